//! POV-Ray scenes: superellipsoids and spheres with plain transforms and colours, in unions and
//! declared objects; cameras, lights, a floor and the background.
//!
//! - Coordinates are kept if the camera is right-handed, as our own export writes it. For
//!   POV-Ray's usual left-handed camera the scene is mirrored, z -> -z, so that it looks as
//!   POV-Ray shows it.
//! - Rotations are turns about x, then y, then z; `matrix` holds the images of the axes.
//! - Variables, arithmetic, `#if`, `#while` and `#for` are carried out. Macros are not.
//! - A pattern becomes its first colour. Unknown parts are skipped with a warning.

mod emit;
mod expression;
mod items;
mod lexer;
mod model;
mod parser;
mod value;

use super::error::ReadError;
use super::format::Format;
use super::import::{Content, Import};
use super::options::ReadOptions;

/// Words with a block that scenes of POV-Ray have.
const BLOCKS: [&str; 12] = [
    "superellipsoid",
    "sphere",
    "camera",
    "light_source",
    "union",
    "merge",
    "object",
    "global_settings",
    "background",
    "intersection",
    "difference",
    "plane",
];

/// The format, if these first bytes are of a POV-Ray scene: a known word with a block, or a
/// directive that only POV-Ray has.
pub(crate) fn recognize(head: &[u8]) -> Result<Option<Format>, ReadError> {
    let text = String::from_utf8_lossy(head);
    let has_directive = text.lines().any(|line| {
        let line = line.trim_start();
        line.starts_with("#declare ") || (line.starts_with("#version ") && line.trim_end().ends_with(';'))
    });
    let has_block = BLOCKS.iter().any(|word| {
        text.match_indices(word).any(|(at, _)| {
            let before = text[..at].chars().next_back();
            let is_start = before.is_none_or(|c| !(c.is_alphanumeric() || matches!(c, '_' | '"' | '\'')));
            is_start && text[at + word.len()..].trim_start().starts_with('{')
        })
    });
    Ok((has_directive || has_block).then_some(Format::Povray))
}

