//! VTK files: the real ones of LIGGGHTS and MercuryDPM, all encodings, and hostile bytes.

#![allow(clippy::print_stderr, reason = "a test that is skipped says so")]

use std::fmt::Write as _;
use std::io::{Cursor, Write as _};
use std::path::PathBuf;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::ZlibEncoder;
use superegg_exchange::read::{Content, Format, Import, Particles, ReadError, ReadOptions, open};
use superegg_geom::glam::{DMat3, DQuat, DVec3};

fn import_with(bytes: &[u8], options: &ReadOptions) -> Result<(Format, Import), ReadError> {
    let mut source = open(Cursor::new(bytes), options)?;
    let import = source.read(0, options)?;
    Ok((source.format(), import))
}

fn import(bytes: &[u8]) -> Result<(Format, Import), ReadError> {
    import_with(bytes, &ReadOptions::default())
}

fn particles(import: Import) -> Particles {
    match import.content {
        Content::Particles(particles) => particles,
        _ => panic!("particles are expected"),
    }
}

/// A file of the folder of real files; `None`, with a message, if the folder is missing.
fn real(name: &str) -> Option<Vec<u8>> {
    let folder = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/exchange"));
    let path = folder.join(name);
    let bytes = std::fs::read(&path).ok();
    if bytes.is_none() {
        eprintln!("skipped: {} is missing", path.display());
    }
    bytes
}

/// The particles of liggghts/known_*: position, semi-axes, blockiness 1 and 2, quaternion w x y z.
fn truth(id: i64) -> (DVec3, DVec3, [f64; 2], DQuat) {
    let quaternion = |w, x, y, z| DQuat::from_xyzw(x, y, z, w);
    let half = 0.5f64.sqrt();
    match id {
        1 => (DVec3::new(-0.05, 0.0, 0.0), DVec3::new(0.01, 0.02, 0.03), [8.0, 2.0], DQuat::IDENTITY),
        2 => (
            DVec3::new(0.05, 0.0, 0.0),
            DVec3::new(0.01, 0.02, 0.03),
            [2.0, 8.0],
            quaternion(half, half, 0.0, 0.0),
        ),
        3 => (
            DVec3::new(0.0, 0.05, 0.0),
            DVec3::splat(0.01),
            [20.0, 20.0],
            quaternion(0.4972602070132743, 0.2318762426260297, 0.4637524852520595, 0.6956287278780892),
        ),
        4 => (
            DVec3::new(0.0, -0.05, 0.0123456789012),
            DVec3::new(0.01, 0.02, 0.03),
            [2.0, 2.0],
            quaternion(0.9659258262890683, 0.0, 0.0, 0.2588190451025207),
        ),
        5 => (
            DVec3::new(0.0, 0.0, 0.06),
            DVec3::new(0.012, 0.007, 0.02),
            [4.0, 6.0],
            quaternion(0.819152044288992, 0.0, -0.5735764363510462, 0.0),
        ),
        6 => (
            DVec3::new(0.0, 0.0, -0.06),
            DVec3::new(0.005, 0.025, 0.015),
            [3.0, 2.5],
            quaternion(0.3779644730092273, 0.6546536707079771, -0.6546536707079771, 0.0),
        ),
        _ => panic!("no particle has the id {id}"),
    }
}

fn assert_turns_alike(a: DQuat, b: DQuat, tolerance: f64) {
    for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
        assert!((a * axis).abs_diff_eq(b * axis, tolerance), "{a} {b}");
    }
}

fn assert_known(particles: &Particles, rotation_tolerance: f64) {
    assert_eq!(particles.ids.len(), particles.len());
    for (row, id) in particles.ids.iter().enumerate() {
        let (position, radii, [n, e], rotation) = truth(*id);
        assert!(particles.positions[row].abs_diff_eq(position, 5e-8), "{id}");
        assert_eq!(particles.radii[row], radii, "{id}");
        assert_eq!(particles.exponents[row], [2.0 / e, 2.0 / n], "{id}");
        assert_turns_alike(particles.rotations[row], rotation, rotation_tolerance);
    }
}

