//! Parts of the library that nothing public shows alone. Their files are compiled here once more by themselves, beside the public library, and asked directly: so the
//! library need not be compiled a second time for tests of its own, and nothing is public for their sake.
#![allow(dead_code, unused_imports, reason = "a file stands here as a whole, and a test asks a part of it")]

mod algebra;
mod batch;
#[path = "../alone/bench.rs"]
mod bench;
mod clocks;
mod earth;
#[path = "../../src/elements.rs"]
mod elements;
mod estimate;
mod expressions;
#[path = "../../src/linear.rs"]
mod linear;
mod lists;
#[path = "../../src/mix.rs"]
mod mix;
mod navigate;
mod noise;
#[path = "../../src/number.rs"]
mod number;
mod numbers;
mod plan;
mod plot;
mod quality;
mod quantiles;
mod record;
mod reduce;
mod streamed;
mod uncertainty;
mod unit_texts;
#[path = "../../src/units/mod.rs"]
mod units;
mod units_of_certificates;
#[path = "../../src/vocabulary.rs"]
mod vocabulary;
mod words;

use tumble::error;
