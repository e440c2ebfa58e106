//! The side panel, the help and the texts over the scene. What is changed here leaves as the line that the prompt would take.

use egui::{Align2, Color32, DragValue, RichText, Slider, Ui};
use superegg_geom::glam::DVec3;
use superegg_geom::{Exponents, Superquadric, TransformStep};
use superegg_scene::{
    Camera, Encoding, Entity, Light, LightKind, Material, Object, Patches, Primitive, Scene, Shading,
};

use crate::cast::CastHit;
use crate::keys::{Action, BINDINGS, POINTER_HELP};
use crate::state::{ViewState, number_text};

/// What the panel reads.
pub(crate) struct Model<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) selected: Option<&'a str>,
    /// What the window shows.
    pub(crate) root: Option<&'a str>,
    pub(crate) hit: Option<&'a CastHit>,
    /// Lines at the bottom of the scene: what is shown, and what is not.
    pub(crate) status: &'a [String],
    pub(crate) notice: Option<&'a str>,
    pub(crate) device: &'a str,
}

/// What was done in the panel.
#[derive(Debug)]
pub(crate) enum Done {
    /// A line for the prompt.
    Command(String),
    /// The scene as it will be when the pointer is let go, to be shown meanwhile.
    Draft(Box<Scene>),
    /// What a key does.
    Action(Action),
    /// A setting was changed in place.
    SettingsChanged,
}

/// A change that is still being made: a slider held, a field typed into.
#[derive(Debug)]
struct Pending {
    /// The line, or the lines, that make it.
    line: String,
    draft: Scene,
}

/// What the panel keeps from frame to frame.
#[derive(Debug, Default)]
pub(crate) struct Panel {
    pending: Option<Pending>,
    /// How far the child at the cursor, or the whole, is about to be moved, turned and scaled.
    nudge: Nudge,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Nudge {
    translate: DVec3,
    axis: usize,
    angle_deg: f64,
    scale: f64,
}

impl Default for Nudge {
    fn default() -> Self {
        Self { translate: DVec3::ZERO, axis: 2, angle_deg: 0.0, scale: 1.0 }
    }
}

/// So many children of one object are listed; a list of thousands is no help and takes time.
const MOST_LISTED: usize = 200;
const PANEL_WIDTH: f32 = 290.0;
/// Decimals of a number in a line.
const DECIMALS: usize = 6;

impl Panel {
    /// Draws everything over and beside the scene; what is left of `ui` afterwards is the scene's.
    pub(crate) fn show(&mut self, ui: &mut Ui, view: &mut ViewState, model: &Model<'_>) -> Vec<Done> {
        let mut done = Vec::new();
        if view.has_panel {
            // The theme's own grey is hard to read on a dark panel.
            ui.visuals_mut().override_text_color = Some(Color32::from_gray(215));
            egui::Panel::right("panel").default_size(PANEL_WIDTH).show(ui, |ui| {
                egui::ScrollArea::vertical().auto_shrink([false; 2]).show(ui, |ui| {
                    self.sections(ui, view, model, &mut done);
                });
            });
        }
        texts(ui, model);
        if view.has_help {
            help(ui, model);
        }
        // A change is one line when it is over, not one for each frame of it.
        let is_held =
            ui.input(|input| input.pointer.any_down()) || ui.memory(|memory| memory.focused().is_some());
        match self.pending.take() {
            Some(pending) if is_held => {
                done.push(Done::Draft(Box::new(pending.draft.clone())));
                self.pending = Some(pending);
            }
            Some(pending) => {
                self.nudge = Nudge { axis: self.nudge.axis, ..Nudge::default() };
                done.extend(pending.line.lines().map(|line| Done::Command(line.to_owned())));
            }
            None => (),
        }
        done
    }

