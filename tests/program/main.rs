//! The program as a user meets it: files, errors, examples, pages, certificates, schemas.

mod api;
mod bad_input;
mod by;
mod circles;
mod cli;
mod columns;
mod conformity;
mod data_sources;
mod dcc;
mod documents;
mod doors;
#[path = "../draws/mod.rs"]
mod draws;
#[allow(dead_code, unused_imports, reason = "a file of the library stands here as a whole")]
#[path = "../../src/elements.rs"]
mod elements;
mod examples;
mod files;
mod html;
mod kept;
mod languages;
#[path = "../markup/mod.rs"]
mod markup;
mod missing_names;
mod mutated;
mod new;
mod schemas;
#[path = "../support/mod.rs"]
mod support;
mod threads;
mod width;
mod workbook;
#[allow(dead_code, reason = "a file of the library stands here as a whole")]
#[path = "../../src/document/wrap.rs"]
mod wrap;