#[test]
fn files_of_liggghts_have_the_known_particles() {
    for (name, tolerance) in [
        ("liggghts/known_0.vtk", 1e-11),
        ("liggghts/known_0.vtp", 1e-15),
        ("liggghts/known_bin_0.vtp", 1e-15),
        ("liggghts/known_zlib_0.vtp", 1e-15),
    ] {
        let Some(bytes) = real(name) else { return };
        let (format, import) = import(&bytes).unwrap();
        assert_eq!((format, &import.warnings[..]), (Format::LiggghtsVtk, &[][..]), "{name}");
        assert!(import.reading.contains("rotation from TENSOR, row by row"), "{}", import.reading);
        let particles = particles(import);
        assert_eq!(particles.len(), 6, "{name}");
        assert_known(&particles, tolerance);
    }
    for (name, x) in [("known_100.vtk", -0.049), ("known_100.vtp", -0.049), ("known_200.vtp", -0.048)] {
        let Some(bytes) = real(&format!("liggghts/{name}")) else { return };
        let particles = particles(import(&bytes).unwrap().1);
        let row = particles.ids.iter().position(|id| *id == 1).unwrap();
        assert!((particles.positions[row].x - x).abs() < 5e-9, "{name}");
    }
}

#[test]
fn rotations_of_a_group_are_not_trusted() {
    let Some(bytes) = real("liggghts/known_sub_0.vtp") else { return };
    let import = import(&bytes).unwrap().1;
    assert_eq!(import.warnings.len(), 1);
    assert!(
        import.warnings[0].contains("TENSOR cannot be trusted: 3 ids from 1 to 6"),
        "{:?}",
        import.warnings
    );
    assert_eq!(particles(import).ids, [6, 4, 3]);
}

#[test]
fn the_box_of_a_simulation_is_refused() {
    let Some(bytes) = real("liggghts/known_boundingBox_0.vtk") else { return };
    let error = import(&bytes).unwrap_err().to_string();
    assert!(error.contains("NAME_boundingBox_N"), "{error}");
}

#[test]
fn a_mesh_is_told_by_what_it_has() {
    let Some(bytes) = real("meshes/vtk_rod.vtp") else { return };
    let error = import(&bytes).unwrap_err().to_string();
    assert!(error.contains("PolyData of 480 points with the arrays Normals, TextureCoords"), "{error}");
    let options = ReadOptions { point_radius: Some(0.01), ..ReadOptions::default() };
    let particles = particles(import_with(&bytes, &options).unwrap().1);
    assert_eq!((particles.len(), particles.radii[7]), (480, DVec3::splat(0.01)));
}

#[test]
fn mercury_has_full_widths_and_rotations_row_by_row() {
    let Some(bytes) = real("mercurydpm/tensorsTest.vtu") else { return };
    let (format, import) = import(&bytes).unwrap();
    assert_eq!((format, import.warnings.len()), (Format::MercuryVtu, 0));
    let particles = particles(import);
    assert_eq!(particles.radii, [DVec3::new(0.5, 1.0, 1.5); 4]);
    assert_eq!(particles.exponents, [[1.0; 2]; 4]);
    assert_eq!(particles.positions[3], DVec3::new(10.0, 0.0, 0.0));
    for (rotation, degrees) in particles.rotations.iter().zip([0.0f64, -45.0, -90.0, -120.0]) {
        assert_turns_alike(*rotation, DQuat::from_rotation_z(degrees.to_radians()), 1e-6);
    }
}

#[test]
fn further_columns_are_those_asked_for() {
    let Some(bytes) = real("liggghts/known_0.vtp") else { return };
    let with = |extra: &[&str], all_extra| {
        let extra = extra.iter().map(|name| (*name).to_owned()).collect();
        import_with(&bytes, &ReadOptions { extra, all_extra, ..ReadOptions::default() })
    };
    let names =
        |particles: &Particles| particles.extra.iter().map(|(name, _)| name.clone()).collect::<Vec<_>>();
    let some = particles(with(&["mass", "id"], false).unwrap().1);
    assert_eq!(names(&some), ["id", "mass"]);
    assert_eq!(some.extra[1].1[0], 0.025551410046197046);
    let all = particles(with(&[], true).unwrap().1);
    assert_eq!(names(&all)[..4], ["id", "type", "mass", "radius"]);
    assert_eq!(all.extra.len(), 7 + 9 + 2);
    let error = with(&["vx"], false).unwrap_err().to_string();
    assert!(error.contains("'vx'") && error.contains("blockiness2"), "{error}");
}

