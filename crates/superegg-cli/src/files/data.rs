//! Loads data of other programs as scenes.

use std::fmt;
use std::io::{self, Read, SeekFrom};
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, anyhow, bail};
use superegg_exchange::coloring::{ColorKey, ColoredTable, Coloring, to_table};
use superegg_exchange::read::{
    Content, Import, Input, Particles, ReadError, ReadOptions, SimulationBox, Source, open, sniff,
};
use superegg_exchange::sqb;
use superegg_geom::glam::{DQuat, DVec3};
use superegg_geom::{Aabb, Exponents, TransformStep, unit_vector};
use superegg_lang::{Session, find_command, format_number, load_text};
use superegg_render::frame_data;
use superegg_scene::{InstanceTable, Material, Scene, TableBuilder};

use crate::text::counted;

/// The number of bytes that decide whether a file is data.
const HEAD: u64 = 1 << 16;

/// The most warnings about a file that are reported one by one.
const MOST_WARNINGS: usize = 100;

/// How data is read and shown.
#[derive(Clone, Debug, Default)]
pub struct DataOptions {
    /// The format and the columns.
    pub read: ReadOptions,
    /// The colours of the rows.
    pub coloring: Coloring,
    /// The frame; the first one that is not empty if `None`.
    pub frame: Option<usize>,
    /// The number of images of a periodic box along each edge; `[0; 3]` stands for one.
    pub images: [u32; 3],
    /// Whether the edges of the simulation box are shown.
    pub shows_box: bool,
    /// The width and height of the middle part of the picture that all data is to be seen in; by
    /// default those of a scene.
    pub size: Option<(u32, u32)>,
}

impl DataOptions {
    /// Whether the options only make sense for data.
    pub(crate) fn are_for_data(&self) -> bool {
        let Self { read, coloring, images, shows_box, frame: _, size: _ } = self;
        read.from.is_some()
            || read.columns.is_some()
            || *coloring != Coloring::Own
            || images.iter().any(|count| *count > 1)
            || *shows_box
    }
}

/// The kind of a file by its first bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum FileKind {
    /// Lines of the modelling language, or nothing that is known.
    Text,
    /// A binary scene.
    Binary,
    /// Data of another program.
    Data,
}

/// Recognizes the kind of a file.
pub(super) fn kind_of(input: &mut dyn Input, options: &DataOptions) -> Result<FileKind> {
    let head = head_of(input)?;
    Ok(if head.starts_with(&sqb::SIGNATURE) {
        FileKind::Binary
    } else if options.are_for_data() || sniff(&head).is_some() {
        FileKind::Data
    } else {
        FileKind::Text
    })
}

/// The first bytes of a file, which is then at its start again.
pub(crate) fn head_of(input: &mut dyn Input) -> io::Result<Vec<u8>> {
    let mut head = Vec::new();
    input.seek(SeekFrom::Start(0))?;
    Read::take(&mut *input, HEAD).read_to_end(&mut head)?;
    input.seek(SeekFrom::Start(0))?;
    Ok(head)
}

/// Opens data. The error for a scene of superegg says that it is one.
pub(super) fn open_source<R: Input>(mut input: R, options: &ReadOptions) -> Result<Source<R>> {
    let head = head_of(&mut input)?;
    open(input, options).map_err(|error| match error {
        ReadError::Unrecognized if is_scene(&head) => anyhow!(
            "this is a scene of superegg, not data of another program; use it without import and without the options for data files"
        ),
        error => error.into(),
    })
}

/// Whether the first line that is no comment is a command of the modelling language.
pub(crate) fn is_scene(head: &[u8]) -> bool {
    let lines = String::from_utf8_lossy(head);
    let first = lines.lines().map(str::trim).find(|line| !line.is_empty() && !line.starts_with('#'));
    first.and_then(|line| line.split_whitespace().next()).is_some_and(|word| find_command(word).is_some())
}

