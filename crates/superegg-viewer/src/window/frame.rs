//! One frame: annotations of the scene, panel, painting.

use superegg_geom::Ray;
use superegg_geom::glam::DVec2;
use superegg_scene::{Camera, Light, Scene};

use super::background::Background;
use super::content::Content;
use super::egui_layer::UiPaint;
use super::surface::OpenWindow;
use crate::draw::{FilmTexture, Line, Mark, Picture, Selected, Style, Target};
use crate::input::{ViewState, Viewport};
use crate::overlay::annotations::{axes, light_marks};
use crate::overlay::cast::lines_and_marks;
use crate::overlay::io_grid::marks;
use crate::panel::{Files, Panel, PanelEvent, PanelModel};
use crate::preview::Preview;
use crate::queries::{CastHit, cast};

/// A picture of the scene with its annotations.
pub(super) struct Composed<'a> {
    scene: &'a Scene,
    preview: &'a Preview,
    camera: Camera,
    lights: Vec<Light>,
    style: Style,
    is_course: bool,
    highlight: Option<Selected>,
    lines: Vec<Line>,
    marks: Vec<Mark>,
}

/// The intersection test, if it is on: its ray, and the first hit.
pub(super) fn intersection_test(
    content: &Content,
    background: &Background,
    view: &ViewState,
) -> Option<(Ray, Option<CastHit>)> {
    let compiled = background.compiled().filter(|_| view.settings.intersect_test)?;
    let ray = view.test_ray();
    Some((ray, cast(content.scene(), compiled, &ray)))
}

impl<'a> Composed<'a> {
    pub(super) fn new(content: &'a Content, background: &'a Background, view: &ViewState) -> Self {
        let scene = content.scene();
        let camera = view.eye.camera();
        let settings = &view.settings;
        let lights = view.eye.lights(&scene.lights(), settings.lights_turn);
        let preview = background.preview();
        let mut composed = Self {
            scene,
            preview,
            camera,
            lights,
            style: if settings.wireframe {
                Style::Wireframe { has_normals: settings.normals }
            } else {
                Style::Solid(settings.shading)
            },
            is_course: settings.course,
            // The selected primitive is highlighted if it is one among others.
            highlight: background
                .selected_shape()
                .filter(|_| content.root() != content.selected())
                .map(Selected::Shape)
                .or(content.child_index().map(Selected::Child)),
            lines: Vec::new(),
            marks: Vec::new(),
        };
        if settings.axes {
            composed.lines.extend(axes(preview.bounds.as_ref()));
            composed.marks.extend(light_marks(&composed.lights, &camera, scene.picture.encoding));
        }
        if let Some(grid) = background.grid().filter(|_| settings.io_test) {
            composed.marks.extend(marks(grid, settings, settings.wireframe));
        }
        if let Some((ray, hit)) = intersection_test(content, background, view) {
            let distance = (camera.target - camera.position).length();
            let (lines, marks) = lines_and_marks(&ray, hit.as_ref(), 100.0 * distance, 0.008 * distance);
            composed.lines.extend(lines);
            composed.marks.extend(marks);
        }
        composed
    }

    /// The picture for the drawing module. A film replaces everything else.
    pub(super) fn picture<'b>(&'b self, film: Option<&'b FilmTexture>) -> Picture<'b> {
        Picture {
            camera: self.camera,
            is_course: self.is_course,
            style: self.style,
            selected: self.highlight,
            lines: &self.lines,
            marks: &self.marks,
            film,
            ..Picture::of(self.scene, self.preview, &self.lights)
        }
    }
}

/// Runs the panel and takes over the viewport that it leaves.
pub(super) fn run_panel(
    open: &mut OpenWindow,
    panel: &mut Panel,
    files: &mut Files,
    view: &mut ViewState,
    model: &PanelModel<'_>,
) -> (UiPaint, Vec<PanelEvent>) {
    let mut events = Vec::new();
    let mut rest = egui::Rect::NOTHING;
    let theme = view.settings.theme;
    let paint = open.egui.run(&open.gpu, &open.surface.window, theme, |ui| {
        events.extend(panel.show(ui, view, model));
        events.extend(files.show(ui, model.document).into_iter().map(PanelEvent::FileEvent));
        rest = ui.available_rect_before_wrap();
    });
    let scale = f64::from(paint.pixels_per_point);
    let pixels = |at: egui::Pos2| DVec2::new(f64::from(at.x), f64::from(at.y)) * scale;
    let (corner, end) = (pixels(rest.min).round(), pixels(rest.max).round());
    view.viewport = Viewport { corner: corner.max(DVec2::ZERO), size: (end - corner).max(DVec2::ONE) };
    (paint, events)
}

/// Draws the scene and the panel into the next image of the surface.
pub(super) fn paint(open: &mut OpenWindow, composed: &Composed<'_>, view: &ViewState, ui: &UiPaint) {
    if let Some(texture) = open.surface.acquire() {
        let target_view = texture.texture.create_view(&wgpu::TextureViewDescriptor::default());
        let size = open.surface.size();
        let mut encoder = open.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let target = Target { view: &target_view, size, viewport: within(&view.viewport, size) };
        let picture = composed.picture(open.film.as_ref().filter(|_| view.is_traced));
        open.stats = open.drawing.draw(&mut encoder, &picture, &target);
        let mut commands = open.egui.paint(&open.gpu, &mut encoder, ui, &target_view, size);
        commands.push(encoder.finish());
        open.gpu.queue.submit(commands);
        open.surface.window.pre_present_notify();
        open.gpu.queue.present(texture);
    }
    open.egui.free_textures(ui);
}

/// The viewport in whole pixels, clipped to a target.
fn within(viewport: &Viewport, (width, height): (u32, u32)) -> (u32, u32, u32, u32) {
    let left = (viewport.corner.x as u32).min(width - 1);
    let top = (viewport.corner.y as u32).min(height - 1);
    let (w, h) = (viewport.size.x.max(1.0) as u32, viewport.size.y.max(1.0) as u32);
    (left, top, w.min(width - left), h.min(height - top))
}
