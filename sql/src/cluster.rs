//! Ballista: the same SQL on several machines. The campaign travels with the query, so that schedulers and executors need no file of it.
//!
//! Scheduler and executors must see the tables under the same paths; they need `tumble_fit()`, and so this program (`tumble-sql-node`).

use crate::function::{Fit, own};
use crate::question::Question;
use ballista::prelude::SessionContextExt;
use ballista_core::config::TaskSchedulingPolicy;
use ballista_core::extension::SessionConfigExt;
use ballista_core::serde::{BallistaLogicalExtensionCodec, BallistaPhysicalExtensionCodec};
use ballista_executor::executor_process::{ExecutorProcessConfig, start_executor_process};
use ballista_scheduler::cluster::BallistaCluster;
use ballista_scheduler::config::SchedulerConfig;
use ballista_scheduler::scheduler_process::start_server;
use datafusion::arrow::datatypes::SchemaRef;
use datafusion::catalog::TableProvider;
use datafusion::common::{Result, TableReference, exec_datafusion_err};
use datafusion::datasource::file_format::FileFormatFactory;
use datafusion::execution::{SessionStateBuilder, TaskContext};
use datafusion::logical_expr::{AggregateUDF, Extension, LogicalPlan, ScalarUDF, WindowUDF};
use datafusion::physical_plan::ExecutionPlan;
use datafusion::prelude::{DataFrame, SessionConfig, SessionContext};
use datafusion::sql::parser::Statement;
use datafusion::sql::sqlparser::ast::{ObjectName, ObjectNamePart, visit_relations_mut};
use datafusion_proto::logical_plan::LogicalExtensionCodec;
use datafusion_proto::physical_plan::{PhysicalExtensionCodec, PhysicalProtoConverterExtension};
use serde::{Deserialize, Serialize};
use std::ops::ControlFlow;
use std::sync::Arc;

/// Our functions with their campaign and columns; everything else as Ballista sends it.
#[derive(Debug, Default)]
pub struct Codec {
    logical: BallistaLogicalExtensionCodec,
    physical: BallistaPhysicalExtensionCodec,
}

/// A function as it is sent.
#[derive(Debug, Serialize, Deserialize)]
struct Definition {
    question: Question,
    exact: bool,
    keys: Option<Vec<String>>,
}

fn encoded(function: &AggregateUDF, to: &mut Vec<u8>) -> Option<Result<()>> {
    let (question, exact, keys) = own(function)?.definition();
    let definition = Definition { question: question.clone(), exact, keys: keys.map(<[String]>::to_vec) };
    Some(serde_json::to_writer(to, &definition).map_err(|error| exec_datafusion_err!("{error}")))
}

fn decoded(name: &str, from: &[u8]) -> Option<Result<Arc<AggregateUDF>>> {
    if ![crate::FIT, crate::EXACT].contains(&name) {
        return None;
    }
    let function = || -> Result<Arc<AggregateUDF>> {
        let definition: Definition = serde_json::from_slice(from).map_err(|error| exec_datafusion_err!("{error}"))?;
        let fit = Fit::new(Arc::new(definition.question), definition.exact)?;
        let fit = definition.keys.map_or(Ok(fit.clone()), |keys| fit.of(keys))?;
        Ok(Arc::new(AggregateUDF::from(fit)))
    };
    Some(function())
}

