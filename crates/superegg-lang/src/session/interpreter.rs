//! The interpreter: commands change a scene.

use superegg_geom::{Exponents, Superquadric};
use superegg_scene::{Camera, Entity, Floor, Lens, Light, Primitive, Scene, SceneError, TrackSubject};

use crate::diagnostic::Fault;
use crate::grammar::command::{Command, Request};
use crate::grammar::spec::Needs;
use crate::grammar::table::{COMMANDS, commands_spelt};
use crate::parse::number::{format_number, parse_number};
use crate::parse::parser::{Parsed, parse_line};
use crate::session::checks::{check_direction, check_light, distance_of_target, pattern};
use crate::session::faults::scene_fault;
use crate::session::keys::{ALL, subject_of};
use crate::session::selection::Selection;
use crate::session::settings::{self, Settings};
use crate::session::{help, info};
use crate::suggest::did_you_mean;
use crate::text::shorten;

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

    /// The scene with the selected name, for what only reads them.
    pub fn selection(&self) -> Selection<'_> {
        Selection { scene: &self.scene, selected: self.selected() }
    }

    /// What there is, in words, or the details of each thing named, as the command `info` tells them.
    ///
    /// # Errors
    /// A name that nothing has.
    pub fn describe(&self, names: &[String]) -> Result<String, Fault> {
        info::info(self.selection(), names).map_err(|(_, fault)| fault)
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
        let fault_of = |session: &Self, error: SceneError| scene_fault(&session.scene, &error, parsed);
        match &parsed.command {
            Command::Help(names) => {
                return help::help(names)
                    .map(Effect::Print)
                    .map_err(|(i, fault)| fault.at(parsed.word_columns(i + 1)));
            }
            Command::Info(names) => {
                return info::info(self.selection(), names)
                    .map(Effect::Print)
                    .map_err(|(i, fault)| fault.at(parsed.word_columns(i + 1)));
            }
            Command::Ask(request) => return Ok(Effect::Ask(request.clone())),
            Command::Set { setting, value } => {
                let set = settings::set(&mut self.scene.picture, &mut self.settings, setting, value);
                let spec = set.map_err(|(word, fault)| fault.at(parsed.word_columns(word)))?;
                return Ok(if spec.is_of_scene { Effect::Changed(None) } else { Effect::Done });
            }
            Command::Get(names) => {
                return settings::tell(&self.scene.picture, &self.settings, names)
                    .map(Effect::Print)
                    .map_err(|(i, fault)| fault.at(parsed.word_columns(i + 1)));
            }
            Command::Clear => self.clear(),
            Command::Delete(name) => {
                let uses = self.scene.delete(name).map_err(|error| fault_of(self, error))?;
                self.selected.take_if(|selected| selected == name);
                return Ok(Effect::Changed(gone_with(name, &uses)));
            }
            Command::Rename { name, new } => {
                self.scene.rename(name, new).map_err(|error| fault_of(self, error))?;
                if self.selected.as_ref() == Some(name) {
                    self.selected = Some(new.clone());
                }
            }
            Command::Copy { name, new } => {
                self.scene.copy(name, new).map_err(|error| fault_of(self, error))?;
            }
            Command::Deselect => self.selected = None,
            Command::Primitive(name) => {
                self.scene.ensure_primitive(name).map_err(|error| fault_of(self, error))?;
                self.selected = Some(name.clone());
            }
            Command::Object(name) => {
                self.scene.ensure_object(name).map_err(|error| fault_of(self, error))?;
                self.selected = Some(name.clone());
            }
            Command::SetLight(name, light) => {
                check_light(light, parsed)?;
                self.scene.set_light(name, *light);
            }
            Command::SetLightRadius { name, radius } => {
                let light = *self.scene.light(name).map_err(|error| fault_of(self, error))?;
                self.scene.set_light(name, Light { radius: *radius, ..light });
            }
            Command::RemoveLight(name) => {
                self.scene.remove_light(name).map_err(|error| fault_of(self, error))?;
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
                        .at(parsed.argument_columns()));
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
                    self.scene.primitive(name).map_err(|error| scene_fault(&self.scene, &error, parsed))?;
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
                self.set_key(*frame, keyed, words)?;
            }
            Command::RemoveKeys { frame, command } => {
                let told = self.remove_keys(frame, command.as_deref(), parsed)?;
                return Ok(Effect::Changed(Some(told)));
            }
            Command::SetDepth(depth) => self.scene.depth = *depth,
            command => match parsed.spec.needs {
                Needs::Object => {
                    self.change_object(command).map_err(|error| fault_of(self, error))?;
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
            Fault::new("out-of-range", error.to_string()).at(parsed.argument_columns())
        };
        let primitive: &mut Primitive = match self.scene.primitive_mut(name) {
            Ok(primitive) => primitive,
            Err(error) => return Err(scene_fault(&self.scene, &error, parsed)),
        };
        let shape = primitive.shape;
        match command {
            Command::SetRadii(radii) => {
                primitive.shape = Superquadric::new(*radii, shape.exponents()).map_err(shape_fault)?;
            }
            Command::SetExponents { e, n } => {
                let exponents = Exponents::new(*e, *n).map_err(shape_fault)?;
                primitive.shape = Superquadric::new(shape.radii(), exponents).map_err(shape_fault)?;
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
                .at(parsed.argument_columns()));
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

    /// Adds a key of a line.
    ///
    /// # Errors
    /// The line could not be carried out on its own, or has another count of numbers than the other keys of its track.
    fn set_key(&mut self, frame: f64, keyed: &Parsed, words: &[String]) -> Result<(), Fault> {
        let (subject, numbers) = subject_of(self.selection(), keyed, words)?;
        self.check_keyed(keyed)?;
        self.scene.set_key(subject, frame, &numbers).map_err(|error| {
            let help = "give as many numbers; or take those keys away, for example: unkey all";
            Fault::new("key-numbers", error.to_string()).help(help).at(keyed.argument_columns())
        })
    }

    /// Refuses a line for what it says, and for names that are not there. Whether its transform can be undone depends on what other commands make,
    /// now and later, and is not looked at: a scene that was saved must load.
    fn check_keyed(&self, keyed: &Parsed) -> Result<(), Fault> {
        const OF_NAMES: [&str; 5] = ["selection", "unknown-name", "wrong-kind", "no-child", "no-floor"];
        match self.clone().execute(keyed) {
            Err(fault) if OF_NAMES.contains(&fault.code) => return Err(fault),
            _ => {}
        }
        // A scene with nothing but what the line names.
        let mut alone = Self { selected: self.selected.clone(), ..Self::default() };
        let (selected, cursor) = (self.selected(), self.selection().cursor());
        let mut names: Vec<&str> = selected.into_iter().collect();
        match &keyed.command {
            Command::SetFloor { surface: Some(name), .. } => names.push(name),
            Command::SetLightRadius { name, .. } => alone.scene.set_light(name, Light::DEFAULT),
            _ => {}
        }
        // None is there yet, so each can be made.
        for name in names {
            let _ = match self.scene.primitive(name) {
                Ok(_) => alone.scene.ensure_primitive(name),
                Err(_) => alone.scene.ensure_object(name),
            };
        }
        if let (Some(object), Some(alias)) = (selected, cursor) {
            let _ = alone.scene.add_child(object, alias, object);
        }
        alone.scene.floor.clone_from(&self.scene.floor);
        alone.execute(keyed).map(drop)
    }

    /// Takes away the keys at a frame, or all: of every command, or of one on what is selected. Returns what there is to say.
    ///
    /// # Errors
    /// There is no such key.
    fn remove_keys(&mut self, frame: &str, command: Option<&str>, parsed: &Parsed) -> Result<String, Fault> {
        let at = if frame.eq_ignore_ascii_case(ALL) {
            None
        } else {
            let number = parse_number(frame).map_err(|error| {
                let fault = Fault::new("not-a-number", format!("'{}' {error}", shorten(frame)));
                fault.help("give a frame, or 'all'; for example: unkey 24").at(parsed.word_columns(1))
            })?;
            Some(number)
        };
        let names: Vec<&str> = command.into_iter().flat_map(commands_spelt).map(|spec| spec.name).collect();
        if let Some(word) = command.filter(|_| names.is_empty()) {
            let known = COMMANDS.iter().filter(|spec| spec.is_keyable()).map(|spec| spec.name);
            let fault = Fault::new("unknown-command", format!("there is no command '{}'", shorten(word)));
            return Err(fault
                .help(did_you_mean(word, known, "'info' lists the keys"))
                .at(parsed.word_columns(2)));
        }
        let selected = self.selected.clone();
        let cursor = self.selection().cursor().map(str::to_owned);
        let is_meant = |subject: &TrackSubject| {
            let is_here = |held: Option<&str>, now: &Option<String>| held.is_none() || held == now.as_deref();
            command.is_none()
                || (names.contains(&&*subject.command)
                    && is_here(subject.selected.as_deref(), &selected)
                    && is_here(subject.cursor.as_deref(), &cursor))
        };
        let count = self.scene.remove_keys(at, is_meant);
        if count == 0 {
            let of =
                command.map_or(String::new(), |word| format!(" of {} for what is selected", shorten(word)));
            let when = at.map_or(String::new(), |at| format!(" at frame {}", format_number(at)));
            let fault = Fault::new("no-key", format!("there is no key{of}{when}"));
            return Err(fault.help("'info' lists the keys with their frames").at(parsed.word_columns(1)));
        }
        Ok(format!("{count} {} taken away", if count == 1 { "key" } else { "keys" }))
    }
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
