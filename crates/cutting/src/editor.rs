//! Changes to a topology, recorded as one edit.

use crate::fibre::Fibre;
use crate::moves::last_places;
use crate::pieces;
use crate::report::{Cut, Opened, SurfaceChange};
use crate::settings::Settings;
use crate::topology::{Child, SurfaceTriangle, Topology};
use microsim_mesh::{CutFace, NewNode, Replacement, Side, TetMesh, TopologyEdit};
use nalgebra::Vector3;
use std::collections::{BTreeMap, BTreeSet};

/// A face that came apart: element and opposite corner on both sides, the sheet, and the sides.
#[derive(Clone, Copy, Debug)]
struct OpenedFace {
    faces: [(u32, usize); 2],
    sheet: u32,
    /// Whether the first is the negative side.
    in_order: bool,
}

/// A topology under change and the edit that records it.
pub(crate) struct Editor<'a> {
    pub topology: &'a mut Topology,
    mesh: &'a TetMesh,
    current: &'a [Vector3<f64>],
    nodes: Vec<NewNode>,
    /// Rest and current positions of the new nodes \[m\].
    new_places: Vec<[Vector3<f64>; 2]>,
    /// Parent of each appended element.
    parents: Vec<u32>,
    /// The surface of each touched element before the edit.
    touched: BTreeMap<u32, Vec<SurfaceTriangle>>,
    opened: Vec<OpenedFace>,
    /// Elements that rupture: alone they are crumbs, whatever their size.
    pub shreds: BTreeMap<u32, Fibre>,
    /// Elements that are taken away: crumbs too.
    pub taken: BTreeSet<u32>,
    /// Of what takes them away the normal of its path.
    pub across: Vector3<f64>,
    /// Elements that have collapsed.
    collapsed: Vec<u32>,
}

impl<'a> Editor<'a> {
    /// An editor for `topology`, which is that of `mesh`; nodes are now at `current` \[m\].
    pub(crate) fn new(
        topology: &'a mut Topology,
        mesh: &'a TetMesh,
        current: &'a [Vector3<f64>],
    ) -> Self {
        Self {
            topology,
            mesh,
            current,
            nodes: Vec::new(),
            new_places: Vec::new(),
            parents: Vec::new(),
            touched: BTreeMap::new(),
            opened: Vec::new(),
            shreds: BTreeMap::new(),
            taken: BTreeSet::new(),
            across: Vector3::zeros(),
            collapsed: Vec::new(),
        }
    }

    /// The index of the next new node.
    pub(crate) fn next_node(&self) -> u32 {
        (self.mesh.positions.len() + self.nodes.len()) as u32
    }

    /// Where a node is, at rest and now \[m\].
    pub(crate) fn place(&self, node: u32) -> [Vector3<f64>; 2] {
        let old = self.mesh.positions.len();
        match (node as usize).checked_sub(old) {
            None => [
                self.mesh.positions[node as usize],
                self.current[node as usize],
            ],
            Some(new) => self.new_places[new],
        }
    }

    /// A new node.
    pub(crate) fn add_node(&mut self, between: [u32; 2], fraction: f64) {
        let [a, b] = between.map(|n| self.place(n));
        self.nodes.push(NewNode { between, fraction });
        self.new_places
            .push([0, 1].map(|k| a[k] + (b[k] - a[k]) * fraction));
    }

    /// Number of the original element in whose place, or behind whose place, `element` is.
    fn slot(&self, element: u32) -> u32 {
        let old = self.mesh.tets.len();
        match (element as usize).checked_sub(old) {
            None => element,
            Some(new) => self.parents[new],
        }
    }

    /// What happens to an element is part of the edit.
    pub(crate) fn touch(&mut self, element: u32) {
        let slot = self.slot(element);
        let topology = &self.topology;
        self.touched
            .entry(slot)
            .or_insert_with(|| topology.triangles_of(slot).collect());
    }

