//! Handles that move, rotate and scale the selected child: pure state, in pixels of the window.

use std::f64::consts::TAU;

use superegg_geom::TransformStep;
use superegg_geom::glam::{DAffine3, DMat3, DQuat, DVec2, DVec3};

use super::projection::Projection;

/// The actions of handles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tool {
    /// Arrows along the axes.
    Move,
    /// Rings about the axes.
    Rotate,
    /// Bars along the axes, and a box for all of them.
    Scale,
}

/// One handle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Handle {
    /// Along or about the axis of this index.
    Axis(usize),
    /// All axes alike.
    All,
}

/// Length of an arrow and radius of a ring.
pub(crate) const SIZE_PX: f64 = 90.0;
/// A handle is grabbed within this distance.
const GRAB_PX: f64 = 9.0;
/// Points of a drawn ring.
const RING_POINTS: usize = 48;
/// Steps of rotation and of scale with Ctrl.
const SNAP_DEG: f64 = 15.0;
const SNAP_FACTOR: f64 = 0.1;
/// Least factor of one drag.
const LEAST_FACTOR: f64 = 0.02;

/// The frame of the handles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct GizmoFrame {
    /// The child's origin in the space of its object, where its transforms act.
    pub(crate) pivot: DVec3,
    /// World from the space of the object.
    pub(crate) world_from_object: DAffine3,
}

/// The handles on the screen.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Handles {
    pub(crate) tool: Tool,
    pub(crate) origin: DVec2,
    /// The line of each axis: an arrow from the origin, or a ring.
    pub(crate) lines: [Vec<DVec2>; 3],
}

/// A drag of a handle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct GizmoDrag {
    tool: Tool,
    handle: Handle,
    start: DVec2,
    frame: GizmoFrame,
    /// The origin on the screen.
    origin: DVec2,
    /// World units of the axis per pixel along its arrow, and the arrow's direction on the screen.
    units: f64,
    along: DVec2,
    /// 1 if the axis points to the eye: the scene turns as the pointer does.
    turn: f64,
    /// The last angle, so that a drag can make several turns.
    angle: f64,
}

impl GizmoFrame {
    fn origin(&self) -> DVec3 {
        self.world_from_object.transform_point3(self.pivot)
    }

    fn axis(&self, index: usize) -> DVec3 {
        (self.world_from_object.matrix3 * DVec3::AXES[index]).normalize_or_zero()
    }
}

impl Handles {
    /// The handles on the screen. `None` if their origin is behind the camera.
    pub(crate) fn new(tool: Tool, frame: &GizmoFrame, projection: &Projection) -> Option<Self> {
        let center = frame.origin();
        let origin = projection.pixel(center)?;
        let size = SIZE_PX * projection.unit_per_pixel(center)?;
        let line = |index: usize| -> Vec<DVec2> {
            let axis = frame.axis(index);
            let points: Vec<DVec3> = match tool {
                Tool::Move | Tool::Scale => vec![center, center + size * axis],
                Tool::Rotate => {
                    let (u, v) = axis.any_orthonormal_pair();
                    let angles = (0..=RING_POINTS).map(|i| TAU * i as f64 / RING_POINTS as f64);
                    angles.map(|angle| center + size * (angle.cos() * u + angle.sin() * v)).collect()
                }
            };
            points.into_iter().filter_map(|point| projection.pixel(point)).collect()
        };
        Some(Self { tool, origin, lines: [0, 1, 2].map(line) })
    }

    /// The handle at a pixel.
    pub(crate) fn at(&self, pixel: DVec2) -> Option<Handle> {
        if self.tool == Tool::Scale && (pixel - self.origin).length() <= GRAB_PX {
            return Some(Handle::All);
        }
        let distance = |line: &[DVec2]| {
            line.windows(2).map(|ends| distance_to_segment(pixel, ends[0], ends[1])).fold(f64::MAX, f64::min)
        };
        let distances = self.lines.each_ref().map(|line| distance(line));
        let nearest = (0..3).min_by(|a, b| distances[*a].total_cmp(&distances[*b]))?;
        (distances[nearest] <= GRAB_PX).then_some(Handle::Axis(nearest))
    }

