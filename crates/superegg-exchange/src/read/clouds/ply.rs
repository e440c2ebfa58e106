//! PLY files: the vertices as points, with their colours; faces are left out.

use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{
    ElementDef, Encoding, Header, Property, PropertyAccess, PropertyAccessResult, PropertyType, ScalarType,
};
use superegg_geom::glam::DVec3;

use super::points;
use crate::read::error::ReadError;
use crate::read::format::Format;
use crate::read::import::{Content, Import};
use crate::read::options::ReadOptions;

/// The first bytes of a PLY file.
const MAGIC: &[u8] = b"ply";
/// The element whose items are points.
const VERTEX: &str = "vertex";
/// The element whose items are faces.
const FACE: &str = "face";
/// Items that are read at a time.
const CHUNK: usize = 4096;
/// The names of colour channels.
const COLOR_NAMES: [[&str; 3]; 3] =
    [["red", "green", "blue"], ["diffuse_red", "diffuse_green", "diffuse_blue"], ["r", "g", "b"]];
/// The longest message of the parser, in characters.
const MOST_MESSAGE: usize = 160;

/// The format, if these first bytes begin a PLY file.
pub(crate) fn recognize(head: &[u8]) -> Option<Format> {
    let rest = head.strip_prefix(MAGIC)?;
    matches!(rest.first(), Some(b'\n' | b'\r' | b' ')).then_some(Format::Ply)
}

/// Whether these first bytes begin a PLY file.
pub(crate) fn is_ply(head: &[u8]) -> bool {
    recognize(head).is_some()
}

/// The scalar properties of an item in the order of the header.
struct Scalars(Vec<f64>);

impl PropertyAccess for Scalars {
    fn new() -> Self {
        Self(Vec::new())
    }

    fn set_property(&mut self, _name: &str, property: Property) -> PropertyAccessResult {
        self.0.push(match property {
            Property::Char(value) => f64::from(value),
            Property::UChar(value) => f64::from(value),
            Property::Short(value) => f64::from(value),
            Property::UShort(value) => f64::from(value),
            Property::Int(value) => f64::from(value),
            Property::UInt(value) => f64::from(value),
            Property::Float(value) => f64::from(value),
            Property::Double(value) => value,
            _ => return PropertyAccessResult::Ignored,
        });
        PropertyAccessResult::Set
    }
}

/// An item that is passed over.
struct Skipped;

impl PropertyAccess for Skipped {
    fn new() -> Self {
        Self
    }
}

/// Reads the vertices of a PLY file: ASCII or binary in both byte orders. Colours of integers are
/// sRGB values of their full range, colours of floats sRGB values from 0 to 1.
///
/// # Errors
/// The header or a value is wrong, the file is cut off, or it has no vertices with x, y and z.
pub(crate) fn read(bytes: &[u8], options: &ReadOptions) -> Result<Import, ReadError> {
    let mut reader = Reader::new(bytes);
    let header = Parser::<Skipped>::new().read_header(&mut reader).map_err(|error| error_of(&error))?;
    let mut columns = None;
    for element in header.elements.values() {
        check_count(element, header.encoding, reader.get_ref().len())?;
        if element.name == VERTEX {
            columns = Some(read_columns(&mut reader, element, &header)?);
            break;
        }
        read_chunks::<Skipped>(&mut reader, element, &header, |_| {})?;
    }
    let Some(columns) = columns else {
        return Err(ReadError::part(VERTEX, "the file has no such element, so it has no points"));
    };
    import(columns, header.elements.contains_key(FACE), options)
}

/// The corners of a face.
struct Face(Vec<usize>);

/// The names of the property of a face that lists its corners.
const CORNERS: [&str; 2] = ["vertex_indices", "vertex_index"];

impl PropertyAccess for Face {
    fn new() -> Self {
        Self(Vec::new())
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        if !CORNERS.contains(&name) {
            return PropertyAccessResult::Ignored;
        }
        // An index below 0 is none of a vertex.
        let index = |index: i64| usize::try_from(index).unwrap_or(usize::MAX);
        self.0 = match property {
            Property::ListChar(list) => list.into_iter().map(|x| index(x.into())).collect(),
            Property::ListUChar(list) => list.into_iter().map(|x| index(x.into())).collect(),
            Property::ListShort(list) => list.into_iter().map(|x| index(x.into())).collect(),
            Property::ListUShort(list) => list.into_iter().map(|x| index(x.into())).collect(),
            Property::ListInt(list) => list.into_iter().map(|x| index(x.into())).collect(),
            Property::ListUInt(list) => list.into_iter().map(|x| index(x.into())).collect(),
            _ => return PropertyAccessResult::Ignored,
        };
        PropertyAccessResult::Set
    }
}

