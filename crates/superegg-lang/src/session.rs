//! The interpreter: commands change a scene.

use superegg_geom::Superquadric;
use superegg_geom::glam::DVec3;
use superegg_scene::{Camera, Entity, Floor, Lens, Light, LightKind, Pattern, Primitive, Scene, SceneError};

use crate::command::{Command, Request};
use crate::diagnostic::Fault;
use crate::parser::{Parsed, parse_line, shorten};
use crate::settings::{self, Settings};
use crate::spec::{ArgKind, Needs, Of};
use crate::suggest::nearest;
use crate::table::CHECKER_SIZE;
use crate::{animation, help, info};

/// A scene with what is selected in it, and the settings. Every change goes through [`Session::run_line`] or [`Session::execute`]. A clone
/// takes no time that grows with the scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Session {
    pub(crate) scene: Scene,
    pub(crate) selected: Option<String>,
    /// The settings that do not belong to the scene.
    pub settings: Settings,
}

/// What came of a line.
#[derive(Clone, Debug, PartialEq)]
pub enum Effect {
    /// Nothing in the scene or the selection changed: a blank line, or a setting of the session.
    Done,
    /// The scene or the selection was changed; perhaps there is something to say about it.
    Changed(Option<String>),
    /// Show this text.
    Print(String),
    /// Something that whoever runs the session must do.
    Ask(Request),
}

impl Session {
    /// The scene as it is now.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The name of the selected primitive or object.
    pub fn selected(&self) -> Option<&str> {
        self.selected.as_deref()
    }

    /// The name of what is selected, and the alias of the child at its cursor.
    pub fn place(&self) -> (Option<&str>, Option<&str>) {
        place(&self.scene, self.selected())
    }

    /// What there is, in words, or the details of each thing named, as the command `info` tells them.
    ///
    /// # Errors
    /// A name that nothing has.
    pub fn describe(&self, names: &[String]) -> Result<String, Fault> {
        info::info(self, names).map_err(|(_, fault)| fault)
    }

    /// Back to an empty scene with nothing selected. The session's settings stay.
    pub fn clear(&mut self) {
        *self = Self { settings: self.settings, ..Self::default() };
    }

    /// Reads and carries out one line. A line without a command does nothing.
    ///
    /// # Errors
    /// The line cannot be read or carried out; then the session is as it was.
    pub fn run_line(&mut self, line: &str) -> Result<Effect, Fault> {
        match parse_line(line)? {
            Some(parsed) => self.execute(&parsed),
            None => Ok(Effect::Done),
        }
    }

