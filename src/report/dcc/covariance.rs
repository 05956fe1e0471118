//! The covariance of all estimates, with the factor of their joint region.

use super::texts::{Texts, Xml, text, told, within};
use super::{Quantity, decimal, plain, units};
use crate::language::say;
use crate::report::FitReport;
use crate::uncertainty::quantiles;
use std::io;

/// The joint region: covariance and the factor of its ellipsoid, `k^2 = n F(level; n, nu)` with the smallest degrees of freedom (GUM
/// Supplement 2, 6.5.3 for the normal: `k^2` the chi-square quantile).
pub(super) fn write(xml: &mut Xml, report: &FitReport, quantities: &[Quantity], texts: Texts<'_>) -> io::Result<()> {
    let joint: Vec<(&Quantity, usize)> = quantities.iter().filter_map(|q| Some((q, q.index?))).collect();
    let at = |i: usize, j: usize| report.covariance.matrix.get(i).and_then(|row| row.get(j)).copied().flatten();
    // column by column; nothing where an element is missing
    let column = |(_, j): &(&Quantity, usize)| joint.iter().map(|(_, i)| at(*i, *j)).collect::<Option<Vec<f64>>>();
    let Some(columns) = joint.iter().map(column).collect::<Option<Vec<_>>>() else { return Ok(()) };
    let level = report.parameters.first().map_or(0.95, |p| p.level);
    let dof = joint.iter().map(|(q, _)| q.dof).fold(f64::INFINITY, f64::min);
    let n = joint.len() as f64;
    let square = match dof.is_finite() {
        true => quantiles::fisher_f_quantile(level, n, dof).map(|f| n * f),
        false => quantiles::chi_square_quantile(level, n),
    };
    let factor = square.map(f64::sqrt).filter(|k| k.is_finite() && *k >= 1.0);
    let Some(factor) = factor.filter(|_| joint.len() > 1) else { return Ok(()) };
    let list = |of: &dyn Fn(&Quantity) -> String| joint.iter().map(|(q, _)| of(q)).collect::<Vec<_>>().join(" ");
    within(xml, "dcc:result", |xml| {
        told(xml, "dcc:name", texts, |lang| say!(lang, "dcc-covariance").into())?;
        within(xml, "dcc:data", |xml| {
            within(xml, "dcc:quantity", |xml| {
                told(xml, "dcc:name", texts, |lang| say!(lang, "estimates").into())?;
                within(xml, "si:realListXMLList", |xml| {
                    text(xml, "si:labelXMLList", &list(&|q| q.id.clone()))?;
                    text(xml, "si:valueXMLList", &list(&|q| decimal(q.value)))?;
                    text(xml, "si:unitXMLList", &list(&|q| units::d_si(&[&q.unit])))?;
                    within(xml, "si:ellipsoidalRegionXMLList", |xml| {
                        within(xml, "si:covarianceMatrix", |xml| {
                            joint.iter().zip(&columns).try_for_each(|((a, _), column)| {
                                within(xml, "si:column", |xml| {
                                    joint.iter().zip(column).try_for_each(|((b, _), value)| {
                                        within(xml, "si:covariance", |xml| {
                                            text(xml, "si:value", &decimal(*value))?;
                                            text(xml, "si:unit", &units::d_si(&[&a.unit, &b.unit]))
                                        })
                                    })
                                })
                            })
                        })?;
                        text(xml, "si:coverageFactor", &plain(factor))?;
                        text(xml, "si:coverageProbability", &plain(level))?;
                        text(xml, "si:distribution", if dof.is_finite() { "t" } else { "normal" })
                    })
                })
            })
        })
    })
}
