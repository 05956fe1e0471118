//! The bench as a picture: its joints where a reading has them, the unit, gravity and the Earth rate.

use crate::bench::{Bench, Link};
use crate::campaign::JointState;
use crate::document::Figure;
use crate::document::chart::{Chart, Ring, Scene};
use crate::document::number::trimmed;
use crate::language::Language;
#[cfg(feature = "navigate")]
use crate::language::say;
#[cfg(feature = "navigate")]
use crate::navigate::{earth::earth_rate, mission::Mission, trajectory::Trajectory};
use nalgebra::{Matrix3, Rotation3, Unit, Vector3};
#[cfg(feature = "navigate")]
use nalgebra::{Quaternion, UnitQuaternion};

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
    let mut states = joints.iter();
    let joints = bench.chain.iter().filter_map(|link| match link {
        Link::Joint { name, about, .. } => {
            let state = states.next().copied().unwrap_or(JointState::Held { angle_deg: 0.0 });
            let angle_deg = state.keys().0.unwrap_or(0.0);
            Some((said(name, &state), about.unit(), angle_deg, state.rate_deg_s()))
        }
        _ => None,
    });
    let (rings, unit) = turned(joints);
    let mut inputs = Vec::new();
    for sensor in &bench.sensors {
        let directions = match sensor.input() {
            Some(direction) => vec![(sensor.id.clone(), direction)],
            None => sensor.axes.clone(),
        };
        let new = directions.into_iter().filter(|(_, direction)| !inputs.iter().any(|(_, known)| known == direction));
        let new: Vec<_> = new.collect();
        inputs.extend(new);
    }
    let earth_rate = bench.earth_rate();
    let earth_rate = (earth_rate.norm() > 0.0).then(|| earth_rate.normalize());
    Scene { rings, unit, inputs, earth_rate }
}

/// Joints from the outermost on (label, axis, angle, rate) as rings, and what they turn the unit to.
fn turned(joints: impl Iterator<Item = (String, Vector3<f64>, f64, f64)>) -> (Vec<Ring>, Matrix3<f64>) {
    let mut turned = Rotation3::identity();
    let mut rings = Vec::new();
    for (label, axis, angle_deg, rate_deg_s) in joints {
        // zero is along the next axis of the frame before the joint
        rings.push(Ring { label, axis: turned * axis, zero: turned * axis.yzx(), angle_deg, rate_deg_s });
        turned *= Rotation3::from_axis_angle(&Unit::new_normalize(axis), angle_deg.to_radians());
    }
    (rings, turned.into_inner())
}

/// A joint and its state, as short as it goes.
fn said(name: &str, state: &JointState) -> String {
    match (state.keys().0, state.rate_deg_s()) {
        (Some(angle), 0.0) => format!("{name} {}\u{b0}", trimmed(angle)),
        (_, rate) => format!("{name} {}\u{b0}/s", trimmed(rate)),
    }
}

pub(super) fn scene_figure(bench: &Bench, joints: &[JointState], caption: String, lang: Language) -> Figure {
    let scene = scene(bench, joints);
    let list: Vec<String> = scene.rings.iter().map(|ring| ring.label.clone()).collect();
    let description = format!("{caption} {}{}{}", bench.id, lang.colon(), list.join(lang.comma()));
    Figure { caption, description, chart: Chart::Scene(scene), wide: false }
}

/// The figure of a mission: the unit as its first motion begins, by its heading, pitch and roll.
#[cfg(feature = "navigate")]
pub(super) fn mission_figure(mission: &Mission, lang: Language) -> Figure {
    let [w, x, y, z] = Trajectory::new(mission, &mission.motion).truth().quaternion;
    let body = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z)).to_rotation_matrix();
    // about up, then the body's right, then its forward axis: Rot_z(yaw) Rot_x(pitch) Rot_y(roll)
    let yaw = (-body[(0, 1)]).atan2(body[(1, 1)]);
    let pitch = body[(2, 1)].clamp(-1.0, 1.0).asin();
    let roll = (-body[(2, 0)]).atan2(body[(2, 2)]);
    let attitude = &mission.motion.attitude;
    let angles = [
        // a heading is clockwise from north
        (say!(lang, "heading-angle"), Vector3::z(), yaw, -1.0, attitude.yaw),
        (say!(lang, "pitch-angle"), Vector3::x(), pitch, 1.0, attitude.pitch),
        (say!(lang, "roll-angle"), Vector3::y(), roll, 1.0, attitude.roll),
    ];
    let (rings, unit) = turned(angles.into_iter().map(|(name, axis, angle, sense, motion)| {
        let swing = motion.amplitude.to_degrees().abs();
        let swing = if swing > 0.0 { format!(" \u{b1} {}\u{b0}", trimmed(swing)) } else { String::new() };
        let angle = angle.to_degrees();
        // without what turning by a matrix left in the last digits
        let said = (1e6 * sense * angle).round() / 1e6 + 0.0;
        (format!("{name} {}\u{b0}{swing}", trimmed(said)), axis, angle, 0.0)
    }));
    let labels = rings.iter().map(|ring| ring.label.clone()).collect::<Vec<_>>().join(lang.comma());
    let earth_rate = Some(Vector3::from(earth_rate(mission.site.latitude_rad)).normalize());
    Figure {
        caption: say!(lang, "unit-at-the-start").into(),
        description: labels,
        chart: Chart::Scene(Scene { rings, unit, inputs: Vec::new(), earth_rate }),
        wide: false,
    }
}
