//! `tumble fit CAMPAIGN`.

use super::{Outcome, batch, devices, pages};
use crate::error::{Fault, Malformed, Result};
use crate::fit::{self, Estimator, Remount, RobustMethod, Weighting};
use crate::language::Language;
use crate::report;
use crate::uncertainty::monte_carlo;
use crate::wire;
use clap::Args;
use std::path::PathBuf;

/// What to fit and what to write.
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// The campaign file (JSON), or standard input with '-'.
    #[arg(required_unless_present = "readings")]
    campaign: Option<PathBuf>,
    /// One least-squares step from the reference point (the estimator of the published formulas) instead of Gauss-Newton on the exact model to convergence.
    #[arg(long)]
    linear: bool,
    /// What is done without it; for scripts that state it.
    #[arg(long, hide = true, conflicts_with = "linear")]
    exact: bool,
    /// Take stated uncertainties of readings as relative weights, and estimate their scale from the residuals.
    #[arg(long)]
    relative: bool,
    /// Coverage probability of expanded uncertainties.
    #[arg(long, default_value_t = 0.95, value_name = "P", allow_negative_numbers = true)]
    level: f64,
    /// Robust estimation in the presence of outliers: Huber, Tukey (bisquare) or L1 instead of least squares.
    #[arg(long, value_name = "METHOD", value_parser = robust_method)]
    robust: Option<RobustMethod>,
    /// Random offset common to the readings of a position (set-up repeatability): 'estimate' its variance, or state its standard uncertainty.
    #[arg(long, value_name = "estimate|U", value_parser = remount, allow_negative_numbers = true)]
    remount: Option<Remount>,
    /// Also propagate distributions by N Monte Carlo trials (GUM Supplements 1 and 2).
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    monte_carlo: Option<usize>,
    /// Seed of the Monte Carlo trials.
    #[arg(long, default_value_t = 1, value_name = "SEED", requires = "monte_carlo", allow_negative_numbers = true)]
    seed: u64,
    /// Also print the uncertainty budget of every quantity, and the correlations.
    #[arg(long)]
    budget: bool,
    /// Also print the correction of readings: matrix, bias, and the range in which first order is sufficient.
    #[arg(long)]
    correction: bool,
    /// Files of readings (CSV, Parquet, gzip; patterns with * and ?) in place of the campaign's: without '--by', each file is one device.
    /// The campaign may follow them.
    /// Without a FILE: also list every reading with its residual, redundancy and minimal detectable bias.
    #[arg(long, value_name = "FILE", num_args = 0..)]
    readings: Option<Vec<PathBuf>>,
    #[command(flatten)]
    many: devices::Many,
    /// With many devices: write into this folder a page for each device that is not accepted, is outside a limit or is an outlier (at most
    /// 100 pages); --html and --md have links to them.
    #[arg(long, value_name = "FOLDER")]
    reports: Option<PathBuf>,
    #[command(flatten)]
    pages: pages::Pages,
    #[command(flatten)]
    certificate: pages::Certificate,
}

fn robust_method(text: &str) -> std::result::Result<RobustMethod, String> {
    RobustMethod::ALL.into_iter().find(|method| method.name() == text).ok_or("expected huber, tukey or l1".into())
}

pub(super) fn remount(text: &str) -> std::result::Result<Remount, String> {
    match text.parse::<f64>() {
        _ if text == "estimate" => Ok(Remount::Estimate),
        Ok(u) if u > 0.0 && u.is_finite() => Ok(Remount::Stated(u)),
        _ => Err("expected 'estimate' or a positive standard uncertainty in the sensor's unit".into()),
    }
}

/// Most numbers that a Monte Carlo may keep: 4 GiB.
const MOST_VALUES: usize = 1 << 29;

/// Monte Carlo with a bar on stderr (only where that is a terminal).
fn draw(fit: &fit::Fit, trials: usize, seed: u64) -> Result<Option<fit::Drawn>> {
    let outputs = fit.parameters.len() + fit.derived.len();
    let fits = |trials: usize| monte_carlo::values_kept(trials, outputs, fit.settings.level) <= MOST_VALUES;
    if !fits(trials) {
        let most = (0..60).map(|k| 1_usize << k).take_while(|trials| fits(*trials)).last().unwrap_or(1);
        return Err(Malformed::new(Fault::Value, "so many trials do not fit into memory")
            .expected(format!("--monte-carlo of at most {} for this campaign", most.min(fit::MOST_TRIALS)))
            .found(trials.to_string()));
    }
    let bar = super::bar(trials as u64, "{wide_bar} {pos}/{len}");
    let drawn = fit::draw(fit, trials, seed, &|block| bar.inc(block as u64));
    bar.finish_and_clear();
    drawn
}

