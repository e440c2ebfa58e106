//! Reading a binary scene.

use std::io::SeekFrom;

use superegg_geom::glam::{DQuat, DVec3};
use superegg_scene::{InstanceTable, Material, TableColumns, TableShape};
use twox_hash::XxHash3_128;

use super::bytes::{Facets, Fixed};
use super::layout::{BinaryScene, END, HAS_FACETS, HAS_IDS, SIGNATURE, SqbError, TABLE, TEXT};
use crate::read::Input;

/// The number of bytes that are read at a time.
const BLOCK: usize = 1 << 16;

/// Reads a binary scene. Nothing is reserved that the file does not have bytes for.
///
/// # Errors
/// The stream cannot be read, or the file is incomplete, damaged or wrong.
pub fn read(input: &mut dyn Input) -> Result<BinaryScene, SqbError> {
    let length = input.seek(SeekFrom::End(0))?;
    input.seek(SeekFrom::Start(0))?;
    let mut signature = [0; SIGNATURE.len()];
    if length < SIGNATURE.len() as u64 {
        return Err(SqbError::Signature);
    }
    input.read_exact(&mut signature)?;
    if signature != SIGNATURE {
        return Err(SqbError::Signature);
    }
    let mut scene = BinaryScene::default();
    let mut left = length - SIGNATURE.len() as u64;
    for number in 1.. {
        let (mut section, tag) = Section::begin(input, number, &mut left)?;
        match tag {
            END => {
                section.end()?;
                break;
            }
            TEXT => {
                let text = section.bytes(section.left)?;
                section.end()?;
                scene.text = String::from_utf8(text).map_err(|_| wrong(number, "the text is not UTF-8"))?;
            }
            TABLE => {
                let (name, table) = read_table(&mut section)?;
                section.end()?;
                scene.tables.push((name, table));
            }
            _ => return Err(wrong(number, "the tag is unknown; a newer version may have written it")),
        }
    }
    Ok(scene)
}

fn wrong(section: u32, message: impl Into<String>) -> SqbError {
    SqbError::Section { section, message: message.into() }
}

fn read_table(section: &mut Section<'_>) -> Result<(String, InstanceTable), SqbError> {
    let name_length = section.value::<u32>()?;
    let name = section.bytes(name_length.into())?;
    let number = section.number;
    let name = String::from_utf8(name).map_err(|_| wrong(number, "the name is not UTF-8"))?;
    // It stands in lines of text, as one word.
    if name.is_empty() || name.contains(|c: char| c.is_whitespace() || c.is_control()) {
        return Err(wrong(number, "the name of the table is not a word"));
    }
    let rows = usize::try_from(section.value::<i64>()?).map_err(|_| wrong(number, "a negative count"))?;
    let (shapes, materials) = (section.value::<u32>()? as usize, section.value::<u32>()? as usize);
    let flags = section.value::<u32>()?;
    if flags & !(HAS_IDS | HAS_FACETS) != 0 {
        return Err(wrong(number, "a flag is unknown; a newer version may have written it"));
    }
    let mut materials = section.column::<Material>(materials)?;
    if flags & HAS_FACETS != 0 {
        let facets = section.column::<Facets>(materials.len())?;
        materials.iter_mut().zip(&facets).for_each(|(material, facets)| facets.set(material));
    }
    let columns = TableColumns {
        materials,
        shapes: section.column::<TableShape>(shapes)?,
        shape_of: section.column(rows)?,
        positions: section.column::<DVec3>(rows)?,
        rotations: section.column::<DQuat>(rows)?,
        ids: if flags & HAS_IDS != 0 { Some(section.column(rows)?) } else { None },
    };
    let table = InstanceTable::from_columns(columns).map_err(|error| wrong(number, error.to_string()))?;
    Ok((name, table))
}

/// A section that is being read.
struct Section<'a> {
    input: &'a mut dyn Input,
    number: u32,
    /// The bytes of the payload that are not read yet.
    left: u64,
    hash: twox_hash::xxhash3_128::Hasher,
}

impl<'a> Section<'a> {
    /// Begins the next section; `left` is the number of bytes left in the file.
    fn begin(input: &'a mut dyn Input, number: u32, left: &mut u64) -> Result<(Self, [u8; 4]), SqbError> {
        const AROUND: u64 = 4 + 8 + 16;
        if *left < AROUND {
            return Err(SqbError::Incomplete(number));
        }
        let (mut tag, mut length) = ([0; 4], [0; 8]);
        input.read_exact(&mut tag)?;
        input.read_exact(&mut length)?;
        let length = u64::from_le_bytes(length);
        if *left - AROUND < length {
            return Err(SqbError::Incomplete(number));
        }
        *left -= AROUND + length;
        Ok((Self { input, number, left: length, hash: XxHash3_128::new() }, tag))
    }

    fn bytes(&mut self, count: u64) -> Result<Vec<u8>, SqbError> {
        if count > self.left {
            return Err(wrong(self.number, "a count is larger than the section"));
        }
        let mut bytes = Vec::new();
        let length = usize::try_from(count).ok().filter(|length| bytes.try_reserve_exact(*length).is_ok());
        bytes.resize(length.ok_or_else(|| self.too_large())?, 0);
        self.input.read_exact(&mut bytes)?;
        self.left -= count;
        self.hash.write(&bytes);
        Ok(bytes)
    }

    fn value<T: Fixed>(&mut self) -> Result<T, SqbError> {
        let bytes = self.bytes(T::BYTES as u64)?;
        T::take(&bytes).ok_or_else(|| wrong(self.number, "a number is out of range"))
    }

    fn column<T: Fixed>(&mut self, count: usize) -> Result<Vec<T>, SqbError> {
        if count as u64 > self.left / T::BYTES as u64 {
            return Err(wrong(self.number, "a count is larger than the section"));
        }
        let mut values = Vec::new();
        // A hole in a file has a length and takes no disk.
        values.try_reserve_exact(count).map_err(|_| self.too_large())?;
        while values.len() < count {
            let part = (count - values.len()).min(BLOCK / T::BYTES);
            let bytes = self.bytes((part * T::BYTES) as u64)?;
            for bytes in bytes.chunks_exact(T::BYTES) {
                values.push(T::take(bytes).ok_or_else(|| wrong(self.number, "a number is out of range"))?);
            }
        }
        Ok(values)
    }

    fn too_large(&self) -> SqbError {
        wrong(self.number, "it is larger than the memory")
    }

    fn end(self) -> Result<(), SqbError> {
        if self.left > 0 {
            return Err(wrong(self.number, "bytes are left over"));
        }
        let mut checksum = [0; 16];
        self.input.read_exact(&mut checksum)?;
        if u128::from_le_bytes(checksum) != self.hash.finish_128() {
            return Err(SqbError::Checksum(self.number));
        }
        Ok(())
    }
}
