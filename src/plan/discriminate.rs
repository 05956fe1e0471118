//! Positions that discriminate between effects.
//!
//! If the truth has the term `a` with coefficient 1, the model with `b` in its place lacks
//!
//! ```text
//! T = min over x, beta of |a - A x - beta b|^2 / u^2 = 1 / [M^-1]_aa,   M the information of (A, a, b)
//! ```
//!
//! (A. C. Atkinson, V. V. Fedorov, Biometrika 62 (1975) 57: T-optimality; for linear rivals it is the c-criterion of the rival's coefficient.)
//! Which of two is true nobody knows, so both take part, each in units of what all candidates could reach. For a campaign that has been measured,
//! single further positions: with several rivals, the best position maximises the smallest `T` over them (Biometrika 62 (1975) 289).
#![allow(
    clippy::indexing_slicing,
    reason = "whitened rows have the unknowns and one column for each term; lists over rivals have one entry for each term but the first"
)]

use super::blocks::{invert, times};
use super::candidates::{Unit, portions};
use super::effort::{Offer, planned};
use super::improve::{Improvement, SearchRecord};
use super::judge::check_question;
use super::objective::{Combinations, Objective};
use super::order::ordered;
use super::pool::in_coordinates;
use super::problem::{counted, information};
use super::question::Question;
use super::request::Request;
use super::search::{Limits, Outcome};
use super::whitened::{Augmentation, Term, adjusted, mounted_apart, single, whitened, with_priors};
use crate::algebra::{Scratch, Tape};
use crate::campaign::{Campaign, Reading, Readings};
use crate::error::{Fault, Malformed, Result};
use crate::linear::{Triangle, dot, normalise};
use crate::simulate::{Regressor, largest_inputs};

/// Positions that discriminate between two terms.
#[derive(Debug, Clone)]
pub struct Discrimination {
    /// Positions to add; empty where no candidate discriminates between them.
    pub positions: Vec<Reading>,
    /// Standard uncertainties of the two coefficients with both in the model line, before; `None` where they are confounded.
    pub before: [Option<f64>; 2],
    /// The same with the added positions.
    pub after: [Option<f64>; 2],
    /// Starts of the exchange that ended here.
    pub hits: usize,
}

/// The positions, `readings` or as many more as it takes, whose addition to those kept discriminates best between the two terms.
///
/// Kept readings count with the values that were read there. Errors: a term that uses what is no input here, no candidates. That nothing
/// separates them is a result.
pub fn discriminate(
    campaign: &Campaign,
    offer: &Offer,
    terms: [&Term; 2],
    readings: usize,
    starts: usize,
    seed: u64,
) -> Result<Discrimination> {
    let request = Request { readings, starts, seed, ..Request::default() };
    let question = Question::new(campaign, offer, &request, &terms.map(Clone::clone))?;
    let pool = &question.pool;
    let n = pool.augmentation.fitted(campaign);
    let coordinates = [n, n + 1].map(|k| pool.coordinates(&single(n + 2, k, 1.0)));
    let nothing = Discrimination { positions: Vec::new(), before: [None; 2], after: [None; 2], hits: 0 };
    let [Some(a), Some(b)] = &coordinates else { return Ok(nothing) };
    let u = |m: &[f64], c: &[f64]| {
        let (inverse, _) = invert(m, pool.blocks.unknowns())?;
        Some(dot(c, &times(&inverse, c)).sqrt())
    };
    let mut shares = vec![a.clone(), b.clone()];
    for row in &mut shares {
        normalise(row);
    }
    let objective = Objective::Trace(Combinations::new(shares).sum());
    // singular with too few: one more until regular
    let most = readings.max(1) + pool.blocks.unknowns();
    let limits = Limits::of(&request, &Vec::new);
    let outcome = (readings.max(1)..=most).find_map(|choose| question.seek(&objective, choose, None, &limits));
    let Some(Outcome { design, hits, .. }) = outcome else { return Ok(nothing) };
    let after = information(&pool.blocks, &pool.base, &counted(&design.chosen));
    Ok(Discrimination {
        positions: question.rows(&design.chosen).into_iter().skip(offer.kept.rows.len()).collect(),
        before: [u(&pool.base, a), u(&pool.base, b)],
        after: [u(&after, a), u(&after, b)],
        hits,
    })
}

/// A schedule that discriminates between two effects.
#[derive(Debug, Clone)]
pub struct Separated {
    /// The kept readings, then the added ones; and the predicted uncertainties of the estimated parameters.
    pub improvement: Improvement,
    /// Standard uncertainties of the two coefficients before; `None` where they are confounded.
    pub before: [Option<f64>; 2],
    /// The same with the added positions.
    pub after: [Option<f64>; 2],
}

