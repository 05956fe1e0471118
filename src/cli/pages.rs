//! `--html`, `--md` and `--dcc`: a report as a page or a certificate. All are made before any is written.

use super::files;
use crate::compare;
use crate::error::Result;
use crate::fit::Fit;
use crate::report::html::{self, Page};
use crate::report::{self, FitReport, Input, dcc, markdown};
use crate::wire::{self, Source};
use clap::Args;
use std::path::{Path, PathBuf};

/// Where to write a report as a page.
#[derive(Debug, Args)]
pub(super) struct Pages {
    /// Write the report as one self-contained HTML file, or to stdout with '-'.
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
    /// Write the report as markdown to a file, or to stdout with '-'.
    #[arg(long, value_name = "FILE")]
    md: Option<PathBuf>,
}

/// Where to write a fit as a calibration certificate.
#[derive(Debug, Args)]
pub(super) struct Certificate {
    /// Write a digital calibration certificate (PTB's DCC, XML) to a file, or to stdout with '-'.
    #[arg(long, value_name = "FILE", requires = "lab")]
    dcc: Option<PathBuf>,
    /// The identities that a certificate needs: laboratory, persons, customer, items (see `tumble schema lab`).
    #[arg(long, value_name = "FILE", requires = "dcc")]
    lab: Option<PathBuf>,
}

impl Certificate {
    /// Make the certificate, if it is asked for; faults of the campaign are located in its source.
    pub(super) fn make(&self, fit: &Fit, report: &FitReport, campaign: &Source) -> Result<Ready> {
        let mut ready = Ready::default();
        if let (Some(path), Some(lab)) = (&self.dcc, &self.lab) {
            let lab = wire::read_lab(&files::read(lab)?)?;
            let text = dcc::certificate(fit, report, &lab).map_err(|error| wire::locate(error, campaign))?;
            ready.0.push((path.clone(), text));
        }
        Ok(ready)
    }
}

/// Texts that are ready to be written.
#[derive(Debug, Default)]
pub(super) struct Ready(Vec<(PathBuf, String)>);

impl Pages {
    /// Is any page asked for?
    pub(super) fn is_asked_for(&self) -> bool {
        self.html.is_some() || self.md.is_some()
    }

    /// Lay out a page, if it is asked for.
    pub(super) fn page(&self, page: &Page) -> Result<Ready> {
        let mut ready = Ready::default();
        if let Some(path) = &self.html {
            ready.0.push((path.clone(), html::render(page)?));
        }
        if let Some(path) = &self.md {
            ready.0.push((path.clone(), markdown::render(page)));
        }
        Ok(ready)
    }

    /// The page of a fit, with the published closed forms beside it where this bench has them and this campaign suits them.
    pub(super) fn fit(&self, fit: &Fit, report: &FitReport, inputs: &[Input]) -> Result<Ready> {
        if self.html.is_none() && self.md.is_none() {
            return Ok(Ready::default());
        }
        let comparison = compare::closed_forms(&fit.campaign.bench.id)
            .and_then(|forms| compare::compare(&fit.campaign, &forms, &fit.settings))
            .ok()
            .map(|comparison| report::compare_report(&comparison));
        self.page(&html::fit_page(fit, report, comparison.as_ref(), inputs)?)
    }
}

impl Ready {
    /// One more text.
    pub(super) fn add(&mut self, path: &Path, text: String) {
        self.0.push((path.to_path_buf(), text));
    }

    /// These and others.
    pub(super) fn and(mut self, other: Ready) -> Ready {
        self.0.extend(other.0);
        self
    }

    /// Does one of them go to stdout, so that the table must not?
    pub(super) fn to_stdout(&self) -> bool {
        self.0.iter().any(|(path, _)| path == Path::new("-"))
    }

    /// Write them all, or none where one of the files cannot be written.
    pub(super) fn write(&self) -> Result<()> {
        let (printed, files): (Vec<_>, Vec<_>) = self.0.iter().partition(|(path, _)| path == Path::new("-"));
        files::write_all(&files)?;
        printed.iter().for_each(|(_, text)| super::print(text));
        Ok(())
    }
}
