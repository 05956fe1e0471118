//! Units of coefficients, inferred from the model lines: in `V0 + kI*w_I`, with V in volts and rates in deg/s, `kI` is in V/(deg/s).
//!
//! Every line has its sensor's unit, sums have equal units, products add powers, functions take pure numbers or radians: linear
//! equations in the powers of the known units of sensors and inputs. They may leave units undetermined.

use crate::algebra::{Expression, Powers, Reason};
use crate::bench::Bench;
use crate::error::Result;
use crate::units::{self, Conversion, Unit};
use std::collections::{BTreeMap, HashMap};

/// Units of a bench that follow from its model lines.
#[derive(Debug, Clone, Default)]
pub struct Inferred {
    /// Unit of each coefficient that the lines (or stated units) determine.
    units: HashMap<String, Unit>,
    /// Units of sensors that the table of units does not have.
    sensor_units: Vec<String>,
    /// Sensors whose lines add terms of different dimensions, by index, with the quotient of the two units.
    conflicts: Vec<(usize, String)>,
}

impl Inferred {
    /// Infer the units of the coefficients of a bench whose readings have these columns; `stated` units count where the lines do not determine one.
    ///
    /// The unit of a numeric column is the end of its name (`time_s`, `temperature_c`); a sensor or column without a unit adds no equation.
    pub fn new(bench: &Bench, columns: &[String], stated: &[(String, Unit)]) -> Self {
        let mut system = System::default();
        let mut sensor_units = Vec::new();
        let mut rows: Vec<(usize, Stage, Row)> = Vec::new();
        for (k, sensor) in bench.sensors.iter().enumerate() {
            let line = sensor.model.homogeneity();
            if let Some(mut row) = line.unit.and_then(|unit| system.row(bench, columns, &unit)) {
                match Unit::parse_any(&sensor.unit) {
                    Ok((unit, names)) if !sensor.unit.is_empty() => {
                        add(&mut row.known, system.known(unit), -1.0);
                        sensor_units.extend(names);
                    }
                    _ => add(&mut row.open, system.open(&format!("unit of {}", sensor.id), Open::Sensor), -1.0),
                }
                rows.push((k, Stage::Line, row));
            }
            for relation in line.relations {
                let Some(row) = system.row(bench, columns, &relation.powers) else { continue };
                let stage = match relation.reason {
                    Reason::One if row.open.keys().all(|k| system.is(*k, Open::Column)) => Stage::Indicator,
                    Reason::One => Stage::One,
                    Reason::Terms => Stage::Terms,
                    Reason::Argument => Stage::Argument,
                };
                rows.push((k, stage, row));
            }
        }
        // stated units come before terms added to one, which need not be pure numbers
        for (name, unit) in stated {
            let mut row = Row::default();
            add(&mut row.open, system.open(name, Open::Coefficient), 1.0);
            add(&mut row.known, system.known(unit.clone()), -1.0);
            rows.push((0, Stage::Stated, row));
        }
        rows.sort_by_key(|(_, stage, _)| *stage);
        let mut conflicts = Vec::new();
        for (sensor, stage, row) in rows {
            let quotient = system.require(row, stage == Stage::One);
            if let Some(quotient) = quotient.filter(|_| matches!(stage, Stage::Line | Stage::Terms))
                && !quotient.dimension().is_angle_or_number()
            {
                conflicts.push((sensor, quotient.symbol().to_string()));
            }
        }
        sensor_units.sort_unstable();
        sensor_units.dedup();
        let units = system.solution();
        Inferred { units, sensor_units, conflicts }
    }

    /// The unit of a coefficient; `None` where it is not determined.
    pub fn unit(&self, coefficient: &str) -> Option<&Unit> {
        self.units.get(coefficient)
    }

    /// Read a unit as this bench knows units: the table's, and those of its sensors.
    ///
    /// Errors: those of [`Unit::parse`].
    pub fn parse(&self, text: &str) -> Result<Unit> {
        Unit::parse_with(text, &self.sensor_units)
    }

    /// Sensors, by index, whose lines add terms of different dimensions, and the quotient of the two units.
    pub fn conflicts(&self) -> &[(usize, String)] {
        &self.conflicts
    }
}

impl super::Campaign {
    /// From a unit that a person wrote to another, both as this bench knows units; `what` names the value in messages.
    ///
    /// Errors: a unit that does not parse, or one of another dimension, with the unit that was expected.
    pub fn conversion(&self, unit: &str, to: &str, what: &str) -> Result<Conversion> {
        let given = self.units.parse(unit)?;
        if to.is_empty() {
            return Ok(Conversion::NONE);
        }
        given.conversion_for(&self.units.parse(to)?, what)
    }

