//! Tables of instances: many superquadrics as columns.

use std::collections::HashMap;
use std::hash::Hasher;
use std::sync::Arc;

use foldhash::fast::RandomState;
use superegg_geom::glam::{DQuat, DVec3};
use superegg_geom::{Exponents, ShapeError, Superquadric, Transform};
use thiserror::Error;

use crate::numbers::Numbers;
use crate::primitive::Material;

/// A shape of a table with its material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TableShape {
    /// The semi-axes, finite and above 0.
    pub radii: DVec3,
    /// The exponents.
    pub exponents: Exponents,
    /// The index of its material in [`InstanceTable::materials`].
    pub material: u32,
}

/// Many instances of superquadrics, as columns: shape, position, rotation, id.
///
/// A row takes 50 to 90 bytes, far less than a named child. A table comes from data, such as
/// particles of a simulation, and never changes.
///
/// ```
/// use superegg_geom::glam::{DQuat, DVec3};
/// use superegg_geom::Exponents;
/// use superegg_scene::{InstanceTable, Material, TableBuilder};
///
/// let mut builder = TableBuilder::default();
/// let white = builder.material(Material::default());
/// let shape = builder.shape(DVec3::new(1.0, 1.0, 2.0), Exponents::ROUND, white)?;
/// builder.push(shape, DVec3::new(5.0, 0.0, 0.0), DQuat::IDENTITY, Some(17));
/// let table: InstanceTable = builder.finish();
/// assert_eq!((table.len(), table.name(0).as_str()), (1, "p17"));
/// assert_eq!(table.transform(0).forward().translation.x, 5.0);
/// # Ok::<(), superegg_geom::ShapeError>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct InstanceTable {
    /// The semi-axes of each shape.
    radii: Numbers<3>,
    /// The index in `kinds` of each shape.
    kind_of: Vec<u32>,
    kinds: Vec<Kind>,
    materials: Vec<Material>,
    shape_of: Vec<u32>,
    positions: Numbers<3>,
    /// As x, y, z, w, of unit length to a few digits.
    rotations: Numbers<4>,
    ids: Option<Arc<[i64]>>,
}

/// The part that many shapes of different sizes share.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Kind {
    exponents: Exponents,
    material: u32,
}

impl InstanceTable {
    /// A table of these columns.
    ///
    /// # Errors
    /// Columns of different lengths, a shape or material that does not exist, or numbers that make
    /// no shape, position or rotation.
    pub fn from_columns(columns: TableColumns) -> Result<Self, TableError> {
        let TableColumns { shapes, materials, shape_of, positions, rotations, ids } = columns;
        let rows = shape_of.len();
        if positions.len() != rows
            || rotations.len() != rows
            || ids.as_ref().is_some_and(|ids| ids.len() != rows)
        {
            return Err(TableError::Lengths);
        }
        if let Some(row) = shape_of.iter().position(|shape| *shape as usize >= shapes.len()) {
            return Err(TableError::Row { row, what: "shape" });
        }
        if let Some(row) = positions.iter().position(|position| !position.is_finite()) {
            return Err(TableError::Row { row, what: "position" });
        }
        if let Some(row) = rotations.iter().position(|rotation| !rotation.is_normalized()) {
            return Err(TableError::Row { row, what: "rotation" });
        }
        let mut builder = TableBuilder::default();
        for TableShape { radii, exponents, material } in shapes {
            if material as usize >= materials.len() || !is_size(radii) {
                return Err(TableError::Shape);
            }
            builder.append_shape(radii, exponents, material);
        }
        let mut table = builder.table;
        table.materials = materials;
        table.shape_of = shape_of;
        positions.iter().for_each(|position| table.positions.push(position.to_array()));
        rotations.iter().for_each(|rotation| table.rotations.push(rotation.to_array()));
        table.ids = ids.map(Into::into);
        Ok(table)
    }

    /// The number of rows.
    pub fn len(&self) -> usize {
        self.shape_of.len()
    }

