//! A step of a cut: from the blade's path to the edit.

use crate::blade::Blade;
use crate::change::TopologyChange;
use crate::crossing::Crossing;
use crate::decide::{self, Decisions, Fate};
use crate::editor::Editor;
use crate::mend;
use crate::opening;
use crate::pattern::{self, PatternNode};
use crate::report::{Cut, Rejected};
use crate::settings::Settings;
use crate::stroke::Stroke;
use crate::sweep::Sweep;
use crate::topology::{Child, Topology};
use microsim_geometry::{Aabb, closest_on_segment};
use microsim_mesh::TetMesh;
use nalgebra::Vector3;
use std::collections::{BTreeMap, BTreeSet};

/// Distance of a blade from all nodes, over the mean edge, at which it has left the tissue: beyond what a tremor draws it out and in again.
const CLEAR: f64 = 1.5;

impl Topology {
    /// Cuts where the blade passes in this step. `None` when it divides and opens nothing.
    ///
    /// The topology is then that of the next generation, and so is the stroke; [`Cut::edit`] takes the mesh there. Crossed edges are
    /// divided for all elements at them, so the mesh is conforming after every step, with the blade inside too. Open is what the
    /// blade has passed: faces with all nodes on its path and elements on both sides. Where it has gone only in part
    /// through an element the element is divided and holds together until the blade has passed it.
    ///
    /// ```
    /// use microsim_cutting::{Blade, Settings, Sheet, Stroke, Topology, check};
    /// use microsim_mesh::{Block, CellSplit};
    /// use nalgebra::Vector3;
    ///
    /// let block = Block { center: [0.0; 3], size: [4.0, 2.0, 2.0], cells: [4, 2, 2], split: CellSplit::Kuhn };
    /// let mut mesh = block.mesh()?;
    /// let mut topology = Topology::new(&mesh);
    /// // The plane x = 0.3, in one step.
    /// let corner = |y: f64, z: f64| Vector3::new(0.3, y, z);
    /// let sheet = Sheet::quad([corner(-2.0, -2.0), corner(2.0, -2.0)], [corner(-2.0, 2.0), corner(2.0, 2.0)]);
    /// let positions = mesh.positions.clone();
    /// let blade = Blade::Sheet { sheet: &sheet, positions: &positions };
    /// let cut = topology.cut(&mesh, &mut Stroke::new(), &blade, &Settings::default())?;
    /// let cut = cut.expect("the blade goes through");
    /// mesh.apply(&cut.edit)?;
    /// // One part has come off, along an area of 2 × 2.
    /// assert_eq!(cut.pieces.len(), 1);
    /// assert!((cut.opened[0].area - 4.0).abs() < 1e-9);
    /// assert!(check(&mesh, &topology).is_ok());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
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
            let Some(near) = self.go_on(stroke, blade) else {
                return Ok(None);
            };
            let due = self.due(stroke, blade);
            if due.is_empty() {
                return Ok(self.pass_by(mesh, stroke, blade, &near, settings));
            }
            self.remember_swept(&stroke.across, blade);
            return Ok(self.make(mesh, stroke, blade, due, settings));
        }
        if stroke.sheet == 0 {
            self.sheets += 1;
            stroke.sheet = self.sheets;
        }
        if matches!(blade, Blade::Sweep { .. }) {
            let normals = crossings.values().map(|crossing| crossing.normal);
            let normal = normals.sum::<Vector3<f64>>() / crossings.len() as f64;
            stroke.advance_by(&normal, self.mean_edge);
            if settings.change != TopologyChange::Remove {
                self.remember_swept(&stroke.across, blade);
            }
            let forward = crossings.iter().map(|(edge, of)| (*edge, of.positive));
            let forward = forward.collect();
            orient(stroke, &mut crossings, blade.now());
            if settings.change == TopologyChange::SemiProgressive {
                self.add_points(mesh, stroke, &crossings);
                stroke.hold(crossings, &forward);
                let due = self.due(stroke, blade);
                return Ok(self.make(mesh, stroke, blade, due, settings));
            }
        } else {
            let normals = crossings.values().map(|crossing| crossing.normal);
            stroke.across = normals.filter_map(|normal| normal.try_normalize(0.0)).sum();
        }
        self.add_points(mesh, stroke, &crossings);
        if settings.change == TopologyChange::Remove {
            return self.take_away(mesh, stroke, blade.now(), &crossings, settings);
        }
        Ok(self.make(mesh, stroke, blade, crossings, settings))
    }

    /// Cuts what waits in a stroke whose blade is gone; nodes are now at `current` \[m\]. `None` when nothing waits, as with all but
    /// [`TopologyChange::SemiProgressive`].
    pub fn conclude_stroke(
        &mut self,
        mesh: &TetMesh,
        stroke: &mut Stroke,
        current: &[Vector3<f64>],
        settings: &Settings,
    ) -> Option<Cut> {
        let due = self.all_due(stroke);
        let blade = Blade::Sweep {
            sweeps: &[],
            before: current,
            now: current,
        };
        self.make(mesh, stroke, &blade, due, settings)
    }

    /// Remembers where crossed edges were crossed, at rest.
    fn add_points(
        &self,
        mesh: &TetMesh,
        stroke: &mut Stroke,
        crossings: &BTreeMap<[u32; 2], Crossing>,
    ) {
        for ([a, b], crossing) in crossings {
            let [a, b] = [a, b].map(|n| mesh.positions[*n as usize]);
            stroke.points.add(&a.lerp(&b, crossing.fraction));
        }
    }

    /// Makes a cut of crossed edges.
    fn make(
        &mut self,
        mesh: &TetMesh,
        stroke: &mut Stroke,
        blade: &Blade,
        crossings: BTreeMap<[u32; 2], Crossing>,
        settings: &Settings,
    ) -> Option<Cut> {
        if crossings.is_empty() {
            return None;
        }
        let crossed = crossings.len();
        let decisions = decide::decide(self, mesh, stroke, crossings, settings);
        let mut cut = self.carry_out(mesh, stroke, blade, &decisions, settings)?;
        stroke.leave(&cut.edit, mesh.positions.len());
        if cut.opened[0].area > 0.0 {
            cut.points = std::mem::take(&mut stroke.points);
        }
        cut.crossed = crossed;
        cut.clamped = decisions.clamped;
        cut.followed = decisions.followed;
        cut.joined = decisions.joined;
        cut.snapped = decisions.snapped;
        cut.dropped = decisions.dropped;
        Some(cut)
    }

    /// The edges that a blade crosses in this step, smaller node first, and where on each, from 0 to 1. Nothing is cut.
    pub fn crossed(&mut self, blade: &Blade) -> Result<Vec<([u32; 2], f64)>, Rejected> {
        let crossings = self.crossings(blade)?.into_iter();
        Ok(crossings.map(|(edge, of)| (edge, of.fraction)).collect())
    }

    /// The crossed edges, smaller node first.
    fn crossings(&mut self, blade: &Blade) -> Result<BTreeMap<[u32; 2], Crossing>, Rejected> {
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
            Blade::Sweep {
                sweeps,
                before,
                now,
            } => {
                for sweep in *sweeps {
                    let sweep = sweep.displaced(self.mean_edge);
                    for edge in self.edges_near(&sweep.bounds(), [before, now]) {
                        let motion = Sweep {
                            before: edge.map(|n| before[n as usize]),
                            now: edge.map(|n| now[n as usize]),
                        };
                        if !motion.before.iter().chain(&motion.now).all(finite) {
                            return Err(Rejected::NotFinite);
                        }
                        // What two parts cross is cut once.
                        if let Some(crossing) = sweep.crossing(&motion) {
                            crossings.entry(edge).or_insert(crossing);
                        }
                    }
                }
            }
        }
        Ok(crossings)
    }

    /// A step in which the blade crosses nothing: its motion relative to the tissue around it, of which the nodes are given back; `None` of a sheet.
    fn go_on(&mut self, stroke: &mut Stroke, blade: &Blade) -> Option<BTreeSet<u32>> {
        let Blade::Sweep {
            sweeps,
            before,
            now,
        } = blade
        else {
            return None;
        };
        let reach = CLEAR * self.mean_edge;
        let mut near: BTreeSet<u32> = BTreeSet::new();
        for Sweep { now: [a, b], .. } in *sweeps {
            let bounds = Aabb::of(&[*a, *b]).inflated(reach);
            self.elements_near(&bounds, [now, now], |_, tet| {
                let is_near = |&&node: &&u32| {
                    let place = now[node as usize];
                    (closest_on_segment(&place, a, b).point - place).norm() < reach
                };
                near.extend(tet.iter().filter(is_near));
            });
        }
        let motion = |node: usize| now[node] - before[node];
        let tissue: Vector3<f64> = if near.is_empty() {
            (0..now.len()).map(motion).sum::<Vector3<f64>>() / now.len().max(1) as f64
        } else {
            near.iter()
                .map(|&node| motion(node as usize))
                .sum::<Vector3<f64>>()
                / near.len() as f64
        };
        let across = sweeps
            .iter()
            .map(|sweep| sweep.displacement_across(&tissue));
        let normal = across.sum::<Vector3<f64>>() / sweeps.len().max(1) as f64;
        stroke.advance_by(&normal, self.mean_edge);
        Some(near)
    }

    /// After a step in which the blade crosses nothing: whether it has left the tissue, and bridges.
    fn pass_by(
        &mut self,
        mesh: &TetMesh,
        stroke: &mut Stroke,
        blade: &Blade,
        near: &BTreeSet<u32>,
        settings: &Settings,
    ) -> Option<Cut> {
        if stroke.sheet == 0 {
            return None;
        }
        if settings.change != TopologyChange::Remove {
            self.remember_swept(&stroke.across, blade);
        }
        let is_clear = near.is_empty();
        let mut mended = None;
        if is_clear || stroke.unseen > self.mean_edge {
            stroke.unseen = 0.0;
            mended = self.mend(mesh, stroke, blade.now(), near, settings);
        }
        if is_clear {
            stroke.end();
        }
        mended
    }

    /// Calls `found` with every element, and its nodes, whose path from the first to the second positions comes into `bounds` \[m\]. Its cost is proportional
    /// to what is there, but for a nanosecond per node.
    pub fn elements_near(
        &mut self,
        bounds: &Aabb,
        positions: [&[Vector3<f64>]; 2],
        mut found: impl FnMut(u32, &[u32; 4]),
    ) {
        let Self { clusters, tets, .. } = self;
        let found = |element: u32| found(element, &tets[element as usize]);
        clusters.near(bounds, self.mean_edge, tets, positions, found);
    }

    /// Every edge, smaller node first and ascending, whose path in the step comes into `bounds`.
    fn edges_near(&mut self, bounds: &Aabb, positions: [&[Vector3<f64>]; 2]) -> Vec<[u32; 2]> {
        let around = |nodes: &[u32]| {
            let places = nodes.iter().map(|&n| n as usize);
            Aabb::of(places.flat_map(|n| [&positions[0][n], &positions[1][n]]))
        };
        let mut edges = Vec::new();
        self.elements_near(bounds, positions, |_, tet| {
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

    /// Enters into the stroke on which sides the ends of crossed edges lie that are not on its path; the nodes of which that was not known. A node on
    /// the edge of an older cut lies on no side: the path may pass it on either, and would leave a bridge there.
    fn learn_sides(&self, stroke: &mut Stroke, decisions: &Decisions) -> Vec<u32> {
        let mut learned = Vec::new();
        for (edge, crossed) in &decisions.edges {
            if !crossed.crossing.is_certain {
                continue;
            }
            for (end, &node) in edge.iter().enumerate() {
                let is_free = !self.front.contains(&node);
                if is_free && stroke.learn(node, crossed.crossing.side_of_end(end)) {
                    learned.push(node);
                }
            }
        }
        learned
    }

    /// Nodes on the edges of older cuts that this one goes on from: corners of elements that its path comes to or goes through, and that it passes by on
    /// neither side. Without them a cut in several strokes would leave a bridge at each.
    fn continued(&self, stroke: &Stroke, elements: &BTreeSet<u32>) -> BTreeSet<u32> {
        let mut found = BTreeSet::new();
        for &element in elements {
            let tet = &self.tets[element as usize];
            let sides = tet.map(|node| stroke.side(node));
            let is_passed = sides.contains(&1) && sides.contains(&-1);
            if is_passed || tet.iter().any(|node| stroke.is_on_path(*node)) {
                let nodes = tet.iter().filter(|node| self.front.contains(node));
                found.extend(nodes.filter(|node| !stroke.nodes.contains_key(node)));
            }
        }
        found
    }

    /// Divides and opens.
    fn carry_out(
        &mut self,
        mesh: &TetMesh,
        stroke: &mut Stroke,
        blade: &Blade,
        decisions: &Decisions,
        settings: &Settings,
    ) -> Option<Cut> {
        let sheet = stroke.sheet;
        // Where faces may come apart: elements at crossed edges, their children, and all at nodes that have come onto the path.
        let mut touched: BTreeSet<u32> = BTreeSet::new();
        for (edge, crossed) in &decisions.edges {
            touched.extend(self.elements_at_edge(*edge));
            if let Fate::Retained(node) = crossed.fate
                && stroke.put_on_path(node)
            {
                touched.extend(self.elements_at(node));
                self.front.insert(node);
            }
        }
        for node in self.learn_sides(stroke, decisions) {
            touched.extend(self.elements_at(node));
        }
        for node in self.continued(stroke, &touched) {
            stroke.put_on_path(node);
            touched.extend(self.elements_at(node));
        }
        let mut editor = Editor::new(self, mesh, blade.now());
        let mut new_nodes: BTreeMap<[u32; 2], u32> = BTreeMap::new();
        for (edge, crossed) in &decisions.edges {
            if let Fate::Divided(fraction) = crossed.fate {
                let node = editor.next_node();
                editor.add_node(*edge, fraction);
                new_nodes.insert(*edge, node);
                stroke.put_on_path(node);
                editor.topology.front.insert(node);
            }
        }
        let mut replaced = Vec::with_capacity(decisions.elements.len());
        let mut next = mesh.tets.len() as u32;
        for (&element, &set) in &decisions.elements {
            let tet = editor.topology.tets[element as usize];
            let marks = editor.topology.marks[element as usize];
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
                touched.insert(slot);
            }
            replaced.push((element, children));
        }
        editor.divide(&replaced);
        let parents = replaced.iter().map(|(element, _)| *element);
        let children = parents.chain(mesh.tets.len() as u32..next);
        mend::remember_children(&mut editor, &stroke.across, blade, children);
        let mut faces = opening::faces_to_open(&editor, stroke, &touched);
        if settings.change == TopologyChange::SemiProgressive {
            faces.extend(opening::cracks(&editor, stroke, &touched));
        }
        opening::retain_flakes(&editor, stroke, &mut faces, settings);
        for [node, copy] in editor.open(&faces, sheet) {
            stroke.copied(node, copy);
            if editor.topology.front.contains(&node) {
                editor.topology.front.insert(copy);
                editor.topology.parted.extend([node, copy]);
            }
        }
        opening::leave_front(&mut editor, stroke, &touched);
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

/// Gives all crossings the positive side of the stroke's steady direction: a blade that goes back for a while would exchange the sides. Nodes are now
/// at `current` \[m\].
fn orient(stroke: &Stroke, crossings: &mut BTreeMap<[u32; 2], Crossing>, current: &[Vector3<f64>]) {
    for ([a, b], crossing) in crossings {
        if crossing.normal.dot(&stroke.across) < 0.0 {
            crossing.positive = !crossing.positive;
            crossing.normal = -crossing.normal;
        }
        let edge = current[*b as usize] - current[*a as usize];
        let is_positive = edge.dot(&stroke.across) >= 0.0;
        crossing.is_certain = crossing.positive == is_positive;
    }
}

#[cfg(test)]
mod tests;
