//! What becomes of each crossed edge: divided where both parts leave valid elements, or left whole with one of its nodes on the path.
//!
//! Every decision is that of an edge or a face alone, so all elements at it agree. Whatever is decided, a crossed edge has a
//! node on the path in the end: no path along edges joins both sides without it.

use crate::change::TopologyChange;
use crate::crossing::Crossing;
use crate::pattern::{self, EDGES, EdgeSet, PatternNode};
use crate::settings::Settings;
use crate::stroke::Stroke;
use crate::topology::{FACES, Topology};
use microsim_geometry::signed_volume;
use microsim_mesh::TetMesh;
use nalgebra::Vector3;
use std::collections::{BTreeMap, BTreeSet};

/// A blade that comes so near to a node, relative to the crossed edge, goes through it: no plane through nodes is off by more, in
/// coordinates that were computed.
const TOUCHING: f64 = 1e-6;

/// What becomes of a crossed edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Fate {
    /// A new node at this fraction of the edge.
    Divided(f64),
    /// This node of it is on the path.
    Retained(u32),
}

/// A crossed edge, smaller node first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct CrossedEdge {
    pub crossing: Crossing,
    pub fate: Fate,
}

/// The crossed edges of a step, and how many were treated how.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Decisions {
    pub edges: BTreeMap<[u32; 2], CrossedEdge>,
    /// Elements to divide, with their divided edges.
    pub elements: BTreeMap<u32, EdgeSet>,
    /// Fractions that were clamped.
    pub clamped: usize,
    /// Left as they are, nearer to a node that the path has parted.
    pub followed: usize,
    /// Left whole, as an end is on the path already, or the blade goes through it.
    pub joined: usize,
    /// Left whole with the nearer end on the path, as division would leave an element or a part of the edge too small.
    pub snapped: usize,
    /// Left whole with the nearer end on the path, as all edges of a face were crossed.
    pub dropped: usize,
}

/// Decides for all crossings of a step.
pub(crate) fn decide(
    topology: &Topology,
    mesh: &TetMesh,
    stroke: &Stroke,
    crossings: BTreeMap<[u32; 2], Crossing>,
    settings: &Settings,
) -> Decisions {
    let mut decisions = Decisions::default();
    let beside = match settings.change {
        // The mesh comes apart at what is nearest anyway.
        TopologyChange::SplitAtFaces => BTreeSet::new(),
        _ => nodes_beside(topology, mesh, stroke, &crossings, settings),
    };
    // Of edges that wait the path may have parted a node after it crossed them.
    let waits = settings.change == TopologyChange::SemiProgressive;
    for (edge, crossing) in crossings {
        if !waits && follows_own_cut(topology, stroke, edge, &crossing) {
            decisions.followed += 1;
            continue;
        }
        let fate = first_fate(
            topology,
            mesh,
            stroke,
            edge,
            &crossing,
            &beside,
            settings,
            &mut decisions,
        );
        decisions.edges.insert(edge, CrossedEdge { crossing, fate });
    }
    decisions.legalise(topology, mesh);
    decisions.keep_elements_sound(topology, mesh, settings);
    let divided = decisions.edges.values().filter_map(|e| match e.fate {
        Fate::Divided(fraction) => Some((fraction, e.crossing.fraction)),
        Fate::Retained(_) => None,
    });
    decisions.clamped = divided.filter(|(used, found)| used != found).count();
    decisions
}

/// Whether a node is on the path, or on the edge of an older cut.
fn is_on_path(topology: &Topology, stroke: &Stroke, node: u32) -> bool {
    stroke.is_on_path(node) || topology.front.contains(&node)
}

/// Whether an edge is crossed nearer to a node that this path has parted already: the blade follows its own cut, as where a vessel swings back between
/// blades that still close, and would take a tooth off its lip.
fn follows_own_cut(
    topology: &Topology,
    stroke: &Stroke,
    edge: [u32; 2],
    crossing: &Crossing,
) -> bool {
    let node = nearer(crossing, edge);
    stroke.is_on_path(node) && !topology.front.contains(&node)
}

