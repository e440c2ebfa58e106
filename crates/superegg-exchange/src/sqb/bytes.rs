//! Numbers as bytes, and the materials and shapes made of them.

use superegg_geom::Exponents;
use superegg_geom::glam::{DQuat, DVec3};
use superegg_scene::{Material, Pattern, TableShape};

/// A value of a fixed number of bytes.
pub(super) trait Fixed: Sized {
    /// The number of bytes.
    const BYTES: usize;

    /// Appends the bytes.
    fn put(&self, bytes: &mut Vec<u8>);

    /// The value of these bytes, at least [`Fixed::BYTES`]; `None` if they are no value.
    fn take(bytes: &[u8]) -> Option<Self>;
}

/// The eight bytes at an index.
fn word(bytes: &[u8], index: usize) -> Option<[u8; 8]> {
    bytes.get(8 * index..8 * index + 8)?.try_into().ok()
}

fn number(bytes: &[u8], index: usize) -> Option<f64> {
    Some(f64::from_le_bytes(word(bytes, index)?))
}

fn vector(bytes: &[u8], index: usize) -> Option<DVec3> {
    Some(DVec3::new(number(bytes, index)?, number(bytes, index + 1)?, number(bytes, index + 2)?))
}

impl Fixed for u32 {
    const BYTES: usize = 4;

    fn put(&self, bytes: &mut Vec<u8>) {
        bytes.extend(self.to_le_bytes());
    }

    fn take(bytes: &[u8]) -> Option<Self> {
        Some(Self::from_le_bytes(bytes.get(..4)?.try_into().ok()?))
    }
}

impl Fixed for i64 {
    const BYTES: usize = 8;

    fn put(&self, bytes: &mut Vec<u8>) {
        bytes.extend(self.to_le_bytes());
    }

    fn take(bytes: &[u8]) -> Option<Self> {
        Some(Self::from_le_bytes(word(bytes, 0)?))
    }
}

impl Fixed for DVec3 {
    const BYTES: usize = 24;

    fn put(&self, bytes: &mut Vec<u8>) {
        self.to_array().iter().for_each(|x| bytes.extend(x.to_le_bytes()));
    }

    fn take(bytes: &[u8]) -> Option<Self> {
        vector(bytes, 0)
    }
}

/// As x, y, z, w.
impl Fixed for DQuat {
    const BYTES: usize = 32;

    fn put(&self, bytes: &mut Vec<u8>) {
        self.to_array().iter().for_each(|x| bytes.extend(x.to_le_bytes()));
    }

    fn take(bytes: &[u8]) -> Option<Self> {
        let v = vector(bytes, 0)?;
        Some(Self::from_xyzw(v.x, v.y, v.z, number(bytes, 3)?))
    }
}

impl Fixed for TableShape {
    const BYTES: usize = 44;

    fn put(&self, bytes: &mut Vec<u8>) {
        self.radii.put(bytes);
        [self.exponents.e(), self.exponents.n()].iter().for_each(|x| bytes.extend(x.to_le_bytes()));
        self.material.put(bytes);
    }

    fn take(bytes: &[u8]) -> Option<Self> {
        Some(Self {
            radii: vector(bytes, 0)?,
            exponents: Exponents::new(number(bytes, 3)?, number(bytes, 4)?).ok()?,
            material: u32::take(bytes.get(40..)?)?,
        })
    }
}

/// 23 numbers, to which [`Facets`] adds two: -1 marks an unset one of `reflected`, `refracted` and `shininess`, none of
/// which is negative. The kind of pattern is 0 for none, 1 for a checker, 2 for a gradient, 3, 4
/// and 5 for noise, marble and wood.
impl Fixed for Material {
    const BYTES: usize = 23 * 8;

