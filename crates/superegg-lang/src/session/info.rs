//! The command `info`: the contents of a scene as text.

use superegg_geom::TransformStep;
use superegg_scene::{
    Daylight, Entity, EnvironmentLight, EnvironmentPicture, InstanceTable, Light, LightKind, Material,
    Object, Primitive, Scene, Track, TrackWord,
};

use crate::diagnostic::{Fault, FaultCode};
use crate::parse::material_words::{pattern_words, texture_words};
use crate::parse::number::{format_number, matrix_words, quaternion_words, vector};
use crate::session::keys::line_of;
use crate::session::selection::Selection;
use crate::suggest::Suggestions;
use crate::text::shorten;

/// The contents of the scene, or the details of each named entity. `all` and `selected` are
/// keywords unless an entity has that name.
///
/// # Errors
/// The index in `names` of an unknown name, and the fault.
pub(crate) fn info(
    selection: Selection<'_>,
    names: &[String],
    suggestions: Suggestions,
) -> Result<String, (usize, Fault)> {
    if names.is_empty() {
        return Ok(list(selection));
    }
    let mut texts = Vec::new();
    for (i, name) in names.iter().enumerate() {
        let scene = selection.scene;
        if let Some(entity) = scene.get(name) {
            texts.push(details(scene, name, entity));
            continue;
        }
        match name.to_ascii_lowercase().as_str() {
            "all" => {
                texts.extend(
                    sorted(scene.entities()).iter().map(|(name, entity)| details(scene, name, entity)),
                );
            }
            "selected" => {
                texts.push(match selection.entity() {
                    Some((name, entity)) => details(scene, name, entity),
                    None => "nothing is selected".to_owned(),
                });
            }
            _ => {
                let known = scene.entities().map(|(name, _)| name);
                let fault =
                    Fault::new(FaultCode::UnknownName, format!("nothing is named '{}'", shorten(name)));
                return Err((
                    i,
                    fault.help(suggestions.did_you_mean(name, known, "'info' alone lists what there is")),
                ));
            }
        }
    }
    Ok(texts.join("\n"))
}

fn list(selection: Selection<'_>) -> String {
    let scene = selection.scene;
    let mut lines = Vec::new();
    lines.push(format!("primitives ({})", scene.primitives().count()));
    lines.extend(sorted(scene.primitives()).iter().map(|(name, _)| format!("  {name}")));
    lines.push(format!("objects ({})", scene.objects().count()));
    for (name, object) in sorted(scene.objects()) {
        let count = object.children().len();
        let plural = if count == 1 { "" } else { "ren" };
        let hidden = match object.hidden_count() {
            0 => String::new(),
            hidden => format!(", {hidden} hidden"),
        };
        lines.push(format!("  {name}: {count} child{plural}{hidden}"));
    }
    if scene.tables().next().is_some() {
        lines.push(format!("tables ({})", scene.tables().count()));
        lines.extend(
            sorted(scene.tables()).iter().map(|(name, table)| format!("  {name}: {} instances", table.len())),
        );
    }
    lines.push(format!("lights ({})", scene.named_lights().len()));
    lines.extend(scene.named_lights().map(|(name, light)| format!("  {name}: {}", light_words(light))));
    if scene.named_lights().len() == 0 {
        lines.push(format!("  the default: {}", light_words(&Light::DEFAULT)));
    }
    lines.push(camera_words(scene));
    lines.push(format!("background {}", vector(scene.background)));
    lines.extend(environment_words(scene));
    lines.push(format!("depth {}", scene.depth));
    if scene.tracks().len() > 0 {
        lines.push(format!("keys ({})", scene.tracks().map(|track| track.keys().len()).sum::<usize>()));
        lines.extend(scene.tracks().map(|track| format!("  {}", track_words(track))));
    }
    lines.push(match selection.selected {
        Some(name) => format!("selected: {name}"),
        None => "nothing is selected".to_owned(),
    });
    lines.join("\n")
}

