//! Section of a fit's document on its use: the correction to apply, and the mounting of the sensors.

use super::super::{FitReport, correction_lines, given_sentence, validity_sentence};
use crate::campaign::Kind;
use crate::document::{Align, Cell, Content, Section, Table, Tone};
use crate::fit::State;
use crate::language::{Language, say};
use crate::wire::{CorrectionFile, MountingFile};

/// Readings to inputs: the first order with numbers, where it holds, and the sensors' axes on the mounting face; a reader of a terminal has to
/// ask for it.
pub(super) fn correction(report: &FitReport, asked: bool, lang: Language) -> Section {
    let section = Section::new(say!(lang, "the-correction-to-apply"));
    let mut section = if asked { section } else { section.full() };
    let Some(correction) = &report.correction else {
        let missing: Vec<&str> =
            report.parameters.iter().filter(|p| p.state == State::NotEstimable).map(|p| p.id.as_str()).collect();
        if !missing.is_empty() {
            let text = say!(
                lang,
                "readings-cannot-be-corrected-not-estimable-here",
                missing = lang.names(&missing),
                n = missing.len()
            );
            section = section.verdict(Tone::Caution, text);
        } else if asked {
            section = section.prose(say!(lang, "correction-none-of-the-sensors-follows-a"));
        }
        return section;
    };
    section = section
        .prose(say!(lang, "all-sensors-are-solved-together-for-the"))
        .block(Content::Formula(correction_lines(correction)))
        .prose(validity_sentence(correction, lang));
    if let Some(sentence) = given_sentence(correction, lang) {
        section = section.prose(sentence);
    }
    for (sensor, why) in &correction.left_out {
        section = section.verdict(Tone::Caution, say!(lang, "is-left-out-of-the-correction", sensor, why));
    }
    if let Some(mounting) = &correction.mounting {
        section = mounted(section, correction, mounting, lang);
        let others: Vec<&str> = report
            .parameters
            .iter()
            .filter(|p| p.kind == Kind::Tilt && !mounting.tilts.contains(&p.id))
            .map(|p| p.id.as_str())
            .collect();
        if !others.is_empty() {
            section = section.prose(say!(
                lang,
                "belongs-to-the-bench-and-stays-there",
                others = lang.names(&others),
                n = others.len()
            ));
        }
    }
    section
}

fn mounted(section: Section, correction: &CorrectionFile, mounting: &MountingFile, lang: Language) -> Section {
    let tilts = lang.names(&mounting.tilts);
    if !mounting.missing.is_empty() {
        return section.prose(say!(
            lang,
            "the-rotation-from-the-sensors-axes-to",
            tilts,
            missing = lang.names(&mounting.missing),
            n = mounting.missing.len()
        ));
    }
    let mut table = Table::new(&[
        (say!(lang, "input"), Align::Left),
        ("x", Align::Decimal),
        ("y", Align::Decimal),
        ("z", Align::Decimal),
    ]);
    for input in correction.inputs.iter().filter(|input| input.solved) {
        let Some(d) = input.direction else { continue };
        let cosine = |row: &[f64; 3]| row.iter().zip(&d).map(|(r, d)| r * d).sum::<f64>();
        let cosines = mounting.rotation.iter().map(|row| Cell::Decimals(cosine(row), 9));
        table.row(std::iter::once(Cell::name(&input.id)).chain(cosines).collect());
    }
    table.caption = say!(lang, "direction-cosines-of-the-corrected-inputs-on").into();
    section.prose(say!(lang, "a-corrected-input-points-along-the-sensors", tilts)).table(table)
}