    /// Divides elements (ascending).
    pub(crate) fn divide(&mut self, replaced: &[(u32, Vec<Child>)]) {
        for (element, children) in replaced {
            self.touch(*element);
            self.parents
                .extend(children.iter().skip(1).map(|_| *element));
        }
        let nodes = self.next_node() as usize;
        self.topology.replace(replaced, nodes);
    }

    /// Opens inner faces, given by element and opposite corner, for the sheet with number `sheet`; the flag is whether that element is
    /// on the negative side. What is left of them hangs together at nodes on the edge of the cut and stays marked.
    /// Returns the copies: node and copy.
    pub(crate) fn open(&mut self, faces: &[(u32, usize, bool)], sheet: u32) -> Vec<[u32; 2]> {
        // A new node on an edge at which fans of elements meet that have no common face belongs to one of them.
        let first = self.mesh.positions.len() as u32;
        let mut nodes: BTreeSet<u32> = (first..self.next_node()).collect();
        let mut negative: BTreeSet<(u32, u32)> = BTreeSet::new();
        for &(element, corner, is_negative) in faces {
            let Some(other) = self.topology.neighbour(element, corner) else {
                continue;
            };
            let back = self.topology.back(element, other);
            self.topology.marks[element as usize][corner] = sheet;
            self.topology.marks[other as usize][back] = sheet;
            negative.insert(if is_negative {
                (element, other)
            } else {
                (other, element)
            });
            nodes.extend(self.topology.face(element, corner));
        }
        let mut copies = Vec::new();
        for node in nodes {
            let groups = self.topology.groups_at(node);
            if groups.len() > 1 {
                for element in self.topology.elements_at(node).to_vec() {
                    self.touch(element);
                }
            }
            for group in groups.iter().skip(1) {
                let copy = self.next_node();
                self.add_node([node, node], 0.0);
                copies.push([node, copy]);
                let mut apart = Vec::new();
                self.topology.double(node, group, |topology, faces| {
                    let (element, corner) = faces[0];
                    let mark = topology.marks[element as usize][corner];
                    apart.push((faces, mark));
                });
                for (faces, mark) in apart {
                    self.opened.push(OpenedFace {
                        faces,
                        sheet: mark,
                        in_order: !negative.contains(&(faces[1].0, faces[0].0)),
                    });
                }
            }
        }
        copies
    }

    /// Puts `onto` in the place of `node`, one of its neighbours.
    pub(crate) fn merge(&mut self, node: u32, onto: u32) {
        for end in [node, onto] {
            for element in self.topology.elements_at(end).to_vec() {
                self.touch(element);
            }
        }
        let collapsed = self.topology.merge(node, onto);
        self.collapsed.extend(collapsed);
    }

    /// The edit of merges, with its report.
    pub(crate) fn conclude_merges(mut self) -> Cut {
        let mut collapsed = std::mem::take(&mut self.collapsed);
        collapsed.sort_unstable();
        Cut {
            merged: self.leaving_nodes(&collapsed).len(),
            // Those around them have their volume.
            lost_volume: 0.0,
            ..self.finish(&collapsed, Vec::new())
        }
    }

    /// The edit with its report; `None` when nothing was changed.
    pub(crate) fn conclude(self, settings: &Settings) -> Option<Cut> {
        if self.touched.is_empty() {
            return None;
        }
        let pairs = self
            .opened
            .iter()
            .map(|o| o.faces.map(|(element, _)| element));
        let mut pieces = pieces::come_off(self.topology, &pairs.collect::<Vec<_>>());
        let mut crumbs = Vec::new();
        pieces.retain(|piece| {
            let crumb = piece.iter().all(|e| self.is_shred(e))
                || self.is_crumb(piece, settings.crumb_volume, settings.least_fraction);
            if crumb {
                crumbs.extend_from_slice(piece);
            }
            !crumb
        });
        // The part with most elements is no piece, and may be a shred.
        let apart = |shred: u32| (0..4).all(|k| self.topology.neighbour(shred, k).is_none());
        let shreds = self.shreds.keys().chain(&self.taken);
        crumbs.extend(shreds.filter(|shred| apart(**shred)));
        crumbs.sort_unstable();
        crumbs.dedup();
        Some(self.finish(&crumbs, pieces))
    }

