//! Crossed edges that wait until the blade has left all elements at them (dissertation 4.2.1, listing 4.1).
//!
//! The dissertation divides an element as soon as the blade has left it. Its neighbours may still be in contact, and hold the same edges: so that the mesh is
//! conforming after every step an edge is divided when all elements at it have been left.

use crate::blade::Blade;
use crate::crossing::Crossing;
use crate::moves::last_places;
use crate::stroke::{Stroke, Waiting};
use crate::sweep::Sweep;
use crate::topology::Topology;
use microsim_mesh::TopologyEdit;
use nalgebra::Vector3;
use std::collections::BTreeMap;

impl Stroke {
    /// Enters the crossings of a step; what the blade crosses back is as if it had not been crossed. `forward` is of the step, `crossings` of the stroke.
    pub(crate) fn hold(
        &mut self,
        crossings: BTreeMap<[u32; 2], Crossing>,
        forward: &BTreeMap<[u32; 2], bool>,
    ) {
        for (edge, crossing) in crossings {
            let forward = forward[&edge];
            let old = self.waiting.insert(edge, Waiting { crossing, forward });
            if old.is_some_and(|old| old.forward != forward) {
                self.waiting.remove(&edge);
            }
        }
    }
}

impl Stroke {
    /// A node has been doubled: an edge at it may be one of its copy now, or of both. Of these the one that is not there is dropped when it is due.
    pub(crate) fn hold_copies(&mut self, node: u32, copy: u32) {
        let at_node = self.waiting.iter().filter(|(edge, _)| edge.contains(&node));
        let copies: Vec<_> = at_node
            .map(|(edge, of)| of.renamed(*edge, |n| if n == node { copy } else { n }))
            .collect();
        self.waiting.extend(copies);
    }

    /// Gives nodes the numbers that they have after an edit of a mesh that had so many; edges at nodes that it removes wait no more.
    pub(crate) fn leave_waiting(&mut self, edit: &TopologyEdit, nodes: usize) {
        if self.waiting.is_empty() || edit.removed_nodes.is_empty() {
            return;
        }
        let places = last_places(&edit.node_moves(nodes));
        let is_gone = |node: &u32| edit.removed_nodes.binary_search(node).is_ok();
        let waiting = std::mem::take(&mut self.waiting).into_iter();
        let waiting = waiting.filter(|(edge, _)| !edge.iter().any(is_gone));
        let number = |node: u32| places.get(&node).copied().unwrap_or(node);
        self.waiting = waiting.map(|(edge, of)| of.renamed(edge, number)).collect();
    }
}

impl Waiting {
    /// The same on the edge whose nodes have other numbers.
    fn renamed(&self, edge: [u32; 2], number: impl Fn(u32) -> u32) -> ([u32; 2], Self) {
        let [a, b] = edge.map(number);
        let mut of = *self;
        if a > b {
            of.crossing.fraction = 1.0 - of.crossing.fraction;
            of.crossing.positive = !of.crossing.positive;
            of.forward = !of.forward;
        }
        ([a.min(b), a.max(b)], of)
    }
}

impl Topology {
    /// Takes those out of what waits that are at no element any more in which the blade is.
    pub(crate) fn due(&self, stroke: &mut Stroke, blade: &Blade) -> BTreeMap<[u32; 2], Crossing> {
        let Blade::Sweep { sweeps, now, .. } = blade else {
            return self.all_due(stroke);
        };
        self.drop_unknown(stroke);
        let mut due = BTreeMap::new();
        stroke.waiting.retain(|edge, waiting| {
            let is_in = |element: u32| {
                let corners = self.tets[element as usize].map(|node| now[node as usize]);
                sweeps
                    .iter()
                    .any(|Sweep { now, .. }| reaches(now, &corners))
            };
            let waits = self.elements_at_edge(*edge).any(is_in);
            if !waits {
                due.insert(*edge, waiting.crossing);
            }
            waits
        });
        due
    }

