//! Several devices in one campaign that nobody has told apart.

use crate::campaign::{Campaign, JointState, Reading};
use std::collections::HashMap;

/// What a numeric column of serial numbers is called.
const SERIAL: [&str; 6] = ["serial", "serial_number", "serial_no", "sn", "device", "unit"];

/// A column of texts (or of serial numbers) that no model line uses and that repeats one schedule for each of its values: its name, and how many values.
pub fn repeats(campaign: &Campaign) -> Option<(String, usize)> {
    let rows = &campaign.readings.rows;
    let mut names: Vec<String> = Vec::new();
    for (name, _) in rows.iter().flat_map(|row| &row.remarks) {
        if !names.contains(name) {
            names.push(name.clone());
        }
    }
    let used: Vec<&str> = campaign.bench.sensors.iter().flat_map(|sensor| sensor.model.names()).collect();
    let numeric = campaign.readings.columns.iter().filter(|name| SERIAL.contains(&name.to_lowercase().as_str()));
    names.extend(numeric.filter(|name| !used.contains(&name.as_str())).cloned());
    names.into_iter().find_map(|name| Some((name.clone(), labels(campaign, &name, &used)?)))
}

/// How many labels a column has, where each has the same schedule of at least two readings.
fn labels(campaign: &Campaign, name: &str, used: &[&str]) -> Option<usize> {
    let readings = &campaign.readings;
    let column = readings.columns.iter().position(|other| other == name);
    let label = |row: &Reading| match column {
        Some(k) => row.columns.get(k).copied().flatten().map(|x| x.to_string()),
        None => row.remarks.iter().find(|(column, _)| column == name).map(|(_, text)| text.clone()),
    };
    let inputs: Vec<usize> = (0..readings.columns.len())
        .filter(|k| readings.columns.get(*k).is_some_and(|name| used.contains(&name.as_str())))
        .collect();
    type Key<'a> = (&'a [JointState], Vec<Option<f64>>, Vec<usize>);
    let (mut places, mut groups) = (HashMap::<String, usize>::new(), Vec::<Vec<Key<'_>>>::new());
    for row in &readings.rows {
        let label = label(row)?;
        let columns = inputs.iter().map(|k| row.columns.get(*k).copied().flatten()).collect();
        let key = (row.joints.as_slice(), columns, row.observations.iter().map(|o| o.sensor).collect());
        let place = *places.entry(label).or_insert(groups.len());
        match groups.get_mut(place) {
            Some(keys) => keys.push(key),
            None => groups.push(vec![key]),
        }
    }
    let first = groups.first()?;
    let distinct = first.iter().any(|key| first.first() != Some(key));
    let same = groups.iter().all(|keys| keys == first);
    (groups.len() > 1 && first.len() > 1 && distinct && same).then_some(groups.len())
}
