//! The part of the light that one bounce off the facets of a surface keeps. The rest has met further facets, and is given
//! back as diffuse light (Kulla and Conty 2017): without it rough surfaces are too dark.

use std::sync::OnceLock;

use superegg_geom::glam::{DVec2, DVec3};

use crate::camera::sobol::sobol;
use crate::shade::microfacet::ggx::{Ggx, grazing};
use crate::shade::phong;

/// The parts of a curve between its nodes, which are even in the square root of the cosine.
const PARTS: usize = 64;
/// The directions at each node.
const DIRECTIONS: u32 = 2048;
/// The steps of roughness from 0 to 1, between which curves are blended.
const ROUGHNESSES: usize = 64;
/// The steps of the relative index of refraction from 1 to 4.
const INDICES: usize = 96;

/// A function of the cosine of the angle to the normal, [0, 1].
#[derive(Clone, Debug)]
struct Curve {
    values: [f64; PARTS + 1],
    /// The mean, weighted by the cosine.
    mean: f64,
}

impl Curve {
    /// The curves of a function.
    fn all<const N: usize>(function: impl Fn(f64) -> [f64; N]) -> [Self; N] {
        let mut values = [[0.0; PARTS + 1]; N];
        for node in 0..=PARTS {
            let root = node as f64 / PARTS as f64;
            let found = function((root * root).max(1e-5));
            values.iter_mut().zip(found).for_each(|(values, found)| values[node] = found);
        }
        values.map(|values| {
            /// Steps of the mean.
            const STEPS: usize = 16 * PARTS;
            let mut curve = Self { values, mean: 0.0 };
            let at = |step: usize| (step as f64 + 0.5) / STEPS as f64;
            // With the square root of the cosine as variable: 2 cos d(cos) = 4 root^3 d(root).
            let weighted = |step: usize| 4.0 * at(step).powi(3) * curve.at_root(at(step));
            curve.mean = (0..STEPS).map(weighted).sum::<f64>() / STEPS as f64;
            curve
        })
    }

    fn at_root(&self, root: f64) -> f64 {
        let x = root.clamp(0.0, 1.0) * PARTS as f64;
        let node = (x as usize).min(PARTS - 1);
        let part = x - node as f64;
        self.values[node] + part * (self.values[node + 1] - self.values[node])
    }
}

/// A blend of curves with weights of sum 1.
#[derive(Clone, Copy, Debug)]
struct Blend<'a, const N: usize>([(f64, &'a Curve); N]);

impl<const N: usize> Blend<'_, N> {
    fn at(&self, cos: f64) -> f64 {
        let root = cos.max(0.0).sqrt();
        self.0.iter().map(|(weight, curve)| weight * curve.at_root(root)).sum()
    }

    fn mean(&self) -> f64 {
        self.0.iter().map(|(weight, curve)| weight * curve.mean).sum()
    }
}

/// The curves of mirrors of one roughness.
#[derive(Clone, Debug)]
struct MirrorRow {
    /// The albedo of a mirror that reflects all.
    full: Curve,
    /// The same, of one that reflects `(1 - cos)^5`.
    grazing: Curve,
}

/// The curves of glass of one roughness and index, for light from the thinner and from the denser side.
#[derive(Clone, Debug)]
struct GlassRow {
    /// The reflected or transmitted part.
    kept: [Curve; 2],
    /// The transmitted part.
    transmitted: [Curve; 2],
}

/// The curves of all surfaces of a picture, each computed at its first use.
pub(crate) struct AlbedoTables {
    mirrors: Vec<OnceLock<MirrorRow>>,
    glasses: Vec<OnceLock<Box<GlassRow>>>,
}

/// The albedo of a mirror of one roughness.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MirrorAlbedo<'a> {
    full: Blend<'a, 2>,
    grazing: Blend<'a, 2>,
}

/// The albedo of one side of a glass surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct GlassAlbedo<'a> {
    /// The part that is not lost, on this side and on the other.
    kept: [Blend<'a, 4>; 2],
    /// The part of the lost light of this side that is given back beyond the surface.
    pub(crate) beyond: f64,
}

