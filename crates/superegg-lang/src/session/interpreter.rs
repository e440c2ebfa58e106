//! The interpreter: a session and how commands change it.

use std::ops::Range;
use std::sync::Arc;

use superegg_geom::glam::DVec3;
use superegg_geom::{Exponents, ShapeError, Superquadric, TransformStep};
use superegg_scene::{
    Camera, Entity, EnvironmentLight, Floor, Lens, Light, Scene, SceneError, Sky, TextureChannel, Textures,
    TrackSubject,
};

use crate::diagnostic::{Fault, FaultCode};
use crate::grammar::command::{
    Command, Needs, ObjectCommand, PrimitiveCommand, Request, SceneCommand, SessionCommand,
};
use crate::grammar::table::{COMMANDS, commands_spelt};
use crate::parse::number::{format_number, parse_number};
use crate::parse::parser::{
    Parsed, check_text, parse_suggesting, parse_words, plain_object_command, words_of_command,
};
use crate::session::checks::{check_camera, check_direction, check_light, pattern, target_distance};
use crate::session::faults::{scene_fault, table_help};
use crate::session::keys::{self, ALL_FRAMES, subject_of};
use crate::session::selection::Selection;
use crate::session::settings::{self, Settings};
use crate::session::{help, info};
use crate::suggest::Suggestions;
use crate::text::shorten;

/// A scene, the selected name in it, and the settings.
///
/// Every change goes through [`Session::run_line`] or [`Session::execute`], but for other names of files
/// ([`Session::rename_files`]). Cloning takes constant
/// time, whatever the size of the scene.
///
/// ```
/// use superegg_lang::{Effect, Session};
///
/// let mut session = Session::default();
/// for line in ["primitive ball", "setExponent 0.2 1", "object man", "addPrimitive ball head"] {
///     session.run_line(line)?;
/// }
/// assert_eq!(session.run_line("translate 0 0 2")?, Effect::Changed(None));
/// assert_eq!(session.selected(), Some("man"));
/// assert_eq!(session.scene().object("man").unwrap().children().len(), 1);
///
/// let fault = session.run_line("addPrimitive bal").unwrap_err();
/// assert_eq!(fault.to_string(), "nothing is named 'bal'");
/// assert_eq!(fault.help.as_deref(), Some("did you mean 'ball'?"));
/// # Ok::<(), superegg_lang::Fault>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Session {
    pub(crate) scene: Scene,
    pub(crate) selected: Option<String>,
    /// The settings that do not belong to the scene.
    pub settings: Settings,
    pub(crate) suggestions: Suggestions,
}

/// The result of a line. Exhaustive on purpose: whoever runs a session must handle each of these.
#[derive(Clone, Debug, PartialEq)]
pub enum Effect {
    /// The scene and the selection are unchanged: a blank line, or a setting of the session.
    Done,
    /// The scene or the selection has changed. The text, if there is one, is a message for the
    /// user.
    Changed(Option<String>),
    /// Show this text.
    Print(String),
    /// Whoever runs the session must do this.
    Request(Request),
}

impl Session {
    /// A session with this scene. Selects `selected` if the scene has it.
    pub fn with_scene(scene: Scene, selected: Option<&str>) -> Self {
        let selected = selected.filter(|name| scene.get(name).is_some()).map(str::to_owned);
        Self { scene, selected, ..Self::default() }
    }

    /// Gives other names to the files of textures and surroundings, as [`rename_files`](crate::rename_files).
    pub fn rename_files(&mut self, new_name: &mut dyn FnMut(&str) -> Option<String>) -> bool {
        keys::rename_files(&mut self.scene, new_name)
    }

    /// The scene as it is now.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The name of the selected primitive or object.
    pub fn selected(&self) -> Option<&str> {
        self.selected.as_deref()
    }

