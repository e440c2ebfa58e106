//! Procedural scenes for benchmarks: random clouds, grids of glyphs and fractals.

use std::fmt::Write;

use anyhow::{Context, Result, bail};
use superegg_geom::glam::DVec3;
use superegg_geom::{Exponents, Superquadric, TransformStep};
use superegg_scene::{Camera, Light, LightKind, MAX_DEPTH, Scene};

/// The root object of every generated scene.
pub(crate) const ROOT: &str = "all";

/// A generated scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum GeneratedScene {
    /// `cloud:N`: N superquadrics with e, n in [0.1, 2] and random rotations, in a cube.
    Cloud(u32),
    /// `glyphs:N`: N instances of 64 shapes on a grid.
    Glyphs(u32),
    /// `fractal:B,D`: a ball with B smaller copies of the whole, D levels deep.
    Fractal(u32, u32),
}

/// The SplitMix64 random number generator.
pub(crate) struct Random(u64);

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed)
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut mixed = self.0;
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    }

    /// A number in [low, high).
    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * ((self.next() >> 11) as f64 / (1u64 << 53) as f64)
    }

    /// A number rounded to six decimals, so that text keeps it exactly.
    fn rounded(&mut self, low: f64, high: f64) -> f64 {
        (self.between(low, high) * 1e6).round() / 1e6
    }
}

/// A primitive of a generated scene.
struct Shape {
    name: String,
    radii: [f64; 3],
    exponents: [f64; 2],
    color: [f64; 3],
}

/// A child of the root object.
struct Child {
    target: String,
    alias: String,
    steps: Vec<TransformStep>,
}

/// Receives the parts of a scene: as a scene, or as text.
trait Sink {
    fn shape(&mut self, shape: &Shape) -> Result<()>;
    fn child(&mut self, child: &Child) -> Result<()>;
}

const COLORS: [[f64; 3]; 8] = [
    [0.85, 0.35, 0.25],
    [0.9, 0.6, 0.2],
    [0.85, 0.8, 0.35],
    [0.4, 0.7, 0.35],
    [0.3, 0.65, 0.65],
    [0.3, 0.45, 0.8],
    [0.6, 0.4, 0.7],
    [0.8, 0.8, 0.8],
];

impl GeneratedScene {
    /// The generated scene of a name; `None` for other names.
    ///
    /// # Errors
    /// A number in the name is missing or out of range.
    pub(crate) fn parse(name: &str) -> Result<Option<Self>> {
        let Some((kind, numbers)) = name.split_once(':') else { return Ok(None) };
        let count = |text: &str, most: u32| -> Result<u32> {
            let count =
                text.parse().with_context(|| format!("'{text}' in '{name}' is not a whole number"))?;
            if !(1..=most).contains(&count) {
                bail!("'{text}' in '{name}' must be 1 to {most}");
            }
            Ok(count)
        };
        Ok(match kind {
            "cloud" => Some(Self::Cloud(count(numbers, 10_000_000)?)),
            "glyphs" => Some(Self::Glyphs(count(numbers, 10_000_000)?)),
            "fractal" => {
                let (branches, depth) = numbers
                    .split_once(',')
                    .with_context(|| format!("'{name}' needs branches and depth, as in fractal:20,64"))?;
                Some(Self::Fractal(count(branches, 1000)?, count(depth, MAX_DEPTH)?))
            }
            _ => None,
        })
    }

    /// Generates the scene.
    pub(crate) fn scene(self, seed: u64) -> Result<Scene> {
        let mut scene = Scene::default();
        scene.camera = self.camera();
        scene.sets_camera = true;
        scene.depth = self.depth();
        scene.background = DVec3::new(0.6, 0.7, 0.8);
        for (name, light) in self.lights() {
            scene.set_light(name, light);
        }
        scene.ensure_object(ROOT)?;
        self.fill(seed, &mut SceneSink(&mut scene))?;
        Ok(scene)
    }

    /// Generates the commands of the scene.
    pub(crate) fn text(self, seed: u64) -> String {
        let mut text = String::new();
        let Camera { position: p, target: t, up, fov_deg, .. } = self.camera();
        let _ = writeln!(text, "# Generated scene: {self:?}, seed {seed}.\n");
        let _ = writeln!(text, "camera {} {} {} {} {} {} {fov_deg}", p.x, p.y, p.z, t.x, t.y, t.z);
        let _ = writeln!(
            text,
            "cameraUp {} {} {}\nbackground 0.6 0.7 0.8\nsetDepth {}",
            up.x,
            up.y,
            up.z,
            self.depth()
        );
        for (name, light) in self.lights() {
            let (p, c, falloff) = (light.position().unwrap_or_default(), light.color, light.falloff);
            let _ = writeln!(text, "light {name} {} {} {} {} {} {} {falloff}", p.x, p.y, p.z, c.x, c.y, c.z);
        }
        let mut sink = TextSink { shapes: String::new(), children: String::new() };
        // Writing to a String cannot fail.
        let _ = self.fill(seed, &mut sink);
        let _ = write!(text, "\n{}\nobject {ROOT}\n{}", sink.shapes, sink.children);
        text
    }

