//! The picture as it is made: linear values.

use std::ops::Range;

use crate::tiling::Tile;

/// What a picture knows of one pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pixel {
    /// Linear light, before exposure and tone; where the background is transparent only that of surfaces, times `alpha` as it were
    /// (premultiplied).
    pub color: [f32; 3],
    /// The share of the pixel that surfaces cover, [0, 1]; 1 everywhere unless the background is transparent.
    pub alpha: f32,
    /// The distance of the first surface from the plane of the camera, in world units along the line of sight: the mean over the samples
    /// that meet one, infinity where none does.
    pub depth: f32,
    /// The mean direction of the normals on the camera's side in world space, of length 1; 0 0 0 where no sample meets a surface.
    pub normal: [f32; 3],
    /// The mean linear colour of the surfaces themselves; 0 0 0 where no sample meets one.
    pub albedo: [f32; 3],
    /// The number of the instance that most samples meet, 0 for none. Where no instance has more than half of the samples, one of them.
    pub id: u32,
    /// How many samples were taken; 0 where the pixel has not been made.
    pub samples: u32,
}

impl Pixel {
    /// One that has not been made: black, nothing met.
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

    /// Its thirteen numbers in the order of the fields, four bytes each, the lowest first.
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

/// What a film may know of a pixel beyond its light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Layers {
    pub(crate) depth: f32,
    pub(crate) normal: [f32; 3],
    pub(crate) albedo: [f32; 3],
    pub(crate) id: u32,
}

impl Layers {
    /// Of nothing met.
    pub(crate) const EMPTY: Self = Self {
        depth: Pixel::EMPTY.depth,
        normal: Pixel::EMPTY.normal,
        albedo: Pixel::EMPTY.albedo,
        id: Pixel::EMPTY.id,
    };
}

/// A picture as it is made, or a tile of one: linear values, rows from the top.
#[derive(Clone, Debug)]
pub struct Film {
    width: u32,
    height: u32,
    colors: Vec<[f32; 3]>,
    /// None where each is that of an opaque picture ([`opaque_alpha`]).
    alphas: Vec<f32>,
    samples: Counts,
    /// None where they are not kept.
    layers: Vec<Layers>,
}

/// The alpha of a pixel with so many samples in a picture without holes.
fn opaque_alpha(samples: u32) -> f32 {
    if samples > 0 { 1.0 } else { 0.0 }
}

/// How many samples each pixel has, in a byte as long as those are enough: fresh memory takes a tenth of a cheap picture's time.
#[derive(Clone, Debug)]
pub(crate) enum Counts {
    Few(Vec<u8>),
    Many(Vec<u32>),
}

impl Counts {
    fn get(&self, place: usize) -> u32 {
        match self {
            Self::Few(counts) => u32::from(counts[place]),
            Self::Many(counts) => counts[place],
        }
    }

    fn set(&mut self, place: usize, count: u32) {
        match (&mut *self, u8::try_from(count)) {
            (Self::Few(counts), Ok(count)) => counts[place] = count,
            (Self::Few(counts), Err(_)) => {
                *self = Self::Many(counts.iter().copied().map(u32::from).collect());
                self.set(place, count);
            }
            (Self::Many(counts), _) => counts[place] = count,
        }
    }

    /// Takes a row of others.
    fn set_row(&mut self, to: Range<usize>, others: &Self, from: Range<usize>) {
        match (&mut *self, others) {
            (Self::Few(counts), Self::Few(others)) => counts[to].copy_from_slice(&others[from]),
            (Self::Many(counts), Self::Many(others)) => counts[to].copy_from_slice(&others[from]),
            _ => to.zip(from).for_each(|(to, from)| self.set(to, others.get(from))),
        }
    }
}

impl FromIterator<u32> for Counts {
    fn from_iter<I: IntoIterator<Item = u32>>(counts: I) -> Self {
        let mut counts = counts.into_iter();
        let mut few = Vec::with_capacity(counts.size_hint().0);
        while let Some(count) = counts.next() {
            match u8::try_from(count) {
                Ok(count) => few.push(count),
                Err(_) => {
                    let before = few.into_iter().map(u32::from);
                    return Self::Many(before.chain(std::iter::once(count)).chain(counts).collect());
                }
            }
        }
        Self::Few(few)
    }
}

