//! Tensor fields: VTK's tensors on points and lattices, and Teem's NRRD.

#![allow(clippy::print_stderr, reason = "a test that is skipped says so")]

use std::io::{Cursor, Write as _};
use std::path::PathBuf;

use flate2::Compression;
use flate2::write::GzEncoder;
use superegg_exchange::read::{Content, Format, Import, Particles, ReadError, ReadOptions, open};
use superegg_geom::glam::{DMat3, DVec3};

fn import(bytes: &[u8]) -> Result<(Format, Import), ReadError> {
    let options = ReadOptions::default();
    let mut source = open(Cursor::new(bytes), &options)?;
    let import = source.read(0, &options)?;
    Ok((source.format(), import))
}

fn particles(import: Import) -> Particles {
    match import.content {
        Content::Particles(particles) => particles,
        _ => panic!("particles are expected"),
    }
}

/// The tensor of a glyph, in units of its greatest number.
fn tensor_of(particles: &Particles, row: usize) -> DMat3 {
    let rotation = DMat3::from_quat(particles.rotations[row]);
    let radii = particles.radii[row] / particles.radii[row].max_element();
    rotation * DMat3::from_diagonal(radii) * rotation.transpose()
}

const HEADER: &str = "type: float\ndimension: 4\nsizes: 7 2 1 1\nendian: little\n";
const NUMBERS: [f32; 14] = [1.0, 3.0, 0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 2.0, 1.0, 0.0, 2.0, 0.0, 1.0];

fn assert_two_rods(particles: &Particles) {
    assert_eq!(particles.len(), 2);
    // Both tensors have the eigenvalues 3 1 1: cl = 2/5, cp = 0.
    for row in 0..2 {
        assert!(
            particles.radii[row].abs_diff_eq(DVec3::new(1.0, 1.0, 3.0) / 6.0, 1e-12),
            "{:?}",
            particles.radii
        );
        let [e, n] = particles.exponents[row];
        assert!((e - 1.0).abs() < 1e-12 && (n - 0.216).abs() < 1e-12, "{e} {n}");
    }
    let along = |row: usize| particles.rotations[row] * DVec3::Z;
    assert!((along(0).dot(DVec3::X).abs() - 1.0).abs() < 1e-12);
    assert!((along(1).dot(DVec3::new(1.0, 1.0, 0.0).normalize()).abs() - 1.0).abs() < 1e-12);
    assert_eq!(particles.positions, [DVec3::ZERO, DVec3::X]);
}

#[test]
fn the_file_of_teem_has_two_rods() {
    let folder = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/exchange"));
    let path = folder.join("tensors/teem_tensors_7x2x1x1.nrrd");
    let Ok(bytes) = std::fs::read(&path) else {
        eprintln!("skipped: {} is missing", path.display());
        return;
    };
    let (format, import) = import(&bytes).unwrap();
    assert_eq!((format, import.warnings.len()), (Format::TeemNrrd, 0));
    assert!(import.reading.contains("largest glyph fits the spacing 1"), "{}", import.reading);
    assert_two_rods(&particles(import));
}

fn nrrd(header: &str, data: &[u8]) -> Vec<u8> {
    [b"NRRD0005\n# a comment\n", header.as_bytes(), b"\n", data].concat()
}

fn raw() -> Vec<u8> {
    NUMBERS.iter().flat_map(|number| number.to_le_bytes()).collect()
}

fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

#[test]
fn encodings_read_alike() {
    let text = NUMBERS.map(|number| number.to_string()).join(" ");
    let big: Vec<u8> = NUMBERS.iter().flat_map(|number| f64::from(*number).to_be_bytes()).collect();
    let doubles = HEADER.replace("float", "double").replace("little", "big");
    for file in [
        nrrd(&format!("{HEADER}encoding: raw\n"), &raw()),
        nrrd(&format!("{HEADER}encoding: ascii\nkey:=value\n"), text.as_bytes()),
        nrrd(&format!("{HEADER}encoding: gzip\n"), &gzip(&raw())),
        nrrd(&format!("{doubles}encoding: raw\n"), &big),
        nrrd(
            &format!("{HEADER}encoding: raw\nbyte skip: 3\nline skip: 1\n"),
            &[b"line\nabc", &raw()[..]].concat(),
        ),
        nrrd(&format!("{HEADER}encoding: raw\nbyte skip: -1\n"), &[b"anything", &raw()[..]].concat()),
        nrrd(&format!("{HEADER}encoding: gz\nbyteskip: 2\n"), &gzip(&[b"ab", &raw()[..]].concat())),
    ] {
        let (format, import) =
            import(&file).unwrap_or_else(|error| panic!("{}: {error}", String::from_utf8_lossy(&file)));
        assert_eq!(format, Format::TeemNrrd);
        assert_two_rods(&particles(import));
    }
}

