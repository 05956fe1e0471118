//! Section of a fit's page on its use: the correction to apply, and the mounting of the sensors.

use super::{Align, Block, Section, Table, Tone, cells};
use crate::fit::Fit;
use crate::report::{FitReport, corrections, mounting};

/// The model lines solved for their inputs, and the sensors' axes on the mounting face.
pub(super) fn correction(fit: &Fit, report: &FitReport) -> Section {
    let mut section = Section::new("The correction to apply");
    let corrections = corrections(fit);
    let symbolic: Vec<String> = corrections.iter().map(|c| c.symbolic.clone()).collect();
    let numeric: Vec<String> = corrections.iter().filter_map(|c| c.numeric.clone()).collect();
    if !symbolic.is_empty() {
        section = section.prose("The model line solved for its input:").block(Block::Formula(symbolic));
    }
    if !numeric.is_empty() {
        section = section
            .prose("With the numbers of this calibration, two digits beyond their uncertainty:")
            .block(Block::Formula(numeric));
    }
    for c in corrections.iter().filter(|c| !c.missing.is_empty()) {
        section = section.verdict(
            Tone::Caution,
            format!("`{}` cannot be corrected by itself: {} not estimable here.", c.sensor, is_or_are(&c.missing)),
        );
    }
    if corrections.iter().any(|c| c.iterate) {
        section = section.prose("Where the input stands on the right too, begin with zero there and repeat; two or three rounds are enough for small nonlinear terms.");
    }
    let shared = corrections
        .iter()
        .any(|c| c.symbolic.matches("w_").count() + c.symbolic.matches("a_").count() > 1 && !c.iterate);
    if shared {
        section = section.prose("Other rates and forces on the right come from the other sensors: correct all, then repeat with the corrected values.");
    }
    if let Some(mounting) = mounting(fit) {
        let tilts = cells::names(&mounting.tilts);
        if mounting.missing.is_empty() && !mounting.directions.is_empty() {
            let mut table = Table::new(&[
                ("input", Align::Left),
                ("x", Align::Decimal),
                ("y", Align::Decimal),
                ("z", Align::Decimal),
            ]);
            for d in &mounting.directions {
                let mut row = vec![format!("`{}` of `{}`", d.input, d.sensor)];
                row.extend(d.cosines.iter().map(|c| format!("{c:.9}")));
                table.row(row);
            }
            table.caption = "Direction cosines of the corrected inputs on the mounting face".into();
            section = section
                .prose(format!("The corrected input points along the sensor's own axis. On the mounting face (the frame after the last joint) that axis is turned by {tilts}; a rate or force known there has this component along it:"))
                .table(table);
        } else if !mounting.missing.is_empty() {
            section = section.prose(format!(
                "The rotation from the sensor's axis to the mounting face needs {tilts}; {} not estimable here.",
                is_or_are(&mounting.missing)
            ));
        }
        let others: Vec<&str> = report
            .parameters
            .iter()
            .filter(|p| p.kind == "tilt" && !mounting.tilts.contains(&p.id))
            .map(|p| p.id.as_str())
            .collect();
        if !others.is_empty() {
            let verb =
                if others.len() == 1 { "belongs to the bench and stays" } else { "belong to the bench and stay" };
            section = section.prose(format!("{} {verb} there.", cells::names(&others)));
        }
    }
    section
}

fn is_or_are(names: &[String]) -> String {
    format!("{} {}", cells::names(names), if names.len() == 1 { "is" } else { "are" })
}
