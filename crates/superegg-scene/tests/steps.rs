//! Steps of children and of whole objects are accepted exactly where their composition is a
//! transform, though most are accepted without being composed.

use superegg_geom::glam::{DAffine3, DMat3, DQuat, DVec3};
use superegg_geom::{Transform, TransformBound, TransformError, TransformStep};
use superegg_scene::{Scene, SceneError};

struct Random(u64);

impl Random {
    fn below(&mut self, end: u64) -> u64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (self.0 >> 33) % end
    }

    /// A number of plain size; if `is_hostile` also of any size, and sometimes no finite number.
    fn number(&mut self, is_hostile: bool) -> f64 {
        let plain = self.below(2001) as f64 * 1e-3 - 1.0;
        match self.below(if is_hostile { 24 } else { 4 }) {
            4 => 0.0,
            5 => f64::NAN,
            6 => f64::INFINITY,
            7..=12 => plain * 10f64.powi(self.below(613) as i32 - 306),
            13..=16 => plain * 10f64.powi(self.below(60) as i32 - 30),
            _ => plain,
        }
    }

    fn vector(&mut self, is_hostile: bool) -> DVec3 {
        DVec3::from_array([(); 3].map(|()| self.number(is_hostile)))
    }

    fn step(&mut self, is_hostile: bool) -> TransformStep {
        match self.below(8) {
            0..3 => TransformStep::Translate(self.vector(is_hostile)),
            3..5 => TransformStep::Rotate {
                axis: self.vector(is_hostile),
                angle_deg: 100.0 * self.number(is_hostile),
            },
            5 => TransformStep::Scale(self.vector(is_hostile)),
            6 => {
                let v = self.vector(is_hostile);
                TransformStep::Orient(DQuat::from_xyzw(v.x, v.y, v.z, self.number(is_hostile)))
            }
            _ => {
                let columns = [(); 3].map(|()| self.vector(is_hostile));
                let matrix3 = DMat3::from_cols(columns[0], columns[1], columns[2]);
                TransformStep::Affine(Box::new(DAffine3 { matrix3, translation: self.vector(is_hostile) }))
            }
        }
    }
}

fn appended(transform: &Transform, step: &TransformStep) -> Result<Transform, TransformError> {
    let mut transform = *transform;
    transform.append(step).map(|()| transform)
}

#[test]
fn steps_are_accepted_where_they_compose_to_a_transform() {
    let mut random = Random(19);
    let (mut accepted, mut rejected) = (0, 0);
    for round in 0..600 {
        let mut scene = Scene::default();
        scene.ensure_object("o").unwrap();
        scene.add_child("o", "a", "o").unwrap();
        let (mut own, mut overall) = (Transform::IDENTITY, Transform::IDENTITY);
        for count in 0..50 {
            let step = random.step(round % 3 != 0);
            let moves_whole = random.below(6) == 0 && round % 2 == 0;
            let expected = if moves_whole {
                appended(&overall, &step).and_then(|next| next.after(&own).map(|_| (own, next)))
            } else {
                appended(&own, &step).and_then(|next| overall.after(&next).map(|_| (next, overall)))
            };
            // The bounds of the steps so far are also found by moving the cursor back.
            if count % 7 == 0 {
                scene.move_cursor("o", "a").unwrap();
            }
            let done = match moves_whole {
                true => scene.transform_whole("o", step),
                false => scene.transform_child("o", step),
            };
            match expected {
                Ok(both) => (own, overall) = both,
                Err(error) => {
                    assert_eq!(done, Err(SceneError::Transform(error)));
                    rejected += 1;
                    continue;
                }
            }
            assert_eq!(done, Ok(()));
            accepted += 1;
            let object = scene.object("o").unwrap();
            let composed = object.parent_from_child(object.child("a").unwrap()).unwrap();
            assert_eq!(composed, overall.after(&own).unwrap());
        }
    }
    assert!(accepted > 8000 && rejected > 2000, "{accepted} {rejected}");
}

#[test]
fn bounds_of_steps_hold() {
    let mut random = Random(7);
    let mut known = 0;
    for round in 0..2000 {
        let mut transform = Transform::IDENTITY;
        let mut bound = Some(TransformBound::IDENTITY);
        for _ in 0..30 {
            let step = random.step(round % 2 == 0);
            bound = bound.and_then(|bound| bound.after(&step));
            let Some(bound) = bound else { break };
            transform.append(&step).unwrap();
            for bound in [bound, TransformBound::of(&transform)] {
                let maps = [transform.forward(), transform.inverse()];
                let entries = maps.into_iter().flat_map(DAffine3::to_cols_array);
                assert!(entries.into_iter().all(|entry| entry.abs() <= bound.largest()), "{transform:?}");
            }
            known += 1;
        }
    }
    assert!(known > 5000, "{known}");
}
