//! A campaign's lines of scatter as the adjustment takes them: which rows feel which deviation, by the exact derivatives of the model lines.

use super::Remount;
use super::rules::Rules;
use super::system::{Weighting, known_inputs, rounding, weigh};
use crate::campaign::{Campaign, Deviating, Per, Scatter, Size};
use crate::design::DesignMatrix;
use crate::elements::Elements;
use crate::error::Result;
use crate::estimate::{self, Felt, Floor, Memory, Pattern, ScatterLine, System, Variances, Whitening};
use crate::mix::Mix;
use std::borrow::Cow;
use std::collections::HashMap;
use std::hash::BuildHasherDefault;

/// The campaign with the shorthand `--remount` spelled out: each sensor's offset per position.
pub(crate) fn spelled_out(campaign: &Campaign, remount: Remount) -> Result<Cow<'_, Campaign>> {
    let size = match remount {
        Remount::No => return Ok(Cow::Borrowed(campaign)),
        Remount::Estimate => Size::Estimated,
        Remount::Stated(sd) => Size::Stated { sd, dof: f64::INFINITY },
    };
    let mut campaign = campaign.clone();
    for s in 0..campaign.bench.sensors.len() {
        let read = campaign.readings.rows.iter().any(|r| r.observations.iter().any(|o| o.sensor == s));
        if read {
            campaign.add_scatter(Scatter {
                of: Deviating::Sensor(s),
                per: Per::Position,
                size: size.clone(),
                over: None,
                shown: 1.0,
                unit: campaign.sensor_unit(s).to_string(),
                place: "remount".into(),
            })?;
        }
    }
    Ok(Cow::Owned(campaign))
}

/// The lines at a design's point, one for each line of the campaign, in its order.
///
/// `u` are the standard uncertainties of the rows: a correlation of sensors shares out a part of them, see `own_noise`.
pub fn scatter_lines(campaign: &Campaign, design: &DesignMatrix, u: &[f64]) -> Vec<ScatterLine> {
    campaign.scatter.iter().map(|line| scatter_line(campaign, design, u, line)).collect()
}

/// Those, and one for each known input that has an uncertainty: a deviation of unit variance that every reading shares.
pub(crate) fn noise_lines(campaign: &Campaign, design: &DesignMatrix, u: &[f64]) -> Vec<ScatterLine> {
    let mut lines = scatter_lines(campaign, design, u);
    let inputs = known_inputs(campaign, design);
    lines.extend(inputs.iter().flat_map(|own| (0..own.ncols()).map(|j| own.col_as_slice(j))).map(|column| {
        let rows = column.iter().enumerate().filter(|(_, by)| **by != 0.0);
        let felt = rows.map(|(row, by)| Felt { row, level: 0, by: *by }).collect();
        ScatterLine { felt, variance: Some(1.0), memory: None }
    }));
    lines
}

fn scatter_line(campaign: &Campaign, design: &DesignMatrix, u: &[f64], line: &Scatter) -> ScatterLine {
    let (level_of, _) = line.per.levels(campaign);
    let readings = &campaign.readings;
    let column = |name: &str| readings.columns.iter().position(|c| c == name);
    let value = |reading: usize, k: Option<usize>| {
        readings.rows.get(reading).and_then(|r| r.columns.get(k?).copied().flatten())
    };
    let size_column = if let Size::Column(name) = &line.size { Some(column(name)) } else { None };
    let time = line.over.as_ref().map(|over| column(&over.column));
    let mut numbers: HashMap<(usize, u64), usize, BuildHasherDefault<Mix>> = HashMap::default();
    let (mut felt, mut times, mut runs) = (Vec::new(), Vec::new(), Vec::new());
    for (row, origin) in design.rows.iter().enumerate() {
        let by = match &line.of {
            Deviating::Sensor(s) => f64::from(u8::from(origin.sensor == *s)),
            Deviating::Joint(joint) if *joint < design.by_joint.ncols() => design.by_joint[(row, *joint)],
            Deviating::Parameter(k) if *k < design.jacobian.ncols() => design.jacobian[(row, *k)],
            Deviating::Correlated(sensors, r) => match sensors.iter().position(|s| *s == origin.sensor) {
                None => 0.0,
                Some(at) => {
                    let sign = if *r < 0.0 && at == 1 { -1.0 } else { 1.0 };
                    sign * r.abs().sqrt() * u.at(row)
                }
            },
            _ => 0.0,
        };
        let by = match size_column {
            None => by,
            // a reading whose setting has no u of its own feels none
            Some(k) => by * value(origin.reading, k).unwrap_or_default().to_radians(),
        };
        let Some(level) = level_of.get(origin.reading).copied().flatten() else { continue };
        if by == 0.0 {
            continue;
        }
        // the campaign refuses a reading without the time
        let at = time.map_or(0.0, |k| value(origin.reading, k).unwrap_or(f64::NAN) + 0.0);
        let next = numbers.len();
        let level = *numbers.entry((level, at.to_bits())).or_insert_with(|| {
            times.push(at);
            runs.push(level);
            next
        });
        felt.push(Felt { row, level, by });
    }
    let memory = line.over.as_ref().map(|over| Memory { time: times, run: runs, tau: over.tau });
    ScatterLine { felt, variance: variance(line), memory }
}