    fn depth(self) -> u32 {
        match self {
            Self::Fractal(_, depth) => depth,
            Self::Cloud(_) | Self::Glyphs(_) => superegg_scene::DEFAULT_DEPTH,
        }
    }

    fn camera(self) -> Camera {
        let (position, target, fov_deg) = match self {
            Self::Cloud(_) => (DVec3::new(2.2, 1.6, 2.9), DVec3::ZERO, 36.0),
            Self::Glyphs(_) => (DVec3::new(0.0, -1.9, 1.9), DVec3::new(0.0, -0.1, 0.0), 40.0),
            Self::Fractal(..) => (DVec3::new(0.0, -4.6, 2.3), DVec3::ZERO, 40.0),
        };
        let up = if matches!(self, Self::Cloud(_)) { DVec3::Y } else { DVec3::Z };
        Camera { position, target, up, fov_deg, ..Camera::default() }
    }

    fn lights(self) -> [(&'static str, Light); 1] {
        let position = match self {
            Self::Cloud(_) => DVec3::new(3.0, 6.0, 4.0),
            Self::Glyphs(_) | Self::Fractal(..) => DVec3::new(-3.0, -4.0, 6.0),
        };
        [("sun", Light { kind: LightKind::Point { position }, falloff: 0.0, ..Light::DEFAULT })]
    }

    fn fill(self, seed: u64, sink: &mut dyn Sink) -> Result<()> {
        let mut random = Random::new(seed);
        match self {
            Self::Cloud(count) => cloud(count, &mut random, sink),
            Self::Glyphs(count) => glyphs(count, &mut random, sink),
            Self::Fractal(branches, _) => fractal(branches, sink),
        }
    }
}

/// Semi-axes are 0.15 to 0.45 of the spacing of N points on a grid.
fn cloud(count: u32, random: &mut Random, sink: &mut dyn Sink) -> Result<()> {
    let spacing = 2.0 / f64::from(count).cbrt();
    for i in 0..count {
        let name = format!("p{i}");
        let shape = Shape {
            radii: std::array::from_fn(|_| random.rounded(0.15, 0.45) * spacing),
            exponents: std::array::from_fn(|_| random.rounded(0.1, 2.0)),
            color: COLORS[random.between(0.0, 8.0) as usize],
            name: name.clone(),
        };
        sink.shape(&shape)?;
        let mut within = || DVec3::from_array(std::array::from_fn(|_| random.rounded(-1.0, 1.0)));
        let axis = within() + DVec3::splat(1e-3);
        let position = within();
        let angle_deg = random.rounded(0.0, 360.0);
        let steps = vec![TransformStep::Rotate { axis, angle_deg }, TransformStep::Translate(position)];
        sink.child(&Child { target: name.clone(), alias: name, steps })?;
    }
    Ok(())
}

/// Size and rotation follow a smooth field.
fn glyphs(count: u32, random: &mut Random, sink: &mut dyn Sink) -> Result<()> {
    for i in 0..64u32 {
        sink.shape(&Shape {
            name: format!("g{i}"),
            radii: std::array::from_fn(|_| random.rounded(0.4, 1.0)),
            exponents: [0.25 * f64::from(i % 8) + 0.2, 0.25 * f64::from(i / 8) + 0.2],
            color: COLORS[(i % 8) as usize],
        })?;
    }
    let columns = f64::from(count).sqrt().ceil();
    let spacing = 2.0 / columns;
    for i in 0..count {
        let (row, column) = ((f64::from(i) / columns).floor(), f64::from(i) % columns);
        let (x, y) = (spacing * (column + 0.5) - 1.0, spacing * (row + 0.5) - 1.0);
        let field = (3.0 * x).sin() * (2.0 * y).cos();
        let size = spacing * (0.3 + 0.12 * field);
        let kind = ((field + 1.0) * 31.9) as u32;
        let steps = vec![
            TransformStep::Scale(DVec3::splat(size)),
            TransformStep::Rotate { axis: DVec3::new(x, y, 1.0), angle_deg: 120.0 * field },
            TransformStep::Translate(DVec3::new(x, y, 0.1 * field)),
        ];
        sink.child(&Child { target: format!("g{kind}"), alias: format!("a{i}"), steps })?;
    }
    Ok(())
}

/// The copies lie evenly on a spiral from pole to pole, as large as fits.
fn fractal(branches: u32, sink: &mut dyn Sink) -> Result<()> {
    sink.shape(&Shape { name: "ball".to_owned(), radii: [0.6; 3], exponents: [1.0; 2], color: COLORS[1] })?;
    sink.child(&Child { target: "ball".to_owned(), alias: "ball".to_owned(), steps: Vec::new() })?;
    let golden = 180.0 * (3.0 - 5f64.sqrt());
    let scale = (0.9 / f64::from(branches).sqrt()).min(0.45);
    for i in 0..branches {
        let height = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(branches);
        let polar_deg = height.acos().to_degrees();
        let steps = vec![
            TransformStep::Scale(DVec3::splat(scale)),
            TransformStep::Translate(DVec3::new(0.0, 0.0, 0.6 + 0.6 * scale)),
            TransformStep::Rotate { axis: DVec3::Y, angle_deg: polar_deg },
            TransformStep::Rotate { axis: DVec3::Z, angle_deg: golden * f64::from(i) },
        ];
        sink.child(&Child { target: ROOT.to_owned(), alias: format!("c{i}"), steps })?;
    }
    Ok(())
}

struct SceneSink<'a>(&'a mut Scene);