/// The subject of a track, and its frames.
fn track_words(track: &Track) -> String {
    const MOST_FRAMES: usize = 12;
    let subject = track.subject();
    let plain = subject.words.iter().filter_map(|word| match word {
        TrackWord::Number => None,
        TrackWord::Word(word) | TrackWord::Entity(word) | TrackWord::Light(word) => Some(&**word),
    });
    let mut words = std::iter::once(&*subject.command).chain(plain).collect::<Vec<_>>().join(" ");
    if let Some(selected) = &subject.selected {
        words += &format!(" of {selected}");
    }
    if let Some(cursor) = &subject.cursor {
        words += &format!("/{cursor}");
    }
    let frames: Vec<String> = track.keys().take(MOST_FRAMES).map(|key| format_number(key.frame)).collect();
    words += &format!(": {} {}", if track.keys().len() == 1 { "frame" } else { "frames" }, frames.join(", "));
    if track.keys().len() > MOST_FRAMES {
        words += &format!(" and {} more", track.keys().len() - MOST_FRAMES);
    }
    words
}

/// The keys of an entity, one per line.
fn key_details(scene: &Scene, name: &str) -> String {
    let mut text = String::new();
    for track in scene.tracks().filter(|track| track.subject().selected.as_deref() == Some(name)) {
        let child =
            track.subject().cursor.as_ref().map_or(String::new(), |alias| format!(" (child {alias})"));
        for key in track.keys() {
            let line = line_of(track.subject(), &key.numbers);
            text.push_str(&format!("\n  key {} {line}{child}", format_number(key.frame)));
        }
    }
    text
}

/// The entries sorted by name, ignoring case.
fn sorted<'a, T>(entries: impl Iterator<Item = (&'a str, T)>) -> Vec<(&'a str, T)> {
    let mut entries: Vec<_> = entries.collect();
    entries.sort_by_cached_key(|(name, _)| (name.to_lowercase(), *name));
    entries
}

fn camera_words(scene: &Scene) -> String {
    let camera = &scene.camera;
    let mut words = format!(
        "camera at {} towards {}, up {}",
        vector(camera.position),
        vector(camera.target),
        vector(camera.up)
    );
    words += &match camera.ortho_height {
        Some(height) => format!(", orthographic, {} high", format_number(height)),
        None => format!(", field of view {} degrees", format_number(camera.fov_deg)),
    };
    if let Some(lens) = camera.lens {
        let (radius, focus) = (format_number(lens.radius), format_number(lens.focus));
        words += &format!(", lens of radius {radius} with focus at {focus}");
    }
    words
}

/// Sky, surroundings, floor and ambient occlusion, if set.
fn environment_words(scene: &Scene) -> Vec<String> {
    let sky = scene.sky.map(|sky| {
        let (horizon, zenith) = (vector(sky.horizon), vector(sky.zenith));
        format!("sky {horizon} at the horizon, {zenith} at the zenith, up {}", vector(sky.up))
    });
    let surroundings = scene.environment.as_ref().map(|environment| match environment {
        EnvironmentLight::Picture(EnvironmentPicture { file, rotation_deg, scale }) => {
            let [rotation, scale] = [rotation_deg, scale].map(|number| format_number(*number));
            format!("environment '{file}', turned by {rotation} degrees, times {scale}")
        }
        EnvironmentLight::Daylight(Daylight { elevation_deg, turbidity, azimuth_deg }) => {
            let [elevation, haze, azimuth] =
                [elevation_deg, turbidity, azimuth_deg].map(|number| format_number(*number));
            format!("daylight: sun at elevation {elevation}, azimuth {azimuth}, turbidity {haze}")
        }
    });
    let floor = scene.floor.as_ref().map(|floor| {
        let surface = floor.surface.as_ref().map_or(String::new(), |name| format!(", surface of {name}"));
        format!("floor at height {}, up {}{surface}", format_number(floor.height), vector(floor.up))
    });
    let occlusion = scene.ambient_occlusion.map(|occlusion| {
        let distance = format_number(occlusion.distance);
        format!("ambient occlusion: {} samples, distance {distance}", occlusion.samples)
    });
    [sky, surroundings, floor, occlusion].into_iter().flatten().collect()
}

fn light_words(light: &Light) -> String {
    let (color, falloff) = (vector(light.color), format_number(light.falloff));
    let words = match light.kind {
        LightKind::Point { position } => format!("at {}, colour {color}, k {falloff}", vector(position)),
        LightKind::Spot { position, target, cone_deg, soft } => format!(
            "spot at {} towards {}, {} degrees, colour {color}, k {falloff}, soft {}",
            vector(position),
            vector(target),
            format_number(cone_deg),
            format_number(soft)
        ),
        LightKind::Sun { direction } => format!("sun from {}, colour {color}", vector(direction)),
    };
    if light.radius > 0.0 { format!("{words}, radius {}", format_number(light.radius)) } else { words }
}

