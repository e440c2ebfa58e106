//! The samples of a pixel, as they come together to its values.

use superegg_geom::glam::DVec3;
use superegg_geom::unit_vector;

use crate::film::Pixel;
use crate::tile::{FirstSurface, Sighting};

/// What the samples of a pixel come to so far.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Gathered {
    color: DVec3,
    samples: u32,
    /// Sums over the samples that meet a surface, and how many do.
    surfaces: Sums,
    most_seen: Vote,
}

#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    count: u32,
    depth: f64,
    normal: DVec3,
    albedo: DVec3,
}

impl Gathered {
    /// Takes a sample.
    pub(crate) fn add(&mut self, seen: &Sighting) {
        self.color += seen.color;
        self.samples += 1;
        if let Some(FirstSurface { depth, normal, albedo, .. }) = seen.first {
            self.surfaces.count += 1;
            self.surfaces.depth += depth;
            self.surfaces.normal += normal;
            self.surfaces.albedo += albedo;
        }
        self.most_seen.add(seen.first.map_or(0, |first| first.id));
    }

    /// The pixel that they make.
    pub(crate) fn pixel(&self) -> Pixel {
        let count = f64::from(self.surfaces.count);
        let is_met = self.surfaces.count > 0;
        let mean = |sum: DVec3| if is_met { (sum / count).as_vec3().to_array() } else { [0.0; 3] };
        Pixel {
            color: (self.color / f64::from(self.samples.max(1))).as_vec3().to_array(),
            alpha: 1.0,
            depth: if is_met { (self.surfaces.depth / count) as f32 } else { f32::INFINITY },
            normal: unit_vector(self.surfaces.normal).unwrap_or(DVec3::ZERO).as_vec3().to_array(),
            albedo: mean(self.surfaces.albedo),
            id: self.most_seen.winner,
            samples: self.samples,
        }
    }
}

/// The vote of Boyer and Moore (1981): what has more than half of the votes wins, found without counting each.
#[derive(Clone, Copy, Debug, Default)]
struct Vote {
    winner: u32,
    lead: u32,
}

impl Vote {
    fn add(&mut self, id: u32) {
        if self.lead == 0 {
            *self = Self { winner: id, lead: 1 };
        } else if self.winner == id {
            self.lead += 1;
        } else {
            self.lead -= 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_than_half_of_the_votes_win_in_any_order() {
        for votes in [[7, 7, 7, 0, 3], [0, 7, 3, 7, 7], [7, 0, 7, 3, 7]] {
            let mut vote = Vote::default();
            votes.into_iter().for_each(|id| vote.add(id));
            assert_eq!(vote.winner, 7);
        }
    }

    #[test]
    fn surfaces_count_alone_where_some_samples_meet_nothing() {
        let first = FirstSurface { depth: 3.0, normal: DVec3::Z, albedo: DVec3::X, id: 9 };
        let mut gathered = Gathered::default();
        gathered.add(&Sighting { color: DVec3::ONE, first: None });
        assert_eq!(gathered.pixel().depth, f32::INFINITY);
        gathered.add(&Sighting { color: DVec3::ZERO, first: Some(first) });
        gathered.add(&Sighting { color: DVec3::ZERO, first: Some(FirstSurface { depth: 5.0, ..first }) });
        let pixel = gathered.pixel();
        assert_eq!((pixel.depth, pixel.normal, pixel.albedo), (4.0, [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]));
        assert_eq!((pixel.color, pixel.id, pixel.samples), ([1.0 / 3.0; 3], 9, 3));
    }
}
