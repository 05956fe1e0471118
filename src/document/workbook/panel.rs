//! A chart of a document as series over data in a sheet.

use super::Sheet;
use crate::document::chart::{Chart as Specification, Spot};
use crate::language::{Language, say};
use crate::uncertainty::quantiles::normal_quantile;
use rust_xlsxwriter::{
    Chart, ChartAxisCrossing, ChartErrorBars, ChartErrorBarsType, ChartFormat, ChartLegendPosition, ChartLine,
    ChartLineDashType, ChartMarker, ChartMarkerType, ChartRange, ChartType, Format, XlsxError,
};

/// More points than this are thinned evenly: older programs draw no more in a series.
const MOST: usize = 32_000;

/// One pair of axes and what is drawn over them.
pub(super) struct Panel {
    titles: [String; 2],
    /// Names along the level axis, where it has names; the abscissas count them then.
    names: Vec<String>,
    kind: Kind,
    series: Vec<Series>,
}

#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Points,
    Stacked,
    Logarithmic,
}

struct Series {
    name: String,
    /// Abscissa, ordinate, half length of the error bar.
    points: Vec<(f64, f64, f64)>,
    style: Style,
}

#[derive(Clone, Copy, PartialEq)]
enum Style {
    Marks,
    Line,
    Dashed,
}

impl Series {
    fn new(name: impl Into<String>, style: Style, points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        let points: Vec<(f64, f64, f64)> =
            points.into_iter().filter(|(x, y)| x.is_finite() && y.is_finite()).map(|(x, y)| (x, y, 0.0)).collect();
        let every = points.len().div_ceil(MOST).max(1);
        Series { name: name.into(), points: points.into_iter().step_by(every).collect(), style }
    }
}

/// Pairs of a place (counted from 1) and a value.
fn counted<'a>(values: impl Iterator<Item = f64> + 'a) -> impl Iterator<Item = (f64, f64)> + 'a {
    values.enumerate().map(|(k, value)| (k as f64 + 1.0, value))
}

fn with_unit(title: &str, unit: &str) -> String {
    if unit.is_empty() { title.to_string() } else { format!("{title}, {unit}") }
}

impl Panel {
    fn new(titles: [String; 2], series: Vec<Series>) -> Self {
        Panel { titles, names: Vec::new(), kind: Kind::Points, series }
    }

