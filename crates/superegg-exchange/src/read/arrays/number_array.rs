//! Arrays of numbers, as array files hold them.

use crate::read::error::ReadError;

/// An array of numbers in C order: the last index varies fastest.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct NumberArray {
    /// The length along each axis.
    pub(crate) shape: Vec<usize>,
    /// The numbers; as many as the product of the lengths.
    pub(crate) values: Vec<f64>,
}

impl NumberArray {
    /// An array whose values are in Fortran order: the first index varies fastest.
    pub(crate) fn from_fortran(shape: Vec<usize>, values: &[f64]) -> Self {
        let mut strides = Vec::with_capacity(shape.len());
        let mut stride = 1;
        for &length in &shape {
            strides.push(stride);
            stride *= length;
        }
        let mut index = vec![0_usize; shape.len()];
        let mut position = 0;
        let ordered = (0..values.len()).map(|_| {
            let value = values[position];
            // The next index in C order.
            for axis in (0..shape.len()).rev() {
                index[axis] += 1;
                position += strides[axis];
                if index[axis] < shape[axis] {
                    break;
                }
                index[axis] = 0;
                position -= strides[axis] * shape[axis];
            }
            value
        });
        let values = ordered.collect();
        Self { shape, values }
    }

    /// The array as rows of `width` numbers: the last axis has that length, or the array is one row.
    pub(crate) fn rows(&self, width: usize, name: &str) -> Result<Vec<&[f64]>, ReadError> {
        if self.shape.last() == Some(&width) {
            return Ok(self.values.chunks_exact(width).collect());
        }
        let message = format!("expected rows of {width} numbers, found the shape {}", self.shape_text());
        Err(ReadError::part(name, message))
    }

    /// The shape as Python writes it: `(4, 11)`.
    pub(crate) fn shape_text(&self) -> String {
        let lengths: Vec<String> = self.shape.iter().map(usize::to_string).collect();
        let comma = if lengths.len() == 1 { "," } else { "" };
        format!("({}{comma})", lengths.join(", "))
    }

    /// The transposed array of two axes.
    pub(crate) fn transposed(&self) -> Self {
        let (rows, columns) = match self.shape[..] {
            [rows, columns] => (rows, columns),
            _ => return self.clone(),
        };
        let values =
            (0..columns).flat_map(|column| (0..rows).map(move |row| self.values[row * columns + column]));
        Self { values: values.collect(), shape: vec![columns, rows] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fortran_order_becomes_c_order() {
        let array = NumberArray::from_fortran(vec![2, 3], &[0.0, 10.0, 1.0, 11.0, 2.0, 12.0]);
        assert_eq!(array.values, [0.0, 1.0, 2.0, 10.0, 11.0, 12.0]);
        assert_eq!(array.transposed().values, [0.0, 10.0, 1.0, 11.0, 2.0, 12.0]);
        let value = |i: usize, j: usize, k: usize| (100 * i + 10 * j + k) as f64;
        let mut fortran = Vec::new();
        for k in 0..4 {
            for j in 0..3 {
                fortran.extend((0..2).map(|i| value(i, j, k)));
            }
        }
        let array = NumberArray::from_fortran(vec![2, 3, 4], &fortran);
        let mut at = array.values.iter();
        for i in 0..2 {
            for j in 0..3 {
                for k in 0..4 {
                    assert_eq!(at.next(), Some(&value(i, j, k)));
                }
            }
        }
        assert!(NumberArray::from_fortran(vec![0, 3], &[]).values.is_empty());
        assert_eq!(NumberArray::from_fortran(vec![], &[7.0]).values, [7.0]);
    }

    #[test]
    fn a_row_of_another_width_is_an_error() {
        let array = NumberArray { shape: vec![2, 3], values: vec![0.0; 6] };
        assert_eq!(array.rows(3, "size").unwrap().len(), 2);
        let message = array.rows(4, "size").unwrap_err().to_string();
        assert_eq!(message, "'size': expected rows of 4 numbers, found the shape (2, 3)");
        assert_eq!(NumberArray { shape: vec![5], values: vec![0.0; 5] }.shape_text(), "(5,)");
    }
}