/// An array of a file that a test writes.
struct Column {
    name: &'static str,
    kind: &'static str,
    components: usize,
    values: Vec<f64>,
}

fn column(name: &'static str, kind: &'static str, components: usize, values: &[f64]) -> Column {
    Column { name, kind, components, values: values.to_vec() }
}

#[derive(Clone, Copy, PartialEq)]
enum Layout {
    Ascii,
    Inline,
    AppendedRaw,
    AppendedBase64,
}

/// Writes VTK's XML files in all encodings.
#[derive(Clone, Copy)]
struct Writer {
    layout: Layout,
    is_wide: bool,
    is_big: bool,
    is_compressed: bool,
}

impl Writer {
    fn all() -> impl Iterator<Item = Self> {
        use Layout::{AppendedBase64, AppendedRaw, Ascii, Inline};
        let choices = (0..8).map(|bits| (bits & 1 != 0, bits & 2 != 0, bits & 4 != 0));
        choices.flat_map(|(is_wide, is_big, is_compressed)| {
            [Ascii, Inline, AppendedRaw, AppendedBase64].map(|layout| Self {
                layout,
                is_wide,
                is_big,
                is_compressed,
            })
        })
    }

    fn bytes_of(&self, column: &Column) -> Vec<u8> {
        let number = |x: f64| {
            let mut bytes = match column.kind {
                "Int32" => (x as i32).to_le_bytes().to_vec(),
                "Int64" => (x as i64).to_le_bytes().to_vec(),
                "UInt8" => vec![x as u8],
                "Float32" => (x as f32).to_le_bytes().to_vec(),
                _ => x.to_le_bytes().to_vec(),
            };
            if self.is_big {
                bytes.reverse();
            }
            bytes
        };
        column.values.iter().flat_map(|x| number(*x)).collect()
    }

    fn length(&self, length: usize) -> Vec<u8> {
        let mut bytes = if self.is_wide {
            (length as u64).to_le_bytes().to_vec()
        } else {
            (length as u32).to_le_bytes().to_vec()
        };
        if self.is_big {
            bytes.reverse();
        }
        bytes
    }

    /// The header and the data of an array.
    fn encoded(&self, bytes: &[u8]) -> (Vec<u8>, Vec<u8>) {
        if !self.is_compressed {
            return (self.length(bytes.len()), bytes.to_vec());
        }
        let block = 40;
        let blocks: Vec<Vec<u8>> = bytes
            .chunks(block)
            .map(|chunk| {
                let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
                encoder.write_all(chunk).unwrap();
                encoder.finish().unwrap()
            })
            .collect();
        let lengths = [blocks.len(), block, bytes.len() % block];
        let lengths = lengths.into_iter().chain(blocks.iter().map(Vec::len));
        (lengths.flat_map(|length| self.length(length)).collect(), blocks.concat())
    }

    fn array(&self, column: &Column, appended: &mut Vec<u8>) -> String {
        let Column { name, kind, components, values } = column;
        let head = format!("<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\"");
        let (header, data) = self.encoded(&self.bytes_of(column));
        let text = |header: &[u8], data: &[u8]| {
            if self.is_compressed {
                STANDARD.encode(header) + &STANDARD.encode(data)
            } else {
                STANDARD.encode([header, data].concat())
            }
        };
        match self.layout {
            Layout::Ascii => {
                let mut text = format!("{head} format=\"ascii\">\n");
                values.iter().for_each(|x| write!(text, "{x} ").unwrap());
                text + "\n</DataArray>\n"
            }
            Layout::Inline => format!("{head} format=\"binary\">\n {}\n</DataArray>\n", text(&header, &data)),
            Layout::AppendedRaw | Layout::AppendedBase64 => {
                let offset = appended.len();
                if self.layout == Layout::AppendedRaw {
                    appended.extend([header, data].concat());
                } else {
                    appended.extend(text(&header, &data).into_bytes());
                }
                format!("{head} format=\"appended\" offset=\"{offset}\"/>\n")
            }
        }
    }

