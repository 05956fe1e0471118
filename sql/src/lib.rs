//! tumble's linear fit in SQL: `SELECT serial, tumble_fit() FROM 'runs/*.parquet' GROUP BY serial`.
//!
//! ```text
//! campaign -> Question -> tumble_fit() --(columns of the table)--> rows of the design -> triangle of each device -> one struct a device
//! ```
//!
//! The campaign file says which columns are angles, rates, values and uncertainties, so that the user writes no design matrix. The state of a
//! device is the triangle of its readings (`tumble::batch::Part`), and states merge by a QR of stacked triangles: the answer does not depend
//! on how rows are dealt to partitions or machines.
//!
//! | file | subject |
//! |---|---|
//! | `question.rs` | the campaign file, and which columns of a table answer it |
//! | `function.rs` | `tumble_fit()` as DataFusion knows it, and the rule that gives it its columns |
//! | `groups.rs` | devices while their rows come: values to triangles |
//! | `positions.rs` | positions that were met, each evaluated once |
//! | `whole.rs` | `tumble_fit_exact()`: devices whose rows are kept together |
//! | `answer.rs` | one struct a device |
//! | `cluster.rs` | the same on several machines, by Ballista (feature `cluster`) |
//! | `local.rs` | scheduler and executors on this machine, for trying |
//! | `output.rs` | tables for people, CSV, Parquet, JSON lines |
//! | `error.rs` | what can be wrong with a question |

mod answer;
#[cfg(feature = "cluster")]
pub mod cluster;
mod error;
mod function;
mod groups;
#[cfg(feature = "cluster")]
pub mod local;
pub mod output;
mod positions;
mod question;
mod whole;

pub use error::{Error, Result};
pub use function::{Columns, EXACT, FIT, Fit, own};
pub use question::Question;

use datafusion::execution::FunctionRegistry;
use datafusion::logical_expr::AggregateUDF;
use datafusion::prelude::SessionContext;
use std::sync::Arc;

/// Make `tumble_fit()` and `tumble_fit_exact()` known to a session, for one campaign.
///
/// ```
/// # tokio::runtime::Runtime::new().unwrap().block_on(async {
/// use datafusion::prelude::*;
/// let folder = tempfile::tempdir().unwrap();
/// let file = folder.path().join("line.campaign.json");
/// std::fs::write(&file, r#"{ "bench": { "id": "line", "sensors": { "y": { "model": "a + b*x" } } },
///     "estimate": { "a": {}, "b": {} }, "readings": [] }"#).unwrap();
/// let ctx = SessionContext::new();
/// tumble_sql::register(&ctx, &tumble_sql::Question::read(&file).unwrap()).unwrap();
/// let rows = ctx.sql("SELECT f.b FROM (SELECT tumble_fit() AS f FROM (VALUES (0, 1.0), (1, 3.0), (2, 5.0)) AS t(x, y))").await.unwrap();
/// let slope = rows.collect().await.unwrap()[0].column(0).clone();
/// let slope = datafusion::arrow::array::AsArray::as_primitive::<datafusion::arrow::datatypes::Float64Type>(&slope).value(0);
/// assert!((slope - 2.0).abs() < 1e-15);
/// # });
/// ```
///
/// # Errors
///
/// A campaign that is malformed.
pub fn register(ctx: &SessionContext, question: &Question) -> Result<()> {
    let question = Arc::new(question.clone());
    let state = ctx.state_ref();
    let mut state = state.write();
    for exact in [false, true] {
        let function = AggregateUDF::from(Fit::new(Arc::clone(&question), exact)?);
        state.register_udaf(Arc::new(function))?;
    }
    if !state.analyzer().rules.iter().any(|rule| rule.name() == "tumble_columns") {
        state.add_analyzer_rule(Arc::new(Columns));
    }
    Ok(())
}
