//! What a state has to follow once its model was edited.

use crate::elements::splice::{Blend, Inherited, splice};
use crate::elements::{BLOCKS, PlasticState};
use crate::state::State;
use nalgebra::Vector3;

/// What an edit changed in a model.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ModelChange {
    /// The nodes whose masses or forces have changed, ascending: those whose inertia may need a
    /// [floor](crate::stability::floor_nodes). What was added to it before is taken off.
    pub touched: Vec<u32>,
    pub(super) new_nodes: Vec<([u32; 2], f64)>,
    pub(super) removed_nodes: Vec<u32>,
    /// Set after set.
    pub(super) sets: Vec<SetChange>,
}

/// What an edit changed in a set of elements.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct SetChange {
    /// Numbers of elements and of internal variables before it.
    pub count: usize,
    pub internal: usize,
    /// What went out, ascending, how many came in, and what their internal variables are.
    pub removed: Vec<u32>,
    pub added: usize,
    pub inherited: Vec<Inherited>,
    pub blend: Blend,
    /// Where there are other elements now.
    pub placed: Vec<u32>,
}

impl SetChange {
    /// That of a set of so many elements and internal variables that is as it was.
    pub fn none(count: usize, internal: usize) -> Self {
        Self {
            count,
            internal,
            ..Self::default()
        }
    }

    /// Internal variables per element.
    pub fn blocks(&self) -> usize {
        match (self.internal, self.inherited.len()) {
            (0, 0) => 0,
            (0, inherited) => inherited / self.added,
            (internal, _) => internal / self.count,
        }
    }

    /// Adds the internal variables after the edit to `after`.
    fn follow(&self, before: &[f64], after: &mut Vec<f64>) {
        let blocks = self.blocks();
        let mut added: Vec<f64> = self
            .inherited
            .iter()
            .map(|one| {
                let terms = one.terms.iter();
                one.constant
                    + terms
                        .map(|(old, factor)| before[*old as usize] * factor)
                        .sum::<f64>()
            })
            .collect();
        if self.blend == Blend::PlasticState {
            for element in 0..self.added {
                let at = |block: usize| block * self.added + element;
                let means: [f64; BLOCKS] = std::array::from_fn(|block| added[at(block)]);
                for (block, value) in PlasticState::of_means(&means)
                    .blocks()
                    .into_iter()
                    .enumerate()
                {
                    added[at(block)] = value;
                }
            }
        }
        for block in 0..blocks {
            let mut values = before[block * self.count..(block + 1) * self.count].to_vec();
            let new = &added[block * self.added..(block + 1) * self.added];
            splice(&mut values, &self.removed, new);
            after.append(&mut values);
        }
    }
}

impl State {
    /// Follows an edit of the model, of whose state before it this is one. New nodes have positions, velocities and accelerations of the line on which they
    /// are; internal variables are inherited.
    pub fn edit(&mut self, change: &ModelChange) {
        for values in [
            &mut self.positions,
            &mut self.velocities,
            &mut self.accelerations,
        ] {
            if !values.is_empty() {
                follow(values, change);
            }
        }
        let mut internal = Vec::with_capacity(self.internal.len());
        let mut start = 0;
        for set in &change.sets {
            set.follow(&self.internal[start..start + set.internal], &mut internal);
            start += set.internal;
        }
        self.internal = internal;
    }
}

fn follow(values: &mut Vec<Vector3<f64>>, change: &ModelChange) {
    for ([a, b], share) in &change.new_nodes {
        let (a, b) = (values[*a as usize], values[*b as usize]);
        values.push(a + (b - a) * *share);
    }
    splice(values, &change.removed_nodes, &[]);
}
