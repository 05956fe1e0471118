//! Which rows share deviations, and in which order fronts take the deviations out.
//!
//! Rows that share a deviation, directly or through others, are a block; blocks are independent. A small block is one front. In a large one
//! (positions within days, a chain in time) the rows come in the order of time, or of the line with the most levels, and a deviation leaves
//! the front as soon as no later row feels it: the front stays small, and the work linear in the rows.
#![allow(
    clippy::indexing_slicing,
    reason = "`before`, `time` and `line_of` one for each deviation, numbered by the lines' starts; felt rows beyond are left out at the beginning"
)]

use super::ScatterLine;
use crate::elements::Elements;

/// Blocks with no more deviations than this are one front.
const ONE_FRONT: usize = 40;

/// The order of the elimination; it depends on who feels what, not on how strongly.
#[derive(Debug, Clone)]
pub struct Pattern {
    /// Rows.
    pub(super) rows: usize,
    /// First deviation of each line.
    pub(super) first: Vec<usize>,
    /// Deviations of all lines.
    pub(super) deviations: usize,
    /// Deviations before each in its chain.
    pub(super) before: Vec<Option<usize>>,
    /// Fronts, block after block.
    pub(super) fronts: Vec<Front>,
    /// Is every block one front?
    pub(super) is_simple: bool,
}

/// One front: rows that are added, and deviations that leave.
#[derive(Debug, Clone)]
pub(super) struct Front {
    /// Does a block begin here?
    pub begins: bool,
    /// Deviations in the front, those that leave first.
    pub columns: Vec<usize>,
    /// How many leave.
    pub leaving: usize,
    /// Rows of readings that are added.
    pub rows: Vec<usize>,
    /// Deviations whose own rows are added.
    pub entering: Vec<usize>,
}

impl Pattern {
    /// The order for `rows` rows and these lines.
    pub fn new(rows: usize, lines: &[ScatterLine]) -> Self {
        let mut first = Vec::with_capacity(lines.len());
        let mut deviations = 0;
        for line in lines {
            first.push(deviations);
            deviations += line.levels();
        }
        let mut before = vec![None; deviations];
        let mut time = vec![None; deviations];
        let mut line_of = vec![0; deviations];
        for (k, (line, start)) in lines.iter().zip(&first).enumerate() {
            line_of[*start..start + line.levels()].fill(k);
            let Some(memory) = &line.memory else { continue };
            let order = memory.order(line.levels());
            for level in &order {
                time[start + level] = Some(memory.time.at(*level));
            }
            for pair in order.windows(2) {
                if memory.run_of(pair[0]) == memory.run_of(pair[1]) {
                    before[start + pair[1]] = Some(start + pair[0]);
                }
            }
        }
        let felt = lines.iter().zip(&first).flat_map(|(line, start)| {
            let start = *start;
            line.felt.iter().map(move |felt| (felt.row, start + felt.level))
        });
        let own = ByRow::new(rows, felt);
        let mut pattern = Pattern { rows, first, deviations, before, fronts: Vec::new(), is_simple: true };
        for (rows, deviations) in blocks(&own, &pattern.before) {
            if deviations.len() <= ONE_FRONT {
                pattern.fronts.push(Front {
                    begins: true,
                    leaving: deviations.len(),
                    columns: deviations.clone(),
                    rows,
                    entering: deviations,
                });
            } else {
                pattern.is_simple = false;
                pattern.large(rows, &deviations, &own, &time, &line_of);
            }
        }
        pattern
    }

