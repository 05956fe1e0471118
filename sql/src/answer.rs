//! One row a device as a struct: the columns of `tumble fit --by`, as far as there are any.

use crate::question::Quantities;
use datafusion::arrow::array::{ArrayRef, Float64Builder, Int64Builder, StringBuilder, StructArray};
use datafusion::arrow::datatypes::{DataType, Field, Fields};
use std::sync::Arc;
use tumble::batch::Row;

/// The fields of an answer; `whole` where the readings were at hand, so that every check is there.
pub(crate) fn fields(quantities: &Quantities, whole: bool) -> Fields {
    let field = |name: &str, kind: DataType, nullable: bool| Field::new(name, kind, nullable);
    let mut fields = vec![field("verdict", DataType::Utf8, false)];
    if quantities.limited {
        fields.push(field("conformity", DataType::Utf8, true));
    }
    for name in &quantities.names {
        fields.extend(["", "_u", "_U"].map(|end| field(&format!("{name}{end}"), DataType::Float64, true)));
    }
    fields.extend(["readings", "rank", "dof"].map(|name| field(name, DataType::Int64, false)));
    fields.extend(["chi_square", "residual_sd", "chi_square_p"].map(|name| field(name, DataType::Float64, true)));
    if whole {
        let tests = ["lack_of_fit_p", "runs_p", "normality_p"];
        fields.extend(tests.map(|name| field(name, DataType::Float64, true)));
        fields.push(field("suspects", DataType::Int64, false));
    }
    fields.push(field("why", DataType::Utf8, false));
    Fields::from(fields)
}

/// Answers as an array of these fields.
pub(crate) fn array(rows: &[Row], quantities: &Quantities, whole: bool) -> StructArray {
    let number = |of: &dyn Fn(&Row) -> f64| -> ArrayRef {
        let mut column = Float64Builder::with_capacity(rows.len());
        rows.iter().for_each(|row| column.append_option(Some(of(row)).filter(|x| x.is_finite())));
        Arc::new(column.finish())
    };
    let count = |of: &dyn Fn(&Row) -> usize| -> ArrayRef {
        let mut column = Int64Builder::with_capacity(rows.len());
        rows.iter().for_each(|row| column.append_value(of(row) as i64));
        Arc::new(column.finish())
    };
    let text = |of: &dyn Fn(&Row) -> Option<&str>| -> ArrayRef {
        let mut column = StringBuilder::new();
        rows.iter().for_each(|row| column.append_option(of(row)));
        Arc::new(column.finish())
    };
    let mut columns = vec![text(&|row| Some(row.verdict.name()))];
    if quantities.limited {
        columns.push(text(&|row| row.conformity.map(|own| own.name())));
    }
    let at = |list: &[f64], k: usize| list.get(k).copied().unwrap_or(f64::NAN);
    for k in 0..quantities.names.len() {
        columns.push(number(&|row| at(&row.value, k)));
        columns.push(number(&|row| at(&row.u, k)));
        columns.push(number(&|row| at(&row.expanded, k)));
    }
    columns.extend([count(&|row| row.readings), count(&|row| row.rank), count(&|row| row.dof)]);
    columns.push(number(&|row| row.residual_sd * row.residual_sd * row.dof as f64));
    columns.extend([number(&|row| row.residual_sd), number(&|row| row.chi_square_p)]);
    if whole {
        columns.extend([number(&|row| row.lack_of_fit_p), number(&|row| row.runs_p), number(&|row| row.normality_p)]);
        columns.push(count(&|row| row.suspects.len()));
    }
    columns.push(text(&|row| Some(&row.why)));
    StructArray::new(fields(quantities, whole), columns, None)
}
