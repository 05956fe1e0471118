//! A plan as a person at a terminal reads it.

use super::foresight_table::foresight_table;
use super::plan_better::{better, not_told_apart};
use super::plan_words::{defects, drift, judged_at, keys, lacking, nowhere, number, through_tilts, work};
use super::table::{plain, significant};
use super::wrap::hanging;
use super::{JudgementReport, PlanReport};
use crate::language::{Language, say};
use std::collections::BTreeMap;

/// A plan report as text; `with_readings` lists every value with its leverage and minimal detectable bias.
pub fn plan_table(report: &PlanReport, with_readings: bool, lang: Language) -> String {
    let mut text = format!("{}\n", say!(lang, "tumble-plan-on", tumble = report.tumble, bench = report.bench));
    for (sensor, line) in &report.model {
        text.push_str(&format!("  {sensor} = {line}\n"));
    }
    for (sensor, noise) in &report.noise {
        let sd = significant(noise.sd, 4);
        let from = lang.term("sd-from", &noise.from.to_string());
        text.push_str(&format!("  {}\n", say!(lang, "noise-of", sensor, sd, unit = noise.unit, from)));
    }
    for (id, sd) in &report.remount {
        text.push_str(&format!(
            "  {}\n",
            say!(lang, "every-remounting-scatters-sd-rad-for-a", id, sd = significant(*sd, 3))
        ));
    }
    let at = say!(lang, "judged-at", point = judged_at(&report.judged_at, lang));
    text.push_str(&format!("{}\n", hanging(&format!("  {at}"), 4)));
    text.push_str(&format!("\n{}\n\n", say!(lang, "the-schedule", work = work(&report.schedule, lang))));
    text.push_str(&judgement(&report.schedule, lang));
    if with_readings {
        text.push_str(&readings(&report.schedule, lang));
    }
    if let (Some(effects), None) = (&report.schedule.effects, &report.improved) {
        text.push_str(&foresight_table(effects, lang));
    }
    if let Some(improved) = &report.improved {
        text.push_str(&better(improved, &report.finds, lang));
        let effects = improved.judgement.effects.as_ref().filter(|_| not_told_apart(improved, lang).is_none());
        if let Some(effects) = effects {
            text.push_str(&foresight_table(effects, lang));
        }
        if with_readings && not_told_apart(improved, lang).is_none() {
            text.push_str(&readings(&improved.judgement, lang));
        }
    }
    text
}

fn judgement(j: &JudgementReport, lang: Language) -> String {
    let mut rows = Vec::new();
    // the strongest partner says more than a matrix; the matrix is in the JSON
    let strongest = |i: usize| {
        let row = j.correlation.matrix.get(i)?;
        let others = row.iter().enumerate().filter(|(k, _)| *k != i).filter_map(|(k, r)| r.map(|r| (k, r)));
        let (k, r) = others.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))?;
        let partner = j.correlation.order.get(k)?;
        (r.abs() >= 0.005).then(|| say!(lang, "correlation-with", r = format!("{r:+.2}"), partner))
    };
    let needs_value = |id: &String| j.lacking.as_ref().is_some_and(|l| l.untold.contains(id));
    for (i, p) in j.parameters.iter().enumerate() {
        let angle = p.u_arcsec.is_some();
        rows.push(vec![
            p.id.clone(),
            if needs_value(&p.id) {
                say!(lang, "needs-a-value").into()
            } else if p.u.is_none() {
                say!(lang, "not-estimable").into()
            } else {
                number(if angle { p.u_arcsec } else { p.u })
            },
            if angle { "arcsec".into() } else { p.unit.clone() },
            strongest(i).unwrap_or_default(),
            if p.u.is_some() { number(p.undetected_fault_arcsec.or(p.undetected_fault)) } else { "-".into() },
        ]);
    }
    for d in &j.derived {
        let note = if d.is_largest { say!(lang, "largest-near-the-reference") } else { "" };
        let unit = if d.u_arcsec.is_some() { "arcsec" } else { d.unit.as_str() };
        rows.push(vec![d.id.clone(), number(d.u_arcsec.or(d.u)), unit.into(), note.into(), "".into()]);
    }
    let mut text = plain(
        &[
            say!(lang, "parameter"),
            say!(lang, "predicted-u"),
            say!(lang, "unit"),
            say!(lang, "strongest-correlation"),
            say!(lang, "undetected-fault"),
        ],
        &rows,
    );
    let mut rank = say!(lang, "plan-table-rank", rank = j.rank.to_string(), dof = lang.count(j.dof, "degree"));
    if let Some(condition) = j.condition {
        rank.push_str(&say!(lang, "fit-table-condition", condition = significant(condition, 3)));
    }
    if j.unchecked > 0 {
        rank.push_str(lang.semicolon());
        rank.push_str(&say!(lang, "values-checked-by-no-other", n = j.unchecked));
    }
    text.push_str(&format!("\n{}\n", hanging(&rank, 2)));
    text.push_str(&drift(j, lang));
    if let Some(through) = &j.through_tilts {
        text.push_str(&format!("{}\n", hanging(&through_tilts(through, lang), 2)));
    }
    if j.effects.is_none() && j.work.readings > 0 {
        let line = say!(lang, "so-many-values-what-a-diagnosis-could");
        text.push_str(&format!("{}\n", hanging(line, 2)));
    }
    if let Some(own) = &j.lacking {
        text.push_str(&format!("{}\n", hanging(&lacking(own, lang), 2)));
    }
    if j.bounds_not_counted > 0 {
        text.push_str(&format!("{}\n", say!(lang, "bounds-not-counted", n = j.bounds_not_counted)));
    }
    let defect = |text: &str| say!(lang, "is-not-estimable", text);
    text.push_str(&defects(&j.not_estimable, defect, &nowhere(&BTreeMap::new(), lang), lang));
    text
}

fn readings(j: &JudgementReport, lang: Language) -> String {
    let rows: Vec<Vec<String>> = j
        .readings
        .iter()
        .map(|r| {
            let worst = r.effect_arcsec.iter().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
            vec![
                r.index.to_string(),
                r.position.clone(),
                keys(&r.at),
                r.sensor.clone(),
                format!("{:.3}", r.leverage),
                number(r.mdb),
                worst.map_or(String::new(), |(id, e)| say!(lang, "arcsec-of", e = significant(*e, 3), id)),
            ]
        })
        .collect();
    let header = [
        "#",
        say!(lang, "per-position"),
        say!(lang, "gap-at"),
        say!(lang, "sensor"),
        say!(lang, "leverage"),
        say!(lang, "mdb"),
        say!(lang, "its-largest-effect-on-an-angle"),
    ];
    format!("\n{}", plain(&header, &rows))
}