    /// Carries out a parsed command.
    ///
    /// # Errors
    /// What it needs is not selected, a name does not fit, or a transform could not be undone; then the session is as it was.
    pub fn execute(&mut self, parsed: &Parsed) -> Result<Effect, Fault> {
        self.check_selection(parsed)?;
        let scene_fault = |session: &Self, error: SceneError| session.fault_of(&error, parsed);
        match &parsed.command {
            Command::Help(names) => {
                return help::help(names)
                    .map(Effect::Print)
                    .map_err(|(i, fault)| at_word(fault, parsed, i + 1));
            }
            Command::Info(names) => {
                return info::info(self, names)
                    .map(Effect::Print)
                    .map_err(|(i, fault)| at_word(fault, parsed, i + 1));
            }
            Command::Ask(request) => return Ok(Effect::Ask(request.clone())),
            Command::Set { setting, value } => {
                let set = settings::set(&mut self.scene.picture, &mut self.settings, setting, value);
                let spec = set.map_err(|(word, fault)| at_word(fault, parsed, word))?;
                return Ok(if spec.is_of_scene { Effect::Changed(None) } else { Effect::Done });
            }
            Command::Get(names) => {
                return settings::tell(&self.scene.picture, &self.settings, names)
                    .map(Effect::Print)
                    .map_err(|(i, fault)| at_word(fault, parsed, i + 1));
            }
            Command::Clear => self.clear(),
            Command::Delete(name) => {
                let uses = self.scene.delete(name).map_err(|error| scene_fault(self, error))?;
                self.selected.take_if(|selected| selected == name);
                return Ok(Effect::Changed(gone_with(name, &uses)));
            }
            Command::Rename { name, new } => {
                self.scene.rename(name, new).map_err(|error| scene_fault(self, error))?;
                if self.selected.as_ref() == Some(name) {
                    self.selected = Some(new.clone());
                }
            }
            Command::Copy { name, new } => {
                self.scene.copy(name, new).map_err(|error| scene_fault(self, error))?;
            }
            Command::Deselect => self.selected = None,
            Command::Primitive(name) => {
                self.scene.ensure_primitive(name).map_err(|error| scene_fault(self, error))?;
                self.selected = Some(name.clone());
            }
            Command::Object(name) => {
                self.scene.ensure_object(name).map_err(|error| scene_fault(self, error))?;
                self.selected = Some(name.clone());
            }
            Command::SetLight(name, light) => {
                check_light(light, parsed)?;
                self.scene.set_light(name, *light);
            }
            Command::SetLightRadius { name, radius } => {
                let light = *self.scene.light(name).map_err(|error| scene_fault(self, error))?;
                self.scene.set_light(name, Light { radius: *radius, ..light });
            }
            Command::RemoveLight(name) => {
                self.scene.remove_light(name).map_err(|error| scene_fault(self, error))?;
            }
            Command::SetCamera(camera) => self.set_camera(camera, parsed)?,
            Command::SetCameraUp(up) => {
                check_direction(*up, "the direction that goes up in the picture, such as 0 1 0", parsed)?;
                self.scene.camera.up = *up;
            }
            Command::SetOrthographic(height) => {
                self.scene.camera.ortho_height = (*height > 0.0).then_some(*height);
            }
            Command::SetLens { radius, focus } => {
                let focus = focus.unwrap_or_else(|| distance_of_target(&self.scene.camera));
                if !focus.is_finite() {
                    let fault =
                        Fault::new("out-of-range", "the camera's target is too far away to be in focus");
                    return Err(fault
                        .help("give the distance in focus: lens radius focus")
                        .at(arguments(parsed)));
                }
                self.scene.camera.lens = (*radius > 0.0).then_some(Lens { radius: *radius, focus });
            }
            Command::SetBackground(color) => self.scene.background = *color,
            Command::SetSky(sky) => {
                if let Some(sky) = sky {
                    check_direction(sky.up, "the direction that is above, such as 0 1 0", parsed)?;
                }
                self.scene.sky = *sky;
                if sky.is_none() {
                    self.scene.remove_keys(None, |subject| &*subject.command == "sky");
                }
            }
            Command::SetFloor { height, surface, up } => {
                if let Some(name) = surface {
                    self.scene.primitive(name).map_err(|error| self.fault_of(&error, parsed))?;
                }
                check_direction(*up, "the direction that is up from the floor, such as 0 1 0", parsed)?;
                let surface = surface.as_deref().map(Into::into);
                self.scene.floor = Some(Floor { height: *height, up: *up, surface });
            }
            Command::SetFloorUp(up) => {
                check_direction(*up, "the direction that is up from the floor, such as 0 1 0", parsed)?;
                self.floor_or_fault(parsed)?.up = *up;
            }
            Command::RemoveFloor => {
                self.floor_or_fault(parsed)?;
                self.scene.floor = None;
                self.scene.remove_keys(None, |subject| ["floor", "floorUp"].contains(&&*subject.command));
            }
            Command::SetAmbientOcclusion(occlusion) => self.scene.ambient_occlusion = *occlusion,
            Command::SetKey { frame, words } => {
                let Some(keyed) = &parsed.keyed else { return Ok(Effect::Done) };
                animation::set_key(self, *frame, keyed, words)?;
            }
            Command::RemoveKeys { frame, command } => {
                let told = animation::remove_keys(self, frame, command.as_deref(), parsed)?;
                return Ok(Effect::Changed(Some(told)));
            }
            Command::SetDepth(depth) => self.scene.depth = *depth,
            command => match parsed.spec.needs {
                Needs::Object => {
                    self.change_object(command).map_err(|error| scene_fault(self, error))?;
                }
                _ => self.change_primitive(command, parsed)?,
            },
        }
        Ok(Effect::Changed(None))
    }

