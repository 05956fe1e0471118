//! Reports as pages that are not yet one document with the terminal's table: each returns a [`Page`], which is a `document`.

#[cfg(feature = "navigate")]
mod navigate;
#[cfg(feature = "navigate")]
mod navigate_diagnose;

pub use crate::document::html::render;
pub use crate::document::{
    Align, Cell, Content as PageBlock, Document as Page, Figure, MarkedLine, Section, Table, Tone,
};
#[cfg(feature = "navigate")]
pub use navigate::navigate_page;
#[cfg(feature = "navigate")]
pub use navigate_diagnose::{navigate_diagnose_page, navigate_diagnose_svg};