/// Films are the same whose pixels are.
impl PartialEq for Film {
    fn eq(&self, other: &Self) -> bool {
        self.width == other.width
            && self.height == other.height
            && self.has_layers() == other.has_layers()
            && self.pixels().eq(other.pixels())
    }
}

impl Film {
    /// One of which no pixel has been made.
    pub fn new(width: u32, height: u32) -> Self {
        let count = width as usize * height as usize;
        Self { layers: vec![Layers::EMPTY; count], ..Self::without_layers(width, height) }
    }

    /// The same that keeps neither depth nor normals, albedo and ids, but takes less than a third of the memory. Its pixels have those of [`Pixel::EMPTY`].
    pub fn without_layers(width: u32, height: u32) -> Self {
        let count = width as usize * height as usize;
        let samples = Counts::Few(vec![0; count]);
        Self { width, height, colors: vec![[0.0; 3]; count], alphas: Vec::new(), samples, layers: Vec::new() }
    }

    /// One with these pixels; `alphas` are empty where nothing shows through, `layers` where they are not kept.
    pub(crate) fn of_parts(
        (width, height): (u32, u32),
        colors: Vec<[f32; 3]>,
        alphas: Vec<f32>,
        samples: Counts,
        layers: Vec<Layers>,
    ) -> Self {
        Self { width, height, colors, alphas, samples, layers }
    }

    /// One with layers, of these pixels; those that are missing have not been made.
    pub fn of_pixels(width: u32, height: u32, pixels: impl IntoIterator<Item = Pixel>) -> Self {
        let mut film = Self::new(width, height);
        for (place, pixel) in (0..film.colors.len()).zip(pixels) {
            film.put(place, pixel);
        }
        film
    }

    /// Its width in pixels.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Its height in pixels.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Whether it keeps depth, normals, albedo and ids.
    pub fn has_layers(&self) -> bool {
        self.layers.len() == self.colors.len()
    }

    /// The pixels, rows from the top.
    pub fn pixels(&self) -> impl ExactSizeIterator<Item = Pixel> {
        (0..self.colors.len()).map(|place| self.pixel_at(place))
    }

    /// Linear red, green and blue of the pixels, rows from the top.
    pub fn colors(&self) -> &[[f32; 3]] {
        &self.colors
    }

    /// The same with alpha.
    pub fn light(&self) -> impl Iterator<Item = ([f32; 3], f32)> {
        self.colors.iter().enumerate().map(|(place, color)| (*color, self.alpha(place)))
    }

    fn alpha(&self, place: usize) -> f32 {
        self.alphas.get(place).copied().unwrap_or_else(|| opaque_alpha(self.samples.get(place)))
    }

    /// A pixel, from the top left corner.
    pub fn pixel(&self, x: u32, y: u32) -> Pixel {
        self.pixel_at(self.place(x, y))
    }

    fn pixel_at(&self, place: usize) -> Pixel {
        let Layers { depth, normal, albedo, id } = self.layers.get(place).copied().unwrap_or(Layers::EMPTY);
        let (color, alpha, samples) = (self.colors[place], self.alpha(place), self.samples.get(place));
        Pixel { color, alpha, depth, normal, albedo, id, samples }
    }

    /// Puts a pixel in its place.
    pub fn set(&mut self, x: u32, y: u32, pixel: Pixel) {
        self.put(self.place(x, y), pixel);
    }

    fn put(&mut self, place: usize, pixel: Pixel) {
        let Pixel { color, alpha, depth, normal, albedo, id, samples } = pixel;
        if alpha != opaque_alpha(samples) {
            self.keep_alphas();
        }
        self.colors[place] = color;
        self.samples.set(place, samples);
        if let Some(to) = self.alphas.get_mut(place) {
            *to = alpha;
        }
        if let Some(layers) = self.layers.get_mut(place) {
            *layers = Layers { depth, normal, albedo, id };
        }
    }

    /// A tile of this picture.
    pub fn tile(&self, tile: &Tile) -> Self {
        let (width, height) = tile.size();
        let mut of_tile = Self { width, height, ..Self::without_layers(0, 0) };
        for y in tile.y.clone() {
            let row = self.place(tile.x.start, y)..self.place(tile.x.end, y);
            of_tile.colors.extend_from_slice(&self.colors[row.clone()]);
            of_tile.alphas.extend_from_slice(self.alphas.get(row.clone()).unwrap_or_default());
            of_tile.layers.extend_from_slice(self.layers.get(row).unwrap_or_default());
        }
        let rows = tile.y.clone().flat_map(|y| self.place(tile.x.start, y)..self.place(tile.x.end, y));
        of_tile.samples = rows.map(|place| self.samples.get(place)).collect();
        of_tile
    }

