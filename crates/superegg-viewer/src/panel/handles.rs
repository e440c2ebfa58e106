//! The handles of the selected child, and the compass in the corner that shows the axes.

use egui::{Align2, Color32, FontId, Painter, Pos2, Rect, Sense, Stroke, Ui, Vec2};

use super::model::{PanelEvent, PanelModel};
use crate::input::gizmo::{Handle, Handles};
use crate::input::{Tool, ViewSide};

/// x, y and z.
const COLORS: [Color32; 3] =
    [Color32::from_rgb(235, 80, 75), Color32::from_rgb(110, 200, 80), Color32::from_rgb(90, 140, 255)];
const ALL_COLOR: Color32 = Color32::from_rgb(240, 240, 240);
const COMPASS_RADIUS: f32 = 32.0;
const BALL_RADIUS: f32 = 8.0;

/// Draws the handles over the scene.
pub(super) fn handles(ui: &Ui, scene: Rect, handles: &Handles) {
    let painter = ui.painter().with_clip_rect(scene);
    let scale = ui.ctx().pixels_per_point();
    let point = |pixel: superegg_geom::glam::DVec2| Pos2::new(pixel.x as f32, pixel.y as f32) / scale;
    let hovered = ui.ctx().pointer_hover_pos().and_then(|at| {
        let pixel = superegg_geom::glam::DVec2::new(f64::from(at.x * scale), f64::from(at.y * scale));
        handles.at(pixel)
    });
    for (axis, line) in handles.lines.iter().enumerate() {
        let is_hovered = hovered == Some(Handle::Axis(axis));
        let color = if is_hovered { Color32::YELLOW } else { COLORS[axis] };
        let points: Vec<Pos2> = line.iter().map(|pixel| point(*pixel)).collect();
        draw_line(&painter, handles.tool, &points, Stroke::new(if is_hovered { 4.0 } else { 3.0 }, color));
    }
    if handles.tool == Tool::Scale {
        let color = if hovered == Some(Handle::All) { Color32::YELLOW } else { ALL_COLOR };
        painter.rect_filled(Rect::from_center_size(point(handles.origin), Vec2::splat(11.0)), 2.0, color);
    }
}

fn draw_line(painter: &Painter, tool: Tool, points: &[Pos2], stroke: Stroke) {
    match (tool, points) {
        (Tool::Move, [from, to]) => painter.arrow(*from, *to - *from, stroke),
        (Tool::Scale, [from, to]) => {
            painter.line_segment([*from, *to], stroke);
            painter.rect_filled(Rect::from_center_size(*to, Vec2::splat(10.0)), 2.0, stroke.color);
        }
        _ => {
            painter.line(points.to_vec(), stroke);
        }
    }
}

/// Draws the axes in the upper right corner of the scene. A click on an end shows the scene from
/// there.
pub(super) fn compass(ui: &Ui, scene: Rect, model: &PanelModel<'_>, events: &mut Vec<PanelEvent>) {
    let reach = COMPASS_RADIUS + BALL_RADIUS;
    if scene.width() < 6.0 * reach || scene.height() < 4.0 * reach {
        return;
    }
    let corner = scene.right_top() + Vec2::new(-2.0 * reach - 8.0, 8.0);
    egui::Area::new(egui::Id::unique("compass")).fixed_pos(corner).show(ui.ctx(), |ui| {
        let (response, painter) = ui.allocate_painter(Vec2::splat(2.0 * reach), Sense::click());
        let middle = response.rect.center();
        let mut ends: Vec<(f64, Pos2, usize, bool)> = Vec::new();
        for (axis, [right, up, towards]) in model.compass.into_iter().enumerate() {
            for (sign, is_positive) in [(1.0, true), (-1.0, false)] {
                let at = middle + COMPASS_RADIUS * Vec2::new((sign * right) as f32, (-sign * up) as f32);
                ends.push((sign * towards, at, axis, is_positive));
            }
        }
        ends.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (towards, at, axis, is_positive) in &ends {
            let color = COLORS[*axis].gamma_multiply(if *towards < -0.2 { 0.55 } else { 1.0 });
            if *is_positive {
                painter.line_segment([middle, *at], Stroke::new(2.5, color));
                painter.circle_filled(*at, BALL_RADIUS, color);
                let letter = ["x", "y", "z"][*axis];
                painter.text(*at, Align2::CENTER_CENTER, letter, FontId::proportional(12.0), Color32::BLACK);
            } else {
                painter.circle_filled(*at, 0.7 * BALL_RADIUS, color.gamma_multiply(0.45));
            }
        }
        let clicked = response.interact_pointer_pos().filter(|_| response.clicked());
        let end =
            clicked.and_then(|at| ends.iter().rev().find(|end| end.1.distance(at) <= BALL_RADIUS + 2.0));
        if let Some((_, _, axis, is_positive)) = end {
            events.extend(side_towards(model, *axis, *is_positive).map(PanelEvent::LookFrom));
        }
        response.on_hover_text("click an axis to look along it");
    });
}

/// The side of the scene that an axis points to.
fn side_towards(model: &PanelModel<'_>, axis: usize, is_positive: bool) -> Option<ViewSide> {
    let sign = if is_positive { 1.0 } else { -1.0 };
    let direction = sign * superegg_geom::glam::DVec3::AXES[axis];
    let up = model.scene.up();
    let sides =
        [ViewSide::Front, ViewSide::Back, ViewSide::Right, ViewSide::Left, ViewSide::Top, ViewSide::Bottom];
    sides.into_iter().max_by(|a, b| {
        let along = |side: &ViewSide| side.directions(up).0.dot(direction);
        along(a).total_cmp(&along(b))
    })
}
