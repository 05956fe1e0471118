//! Lists that many readings have in common, held once.

use crate::error::Result;
use crate::mix::Mix;
use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};
use std::ops::{Deref, DerefMut};
use std::sync::Arc;

/// A list of fixed length that readings share until one of them changes it.
#[derive(Debug, Clone)]
pub struct Shared<T>(Arc<[T]>);

impl<T> Shared<T> {
    /// The items.
    pub(crate) fn as_slice(&self) -> &[T] {
        &self.0
    }

    /// These `count` items in its place, where they are; nothing is allocated if it had so many and nobody shares it.
    pub(crate) fn refill(&mut self, count: usize, items: impl Iterator<Item = Result<T>>) -> Result<()> {
        match Arc::get_mut(&mut self.0) {
            Some(list) if list.len() == count => {
                for (slot, item) in list.iter_mut().zip(items) {
                    *slot = item?;
                }
            }
            _ => self.0 = items.collect::<Result<Vec<T>>>()?.into(),
        }
        Ok(())
    }
}

/// A text that readings share.
#[derive(Debug, Clone, Default, Eq, Hash, PartialOrd, Ord)]
pub struct Label(Arc<str>);

impl Label {
    /// The text.
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl Deref for Label {
    type Target = str;
    fn deref(&self) -> &str {
        &self.0
    }
}

impl AsRef<str> for Label {
    fn as_ref(&self) -> &str {
        &self.0
    }
}

impl std::fmt::Display for Label {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::borrow::Borrow<str> for Label {
    fn borrow(&self) -> &str {
        &self.0
    }
}

impl<T: Into<Arc<str>>> From<T> for Label {
    fn from(text: T) -> Self {
        Label(text.into())
    }
}

impl<T: AsRef<str> + ?Sized> PartialEq<T> for Label {
    fn eq(&self, other: &T) -> bool {
        *self.0 == *other.as_ref()
    }
}

impl<T> Default for Shared<T> {
    fn default() -> Self {
        Shared(Arc::new([]))
    }
}

impl<T> Deref for Shared<T> {
    type Target = [T];
    fn deref(&self) -> &[T] {
        &self.0
    }
}

/// A change makes a list of its own where others share it.
impl<T: Clone> DerefMut for Shared<T> {
    fn deref_mut(&mut self) -> &mut [T] {
        Arc::make_mut(&mut self.0)
    }
}

impl<T: PartialEq> PartialEq for Shared<T> {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0) || self.0 == other.0
    }
}

impl<T> From<Vec<T>> for Shared<T> {
    fn from(list: Vec<T>) -> Self {
        Shared(list.into())
    }
}

impl<T> FromIterator<T> for Shared<T> {
    fn from_iter<I: IntoIterator<Item = T>>(items: I) -> Self {
        Shared(items.into_iter().collect())
    }
}

impl<'a, T> IntoIterator for &'a Shared<T> {
    type Item = &'a T;
    type IntoIter = std::slice::Iter<'a, T>;
    fn into_iter(self) -> Self::IntoIter {
        self.0.iter()
    }
}

/// What was shared before, found by its bits.
#[derive(Debug)]
pub(crate) struct Pool<T>(HashMap<u64, Shared<T>, BuildHasherDefault<Mix>>);

impl<T> Default for Pool<T> {
    fn default() -> Self {
        Pool(HashMap::default())
    }
}

impl<T: Copy + PartialEq> Pool<T> {
    /// Different lists that are remembered: beyond, there is little to share.
    const MOST: usize = 1 << 16;

    /// The list, shared with the earlier ones that are equal.
    pub fn share(&mut self, list: &[T], bits: impl Iterator<Item = u64>) -> Shared<T> {
        let mut hash = Mix::default();
        bits.for_each(|word| hash.write_u64(word));
        match self.0.get(&hash.finish()) {
            Some(known) if **known == *list => known.clone(),
            _ => {
                let new = Shared(list.into());
                if self.0.len() < Self::MOST {
                    self.0.insert(hash.finish(), new.clone());
                }
                new
            }
        }
    }
}
