//! Writing a binary scene.

use std::io::{self, Write};

use superegg_scene::InstanceTable;
use twox_hash::XxHash3_128;

use super::bytes::{Facets, Fixed};
use super::layout::{END, HAS_FACETS, HAS_IDS, SIGNATURE, TABLE, TEXT};

/// The number of bytes that are collected before they are written.
const BLOCK: usize = 1 << 16;

/// Writes a scene: the text of everything but the tables, and the tables with their names.
///
/// # Errors
/// The stream cannot be written.
///
/// ```
/// use superegg_exchange::sqb;
/// use superegg_scene::InstanceTable;
///
/// let mut bytes = Vec::new();
/// sqb::write(&mut bytes, "object grains\n", &[("grains", &InstanceTable::default())])?;
/// let scene = sqb::read(&mut std::io::Cursor::new(bytes)).unwrap();
/// assert_eq!((scene.text.as_str(), scene.tables.len()), ("object grains\n", 1));
/// # Ok::<(), std::io::Error>(())
/// ```
pub fn write(output: &mut dyn Write, text: &str, tables: &[(&str, &InstanceTable)]) -> io::Result<()> {
    output.write_all(&SIGNATURE)?;
    for (name, table) in tables {
        let mut section = Section::begin(output, TABLE, table_length(name, table))?;
        section.put(&(name.len() as u32))?;
        section.bytes(name.as_bytes())?;
        section.put(&(table.len() as i64))?;
        section.put(&(table.shapes().len() as u32))?;
        section.put(&(table.materials().len() as u32))?;
        let ids = if table.ids().is_some() { HAS_IDS } else { 0 };
        section.put(&(ids | if has_facets(table) { HAS_FACETS } else { 0 }))?;
        table.materials().iter().try_for_each(|material| section.put(material))?;
        if has_facets(table) {
            table.materials().iter().try_for_each(|material| section.put(&Facets::of(material)))?;
        }
        table.shapes().try_for_each(|shape| section.put(&shape))?;
        (0..table.len()).try_for_each(|row| section.put(&table.shape_index(row)))?;
        (0..table.len()).try_for_each(|row| section.put(&table.position(row)))?;
        (0..table.len()).try_for_each(|row| section.put(&table.raw_rotation(row)))?;
        table.ids().into_iter().flat_map(|ids| ids.iter()).try_for_each(|id| section.put(id))?;
        section.end()?;
    }
    let mut section = Section::begin(output, TEXT, text.len() as u64)?;
    section.bytes(text.as_bytes())?;
    section.end()?;
    Section::begin(output, END, 0)?.end()
}

/// Whether a material of a table has facets. Files without them are those of older programs.
fn has_facets(table: &InstanceTable) -> bool {
    table.materials().iter().any(|material| material.facet_roughness().is_some())
}

/// The length of a table's payload.
fn table_length(name: &str, table: &InstanceTable) -> u64 {
    use superegg_geom::glam::{DQuat, DVec3};
    use superegg_scene::{Material, TableShape};
    let id = if table.ids().is_some() { i64::BYTES } else { 0 };
    let row = u32::BYTES + DVec3::BYTES + DQuat::BYTES + id;
    let length = 4 * u32::BYTES
        + name.len()
        + i64::BYTES
        + table.materials().len() * (Material::BYTES + if has_facets(table) { Facets::BYTES } else { 0 })
        + table.shapes().len() * TableShape::BYTES
        + table.len() * row;
    length as u64
}

/// A section that is being written.
struct Section<'a> {
    output: &'a mut dyn Write,
    block: Vec<u8>,
    hash: twox_hash::xxhash3_128::Hasher,
}

impl<'a> Section<'a> {
    fn begin(output: &'a mut dyn Write, tag: [u8; 4], length: u64) -> io::Result<Self> {
        output.write_all(&tag)?;
        output.write_all(&length.to_le_bytes())?;
        Ok(Self { output, block: Vec::with_capacity(2 * BLOCK), hash: XxHash3_128::new() })
    }

    fn put(&mut self, value: &impl Fixed) -> io::Result<()> {
        value.put(&mut self.block);
        if self.block.len() < BLOCK { Ok(()) } else { self.flush() }
    }

    fn bytes(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.block.extend_from_slice(bytes);
        self.flush()
    }

    fn flush(&mut self) -> io::Result<()> {
        self.hash.write(&self.block);
        self.output.write_all(&self.block)?;
        self.block.clear();
        Ok(())
    }

    fn end(mut self) -> io::Result<()> {
        self.flush()?;
        self.output.write_all(&self.hash.finish_128().to_le_bytes())
    }
}