    /// The scene with the selected name, for reading.
    pub fn selection(&self) -> Selection<'_> {
        Selection { scene: &self.scene, selected: self.selected() }
    }

    /// The text of the command `info`: the contents of the scene, or the details of the named
    /// entities.
    ///
    /// # Errors
    /// An unknown name.
    pub fn describe(&self, names: &[String]) -> Result<String, Fault> {
        info::info(self.selection(), names, self.suggestions).map_err(|(_, fault)| fault)
    }

    /// The session with the camera and the lights of another scene.
    #[must_use]
    pub fn with_view_of(mut self, scene: &Scene) -> Self {
        self.scene.camera = scene.camera;
        self.scene.sets_camera = scene.sets_camera;
        for (name, light) in scene.named_lights() {
            self.scene.set_light(name, *light);
        }
        self
    }

    /// Empties the scene and selects nothing. The session's settings stay.
    pub fn clear(&mut self) {
        *self = Self { settings: self.settings, suggestions: self.suggestions, ..Self::default() };
    }

    /// Reads and carries out one line. A line without a command does nothing.
    ///
    /// # Errors
    /// The line cannot be read or carried out. The session is then unchanged.
    pub fn run_line(&mut self, line: &str) -> Result<Effect, Fault> {
        check_text(line)?;
        let words = words_of_command(line);
        let Some((first, rest)) = words.split_first() else { return Ok(Effect::Done) };
        // Large scenes have millions of such lines. One that fails is read again, for its fault.
        if let Some(command) = plain_object_command(first, rest)
            && self.change_object(&command).is_ok()
        {
            return Ok(Effect::Changed(quaternion_note(&command)));
        }
        let parsed = match parse_words(first, rest, self.suggestions) {
            Err(fault) => read_as_setting(line, fault, self.suggestions)?,
            Ok(parsed) => parsed,
        };
        self.execute(&parsed)
    }

    /// Carries out a parsed command.
    ///
    /// # Errors
    /// The selection is of the wrong kind, a name does not fit, or a transform is not invertible.
    /// The session is then unchanged.
    pub fn execute(&mut self, parsed: &Parsed) -> Result<Effect, Fault> {
        self.check_selection(parsed)?;
        match &parsed.command {
            Command::Session(command) => self.run_session_command(command, parsed),
            Command::Scene(command) => self.change_scene(command, parsed).map(Effect::Changed),
            Command::Primitive(command) => {
                self.change_primitive(command, parsed)?;
                Ok(Effect::Changed(None))
            }
            Command::Object(command) => {
                self.change_object(command)
                    .map_err(|error| scene_fault(&self.scene, &error, parsed, self.suggestions))?;
                Ok(Effect::Changed(quaternion_note(command)))
            }
            Command::Request(request) => Ok(Effect::Request(request.clone())),
        }
    }

    fn run_session_command(&mut self, command: &SessionCommand, parsed: &Parsed) -> Result<Effect, Fault> {
        // The names of these commands are their arguments from the first on.
        let printed = |text: Result<String, (usize, Fault)>| match text {
            Ok(text) => Ok(Effect::Print(text)),
            Err((i, fault)) => Err(fault.at(parsed.word_columns(i + 1))),
        };
        match command {
            SessionCommand::Help(names) => return printed(help::help(names, self.settings.columns)),
            SessionCommand::Info(names) => {
                return printed(info::info(self.selection(), names, self.suggestions));
            }
            SessionCommand::Get(names) => {
                return printed(settings::list(&self.scene.picture, &self.settings, names));
            }
            SessionCommand::Set { setting, value } => {
                let set = settings::set(&mut self.scene.picture, &mut self.settings, setting, value);
                let spec = set.map_err(|(word, fault)| fault.at(parsed.word_columns(word)))?;
                return Ok(if spec.is_of_scene { Effect::Changed(None) } else { Effect::Done });
            }
            SessionCommand::ClearScreen => return Ok(Effect::Request(Request::ClearScreen)),
            SessionCommand::Clear => self.clear(),
            SessionCommand::Deselect => self.selected = None,
            SessionCommand::SelectPrimitive(name) => {
                let done = self.scene.ensure_primitive(name);
                done.map_err(|error| scene_fault(&self.scene, &error, parsed, self.suggestions))?;
                self.selected = Some(name.clone());
            }
            SessionCommand::SelectObject(name) => {
                let done = self.scene.ensure_object(name);
                done.map_err(|error| scene_fault(&self.scene, &error, parsed, self.suggestions))?;
                self.selected = Some(name.clone());
            }
        }
        Ok(Effect::Changed(None))
    }

    /// Returns a message for the user, if there is one.
    fn change_scene(&mut self, command: &SceneCommand, parsed: &Parsed) -> Result<Option<String>, Fault> {
        let fault_of = |session: &Self, error: SceneError| {
            scene_fault(&session.scene, &error, parsed, session.suggestions)
        };
        match command {
            SceneCommand::Delete(name) => {
                let uses = self
                    .scene
                    .delete(name)
                    .map_err(|error| self.or_of_child(fault_of(self, error), name, "remove"))?;
                self.selected.take_if(|selected| selected == name);
                return Ok(deleted_children(name, &uses));
            }
            SceneCommand::Rename { name, new } => {
                self.scene
                    .rename(name, new)
                    .map_err(|error| self.or_of_child(fault_of(self, error), name, "renameChild"))?;
                if self.selected.as_ref() == Some(name) {
                    self.selected = Some(new.clone());
                }
            }
            SceneCommand::Copy { name, new } => {
                self.scene.copy(name, new).map_err(|error| fault_of(self, error))?;
            }
            SceneCommand::SetLight(name, light) => {
                check_light(light, parsed)?;
                self.scene.set_light(name, *light);
                return Ok(bytes_note(light.color));
            }
            SceneCommand::SetLightRadius { name, radius } => {
                let light = *self.scene.light(name).map_err(|error| fault_of(self, error))?;
                self.scene.set_light(name, Light { radius: *radius, ..light });
            }
            SceneCommand::RemoveLight(name) => {
                self.scene.remove_light(name).map_err(|error| fault_of(self, error))?;
            }
            SceneCommand::SetCamera(camera) => {
                check_camera(camera, parsed)?;
                let Camera { position, target, fov_deg, .. } = *camera;
                self.scene.camera = Camera { position, target, fov_deg, ..self.scene.camera };
                self.scene.sets_camera = true;
            }
            SceneCommand::SetCameraUp(up) => {
                check_direction(*up, "the direction that goes up in the picture, such as 0 1 0", parsed)?;
                self.scene.camera.up = *up;
            }
            SceneCommand::SetOrthographic(height) => {
                self.scene.camera.ortho_height = (*height > 0.0).then_some(*height);
            }
            SceneCommand::SetLens { radius, focus } => {
                let focus = focus.unwrap_or_else(|| target_distance(&self.scene.camera));
                if !focus.is_finite() {
                    let message = "the camera's target is too far away to be in focus";
                    return Err(Fault::new(FaultCode::OutOfRange, message)
                        .help("give the distance in focus: lens radius focus")
                        .at(parsed.argument_columns()));
                }
                self.scene.camera.lens = (*radius > 0.0).then_some(Lens { radius: *radius, focus });
            }
            SceneCommand::SetBackground(color) => {
                self.scene.background = *color;
                return Ok(bytes_note(*color));
            }
            SceneCommand::SetUp(up) => {
                check_direction(*up, "the direction that is up, such as z or 0 0 1", parsed)?;
                self.scene.set_up(*up);
            }
            SceneCommand::SetSky { horizon, zenith, up } => {
                let up = up.unwrap_or(self.scene.up());
                check_direction(up, "the direction that is above, such as 0 1 0", parsed)?;
                self.scene.sky = Some(Sky { horizon: *horizon, zenith: *zenith, up });
                return Ok(bytes_note(*horizon).or_else(|| bytes_note(*zenith)));
            }
            SceneCommand::RemoveSky => {
                self.scene.sky = None;
                self.scene.remove_keys(None, |subject| &*subject.command == "sky");
            }
            SceneCommand::SetEnvironment(picture) => {
                self.scene.environment = Some(EnvironmentLight::Picture(picture.clone()));
            }
            SceneCommand::SetDaylight(daylight) => {
                self.scene.environment = Some(EnvironmentLight::Daylight(*daylight));
            }
            SceneCommand::RemoveEnvironment => {
                self.scene.environment = None;
                let is_own = |command: &str| matches!(command, "environment" | "daylight");
                self.scene.remove_keys(None, |subject| is_own(&subject.command));
            }
            SceneCommand::SetFloor { height, surface, up } => {
                if let Some(name) = surface {
                    self.scene.primitive(name).map_err(|error| fault_of(self, error))?;
                }
                let up = up.unwrap_or(self.scene.up());
                check_direction(up, "the direction that is up from the floor, such as 0 1 0", parsed)?;
                let surface = surface.as_deref().map(Into::into);
                self.scene.floor = Some(Floor { height: *height, up, surface });
            }
            SceneCommand::SetFloorUp(up) => {
                check_direction(*up, "the direction that is up from the floor, such as 0 1 0", parsed)?;
                self.floor_or_fault(parsed)?.up = *up;
            }
            SceneCommand::RemoveFloor => {
                self.floor_or_fault(parsed)?;
                self.scene.floor = None;
                self.scene.remove_keys(None, |subject| ["floor", "floorUp"].contains(&&*subject.command));
            }
            SceneCommand::SetAmbientOcclusion(occlusion) => self.scene.ambient_occlusion = *occlusion,
            SceneCommand::SetDepth(depth) => self.scene.depth = *depth,
            SceneCommand::SetKey { frame, words } => {
                let Some(keyed) = &parsed.keyed else {
                    return Err(Fault::new(FaultCode::ArgumentCount, "key takes a frame and a command"));
                };
                self.set_key(*frame, keyed, words)?;
            }
            SceneCommand::RemoveKeys { frame, command } => {
                return self.remove_keys(frame, command.as_deref(), parsed).map(Some);
            }
        }
        Ok(None)
    }

    /// The fault about a name, with the command for children if it is the alias of one.
    fn or_of_child(&self, fault: Fault, name: &str, command: &str) -> Fault {
        let object = self.selected().and_then(|selected| self.scene.object(selected).ok());
        let is_child = object.is_some_and(|object| object.child(name).is_some());
        if fault.code == FaultCode::UnknownName && is_child {
            return fault.help(format!("it is a child of what is selected, which '{command}' is for"));
        }
        fault
    }

    fn change_primitive(&mut self, command: &PrimitiveCommand, parsed: &Parsed) -> Result<(), Fault> {
        let name = self.selected.as_deref().unwrap_or_default();
        let shape_fault = |error: ShapeError| {
            Fault::new(FaultCode::OutOfRange, error.to_string()).at(parsed.argument_columns())
        };
        let primitive = match self.scene.primitive_mut(name) {
            Ok(primitive) => primitive,
            Err(error) => return Err(scene_fault(&self.scene, &error, parsed, self.suggestions)),
        };
        let (shape, material) = (primitive.shape, &mut primitive.material);
        match command {
            PrimitiveCommand::SetRadii(radii) => {
                primitive.shape = Superquadric::new(*radii, shape.exponents()).map_err(shape_fault)?;
            }
            PrimitiveCommand::SetExponents { e, n } => {
                let exponents = Exponents::new(*e, *n).map_err(shape_fault)?;
                primitive.shape = Superquadric::new(shape.radii(), exponents).map_err(shape_fault)?;
            }
            PrimitiveCommand::SetPatches(patches) => primitive.patches = *patches,
            PrimitiveCommand::SetColor(color) => material.color = *color,
            PrimitiveCommand::SetWeight(weight, value) => material.set_weight(*weight, *value),
            PrimitiveCommand::SetIndex(index) => material.index = *index,
            PrimitiveCommand::SetEmission(emission) => material.emission = *emission,
            PrimitiveCommand::SetShininess(exponent) => material.shininess = Some(*exponent),
            PrimitiveCommand::SetFresnel(on) => material.fresnel = *on,
            PrimitiveCommand::SetAbsorption(absorb) => material.absorb = *absorb,
            PrimitiveCommand::SetPattern { word, numbers } => {
                material.pattern = pattern(word, numbers, parsed)?;
            }
            PrimitiveCommand::SetTexture { channel, texture } => {
                let has_height = texture.as_ref().is_some_and(|texture| texture.height.is_some());
                if has_height && *channel != TextureChannel::Bump {
                    let message = format!("a texture of {} has no height", channel.word());
                    let fault = Fault::new(FaultCode::ArgumentCount, message).at(parsed.argument_columns());
                    return Err(fault.help("only 'setTexture bump' has one"));
                }
                let mut textures = primitive.textures.as_deref().cloned().unwrap_or_default();
                textures.set(*channel, texture.clone());
                primitive.textures = (textures != Textures::default()).then(|| Arc::new(textures));
            }
        }
        Ok(())
    }

    fn change_object(&mut self, command: &ObjectCommand) -> Result<(), SceneError> {
        let (name, scene) = (self.selected.as_deref().unwrap_or_default(), &mut self.scene);
        match command {
            ObjectCommand::AddObject { target, alias } => {
                if !matches!(scene.get(target), Some(Entity::Table(_))) {
                    scene.object(target)?;
                }
                scene.add_child(name, alias.as_ref().unwrap_or(target), target)
            }
            ObjectCommand::AddPrimitive { target, alias } => {
                scene.primitive(target)?;
                scene.add_child(name, alias.as_ref().unwrap_or(target), target)
            }
            ObjectCommand::RemoveChild(alias) => scene.remove_child(name, alias),
            ObjectCommand::RenameChild { alias, new } => scene.rename_child(name, alias, new),
            ObjectCommand::Hide(Some(alias)) => scene.set_hidden(name, alias, true),
            ObjectCommand::Hide(None) => {
                let cursor = scene.object(name)?.cursor().map(|(alias, _)| alias.to_owned());
                let alias = cursor.ok_or_else(|| SceneError::NoChild(name.to_owned()))?;
                scene.set_hidden(name, &alias, true)
            }
            ObjectCommand::Unhide(Some(alias)) => scene.set_hidden(name, alias, false),
            ObjectCommand::Unhide(None) => scene.show_all(name),
            ObjectCommand::SetCursor(alias) => scene.move_cursor(name, alias),
            ObjectCommand::TransformChild(step) => scene.transform_child(name, step.clone()),
            ObjectCommand::TransformWhole(step) => scene.transform_whole(name, step.clone()),
        }
    }

    fn floor_or_fault(&mut self, parsed: &Parsed) -> Result<&mut Floor, Fault> {
        let fault = Fault::new(FaultCode::NoFloor, "there is no floor");
        let fault = fault.help("floor lays one, for example: floor -1").at(parsed.word_columns(0));
        self.scene.floor.as_mut().ok_or(fault)
    }

    fn check_selection(&self, parsed: &Parsed) -> Result<(), Fault> {
        let selected = self.selection().entity();
        let (wanted, how) = match (parsed.command.needs(), selected) {
            (Needs::Nothing, _)
            | (Needs::Primitive, Some((_, Entity::Primitive(_))))
            | (Needs::Object, Some((_, Entity::Object(_)))) => return Ok(()),
            (Needs::Primitive, _) => ("primitive", "'primitive NAME' selects one, or makes it"),
            (Needs::Object, _) => ("object", "'object NAME' selects one, or makes it"),
        };
        let how = match selected {
            Some((name, Entity::Table(_))) => table_help(name),
            _ => how.to_owned(),
        };
        let found = match selected {
            Some((name, entity)) => format!("'{}', which is selected, is {}", shorten(name), entity.kind()),
            None => "nothing is selected".to_owned(),
        };
        let message = format!("{} needs a selected {wanted}; {found}", parsed.spec.name);
        Err(Fault::new(FaultCode::Selection, message).help(how).at(parsed.word_columns(0)))
    }

    /// Adds a key of a line.
    ///
    /// # Errors
    /// The line cannot be carried out on its own, or its count of numbers differs from that of the
    /// track's other keys.
    fn set_key(&mut self, frame: f64, keyed: &Parsed, words: &[String]) -> Result<(), Fault> {
        let (subject, numbers) = subject_of(self.selection(), keyed, words)?;
        self.check_keyed(keyed)?;
        self.scene.set_key(subject, frame, &numbers).map_err(|error| {
            let help = "give as many numbers; or take those keys away, for example: unkey all";
            Fault::new(FaultCode::KeyNumbers, error.to_string()).help(help).at(keyed.argument_columns())
        })
    }

    /// Rejects a keyed line with wrong numbers or unknown names.
    ///
    /// Whether its transform is invertible together with those before it is not checked: that
    /// depends on what other commands do, now and later, and a saved scene must load.
    fn check_keyed(&self, keyed: &Parsed) -> Result<(), Fault> {
        const CODES_OF_NAMES: [FaultCode; 5] = [
            FaultCode::Selection,
            FaultCode::UnknownName,
            FaultCode::WrongKind,
            FaultCode::NoChild,
            FaultCode::NoFloor,
        ];
        if let Err(fault) = self.clone().execute(keyed)
            && CODES_OF_NAMES.contains(&fault.code)
        {
            return Err(fault);
        }
        // A scene with nothing but what the line names.
        let mut alone = Self { selected: self.selected.clone(), ..Self::default() };
        let (selected, cursor) = (self.selected(), self.selection().cursor());
        let mut names: Vec<&str> = selected.into_iter().collect();
        if let Command::Scene(SceneCommand::SetFloor { surface: Some(name), .. }) = &keyed.command {
            names.push(name);
        }
        if let Command::Scene(SceneCommand::SetLightRadius { name, .. }) = &keyed.command {
            alone.scene.set_light(name, Light::DEFAULT);
        }
        // The scene is empty, so each name is free.
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

    /// Removes the keys at a frame, or at all frames: of every command, or of one on the selected
    /// entity. Returns a message for the user.
    ///
    /// # Errors
    /// There is no such key.
    fn remove_keys(&mut self, frame: &str, command: Option<&str>, parsed: &Parsed) -> Result<String, Fault> {
        let at = if frame.eq_ignore_ascii_case(ALL_FRAMES) {
            None
        } else {
            let number = parse_number(frame).map_err(|error| {
                let fault = Fault::new(FaultCode::NotANumber, format!("'{}' {error}", shorten(frame)));
                fault.help("give a frame, or 'all'; for example: unkey 24").at(parsed.word_columns(1))
            })?;
            Some(number)
        };
        let names: Vec<&str> = command.into_iter().flat_map(commands_spelt).map(|spec| spec.name).collect();
        if let Some(word) = command.filter(|_| names.is_empty()) {
            let known = COMMANDS.iter().filter(|spec| spec.is_keyable()).map(|spec| spec.name);
            let message = format!("there is no command '{}'", shorten(word));
            return Err(Fault::new(FaultCode::UnknownCommand, message)
                .help(self.suggestions.did_you_mean(word, known, "'info' lists the keys"))
                .at(parsed.word_columns(2)));
        }
        let selected = self.selected.clone();
        let cursor = self.selection().cursor().map(str::to_owned);
        let matches = |subject: &TrackSubject| {
            let is_here = |held: Option<&str>, now: &Option<String>| held.is_none() || held == now.as_deref();
            command.is_none()
                || (names.contains(&&*subject.command)
                    && is_here(subject.selected.as_deref(), &selected)
                    && is_here(subject.cursor.as_deref(), &cursor))
        };
        let count = self.scene.remove_keys(at, matches);
        if count == 0 {
            let of =
                command.map_or(String::new(), |word| format!(" of {} for what is selected", shorten(word)));
            let when = at.map_or(String::new(), |at| format!(" at frame {}", format_number(at)));
            let fault = Fault::new(FaultCode::NoKey, format!("there is no key{of}{when}"));
            return Err(fault.help("'info' lists the keys with their frames").at(parsed.word_columns(1)));
        }
        Ok(format!("{count} {} removed", if count == 1 { "key" } else { "keys" }))
    }
}

