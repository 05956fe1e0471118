//! `tumble diagnose CAMPAIGN --by COLUMN`: which device has which effect.

use super::catalogue::Catalogue;
use super::devices::{DeviceCampaign, Many, Others};
use super::outputs::Outputs;
use super::rows::{DiagnosedRow, EffectColumn, diagnosed};
use super::{Outcome, rows::Format};
use crate::batch::Device;
use crate::diagnosis::{self, Settings, Verdict};
use crate::document::terminal;
use crate::error::{Fault, Malformed, Result};
use crate::language::{Language, say};
use crate::wire;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::io::Write;
use std::path::PathBuf;

/// Diagnose every device by itself.
pub(super) fn run(
    question: &DeviceCampaign,
    many: &Many,
    catalogue: &Catalogue,
    settings: &Settings,
    lang: Language,
) -> Result<Outcome> {
    let table = question.table(Others::All, None)?;
    table.template()?;
    // what is wrong with the question itself (the significance, the catalogue) is no device's answer
    super::probability("significance", settings.significance, "0.01")?;
    let mut outputs = Outputs::plan([many.to.as_deref()])?;
    let target = many.to.clone().unwrap_or_else(|| PathBuf::from("-"));
    let format = Format::of(&target)?;
    if format == Format::Parquet {
        return Err(Malformed::new(Fault::Value, "effects of devices are not written as Parquet")
            .expected("a name that ends in .csv or .jsonl"));
    }
    let bar = table.bar();
    let found = std::cell::RefCell::new(Vec::<DiagnosedRow>::new());
    table.read(
        &mut |devices, layout| {
            let one = |device: &Device| {
                let diagnosed = table
                    .campaign(layout, device)
                    .and_then(|campaign| diagnosis::diagnose(&campaign, &catalogue.effects, settings));
                bar.inc(device.rows as u64);
                match diagnosed {
                    Ok(own) => DiagnosedRow {
                        label: device.label.clone(),
                        verdict: own.verdict.name().into(),
                        effects: own
                            .effects
                            .iter()
                            .map(|finding| EffectColumn {
                                regressor: finding.effect.regressor.clone(),
                                name: finding.effect.name.clone(),
                                value: finding.value,
                                u: finding.u,
                                unit: finding.unit.clone(),
                                p: finding.p,
                                aliases: finding.aliases.iter().map(|alias| alias.regressor.clone()).collect(),
                            })
                            .collect(),
                        why: String::new(),
                    },
                    Err(error) => {
                        let error = wire::locate(error, question.source());
                        let found = error.finding().map_or(String::new(), |found| format!("; found: {found}"));
                        DiagnosedRow {
                            label: device.label.clone(),
                            verdict: "malformed".into(),
                            effects: Vec::new(),
                            why: format!("{} ({}){found}", error.what(), error.place().path),
                        }
                    }
                }
            };
            let rows: Vec<DiagnosedRow> = devices.par_iter().map(one).collect();
            found.borrow_mut().extend(rows);
            Ok(true)
        },
        &mut || {
            found.borrow_mut().clear();
            bar.reset();
            Ok(())
        },
    )?;
    bar.finish_and_clear();
    let rows = found.into_inner();
    let mut stream = outputs.open(&target)?;
    let text = diagnosed(table.by(), &rows, format);
    stream
        .write_all(&text)
        .or_else(super::outputs::reader_left)
        .map_err(|error| super::outputs::fault(&target, &error))?;
    outputs.finish(stream);
    outputs.write()?;
    let mut effects: BTreeMap<(&str, &str), usize> = BTreeMap::new();
    let mut verdicts: BTreeMap<&str, usize> = BTreeMap::new();
    for row in &rows {
        *verdicts.entry(row.verdict.as_str()).or_default() += 1;
        for effect in &row.effects {
            *effects.entry((effect.regressor.as_str(), effect.name.as_str())).or_default() += 1;
        }
    }
    let mut counts: Vec<((&str, &str), usize)> = effects.into_iter().collect();
    counts.sort_by_key(|b| std::cmp::Reverse(b.1));
    let said: Vec<String> = verdicts.iter().map(|(verdict, n)| format!("{n} {}", lang.term(verdict))).collect();
    let devices = lang.count(rows.len(), "device");
    let devices = say!(lang, "grouped-by", what = devices, by = table.by());
    let mut text = format!("{devices}{}{}\n", lang.colon(), said.join(lang.comma()));
    if !counts.is_empty() {
        let cells: Vec<Vec<String>> = counts
            .iter()
            .map(|((regressor, name), n)| vec![n.to_string(), (*regressor).to_string(), lang.name(name).into_owned()])
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
    let nothing = rows.iter().all(|row| row.verdict == Verdict::NothingMissing.name());
    Ok(if nothing { Outcome::Done } else { Outcome::Rejected })
}
