//! Section of a fit's page on its use: the correction to apply, and the mounting of the sensors.

use super::{Align, Block, Section, Table, Tone, cells};
use crate::campaign::Kind;
use crate::fit::State;
use crate::report::{FitReport, correction_lines, given_sentence, validity_sentence};
use crate::wire::{CorrectionFile, MountingFile};

/// Readings to inputs: the first order with numbers, where it holds, and the sensors' axes on the mounting face.
pub(super) fn correction(report: &FitReport) -> Section {
    let mut section = Section::new("The correction to apply");
    let Some(correction) = &report.correction else {
        let missing: Vec<&str> =
            report.parameters.iter().filter(|p| p.state == State::NotEstimable).map(|p| p.id.as_str()).collect();
        if !missing.is_empty() {
            let verb = if missing.len() == 1 { "is" } else { "are" };
            let text = format!("Readings cannot be corrected: {} {verb} not estimable here.", cells::names(&missing));
            section = section.verdict(Tone::Caution, text);
        }
        return section;
    };
    section = section
        .prose("All sensors are solved together for the inputs that they determine. To first order, with the numbers of this calibration:")
        .block(Block::Formula(correction_lines(correction)))
        .prose(validity_sentence(correction));
    if let Some(sentence) = given_sentence(correction) {
        section = section.prose(sentence);
    }
    for (sensor, why) in &correction.left_out {
        section = section.verdict(Tone::Caution, format!("`{sensor}` is left out of the correction: {why}."));
    }
    section = section.prose("`tumble apply` corrects a record by the exact lines, `tumble export` writes them as source code; both read the JSON report of this fit.");
    if let Some(mounting) = &correction.mounting {
        section = mounted(section, correction, mounting);
        let others: Vec<&str> = report
            .parameters
            .iter()
            .filter(|p| p.kind == Kind::Tilt && !mounting.tilts.contains(&p.id))
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

fn mounted(section: Section, correction: &CorrectionFile, mounting: &MountingFile) -> Section {
    let tilts = cells::names(&mounting.tilts);
    if !mounting.missing.is_empty() {
        let verb = if mounting.missing.len() == 1 { "is" } else { "are" };
        return section.prose(format!(
            "The rotation from the sensors' axes to the mounting face needs {tilts}; {} {verb} not estimable here.",
            cells::names(&mounting.missing)
        ));
    }
    let mut table =
        Table::new(&[("input", Align::Left), ("x", Align::Decimal), ("y", Align::Decimal), ("z", Align::Decimal)]);
    for input in correction.inputs.iter().filter(|input| input.solved) {
        let Some(d) = input.direction else { continue };
        let cosine = |row: &[f64; 3]| row.iter().zip(&d).map(|(r, d)| r * d).sum::<f64>();
        let mut cells = vec![format!("`{}`", input.id)];
        cells.extend(mounting.rotation.iter().map(|row| format!("{:.9}", cosine(row))));
        table.row(cells);
    }
    table.caption = "Direction cosines of the corrected inputs on the mounting face".into();
    section
        .prose(format!("A corrected input points along the sensors' own axes. On the mounting face (the frame after the last joint) these are turned by {tilts}; a rate or force known there has this component along them:"))
        .table(table)
}