    /// Takes all that waits, as the blade is gone.
    pub(crate) fn all_due(&self, stroke: &mut Stroke) -> BTreeMap<[u32; 2], Crossing> {
        self.drop_unknown(stroke);
        let waiting = std::mem::take(&mut stroke.waiting);
        let crossings = waiting.into_iter().map(|(edge, of)| (edge, of.crossing));
        crossings.collect()
    }

    /// What has no element any more, as another blade has divided it, waits no more.
    fn drop_unknown(&self, stroke: &mut Stroke) {
        let is_edge = |edge: &[u32; 2]| self.elements_at_edge(*edge).next().is_some();
        stroke.waiting.retain(|edge, _| is_edge(edge));
    }

    /// Whether an edge of one of two elements waits.
    pub(crate) fn is_waiting(&self, stroke: &Stroke, elements: [u32; 2]) -> bool {
        let waits = |element: u32| {
            let tet = self.tets[element as usize];
            let mut edges = crate::pattern::EDGES.iter();
            edges.any(|[i, j]| {
                let (a, b) = (tet[*i], tet[*j]);
                stroke.waiting.contains_key(&[a.min(b), a.max(b)])
            })
        };
        !stroke.waiting.is_empty() && elements.into_iter().any(waits)
    }
}

/// How near to an element a blade is in it, over its height: beyond rounding, and beyond the displacement of blades, so that what rests at a node has not left
/// the elements there.
const TOUCHING: f64 = 1e-6;

/// Whether a segment has a point in an element. An element that is turned inside out, or flat, has no inside.
fn reaches([a, b]: &[Vector3<f64>; 2], corners: &[Vector3<f64>; 4]) -> bool {
    let volume = |p: [&Vector3<f64>; 4]| (p[1] - p[0]).cross(&(p[2] - p[0])).dot(&(p[3] - p[0]));
    let [c0, c1, c2, c3] = corners;
    let whole = volume([c0, c1, c2, c3]);
    if whole <= 0.0 {
        return false;
    }
    let margin = TOUCHING * whole;
    // Barycentric coordinates times the volume are linear along the segment.
    let at = |p: &Vector3<f64>| {
        [
            volume([p, c1, c2, c3]),
            volume([c0, p, c2, c3]),
            volume([c0, c1, p, c3]),
            volume([c0, c1, c2, p]),
        ]
        .map(|part| part + margin)
    };
    let (mut first, mut last) = (0.0_f64, 1.0_f64);
    for (from, to) in at(a).into_iter().zip(at(b)) {
        match (from >= 0.0, to >= 0.0) {
            (true, true) => {}
            (false, false) => return false,
            (true, false) => last = last.min(from / (from - to)),
            (false, true) => first = first.max(from / (from - to)),
        }
    }
    first <= last
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The unit tetrahedron, and segments of which it is seen whether they come in.
    #[test]
    fn a_segment_reaches_into_an_element_or_passes_it() {
        let v = Vector3::new;
        let unit = [Vector3::zeros(), Vector3::x(), Vector3::y(), Vector3::z()];
        let through = [v(0.2, 0.2, -1.0), v(0.2, 0.2, 1.0)];
        let within = [v(0.2, 0.2, 0.2), v(0.1, 0.3, 0.2)];
        let ends_before = [v(0.2, 0.2, -1.0), v(0.2, 0.2, -0.01)];
        // In front of the slanted face, where x + y + z > 1.
        let beside = [v(0.6, 0.6, -1.0), v(0.6, 0.6, 1.0)];
        assert!(reaches(&through, &unit) && reaches(&within, &unit));
        assert!(!reaches(&ends_before, &unit) && !reaches(&beside, &unit));
        let [a, b, c, d] = unit;
        assert!(!reaches(&through, &[a, c, b, d]), "turned inside out");
        // In the plane of a face, and off it by rounding.
        let [touching, off] = [0.0, -1e-16].map(|z| [v(-1.0, 0.2, z), v(1.0, 0.2, z)]);
        assert!(reaches(&touching, &unit) && reaches(&off, &unit));
    }
}