    /// Fronts of a large block: in the order of time, or of the line with the most levels.
    fn large(
        &mut self,
        rows: Vec<usize>,
        deviations: &[usize],
        own: &ByRow<usize>,
        time: &[Option<f64>],
        line_of: &[usize],
    ) {
        let timed = deviations.iter().any(|d| time[*d].is_some());
        let mut count: Vec<usize> = vec![0; self.first.len()];
        deviations.iter().for_each(|d| count[line_of[*d]] += 1);
        // there is a line: deviations belong to it
        let leading = (0..count.len()).max_by_key(|k| count[*k]).unwrap_or(0);
        let key = |row: &usize| -> f64 {
            let of = |d: &usize| if timed { time[*d] } else { (line_of[*d] == leading).then_some(*d as f64) };
            // a row that feels none of these stands last
            own.of(*row).iter().find_map(of).unwrap_or(f64::INFINITY)
        };
        let mut sorted: Vec<(f64, usize)> = rows.iter().map(|row| (key(row), *row)).collect();
        sorted.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let steps: Vec<&[(f64, usize)]> = sorted.chunk_by(|a, b| a.0 == b.0).collect();
        // when each deviation is felt first and last; a chain's deviation stays until the next one has come
        let mut span: std::collections::HashMap<usize, (usize, usize)> = std::collections::HashMap::new();
        for (s, step) in steps.iter().enumerate() {
            for d in step.iter().flat_map(|(_, row)| own.of(*row)) {
                let entry = span.entry(*d).or_insert((s, s));
                entry.1 = s;
            }
        }
        for d in deviations {
            let Some(from) = self.before[*d] else { continue };
            let (here, there) = (span.get(d).copied(), span.get(&from).copied());
            if let (Some((mine, _)), Some((its, last))) = (here, there) {
                // the row of the chain needs both
                span.insert(from, (its.min(mine), last.max(mine)));
            }
        }
        let mut coming: Vec<Vec<usize>> = vec![Vec::new(); steps.len()];
        for d in deviations {
            coming[span.get(d).map_or(0, |(s, _)| *s)].push(*d);
        }
        let last = |d: usize| span.get(&d).map_or(0, |(_, last)| *last);
        let mut active: Vec<usize> = Vec::new();
        for (s, step) in steps.iter().enumerate() {
            let entering = std::mem::take(&mut coming[s]);
            active.extend(&entering);
            let (leaving, staying): (Vec<usize>, Vec<usize>) = active.iter().partition(|d| last(**d) <= s);
            let columns = leaving.iter().chain(&staying).copied().collect();
            let rows = step.iter().map(|(_, row)| *row).collect();
            self.fronts.push(Front { begins: s == 0, columns, leaving: leaving.len(), rows, entering });
            active = staying;
        }
    }
}

/// Blocks of rows and deviations that are linked; rows without a deviation are in none.
fn blocks(own: &ByRow<usize>, before: &[Option<usize>]) -> Vec<(Vec<usize>, Vec<usize>)> {
    let mut label: Vec<usize> = (0..before.len()).collect();
    fn root(label: &mut [usize], mut i: usize) -> usize {
        while label[i] != i {
            label[i] = label[label[i]];
            i = label[i];
        }
        i
    }
    let links = own.rows().flat_map(|list| list.windows(2).map(|pair| (pair[0], pair[1])));
    let chains = before.iter().enumerate().filter_map(|(d, from)| Some((d, (*from)?)));
    for (a, b) in links.chain(chains) {
        let (a, b) = (root(&mut label, a), root(&mut label, b));
        label[a.max(b)] = a.min(b);
    }
    let mut number = vec![usize::MAX; before.len()];
    let mut blocks: Vec<(Vec<usize>, Vec<usize>)> = Vec::new();
    for d in 0..before.len() {
        let root = root(&mut label, d);
        if number[root] == usize::MAX {
            number[root] = blocks.len();
            blocks.push((Vec::new(), Vec::new()));
        }
        blocks[number[root]].1.push(d);
    }
    for (row, list) in own.rows().enumerate() {
        if let Some(d) = list.first() {
            let root = root(&mut label, *d);
            blocks[number[root]].0.push(row);
        }
    }
    blocks
}

/// What belongs to each row of a system, in two lists for all rows: a list for each row would cost more than what is in it.
#[derive(Debug, Clone)]
pub(super) struct ByRow<T> {
    /// Where the items of each row begin; one more than there are rows.
    start: Vec<usize>,
    items: Vec<T>,
}

impl<T: Copy> ByRow<T> {
    /// Pairs of a row and an item, in the order in which each row gets its items; pairs of rows beyond `rows` are left out.
    pub fn new(rows: usize, pairs: impl Iterator<Item = (usize, T)>) -> Self {
        let mut pairs: Vec<(usize, T)> = pairs.filter(|(row, _)| *row < rows).collect();
        pairs.sort_by_key(|(row, _)| *row);
        let mut start = vec![0_usize; rows + 1];
        for (k, (row, _)) in pairs.iter().enumerate() {
            start[row + 1] = k + 1;
        }
        // a row without items ends where the one before it does
        (0..rows).for_each(|row| start[row + 1] = start[row + 1].max(start[row]));
        ByRow { start, items: pairs.into_iter().map(|(_, item)| item).collect() }
    }

    /// The items of a row; none for a row that there is not.
    pub fn of(&self, row: usize) -> &[T] {
        let end = row.checked_add(1).and_then(|next| self.start.get(next));
        let range = self.start.get(row).zip(end).map(|(from, to)| *from..*to);
        range.and_then(|range| self.items.get(range)).unwrap_or_default()
    }

    /// The items of all rows, one row after the other.
    pub fn rows(&self) -> impl Iterator<Item = &[T]> {
        self.start.windows(2).map(|pair| match pair {
            [from, to] => self.items.get(*from..*to).unwrap_or_default(),
            _ => &[],
        })
    }
}
