//! How often seeded experiments draw: a few times by default, in full where `TUMBLE_LONG` is set (`TUMBLE_LONG=1 cargo test --release`).
#![allow(dead_code, reason = "each test uses its part")]

/// Is this a long run?
pub fn long() -> bool {
    std::env::var_os("TUMBLE_LONG").is_some_and(|value| !value.is_empty() && value != "0")
}

/// `few` draws, or `full` in a long run.
pub fn draws(few: usize, full: usize) -> usize {
    if long() { full } else { few }
}