fn settings(arguments: &Arguments) -> fit::Settings {
    let weighting = if arguments.relative { Weighting::Relative } else { Weighting::AsStated };
    fit::Settings {
        estimator: if arguments.linear { Estimator::Linear } else { Estimator::Exact },
        level: arguments.level,
        weighting,
        robust: arguments.robust,
        remount: arguments.remount.unwrap_or_default(),
        ..fit::Settings::default()
    }
}

fn many(arguments: &Arguments, question: devices::DeviceCampaign, lang: Language) -> Result<Outcome> {
    let single = vec![
        ("--monte-carlo", arguments.monte_carlo.is_some()),
        ("--budget", arguments.budget),
        ("--correction", arguments.correction),
        ("--dcc", arguments.certificate.path().is_some()),
        ("--readings without a file", arguments.readings.as_ref().is_some_and(Vec::is_empty)),
    ];
    let one = "the readings of one device, for example --readings ONE.csv with a campaign without \"by\"";
    devices::refuse_many(single, one)?;
    let (settings, reports) = (settings(arguments), arguments.reports.as_deref());
    batch::fit(&question, &arguments.many, &settings, reports, &arguments.pages, lang)
}

/// The fit of one device, and every file that was read.
fn fitted(question: &devices::DeviceCampaign, settings: &fit::Settings) -> Result<(fit::Fit, Vec<report::Input>)> {
    if question.is_streamed() {
        return question.stream(settings);
    }
    let (campaign, inputs) = question.single()?;
    batch::note_repeated(&campaign);
    let fit = fit::fit_owned(campaign, settings).map_err(|error| wire::locate(error, &question.source))?;
    Ok((fit, inputs))
}

pub(super) fn run(arguments: &Arguments, lang: Language) -> Result<Outcome> {
    let (campaign, input_files) =
        devices::behind(arguments.campaign.as_deref(), arguments.readings.as_deref().unwrap_or_default())?;
    let question = devices::DeviceCampaign::read(campaign, &arguments.many, input_files)?;
    if question.is_of_many() {
        return many(arguments, question, lang);
    }
    arguments.many.refuse_alone(&[("--reports", arguments.reports.is_some())])?;
    let mut outputs = arguments.pages.outputs([arguments.certificate.path()])?;
    let (fit, inputs) = fitted(&question, &settings(arguments))?;
    let listed = arguments.readings.is_some() && input_files.is_empty();
    let lists = listed || arguments.pages.is_asked_for();
    let mut report = if lists { report::fit_report(&fit) } else { report::fit_summary(&fit) };
    report.inputs = inputs.clone();
    if let Some(trials) = arguments.monte_carlo {
        let drawn = draw(&fit, trials, arguments.seed)?;
        report.monte_carlo = drawn.map(|drawn| report::monte_carlo_report(drawn, &fit));
    }
    outputs.extend(arguments.certificate.make(&fit, &report, &question.source, lang)?);
    let asked = report::Asked {
        fit: Some(&fit),
        comparison: None,
        inputs: &inputs,
        readings: listed,
        budget: arguments.budget,
        correction: arguments.correction,
    };
    let document = |page: bool| match page {
        true => pages::document_of(&fit, &report, &inputs, lang),
        false => report::fit_document(&report, &asked, lang),
    };
    let written = arguments.pages.json().map(|_| {
        let mut written = report::fit_to_write(&fit);
        (written.inputs, written.monte_carlo) = (report.inputs.clone(), report.monte_carlo.clone());
        written
    });
    arguments.pages.finish(outputs, &written, document)?;
    let conforms =
        report.conformity.as_ref().is_none_or(|conformity| conformity.outcome == crate::fit::Conformity::Pass);
    Ok(if !conforms || fit.is_rejected() { Outcome::Rejected } else { Outcome::Done })
}