    fn sections(&mut self, ui: &mut Ui, view: &mut ViewState, model: &Model<'_>, done: &mut Vec<Done>) {
        ui.horizontal(|ui| {
            for (text, action, help) in [
                ("Undo", Action::Undo, "Ctrl+Z"),
                ("Redo", Action::Redo, "Ctrl+Y"),
                ("Frame", Action::FrameAll, "f"),
                ("Home", Action::Home, "Home"),
                ("Picture", Action::Screenshot, "F12: a numbered PNG of what is seen"),
                ("Keys", Action::ToggleHelp, "h"),
            ] {
                if ui.button(text).on_hover_text(help).clicked() {
                    done.push(Done::Action(action));
                }
            }
        });
        section(ui, "Objects", true, |ui| tree(ui, model, done));
        let title = match model.selected {
            Some(name) => format!("Selected: {name}"),
            None => "Selected: nothing".to_owned(),
        };
        egui::CollapsingHeader::new(title).id_salt("selected").default_open(true).show(ui, |ui| {
            let entity = model.selected.and_then(|name| Some((name, model.scene.get(name)?)));
            match entity {
                Some((name, Entity::Primitive(primitive))) => {
                    self.primitive(ui, name, primitive, model.scene);
                }
                Some((name, Entity::Object(object))) => self.object(ui, name, object, model.scene, done),
                None => {
                    ui.label("Select something in the tree, or by a double click in the scene.");
                }
            }
        });
        section(ui, "View", true, |ui| switches(ui, view, done));
        section(ui, "Inside-outside test", false, |ui| io_settings(ui, view, done));
        section(ui, "Intersection test", true, |ui| intersection(ui, view, model.hit, done));
        section(ui, "Lights", false, |ui| self.lights(ui, model.scene, done));
        section(ui, "Camera", false, |ui| self.camera(ui, model.scene, done));
        section(ui, "Picture", false, |ui| self.picture(ui, model.scene));
        ui.separator();
        ui.small(model.device);
    }

    fn change(&mut self, line: String, draft: Scene) {
        self.pending = Some(Pending { line, draft });
    }

    fn primitive(&mut self, ui: &mut Ui, name: &str, primitive: &Primitive, scene: &Scene) {
        let mut edited = primitive.clone();
        let Some(line) = edit_primitive(ui, &mut edited) else { return };
        let mut draft = scene.clone();
        if let Ok(place) = draft.primitive_mut(name) {
            *place = edited;
            self.change(line, draft);
        }
    }

    fn object(&mut self, ui: &mut Ui, name: &str, object: &Object, scene: &Scene, done: &mut Vec<Done>) {
        let cursor = object.cursor().map(|(alias, _)| alias.to_owned());
        ui.label(match &cursor {
            Some(alias) => format!("The cursor is on the child '{alias}'."),
            None => "No children yet.".to_owned(),
        });
        egui::ScrollArea::vertical().id_salt("children").max_height(140.0).show(ui, |ui| {
            for (alias, child) in object.children().take(MOST_LISTED) {
                let text = if alias == child.target() {
                    alias.to_owned()
                } else {
                    format!("{alias}: {}", child.target())
                };
                if ui.selectable_label(cursor.as_deref() == Some(alias), text).clicked() {
                    done.push(Done::Command(format!("setCursor {alias}")));
                }
            }
        });
        if cursor.is_some() {
            ui.label("Move, turn, scale that child");
            ui.push_id("child", |ui| self.nudges(ui, name, scene, false));
        }
        ui.label("The whole");
        ui.push_id("whole", |ui| self.nudges(ui, name, scene, true));
    }