    /// A file of points, with the attributes of the data set and of its piece.
    fn file(&self, kind: &str, attributes: [&str; 2], points: &Column, arrays: &[Column]) -> Vec<u8> {
        let mut appended = Vec::new();
        let order = if self.is_big { "BigEndian" } else { "LittleEndian" };
        let header = if self.is_wide { "UInt64" } else { "UInt32" };
        let compressor = if self.is_compressed { " compressor=\"vtkZLibDataCompressor\"" } else { "" };
        let mut text = format!(
            "<?xml version=\"1.0\"?>\n<!-- by a test -->\n<VTKFile type=\"{kind}\" version=\"1.0\" byte_order=\"{order}\" \
             header_type=\"{header}\"{compressor}>\n<{kind} {}>\n<Piece {}>\n<PointData>\n",
            attributes[0], attributes[1]
        );
        for array in arrays {
            text += &self.array(array, &mut appended);
        }
        text += "</PointData>\n<CellData/>\n<Points>\n";
        text += &self.array(points, &mut appended);
        text += &format!("</Points>\n</Piece>\n</{kind}>\n");
        let mut bytes = text.into_bytes();
        if !appended.is_empty() {
            let encoding = if self.layout == Layout::AppendedRaw { "raw" } else { "base64" };
            bytes.extend(format!("<AppendedData encoding=\"{encoding}\">\n  _").into_bytes());
            bytes.extend(appended);
            bytes.extend(b"\n</AppendedData>\n");
        }
        bytes.extend(b"</VTKFile>\n");
        bytes
    }
}

/// Two particles as columns, and what must be read of them.
fn two_particles() -> (Column, Vec<Column>, Particles) {
    let turns =
        [DQuat::from_rotation_x(0.3), DQuat::from_euler(superegg_geom::glam::EulerRot::ZYX, 1.0, -0.4, 2.0)];
    let tensors: Vec<f64> =
        turns.iter().flat_map(|turn| DMat3::from_quat(*turn).transpose().to_cols_array()).collect();
    let points = column("Points", "Float64", 3, &[0.1, -0.2, 0.3, 1e-3, 7.0, -1e6]);
    let arrays = vec![
        column("id", "Int64", 1, &[2.0, 1.0]),
        column("v", "Float64", 3, &[1.0, 2.0, 3.0, 4.0, 5.0, 6.5]),
        column("shapex", "Float64", 1, &[0.1, 4.0]),
        column("shapey", "Float64", 1, &[0.2, 5.0]),
        column("shapez", "Float32", 1, &[0.25, 6.0]),
        column("TENSOR", "Float64", 9, &tensors),
        column("blockiness1", "Int32", 1, &[8.0, 2.0]),
        column("blockiness2", "UInt8", 1, &[4.0, 20.0]),
    ];
    let particles = Particles {
        ids: vec![2, 1],
        positions: vec![DVec3::new(0.1, -0.2, 0.3), DVec3::new(1e-3, 7.0, -1e6)],
        radii: vec![DVec3::new(0.1, 0.2, 0.25), DVec3::new(4.0, 5.0, 6.0)],
        exponents: vec![[0.5, 0.25], [0.1, 1.0]],
        rotations: turns.to_vec(),
        extra: vec![("vx".to_owned(), vec![1.0, 4.0]), ("vz".to_owned(), vec![3.0, 6.5])],
        ..Particles::default()
    };
    (points, arrays, particles)
}

fn velocity() -> ReadOptions {
    ReadOptions { extra: vec!["vx".to_owned(), "vz".to_owned()], ..ReadOptions::default() }
}

fn assert_same(found: &Particles, expected: &Particles) {
    for (a, b) in found.rotations.iter().zip(&expected.rotations) {
        assert_turns_alike(*a, *b, 1e-14);
    }
    let rotations = expected.rotations.clone();
    assert_eq!(&Particles { rotations, ..found.clone() }, expected);
}

#[test]
fn every_encoding_of_xml_reads_alike() {
    for writer in Writer::all() {
        for kind in ["PolyData", "UnstructuredGrid"] {
            let (points, arrays, expected) = two_particles();
            let bytes = writer.file(kind, ["", "NumberOfPoints=\"2\""], &points, &arrays);
            let (format, import) = import_with(&bytes, &velocity()).unwrap();
            assert_eq!(format, Format::LiggghtsVtk);
            assert_same(&particles(import), &expected);
        }
    }
}

