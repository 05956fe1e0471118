//! Names and units by the indices in parts of the campaign (rows of a design, terms of a combination, lines of scatter).

use super::Campaign;

impl Campaign {
    /// Identifier of parameter `k`.
    pub(crate) fn parameter_id(&self, k: usize) -> &str {
        of(&self.parameters, k, |p| &p.id)
    }

    /// Unit of parameter `k`.
    pub(crate) fn parameter_unit(&self, k: usize) -> &str {
        of(&self.parameters, k, |p| &p.unit)
    }

    /// Identifier of the bench's sensor `k`.
    pub(crate) fn sensor_id(&self, k: usize) -> &str {
        of(&self.bench.sensors, k, |s| &s.id)
    }

    /// Unit of the bench's sensor `k`.
    pub(crate) fn sensor_unit(&self, k: usize) -> &str {
        of(&self.bench.sensors, k, |s| &s.unit)
    }

    /// Label of the position of reading `k`.
    pub(crate) fn position_of(&self, k: usize) -> &str {
        of(&self.readings.rows, k, |r| &r.position)
    }

    /// Place of reading `k` in its file.
    pub(crate) fn place_of(&self, k: usize) -> String {
        self.readings.rows.get(k).map_or(String::new(), |r| r.place.to_string())
    }
}

/// The name at an index of a list; an index outside shows as `?`, never as another name or an empty one.
#[track_caller]
fn of<'a, T>(list: &'a [T], k: usize, name: impl Fn(&'a T) -> &'a str) -> &'a str {
    debug_assert!(k < list.len(), "name {k} of {}", list.len());
    list.get(k).map_or("?", name)
}