    /// Whether an element is not to remain when it is alone.
    fn is_shred(&self, element: &u32) -> bool {
        self.shreds.contains_key(element) || self.taken.contains(element)
    }

    /// Whether a part is too small to remain: by its volume over the mean element's, or its longest edge over the mean
    /// one.
    fn is_crumb(&self, piece: &[u32], least_volume: f64, least_edge: f64) -> bool {
        // A crumb has few elements: what is larger in number has the volume as well.
        let volume: f64 = piece.iter().map(|&e| self.rest_volume(e)).sum();
        let longest = || {
            let edges = piece.iter().flat_map(|&e| {
                let places = self.topology.tets[e as usize].map(|n| self.place(n)[0]);
                crate::pattern::EDGES.map(|[i, j]| (places[j] - places[i]).norm())
            });
            edges.fold(0.0, f64::max)
        };
        volume < least_volume * self.topology.mean_volume
            || (piece.len() < 64 && longest() < least_edge * self.topology.mean_edge)
    }

    /// Area of a face at rest \[m²\].
    pub(crate) fn face_area(&self, element: u32, corner: usize) -> f64 {
        let [a, b, c] = self
            .topology
            .face(element, corner)
            .map(|n| self.place(n)[0]);
        0.5 * (b - a).cross(&(c - a)).norm()
    }

    /// Rest volume of an element \[m³\].
    pub(crate) fn rest_volume(&self, element: u32) -> f64 {
        let [a, b, c, d] = self.topology.tets[element as usize].map(|n| self.place(n)[0]);
        microsim_geometry::signed_volume(&a, &b, &c, &d)
    }

    /// The edit with its report, without `crumbs` (ascending).
    fn finish(mut self, crumbs: &[u32], mut pieces: Vec<Vec<u32>>) -> Cut {
        let mut lists: BTreeMap<u32, Vec<[u32; 4]>> = BTreeMap::new();
        for &slot in self.touched.keys() {
            lists.insert(slot, vec![self.topology.tets[slot as usize]]);
        }
        let old_count = self.mesh.tets.len();
        for (k, parent) in self.parents.iter().enumerate() {
            let tet = self.topology.tets[old_count + k];
            lists.entry(*parent).or_default().push(tet);
        }
        let elements = lists
            .into_iter()
            .map(|(element, children)| Replacement { element, children })
            .filter(|r| {
                let unchanged =
                    r.children.len() == 1 && r.children[0] == self.mesh.tets[r.element as usize];
                !unchanged
            });
        let mut edit = TopologyEdit {
            generation: self.mesh.generation,
            nodes: std::mem::take(&mut self.nodes),
            elements: elements.collect(),
            ..TopologyEdit::default()
        };
        let divided = edit
            .elements
            .iter()
            .filter(|r| r.children.len() > 1)
            .count();
        let lost_volume = crumbs.iter().map(|&e| self.rest_volume(e)).sum();
        let opened = self.opened_area();
        let mut now: BTreeSet<u32> = self.touched.keys().copied().collect();
        now.extend(old_count as u32..self.topology.tets.len() as u32);
        if !crumbs.is_empty() {
            self.take_out(crumbs, &mut edit, &mut now, &mut pieces);
        }
        edit.cut_faces = self.cut_faces();
        let before: BTreeSet<SurfaceTriangle> = self.touched.values().flatten().copied().collect();
        let after: BTreeSet<SurfaceTriangle> = now
            .iter()
            .flat_map(|&e| self.topology.triangles_of(e))
            .collect();
        self.topology.generation = self.mesh.generation + 1;
        self.topology.clusters.update_after_edit(&edit);
        Cut {
            divided,
            opened,
            surface: SurfaceChange {
                removed: before.difference(&after).copied().collect(),
                added: after.difference(&before).copied().collect(),
            },
            pieces,
            lost_volume,
            edit,
            ..Cut::default()
        }
    }