/// Parses a typed line, which may begin with the name of a setting.
///
/// # Errors
/// As for [`crate::parse_line`].
pub(crate) fn parse_typed(line: &str, suggestions: Suggestions) -> Result<Option<Parsed>, Fault> {
    match parse_suggesting(line, suggestions) {
        Err(fault) => read_as_setting(line, fault, suggestions).map(Some),
        parsed => parsed,
    }
}

/// Reads a line with this fault again, with `set` before the name of a setting that stands where a
/// command should.
///
/// # Errors
/// There is no such name, or `set` would have a fault.
fn read_as_setting(line: &str, fault: Fault, suggestions: Suggestions) -> Result<Parsed, Fault> {
    const SET: &str = "set ";
    let columns = fault.columns.clone().filter(|_| fault.code == FaultCode::UnknownCommand);
    let Some(Range { start, end }) = columns else { return Err(fault) };
    let word: String = line.chars().skip(start).take(end - start).collect();
    if settings::find_setting(&word).is_none() {
        return Err(fault);
    }
    let at = line.char_indices().nth(start).map_or(line.len(), |(byte, _)| byte);
    // The columns in the line as it was typed.
    let column =
        |column: usize| if column > start { column.saturating_sub(SET.len()).max(start) } else { column };
    let moved = |columns: &Range<usize>| {
        let first = column(columns.start);
        first..column(columns.end).max(first + 1)
    };
    let line = format!("{}{SET}{}", &line[..at], &line[at..]);
    let parsed = parse_suggesting(&line, suggestions)
        .map_err(|fault| Fault { columns: fault.columns.as_ref().map(moved), ..fault })?;
    let mut parsed = parsed.ok_or(fault)?;
    let mut inner = Some(&mut parsed);
    while let Some(parsed) = inner {
        parsed.columns.iter_mut().for_each(|columns| *columns = moved(columns));
        inner = parsed.keyed.as_deref_mut();
    }
    Ok(parsed)
}

