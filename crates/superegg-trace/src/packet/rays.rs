//! Rays with one origin: camera rays, and shadow rays traced from their light.

use superegg_geom::Ray;
use superegg_geom::glam::DVec3;
use superegg_geom::kernels::packet::{ALL_LANES, PACKET, PacketColumn, PacketVectors64};
use superegg_simd::{Simd, WithSimd};

use superegg_simd::bits;

/// A mask of the first lanes of a packet. `count` is at least 1.
pub fn first_lanes(count: usize) -> u32 {
    ALL_LANES >> (PACKET - count)
}

/// The direction in one lane of a packet.
pub fn direction(packet: &PacketVectors64, lane: usize) -> DVec3 {
    DVec3::from_array(packet.each_ref().map(|column| column.0[lane]))
}

/// Rays with one origin, sixteen to a packet.
#[derive(Clone, Debug, Default)]
pub struct PacketRays {
    /// The origin of all rays.
    pub origin: DVec3,
    directions: Vec<PacketVectors64>,
    count: usize,
}

impl PacketRays {
    /// Removes the rays and sets the origin of those to come.
    pub fn start(&mut self, origin: DVec3) {
        self.origin = origin;
        self.directions.clear();
        self.count = 0;
    }

    /// Adds a ray by its direction, of any length.
    #[inline]
    pub fn push(&mut self, direction: DVec3) {
        let lane = self.count % PACKET;
        if lane == 0 {
            self.directions.push([PacketColumn::splat(f64::NAN); 3]);
        }
        if let Some(packet) = self.directions.last_mut() {
            for axis in 0..3 {
                packet[axis].0[lane] = direction[axis];
            }
        }
        self.count += 1;
    }

    /// Adds the rays of a packet in the `lanes` of a mask.
    pub fn extend(&mut self, packet: &PacketVectors64, lanes: u32) {
        if lanes == ALL_LANES && self.count.is_multiple_of(PACKET) {
            self.directions.push(*packet);
            self.count += PACKET;
        } else {
            bits(lanes).for_each(|lane| self.push(direction(packet, lane)));
        }
    }

    /// The number of rays.
    pub fn count(&self) -> usize {
        self.count
    }

    /// The directions by packets. Unused lanes of the last packet are NaN.
    pub fn directions(&self) -> &[PacketVectors64] {
        &self.directions
    }

    /// The direction of a ray.
    pub fn direction(&self, ray: usize) -> DVec3 {
        direction(&self.directions[ray / PACKET], ray % PACKET)
    }

    /// A ray.
    pub fn ray(&self, ray: usize) -> Ray {
        Ray::new(self.origin, self.direction(ray))
    }

    /// A mask of the lanes of a packet that hold a ray.
    pub fn lanes(&self, packet: usize) -> u32 {
        first_lanes(PACKET.min(self.count - packet * PACKET))
    }
}

/// The directions from a point to points on the rays of a packet: `offset + t * direction`.
pub struct DirectionsFrom<'a> {
    /// The directions of the rays.
    pub rays: &'a PacketVectors64,
    /// The points, by their t divided by `t_scale`.
    pub t: &'a PacketColumn<f32>,
    /// Converts `t` to the rays' own.
    pub t_scale: f64,
    /// From the point to the rays' origin.
    pub offset: DVec3,
}

impl WithSimd for DirectionsFrom<'_> {
    type Output = PacketVectors64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> PacketVectors64 {
        let Self { rays, t, t_scale, offset } = self;
        // Plain loops, which the compiler vectorises.
        let t: [f64; PACKET] = std::array::from_fn(|lane| f64::from(t.0[lane]) * t_scale);
        let mut directions = *rays;
        for (axis, column) in directions.iter_mut().enumerate() {
            column.0.iter_mut().zip(&t).for_each(|(part, t)| *part = offset[axis] + t * *part);
        }
        directions
    }
}

#[cfg(test)]
mod tests {
    use superegg_simd::Column;

    use super::*;

    #[test]
    fn packets_and_single_rays_are_added_alike() {
        let packet: PacketVectors64 =
            [0.0, 0.25, 0.5].map(|part| Column(std::array::from_fn(|lane| lane as f64 + part)));
        let (mut one_by_one, mut by_packets) = (PacketRays::default(), PacketRays::default());
        for lanes in [0xffff, 0, 0x8001, 0xffff, 0x7ffe, 1, 0xfff, 0xffff, 0xaaaa] {
            by_packets.extend(&packet, lanes);
            for lane in bits(lanes) {
                one_by_one.push(direction(&packet, lane));
            }
            assert_eq!(format!("{one_by_one:?}"), format!("{by_packets:?}"));
        }
    }

    #[test]
    fn directions_from_another_point_lead_to_the_same_points() {
        let rays: PacketVectors64 =
            [1.0, -0.5, 0.25].map(|part| Column(std::array::from_fn(|lane| part + lane as f64)));
        let t = Column(std::array::from_fn(|lane| 0.5 * lane as f32));
        let offset = DVec3::new(3.0, 5.0, -7.0);
        let found =
            superegg_simd::Arch::new().dispatch(DirectionsFrom { rays: &rays, t: &t, t_scale: 2.0, offset });
        for lane in 0..PACKET {
            assert_eq!(direction(&found, lane), offset + lane as f64 * direction(&rays, lane));
        }
    }

    #[test]
    fn rays_come_out_as_they_went_in_and_unused_lanes_are_nan() {
        let mut rays = PacketRays::default();
        for count in [40usize, 16, 3] {
            rays.start(DVec3::X);
            let direction = |i: usize| DVec3::new(i as f64, -(i as f64), 0.5);
            (0..count).for_each(|i| rays.push(direction(i)));
            assert!((0..count).all(|i| rays.ray(i) == Ray::new(DVec3::X, direction(i))));
            assert_eq!((rays.count(), rays.directions().len()), (count, count.div_ceil(PACKET)));
            let lanes: u32 = (0..rays.directions().len()).map(|i| rays.lanes(i).count_ones()).sum();
            assert_eq!(lanes as usize, count);
            let unused = rays.directions().iter().flat_map(|packet| packet[2].0);
            assert_eq!(unused.filter(|x| x.is_nan()).count(), count.next_multiple_of(PACKET) - count);
        }
    }
}