#[test]
fn space_frame_and_confidence_count() {
    let header = "type: float\ndimension: 4\nsizes: 7 2 1 1\nendian: little\nencoding: raw\nspace dimension: 3\n\
        space directions: none (0,2,0) (3,0,0) (0,0,4)\nspace origin: (10,20,30)\n\
        measurement frame: (0,1,0) (-1,0,0) (0,0,1)\nkinds: 3D-masked-symmetric-matrix space space space\n";
    let found = particles(import(&nrrd(header, &raw())).unwrap().1);
    assert_eq!(found.positions, [DVec3::new(10.0, 20.0, 30.0), DVec3::new(10.0, 22.0, 30.0)]);
    // The frame turns x to y; the spacing is 2.
    assert!(((found.rotations[0] * DVec3::Z).dot(DVec3::Y).abs() - 1.0).abs() < 1e-12);
    assert!((found.radii[0].max_element() - 1.0).abs() < 1e-12);
    let mut numbers = NUMBERS;
    numbers[0] = 0.49;
    let bytes: Vec<u8> = numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
    let import = import(&nrrd(&format!("{HEADER}encoding: raw\n"), &bytes)).unwrap().1;
    assert!(import.warnings[0].contains("1 tensors have a confidence below 0.5"), "{:?}", import.warnings);
    assert_eq!(particles(import).positions, [DVec3::X]);
    let spaced = format!("{HEADER}encoding: raw\nspacings: nan 0.5 1 1\naxis mins: nan 4 -1 nan\n");
    let found = particles(self::import(&nrrd(&spaced, &raw())).unwrap().1);
    assert_eq!(found.positions, [DVec3::new(4.0, -1.0, 0.0), DVec3::new(4.5, -1.0, 0.0)]);
}

#[test]
fn wrong_headers_are_errors() {
    for (change, reason) in [
        (("encoding: raw", "encoding: hex"), "'encoding': expected raw, ascii or gzip"),
        (("encoding: raw", "encoding: raw\ndata file: a.raw"), "other files"),
        (("encoding: raw", ""), "'encoding'"),
        (("type: float", "type: block"), "'block'"),
        (("endian: little\n", ""), "'endian' is missing"),
        (("sizes: 7 2 1 1", "sizes: 3 2 1 1"), "no tensors"),
        (("sizes: 7 2 1 1", "sizes: 7 2 1"), "expected 4 sizes"),
        (("sizes: 7 2 1 1", "sizes: 7 2 0 1"), "sizes above 0"),
        (("sizes: 7 2 1 1", "sizes: 7 9000000000000000000 9 9"), "too large"),
        (("sizes: 7 2 1 1", "sizes: 7 2 1 1000000"), "expected 56000000 bytes, found 56"),
        (("dimension: 4", "dimension: 5\nsizes: 7 2 1 1 1"), "expected 5 sizes"),
        (("dimension: 4", "dimension four"), "line 4"),
        (("type: float", "space directions: (1,0) none"), "three numbers"),
    ] {
        let header = format!("{HEADER}encoding: raw\n").replacen(change.0, change.1, 1);
        let error = import(&nrrd(&header, &raw())).unwrap_err().to_string();
        assert!(error.contains(reason), "{change:?}: {error}");
    }
}

#[test]
fn truncated_files_and_bombs_are_errors() {
    for file in [
        nrrd(&format!("{HEADER}encoding: raw\n"), &raw()),
        nrrd(&format!("{HEADER}encoding: gzip\n"), &gzip(&raw())),
        nrrd(
            &format!("{HEADER}encoding: ascii\n"),
            NUMBERS.map(|number| format!("{number:.3}")).join(" ").as_bytes(),
        ),
    ] {
        assert!(import(&file).is_ok());
        for end in 0..file.len() {
            // The checksum at the end of gzip data may be cut off, and digits of the last number.
            assert!(import(&file[..end]).is_err() || file.len() - end <= 8, "{end} of {}", file.len());
        }
        for at in 0..file.len() {
            let mut damaged = file.clone();
            damaged[at] ^= 0x15;
            let _ = import(&damaged);
        }
    }
    let zeros = gzip(&vec![0; 28 << 20]);
    let header = "type: uchar\ndimension: 4\nsizes: 7 1024 1024 100\nencoding: gzip\n";
    let error = import(&nrrd(header, &zeros)).unwrap_err().to_string();
    assert!(error.contains("bytes in memory"), "{error}");
}

