//! Tables and numbers at a terminal, for the answers that are not one document yet.

pub use crate::document::number::{percent, rounded, significant, trimmed};
pub use crate::document::terminal::plain;