/// A line about how data was read.
#[derive(Clone, Debug)]
pub(crate) enum Note {
    /// The recognized format, and the meaning of its numbers.
    Reading(String),
    /// Parts that were skipped or cannot be trusted.
    Warning(String),
}

impl Note {
    /// Whether a quiet command prints the note.
    pub(crate) fn is_warning(&self) -> bool {
        match self {
            Self::Reading(_) => false,
            Self::Warning(_) => true,
        }
    }
}

impl fmt::Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Reading(text) | Self::Warning(text) => f.write_str(text),
        }
    }
}

/// A data file as a scene, with notes about how it was read.
pub(crate) struct LoadedData {
    pub(crate) session: Session,
    pub(crate) notes: Vec<Note>,
    /// The box that the camera shows.
    pub(crate) bounds: Aabb,
    /// The meaning of the colours.
    pub(crate) key: ColorKey,
    /// The index of the frame in its file.
    pub(crate) frame: usize,
}

/// Loads data files as one scene: a table of instances for each, in an object if there are several.
///
/// # Errors
/// A file cannot be read, is in no known format, or is wrong.
pub(crate) fn load_files(paths: &[PathBuf], options: &DataOptions) -> Result<LoadedData> {
    let mut loaded = Vec::new();
    for path in paths {
        let mut input = super::binary_scene::open_input(path)?;
        loaded.push(load(path, &mut *input, options)?);
    }
    if loaded.len() == 1 {
        return loaded.pop().ok_or_else(|| anyhow!("no file"));
    }
    join(loaded, options)
}

/// Opens a file of data, or standard input for `-`.
///
/// # Errors
/// The file cannot be opened.
pub(crate) fn open_data(path: &Path) -> Result<Box<dyn Input>> {
    super::binary_scene::open_input(path)
}

/// Particles under names as one scene: a table for each, in an object if there are several.
///
/// # Errors
/// Numbers of a particle make no superquadric.
pub(crate) fn scene_of_particles(parts: Vec<(&str, Particles)>) -> Result<Session> {
    let options = DataOptions::default();
    let mut loaded = Vec::new();
    for (name, particles) in parts {
        let bounds = bounds_of(&particles, &options);
        let ColoredTable { table, key } = to_table(&particles, &options.coloring)?;
        let session = particle_scene(name, table, None, &bounds, &options)?;
        loaded.push(LoadedData { session, notes: Vec::new(), bounds, key, frame: 0 });
    }
    if loaded.len() == 1 {
        return loaded.pop().map(|one| one.session).ok_or_else(|| anyhow!("no particles"));
    }
    Ok(join(loaded, &options)?.session)
}

/// Puts the tables of several files into one scene.
fn join(loaded: Vec<LoadedData>, options: &DataOptions) -> Result<LoadedData> {
    let (mut scene, mut notes) = (Scene::default(), Vec::new());
    let mut bounds = Aabb::EMPTY;
    scene.ensure_object("all")?;
    for data in loaded {
        let root = data.session.selected().map(str::to_owned);
        for (name, table) in data.session.scene().tables() {
            let free = (1..)
                .map(|number| if number == 1 { name.to_owned() } else { format!("{name}_{number}") })
                .find(|name| scene.get(name).is_none());
            let free = free.unwrap_or_default();
            scene.add_table(&free, table.clone())?;
            scene.add_child("all", &free, &free)?;
        }
        if data.session.scene().tables().next().is_none() {
            bail!("'{}' holds a scene; import it alone", root.unwrap_or_default());
        }
        notes.extend(data.notes);
        bounds = bounds.union(&data.bounds);
    }
    frame(&mut scene, &bounds, options);
    Ok(LoadedData {
        session: Session::with_scene(scene, Some("all")),
        notes,
        bounds,
        key: ColorKey::None,
        frame: 0,
    })
}