    /// A chart as panels; none for a matrix, which is read as a table, and for a drawing of a bench.
    pub(super) fn of(chart: &Specification, lang: Language) -> Vec<Panel> {
        let readings = || say!(lang, "readings-in-their-order").to_string();
        let residual = || say!(lang, "residual").to_string();
        match chart {
            Specification::Correlation(..) | Specification::Scene(_) => Vec::new(),
            Specification::Values(rows, unit) => {
                let points = (1..).zip(rows).map(|(k, row)| (f64::from(k), row.value, row.expanded)).collect();
                let series = Series { name: unit.clone(), points, style: Style::Marks };
                let names = rows.iter().map(|row| row.label.clone()).collect();
                vec![Panel { names, ..Panel::new([String::new(), unit.clone()], vec![series]) }]
            }
            Specification::Bars(rows, what, unit, _) => {
                let mut sources: Vec<&str> = Vec::new();
                for part in rows.iter().flat_map(|row| &row.parts) {
                    if !sources.contains(&part.source.as_str()) {
                        sources.push(&part.source);
                    }
                }
                let size = |source: &str, row: &crate::document::chart::Bar| -> f64 {
                    row.parts.iter().filter(|part| part.source == source).map(|part| part.size).sum()
                };
                let series = sources.iter().map(|source| {
                    Series::new(*source, Style::Marks, counted(rows.iter().map(|row| size(source, row))))
                });
                let series = series.collect();
                let names = rows.iter().map(|row| row.label.clone()).collect();
                let titles = [String::new(), with_unit(what, unit)];
                vec![Panel { names, kind: Kind::Stacked, ..Panel::new(titles, series) }]
            }
            Specification::Residuals(rows, what, unit) => {
                let of =
                    |far: bool| rows.iter().filter(move |row| row.far == far).map(|row| (row.number as f64, row.value));
                let band = |sign: f64| rows.iter().filter_map(move |row| Some((row.number as f64, sign * row.band?)));
                let mut series = vec![Series::new(what, Style::Marks, of(false))];
                if rows.iter().any(|row| row.far) {
                    series.push(Series::new(format!("{what} *"), Style::Marks, of(true)));
                }
                let name = || say!(lang, "noise-standard-deviations").to_string();
                series.extend([1.0, -1.0].map(|sign| Series::new(name(), Style::Line, band(sign))));
                vec![Panel::new([readings(), with_unit(what, unit)], series)]
            }
            Specification::Normal(studentized) => {
                let mut sorted: Vec<f64> = studentized.iter().copied().filter(|v| v.is_finite()).collect();
                sorted.sort_by(f64::total_cmp);
                let n = sorted.len() as f64;
                let points: Vec<(f64, f64)> = sorted
                    .iter()
                    .enumerate()
                    .filter_map(|(k, value)| Some((normal_quantile((k as f64 + 0.625) / (n + 0.25))?, *value)))
                    .collect();
                let ends = points.first().into_iter().chain(points.last()).map(|(z, _)| (*z, *z));
                let line = Series::new("1:1", Style::Dashed, ends.collect::<Vec<_>>());
                let titles = [say!(lang, "normal-quantile"), say!(lang, "studentized-residual")].map(String::from);
                vec![Panel::new(titles.clone(), vec![Series::new(&titles[1], Style::Marks, points), line])]
            }
            Specification::Gap(panels, _) => {
                let panel = |gaps: &crate::document::chart::GapPanel| {
                    let repaired = gaps.points.iter().any(|point| point.after.is_some());
                    let first = if repaired { say!(lang, "before").to_string() } else { residual() };
                    let mut series =
                        vec![Series::new(first, Style::Marks, counted(gaps.points.iter().map(|point| point.before)))];
                    if repaired {
                        let after = gaps.points.iter().map(|point| point.after.unwrap_or(f64::NAN));
                        series.push(Series::new(say!(lang, "after"), Style::Marks, counted(after)));
                    }
                    Panel::new([readings(), with_unit(&gaps.title, &gaps.unit)], series)
                };
                panels.iter().map(panel).collect()
            }
            Specification::Curves(curves, [what, unit, along]) => {
                let style = |dashed: bool| if dashed { Style::Dashed } else { Style::Line };
                let series = curves.iter().map(|c| Series::new(&c.label, style(c.dashed), c.points.clone()));
                vec![Panel::new([along.clone(), with_unit(what, unit)], series.collect())]
            }
            Specification::History(h) => {
                let points = h.points.clone();
                let mut series = vec![Series { name: h.label.clone(), points, style: Style::Marks }];
                let limits = h.limits.into_iter().flatten();
                let ends: Vec<f64> = h.points.first().into_iter().chain(h.points.last()).map(|p| p.0).collect();
                for limit in limits.filter(|limit| limit.is_finite()) {
                    series.push(Series::new("", Style::Dashed, ends.iter().map(|year| (*year, limit))));
                }
                series.extend(h.trend.map(|trend| Series::new("", Style::Line, trend)));
                vec![Panel::new([String::new(), with_unit(&h.label, &h.unit)], series)]
            }
            Specification::Control(control) => {
                let lots = || control.lots.iter();
                let limit = |sign: f64| counted(lots().map(move |(_, _, distance)| control.mean + sign * distance));
                let series = vec![
                    Series::new(&control.label, Style::Marks, counted(lots().map(|(_, mean, _)| *mean))),
                    Series::new("", Style::Line, counted(lots().map(|_| control.mean))),
                    Series::new("", Style::Dashed, limit(1.0)),
                    Series::new("", Style::Dashed, limit(-1.0)),
                ];
                let names = lots().map(|(name, ..)| name.clone()).collect();
                vec![Panel { names, ..Panel::new([String::new(), with_unit(&control.label, &control.unit)], series) }]
            }
            Specification::Distribution(d) => {
                // the share of the devices up to each value: the values themselves, without the choice of a bin
                let mut sorted: Vec<f64> = d.values.iter().copied().filter(|value| value.is_finite()).collect();
                sorted.sort_by(f64::total_cmp);
                let points = counted(sorted.iter().copied()).map(|(k, value)| (value, k)).collect::<Vec<_>>();
                let titles = [with_unit(&d.label, &d.unit), say!(lang, "devices").to_string()];
                vec![Panel::new(titles, vec![Series::new(&d.label, Style::Marks, points)])]
            }
            Specification::Deviations(points, title) => {
                let value = Series::new(title, Style::Marks, points.iter().map(|point| (point.tau, point.value)));
                let fitted = points.iter().filter_map(|point| Some((point.tau, point.fitted?)));
                let mut series = vec![value, Series::new("", Style::Line, fitted)];
                series.retain(|s| s.points.iter().all(|(x, y, _)| *x > 0.0 && *y > 0.0) && !s.points.is_empty());
                vec![Panel { kind: Kind::Logarithmic, ..Panel::new(["s".into(), title.clone()], series) }]
            }
            Specification::Record(record) => {
                let panel = |(title, course): &(String, Vec<(f64, f64)>)| {
                    Panel::new(["s".into(), title.clone()], vec![Series::new(title, Style::Line, course.clone())])
                };
                record.channels.iter().map(panel).collect()
            }
            Specification::Positions(spots, titles) => {
                let series = spots
                    .iter()
                    .filter(|spots| !spots.is_empty())
                    .map(|spots| Series::new("", Style::Marks, spots.iter().map(|spot: &Spot| (spot.x, spot.y))));
                vec![Panel::new(titles.clone(), series.collect())]
            }
        }
    }
}

