//! Where rays enter and leave convex shapes, and at which angles, in f32.

use superegg_simd::{Column, Lanes, Simd, Triple, WithSimd};

use super::super::norm::{EvaluateNorm, SIDE_BY_SIDE, SQUARES, ValueAndGradient};
use super::super::root::{NEAR, Segment, first_crossings};
use super::solve::{STREAM_LANES, StreamLanes, TOLERANCE};

/// Shorter chords, in unit space, graze the surface: their ends and angles are not reliable.
const LEAST_CHORD: f32 = 1e-2;

/// The chords of rays through shapes, by lanes.
#[derive(Clone, Debug)]
pub struct StreamChords {
    /// The distances of entry and exit from the start of the segment, in unit space.
    pub s: [Column<f32, STREAM_LANES>; 2],
    /// At both ends `|d . g| / |M^T g|`, with the unit direction d, the gradient g, and the linear map M from the world.
    pub slopes: [Column<f32, STREAM_LANES>; 2],
    /// The rays with a chord, one bit each.
    pub found: u32,
    /// The rays that certainly miss their shape. All others are not resolved.
    pub missed: u32,
}

impl Default for StreamChords {
    fn default() -> Self {
        let none = Column::splat(0.0);
        Self { s: [none; 2], slopes: [none; 2], found: 0, missed: 0 }
    }
}

impl StreamLanes {
    /// The chords of the first `count` rays, whose segments begin where they enter the box of their shape and end where they
    /// leave it. `unit_from_world` has the columns of the linear map M from the world, of any scale, which is the same for all.
    pub fn chords(&self, count: usize, unit_from_world: &[[f32; 3]; 3], chords: &mut StreamChords) {
        self.arch().dispatch(ChordKernel { lanes: self, count, unit_from_world, chords });
    }
}

struct ChordKernel<'a> {
    lanes: &'a StreamLanes,
    count: usize,
    unit_from_world: &'a [[f32; 3]; 3],
    chords: &'a mut StreamChords,
}

impl WithSimd for ChordKernel<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { lanes, count, unit_from_world, chords } = self;
        (chords.found, chords.missed) = (0, 0);
        // Closures of `map` are not inlined here, and then each instruction is a call.
        let [x, y, z] = *unit_from_world;
        let [x, y, z] = [Triple::splat(simd, x), Triple::splat(simd, y), Triple::splat(simd, z)];
        let tolerance = Lanes::<S, SIDE_BY_SIDE>::splat(simd, TOLERANCE);
        let near = tolerance.all(NEAR);
        for i in (0..count.div_ceil(S::F32_LANES)).step_by(SIDE_BY_SIDE) {
            let (norm, segment) = lanes.load(simd, i);
            let Segment { start, direction, length, active } = segment;
            let back = Segment {
                start: start.along(length, direction),
                direction: direction.scaled(length.all(-1.0)),
                length,
                active,
            };
            let entry = first_crossings(norm, &segment, tolerance, near);
            let exit = first_crossings(norm, &back, tolerance, near);
            let (first, last) = (entry.s, length - exit.s);
            let is_long = (first + first.all(LEAST_CHORD)).lt(last);
            let mut found =
                (entry.found & exit.found & active & is_long).and_not(entry.unresolved | exit.unresolved);
            for (end, &s) in [first, last].iter().enumerate() {
                let ValueAndGradient { gradient, .. } = norm.value_and_gradient(start.along(s, direction));
                let [along_x, along_y, along_z] = [x.dot(gradient), y.dot(gradient), z.dot(gradient)];
                let square = along_x.mul_add(along_x, along_y.mul_add(along_y, along_z * along_z));
                found = found & square.all(SQUARES[0]).lt(square) & square.lt(square.all(SQUARES[1]));
                chords.s[end].store(i, s);
                chords.slopes[end].store(i, gradient.dot(direction).abs() * square.rsqrt());
            }
            chords.found |= found.bits_from(i);
            chords.missed |= active.and_not(entry.found | entry.unresolved).bits_from(i);
        }
    }
}
