//! Domain types back to files: what `simulate` and the repair of a model write.

use super::bench_file::{BenchFile, DirectionFile, LinkFile, SensorFile};
use super::bounds_file::{ConstraintFile, limits_file};
use super::campaign_file::{BenchRef, CampaignFile, KnownEntry, ReadingsRef};
use super::{Cell, DerivedFile, Named, ReadingFile, SiteFile};
use crate::bench::{Axis, Bench, DerivedQuantity, Link, Sensor};
use crate::campaign::{Asked, Campaign, Constraint, Decision, Derived, Kind, Reading, Role, joint_keys};
use nalgebra::Vector3;

/// The file that describes this bench.
pub fn bench_file(bench: &Bench) -> BenchFile {
    let link = |link: &Link| match link {
        Link::Joint { name, about, meaning } => {
            LinkFile { joint: Some(name.clone()), tilt: None, about: *about, is: meaning.clone(), times: None }
        }
        Link::Tilt { name, about, meaning, times } => LinkFile {
            joint: None,
            tilt: Some(name.clone()),
            about: *about,
            is: meaning.clone(),
            times: times.as_ref().map(|t| t.line().to_string()),
        },
    };
    let derived = |own: &DerivedQuantity| (own.id.clone(), DerivedFile::of(own.line.to_string(), own.unit.clone()));
    BenchFile {
        id: bench.id.clone(),
        title: bench.title.clone(),
        source: bench.source.clone(),
        notes: bench.notes.clone(),
        site: bench.site.as_ref().map(SiteFile::of),
        units: bench.units,
        chain: bench.chain.iter().map(link).collect(),
        sensors: Named(bench.sensors.iter().map(|sensor| (sensor.id.clone(), sensor_file(sensor))).collect()),
        rate_u_ppm: Named(bench.rate_u.iter().map(|(joint, u)| (joint.clone(), u * 1e6)).collect()),
        rate_range_deg_s: Named(bench.rate_range.clone()),
        derived: Named(bench.derived.iter().map(derived).collect()),
        in_use: Named(bench.in_use.iter().map(|(column, line)| (column.clone(), line.to_string())).collect()),
    }
}

fn sensor_file(sensor: &Sensor) -> SensorFile {
    let direction = |v: &Vector3<f64>| {
        let along = Axis::ALL.into_iter().find(|axis| axis.unit() == *v);
        along.map_or(DirectionFile::Cosines([v.x, v.y, v.z]), DirectionFile::Axis)
    };
    SensorFile {
        unit: sensor.unit.clone(),
        axes: Named(sensor.axes.iter().map(|(name, v)| (name.clone(), direction(v))).collect()),
        turn: sensor.turn,
        input_axis: sensor.input_axis.clone(),
        model: sensor.model.to_string(),
    }
}