/// The schedule that is kept, with `request.readings` more positions (or as many as it takes) that discriminate between two effects; its criterion plays
/// no part. That nothing separates them is a result: nothing is added. Errors: those of [`discriminate`]; the same term twice; a term that is
/// zero at every reading and candidate.
pub fn separate(campaign: &Campaign, offer: &Offer, terms: [&Term; 2], request: &Request) -> Result<Separated> {
    check_terms(campaign, offer, terms)?;
    let discrimination = discriminate(campaign, offer, terms, request.readings, request.starts, request.seed)?;
    let kept = planned(campaign, &offer.kept);
    let stays = kept.rows.len();
    let mut rows = kept.rows;
    rows.extend(discrimination.positions);
    let all = campaign.with_readings(planned(campaign, &Readings { columns: kept.columns, rows }));
    let schedule =
        campaign.with_readings(ordered(&all, &offer.noise, &offer.costs, request.order, request.seed, stays)?);
    let (hits, starts) = (discrimination.hits, request.starts.max(1));
    Ok(Separated {
        before: discrimination.before,
        after: discrimination.after,
        improvement: Improvement {
            search: SearchRecord { hits, starts, ..SearchRecord::default() },
            ..Improvement::of(schedule, offer, offer.candidates.rows.len(), stays)?
        },
    })
}

/// A term smaller than this share of its size for typical inputs is zero but for rounding.
const ROUNDING: f64 = 1e-10;

/// Two different terms, neither of which is zero (but for rounding) wherever it could be seen.
fn check_terms(campaign: &Campaign, offer: &Offer, terms: [&Term; 2]) -> Result<()> {
    let names = terms.map(|term| name(campaign, &term.regressor));
    if names[0] == names[1] && terms[0].sensor == terms[1].sensor {
        return Err(Malformed::new(Fault::Value, "the two effects to be discriminated are the same")
            .expected("two different effects")
            .found(format!("'{}' twice", names[0])));
    }
    let n = campaign.unknowns();
    // columns of the effects alone, without shared deviations
    let augmentation = Augmentation { terms: terms.map(Clone::clone).to_vec(), ..Augmentation::default() };
    let mut rows = whitened(campaign, &offer.kept, &offer.noise, &augmentation, false)?;
    rows.extend(whitened(campaign, &offer.candidates, &offer.noise, &augmentation, true)?);
    let sd = offer.noise.sensors.iter().map(|s| s.sd).fold(0.0, f64::max);
    for (t, (term, name)) in terms.iter().zip(&names).enumerate() {
        let largest = rows.iter().filter_map(|row| row.get(n + t)).fold(0.0_f64, |most, v| most.max(v.abs()));
        let natural = natural_size(campaign, &term.regressor);
        if largest == 0.0 || largest * sd < ROUNDING * natural {
            return Err(Malformed::new(Fault::Value, format!("{name} is zero at every candidate and reading"))
                .expected("two effects that some position shows")
                .found(format!("'{name}'")));
        }
    }
    Ok(())
}

/// Size of a term for typical inputs: gravity along an axis, the fastest rate, any angle; zero for other regressors.
fn natural_size(campaign: &Campaign, regressor: &Regressor) -> f64 {
    let Regressor::Term(line) = regressor else { return 0.0 };
    let size = largest_inputs(campaign);
    let names = line.names();
    let inputs: Vec<f64> = names.iter().map(|name| size(name)).collect();
    let natural = Tape::compile(line, &names).map(|tape| tape.value(&inputs, &mut Scratch::default()).abs());
    // a term without a value at these inputs has no natural size
    natural.ok().filter(|size| size.is_finite()).unwrap_or_default()
}

/// A regressor in words; the same for terms that differ in the order of their factors only.
fn name(campaign: &Campaign, regressor: &Regressor) -> String {
    match regressor {
        Regressor::Term(line) => line.canonical(),
        Regressor::Tilt(k) | Regressor::Known(k) => campaign.parameter_id(*k).to_string(),
        // of single readings, mountings and columns, in the program's words
        other => format!("{other:?}"),
    }
}

/// A position that discriminates between an effect and its rivals.
#[derive(Debug, Clone)]
pub struct DiscriminatingPosition {
    /// The position.
    pub position: Reading,
    /// What it adds to `T`, as a share of the most that any candidate adds: the smallest over the rivals.
    pub least: f64,
    /// The mean of these shares over all rivals.
    pub mean: f64,
    /// The rivals that it clearly discriminates, by index: it adds at least a tenth of the mean information of a reading on the effect.
    pub told: Vec<usize>,
}

/// A rival is not separable where no candidate adds this share of the information on the effect to `T`.
const TELLS: f64 = 1e-4;
/// A position clearly discriminates a rival if it adds this share of the mean information of a kept reading on the effect.
const PLAINLY: f64 = 0.1;
/// Weight of a loose prior on parameters where the kept readings do not determine all of them, as a share of their columns.
const LOOSE: f64 = 1e-3;