fn details(scene: &Scene, name: &str, entity: &Entity) -> String {
    let details = match entity {
        Entity::Primitive(primitive) => primitive_details(name, primitive),
        Entity::Object(object) => object_details(name, object),
        Entity::Table(table) => table_details(name, table),
    };
    details + &key_details(scene, name)
}

fn primitive_details(name: &str, primitive: &Primitive) -> String {
    let Primitive { shape, patches, material, textures } = primitive;
    let unset = |value: Option<f64>, fallback: f64| match value {
        Some(value) => format_number(value),
        None => format!("{} (not set: not traced)", format_number(fallback)),
    };
    let shininess = match material.shininess {
        Some(exponent) => format_number(exponent),
        // A computed value: rounded to six decimals.
        None => format!("{} (from gloss)", (material.highlight_exponent() * 1e6).round() / 1e6),
    };
    let exponents = shape.exponents();
    let rows = [
        ("coeff", vector(shape.radii())),
        ("exponent", format!("{} {}", format_number(exponents.e()), format_number(exponents.n()))),
        ("patch", format!("{} {}", patches.u, patches.v)),
        ("color", vector(material.color)),
        ("ambient", format_number(material.ambient)),
        ("reflected", unset(material.reflected, Material::UNSET_REFLECTED)),
        ("refracted", unset(material.refracted, Material::UNSET_REFRACTED)),
        ("gloss", format_number(material.gloss)),
        ("diffuse", format_number(material.diffuse)),
        ("specular", format_number(material.specular)),
        ("index", format_number(material.index)),
        ("shininess", shininess),
        ("fresnel", if material.fresnel { "on" } else { "off" }.to_owned()),
        ("absorb", vector(material.absorb)),
        ("emission", format_number(material.emission)),
        ("roughness", material.roughness.map_or_else(|| "unset, no facets".to_owned(), format_number)),
        ("metallic", format_number(material.metallic)),
        ("pattern", pattern_words(&material.pattern)),
    ];
    let mut text = format!("primitive {name}");
    for (word, value) in rows {
        text.push_str(&format!("\n  {word:<10} {value}"));
    }
    for (channel, texture) in textures.iter().flat_map(|textures| textures.all()) {
        text.push_str(&format!("\n  {:<10} {}", "texture", texture_words(channel, texture)));
    }
    text
}

fn object_details(name: &str, object: &Object) -> String {
    let mut text = format!("object {name}");
    let cursor = object.cursor().map(|(alias, _)| alias);
    for (alias, child) in object.children() {
        let mark = if cursor == Some(alias) { "  <- cursor" } else { "" };
        let target = if alias == child.target() { String::new() } else { format!(" ({})", child.target()) };
        let hidden = if object.is_hidden(alias) { "  (hidden)" } else { "" };
        text.push_str(&format!("\n  child {alias}{target}{hidden}{mark}"));
        for step in child.steps() {
            text.push_str(&format!("\n    {}", step_words(step)));
        }
    }
    if object.children().len() == 0 {
        text.push_str("\n  no children");
    }
    for step in object.overall_steps() {
        text.push_str(&format!("\n  as a whole: {}", step_words(step)));
    }
    text
}

fn table_details(name: &str, table: &InstanceTable) -> String {
    let (rows, shapes, materials) = (table.len(), table.shapes().len(), table.materials().len());
    format!(
        "object {name}\n  a table of {rows} instances: shapes {shapes}, materials {materials}, {} bytes",
        table.bytes()
    )
}

fn step_words(step: &TransformStep) -> String {
    match step {
        TransformStep::Translate(by) => format!("translate {}", vector(*by)),
        TransformStep::Rotate { axis, angle_deg } => {
            format!("rotate {} {}", vector(*axis), format_number(*angle_deg))
        }
        TransformStep::Scale(factors) => format!("scale {}", vector(*factors)),
        TransformStep::Orient(quaternion) => format!("orient {}", quaternion_words(*quaternion)),
        TransformStep::Affine(map) => format!("matrix {}", matrix_words(map)),
    }
}