/// The file of this campaign on a bench that is named, given by path or in full.
pub fn campaign_file(campaign: &Campaign, bench: BenchRef) -> CampaignFile {
    let mut known = Vec::new();
    let mut estimate = Vec::new();
    // inputs of the bench are written with its site
    for parameter in campaign.parameters.iter().filter(|p| p.kind != Kind::Input) {
        if let Some(Asked { start, prior, prior_u, unit }) = parameter.asked() {
            let unit = unit.filter(|_| start.is_some() || prior.is_some());
            estimate.push((parameter.id.clone(), Asked { start, prior, prior_u, unit }));
        }
        if let Role::Known(input) = &parameter.role {
            known.push((parameter.id.clone(), KnownEntry::Known(input.given(parameter.stated_unit()))));
        }
    }
    // a bench that stands elsewhere keeps the campaign's site, unless it is the campaign's own
    let named = !matches!(bench, BenchRef::Inline(_));
    let own_site = match &bench {
        BenchRef::Named(id) => Bench::named(id).ok().and_then(|bench| bench.site),
        BenchRef::Inline(_) => None,
    };
    // the bench brings its own lines
    let of_bench = |derived: &&Derived| {
        let line = derived.written.as_ref().unwrap_or(&derived.line).to_string();
        campaign.bench.derived.iter().any(|other| other.id == derived.id && other.line.to_string() == line)
    };
    let derived = campaign.derived.iter().filter(|derived| !of_bench(derived)).map(|derived| {
        let line = derived.written.as_ref().unwrap_or(&derived.line).to_string();
        let unit = derived.written.as_ref().map(|_| derived.unit.clone());
        (derived.id.clone(), DerivedFile::of(line, unit))
    });
    CampaignFile {
        site: campaign.bench.site.as_ref().filter(|site| named && own_site.as_ref() != Some(*site)).map(SiteFile::of),
        columns: Named::default(),
        rate_u_ppm: Named(
            campaign.bench.rate_u.iter().filter(|_| named).map(|(joint, u)| (joint.clone(), u * 1e6)).collect(),
        ),
        bench,
        known: Named(known),
        correlations: campaign.correlations.clone(),
        estimate: Named(estimate),
        constraints: campaign.constraints.iter().map(|constraint| constraint_file(campaign, constraint)).collect(),
        derived: Named(derived.collect()),
        limits: limits_file(campaign),
        decision: (campaign.decision != Decision::default()).then_some(campaign.decision),
        unit: campaign.identity.unit.clone(),
        date: campaign.identity.date.clone(),
        place: campaign.identity.place.clone(),
        operator: campaign.identity.operator.clone(),
        instruments: campaign.identity.instruments.clone(),
        procedure: campaign.identity.procedure.clone(),
        environment: campaign.identity.environment.clone(),
        note: campaign.identity.note.clone(),
        scatter: campaign.scatter.iter().filter_map(|line| line.request(campaign)).collect(),
        by: campaign.by.clone(),
        readings: ReadingsRef::Inline(
            campaign.readings.rows.iter().map(|reading| reading_file(campaign, reading)).collect(),
        ),
    }
}

fn constraint_file(campaign: &Campaign, constraint: &Constraint) -> ConstraintFile {
    let id = |k: &usize| campaign.parameter_id(*k).to_string();
    match constraint {
        Constraint::Linear { terms, lower, upper } => {
            let of = Some(Named(terms.iter().map(|(k, factor)| (id(k), *factor)).collect()));
            if lower == upper {
                ConstraintFile { of, equals: Some(*lower), ..ConstraintFile::default() }
            } else {
                let bound = |v: f64| v.is_finite().then_some(v);
                ConstraintFile { of, between: Some([bound(*lower), bound(*upper)]), ..ConstraintFile::default() }
            }
        }
        Constraint::Norm { of, at_most } => ConstraintFile {
            norm_of: Some(of.iter().map(id).collect()),
            at_most: Some(*at_most),
            ..ConstraintFile::default()
        },
    }
}

/// One reading with its joint keys, further columns and values, in the order that people write them.
fn reading_file(campaign: &Campaign, reading: &Reading) -> ReadingFile {
    let mut cells: Vec<(String, Cell)> = Vec::new();
    if !reading.position.is_empty() {
        cells.push(("position".into(), Cell::Text(reading.position.to_string())));
    }
    let joints = joint_keys(campaign.bench.joints(), &reading.joints);
    cells.extend(joints.map(|(key, value)| (key, Cell::Number(value))));
    for (column, value) in campaign.readings.columns.iter().zip(&reading.columns) {
        if let Some(value) = value.filter(|_| !cells.iter().any(|(key, _)| key == column)) {
            cells.push((column.clone(), Cell::Number(value)));
        }
    }
    cells.extend(reading.remarks.iter().map(|(key, text)| (key.clone(), Cell::Text(text.clone()))));
    let u_of = |k: usize, u: f64| (format!("{}_u", campaign.sensor_id(k)), Cell::Number(u));
    for own in &reading.observations {
        cells.push((campaign.sensor_id(own.sensor).to_string(), Cell::Number(own.value)));
        cells.extend(own.u.map(|u| u_of(own.sensor, u)));
    }
    cells.extend(reading.planned_u.iter().map(|(k, u)| u_of(*k, *u)));
    let samples = reading.observations.first().map_or(reading.samples, |o| o.samples);
    if samples != 1.0 {
        cells.push(("n".into(), Cell::Number(samples)));
    }
    Named(cells)
}
