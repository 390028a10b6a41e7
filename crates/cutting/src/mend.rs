//! Bridges: what a blade has swept between and left joined, found and opened.
//!
//! Which faces open behind a blade is decided by the sides of nodes that its stroke remembers. A path that comes around and crosses itself, or that
//! trembles in and out of the surface, gives some nodes two sides one after another, and a few faces stay closed. So it is looked at again, without
//! sides: elements that the blade has swept are remembered with the mesh ([`Topology::remember_swept`]). Regions of all others that hang together by swept elements
//! alone are parted by the smallest set of faces at what was cut already.
//!
//! A blade that ends inside tissue has swept nothing beyond its edge: there its two sides are one region, and nothing is opened.

use crate::blade::Blade;
use crate::editor::Editor;
use crate::flow::Flow;
use crate::report::Cut;
use crate::settings::Settings;
use crate::stroke::Stroke;
use crate::sweep::Sweep;
use crate::swept::{ONE_SIDE, Swept};
use crate::topology::{NONE, Topology};
use microsim_geometry::{closest_on_triangle, signed_volume};
use microsim_mesh::TetMesh;
use nalgebra::Vector3;
use std::collections::{BTreeMap, BTreeSet};

/// Distance from a sweep within which an element counts as swept, over the mean edge: by as much a cut may stray.
const REACH: f64 = 0.5;

/// Regions of which less than so many mean elements lie farther than `REACH` from all sweeps may stay where they hang: shards of a cut.
const REGION: f64 = 1.0;

/// Cosine of the angle to the normal of the path within which an element at a fold of it lies beside it, not ahead.
const BESIDE: f64 = 0.7;

/// Fraction of the blade's length, and sine of an angle, above rounding.
const TIP: f64 = 1e-6;

/// What opening a face costs, by the number of its nodes that are on no cut yet: the path goes through nodes of cuts as far as it can, and through no
/// face that has none: on both sides of what is whole a blade may have gone by.
const COSTS: [u32; 4] = [1, 2, 4, 1 << 16];

impl Topology {
    /// Remembers the elements whose centroid has passed within reach at the side of the blade in this step.
    pub(crate) fn remember_swept(&mut self, across: &Vector3<f64>, blade: &Blade) {
        let Blade::Sweep {
            sweeps,
            before,
            now,
        } = blade
        else {
            return;
        };
        let reach = REACH * self.mean_edge;
        let centroid = |positions: &[Vector3<f64>], tet: &[u32; 4]| {
            let corners = tet.iter().map(|&node| positions[node as usize]);
            corners.sum::<Vector3<f64>>() / 4.0
        };
        let mut swept: Vec<(u32, Option<Vector3<f64>>)> = Vec::new();
        for sweep in *sweeps {
            let bounds = sweep.bounds().inflated(reach);
            self.elements_near(&bounds, [before, now], |element, tet| {
                let [from, to] = [before, now].map(|positions| centroid(positions, tet));
                if let Some(side) = comes_near(sweep, [from, to], across, reach) {
                    swept.push((element, side));
                }
            });
        }
        for (element, side) in swept {
            let swept = self.swept.entry(element).or_default();
            if let Some(side) = side {
                swept.pass(side);
            }
        }
    }

    /// Opens the bridges of all that was swept so far; `None` where there are none.
    pub(crate) fn mend(
        &mut self,
        mesh: &TetMesh,
        stroke: &mut Stroke,
        current: &[Vector3<f64>],
        near: &BTreeSet<u32>,
        settings: &Settings,
    ) -> Option<Cut> {
        let faces = self.bridges(mesh, near);
        if faces.is_empty() {
            return None;
        }
        let faces = self.turned_alike(mesh, &faces);
        let mut editor = Editor::new(self, mesh, current);
        for [node, copy] in editor.open(&faces, stroke.sheet) {
            stroke.copied(node, copy);
            if editor.topology.front.contains(&node) {
                editor.topology.front.insert(copy);
                editor.topology.parted.extend([node, copy]);
            }
        }
        let mut cut = editor.conclude(settings)?;
        stroke.leave(&cut.edit, mesh.positions.len());
        cut.mended = faces.len();
        Some(cut)
    }

