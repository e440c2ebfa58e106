//! The side panel, the help and the texts over the scene. A change in the panel leaves as lines of
//! the modelling language.

mod add;
mod edit;
mod eye;
mod fields;
mod file_dialog;
mod files;
mod handles;
mod menu;
mod model;
mod naming;
mod pictures;
mod scene;
mod sections;
mod texts;
mod tree;
mod view;

pub(crate) use files::{FileEvent, Files, document_name};
pub(crate) use model::{PanelEvent, PanelModel};
pub(crate) use sections::Panel;