    /// Begins to drag the handle at a pixel.
    pub(crate) fn press(
        &self,
        pixel: DVec2,
        frame: &GizmoFrame,
        projection: &Projection,
    ) -> Option<GizmoDrag> {
        let handle = self.at(pixel)?;
        let center = frame.origin();
        let size = SIZE_PX * projection.unit_per_pixel(center)?;
        let axis = match handle {
            Handle::Axis(index) => frame.axis(index),
            Handle::All => DVec3::ZERO,
        };
        let arrow = projection.pixel(center + size * axis).map_or(DVec2::ZERO, |end| end - self.origin);
        let length = arrow.length();
        Some(GizmoDrag {
            tool: self.tool,
            handle,
            start: pixel,
            frame: *frame,
            origin: self.origin,
            units: if length > 1.0 { size / length } else { 0.0 },
            along: if length > 1.0 { arrow / length } else { DVec2::X },
            turn: if projection.faces_eye(center, axis) { -1.0 } else { 1.0 },
            angle: 0.0,
        })
    }
}

impl GizmoDrag {
    /// The step of a drag to a pixel. With `snaps` rotations and factors are round. `None` if it
    /// changes nothing.
    pub(crate) fn step(&mut self, pixel: DVec2, snaps: bool) -> Option<TransformStep> {
        let moved = pixel - self.start;
        let axis = match self.handle {
            Handle::Axis(index) => DVec3::AXES[index],
            Handle::All => DVec3::ONE,
        };
        let along_px = moved.dot(self.along);
        match self.tool {
            Tool::Move => {
                let stretch = (self.frame.world_from_object.matrix3 * axis).length().max(1e-300);
                let distance = along_px * self.units / stretch;
                (distance != 0.0).then_some(TransformStep::Translate(distance * axis))
            }
            Tool::Rotate => {
                let turned =
                    (self.start - self.origin).angle_to(pixel - self.origin).to_degrees() * self.turn;
                // The angle nearest to the last one, among those that differ by whole turns.
                self.angle = turned + 360.0 * ((self.angle - turned) / 360.0).round();
                let angle_deg = if snaps { (self.angle / SNAP_DEG).round() * SNAP_DEG } else { self.angle };
                if angle_deg == 0.0 || !angle_deg.is_finite() {
                    return None;
                }
                let step = TransformStep::Rotate { axis, angle_deg };
                let linear = DMat3::from_quat(DQuat::from_axis_angle(axis, angle_deg.to_radians()));
                Some(self.about_pivot(step, linear))
            }
            Tool::Scale => {
                let pulled = if self.handle == Handle::All { moved.x - moved.y } else { along_px };
                let factor = (1.0 + pulled / SIZE_PX).max(LEAST_FACTOR);
                let factor =
                    if snaps { (factor / SNAP_FACTOR).round().max(1.0) * SNAP_FACTOR } else { factor };
                if factor == 1.0 {
                    return None;
                }
                let factors = DVec3::ONE + (factor - 1.0) * axis;
                Some(self.about_pivot(TransformStep::Scale(factors), DMat3::from_diagonal(factors)))
            }
        }
    }

    /// A step about the child's own origin. Steps of the language are about that of the object.
    fn about_pivot(&self, step: TransformStep, linear: DMat3) -> TransformStep {
        let pivot = self.frame.pivot;
        if pivot == DVec3::ZERO {
            return step;
        }
        let translation = pivot - linear * pivot;
        TransformStep::Affine(Box::new(DAffine3 { matrix3: linear, translation }))
    }
}

fn distance_to_segment(point: DVec2, from: DVec2, to: DVec2) -> f64 {
    let along = to - from;
    let t = ((point - from).dot(along) / along.length_squared().max(1e-300)).clamp(0.0, 1.0);
    (point - from - t * along).length()
}

#[cfg(test)]
mod tests {
    use superegg_scene::Camera;

    use super::*;
    use crate::input::Viewport;

    fn projection() -> Projection {
        let viewport = Viewport { corner: DVec2::ZERO, size: DVec2::new(800.0, 600.0) };
        Projection::new(&Camera::default(), &viewport)
    }

