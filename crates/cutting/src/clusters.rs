//! Groups of elements that lie together, with their nodes: where is an element near a blade?
//!
//! The nodes move in every step, so no tree stays right without looking at all of them. A group has half as many nodes as
//! elements: boxes around groups cost little more than a nanosecond per element of the body, and the elements of those
//! groups alone are looked at whose box a blade comes into. Groups grow as their elements are divided and are halved when
//! they have become large.

use microsim_geometry::Aabb;
use microsim_mesh::TetMesh;
use nalgebra::Vector3;

/// Elements in a new group, at most.
const NEW: usize = 64;

/// A group with more elements is halved.
const LARGE: usize = 160;

#[derive(Clone, Debug, Default)]
struct Cluster {
    elements: Vec<u32>,
    /// All nodes of its elements, and some that were so.
    nodes: Vec<u32>,
}

/// The groups of a body.
#[derive(Clone, Debug, Default)]
pub(crate) struct Clusters {
    clusters: Vec<Cluster>,
    /// Group of each element.
    of: Vec<u32>,
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
            self.add(elements.to_vec(), tets);
        }
    }

    fn add(&mut self, elements: Vec<u32>, tets: &[[u32; 4]]) {
        let index = self.clusters.len() as u32;
        self.put(index as usize, elements, tets);
    }

    /// Makes group `index`, or the next one, of these elements.
    fn put(&mut self, index: usize, elements: Vec<u32>, tets: &[[u32; 4]]) {
        let mut nodes: Vec<u32> = elements.iter().flat_map(|&e| tets[e as usize]).collect();
        nodes.sort_unstable();
        nodes.dedup();
        for &element in &elements {
            self.of[element as usize] = index as u32;
        }
        let cluster = Cluster { elements, nodes };
        match self.clusters.get_mut(index) {
            Some(place) => *place = cluster,
            None => self.clusters.push(cluster),
        }
    }

    /// Calls `found` for the elements whose corners' way from the first to the second positions comes into `bounds`, or is not
    /// finite.
    pub(crate) fn near(
        &self,
        bounds: &Aabb,
        tets: &[[u32; 4]],
        positions: [&[Vector3<f64>]; 2],
        mut found: impl FnMut(u32),
    ) {
        let rests = std::ptr::eq(positions[0], positions[1]);
        let is_near = |nodes: &[u32]| {
            let mut around = Aabb::empty();
            let mut finite = 0.0;
            for &node in nodes {
                for place in positions.iter().take(if rests { 1 } else { 2 }) {
                    if let Some(place) = place.get(node as usize) {
                        around.include(place);
                        // 0, or not a number.
                        finite += (place.x + place.y + place.z) * 0.0;
                    }
                }
            }
            around.overlaps(bounds) || finite != 0.0
        };
        for cluster in &self.clusters {
            if is_near(&cluster.nodes) {
                for &element in &cluster.elements {
                    if is_near(&tets[element as usize]) {
                        found(element);
                    }
                }
            }
        }
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
            self.put(index, first, tets);
            self.add(second, tets);
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
