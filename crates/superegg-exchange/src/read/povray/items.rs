//! Objects, surfaces, lights and cameras.

use std::rc::Rc;

use superegg_geom::TransformStep;
use superegg_geom::glam::{DAffine3, DMat3, DVec3};

use super::expression::is_color_word;
use super::lexer::TokenKind;
use super::model::{LightSource, Node, NodeKind, Plane, PovCamera, Surface, map_of, steps_of};
use super::parser::{Declared, Parsed, Parser, Part};
use super::value::named_color;

/// From this `fade_power` on POV-Ray absorbs exponentially.
const EXPONENTIAL_POWER: f64 = 1000.0;
/// Words of objects that change nothing here; a switch may follow.
const FLAGS: [&str; 10] = [
    "no_shadow",
    "no_image",
    "no_reflection",
    "no_radiosity",
    "hollow",
    "double_illuminate",
    "inverse",
    "sturm",
    "uv_mapping",
    "split_union",
];

/// The collected modifiers of an object.
#[derive(Default)]
struct Modifiers {
    steps: Vec<TransformStep>,
    surface: Option<Surface>,
}

impl Modifiers {
    fn surface(&mut self) -> &mut Surface {
        self.surface.get_or_insert_default()
    }

    fn into_node(self, kind: NodeKind, levels: usize) -> Node {
        Node { kind, steps: self.steps, surface: self.surface.map(Rc::new), name: None, levels }
    }
}

/// The exponents (e, n) of a shape, and the transforms of the unit shape that its numbers mean.
type ShapeNumbers = ([f64; 2], Vec<TransformStep>);

/// Copies a part of a surface.
fn apply(part: Part, from: &Surface, to: &mut Surface) {
    match part {
        Part::Pigment => (to.color, to.through) = (from.color, from.through),
        Part::Interior => (to.index, to.absorb) = (from.index, from.absorb),
        Part::Finish => {
            let Surface { color, through, index, absorb, .. } = *to;
            *to = Surface { color, through, index, absorb, ..from.clone() };
        }
        Part::Texture => {
            let Surface { index, absorb, .. } = *to;
            *to = Surface { index, absorb, ..from.clone() };
        }
        Part::Material => *to = from.clone(),
    }
}

impl Parser {
    /// Reads a statement of a scene that begins with this word; `false` if it is none.
    pub(crate) fn scene_item(&mut self, word: &str) -> Parsed<bool> {
        match word {
            "camera" => {
                self.advance()?;
                self.scene.camera = Some(self.camera()?);
            }
            "light_source" => {
                self.advance()?;
                let light = self.light_source()?;
                self.scene.lights.push(light);
            }
            "background" => {
                self.advance()?;
                let mut color = None;
                self.block(&mut |parser| {
                    color = Some(parser.color()?.three());
                    parser.accept(',').map(drop)
                })?;
                self.scene.background = color;
            }
            "global_settings" => {
                self.advance()?;
                self.global_settings()?;
            }
            "plane" => {
                let line = self.line();
                self.advance()?;
                let plane = self.plane()?;
                if self.scene.plane.replace(plane).is_some() {
                    self.warn(line, "only the last plane is kept, as the floor");
                }
            }
            _ => {
                let Some(node) = self.object(word)? else { return Ok(false) };
                self.scene.objects.push(node);
            }
        }
        Ok(true)
    }

    fn global_settings(&mut self) -> Parsed<()> {
        self.block(&mut |parser| match parser.word().map(str::to_owned).as_deref() {
            Some("ambient_light") => {
                parser.advance()?;
                parser.ambient_light = parser.color()?.three().element_sum() / 3.0;
                Ok(())
            }
            Some("assumed_gamma") => {
                let line = parser.line();
                parser.advance()?;
                if parser.expression()?.number() != 1.0 {
                    parser.warn(line, "colours are read as linear, whatever 'assumed_gamma' is");
                }
                Ok(())
            }
            Some("radiosity" | "photons") => {
                parser.warn(parser.line(), "radiosity and photons are left out");
                parser.advance()?;
                parser.pass_block()
            }
            // Settings of POV-Ray's own work.
            Some(_) => {
                parser.advance()?;
                if parser.is_symbol('{') { parser.pass_block() } else { parser.pass_value() }
            }
            None => parser.advance(),
        })
    }

