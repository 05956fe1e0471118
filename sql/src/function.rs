//! `tumble_fit()` and `tumble_fit_exact()` as DataFusion knows them, and the rule that gives them their columns.

use crate::answer;
use crate::error::Result;
use crate::groups::Groups;
use crate::question::{Bound, Quantities, Question};
use crate::whole::Whole;
use datafusion::arrow::datatypes::{DataType, Field, FieldRef};
use datafusion::common::config::ConfigOptions;
use datafusion::common::tree_node::{Transformed, TreeNode};
use datafusion::common::{Column, DFSchema, plan_datafusion_err, plan_err};
use datafusion::error::Result as PlanResult;
use datafusion::logical_expr::expr::{AggregateFunction, AggregateFunctionParams};
use datafusion::logical_expr::expr_rewriter::NamePreserver;
use datafusion::logical_expr::function::{AccumulatorArgs, StateFieldsArgs};
use datafusion::logical_expr::{
    Accumulator, Aggregate, AggregateUDF, AggregateUDFImpl, Expr, GroupsAccumulator, LogicalPlan, Signature,
    TypeSignature, Volatility, cast,
};
use datafusion::optimizer::AnalyzerRule;
use std::hash::{Hash, Hasher};
use std::sync::Arc;

/// The linear step, whose state is a triangle.
pub const FIT: &str = "tumble_fit";
/// The ordinary fit, whose state are the rows.
pub const EXACT: &str = "tumble_fit_exact";

/// One of the functions; without columns until a query says which there are.
#[derive(Debug, Clone)]
pub struct Fit {
    question: Arc<Question>,
    quantities: Arc<Quantities>,
    exact: bool,
    /// Columns in the order of the arguments.
    keys: Option<Vec<String>>,
    bound: Option<Arc<Bound>>,
    signature: Signature,
}

impl PartialEq for Fit {
    fn eq(&self, other: &Self) -> bool {
        (self.exact, &self.keys, &self.question) == (other.exact, &other.keys, &other.question)
    }
}

impl Eq for Fit {}

impl Hash for Fit {
    fn hash<H: Hasher>(&self, state: &mut H) {
        (self.exact, &self.keys, &self.question).hash(state);
    }
}

impl Fit {
    /// The function for a campaign; `exact` for the one that keeps the rows.
    ///
    /// # Errors
    ///
    /// A campaign that is malformed.
    pub fn new(question: Arc<Question>, exact: bool) -> Result<Self> {
        let quantities = Arc::new(question.quantities()?);
        let signature =
            Signature::one_of(vec![TypeSignature::Nullary, TypeSignature::VariadicAny], Volatility::Immutable);
        Ok(Fit { question, quantities, exact, keys: None, bound: None, signature })
    }

    /// The same function of columns with these names, in this order.
    ///
    /// # Errors
    ///
    /// A campaign that the function cannot answer, and what does.
    pub fn of(&self, keys: Vec<String>) -> Result<Self> {
        let bound = self.question.bind(&keys, self.exact)?;
        Ok(Fit { keys: Some(keys), bound: Some(Arc::new(bound)), ..self.clone() })
    }

    /// The question, whether rows are kept, and the columns.
    pub fn definition(&self) -> (&Question, bool, Option<&[String]>) {
        (&self.question, self.exact, self.keys.as_deref())
    }

    fn bound(&self) -> PlanResult<Arc<Bound>> {
        let unbound = || plan_datafusion_err!("{}() stands where no table's columns are to be found", self.name());
        self.bound.clone().ok_or_else(unbound)
    }

    /// Columns of a table as arguments.
    fn arguments(&self, schema: &DFSchema) -> PlanResult<(Self, Vec<Expr>)> {
        let names: Vec<String> = schema.fields().iter().map(|field| field.name().clone()).collect();
        let keys = self.question.columns(&names)?;
        let mut arguments = Vec::with_capacity(keys.len());
        for key in &keys {
            let Some((qualifier, field)) = schema.iter().find(|(_, field)| field.name() == key) else { continue };
            let column = Expr::Column(Column::from((qualifier, field)));
            arguments.push(match field.data_type() {
                DataType::Float64 => column,
                // a cell that is no number is the answer of its device
                DataType::Utf8 => column,
                DataType::LargeUtf8 | DataType::Utf8View => cast(column, DataType::Utf8),
                kind if kind.is_numeric() || *kind == DataType::Null => cast(column, DataType::Float64),
                kind => {
                    return plan_err!(
                        "the column {key} is {kind}, and the campaign needs numbers there: expected a numeric column, for example \
                         SELECT CAST(\"{key}\" AS DOUBLE) AS \"{key}\", ... FROM ..."
                    );
                }
            });
        }
        Ok((self.of(keys)?, arguments))
    }
}

