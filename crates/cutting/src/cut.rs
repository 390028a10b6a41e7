//! A step of a cut: from the blade's path to the edit.

use crate::decide::{self, Decisions, Fate};
use crate::editor::Editor;
use crate::pattern::{self, PatternNode};
use crate::report::{Cut, Rejected};
use crate::sheet::{Crossing, Sheet};
use crate::stroke::Stroke;
use crate::sweep::Sweep;
use crate::topology::{Child, Topology};
use microsim_geometry::Aabb;
use microsim_mesh::TetMesh;
use nalgebra::Vector3;
use std::collections::{BTreeMap, BTreeSet};

/// Limits of a cut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Edges are divided no nearer to an end than this share (NUMERICS 3.5 a).
    pub least_share: f64,
    /// No division leaves a part of an edge shorter than this share of the mean edge of the whole mesh.
    pub least_edge: f64,
    /// No division leaves an element with less than this share of the mean volume of the whole mesh (NUMERICS 3.5 e).
    pub least_volume: f64,
    /// What comes off with less than this share of the mean volume is a crumb and is taken away.
    pub crumb_volume: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            least_share: 0.15,
            least_edge: 0.01,
            least_volume: 1e-4,
            crumb_volume: 1e-3,
        }
    }
}

/// A blade and the nodes around it.
#[derive(Clone, Copy, Debug)]
pub enum Blade<'a> {
    /// A sheet through nodes that stand still.
    Sheet {
        /// The sheet.
        sheet: &'a Sheet,
        /// Where the nodes are [m].
        positions: &'a [Vector3<f64>],
    },
    /// A blade that moves, through nodes that move.
    Sweep {
        /// The blade.
        sweep: &'a Sweep,
        /// Where the nodes were before the step [m].
        before: &'a [Vector3<f64>],
        /// Where they are after it [m].
        now: &'a [Vector3<f64>],
    },
}

impl Blade<'_> {
    fn now(&self) -> &[Vector3<f64>] {
        match self {
            Self::Sheet { positions, .. } => positions,
            Self::Sweep { now, .. } => now,
        }
    }

    fn check(&self, nodes: usize) -> Result<(), Rejected> {
        let all = |points: &[Vector3<f64>]| points.iter().all(|p| p.iter().all(|x| x.is_finite()));
        let count = |positions: &[Vector3<f64>]| {
            let count = positions.len();
            if count == nodes {
                Ok(())
            } else {
                Err(Rejected::Positions {
                    nodes,
                    positions: count,
                })
            }
        };
        match self {
            Self::Sheet { sheet, positions } => {
                count(positions)?;
                if !all(&sheet.points) {
                    return Err(Rejected::NotFinite);
                }
                let has_area = |t: usize| {
                    let [a, b, c] = sheet.corners(t);
                    (b - a).cross(&(c - a)) != Vector3::zeros()
                };
                if !(0..sheet.triangles.len()).any(has_area) {
                    return Err(Rejected::NoBlade);
                }
            }
            Self::Sweep { sweep, before, now } => {
                count(before)?;
                count(now)?;
                if !all(&sweep.before) || !all(&sweep.now) {
                    return Err(Rejected::NotFinite);
                }
                if sweep.before[0] == sweep.before[1] && sweep.now[0] == sweep.now[1] {
                    return Err(Rejected::NoBlade);
                }
            }
        }
        Ok(())
    }
}

impl Topology {
    /// Cuts where the blade passes in this step. `None` when it divides and opens nothing.
    ///
    /// The topology is then that of the next generation, and so is the stroke; [`Cut::edit`] takes the mesh there. Crossed edges are
    /// divided for all elements at them, so the mesh is conforming after every step, with the blade inside too. Open is what the
    /// blade has passed: faces with all nodes on its path and elements on both sides. Where it has gone only part of the way
    /// through an element the element is divided and holds together until the blade has passed it.
    pub fn cut(
        &mut self,
        mesh: &TetMesh,
        stroke: &mut Stroke,
        blade: &Blade,
        settings: &Settings,
    ) -> Result<Option<Cut>, Rejected> {
        if mesh.generation != self.generation {
            return Err(Rejected::Generation {
                mesh: mesh.generation,
                topology: self.generation,
            });
        }
        blade.check(mesh.positions.len())?;
        let mut crossings = self.crossings(blade)?;
        if crossings.is_empty() {
            return Ok(None);
        }
        if stroke.sheet == 0 {
            self.sheets += 1;
            stroke.sheet = self.sheets;
        }
        orient(stroke, &mut crossings, matches!(blade, Blade::Sweep { .. }));
        let crossed = crossings.len();
        let decisions = decide::decide(self, mesh, stroke, crossings, settings);
        self.learn_sides(stroke, &decisions);
        let mut cut = self.carry_out(mesh, stroke, blade.now(), &decisions, settings);
        if let Some(cut) = &mut cut {
            stroke.leave(&cut.edit, mesh.positions.len(), mesh.tets.len());
            cut.crossed = crossed;
            cut.clamped = decisions.clamped;
            cut.joined = decisions.joined;
            cut.snapped = decisions.snapped;
            cut.dropped = decisions.dropped;
        }
        Ok(cut)
    }

