//! The columns of a table, assigned to quantities.

use super::error::ReadError;
use super::layout::{Layout, Names};
use super::quantity::{self, LIST, Quantity};

/// The columns of a table, by name, for tables of no known program (`--columns`).
///
/// Written as `semi-axes=a,b,c;exponents=e,n;position=x,y,z;quaternion=w,x,y,z`. The quantities are
/// position, semi-axes, diameters, radius, diameter, exponents (e, n), blockiness (n1, n2),
/// quaternion (w, x, y, z), euler-ABC-deg and euler-ABC-rad (R = R_A R_B R_C, for example
/// euler-zyx-deg), color (0..1 linear or 0..255 sRGB) and id.
///
/// ```
/// use superegg_exchange::read::ColumnMap;
/// let map: ColumnMap = "position=px,py,pz;diameters=sx,sy,sz".parse()?;
/// assert_eq!(map.assignments[1].0, "diameters");
/// assert!("position=x,y".parse::<ColumnMap>().is_err());
/// # Ok::<(), superegg_exchange::read::ReadError>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ColumnMap {
    /// The pairs of a quantity and the names of its columns, in the order given.
    pub assignments: Vec<(String, Vec<String>)>,
}

impl std::str::FromStr for ColumnMap {
    type Err = ReadError;

    /// Reads `quantity=column,column;quantity=column`.
    fn from_str(text: &str) -> Result<Self, ReadError> {
        let assignment = |part: &str| {
            let (quantity, columns) = part.split_once('=')?;
            let columns: Vec<String> = columns.split(',').map(|name| name.trim().to_owned()).collect();
            let is_complete = !quantity.trim().is_empty() && columns.iter().all(|name| !name.is_empty());
            is_complete.then(|| (quantity.trim().to_ascii_lowercase(), columns))
        };
        let parts = text.split(';').filter(|part| !part.trim().is_empty());
        let assignments: Option<Vec<_>> = parts.map(assignment).collect();
        match assignments {
            Some(assignments) if !assignments.is_empty() => {
                let map = Self { assignments };
                check(&map)?;
                Ok(map)
            }
            Some(_) | None => Err(ReadError::File(format!(
                "expected quantities and columns, such as position=x,y,z;semi-axes=a,b,c; quantities: {LIST}"
            ))),
        }
    }
}

/// Checks the quantities of a map and the numbers of their columns.
///
/// # Errors
/// A quantity is unknown, has another number of columns, or stands beside one that gives the same.
fn check(map: &ColumnMap) -> Result<(), ReadError> {
    let mut subjects = Vec::new();
    for (name, columns) in &map.assignments {
        let Some(quantity) = Quantity::by_name(name) else {
            return Err(ReadError::part(name, format!("there is no such quantity; those are: {LIST}")));
        };
        if columns.len() != quantity.count() {
            let (wanted, found) = (quantity.count(), columns.len());
            return Err(ReadError::part(
                name,
                format!("expected {wanted} columns, found {found}; quantities: {LIST}"),
            ));
        }
        if subjects.contains(&quantity.subject()) {
            let message = format!("the {} is given twice", quantity.subject());
            return Err(ReadError::part(name, message));
        }
        subjects.push(quantity.subject());
    }
    Ok(())
}

/// Whether a map has the position.
pub(super) fn has_position(map: &ColumnMap) -> bool {
    map.assignments.iter().any(|(name, _)| Quantity::by_name(name) == Some(Quantity::Position))
}

/// Gives the columns of a map to a layout.
///
/// # Errors
/// The map is wrong, or a column is not there.
pub(super) fn assign(map: &ColumnMap, layout: &mut Layout) -> Result<(), ReadError> {
    check(map)?;
    for (name, wanted) in &map.assignments {
        let names = Names(&layout.names);
        let mut columns = Vec::with_capacity(wanted.len());
        for column in wanted {
            let message =
                || format!("there is no column '{column}'; the file has: {}", layout.names.join(", "));
            columns.push(names.one(column).ok_or_else(|| ReadError::part(name, message()))?);
        }
        if let Some(quantity) = Quantity::by_name(name) {
            quantity::set(layout, quantity, &columns);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wrong_maps_list_the_quantities() {
        for text in [
            "",
            "x",
            "position",
            "position=",
            "size=a",
            "position=x,y",
            "euler-zzy-deg=a,b,c",
            "euler-zyx=a,b,c",
        ] {
            let error = text.parse::<ColumnMap>().unwrap_err().to_string();
            assert!(error.contains("semi-axes (a,b,c)"), "{text}: {error}");
        }
        assert!("radius=r;semi-axes=a,b,c".parse::<ColumnMap>().is_err());
        assert!("id=i;euler-zyx-rad=a,b,c;".parse::<ColumnMap>().is_ok());
    }
}
