//! The film: the linear values of a picture, or of one tile of it.

use std::collections::BTreeSet;
use std::ops::Range;

use crate::film::matte::{Coverage, MatteLevel, Mattes};
use crate::film::pixel::{Layers, LightPasses, Pixel};
use crate::film::tile::Tile;

/// The linear values of a picture, or of one tile of it. Rows go from the top, pixels from the
/// left.
///
/// ```
/// use superegg_render::{Film, Pixel};
///
/// let pixel = Pixel { color: [0.5, 0.25, 0.0], alpha: 1.0, samples: 4, ..Pixel::EMPTY };
/// let film = Film::of_pixels(2, 1, [pixel]);
/// assert_eq!(film.pixel(0, 0), Some(pixel));
/// assert_eq!(film.pixel(2, 0), None, "outside the film");
/// assert_eq!(film.alphas().collect::<Vec<f32>>(), [1.0, 0.0]);
/// ```
#[derive(Clone, Debug)]
pub struct Film {
    width: u32,
    height: u32,
    colors: Vec<[f32; 3]>,
    /// Empty if every alpha is that of an opaque picture ([`opaque_alpha`]).
    alphas: Vec<f32>,
    samples: SampleCounts,
    /// Empty if the film keeps light alone.
    layers: Vec<Layers>,
    /// Empty unless the film keeps them.
    passes: Vec<LightPasses>,
    /// Empty unless the film keeps them.
    mattes: Mattes,
}

/// The alpha of a pixel of an opaque picture.
fn opaque_alpha(samples: u32) -> f32 {
    if samples > 0 { 1.0 } else { 0.0 }
}

/// The number of samples of each pixel. One byte each while they fit: allocating fresh memory takes
/// a tenth of the time of a cheap picture.
#[derive(Clone, Debug)]
pub(crate) enum SampleCounts {
    Few(Vec<u8>),
    Many(Vec<u32>),
}

impl SampleCounts {
    fn get(&self, index: usize) -> u32 {
        match self {
            Self::Few(counts) => u32::from(counts[index]),
            Self::Many(counts) => counts[index],
        }
    }

    fn set(&mut self, index: usize, count: u32) {
        match (&mut *self, u8::try_from(count)) {
            (Self::Few(counts), Ok(count)) => counts[index] = count,
            (Self::Few(counts), Err(_)) => {
                *self = Self::Many(counts.iter().copied().map(u32::from).collect());
                self.set(index, count);
            }
            (Self::Many(counts), _) => counts[index] = count,
        }
    }

    /// Copies a row of other counts.
    fn set_row(&mut self, to: Range<usize>, others: &Self, from: Range<usize>) {
        match (&mut *self, others) {
            (Self::Few(counts), Self::Few(others)) => counts[to].copy_from_slice(&others[from]),
            (Self::Many(counts), Self::Many(others)) => counts[to].copy_from_slice(&others[from]),
            (Self::Few(_), Self::Many(_)) | (Self::Many(_), Self::Few(_)) => {
                to.zip(from).for_each(|(to, from)| self.set(to, others.get(from)));
            }
        }
    }
}

impl FromIterator<u32> for SampleCounts {
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

/// Equal if all pixels are equal; the storage does not matter.
impl PartialEq for Film {
    fn eq(&self, other: &Self) -> bool {
        self.width == other.width
            && self.height == other.height
            && self.has_layers() == other.has_layers()
            && self.pixels().eq(other.pixels())
            && self.passes == other.passes
            && self.mattes == other.mattes
    }
}

impl Film {
    /// An empty film that keeps depth, normals, albedo and ids: every pixel is [`Pixel::EMPTY`].
    pub fn new(width: u32, height: u32) -> Self {
        let count = width as usize * height as usize;
        Self { layers: vec![Layers::EMPTY; count], ..Self::without_layers(width, height) }
    }

    /// An empty film that keeps light alone, in less than a third of the memory. Depth, normals,
    /// albedo and ids of its pixels are those of [`Pixel::EMPTY`].
    pub fn without_layers(width: u32, height: u32) -> Self {
        let count = width as usize * height as usize;
        let samples = SampleCounts::Few(vec![0; count]);
        Self::of_parts((width, height), vec![[0.0; 3]; count], Vec::new(), samples, Vec::new())
    }

    /// A film of columns. `alphas` is empty for an opaque picture, `layers` if they are not kept.
    pub(crate) fn of_parts(
        (width, height): (u32, u32),
        colors: Vec<[f32; 3]>,
        alphas: Vec<f32>,
        samples: SampleCounts,
        layers: Vec<Layers>,
    ) -> Self {
        let (passes, mattes) = (Vec::new(), Mattes::default());
        Self { width, height, colors, alphas, samples, layers, passes, mattes }
    }