    /// The crossed edges, smaller node first.
    fn crossings(&self, blade: &Blade) -> Result<BTreeMap<[u32; 2], Crossing>, Rejected> {
        let finite = |p: &Vector3<f64>| p.iter().all(|x| x.is_finite());
        let mut crossings = BTreeMap::new();
        match blade {
            Blade::Sheet { sheet, positions } => {
                let sheet = sheet.displaced(self.mean_edge);
                let (bounds, boxes) = (sheet.bounds(), sheet.triangle_bounds());
                for [a, b] in self.edges_near(&bounds, [positions, positions]) {
                    let [u, v] = [a, b].map(|n| &positions[n as usize]);
                    if !finite(u) || !finite(v) {
                        return Err(Rejected::NotFinite);
                    }
                    if let Some(crossing) = sheet.crossing(u, v, &boxes) {
                        crossings.insert([a, b], crossing);
                    }
                }
            }
            Blade::Sweep { sweep, before, now } => {
                let sweep = sweep.displaced(self.mean_edge);
                for edge in self.edges_near(&sweep.bounds(), [before, now]) {
                    let motion = Sweep {
                        before: edge.map(|n| before[n as usize]),
                        now: edge.map(|n| now[n as usize]),
                    };
                    if !motion.before.iter().chain(&motion.now).all(finite) {
                        return Err(Rejected::NotFinite);
                    }
                    if let Some(crossing) = sweep.crossing(&motion) {
                        crossings.insert(edge, crossing);
                    }
                }
            }
        }
        Ok(crossings)
    }

    /// Every edge, smaller node first and ascending, whose way in the step comes into `bounds`.
    fn edges_near(&self, bounds: &Aabb, positions: [&[Vector3<f64>]; 2]) -> Vec<[u32; 2]> {
        let around = |nodes: &[u32]| {
            let places = nodes.iter().map(|&n| n as usize);
            Aabb::of(places.flat_map(|n| [&positions[0][n], &positions[1][n]]))
        };
        let mut edges = Vec::new();
        self.clusters.near(bounds, &self.tets, positions, |element| {
            let tet = self.tets[element as usize];
            for [i, j] in pattern::EDGES {
                edges.push([tet[i].min(tet[j]), tet[i].max(tet[j])]);
            }
        });
        edges.sort_unstable();
        edges.dedup();
        // Not a number is near everything: it is found out later.
        edges.retain(|edge| {
            let around = around(edge);
            !around.is_valid() || around.overlaps(bounds)
        });
        edges
    }

    /// Enters into the stroke on which sides the ends of crossed edges lie.
    fn learn_sides(&self, stroke: &mut Stroke, decisions: &Decisions) {
        for (edge, crossed) in &decisions.edges {
            let side = if crossed.crossing.positive { 1 } else { -1 };
            for element in self.elements_at_edge(*edge) {
                let sides = stroke.sides.entry(element).or_default();
                for (k, node) in self.tets[element as usize].iter().enumerate() {
                    if *node == edge[0] {
                        sides[k] = -side;
                    } else if *node == edge[1] {
                        sides[k] = side;
                    }
                }
            }
        }
    }

    /// Divides and opens.
    fn carry_out(
        &mut self,
        mesh: &TetMesh,
        stroke: &mut Stroke,
        current: &[Vector3<f64>],
        decisions: &Decisions,
        settings: &Settings,
    ) -> Option<Cut> {
        let sheet = stroke.sheet;
        // Where faces may come apart: elements at crossed edges, their children, and all at nodes that have come onto the path.
        let mut touched: BTreeSet<u32> = BTreeSet::new();
        for (edge, crossed) in &decisions.edges {
            touched.extend(self.elements_at_edge(*edge));
            if let Fate::Kept(node) = crossed.fate
                && stroke.path.insert(node)
            {
                touched.extend(self.elements_at(node));
            }
        }
        let mut editor = Editor::new(self, mesh, current);
        let mut new_nodes: BTreeMap<[u32; 2], u32> = BTreeMap::new();
        for (edge, crossed) in &decisions.edges {
            if let Fate::Divided(share) = crossed.fate {
                let node = editor.next_node();
                editor.add_node(*edge, share);
                new_nodes.insert(*edge, node);
                stroke.path.insert(node);
            }
        }
        let mut replaced = Vec::with_capacity(decisions.elements.len());
        let mut next = mesh.tets.len() as u32;
        for (&element, &set) in &decisions.elements {
            let tet = editor.topology.tets[element as usize];
            let marks = editor.topology.marks[element as usize];
            let sides = stroke.sides_of(element);
            let ids = tet.map(|n| mesh.node_ids[n as usize]);
            let mut children = Vec::new();
            for (k, child) in pattern::divide(set, ids).into_iter().enumerate() {
                let slot = if k == 0 {
                    element
                } else {
                    next += 1;
                    next - 1
                };
                let node = |[i, j]: PatternNode| {
                    let (a, b) = (tet[i as usize], tet[j as usize]);
                    if i == j {
                        a
                    } else {
                        new_nodes[&[a.min(b), a.max(b)]]
                    }
                };
                children.push(Child {
                    corners: child.map(node),
                    marks: child_marks(&child, &marks),
                });
                stroke.sides.insert(slot, child.map(|[near, _]| sides[near as usize]));
                touched.insert(slot);
            }
            replaced.push((element, children));
        }
        editor.divide(&replaced);
        give_flat_ones(editor.topology, stroke, &touched);
        let faces = faces_to_open(editor.topology, stroke, &touched);
        for [node, copy] in editor.open(&faces, sheet) {
            if stroke.path.contains(&node) {
                stroke.path.insert(copy);
            }
        }
        editor.conclude(settings)
    }
}