impl Sheet<'_> {
    /// The data of a panel, to the right of what is read, and the chart over them; `None` where there is nothing to draw.
    pub(super) fn panel(&mut self, panel: &Panel) -> std::result::Result<Option<Chart>, XlsxError> {
        let mut chart = Chart::new(match panel.kind {
            Kind::Stacked => ChartType::BarStacked,
            _ => ChartType::Scatter,
        });
        let plain = Format::new();
        let name = self.name.clone();
        let mut drawn = 0_usize;
        for series in panel.series.iter().filter(|series| !series.points.is_empty()) {
            let (top, left) = (1_u32, self.data);
            let last = top + u32::try_from(series.points.len()).unwrap_or(u32::MAX) - 1;
            self.text(0, left, &panel.titles[0], &plain)?;
            self.text(0, left + 1, if series.name.is_empty() { &panel.titles[1] } else { &series.name }, &plain)?;
            let barred = series.points.iter().any(|(_, _, half)| *half > 0.0);
            for (row, (k, (x, y, half))) in (top..).zip(series.points.iter().enumerate()) {
                match panel.names.get(k) {
                    Some(name) => self.text(row, left, name, &plain)?,
                    None => self.number(row, left, *x, &plain)?,
                }
                self.number(row, left + 1, *y, &plain)?;
                if barred {
                    self.number(row, left + 2, *half, &plain)?;
                }
            }
            self.data = left.saturating_add(if barred { 4 } else { 3 });
            let range = |column: u16| ChartRange::new_from_range(&name, top, column, last, column);
            let chart_series = chart.add_series();
            chart_series.set_categories(&range(left)).set_values(&range(left + 1));
            if !series.name.is_empty() {
                chart_series.set_name(series.name.as_str());
            }
            if barred {
                let bars = ChartErrorBarsType::Custom(range(left + 2), range(left + 2));
                chart_series.set_y_error_bars(ChartErrorBars::new().set_type(bars));
            }
            style(chart_series, series.style, panel.kind);
            drawn += 1;
        }
        if drawn == 0 {
            return Ok(None);
        }
        let [along, up] = &panel.titles;
        let stacked = panel.kind == Kind::Stacked;
        let (along, up) = if stacked { (up, along) } else { (along, up) };
        let (x, y) = (along.as_str(), up.as_str());
        chart.x_axis().set_name(x);
        if stacked {
            // the first name on top, the numbers below
            chart.y_axis().set_reverse().set_crossing(ChartAxisCrossing::Max);
        } else {
            chart.y_axis().set_name(y);
        }
        if drawn == 1 {
            chart.title().set_hidden();
        }
        if panel.kind == Kind::Logarithmic {
            chart.x_axis().set_log_base(10);
            chart.y_axis().set_log_base(10);
        }
        match drawn {
            1 => chart.legend().set_hidden(),
            _ => chart.legend().set_position(ChartLegendPosition::Bottom),
        };
        Ok(Some(chart))
    }
}

fn style(series: &mut rust_xlsxwriter::ChartSeries, style: Style, kind: Kind) {
    if kind == Kind::Stacked {
        return;
    }
    let mut line = ChartLine::new();
    match style {
        Style::Marks => line.set_hidden(true),
        Style::Line => line.set_width(1.5),
        Style::Dashed => line.set_width(1.0).set_dash_type(ChartLineDashType::Dash),
    };
    series.set_format(ChartFormat::new().set_line(&line));
    let mut marker = ChartMarker::new();
    match style {
        Style::Marks => marker.set_type(ChartMarkerType::Circle).set_size(5),
        _ => marker.set_none(),
    };
    series.set_marker(&marker);
}
