//! The side panel, the help and the texts over the scene. A change in the panel leaves as lines of
//! the modelling language.

mod edit;
mod fields;
mod model;
mod sections;
mod texts;
mod tree;
mod view;

pub(crate) use model::{PanelEvent, PanelModel};
pub(crate) use sections::Panel;