impl AlbedoTables {
    pub(crate) fn new() -> Self {
        let glasses = (ROUGHNESSES + 1) * (INDICES + 1);
        Self {
            mirrors: std::iter::repeat_with(OnceLock::new).take(ROUGHNESSES + 1).collect(),
            glasses: std::iter::repeat_with(OnceLock::new).take(glasses).collect(),
        }
    }

    /// The albedo of a mirror of a roughness in [0, 1].
    pub(crate) fn mirror(&self, roughness: f64) -> MirrorAlbedo<'_> {
        let (first, part) = step(roughness, ROUGHNESSES);
        let [a, b] = [first, first + 1].map(|row| self.mirrors[row].get_or_init(|| MirrorRow::of(row)));
        MirrorAlbedo {
            full: Blend([(1.0 - part, &a.full), (part, &b.full)]),
            grazing: Blend([(1.0 - part, &a.grazing), (part, &b.grazing)]),
        }
    }

    /// The albedo of glass of a roughness in [0, 1], for light from a side whose index of refraction is `ratio` times
    /// smaller than that of the other.
    pub(crate) fn glass(&self, roughness: f64, ratio: f64) -> GlassAlbedo<'_> {
        let (row, row_part) = step(roughness, ROUGHNESSES);
        let index = ratio.max(ratio.recip());
        let (column, column_part) = step((index - 1.0) / 3.0, INDICES);
        let corners = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(down, right)| {
            let (row, column) = (row + down, column + right);
            let part = |upper: usize, part: f64| if upper == 0 { 1.0 - part } else { part };
            let found = self.glasses[row * (INDICES + 1) + column].get_or_init(|| GlassRow::of(row, column));
            (part(down, row_part) * part(right, column_part), &**found)
        });
        let (here, there) = if ratio >= 1.0 { (0, 1) } else { (1, 0) };
        let kept = [here, there].map(|side| Blend(corners.map(|(weight, row)| (weight, &row.kept[side]))));
        let transmitted =
            [here, there].map(|side| Blend(corners.map(|(weight, row)| (weight, &row.transmitted[side]))));
        // As much light crosses from each side, in a world of one brightness: of the lost light that the side with less
        // of it has, the part that crosses is that of the first bounce.
        let lost = [1.0 - kept[0].mean(), (1.0 - kept[1].mean()) * ratio * ratio];
        let least = usize::from(lost[1] < lost[0]);
        let crossing = transmitted[least].mean() / kept[least].mean().max(1e-9);
        let beyond = crossing * (lost[least] / lost[0].max(1e-12)).min(1.0);
        GlassAlbedo { kept, beyond }
    }
}

/// The step before a number in [0, 1] among `count`, and the part of the way to the next.
fn step(x: f64, count: usize) -> (usize, f64) {
    let x = x.clamp(0.0, 1.0) * count as f64;
    let first = (x as usize).min(count - 1);
    (first, x - first as f64)
}

impl MirrorRow {
    fn of(row: usize) -> Self {
        let ggx = Ggx::new(row as f64 / ROUGHNESSES as f64);
        let [full, grazing] = Curve::all(|cos| {
            let eye = eye_of(cos);
            let mut sums = [0.0; 2];
            for i in 0..DIRECTIONS {
                let facet = ggx.visible_facet(eye, half_square(i));
                let out = phong::mirror(-eye, facet);
                if out.z > 0.0 {
                    let kept = ggx.visible_to_both(eye, out) / ggx.visible(eye);
                    sums[0] += kept;
                    sums[1] += kept * grazing(eye.dot(facet));
                }
            }
            sums.map(|sum| sum / f64::from(DIRECTIONS))
        });
        Self { full, grazing }
    }
}