impl Sink for SceneSink<'_> {
    fn shape(&mut self, shape: &Shape) -> Result<()> {
        self.0.ensure_primitive(&shape.name)?;
        let primitive = self.0.primitive_mut(&shape.name)?;
        let [e, n] = shape.exponents;
        primitive.shape = Superquadric::new(shape.radii.into(), Exponents::new(e, n)?)?;
        primitive.material.color = shape.color.into();
        Ok(())
    }

    fn child(&mut self, child: &Child) -> Result<()> {
        self.0.add_child(ROOT, &child.alias, &child.target)?;
        for step in &child.steps {
            self.0.transform_child(ROOT, step.clone())?;
        }
        Ok(())
    }
}

struct TextSink {
    shapes: String,
    children: String,
}

impl Sink for TextSink {
    fn shape(&mut self, shape: &Shape) -> Result<()> {
        let Shape { name, radii: [x, y, z], exponents: [e, n], color: [r, g, b] } = shape;
        writeln!(self.shapes, "primitive {name}\ncoeff {x} {y} {z}\nexp {e} {n}\ncolor {r} {g} {b}")?;
        Ok(())
    }

    fn child(&mut self, child: &Child) -> Result<()> {
        let word = if child.target == ROOT { "addObject" } else { "addPrimitive" };
        writeln!(self.children, "{word} {} {}", child.target, child.alias)?;
        for step in &child.steps {
            match step {
                TransformStep::Translate(v) => writeln!(self.children, "translate {} {} {}", v.x, v.y, v.z)?,
                TransformStep::Scale(v) => writeln!(self.children, "scale {} {} {}", v.x, v.y, v.z)?,
                TransformStep::Rotate { axis: v, angle_deg } => {
                    writeln!(self.children, "rotate {} {} {} {angle_deg}", v.x, v.y, v.z)?;
                }
                TransformStep::Orient(_) | TransformStep::Affine(_) => {
                    bail!("a generated scene has no step {step:?}")
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use superegg_lang::load_text;
    use superegg_trace::CompiledScene;

    use super::*;

    #[test]
    fn text_and_scene_are_the_same() {
        for name in ["cloud:50", "glyphs:30", "fractal:7,5"] {
            let generated = GeneratedScene::parse(name).unwrap().unwrap();
            let scene = generated.scene(3).unwrap();
            let (session, diagnostics) = load_text(name, &generated.text(3));
            assert!(diagnostics.is_empty(), "{diagnostics:?}");
            assert_eq!(session.selected(), Some(ROOT));
            let count = |scene: &Scene| {
                CompiledScene::compile(scene, Some(ROOT), scene.depth).instance_count().clone()
            };
            assert_eq!(count(&scene), count(session.scene()));
            for (name, object) in scene.objects() {
                assert_eq!(session.scene().object(name).unwrap(), object);
            }
            assert_eq!(session.scene().camera, scene.camera);
            assert_eq!(session.scene().lights(), scene.lights());
        }
    }

    #[test]
    fn wrong_names_are_errors() {
        for bad in [
            "cloud:",
            "cloud:0",
            "cloud:x",
            "cloud:-1",
            "cloud:99999999",
            "fractal:20",
            "fractal:0,1",
            "fractal:2,65",
        ] {
            assert!(GeneratedScene::parse(bad).is_err(), "{bad}");
        }
        assert_eq!(GeneratedScene::parse("scene.scn").unwrap(), None);
        assert_eq!(GeneratedScene::parse("C:stuff.scn").unwrap(), None);
    }
}
