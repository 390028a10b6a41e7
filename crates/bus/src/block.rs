//! A large state as one relocatable block of plain data: header, array directory, arrays. No pointer is in it, so it
//! may be shared, copied, mapped or sent as it is.
//!
//! Layout in little-endian 64-bit words:
//!
//! | word | what |
//! |---|---|
//! | 0 | magic `MSBLOCK1` |
//! | 1 | message kind |
//! | 2 | name id (`kind_id` of the body's name) |
//! | 3 | topology generation: changes whenever nodes or elements come or go |
//! | 4 | simulated time \[ns\] |
//! | 5 | number of arrays n |
//! | 6 + 4 i … | array i: name id, element type, number of elements, first word |
//! | 6 + 4 n … | the arrays, each starting at a word |
//!
//! Node and element ids in the arrays are stable: they are never reused, so that a reader which holds an id over a cut
//! finds the same node or none.

use crate::kind::kind_id;
use std::fmt;
use std::sync::Arc;

const MAGIC: u64 = u64::from_le_bytes(*b"MSBLOCK1");
const HEAD: usize = 6;
const ENTRY: usize = 4;
const F64: u64 = 1;
const U32: u64 = 2;

/// A finished block, shared read-only.
#[derive(Clone, Debug, PartialEq)]
pub struct Block(Arc<[u64]>);

/// A block that does not follow the layout.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BlockError(String);

impl fmt::Display for BlockError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "bad block: {}", self.0)
    }
}

impl std::error::Error for BlockError {}

impl Block {
    /// Takes words that some plugin made, after checking the layout.
    pub fn new(words: &[u64]) -> Result<Self, BlockError> {
        BlockView::new(words)?;
        Ok(Self(words.into()))
    }

    /// The words, as they cross a boundary.
    pub fn words(&self) -> &[u64] {
        &self.0
    }

    /// The block to read from.
    pub fn view(&self) -> BlockView<'_> {
        BlockView { words: &self.0 }
    }
}

/// A block to read from.
#[derive(Clone, Copy, Debug)]
pub struct BlockView<'a> {
    words: &'a [u64],
}

impl<'a> BlockView<'a> {
    /// Checks every offset and length once, so that reading cannot fail for them later.
    pub fn new(words: &'a [u64]) -> Result<Self, BlockError> {
        if words.len() < HEAD || words[0] != MAGIC {
            return Err(BlockError("no MSBLOCK1 header".into()));
        }
        let count = words[5];
        if count > 64 || words.len() < HEAD + ENTRY * count as usize {
            return Err(BlockError(format!(
                "directory of {count} arrays does not fit"
            )));
        }
        let view = Self { words };
        for i in 0..count as usize {
            let [_, element, length, first] = view.entry(i);
            let words_needed = match element {
                F64 => Some(length),
                U32 => Some(length.div_ceil(2)),
                _ => None,
            };
            let end = words_needed.and_then(|n| first.checked_add(n));
            let start = (HEAD + ENTRY * count as usize) as u64;
            if first < start || end.is_none_or(|end| end > words.len() as u64) {
                return Err(BlockError(format!("array {i} lies outside the block")));
            }
        }
        Ok(view)
    }

    fn entry(&self, i: usize) -> [u64; 4] {
        let at = HEAD + ENTRY * i;
        [
            self.words[at],
            self.words[at + 1],
            self.words[at + 2],
            self.words[at + 3],
        ]
    }

    fn find(&self, name: &str, element: u64) -> Option<(usize, usize)> {
        let id = kind_id(name);
        (0..self.words[5] as usize)
            .map(|i| self.entry(i))
            .find(|e| e[0] == id && e[1] == element)
            .map(|e| (e[3] as usize, e[2] as usize))
    }

    /// Message kind.
    pub fn kind(&self) -> u64 {
        self.words[1]
    }

    /// Id of the body's name ([`kind_id`]).
    pub fn name(&self) -> u64 {
        self.words[2]
    }

    /// Topology generation.
    pub fn generation(&self) -> u64 {
        self.words[3]
    }

    /// Simulated time \[ns\].
    pub fn time_ns(&self) -> u64 {
        self.words[4]
    }

