//! What an edit comes to, checked before anything is changed.

use super::ModelEdit;
use super::error::EditError;
use crate::element_index::Index;
use crate::elements::splice::places;
use crate::elements::{Coupling, Sliding};
use crate::model::TissueModel;
use std::any::Any;

/// Where the entries of an array are once some have left, each replaced by the last one.
#[derive(Clone, Debug)]
pub(super) struct Leaving {
    before: usize,
    removed: Vec<u32>,
    /// Old and new place, ascending in the old one.
    moves: Vec<[u32; 2]>,
}

impl Leaving {
    fn new(before: usize, removed: &[u32]) -> Self {
        let (_, mut moves) = places(before, removed, 0);
        moves.sort_unstable();
        Self {
            before,
            removed: removed.to_vec(),
            moves,
        }
    }

    /// How many are left.
    pub fn count(&self) -> usize {
        self.before - self.removed.len()
    }

    /// Where an entry is then.
    pub fn after(&self, place: u32) -> Option<u32> {
        if self.removed.binary_search(&place).is_ok() {
            return None;
        }
        let moved = self.moves.binary_search_by_key(&place, |m| m[0]);
        Some(moved.map_or(place, |index| self.moves[index][1]))
    }

    /// Whether nothing leaves.
    pub fn is_same(&self) -> bool {
        self.removed.is_empty()
    }

    /// Which entry is at a place then.
    pub fn before(&self, place: u32) -> u32 {
        let moved = self.moves.iter().find(|m| m[1] == place);
        moved.map_or(place, |m| m[0])
    }

    /// Entries that are elsewhere then, with their new place.
    pub fn moves(&self) -> &[[u32; 2]] {
        &self.moves
    }
}

/// What an edit comes to.
#[derive(Clone, Debug)]
pub(super) struct Plan {
    pub nodes: Leaving,
    pub elements: Leaving,
    /// Elements before the edit of which there is nothing left but parts, ascending, with their tetrahedra.
    pub gone: Vec<(u32, [u32; 4])>,
    /// Elements after the edit that are new, ascending, with the one they are a part of.
    pub fresh: Vec<(u32, u32)>,
    /// Elements that are the same with other numbers of nodes: before and after, ascending.
    pub reshaped: Vec<(u32, u32)>,
    /// Elements that are the same but for their number: before and after.
    pub renumbered: Vec<(u32, u32)>,
    /// The nodes before the edit between which each new node is, ascending.
    pub supports: Vec<Vec<u32>>,
}

impl Plan {
    pub fn new(model: &TissueModel, edit: &ModelEdit<'_>) -> Result<Self, EditError> {
        if model.drags().len() > 1 {
            return Err(EditError::Union);
        }
        let made = model.parts_made();
        if let Some(part) = made.iter().find(|part| part.material.is_quadratic()) {
            return Err(EditError::Quadratic {
                region: part.region,
            });
        }
        let foreign = model.sets().iter().enumerate().skip(made.len());
        for (set, elements) in foreign {
            let elements: &dyn Any = &**elements;
            if !elements.is::<Coupling>() && !elements.is::<Sliding>() {
                return Err(EditError::Foreign { set });
            }
        }
        let (nodes_before, elements_before) = (model.node_count(), model.tets().len());
        let appended = nodes_before + edit.new_nodes.len();
        ascending("element", &edit.replaced, elements_before)?;
        let all_elements = elements_before + edit.parents.len();
        ascending("element", &edit.removed_elements, all_elements)?;
        ascending("node", &edit.removed_nodes, appended)?;
        for &parent in &edit.parents {
            in_range("element", parent, elements_before)?;
        }
        for (place, (between, fraction)) in edit.new_nodes.iter().enumerate() {
            for &node in between {
                in_range("node", node, nodes_before + place)?;
            }
            if !(0.0..=1.0).contains(fraction) {
                return Err(EditError::Fraction {
                    node: place,
                    fraction: *fraction,
                });
            }
        }
        let nodes = Leaving::new(appended, &edit.removed_nodes);
        let elements = Leaving::new(all_elements, &edit.removed_elements);
        count("nodes", nodes.count(), edit.mesh.positions.len())?;
        count("elements", elements.count(), edit.mesh.tets.len())?;
        count("elements", elements.count(), edit.mesh.regions.len())?;
        count("clamp flags", edit.new_nodes.len(), edit.clamped.len())?;

        let removed = edit.removed_elements.iter().copied();
        let removed = removed.filter(|&e| (e as usize) < elements_before);
        let mut gone: Vec<u32> = edit.replaced.iter().copied().chain(removed).collect();
        gone.sort_unstable();
        gone.dedup();
        let appended_parents = (elements_before as u32..).zip(edit.parents.iter().copied());
        let parts = edit
            .replaced
            .iter()
            .map(|&e| (e, e))
            .chain(appended_parents);
        let mut fresh: Vec<(u32, u32)> = parts
            .filter_map(|(element, parent)| Some((elements.after(element)?, parent)))
            .collect();
        fresh.sort_unstable();

        let index = model.index();
        let other_nodes = nodes.moves().iter().map(|m| m[0]);
        let mut reshaped: Vec<(u32, u32)> = other_nodes
            .filter(|&node| (node as usize) < nodes_before)
            .flat_map(|node| index.tets_at(node).iter().copied())
            .filter(|element| gone.binary_search(element).is_err())
            .filter_map(|element| Some((element, elements.after(element)?)))
            .collect();
        reshaped.sort_unstable();
        reshaped.dedup();
        let renumbered = elements.moves().iter().map(|m| (m[0], m[1]));
        let renumbered = renumbered
            .filter(|&(from, _)| (from as usize) < elements_before)
            .filter(|(from, _)| gone.binary_search(from).is_err())
            .filter(|both| reshaped.binary_search(both).is_err())
            .collect();
        let plan = Self {
            gone: gone
                .iter()
                .map(|&element| (element, model.tets()[element as usize]))
                .collect(),
            fresh,
            reshaped,
            renumbered,
            supports: supports(nodes_before, &edit.new_nodes),
            nodes,
            elements,
        };
        plan.check_elements(model, edit)?;
        plan.check_nodes(nodes_before, index, edit)?;
        Ok(plan)
    }