    /// Puts a tile in its place; of layers what both know.
    pub fn set_tile(&mut self, tile: &Tile, pixels: &Self) {
        let width = tile.x.len();
        if !pixels.alphas.is_empty() {
            self.keep_alphas();
        }
        for (row, y) in tile.y.clone().enumerate() {
            let (to, from) = (self.place(tile.x.start, y), row * width);
            let (to, from) = (to..to + width, from..from + width);
            self.colors[to.clone()].copy_from_slice(&pixels.colors[from.clone()]);
            self.samples.set_row(to.clone(), &pixels.samples, from.clone());
            if let Some(to) = self.alphas.get_mut(to.clone()) {
                to.iter_mut().zip(from.clone()).for_each(|(to, from)| *to = pixels.alpha(from));
            }
            if let (Some(to), Some(from)) = (self.layers.get_mut(to), pixels.layers.get(from)) {
                to.copy_from_slice(from);
            }
        }
    }

    /// From here on each pixel has an alpha of its own.
    fn keep_alphas(&mut self) {
        if self.alphas.is_empty() {
            self.alphas = (0..self.colors.len()).map(|place| self.alpha(place)).collect();
        }
    }

    fn place(&self, x: u32, y: u32) -> usize {
        y as usize * self.width as usize + x as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_bring_what_they_and_the_film_know() {
        let tile = Tile { x: 1..3, y: 1..2 };
        let pixel = |id| Pixel { color: [1.0, 2.0, id as f32], alpha: 1.0, id, samples: 4, ..Pixel::EMPTY };
        let with = Film::of_pixels(2, 1, [pixel(7), pixel(8)]);
        let mut without = Film::without_layers(2, 1);
        (0..2).for_each(|x| without.set(x, 0, pixel(7 + x)));
        for part in [&with, &without] {
            for mut film in [Film::new(4, 3), Film::without_layers(4, 3)] {
                let knows = film.has_layers();
                film.set_tile(&tile, part);
                let id = if knows && part.has_layers() { 8 } else { 0 };
                assert_eq!(film.pixel(2, 1), Pixel { id, ..pixel(8) });
                assert_eq!(film.pixels().filter(|pixel| *pixel != Pixel::EMPTY).count(), 2);
                assert_eq!(film.tile(&tile).has_layers(), knows);
                assert!(film.tile(&tile).light().eq(part.light()));
            }
        }
    }

    #[test]
    fn counts_and_alphas_are_kept_whatever_they_are() {
        let tile = Tile { x: 1..3, y: 0..1 };
        let pixel = |samples, alpha| Pixel { color: [0.5; 3], alpha, samples, ..Pixel::EMPTY };
        let opaque = [pixel(1, 1.0), pixel(255, 1.0)];
        let many = [pixel(3, 1.0), pixel(65_536, 1.0)];
        let clear = [pixel(2, 0.25), pixel(2, 1.0)];
        let film = |pixels: [Pixel; 2]| {
            let mut film = Film::without_layers(2, 1);
            (0..2).zip(pixels).for_each(|(x, pixel)| film.set(x, 0, pixel));
            film
        };
        for before in [opaque, many, clear] {
            for after in [opaque, many, clear] {
                let mut whole = Film::without_layers(4, 1);
                whole.set_tile(&Tile { x: 2..4, y: 0..1 }, &film(before));
                whole.set_tile(&tile, &film(after));
                let expected = [Pixel::EMPTY, after[0], after[1], before[1]];
                assert!(whole.pixels().eq(expected), "{before:?} {after:?}");
                assert_eq!(whole.tile(&tile), film(after));
                assert!(whole.tile(&tile).light().eq(after.map(|pixel| (pixel.color, pixel.alpha))));
            }
        }
        for counts in [[0, 255, 7], [1, 256, 65_536]] {
            let kept: Counts = counts.into_iter().collect();
            assert!((0..3).all(|place| kept.get(place) == counts[place]));
        }
    }

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
