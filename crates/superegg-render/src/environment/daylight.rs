//! The light of sun and sky by the formulas of Preetham, Shirley and Smits (1999), as a picture of the surroundings.
//!
//! The unit is 32 kcd/m^2, the luminance of white paper in the sun: a white floor at noon is about 1. The sky has the
//! distribution of Perez with the coefficients of the paper; below the horizon the surroundings are a dim ground. The sun
//! is 0.53 degrees wide, and as bright as air of the turbidity lets it through.

use std::f64::consts::PI;
use std::sync::Arc;

use superegg_geom::glam::{DMat3, DVec2, DVec3};
use superegg_scene::Daylight;

use crate::environment::map::{EnvironmentMap, EnvironmentPixels};

const WIDTH: usize = 1024;
const HEIGHT: usize = 512;
/// The luminance that counts as 1, in kcd/m^2.
const UNIT: f64 = 32.0;
/// The illuminance of the sun outside of the air, in klx.
const SUN_OUTSIDE: f64 = 128.0;
/// Half of the angle at which the sun is seen, in radians.
const SUN_RADIUS: f64 = 0.265 * PI / 180.0;
/// The part of the light that the ground reflects.
const GROUND: f64 = 0.2;

/// The distribution of one quantity over the sky, relative to the zenith: Perez et al. (1993).
struct Perez {
    coefficients: [f64; 5],
    zenith: f64,
    /// The value of the formula at the zenith.
    at_zenith: f64,
}

impl Perez {
    fn new(coefficients: [f64; 5], zenith: f64, sun_angle: f64) -> Self {
        let mut perez = Self { coefficients, zenith, at_zenith: 1.0 };
        perez.at_zenith = perez.formula(1.0, sun_angle);
        perez
    }

    fn formula(&self, cos: f64, to_sun: f64) -> f64 {
        let [a, b, c, d, e] = self.coefficients;
        (1.0 + a * (b / cos).exp()) * (1.0 + c * (d * to_sun).exp() + e * to_sun.cos().powi(2))
    }

    /// The value in a direction, by the cosine of its angle to the zenith and its angle to the sun.
    fn at(&self, cos: f64, to_sun: f64) -> f64 {
        self.zenith * self.formula(cos, to_sun) / self.at_zenith
    }
}

/// The luminance and the chromaticity of the sky.
struct PreethamSky {
    luminance: Perez,
    x: Perez,
    y: Perez,
}

impl PreethamSky {
    fn new(turbidity: f64, sun_angle: f64) -> Self {
        let t = turbidity;
        let line = |pairs: [[f64; 2]; 5]| pairs.map(|[slope, offset]| slope * t + offset);
        let chi = (4.0 / 9.0 - t / 120.0) * (PI - 2.0 * sun_angle);
        let zenith = (4.0453 * t - 4.9710) * chi.tan() - 0.2155 * t + 2.4192;
        let angles = [sun_angle.powi(3), sun_angle.powi(2), sun_angle, 1.0];
        let chromaticity = |rows: [[f64; 4]; 3]| {
            let sums = rows.map(|row| row.iter().zip(angles).map(|(a, b)| a * b).sum::<f64>());
            sums[0] * t * t + sums[1] * t + sums[2]
        };
        let zenith_x = chromaticity([
            [0.00166, -0.00375, 0.00209, 0.0],
            [-0.02903, 0.06377, -0.03202, 0.00394],
            [0.11693, -0.21196, 0.06052, 0.25886],
        ]);
        let zenith_y = chromaticity([
            [0.00275, -0.00610, 0.00317, 0.0],
            [-0.04214, 0.08970, -0.04153, 0.00516],
            [0.15346, -0.26756, 0.06670, 0.26688],
        ]);
        let of_luminance =
            [[0.1787, -1.4630], [-0.3554, 0.4275], [-0.0227, 5.3251], [0.1206, -2.5771], [-0.0670, 0.3703]];
        let of_x =
            [[-0.0193, -0.2592], [-0.0665, 0.0008], [-0.0004, 0.2125], [-0.0641, -0.8989], [-0.0033, 0.0452]];
        let of_y =
            [[-0.0167, -0.2608], [-0.0950, 0.0092], [-0.0079, 0.2102], [-0.0441, -1.6537], [-0.0109, 0.0529]];
        Self {
            luminance: Perez::new(line(of_luminance), zenith.max(0.01), sun_angle),
            x: Perez::new(line(of_x), zenith_x, sun_angle),
            y: Perez::new(line(of_y), zenith_y, sun_angle),
        }
    }

    /// The linear colour in a direction above the horizon.
    fn color(&self, cos: f64, to_sun: f64) -> DVec3 {
        let luminance = self.luminance.at(cos, to_sun).max(0.0) / UNIT;
        let (x, y) = (self.x.at(cos, to_sun), self.y.at(cos, to_sun).max(1e-3));
        let xyz = DVec3::new(x / y, 1.0, (1.0 - x - y) / y) * luminance;
        rgb_of_xyz(xyz).max(DVec3::ZERO)
    }
}

/// CIE XYZ to linear sRGB.
fn rgb_of_xyz(xyz: DVec3) -> DVec3 {
    let columns = [[3.2406, -0.9689, 0.0557], [-1.5372, 1.8758, -0.2040], [-0.4986, 0.0415, 1.0570]];
    DMat3::from_cols_array_2d(&columns) * xyz
}

