//! One pixel of a film.

/// The values of one pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pixel {
    /// Linear light, before exposure and tone mapping. In a picture with a transparent background
    /// it is the light of surfaces alone, premultiplied by `alpha`.
    pub color: [f32; 3],
    /// The fraction of the pixel that surfaces cover, 0 to 1. It is 1 if the background is opaque.
    pub alpha: f32,
    /// The distance of the first surface from the camera's plane along the line of sight, in world
    /// units: the mean of the samples that hit one; infinity if none does.
    pub depth: f32,
    /// The mean unit normal on the camera's side, in world space; 0 0 0 if no sample hits a
    /// surface.
    pub normal: [f32; 3],
    /// The mean linear base colour of the surfaces; 0 0 0 if no sample hits one.
    pub albedo: [f32; 3],
    /// The number of the instance that most samples hit; 0 for none. If no instance has more than
    /// half of the samples, it is the number of one of them.
    pub id: u32,
    /// The number of samples; 0 before the pixel is rendered.
    pub samples: u32,
}

impl Pixel {
    /// A pixel that is not rendered: black, nothing hit.
    pub const EMPTY: Self = Self {
        color: [0.0; 3],
        alpha: 0.0,
        depth: f32::INFINITY,
        normal: [0.0; 3],
        albedo: [0.0; 3],
        id: 0,
        samples: 0,
    };

    /// The length of [`Pixel::to_bytes`].
    pub const BYTES: usize = 52;

    /// The thirteen numbers in the order of the fields, four bytes each, little-endian.
    pub fn to_bytes(&self) -> [u8; Self::BYTES] {
        let [r, g, b] = self.color.map(f32::to_bits);
        let [nx, ny, nz] = self.normal.map(f32::to_bits);
        let [ar, ag, ab] = self.albedo.map(f32::to_bits);
        let (alpha, depth) = (self.alpha.to_bits(), self.depth.to_bits());
        let words = [r, g, b, alpha, depth, nx, ny, nz, ar, ag, ab, self.id, self.samples];
        let mut bytes = [0; Self::BYTES];
        bytes.chunks_exact_mut(4).zip(words).for_each(|(to, word)| to.copy_from_slice(&word.to_le_bytes()));
        bytes
    }

    /// The pixel that [`Pixel::to_bytes`] wrote, to the bit.
    pub fn from_bytes(bytes: &[u8; Self::BYTES]) -> Self {
        let word = |i: usize| u32::from_le_bytes(std::array::from_fn(|byte| bytes[4 * i + byte]));
        let number = |i: usize| f32::from_bits(word(i));
        let vector = |i: usize| [number(i), number(i + 1), number(i + 2)];
        Self {
            color: vector(0),
            alpha: number(3),
            depth: number(4),
            normal: vector(5),
            albedo: vector(8),
            id: word(11),
            samples: word(12),
        }
    }
}

/// The values of a pixel that a film may keep beside light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Layers {
    pub(crate) depth: f32,
    pub(crate) normal: [f32; 3],
    pub(crate) albedo: [f32; 3],
    pub(crate) id: u32,
}

impl Layers {
    /// Nothing hit.
    pub(crate) const EMPTY: Self = Self {
        depth: Pixel::EMPTY.depth,
        normal: Pixel::EMPTY.normal,
        albedo: Pixel::EMPTY.albedo,
        id: Pixel::EMPTY.id,
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_go_to_bytes_and_back_to_the_bit() {
        let pixel = Pixel {
            color: [1.0, -0.0, f32::MIN_POSITIVE],
            alpha: 0.25,
            depth: 1e30,
            normal: [0.0, 0.6, -0.8],
            albedo: [0.1, 0.2, 0.3],
            id: u32::MAX,
            samples: 65_536,
        };
        for pixel in [pixel, Pixel::EMPTY] {
            assert_eq!(Pixel::from_bytes(&pixel.to_bytes()).to_bytes(), pixel.to_bytes());
            assert_eq!(Pixel::from_bytes(&pixel.to_bytes()), pixel);
        }
        assert_eq!(pixel.to_bytes()[..4], [0, 0, 0x80, 0x3f]);
        assert_eq!(pixel.to_bytes()[44..], [0xff, 0xff, 0xff, 0xff, 0, 0, 1, 0]);
    }
}
