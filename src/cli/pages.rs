//! `--json`, `--html`, `--md`, `--xlsx` and `--dcc`: a report as JSON, as a page or as a certificate.

use super::outputs::Outputs;
use super::{Outcome, calibrations, files};
use crate::compare;
use crate::document::chart::Chart;
use crate::document::{Detail, Document, html, markdown, plot, terminal};
use crate::error::{Fault, Malformed, Result};
use crate::fit::Fit;
use crate::language::Language;
use crate::record::parted;
use crate::report::{self, FitReport, Input, dcc};
use crate::wire::{self, Source};
use clap::Args;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Where to write a report: as JSON, or as a page.
#[derive(Debug, Args)]
pub(super) struct Pages {
    /// Write the report as JSON to a file, or to stdout with '-'.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Write the report as one self-contained HTML file, or to stdout with '-'.
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
    /// Write the report as markdown to a file, or to stdout with '-'.
    #[arg(long, value_name = "FILE")]
    md: Option<PathBuf>,
    /// Write the report as a workbook (.xlsx): one sheet for each section, values as numbers, figures as charts.
    #[arg(long, value_name = "FILE")]
    xlsx: Option<PathBuf>,
    /// Print everything that a page contains.
    #[arg(short, long)]
    verbose: bool,
}

/// How the content of a format is made.
type Render = fn(&Document) -> Result<Vec<u8>>;

/// Where to write a fit as a calibration certificate.
#[derive(Debug, Args)]
pub(super) struct Certificate {
    /// Write a digital calibration certificate (PTB's DCC, XML) to a file, or to stdout with '-'.
    #[arg(long, value_name = "FILE", requires = "lab")]
    dcc: Option<PathBuf>,
    /// The identities that a certificate needs: laboratory, persons, customer, items (see `tumble schema lab`).
    #[arg(long, value_name = "FILE", requires = "dcc")]
    lab: Option<PathBuf>,
    /// The JSON report of a fit of the same unit before it was adjusted: the certificate then has both, as found and as left.
    #[arg(long, value_name = "REPORT", requires = "dcc")]
    as_found: Option<PathBuf>,
}

impl Certificate {
    pub(super) fn path(&self) -> Option<&Path> {
        self.dcc.as_deref()
    }

    /// Make the certificate, if it is asked for; faults of the campaign are located in its source.
    pub(super) fn make(&self, fit: &Fit, report: &FitReport, campaign: &Source, lang: Language) -> Result<Texts> {
        let (Some(path), Some(lab)) = (&self.dcc, &self.lab) else { return Ok(Texts::new()) };
        let lab = wire::read_lab(&files::read(lab)?)?;
        let found = self.as_found.as_deref().map(|path| as_found(path, report)).transpose()?;
        let text = dcc::certificate(fit, report, found.as_ref(), &lab, lang);
        Ok(vec![(path.clone(), text.map_err(|error| wire::locate(error, campaign))?.into_bytes())])
    }
}

/// The calibration before the adjustment.
///
/// Errors: a report of another bench or of another unit.
fn as_found(path: &Path, left: &FitReport) -> Result<FitReport> {
    let found = calibrations::read(path)?;
    let refuse = |what: &str, expected: &str, found: &str| {
        Err(Malformed::new(Fault::Value, format!("the calibration as found is of another {what}"))
            .expected(format!("{what} '{expected}'"))
            .found(format!("'{found}'"))
            .in_file(path.display().to_string()))
    };
    match (calibrations::serial(left), calibrations::serial(&found.report)) {
        _ if left.bench != found.report.bench => refuse("bench", &left.bench, &found.report.bench),
        (Some(left), Some(found)) if left != found => refuse("unit", &left, &found),
        _ => Ok(found.report),
    }
}

/// Contents of files, each with the file that it goes to.
pub(super) type Texts = Vec<(PathBuf, Vec<u8>)>;

