//! The advice for a person at the table.

use crate::campaign::{Campaign, Reading};
use crate::guide::{Advice, Agreement, Ending, Mistake, Next, Why};
use crate::report::ARCSEC;
use std::fmt::Write;

/// A setting as the advice writes it.
pub(super) fn setting(campaign: &Campaign, reading: &Reading) -> String {
    crate::guide::setting(campaign, &reading.joints)
}

/// Everything that is said after a step.
pub(super) fn text(advice: &Advice) -> String {
    let mut out = String::new();
    // writing to a text cannot fail
    let _ = write(&mut out, advice);
    out
}

fn write(out: &mut String, advice: &Advice) -> std::fmt::Result {
    if let Some(own) = &advice.newest {
        let verdict = match own.agreement {
            Agreement::NotPredicted => "the others do not predict it yet".to_string(),
            Agreement::Agrees => format!("agrees ({:.1} sd)", own.deviation.unwrap_or(0.0)),
            Agreement::Disagrees => format!("DOES NOT AGREE: {:.1} sd off", own.deviation.unwrap_or(0.0)),
        };
        let label = if own.position.is_empty() { String::new() } else { format!("position {}, ", own.position) };
        writeln!(out, "reading {}: {label}{}: {verdict}", own.reading, own.setting)?;
        for remark in &own.remarks {
            writeln!(out, "  {remark}")?;
        }
    }
    if let Some(own) = &advice.mistake {
        mistake(out, own)?;
    }
    for goal in &advice.goals {
        let (scale, unit) = if goal.unit == "rad" { (ARCSEC, "arcsec") } else { (1.0, goal.unit.as_str()) };
        let state = if goal.met { "met" } else { "not yet" };
        match goal.value.zip(goal.u) {
            None => writeln!(out, "  {}: not estimable yet, goal {} {unit}", goal.id, goal.goal * scale)?,
            Some((value, u)) => {
                writeln!(
                    out,
                    "  {} = {:.6} {unit}, u = {:.4}, goal {:.4}: {state}",
                    goal.id,
                    value * scale,
                    u * scale,
                    goal.goal * scale
                )?;
            }
        }
    }
    if let Some(own) = &advice.diagnosis {
        writeln!(out, "  diagnosis: {}", own.verdict)?;
        for effect in &own.effects {
            let size = effect
                .value
                .zip(effect.u)
                .map_or(String::new(), |(v, u)| format!(" = {v:.4e}, u = {u:.1e} {}", effect.unit));
            let aliases =
                if effect.aliases.is_empty() { String::new() } else { format!("; or {}", effect.aliases.join(", ")) };
            writeln!(
                out,
                "    {} ({}){size}, probability {:.3}{aliases}",
                effect.name, effect.regressor, effect.probability
            )?;
        }
    }
    if advice.readings > 0 {
        writeln!(
            out,
            "  nothing missing, or all named: probability {:.3}; effects that could not show yet: {}",
            advice.nothing_missing_or_named, advice.unseen_effects
        )?;
    }
    for id in &advice.unreachable {
        writeln!(out, "  {id}: these positions do not reach its goal, however often they are taken")?;
    }
    if let Some(own) = &advice.next {
        next(out, own)?;
    }
    match advice.ended {
        None => Ok(()),
        Some(Ending::Reached) => writeln!(
            out,
            "done: every goal is met, and nothing is missing or all of it is named; {} readings, cost {}",
            advice.readings, advice.cost
        ),
        Some(Ending::NothingToGain) => writeln!(
            out,
            "stopped: no position of this schedule tells more of what is still wanted; {} readings, cost {}",
            advice.readings, advice.cost
        ),
        Some(Ending::MostReadings) => {
            writeln!(
                out,
                "stopped: {} readings were taken, the most that --most allows; cost {}",
                advice.readings, advice.cost
            )
        }
    }
}

/// Explanations that are listed.
const LISTED: usize = 8;

fn mistake(out: &mut String, own: &Mistake) -> std::fmt::Result {
    match (own.named, own.at) {
        (Some(kind), Some(at)) => writeln!(out, "  likely at reading {at}: {kind}")?,
        (Some(kind), None) => writeln!(out, "  likely: {kind}")?,
        _ => writeln!(out, "  what happened cannot be told yet:")?,
    }
    for one in own.explanations.iter().take(LISTED) {
        writeln!(out, "    {:.3}  {} at reading {}: {}", one.probability, one.kind, one.reading, one.what)?;
    }
    if own.explanations.len() > LISTED {
        writeln!(out, "    and {} more", own.explanations.len() - LISTED)?;
    }
    Ok(())
}

fn next(out: &mut String, own: &Next) -> std::fmt::Result {
    let label = if own.position.is_empty() { String::new() } else { format!("position {}: ", own.position) };
    let why = match (own.why, own.information) {
        (Why::Information, Some(nats)) => format!("{nats:.2} nats for a cost of {}", own.cost),
        (Why::Discriminates, _) => format!("tells {} apart", own.between.join(" and ")),
        _ => "the same position again".to_string(),
    };
    writeln!(out, "next: {label}{} ({why})", own.setting)
}
