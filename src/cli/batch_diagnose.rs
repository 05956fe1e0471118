//! `tumble diagnose CAMPAIGN --by COLUMN`: which device has which effect.

use super::Outcome;
use super::devices::{DeviceCampaign, Many, Passed};
use super::files::Catalogue;
use super::outputs::Outputs;
use super::rows::{Cell, Format, Kind, Rows, Shortest, Titles};
use crate::batch::Device;
use crate::diagnosis::{self, Diagnosis, Finding, Settings, Verdict};
use crate::document::terminal;
use crate::error::Result;
use crate::language::{Language, say};
use crate::wire;
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

/// Diagnose every device by itself.
pub(super) fn run(
    question: &DeviceCampaign,
    many: &Many,
    catalogue: &Catalogue,
    settings: &Settings,
    lang: Language,
) -> Result<Outcome> {
    let table = question.table(true, None)?;
    // what is wrong with the question itself (the significance, the catalogue) is no device's answer
    settings.check()?;
    let mut outputs = Outputs::plan([many.to.as_deref()])?;
    let target = many.to.clone().unwrap_or_else(|| PathBuf::from("-"));
    Format::of(&target)?;
    let bar = table.bar();
    let mut found: Vec<Diagnosed> = Vec::new();
    table.read(&mut |passed| {
        let Passed::Devices(devices, layout) = passed else {
            found.clear();
            bar.reset();
            return Ok(true);
        };
        let one = |device: &Device| {
            let campaign = table.campaign(layout, device);
            let diagnosed = campaign.and_then(|c| diagnosis::diagnose(&c, &catalogue.effects, settings));
            bar.inc(device.rows as u64);
            Diagnosed::new(device, &diagnosed.map_err(|error| wire::locate(error, &question.source)))
        };
        found.par_extend(devices.par_iter().map(one));
        Ok(true)
    })?;
    bar.finish_and_clear();
    let (mut effects, mut verdicts) = (BTreeMap::<(String, String), usize>::new(), BTreeMap::<&str, usize>::new());
    let mut cells = Vec::with_capacity(found.len());
    for diagnosed in found {
        *verdicts.entry(diagnosed.verdict).or_default() += 1;
        // one effect in several sensors of a device is one device
        let of_device: BTreeSet<(String, String)> = diagnosed.effects.into_iter().collect();
        of_device.into_iter().for_each(|effect| *effects.entry(effect).or_default() += 1);
        cells.push(diagnosed.cells);
    }
    let mut rows = Rows::begin(&target, outputs.open(&target)?, titles(table.by()), &[])?;
    rows.write(&cells)?;
    outputs.finish(rows.finish()?);
    outputs.write()?;
    let mut counts: Vec<((String, String), usize)> = effects.into_iter().collect();
    counts.sort_by_key(|b| std::cmp::Reverse(b.1));
    let said: Vec<String> = verdicts.iter().map(|(verdict, n)| format!("{n} {}", lang.term(verdict))).collect();
    let devices = lang.count(cells.len(), "device");
    let devices = say!(lang, "grouped-by", what = devices, by = table.by());
    let mut text = format!("{devices}{}{}\n", lang.colon(), said.join(lang.comma()));
    if !counts.is_empty() {
        let cells: Vec<Vec<String>> = counts
            .iter()
            .map(|((regressor, name), n)| vec![n.to_string(), regressor.clone(), lang.name(name).into_owned()])
            .collect();
        text += &format!(
            "\n{}",
            terminal::plain(&[say!(lang, "devices"), say!(lang, "effect"), say!(lang, "meaning")], &cells)
        );
    }
    match &many.to {
        Some(_) => super::print(&text)?,
        // rows are on stdout
        None => super::note(text.trim_end()),
    }
    let nothing = Verdict::NothingMissing.name();
    Ok(if verdicts.keys().all(|verdict| *verdict == nothing) { Outcome::Done } else { Outcome::Rejected })
}

/// What stays of the diagnosis of a device.
struct Diagnosed {
    verdict: &'static str,
    /// Terms and names.
    effects: Vec<(String, String)>,
    cells: Vec<Cell<'static>>,
}

fn titles(by: &str) -> Titles {
    let names = ["verdict", "effects", "regressors", "names", "values", "u", "units", "p", "aliases", "why"];
    let kind = |name: &str| if name == "effects" { Kind::Count } else { Kind::Text };
    [(by.to_string(), Kind::Text)].into_iter().chain(names.map(|name| (name.to_string(), kind(name)))).collect()
}

impl Diagnosed {
    /// Its cells: how many effects, and the regressors, values, u, probabilities and aliases of all of them, parted by semicolons.
    fn new(device: &Device, diagnosis: &Result<Diagnosis>) -> Self {
        let verdict = diagnosis.as_ref().map_or("malformed", |diagnosis| diagnosis.verdict.name());
        let effects: &[Finding] = diagnosis.as_ref().map_or(&[], |diagnosis| &diagnosis.effects);
        let all = |of: &dyn Fn(&Finding) -> String| effects.iter().map(of).collect::<Vec<_>>().join("; ");
        let number = |x: Option<f64>| x.map_or(String::new(), |x| Shortest(x).to_string());
        let texts = [
            all(&|f| f.effect.regressor.clone()),
            all(&|f| f.effect.name.clone()),
            all(&|f| number(f.value)),
            all(&|f| number(f.u)),
            all(&|f| f.unit.clone()),
            all(&|f| number(Some(f.p))),
            all(&|f| f.aliases.iter().map(|alias| alias.regressor.as_str()).collect::<Vec<_>>().join(" or ")),
            diagnosis.as_ref().err().map_or(String::new(), |error| {
                let found = error.finding().map_or(String::new(), |found| format!("; found: {found}"));
                format!("{} ({}){found}", error.what(), error.place().path)
            }),
        ];
        let first = [Cell::Text(device.label.clone().into()), Cell::Text(verdict.into()), Cell::Count(effects.len())];
        let named = |finding: &Finding| (finding.effect.regressor.clone(), finding.effect.name.clone());
        Diagnosed {
            verdict,
            effects: effects.iter().map(named).collect(),
            cells: first.into_iter().chain(texts.map(|text| Cell::Text(text.into()))).collect(),
        }
    }
}