    /// Passes a value that has no effect, if one is next.
    fn pass_value(&mut self) -> Parsed<()> {
        match self.kind() {
            Some(TokenKind::Number(_) | TokenKind::Symbol('-' | '+' | '<' | '(')) => {
                self.expression().map(drop)
            }
            Some(TokenKind::Word(word))
                if matches!(word.as_str(), "on" | "off" | "yes" | "no" | "true" | "false") =>
            {
                self.advance()
            }
            _ => Ok(()),
        }
    }

    /// The value of a `#declare`.
    pub(crate) fn declared_value(&mut self, name: &str) -> Parsed<Declared> {
        let Some(word) = self.word().map(str::to_owned) else {
            return match self.kind() {
                Some(TokenKind::Text(_)) => {
                    self.advance()?;
                    Ok(Declared::Other)
                }
                _ => self.expression().map(Declared::Value),
            };
        };
        let part = part_of(&word);
        if let Some(part) = part {
            self.advance()?;
            let mut surface = Surface::default();
            self.surface_part(part, &mut surface)?;
            return Ok(Declared::Surface(part, surface));
        }
        match word.as_str() {
            "transform" => {
                let mut steps = Vec::new();
                self.transform(&mut steps)?;
                Ok(Declared::Steps(steps))
            }
            "camera" | "light_source" | "plane" | "background" => {
                let line = self.line();
                self.advance()?;
                self.pass_block()?;
                self.warn(line, &format!("a declared '{word}' is not read; write it into the scene"));
                Ok(Declared::Other)
            }
            _ => {
                if let Some(node) = self.object(&word)? {
                    let Ok(node) = Rc::try_unwrap(node) else { return Ok(Declared::Other) };
                    let node = self.node(Node { name: Some(name.to_owned()), ..node })?;
                    return Ok(Declared::Object(node));
                }
                if let Some(declared @ (Declared::Surface(..) | Declared::Object(_) | Declared::Steps(_))) =
                    self.declared.get(&word)
                {
                    let declared = declared.clone();
                    self.advance()?;
                    return Ok(declared);
                }
                if is_color_word(&word) || named_color(&word).is_some() {
                    let color = self.color()?;
                    // Colours may be used in sums.
                    return Ok(Declared::Value(color));
                }
                self.expression().map(Declared::Value)
            }
        }
    }

    /// Reads an object that begins with this word; `None`, and the word stays, if it begins none
    /// that is read.
    fn object(&mut self, word: &str) -> Parsed<Option<Rc<Node>>> {
        let node = match word {
            "superellipsoid" => {
                self.advance()?;
                self.shape(&mut |parser| {
                    let [e, n, ..] = parser.expression()?.five();
                    if !(e >= 0.0 && n >= 0.0 && e.is_finite() && n.is_finite()) {
                        return parser
                            .trouble(format!("the exponents must not be below 0, found {e} and {n}"));
                    }
                    Ok(([e, n], Vec::new()))
                })?
            }
            "sphere" => {
                self.advance()?;
                self.shape(&mut |parser| {
                    let center = parser.expression()?.three();
                    parser.accept(',')?;
                    let radius = parser.expression()?.number();
                    if !(radius > 0.0 && radius.is_finite()) {
                        return parser.trouble(format!("the radius must be above 0, found {radius}"));
                    }
                    let mut steps = Vec::new();
                    if radius != 1.0 {
                        steps.push(TransformStep::Scale(DVec3::splat(radius)));
                    }
                    if center != DVec3::ZERO {
                        steps.push(TransformStep::Translate(center));
                    }
                    Ok(([1.0, 1.0], steps))
                })?
            }
            "union" | "merge" => {
                self.advance()?;
                self.union()?
            }
            "object" => {
                self.advance()?;
                self.use_of_object()?
            }
            _ => return Ok(None),
        };
        self.node(node).map(Some)
    }

