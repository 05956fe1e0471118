//! Names and units by the indices that the campaign's own parts carry (rows of a design, terms of a combination, lines of scatter).

use super::Campaign;

impl Campaign {
    /// Identifier of parameter `k`.
    pub(crate) fn parameter_id(&self, k: usize) -> &str {
        of(&self.parameters, k, |own| &own.id)
    }

    /// Unit of parameter `k`.
    pub(crate) fn parameter_unit(&self, k: usize) -> &str {
        of(&self.parameters, k, |own| &own.unit)
    }

    /// Identifier of the bench's sensor `k`.
    pub(crate) fn sensor_id(&self, k: usize) -> &str {
        of(&self.bench.sensors, k, |own| &own.id)
    }

    /// Unit of the bench's sensor `k`.
    pub(crate) fn sensor_unit(&self, k: usize) -> &str {
        of(&self.bench.sensors, k, |own| &own.unit)
    }

    /// Label of the position of reading `k`.
    pub(crate) fn position_of(&self, k: usize) -> &str {
        of(&self.readings.rows, k, |own| &own.position)
    }

    /// Where reading `k` stands in its file.
    pub(crate) fn place_of(&self, k: usize) -> &str {
        of(&self.readings.rows, k, |own| &own.place)
    }
}

/// A name in a list to which the index belongs; one that does not shows as `?`, never as another's name or as none.
#[track_caller]
fn of<'a, T>(list: &'a [T], k: usize, name: impl Fn(&'a T) -> &'a str) -> &'a str {
    debug_assert!(k < list.len(), "name {k} of {}", list.len());
    list.get(k).map_or("?", name)
}