/// Reads the triangles of a PLY file; the corners of a face are joined to its first one. None if the
/// file has no faces after its vertices.
///
/// # Errors
/// As for [`read`], and a face names a vertex that is not there.
pub(crate) fn read_triangles(bytes: &[u8]) -> Result<Vec<[DVec3; 3]>, ReadError> {
    let mut reader = Reader::new(bytes);
    let header = Parser::<Skipped>::new().read_header(&mut reader).map_err(|error| error_of(&error))?;
    let mut vertices: Vec<DVec3> = Vec::new();
    let mut triangles = Vec::new();
    for element in header.elements.values() {
        check_count(element, header.encoding, reader.get_ref().len())?;
        match element.name.as_str() {
            VERTEX => {
                let columns = read_columns(&mut reader, element, &header)?;
                let column = |name: &str| columns.iter().find(|column| column.name == name);
                let (Some(x), Some(y), Some(z)) = (column("x"), column("y"), column("z")) else {
                    return Err(ReadError::part(VERTEX, "expected the properties x, y and z"));
                };
                let coordinates = x.values.iter().zip(&y.values).zip(&z.values);
                vertices = coordinates.map(|((x, y), z)| DVec3::new(*x, *y, *z)).collect();
            }
            FACE if !vertices.is_empty() => {
                let mut wrong = None;
                read_chunks(&mut reader, element, &header, |Face(corners)| {
                    let corners: Vec<Option<&DVec3>> =
                        corners.iter().map(|&corner| vertices.get(corner)).collect();
                    for pair in corners.windows(2).skip(1) {
                        match (corners[0], pair[0], pair[1]) {
                            (Some(a), Some(b), Some(c)) => triangles.push([*a, *b, *c]),
                            _ => wrong = Some("a face names a vertex that is not there"),
                        }
                    }
                })?;
                if let Some(message) = wrong {
                    return Err(ReadError::part(FACE, message));
                }
                break;
            }
            _ => read_chunks::<Skipped>(&mut reader, element, &header, |_| {})?,
        }
    }
    Ok(triangles)
}

/// A scalar property of all vertices.
struct Column {
    name: String,
    scalar: ScalarType,
    values: Vec<f64>,
}

fn import(mut columns: Vec<Column>, is_mesh: bool, options: &ReadOptions) -> Result<Import, ReadError> {
    let mut take = |name: &str| {
        let found = columns.iter().position(|column| column.name == name);
        found.map(|index| columns.swap_remove(index))
    };
    let (Some(x), Some(y), Some(z)) = (take("x"), take("y"), take("z")) else {
        return Err(ReadError::part(VERTEX, "expected the properties x, y and z"));
    };
    let points = x.values.iter().zip(&y.values).zip(&z.values);
    let points = points.map(|((x, y), z)| DVec3::new(*x, *y, *z)).collect();
    let (mut particles, radius) = points::spheres(points, options)?;
    let colors = COLOR_NAMES.iter().find_map(|names| {
        let channel = |name: &str| columns.iter().find(|column| column.name == name);
        Some([channel(names[0])?, channel(names[1])?, channel(names[2])?])
    });
    if let Some(channels) = colors {
        let color = |index: usize| channels.map(|channel| linear(channel.values[index], &channel.scalar));
        particles.colors = (0..particles.len()).map(color).collect();
    }
    let extra = columns.into_iter().map(|column| (column.name, column.values)).collect();
    particles.extra = crate::read::columns::extra_columns(extra, options)?;
    let what = if is_mesh { "vertices of a mesh" } else { "points" };
    let reading = format!("{} {what}, as spheres of radius {radius}", particles.len());
    Ok(Import::new(Content::Particles(particles), reading))
}

/// A linear colour channel of an sRGB value.
fn linear(value: f64, scalar: &ScalarType) -> f32 {
    let most = match scalar {
        ScalarType::Char | ScalarType::UChar => f64::from(u8::MAX),
        ScalarType::Short | ScalarType::UShort => f64::from(u16::MAX),
        ScalarType::Int | ScalarType::UInt => f64::from(u32::MAX),
        ScalarType::Float | ScalarType::Double => 1.0,
    };
    let encoded = if value.is_nan() { 0.0 } else { (value / most).clamp(0.0, 1.0) };
    crate::srgb::linear_of_srgb(encoded) as f32
}

/// Checks that the bytes can hold the items that the header claims.
fn check_count(element: &ElementDef, encoding: Encoding, bytes: usize) -> Result<(), ReadError> {
    let item = match encoding {
        // A number and what separates it from the next.
        Encoding::Ascii => 2 * element.properties.len().max(1) - 1,
        Encoding::BinaryBigEndian | Encoding::BinaryLittleEndian => element
            .properties
            .values()
            .map(|property| match &property.data_type {
                PropertyType::Scalar(scalar) | PropertyType::List(scalar, _) => size(scalar),
            })
            .sum(),
    };
    if element.count > 0 && item == 0 {
        return Err(ReadError::part(&element.name, "the element has items without properties"));
    }
    if element.count.checked_mul(item).is_none_or(|needed| needed > bytes) {
        let message = format!("the header claims {} items, but {bytes} bytes follow", element.count);
        return Err(ReadError::part(&element.name, message));
    }
    Ok(())
}