    /// Takes crumbs out of topology, surface and pieces.
    fn take_out(
        &mut self,
        crumbs: &[u32],
        edit: &mut TopologyEdit,
        now: &mut BTreeSet<u32>,
        pieces: &mut [Vec<u32>],
    ) {
        edit.removed = crumbs.to_vec();
        let moves = edit.element_moves(self.mesh.tets.len());
        let from = moves.iter().map(|&(from, _)| from);
        for element in crumbs.iter().copied().chain(from) {
            // Its triangles leave, or are those of another number from now on.
            self.touch(element);
        }
        // The touched ones' corners as the edit gives them, to see which nodes bring new numbers.
        let nodes_before = self.topology.node_elements.len();
        let leaving: BTreeSet<u32> = self.leaving_nodes(crumbs);
        let mut renumbered: BTreeSet<u32> = BTreeSet::new();
        let leaving: Vec<u32> = leaving.into_iter().collect();
        edit.removed_nodes.clone_from(&leaving);
        let node_moves = edit.node_moves(self.mesh.positions.len());
        debug_assert_eq!(nodes_before, self.mesh.positions.len() + edit.nodes.len());
        for &(from, _) in &node_moves {
            for e in self.topology.elements_at(from).to_vec() {
                self.touch(e);
                renumbered.insert(e);
            }
        }
        let gone = self.topology.remove(crumbs);
        debug_assert_eq!(gone, leaving);
        let places = last_places(&moves);
        let moved = |element: u32| places.get(&element).copied().unwrap_or(element);
        let is_crumb = |e: &u32| crumbs.binary_search(e).is_ok();
        let renumbered = renumbered.into_iter().filter(|e| !is_crumb(e)).map(moved);
        let mut renumbered: Vec<u32> = renumbered.collect();
        renumbered.sort_unstable();
        edit.renumbered = renumbered
            .iter()
            .map(|&e| (e, self.topology.tets[e as usize]))
            .collect();
        now.extend(self.touched.keys());
        *now = now
            .iter()
            .filter(|e| !is_crumb(e))
            .map(|&e| moved(e))
            .collect();
        for piece in pieces.iter_mut() {
            piece.iter_mut().for_each(|e| *e = moved(*e));
            piece.sort_unstable();
        }
        self.opened.retain_mut(|o| {
            for (element, _) in &mut o.faces {
                *element = if is_crumb(element) {
                    u32::MAX
                } else {
                    moved(*element)
                };
            }
            o.faces.iter().any(|(e, _)| *e != u32::MAX)
        });
    }

    /// The nodes at which nothing is left without `crumbs`.
    fn leaving_nodes(&self, crumbs: &[u32]) -> BTreeSet<u32> {
        let nodes = crumbs.iter().flat_map(|&e| self.topology.tets[e as usize]);
        let gone = |e: &u32| crumbs.binary_search(e).is_ok();
        nodes
            .filter(|&node| self.topology.elements_at(node).iter().all(gone))
            .collect()
    }

    fn cut_faces(&self) -> Vec<CutFace> {
        let mut faces = Vec::new();
        for opened in &self.opened {
            for (k, (element, corner)) in opened.faces.into_iter().enumerate() {
                if element == u32::MAX {
                    continue;
                }
                let is_negative = (k == 0) == opened.in_order;
                faces.push(CutFace {
                    nodes: self.topology.face(element, corner),
                    element,
                    sheet: opened.sheet,
                    side: if is_negative {
                        Side::Negative
                    } else {
                        Side::Positive
                    },
                });
            }
        }
        faces
    }

