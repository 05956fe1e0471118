//! The bench as a picture: its joints where a reading has them, the unit, gravity and the Earth rate.

use crate::bench::{Bench, Link};
use crate::campaign::JointState;
use crate::document::Figure;
use crate::document::chart::{Chart, Ring, Scene};
use crate::document::number::trimmed;
use crate::language::{Language, say};
use nalgebra::{Rotation3, Unit};

/// The bench with its joints in these states (at zero where there are none), all tilts at zero: `R = Rot(joint 1) Rot(joint 2) ...`, which takes
/// components along the unit's axes to east, north and up.
///
/// ```
/// use tumble::bench::built_in;
/// use tumble::campaign::JointState;
/// let source = tumble::wire::Source { name: "gyro-turntable".into(), text: built_in("gyro-turntable").unwrap().text.into() };
/// let bench = tumble::wire::read_bench(&source)?;
/// let still = |angle_deg| JointState::Held { angle_deg };
/// let scene = tumble::report::scene(&bench, &[still(0.0), still(90.0), still(0.0)]);
/// // the fixture turned by 90 degrees about the vertical: the unit's x points north
/// assert!((scene.unit.column(0) - nalgebra::Vector3::y()).norm() < 1e-12);
/// # Ok::<(), tumble::error::Malformed>(())
/// ```
pub fn scene(bench: &Bench, joints: &[JointState]) -> Scene {
    let mut turned = Rotation3::identity();
    let mut states = joints.iter();
    let mut rings = Vec::new();
    for link in &bench.chain {
        let Link::Joint { name, about, .. } = link else { continue };
        let state = states.next().copied().unwrap_or(JointState::Held { angle_deg: 0.0 });
        let (angle_deg, rate_deg_s) = (state.keys().0.unwrap_or(0.0), state.rate_deg_s());
        let axis = about.unit();
        // zero is along the next axis of the frame before the joint
        let zero = turned * axis.yzx();
        rings.push(Ring { label: said(name, &state), axis: turned * axis, zero, angle_deg, rate_deg_s });
        turned *= Rotation3::from_axis_angle(&Unit::new_normalize(axis), angle_deg.to_radians());
    }
    let mut inputs = Vec::new();
    for sensor in &bench.sensors {
        let own = match sensor.input() {
            Some(direction) => vec![(sensor.id.clone(), direction)],
            None => sensor.axes.clone(),
        };
        let new = own.into_iter().filter(|(_, direction)| !inputs.iter().any(|(_, known)| known == direction));
        let new: Vec<_> = new.collect();
        inputs.extend(new);
    }
    let earth_rate = bench.earth_rate();
    let earth_rate = (earth_rate.norm() > 0.0).then(|| earth_rate.normalize());
    Scene { rings, unit: turned.into_inner(), inputs, earth_rate }
}

/// A joint and its state, as short as it goes.
fn said(name: &str, state: &JointState) -> String {
    match (state.keys().0, state.rate_deg_s()) {
        (Some(angle), 0.0) => format!("{name} {}\u{b0}", trimmed(angle)),
        (_, rate) => format!("{name} {}\u{b0}/s", trimmed(rate)),
    }
}

/// The figure of a bench.
pub(super) fn scene_figure(bench: &Bench, joints: &[JointState], caption: String, lang: Language) -> Figure {
    let scene = scene(bench, joints);
    let list: Vec<String> = scene.rings.iter().map(|ring| ring.label.clone()).collect();
    let description = say!(lang, "bench-drawn", bench = &bench.id, joints = list.join(lang.comma()));
    Figure { caption, description, chart: Chart::Scene(scene), wide: false }
}
