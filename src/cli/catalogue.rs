//! The effects that a diagnosis or a plan tries: the built-in catalogue, after a user's own.

use super::files;
use crate::diagnosis::Effect;
use crate::error::{Malformed, Result};
use crate::wire::{self, Source};
use std::path::Path;

pub(super) struct Catalogue {
    pub effects: Vec<Effect>,
    /// The user's own file.
    file: Option<Source>,
}

impl Catalogue {
    /// The user's effects first, so that their names are used where both have the same term.
    pub fn new(file: Option<Source>) -> Result<Self> {
        let mut effects = match &file {
            Some(source) => wire::read_effects(source)?,
            None => Vec::new(),
        };
        effects.extend(wire::built_in_effects()?);
        Ok(Catalogue { effects, file })
    }

    /// The place of an error: the user's catalogue where it is about an effect, else the campaign.
    pub fn locate(&self, error: Malformed, campaign: &Source) -> Malformed {
        match &self.file {
            Some(effects) if error.place().path.starts_with("effects[") => wire::locate(error, effects),
            _ => wire::locate(error, campaign),
        }
    }
}

/// The built-in catalogue, after a user's own.
pub(super) fn catalogue(path: Option<&Path>) -> Result<Catalogue> {
    Catalogue::new(path.map(files::read).transpose()?)
}