    /// The faces that part all regions that hang together by what lies between sweeps alone, or across one.
    fn bridges(&self, mesh: &TetMesh, near: &BTreeSet<u32>) -> Vec<(u32, u8)> {
        let mut on_cut: BTreeMap<u32, bool> = BTreeMap::new();
        let mut is_on_cut = |node: u32| *on_cut.entry(node).or_insert_with(|| self.is_on_cut(node));
        // Where a blade is it may not have come through yet.
        let mut passed: BTreeMap<u32, Swept> = BTreeMap::new();
        for (&element, &swept) in &self.swept {
            let tet = &self.tets[element as usize];
            let is_behind = !tet.iter().any(|node| near.contains(node));
            if swept.passed && is_behind {
                passed.insert(element, swept);
            }
        }
        if passed.is_empty() {
            return Vec::new();
        }
        let regions = self.regions(mesh, &passed);
        let mut opened: BTreeSet<(u32, u32)> = BTreeSet::new();
        let mut faces = Vec::new();
        let mut open = |element: u32, corner: usize, other: u32| {
            if opened.insert((element.min(other), element.max(other))) {
                faces.push((element, corner as u8));
            }
        };
        for &element in passed.keys().filter(|&&e| regions.is_large(e)) {
            for (corner, other) in self.closed(element) {
                if regions.is_large(other) && regions.of(other) != regions.of(element) {
                    open(element, corner, other);
                }
            }
        }
        let mut seen = BTreeSet::new();
        for &start in &regions.between {
            if seen.contains(&start) {
                continue;
            }
            let (group, around) = self.group(start, &regions);
            seen.extend(group.iter().copied());
            let mut around: Vec<u32> = around.into_iter().collect();
            // The largest is what the others are parted from.
            around.sort_by_key(|&region| (regions.sizes[region as usize], region));
            let mut gone: BTreeSet<(u32, u32)> = BTreeSet::new();
            while around.len() > 1 {
                let region = around.remove(0);
                let mut flow = Flow::default();
                for &element in &group {
                    for (corner, other) in self.closed(element) {
                        if gone.contains(&(element.min(other), element.max(other))) {
                            continue;
                        }
                        let nodes = self.face(element, corner);
                        let cost = COSTS[nodes.iter().filter(|node| !is_on_cut(**node)).count()];
                        match regions.of(other) {
                            _ if group.contains(&other) => flow.join(element, other, cost),
                            of if of == region => flow.add_source(element, cost),
                            of if around.contains(&of) => flow.add_sink(element, cost),
                            _ => {}
                        }
                    }
                }
                let Some(source) = flow.source_side(COSTS[3]) else {
                    continue;
                };
                for &element in &group {
                    for (corner, other) in self.closed(element) {
                        let is_source = source.contains(&element);
                        let crosses = match regions.of(other) {
                            _ if group.contains(&other) => is_source && !source.contains(&other),
                            of if of == region => !is_source,
                            of if around.contains(&of) => is_source,
                            _ => false,
                        };
                        if crosses {
                            gone.insert((element.min(other), element.max(other)));
                            open(element, corner, other);
                        }
                    }
                }
            }
        }
        faces
    }

    /// The faces of an element to others: opposite corner, and element across.
    fn closed(&self, element: u32) -> impl Iterator<Item = (usize, u32)> + '_ {
        (0..4).filter_map(move |corner| Some((corner, self.neighbour(element, corner)?)))
    }

    /// Whether a node lies on a face that a blade has passed or on the edge of a cut.
    fn is_on_cut(&self, node: u32) -> bool {
        let is_cut = |&element: &u32| {
            let tet = &self.tets[element as usize];
            let marks = &self.marks[element as usize];
            (0..4).any(|corner| tet[corner] != node && marks[corner] != 0)
        };
        self.front.contains(&node) || self.elements_at(node).iter().any(is_cut)
    }

    /// What hangs together beside the sweeps that have `passed` elements: by faces across none of them.
    fn regions(&self, mesh: &TetMesh, passed: &BTreeMap<u32, Swept>) -> Regions {
        let least = REGION * self.mean_volume;
        let mut regions = Regions {
            of: vec![NONE; self.tets.len()],
            sizes: Vec::new(),
            between: BTreeSet::new(),
        };
        let is_between = |element: u32| passed.get(&element).is_some_and(Swept::is_between);
        let mut found = Vec::new();
        for start in 0..self.tets.len() as u32 {
            if regions.of(start) != NONE {
                continue;
            }
            if is_between(start) {
                regions.between.insert(start);
                continue;
            }
            let region = regions.sizes.len() as u32;
            found.clear();
            found.push(start);
            regions.of[start as usize] = region;
            let mut next = 0;
            while let Some(&element) = found.get(next) {
                next += 1;
                let mine = passed.get(&element);
                for other in self.neighbours[element as usize] {
                    if other == NONE || regions.of(other) != NONE || is_between(other) {
                        continue;
                    }
                    let across = mine.zip(passed.get(&other));
                    if across.is_none_or(|(a, b)| a.side.dot(&b.side) > ONE_SIDE) {
                        regions.of[other as usize] = region;
                        found.push(other);
                    }
                }
            }
            let far = found.iter().filter(|e| !self.swept.contains_key(e));
            let mut volumes = far.map(|&element| {
                let [a, b, c, d] = mesh.corners(element as usize);
                signed_volume(&a, &b, &c, &d)
            });
            let mut volume = 0.0;
            while volume < least
                && let Some(one) = volumes.next()
            {
                volume += one;
            }
            if volume < least {
                regions.between.extend(&found);
            }
            regions.sizes.push(found.len());
        }
        regions
    }

    /// What lies between regions and hangs together with `start`, and the regions at it.
    fn group(&self, start: u32, regions: &Regions) -> (BTreeSet<u32>, BTreeSet<u32>) {
        let (mut group, mut around) = (BTreeSet::from([start]), BTreeSet::new());
        let mut open = vec![start];
        while let Some(element) = open.pop() {
            for (_, other) in self.closed(element) {
                if regions.is_large(other) {
                    around.insert(regions.of(other));
                } else if group.insert(other) {
                    open.push(other);
                }
            }
        }
        (group, around)
    }
}

