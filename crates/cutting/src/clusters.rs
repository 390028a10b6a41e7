//! Groups of elements that lie together, with their nodes: where is an element near a blade?
//!
//! The nodes move in every step. The box around a group is that of some earlier time; how far any node has gone since is
//! looked at in every step, a nanosecond per node, and by so much a box counts as larger. When a node has gone too far all boxes are made
//! again. The elements of those groups alone are looked at into whose box a blade comes. Groups grow as their elements are divided and are
//! halved when they have become large.

use microsim_geometry::Aabb;
use microsim_mesh::{TetMesh, TopologyEdit};
use nalgebra::Vector3;

/// Elements in a new group, at most.
const NEW: usize = 64;

/// A group with more elements is halved.
const LARGE: usize = 160;

/// Boxes are larger by this fraction of an edge.
const ROUNDING: f64 = 1e-6;

#[derive(Clone, Debug)]
struct Cluster {
    elements: Vec<u32>,
    /// All nodes of its elements, and some that were so.
    nodes: Vec<u32>,
    /// Around its elements as nodes were at the places that the groups remember; empty before there are any.
    bounds: Aabb,
}

/// The groups of a body.
#[derive(Clone, Debug, Default)]
pub(crate) struct Clusters {
    clusters: Vec<Cluster>,
    /// Group of each element.
    of: Vec<u32>,
    /// Where nodes were when the boxes were made \[m\].
    places: Vec<Vector3<f64>>,
}

impl Clusters {
    /// Groups of a mesh, from halving it again and again across its longest side.
    pub(crate) fn new(mesh: &TetMesh) -> Self {
        let centroid = |e: u32| mesh.corners(e as usize).iter().sum::<Vector3<f64>>();
        let centroids: Vec<_> = (0..mesh.tets.len() as u32).map(centroid).collect();
        let mut elements: Vec<u32> = (0..mesh.tets.len() as u32).collect();
        let mut clusters = Self {
            clusters: Vec::new(),
            of: vec![0; mesh.tets.len()],
            places: Vec::new(),
        };
        clusters.build(&mut elements, &centroids, &mesh.tets);
        clusters
    }

    fn build(&mut self, elements: &mut [u32], centroids: &[Vector3<f64>], tets: &[[u32; 4]]) {
        if elements.len() > NEW {
            let bounds = Aabb::of(elements.iter().map(|&e| &centroids[e as usize]));
            let axis = (bounds.max - bounds.min).imax();
            let middle = elements.len() / 2;
            elements.select_nth_unstable_by(middle, |&a, &b| {
                let key = |e: u32| centroids[e as usize][axis];
                key(a).total_cmp(&key(b)).then(a.cmp(&b))
            });
            let (first, second) = elements.split_at_mut(middle);
            self.build(first, centroids, tets);
            self.build(second, centroids, tets);
        } else if !elements.is_empty() {
            self.put(self.clusters.len(), elements.to_vec(), tets, Aabb::empty());
        }
    }

    /// Makes group `index`, or the next one, of these elements, all of which are in `bounds`.
    fn put(&mut self, index: usize, elements: Vec<u32>, tets: &[[u32; 4]], bounds: Aabb) {
        let mut nodes: Vec<u32> = elements.iter().flat_map(|&e| tets[e as usize]).collect();
        nodes.sort_unstable();
        nodes.dedup();
        for &element in &elements {
            self.of[element as usize] = index as u32;
        }
        let cluster = Cluster {
            elements,
            nodes,
            bounds,
        };
        match self.clusters.get_mut(index) {
            Some(place) => *place = cluster,
            None => self.clusters.push(cluster),
        }
    }

    /// How much larger than their boxes groups may be with nodes at these places \[m\]. Boxes are rebuilt when that is more than `most`.
    fn slack(&mut self, positions: [&[Vector3<f64>]; 2], most: f64) -> f64 {
        let farthest = |places: &[Vector3<f64>]| {
            // Written without an early exit of the loop; what is not a number makes the sum so.
            let (mut farthest, mut finite) = (0.0, 0.0);
            for positions in positions {
                for (now, then) in positions.iter().zip(places) {
                    let displacement = now - then;
                    farthest = f64::max(farthest, displacement.amax());
                    finite += (displacement.x + displacement.y + displacement.z) * 0.0;
                }
            }
            match finite == 0.0 {
                true => farthest,
                false => f64::INFINITY,
            }
        };
        let known = self.places.len() == positions[1].len();
        let slack = if known {
            farthest(&self.places)
        } else {
            f64::INFINITY
        };
        if slack <= most {
            return slack;
        }
        self.places.clear();
        // New nodes come with every cut.
        self.places.reserve(positions[1].len() * 3 / 2);
        self.places.extend_from_slice(positions[1]);
        for cluster in &mut self.clusters {
            let nodes = cluster.nodes.iter();
            cluster.bounds = Aabb::of(nodes.filter_map(|&node| self.places.get(node as usize)));
        }
        farthest(&self.places)
    }