    /// Number of nodes before the edit.
    pub fn nodes_before(&self) -> usize {
        self.nodes.before - self.supports.len()
    }

    /// The changed elements of the mesh, after the edit.
    pub fn changed(&self) -> impl Iterator<Item = u32> + '_ {
        let fresh = self.fresh.iter().map(|(element, _)| *element);
        fresh.chain(self.reshaped.iter().map(|(_, element)| *element))
    }

    fn check_elements(&self, model: &TissueModel, edit: &ModelEdit<'_>) -> Result<(), EditError> {
        let mesh = edit.mesh;
        for element in self.changed() {
            for &node in &mesh.tets[element as usize] {
                in_range("node", node, mesh.positions.len())?;
            }
            let [a, b, c, d] = mesh.corners(element as usize);
            let volume = microsim_mesh::signed_volume(&a, &b, &c, &d);
            if volume.is_nan() || volume <= 0.0 {
                return Err(EditError::Volume { element, volume });
            }
            let region = mesh.regions[element as usize];
            if model.density(region).is_none() {
                return Err(EditError::Region { element, region });
            }
        }
        Ok(())
    }

    /// Whether nodes that stay, and none that leave, belong to an element.
    fn check_nodes(
        &self,
        nodes_before: usize,
        index: &Index,
        edit: &ModelEdit<'_>,
    ) -> Result<(), EditError> {
        let is_gone = |element: &&u32| self.gone.binary_search_by_key(*element, |g| g.0).is_ok();
        let kept = |node: u32| match (node as usize) < nodes_before {
            true => index.tets_at(node).iter().filter(|e| !is_gone(e)).count(),
            false => 0,
        };
        let fresh = self
            .fresh
            .iter()
            .flat_map(|(e, _)| edit.mesh.tets[*e as usize]);
        let mut fresh: Vec<u32> = fresh.collect();
        fresh.sort_unstable();
        fresh.dedup();
        let touched = self.gone.iter().flat_map(|(_, tet)| *tet);
        let new = (nodes_before as u32..).take(edit.new_nodes.len());
        let all = touched.chain(new).chain(edit.removed_nodes.iter().copied());
        let mut all: Vec<u32> = all.collect();
        all.sort_unstable();
        all.dedup();
        for node in all {
            let elements = kept(node);
            let wrong = match self.nodes.after(node) {
                Some(after) => elements == 0 && fresh.binary_search(&after).is_err(),
                None => elements > 0,
            };
            if wrong {
                return Err(EditError::Node { node, elements });
            }
        }
        Ok(())
    }
}

/// The nodes before the edit between which each new one is.
fn supports(before: usize, new_nodes: &[([u32; 2], f64)]) -> Vec<Vec<u32>> {
    let mut supports: Vec<Vec<u32>> = Vec::with_capacity(new_nodes.len());
    for (between, fraction) in new_nodes {
        let mut support = Vec::new();
        for (node, weight) in between.iter().zip([1.0 - fraction, *fraction]) {
            if weight == 0.0 {
                continue;
            }
            match (*node as usize).checked_sub(before) {
                None => support.push(*node),
                Some(new) => support.extend_from_slice(&supports[new]),
            }
        }
        support.sort_unstable();
        support.dedup();
        supports.push(support);
    }
    supports
}

fn in_range(of: &'static str, number: u32, count: usize) -> Result<(), EditError> {
    match (number as usize) < count {
        true => Ok(()),
        false => Err(EditError::Number { of, number }),
    }
}

fn ascending(of: &'static str, numbers: &[u32], count: usize) -> Result<(), EditError> {
    for pair in numbers.windows(2) {
        if pair[0] >= pair[1] {
            let number = pair[1];
            return Err(EditError::Number { of, number });
        }
    }
    match numbers.last() {
        Some(&number) => in_range(of, number, count),
        None => Ok(()),
    }
}

fn count(of: &'static str, expected: usize, found: usize) -> Result<(), EditError> {
    match expected == found {
        true => Ok(()),
        false => Err(EditError::Count {
            of,
            expected,
            found,
        }),
    }
}