/// Loads one data file from a stream.
pub(super) fn load(path: &Path, input: &mut dyn Input, options: &DataOptions) -> Result<LoadedData> {
    load_named(path, &scene_name(path), input, options)
}

/// Loads one data file from a stream into an object of this name.
pub(super) fn load_named(
    path: &Path,
    object: &str,
    input: &mut dyn Input,
    options: &DataOptions,
) -> Result<LoadedData> {
    let cannot_read = || format!("cannot read '{}'", path.display());
    let mut source = open_source(input, &options.read).with_context(cannot_read)?;
    let format = source.format();
    let (frame, import) = read_frame(&mut source, options).with_context(cannot_read)?;
    let Import { content, reading, warnings, .. } = import;
    let frames = source.frames().len();
    let of_frames = if frames > 1 { format!(", frame {frame} of 0..{}", frames - 1) } else { String::new() };
    let name = path.display();
    let (mut bounds, mut key) = (Aabb::EMPTY, ColorKey::None);
    let (session, count) = match content {
        Content::Particles(particles) => {
            let count = counted(particles.len(), "shape");
            bounds = bounds_of(&particles, options);
            let ColoredTable { table, key: found } =
                to_table(&particles, &options.coloring).with_context(cannot_read)?;
            key = found;
            let simulation = particles.bounds;
            drop(particles);
            (particle_scene(object, table, simulation, &bounds, options).with_context(cannot_read)?, count)
        }
        Content::Script(text) => {
            let (session, diagnostics) = load_text(&name.to_string(), &text);
            if let Some(error) = diagnostics.first() {
                bail!("cannot read '{name}': {error}");
            }
            (session, "a scene".to_owned())
        }
        _ => bail!("cannot read '{name}': it holds nothing that can be shown"),
    };
    let recognized = format.description();
    let mut notes = vec![Note::Reading(format!("{name}: {recognized}{of_frames}: {count}; {reading}"))];
    let warning = |text: String| Note::Warning(format!("{name}: warning: {text}"));
    let more = warnings.len().saturating_sub(MOST_WARNINGS);
    notes.extend(warnings.into_iter().take(MOST_WARNINGS).map(warning));
    if more > 0 {
        notes.push(warning(format!("{} of this file", counted(more, "more warning"))));
    }
    if let ColorKey::Range([low, high]) = key {
        let (low, high) = (format_number(low), format_number(high));
        notes.push(Note::Reading(format!("{name}: colours from {low} to {high}")));
    }
    Ok(LoadedData { session, notes, bounds, key, frame })
}

/// The wanted frame, or the first one with particles.
fn read_frame<R: Input>(source: &mut Source<R>, options: &DataOptions) -> Result<(usize, Import)> {
    let frames = source.frames().len();
    if let Some(frame) = options.frame {
        if frame >= frames {
            bail!(
                "there is no frame {frame}; the file has {} (0 to {})",
                counted(frames, "frame"),
                frames - 1
            );
        }
        return Ok((frame, source.read(frame, &options.read)?));
    }
    for frame in 0..frames {
        let import = source.read(frame, &options.read)?;
        let is_empty = matches!(&import.content, Content::Particles(particles) if particles.is_empty());
        if !is_empty || frame + 1 == frames {
            return Ok((frame, import));
        }
    }
    bail!("the file has no frame")
}

/// The name of the object that holds a file's data: letters, digits and underscores of its stem.
pub(super) fn scene_name(path: &Path) -> String {
    let stem = path.file_stem().and_then(|stem| stem.to_str()).unwrap_or("data");
    let name: String = stem.chars().map(|c| if c.is_alphanumeric() { c } else { '_' }).collect();
    if name.starts_with(|c: char| c.is_alphabetic()) { name } else { format!("data_{name}") }
}

