//! The binary scene file (.sqb): the text of a scene, and its tables of instances as columns.
//!
//! All numbers are little-endian. The file is the signature, then sections, each of a tag (4
//! bytes), the length of its payload (u64), the payload, and the XXH3-128 checksum of the payload
//! (16 bytes). A section `TABL` for each table, then `TEXT`, then `END ` with an empty payload.
//! The text has the language's commands for everything but the tables; it runs on a scene that has
//! them.

mod bytes;
mod layout;
mod read;
mod write;

pub use layout::{BinaryScene, SIGNATURE, SqbError};
pub use read::read;
pub use write::write;

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use superegg_geom::glam::{DQuat, DVec3};
    use superegg_scene::{InstanceTable, Material, TableColumns};

    use super::*;

    fn table(materials: Vec<Material>) -> InstanceTable {
        let columns = TableColumns {
            materials,
            shapes: Vec::new(),
            shape_of: Vec::new(),
            positions: Vec::<DVec3>::new(),
            rotations: Vec::<DQuat>::new(),
            ids: None,
        };
        InstanceTable::from_columns(columns).unwrap()
    }

    #[test]
    fn facets_are_kept_and_cost_no_byte_where_there_are_none() {
        let plain = Material::default();
        let bytes = |materials: Vec<Material>| {
            let (mut bytes, table) = (Vec::new(), table(materials));
            write(&mut bytes, "", &[("t", &table)]).unwrap();
            assert_eq!(read(&mut Cursor::new(bytes.clone())).unwrap().tables, [("t".to_owned(), table)]);
            bytes.len()
        };
        let rough = Material { roughness: Some(0.25), ..plain };
        let metal = Material { metallic: 1.0, ..plain };
        assert_eq!(bytes(vec![plain, rough, metal]), bytes(vec![plain; 3]) + 3 * 16);
    }
}
