//! The header of a data file, and the heads of its sections.

use superegg_geom::glam::DVec3;

use super::super::error::ReadError;
use super::super::lines::Lines;
use super::super::particles::SimulationBox;

/// The head of a section: its name and the comment behind it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Section {
    pub(super) name: String,
    /// The style of atoms in `Atoms # ellipsoid`.
    pub(super) hint: String,
}

impl Section {
    /// The section that a line begins: words that begin with a capital letter.
    pub(super) fn of(line: &[u8]) -> Option<Self> {
        let line = line.trim_ascii();
        if !line.first()?.is_ascii_uppercase() {
            return None;
        }
        let text = String::from_utf8_lossy(line);
        let (name, hint) = text.split_once('#').unwrap_or((&text, ""));
        Some(Self { name: name.trim().to_owned(), hint: hint.trim().to_owned() })
    }
}

/// The header before the sections.
#[derive(Debug, Default)]
pub(super) struct Header {
    pub(super) atoms: u64,
    pub(super) ellipsoids: u64,
    pub(super) bounds: Option<SimulationBox>,
    /// The first section.
    pub(super) section: Section,
}

/// The lines of bounds: orthogonal with tilts, or edges and origin.
#[derive(Default)]
struct Bounds {
    low: Option<DVec3>,
    high: DVec3,
    tilts: DVec3,
    edges: Option<[DVec3; 3]>,
    origin: DVec3,
}

impl Bounds {
    fn finish(self) -> Option<SimulationBox> {
        let periodic = [false; 3];
        if let Some(edges) = self.edges {
            return Some(SimulationBox { origin: self.origin, edges, periodic });
        }
        let low = self.low?;
        let size = self.high - low;
        let [xy, xz, yz] = self.tilts.to_array();
        let edges = [DVec3::X * size.x, DVec3::new(xy, size.y, 0.0), DVec3::new(xz, yz, size.z)];
        Some(SimulationBox { origin: low, edges, periodic })
    }
}

/// Reads the header up to the head of the first section.
pub(super) fn read(lines: &mut Lines<'_>) -> Result<Header, ReadError> {
    let mut header = Header::default();
    let mut bounds = Bounds::default();
    // The first line is a comment.
    lines.next()?;
    while let Some(line) = lines.next()? {
        if let Some(section) = Section::of(line) {
            header.section = section;
            header.bounds = bounds.finish();
            return Ok(header);
        }
        let text = String::from_utf8_lossy(line).into_owned();
        let content = text.split('#').next().unwrap_or_default();
        let words: Vec<&str> = content.split_whitespace().collect();
        keyword(&words, &mut header, &mut bounds)
            .map_err(|message| ReadError::line(lines.line(), message))?;
    }
    Err(ReadError::line(lines.line(), "the file ends before a section Atoms"))
}

/// Reads a line of the header. Lines that say nothing about particles or the box are passed over.
fn keyword(words: &[&str], header: &mut Header, bounds: &mut Bounds) -> Result<(), String> {
    let count = |word: &str| word.parse().map_err(|_| format!("'{word}' is no count"));
    match words {
        [number, "atoms"] => header.atoms = count(number)?,
        [number, "ellipsoids"] => header.ellipsoids = count(number)?,
        [low, high, "xlo", "xhi"] => set_range(bounds, 0, [low, high])?,
        [low, high, "ylo", "yhi"] => set_range(bounds, 1, [low, high])?,
        [low, high, "zlo", "zhi"] => set_range(bounds, 2, [low, high])?,
        [xy, xz, yz, "xy", "xz", "yz"] => bounds.tilts = vector([xy, xz, yz])?,
        [x, y, z, "avec"] => set_edge(bounds, 0, [x, y, z])?,
        [x, y, z, "bvec"] => set_edge(bounds, 1, [x, y, z])?,
        [x, y, z, "cvec"] => set_edge(bounds, 2, [x, y, z])?,
        [x, y, z, "abc", "origin"] => bounds.origin = vector([x, y, z])?,
        _ => {}
    }
    Ok(())
}

fn set_range(bounds: &mut Bounds, axis: usize, [low, high]: [&str; 2]) -> Result<(), String> {
    bounds.low.get_or_insert(DVec3::ZERO)[axis] = coordinate(low)?;
    bounds.high[axis] = coordinate(high)?;
    Ok(())
}

fn set_edge(bounds: &mut Bounds, edge: usize, words: [&str; 3]) -> Result<(), String> {
    bounds.edges.get_or_insert([DVec3::ZERO; 3])[edge] = vector(words)?;
    Ok(())
}

fn vector([x, y, z]: [&str; 3]) -> Result<DVec3, String> {
    Ok(DVec3::new(coordinate(x)?, coordinate(y)?, coordinate(z)?))
}

fn coordinate(word: &str) -> Result<f64, String> {
    let number = word.parse().ok().filter(|number: &f64| number.is_finite());
    number.ok_or_else(|| format!("'{word}' is no bound of the box: expected a finite number"))
}

/// The numbers of a row; comments behind them are left out.
pub(super) fn row_numbers(line: &[u8]) -> Result<Vec<f64>, String> {
    let content = line.split(|&byte| byte == b'#').next().unwrap_or_default();
    let words = content.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
    let parsed = words.enumerate().map(|(index, word)| {
        let message = || format!("column {}: '{}' is not a number", index + 1, String::from_utf8_lossy(word));
        super::super::number::parse(word).ok_or_else(message)
    });
    parsed.collect()
}
