//! Laws that hold for every file that is read and any bytes. Shared by the fuzz target and by a plain
//! test.

use std::io::Cursor;

use superegg_exchange::read::{Content, Format, Particles, ReadOptions, open, sniff};

/// More frames take time and find nothing new.
const MOST_FRAMES: usize = 8;

/// Reads the bytes as the format that they are, and as one that their first byte chooses.
pub(crate) fn check(bytes: &[u8]) {
    let _ = sniff(bytes);
    let chosen = bytes.first().map(|byte| Format::ALL[usize::from(*byte) % Format::ALL.len()]);
    for from in [None, chosen] {
        let options = ReadOptions { from, all_extra: true, ..ReadOptions::default() };
        let Ok(mut source) = open(Cursor::new(bytes), &options) else { continue };
        for frame in 0..source.frames().len().min(MOST_FRAMES) {
            match source.read(frame, &options) {
                Ok(import) => {
                    assert!(!import.reading.contains('\n'), "{:?}", import.reading);
                    if let Content::Particles(particles) = import.content {
                        check_particles(&particles, bytes.len());
                    }
                }
                Err(error) => assert!(!error.to_string().is_empty()),
            }
        }
        assert!(source.read(source.frames().len(), &options).is_err(), "there is no such frame");
    }
}

/// Columns have one length and hold numbers that make superquadrics.
fn check_particles(particles: &Particles, bytes: usize) {
    let rows = particles.len();
    // Compressed data may hold a thousand rows a byte.
    assert!(rows <= 2000 * (bytes + 1), "{rows} rows of {bytes} bytes");
    assert!(particles.ids.is_empty() || particles.ids.len() == rows);
    assert!(particles.colors.is_empty() || particles.colors.len() == rows);
    assert_eq!([particles.radii.len(), particles.exponents.len(), particles.rotations.len()], [rows; 3]);
    assert!(particles.extra.iter().all(|(_, values)| values.len() == rows));
    assert!(particles.positions.iter().all(|position| position.is_finite()));
    assert!(particles.radii.iter().all(|radii| radii.is_finite() && radii.min_element() > 0.0));
    let is_exponent = |exponent: &f64| exponent.is_finite() && *exponent >= 0.0;
    assert!(particles.exponents.iter().flatten().all(is_exponent));
    assert!(particles.rotations.iter().all(|rotation| (rotation.length() - 1.0).abs() < 1e-4));
}