/// Marks of a child's faces: of one that lies on a face of the parent that of the face.
fn child_marks(child: &[PatternNode; 4], marks: &[u32; 4]) -> [u32; 4] {
    std::array::from_fn(|k| {
        let others = || (0..4).filter(|&i| i != k).map(|i| child[i]);
        let lies_on = |face: &usize| others().all(|node| node.iter().all(|&c| c as usize != *face));
        (0..4).find(lies_on).map_or(0, |face| marks[face])
    })
}

/// The inner faces of `elements` that the blade has passed: all nodes on the path, and the elements not on the same side. Each
/// once, with whether the element is on the negative side.
fn faces_to_open(
    topology: &Topology,
    stroke: &Stroke,
    elements: &BTreeSet<u32>,
) -> Vec<(u32, usize, bool)> {
    let mut faces = Vec::new();
    for &element in elements {
        for (corner, other) in closed_faces(topology, element) {
            let face = topology.face(element, corner);
            let once = other > element || !elements.contains(&other);
            if once && face.iter().all(|node| stroke.path.contains(node)) {
                let mine = side(topology, stroke, element, corner);
                let theirs = side(topology, stroke, other, topology.back(element, other));
                if mine != theirs {
                    faces.push((element, corner, mine < theirs));
                }
            }
        }
    }
    faces
}

/// The inner faces of an element that no sheet has passed: opposite corner, and element across.
fn closed_faces(topology: &Topology, element: u32) -> impl Iterator<Item = (usize, u32)> + '_ {
    (0..4).filter_map(move |corner| {
        let other = topology.neighbour(element, corner)?;
        let is_closed = topology.marks[element as usize][corner] == 0;
        is_closed.then_some((corner, other))
    })
}

/// The side on which an element lies that has its face opposite to `corner` on the path: that of the corner; of an element with all
/// corners on the path the one to which it was given.
fn side(topology: &Topology, stroke: &Stroke, element: u32, corner: usize) -> i8 {
    let node = topology.tets[element as usize][corner];
    if stroke.path.contains(&node) {
        stroke.given.get(&element).copied().unwrap_or_default()
    } else {
        stroke.sides_of(element)[corner]
    }
}

/// Elements with all corners on the path lie in the cut itself, as flat as what was clamped leaves them. They are given to a side
/// that they have a face to, together with all such that they hang together with: so nothing comes off that the blade has not
/// cut out.
fn give_flat_ones(topology: &Topology, stroke: &mut Stroke, elements: &BTreeSet<u32>) {
    let is_flat = |stroke: &Stroke, element: u32| {
        let tet = &topology.tets[element as usize];
        tet.iter().all(|node| stroke.path.contains(node)) && !stroke.given.contains_key(&element)
    };
    for &start in elements {
        if !is_flat(stroke, start) {
            continue;
        }
        let mut group = vec![start];
        let mut votes = 0;
        let mut next = 0;
        while let Some(&element) = group.get(next) {
            next += 1;
            votes += stroke.sides_of(element).iter().sum::<i8>().signum() as i32;
            for (_, other) in closed_faces(topology, element) {
                if !is_flat(stroke, other) {
                    // One face weighs more than what the group itself was divided from.
                    let theirs = side(topology, stroke, other, topology.back(element, other));
                    votes += 1000 * i32::from(theirs);
                } else if !group.contains(&other) {
                    group.push(other);
                }
            }
        }
        let given = if votes < 0 { -1 } else { 1 };
        stroke.given.extend(group.into_iter().map(|e| (e, given)));
    }
}

/// Gives all crossings the same positive side as the stroke has so far: a blade that turns back would exchange the sides.
fn orient(stroke: &mut Stroke, crossings: &mut BTreeMap<[u32; 2], Crossing>, turn: bool) {
    let mut sum = Vector3::zeros();
    for crossing in crossings.values_mut() {
        let length = crossing.normal.norm();
        if length == 0.0 {
            continue;
        }
        let mut normal = crossing.normal / length;
        let reference = if stroke.normal == Vector3::zeros() {
            sum
        } else {
            stroke.normal
        };
        if turn && normal.dot(&reference) < 0.0 {
            crossing.positive = !crossing.positive;
            normal = -normal;
            crossing.normal = -crossing.normal;
        }
        sum += normal;
    }
    let length = sum.norm();
    if length > 0.0 {
        stroke.normal = sum / length;
    }
}

#[cfg(test)]
mod tests;
