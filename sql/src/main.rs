//! `tumble-sql --campaign CAMPAIGN 'SELECT serial, tumble_fit() FROM ... GROUP BY serial'`.

use clap::Parser;
use datafusion::execution::SessionStateBuilder;
use datafusion::prelude::{DataFrame, SessionConfig, SessionContext};
use std::io::{IsTerminal, Write};
use std::path::PathBuf;
use std::process::ExitCode;
use tumble_sql::output::{self, Format};
use tumble_sql::{Error, Question, Result};

/// Rows that are shown on a terminal.
const SHOWN: usize = 40;

/// Fits devices in SQL: one row a device, from tables of readings in Parquet or CSV.
///
/// tumble_fit() fits each group by one linear step from the campaign's start values; it takes the columns that the campaign needs by their
/// names. tumble_fit_exact() makes the ordinary fit of tumble, with every check; it keeps a device's rows in memory.
///
/// Example: tumble-sql --campaign gyro.campaign.json "SELECT serial, tumble_fit() FROM 'runs/*.parquet' GROUP BY serial"
#[derive(Debug, Parser)]
#[command(version)]
struct Arguments {
    /// What is asked of every device; its own readings are not looked at.
    #[arg(long, value_name = "FILE")]
    campaign: PathBuf,
    /// The query; 'FOLDER/*.parquet' and 'FILE.csv' in quotes are tables.
    #[arg(value_name = "SQL")]
    sql: String,
    /// One linear step from the start values, also where the model is not linear in its unknowns.
    #[arg(long)]
    linear: bool,
    /// Coverage probability of expanded uncertainties (the columns that end in _U).
    #[arg(long, default_value_t = 0.95)]
    level: f64,
    /// Write the rows to a file, as .csv, .jsonl or .parquet; without it CSV goes to stdout, on a terminal a table.
    #[arg(long, value_name = "FILE")]
    to: Option<PathBuf>,
    /// Threads, and parts that a table is dealt to; one for each processor unless given.
    #[arg(long, value_name = "N")]
    threads: Option<usize>,
    /// Run on so many executors beside a scheduler, each a process of this machine: a cluster for trying.
    #[cfg(feature = "cluster")]
    #[arg(long, value_name = "N", conflicts_with = "scheduler")]
    cluster: Option<std::num::NonZeroUsize>,
    /// Run on the cluster of this scheduler (see tumble-sql-node).
    #[cfg(feature = "cluster")]
    #[arg(long, value_name = "HOST:PORT")]
    scheduler: Option<String>,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    match run(&arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: &Arguments) -> Result<()> {
    let format = arguments.to.as_ref().map(|path| Format::of(&path.to_string_lossy())).transpose()?;
    let question = Question::read(&arguments.campaign)?.linear(arguments.linear).level(arguments.level);
    let mut threads = tokio::runtime::Builder::new_multi_thread();
    let mut config = SessionConfig::new().with_information_schema(true);
    // V is V, and kI is kI
    config.options_mut().sql_parser.enable_ident_normalization = false;
    if let Some(count) = arguments.threads {
        threads.worker_threads(count.max(1));
        config = config.with_target_partitions(count.max(1));
    }
    let runtime = threads.enable_all().build().map_err(|error| Error::Question(error.to_string()))?;
    #[cfg(feature = "cluster")]
    let local = arguments.cluster.map(|count| start(count.get(), arguments.threads.unwrap_or(1))).transpose()?;
    #[cfg(feature = "cluster")]
    let remote = local.as_ref().map(tumble_sql::local::Local::url);
    #[cfg(feature = "cluster")]
    let remote = remote.or_else(|| arguments.scheduler.as_ref().map(|own| format!("df://{own}")));
    #[cfg(not(feature = "cluster"))]
    let remote: Option<String> = None;
    let (schema, batches) = runtime.block_on(async {
        let ctx = session(remote.as_deref(), config, &question).await?;
        let frame = frame(&ctx, &arguments.sql, remote.is_some()).await?;
        let schema = std::sync::Arc::new(frame.schema().as_arrow().clone());
        Ok::<_, Error>((schema, frame.collect().await?))
    })?;
    let (schema, batches) = output::flat(&batches, &schema)?;
    match (&arguments.to, format) {
        (Some(path), Some(format)) => {
            let unwritten =
                |error: std::io::Error| Error::Question(format!("cannot write '{}': {error}", path.display()));
            // under another name until it is whole
            let begun = PathBuf::from(format!("{}.part", path.display()));
            let file = std::fs::File::create(&begun).map_err(unwritten)?;
            output::write(std::io::BufWriter::new(file), format, &schema, &batches)?;
            std::fs::rename(&begun, path).map_err(unwritten)
        }
        _ if std::io::stdout().is_terminal() => {
            let shown = writeln!(std::io::stdout(), "{}", output::table(&schema, &batches, SHOWN));
            shown.map_err(|error| Error::Question(error.to_string()))
        }
        _ => output::write(std::io::stdout(), Format::Csv, &schema, &batches),
    }
}

/// A session on a cluster, or of this process.
async fn session(remote: Option<&str>, config: SessionConfig, question: &Question) -> Result<SessionContext> {
    #[cfg(feature = "cluster")]
    if let Some(url) = remote {
        return tumble_sql::cluster::client(url, config, question).await;
    }
    debug_assert!(remote.is_none(), "a cluster needs its feature");
    let mut state = SessionStateBuilder::new().with_default_features().with_config(config).build();
    // a cell that is no number may stand anywhere in a CSV
    state.table_options_mut().csv.schema_infer_max_rec = Some(usize::MAX);
    let ctx = SessionContext::new_with_state(state).enable_url_table();
    tumble_sql::register(&ctx, question)?;
    Ok(ctx)
}

/// A query of a session.
async fn frame(ctx: &SessionContext, sql: &str, remote: bool) -> Result<DataFrame> {
    #[cfg(feature = "cluster")]
    if remote {
        return Ok(tumble_sql::cluster::query(ctx, sql).await?);
    }
    debug_assert!(!remote, "a cluster needs its feature");
    Ok(ctx.sql(sql).await?)
}

/// Scheduler and executors; their program stands beside this one.
#[cfg(feature = "cluster")]
fn start(executors: usize, threads: usize) -> Result<tumble_sql::local::Local> {
    let own = std::env::current_exe().map_err(|error| Error::Question(error.to_string()))?;
    let node = own.with_file_name(format!("tumble-sql-node{}", std::env::consts::EXE_SUFFIX));
    tumble_sql::local::Local::start(&node, executors, threads, 60)
}