    /// The film with the passes of all pixels, or none.
    pub(crate) fn with_passes(self, passes: Vec<LightPasses>) -> Self {
        Self { passes, ..self }
    }

    /// The film with the mattes of all pixels, or none.
    pub(crate) fn with_mattes(self, mattes: Mattes) -> Self {
        Self { mattes, ..self }
    }

    /// The film with room for passes and mattes.
    pub(crate) fn keeping(self, passes: bool, mattes: bool) -> Self {
        let count = self.colors.len();
        let passes = vec![LightPasses::default(); if passes { count } else { 0 }];
        let mattes = Mattes::new(if mattes { count } else { 0 });
        self.with_passes(passes).with_mattes(mattes)
    }

    /// Adds the names of ids of the mattes.
    pub(crate) fn add_matte_names<'n>(&mut self, names: impl IntoIterator<Item = (u32, &'n str)>) {
        self.mattes.add_names(names);
    }

    /// A film with layers of these pixels. Missing pixels are empty, surplus ones are ignored.
    pub fn of_pixels(width: u32, height: u32, pixels: impl IntoIterator<Item = Pixel>) -> Self {
        let mut film = Self::new(width, height);
        for (index, pixel) in (0..film.colors.len()).zip(pixels) {
            film.set_at(index, pixel);
        }
        film
    }

    /// Width in pixels.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Height in pixels.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Whether the film keeps depth, normals, albedo and ids.
    pub fn has_layers(&self) -> bool {
        self.layers.len() == self.colors.len()
    }

    /// Whether the film keeps the parts of light: [`Film::passes`].
    pub fn has_passes(&self) -> bool {
        !self.passes.is_empty()
    }

    /// Whether the film keeps mattes: [`Film::matte`].
    pub fn has_mattes(&self) -> bool {
        !self.mattes.is_empty()
    }

    /// The light of the pixel in column `x` and row `y` by the number of surfaces on its way; `None` outside the film, and
    /// if the film does not keep it.
    pub fn passes(&self, x: u32, y: u32) -> Option<LightPasses> {
        (x < self.width && y < self.height).then(|| self.passes.get(self.index(x, y)).copied())?
    }

    /// The columns of [`Film::passes`], in the order of [`Film::pixels`]; empty if the film does not keep them.
    pub fn all_passes(&self) -> &[LightPasses] {
        &self.passes
    }

    /// The things that cover the pixel in column `x` and row `y`, the largest share first, at most [`crate::MATTE_RANKS`] things. Empty
    /// outside the film, and if the film does not keep mattes. The shares of all things add up to
    /// [`Pixel::alpha`] of a transparent picture, unless there are more.
    pub fn matte(&self, level: MatteLevel, x: u32, y: u32) -> &[Coverage] {
        if x < self.width && y < self.height { self.mattes.get(self.index(x, y), level) } else { &[] }
    }

    /// The ids of the mattes of a level.
    pub(crate) fn matte_ids(&self, level: MatteLevel) -> BTreeSet<u32> {
        let pixels = 0..self.colors.len();
        pixels.flat_map(|pixel| self.mattes.get(pixel, level)).map(|coverage| coverage.id).collect()
    }

    /// The names of the ids of mattes. Those longer than a kilobyte are left out, and those beyond the first 65,536.
    pub fn matte_names(&self) -> impl ExactSizeIterator<Item = (u32, &str)> {
        self.mattes.names().iter().map(|(id, name)| (*id, name.as_str()))
    }

    /// All pixels, row by row from the top left. The columns below have the same order and length.
    pub fn pixels(&self) -> impl ExactSizeIterator<Item = Pixel> {
        (0..self.colors.len()).map(|index| self.pixel_at(index))
    }

    /// The column of [`Pixel::color`]: linear light, before exposure and tone mapping.
    /// Premultiplied by alpha for a transparent background.
    pub fn colors(&self) -> &[[f32; 3]] {
        &self.colors
    }

    /// The column of [`Pixel::alpha`], in [0, 1]. 1 in rendered pixels of an opaque picture; 0 in
    /// pixels without samples.
    pub fn alphas(&self) -> impl ExactSizeIterator<Item = f32> {
        (0..self.colors.len()).map(|index| self.alpha(index))
    }

    /// The columns of [`Film::colors`] and [`Film::alphas`] together.
    pub fn light(&self) -> impl ExactSizeIterator<Item = ([f32; 3], f32)> {
        self.colors.iter().enumerate().map(|(index, color)| (*color, self.alpha(index)))
    }

    /// The column of [`Pixel::depth`]: world units along the line of sight; infinity without a hit
    /// or without layers ([`Film::has_layers`]).
    pub fn depths(&self) -> impl ExactSizeIterator<Item = f32> {
        (0..self.colors.len()).map(|index| self.layers_at(index).depth)
    }

    /// The column of [`Pixel::normal`]: unit vectors in world space; 0 0 0 without a hit or without
    /// layers.
    pub fn normals(&self) -> impl ExactSizeIterator<Item = [f32; 3]> {
        (0..self.colors.len()).map(|index| self.layers_at(index).normal)
    }

    /// The column of [`Pixel::albedo`]: linear colours of surfaces; black without a hit or without
    /// layers.
    pub fn albedos(&self) -> impl ExactSizeIterator<Item = [f32; 3]> {
        (0..self.colors.len()).map(|index| self.layers_at(index).albedo)
    }

    /// The column of [`Pixel::id`]: instance ids; 0 without a hit or without layers.
    pub fn ids(&self) -> impl ExactSizeIterator<Item = u32> {
        (0..self.colors.len()).map(|index| self.layers_at(index).id)
    }

    /// The column of [`Pixel::samples`]: the number of samples of each pixel.
    pub fn sample_counts(&self) -> impl ExactSizeIterator<Item = u32> {
        (0..self.colors.len()).map(|index| self.samples.get(index))
    }

    fn alpha(&self, index: usize) -> f32 {
        self.alphas.get(index).copied().unwrap_or_else(|| opaque_alpha(self.samples.get(index)))
    }

    fn layers_at(&self, index: usize) -> Layers {
        self.layers.get(index).copied().unwrap_or(Layers::EMPTY)
    }

    /// The pixel in column `x` and row `y`; `None` outside the film.
    pub fn pixel(&self, x: u32, y: u32) -> Option<Pixel> {
        (x < self.width && y < self.height).then(|| self.pixel_at(self.index(x, y)))
    }

    fn pixel_at(&self, index: usize) -> Pixel {
        let Layers { depth, normal, albedo, id, instance, object } = self.layers_at(index);
        let (color, alpha, samples) = (self.colors[index], self.alpha(index), self.samples.get(index));
        Pixel { color, alpha, depth, normal, albedo, id, instance, object, samples }
    }

    /// Replaces the pixel in column `x` and row `y`.
    ///
    /// # Panics
    /// The pixel is outside the film.
    pub fn set(&mut self, x: u32, y: u32, pixel: Pixel) {
        let (width, height) = (self.width, self.height);
        assert!(x < width && y < height, "pixel {x}, {y} is outside a film of {width} x {height}");
        self.set_at(self.index(x, y), pixel);
    }

    fn set_at(&mut self, index: usize, pixel: Pixel) {
        let Pixel { color, alpha, depth, normal, albedo, id, instance, object, samples } = pixel;
        if alpha != opaque_alpha(samples) {
            self.store_alphas();
        }
        self.colors[index] = color;
        self.samples.set(index, samples);
        if let Some(to) = self.alphas.get_mut(index) {
            *to = alpha;
        }
        if let Some(layers) = self.layers.get_mut(index) {
            *layers = Layers { depth, normal, albedo, id, instance, object };
        }
    }

    /// Copies a tile out of the picture.
    ///
    /// # Panics
    /// The tile is not inside the film.
    pub fn tile(&self, tile: &Tile) -> Self {
        self.assert_contains(tile);
        let (width, height) = tile.size();
        let mut of_tile = Self { width, height, ..Self::without_layers(0, 0) };
        for y in tile.y.clone() {
            let row = self.index(tile.x.start, y)..self.index(tile.x.end, y);
            of_tile.colors.extend_from_slice(&self.colors[row.clone()]);
            of_tile.alphas.extend_from_slice(self.alphas.get(row.clone()).unwrap_or_default());
            of_tile.layers.extend_from_slice(self.layers.get(row.clone()).unwrap_or_default());
            of_tile.passes.extend_from_slice(self.passes.get(row).unwrap_or_default());
        }
        if self.has_mattes() {
            of_tile.mattes = Mattes::new(tile.pixel_count());
            for (to, (x, y)) in tile.pixels().enumerate() {
                of_tile.mattes.copy(to, &self.mattes, self.index(x, y));
            }
            of_tile.mattes.add_names(self.matte_names());
        }
        let rows = tile.y.clone().flat_map(|y| self.index(tile.x.start, y)..self.index(tile.x.end, y));
        of_tile.samples = rows.map(|index| self.samples.get(index)).collect();
        of_tile
    }

    /// Copies the pixels of a tile into the picture, with the layers that both films keep.
    ///
    /// # Panics
    /// The tile is not inside the film, or `pixels` has another size than the tile.
    pub fn set_tile(&mut self, tile: &Tile, pixels: &Self) {
        self.assert_contains(tile);
        assert_eq!((pixels.width, pixels.height), tile.size(), "the pixels are those of another tile");
        let width = tile.x.len();
        if !pixels.alphas.is_empty() {
            self.store_alphas();
        }
        for (row, y) in tile.y.clone().enumerate() {
            let (to, from) = (self.index(tile.x.start, y), row * width);
            let (to, from) = (to..to + width, from..from + width);
            self.colors[to.clone()].copy_from_slice(&pixels.colors[from.clone()]);
            self.samples.set_row(to.clone(), &pixels.samples, from.clone());
            if let Some(to) = self.alphas.get_mut(to.clone()) {
                to.iter_mut().zip(from.clone()).for_each(|(to, from)| *to = pixels.alpha(from));
            }
            if let (Some(to), Some(from)) = (self.layers.get_mut(to.clone()), pixels.layers.get(from.clone()))
            {
                to.copy_from_slice(from);
            }
            if let (Some(to), Some(from)) = (self.passes.get_mut(to.clone()), pixels.passes.get(from.clone()))
            {
                to.copy_from_slice(from);
            }
            if self.has_mattes() {
                to.zip(from).for_each(|(to, from)| self.mattes.copy(to, &pixels.mattes, from));
            }
        }
        if self.has_mattes() {
            self.mattes.add_names(pixels.matte_names());
        }
    }

    fn assert_contains(&self, tile: &Tile) {
        let (width, height) = (self.width, self.height);
        let is_inside = tile.x.end <= width && tile.y.end <= height;
        assert!(is_inside, "the tile {tile:?} is not inside a film of {width} x {height}");
    }

    /// Gives each pixel its own alpha.
    fn store_alphas(&mut self) {
        if self.alphas.is_empty() {
            self.alphas = (0..self.colors.len()).map(|index| self.alpha(index)).collect();
        }
    }

    fn index(&self, x: u32, y: u32) -> usize {
        y as usize * self.width as usize + x as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_copy_the_layers_that_both_films_keep() {
        let tile = Tile { x: 1..3, y: 1..2 };
        let pixel = |id| Pixel { color: [1.0, 2.0, id as f32], alpha: 1.0, id, samples: 4, ..Pixel::EMPTY };
        let with = Film::of_pixels(2, 1, [pixel(7), pixel(8)]);
        let mut without = Film::without_layers(2, 1);
        (0..2).for_each(|x| without.set(x, 0, pixel(7 + x)));
        for part in [&with, &without] {
            for mut film in [Film::new(4, 3), Film::without_layers(4, 3)] {
                let has_layers = film.has_layers();
                film.set_tile(&tile, part);
                let id = if has_layers && part.has_layers() { 8 } else { 0 };
                assert_eq!(film.pixel(2, 1).unwrap(), Pixel { id, ..pixel(8) });
                assert_eq!(film.pixels().filter(|pixel| *pixel != Pixel::EMPTY).count(), 2);
                assert_eq!(film.tile(&tile).has_layers(), has_layers);
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
            let kept: SampleCounts = counts.into_iter().collect();
            assert!((0..3).all(|index| kept.get(index) == counts[index]));
        }
    }

    #[test]
    fn pixels_outside_the_film_are_none_and_columns_have_the_values_of_pixels() {
        let pixel = |id: u32| Pixel {
            color: [id as f32, 1.0, 2.0],
            alpha: 1.0 / id as f32,
            depth: id as f32,
            normal: [0.0, id as f32, 0.0],
            albedo: [0.0, 0.0, id as f32],
            id,
            instance: 2 * id,
            object: 3 * id,
            samples: 100 * id,
        };
        let film = Film::of_pixels(4, 3, (1..=12).map(pixel));
        assert_eq!(film.pixel(3, 2), Some(pixel(12)));
        for (x, y) in [(4, 0), (0, 3), (u32::MAX, 0), (0, u32::MAX), (u32::MAX, u32::MAX)] {
            assert_eq!(film.pixel(x, y), None);
        }
        assert!(film.colors().iter().copied().eq((1..=12).map(|id| pixel(id).color)));
        assert!(film.alphas().eq((1..=12).map(|id| pixel(id).alpha)));
        assert!(film.depths().eq((1..=12).map(|id| pixel(id).depth)));
        assert!(film.normals().eq((1..=12).map(|id| pixel(id).normal)));
        assert!(film.albedos().eq((1..=12).map(|id| pixel(id).albedo)));
        assert!(film.ids().eq(1..=12));
        assert!(film.sample_counts().eq((1..=12).map(|id| 100 * id)));
        let light = Film::without_layers(2, 1);
        assert!(light.depths().eq([f32::INFINITY; 2]) && light.ids().eq([0; 2]));
    }
}
