//! Vectors of three coordinates in lanes, and linear maps of them.

use pulp::Simd;

use crate::column::Column;
use crate::vector::Lanes;

/// A point, direction or gradient in each lane.
#[derive(Clone, Copy)]
pub struct Triple<S: Simd, const K: usize = 1> {
    /// The x coordinates.
    pub x: Lanes<S, K>,
    /// The y coordinates.
    pub y: Lanes<S, K>,
    /// The z coordinates.
    pub z: Lanes<S, K>,
}

impl<S: Simd, const K: usize> Triple<S, K> {
    /// The same vector in every lane.
    #[inline(always)]
    pub fn splat(simd: S, [x, y, z]: [f32; 3]) -> Self {
        Self { x: Lanes::splat(simd, x), y: Lanes::splat(simd, y), z: Lanes::splat(simd, z) }
    }

    /// Loads `K` registers of three columns.
    #[inline(always)]
    pub fn load<const N: usize>(simd: S, columns: &[Column<f32, N>; 3], i: usize) -> Self {
        let [x, y, z] = columns;
        Self { x: x.load(simd, i), y: y.load(simd, i), z: z.load(simd, i) }
    }

    /// Joins `K` single registers.
    #[inline(always)]
    pub fn join(parts: [Triple<S>; K]) -> Self {
        let (mut x, mut y, mut z) = ([parts[0].x; K], [parts[0].y; K], [parts[0].z; K]);
        for k in 1..K {
            (x[k], y[k], z[k]) = (parts[k].x, parts[k].y, parts[k].z);
        }
        Self { x: Lanes::join(x), y: Lanes::join(y), z: Lanes::join(z) }
    }

    /// `self + s direction`.
    #[inline(always)]
    pub fn along(self, s: Lanes<S, K>, direction: Self) -> Self {
        Self {
            x: s.mul_add(direction.x, self.x),
            y: s.mul_add(direction.y, self.y),
            z: s.mul_add(direction.z, self.z),
        }
    }

    /// `factor * self`.
    #[inline(always)]
    pub fn scaled(self, factor: Lanes<S, K>) -> Self {
        Self { x: self.x * factor, y: self.y * factor, z: self.z * factor }
    }

    /// The scalar product.
    #[inline(always)]
    pub fn dot(self, other: Self) -> Lanes<S, K> {
        self.x.mul_add(other.x, self.y.mul_add(other.y, self.z * other.z))
    }
}

/// A linear map, the same in every lane.
#[derive(Clone, Copy)]
pub struct Linear<S: Simd>([Triple<S>; 3]);

impl<S: Simd> Linear<S> {
    /// The map with these columns.
    #[inline(always)]
    pub fn splat(simd: S, columns: &[[f32; 3]; 3]) -> Self {
        let [a, b, c] = *columns;
        Self([Triple::splat(simd, a), Triple::splat(simd, b), Triple::splat(simd, c)])
    }

    /// The image of a vector.
    #[inline(always)]
    pub fn image(self, v: Triple<S>) -> Triple<S> {
        let [a, b, c] = self.0;
        let row = |a: Lanes<S>, b: Lanes<S>, c: Lanes<S>| a.mul_add(v.x, b.mul_add(v.y, c * v.z));
        Triple { x: row(a.x, b.x, c.x), y: row(a.y, b.y, c.y), z: row(a.z, b.z, c.z) }
    }
}
