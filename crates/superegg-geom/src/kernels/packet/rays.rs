//! The size of packets, and the columns of their numbers.

use superegg_simd::Column;

/// Rays in a packet.
pub const PACKET: usize = 16;
/// The mask of all lanes of a packet.
pub const ALL_LANES: u32 = (1 << PACKET) - 1;
/// The largest number of packets that are traced together: as many as a mask has bits.
pub const MAX_PACKETS: usize = 32;

/// A number for each ray of a packet.
pub type PacketColumn<T> = Column<T, PACKET>;

/// A vector for each ray of a packet.
pub type PacketVectors = [PacketColumn<f32>; 3];

/// A vector in f64 for each ray of a packet; NaN where there is no ray.
pub type PacketVectors64 = [PacketColumn<f64>; 3];

/// A number for each packet.
pub type PerPacket = Column<f32, MAX_PACKETS>;