    fn frame(pivot: DVec3) -> GizmoFrame {
        GizmoFrame { pivot, world_from_object: DAffine3::IDENTITY }
    }

    fn drag(tool: Tool, pivot: DVec3, from: DVec2, to: DVec2, snaps: bool) -> Option<TransformStep> {
        let handles = Handles::new(tool, &frame(pivot), &projection())?;
        let mut drag = handles.press(handles.origin + from, &frame(pivot), &projection())?;
        drag.step(handles.origin + to, snaps)
    }

    fn map(step: &TransformStep) -> DAffine3 {
        match step {
            TransformStep::Translate(by) => DAffine3::from_translation(*by),
            TransformStep::Rotate { axis, angle_deg } => {
                DAffine3::from_axis_angle(*axis, angle_deg.to_radians())
            }
            TransformStep::Scale(factors) => DAffine3::from_scale(*factors),
            TransformStep::Orient(q) => DAffine3::from_quat(*q),
            TransformStep::Affine(map) => **map,
        }
    }

    #[test]
    fn an_arrow_follows_the_pointer_along_its_axis() {
        let pivot = DVec3::new(1.0, -0.5, 0.0);
        let step = drag(Tool::Move, pivot, DVec2::new(60.0, 0.0), DVec2::new(110.0, 33.0), false).unwrap();
        let TransformStep::Translate(by) = step else { panic!("{step:?}") };
        let moved = projection().pixel(pivot + by).unwrap() - projection().pixel(pivot).unwrap();
        assert!((moved - DVec2::new(50.0, 0.0)).length() < 1e-6 && by.y == 0.0, "{moved} {by}");
        // Beside the handles there is nothing to grab.
        assert_eq!(drag(Tool::Move, pivot, DVec2::new(60.0, 40.0), DVec2::ZERO, false), None);
    }

    #[test]
    fn rings_and_bars_leave_the_pivot_where_it_is() {
        for pivot in [DVec3::ZERO, DVec3::new(1.0, 2.0, -1.0)] {
            for tool in [Tool::Rotate, Tool::Scale] {
                let from =
                    if tool == Tool::Rotate { DVec2::from_angle(0.7) * SIZE_PX } else { DVec2::X * 50.0 };
                let Some(step) = drag(tool, pivot, from, DVec2::new(20.0, -70.0), false) else {
                    panic!("{tool:?} {pivot}");
                };
                assert!((map(&step).transform_point3(pivot) - pivot).length() < 1e-9, "{step:?}");
            }
        }
    }

    #[test]
    fn a_ring_turns_as_the_pointer_does_and_snaps() {
        // About z, which points to the eye: the pointer goes up on the right.
        let (from, to) = (DVec2::from_angle(0.5), DVec2::from_angle(0.5 - 0.7));
        let step = drag(Tool::Rotate, DVec3::ZERO, SIZE_PX * from, SIZE_PX * to, false).unwrap();
        let TransformStep::Rotate { axis, angle_deg } = step else { panic!("{step:?}") };
        assert!(axis == DVec3::Z && (angle_deg - 0.7f64.to_degrees()).abs() < 1e-6, "{axis} {angle_deg}");
        let step = drag(Tool::Rotate, DVec3::ZERO, SIZE_PX * from, SIZE_PX * to, true).unwrap();
        assert_eq!(step, TransformStep::Rotate { axis: DVec3::Z, angle_deg: 45.0 });
    }

    #[test]
    fn the_box_in_the_middle_scales_all_axes() {
        let step = drag(Tool::Scale, DVec3::ZERO, DVec2::ZERO, DVec2::new(90.0, 0.0), false).unwrap();
        assert_eq!(step, TransformStep::Scale(DVec3::splat(2.0)));
        let small = drag(Tool::Scale, DVec3::ZERO, DVec2::ZERO, DVec2::new(-900.0, 0.0), false).unwrap();
        let TransformStep::Scale(factors) = small else { panic!("{small:?}") };
        assert!((factors - DVec3::splat(LEAST_FACTOR)).length() < 1e-12);
    }
}
