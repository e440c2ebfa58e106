//! Files: access with checks, the folders of the user, scene files, pictures, CSV and the answers to its rows.

mod access;
pub(crate) mod answers;
pub(crate) mod binary_scene;
pub(crate) mod csv;
pub(crate) mod data;
pub(crate) mod fingerprint;
pub(crate) mod folders;
pub(crate) mod kept_settings;
pub(crate) mod maker;
pub(crate) mod names;
mod no_scene;
pub(crate) mod notes;
pub(crate) mod picture;
pub(crate) mod recent;
pub(crate) mod scene;
pub(crate) mod series;
pub(crate) mod surroundings;
pub(crate) mod temporary;

pub(crate) use access::{
    Overwrite, begins_with, check_creatable, check_link, check_not_pipe, check_output, check_plain_file,
    check_target, is_standard_stream, read, write,
};