/// Regions of a body.
struct Regions {
    /// Region of each element, or none.
    of: Vec<u32>,
    /// Elements of each region.
    sizes: Vec<usize>,
    /// Elements between regions, or in such as are too small to count.
    between: BTreeSet<u32>,
}

impl Regions {
    fn of(&self, element: u32) -> u32 {
        self.of[element as usize]
    }

    fn is_large(&self, element: u32) -> bool {
        !self.between.contains(&element)
    }
}

/// Remembers those of `children`, elements that were made in this step, whose centroid lies behind the blade and within reach at its side: it has passed there
/// when their parents had other centroids.
pub(crate) fn remember_children(
    editor: &mut Editor,
    across: &Vector3<f64>,
    blade: &Blade,
    children: impl Iterator<Item = u32>,
) {
    let (Blade::Sweep { sweeps, .. }, Some(across)) = (blade, across.try_normalize(0.0)) else {
        return;
    };
    let reach = REACH * editor.topology.mean_edge;
    for child in children {
        let corners = editor.topology.tets[child as usize];
        let centroid = corners
            .iter()
            .map(|&node| editor.place(node)[1])
            .sum::<Vector3<f64>>()
            / 4.0;
        let is_behind = |sweep: &Sweep| {
            let [a, b] = sweep.now;
            let along = (centroid - a).dot(&(b - a)) / (b - a).norm_squared();
            let from = centroid - (a + (b - a) * along);
            let ahead = across.cross(&(b - a));
            (0.0..=1.0).contains(&along)
                && from.dot(&across).abs() <= reach
                && from.dot(&ahead) < 0.0
        };
        if sweeps.iter().any(is_behind) {
            let height = sweeps
                .iter()
                .map(|sweep| (centroid - sweep.now[0]).dot(&across));
            let height: f64 = height.sum();
            let side = if height < 0.0 { -across } else { across };
            let swept = editor.topology.swept.entry(child).or_default();
            // A parent's side is that of its centroid.
            if !swept.is_between() {
                *swept = Swept { passed: true, side };
            }
        }
    }
}

/// Whether a point that moves from one place to another comes within `reach` of what the blade sweeps, in the frame that moves with the point: at its side with
/// the direction from there to the point, beyond its edge with none.
#[expect(clippy::option_option, reason = "beyond reach, near, and passed")]
fn comes_near(
    sweep: &Sweep,
    [from, to]: [Vector3<f64>; 2],
    across: &Vector3<f64>,
    reach: f64,
) -> Option<Option<Vector3<f64>>> {
    let [a, b] = sweep.before.map(|p| p - from);
    let [c, d] = sweep.now.map(|p| p - to);
    let mut near = None;
    for triangle in [[a, b, d], [a, d, c]] {
        let closest = closest_on_triangle(&Vector3::zeros(), &triangle).point;
        if closest.norm() > reach {
            continue;
        }
        let along = (closest - c).dot(&(d - c)) / (d - c).norm_squared();
        let [u, v, w] = triangle;
        let normal = (v - u).cross(&(w - u));
        // Over the triangle, or over the fold to the path of another step: there the sides of the steady path count.
        let beside = |side: Vector3<f64>| {
            let is_normal = side.cross(&normal).norm() < TIP * normal.norm();
            let height = side.dot(across);
            let is_over_fold = height.abs() > BESIDE * across.norm();
            let folded = across.normalize() * height.signum();
            is_normal.then_some(side).or(is_over_fold.then_some(folded))
        };
        let is_within = along > TIP && along < 1.0 - TIP;
        let side = (-closest).try_normalize(0.0).filter(|_| is_within);
        let side = side.and_then(beside);
        near = Some(near.flatten().or(side));
    }
    near
}

#[cfg(test)]
mod tests;