    /// Reads the block of a shape: its numbers, then its modifiers.
    fn shape(&mut self, numbers: &mut dyn FnMut(&mut Self) -> Parsed<ShapeNumbers>) -> Parsed<Node> {
        let mut modifiers = Modifiers::default();
        let mut exponents = None;
        self.block(&mut |parser| {
            if exponents.is_none() {
                let (found, steps) = numbers(parser)?;
                exponents = Some(found);
                modifiers.steps = steps;
                return Ok(());
            }
            parser.modifier(&mut modifiers)
        })?;
        let Some(exponents) = exponents else { return self.trouble("expected the numbers of a shape") };
        Ok(modifiers.into_node(NodeKind::Shape(exponents), 1))
    }

    fn union(&mut self) -> Parsed<Node> {
        let mut modifiers = Modifiers::default();
        let mut children: Vec<Rc<Node>> = Vec::new();
        self.block(&mut |parser| {
            let word = parser.word().map(str::to_owned).unwrap_or_default();
            match parser.object(&word)? {
                Some(child) => children.push(child),
                None => parser.modifier(&mut modifiers)?,
            }
            Ok(())
        })?;
        let levels = 1 + children.iter().map(|child| child.levels).max().unwrap_or(0);
        Ok(modifiers.into_node(NodeKind::Union(children), levels))
    }

    fn use_of_object(&mut self) -> Parsed<Node> {
        let mut modifiers = Modifiers::default();
        let mut target: Option<Rc<Node>> = None;
        self.block(&mut |parser| {
            if target.is_some() {
                return parser.modifier(&mut modifiers);
            }
            let word = parser.word().map(str::to_owned).unwrap_or_default();
            if let Some(node) = parser.object(&word)? {
                target = Some(node);
                return Ok(());
            }
            if let Some(Declared::Object(node)) = parser.declared.get(&word) {
                target = Some(Rc::clone(node));
                return parser.advance();
            }
            let shown: String = word.chars().take(40).collect();
            parser.trouble(format!("'{shown}' is no object that is read"))
        })?;
        let Some(target) = target else { return self.trouble("expected an object") };
        let levels = target.levels + 1;
        Ok(modifiers.into_node(NodeKind::Use(target), levels))
    }

    /// Reads one modifier of an object; unknown ones are skipped with a warning.
    fn modifier(&mut self, modifiers: &mut Modifiers) -> Parsed<()> {
        let Some(word) = self.word().map(str::to_owned) else { return self.advance() };
        if self.transform(&mut modifiers.steps)? {
            return Ok(());
        }
        if let Some(part) = part_of(&word) {
            self.advance()?;
            return self.surface_part(part, modifiers.surface());
        }
        if FLAGS.contains(&word.as_str()) {
            self.advance()?;
            return self.pass_value();
        }
        match word.as_str() {
            "bounded_by" | "photons" => {
                self.advance()?;
                self.pass_block()
            }
            _ => self.pass_unknown(),
        }
    }

    /// Reads a transform if one is next, and appends its steps.
    pub(crate) fn transform(&mut self, steps: &mut Vec<TransformStep>) -> Parsed<bool> {
        let Some(word @ ("translate" | "scale" | "rotate" | "matrix" | "transform")) = self.word() else {
            return Ok(false);
        };
        let word = word.to_owned();
        self.advance()?;
        match word.as_str() {
            "translate" => steps.push(TransformStep::Translate(self.finite_vector()?)),
            "scale" => {
                // POV-Ray takes a factor of 0 for 1.
                let factors = self.finite_vector()?.to_array();
                let factors = factors.map(|factor| if factor == 0.0 { 1.0 } else { factor });
                steps.push(TransformStep::Scale(DVec3::from_array(factors)));
            }
            "rotate" => {
                let angles = self.finite_vector()?;
                for (axis, angle_deg) in DVec3::AXES.into_iter().zip(angles.to_array()) {
                    if angle_deg != 0.0 {
                        steps.push(TransformStep::Rotate { axis, angle_deg });
                    }
                }
            }
            "matrix" => {
                let numbers = self.elements()?;
                let Ok(numbers) = <[f64; 12]>::try_from(numbers) else {
                    return self.trouble("expected a matrix of 12 numbers");
                };
                // Three numbers at a time are the images of x, y, z, and of the origin.
                match steps_of(&DAffine3::from_cols_array(&numbers)) {
                    Some(found) => steps.extend(found),
                    None => return self.trouble("the matrix flattens space"),
                }
            }
            _ => self.transform_block(steps)?,
        }
        Ok(true)
    }

