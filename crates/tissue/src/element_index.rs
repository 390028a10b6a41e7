//! Which elements are at a node: what an edit looks up.

use crate::elements::Elements;
use crate::elements::key::Key;
use crate::elements::splice::{make_room, places};
use std::sync::{Arc, OnceLock};

/// The tetrahedra at each node, and the elements of each set by their keys.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Index {
    tets: Vec<Vec<u32>>,
    sets: Vec<SetIndex>,
}

/// The elements of one set by their keys.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SetIndex {
    /// By the lowest node of the key.
    at: Vec<Vec<(Key, u32)>>,
}

impl Index {
    /// That of these tetrahedra and sets.
    pub fn new(nodes: usize, tets: &[[u32; 4]], sets: &[Arc<dyn Elements>]) -> Self {
        let mut index = Self {
            tets: vec![Vec::new(); nodes],
            sets: sets
                .iter()
                .map(|set| SetIndex::new(nodes, &**set))
                .collect(),
        };
        for (element, tet) in tets.iter().enumerate() {
            index.add_tet(element as u32, tet);
        }
        index
    }

    /// Makes room for so many nodes, or forgets the last ones.
    pub fn resize(&mut self, nodes: usize) {
        self.tets.resize(nodes, Vec::new());
        for set in &mut self.sets {
            set.at.resize(nodes, Vec::new());
        }
    }

    /// The tetrahedra at a node, in no particular order.
    pub fn tets_at(&self, node: u32) -> &[u32] {
        &self.tets[node as usize]
    }

    pub fn add_tet(&mut self, element: u32, tet: &[u32; 4]) {
        for node in tet {
            self.tets[*node as usize].push(element);
        }
    }

    pub fn remove_tet(&mut self, element: u32, tet: &[u32; 4]) {
        for node in tet {
            let at = &mut self.tets[*node as usize];
            if let Some(place) = at.iter().position(|&other| other == element) {
                at.swap_remove(place);
            }
        }
    }

    /// The tetrahedra that have all nodes of a key, ascending, added to `found`.
    pub fn tets_of(&self, key: Key, tets: &[[u32; 4]], found: &mut Vec<u32>) {
        let nodes = key.nodes();
        let Some(fewest) = nodes.iter().min_by_key(|node| self.tets_at(**node).len()) else {
            return;
        };
        let first = found.len();
        let has_all = |element: &&u32| {
            let tet = &tets[**element as usize];
            nodes.iter().all(|node| tet.contains(node))
        };
        found.extend(self.tets_at(*fewest).iter().filter(has_all));
        found[first..].sort_unstable();
    }

    /// Brings all entries in order.
    #[cfg(test)]
    pub fn sort(&mut self) {
        self.tets.iter_mut().for_each(|at| at.sort_unstable());
        let sets = self.sets.iter_mut().flat_map(|set| &mut set.at);
        sets.for_each(|at| at.sort_unstable());
    }

    /// Makes room for half as much again.
    pub fn make_room(&mut self) {
        make_room(&mut self.tets);
        self.sets.iter_mut().for_each(|set| make_room(&mut set.at));
    }

    /// The elements of a set.
    pub fn set(&self, set: usize) -> &SetIndex {
        &self.sets[set]
    }

    /// The elements of a set.
    pub fn set_mut(&mut self, set: usize) -> &mut SetIndex {
        &mut self.sets[set]
    }
}

impl SetIndex {
    fn new(nodes: usize, set: &dyn Elements) -> Self {
        let mut index = Self {
            at: vec![Vec::new(); nodes],
        };
        for element in 0..set.count() {
            index.add(set, element);
        }
        index
    }

    fn add(&mut self, set: &dyn Elements, element: usize) {
        set.keys(element, &mut |key| {
            self.at[key.first() as usize].push((key, element as u32));
        });
    }

    fn remove(&mut self, set: &dyn Elements, element: usize) {
        set.keys(element, &mut |key| {
            let at = &mut self.at[key.first() as usize];
            let entry = (key, element as u32);
            if let Some(place) = at.iter().position(|other| *other == entry) {
                at.swap_remove(place);
            }
        });
    }

    /// The elements with a key.
    pub fn find(&self, key: Key) -> impl Iterator<Item = u32> + '_ {
        let at = self.at[key.first() as usize].iter();
        at.filter(move |(other, _)| *other == key)
            .map(|(_, element)| *element)
    }

    /// Forgets what a splice takes out of `set` or moves; to be called before it. `added` is how many come in.
    pub fn before_splice(&mut self, set: &dyn Elements, removed: &[u32], added: usize) {
        for &element in removed {
            self.remove(set, element as usize);
        }
        for [from, _] in places(set.count(), removed, added).1 {
            self.remove(set, from as usize);
        }
    }

    /// Learns what a splice put in or moved: elements of `set` at these places.
    pub fn after_splice(&mut self, set: &dyn Elements, placed: &[u32]) {
        for &element in placed {
            self.add(set, element as usize);
        }
    }
}

/// The index of a model, once it was needed. A clone makes its own: an edit then never copies one.
#[derive(Debug, Default)]
pub(crate) struct IndexCell(OnceLock<Index>);

impl Clone for IndexCell {
    fn clone(&self) -> Self {
        Self::default()
    }
}

impl IndexCell {
    /// The index, built by `build` where there is none yet.
    pub fn get_or_init(&self, build: impl FnOnce() -> Index) -> &Index {
        self.0.get_or_init(build)
    }

    /// Takes the index out, if there is one.
    pub fn take(&mut self) -> Option<Index> {
        self.0.take()
    }

    /// Puts an index in.
    pub fn put(&mut self, index: Index) {
        self.0 = index.into();
    }
}