    /// From a unit that a person wrote to the internal one of a parameter, by index: radians for a tilt, else the unit from the model line.
    ///
    /// Errors: those of [`super::Campaign::conversion`].
    pub fn parameter_conversion(&self, parameter: usize, unit: &str) -> Result<Conversion> {
        self.conversion(unit, self.parameter_unit(parameter), &format!("'{}'", self.parameter_id(parameter)))
    }

    /// Unit of a line of algebra in the parameters, for example of a derived quantity; `None` where one of them has none, or its terms differ.
    pub fn unit_of(&self, line: &Expression) -> Option<Unit> {
        let homogeneity = line.homogeneity();
        let mut factors: Vec<(Unit, f64)> = Vec::new();
        let radian = Unit::parse("rad").ok()?;
        let mut add = |unit: Unit, power: f64| match factors.iter_mut().find(|(other, _)| other.is_same(&unit)) {
            Some((_, sum)) => *sum += power,
            None => factors.push((unit, power)),
        };
        let powers = homogeneity.unit.filter(|powers| powers.radian == 0.0 || !powers.pi)?;
        for (name, power) in &powers.names {
            let parameter =
                self.parameter_index(name).and_then(|k| self.parameters.get(k)).filter(|p| !p.unit.is_empty())?;
            add(self.units.parse(&parameter.unit).ok()?, *power);
        }
        add(radian, powers.radian);
        // a pure number may have a size: mg/g is 0.001, (deg/h)/(deg/s) 1/3600
        factors.retain(|(unit, power)| power.abs() > SMALL && !unit.is_same(&Unit::one()));
        let homogeneous = homogeneity.relations.iter().all(|relation| {
            let unit = relation.powers.names.iter().try_fold(Unit::one(), |unit, (name, power)| {
                let parameter = self.parameter_index(name).and_then(|k| self.parameters.get(k))?;
                Some(unit.times(&self.units.parse(&parameter.unit).ok()?, *power))
            });
            relation.reason == Reason::Argument || unit.is_some_and(|unit| unit.is_one())
        });
        homogeneous.then(|| Unit::reduced(&factors))
    }
}

/// The unit of a coefficient from the model lines; `None` where they do not determine it.
///
/// ```
/// use tumble::{bench, campaign, wire};
/// let text = bench::built_in("gyro-turntable").unwrap().text;
/// let bench = wire::read_bench(&wire::Source { name: String::new(), text: text.into() })?;
/// assert_eq!(campaign::coefficient_unit(&bench, &[], "kIO").as_deref(), Some("V/(deg/s)^2"));
/// # Ok::<(), tumble::error::Malformed>(())
/// ```
pub fn coefficient_unit(bench: &Bench, columns: &[String], coefficient: &str) -> Option<String> {
    Inferred::new(bench, columns, &[]).unit(coefficient).map(|unit| unit.symbol().to_string())
}

/// Equations in the order in which they are taken: an earlier one decides where two disagree.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Stage {
    /// `1 - 2*face`: a column that is added to one is a pure number.
    Indicator,
    /// The line has its sensor's unit.
    Line,
    /// Two terms of a sum.
    Terms,
    /// The argument of a function.
    Argument,
    /// A stated unit.
    Stated,
    /// A term added to one is a pure number, unless an earlier equation determines it.
    One,
}

/// Names whose unit is not known.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Open {
    Coefficient,
    Column,
    Sensor,
}

/// A product of powers of open and of known units.
#[derive(Debug, Clone, Default)]
struct Row {
    open: BTreeMap<usize, f64>,
    known: BTreeMap<usize, f64>,
}

const SMALL: f64 = 1e-9;

impl Row {
    fn add(&mut self, other: &Row, power: f64) {
        other.open.iter().for_each(|(k, share)| add(&mut self.open, *k, share * power));
        other.known.iter().for_each(|(k, share)| add(&mut self.known, *k, share * power));
    }
}

fn add(powers: &mut BTreeMap<usize, f64>, k: usize, power: f64) {
    let sum = powers.entry(k).or_default();
    *sum += power;
    if sum.abs() < SMALL {
        powers.remove(&k);
    }
}

/// The equations so far, solved: open units in terms of the others.
#[derive(Debug, Clone, Default)]
struct System {
    names: Vec<(String, Open)>,
    index: HashMap<String, usize>,
    units: Vec<Unit>,
    solved: BTreeMap<usize, Row>,
}