    /// Fields that append a transform to the child at the cursor, or to the whole.
    fn nudges(&mut self, ui: &mut Ui, name: &str, scene: &Scene, of_whole: bool) {
        let mut nudge = self.nudge;
        let mut step = None;
        ui.horizontal(|ui| {
            ui.label("move");
            for axis in 0..3 {
                if number(ui, &mut nudge.translate[axis], 0.02).changed() {
                    step = Some(TransformStep::Translate(nudge.translate));
                }
            }
        });
        ui.horizontal(|ui| {
            ui.label("turn");
            for (axis, text) in ["x", "y", "z"].into_iter().enumerate() {
                ui.selectable_value(&mut nudge.axis, axis, text);
            }
            if number(ui, &mut nudge.angle_deg, 1.0).changed() {
                step =
                    Some(TransformStep::Rotate { axis: DVec3::AXES[nudge.axis], angle_deg: nudge.angle_deg });
            }
            ui.label("°  scale");
            let scale =
                DragValue::new(&mut nudge.scale).speed(0.01).range(0.01..=100.0).update_while_editing(false);
            if ui.add(scale).changed() {
                step = Some(TransformStep::Scale(DVec3::splat(nudge.scale)));
            }
        });
        self.nudge = nudge;
        let Some(step) = step else { return };
        let mut draft = scene.clone();
        let changed =
            if of_whole { draft.transform_whole(name, step) } else { draft.transform_child(name, step) };
        if changed.is_ok() {
            self.change(step_line(&step, of_whole), draft);
        }
    }

    fn lights(&mut self, ui: &mut Ui, scene: &Scene, done: &mut Vec<Done>) {
        if scene.named_lights().len() == 0 {
            ui.label("The default light shines: white at 3 4 5. A light of your own takes its place.");
        }
        for (name, light) in scene.named_lights() {
            let mut edited = *light;
            ui.horizontal(|ui| {
                ui.strong(name);
                if ui.small_button("remove").clicked() {
                    done.push(Done::Command(format!("unlight {name}")));
                }
            });
            let has_changed = ui.push_id(name, |ui| edit_light(ui, &mut edited)).inner;
            if has_changed {
                let mut draft = scene.clone();
                draft.set_light(name, edited);
                self.change(light_lines(name, &edited), draft);
            }
        }
        if ui.button("Add a light").clicked() {
            let is_free = |name: &String| scene.named_lights().all(|(taken, _)| taken != name);
            let name = (1..).map(|i| format!("light{i}")).find(is_free).unwrap_or_default();
            done.push(Done::Command(light_lines(&name, &Light { falloff: 0.0, ..Light::DEFAULT })));
        }
    }

    fn camera(&mut self, ui: &mut Ui, scene: &Scene, done: &mut Vec<Done>) {
        let mut camera = scene.camera;
        let mut line = None;
        for (label, value) in [("position", &mut camera.position), ("target", &mut camera.target)] {
            if vector(ui, label, value, 0.05) {
                line = Some(());
            }
        }
        let fov =
            Slider::new(&mut camera.fov_deg, 1.0..=170.0).text("field of view °").update_while_editing(false);
        let line = if ui.add(fov).changed() || line.is_some() { Some(camera_line(&camera)) } else { None };
        let line = if vector(ui, "up", &mut camera.up, 0.02) {
            Some(format!("cameraUp {}", vector_text(camera.up)))
        } else {
            line
        };
        if let Some(line) = line.filter(|_| camera.position != camera.target && camera.up != DVec3::ZERO) {
            let mut draft = scene.clone();
            draft.camera = camera;
            self.change(line, draft);
        }
        if ui.button("This view becomes the camera").on_hover_text("c").clicked() {
            done.push(Done::Action(Action::WriteCamera));
        }
    }

