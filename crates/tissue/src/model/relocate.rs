//! Elements that move on to other nodes: layers that slide on each other.

use super::TissueModel;
use crate::elements::Sliding;
use std::any::Any;

impl TissueModel {
    /// Whether these can be the internal variables of a state of this model, as far as their number and the places that they state go.
    pub fn admits(&self, internal: &[f64]) -> bool {
        let count = self.internal.last().map_or(0, |range| range.end);
        let mut sets = self.sets.iter().zip(&self.internal);
        internal.len() == count && sets.all(|(set, range)| set.admits(&internal[range.clone()]))
    }

    /// Whether a set is one of elements that slide.
    fn slides(&self, set: usize) -> bool {
        (&*self.sets[set] as &dyn Any).is::<Sliding>()
    }

    /// Whether any elements slide.
    pub(crate) fn has_sliding(&self) -> bool {
        (0..self.sets.len()).any(|set| self.slides(set))
    }

    /// The internal variables of elements that slide, set after set: where they are. An edit of the mesh depends on it.
    pub fn places(&self, internal: &[f64]) -> Vec<f64> {
        let sliding = (0..self.sets.len()).filter(|set| self.slides(*set));
        let places = sliding.flat_map(|set| &internal[self.internal[set].clone()]);
        places.copied().collect()
    }

    /// [Relocates](Self::relocate) elements that slide to [places](Self::places); returns whether these can be places of this model.
    pub fn relocate_to(&mut self, places: &[f64]) -> bool {
        let mut internal = vec![0.0; self.internal.last().map_or(0, |range| range.end)];
        let mut rest = places;
        for set in (0..self.sets.len()).filter(|set| self.slides(*set)) {
            let range = self.internal[set].clone();
            let Some((of_set, others)) = rest.split_at_checked(range.len()) else {
                return false;
            };
            internal[range].copy_from_slice(of_set);
            rest = others;
        }
        let fits = rest.is_empty() && self.admits(&internal);
        if fits {
            self.relocate(&internal);
        }
        fits
    }

    /// Puts elements where the internal variables of a state have put them ([`flow`](crate::flow)); returns whether any has other nodes than
    /// before: then solvers must [follow](crate::Solver::follow). Whoever drives solvers calls it before each step. A model that is not
    /// in place gives no right energies of the state.
    pub fn relocate(&mut self, internal: &[f64]) -> bool {
        let out_of_place = |set: &usize| {
            let of_set = &internal[self.internal[*set].clone()];
            !self.sets[*set].is_in_place(of_set)
        };
        let sets: Vec<usize> = (0..self.sets.len()).filter(out_of_place).collect();
        if sets.is_empty() {
            return false;
        }
        let mut moved = vec![Vec::new(); self.sets.len()];
        let mut index = self.index.take();
        for set in sets {
            let of_set = &internal[self.internal[set].clone()];
            moved[set] = self.sets[set].moved(of_set);
            let elements = &moved[set];
            if let Some(index) = &mut index {
                let set = (index.set_mut(set), &*self.sets[set]);
                set.0.before_splice(set.1, elements, elements.len());
            }
            self.own_set(set).relocate(of_set);
            if let Some(index) = &mut index {
                index.set_mut(set).after_splice(&*self.sets[set], elements);
            }
        }
        // Not updated: what is left in a sum of what has been in it would depend on the path.
        self.row_sums.take();
        if let Some(index) = index {
            self.index.put(index);
        }
        if moved.iter().all(Vec::is_empty) {
            return false;
        }
        let placed: Vec<&[u32]> = moved.iter().map(Vec::as_slice).collect();
        self.follow_parts(&placed);
        self.components.take();
        true
    }
}