    /// The commands that change the selected primitive.
    fn change_primitive(&mut self, command: &Command, parsed: &Parsed) -> Result<(), Fault> {
        let name = self.selected.as_deref().unwrap_or_default();
        let shape_fault = |error: superegg_geom::ShapeError| {
            Fault::new("out-of-range", error.to_string()).at(arguments(parsed))
        };
        let primitive: &mut Primitive = match self.scene.primitive_mut(name) {
            Ok(primitive) => primitive,
            Err(error) => return Err(self.fault_of(&error, parsed)),
        };
        let shape = primitive.shape;
        match command {
            Command::SetRadii(radii) => {
                primitive.shape = Superquadric::new(*radii, shape.exponents()).map_err(shape_fault)?;
            }
            Command::SetExponents(exponents) => {
                primitive.shape = Superquadric::new(shape.radii(), *exponents).map_err(shape_fault)?;
            }
            Command::SetPatches(patches) => primitive.patches = *patches,
            Command::SetColor(color) => primitive.material.color = *color,
            Command::SetShare(share, value) => primitive.material.set_share(*share, *value),
            Command::SetIndex(index) => primitive.material.index = *index,
            Command::SetShininess(exponent) => primitive.material.shininess = Some(*exponent),
            Command::SetFresnel(on) => primitive.material.fresnel = *on,
            Command::SetAbsorption(absorb) => primitive.material.absorb = *absorb,
            Command::SetPattern { word, numbers } => {
                primitive.material.pattern = pattern(word, numbers, parsed)?;
            }
            _ => {}
        }
        Ok(())
    }

    /// The commands that change the selected object.
    fn change_object(&mut self, command: &Command) -> Result<(), SceneError> {
        let (name, scene) = (self.selected.as_deref().unwrap_or_default(), &mut self.scene);
        match command {
            Command::AddObject { target, alias } => {
                scene.object(target)?;
                scene.add_child(name, alias.as_ref().unwrap_or(target), target)
            }
            Command::AddPrimitive { target, alias } => {
                scene.primitive(target)?;
                scene.add_child(name, alias.as_ref().unwrap_or(target), target)
            }
            Command::RemoveChild(alias) => scene.remove_child(name, alias),
            Command::SetCursor(alias) => scene.move_cursor(name, alias),
            Command::TransformChild(step) => scene.transform_child(name, *step),
            Command::TransformWhole(step) => scene.transform_whole(name, *step),
            _ => Ok(()),
        }
    }

    fn set_camera(&mut self, camera: &Camera, parsed: &Parsed) -> Result<(), Fault> {
        let to_target = camera.target - camera.position;
        if !to_target.is_finite() || to_target.abs().max_element() == 0.0 {
            let fault =
                Fault::new("no-direction", "the camera and its target must be two places, not too far apart");
            return Err(fault
                .help("the first three numbers place the camera, the next three what it looks at")
                .at(arguments(parsed)));
        }
        let Camera { position, target, fov_deg, .. } = *camera;
        self.scene.camera = Camera { position, target, fov_deg, ..self.scene.camera };
        Ok(())
    }

    fn floor_or_fault(&mut self, parsed: &Parsed) -> Result<&mut Floor, Fault> {
        let fault = Fault::new("no-floor", "there is no floor");
        let fault = fault.help("floor lays one, for example: floor -1").at(parsed.columns[0].clone());
        self.scene.floor.as_mut().ok_or(fault)
    }

    fn check_selection(&self, parsed: &Parsed) -> Result<(), Fault> {
        if parsed.spec.needs == Needs::Nothing {
            return Ok(());
        }
        let selected = self.selected.as_deref().and_then(|name| Some((name, self.scene.get(name)?)));
        let (wanted, how) = match (parsed.spec.needs, selected) {
            (Needs::Nothing, _)
            | (Needs::Primitive, Some((_, Entity::Primitive(_))))
            | (Needs::Object, Some((_, Entity::Object(_)))) => return Ok(()),
            (Needs::Primitive, _) => ("primitive", "'primitive NAME' selects one, or makes it"),
            (Needs::Object, _) => ("object", "'object NAME' selects one, or makes it"),
        };
        let found = match selected {
            Some((name, entity)) => format!("'{}', which is selected, is {}", shorten(name), entity.kind()),
            None => "nothing is selected".to_owned(),
        };
        let message = format!("{} needs a selected {wanted}; {found}", parsed.spec.name);
        Err(Fault::new("selection", message).help(how).at(parsed.columns[0].clone()))
    }