#[test]
fn pieces_are_joined_and_empty_ones_skipped() {
    let piece = |count, shape: &str, points: &str| {
        format!(
            "<Piece NumberOfPoints=\"{count}\"><PointData><DataArray type=\"Float64\" Name=\"shapex\">{shape}</DataArray>\
             <DataArray type=\"Float64\" Name=\"shapey\">{shape}</DataArray><DataArray type=\"Float64\" Name=\"shapez\">{shape}\
             </DataArray></PointData><Points><DataArray type=\"Float32\" NumberOfComponents=\"3\">{points}</DataArray></Points></Piece>"
        )
    };
    let file = |pieces: &str| {
        format!("<VTKFile type=\"PolyData\"><PolyData>{pieces}</PolyData></VTKFile>").into_bytes()
    };
    let pieces = piece(0, "", "") + &piece(1, "2", "1 2 3") + &piece(2, "4 5", "0 0 0 7 8 9");
    let import_of_three = import(&file(&pieces)).unwrap().1;
    assert_eq!(import_of_three.warnings.len(), 2, "{:?}", import_of_three.warnings);
    let three = particles(import_of_three);
    assert_eq!(three.radii, [2.0, 4.0, 5.0].map(DVec3::splat));
    assert_eq!(three.positions[2], DVec3::new(7.0, 8.0, 9.0));
    let none = particles(import(&file(&piece(0, "", ""))).unwrap().1);
    assert!(none.is_empty());
}

/// A legacy file of the two particles.
fn legacy(version: &str, is_binary: bool) -> Vec<u8> {
    let (points, arrays, _) = two_particles();
    let mut bytes = format!("# vtk DataFile Version {version}\ntitle\n").into_bytes();
    bytes.extend(if is_binary { "BINARY\n" } else { "ASCII\n" }.bytes());
    let number = |bytes: &mut Vec<u8>, kind: &str, x: f64| {
        if !is_binary {
            bytes.extend(format!("{x} ").bytes());
        } else {
            match kind {
                "int" => bytes.extend((x as i32).to_be_bytes()),
                "vtktypeint64" => bytes.extend((x as i64).to_be_bytes()),
                _ => bytes.extend(x.to_be_bytes()),
            }
        }
    };
    let data = |bytes: &mut Vec<u8>, kind: &str, values: &[f64]| {
        values.iter().for_each(|x| number(bytes, kind, *x));
        bytes.push(b'\n');
    };
    bytes.extend(b"DATASET POLYDATA\nFIELD FieldData 1\nTIME 1 1 double\n");
    data(&mut bytes, "double", &[0.5]);
    bytes.extend(b"POINTS 2 double\n");
    data(&mut bytes, "double", &points.values);
    if version == "5.1" {
        bytes.extend(b"METADATA\nINFORMATION 1\nNAME L2_NORM_RANGE LOCATION vtkDataArray\nDATA 2 0 1 \n\n");
        bytes.extend(b"VERTICES 3 2\nOFFSETS vtktypeint64\n");
        data(&mut bytes, "vtktypeint64", &[0.0, 1.0, 2.0]);
        bytes.extend(b"CONNECTIVITY vtktypeint64\n");
        data(&mut bytes, "vtktypeint64", &[0.0, 1.0]);
        bytes.extend(b"CELL_DATA 2\nSCALARS shapex int 1\nLOOKUP_TABLE default\n");
        data(&mut bytes, "int", &[1.0, 2.0]);
        bytes.extend(format!("POINT_DATA 2\nFIELD FieldData {}\n", arrays.len()).bytes());
        for array in &arrays {
            bytes.extend(format!("{} {} 2 double\n", array.name, array.components).bytes());
            data(&mut bytes, "double", &array.values);
            bytes.extend(b"METADATA\nINFORMATION 0\n\n");
        }
        return bytes;
    }
    bytes.extend(b"VERTICES 2 4\n");
    data(&mut bytes, "int", &[1.0, 0.0, 1.0, 1.0]);
    bytes.extend(b"POINT_DATA 2\n");
    for array in &arrays {
        let head = match (array.name, array.components) {
            (name, 1) => format!("SCALARS {name} double 1\nLOOKUP_TABLE default\n"),
            (name, 3) => format!("VECTORS {name} double\n"),
            (name, _) => format!("TENSORS {name} double\n"),
        };
        bytes.extend(head.bytes());
        data(&mut bytes, "double", &array.values);
    }
    bytes
}