    /// An array of numbers, or `None` if the block has none of that name.
    pub fn f64s(&self, name: &str) -> Option<&'a [f64]> {
        let (first, length) = self.find(name, F64)?;
        Some(bytemuck::cast_slice(&self.words[first..first + length]))
    }

    /// An array of indices or ids, or `None` if the block has none of that name.
    pub fn u32s(&self, name: &str) -> Option<&'a [u32]> {
        let (first, length) = self.find(name, U32)?;
        let words = &self.words[first..first + length.div_ceil(2)];
        Some(&bytemuck::cast_slice(words)[..length])
    }
}

/// Builds a block array by array.
#[derive(Clone, Debug)]
pub struct BlockBuilder {
    head: [u64; HEAD],
    entries: Vec<[u64; ENTRY]>,
    data: Vec<u64>,
}

impl BlockBuilder {
    /// An empty block of kind `kind` for the body `name`.
    pub fn new(kind: &str, name: &str, generation: u64, time_ns: u64) -> Self {
        Self {
            head: [MAGIC, kind_id(kind), kind_id(name), generation, time_ns, 0],
            entries: Vec::new(),
            data: Vec::new(),
        }
    }

    /// Adds an array of numbers.
    pub fn f64s(mut self, name: &str, values: impl IntoIterator<Item = f64>) -> Self {
        let first = self.data.len();
        self.data.extend(values.into_iter().map(f64::to_bits));
        let length = self.data.len() - first;
        self.entries
            .push([kind_id(name), F64, length as u64, first as u64]);
        self
    }

    /// Adds an array of indices or ids.
    pub fn u32s(mut self, name: &str, values: impl IntoIterator<Item = u32>) -> Self {
        let first = self.data.len();
        let mut length = 0_u64;
        for value in values {
            if length.is_multiple_of(2) {
                self.data.push(u64::from(value));
            } else if let Some(word) = self.data.last_mut() {
                *word |= u64::from(value) << 32;
            }
            length += 1;
        }
        self.entries
            .push([kind_id(name), U32, length, first as u64]);
        self
    }

    /// The finished words.
    pub fn finish(mut self) -> Vec<u64> {
        let start = HEAD + ENTRY * self.entries.len();
        self.head[5] = self.entries.len() as u64;
        let mut words = Vec::with_capacity(start + self.data.len());
        words.extend(self.head);
        for mut entry in self.entries {
            entry[3] += start as u64;
            words.extend(entry);
        }
        words.extend(self.data);
        words
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn example() -> Vec<u64> {
        BlockBuilder::new("tissue.snapshot", "strip", 3, 16)
            .f64s("position", [1.0, -2.5, f64::MIN_POSITIVE])
            .u32s("triangle", [0, 1, 2, 7, u32::MAX])
            .u32s("empty", [])
            .finish()
    }

    #[test]
    fn arrays_come_back_from_a_copy() {
        let words = example();
        let moved = words.clone();
        drop(words);
        let view = BlockView::new(&moved).unwrap();
        assert_eq!(view.kind(), kind_id("tissue.snapshot"));
        assert_eq!((view.generation(), view.time_ns()), (3, 16));
        assert_eq!(
            view.f64s("position").unwrap(),
            [1.0, -2.5, f64::MIN_POSITIVE]
        );
        assert_eq!(view.u32s("triangle").unwrap(), [0, 1, 2, 7, u32::MAX]);
        assert_eq!(view.u32s("empty").unwrap(), [0; 0]);
        assert!(view.f64s("triangle").is_none() && view.u32s("nothing").is_none());
    }

    #[test]
    fn every_cut_is_refused() {
        let words = example();
        for end in 0..words.len() {
            assert!(BlockView::new(&words[..end]).is_err(), "cut to {end} words");
        }
    }

    proptest! {
        #[test]
        fn damaged_directories_never_panic(at in 1_usize..18, value in any::<u64>()) {
            let mut words = example();
            words[at] = value;
            if let Ok(view) = BlockView::new(&words) {
                let _ = (view.f64s("position"), view.u32s("triangle"), view.u32s("empty"));
            }
        }
    }
}