    /// A refusal of the scene as a fault that points to the word it is about.
    fn fault_of(&self, error: &SceneError, parsed: &Parsed) -> Fault {
        let names = || self.scene.entities().map(|(name, _)| name);
        // Where the name stands that is of something.
        let place =
            parsed.spec.all_args().position(|arg| matches!(arg.kind, ArgKind::Name(of) if of != Of::New));
        let place = place.unwrap_or(0) + 1;
        let (code, word, help) = match error {
            SceneError::Unknown(name) => {
                ("unknown-name", place, did_you_mean(name, names(), "'info' lists what there is"))
            }
            SceneError::NotAnObject(_) => (
                "wrong-kind",
                1,
                "addPrimitive adds a primitive, and 'primitive NAME' selects one".to_owned(),
            ),
            SceneError::NotAPrimitive(_) if parsed.spec.name == "floor" => {
                ("wrong-kind", place, "a floor has the surface of a primitive".to_owned())
            }
            SceneError::NotAPrimitive(_) => {
                ("wrong-kind", place, "addObject adds an object, and 'object NAME' selects one".to_owned())
            }
            SceneError::AliasTaken { .. } => (
                "alias-taken",
                parsed.columns.len() - 1,
                format!("give another alias as the last word, such as: {} NAME ALIAS", parsed.spec.name),
            ),
            SceneError::UnknownAlias { object, alias } => {
                let children = self.scene.object(object).ok();
                let aliases = children.iter().flat_map(|object| object.children()).map(|(alias, _)| alias);
                ("unknown-name", 1, did_you_mean(alias, aliases, "'info selected' lists the children"))
            }
            SceneError::NoChild(_) => ("no-child", 0, "addPrimitive or addObject adds a child".to_owned()),
            SceneError::NameTaken(name) => {
                ("name-taken", 2, format!("take another name; 'show {}' tells what has it", shorten(name)))
            }
            SceneError::UnknownLight(name) => {
                let lights = self.scene.named_lights().map(|(name, _)| name);
                ("unknown-name", 1, did_you_mean(name, lights, "'info' lists the lights"))
            }
            SceneError::KeyNumbers { .. } => ("key-numbers", 0, "'info' lists the keys".to_owned()),
            SceneError::Transform(_) => {
                let fault = Fault::new("transform", error.to_string()).at(arguments(parsed));
                return fault.help(format!("for example: {}", parsed.spec.example));
            }
        };
        at_word(Fault::new(code, error.to_string()).help(help), parsed, word)
    }
}

/// What is selected, and the alias of the child at its cursor.
pub(crate) fn place<'a>(scene: &'a Scene, selected: Option<&'a str>) -> (Option<&'a str>, Option<&'a str>) {
    let object = selected.and_then(|name| scene.object(name).ok());
    (selected, object.and_then(|object| object.cursor()).map(|(alias, _)| alias))
}

/// What went with a deleted primitive or object, in words.
fn gone_with(name: &str, uses: &[(String, String)]) -> Option<String> {
    const MOST_NAMED: usize = 5;
    let mut named: Vec<String> =
        uses.iter().take(MOST_NAMED).map(|(object, alias)| shorten(&format!("{object}/{alias}"))).collect();
    if uses.len() > MOST_NAMED {
        named.push(format!("{} more", uses.len() - MOST_NAMED));
    }
    let plural = if uses.len() == 1 { "child" } else { "children" };
    (!uses.is_empty()).then(|| {
        format!("'{}' is deleted, and with it {} {plural}: {}", shorten(name), uses.len(), named.join(", "))
    })
}

pub(crate) fn did_you_mean<'a>(word: &str, known: impl Iterator<Item = &'a str>, otherwise: &str) -> String {
    match nearest(word, known) {
        Some(near) => format!("did you mean '{near}'?"),
        None => otherwise.to_owned(),
    }
}