impl LogicalExtensionCodec for Codec {
    fn try_decode(&self, buf: &[u8], inputs: &[LogicalPlan], ctx: &TaskContext) -> Result<Extension> {
        self.logical.try_decode(buf, inputs, ctx)
    }
    fn try_encode(&self, node: &Extension, buf: &mut Vec<u8>) -> Result<()> {
        self.logical.try_encode(node, buf)
    }
    fn try_decode_table_provider(
        &self,
        buf: &[u8],
        table: &TableReference,
        schema: SchemaRef,
        ctx: &TaskContext,
    ) -> Result<Arc<dyn TableProvider>> {
        self.logical.try_decode_table_provider(buf, table, schema, ctx)
    }
    fn try_encode_table_provider(
        &self,
        table: &TableReference,
        node: Arc<dyn TableProvider>,
        buf: &mut Vec<u8>,
    ) -> Result<()> {
        self.logical.try_encode_table_provider(table, node, buf)
    }
    fn try_decode_file_format(&self, buf: &[u8], ctx: &TaskContext) -> Result<Arc<dyn FileFormatFactory>> {
        self.logical.try_decode_file_format(buf, ctx)
    }
    fn try_encode_file_format(&self, buf: &mut Vec<u8>, node: Arc<dyn FileFormatFactory>) -> Result<()> {
        self.logical.try_encode_file_format(buf, node)
    }
    fn try_decode_udf(&self, name: &str, buf: &[u8]) -> Result<Arc<ScalarUDF>> {
        self.logical.try_decode_udf(name, buf)
    }
    fn try_encode_udf(&self, node: &ScalarUDF, buf: &mut Vec<u8>) -> Result<()> {
        self.logical.try_encode_udf(node, buf)
    }
    fn try_decode_udaf(&self, name: &str, buf: &[u8]) -> Result<Arc<AggregateUDF>> {
        decoded(name, buf).unwrap_or_else(|| self.logical.try_decode_udaf(name, buf))
    }
    fn try_encode_udaf(&self, node: &AggregateUDF, buf: &mut Vec<u8>) -> Result<()> {
        encoded(node, buf).unwrap_or_else(|| self.logical.try_encode_udaf(node, buf))
    }
    fn try_decode_udwf(&self, name: &str, buf: &[u8]) -> Result<Arc<WindowUDF>> {
        self.logical.try_decode_udwf(name, buf)
    }
    fn try_encode_udwf(&self, node: &WindowUDF, buf: &mut Vec<u8>) -> Result<()> {
        self.logical.try_encode_udwf(node, buf)
    }
}

impl PhysicalExtensionCodec for Codec {
    fn try_decode(
        &self,
        buf: &[u8],
        inputs: &[Arc<dyn ExecutionPlan>],
        ctx: &TaskContext,
        proto_converter: &dyn PhysicalProtoConverterExtension,
    ) -> Result<Arc<dyn ExecutionPlan>> {
        self.physical.try_decode(buf, inputs, ctx, proto_converter)
    }
    fn try_encode(
        &self,
        node: Arc<dyn ExecutionPlan>,
        buf: &mut Vec<u8>,
        proto_converter: &dyn PhysicalProtoConverterExtension,
    ) -> Result<()> {
        self.physical.try_encode(node, buf, proto_converter)
    }
    fn try_decode_udf(&self, name: &str, buf: &[u8]) -> Result<Arc<ScalarUDF>> {
        self.physical.try_decode_udf(name, buf)
    }
    fn try_encode_udf(&self, node: &ScalarUDF, buf: &mut Vec<u8>) -> Result<()> {
        self.physical.try_encode_udf(node, buf)
    }
    fn try_decode_udaf(&self, name: &str, buf: &[u8]) -> Result<Arc<AggregateUDF>> {
        decoded(name, buf).unwrap_or_else(|| self.physical.try_decode_udaf(name, buf))
    }
    fn try_encode_udaf(&self, node: &AggregateUDF, buf: &mut Vec<u8>) -> Result<()> {
        encoded(node, buf).unwrap_or_else(|| self.physical.try_encode_udaf(node, buf))
    }
    fn try_decode_udwf(&self, name: &str, buf: &[u8]) -> Result<Arc<WindowUDF>> {
        self.physical.try_decode_udwf(name, buf)
    }
    fn try_encode_udwf(&self, node: &WindowUDF, buf: &mut Vec<u8>) -> Result<()> {
        self.physical.try_encode_udwf(node, buf)
    }
}