    fn picture(&mut self, ui: &mut Ui, scene: &Scene) {
        let mut draft = scene.clone();
        let mut line = None;
        ui.horizontal(|ui| {
            ui.label("background");
            if color(ui, &mut draft.background) {
                line = Some(format!("background {}", vector_text(draft.background)));
            }
        });
        if ui.add(Slider::new(&mut draft.depth, 0..=superegg_scene::MAX_DEPTH).text("depth")).changed() {
            line = Some(format!("setDepth {}", draft.depth));
        }
        let picture = &mut draft.picture;
        ui.horizontal(|ui| {
            ui.label("size");
            let side = |value| DragValue::new(value).range(1..=8192).update_while_editing(false);
            let has_changed = ui.add(side(&mut picture.width)).changed();
            if ui.add(side(&mut picture.height)).changed() || has_changed {
                line = Some(format!("set size {}x{}", picture.width, picture.height));
            }
        });
        if ui
            .add(Slider::new(&mut picture.samples, 1..=64).logarithmic(true).text("samples a pixel"))
            .changed()
        {
            line = Some(format!("set samples {}", picture.samples));
        }
        ui.horizontal(|ui| {
            ui.label("encoding");
            for (encoding, word) in [(Encoding::Srgb, "srgb"), (Encoding::Linear, "linear")] {
                if ui.selectable_value(&mut picture.encoding, encoding, word).changed() {
                    line = Some(format!("set encoding {word}"));
                }
            }
        });
        if let Some(line) = line {
            self.change(line, draft);
        }
    }
}

fn section(ui: &mut Ui, title: &str, is_open: bool, content: impl FnOnce(&mut Ui)) {
    egui::CollapsingHeader::new(title).default_open(is_open).show(ui, content);
}

fn tree(ui: &mut Ui, model: &Model<'_>, done: &mut Vec<Done>) {
    // Those that are in no other object come first, with what is in them.
    let used: std::collections::HashSet<&str> = model
        .scene
        .objects()
        .flat_map(|(name, object)| object.children().map(move |(_, child)| (name, child.target())))
        .filter(|(name, target)| name != target)
        .map(|(_, target)| target)
        .collect();
    egui::ScrollArea::vertical().id_salt("tree").max_height(220.0).show(ui, |ui| {
        let tops = model.scene.entities().filter(|(name, _)| !used.contains(name));
        let mut listed = 0;
        for (name, _) in tops.take(MOST_LISTED) {
            branch(ui, model, name, name, &mut vec![], &mut listed, done);
        }
        let rest = model.scene.entities().len().saturating_sub(MOST_LISTED);
        if listed >= MOST_LISTED && rest > 0 {
            ui.weak("… and more");
        }
    });
}

fn branch<'a>(
    ui: &mut Ui,
    model: &Model<'a>,
    alias: &str,
    name: &'a str,
    above: &mut Vec<&'a str>,
    listed: &mut usize,
    done: &mut Vec<Done>,
) {
    *listed += 1;
    if *listed > 4 * MOST_LISTED {
        return;
    }
    let text = if alias == name { name.to_owned() } else { format!("{alias}: {name}") };
    let text = if model.root == Some(name) { RichText::new(text).strong() } else { RichText::new(text) };
    let is_selected = model.selected == Some(name);
    match model.scene.get(name) {
        Some(Entity::Object(object)) if !above.contains(&name) => {
            let id = ui.make_persistent_id((above.clone(), alias));
            let is_open = above.is_empty() && model.root == Some(name);
            egui::collapsing_header::CollapsingState::load_with_default_open(ui.ctx(), id, is_open)
                .show_header(ui, |ui| {
                    if ui.selectable_label(is_selected, text).clicked() {
                        done.push(Done::Command(format!("object {name}")));
                    }
                })
                .body(|ui| {
                    above.push(name);
                    for (alias, child) in object.children().take(MOST_LISTED) {
                        branch(ui, model, alias, child.target(), above, listed, done);
                    }
                    let rest = object.children().len().saturating_sub(MOST_LISTED);
                    if rest > 0 {
                        ui.weak(format!("… and {rest} more"));
                    }
                    above.pop();
                });
        }
        Some(entity) => {
            // An object within itself is a leaf here, or the tree would have no end.
            let word = if matches!(entity, Entity::Object(_)) { "object" } else { "primitive" };
            if ui.selectable_label(is_selected, text).clicked() {
                done.push(Done::Command(format!("{word} {name}")));
            }
        }
        None => (),
    }
}