/// The message about light whose values are probably those of bytes; `None` for any other light.
fn bytes_note(color: DVec3) -> Option<String> {
    /// Light that is as bright as this by intention is rarely whole in all channels.
    const LEAST: f64 = 16.0;
    let is_byte = |value: f64| value.fract() == 0.0 && (0.0..=255.0).contains(&value);
    let [r, g, b] = color.to_array();
    (color.to_array().into_iter().all(is_byte) && color.max_element() >= LEAST).then(|| {
        format!(
            "1 is white, and {r} {g} {b} is brighter; 8-bit values are one word: #{:02x}{:02x}{:02x}",
            r as u8, g as u8, b as u8
        )
    })
}

/// The message about a quaternion whose length is far from 1; `None` for any other command.
fn quaternion_note(command: &ObjectCommand) -> Option<String> {
    /// Files with six digits are off by up to 6e-7.
    const TOLERANCE: f64 = 1e-3;
    let (ObjectCommand::TransformChild(TransformStep::Orient(quaternion))
    | ObjectCommand::TransformWhole(TransformStep::Orient(quaternion))) = command
    else {
        return None;
    };
    let length = quaternion.length();
    ((length - 1.0).abs() > TOLERANCE).then(|| {
        format!(
            "the quaternion has length {}, not 1; it is scaled to 1",
            format_number((length * 1e6).round() / 1e6)
        )
    })
}

/// The message about the children that were deleted with an entity; `None` if there were none.
fn deleted_children(name: &str, uses: &[(String, String)]) -> Option<String> {
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