/// Refuses the direction 0 0 0.
fn check_direction(direction: DVec3, wanted: &str, parsed: &Parsed) -> Result<(), Fault> {
    if direction.abs().max_element() > 0.0 {
        return Ok(());
    }
    let fault = Fault::new("no-direction", "the direction 0 0 0 leads nowhere");
    Err(fault.help(format!("give {wanted}")).at(arguments(parsed)))
}

/// Refuses a spot without an axis and a sun without a direction.
fn check_light(light: &Light, parsed: &Parsed) -> Result<(), Fault> {
    match light.kind {
        LightKind::Point { .. } => Ok(()),
        LightKind::Sun { direction } => {
            check_direction(direction, "the direction towards the sun, such as 1 3 2", parsed)
        }
        LightKind::Spot { position, target, .. } => {
            let axis = target - position;
            if axis.is_finite() && axis.abs().max_element() > 0.0 {
                return Ok(());
            }
            let fault =
                Fault::new("no-direction", "a spot and its target must be two places, not too far apart");
            Err(fault
                .help("the first three numbers place the light, the next three what it shines at")
                .at(arguments(parsed)))
        }
    }
}

/// The distance from a camera to its target; infinite where it is too large for a number.
fn distance_of_target(camera: &Camera) -> f64 {
    let way = camera.target - camera.position;
    let largest = way.abs().max_element();
    largest * (way / largest).length()
}

/// The pattern of a word and its numbers: the table lets through more numbers than each word takes.
fn pattern(word: &str, numbers: &[f64], parsed: &Parsed) -> Result<Pattern, Fault> {
    let color = || DVec3::from_slice(&numbers[..3]);
    match (word, numbers.len()) {
        ("none", 0) => Ok(Pattern::None),
        ("checker", 3) => Ok(Pattern::Checker { color: color(), size: CHECKER_SIZE }),
        ("checker", 4) if numbers[3] > 0.0 => Ok(Pattern::Checker { color: color(), size: numbers[3] }),
        ("checker", 4) => {
            let fault = Fault::new("out-of-range", "size of a checker must be above 0");
            Err(at_word(fault.help("for example: setPattern checker 0.1 0.1 0.1 0.25"), parsed, 5))
        }
        ("gradient", 3) => Ok(Pattern::Gradient { color: color(), direction: DVec3::Z }),
        ("gradient", 6) => {
            let direction = DVec3::from_slice(&numbers[3..]);
            check_direction(direction, "the direction in which the colour changes, such as 0 0 1", parsed)?;
            Ok(Pattern::Gradient { color: color(), direction })
        }
        _ => {
            let (takes, example) = match word {
                "none" => ("no numbers", "setPattern none"),
                "checker" => ("a colour r g b, and perhaps a size", "setPattern checker 0.1 0.1 0.1 0.25"),
                _ => {
                    ("a colour r g b, and perhaps a direction x y z", "setPattern gradient 0.1 0.2 0.6 0 0 1")
                }
            };
            let message = format!("'{word}' takes {takes}; here are {} numbers", numbers.len());
            Err(Fault::new("argument-count", message)
                .help(format!("for example: {example}"))
                .at(arguments(parsed)))
        }
    }
}

pub(crate) fn at_word(fault: Fault, parsed: &Parsed, word: usize) -> Fault {
    let columns = parsed.columns.get(word).unwrap_or(&parsed.columns[0]).clone();
    fault.at(columns)
}

/// The characters of all arguments.
pub(crate) fn arguments(parsed: &Parsed) -> std::ops::Range<usize> {
    let first = parsed.columns.get(1).unwrap_or(&parsed.columns[0]);
    first.start..parsed.columns[parsed.columns.len() - 1].end
}

#[cfg(test)]
mod tests {
    use superegg_geom::glam::DVec3;

    use super::*;

    fn session(lines: &[&str]) -> Session {
        let mut session = Session::default();
        for line in lines {
            session.run_line(line).unwrap_or_else(|fault| panic!("{line}: {fault:?}"));
        }
        session
    }