impl Pages {
    /// Every format: the file that is asked for, and how its content is made.
    fn formats(&self) -> impl Iterator<Item = (Option<&Path>, Render)> {
        let all: [(_, Render); _] = [
            (self.html.as_deref(), |page| Ok(html::render(page)?.into_bytes())),
            (self.md.as_deref(), |page| Ok(markdown::render(page).into_bytes())),
            (self.xlsx.as_deref(), workbook),
        ];
        all.into_iter()
    }

    /// The outputs of a command: its report, and its other files.
    pub(super) fn outputs<'a>(&'a self, others: impl IntoIterator<Item = Option<&'a Path>>) -> Result<Outputs> {
        Outputs::plan(self.formats().map(|(path, _)| path).chain([self.json()]).chain(others))
    }

    pub(super) fn json(&self) -> Option<&Path> {
        self.json.as_deref()
    }

    pub(super) fn is_asked_for(&self) -> bool {
        self.formats().any(|(path, _)| path.is_some())
    }

    /// The page that has links to pages of single devices.
    pub(super) fn linked(&self) -> Option<&Path> {
        self.html.as_deref().or(self.md.as_deref())
    }

    pub(super) fn print(&self, document: &Document) -> Result<()> {
        super::show(&terminal::render(document, if self.verbose { Detail::Full } else { Detail::Brief }))
    }

    /// The record that a page says it was made from.
    pub(super) fn input(&self, record: &Path) -> Result<Vec<Input>> {
        let asked = self.is_asked_for().then(|| files::input(&parted(record).0));
        Ok(asked.transpose()?.into_iter().collect())
    }

    /// Write the report as pages and as JSON where that is asked for, and every file; where nothing went to stdout, print the document. `document`
    /// hears whether it is for a page.
    pub(super) fn finish(
        &self,
        mut outputs: Outputs,
        report: &impl Serialize,
        document: impl Fn(bool) -> Document,
    ) -> Result<Outcome> {
        if self.is_asked_for() {
            outputs.extend(self.page(&document(true))?);
        }
        if let Some(path) = self.json() {
            outputs.json(path, report)?;
        }
        let to_stdout = outputs.to_stdout();
        outputs.write()?;
        let printed = if to_stdout { Ok(()) } else { self.print(&document(false)) };
        printed.map(|()| Outcome::Done)
    }

    /// Lay out a page, if it is asked for.
    pub(super) fn page(&self, page: &Document) -> Result<Texts> {
        let asked = self.formats().filter_map(|(path, render)| Some((path?.to_path_buf(), render)));
        asked.map(|(path, render)| Ok((path, render(page)?))).collect()
    }
}

/// A chart as a file of its own, which needs paper.
pub(super) fn picture(chart: &Chart, lang: Language) -> Result<String> {
    Ok(plot::draw(chart, lang)?.replacen(">\n", ">\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n", 1))
}

/// The document of a fit with all that a page shows: the published closed forms, where its bench has them and its campaign suits them.
pub(super) fn document_of(fit: &Fit, report: &FitReport, inputs: &[Input], lang: Language) -> Document {
    // closed forms take all readings, and of a stream there is a sample of them
    let forms = fit.streamed.is_none().then(|| compare::closed_forms(&fit.campaign.bench.id).ok()).flatten();
    let comparison = forms.and_then(|forms| compare::compare_fit(fit, &forms).ok());
    let comparison = comparison.map(|comparison| report::compare_report(&comparison));
    let asked = report::Asked { fit: Some(fit), comparison: comparison.as_ref(), inputs, ..report::Asked::default() };
    report::fit_document(report, &asked, lang)
}

#[cfg(feature = "excel")]
pub(super) fn workbook(page: &Document) -> Result<Vec<u8>> {
    crate::document::workbook::render(page)
}

#[cfg(not(feature = "excel"))]
pub(super) fn workbook(_: &Document) -> Result<Vec<u8>> {
    Err(Malformed::new(Fault::Value, "this program was built without workbooks")
        .expected("a program built with the feature 'excel', or --html"))
}
