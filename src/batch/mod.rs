//! Many devices through one schedule: the fit of [`fit`](mod@crate::fit) for each, with what they share done once.
//!
//! ```text
//! columns of many devices -> devices -> { common schedule: P Y for a block of devices; by itself: fit } -> one row a device
//! ```
//!
//! | file | subject |
//! |---|---|
//! | `layout.rs` | which columns of a table matter, and as what |
//! | `device.rs` | the readings of one device, and when two devices have the same schedule |
//! | `stream.rs` | a table of many devices, device by device; a serial number that comes back |
//! | `common.rs` | a schedule factorised once, and the rows of its devices |
//! | `answer.rs` | a device's row from its solution; known inputs with an uncertainty |
//! | `lanes.rs` | devices of different schedules, eight side by side; those of one schedule whose model is not linear, to convergence |
//! | `lane_rows.rs` | their rows of the design, from the columns of the table, and which of them are replicates |
//! | `block.rs` | estimates, residuals and their sums of eight devices side by side |
//! | `residuals.rs` | tests of the residuals: signs, normality, lack of fit beside replicates |
//! | `fleet.rs` | which device is fitted how |
//! | `parts.rs` | one linear step where the readings of a device come in parts, which merge, and the row from them |
//! | `repeat.rs` | a column that seems to tell devices apart where nobody says so |
//! | `row.rs` | what is said of one device |
//! | `summary.rs` | what is said of all of them: distributions, outlying devices, does the line scatter more than it is measured |
//!
//! A device's row says what its own fit would say: where the model is linear in its unknowns, the schedule's factorisation serves all devices
//! that have this schedule; everything else (exact iterations, constraints, scatter, several estimated scales) is the ordinary fit.
//! A device that cannot be fitted is a row that says why, and stops no other.

mod answer;
mod block;
mod common;
mod device;
mod fleet;
mod lane_rows;
mod lanes;
mod layout;
mod parts;
mod repeat;
mod residuals;
mod row;
mod stream;
mod summary;

pub use answer::Coverage;
pub(crate) use common::Common;
pub use device::Device;
pub use fleet::{Fleet, Schedules};
pub use layout::{Layout, Use};
pub use parts::{DesignRow, Part, Parts};
pub(crate) use repeat::repeats;
pub(crate) use row::{Reason, Solved};
pub use row::{Row, Verdict};
pub(crate) use stream::Restart;
pub use stream::{Tables, stream};
pub(crate) use summary::{Chance, DeviceCounts, NoisyDevice, NotInOrder, OutlyingDevice, Scattering};
pub use summary::{Quantity, Summary};