fn size(scalar: &ScalarType) -> usize {
    match scalar {
        ScalarType::Char | ScalarType::UChar => 1,
        ScalarType::Short | ScalarType::UShort => 2,
        ScalarType::Int | ScalarType::UInt | ScalarType::Float => 4,
        ScalarType::Double => 8,
    }
}

fn read_columns(
    reader: &mut Reader<&[u8]>,
    element: &ElementDef,
    header: &Header,
) -> Result<Vec<Column>, ReadError> {
    let mut columns: Vec<Column> = Vec::new();
    for property in element.properties.values() {
        if let PropertyType::Scalar(scalar) = &property.data_type {
            let values = Vec::with_capacity(element.count);
            columns.push(Column { name: property.name.clone(), scalar: scalar.clone(), values });
        }
    }
    read_chunks(reader, element, header, |Scalars(values)| {
        for (column, value) in columns.iter_mut().zip(values) {
            column.values.push(value);
        }
    })?;
    Ok(columns)
}

/// Reads the items of an element a few at a time.
fn read_chunks<T: PropertyAccess>(
    reader: &mut Reader<&[u8]>,
    element: &ElementDef,
    header: &Header,
    mut each: impl FnMut(T),
) -> Result<(), ReadError> {
    let parser = Parser::<T>::new();
    let mut part = element.clone();
    let mut left = element.count;
    while left > 0 {
        part.count = left.min(CHUNK);
        left -= part.count;
        let items = parser.read_payload_for_element(reader, &part, header);
        items.map_err(|error| error_of(&error))?.into_iter().for_each(&mut each);
    }
    Ok(())
}