/// A lattice of 3 x 2 x 1 tensors in six or nine numbers, on an image with turned axes.
fn image(components: usize, direction: &str) -> Vec<u8> {
    let mut numbers = String::new();
    for at in 0..6 {
        let (a, b) = (f64::from(at) + 1.0, 0.25 * f64::from(at));
        numbers += &match components {
            6 => format!("{a} 2 1 {b} 0 0 "),
            _ => format!("{a} {b} 0 {b} 2 0 0 0 1 "),
        };
    }
    format!(
        "<VTKFile type=\"ImageData\"><ImageData WholeExtent=\"0 2 0 1 0 0\" Origin=\"1 2 3\" Spacing=\"0.5 2 9\" {direction}>\
         <Piece Extent=\"0 2 0 1 0 0\"><PointData Tensors=\"D\"><DataArray Name=\"other\" type=\"Float64\" \
         NumberOfComponents=\"9\">{}</DataArray><DataArray Name=\"D\" type=\"Float64\" NumberOfComponents=\"{components}\">\
         {numbers}</DataArray></PointData></Piece></ImageData></VTKFile>",
        "0 ".repeat(54)
    )
    .into_bytes()
}

#[test]
fn an_image_has_a_glyph_at_each_point() {
    for components in [6, 9] {
        let (format, import) = import(&image(components, "")).unwrap();
        assert_eq!(format, Format::VtkTensors);
        assert!(
            import.reading.contains("tensors 'D'") && import.reading.contains("spacing 0.5"),
            "{}",
            import.reading
        );
        assert!(import.warnings[0].contains("the file has other too"), "{:?}", import.warnings);
        let particles = particles(import);
        assert_eq!(particles.len(), 6);
        assert_eq!(particles.positions[4], DVec3::new(1.5, 4.0, 3.0));
        for row in 0..6 {
            let (a, b) = (row as f64 + 1.0, 0.25 * row as f64);
            let tensor = DMat3::from_cols_array(&[a, b, 0.0, b, 2.0, 0.0, 0.0, 0.0, 1.0]);
            let found = tensor_of(&particles, row);
            let scale = tensor.x_axis.x / found.x_axis.x;
            assert!((found * scale).abs_diff_eq(tensor, 1e-12), "{row} {found} {tensor}");
        }
        let widest = particles.radii.iter().map(|radii| radii.max_element()).fold(0.0, f64::max);
        assert!((widest - 0.25).abs() < 1e-15);
    }
    let turned = particles(import(&image(6, "Direction=\"0 -1 0 1 0 0 0 0 1\"")).unwrap().1);
    assert_eq!(turned.positions[1], DVec3::new(1.0, 2.5, 3.0));
    assert_eq!(turned.positions[3], DVec3::new(-1.0, 2.0, 3.0));
}

#[test]
fn extents_that_lie_are_errors() {
    for extent in [
        "0 99 0 99 0 99",
        "0 999999999 0 999999999 0 999999999",
        "5 2 0 1 0 0",
        "0 2 0 1",
        "x",
        "nan 2 0 1 0 0",
    ] {
        let file = String::from_utf8(image(6, "")).unwrap();
        let lie = file.replace("<Piece Extent=\"0 2 0 1 0 0\"", &format!("<Piece Extent=\"{extent}\""));
        assert!(import(lie.as_bytes()).is_err(), "{extent}");
    }
}

#[test]
fn legacy_lattices_and_points_have_glyphs() {
    let tensors = "3 0 0 0 1 0 0 0 1\n".repeat(4);
    let points = format!(
        "# vtk DataFile Version 3.0\nt\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS 2 2 1\nORIGIN 1 1 1\n\
         SPACING 2 3 4\nPOINT_DATA 4\nTENSORS T float\n{tensors}"
    );
    let listed = format!(
        "# vtk DataFile Version 4.2\nt\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 float\n1 1 1 3 1 1 1 4 1 3 4 1\n\
         CELLS 0 0\nCELL_TYPES 0\nPOINT_DATA 4\nFIELD FieldData 1\nT 9 4 double\n{tensors}"
    );
    let rectilinear = format!(
        "# vtk DataFile Version 3.0\nt\nASCII\nDATASET RECTILINEAR_GRID\nDIMENSIONS 2 2 1\nX_COORDINATES 2 float\n1 3\n\
         Y_COORDINATES 2 float\n1 4\nZ_COORDINATES 1 float\n1\nPOINT_DATA 4\nTENSORS T float\n{tensors}"
    );
    for file in [points, listed, rectilinear] {
        let (format, import) = import(file.as_bytes()).unwrap();
        assert_eq!(format, Format::VtkTensors);
        let particles = particles(import);
        assert_eq!(particles.positions[2], DVec3::new(1.0, 4.0, 1.0));
        assert_eq!(particles.len(), 4);
    }
}
