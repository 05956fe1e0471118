//! Fit reports read back as calibrations.

use super::files;
use crate::compare::calibrations::{Determination, day_number};
use crate::correction::Calibration;
use crate::error::{Fault, Malformed, Result};
use crate::report::{CalibratedReport, FitReport, determination};
use crate::wire::{self, CorrectionFile, Source};
use std::path::Path;

/// A fit report and the file that it came from.
pub(super) struct Stored {
    source: Source,
    pub(super) report: FitReport,
}

/// Does this text look like a report of this program (and not like a campaign)?
pub(super) fn is_report(source: &Source) -> bool {
    #[derive(serde::Deserialize)]
    struct Head {
        report: Option<String>,
    }
    serde_json::from_str::<Head>(&source.text).is_ok_and(|head| head.report.is_some())
}

/// Read a fit report.
///
/// Errors: another kind of file, with what was expected.
pub(super) fn read(path: &Path) -> Result<Stored> {
    let source = files::read(path)?;
    if !is_report(&source) {
        return Err(Malformed::new(Fault::Value, "this is not a calibration")
            .expected("the JSON report of a fit: tumble fit CAMPAIGN --json FILE")
            .found("a file without \"report\"")
            .in_file(source.name));
    }
    let report: FitReport = wire::parse(&source)?;
    if report.report != crate::report::ReportKind::Fit {
        return Err(Malformed::new(Fault::Value, "this report is not that of a fit")
            .expected("\"report\": \"fit\"")
            .found(format!("\"report\": \"{}\"", report.report))
            .at_path("report")
            .in_file(source.name));
    }
    Ok(Stored { source, report })
}

/// Two calibrations are of different readings: the uncertainty of their difference takes the noise of both as independent.
///
/// Errors: the same readings, to the last digit.
pub(super) fn of_other_readings(before: &Stored, after: &Stored) -> Result<()> {
    let (a, b) = (&before.report.readings, &after.report.readings);
    let same = a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.sensor == b.sensor && a.value == b.value);
    if a.is_empty() || !same {
        return Ok(());
    }
    Err(Malformed::new(Fault::Value, "both reports are fits of the same readings: they do not differ by a change of the unit")
        .expected("fits of readings that were taken apart; for two models of the same readings, tumble diagnose says which terms they need")
        .found(format!("the same {} values as in {}", a.len(), before.source.name))
        .in_file(&after.source.name))
}

/// The serial number of the unit that a report is about.
pub(super) fn serial(report: &FitReport) -> Option<String> {
    report.identity.unit.as_ref().and_then(|unit| unit.serial.clone())
}

impl Stored {
    pub(super) fn correction(&self) -> Result<CorrectionFile> {
        self.report.correction.clone().ok_or_else(|| {
            Malformed::new(Fault::Missing, "this calibration corrects nothing")
                .expected("a fit with a sensor whose line follows a rate w_* or a specific force a_*, made by this version of the program")
                .found("no \"correction\"")
                .in_file(&self.source.name)
        })
    }

    pub(super) fn calibration(&self) -> Result<Calibration> {
        self.correction()?.into_calibration().map_err(|error| wire::locate(error, &self.source))
    }

    /// Lines that say which unit it is about.
    pub(super) fn identity(&self) -> Vec<String> {
        let serial = serial(&self.report).map(|serial| format!("Serial number: {serial}."));
        serial.into_iter().chain(self.date().map(|date| format!("Date of calibration: {date}."))).collect()
    }

    fn date(&self) -> Option<String> {
        self.report.identity.date.clone()
    }

    /// The limits that it states for a quantity.
    pub(super) fn limits(&self, id: &str) -> Option<[f64; 2]> {
        let limited = self.report.conformity.as_ref()?.quantities.iter().find(|quantity| quantity.id == id)?;
        let low = limited.lower.unwrap_or(f64::NEG_INFINITY);
        let high = limited.upper.unwrap_or(f64::INFINITY);
        Some([low, high])
    }

    /// The day of the calibration, from 1970-01-01.
    pub(super) fn day(&self) -> Option<f64> {
        day_number(&self.date()?)
    }

    pub(super) fn determination(&self) -> Determination {
        determination(&self.source.name, &self.report, self.day())
    }

    pub(super) fn summary(&self) -> CalibratedReport {
        CalibratedReport {
            file: self.source.name.clone(),
            bench: self.report.bench.clone(),
            date: self.date(),
            serial: serial(&self.report),
        }
    }
}