/// The fields of a primitive. Returns the line that makes the change, if one was made.
fn edit_primitive(ui: &mut Ui, primitive: &mut Primitive) -> Option<String> {
    let mut line = None;
    let shape = primitive.shape;
    let (mut radii, exponents) = (shape.radii(), shape.exponents());
    let (mut e, mut n) = (exponents.e(), exponents.n());
    ui.horizontal(|ui| {
        ui.label("semi-axes");
        for axis in 0..3 {
            let field =
                DragValue::new(&mut radii[axis]).speed(0.01).range(1e-3..=1e6).update_while_editing(false);
            if ui.add(field).changed() {
                line = Some(format!("setCoeff {}", vector_text(radii)));
            }
        }
    });
    for (value, text) in [(&mut e, "e: xy plane"), (&mut n, "n: towards z")] {
        let slider = Slider::new(value, 0.01..=4.0).logarithmic(true).text(text).update_while_editing(false);
        if ui.add(slider).changed() {
            line = Some(String::new());
        }
    }
    if line.as_ref().is_some_and(String::is_empty) {
        line = Some(format!("setExponent {} {}", number_text(e, DECIMALS), number_text(n, DECIMALS)));
    }
    if let Ok(shape) = Exponents::new(e, n).and_then(|exponents| Superquadric::new(radii, exponents)) {
        primitive.shape = shape;
    }
    let Patches { u, v } = &mut primitive.patches;
    let mut has_patches = false;
    for (value, text) in [(u, "patches around"), (v, "patches pole to pole")] {
        let slider = Slider::new(value, 1..=200).logarithmic(true).text(text).update_while_editing(false);
        has_patches |= ui.add(slider).changed();
    }
    if has_patches {
        line = Some(format!("setPatch {} {}", primitive.patches.u, primitive.patches.v));
    }
    edit_material(ui, &mut primitive.material).or(line)
}

fn edit_material(ui: &mut Ui, material: &mut Material) -> Option<String> {
    let mut line = None;
    ui.horizontal(|ui| {
        ui.label("colour");
        if color(ui, &mut material.color) {
            line = Some(format!("setColor {}", vector_text(material.color)));
        }
    });
    let mut reflected = material.reflected.unwrap_or(0.0);
    let mut refracted = material.refracted.unwrap_or(0.0);
    for (value, word, text) in [
        (&mut material.ambient, "setAmbient", "ambient"),
        (&mut material.diffuse, "setDiffuse", "diffuse"),
        (&mut material.specular, "setSpecular", "highlight"),
        (&mut material.gloss, "setGloss", "gloss"),
        (&mut reflected, "setReflected", "reflected"),
        (&mut refracted, "setRefracted", "refracted"),
    ] {
        if ui.add(Slider::new(value, 0.0..=1.0).text(text).update_while_editing(false)).changed() {
            line = Some(format!("{word} {}", number_text(*value, DECIMALS)));
        }
    }
    if line.as_ref().is_some_and(|line| line.starts_with("setReflected")) {
        material.reflected = Some(reflected);
    }
    if line.as_ref().is_some_and(|line| line.starts_with("setRefracted")) {
        material.refracted = Some(refracted);
    }
    if ui.add(Slider::new(&mut material.index, 1.0..=4.0).text("index").update_while_editing(false)).changed()
    {
        line = Some(format!("setIndex {}", number_text(material.index, DECIMALS)));
    }
    line
}

