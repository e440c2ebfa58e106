//! A picture of the surroundings, as light that is seen and sampled.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use superegg_geom::glam::{DVec2, DVec3};
use superegg_geom::unit_vector;
use twox_hash::XxHash3_128;

/// A picture of all directions, and its position.
///
/// The picture is equirectangular: its rows go from the zenith to the nadir, its columns once around. Its centre is in the
/// direction -z where y is up, y where z is up; columns go to the right from there, towards x.
#[derive(Clone, Debug)]
pub struct EnvironmentMap {
    pixels: Arc<EnvironmentPixels>,
    /// The directions of the centre, of the right side of the centre, and of the zenith.
    axes: [DVec3; 3],
    scale: f64,
}

/// The pixels of a picture of the surroundings, with the means to sample them by their brightness.
pub struct EnvironmentPixels {
    width: usize,
    height: usize,
    colors: Vec<[f32; 3]>,
    /// The sums of the weights of the pixels of each row up to and with each pixel, divided by those of the row.
    cumulative: Vec<f32>,
    /// The same for rows.
    cumulative_rows: Vec<f64>,
    /// The weight of each pixel divided by the mean.
    weights: Vec<f32>,
    fingerprint: u128,
}

impl std::fmt::Debug for EnvironmentPixels {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "EnvironmentPixels({} x {}, {:032x})", self.width, self.height, self.fingerprint)
    }
}

impl PartialEq for EnvironmentMap {
    fn eq(&self, other: &Self) -> bool {
        self.fingerprint() == other.fingerprint()
    }
}

/// A direction with light.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EnvironmentSample {
    /// A unit vector.
    pub(crate) direction: DVec3,
    pub(crate) radiance: DVec3,
    /// The probability density of the direction, for each unit of solid angle.
    pub(crate) density: f64,
}

impl EnvironmentPixels {
    /// The most pixels of a picture.
    pub const MOST_PIXELS: usize = 1 << 27;

    /// The pixels of a picture, row by row from the top. Values that are no light (negative, NaN) become 0. `None` if the
    /// number of pixels is not `width` times `height`, 0, or more than [`EnvironmentPixels::MOST_PIXELS`].
    pub fn new(width: usize, height: usize, mut colors: Vec<[f32; 3]>) -> Option<Self> {
        const BRIGHTEST: f32 = 1e12;
        let count = width.checked_mul(height).filter(|count| (1..=Self::MOST_PIXELS).contains(count))?;
        if colors.len() != count {
            return None;
        }
        for value in colors.as_flattened_mut() {
            *value = if *value > 0.0 { value.min(BRIGHTEST) } else { 0.0 };
        }
        let mut hasher = XxHash3_128::new();
        hasher.write(&(width as u64).to_le_bytes());
        colors.as_flattened().iter().for_each(|value| hasher.write(&value.to_le_bytes()));
        let fingerprint = hasher.finish_128();
        let mut pixels = Self {
            width,
            height,
            colors,
            cumulative: Vec::with_capacity(count),
            cumulative_rows: Vec::with_capacity(height),
            weights: Vec::with_capacity(count),
            fingerprint,
        };
        pixels.weigh();
        Some(pixels)
    }

    /// Sets weights and their sums. A pixel counts by its brightness and that of its neighbours, with which it is blended,
    /// and by its solid angle.
    fn weigh(&mut self) {
        let (width, height) = (self.width, self.height);
        let brightness = |x: usize, y: usize| {
            let [r, g, b] = self.colors[y * width + x].map(f64::from);
            0.2126 * r + 0.7152 * g + 0.0722 * b
        };
        let mut total = 0.0;
        for y in 0..height {
            let sin = (PI * (y as f64 + 0.5) / height as f64).sin();
            let (above, below) = (y.saturating_sub(1), (y + 1).min(height - 1));
            let mut row = 0.0;
            for x in 0..width {
                let (left, right) = ((x + width - 1) % width, (x + 1) % width);
                // The mean of the blend over the pixel.
                let across =
                    |y: usize| 0.75 * brightness(x, y) + 0.125 * (brightness(left, y) + brightness(right, y));
                let weight = sin * (0.75 * across(y) + 0.125 * (across(above) + across(below)));
                row += weight;
                self.weights.push(weight as f32);
                self.cumulative.push(row as f32);
            }
            total += row;
            self.cumulative_rows.push(total);
            if row > 0.0 {
                self.cumulative[y * width..].iter_mut().for_each(|sum| *sum = (f64::from(*sum) / row) as f32);
            }
        }
        let mean = total / (width * height) as f64;
        if total > 0.0 {
            self.weights.iter_mut().for_each(|weight| *weight = (f64::from(*weight) / mean) as f32);
            self.cumulative_rows.iter_mut().for_each(|sum| *sum /= total);
        }
    }

