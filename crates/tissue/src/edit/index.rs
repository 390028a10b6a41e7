//! What edits look up in a model, and how they prepare it.

use crate::element_index::Index;
use crate::elements::key::Key;
use crate::elements::splice::make_room;
use crate::model::TissueModel;

impl TissueModel {
    /// Builds what [`edit`](Self::edit) and [`stability::floor_nodes`](crate::stability::floor_nodes) look up, takes the sets of
    /// elements to itself where clones hold them too, and makes room for half as much again, in a time that goes with the body. Else edits
    /// do it.
    pub fn prepare_edits(&mut self) {
        self.index();
        self.rate_bound();
        self.row_sums();
        self.components();
        for set in 0..self.sets.len() {
            self.own_set(set).make_room();
        }
        make_room(&mut self.rest_positions);
        make_room(&mut self.masses);
        make_room(&mut self.added_inertia);
        make_room(&mut self.inverse_masses);
        make_room(&mut self.tets);
        make_room(&mut self.rest_volumes);
        if let Some(mut sums) = self.row_sums.take() {
            make_room(&mut sums);
            self.row_sums = sums.into();
        }
        let mut index = self.take_index();
        index.make_room();
        self.put_index(index);
    }

    /// What edits look up.
    pub(crate) fn index(&self) -> &Index {
        let index = || Index::new(self.node_count(), &self.tets, &self.sets);
        self.index.get_or_init(index)
    }

    /// Whether a coupling or an interface that slides holds a node.
    pub fn is_coupled(&self, node: u32) -> bool {
        let couplings = self.made_of.len()..self.sets.len();
        let mut found = couplings.map(|set| self.index().set(set).find(Key::new(&[node])).next());
        found.any(|tie| tie.is_some())
    }

    /// Whether any element has a state of its own, as plastic flow leaves it.
    pub fn flows(&self) -> bool {
        let sets = &self.internal[..self.made_of.len()];
        sets.iter().any(|internal| !internal.is_empty())
    }

    /// Takes the index out, to be changed and [put back](Self::put_index).
    pub(super) fn take_index(&mut self) -> Index {
        self.index();
        self.index.take().unwrap_or_default()
    }

    pub(super) fn put_index(&mut self, index: Index) {
        self.index.put(index);
    }
}
