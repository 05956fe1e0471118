//! A quick hash of words.

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

/// Multiply and rotate: fast, and whoever uses it compares equal keys again.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Mix(pub u64);

impl Hasher for Mix {
    fn finish(&self) -> u64 {
        self.0 ^ (self.0 >> 29)
    }
    fn write(&mut self, bytes: &[u8]) {
        let (words, rest) = bytes.as_chunks::<8>();
        words.iter().for_each(|word| self.write_u64(u64::from_ne_bytes(*word)));
        rest.iter().for_each(|byte| self.write_u64(u64::from(*byte)));
    }
    fn write_u64(&mut self, word: u64) {
        self.0 = (self.0.rotate_left(23) ^ word).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    }
    fn write_usize(&mut self, word: usize) {
        self.write_u64(word as u64);
    }
}

/// Numbers of things that are met one after the other, from 0: things that are alike have one number. Their hashes are kept, not what they are told by, which of many
/// readings would be as large as their design.
#[derive(Debug)]
pub(crate) struct Numbers<T>(HashMap<u64, (usize, T), BuildHasherDefault<Mix>>);

impl<T> Default for Numbers<T> {
    fn default() -> Self {
        Numbers(HashMap::default())
    }
}

impl<T: Copy> Numbers<T> {
    /// The number of a thing with this hash, and the first that is alike.
    pub(crate) fn of(&mut self, mut hash: u64, own: T, mut is_alike: impl FnMut(T) -> bool) -> (usize, T) {
        let next = self.0.len();
        loop {
            match self.0.get(&hash) {
                None => return *self.0.entry(hash).or_insert((next, own)),
                Some(known) if is_alike(known.1) => return *known,
                // two things of one hash
                Some(_) => hash = hash.wrapping_add(1),
            }
        }
    }

    /// How many numbers there are.
    pub(crate) fn len(&self) -> usize {
        self.0.len()
    }

    /// Begins again.
    pub(crate) fn clear(&mut self) {
        self.0.clear();
    }
}