    /// The colour at a position, from 0 to 1 across and down, blended between the middles of pixels.
    fn color(&self, position: DVec2) -> DVec3 {
        let (width, height) = (self.width, self.height);
        let (x, y) = (position.x * width as f64 - 0.5, position.y * height as f64 - 0.5);
        let (left, top) = (x.floor(), y.floor());
        let (dx, dy) = (x - left, y - top);
        let column = |x: f64| x.rem_euclid(width as f64) as usize % width;
        let row = |y: f64| y.clamp(0.0, (height - 1) as f64) as usize;
        let at = |x: f64, y: f64| DVec3::from_array(self.colors[row(y) * width + column(x)].map(f64::from));
        let upper = at(left, top).lerp(at(left + 1.0, top), dx);
        let lower = at(left, top + 1.0).lerp(at(left + 1.0, top + 1.0), dx);
        upper.lerp(lower, dy)
    }

    /// The weight of the pixel at a position, divided by the mean.
    fn weight(&self, position: DVec2) -> f64 {
        let index = |part: f64, count: usize| ((part * count as f64) as usize).min(count - 1);
        f64::from(self.weights[index(position.y, self.height) * self.width + index(position.x, self.width)])
    }

    /// A random position by a point of the unit square, with the density [`EnvironmentPixels::weight`]; `None` for a black
    /// picture.
    fn sample(&self, square: DVec2) -> Option<DVec2> {
        let y = self.cumulative_rows.partition_point(|sum| *sum <= square.y).min(self.height - 1);
        let before = if y == 0 { 0.0 } else { self.cumulative_rows[y - 1] };
        let of_row = self.cumulative_rows[y] - before;
        let row = &self.cumulative[y * self.width..(y + 1) * self.width];
        let x = row.partition_point(|sum| f64::from(*sum) <= square.x).min(self.width - 1);
        let left = if x == 0 { 0.0 } else { f64::from(row[x - 1]) };
        let of_pixel = f64::from(row[x]) - left;
        if of_row <= 0.0 || of_pixel <= 0.0 {
            return None;
        }
        let within = |part: f64| part.clamp(0.0, 1.0);
        let (dx, dy) = (within((square.x - left) / of_pixel), within((square.y - before) / of_row));
        Some(DVec2::new((x as f64 + dx) / self.width as f64, (y as f64 + dy) / self.height as f64))
    }
}

impl EnvironmentMap {
    /// A picture of the surroundings, turned around the up direction by an angle in degrees (to the right, seen from the
    /// centre), with its values times `scale`.
    pub fn new(pixels: Arc<EnvironmentPixels>, up: DVec3, rotation_deg: f64, scale: f64) -> Self {
        let up = unit_vector(up).unwrap_or(DVec3::Y);
        // To the right is x, unless that is up.
        let right = if up.x.abs() < 0.9 { DVec3::X } else { DVec3::Y };
        let right = unit_vector(right - right.dot(up) * up).unwrap_or(DVec3::X);
        let centre = up.cross(right);
        let (sin, cos) = rotation_deg.to_radians().sin_cos();
        Self { pixels, axes: [cos * centre + sin * right, cos * right - sin * centre, up], scale }
    }

    /// A number that identifies the light.
    pub(crate) fn fingerprint(&self) -> u128 {
        let mut hasher = XxHash3_128::new();
        hasher.write(&self.pixels.fingerprint.to_le_bytes());
        let numbers = self.axes.iter().flat_map(DVec3::to_array).chain([self.scale]);
        numbers.for_each(|number| hasher.write(&number.to_bits().to_le_bytes()));
        hasher.finish_128()
    }

    /// The light from a unit direction.
    pub(crate) fn radiance(&self, direction: DVec3) -> DVec3 {
        self.scale * self.pixels.color(self.position(direction))
    }

    /// The density of [`EnvironmentMap::sample`] in a unit direction.
    pub(crate) fn density(&self, direction: DVec3) -> f64 {
        let position = self.position(direction);
        self.pixels.weight(position) / solid_angle(position)
    }

