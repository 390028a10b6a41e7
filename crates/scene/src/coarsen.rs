//! Coarsening: nodes that cuts have made and nothing touches any more are merged, so that the cost of many cuts does not add up.
//!
//! What is here: when, and which nodes may go. What is not: where the shape does without them, and how (crate `cutting`).
//!
//! Like cuts, this is no part of the budget of a tick: what it may look at is bounded. Bodies in which something has flowed are left as they are. Means of probes over nodes that
//! cuts have made change as some of them merge.

use crate::body::Body;
use crate::scene::Scene;
use std::collections::BTreeSet;

/// Time between two looks for what can be merged \[s\]. What is found makes an edit, which costs as much as a small cut.
const PERIOD: f64 = 0.1;

/// A look is left out after a tick whose work was more than this fraction of its length.
const LIGHT: f64 = 0.25;

/// Every so many looks one is made after any tick: bodies that are hard to compute need it most.
const ALWAYS: usize = 3;

/// Nodes of a body that are looked at each time, one after the other in turn: some microseconds each.
const LOOKS: usize = 128;

impl Scene {
    /// Merges nodes of bodies that were cut before, at the end of a tick without a cut that began at `start` \[s\] and has taken so much `work` \[s\].
    pub(crate) fn coarsen(&mut self, start: f64, work: f64) {
        // The casts saturate.
        let turn = (self.state.time / PERIOD) as usize;
        let is_light = work <= LIGHT * (self.state.time - start);
        if (start / PERIOD) as usize == turn || !(is_light || turn.is_multiple_of(ALWAYS)) {
            return;
        }
        for body in 0..self.bodies.len() {
            let needless = self.needless(body);
            let count = needless.len();
            let first = turn.wrapping_mul(LOOKS) % count.max(1);
            let candidates = needless.into_iter().cycle();
            let candidates = candidates.skip(first).take(LOOKS.min(count));
            let of = &mut self.bodies[body];
            let current = &self.state.bodies[body].positions;
            let topology = of.topology.as_mut();
            let made =
                topology.and_then(|topology| topology.coarsen(&of.mesh, current, candidates));
            if let Some(made) = made {
                self.update_strokes(body, None, &made.edit);
                self.apply_cut(body, &made);
            }
        }
        self.update_surfaces();
    }

    /// The nodes that cuts have made of a body and nothing refers to but its elements: no contact, no blade in progress, no clamp, load or coupling.
    fn needless(&self, body: usize) -> Vec<u32> {
        let of = &self.bodies[body];
        if of.model.flows() {
            return Vec::new();
        }
        let new = |node: &u32| of.mesh.node_ids[*node as usize] >= of.first_new_node;
        let new: Vec<u32> = (0..of.mesh.positions.len() as u32).filter(new).collect();
        if new.is_empty() {
            return new;
        }
        let mut referred = of.referred_nodes();
        let (group, place) = self.place_of(body);
        let first = self.groups[group].members[place as usize].first_node as u32;
        let touched = self.state.contacts[group].nodes();
        referred.extend(touched.filter_map(|node| node.checked_sub(first)));
        for (cut, blade) in self.cuts.iter().zip(&self.state.blades) {
            if cut.body == body {
                let passed = blade.strokes.iter().flat_map(|(_, stroke)| {
                    let waiting = stroke.waiting.keys().flatten();
                    stroke.nodes.keys().chain(waiting)
                });
                referred.extend(passed);
            }
        }
        let is_free = |node: &u32| {
            !referred.contains(node)
                && !of.model.is_clamped(*node as usize)
                && !of.model.is_coupled(*node)
        };
        new.into_iter().filter(is_free).collect()
    }
}

impl Body {
    /// Nodes that clamps, grips, loads, open ends and the lumen refer to.
    fn referred_nodes(&self) -> BTreeSet<u32> {
        let mut nodes: BTreeSet<u32> = self.end_nodes.iter().flatten().copied().collect();
        nodes.extend(self.drive.nodes());
        nodes.extend(
            self.lumen
                .iter()
                .flat_map(|lumen| lumen.nodes().iter().copied()),
        );
        nodes
    }
}