impl System {
    fn open(&mut self, name: &str, kind: Open) -> usize {
        *self.index.entry(name.to_string()).or_insert_with(|| {
            self.names.push((name.to_string(), kind));
            self.names.len() - 1
        })
    }

    fn is(&self, k: usize, kind: Open) -> bool {
        self.names.get(k).is_some_and(|(_, other)| *other == kind)
    }

    fn known(&mut self, unit: Unit) -> usize {
        let same = |u: &Unit| u.is_same(&unit);
        self.units.iter().position(same).unwrap_or_else(|| {
            self.units.push(unit);
            self.units.len() - 1
        })
    }

    /// A product as powers of open and known units; `None` where a number with `pi` converts an angle in a way that is not recognised.
    fn row(&mut self, bench: &Bench, columns: &[String], powers: &Powers<'_>) -> Option<Row> {
        let mut row = Row::default();
        for (name, power) in &powers.names {
            match meaning(bench, columns, name) {
                Ok(unit) => add(&mut row.known, self.known(unit), *power),
                Err(kind) => add(&mut row.open, self.open(name, kind), *power),
            }
        }
        if powers.radian == 0.0 {
            return (!powers.pi).then_some(row);
        }
        // value * factor is in radians (an argument), or radians * factor is the value (out of an inverse function)
        let size = powers.factor.powf(-powers.radian);
        let angle = ["deg", "arcmin", "arcsec", "turn", "gon"].iter().filter_map(|name| Unit::parse(name).ok());
        let radian = Unit::parse("rad").ok()?;
        let mut converted =
            angle.filter(|unit| unit.conversion(&radian).is_some_and(|to| (to.factor() / size - 1.0).abs() < 1e-6));
        let unit = match converted.next().filter(|_| powers.radian.abs() == 1.0) {
            Some(unit) => unit,
            None if powers.pi => return None,
            None => radian,
        };
        add(&mut row.known, self.known(unit), powers.radian);
        Some(row)
    }

    /// Add the equation that a product is 1. Returns its unit where all in it is known already, and it is not 1.
    fn require(&mut self, row: Row, unless_sensor: bool) -> Option<Unit> {
        let mut reduced = Row { open: BTreeMap::new(), known: row.known };
        for (k, power) in row.open {
            match self.solved.get(&k) {
                Some(solution) => reduced.add(&solution.clone(), power),
                None => add(&mut reduced.open, k, power),
            }
        }
        if unless_sensor && reduced.open.keys().any(|k| self.is(*k, Open::Sensor)) {
            return None;
        }
        let Some((pivot, power)) = reduced.open.pop_first() else {
            return (!reduced.known.is_empty()).then(|| self.product(&reduced.known));
        };
        let mut solution = Row::default();
        solution.add(&reduced, -1.0 / power);
        for other in self.solved.values_mut() {
            if let Some(power) = other.open.remove(&pivot) {
                other.add(&solution, power);
            }
        }
        self.solved.insert(pivot, solution);
        None
    }

    fn product(&self, known: &BTreeMap<usize, f64>) -> Unit {
        let factors: Vec<(Unit, f64)> =
            known.iter().filter_map(|(k, power)| Some((self.units.get(*k)?.clone(), *power))).collect();
        Unit::product(&factors)
    }

    fn solution(&self) -> HashMap<String, Unit> {
        let closed = self.solved.iter().filter(|(_, row)| row.open.is_empty());
        closed
            .filter_map(|(k, row)| match self.names.get(*k)? {
                (name, Open::Coefficient) => Some((name.clone(), self.product(&row.known))),
                _ => None,
            })
            .collect()
    }
}

/// The unit of the name in a model line, or what it is that has none: an input along an axis, a joint or tilt (rad), a column of the readings, else a coefficient.
fn meaning(bench: &Bench, columns: &[String], name: &str) -> std::result::Result<Unit, Open> {
    let known = |text: &str| Unit::parse(text).map_err(|_| Open::Column);
    if super::is_axis_input(bench, name) {
        return known(if name.starts_with("w_") { bench.units.rate.name() } else { bench.units.force.name() });
    }
    if bench.chain.iter().any(|link| link.name() == name) {
        return known("rad");
    }
    if columns.iter().any(|column| column == name) || super::is_of_joint(bench, name) {
        return units::of_column(name).map_or(Err(Open::Column), |unit| known(&unit));
    }
    Err(Open::Coefficient)
}
