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
    /// The small number of that instance ([`superegg_trace::InstanceNumbers::instance`]); 0 for none.
    pub instance: u32,
    /// The small number of the object that most samples hit ([`superegg_trace::InstanceNumbers::object`]), as `id`; 0 for
    /// none.
    pub object: u32,
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
        instance: 0,
        object: 0,
        samples: 0,
    };

    /// The length of [`Pixel::to_bytes`].
    pub const BYTES: usize = 60;

    /// The fifteen numbers in the order of the fields, instance and object last, four bytes each, little-endian.
    pub fn to_bytes(&self) -> [u8; Self::BYTES] {
        let [r, g, b] = self.color.map(f32::to_bits);
        let [nx, ny, nz] = self.normal.map(f32::to_bits);
        let [ar, ag, ab] = self.albedo.map(f32::to_bits);
        let (alpha, depth) = (self.alpha.to_bits(), self.depth.to_bits());
        let words = [
            r,
            g,
            b,
            alpha,
            depth,
            nx,
            ny,
            nz,
            ar,
            ag,
            ab,
            self.id,
            self.samples,
            self.instance,
            self.object,
        ];
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
            instance: word(13),
            object: word(14),
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
    pub(crate) instance: u32,
    pub(crate) object: u32,
}

impl Layers {
    /// Nothing hit.
    pub(crate) const EMPTY: Self = Self {
        depth: Pixel::EMPTY.depth,
        normal: Pixel::EMPTY.normal,
        albedo: Pixel::EMPTY.albedo,
        id: Pixel::EMPTY.id,
        instance: Pixel::EMPTY.instance,
        object: Pixel::EMPTY.object,
    };
}

/// The light of a pixel by the number of surfaces on its way, linear as [`Pixel::color`], which is their sum.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LightPasses {
    /// Light that comes straight to the camera: of the sky or the background, and of surfaces that shine.
    pub emission: [f32; 3],
    /// Light that one surface scatters, reflects or transmits to the camera.
    pub direct: [f32; 3],
    /// Light that passes by two surfaces or more.
    pub indirect: [f32; 3],
}

impl LightPasses {
    /// The length of [`LightPasses::to_bytes`].
    pub(crate) const BYTES: usize = 36;

    /// The nine numbers in the order of the fields, four bytes each, little-endian.
    pub(crate) fn to_bytes(self) -> [u8; Self::BYTES] {
        let numbers = [self.emission, self.direct, self.indirect];
        let mut bytes = [0; Self::BYTES];
        bytes
            .chunks_exact_mut(4)
            .zip(numbers.as_flattened())
            .for_each(|(to, number)| to.copy_from_slice(&number.to_le_bytes()));
        bytes
    }

    /// The passes that [`LightPasses::to_bytes`] wrote.
    pub(crate) fn from_bytes(bytes: &[u8; Self::BYTES]) -> Self {
        let number = |i: usize| f32::from_le_bytes(std::array::from_fn(|byte| bytes[4 * i + byte]));
        let vector = |i: usize| [number(i), number(i + 1), number(i + 2)];
        Self { emission: vector(0), direct: vector(3), indirect: vector(6) }
    }
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
            instance: 1 << 24,
            object: 7,
            samples: 65_536,
        };
        for pixel in [pixel, Pixel::EMPTY] {
            assert_eq!(Pixel::from_bytes(&pixel.to_bytes()).to_bytes(), pixel.to_bytes());
            assert_eq!(Pixel::from_bytes(&pixel.to_bytes()), pixel);
        }
        assert_eq!(pixel.to_bytes()[..4], [0, 0, 0x80, 0x3f]);
        assert_eq!(pixel.to_bytes()[44..52], [0xff, 0xff, 0xff, 0xff, 0, 0, 1, 0]);
        assert_eq!(pixel.to_bytes()[52..], [0, 0, 0, 1, 7, 0, 0, 0]);
        let passes =
            LightPasses { emission: [1.0, -0.0, 1e-40], direct: [2.0, 3.0, 4.0], indirect: [5.0, 6.0, 7.0] };
        assert_eq!(LightPasses::from_bytes(&passes.to_bytes()).to_bytes(), passes.to_bytes());
        assert_eq!(LightPasses::from_bytes(&passes.to_bytes()), passes);
    }
}