/// Every candidate position that discriminates between `effect` and at least one of `rivals` when it is added to those kept, the best first.
///
/// Adding rows `F` updates the products of the residual columns, `P_ab + e_a' (I + F (A'A)^-1 F')^-1 e_b` with `e = f - F x`, and
/// `T = P_aa - P_ab^2 / P_bb`. Errors: those of [`discriminate`].
pub fn discriminating_positions(
    campaign: &Campaign,
    offer: &Offer,
    effect: &Term,
    rivals: &[Term],
) -> Result<Vec<DiscriminatingPosition>> {
    let Offer { kept, candidates, noise, .. } = offer;
    check_question(campaign)?;
    let terms: Vec<Term> = [effect].into_iter().chain(rivals).cloned().collect();
    let portions = portions(campaign, candidates, Unit::Reading)?;
    let apart = mounted_apart(&portions, candidates);
    let augmentation = Augmentation::new(campaign, noise, &terms, &[kept, &apart]);
    let n = augmentation.fitted(campaign);
    let mut rows = with_priors(campaign, kept, noise, &augmentation)?;
    let mut estimate = adjusted(campaign, &rows, n)?;
    if estimate.unknowns.rank < n {
        for k in 0..n {
            let size = rows.iter().map(|row| row[k] * row[k]).sum::<f64>().sqrt();
            let weight = if size > 0.0 { LOOSE * size } else { LOOSE };
            rows.push(single(n + terms.len(), k, weight));
        }
        estimate = adjusted(campaign, &rows, n)?;
    }
    let column = |t: usize| rows.iter().map(|row| row[n + t]).collect::<Vec<f64>>();
    let fitted: Vec<Vec<f64>> = (0..terms.len()).map(|t| estimate.factor.solve(&column(t))).collect::<Result<_>>()?;
    let residual: Vec<Vec<f64>> =
        (0..terms.len()).map(|t| estimate.factor.project_out(&column(t))).collect::<Result<_>>()?;
    let further = whitened(campaign, &apart, noise, &augmentation, true)?;
    let size = (further.len() / portions.len().max(1)).max(1);
    let information = residual.first().map_or(0.0, |residual| dot(residual, residual));
    let before: Vec<[f64; 3]> = residual.iter().skip(1).map(|b| products(&residual[0], b)).collect();
    let directions = estimate.factor.whitened_directions();
    // what each candidate adds to T against each rival
    let gains: Vec<Vec<f64>> = further
        .chunks(size)
        .map(|rows| {
            let mut errors: Vec<Vec<f64>> = fitted
                .iter()
                .enumerate()
                .map(|(t, x)| rows.iter().map(|row| row[n + t] - dot(&row[..n], x)).collect())
                .collect();
            let along: Vec<Vec<f64>> = rows.iter().map(|row| in_coordinates(&directions, &row[..n])).collect();
            let s = |i: usize, j: usize| f64::from(u8::from(i == j)) + dot(&along[i], &along[j]);
            let Some(root) = Triangle::of(rows.len(), s, |_| 0.0) else { return vec![0.0; before.len()] };
            errors.iter_mut().for_each(|e| root.forward(e));
            let more = errors.iter().skip(1).map(|b| products(&errors[0], b));
            before.iter().zip(more).map(|(now, more)| t_of([0, 1, 2].map(|k| now[k] + more[k])) - t_of(*now)).collect()
        })
        .collect();
    let most: Vec<f64> = (0..before.len()).map(|b| gains.iter().map(|g| g[b]).fold(0.0, f64::max)).collect();
    let separable: Vec<usize> = (0..before.len()).filter(|b| most[*b] > TELLS * information).collect();
    let mut list: Vec<DiscriminatingPosition> = portions
        .iter()
        .zip(&gains)
        .filter_map(|(portion, gain)| {
            let shares = separable.iter().map(|b| gain[*b].max(0.0) / most[*b]);
            let mean = shares.clone().sum::<f64>() / separable.len().max(1) as f64;
            let least = shares.reduce(f64::min)?;
            let plain = PLAINLY * information / kept.rows.len().max(1) as f64;
            let told = separable.iter().copied().filter(|b| gain[*b] > plain).collect();
            Some(DiscriminatingPosition { position: portion.first()?.clone(), least, mean, told })
        })
        .filter(|position| position.mean > TELLS)
        .collect();
    // shares that differ by rounding must not order positions
    let rounded = |v: f64| (v * 1e3).round();
    list.sort_by(|a, b| {
        rounded(b.least).total_cmp(&rounded(a.least)).then(rounded(b.mean).total_cmp(&rounded(a.mean)))
    });
    Ok(list)
}

/// `a'a`, `a'b`, `b'b`.
fn products(a: &[f64], b: &[f64]) -> [f64; 3] {
    [dot(a, a), dot(a, b), dot(b, b)]
}

/// `T` from products of residual columns; a rival that the model absorbs does not reduce it.
fn t_of([aa, ab, bb]: [f64; 3]) -> f64 {
    if bb > 1e-20 * aa { (aa - ab * ab / bb).max(0.0) } else { aa }
}