    /// Reads what follows `transform`: an identifier or a block.
    fn transform_block(&mut self, steps: &mut Vec<TransformStep>) -> Parsed<()> {
        if !self.is_symbol('{') {
            let Some(found) = self.declared_steps()? else { return self.trouble("expected a transform") };
            steps.extend(found);
            return Ok(());
        }
        let mut found = Vec::new();
        self.block(&mut |parser| {
            if parser.transform(&mut found)? {
                return Ok(());
            }
            match parser.declared_steps()? {
                Some(declared) => found.extend(declared),
                // An inverse or a function of transforms would change what is shown.
                None => return parser.trouble("the transform is not understood"),
            }
            Ok(())
        })?;
        steps.extend(found);
        Ok(())
    }

    fn declared_steps(&mut self) -> Parsed<Option<Vec<TransformStep>>> {
        let found = match self.word().and_then(|word| self.declared.get(word)) {
            Some(Declared::Steps(steps)) => steps.clone(),
            _ => return Ok(None),
        };
        self.advance()?;
        Ok(Some(found))
    }

    fn finite_vector(&mut self) -> Parsed<DVec3> {
        let vector = self.expression()?.three();
        if vector.is_finite() { Ok(vector) } else { self.trouble("expected finite numbers") }
    }

    /// Reads the block of a part of a surface.
    fn surface_part(&mut self, part: Part, surface: &mut Surface) -> Parsed<()> {
        let mut has_color = false;
        self.block(&mut |parser| {
            let declared = parser.word().and_then(|word| parser.declared.get(word));
            if let Some(Declared::Surface(declared_part, from)) = declared {
                let (declared_part, from) = (*declared_part, from.clone());
                has_color = true;
                parser.advance()?;
                apply(declared_part, &from, surface);
                return Ok(());
            }
            if parser.transform(&mut Vec::new())? {
                return Ok(());
            }
            match part {
                Part::Pigment => parser.pigment_item(surface, &mut has_color),
                Part::Finish => parser.finish_item(surface),
                Part::Interior => parser.interior_item(surface),
                Part::Texture | Part::Material => match parser.word().and_then(part_of) {
                    Some(inner) => {
                        parser.advance()?;
                        parser.surface_part(inner, surface)
                    }
                    None => parser.pass_unknown(),
                },
            }
        })
    }

    fn pigment_item(&mut self, surface: &mut Surface, has_color: &mut bool) -> Parsed<()> {
        let is_value = match self.word() {
            Some(word) => {
                is_color_word(word)
                    || named_color(word).is_some()
                    || matches!(self.declared.get(word), Some(Declared::Value(_)))
            }
            None => self.is_symbol('<'),
        };
        if is_value {
            let [red, green, blue, filter, transmit] = self.color()?.five();
            if !*has_color {
                surface.color = DVec3::new(red, green, blue);
                surface.through = (filter + transmit).clamp(0.0, 1.0);
                *has_color = true;
            }
            return self.accept(',').map(drop);
        }
        match self.word().map(str::to_owned).as_deref() {
            Some("quick_color" | "quick_colour") => {
                self.advance()?;
                self.color().map(drop)
            }
            Some("color_map" | "colour_map") if !*has_color => {
                self.advance()?;
                self.block(&mut |parser| {
                    if *has_color {
                        return parser.advance();
                    }
                    if parser.accept('[')? {
                        parser.expression()?;
                        parser.accept(',')?;
                        return parser.pigment_item(surface, has_color);
                    }
                    parser.advance()
                })
            }
            Some(word) if !matches!(word, "color_map" | "colour_map") => {
                let shown: String = word.chars().take(40).collect();
                self.warn(self.line(), &format!("the pattern '{shown}' is read as its first colour"));
                self.advance()?;
                // A direction or number of the pattern.
                match self.word() {
                    Some("x" | "y" | "z") => self.advance(),
                    _ => self.pass_value(),
                }
            }
            Some(_) => {
                self.advance()?;
                self.pass_block()
            }
            None if self.is_symbol('{') => self.pass_block(),
            None => self.advance(),
        }
    }