impl GlassRow {
    fn of(row: usize, column: usize) -> Box<Self> {
        let ggx = Ggx::new(row as f64 / ROUGHNESSES as f64);
        let index = (1.0 + 3.0 * column as f64 / INDICES as f64).max(LEAST_RATIO);
        let side = |ratio: f64| {
            Curve::all(|cos| {
                let eye = eye_of(cos);
                let mut sums = [0.0; 2];
                for i in 0..DIRECTIONS {
                    let facet = ggx.visible_facet(eye, half_square(i));
                    let refracted = phong::refract(-eye, facet, ratio.recip());
                    let reflectance = refracted.map_or(1.0, |(_, reflectance)| reflectance);
                    let mirrored = phong::mirror(-eye, facet);
                    if mirrored.z > 0.0 {
                        sums[0] += reflectance * ggx.visible_to_both(eye, mirrored) / ggx.visible(eye);
                    }
                    if let Some((out, _)) = refracted.filter(|(out, _)| out.z < 0.0) {
                        let transmitted = (1.0 - reflectance) * ggx.visible(out);
                        sums[0] += transmitted;
                        sums[1] += transmitted;
                    }
                }
                sums.map(|sum| sum / f64::from(DIRECTIONS))
            })
        };
        let ([thin, thin_through], [dense, dense_through]) = (side(index), side(index.recip()));
        Box::new(Self { kept: [thin, dense], transmitted: [thin_through, dense_through] })
    }
}

/// The relative index of refraction of an interface is at least this or at most its reciprocal: equal indices refract
/// nothing, and the facet of a direction would be lost in rounding.
pub(crate) const LEAST_RATIO: f64 = 1.001;

/// Points of one half of the unit square: a surface looks alike from both sides of the plane of the eye.
fn half_square(index: u32) -> DVec2 {
    sobol(index, 1) * DVec2::new(0.5, 1.0)
}

fn eye_of(cos: f64) -> DVec3 {
    DVec3::new((1.0 - cos * cos).max(0.0).sqrt(), 0.0, cos)
}

impl MirrorAlbedo<'_> {
    /// The part of the light that one bounce loses, at a cosine.
    pub(crate) fn lost(&self, cos: f64) -> f64 {
        1.0 - self.full.at(cos)
    }

    /// The mean of [`MirrorAlbedo::lost`].
    pub(crate) fn mean_lost(&self) -> f64 {
        1.0 - self.full.mean()
    }

    /// The albedo of one bounce for a mirror with this reflectance head on, which grows to 1 at grazing angles.
    pub(crate) fn once(&self, head_on: f64, cos: f64) -> f64 {
        head_on * self.full.at(cos) + (1.0 - head_on) * self.grazing.at(cos)
    }

    /// The part of the lost light that such a mirror gives back.
    pub(crate) fn given_back(&self, head_on: f64) -> f64 {
        // The mean of (1 - cos)^5 is 1/21.
        let mean = head_on + (1.0 - head_on) / 21.0;
        let kept = self.full.mean();
        mean * mean * kept / (1.0 - mean * (1.0 - kept))
    }

    /// All that such a mirror reflects, at a cosine.
    pub(crate) fn whole(&self, head_on: f64, cos: f64) -> f64 {
        self.once(head_on, cos) + self.given_back(head_on) * self.lost(cos)
    }

    /// The mean of [`MirrorAlbedo::whole`].
    pub(crate) fn mean_whole(&self, head_on: f64) -> f64 {
        let once = head_on * self.full.mean() + (1.0 - head_on) * self.grazing.mean();
        once + self.given_back(head_on) * self.mean_lost()
    }
}

impl GlassAlbedo<'_> {
    /// The albedo of one bounce on this side, at a cosine.
    pub(crate) fn kept(&self, cos: f64) -> f64 {
        self.kept[0].at(cos)
    }

    /// The part of the light that one bounce loses, on this side or beyond the surface.
    pub(crate) fn lost(&self, is_beyond: bool, cos: f64) -> f64 {
        1.0 - self.kept[usize::from(is_beyond)].at(cos)
    }

    /// The mean of [`GlassAlbedo::lost`].
    pub(crate) fn mean_lost(&self, is_beyond: bool) -> f64 {
        1.0 - self.kept[usize::from(is_beyond)].mean()
    }
}