fn edit_light(ui: &mut Ui, light: &mut Light) -> bool {
    let before = *light;
    let mut has_changed = match &mut light.kind {
        LightKind::Point { position } => vector(ui, "place", position, 0.05),
        LightKind::Spot { position, target, cone_deg, soft } => {
            let has_moved = vector(ui, "place", position, 0.05);
            let has_turned = vector(ui, "towards", target, 0.05);
            let cone = Slider::new(cone_deg, 1.0..=180.0).text("cone °").update_while_editing(false);
            let rim = Slider::new(soft, 0.0..=1.0).text("soft rim").update_while_editing(false);
            // Each is drawn, whichever has changed.
            [has_moved, has_turned, ui.add(cone).changed(), ui.add(rim).changed()].contains(&true)
        }
        LightKind::Sun { direction } => vector(ui, "from", direction, 0.05),
    };
    // What the language would refuse.
    if matches!(light.kind, LightKind::Spot { position, target, .. } if position == target)
        || matches!(light.kind, LightKind::Sun { direction } if direction == DVec3::ZERO)
    {
        light.kind = before.kind;
        has_changed = false;
    }
    ui.horizontal(|ui| {
        ui.label("colour");
        has_changed |= color(ui, &mut light.color);
        let falloff = (&mut light.falloff, "falloff", 0.001);
        let radius = (&mut light.radius, "radius", 0.01);
        for (value, text, speed) in [falloff, radius] {
            // A sun's light does not fall.
            if text == "falloff" && matches!(light.kind, LightKind::Sun { .. }) {
                continue;
            }
            ui.label(text);
            let field = DragValue::new(value).speed(speed).range(0.0..=1e6).update_while_editing(false);
            has_changed |= ui.add(field).changed();
        }
    });
    has_changed
}

fn switches(ui: &mut Ui, view: &mut ViewState, done: &mut Vec<Done>) {
    let settings = view.settings;
    for (is_on, text, action) in [
        (settings.wireframe, "wireframe (t)", Action::ToggleWireframe),
        (settings.normals, "normals in wireframe (n)", Action::ToggleNormals),
        (settings.shading == Shading::Phong, "shading per pixel (m)", Action::ToggleShading),
        (settings.lights_turn, "lights turn with the scene (b)", Action::ToggleLightsTurn),
        (settings.axes, "axes and lights (a)", Action::ToggleAxes),
        (view.is_traced, "ray traced (p)", Action::ToggleTrace),
    ] {
        let mut shown = is_on;
        if ui.checkbox(&mut shown, text).changed() {
            done.push(Done::Action(action));
        }
    }
}

fn io_settings(ui: &mut Ui, view: &mut ViewState, done: &mut Vec<Done>) {
    let mut is_on = view.settings.io_test;
    if ui.checkbox(&mut is_on, "shown (o): red inside, blue outside").changed() {
        done.push(Done::Action(Action::ToggleIoTest));
    }
    let settings = &mut view.settings;
    for (value, range, text) in [
        (&mut settings.io_step, 0.05..=5.0, "step"),
        (&mut settings.io_half, 0.5..=50.0, "extent"),
        (&mut settings.io_jitter, 0.0..=0.5, "jitter"),
        (&mut settings.io_radius, 0.005..=1.0, "radius"),
    ] {
        if ui
            .add(Slider::new(value, range).logarithmic(true).text(text).update_while_editing(false))
            .changed()
        {
            done.push(Done::SettingsChanged);
        }
    }
}

fn intersection(ui: &mut Ui, view: &mut ViewState, hit: Option<&CastHit>, done: &mut Vec<Done>) {
    let mut is_on = view.settings.intersect_test;
    if ui.checkbox(&mut is_on, "shown (i); a click casts the pixel's ray").changed() {
        done.push(Done::Action(Action::ToggleIntersectTest));
    }
    if !view.settings.intersect_test {
        return;
    }
    ui.label(if view.cast.is_some() {
        "The ray of the click:"
    } else {
        "The eye's own ray, straight ahead:"
    });
    if view.cast.is_some() && ui.small_button("back to the eye's own ray").clicked() {
        view.cast = None;
    }
    let Some(hit) = hit else {
        ui.label("hits nothing");
        return;
    };
    egui::Grid::new("hit").num_columns(2).show(ui, |ui| {
        let steps = match hit.newton_steps {
            Some(steps) => steps.to_string(),
            None => "none: roots isolated by bounds".to_owned(),
        };
        for (label, text) in [
            ("t", number_text(hit.t, DECIMALS)),
            ("point", vector_text(hit.point)),
            ("normal", vector_text(hit.normal)),
            ("path", hit.path.clone()),
            ("Newton steps", steps),
        ] {
            ui.label(label);
            ui.add(egui::Label::new(RichText::new(text).monospace().small()).wrap());
            ui.end_row();
        }
    });
}

