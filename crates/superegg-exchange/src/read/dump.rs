//! Text dumps of LIGGGHTS, LAMMPS and OVITO: frames of `ITEM:` sections.
//!
//! The three programs use the same layout, and partly the same column names with other meanings.
//! Frames are read as a stream, block by block: a file of any size takes the memory of its result.

mod columns;
mod header;
mod lines;

use std::io::SeekFrom;

use superegg_geom::glam::DVec3;

use super::check;
use super::error::ReadError;
use super::format::Format;
use super::frame::Frame;
use super::import::{Content, Import, Input};
use super::options::ReadOptions;
use super::particles::Particles;
use columns::{Columns, Position, Rotation, Size};
use header::Header;
use lines::Lines;

/// The first words of a frame.
const FRAME: &[u8] = b"ITEM: TIMESTEP";

/// Which dump this is, by the columns of its first frame; `None` if it is no dump.
pub(super) fn recognize(head: &[u8]) -> Result<Option<Format>, ReadError> {
    let text = head.strip_prefix(b"\xef\xbb\xbf").unwrap_or(head);
    if !text.trim_ascii_start().starts_with(b"ITEM: ") {
        return Ok(None);
    }
    let atoms = text
        .split(|&byte| byte == b'\n')
        .filter_map(|line| line.strip_prefix(b"ITEM: ATOMS"))
        .map(|names| String::from_utf8_lossy(names).into_owned())
        .next();
    match atoms {
        Some(names) => columns::format_of(&names.split_whitespace().collect::<Vec<_>>()).map(Some),
        None => Err(ReadError::File("the dump has no section ITEM: ATOMS".to_owned())),
    }
}

/// The frames of a dump.
pub(super) fn frames(input: &mut dyn Input) -> Result<Vec<Frame>, ReadError> {
    let mut frames: Vec<Frame> = Vec::new();
    let mut lines = Lines::new(input, 0, u64::MAX, 1)?;
    lines.skip_to(FRAME)?;
    while let Some((start, line)) = lines.at_prefix(FRAME)? {
        if let Some(last) = frames.last_mut() {
            last.end = start;
        }
        let step = lines.next()?.and_then(|text| std::str::from_utf8(text).ok()?.trim().parse().ok());
        frames.push(Frame { step, start, end: lines.end(), first_line: line });
        lines.skip_to(FRAME)?;
    }
    if frames.is_empty() {
        return Err(ReadError::File("the dump has no frame (ITEM: TIMESTEP)".to_owned()));
    }
    Ok(frames)
}

/// Reads one frame.
pub(super) fn read(
    input: &mut dyn Input,
    frame: &Frame,
    format: Format,
    options: &ReadOptions,
) -> Result<Import, ReadError> {
    input.seek(SeekFrom::Start(frame.start))?;
    let mut lines = Lines::new(input, frame.start, frame.end, frame.first_line)?;
    let header = header::read(&mut lines)?;
    let names: Vec<&str> = header.columns.split_whitespace().collect();
    let columns = Columns::of(&names, format, options)?;
    let mut rows = Rows::new(&header, &columns, options, frame);
    while let Some(text) = lines.next()? {
        rows.add(text).map_err(|message| ReadError::line(lines.line(), message))?;
    }
    rows.finish(frame, lines.line())
}

/// The rows of a frame while they are read.
struct Rows<'a> {
    header: &'a Header,
    columns: &'a Columns,
    options: &'a ReadOptions,
    particles: Particles,
    /// The numbers of the wanted columns of one row.
    numbers: Vec<f64>,
    far_quaternions: usize,
}

impl<'a> Rows<'a> {
    fn new(header: &'a Header, columns: &'a Columns, options: &'a ReadOptions, frame: &Frame) -> Self {
        // A row has at least two bytes for each column.
        let most = (frame.end - frame.start) / (2 * columns.count() as u64);
        let count = header.count.min(most) as usize;
        let mut particles = Particles { step: frame.step, bounds: header.bounds, ..Particles::default() };
        particles.positions.reserve_exact(count);
        particles.radii.reserve_exact(count);
        particles.exponents.reserve_exact(count);
        particles.rotations.reserve_exact(count);
        if columns.id.is_some() {
            particles.ids.reserve_exact(count);
        }
        particles.extra = columns.extra.iter().map(|(name, _)| (name.clone(), Vec::new())).collect();
        particles.extra.iter_mut().for_each(|(_, values)| values.reserve_exact(count));
        let numbers = vec![0.0; columns.wanted_count()];
        Self { header, columns, options, particles, numbers, far_quaternions: 0 }
    }

    /// Adds a row.
    fn add(&mut self, text: &[u8]) -> Result<(), String> {
        if self.particles.len() as u64 == self.header.count {
            if text.trim_ascii().is_empty() {
                return Ok(());
            }
            return Err(format!("there are more rows than the {} of the frame", self.header.count));
        }
        self.columns.parse(text, &mut self.numbers)?;
        let at = |index: usize| self.numbers[index];
        let vector = |[x, y, z]: [usize; 3]| DVec3::new(at(x), at(y), at(z));
        let position = match self.columns.position {
            Position::Plain(axes) => vector(axes),
            Position::Scaled(axes) => self.header.unscaled(vector(axes))?,
        };
        let radii = match self.columns.size {
            Size::SemiAxes(axes) => vector(axes),
            Size::Diameters(axes) => vector(axes) * 0.5,
            Size::Radius(radius) => DVec3::splat(at(radius)),
            Size::Diameter(diameter) => DVec3::splat(0.5 * at(diameter)),
        };
        let exponents = match self.columns.exponents {
            None => [1.0, 1.0],
            Some(columns::Powers::Blockiness([first, second])) => {
                check::exponents_of_blockiness(at(first), at(second))?
            }
            Some(columns::Powers::Roundness([phi, theta])) => {
                // OVITO writes 0 for a property that is not set: an ellipsoid.
                let or_round = |x: f64| if x == 0.0 { 1.0 } else { x };
                check::exponents(or_round(at(phi)), or_round(at(theta)))?
            }
        };
        let rotation = match self.columns.rotation {
            Rotation::None => superegg_geom::glam::DQuat::IDENTITY,
            Rotation::Quaternion([w, x, y, z]) => {
                let (rotation, is_far) = check::rotation(at(w), at(x), at(y), at(z))?;
                self.far_quaternions += usize::from(is_far);
                rotation
            }
        };
        let radii = check::semi_axes(radii, self.options)?;
        self.particles.push(check::position(position)?, radii, exponents, rotation);
        if let Some(id) = self.columns.id {
            self.particles.ids.push(at(id) as i64);
        }
        for ((_, values), (_, index)) in self.particles.extra.iter_mut().zip(&self.columns.extra) {
            values.push(self.numbers[*index]);
        }
        Ok(())
    }

    fn finish(self, frame: &Frame, line: u64) -> Result<Import, ReadError> {
        let Self { header, columns, particles, far_quaternions, .. } = self;
        if (particles.len() as u64) < header.count {
            let (found, count) = (particles.len(), header.count);
            return Err(ReadError::line(
                line,
                format!("the frame at line {} ends after {found} of {count} rows", frame.first_line),
            ));
        }
        let mut warnings = columns.warnings.clone();
        warnings.extend(check::repeated_ids(&particles));
        if far_quaternions > 0 {
            warnings
                .push(format!("{far_quaternions} quaternions are not of unit length; they are normalized"));
        }
        let mut import = Import::new(Content::Particles(particles), columns.reading.clone());
        import.warnings = warnings;
        Ok(import)
    }
}