    fn finish_item(&mut self, surface: &mut Surface) -> Parsed<()> {
        let Some(word) = self.word().map(str::to_owned) else { return self.advance() };
        let known = [
            "ambient",
            "emission",
            "diffuse",
            "specular",
            "phong",
            "phong_size",
            "roughness",
            "reflection",
            "brilliance",
            "metallic",
            "conserve_energy",
            "crand",
        ];
        if !known.contains(&word.as_str()) {
            return self.pass_unknown();
        }
        self.advance()?;
        if matches!(word.as_str(), "metallic" | "conserve_energy") {
            return self.pass_value();
        }
        if word == "reflection" && self.is_symbol('{') {
            return self.reflection(surface);
        }
        self.accept_word("albedo")?;
        let value = self.color()?.three();
        let mean = value.element_sum() / 3.0;
        match word.as_str() {
            "ambient" => surface.ambient = mean,
            "emission" => surface.ambient += mean,
            "diffuse" => surface.diffuse = value.x,
            "specular" | "phong" => surface.specular = value.x,
            // A highlight about the mirrored ray has a quarter of the exponent.
            "phong_size" => surface.shininess = Some(4.0 * value.x.max(0.0)),
            "roughness" if value.x > 0.0 => surface.shininess = Some(value.x.recip()),
            "reflection" => surface.reflection = [mean; 2],
            _ => {}
        }
        self.accept(',').map(drop)
    }

    fn reflection(&mut self, surface: &mut Surface) -> Parsed<()> {
        let mut range: Vec<f64> = Vec::new();
        self.block(&mut |parser| match parser.word().map(str::to_owned).as_deref() {
            Some("fresnel") => {
                parser.advance()?;
                surface.fresnel = parser.word() != Some("off");
                parser.pass_value()
            }
            Some("falloff" | "exponent" | "metallic") => {
                parser.advance()?;
                parser.pass_value()
            }
            _ => {
                range.push(parser.color()?.three().element_sum() / 3.0);
                parser.accept(',').map(drop)
            }
        })?;
        surface.reflection = match range[..] {
            [] => [0.0; 2],
            [only] => [only; 2],
            [least, most, ..] => [least, most],
        };
        Ok(())
    }

    fn interior_item(&mut self, surface: &mut Surface) -> Parsed<()> {
        let Some(word) = self.word().map(str::to_owned) else { return self.advance() };
        match word.as_str() {
            "ior" => {
                self.advance()?;
                surface.index = Some(self.expression()?.number());
                Ok(())
            }
            "fade_distance" | "fade_power" | "fade_color" | "fade_colour" => self.absorption(surface),
            "caustics" | "dispersion" | "dispersion_samples" => {
                self.advance()?;
                self.pass_value()
            }
            _ => self.pass_unknown(),
        }
    }

    /// The items of an absorption, which stand together.
    fn absorption(&mut self, surface: &mut Surface) -> Parsed<()> {
        let (mut distance, mut power, mut color) = (0.0, 0.0, DVec3::ZERO);
        let line = self.line();
        loop {
            if self.accept_word("fade_distance")? {
                distance = self.expression()?.number();
            } else if self.accept_word("fade_power")? {
                power = self.expression()?.number();
            } else if self.accept_word("fade_color")? || self.accept_word("fade_colour")? {
                color = self.color()?.three();
            } else {
                break;
            }
        }
        if power < EXPONENTIAL_POWER || distance <= 0.0 {
            self.warn(line, "only exponential absorption is read (fade_power 1000 or more)");
            return Ok(());
        }
        surface.absorb = ((DVec3::ONE - color) / distance).max(DVec3::ZERO);
        Ok(())
    }