impl AggregateUDFImpl for Fit {
    fn name(&self) -> &str {
        if self.exact { EXACT } else { FIT }
    }

    fn signature(&self) -> &Signature {
        &self.signature
    }

    fn return_type(&self, _: &[DataType]) -> PlanResult<DataType> {
        Ok(DataType::Struct(answer::fields(&self.quantities, self.exact)))
    }

    fn is_nullable(&self) -> bool {
        false
    }

    fn accumulator(&self, args: AccumulatorArgs) -> PlanResult<Box<dyn Accumulator>> {
        self.refuse(&args)?;
        let (bound, quantities) = (self.bound()?, Arc::clone(&self.quantities));
        Ok(if self.exact { Box::new(Whole::new(bound, quantities)) } else { Box::new(Groups::new(bound, quantities)) })
    }

    fn state_fields(&self, args: StateFieldsArgs) -> PlanResult<Vec<FieldRef>> {
        let numbers = DataType::List(Arc::new(Field::new_list_field(DataType::Float64, true)));
        let name = |end: &str| format!("{}[{end}]", args.name);
        Ok(match self.exact {
            true => vec![Arc::new(Field::new(name("rows"), numbers, true))],
            false => vec![
                Arc::new(Field::new(name("triangle"), numbers.clone(), true)),
                Arc::new(Field::new(name("values"), numbers, true)),
                Arc::new(Field::new(name("fault"), DataType::Utf8, true)),
            ],
        })
    }

    fn groups_accumulator_supported(&self, _: AccumulatorArgs) -> bool {
        true
    }

    fn create_groups_accumulator(&self, args: AccumulatorArgs) -> PlanResult<Box<dyn GroupsAccumulator>> {
        self.refuse(&args)?;
        let (bound, quantities) = (self.bound()?, Arc::clone(&self.quantities));
        Ok(if self.exact { Box::new(Whole::new(bound, quantities)) } else { Box::new(Groups::new(bound, quantities)) })
    }
}

impl Fit {
    fn refuse(&self, args: &AccumulatorArgs) -> PlanResult<()> {
        if args.is_distinct {
            return plan_err!(
                "{}(DISTINCT) would drop readings that agree; SELECT DISTINCT in a subquery says so plainly",
                self.name()
            );
        }
        Ok(())
    }
}

/// Gives `tumble_fit()` the columns of the table that it stands over.
#[derive(Debug, Default)]
pub struct Columns;

impl AnalyzerRule for Columns {
    fn analyze(&self, plan: LogicalPlan, _: &ConfigOptions) -> PlanResult<LogicalPlan> {
        Ok(plan.transform_up_with_subqueries(bind)?.data)
    }

    fn name(&self) -> &str {
        "tumble_columns"
    }
}

fn bind(plan: LogicalPlan) -> PlanResult<Transformed<LogicalPlan>> {
    let LogicalPlan::Aggregate(aggregate) = plan else { return Ok(Transformed::no(plan)) };
    let names = NamePreserver::new_for_projection();
    let mut changed = false;
    let mut functions = Vec::with_capacity(aggregate.aggr_expr.len());
    for expression in &aggregate.aggr_expr {
        let name = names.save(expression);
        let bound = expression.clone().transform_up(|inner| {
            let Expr::AggregateFunction(AggregateFunction { func, params }) = &inner else {
                return Ok(Transformed::no(inner));
            };
            let Some(fit) = own(func).filter(|fit| fit.keys.is_none()) else { return Ok(Transformed::no(inner)) };
            if !params.args.is_empty() {
                return plan_err!(
                    "{}() takes no arguments: it finds the columns that the campaign needs by their names; rename them in a subquery",
                    fit.name()
                );
            }
            let (fit, args) = fit.arguments(aggregate.input.schema())?;
            let params = AggregateFunctionParams { args, ..params.clone() };
            let func = Arc::new(AggregateUDF::from(fit));
            Ok(Transformed::yes(Expr::AggregateFunction(AggregateFunction { func, params })))
        })?;
        changed |= bound.transformed;
        functions.push(if bound.transformed { name.restore(bound.data) } else { bound.data });
    }
    if !changed {
        return Ok(Transformed::no(LogicalPlan::Aggregate(aggregate)));
    }
    let Aggregate { input, group_expr, .. } = aggregate;
    Ok(Transformed::yes(LogicalPlan::Aggregate(Aggregate::try_new(input, group_expr, functions)?)))
}

/// The function behind an aggregate, if it is one of ours.
pub fn own(function: &AggregateUDF) -> Option<&Fit> {
    (function.inner().as_ref() as &dyn std::any::Any).downcast_ref::<Fit>()
}
