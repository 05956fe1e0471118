//! The benches that ship with the program. A new one is a new file under `data/benches` and a new line here.

/// A bench that ships with the program.
#[derive(Debug, Clone, Copy)]
pub struct BuiltIn {
    /// The id that campaigns may name.
    pub id: &'static str,
    /// The bench file's text.
    pub text: &'static str,
}

/// A bench by the name of its file.
macro_rules! shipped {
    ($id:literal) => {
        BuiltIn { id: $id, text: include_str!(concat!("../../data/benches/", $id, ".bench.json")) }
    };
}

const BUILT_INS: &[BuiltIn] = &[
    shipped!("gyro-turntable"),
    shipped!("accelerometer-plumb-plane"),
    shipped!("accelerometer-dividing-head"),
    shipped!("imu-three-axis-table"),
    shipped!("gyro-skew-triad"),
    shipped!("accelerometer-six-positions"),
    shipped!("accelerometer-triad-norm"),
    shipped!("gyro-rate-steps"),
    shipped!("gyro-temperature"),
    shipped!("gyro-turn-on"),
    shipped!("cube-mirror"),
    shipped!("cube-mirror-right"),
];

/// All built-in benches.
pub fn built_ins() -> &'static [BuiltIn] {
    BUILT_INS
}

/// The built-in bench with this id.
///
/// ```
/// assert!(tumble::bench::built_in("gyro-turntable").is_some());
/// ```
pub fn built_in(id: &str) -> Option<&'static BuiltIn> {
    BUILT_INS.iter().find(|bench| bench.id == id)
}