    /// Calls `found` for the elements whose corners' path from the first to the second positions comes into `bounds`, or is not
    /// finite. `edge` \[m\] is how long edges are, more or less.
    pub(crate) fn near(
        &mut self,
        bounds: &Aabb,
        edge: f64,
        tets: &[[u32; 4]],
        positions: [&[Vector3<f64>]; 2],
        mut found: impl FnMut(u32),
    ) {
        let is_near = |nodes: &[u32; 4]| {
            let mut around = Aabb::empty();
            let mut finite = 0.0;
            for &node in nodes {
                for place in positions.map(|positions| positions[node as usize]) {
                    around.include(&place);
                    // 0, or not a number.
                    finite += (place.x + place.y + place.z) * 0.0;
                }
            }
            around.overlaps(bounds) || finite != 0.0
        };
        // Rounding must not leave out what touches.
        let slack = self.slack(positions, edge) + ROUNDING * edge;
        let anywhere = slack == f64::INFINITY;
        let bounds = bounds.inflated(slack);
        for cluster in &self.clusters {
            if anywhere || cluster.bounds.overlaps(&bounds) {
                let elements = cluster.elements.iter().copied();
                elements
                    .filter(|&e| is_near(&tets[e as usize]))
                    .for_each(&mut found);
            }
        }
    }

    /// Updates boxes after an edit of which only new nodes are missing: a new node is between two others, and so in all their boxes.
    pub(crate) fn update_after_edit(&mut self, edit: &TopologyEdit) {
        if !self.places.is_empty() {
            edit.carry_nodes(&mut self.places);
        }
    }

    /// Makes room for so many more elements.
    pub(crate) fn make_room(&mut self, elements: usize) {
        self.of.reserve(elements);
    }

    /// A new element (the next one) comes from `parent`.
    pub(crate) fn appended(&mut self, parent: u32) {
        let cluster = self.of[parent as usize];
        self.clusters[cluster as usize]
            .elements
            .push(self.of.len() as u32);
        self.of.push(cluster);
    }

    /// An element has these nodes now.
    pub(crate) fn has_nodes(&mut self, element: u32, nodes: &[u32]) {
        let cluster = &mut self.clusters[self.of[element as usize] as usize];
        for node in nodes {
            if !cluster.nodes.contains(node) {
                cluster.nodes.push(*node);
            }
        }
    }

    /// An element has got one of the nodes of the body, which may lie outside of its box.
    pub(crate) fn gains_node(&mut self, element: u32, node: u32) {
        self.has_nodes(element, &[node]);
        if let Some(place) = self.places.get(node as usize) {
            let cluster = &mut self.clusters[self.of[element as usize] as usize];
            cluster.bounds.include(place);
        }
    }

    /// Halves the groups of `elements` that have become large.
    pub(crate) fn halve_large(
        &mut self,
        elements: &[u32],
        tets: &[[u32; 4]],
        neighbours: &[[u32; 4]],
    ) {
        for &element in elements {
            let index = self.of[element as usize] as usize;
            if self.clusters[index].elements.len() <= LARGE {
                continue;
            }
            let all = std::mem::take(&mut self.clusters[index].elements);
            let (first, second) = halves(&all, neighbours);
            let bounds = self.clusters[index].bounds;
            self.put(index, first, tets, bounds);
            self.put(self.clusters.len(), second, tets, bounds);
        }
    }

    /// Element `gone` leaves, and the last one takes its place.
    pub(crate) fn swap_remove(&mut self, gone: u32) {
        let last = self.of.len() as u32 - 1;
        let cluster = &mut self.clusters[self.of[gone as usize] as usize];
        cluster.elements.retain(|&e| e != gone);
        let cluster = &mut self.clusters[self.of[last as usize] as usize];
        let moved = cluster.elements.iter_mut().filter(|e| **e == last);
        moved.for_each(|e| *e = gone);
        self.of.swap_remove(gone as usize);
    }
}

