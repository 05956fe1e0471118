//! The benches that ship with the program. A new one is a new file under `data/benches` and a new line here.

/// A bench that ships with the program.
#[derive(Debug, Clone, Copy)]
pub struct BuiltIn {
    /// The id that campaigns may name.
    pub id: &'static str,
    /// The bench file's text.
    pub text: &'static str,
}

const BUILT_INS: &[BuiltIn] = &[
    BuiltIn { id: "gyro-turntable", text: include_str!("../../data/benches/gyro-turntable.bench.json") },
    BuiltIn {
        id: "accelerometer-plumb-plane",
        text: include_str!("../../data/benches/accelerometer-plumb-plane.bench.json"),
    },
    BuiltIn {
        id: "accelerometer-dividing-head",
        text: include_str!("../../data/benches/accelerometer-dividing-head.bench.json"),
    },
    BuiltIn { id: "imu-three-axis-table", text: include_str!("../../data/benches/imu-three-axis-table.bench.json") },
    BuiltIn { id: "gyro-skew-triad", text: include_str!("../../data/benches/gyro-skew-triad.bench.json") },
    BuiltIn {
        id: "accelerometer-six-positions",
        text: include_str!("../../data/benches/accelerometer-six-positions.bench.json"),
    },
    BuiltIn {
        id: "accelerometer-triad-norm",
        text: include_str!("../../data/benches/accelerometer-triad-norm.bench.json"),
    },
    BuiltIn { id: "gyro-rate-steps", text: include_str!("../../data/benches/gyro-rate-steps.bench.json") },
    BuiltIn { id: "gyro-temperature", text: include_str!("../../data/benches/gyro-temperature.bench.json") },
    BuiltIn { id: "gyro-turn-on", text: include_str!("../../data/benches/gyro-turn-on.bench.json") },
    BuiltIn { id: "cube-mirror", text: include_str!("../../data/benches/cube-mirror.bench.json") },
    BuiltIn { id: "cube-mirror-right", text: include_str!("../../data/benches/cube-mirror-right.bench.json") },
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
