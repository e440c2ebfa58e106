//! The interpreter: commands change a scene.

use superegg_geom::Superquadric;
use superegg_scene::{Camera, Entity, Primitive, Scene, SceneError};

use crate::command::{Command, Request};
use crate::diagnostic::Fault;
use crate::parser::{Parsed, parse_line, shorten};
use crate::settings::{self, Settings};
use crate::spec::Needs;
use crate::suggest::nearest;
use crate::{help, info};

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
            Command::SetLight(name, light) => self.scene.set_light(name, *light),
            Command::RemoveLight(name) => {
                self.scene.remove_light(name).map_err(|error| scene_fault(self, error))?;
            }
            Command::SetCamera(camera) => self.set_camera(camera, parsed)?,
            Command::SetCameraUp(up) => {
                if up.abs().max_element() == 0.0 {
                    let fault = Fault::new("no-direction", "the direction 0 0 0 leads nowhere");
                    return Err(fault
                        .help("give the direction that goes up in the picture, such as 0 1 0")
                        .at(arguments(parsed)));
                }
                self.scene.camera.up = *up;
            }
            Command::SetBackground(color) => self.scene.background = *color,
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
        let name = self.selected.clone().unwrap_or_default();
        let shape_fault = |error: superegg_geom::ShapeError| {
            Fault::new("out-of-range", error.to_string()).at(arguments(parsed))
        };
        let primitive: &mut Primitive = match self.scene.primitive_mut(&name) {
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
            _ => {}
        }
        Ok(())
    }

    /// The commands that change the selected object.
    fn change_object(&mut self, command: &Command) -> Result<(), SceneError> {
        let name = self.selected.clone().unwrap_or_default();
        match command {
            Command::AddObject { target, alias } => {
                self.scene.object(target)?;
                self.scene.add_child(&name, alias.as_ref().unwrap_or(target), target)
            }
            Command::AddPrimitive { target, alias } => {
                self.scene.primitive_mut(target)?;
                self.scene.add_child(&name, alias.as_ref().unwrap_or(target), target)
            }
            Command::RemoveChild(alias) => self.scene.remove_child(&name, alias),
            Command::SetCursor(alias) => self.scene.move_cursor(&name, alias),
            Command::TransformChild(step) => self.scene.transform_child(&name, *step),
            Command::TransformWhole(step) => self.scene.transform_whole(&name, *step),
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
        self.scene.camera = Camera { up: self.scene.camera.up, ..*camera };
        Ok(())
    }

    fn check_selection(&self, parsed: &Parsed) -> Result<(), Fault> {
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
        let (code, word, help) = match error {
            SceneError::Unknown(name) => {
                ("unknown-name", 1, did_you_mean(name, names(), "'info' lists what there is"))
            }
            SceneError::NotAnObject(_) => (
                "wrong-kind",
                1,
                "addPrimitive adds a primitive, and 'primitive NAME' selects one".to_owned(),
            ),
            SceneError::NotAPrimitive(_) => {
                ("wrong-kind", 1, "addObject adds an object, and 'object NAME' selects one".to_owned())
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

fn at_word(fault: Fault, parsed: &Parsed, word: usize) -> Fault {
    let columns = parsed.columns.get(word).unwrap_or(&parsed.columns[0]).clone();
    fault.at(columns)
}

/// The characters of all arguments.
fn arguments(parsed: &Parsed) -> std::ops::Range<usize> {
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
