//! Files: access with checks, the folders of the user, scene files, pictures, CSV and the answers to its rows.

mod access;
pub(crate) mod answers;
pub(crate) mod binary_scene;
pub(crate) mod csv;
pub(crate) mod data;
pub(crate) mod folders;
mod no_scene;
pub(crate) mod picture;
pub(crate) mod scene;
pub(crate) mod series;

pub(crate) use access::{
    begins_with, check_creatable, check_not_pipe, check_output, check_plain_file, is_standard_stream, write,
};
