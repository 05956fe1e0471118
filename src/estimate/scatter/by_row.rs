//! What belongs to each row of a system, in two lists for all rows: a list for each row would cost more than what is in it.

/// Items row after row.
#[derive(Debug, Clone)]
pub(super) struct ByRow<T> {
    /// Where the items of each row begin; one more than there are rows.
    start: Vec<usize>,
    items: Vec<T>,
}

impl<T: Copy> ByRow<T> {
    /// Pairs of a row and an item, in the order in which each row gets its items; pairs of rows beyond `rows` are left out.
    pub fn new(rows: usize, pairs: impl Iterator<Item = (usize, T)> + Clone) -> Self {
        let mut start = vec![0_usize; rows + 1];
        for (row, _) in pairs.clone() {
            if let Some(count) = start.get_mut(row.saturating_add(1)) {
                *count += 1;
            }
        }
        let mut sum = 0;
        for count in &mut start {
            sum += *count;
            *count = sum;
        }
        let Some((_, first)) = pairs.clone().find(|(row, _)| *row < rows) else {
            return ByRow { start, items: Vec::new() };
        };
        let mut items = vec![first; sum];
        let mut next = start.clone();
        for (row, item) in pairs.filter(|(row, _)| *row < rows) {
            let Some(place) = next.get_mut(row) else { continue };
            if let Some(slot) = items.get_mut(*place) {
                *slot = item;
            }
            *place += 1;
        }
        ByRow { start, items }
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