/// What is shown, and what is not, at the bottom of the scene; a notice at its top.
fn texts(ui: &Ui, model: &Model<'_>) {
    let scene = ui.available_rect_before_wrap();
    let text_box = |id: &str, pivot: Align2, at: egui::Pos2, lines: &[&str], color: Color32| {
        egui::Area::new(egui::Id::unique(id)).interactable(false).pivot(pivot).fixed_pos(at).show(
            ui.ctx(),
            |ui| {
                egui::Frame::new()
                    .fill(Color32::from_black_alpha(150))
                    .inner_margin(5)
                    .corner_radius(4)
                    .show(ui, |ui| {
                        ui.set_max_width((scene.width() - 24.0).max(80.0));
                        for line in lines {
                            ui.label(RichText::new(*line).color(color));
                        }
                    });
            },
        );
    };
    let status: Vec<&str> = model.status.iter().map(String::as_str).collect();
    if !status.is_empty() {
        let at = scene.left_bottom() + egui::vec2(8.0, -8.0);
        text_box("status", Align2::LEFT_BOTTOM, at, &status, Color32::from_gray(220));
    }
    if let Some(notice) = model.notice {
        let at = scene.center_top() + egui::vec2(0.0, 10.0);
        text_box("notice", Align2::CENTER_TOP, at, &[notice], Color32::from_rgb(255, 224, 150));
    }
}

fn help(ui: &Ui, model: &Model<'_>) {
    let scene = ui.available_rect_before_wrap();
    egui::Area::new(egui::Id::unique("help"))
        .interactable(false)
        .order(egui::Order::Foreground)
        .pivot(Align2::CENTER_CENTER)
        .fixed_pos(scene.center())
        .show(ui.ctx(), |ui| {
            egui::Frame::new().fill(Color32::from_black_alpha(225)).inner_margin(16).corner_radius(8).show(
                ui,
                |ui| {
                    ui.visuals_mut().override_text_color = Some(Color32::from_gray(225));
                    ui.heading("Keys");
                    egui::Grid::new("keys").num_columns(2).spacing([18.0, 3.0]).show(ui, |ui| {
                        for row in BINDINGS {
                            ui.label(RichText::new(row.keys.join("  ")).strong().monospace());
                            ui.label(row.help);
                            ui.end_row();
                        }
                        for (what, does) in POINTER_HELP {
                            ui.label(RichText::new(*what).strong());
                            ui.label(*does);
                            ui.end_row();
                        }
                    });
                    ui.small(model.device);
                },
            );
        });
}

fn number(ui: &mut Ui, value: &mut f64, speed: f64) -> egui::Response {
    ui.add(DragValue::new(value).speed(speed).max_decimals(3).update_while_editing(false))
}

fn vector(ui: &mut Ui, label: &str, value: &mut DVec3, speed: f64) -> bool {
    ui.horizontal(|ui| {
        ui.label(label);
        // Each is drawn, whichever has changed.
        let fields = [0, 1, 2].map(|axis| number(ui, &mut value[axis], speed).changed());
        fields.contains(&true)
    })
    .inner
}

/// A field for a linear colour; parts above 1 stay until it is touched.
fn color(ui: &mut Ui, value: &mut DVec3) -> bool {
    let mut rgb = value.as_vec3().to_array();
    let has_changed = ui.color_edit_button_rgb(&mut rgb).changed();
    if has_changed {
        *value = DVec3::from_array(rgb.map(|part| (f64::from(part.clamp(0.0, 1.0)) * 1e4).round() / 1e4));
    }
    has_changed
}