#[test]
fn both_layouts_of_legacy_files_read_alike() {
    for version in ["3.0", "5.1"] {
        for is_binary in [false, true] {
            let mut expected = two_particles().2;
            expected.step = Some(0.5);
            let import = import_with(&legacy(version, is_binary), &velocity());
            let (format, import) = import.unwrap_or_else(|error| panic!("{version} {is_binary}: {error}"));
            assert_eq!(format, Format::LiggghtsVtk);
            assert_same(&particles(import), &expected);
        }
    }
}

/// Neither a part of a file nor a file with a wrong byte makes the reader panic or claim memory.
#[test]
fn truncated_and_damaged_files_are_errors() {
    let mut files =
        vec![legacy("3.0", false), legacy("3.0", true), legacy("5.1", false), legacy("5.1", true)];
    for writer in Writer::all() {
        let (points, arrays, _) = two_particles();
        files.push(writer.file("PolyData", ["", "NumberOfPoints=\"2\""], &points, &arrays));
    }
    let everything = ReadOptions { all_extra: true, ..ReadOptions::default() };
    for file in &files {
        for end in 0..file.len() {
            // The headers and the last bytes whole, long data in steps.
            if end % 5 != 0 && file.len() - end > 300 && end > 600 {
                continue;
            }
            if let Ok((_, import)) = import_with(&file[..end], &everything) {
                // A blank or a closing tag at the end is no loss; before the points none are read.
                let count = particles(import).len();
                assert!(count == 0 || count == 2, "{end}");
            }
        }
        for at in (0..file.len()).step_by(7) {
            for byte in [0, b'9', b'<', b'"'] {
                let mut damaged = file.clone();
                damaged[at] = byte;
                let _ = import_with(&damaged, &everything);
            }
        }
    }
}

#[test]
fn counts_that_lie_are_errors() {
    let huge = u64::MAX / 2;
    for count in ["7", "1000000000000", &huge.to_string(), "99999999999999999999999", "-1", "nan"] {
        for version in ["3.0", "5.1"] {
            for is_binary in [false, true] {
                let bytes = legacy(version, is_binary);
                for words in
                    ["POINTS 2", "POINT_DATA 2", "VERTICES 3 2", "VERTICES 2 4", "TENSOR 9 2", "CELL_DATA 2"]
                {
                    let at = bytes.windows(words.len()).position(|window| window == words.as_bytes());
                    let Some(at) = at else { continue };
                    let end = at + words.len();
                    let lie = [&bytes[..end - 1], count.as_bytes(), &bytes[end..]].concat();
                    assert!(import(&lie).is_err(), "{version} {is_binary} {words} {count}");
                }
            }
        }
        for writer in Writer::all() {
            let (points, arrays, _) = two_particles();
            let lie = writer.file("PolyData", ["", &format!("NumberOfPoints=\"{count}\"")], &points, &arrays);
            assert!(import(&lie).is_err(), "{count}");
        }
    }
}

/// A few megabytes of zlib that would become more than a gigabyte.
#[test]
fn a_bomb_is_refused() {
    let rows = 1usize << 26;
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::fast());
    let zeros = vec![0u8; 1 << 20];
    (0..(rows * 8) >> 20).for_each(|_| encoder.write_all(&zeros).unwrap());
    let block = encoder.finish().unwrap();
    let header = [1u64, (rows * 8) as u64, 0, block.len() as u64].map(u64::to_le_bytes).concat();
    let data = STANDARD.encode(header) + &STANDARD.encode(&block);
    let arrays: String = ["shapex", "shapey", "shapez"]
        .map(|name| {
            format!("<DataArray type=\"Float64\" Name=\"{name}\" format=\"binary\">{data}</DataArray>")
        })
        .concat();
    let file = format!(
        "<VTKFile type=\"PolyData\" header_type=\"UInt64\" compressor=\"vtkZLibDataCompressor\"><PolyData>\
         <Piece NumberOfPoints=\"{rows}\"><PointData>{arrays}</PointData></Piece></PolyData></VTKFile>"
    );
    let error = import(file.as_bytes()).unwrap_err().to_string();
    assert!(error.contains("'shape") && error.contains("bytes in memory"), "{error}");
}