/// The nodes beside the path that it goes through instead: ends nearer than the least fraction to where an edge is crossed, the nearest first. Not those that would be the last
/// corner of an element to come onto the path, as far as is known yet: what lies in the cut itself hangs on one of its lips as a tooth.
fn nodes_beside(
    topology: &Topology,
    mesh: &TetMesh,
    stroke: &Stroke,
    crossings: &BTreeMap<[u32; 2], Crossing>,
    settings: &Settings,
) -> BTreeSet<u32> {
    let mut near: Vec<(f64, u32)> = Vec::new();
    for (&edge, crossing) in crossings {
        let distance = crossing.fraction.min(1.0 - crossing.fraction);
        if distance < settings.least_fraction
            && !edge.iter().any(|&n| is_on_path(topology, stroke, n))
        {
            near.push((distance, nearer(crossing, edge)));
        }
    }
    let id = |node: u32| mesh.node_ids[node as usize];
    near.sort_by(|a, b| a.0.total_cmp(&b.0).then_with(|| id(a.1).cmp(&id(b.1))));
    let mut beside = BTreeSet::new();
    for (_, node) in near {
        let is_free = |corner: &&u32| {
            **corner != node && !beside.contains(*corner) && !is_on_path(topology, stroke, **corner)
        };
        let mut elements = topology.elements_at(node).iter();
        if elements.all(|&element| topology.tets[element as usize].iter().any(|n| is_free(&n))) {
            beside.insert(node);
        }
    }
    beside
}

#[expect(clippy::too_many_arguments, reason = "what decides of an edge")]
fn first_fate(
    topology: &Topology,
    mesh: &TetMesh,
    stroke: &Stroke,
    edge: [u32; 2],
    crossing: &Crossing,
    beside: &BTreeSet<u32>,
    settings: &Settings,
    decisions: &mut Decisions,
) -> Fate {
    let least = settings.least_fraction;
    let fraction = crossing.fraction.clamp(least, 1.0 - least);
    let on_path = edge.map(|node| is_on_path(topology, stroke, node));
    // An end that lies on the other side as was found when the blade passed it: the path has come around it.
    let contradicts =
        |end: usize| crossing.is_certain && stroke.side(edge[end]) == -crossing.side_of_end(end);
    let end = match (on_path, [contradicts(0), contradicts(1)]) {
        ([true, true], _) => Some(nearer(crossing, edge)),
        ([false, false], [true, false]) => Some(edge[0]),
        ([false, false], [false, true]) => Some(edge[1]),
        ([false, false], _) => {
            let touched = crossing.fraction.min(1.0 - crossing.fraction) <= TOUCHING;
            touched.then(|| nearer(crossing, edge))
        }
        // The path goes on past its own node.
        ([true, false], [_, second]) => Some(edge[usize::from(second)]),
        ([false, true], [first, _]) => Some(edge[usize::from(!first)]),
    };
    if let Some(node) = end {
        decisions.joined += 1;
        return Fate::Retained(node);
    }
    let [a, b] = edge.map(|n| mesh.positions[n as usize]);
    let is_short = (b - a).norm() < settings.least_edge * topology.mean_edge;
    let node = match edge.map(|node| beside.contains(&node)) {
        [true, false] => Some(edge[0]),
        [false, true] => Some(edge[1]),
        [true, true] => Some(nearer(crossing, edge)),
        _ if is_short || settings.change == TopologyChange::SplitAtFaces => {
            Some(nearer(crossing, edge))
        }
        _ => None,
    };
    match node {
        Some(node) => {
            decisions.snapped += 1;
            Fate::Retained(node)
        }
        None => Fate::Divided(fraction),
    }
}

/// The end nearer to a crossing.
fn nearer(crossing: &Crossing, [a, b]: [u32; 2]) -> u32 {
    if crossing.fraction <= 0.5 { a } else { b }
}

impl Decisions {
    /// The divided edges of an element.
    fn divided(&self, tet: &[u32; 4]) -> EdgeSet {
        let divided = EDGES.iter().enumerate().filter(|(_, [i, j])| {
            let edge = [tet[*i].min(tet[*j]), tet[*i].max(tet[*j])];
            matches!(self.edges.get(&edge), Some(e) if matches!(e.fate, Fate::Divided(_)))
        });
        divided.fold(0, |set, (k, _)| set | 1 << k)
    }

    /// Keeps the edge with the nearer end on the path; the elements at it.
    fn keep(&mut self, edge: [u32; 2]) {
        if let Some(crossed) = self.edges.get_mut(&edge) {
            crossed.fate = Fate::Retained(nearer(&crossed.crossing, edge));
        }
    }