    /// Whether the table has no row.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The shapes. Rows may share one.
    pub fn shapes(&self) -> impl ExactSizeIterator<Item = TableShape> + '_ {
        (0..self.kind_of.len()).map(|shape| self.shape_at(shape))
    }

    /// The shape of this index.
    #[inline]
    fn shape_at(&self, shape: usize) -> TableShape {
        let Kind { exponents, material } = self.kinds[self.kind_of[shape] as usize];
        TableShape { radii: DVec3::from_array(self.radii.get(shape)), exponents, material }
    }

    /// The materials. Shapes may share one.
    pub fn materials(&self) -> &[Material] {
        &self.materials
    }

    /// The index in [`InstanceTable::shapes`] of a row's shape.
    ///
    /// # Panics
    /// If the row is not below [`InstanceTable::len`]. So do the other methods that take a row.
    #[inline]
    pub fn shape_index(&self, row: usize) -> u32 {
        self.shape_of[row]
    }

    /// The shape of a row.
    #[inline]
    pub fn shape(&self, row: usize) -> TableShape {
        self.shape_at(self.shape_of[row] as usize)
    }

    /// The material of a row.
    pub fn material(&self, row: usize) -> &Material {
        &self.materials[self.shape(row).material as usize]
    }

    /// The superquadric of a row, centred at the origin.
    pub fn superquadric(&self, row: usize) -> Superquadric {
        let TableShape { radii, exponents, .. } = self.shape(row);
        // The builder has checked the semi-axes.
        Superquadric::new(radii, exponents).unwrap_or_else(|_| Superquadric::unit(exponents))
    }

    /// The centre of a row.
    #[inline]
    pub fn position(&self, row: usize) -> DVec3 {
        DVec3::from_array(self.positions.get(row))
    }

    /// The rotation of a row from the space of its shape, a unit quaternion.
    #[inline]
    pub fn rotation(&self, row: usize) -> DQuat {
        DQuat::from_array(self.rotations.get(row)).normalize()
    }

    /// The rotation of a row as it was pushed: of unit length to a few digits.
    pub fn raw_rotation(&self, row: usize) -> DQuat {
        DQuat::from_array(self.rotations.get(row))
    }

    /// The map from the space of a row's shape to the space of the table.
    #[inline]
    pub fn transform(&self, row: usize) -> Transform {
        Transform::rigid(self.rotation(row), self.position(row))
    }

    /// The ids of the rows; `None` if the data has none.
    pub fn ids(&self) -> Option<&Arc<[i64]>> {
        self.ids.as_ref()
    }

    /// The name of a row in paths: "p" and its id, or its number from 1 if the data has no ids.
    pub fn name(&self, row: usize) -> String {
        row_name(self.ids.as_deref(), row)
    }

    /// Feeds all columns to a hasher. Equal tables give equal hashes.
    pub fn hash_columns(&self, hasher: &mut impl Hasher) {
        self.radii.hash(hasher);
        hasher.write(bytemuck::cast_slice(&self.kind_of));
        for Kind { exponents, material } in &self.kinds {
            [exponents.e(), exponents.n(), f64::from(*material)]
                .iter()
                .for_each(|x| hasher.write_u64(x.to_bits()));
        }
        hasher.write(bytemuck::cast_slice(&self.shape_of));
        self.positions.hash(hasher);
        self.rotations.hash(hasher);
        if let Some(ids) = &self.ids {
            hasher.write(bytemuck::cast_slice(ids));
        }
    }

    /// A hash of all columns, the same on every machine: FNV-1a over the bits of the numbers.
    pub fn fingerprint(&self) -> u64 {
        let mut hash = 0xcbf2_9ce4_8422_2325_u64;
        let mut mix = |word: u64| hash = (hash ^ word).wrapping_mul(0x0100_0000_01b3).rotate_left(29);
        for shape in self.shapes() {
            let numbers =
                [shape.radii.x, shape.radii.y, shape.radii.z, shape.exponents.e(), shape.exponents.n()];
            numbers.iter().for_each(|number| mix(number.to_bits()));
            mix(shape.material.into());
        }
        for material in &self.materials {
            format!("{material:?}").bytes().for_each(|byte| mix(byte.into()));
        }
        for row in 0..self.len() {
            mix(self.shape_of[row].into());
            self.positions.get(row).iter().for_each(|number| mix(number.to_bits()));
            self.rotations.get(row).iter().for_each(|number| mix(number.to_bits()));
        }
        self.ids.iter().flat_map(|ids| ids.iter()).for_each(|id| mix(*id as u64));
        hash
    }

    /// The memory of the columns, in bytes.
    pub fn bytes(&self) -> usize {
        self.radii.bytes()
            + self.kind_of.capacity() * size_of::<u32>()
            + self.kinds.capacity() * size_of::<Kind>()
            + self.materials.capacity() * size_of::<Material>()
            + self.shape_of.capacity() * size_of::<u32>()
            + self.positions.bytes()
            + self.rotations.bytes()
            + self.ids.as_ref().map_or(0, |ids| ids.len() * size_of::<i64>())
    }
}