    fn light_source(&mut self) -> Parsed<LightSource> {
        let line = self.line();
        let mut light = LightSource {
            position: DVec3::ZERO,
            color: DVec3::ONE,
            target: DVec3::ZERO,
            cone: None,
            is_parallel: false,
            attenuation: 0.0,
            radius: 0.0,
        };
        let (mut has_position, mut has_color, mut has_target) = (false, false, false);
        let (mut fade_distance, mut fade_power) = (0.0_f64, 0.0);
        let mut steps = Vec::new();
        self.block(&mut |parser| {
            if !has_position {
                light.position = parser.finite_vector()?;
                has_position = true;
                return parser.accept(',').map(drop);
            }
            if parser.transform(&mut steps)? || parser.accept(',')? {
                return Ok(());
            }
            let word = parser.word().map(str::to_owned).unwrap_or_default();
            let number = |parser: &mut Self| {
                parser.advance()?;
                Ok::<_, super::parser::Trouble>(parser.expression()?.number())
            };
            match word.as_str() {
                "spotlight" => {
                    light.cone.get_or_insert([30.0, 45.0]);
                    parser.advance()
                }
                "parallel" => {
                    light.is_parallel = true;
                    parser.advance()
                }
                "point_at" => {
                    parser.advance()?;
                    light.target = parser.finite_vector()?;
                    has_target = true;
                    Ok(())
                }
                "radius" => number(parser).map(|angle| light.cone.get_or_insert([30.0, 45.0])[0] = angle),
                "falloff" => number(parser).map(|angle| light.cone.get_or_insert([30.0, 45.0])[1] = angle),
                "tightness" | "adaptive" => number(parser).map(drop),
                "fade_distance" => number(parser).map(|distance| fade_distance = distance),
                "fade_power" => number(parser).map(|power| fade_power = power),
                "jitter" | "circular" | "orient" => parser.advance(),
                "area_light" => {
                    parser.advance()?;
                    light.radius = 0.5 * parser.finite_vector()?.length();
                    for _ in 0..3 {
                        parser.accept(',')?;
                        parser.expression()?;
                    }
                    Ok(())
                }
                _ if !has_color => {
                    light.color = parser.color()?.three();
                    has_color = true;
                    Ok(())
                }
                _ => parser.pass_unknown(),
            }
        })?;
        let map = map_of(&steps);
        light.position = map.transform_point3(light.position);
        light.target = map.transform_point3(light.target);
        light.color = light.color.max(DVec3::ZERO);
        if fade_power == 2.0 && fade_distance > 0.0 {
            // POV-Ray's light is 2 / (1 + (d / distance)^2).
            light.attenuation = fade_distance.powi(2).recip();
            light.color *= 2.0;
        } else if fade_power != 0.0 {
            self.warn(line, "only 'fade_power 2' with a distance is read; the light does not fade");
        }
        if light.cone.is_some() && !has_target {
            light.target = light.position + map.transform_vector3(DVec3::Z);
        }
        if !light.color.is_finite() {
            return self.trouble("expected a finite colour");
        }
        Ok(light)
    }

    fn plane(&mut self) -> Parsed<Plane> {
        let line = self.line();
        let mut modifiers = Modifiers::default();
        let mut plane = None;
        self.block(&mut |parser| {
            if plane.is_some() {
                return parser.modifier(&mut modifiers);
            }
            let normal = parser.finite_vector()?;
            parser.accept(',')?;
            let height = parser.expression()?.number();
            if normal == DVec3::ZERO || !height.is_finite() {
                return parser.trouble("expected a normal and a distance");
            }
            plane = Some((normal.normalize(), height));
            Ok(())
        })?;
        let Some((normal, height)) = plane else { return self.trouble("expected a normal and a distance") };
        let map = map_of(&modifiers.steps);
        let turned = DMat3::from_cols_array(&map.matrix3.inverse().transpose().to_cols_array()) * normal;
        let Some(turned) = turned.try_normalize() else { return self.trouble("the plane has no normal") };
        let height = map.transform_point3(height * normal).dot(turned);
        if !height.is_finite() {
            self.warn(line, "the plane is out of the range of numbers");
        }
        Ok(Plane { normal: turned, height, surface: modifiers.surface.map(Rc::new) })
    }