/// The part of the sun's light that reaches the ground at wavelengths of red, green and blue: molecules scatter it
/// (Rayleigh), and dust by the turbidity (Angstrom).
fn through_air(sun_angle: f64, turbidity: f64) -> DVec3 {
    let degrees = sun_angle.to_degrees().min(90.0);
    let mass = (degrees.to_radians().cos() + 0.15 * (93.885 - degrees).powf(-1.253)).recip();
    let dust = (0.04608 * turbidity - 0.04586).max(0.0);
    // In micrometres.
    DVec3::new(0.61, 0.55, 0.465).map(|wavelength: f64| {
        (-mass * (0.008735 * wavelength.powf(-4.08) + dust * wavelength.powf(-1.3))).exp()
    })
}

impl EnvironmentMap {
    /// The light of sun and sky.
    pub fn of_daylight(daylight: &Daylight, up: DVec3) -> Self {
        Self::new(Arc::new(daylight_pixels(daylight)), up, daylight.azimuth_deg, 1.0)
    }
}

/// The picture of sun and sky. The sun is in its middle column.
fn daylight_pixels(daylight: &Daylight) -> EnvironmentPixels {
    let sun_angle = (90.0 - daylight.elevation_deg).clamp(0.0, 90.0).to_radians();
    let sun = DVec3::new(sun_angle.sin(), 0.0, sun_angle.cos());
    let sky = PreethamSky::new(daylight.turbidity, sun_angle);
    let illuminance = SUN_OUTSIDE / UNIT * through_air(sun_angle, daylight.turbidity);
    // The light of the sun and of the zenith that the ground scatters.
    let ground = GROUND * (illuminance * sun.z / PI + sky.color(1.0, sun_angle));
    let mut colors = Vec::with_capacity(WIDTH * HEIGHT);
    // The part of each pixel that the sun covers is found on a finer grid, and its light kept whole.
    let mut covered = Vec::new();
    for row in 0..HEIGHT {
        for column in 0..WIDTH {
            let direction = |offset: DVec2| {
                let angle = PI * (row as f64 + offset.y) / HEIGHT as f64;
                let around = 2.0 * PI * ((column as f64 + offset.x) / WIDTH as f64 - 0.5);
                DVec3::new(angle.sin() * around.cos(), angle.sin() * around.sin(), angle.cos())
            };
            let middle = direction(DVec2::splat(0.5));
            let to_sun = middle.dot(sun).clamp(-1.0, 1.0).acos();
            if to_sun < SUN_RADIUS + 2.0 * PI / HEIGHT as f64 {
                let fine =
                    (0..256).map(|i| DVec2::new(f64::from(i % 16) + 0.5, f64::from(i / 16) + 0.5) / 16.0);
                let inside = fine.filter(|offset| direction(*offset).dot(sun) > SUN_RADIUS.cos()).count();
                let solid_angle = middle.z.acos().sin() * 2.0 * (PI / HEIGHT as f64) * (PI / WIDTH as f64);
                covered.push((colors.len(), inside as f64, solid_angle));
            }
            let color = if middle.z > 0.0 { sky.color(middle.z.max(0.01), to_sun) } else { ground };
            colors.push(color.as_vec3().to_array());
        }
    }
    let total: f64 = covered.iter().map(|(_, inside, solid_angle)| inside * solid_angle).sum();
    for (index, inside, _) in covered {
        if total > 0.0 {
            let light = illuminance * (inside / total);
            colors[index] = (DVec3::from_array(colors[index].map(f64::from)) + light).as_vec3().to_array();
        }
    }
    // The size is that of the constants.
    EnvironmentPixels::new(WIDTH, HEIGHT, colors).unwrap_or_else(|| unreachable!())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::sobol::{cosine_direction, sobol};

    /// The light on a level plane, as a colour of a white surface.
    fn on_ground(elevation_deg: f64, turbidity: f64) -> (DVec3, DVec3) {
        let map =
            EnvironmentMap::of_daylight(&Daylight { elevation_deg, turbidity, azimuth_deg: 20.0 }, DVec3::Z);
        let count = 1 << 15;
        let mut all = DVec3::ZERO;
        let mut sky = DVec3::ZERO;
        for i in 0..count {
            let sample = map.sample(sobol(i, 1)).unwrap();
            all += sample.direction.z.max(0.0) * sample.radiance / (PI * sample.density * f64::from(count));
            let direction = cosine_direction(sobol(i, 2), DVec3::Z);
            sky += map.radiance(direction).min(DVec3::splat(10.0)) / f64::from(count);
        }
        (all, sky)
    }

    #[test]
    fn white_paper_in_the_sun_is_white_and_the_sky_is_blue() {
        let (noon, sky) = on_ground(60.0, 3.0);
        assert!(noon.min_element() > 0.5 && noon.max_element() < 1.5, "{noon}");
        assert!(sky.z > 1.2 * sky.x && sky.y < 0.4 * noon.y, "{sky}");
        let (evening, _) = on_ground(5.0, 3.0);
        assert!(evening.y < 0.3 * noon.y && evening.y > 0.0, "{evening}");
        // The sun reddens as it sinks, and dust dims it.
        let colour = |angle: f64| through_air(angle.to_radians(), 3.0);
        assert!(colour(85.0).x / colour(85.0).z > 2.0 * colour(20.0).x / colour(20.0).z);
        assert!(through_air(0.5, 8.0).y < 0.8 * through_air(0.5, 2.0).y);
    }

    #[test]
    fn every_sun_gives_light_that_is_finite() {
        for elevation_deg in [0.0, 0.1, 10.0, 89.9, 90.0] {
            for turbidity in [1.7, 2.0, 6.0, 10.0] {
                let (all, sky) = on_ground(elevation_deg, turbidity);
                assert!(
                    all.is_finite() && sky.is_finite() && all.y > 0.0,
                    "{elevation_deg} {turbidity} {all}"
                );
            }
        }
    }
}