/// A scene of a table of particles: the table, or an object of its images and the edges of the box.
fn particle_scene(
    name: &str,
    table: InstanceTable,
    simulation: Option<SimulationBox>,
    bounds: &Aabb,
    options: &DataOptions,
) -> Result<Session> {
    let mut scene = Scene::default();
    frame(&mut scene, bounds, options);
    if options.images.iter().all(|count| *count <= 1) && !options.shows_box {
        scene.add_table(name, table)?;
        return Ok(Session::with_scene(scene, Some(name)));
    }
    let Some(simulation) = simulation else {
        bail!("the file has no simulation box, which --images and --box need");
    };
    let held = format!("{name}_particles");
    scene.add_table(&held, table)?;
    scene.ensure_object(name)?;
    let offsets = image_offsets(&simulation, options);
    for (number, by) in offsets.iter().enumerate() {
        let alias = if number == 0 { held.clone() } else { format!("{held}_{number}") };
        scene.add_child(name, &alias, &held)?;
        if *by != DVec3::ZERO {
            scene.transform_child(name, TransformStep::Translate(*by))?;
        }
    }
    if options.shows_box {
        let edges = format!("{name}_box");
        scene.add_table(&edges, box_edges(&simulation)?)?;
        scene.add_child(name, &edges, &edges)?;
    }
    Ok(Session::with_scene(scene, Some(name)))
}

/// The offsets of the images of a box, the first one zero.
fn image_offsets(bounds: &SimulationBox, options: &DataOptions) -> Vec<DVec3> {
    let [x, y, z] = options.images.map(|count| count.max(1));
    let [a, b, c] = bounds.edges;
    let mut offsets = Vec::new();
    for k in 0..z {
        for j in 0..y {
            let row = (0..x).map(|i| a * f64::from(i) + b * f64::from(j) + c * f64::from(k));
            offsets.extend(row);
        }
    }
    offsets
}

/// The box around particles, their images and the edges of the simulation box.
fn bounds_of(particles: &Particles, options: &DataOptions) -> Aabb {
    let one = particles.reach();
    let Some(bounds) = &particles.bounds else { return one };
    let mut all = one;
    for by in image_offsets(bounds, options) {
        all = all.union(&Aabb { min: one.min + by, max: one.max + by });
    }
    if options.shows_box {
        let SimulationBox { origin, edges: [a, b, c], .. } = *bounds;
        for corner in [origin, origin + a, origin + b, origin + c, origin + a + b + c] {
            all = all.union(&Aabb::around(corner, DVec3::ZERO));
        }
    }
    all
}

/// Gives a scene the camera and the light of data. An empty box changes nothing.
pub(crate) fn frame(scene: &mut Scene, bounds: &Aabb, options: &DataOptions) {
    let size = options.size.unwrap_or((scene.picture.width, scene.picture.height));
    frame_data(scene, bounds, size);
}

/// The twelve edges of a box as thin cylinders.
fn box_edges(bounds: &SimulationBox) -> Result<InstanceTable> {
    let SimulationBox { origin, edges, .. } = *bounds;
    let diagonal = (edges[0] + edges[1] + edges[2]).length();
    let radius = 1.5e-3 * diagonal;
    let mut builder = TableBuilder::default();
    let material = builder.material(Material { color: DVec3::splat(0.2), ..Material::default() });
    // A cylinder with nearly flat ends.
    let exponents = Exponents::new(1.0, 0.02)?;
    for axis in 0..3 {
        let (along, [first, second]) = (edges[axis], [edges[(axis + 1) % 3], edges[(axis + 2) % 3]]);
        let Some(direction) = unit_vector(along) else { continue };
        let half = 0.5 * along.length() + radius;
        let shape = builder.shape(DVec3::new(radius, radius, half), exponents, material)?;
        for corner in [DVec3::ZERO, first, second, first + second] {
            let middle = origin + corner + 0.5 * along;
            builder.push(shape, middle, DQuat::from_rotation_arc(DVec3::Z, direction), None);
        }
    }
    Ok(builder.finish())
}