    fn camera(&mut self) -> Parsed<PovCamera> {
        let mut camera = PovCamera::default();
        let (mut look_at, mut sky, mut angle) = (None, DVec3::Y, None);
        let mut steps = Vec::new();
        self.block(&mut |parser| {
            if parser.transform(&mut steps)? || parser.accept(',')? {
                return Ok(());
            }
            let word = parser.word().map(str::to_owned).unwrap_or_default();
            let vector = |parser: &mut Self| {
                parser.advance()?;
                parser.finite_vector()
            };
            match word.as_str() {
                "perspective" => parser.advance(),
                "orthographic" => {
                    camera.is_orthographic = true;
                    parser.advance()
                }
                "location" => vector(parser).map(|v| camera.location = v),
                "direction" => vector(parser).map(|v| camera.direction = v),
                "right" => vector(parser).map(|v| camera.right = v),
                "up" => vector(parser).map(|v| camera.up = v),
                "sky" => vector(parser).map(|v| sky = v),
                "look_at" => vector(parser).map(|v| look_at = Some(v)),
                "focal_point" => vector(parser).map(|v| camera.focal_point = Some(v)),
                "angle" => {
                    parser.advance()?;
                    angle = Some(parser.expression()?.number());
                    Ok(())
                }
                "aperture" => {
                    parser.advance()?;
                    camera.aperture = parser.expression()?.number();
                    Ok(())
                }
                "blur_samples" | "variance" | "confidence" => {
                    parser.advance()?;
                    parser.pass_value()
                }
                _ => parser.pass_unknown(),
            }
        })?;
        self.framed(&mut camera, look_at, sky, angle)?;
        let map = map_of(&steps);
        camera.location = map.transform_point3(camera.location);
        camera.focal_point = camera.focal_point.map(|point| map.transform_point3(point));
        for v in [&mut camera.direction, &mut camera.right, &mut camera.up] {
            *v = map.transform_vector3(*v);
        }
        Ok(camera)
    }

    /// Applies `angle` and `look_at`, which keep the lengths and the handedness of the vectors.
    fn framed(
        &self,
        camera: &mut PovCamera,
        look_at: Option<DVec3>,
        sky: DVec3,
        angle: Option<f64>,
    ) -> Parsed<()> {
        let lengths = [camera.direction, camera.right, camera.up].map(DVec3::length);
        let [mut reach, width, height] = lengths;
        if lengths.contains(&0.0) {
            return self.trouble("the vectors of the camera must not be 0");
        }
        if let Some(angle) = angle {
            if !(angle > 0.0 && angle < 180.0) {
                return self.trouble(format!("the angle must be between 0 and 180, found {angle}"));
            }
            let half = (0.5 * angle).to_radians().tan();
            if camera.is_orthographic {
                // The picture is as wide as the angle sees at the target.
                let distance = look_at.map_or(reach, |target| (target - camera.location).length());
                let factor = 2.0 * distance * half / width;
                camera.right *= factor;
                camera.up *= factor;
            } else {
                reach = 0.5 * width / half;
                camera.direction *= reach / lengths[0];
            }
        }
        let Some(target) = look_at else { return Ok(()) };
        let is_left = camera.up.cross(camera.direction).dot(camera.right) > 0.0;
        let (width, height) = match camera.is_orthographic {
            true => (camera.right.length(), camera.up.length()),
            false => (width, height),
        };
        let forward = (target - camera.location).try_normalize();
        let Some(forward) = forward else { return self.trouble("the camera looks at its own location") };
        let right = sky.cross(forward).try_normalize();
        let Some(right) = right else { return self.trouble("the camera looks along its sky vector") };
        camera.direction = reach * forward;
        camera.up = height * forward.cross(right);
        camera.right = if is_left { width * right } else { -width * right };
        Ok(())
    }
}

/// The part of a surface whose block begins with this word.
fn part_of(word: &str) -> Option<Part> {
    Some(match word {
        "pigment" => Part::Pigment,
        "finish" => Part::Finish,
        "interior" => Part::Interior,
        "texture" => Part::Texture,
        "material" => Part::Material,
        _ => return None,
    })
}