    /// A direction, by a point of the unit square; `None` for black surroundings.
    pub(crate) fn sample(&self, square: DVec2) -> Option<EnvironmentSample> {
        let position = self.pixels.sample(square)?;
        let [centre, right, up] = self.axes;
        let (sin, cos) = (PI * position.y).sin_cos();
        let around = DVec2::from_angle(TAU * (position.x - 0.5));
        let direction = (sin * (around.x * centre + around.y * right) + cos * up).normalize();
        let density = self.pixels.weight(position) / solid_angle(position);
        let radiance = self.scale * self.pixels.color(position);
        (density > 0.0 && density.is_finite()).then_some(EnvironmentSample { direction, radiance, density })
    }

    /// The position of a unit direction in the picture.
    fn position(&self, direction: DVec3) -> DVec2 {
        let [centre, right, up] = self.axes.map(|axis| axis.dot(direction));
        DVec2::new(0.5 + right.atan2(centre) / TAU, up.clamp(-1.0, 1.0).acos() / PI)
    }
}

/// The solid angle of a picture, as if all of it were like this position.
fn solid_angle(position: DVec2) -> f64 {
    TAU * PI * (PI * position.y).sin().max(1e-9)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::sobol::sobol;

    /// A picture of 16 x 8 pixels with a bright and a black spot.
    fn pixels() -> Arc<EnvironmentPixels> {
        let mut colors: Vec<[f32; 3]> = (0..128).map(|i| [0.1 + (i % 7) as f32 / 7.0, 0.5, 0.2]).collect();
        colors[3 * 16 + 11] = [500.0, 400.0, 300.0];
        colors[5 * 16 + 2] = [f32::NAN, -1.0, 0.0];
        Arc::new(EnvironmentPixels::new(16, 8, colors).unwrap())
    }

    #[test]
    fn samples_have_their_density_and_the_whole_light() {
        let map = EnvironmentMap::new(pixels(), DVec3::new(0.3, 0.2, 1.0), 37.0, 2.0);
        let count = 1 << 16;
        let (mut sampled, mut even, mut total) = (DVec3::ZERO, DVec3::ZERO, 0.0);
        for i in 0..count {
            let EnvironmentSample { direction, radiance, density } = map.sample(sobol(i, 1)).unwrap();
            assert!((map.density(direction) / density - 1.0).abs() < 1e-6);
            assert!((map.radiance(direction) - radiance).length() <= 1e-6 * radiance.length());
            sampled += direction.x * radiance / density / f64::from(count);
            let square = sobol(i, 2);
            let z = 1.0 - 2.0 * square.y;
            let direction = (DVec2::from_angle(TAU * square.x) * (1.0 - z * z).sqrt()).extend(z);
            even += 2.0 * TAU / f64::from(count) * direction.x * map.radiance(direction);
            total += 2.0 * TAU / f64::from(count) * map.density(direction);
        }
        assert!((total - 1.0).abs() < 1e-2, "{total}");
        assert!((sampled - even).length() < 1e-2 * even.length(), "{sampled} {even}");
    }

    #[test]
    fn the_centre_is_where_the_camera_looks_and_turns_to_the_right() {
        let mut colors = vec![[0.0; 3]; 64 * 32];
        colors[16 * 64 + 32] = [1.0; 3];
        let pixels = Arc::new(EnvironmentPixels::new(64, 32, colors).unwrap());
        let at = |up: DVec3, turn: f64| {
            EnvironmentMap::new(pixels.clone(), up, turn, 1.0).sample(DVec2::splat(0.5)).unwrap().direction
        };
        let near = |a: DVec3, b: DVec3| assert!((a - b).length() < 0.15, "{a} {b}");
        near(at(DVec3::Y, 0.0), DVec3::NEG_Z);
        near(at(DVec3::Y, 90.0), DVec3::X);
        near(at(DVec3::Z, 0.0), DVec3::Y);
        near(at(DVec3::Z, 90.0), DVec3::X);
        let dark = EnvironmentPixels::new(2, 1, vec![[0.0; 3]; 2]).unwrap();
        assert!(EnvironmentMap::new(Arc::new(dark), DVec3::Y, 0.0, 1.0).sample(DVec2::splat(0.5)).is_none());
        assert!(EnvironmentPixels::new(2, 2, vec![[0.0; 3]; 2]).is_none());
    }
}