/// The parser's error in one line.
fn error_of(error: &ParseError) -> ReadError {
    let words: Vec<String> = error.to_string().split_whitespace().map(str::to_owned).collect();
    let message: String = words.join(" ").chars().take(MOST_MESSAGE).collect();
    match error.line() {
        Some(line) => {
            let prefix = format!("Line {line}: ");
            ReadError::line(line as u64, message.strip_prefix(&prefix).unwrap_or(&message))
        }
        None => ReadError::File(format!("the PLY file cannot be read: {message}")),
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::read::particles::Particles;

    fn particles(bytes: &[u8], options: &ReadOptions) -> Particles {
        match read(bytes, options).unwrap().content {
            Content::Particles(particles) => particles,
            Content::Script(script) => panic!("{script}"),
        }
    }

    fn message(bytes: &[u8]) -> String {
        read(bytes, &ReadOptions::default()).unwrap_err().to_string()
    }

    const HEAD: &str = "element camera 1\nproperty list uchar int views\nelement vertex COUNT\n\
        property double x\nproperty float quality\nproperty double y\nproperty list uchar short near\n\
        property double z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n\
        element face 1\nproperty list uchar int vertex_indices\nend_header\n";

    /// A file with all that PLY has, in one encoding.
    fn file(encoding: &str, points: &[[f64; 3]]) -> Vec<u8> {
        let head = HEAD.replace("COUNT", &points.len().to_string());
        let mut bytes = format!("ply\nformat {encoding} 1.0\ncomment by a test\n{head}").into_bytes();
        if encoding == "ascii" {
            bytes.extend(b"2 7 8\n");
            for [x, y, z] in points {
                bytes.extend(format!("{x} 0.5 {y} 1 -3 {z} 255 0 128\n").bytes());
            }
            bytes.extend(b"3 0 1 2\n");
            return bytes;
        }
        let is_big = encoding == "binary_big_endian";
        let mut put = |little: &[u8]| {
            let ordered: Vec<u8> =
                if is_big { little.iter().rev().copied().collect() } else { little.to_vec() };
            bytes.extend(ordered);
        };
        put(&[2]);
        put(&7_i32.to_le_bytes());
        put(&8_i32.to_le_bytes());
        for [x, y, z] in points {
            put(&x.to_le_bytes());
            put(&0.5_f32.to_le_bytes());
            put(&y.to_le_bytes());
            put(&[1]);
            put(&(-3_i16).to_le_bytes());
            put(&z.to_le_bytes());
            [255, 0, 128].iter().for_each(|channel| put(&[*channel]));
        }
        put(&[3]);
        (0..3_i32).for_each(|index| put(&index.to_le_bytes()));
        bytes
    }

    const ENCODINGS: [&str; 3] = ["ascii", "binary_little_endian", "binary_big_endian"];

    proptest! {
        #[test]
        fn points_keep_their_digits(points in prop::collection::vec(prop::array::uniform3(-1e3..1e3_f64), 1..50)) {
            let options = ReadOptions { all_extra: true, point_radius: Some(0.25), ..ReadOptions::default() };
            for encoding in ENCODINGS {
                let bytes = file(encoding, &points);
                prop_assert_eq!(recognize(&bytes), Some(Format::Ply));
                let found = particles(&bytes, &options);
                let positions: Vec<[f64; 3]> = found.positions.iter().map(DVec3::to_array).collect();
                prop_assert_eq!(&positions, &points);
                prop_assert_eq!(found.radii[0], DVec3::splat(0.25));
                let quality = found.extra.iter().find(|(name, _)| name == "quality").unwrap();
                prop_assert_eq!(&quality.1, &vec![0.5; points.len()]);
                let [red, green, blue] = found.colors[points.len() - 1];
                prop_assert!(red == 1.0 && green == 0.0 && (blue - 0.215_861).abs() < 1e-6);
            }
        }

        #[test]
        fn damage_is_an_error_or_a_cloud(at in 0..400_usize, to in any::<u8>(), end in 0..700_usize) {
            for encoding in ENCODINGS {
                let mut bytes = file(encoding, &[[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]);
                if let Some(byte) = bytes.get_mut(at) {
                    *byte = to;
                }
                bytes.truncate(end);
                let _ = read(&bytes, &ReadOptions::default());
            }
        }
    }

    #[test]
    fn more_points_than_a_chunk_are_read() {
        let points: Vec<[f64; 3]> = (0..10_000).map(|i| [f64::from(i), 0.0, 1.0]).collect();
        for encoding in ENCODINGS {
            let found = particles(&file(encoding, &points), &ReadOptions::default());
            assert_eq!((found.len(), found.positions[9_999].x), (10_000, 9_999.0));
            assert!(found.extra.is_empty());
        }
    }

    #[test]
    fn claims_that_the_bytes_do_not_hold_are_errors() {
        for encoding in ENCODINGS {
            let whole = file(encoding, &[[1.0, 2.0, 3.0]]);
            let text = String::from_utf8_lossy(&whole).into_owned();
            let head_end = text.find("end_header").unwrap();
            let mut lie =
                text[..head_end].replace("vertex 1\n", "vertex 18446744073709551615\n").into_bytes();
            lie.extend(&whole[head_end..]);
            assert!(message(&lie).contains("items, but"), "{encoding}");
        }
        let head = "ply\nformat binary_little_endian 1.0\n";
        assert!(
            message(format!("{head}element vertex 9999999999\nend_header\n").as_bytes())
                .contains("without properties")
        );
        assert!(
            message(format!("{head}element face 0\nproperty float x\nend_header\n").as_bytes())
                .contains("no points")
        );
        let flat = format!("{head}element vertex 0\nproperty float x\nproperty float y\nend_header\n");
        assert!(message(flat.as_bytes()).contains("x, y and z"));
        let ascii = "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n\
                     property float z\nend_header\n1 2 3\n1 two 3\n";
        assert!(message(ascii.as_bytes()).starts_with("line 9: "), "{}", message(ascii.as_bytes()));
        assert!(message(ascii.replace("two", "1e999").as_bytes()).contains("'point 1': expected finite"));
        assert!(read(ascii.replace("two", "nan").as_bytes(), &ReadOptions::default()).is_err());
        assert!(message(b"ply\nformat ascii 2.0\n").len() < 250);
        assert_eq!(recognize(b"plywood"), None);
    }

    /// The number of points of each real file, and one of its coordinates.
    #[allow(clippy::print_stderr, reason = "a test that is skipped says so")]
    #[test]
    fn real_files_are_read() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/exchange");
        for (file, count) in [
            ("clouds/noisy_pointCloud_example_1.ply", 1288),
            ("clouds/partial_pointCloud_example_1.ply", 147),
            ("meshes/grid_pole_quads_double.ply", 1225),
            ("meshes/trimesh_out.ply", 1225),
            ("meshes/vtk_rod.ply", 480),
        ] {
            let Ok(bytes) = std::fs::read(format!("{folder}/{file}")) else {
                eprintln!("skipped: {folder}/{file} is missing");
                continue;
            };
            let found = particles(&bytes, &ReadOptions::default());
            assert_eq!(found.len(), count, "{file}");
            if file.contains("noisy") {
                let first = DVec3::new(-0.352116502425237, 1.002350161925221, -0.452004614243209);
                assert_eq!(found.positions[0], first);
            }
            if file == "meshes/vtk_rod.ply" {
                // The rod of half axes .5 .5 2 is within a box around the origin.
                assert!(found.positions.iter().all(|point| point.abs().max_element() < 3.0), "{file}");
            }
        }
    }
}
