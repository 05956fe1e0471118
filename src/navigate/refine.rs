//! A set of causes refined on the full simulation, from near by or from far away.

use super::case::{Case, Flown};
use super::cause::Cause;
use super::errors::ImuErrors;
use super::products::{Products, Solved};
use super::weighed::Weighed;
use super::whiten::{Instant, Walks};
use crate::diagnosis::{Gap, NoiseFrom, Step};
use crate::linear::dot;
use std::cell::{OnceCell, RefCell};
use std::rc::Rc;

/// Gauss-Newton steps of one refinement, at most.
const STEPS: usize = 25;
/// A refinement has settled when no cause moves by more than this share of its standard uncertainty.
const SETTLED: f64 = 0.02;
/// or where the linear model predicts a reduction of the sum of squares by no more than this share.
const FLAT: f64 = 1e-6;
/// Damping of a Gauss-Newton step (Levenberg and Marquardt), shares of each column's square: the least and the most.
const LEAST_DAMPED: f64 = 1e-6;
const MOST_DAMPED: f64 = 1e4;
/// and that of the first step which does not lead down.
const FIRST_DAMPED: f64 = 1e-3;

/// A set of causes, refined.
#[derive(Clone)]
pub(super) struct State {
    pub set: Vec<Cause>,
    pub values: Vec<f64>,
    pub u: Vec<f64>,
    pub flown: Flown,
    /// Single values that are left out.
    pub out: Vec<usize>,
    pub rss: f64,
    pub settled: bool,
    /// ln p of its set, and is no set more probable? Before it is judged, minus infinity and no.
    pub value: f64,
    pub is_best: bool,
    /// Of the last state of a search: the probability of each cause, and is it likelier than not that more than noise remains?
    pub each: Vec<f64>,
    pub outside: bool,
    /// Likewise further causes that are suspected, each with its probability.
    pub suspected: Vec<(Cause, f64)>,
}

impl State {
    /// The values that some causes have here: zero of those that are not in the set.
    pub fn values_of(&self, causes: &[Cause]) -> Vec<f64> {
        let one =
            |cause: &Cause| self.set.iter().zip(&self.values).find(|(own, _)| *own == cause).map_or(0.0, |(_, x)| *x);
        causes.iter().map(one).collect()
    }
}

/// A random walk that the mission does not state (`unstated_walk.rs` looks for them).
#[derive(Debug, Clone)]
pub(super) struct UnstatedWalk {
    pub cause: Cause,
    /// Its density, SI.
    pub density: f64,
    pub u: f64,
    /// By how much `-2 ln L` is less than without it, the densities of the others fitted anew.
    pub gain: f64,
    /// Other walks in its place, with their density and by how much `-2 ln L` is larger.
    pub others: Vec<(Cause, f64, f64)>,
}

/// The errors with those among these walks that a mission can state: white noise of the gyros or the accelerometers.
pub(super) fn stated(errors: &ImuErrors, walks: &[UnstatedWalk]) -> ImuErrors {
    walks.iter().fold(*errors, |errors, walk| match walk.cause {
        Cause::RandomWalk(instrument) => errors.walking(instrument, walk.density),
        _ => errors,
    })
}

/// A search through sets of causes.
pub(super) struct Search<'a> {
    pub case: Case<'a>,
    pub u: &'a [f64],
    /// Penalty of each cause, and how many are distinct.
    pub penalty: f64,
    pub distinct: usize,
    /// Its record.
    pub steps: Vec<Step>,
    pub flights: usize,
    /// How often the columns were made anew around a state.
    pub moved: usize,
    /// All ordinary causes together, refined.
    pub ordinary: Option<State>,
    /// Random walks that the mission does not state and that have been added to those that it states.
    pub unstated: Vec<UnstatedWalk>,
    /// What the mission states.
    pub stated: Walks,
    /// What white noise of the gyros and of the accelerometers builds up, for a density of one.
    pub units: OnceCell<[Vec<Vec<Instant>>; 2]>,
    /// The part of the whole that is being done: its start and its end, shares.
    pub part: (f64, f64),
    /// The question in fewer rows.
    pub weighed: RefCell<Option<Rc<Weighed>>>,
    pub progress: &'a mut Progress<'a>,
}

/// Reports of a long search: the approximate share that is done, and what is being tried.
pub(super) type Progress<'a> = dyn FnMut(f64, &str) + 'a;

