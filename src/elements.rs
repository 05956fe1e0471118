//! Elements of lists whose lengths a constructor has established, so that the index cannot lie outside: one policy for all of them.
//!
//! A build with debug assertions (fuzzing, `cargo test` without `--release`) stops where an index is outside after all. A release build goes on with
//! what no reader takes for a result: not-a-number, an empty part, a place that no list has. A plausible number (0, 1) never stands in for one that is
//! missing. Where an element may honestly be absent, the code says `get` and what absence means.

use std::collections::HashMap;
use std::hash::Hash;
use std::slice::SliceIndex;

/// Of each key its number, counted from 0 in the order in which they first occur; and how many there are.
pub(crate) fn numbered<K: Hash + Eq>(keys: impl IntoIterator<Item = K>) -> (Vec<usize>, usize) {
    let mut seen: HashMap<K, usize> = HashMap::new();
    let number = |key: K| {
        let next = seen.len();
        *seen.entry(key).or_insert(next)
    };
    let numbers = keys.into_iter().map(number).collect();
    (numbers, seen.len())
}

/// Elements by an index that the list's constructor has established.
pub(crate) trait Elements {
    /// What an element is read as.
    type Element<'a>
    where
        Self: 'a;

    /// Element `k`; outside, NaN (numbers), an empty list (lists of numbers), `usize::MAX` (places).
    fn at(&self, k: usize) -> Self::Element<'_>;
}

/// What stands for an element that a list has not.
pub(crate) trait Absent: Copy {
    const ABSENT: Self;
}

impl Absent for f64 {
    const ABSENT: f64 = f64::NAN;
}

impl Absent for usize {
    const ABSENT: usize = usize::MAX;
}

impl<const N: usize> Absent for [f64; N] {
    const ABSENT: [f64; N] = [f64::NAN; N];
}

impl Absent for &'static str {
    const ABSENT: &'static str = "?";
}

impl<T: Absent> Elements for [T] {
    type Element<'a>
        = T
    where
        Self: 'a;

    #[inline]
    #[track_caller]
    fn at(&self, k: usize) -> T {
        debug_assert!(k < self.len(), "element {k} of {}", self.len());
        self.get(k).copied().unwrap_or(T::ABSENT)
    }
}

/// Numbers whose count the caller of a public function chose.
pub(crate) trait OrNan {
    /// Number `k`, NaN where there is none.
    fn or_nan(&self, k: usize) -> f64;
}

impl OrNan for [f64] {
    #[inline]
    fn or_nan(&self, k: usize) -> f64 {
        self.get(k).copied().unwrap_or(f64::NAN)
    }
}

impl<T> Elements for [Vec<T>] {
    type Element<'a>
        = &'a [T]
    where
        T: 'a;

    #[inline]
    #[track_caller]
    fn at(&self, k: usize) -> &[T] {
        debug_assert!(k < self.len(), "list {k} of {}", self.len());
        self.get(k).map(Vec::as_slice).unwrap_or_default()
    }
}

/// Parts of a list or a text by a range that lies within it, of a text from one character's edge to another's.
pub(crate) trait Parts {
    /// What is in `range`; nothing if that is not within it.
    fn part<R: SliceIndex<Self, Output = Self>>(&self, range: R) -> &Self;
}

impl<T> Parts for [T] {
    #[inline]
    #[track_caller]
    fn part<R: SliceIndex<Self, Output = Self>>(&self, range: R) -> &Self {
        let part = self.get(range);
        debug_assert!(part.is_some(), "a range beyond {} elements", self.len());
        part.unwrap_or_default()
    }
}

impl Parts for str {
    #[inline]
    #[track_caller]
    fn part<R: SliceIndex<Self, Output = Self>>(&self, range: R) -> &Self {
        let part = self.get(range);
        debug_assert!(part.is_some(), "a range beyond a text of {} bytes, or within a character", self.len());
        part.unwrap_or_default()
    }
}

/// How many numbers are looked at together where what is rare is looked for.
pub(crate) const TOGETHER: usize = 64;

/// The place of the first number that is odd. What is rare is looked for in many numbers at a time, without a decision for each.
pub(crate) fn first_odd(values: &[f64], is_odd: impl Fn(f64) -> bool) -> Option<usize> {
    let mut before = 0;
    for part in values.chunks(TOGETHER) {
        if part.iter().fold(false, |any, v| any | is_odd(*v)) {
            return part.iter().position(|v| is_odd(*v)).map(|k| before + k);
        }
        before += part.len();
    }
    None
}