    #[test]
    fn a_fault_changes_nothing() {
        let before = session(&["prm ball", "obj o", "ap ball", "ss 1e-300 1 1"]);
        for (line, code) in [
            ("coeff 1 1 1", "selection"),
            ("prm o", "wrong-kind"),
            ("obj ball", "wrong-kind"),
            ("ap ball", "alias-taken"),
            ("ap bal second", "unknown-name"),
            ("ao ball second", "wrong-kind"),
            ("cursor bal", "unknown-name"),
            ("rs 0 0 0 10", "transform"),
            ("ss 1e-100 1 1", "transform"),
            ("unlight lamp", "unknown-name"),
            ("camera 0 0 1 0 0 1", "no-direction"),
            ("cameraUp 0 0 -0", "no-direction"),
            ("spot lamp 1 2 3 1 2 3 40", "no-direction"),
            ("spot lamp -1e308 0 0 1e308 0 0 40", "no-direction"),
            ("sun noon 0 -0 0", "no-direction"),
            ("lightRadius lamp 1", "unknown-name"),
            ("sky 1 1 1 0 0 1 0 0 0", "no-direction"),
            ("floor 0 bal", "unknown-name"),
            ("floor 0 o", "wrong-kind"),
            ("floor 0 ball 0 0 0", "no-direction"),
            ("floorUp 0 0 1", "no-floor"),
            ("unfloor", "no-floor"),
            ("absorb 1 1 1", "selection"),
            ("help nonsense", "unknown-command"),
            ("delete nobody", "unknown-name"),
            ("rename ball o", "name-taken"),
            ("rename o o", "name-taken"),
            ("copy nobody x", "unknown-name"),
            ("copy ball ball", "name-taken"),
            ("remove bal", "unknown-name"),
            ("set size 0x5", "out-of-range"),
            ("set sizes 5x5", "unknown-setting"),
            ("get nothing", "unknown-setting"),
            ("stop rendr", "unknown-word"),
            ("save --histry x", "unknown-option"),
            ("info nobody", "unknown-name"),
        ] {
            let mut after = before.clone();
            let fault = after.run_line(line).unwrap_err();
            assert_eq!(fault.code, code, "{line}: {}", fault.message);
            assert!(fault.help.is_some() && fault.columns.is_some(), "{line}");
            assert_eq!(after, before, "{line}");
        }
    }

    #[test]
    fn a_pattern_takes_the_numbers_of_its_word() {
        let before = session(&["prm ball", "pattern checker 1 0 0"]);
        for (line, code, columns) in [
            ("pattern none 1 0 0", "argument-count", 8..18),
            ("pattern checker", "argument-count", 8..15),
            ("pattern checker 1 0 0 1 1 1", "argument-count", 8..27),
            ("pattern checker 1 0 0 -1", "out-of-range", 22..24),
            ("pattern gradient 1 0 0 2", "argument-count", 8..24),
            ("pattern gradient 1 0 0 0 0 0", "no-direction", 8..28),
            ("pattern stripes", "unknown-word", 8..15),
        ] {
            let mut after = before.clone();
            let fault = after.run_line(line).unwrap_err();
            assert_eq!((fault.code, fault.columns), (code, Some(columns)), "{line}");
            assert_eq!(after, before, "{line}");
        }
    }

    #[test]
    fn a_light_is_replaced_whole_and_a_camera_keeps_its_lens() {
        let mut session = session(&["light lamp 0 0 5", "lightRadius lamp 2", "lens 0.5", "ortho 4"]);
        assert_eq!(session.scene().light("lamp").unwrap().radius, 2.0);
        session.run_line("spot lamp 0 0 5 0 0 0 30").unwrap();
        assert_eq!(session.scene().light("lamp").unwrap().radius, 0.0);
        session.run_line("camera 0 0 3 0 0 0").unwrap();
        let camera = session.scene().camera;
        assert_eq!((camera.lens, camera.ortho_height), (Some(Lens { radius: 0.5, focus: 10.0 }), Some(4.0)));
        session.run_line("lens 0").unwrap();
        session.run_line("ortho -0").unwrap();
        assert_eq!((session.scene().camera.lens, session.scene().camera.ortho_height), (None, None));
    }

