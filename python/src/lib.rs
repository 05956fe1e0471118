//! What Python calls. `package/tumble` makes a package of it.
//!
//! | file | subject |
//! |---|---|
//! | `work.rs` | work without the interpreter's lock, which Ctrl-C stops; errors |
//! | `table.rs` | tables of Python: Arrow's C interface, buffers, sequences |
//! | `question.rs` | campaigns from dicts, and templates of those that come again |
//! | `fit.rs` | one fit |
//! | `devices.rs` | many devices: arrays in, arrays out |
//! | `command.rs` | commands of the program, their tables; simulated readings |
//! | `converse.rs` | a command that is spoken with line by line |

mod command;
mod converse;
mod devices;
mod fit;
mod question;
mod table;
mod work;

use pyo3::prelude::*;

#[pymodule]
fn _tumble(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", tumble::report::VERSION)?;
    module.add("MalformedError", work::malformed(module.py())?)?;
    module.add_class::<fit::Fit>()?;
    module.add_class::<devices::Devices>()?;
    module.add_class::<converse::Conversation>()?;
    module.add_function(wrap_pyfunction!(converse::guide_text, module)?)?;
    module.add_function(wrap_pyfunction!(question::sensors, module)?)?;
    module.add_function(wrap_pyfunction!(fit::fit, module)?)?;
    module.add_function(wrap_pyfunction!(fit::report_table, module)?)?;
    module.add_function(wrap_pyfunction!(fit::report_page, module)?)?;
    module.add_function(wrap_pyfunction!(fit::coverage_factor, module)?)?;
    module.add_function(wrap_pyfunction!(fit::engine_seconds, module)?)?;
    module.add_function(wrap_pyfunction!(devices::fit_array, module)?)?;
    module.add_function(wrap_pyfunction!(devices::fit_table, module)?)?;
    module.add_function(wrap_pyfunction!(devices::batch_seconds, module)?)?;
    module.add_function(wrap_pyfunction!(command::simulate, module)?)?;
    module.add_function(wrap_pyfunction!(command::run, module)?)?;
    module.add_function(wrap_pyfunction!(command::write_table, module)?)?;
    module.add_function(wrap_pyfunction!(command::read_numbers, module)?)
}