    /// Where all three edges of a face would be divided (NUMERICS 4.7), the one crossed nearest to an end is left whole.
    fn legalise(&mut self, topology: &Topology, mesh: &TetMesh) {
        let mut elements = BTreeSet::new();
        for (edge, crossed) in &self.edges {
            if matches!(crossed.fate, Fate::Divided(_)) {
                elements.extend(topology.elements_at_edge(*edge));
            }
        }
        let mut faces = BTreeSet::new();
        for &element in &elements {
            let tet = topology.tets[element as usize];
            if self.divided(&tet).count_ones() >= 3 {
                for face in FACES {
                    let mut nodes = face.map(|k| tet[k]);
                    nodes.sort_unstable();
                    faces.insert(nodes);
                }
            }
        }
        for [a, b, c] in faces {
            let edges = [[a, b], [a, c], [b, c]];
            let divided = |edge: &[u32; 2]| {
                let crossed = self.edges.get(edge)?;
                matches!(crossed.fate, Fate::Divided(_)).then_some(crossed.crossing.fraction)
            };
            let fractions = edges.each_ref().map(divided);
            if fractions.iter().any(Option::is_none) {
                continue;
            }
            let distance = |k: usize| fractions[k].map_or(1.0, |s| s.min(1.0 - s));
            let ids = |k: usize| edges[k].map(|n| mesh.node_ids[n as usize]);
            let first = (0..3).min_by(|&i, &j| {
                distance(i)
                    .total_cmp(&distance(j))
                    .then(ids(i).cmp(&ids(j)))
            });
            if let Some(k) = first {
                self.keep(edges[k]);
                self.dropped += 1;
            }
        }
        for element in elements {
            let set = self.divided(&topology.tets[element as usize]);
            if set != 0 {
                self.elements.insert(element, set);
            }
        }
    }

    /// As long as a child would have too little volume, the shortest part of an edge of its parent is not made.
    fn keep_elements_sound(&mut self, topology: &Topology, mesh: &TetMesh, settings: &Settings) {
        let least = settings.least_volume * topology.mean_volume;
        let mut open: BTreeSet<u32> = self.elements.keys().copied().collect();
        while let Some(element) = open.pop_first() {
            let Some(&set) = self.elements.get(&element) else {
                continue;
            };
            let tet = topology.tets[element as usize];
            let ids = tet.map(|n| mesh.node_ids[n as usize]);
            let corners = tet.map(|n| mesh.positions[n as usize]);
            let place = |[i, j]: PatternNode| -> Vector3<f64> {
                let (i, j) = (i as usize, j as usize);
                self.new_place(&tet, &corners, i, j)
            };
            let is_valid = pattern::divide(set, ids).iter().all(|child| {
                let [a, b, c, d] = child.map(place);
                signed_volume(&a, &b, &c, &d) > least
            });
            if is_valid {
                continue;
            }
            let part = |k: usize| {
                let [i, j] = EDGES[k];
                let edge = [tet[i].min(tet[j]), tet[i].max(tet[j])];
                let fraction = self.edges[&edge].crossing.fraction;
                let length = (corners[j] - corners[i]).norm();
                (edge, fraction.min(1.0 - fraction) * length)
            };
            let parts = (0..6).filter(|k| set & 1 << k != 0).map(part);
            let shortest = parts.min_by(|a, b| {
                let ids = |edge: &[u32; 2]| edge.map(|n| mesh.node_ids[n as usize]);
                a.1.total_cmp(&b.1).then(ids(&a.0).cmp(&ids(&b.0)))
            });
            let Some((edge, _)) = shortest else { continue };
            self.keep(edge);
            self.snapped += 1;
            for other in topology.elements_at_edge(edge) {
                let set = self.divided(&topology.tets[other as usize]);
                if set == 0 {
                    self.elements.remove(&other);
                } else {
                    self.elements.insert(other, set);
                    open.insert(other);
                }
            }
        }
    }

    /// Rest place of a node of a pattern: a corner, or the new node on an edge.
    fn new_place(
        &self,
        tet: &[u32; 4],
        corners: &[Vector3<f64>; 4],
        i: usize,
        j: usize,
    ) -> Vector3<f64> {
        if i == j {
            return corners[i];
        }
        let (low, high) = if tet[i] < tet[j] { (i, j) } else { (j, i) };
        match self.edges.get(&[tet[low], tet[high]]).map(|e| e.fate) {
            Some(Fate::Divided(fraction)) => {
                corners[low] + (corners[high] - corners[low]) * fraction
            }
            _ => corners[i],
        }
    }
}