    #[test]
    fn a_floor_follows_the_primitive_it_names() {
        let mut session = session(&["prm tile", "floor -1 tile 0 0 1", "rename tile slab"]);
        assert_eq!(session.scene().floor.as_ref().unwrap().surface.as_deref(), Some("slab"));
        let loaded = crate::load_text("saved", &crate::write_session(&session)).0;
        assert_eq!(loaded, session);
        session.run_line("delete slab").unwrap();
        let text = crate::write_session(&session);
        assert!(text.contains("floor -1\nfloorUp 0 0 1\n"), "{text}");
        assert_eq!(crate::load_text("saved", &text).0, session);
    }

    #[test]
    fn the_cursor_is_the_objects_own_and_follows_what_is_added() {
        let session = session(&[
            "prm a", "prm b", "obj o", "ap a", "ap b", "obj p", "obj o", "xs 1 0 0", "cur a", "xs 0 2 0",
        ]);
        let object = session.scene().object("o").unwrap();
        let moved = |alias: &str| {
            let child = object.child(alias).unwrap();
            object.parent_from_child(child).unwrap().forward().transform_point3(DVec3::ZERO)
        };
        assert_eq!((moved("a"), moved("b")), (DVec3::Y * 2.0, DVec3::X));
        assert_eq!(object.cursor().unwrap().0, "a");
    }

    #[test]
    fn an_object_may_hold_itself() {
        let session = session(&[
            "prm a",
            "obj o",
            "ap a",
            "ao o again",
            "ss .5 .5 .5",
            "obj p",
            "ao o",
            "obj o",
            "ao p",
        ]);
        assert_eq!(session.scene().object("o").unwrap().children().len(), 3);
    }

    #[test]
    fn deleting_takes_the_children_along_and_renaming_leads_them() {
        let mut session =
            session(&["prm a", "prm b", "obj o", "ap a", "ap b", "ap a again", "ao o self", "ss .5 .5 .5"]);
        session.run_line("copy o p").unwrap();
        session.run_line("rename o q").unwrap();
        assert_eq!(session.selected(), Some("q"));
        let target = |object: &str, alias: &str| {
            session.scene().object(object).unwrap().child(alias).map(|child| child.target().to_owned())
        };
        assert_eq!((target("q", "self").unwrap(), target("p", "self").unwrap()), ("q".into(), "p".into()));
        let told = session.run_line("delete a").unwrap();
        let Effect::Changed(Some(told)) = told else { panic!("{told:?}") };
        assert!(told.contains("4 children: q/a, q/again, p/a, p/again"), "{told}");
        let object = session.scene().object("q").unwrap();
        assert_eq!(object.children().map(|(alias, _)| alias).collect::<Vec<_>>(), ["b", "self"]);
        assert_eq!(object.cursor().unwrap().0, "self");
        session.run_line("remove self").unwrap();
        assert_eq!(session.scene().object("q").unwrap().cursor().unwrap().0, "b");
        session.run_line("remove b").unwrap();
        assert_eq!(session.run_line("xs 1 0 0").unwrap_err().code, "no-child");
        session.run_line("delete q").unwrap();
        assert_eq!((session.selected(), session.scene().entities().len()), (None, 2));
    }

    #[test]
    fn child_steps_come_before_overall_ones_in_the_order_written() {
        let session = session(&["prm a", "obj o", "sall 2 2 2", "ap a", "xs 1 0 0", "xall 0 0 5"]);
        let object = session.scene().object("o").unwrap();
        let transform = object.parent_from_child(object.child("a").unwrap()).unwrap();
        assert_eq!(transform.forward().transform_point3(DVec3::ZERO), DVec3::new(2.0, 0.0, 5.0));
    }

    #[test]
    fn camera_keeps_its_up_direction() {
        let session = session(&["cameraUp 0 0 1", "camera 1 2 3 0 0 0 30", "camera 4 5 6 0 0 0"]);
        let camera = session.scene().camera;
        assert_eq!((camera.up, camera.fov_deg, camera.position.x), (DVec3::Z, 60.0, 4.0));
    }
}
