//! Point clouds with normals: PLY, NumPy arrays and plain text.

use std::fmt::Write;

/// A point of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CloudPoint {
    /// The position.
    pub position: [f64; 3],
    /// The unit normal.
    pub normal: [f64; 3],
    /// The id of the instance that it belongs to: that of the instance id output of a picture.
    pub instance_id: u32,
}

/// The points as a binary PLY file, little endian: `x y z nx ny nz` as float32, which all readers
/// understand, and `instance_id` as uint32.
pub fn to_ply(points: &[CloudPoint]) -> Vec<u8> {
    let mut header = format!(
        "ply\nformat binary_little_endian 1.0\ncomment sampled by superegg\nelement vertex {}\n",
        points.len()
    );
    for name in ["x", "y", "z", "nx", "ny", "nz"] {
        let _ = writeln!(header, "property float {name}");
    }
    header.push_str("property uint instance_id\nend_header\n");
    let mut bytes = header.into_bytes();
    bytes.reserve_exact(28 * points.len());
    for point in points {
        for x in point.position.iter().chain(&point.normal) {
            bytes.extend((*x as f32).to_le_bytes());
        }
        bytes.extend(point.instance_id.to_le_bytes());
    }
    bytes
}

/// The points as a NumPy file of version 1.0: an array of float64 with a row for each point and the
/// columns x, y, z, nx, ny, nz and instance id.
pub fn to_npy(points: &[CloudPoint]) -> Vec<u8> {
    const PREFIX: usize = 10;
    let mut header = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({}, 7), }}", points.len());
    // The data begin at a multiple of 64 bytes, after a line feed.
    let padding = 63 - (PREFIX + header.len()) % 64;
    header.extend(std::iter::repeat_n(' ', padding));
    header.push('\n');
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.reserve_exact(56 * points.len());
    for point in points {
        let id = f64::from(point.instance_id);
        for x in point.position.iter().chain(&point.normal).chain([&id]) {
            bytes.extend(x.to_le_bytes());
        }
    }
    bytes
}

/// The points as text: a line `x y z nx ny nz` for each, with all digits of f64.
pub fn to_xyz(points: &[CloudPoint]) -> String {
    let mut text = String::with_capacity(100 * points.len());
    for CloudPoint { position: [x, y, z], normal: [nx, ny, nz], .. } in points {
        let _ = writeln!(text, "{x} {y} {z} {nx} {ny} {nz}");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points() -> Vec<CloudPoint> {
        let point = |i: u32| {
            let x = f64::from(i);
            CloudPoint { position: [x, -x, 0.1], normal: [0.0, 1.0, -0.5], instance_id: u32::MAX - i }
        };
        (0..3).map(point).collect()
    }

    #[test]
    fn ply_has_a_row_of_28_bytes_for_each_point() {
        let bytes = to_ply(&points());
        let marker = b"end_header\n";
        let data = 11 + bytes.windows(11).position(|window| window == marker).unwrap();
        assert!(bytes.starts_with(b"ply\nformat binary_little_endian 1.0\n"));
        assert_eq!(bytes.len() - data, 3 * 28);
        assert_eq!(bytes[data + 28..data + 32], 1f32.to_le_bytes());
        assert_eq!(bytes[data + 52..data + 56], (u32::MAX - 1).to_le_bytes());
    }

    #[test]
    fn npy_data_are_aligned_and_complete() {
        for count in [0, 1, 3] {
            let bytes = to_npy(&points()[..count]);
            let header = u16::from_le_bytes([bytes[8], bytes[9]]) as usize;
            assert_eq!((header + 10) % 64, 0);
            assert_eq!(bytes[10 + header - 1], b'\n');
            assert_eq!(bytes.len(), 10 + header + 56 * count);
        }
    }

    #[test]
    fn text_has_all_digits() {
        assert_eq!(to_xyz(&points()).lines().nth(1), Some("1 -1 0.1 0 1 -0.5"));
    }
}