fn vector_text(v: DVec3) -> String {
    v.to_array().map(|x| number_text(x, DECIMALS)).join(" ")
}

/// The line that makes a light, and another one where it has a radius.
fn light_lines(name: &str, light: &Light) -> String {
    let (color, falloff) = (vector_text(light.color), number_text(light.falloff, DECIMALS));
    let line = match light.kind {
        LightKind::Point { position } => format!("light {name} {} {color} {falloff}", vector_text(position)),
        LightKind::Spot { position, target, cone_deg, soft } => format!(
            "spot {name} {} {} {} {color} {falloff} {}",
            vector_text(position),
            vector_text(target),
            number_text(cone_deg, DECIMALS),
            number_text(soft, DECIMALS)
        ),
        LightKind::Sun { direction } => format!("sun {name} {} {color}", vector_text(direction)),
    };
    if light.radius > 0.0 {
        format!("{line}\nlightRadius {name} {}", number_text(light.radius, DECIMALS))
    } else {
        line
    }
}

fn camera_line(camera: &Camera) -> String {
    let fov = number_text(camera.fov_deg, DECIMALS);
    format!("camera {} {} {fov}", vector_text(camera.position), vector_text(camera.target))
}

fn step_line(step: &TransformStep, of_whole: bool) -> String {
    let all = if of_whole { "All" } else { "" };
    match step {
        TransformStep::Translate(by) => format!("translate{all} {}", vector_text(*by)),
        TransformStep::Rotate { axis, angle_deg } => {
            format!("rotate{all} {} {}", vector_text(*axis), number_text(*angle_deg, DECIMALS))
        }
        TransformStep::Scale(factors) => format!("scale{all} {}", vector_text(*factors)),
    }
}

#[cfg(test)]
mod tests {
    use superegg_lang::Session;

    use super::*;

    /// The lines that the panel writes are lines of the language, and do what the draft showed.
    #[test]
    fn lines_of_the_panel_are_commands() {
        let mut session = Session::default();
        for line in ["prm ball", "obj o", "ap ball"] {
            assert!(session.run_line(line).is_ok());
        }
        let light = Light {
            kind: LightKind::Point { position: DVec3::new(1.5, -2.0, 0.0) },
            color: DVec3::splat(0.25),
            ..Light::DEFAULT
        };
        let camera = Camera { position: DVec3::new(1.0, 2.0, -3.0), fov_deg: 45.5, ..Camera::default() };
        let steps = [
            TransformStep::Translate(DVec3::new(0.1, 0.0, -2.0)),
            TransformStep::Rotate { axis: DVec3::Y, angle_deg: -30.0 },
            TransformStep::Scale(DVec3::splat(1.5)),
        ];
        let mut expected = session.scene().clone();
        let spot = Light {
            kind: LightKind::Spot { position: DVec3::Y * 4.0, target: DVec3::X, cone_deg: 35.5, soft: 0.25 },
            radius: 0.5,
            ..light
        };
        let sun = Light {
            kind: LightKind::Sun { direction: DVec3::new(1.0, 3.0, 2.0) },
            falloff: 0.0,
            radius: 0.0047,
            ..light
        };
        for (name, light) in [("light1", light), ("spot1", spot), ("sun1", sun)] {
            expected.set_light(name, light);
        }
        expected.camera = camera;
        let mut lines = vec![camera_line(&camera)];
        for (name, light) in [("light1", light), ("spot1", spot), ("sun1", sun)] {
            lines.extend(light_lines(name, &light).lines().map(str::to_owned));
        }
        for of_whole in [false, true] {
            for step in steps {
                lines.push(step_line(&step, of_whole));
                let done = if of_whole {
                    expected.transform_whole("o", step)
                } else {
                    expected.transform_child("o", step)
                };
                assert!(done.is_ok());
            }
        }
        for line in &lines {
            assert!(session.run_line(line).is_ok(), "{line}");
        }
        assert_eq!(*session.scene(), expected);
    }
}
