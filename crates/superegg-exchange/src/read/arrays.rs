//! Files of arrays: NumPy's and MATLAB's.

pub(crate) mod matlab;
pub(crate) mod npz;
pub(crate) mod number_array;
pub(crate) mod numpy;
