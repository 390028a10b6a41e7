//! Whether an edit has taken a body apart.

use super::plan::Plan;
use crate::model::TissueModel;
use microsim_contact_solver::Groups;
use std::sync::Arc;

impl TissueModel {
    /// Makes the connected parts follow. Where what was touched still holds together by itself, or with the tetrahedra next to it, they
    /// are as they were; else something may have come off, and they are found again when they are next asked for, in a time that
    /// goes with the body. `ties_changed` states that of a coupling.
    pub(super) fn follow_components(&mut self, plan: &Plan, ties_changed: bool) {
        let Some(mut components) = self.components.take() else {
            return;
        };
        if ties_changed || !plan.nodes.is_same() {
            return;
        }
        let gone = plan.gone.iter().flat_map(|(_, tet)| *tet);
        let changed: Vec<u32> = plan.changed().collect();
        let tets = changed.iter().flat_map(|e| self.tets[*e as usize]);
        let mut touched: Vec<u32> = gone.chain(tets).collect();
        touched.sort_unstable();
        touched.dedup();
        let around = || {
            let tets = touched.iter().flat_map(|node| self.index().tets_at(*node));
            let mut tets: Vec<u32> = tets.copied().collect();
            tets.sort_unstable();
            tets.dedup();
            tets
        };
        if !self.are_joined(&touched, &changed) && !self.are_joined(&touched, &around()) {
            return;
        }
        let before = plan.nodes_before();
        let old = touched.iter().take_while(|node| (**node as usize) < before);
        let mut parts = old.map(|node| components.of_node[*node as usize]);
        let first = parts.next();
        let is_one = parts.all(|part| Some(part) == first);
        if let (true, Some(part)) = (is_one, first) {
            let all = Arc::make_mut(&mut components);
            all.of_node.resize(self.rest_positions.len(), part);
            self.components = components.into();
        }
    }

    /// Whether these tetrahedra join these nodes, ascending, to one part.
    fn are_joined(&self, nodes: &[u32], tets: &[u32]) -> bool {
        let mut local: Vec<u32> = tets.iter().flat_map(|e| self.tets[*e as usize]).collect();
        local.extend_from_slice(nodes);
        local.sort_unstable();
        local.dedup();
        let place = |node: u32| local.partition_point(|other| *other < node) as u32;
        let mut groups = Groups::new(local.len());
        for element in tets {
            groups.join(&self.tets[*element as usize].map(place));
        }
        let Some(first) = nodes.first().map(|node| groups.root(place(*node))) else {
            return true;
        };
        nodes.iter().all(|node| groups.root(place(*node)) == first)
    }
}