/// The variance of a line, where it is not to be estimated.
fn variance(line: &Scatter) -> Option<f64> {
    match (&line.of, &line.size) {
        (Deviating::Correlated(..), _) | (_, Size::Column(_)) => Some(1.0),
        (_, Size::Stated { sd, .. }) => Some(sd * sd),
        (_, Size::Estimated) => None,
    }
}

/// What the rows keep of their standard uncertainties where a correlation shares out a part: `sqrt(1 - |r|) u`.
pub(crate) fn own_noise(campaign: &Campaign, design: &DesignMatrix, u: &[f64]) -> Vec<f64> {
    let mut own = u.to_vec();
    for line in &campaign.scatter {
        let Deviating::Correlated(sensors, r) = &line.of else { continue };
        for (origin, slot) in design.rows.iter().zip(&mut own) {
            if sensors.contains(&origin.sensor) {
                *slot *= (1.0 - r.abs()).sqrt();
            }
        }
    }
    own
}

/// The whitening of a system of this campaign, every standard deviation known: `sd` of the rows' own noise (priors included), and the variance
/// of each line of the campaign (those of a fit, or `stated_variances`).
///
/// Whitened columns have the inner products of `V^-1`, so that whatever holds for independent rows of unit variance holds for them.
pub fn whitening(campaign: &Campaign, design: &DesignMatrix, sd: &[f64], variance: &[f64]) -> Whitening {
    let lines = scatter_lines(campaign, design, sd);
    let own = own_noise(campaign, design, sd);
    Whitening::new(&Pattern::new(sd.len(), &lines), &own, &lines, variance)
}

/// The noise floor of a weighted system of this campaign, as for [`whitening`], with what is not known of its known inputs.
pub fn floor(campaign: &Campaign, design: &DesignMatrix, system: &System, variances: &Variances) -> Floor {
    let lines = noise_lines(campaign, design, &system.u);
    let mut all = variances.clone();
    all.lines.resize(campaign.scatter.len(), 0.0);
    all.lines.resize(lines.len(), 1.0);
    all.tau.resize(lines.len(), None);
    Floor::new(&own_system(campaign, design, system), &lines, &all)
}

/// What scatters at a design's point: as stated, or estimated with the campaign's equations met, beside what is not known of its known inputs.
pub(crate) fn scattered(campaign: &Campaign, design: &DesignMatrix) -> Result<Variances> {
    let system = weigh(campaign, design, Weighting::AsStated)?;
    let lines = noise_lines(campaign, design, &system.u);
    let own = own_system(campaign, design, &system);
    let elimination = Rules::at(campaign, &design.point).eliminate(&system, campaign.unknowns()).0;
    let least = rounding(campaign, design, &system);
    let settings = estimate::Settings::default();
    let found = estimate::scattered((&own, &lines), elimination.as_ref(), &least, &settings, false)?;
    let mut variances = Variances::from(&found);
    variances.lines.truncate(campaign.scatter.len());
    variances.tau.truncate(campaign.scatter.len());
    Ok(variances)
}

/// The variances of a campaign's lines as far as they are stated; zero for those to be estimated.
pub(crate) fn stated_variances(campaign: &Campaign) -> Vec<f64> {
    // as asked for
    campaign.scatter.iter().map(|line| variance(line).unwrap_or(0.0)).collect()
}

/// The system with the rows' own noise alone: itself, where no correlation shares out a part of it.
pub(super) fn own_system<'a>(campaign: &Campaign, design: &DesignMatrix, system: &'a System) -> Cow<'a, System> {
    if !campaign.scatter.iter().any(|line| matches!(line.of, Deviating::Correlated(..))) {
        return Cow::Borrowed(system);
    }
    Cow::Owned(System { u: own_noise(campaign, design, &system.u), ..system.clone() })
}
