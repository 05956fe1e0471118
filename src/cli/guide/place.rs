//! Where a reading of samples belongs.

use super::lines;
use super::table::State;
use crate::campaign::Reading;
use crate::error::Result;
use crate::guide::Agreement;
use crate::wire::ReadingFile;

pub(super) enum Placed {
    Here(Reading),
    /// Several settings agree.
    Which(Vec<String>),
}

/// The position of a reading: what its keys say, else the one that was asked for, unless its values do not agree with that one and another does.
///
/// Errors: those of a reading.
pub(super) fn placed(cells: &ReadingFile, state: State) -> Result<Placed> {
    let State { campaign, guide, asked, .. } = state;
    let joints = campaign.bench.joints();
    let says =
        |joint: &str| cells.0.iter().any(|(key, _)| key.strip_prefix(joint).is_some_and(|s| s.starts_with("_deg")));
    let by_joints = joints.filter(|joint| says(joint)).count() > 0;
    let named = lines::label(cells);
    let is_named = lines::is_labelled(named.as_deref());
    let settings: Vec<&Reading> = guide.candidates().iter().filter(&is_named).collect();
    let is_stated = by_joints || named.is_some() && settings.len() < 2;
    if is_stated || asked.is_none() && named.is_none() {
        return lines::reading(cells.clone(), campaign, guide, asked).map(Placed::Here);
    }
    let at = |reading: &Reading| lines::reading(cells.clone(), campaign, guide, Some(reading));
    if let Some(reading) = asked.filter(&is_named) {
        let reading = at(reading)?;
        if guide.would_agree(&reading)? != Agreement::Disagrees {
            return Ok(Placed::Here(reading));
        }
    }
    let mut possible: Vec<(Reading, Agreement)> = Vec::new();
    for reading in settings {
        // a setting at which the model lacks a column cannot be compared
        if let Ok(reading) = at(reading)
            && let Ok(found) = guide.would_agree(&reading)
            && found != Agreement::Disagrees
        {
            possible.push((reading, found));
        }
    }
    let agrees = possible.iter().any(|(_, found)| *found == Agreement::Agrees);
    match (possible.as_slice(), asked.filter(&is_named)) {
        ([(reading, _)], _) if agrees => Ok(Placed::Here(reading.clone())),
        (several, _) if agrees => {
            let one = |(reading, _): &(Reading, Agreement)| {
                format!("{}: {}", reading.position, crate::guide::setting(campaign, &reading.joints))
            };
            Ok(Placed::Which(several.iter().map(one).collect()))
        }
        (_, Some(asked)) => at(asked).map(Placed::Here),
        _ => lines::reading(cells.clone(), campaign, guide, asked).map(Placed::Here),
    }
}