/// Two halves of a group, the first of elements that hang together as far as they do.
fn halves(all: &[u32], neighbours: &[[u32; 4]]) -> (Vec<u32>, Vec<u32>) {
    let mut sorted = all.to_vec();
    sorted.sort_unstable();
    let mut taken = vec![false; sorted.len()];
    let mut first: Vec<u32> = Vec::new();
    let mut next = 0;
    let half = sorted.len() / 2;
    for start in 0..sorted.len() {
        if taken[start] || first.len() >= half {
            continue;
        }
        taken[start] = true;
        first.push(sorted[start]);
        while first.len() < half
            && let Some(&element) = first.get(next)
        {
            next += 1;
            for other in neighbours[element as usize] {
                if let Ok(place) = sorted.binary_search(&other)
                    && !taken[place]
                    && first.len() < half
                {
                    taken[place] = true;
                    first.push(other);
                }
            }
        }
    }
    let second = sorted.iter().zip(&taken).filter(|(_, taken)| !**taken);
    let second = second.map(|(&e, _)| e).collect();
    (first, second)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Blade, Settings, Sheet, Stroke, Topology};
    use microsim_mesh::{Block, CellSplit};
    use microsim_random::Congruential;

    /// Nodes that drift, shake, and jump, in a mesh that is cut in between: what is found is what a look at every element finds.
    #[test]
    fn near_finds_what_a_look_at_every_element_finds() {
        let block = Block {
            center: [0.0; 3],
            size: [6.0, 5.0, 4.0],
            cells: [6, 5, 4],
            split: CellSplit::Kuhn,
        };
        let mut mesh = block.mesh().unwrap();
        let mut topology = Topology::new(&mesh);
        let mut random = Congruential(1);
        let mut vector = move || random.vector();
        let (mut some, mut none) = (0, 0);
        for step in 0..60_usize {
            let drift = vector() * [0.0, 0.3, 4.0][step % 3];
            let shake = [0.0, 0.1, 1.0][step / 3 % 3];
            let mut now = mesh.positions.clone();
            now.iter_mut().for_each(|p| *p += drift + vector() * shake);
            let mut before = now.clone();
            before.iter_mut().for_each(|p| *p += vector() * shake);
            if step % 20 == 19 {
                now[step].x = f64::NAN;
            }
            let (a, b) = (vector() * 4.0, vector());
            let bounds = Aabb::of(&[a, a + b]);
            let expected = (0..mesh.tets.len() as u32).filter(|&element| {
                let corners = mesh.tets[element as usize].map(|node| node as usize);
                let places = corners.map(|node| [before[node], now[node]]);
                let finite = places
                    .iter()
                    .flatten()
                    .all(|p| p.iter().all(|x| x.is_finite()));
                !finite || Aabb::of(places.iter().flatten()).overlaps(&bounds)
            });
            let expected: Vec<u32> = expected.collect();
            let mut found = Vec::new();
            let Topology { clusters, tets, .. } = &mut topology;
            clusters.near(&bounds, 1.0, tets, [&before, &now], |element| {
                found.push(element)
            });
            found.sort_unstable();
            assert_eq!(found, expected, "step {step}");
            some += usize::from(!found.is_empty());
            none += usize::from(found.is_empty());
            if step % 4 == 0 {
                let center = vector();
                let [along, across] = [vector(), vector()].map(|v| v.normalize() * 20.0);
                let corner = |s: f64, t: f64| center + along * s + across * t;
                let sheet = Sheet::quad(
                    [corner(-1.0, -1.0), corner(1.0, -1.0)],
                    [corner(-1.0, 1.0), corner(1.0, 1.0)],
                );
                let positions = mesh.positions.clone();
                let blade = Blade::Sheet {
                    sheet: &sheet,
                    positions: &positions,
                };
                let made = topology.cut(&mesh, &mut Stroke::new(), &blade, &Settings::default());
                if let Some(cut) = made.unwrap() {
                    mesh.apply(&cut.edit).unwrap();
                }
            }
        }
        assert!(
            some > 10 && none > 10 && topology.clusters.clusters.len() > 20,
            "{some}, {none}"
        );
    }
}