/// The columns of an [`InstanceTable`], for files.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TableColumns {
    /// The shapes.
    pub shapes: Vec<TableShape>,
    /// The materials.
    pub materials: Vec<Material>,
    /// The shape of each row.
    pub shape_of: Vec<u32>,
    /// The centre of each row.
    pub positions: Vec<DVec3>,
    /// The rotation of each row, a unit quaternion.
    pub rotations: Vec<DQuat>,
    /// The id of each row, if the data has some.
    pub ids: Option<Vec<i64>>,
}

/// Why columns are no table.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum TableError {
    /// The columns differ in length.
    #[error("the columns of the table differ in length")]
    Lengths,
    /// A shape has no valid semi-axes or no material.
    #[error("a shape of the table has semi-axes that are not above 0, or no material")]
    Shape,
    /// A row is not valid.
    #[error("row {row} of the table has no valid {what}")]
    Row {
        /// The row, counted from 0.
        row: usize,
        /// The invalid column.
        what: &'static str,
    },
}

/// Whether semi-axes are finite and above 0.
fn is_size(radii: DVec3) -> bool {
    radii.to_array().iter().all(|radius| radius.is_finite() && *radius > 0.0)
}

/// The name of a row of a table with these ids.
pub fn row_name(ids: Option<&[i64]>, row: usize) -> String {
    match ids {
        Some(ids) => format!("p{}", ids[row]),
        None => format!("p{}", row + 1),
    }
}

/// Rows share equal shapes up to this many. Data with more has a shape of its own in nearly every
/// row, and looking for equal ones would take more memory than they do.
const MOST_SHARED: usize = 1 << 14;

/// Builds an [`InstanceTable`] row by row.
#[derive(Clone, Debug, Default)]
pub struct TableBuilder {
    table: InstanceTable,
    shape_of_bits: HashMap<[u64; 6], u32, RandomState>,
    kind_of_bits: HashMap<[u64; 3], u32, RandomState>,
    ids: Vec<i64>,
}

impl TableBuilder {
    /// Makes room for this many rows.
    pub fn reserve(&mut self, rows: usize) {
        self.table.shape_of.reserve_exact(rows);
        self.table.positions.reserve(rows);
        self.table.rotations.reserve(rows);
    }

    /// Adds a material and returns its index. Call it once for each distinct material.
    pub fn material(&mut self, material: Material) -> u32 {
        self.table.materials.push(material);
        self.table.materials.len() as u32 - 1
    }

    /// The index of a shape, which is added if it is new.
    ///
    /// # Errors
    /// [`ShapeError::Radius`] if a semi-axis is not finite and above 0.
    pub fn shape(&mut self, radii: DVec3, exponents: Exponents, material: u32) -> Result<u32, ShapeError> {
        let new = self.table.kind_of.len() as u32;
        if self.table.kind_of.len() < MOST_SHARED {
            let [a, b, c] = radii.to_array().map(f64::to_bits);
            let bits = [a, b, c, exponents.e().to_bits(), exponents.n().to_bits(), material.into()];
            match self.shape_of_bits.get(&bits) {
                Some(&shape) => return Ok(shape),
                None => self.shape_of_bits.insert(bits, new),
            };
        }
        if !is_size(radii) {
            return Err(ShapeError::Radius);
        }
        self.append_shape(radii, exponents, material);
        Ok(new)
    }

    fn append_shape(&mut self, radii: DVec3, exponents: Exponents, material: u32) {
        let bits = [exponents.e().to_bits(), exponents.n().to_bits(), material.into()];
        let kinds = &mut self.table.kinds;
        let kind = *self.kind_of_bits.entry(bits).or_insert_with(|| {
            kinds.push(Kind { exponents, material });
            kinds.len() as u32 - 1
        });
        self.table.kind_of.push(kind);
        self.table.radii.push(radii.to_array());
    }

    /// Appends a row: an instance of a shape with this position and rotation, a quaternion of unit
    /// length to a few digits.
    /// Either all rows have an id or none.
    pub fn push(&mut self, shape: u32, position: DVec3, rotation: DQuat, id: Option<i64>) {
        self.table.shape_of.push(shape);
        self.table.positions.push(position.to_array());
        self.table.rotations.push(rotation.to_array());
        self.ids.extend(id);
    }

    /// The table. Ids are dropped if a row lacks one, or if they are the row numbers from 1.
    pub fn finish(self) -> InstanceTable {
        let Self { mut table, ids, .. } = self;
        let are_numbers = ids.iter().zip(1..).all(|(&id, number)| id == number);
        table.ids = (ids.len() == table.len() && !are_numbers).then(|| ids.into());
        table.radii.shrink();
        table.kind_of.shrink_to_fit();
        table.materials.shrink_to_fit();
        table
    }
}
