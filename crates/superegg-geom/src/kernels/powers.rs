//! The powers p = 2/e and q = 2/n of a shape, in f32.

use std::num::NonZeroU32;

use crate::superquadric::{Convex, Superquadric};

/// A power, with the two values that have formulas of their own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum PowerKind {
    One,
    Two,
    General(f32),
}

impl PowerKind {
    pub(super) fn of(p: f64) -> Self {
        match p {
            1.0 => Self::One,
            2.0 => Self::Two,
            _ => Self::General(lane_power(p)),
        }
    }

    pub(super) fn power(self) -> f32 {
        match self {
            Self::One => 1.0,
            Self::Two => 2.0,
            Self::General(p) => p,
        }
    }
}

/// A power in f32. Above 1e9 the norm equals its larger argument in f32.
pub(super) fn lane_power(p: f64) -> f32 {
    p.min(1e9) as f32
}

/// The powers of a shape for [`super::stream`]: p = 2/e and q = 2/n, at most 1e9; at least 1 for a convex shape.
///
/// `Option<LanePowers>` is no larger than two f32: p is stored by its bits, which are not 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LanePowers {
    p_bits: NonZeroU32,
    q: f32,
}

impl LanePowers {
    /// The powers of a shape.
    pub fn of(shape: &Convex) -> Self {
        Self::of_any(shape)
    }

    /// The powers of a shape of any exponents, for the search of [`super::stream`]; at most 1e9.
    pub fn of_any(shape: &Superquadric) -> Self {
        let norm = shape.norm();
        let p_bits = NonZeroU32::new(lane_power(norm.xy.p).to_bits()).unwrap_or(NonZeroU32::MIN);
        Self { p_bits, q: lane_power(norm.rz.p) }
    }

    /// p = 2/e.
    #[inline(always)]
    pub fn p(self) -> f32 {
        f32::from_bits(self.p_bits.get())
    }

    /// q = 2/n.
    #[inline(always)]
    pub fn q(self) -> f32 {
        self.q
    }
}