/// Reads a scene as lines of the modelling language.
///
/// # Errors
/// A comment, text or brace has no end, the loops of the scene do not end, or it has no shape that
/// is read.
pub(crate) fn read(bytes: &[u8], _options: &ReadOptions) -> Result<Import, ReadError> {
    // Old scenes have names in other encodings than UTF-8.
    let text = String::from_utf8_lossy(bytes);
    let tokens = lexer::tokens(text.strip_prefix('\u{feff}').unwrap_or(&text))?;
    let mut parser = parser::Parser::new(tokens);
    parser.run()?;
    let mut warnings = parser.take_warnings();
    if parser.scene.objects.is_empty() {
        let detail = warnings.first().map_or(String::new(), |warning| format!(" ({warning})"));
        return Err(ReadError::File(format!("the scene shows no superellipsoid or sphere{detail}")));
    }
    let is_left = emit::is_left_handed(&parser.scene.camera.unwrap_or_default());
    let (script, more) = emit::script_of(&parser.scene, parser.ambient_light, parser.uses_picture_size);
    warnings.extend(more);
    let handed = match (is_left, parser.scene.camera.is_some()) {
        (true, true) => "the camera is left-handed, so z is mirrored",
        (true, false) => "POV-Ray's own camera is left-handed, so z is mirrored",
        (false, _) => "the camera is right-handed, so coordinates are kept",
    };
    let reading = format!("superellipsoid <e, n> of half width 1; {handed}");
    Ok(Import { warnings, ..Import::new(Content::Script(script), reading) })
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use superegg_geom::glam::{DAffine3, DMat3, DVec3};
    use superegg_geom::{Exponents, Superquadric, TransformStep};
    use superegg_lang::{Session, load_text};
    use superegg_scene::{Camera, Entity, Light, LightKind, Primitive, Scene};

    use super::*;
    use crate::povray::to_povray;

    fn import(text: &str) -> Import {
        read(text.as_bytes(), &ReadOptions::default()).unwrap()
    }

    fn session(import: &Import) -> Session {
        let Content::Script(script) = &import.content else { panic!("no script") };
        let (session, diagnostics) = load_text("scene", script);
        assert!(diagnostics.is_empty(), "{diagnostics:?} in\n{script}");
        session
    }

    /// A shape of the world: exponents, colour, and the map of the unit shape.
    type Shown = ([f64; 2], DVec3, DAffine3);

    /// All shapes below an entity, in order.
    fn shown(scene: &Scene, name: &str, map: DAffine3, depth: u32, found: &mut Vec<Shown>) {
        match scene.get(name).unwrap() {
            Entity::Primitive(primitive) => {
                let exponents = primitive.shape.exponents();
                let unit = map * DAffine3::from_scale(primitive.shape.radii());
                found.push(([exponents.e(), exponents.n()], primitive.material.color, unit));
            }
            Entity::Object(_) if depth == 0 => {}
            Entity::Table(_) => unreachable!("neither language reads tables here"),
            Entity::Object(object) => {
                for (_, child) in object.children() {
                    let below = map * *object.parent_from_child(child).unwrap().forward();
                    shown(scene, child.target(), below, depth - 1, found);
                }
            }
        }
    }

    fn shapes(session: &Session) -> Vec<Shown> {
        let mut found = Vec::new();
        shown(session.scene(), session.selected().unwrap(), DAffine3::IDENTITY, 30, &mut found);
        found
    }

    fn distance(a: &DAffine3, b: &DAffine3) -> f64 {
        let pairs = a.to_cols_array().into_iter().zip(b.to_cols_array());
        pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    }

    /// A scene with everything that both languages have.
    fn own_scene(numbers: &[f64; 12]) -> Scene {
        let [a, b, c, e, n, x, y, z, ax, ay, az, angle] = *numbers;
        let mut scene = Scene::default();
        scene.ensure_primitive("ball").unwrap();
        let shape = Superquadric::new(DVec3::new(a, b, c), Exponents::new(e, n).unwrap()).unwrap();
        let mut primitive = Primitive { shape, ..Primitive::default() };
        primitive.material.color = DVec3::new(0.25, 0.5, 1.0);
        primitive.material.shininess = Some(80.0);
        scene.ensure_primitive("egg").unwrap();
        *scene.primitive_mut("egg").unwrap() = primitive;
        scene.ensure_object("pair").unwrap();
        scene.add_child("pair", "first", "egg").unwrap();
        let turn = TransformStep::Rotate { axis: DVec3::new(ax, ay, az + 3.0), angle_deg: angle };
        scene.transform_child("pair", TransformStep::Scale(DVec3::new(1.0, -2.0, 0.5))).unwrap();
        scene.transform_child("pair", turn.clone()).unwrap();
        scene.add_child("pair", "second", "ball").unwrap();
        scene.transform_child("pair", TransformStep::Translate(DVec3::new(x, y, z))).unwrap();
        scene.ensure_object("tree").unwrap();
        scene.add_child("tree", "a", "pair").unwrap();
        scene.transform_child("tree", TransformStep::Translate(DVec3::new(z, x, y))).unwrap();
        scene.add_child("tree", "b", "pair").unwrap();
        scene.transform_child("tree", turn).unwrap();
        scene.camera = Camera {
            position: DVec3::new(4.0 + x, y, z),
            target: DVec3::new(-1.0, 0.5, 0.0),
            up: DVec3::Z,
            fov_deg: 35.0,
            ..Camera::default()
        };
        scene
    }

    proptest! {
        #[test]
        fn our_own_export_reads_back(numbers in prop::array::uniform12(0.1..2.0_f64), is_flat in any::<bool>()) {
            let mut scene = own_scene(&numbers);
            scene.camera.ortho_height = is_flat.then_some(3.5);
            let text = to_povray(&scene, "tree", 5).unwrap();
            prop_assert_eq!(recognize(text.as_bytes()).unwrap(), Some(Format::Povray));
            let import = import(&text);
            prop_assert!(import.warnings.is_empty(), "{:?}", import.warnings);
            let session = session(&import);
            let (mut before, after) = (Vec::new(), shapes(&session));
            shown(&scene, "tree", DAffine3::IDENTITY, 5, &mut before);
            prop_assert_eq!(before.len(), after.len());
            for (a, b) in before.iter().zip(&after) {
                prop_assert_eq!((a.0, a.1), (b.0, b.1));
                prop_assert!(distance(&a.2, &b.2) < 1e-12, "{:?} {:?}", a.2, b.2);
            }
            let (old, new) = (scene.camera, session.scene().camera);
            let axes = |camera: &Camera| { let (right, up, forward) = camera.frame(); DMat3::from_cols(right, up, forward) };
            prop_assert!((axes(&old) - axes(&new)).to_cols_array().iter().all(|d| d.abs() < 1e-12));
            prop_assert!((old.position - new.position).length() < 1e-12);
            match old.ortho_height {
                Some(height) => prop_assert!((new.ortho_height.unwrap() - height).abs() < 1e-12),
                None => prop_assert!((old.fov_deg - new.fov_deg).abs() < 1e-12),
            }
        }

        #[test]
        fn any_text_is_a_scene_or_an_error(text in "(sphere|union|object|#declare A = |#while\\(0\\)|#if\\(1\\)|#for\\(I,0,0\\)|#else|#end|matrix|texture|camera|[{}<>,0-9;x ()-]){0,40}") {
            let _ = read(text.as_bytes(), &ReadOptions::default());
        }
    }

    #[test]
    fn surfaces_and_lights_of_our_export_read_back() {
        let mut scene = own_scene(&[1.0; 12]);
        let mut plain = scene.primitive("egg").unwrap().material;
        (plain.reflected, plain.specular, plain.ambient) = (Some(0.25), 0.5, 0.2);
        scene.primitive_mut("egg").unwrap().material = plain;
        let mut glass = scene.primitive("ball").unwrap().material;
        (glass.refracted, glass.index, glass.absorb) = (Some(0.5), 1.33, DVec3::new(0.0, 0.5, 1.0));
        scene.primitive_mut("ball").unwrap().material = glass;
        let color = DVec3::new(1.0, 0.5, 2.0);
        let position = DVec3::new(1.0, 2.0, 3.0);
        let point = Light { kind: LightKind::Point { position }, color, falloff: 0.25, radius: 0.5 };
        let spot = LightKind::Spot { position, target: DVec3::ZERO, cone_deg: 60.0, soft: 0.5 };
        let sun = LightKind::Sun { direction: DVec3::new(1.0, 2.0, 2.0) };
        let lights = [
            point,
            Light { kind: spot, color, falloff: 0.0, radius: 0.0 },
            Light { kind: sun, color, falloff: 0.0, radius: 0.0 },
        ];
        for (index, light) in lights.iter().enumerate() {
            scene.set_light(&format!("l{index}"), *light);
        }
        scene.background = DVec3::new(0.1, 0.2, 0.3);
        let session = session(&import(&to_povray(&scene, "tree", 5).unwrap()));
        let found = session.scene();
        assert_eq!(found.background, scene.background);
        for (a, b) in lights.iter().zip(found.lights()) {
            assert!((a.color - b.color).length() < 1e-12 && (a.falloff - b.falloff).abs() < 1e-12);
            assert!((a.radius - b.radius).abs() < 1e-12);
            match (a.kind, b.kind) {
                (LightKind::Sun { direction: a }, LightKind::Sun { direction: b }) => {
                    assert!((a.normalize() - b.normalize()).length() < 1e-9);
                }
                (
                    LightKind::Spot { cone_deg: cone, soft, .. },
                    LightKind::Spot { cone_deg, soft: found, .. },
                ) => {
                    assert!((cone - cone_deg).abs() < 1e-12 && (soft - found).abs() < 1e-12);
                }
                (a, b) => assert_eq!(a, b),
            }
        }
        let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} {b}");
        for (name, old) in [("egg", plain), ("ball", glass)] {
            let is_it = |primitive: &&Primitive| {
                let is_round = primitive.shape.exponents() == Superquadric::unit_sphere().exponents();
                is_round == (scene.primitive(name).unwrap().shape.exponents().e() == 1.0)
                    && primitive.material.reflected == old.reflected
            };
            let new = found.entities().filter_map(|(_, entity)| match entity {
                Entity::Primitive(primitive) => Some(primitive),
                Entity::Object(_) | Entity::Table(_) => None,
            });
            let new = new.filter(|primitive| is_it(primitive)).last().unwrap().material;
            close(old.ambient, new.ambient);
            close(old.diffuse, new.diffuse);
            close(old.specular, new.specular);
            close(old.highlight_exponent(), new.highlight_exponent());
            close(old.refracted.unwrap_or(0.0), new.refracted.unwrap_or(0.0));
            close(old.absorb.length(), new.absorb.length());
        }
    }

    #[test]
    fn a_left_handed_scene_is_mirrored_and_looks_the_same() {
        let text = "camera { location <1, 2, -8> look_at <0, 1, 0.5> angle 50 }\n\
            light_source { <2, 4, -3> color rgb 1 }\n\
            superellipsoid { <0.3, 1.5> scale <1, 2, 3> rotate <20, -30, 40> translate <1, 2, 3> pigment { color rgb <1, 0.5, 0> } }\n";
        let import = import(text);
        assert!(
            import.warnings.is_empty() && import.reading.contains("z is mirrored"),
            "{:?}",
            import.warnings
        );
        let session = session(&import);
        let camera = session.scene().camera;
        let [(exponents, color, map)] = shapes(&session)[..] else { panic!("one shape") };
        assert_eq!((exponents, color), ([0.3, 1.5], DVec3::new(1.0, 0.5, 0.0)));
        // POV-Ray: points are turned about x, y, z; the picture's x is along right = sky x forward.
        let turn = DMat3::from_rotation_z(40_f64.to_radians())
            * DMat3::from_rotation_y((-30_f64).to_radians())
            * DMat3::from_rotation_x(20_f64.to_radians());
        let location = DVec3::new(1.0, 2.0, -8.0);
        let forward = (DVec3::new(0.0, 1.0, 0.5) - location).normalize();
        let right = DVec3::Y.cross(forward).normalize();
        let up = forward.cross(right);
        let (our_right, our_up, our_forward) = camera.frame();
        for corner in [DVec3::new(0.7, 0.1, -0.4), DVec3::new(-0.2, 0.9, 0.3), DVec3::ZERO] {
            let theirs = turn * (corner * DVec3::new(1.0, 2.0, 3.0)) + DVec3::new(1.0, 2.0, 3.0) - location;
            // The shape is its own mirror image.
            let ours = map.transform_point3(corner * DVec3::new(1.0, 1.0, -1.0)) - camera.position;
            for (a, b) in [(right, our_right), (up, our_up), (forward, our_forward)] {
                assert!((theirs.dot(a) - ours.dot(b)).abs() < 1e-12);
            }
        }
        // The angle is horizontal: 4/3 wide.
        let half = (25_f64.to_radians().tan() * 0.75).atan().to_degrees();
        assert!((camera.fov_deg - 2.0 * half).abs() < 1e-12);
        assert_eq!(session.scene().lights()[0].position(), Some(DVec3::new(2.0, 4.0, 3.0)));
    }

    #[test]
    fn declarations_loops_and_inheritance_are_carried_out() {
        let text = "#include \"colors.inc\"\n#declare R = 0.5;\n#declare T = texture { pigment { Red } finish { ambient 0.3 diffuse 0.5 } }\n\
            #declare Ball = sphere { 0, R };\n\
            #declare Blue_ball = object { Ball pigment { Blue } }\n\
            #if (R > 1) #declare N = 1; #elseif (R = 0.5) #declare N = 3; #else #declare N = 9; #end\n\
            union {\n  #for (I, 1, N)\n    object { Ball translate I*2*x }\n  #end\n  object { Blue_ball translate y }\n  texture { T }\n}\n\
            #declare I = 0;\n#while (I < 2) superellipsoid { <1, 0.5> translate <0, 0, I> } #declare I = I + 1; #end\n\
            box { 0, 1 }\n";
        let import = import(text);
        assert_eq!(import.warnings, ["line 16: 'box' is not understood and left out"]);
        let found = shapes(&session(&import));
        let red = DVec3::X;
        let centres: Vec<DVec3> = found.iter().map(|(_, _, map)| map.translation).collect();
        let expected =
            [[2.0, 0.0, 0.0], [4.0, 0.0, 0.0], [6.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0; 3], [0.0, 0.0, -1.0]];
        assert_eq!(centres, expected.map(DVec3::from_array));
        let colors: Vec<DVec3> = found.iter().map(|(_, color, _)| *color).collect();
        assert_eq!(colors[..4], [red, red, red, DVec3::Z]);
        assert_eq!(found[0].2.matrix3, DMat3::from_diagonal(DVec3::splat(0.5)));
    }

    #[test]
    fn what_is_not_understood_is_listed_by_line() {
        let ball = "sphere { <0, 0, 0>, 1 }\n";
        let warnings = |text: &str| import(&format!("{ball}{text}")).warnings.join("; ");
        assert!(warnings("mesh { triangle { 0, x, y } }").contains("line 2: 'mesh'"));
        assert!(warnings("sphere { 0, rand(S) }").contains("line 2: 'rand' has no value"));
        assert!(warnings("superellipsoid { <-1, 1> }").contains("line 2: the exponents must not be below 0"));
        assert_eq!(warnings("superellipsoid { <0, 1> }"), "");
        assert!(warnings("object { Nobody }").contains("'Nobody' is no object"));
        assert!(
            warnings("#macro M(A)\n sphere { A, 1 }\n#end\nM(1)").contains("'#macro' is not carried out")
        );
        assert!(
            warnings("sphere { 0, 1 pigment { bozo color_map { [0 Red] [1 Blue] } } }")
                .contains("first colour")
        );
        assert!(warnings("sphere { 0, 1 matrix <1,0,0, 0,0,0, 0,0,1, 0,0,0> }").contains("flattens"));
        let message = |text: &str| read(text.as_bytes(), &ReadOptions::default()).unwrap_err().to_string();
        assert!(message("camera { }").contains("no superellipsoid or sphere"));
        assert!(message("sphere { 0, 1").contains("line 1: this '{' is not closed"));
        assert!(message(&format!("{ball}#while (1) #end")).contains("too long"));
        assert!(message(&"union {".repeat(100_000)).contains("not closed"));
        let deep = format!("{}{}", "union { ".repeat(500), "} ".repeat(500));
        assert!(message(&deep).contains("nested deeper"));
        let mut chain = "#declare A0 = sphere { 0, 1 }\n".to_owned();
        for level in 1..200 {
            chain += &format!("#declare A{level} = union {{ object {{ A{} }} }}\n", level - 1);
        }
        assert!(message(&format!("{chain}object {{ A199 }}")).contains("nested deeper"));
    }

    #[test]
    fn scenes_of_our_own_language_are_none() {
        for text in [
            "primitive sphere\nsetCoeff 1 1 1\n",
            "# camera of the union\nobject sphere\n",
            "",
            "camera 0 0 1 0 0 0\n",
        ] {
            assert_eq!(recognize(text.as_bytes()).unwrap(), None, "{text}");
        }
        for text in ["  sphere{0,1}", "#declare A = 1;", "// x\n#version 3.7;\n", "camera\n{ location x }"] {
            assert_eq!(recognize(text.as_bytes()).unwrap(), Some(Format::Povray), "{text}");
        }
    }
}
