//! Tables of instances: many superquadrics as columns.

use std::collections::HashMap;
use std::sync::Arc;

use foldhash::fast::RandomState;
use superegg_geom::glam::{DQuat, DVec3};
use superegg_geom::{Exponents, ShapeError, Superquadric, Transform};
use thiserror::Error;

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
/// A table takes about 100 bytes a row where a named child takes about 800. It comes from data,
/// such as particles of a simulation, and never changes.
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
    shapes: Vec<TableShape>,
    materials: Vec<Material>,
    shape_of: Vec<u32>,
    positions: Vec<DVec3>,
    rotations: Vec<DQuat>,
    ids: Option<Arc<[i64]>>,
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
        if shapes.iter().any(|shape| shape.material as usize >= materials.len() || !is_size(shape.radii)) {
            return Err(TableError::Shape);
        }
        if let Some(row) = positions.iter().position(|position| !position.is_finite()) {
            return Err(TableError::Row { row, what: "position" });
        }
        if let Some(row) = rotations.iter().position(|rotation| !rotation.is_normalized()) {
            return Err(TableError::Row { row, what: "rotation" });
        }
        Ok(Self { shapes, materials, shape_of, positions, rotations, ids: ids.map(Into::into) })
    }

    /// The number of rows.
    pub fn len(&self) -> usize {
        self.positions.len()
    }

    /// Whether the table has no row.
    pub fn is_empty(&self) -> bool {
        self.positions.is_empty()
    }

    /// The shapes. Rows may share one.
    pub fn shapes(&self) -> &[TableShape] {
        &self.shapes
    }

    /// The materials. Shapes may share one.
    pub fn materials(&self) -> &[Material] {
        &self.materials
    }

    /// The index in [`InstanceTable::shapes`] of a row's shape.
    ///
    /// # Panics
    /// If the row is not below [`InstanceTable::len`]. So do the other methods that take a row.
    pub fn shape_index(&self, row: usize) -> u32 {
        self.shape_of[row]
    }

    /// The shape of a row.
    pub fn shape(&self, row: usize) -> &TableShape {
        &self.shapes[self.shape_of[row] as usize]
    }

    /// The material of a row.
    pub fn material(&self, row: usize) -> &Material {
        &self.materials[self.shape(row).material as usize]
    }

    /// The superquadric of a row, centred at the origin.
    pub fn superquadric(&self, row: usize) -> Superquadric {
        let TableShape { radii, exponents, .. } = *self.shape(row);
        // The builder has checked the semi-axes.
        Superquadric::new(radii, exponents).unwrap_or_else(|_| Superquadric::unit(exponents))
    }

    /// The centre of a row.
    pub fn position(&self, row: usize) -> DVec3 {
        self.positions[row]
    }

    /// The rotation of a row from the space of its shape, a unit quaternion.
    pub fn rotation(&self, row: usize) -> DQuat {
        self.rotations[row]
    }

    /// The map from the space of a row's shape to the space of the table.
    pub fn transform(&self, row: usize) -> Transform {
        Transform::rigid(self.rotations[row], self.positions[row])
    }

    /// The ids of the rows; `None` if the data has none.
    pub fn ids(&self) -> Option<&Arc<[i64]>> {
        self.ids.as_ref()
    }

    /// The name of a row in paths: "p" and its id, or its number from 1 if the data has no ids.
    pub fn name(&self, row: usize) -> String {
        row_name(self.ids.as_deref(), row)
    }

    /// A hash of all columns, the same on every machine: FNV-1a over the bits of the numbers.
    pub fn fingerprint(&self) -> u64 {
        let mut hash = 0xcbf2_9ce4_8422_2325_u64;
        let mut mix = |word: u64| hash = (hash ^ word).wrapping_mul(0x0100_0000_01b3).rotate_left(29);
        for shape in &self.shapes {
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
            self.positions[row].to_array().iter().for_each(|number| mix(number.to_bits()));
            self.rotations[row].to_array().iter().for_each(|number| mix(number.to_bits()));
        }
        self.ids.iter().flat_map(|ids| ids.iter()).for_each(|id| mix(*id as u64));
        hash
    }

    /// The memory of the columns, in bytes.
    pub fn bytes(&self) -> usize {
        self.shapes.capacity() * size_of::<TableShape>()
            + self.materials.capacity() * size_of::<Material>()
            + self.shape_of.capacity() * size_of::<u32>()
            + self.positions.capacity() * size_of::<DVec3>()
            + self.rotations.capacity() * size_of::<DQuat>()
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
    ids: Vec<i64>,
}

impl TableBuilder {
    /// Makes room for this many rows.
    pub fn reserve(&mut self, rows: usize) {
        self.table.shape_of.reserve_exact(rows);
        self.table.positions.reserve_exact(rows);
        self.table.rotations.reserve_exact(rows);
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
        let new = self.table.shapes.len() as u32;
        if self.table.shapes.len() < MOST_SHARED {
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
        self.table.shapes.push(TableShape { radii, exponents, material });
        Ok(new)
    }

    /// Appends a row: an instance of a shape with this position and rotation, which is normalized.
    /// Either all rows have an id or none.
    pub fn push(&mut self, shape: u32, position: DVec3, rotation: DQuat, id: Option<i64>) {
        self.table.shape_of.push(shape);
        self.table.positions.push(position);
        self.table.rotations.push(rotation);
        self.ids.extend(id);
    }

    /// The table. Ids are dropped if a row lacks one, or if they are the row numbers from 1.
    pub fn finish(self) -> InstanceTable {
        let Self { mut table, ids, .. } = self;
        let are_numbers = ids.iter().zip(1..).all(|(&id, number)| id == number);
        table.ids = (ids.len() == table.len() && !are_numbers).then(|| ids.into());
        table.shapes.shrink_to_fit();
        table.materials.shrink_to_fit();
        table
    }
}
