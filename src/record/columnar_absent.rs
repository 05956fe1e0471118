//! In place of Parquet where the crate is built without the feature `parquet`: opening one is an error that says so.

use super::{As, Block, Column};
use crate::error::{Fault, Malformed, Result};
use std::fs::File;

/// An open Parquet file: there is none.
#[derive(Debug)]
pub enum Columnar {}

impl Columnar {
    /// Always an error.
    pub(super) fn open(name: &str, _: File) -> Result<Self> {
        Err(Malformed::new(Fault::Value, "this build reads no Parquet")
            .expected("a table of text, or tumble built with its feature 'parquet'")
            .in_file(name))
    }

    /// Its columns.
    pub(super) fn columns(&self) -> &[Column] {
        match *self {}
    }

    /// Does a column hold texts?
    pub(super) fn is_text(&self, _: usize) -> bool {
        match *self {}
    }

    /// Which columns are read.
    pub(super) fn select(&mut self, _: &[(usize, As)]) {
        match *self {}
    }

    /// Forget the labels.
    pub(super) fn forget_labels(&mut self) {
        match *self {}
    }

    /// The next rows.
    pub(super) fn next(&mut self, _: &mut Block) -> Result<bool> {
        match *self {}
    }

    /// The labels met so far.
    pub(super) fn labels(&self) -> &[String] {
        match *self {}
    }

    /// How many rows it has.
    pub(super) fn rows(&self) -> u64 {
        match *self {}
    }

    /// The file's name.
    pub(super) fn name(&self) -> &str {
        match *self {}
    }
}
