//! Work that somebody may stop while it runs: a person at a notebook, the user of a window.
//!
//! ```
//! let stop = tumble::stop::Stop::default();
//! let line = r#"{ "bench": { "id": "line", "sensors": { "y": { "model": "a + b*x" } } }, "estimate": { "a": {}, "b": {} },
//!     "readings": [ {"x": 0, "y": 1}, {"x": 1, "y": 3}, {"x": 2, "y": 4} ] }"#;
//! let campaign = tumble::Campaign::from_json(line)?;
//! assert!(stop.run(|| tumble::fit(&campaign, &Default::default())).is_some());
//! stop.ask(); // from another thread, as a rule
//! assert!(stop.run(|| tumble::fit(&campaign, &Default::default())).is_none());
//! # Ok::<(), tumble::error::Malformed>(())
//! ```
//!
//! Long loops look now and then whether they are asked to stop, and then unwind to [`Stop::run`] without a word (no panic hook is called). Work
//! outside of `run` never unwinds. Deliberately absent: work that goes on where it was stopped.

use std::cell::RefCell;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Stack of the threads that work, as large as a program's own, and some more.
const STACK: usize = 16 << 20;

thread_local! {
    /// The stop that the work of this thread obeys.
    static OBEYED: RefCell<Option<Stop>> = const { RefCell::new(None) };
}

/// Unwound with.
struct Stopped;

/// A request to stop; its clones are one request.
#[derive(Debug, Clone, Default)]
pub struct Stop(Arc<AtomicBool>);

impl Stop {
    /// Ask the work to stop; it does so at the next place where it looks.
    pub fn ask(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Is it asked to?
    pub(crate) fn is_asked(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }

    /// Do work in threads of its own until it is done; `None` where it was stopped. A panic of the work goes on here.
    pub fn run<T: Send>(&self, work: impl FnOnce() -> T + Send) -> Option<T> {
        let own = self.clone();
        let pool = rayon::ThreadPoolBuilder::new()
            .stack_size(STACK)
            .thread_name(|k| format!("tumble-{k}"))
            .start_handler(move |_| OBEYED.set(Some(own.clone())))
            .build();
        let done = match pool {
            Ok(pool) => catch_unwind(AssertUnwindSafe(|| pool.install(work))),
            // no threads: here, and it cannot be stopped
            Err(_) => Ok(work()),
        };
        match done {
            Ok(found) => Some(found),
            Err(cause) if cause.is::<Stopped>() => None,
            Err(cause) => resume_unwind(cause),
        }
    }
}

/// A place where long work looks whether it should stop; it unwinds to [`Stop::run`] if so.
#[inline]
pub fn poll() {
    let asked = OBEYED.with_borrow(|stop| stop.as_ref().is_some_and(Stop::is_asked));
    if asked {
        resume_unwind(Box::new(Stopped));
    }
}