impl<'a> Search<'a> {
    pub fn new(
        case: Case<'a>,
        u: &'a [f64],
        (penalty, distinct): (f64, usize),
        progress: &'a mut Progress<'a>,
    ) -> Search<'a> {
        Search {
            stated: case.columns.walks.clone(),
            case,
            u,
            penalty,
            distinct,
            steps: Vec::new(),
            flights: 0,
            moved: 0,
            ordinary: None,
            unstated: Vec::new(),
            units: OnceCell::new(),
            part: (0.0, 1.0),
            weighed: RefCell::new(None),
            progress,
        }
    }

    /// Report that a set is being tried, in the given round of the present part.
    pub fn report(&mut self, round: usize, set: &[Cause]) {
        let names: Vec<String> = set.iter().map(Cause::id).collect();
        // the number of rounds is not known: each takes a share of what remains
        let (start, end) = self.part;
        let share = end - (end - start) * 0.7_f64.powf(round as f64);
        (self.progress)(share, &names.join(" + "));
    }

    /// The present question in fewer rows.
    pub fn weighed(&self, out: &[usize]) -> Rc<Weighed> {
        if let Some(weighed) = self.weighed.borrow().as_ref().filter(|weighed| weighed.is_of(&self.case, out)) {
            return weighed.clone();
        }
        let weighed = Rc::new(Weighed::new(&self.case, self.u, out));
        *self.weighed.borrow_mut() = Some(weighed.clone());
        weighed
    }

    /// Gauss-Newton on the full simulation, damped where a step does not lead down; `None` where the set is not independent or cannot be flown.
    pub fn refine(&mut self, set: &[Cause], start: &[f64], out: &[usize]) -> Option<State> {
        self.descend(set, start, out, 0.0)
    }

    /// The same; where the set is not independent, with the least damping that makes it so: a start, whose idle members are still to go.
    pub fn refine_or_damp(&mut self, set: &[Cause], start: &[f64], out: &[usize]) -> Option<State> {
        self.refine(set, start, out).or_else(|| self.descend(set, start, out, LEAST_DAMPED))
    }

    /// The same; `least` is the least damping, without which columns that hardly differ go anywhere.
    fn descend(&mut self, set: &[Cause], start: &[f64], out: &[usize], least: f64) -> Option<State> {
        let mut values = start.to_vec();
        let mut flown = self.case.fly(set, &values, self.u)?;
        self.flights += 1;
        let mut settled = false;
        let mut u = vec![f64::INFINITY; set.len()];
        let mut rss = self.rss(&flown, out);
        let mut damping = least;
        for _ in 0..STEPS {
            let mut columns = flown.jacobian.clone();
            columns.push(self.case.residual(&flown.predicted));
            self.case.weigh(self.u, out, &mut columns);
            let residual = columns.pop()?;
            let (products, norms) = Products::normalised(columns, &residual);
            let all: Vec<usize> = (0..set.len()).collect();
            let of = |solved: &Solved| -> Vec<f64> {
                solved.values.iter().zip(&norms).map(|(x, norm)| if *norm > 0.0 { x / norm } else { 0.0 }).collect()
            };
            let solved = products.damped(&all, least)?;
            u = solved
                .inverse
                .iter()
                .zip(&norms)
                .enumerate()
                .map(|(k, (row, norm))| row.get(k).map_or(f64::NAN, |v| v.max(0.0).sqrt() / norm))
                .collect();
            // noise that is estimated from the residuals has their size, not one
            let size = if self.case.from == NoiseFrom::Residuals {
                (rss / residual.len().max(1) as f64).sqrt().max(1e-3)
            } else {
                1.0
            };
            settled = of(&solved).iter().zip(&u).all(|(dx, u)| dx.abs() <= SETTLED * u * size);
            if settled {
                break;
            }
            let next = loop {
                let step = products.damped(&all, damping).map(|solved| of(&solved))?;
                let trial: Vec<f64> = values.iter().zip(&step).map(|(x, dx)| x + dx).collect();
                self.flights += 1;
                let better = self.case.fly(set, &trial, self.u).map(|flown| (self.rss(&flown, out), flown));
                match better {
                    Some((after, flown)) if after <= rss * (1.0 + 1e-9) => break Some((trial, after, flown)),
                    _ if damping > MOST_DAMPED => break None,
                    _ => damping = (10.0 * damping).max(FIRST_DAMPED),
                }
            };
            let Some((trial, after, next)) = next else {
                // no way down: the end, where the linear model sees none either
                settled = solved.rss >= rss * (1.0 - FLAT);
                break;
            };
            (values, rss, flown) = (trial, after, next);
            damping = if damping > LEAST_DAMPED { (0.1 * damping).max(least) } else { least };
        }
        Some(State {
            set: set.to_vec(),
            values,
            u,
            flown,
            out: out.to_vec(),
            rss,
            settled,
            value: f64::NEG_INFINITY,
            is_best: false,
            each: Vec::new(),
            outside: false,
            suspected: Vec::new(),
        })
    }

    /// Values of a set where a gap is far from linear: those of the first rows, where errors have not grown yet, then of twice as many, and
    /// so on; half of the rows are the last.
    pub fn approach(&mut self, set: &[Cause], out: &[usize]) -> Vec<f64> {
        let mut values = vec![0.0; set.len()];
        let cells: Vec<f64> = self.case.measured.cells().map(|cell| cell.time).collect();
        let last = self.case.measured.last_time();
        for part in [16.0, 8.0, 4.0, 2.0] {
            let kept: Vec<bool> = cells.iter().map(|time| *time <= last / part).collect();
            let mut early = self.case.measured.clone();
            early.runs.iter_mut().for_each(|run| run.rows.retain(|row| row.time <= last / part));
            if early.count() < 4 * set.len() {
                continue;
            }
            let case = self.case.until(&early, &kept);
            let u: Vec<f64> = self.u.iter().zip(&kept).filter(|(_, kept)| **kept).map(|(u, _)| *u).collect();
            let place = |at: &usize| kept.iter().take(*at).filter(|kept| **kept).count();
            let out: Vec<usize> = out.iter().filter(|at| kept.get(**at) == Some(&true)).map(place).collect();
            let mut nobody = |_: f64, _: &str| {};
            let mut search = Search::new(case, &u, (self.penalty, self.distinct), &mut nobody);
            if let Some(state) = search.descend(set, &values, &out, LEAST_DAMPED) {
                values = state.values;
            }
            self.flights += search.flights;
        }
        values
    }

    /// A state refined with these single values left out.
    pub fn leaving_out(&mut self, state: State, out: &[usize]) -> Option<State> {
        if state.out == out { Some(state) } else { self.refine(&state.set, &state.values, out) }
    }

    /// What a state leaves of the gap.
    pub fn gap_of(&self, state: &State) -> Gap {
        self.case.gap(&self.case.residual(&state.flown.predicted), self.u, &state.out, state.set.len())
    }

    fn rss(&self, flown: &Flown, out: &[usize]) -> f64 {
        let white = self.case.whitened(self.case.residual(&flown.predicted), self.u, out);
        dot(&white, &white)
    }
}