    fn put(&self, bytes: &mut Vec<u8>) {
        let Self {
            color,
            ambient,
            reflected,
            refracted,
            gloss,
            diffuse,
            specular,
            index,
            shininess,
            fresnel,
            absorb,
            emission,
            roughness: _,
            metallic: _,
            pattern,
        } = *self;
        let (kind, second, detail) = match pattern {
            Pattern::None => (0.0, DVec3::ZERO, DVec3::ZERO),
            Pattern::Checker { color, size } => (1.0, color, DVec3::splat(size)),
            Pattern::Gradient { color, direction } => (2.0, color, direction),
            Pattern::Noise { color, size } => (3.0, color, DVec3::splat(size)),
            Pattern::Marble { color, size } => (4.0, color, DVec3::splat(size)),
            Pattern::Wood { color, size } => (5.0, color, DVec3::splat(size)),
        };
        let unset = |number: Option<f64>| number.unwrap_or(-1.0);
        let numbers = [
            ambient,
            unset(reflected),
            unset(refracted),
            gloss,
            diffuse,
            specular,
            index,
            unset(shininess),
            f64::from(u8::from(fresnel)),
            kind,
            emission,
        ];
        color.put(bytes);
        numbers.iter().for_each(|x| bytes.extend(x.to_le_bytes()));
        [absorb, second, detail].iter().for_each(|v| v.put(bytes));
    }

    fn take(bytes: &[u8]) -> Option<Self> {
        let at = |index: usize| number(bytes, index).filter(|x| x.is_finite());
        let set = |index: usize| Some(at(index)?).map(|x| Some(x).filter(|x| *x >= 0.0));
        let unit = |index: usize| at(index).filter(|x| (0.0..=1.0).contains(x));
        let of_unit = |v: DVec3| (v.min_element() >= 0.0 && v.max_element() <= 1.0).then_some(v);
        let (second, detail) = (vector(bytes, 17)?, vector(bytes, 20)?);
        let pattern = match at(12)? {
            0.0 => Pattern::None,
            1.0 if detail.x > 0.0 => Pattern::Checker { color: of_unit(second)?, size: detail.x },
            2.0 if detail != DVec3::ZERO && detail.is_finite() => {
                Pattern::Gradient { color: of_unit(second)?, direction: detail }
            }
            3.0 if detail.x > 0.0 => Pattern::Noise { color: of_unit(second)?, size: detail.x },
            4.0 if detail.x > 0.0 => Pattern::Marble { color: of_unit(second)?, size: detail.x },
            5.0 if detail.x > 0.0 => Pattern::Wood { color: of_unit(second)?, size: detail.x },
            _ => return None,
        };
        let weight = |index: usize| Some(set(index)?.filter(|x| *x <= 1.0));
        Some(Self {
            color: of_unit(vector(bytes, 0)?)?,
            ambient: unit(3)?,
            reflected: weight(4)?,
            refracted: weight(5)?,
            gloss: unit(6)?,
            diffuse: unit(7)?,
            specular: unit(8)?,
            index: at(9).filter(|x| (1.0..=4.0).contains(x))?,
            shininess: set(10)?,
            fresnel: at(11)? != 0.0,
            absorb: vector(bytes, 14).filter(|v| v.is_finite() && v.min_element() >= 0.0)?,
            // Older programs knew no emission and wrote 0.
            emission: at(13).filter(|x| *x >= 0.0)?,
            roughness: None,
            metallic: 0.0,
            pattern,
        })
    }
}

/// The facets of a material, in a column of their own that older files lack. -1 marks an unset roughness.
pub(super) struct Facets {
    roughness: Option<f64>,
    metallic: f64,
}

impl Facets {
    pub(super) fn of(material: &Material) -> Self {
        Self { roughness: material.roughness, metallic: material.metallic }
    }

    pub(super) fn set(&self, material: &mut Material) {
        (material.roughness, material.metallic) = (self.roughness, self.metallic);
    }
}

impl Fixed for Facets {
    const BYTES: usize = 16;

    fn put(&self, bytes: &mut Vec<u8>) {
        let numbers = [self.roughness.unwrap_or(-1.0), self.metallic];
        numbers.iter().for_each(|x| bytes.extend(x.to_le_bytes()));
    }

    fn take(bytes: &[u8]) -> Option<Self> {
        let is_unit = |x: &f64| (0.0..=1.0).contains(x);
        let roughness = number(bytes, 0).filter(|x| *x == -1.0 || is_unit(x))?;
        Some(Self { roughness: Some(roughness).filter(is_unit), metallic: number(bytes, 1).filter(is_unit)? })
    }
}
