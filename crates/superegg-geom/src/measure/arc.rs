//! A quarter of a superellipse, in a parametrisation without cancellation.

/// The arc `X^(2/w) + Y^(2/w) = 1`, X, Y >= 0, from (1, 0) to (0, 1), for a superellipse exponent
/// w:
///
/// ```text
/// X = S(-t)^(w/2),   Y = S(t)^(w/2),   S(t) = 1 / (1 + exp(-t)),   t from -infinity to infinity
/// ```
///
/// Both are right to a few ulps of themselves, on the longest spike and in the sharpest corner.
/// With an angle, `t = 2 ln tan(angle)`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Arc {
    half_exponent: f64,
}

/// A point of an arc, with derivatives by t.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct ArcPoint {
    pub(crate) x: f64,
    pub(crate) y: f64,
    /// -dX/dt >= 0.
    pub(crate) x_fall: f64,
    /// dY/dt >= 0.
    pub(crate) y_rise: f64,
    /// The steepness `-dY/dX`: 0 to infinity.
    pub(crate) steepness: f64,
    /// S(t).
    pub(crate) share: f64,
    /// S(-t).
    pub(crate) rest: f64,
}

impl Arc {
    pub(crate) fn new(exponent: f64) -> Self {
        Self { half_exponent: (0.5 * exponent).max(1e-300) }
    }

    /// The point at t, which may be infinite.
    pub(crate) fn at(self, t: f64) -> ArcPoint {
        let h = self.half_exponent;
        let (share, rest) = (logistic(t), logistic(-t));
        let (x, y) = ((-h * softplus(t)).exp(), (-h * softplus(-t)).exp());
        let slant = h - 1.0;
        let steepness = if slant == 0.0 { 1.0 } else { (slant * t).exp() };
        ArcPoint { x, y, x_fall: self.speed(x, share), y_rise: self.speed(y, rest), steepness, share, rest }
    }

    /// The speed of a coordinate: |dX/dt| from X and S(t), |dY/dt| from Y and S(-t).
    pub(crate) fn speed(self, coordinate: f64, share: f64) -> f64 {
        self.half_exponent * coordinate * share
    }

    /// A t beyond which both coordinates are within about 1e-18 of their limits, on either side.
    pub(crate) fn far(self) -> f64 {
        42.0 / self.half_exponent.min(1.0)
    }

    /// The t at which Y / X is this ratio: [`Arc::within`] the arc.
    pub(crate) fn at_ratio(self, ratio: f64) -> f64 {
        self.within(ratio.ln() / self.half_exponent)
    }

    /// A t of at most [`Arc::far`], or infinite at an end of the arc; 0 for no number.
    pub(crate) fn within(self, t: f64) -> f64 {
        if t.is_nan() {
            0.0
        } else if t.is_infinite() {
            t
        } else {
            t.clamp(-self.far(), self.far())
        }
    }

    /// The t at which X = 1 - `fall`, for 0 < `fall` < 1.
    pub(crate) fn t_at_fall(self, fall: f64) -> f64 {
        // softplus(t) = u.
        let u = -(-fall).ln_1p() / self.half_exponent;
        u + (-(-u).exp()).ln_1p()
    }

    /// The t at which the tangent has this steepness; `None` on a straight arc (exponent 2).
    pub(crate) fn parallel_to(self, steepness: f64) -> Option<f64> {
        let slant = self.half_exponent - 1.0;
        (slant != 0.0).then(|| steepness.ln() / slant)
    }

    /// d ln(-dX/dt) / dt and d ln(dY/dt) / dt.
    pub(crate) fn log_slopes(self, point: &ArcPoint) -> (f64, f64) {
        let (share, rest) = (point.share, point.rest);
        (rest - self.half_exponent * share, self.half_exponent * rest - share)
    }
}

/// 1 / (1 + exp(-t)).
fn logistic(t: f64) -> f64 {
    1.0 / (1.0 + (-t).exp())
}

/// ln(1 + exp(t)).
fn softplus(t: f64) -> f64 {
    t.max(0.0) + (-t.abs()).exp().ln_1p()
}
