//! The words and bytes of partial files. They are spelled out here, independent of the names in the
//! code: renaming a variant or a field does not change the format.

use superegg_geom::glam::DVec3;
use superegg_scene::{
    AmbientOcclusion, Camera, Encoding, Filter, Floor, Lens, Light, LightKind, LightModel, Material, Pattern,
    Sky, Tone,
};

use crate::settings::{Environment, Output};

/// The words of an enumeration.
pub(crate) type Words<T, const N: usize> = [(T, &'static str); N];

/// The words of outputs.
pub(crate) const OUTPUTS: Words<Output, 7> = [
    (Output::Light, "Light"),
    (Output::Normal, "Normal"),
    (Output::Depth, "Depth"),
    (Output::Albedo, "Albedo"),
    (Output::Id, "Id"),
    (Output::Steps, "Steps"),
    (Output::Occlusion, "Occlusion"),
];

/// The words of reconstruction filters.
pub(crate) const FILTERS: Words<Filter, 5> = [
    (Filter::Box, "Box"),
    (Filter::Tent, "Tent"),
    (Filter::Gaussian, "Gaussian"),
    (Filter::Blackman, "Blackman"),
    (Filter::Mitchell, "Mitchell"),
];

/// The words of encodings.
pub(crate) const ENCODINGS: Words<Encoding, 2> = [(Encoding::Srgb, "Srgb"), (Encoding::Linear, "Linear")];

/// The words of tone curves.
pub(crate) const TONES: Words<Tone, 5> = [
    (Tone::None, "None"),
    (Tone::Reinhard, "Reinhard"),
    (Tone::Filmic, "Filmic"),
    (Tone::Aces, "Aces"),
    (Tone::Agx, "Agx"),
];

/// The words of light models.
pub(crate) const LIGHT_MODELS: Words<LightModel, 2> =
    [(LightModel::Course, "Course"), (LightModel::Path, "Path")];

/// The words of booleans.
pub(crate) const FLAGS: Words<bool, 2> = [(false, "false"), (true, "true")];

/// The word of a value. A value without a word, which is an omission in a table, gets a word that
/// no reader accepts.
pub(crate) fn word_of<T: Copy + PartialEq>(value: T, words: &[(T, &'static str)]) -> &'static str {
    words.iter().find(|(own, _)| *own == value).map_or("(no word)", |(_, word)| word)
}

/// The value of a word.
pub(crate) fn value_of_word<T: Copy>(text: Option<&str>, words: &[(T, &'static str)]) -> Option<T> {
    words.iter().find(|(_, word)| text == Some(word)).map(|(value, _)| *value)
}

/// Bytes whose hash identifies a value: numbers by their bits, variants by words.
#[derive(Default)]
struct Bytes(Vec<u8>);

impl Bytes {
    /// A word: its length and its bytes, so that no two sequences of words are equal.
    fn word(&mut self, word: &str) {
        self.0.extend((word.len() as u32).to_le_bytes());
        self.0.extend(word.as_bytes());
    }

    fn count(&mut self, count: u32) {
        self.0.extend(count.to_le_bytes());
    }

    fn flag(&mut self, flag: bool) {
        self.0.push(u8::from(flag));
    }

    fn number(&mut self, number: f64) {
        self.0.extend(number.to_bits().to_le_bytes());
    }

    fn vector(&mut self, vector: DVec3) {
        vector.to_array().into_iter().for_each(|number| self.number(number));
    }

    fn optional<T>(&mut self, value: Option<T>, write: impl FnOnce(&mut Self, T)) {
        self.flag(value.is_some());
        if let Some(value) = value {
            write(self, value);
        }
    }
}

/// The bytes of a camera.
pub(crate) fn camera_bytes(camera: &Camera) -> Vec<u8> {
    let &Camera { position, target, up, fov_deg, ortho_height, lens } = camera;
    let mut bytes = Bytes::default();
    bytes.vector(position);
    bytes.vector(target);
    bytes.vector(up);
    bytes.number(fov_deg);
    bytes.optional(ortho_height, Bytes::number);
    bytes.optional(lens, |bytes, Lens { radius, focus }| {
        bytes.number(radius);
        bytes.number(focus);
    });
    bytes.0
}

/// The bytes of an environment.
pub(crate) fn environment_bytes(environment: &Environment) -> Vec<u8> {
    let Environment { lights, background, sky, floor, ambient_occlusion, map } = environment;
    let mut bytes = Bytes::default();
    bytes.count(lights.len() as u32);
    lights.iter().for_each(|light| write_light(&mut bytes, light));
    bytes.vector(*background);
    bytes.optional(*sky, |bytes, Sky { horizon, zenith, up }| {
        bytes.vector(horizon);
        bytes.vector(zenith);
        bytes.vector(up);
    });
    bytes.optional(floor.as_ref(), |bytes, (floor, material)| {
        let Floor { height, up, surface } = floor;
        bytes.number(*height);
        bytes.vector(*up);
        bytes.optional(surface.as_deref(), Bytes::word);
        write_material(bytes, material);
    });
    bytes.optional(*ambient_occlusion, |bytes, AmbientOcclusion { samples, distance }| {
        bytes.count(samples);
        bytes.number(distance);
    });
    // Older programs knew none.
    if let Some(map) = map {
        bytes.word("map");
        bytes.0.extend(map.fingerprint().to_le_bytes());
    }
    bytes.0
}

fn write_light(bytes: &mut Bytes, light: &Light) {
    let &Light { kind, color, falloff, radius } = light;
    match kind {
        LightKind::Point { position } => {
            bytes.word("point");
            bytes.vector(position);
        }
        LightKind::Spot { position, target, cone_deg, soft } => {
            bytes.word("spot");
            bytes.vector(position);
            bytes.vector(target);
            bytes.number(cone_deg);
            bytes.number(soft);
        }
        LightKind::Sun { direction } => {
            bytes.word("sun");
            bytes.vector(direction);
        }
    }
    bytes.vector(color);
    bytes.number(falloff);
    bytes.number(radius);
}

fn write_material(bytes: &mut Bytes, material: &Material) {
    let &Material {
        color,
        ambient,
        reflected,
        refracted,
        gloss,
        diffuse,
        specular,
        index,
        shininess,
        fresnel,
        absorb,
        emission,
        roughness,
        metallic,
        pattern,
    } = material;
    bytes.vector(color);
    bytes.number(ambient);
    bytes.optional(reflected, Bytes::number);
    bytes.optional(refracted, Bytes::number);
    [gloss, diffuse, specular, index].into_iter().for_each(|number| bytes.number(number));
    bytes.optional(shininess, Bytes::number);
    bytes.flag(fresnel);
    bytes.vector(absorb);
    // Older programs knew no emission, and their partial files stay valid.
    if emission > 0.0 {
        bytes.word("emission");
        bytes.number(emission);
    }
    // The same for facets.
    if roughness.is_some() || metallic > 0.0 {
        bytes.word("facets");
        bytes.optional(roughness, Bytes::number);
        bytes.number(metallic);
    }
    match pattern {
        Pattern::None => bytes.word("none"),
        Pattern::Checker { color, size } => {
            bytes.word("checker");
            bytes.vector(color);
            bytes.number(size);
        }
        Pattern::Noise { color, size } | Pattern::Marble { color, size } | Pattern::Wood { color, size } => {
            bytes.word(pattern.word());
            bytes.vector(color);
            bytes.number(size);
        }
        Pattern::Gradient { color, direction } => {
            bytes.word("gradient");
            bytes.vector(color);
            bytes.vector(direction);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use superegg_scene::Daylight;

    use super::*;
    use crate::environment::map::EnvironmentMap;

    /// Words as literals: a table whose words change fails.
    #[test]
    fn every_value_has_its_word_and_reads_back() {
        let words = |words: &[&str], found: Vec<&str>| assert_eq!(words, found);
        words(
            &["Light", "Normal", "Depth", "Albedo", "Id", "Steps", "Occlusion"],
            Output::ALL.map(|output| word_of(output, &OUTPUTS)).to_vec(),
        );
        use Filter::{Blackman, Box, Gaussian, Mitchell, Tent};
        words(
            &["Box", "Tent", "Gaussian", "Blackman", "Mitchell"],
            [Box, Tent, Gaussian, Blackman, Mitchell].map(|filter| word_of(filter, &FILTERS)).to_vec(),
        );
        words(
            &["Srgb", "Linear"],
            [Encoding::Srgb, Encoding::Linear].map(|encoding| word_of(encoding, &ENCODINGS)).to_vec(),
        );
        words(
            &["None", "Reinhard", "Filmic", "Aces", "Agx"],
            [Tone::None, Tone::Reinhard, Tone::Filmic, Tone::Aces, Tone::Agx]
                .map(|tone| word_of(tone, &TONES))
                .to_vec(),
        );
        words(&["false", "true"], [false, true].map(|flag| word_of(flag, &FLAGS)).to_vec());
        for output in Output::ALL {
            assert_eq!(value_of_word(Some(word_of(output, &OUTPUTS)), &OUTPUTS), Some(output));
        }
        assert_eq!(value_of_word(Some("light"), &OUTPUTS), None);
        assert_eq!(value_of_word(None, &OUTPUTS), None);
    }

    #[test]
    fn every_value_of_a_camera_and_of_an_environment_changes_the_bytes() {
        let camera = Camera::default();
        let cameras = [
            camera,
            Camera { position: DVec3::X, ..camera },
            Camera { target: DVec3::X, ..camera },
            Camera { up: DVec3::X, ..camera },
            Camera { fov_deg: camera.fov_deg.next_up(), ..camera },
            Camera { ortho_height: Some(1.0), ..camera },
            Camera { lens: Some(Lens { radius: 1.0, focus: 2.0 }), ..camera },
            Camera { lens: Some(Lens { radius: 2.0, focus: 1.0 }), ..camera },
        ];
        let all: HashSet<Vec<u8>> = cameras.iter().map(camera_bytes).collect();
        assert_eq!(all.len(), cameras.len());

        let plain = Environment::of(&superegg_scene::Scene::default());
        let floor = Floor { height: 0.0, up: DVec3::Y, surface: None };
        let with_material = |change: fn(&mut Material)| {
            let mut material = Material::default();
            change(&mut material);
            Environment { floor: Some((floor.clone(), material)), ..plain.clone() }
        };
        let with_light = |light: Light| Environment { lights: vec![light], ..plain.clone() };
        let position = DVec3::X;
        let daylight = Daylight { elevation_deg: 30.0, turbidity: 3.0, azimuth_deg: 0.0 };
        let environments = [
            plain.clone(),
            Environment { lights: Vec::new(), ..plain.clone() },
            Environment { background: DVec3::new(-0.0, 0.0, 0.0), ..plain.clone() },
            Environment {
                sky: Some(Sky { horizon: DVec3::X, zenith: DVec3::Y, up: DVec3::Z }),
                ..plain.clone()
            },
            Environment {
                ambient_occlusion: Some(AmbientOcclusion { samples: 1, distance: 2.0 }),
                ..plain.clone()
            },
            plain.clone().with_map(EnvironmentMap::of_daylight(&daylight, DVec3::Y)),
            plain.clone().with_map(EnvironmentMap::of_daylight(&daylight, DVec3::Z)),
            with_light(Light { kind: LightKind::Point { position }, ..Light::DEFAULT }),
            with_light(Light { kind: LightKind::Sun { direction: position }, ..Light::DEFAULT }),
            with_light(Light {
                kind: LightKind::Spot { position, target: DVec3::Y, cone_deg: 30.0, soft: 0.5 },
                ..Light::DEFAULT
            }),
            with_light(Light { falloff: 0.5, ..Light::DEFAULT }),
            with_light(Light { radius: 0.5, ..Light::DEFAULT }),
            with_light(Light { color: DVec3::X, ..Light::DEFAULT }),
            Environment {
                floor: Some((Floor { surface: Some("egg".into()), ..floor.clone() }, Material::default())),
                ..plain.clone()
            },
            with_material(|_| ()),
            with_material(|material| material.color = DVec3::X),
            with_material(|material| material.ambient = 0.7),
            with_material(|material| material.reflected = Some(0.0)),
            with_material(|material| material.refracted = Some(0.0)),
            with_material(|material| material.gloss = 0.7),
            with_material(|material| material.diffuse = 0.77),
            with_material(|material| material.specular = 0.77),
            with_material(|material| material.index = 1.77),
            with_material(|material| material.shininess = Some(7.0)),
            with_material(|material| material.fresnel = true),
            with_material(|material| material.absorb = DVec3::X),
            with_material(|material| material.emission = 0.5),
            with_material(|material| material.roughness = Some(0.0)),
            with_material(|material| material.roughness = Some(0.5)),
            with_material(|material| material.metallic = 0.5),
            with_material(|material| material.pattern = Pattern::Checker { color: DVec3::X, size: 1.0 }),
            with_material(|material| {
                material.pattern = Pattern::Gradient { color: DVec3::X, direction: DVec3::Y };
            }),
        ];
        let all: HashSet<Vec<u8>> = environments.iter().map(environment_bytes).collect();
        assert_eq!(all.len(), environments.len());
    }
}