    /// Adds what shreds held together, at rest (0) or now (1).
    fn add_ruptured(&self, k: usize, sum: &mut Opened) {
        let Some(along) = self.shreds.values().next().map(|fibre| fibre[k]) else {
            return;
        };
        let (mut ahead, mut behind, mut centroid) = (0.0, 0.0, Vector3::zeros());
        for opened in &self.opened {
            let shreds = opened.faces.iter();
            let mut shreds =
                shreds.filter_map(|&(e, corner)| Some((e, corner, self.shreds.get(&e)?)));
            // Between two shreds that fail together nothing is laid open that is left.
            let (Some((element, corner, fibre)), None) = (shreds.next(), shreds.next()) else {
                continue;
            };
            let nodes = self.topology.face(element, corner);
            let [a, b, c] = nodes.map(|n| self.place(n)[k]);
            let outward = (b - a).cross(&(c - a)) * 0.5;
            let sign = if fibre[k].dot(&along) < 0.0 {
                -1.0
            } else {
                1.0
            };
            let seen = sign * outward.dot(&fibre[k]);
            ahead += seen.max(0.0);
            behind -= seen.min(0.0);
            centroid += (a + b + c) * (seen.abs() / 3.0);
        }
        let section = |(shred, fibre): (&u32, &Fibre)| {
            let corners = self.topology.tets[*shred as usize].map(|n| self.place(n)[k]);
            mean_section(&corners, &fibre[k])
        };
        let sections: f64 = self.shreds.iter().map(section).sum();
        let area = ahead.min(behind).min(sections);
        if area > 0.0 {
            sum.area += area;
            sum.centroid += centroid * (area / (ahead + behind));
            sum.normal += along * area;
        }
    }

    /// Adds the mean sections of elements that are taken away across the normal of the path, at rest (0) or now (1): what the blade went through.
    fn add_taken(&self, k: usize, sum: &mut Opened) {
        let Some(across) = self.across.try_normalize(0.0) else {
            return;
        };
        for &element in &self.taken {
            let corners = self.topology.tets[element as usize].map(|n| self.place(n)[k]);
            let area = mean_section(&corners, &across);
            sum.area += area;
            sum.centroid += corners.iter().sum::<Vector3<f64>>() * (area / 4.0);
            sum.normal += across * area;
        }
    }

    /// Area, centroid and normal of what came apart, at rest and now.
    fn opened_area(&self) -> [Opened; 2] {
        let mut sums = [Opened::default(); 2];
        for opened in &self.opened {
            let shreds = opened.faces.iter().filter(|(e, _)| self.is_shred(e));
            if shreds.count() > 0 {
                continue;
            }
            let (element, corner) = opened.faces[usize::from(!opened.in_order)];
            let nodes = self.topology.face(element, corner).map(|n| self.place(n));
            for (k, sum) in sums.iter_mut().enumerate() {
                let [a, b, c] = nodes.map(|place| place[k]);
                // Outward from the negative side: towards the positive one.
                let normal = (b - a).cross(&(c - a)) * 0.5;
                let area = normal.norm();
                sum.area += area;
                sum.centroid += (a + b + c) * (area / 3.0);
                sum.normal += normal;
            }
        }
        for (k, sum) in sums.iter_mut().enumerate() {
            self.add_ruptured(k, sum);
            self.add_taken(k, sum);
        }
        for sum in &mut sums {
            sum.centroid = if sum.area > 0.0 {
                sum.centroid / sum.area
            } else {
                Vector3::zeros()
            };
            let length = sum.normal.norm();
            sum.normal = if length > 0.0 {
                sum.normal / length
            } else {
                Vector3::zeros()
            };
        }
        sums
    }
}

/// Mean area of the sections of a tetrahedron across a direction: its volume over its extent along it.
fn mean_section(corners: &[Vector3<f64>; 4], along: &Vector3<f64>) -> f64 {
    let [a, b, c, d] = corners;
    let places = [a, b, c, d].map(|place| place.dot(along));
    let [least, most] = [f64::min, f64::max].map(|of| places.into_iter().reduce(of));
    let extent = most.unwrap_or_default() - least.unwrap_or_default();
    microsim_geometry::signed_volume(a, b, c, d).abs() / extent.max(f64::MIN_POSITIVE)
}