/// A scheduler; it serves until the process ends. An executor that has not been heard of for `timeout_s` seconds is given up, and its work done anew.
///
/// # Errors
///
/// A port that cannot be had.
pub async fn scheduler(host: &str, port: u16, timeout_s: u64) -> Result<()> {
    let config = SchedulerConfig {
        bind_host: host.into(),
        bind_port: port,
        external_host: host.into(),
        scheduling_policy: TaskSchedulingPolicy::PullStaged,
        executor_timeout_seconds: timeout_s,
        no_executors_grace_period_seconds: timeout_s,
        expire_dead_executor_interval_seconds: (timeout_s / 4).max(1),
        override_logical_codec: Some(Arc::new(Codec::default())),
        override_physical_codec: Some(Arc::new(Codec::default())),
        ..SchedulerConfig::default()
    };
    let address = format!("{host}:{port}").parse().map_err(|error| exec_datafusion_err!("{host}:{port}: {error}"))?;
    let cluster = BallistaCluster::new_from_config(&config).await.map_err(|error| exec_datafusion_err!("{error}"))?;
    start_server(cluster, address, Arc::new(config)).await.map_err(|error| exec_datafusion_err!("{error}"))
}

/// An executor of a scheduler at `host:port`, with ports of its own and a folder for what it passes on; it works until the process ends.
///
/// # Errors
///
/// A scheduler that does not answer, ports that cannot be had.
pub async fn executor(
    scheduler: (&str, u16),
    host: &str,
    ports: [u16; 2],
    threads: usize,
    work: Option<String>,
) -> Result<()> {
    let config = ExecutorProcessConfig {
        bind_host: host.into(),
        external_host: Some(host.into()),
        port: ports[0],
        grpc_port: ports[1],
        scheduler_host: scheduler.0.into(),
        scheduler_port: scheduler.1,
        scheduler_connect_timeout_seconds: 20,
        vcores: threads.max(1),
        work_dir: work,
        task_scheduling_policy: TaskSchedulingPolicy::PullStaged,
        override_logical_codec: Some(Arc::new(Codec::default())),
        override_physical_codec: Some(Arc::new(Codec::default())),
        ..ExecutorProcessConfig::default()
    };
    start_executor_process(Arc::new(config)).await.map_err(|error| exec_datafusion_err!("{error}"))
}

/// A session whose queries run on the cluster of a scheduler (`df://host:port`), with our functions.
///
/// # Errors
///
/// A campaign that is malformed; an address that is none.
pub async fn client(url: &str, config: SessionConfig, question: &Question) -> crate::Result<SessionContext> {
    let config = config
        .upgrade_for_ballista()
        .with_ballista_logical_extension_codec(Arc::new(Codec::default()))
        .with_ballista_physical_extension_codec(Arc::new(Codec::default()));
    let mut state = SessionStateBuilder::new().with_default_features().with_config(config).build();
    // a cell that is no number may stand anywhere in a CSV
    state.table_options_mut().csv.schema_infer_max_rec = Some(usize::MAX);
    let ctx = SessionContext::remote_with_state(url, state).await?.enable_url_table();
    crate::register(&ctx, question)?;
    Ok(ctx)
}

/// A query on a cluster.
///
/// A table that is a file of the working folder, `FROM 'readings.csv'`, is sent as `./readings.csv`: Ballista's messages take a name with a point and
/// without a slash for that of a table in a schema.
///
/// # Errors
///
/// What DataFusion says of the query.
pub async fn query(ctx: &SessionContext, sql: &str) -> Result<DataFrame> {
    let state = ctx.state();
    let dialect = state.config().options().sql_parser.dialect;
    let mut statement = state.sql_to_statement(sql, &dialect)?;
    if let Statement::Statement(own) = &mut statement {
        let _ = visit_relations_mut(own, |name: &mut ObjectName| {
            if let [ObjectNamePart::Identifier(file)] = name.0.as_mut_slice()
                && file.quote_style.is_some()
                && file.value.contains('.')
                && !file.value.contains('/')
            {
                file.value.insert_str(0, "./");
            }
            ControlFlow::<()>::Continue(())
        });
    }
    let plan = state.statement_to_plan(statement).await?;
    ctx.execute_logical_plan(plan).await
}
