//! Lists that many readings have in common, held once.

use crate::error::Result;
use crate::mix::Mix;
use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};
use std::ops::{Deref, DerefMut};
use std::sync::{Arc, OnceLock};

/// A list of fixed length that readings share until one of them changes it. Lists of many readings stand side by side in a block, which costs no allocation and no room
/// beside the items; an empty one is nowhere.
#[derive(Debug, Clone)]
pub struct Shared<T> {
    block: Option<Block<T>>,
    start: u32,
    length: u32,
}

/// Lists side by side, there from when their [`Pool`] is full.
type Block<T> = Arc<OnceLock<Vec<T>>>;

impl<T> Shared<T> {
    /// The items.
    pub(crate) fn as_slice(&self) -> &[T] {
        let items = self.block.as_ref().and_then(|block| block.get()).map_or(&[][..], Vec::as_slice);
        items.get(self.start as usize..).and_then(|items| items.get(..self.length as usize)).unwrap_or_default()
    }

    /// The items, where nobody shares them.
    fn alone(&mut self) -> Option<&mut [T]> {
        let items = Arc::get_mut(self.block.as_mut()?)?.get_mut()?;
        items.get_mut(self.start as usize..)?.get_mut(..self.length as usize)
    }

    /// These `count` items in its place, where they are; nothing is allocated if it had so many and nobody shares it.
    pub(crate) fn refill(&mut self, count: usize, items: impl Iterator<Item = Result<T>>) -> Result<()> {
        match self.alone().filter(|list| list.len() == count) {
            Some(list) => {
                for (slot, item) in list.iter_mut().zip(items) {
                    *slot = item?;
                }
            }
            None => *self = items.collect::<Result<Vec<T>>>()?.into(),
        }
        Ok(())
    }
}

impl<T: Clone> Shared<T> {
    /// One more item behind the others.
    pub(crate) fn push(&mut self, item: T) {
        *self = self.iter().cloned().chain([item]).collect();
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
        Shared { block: None, start: 0, length: 0 }
    }
}

impl<T> Deref for Shared<T> {
    type Target = [T];
    fn deref(&self) -> &[T] {
        self.as_slice()
    }
}

/// A change makes a list of its own where others share it.
impl<T: Clone> DerefMut for Shared<T> {
    fn deref_mut(&mut self) -> &mut [T] {
        if self.alone().is_none() {
            *self = self.to_vec().into();
        }
        // an empty list has no items to change
        self.alone().unwrap_or_default()
    }
}

impl<T: PartialEq> PartialEq for Shared<T> {
    fn eq(&self, other: &Self) -> bool {
        let block = |own: &Self| own.block.as_ref().map(Arc::as_ptr);
        (block(self), self.start, self.length) == (block(other), other.start, other.length) || **self == **other
    }
}

impl<T> From<Vec<T>> for Shared<T> {
    fn from(list: Vec<T>) -> Self {
        // longer ones do not fit into memory
        let length = u32::try_from(list.len()).unwrap_or(u32::MAX);
        let block = (length > 0).then(|| Arc::new(OnceLock::from(list)));
        Shared { block, start: 0, length }
    }
}

impl<T> FromIterator<T> for Shared<T> {
    fn from_iter<I: IntoIterator<Item = T>>(items: I) -> Self {
        Vec::from_iter(items).into()
    }
}

impl<'a, T> IntoIterator for &'a Shared<T> {
    type Item = &'a T;
    type IntoIter = std::slice::Iter<'a, T>;
    fn into_iter(self) -> Self::IntoIter {
        self.as_slice().iter()
    }
}

/// Lists on their way into readings: they stand in blocks, each of which is there when it is full, the last when the pool is dropped.
#[derive(Debug)]
pub(crate) struct Pool<T> {
    block: Block<T>,
    /// What will stand in it.
    items: Vec<T>,
    /// What may be shared, by its bits.
    seen: HashMap<u64, Shared<T>, BuildHasherDefault<Mix>>,
}

impl<T> Default for Pool<T> {
    fn default() -> Self {
        Pool { block: Block::default(), items: Vec::new(), seen: HashMap::default() }
    }
}

impl<T> Pool<T> {
    fn close(&mut self) {
        let items = std::mem::take(&mut self.items);
        drop(std::mem::take(&mut self.block).set(items));
    }
}

impl<T> Drop for Pool<T> {
    fn drop(&mut self) {
        self.close();
    }
}

impl<T: Copy + PartialEq> Pool<T> {
    /// Different lists that are remembered: beyond, there is little to share.
    const MOST: usize = 1 << 16;
    /// Items of a block: one allocation for thousands of lists, and no more than a megabyte that is kept for the last of them.
    const BLOCK: usize = 1 << 16;

    /// The list, shared with the earlier ones that are equal.
    pub fn share(&mut self, list: &[T], bits: impl Iterator<Item = u64>) -> Shared<T> {
        let mut hash = Mix::default();
        bits.for_each(|word| hash.write_u64(word));
        let hash = hash.finish();
        if let Some(known) = self.seen.get(&hash) {
            let is_open = known.block.as_ref().is_some_and(|block| Arc::ptr_eq(block, &self.block));
            let open = || self.items.get(known.start as usize..)?.get(..known.length as usize);
            if if is_open { open() } else { Some(&**known) } == Some(list) {
                return known.clone();
            }
        }
        let new = self.keep(list);
        if self.seen.len() < Self::MOST {
            self.seen.insert(hash, new.clone());
        }
        new
    }

    /// The list by itself.
    pub fn keep(&mut self, list: &[T]) -> Shared<T> {
        if list.is_empty() {
            return Shared::default();
        }
        if self.items.len() + list.len() > Self::BLOCK {
            self.close();
        }
        // longer ones do not fit into memory
        let [start, length] = [self.items.len(), list.len()].map(|count| u32::try_from(count).unwrap_or(u32::MAX));
        self.items.extend_from_slice(list);
        Shared { block: Some(self.block.clone()), start, length }
    }
}