#[test]
fn wrong_numbers_name_the_array_and_the_row() {
    let cases = [
        ("shapex", 0, -1.0, "row 1: a semi-axis of -1"),
        ("shapez", 1, 0.0, "--min-axis"),
        ("blockiness1", 1, 0.0, "row 2"),
        ("blockiness2", 0, f64::NAN, "row 1"),
        ("TENSOR", 12, 5.0, "row 2"),
        ("id", 0, 0.5, "no integer"),
        ("v", 0, f64::NAN, ""),
    ];
    for (name, at, number, message) in cases {
        let (points, mut arrays, _) = two_particles();
        let array = arrays.iter_mut().find(|array| array.name == name).unwrap();
        array.values[at] = number;
        array.kind = "Float64";
        let writer = Writer { layout: Layout::Inline, is_wide: false, is_big: false, is_compressed: false };
        let bytes = writer.file("PolyData", ["", "NumberOfPoints=\"2\""], &points, &arrays);
        match import_with(&bytes, &velocity()) {
            Ok(_) => assert_eq!(message, "", "{name}"),
            Err(error) => {
                let error = error.to_string();
                assert!(error.contains(name) && error.contains(message) && !message.is_empty(), "{error}");
            }
        }
    }
}

#[test]
fn files_that_are_not_read_are_refused_with_a_reason() {
    let file = |attributes: &str| format!("<VTKFile {attributes}></VTKFile>");
    for (attributes, reason) in [
        ("type=\"PPolyData\"", "names other files"),
        ("type=\"vtkMultiBlockDataSet\"", "names other files"),
        ("type=\"Collection\"", "names other files"),
        ("type=\"HyperTreeGrid\"", "no points"),
        ("type=\"PolyData\" byte_order=\"Middle\"", "byte_order"),
    ] {
        let error = import(file(attributes).as_bytes()).unwrap_err().to_string();
        assert!(error.contains(reason) && error.contains("line 1"), "{error}");
    }
}

#[test]
fn only_binary_data_need_the_compressor() {
    for (layout, is_read) in [(Layout::Ascii, true), (Layout::Inline, false)] {
        let (points, arrays, _) = two_particles();
        let writer = Writer { layout, is_wide: false, is_big: false, is_compressed: true };
        let bytes = writer.file("PolyData", ["", "NumberOfPoints=\"2\""], &points, &arrays);
        let text = String::from_utf8(bytes).unwrap().replace("vtkZLib", "vtkLZ4");
        match import(text.as_bytes()) {
            Ok(_) => assert!(is_read),
            Err(error) => {
                let error = error.to_string();
                assert!(
                    !is_read && error.contains("vtkLZ4DataCompressor") && error.contains("zlib"),
                    "{error}"
                );
            }
        }
    }
}

#[test]
fn texts_and_bits_of_legacy_files_are_skipped() {
    let (points, text, bits) = ("0 0 0 1 1 1", "a b c\nd%20e", "0 1");
    let file = format!(
        "# vtk DataFile Version 5.1\nt\nASCII\nDATASET POLYDATA\nPOINTS 2 float\n{points}\nPOINT_DATA 2\n\
         SCALARS flags bit\nLOOKUP_TABLE default\n{bits}\nFIELD FieldData 3\nlabels 1 2 string\n{text}\n\
         odd%20name 2 2 float\n1 2 3 4\nradius 1 2 float\n5 6\n"
    );
    let options = ReadOptions { extra: vec!["odd name[2]".to_owned()], ..ReadOptions::default() };
    let particles = particles(import_with(file.as_bytes(), &options).unwrap().1);
    assert_eq!(particles.radii, [DVec3::splat(5.0), DVec3::splat(6.0)]);
    assert_eq!(particles.extra, [("odd name[2]".to_owned(), vec![2.0, 4.0])]);
}
