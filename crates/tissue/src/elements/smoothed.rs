//! Smoothing domains: the deformation gradient is the mean over the tetrahedra around an edge or a node, or of a patch.
//!
//! A tetrahedron gives a sixth of its volume to each of its edges, or a quarter to each of its nodes; the gradients of a domain
//! are the means of those of its tetrahedra, weighted with these volumes, so that F = Σ x_i ⊗ b_i still is exact for a linear
//! displacement (Liu, Nguyen-Thoi 2010: ES-FEM-T4, NS-FEM-T4). Fewer constraints of volume than tetrahedra remain, which is what
//! keeps nearly incompressible tissue from locking. Domains are made of the elements that are given: those of one region, so
//! nothing is smoothed across a layer.
//!
//! Each domain gathers F from its nodes and scatters its force to them. The alternative, F once per tetrahedron and means of those,
//! takes the same time around edges (39 ns per tetrahedron, both measured), but a pass and memory more.

use super::domains::{Domains, add_balanced, lanes_in, natural_shape};
use super::key::Key;
use super::splice::{make_room, splice};
use crate::elements::NodeWindow;
use crate::lanes::{FourVectors, matrix_of};
use crate::law::decomposition::symmetric_eigen;
use microsim_mesh::{FAMILIES, TetMesh};
use nalgebra::{Matrix3, Vector3};
use std::ops::Range;

/// More elements than that around an edge make more than one patch.
const LARGEST_PATCH: usize = 6;

/// The fraction of its volume that a tetrahedron gives to each of its edges.
pub(crate) const EDGE_FRACTION: f64 = 1.0 / 6.0;

/// And to each of its nodes.
pub(crate) const NODE_FRACTION: f64 = 0.25;

/// Domains of any number of nodes, as arrays.
#[derive(Clone, Debug)]
pub struct SmoothingDomains {
    /// Start and end of each domain among the nodes and gradients.
    runs: Vec<[u32; 2]>,
    /// The starts of the gaps that edits left, by their lengths.
    gaps: Vec<Vec<u32>>,
    nodes: Vec<u32>,
    gradients: Vec<Vector3<f64>>,
    volumes: Vec<f64>,
    /// Fibre directions, if the mesh has any.
    directions: Vec<[Vector3<f64>; FAMILIES]>,
    keys: Keys,
}

/// By what an edit finds domains.
#[derive(Clone, Debug)]
enum Keys {
    /// The edge or the node that each is around.
    Around(Vec<Key>),
    /// The tetrahedra of each.
    Of(Vec<Vec<Key>>),
}

impl SmoothingDomains {
    /// One domain per edge of these elements, in ascending order of the edges.
    pub fn around_edges(mesh: &TetMesh, elements: &[u32]) -> Self {
        let around = elements.iter().flat_map(|&element| {
            mesh.element_edges(element as usize)
                .map(|edge| (Key::new(&edge), element))
        });
        let mut around: Vec<_> = around.collect();
        around.sort_unstable();
        Self::around(mesh, &around, EDGE_FRACTION)
    }

    /// One domain per node of these elements, in ascending order.
    pub fn around_nodes(mesh: &TetMesh, elements: &[u32]) -> Self {
        let around = elements.iter().flat_map(|&element| {
            mesh.tets[element as usize].map(|node| (Key::new(&[node]), element))
        });
        let mut around: Vec<_> = around.collect();
        around.sort_unstable();
        Self::around(mesh, &around, NODE_FRACTION)
    }

    /// One domain per patch of about five elements around a common edge.
    ///
    /// Edges are taken by the number of their elements that are not in a patch yet, the longest first among equals (of the six
    /// tetrahedra of a cell that is their common diagonal); elements that are left alone go to the smallest patch across a face.
    pub fn of_patches(mesh: &TetMesh, elements: &[u32]) -> Self {
        let patches = patches(mesh, elements);
        let mut members: Vec<_> = patches.into_iter().zip(elements.iter().copied()).collect();
        members.sort_unstable();
        Self::of(mesh, &members)
    }

    /// One domain per key, around an edge or a node: of each of its elements this fraction of the volume. Pairs of key and element
    /// are ascending.
    pub(crate) fn around(mesh: &TetMesh, around: &[(Key, u32)], share: f64) -> Self {
        let mut domains = Self::new(Keys::Around(Vec::new()));
        // m tetrahedra around an edge have m + 2 or m + 3 nodes; there are more than four around most.
        domains.nodes.reserve(2 * around.len());
        domains.gradients.reserve(2 * around.len());
        let mut shares = Vec::new();
        for members in around.chunk_by(|a, b| a.0 == b.0) {
            domains.push(mesh, members, share, &mut shares);
            if let Keys::Around(keys) = &mut domains.keys {
                keys.push(members[0].0);
            }
        }
        domains
    }

    /// One domain per patch; pairs of patch and element are ascending.
    pub(crate) fn of(mesh: &TetMesh, members: &[(u32, u32)]) -> Self {
        let mut domains = Self::new(Keys::Of(Vec::new()));
        let mut shares = Vec::new();
        for members in members.chunk_by(|a, b| a.0 == b.0) {
            domains.push(mesh, members, 1.0, &mut shares);
            if let Keys::Of(keys) = &mut domains.keys {
                let tets = members
                    .iter()
                    .map(|(_, element)| &mesh.tets[*element as usize]);
                keys.push(tets.map(|tet| Key::new(tet)).collect());
            }
        }
        domains
    }

    fn new(keys: Keys) -> Self {
        Self {
            runs: Vec::new(),
            gaps: Vec::new(),
            nodes: Vec::new(),
            gradients: Vec::new(),
            volumes: Vec::new(),
            directions: Vec::new(),
            keys,
        }
    }

    /// Adds a domain of these elements; the last argument is working memory.
    fn push<K>(
        &mut self,
        mesh: &TetMesh,
        members: &[(K, u32)],
        share: f64,
        shares: &mut Vec<(u32, Vector3<f64>)>,
    ) {
        shares.clear();
        let mut volume = 0.0;
        let mut tensors = [Matrix3::zeros(); FAMILIES];
        for &(_, element) in members {
            let ([g1, g2, g3], of_element) = natural_shape(mesh, element as usize);
            let part = share * of_element;
            volume += part;
            if let Some(directions) = mesh.directions.get(element as usize) {
                for (tensor, a) in tensors.iter_mut().zip(directions) {
                    *tensor += a * a.transpose() * part;
                }
            }
            let gradients = [-(g1 + g2 + g3), g1, g2, g3];
            let nodes = mesh.tets[element as usize].into_iter();
            // The shares of a node are summed in the order of the elements. There are few nodes.
            for (node, gradient) in nodes.zip(gradients) {
                match shares.iter_mut().find(|(other, _)| *other == node) {
                    Some((_, sum)) => *sum += gradient * part,
                    None => shares.push((node, gradient * part)),
                }
            }
        }
        shares.sort_unstable_by_key(|(node, _)| *node);
        let start = self.nodes.len() as u32;
        for (node, sum) in shares {
            self.nodes.push(*node);
            self.gradients.push(*sum / volume);
        }
        self.volumes.push(volume);
        self.runs.push([start, self.nodes.len() as u32]);
        if !mesh.directions.is_empty() {
            let means = tensors.each_ref().map(mean_direction);
            self.directions.push(means);
        }
    }

    /// Writes nodes and gradients of a domain into a gap of their number, or at the end; returns start and end.
    fn enter(&mut self, nodes: &[u32], gradients: &[Vector3<f64>]) -> [u32; 2] {
        let gaps = self.gaps.get_mut(nodes.len());
        let start = gaps.and_then(Vec::pop).unwrap_or(self.nodes.len() as u32);
        let end = start as usize + nodes.len();
        if end > self.nodes.len() {
            self.nodes.resize(end, 0);
            self.gradients.resize(end, Vector3::zeros());
        }
        self.nodes[start as usize..end].copy_from_slice(nodes);
        self.gradients[start as usize..end].copy_from_slice(gradients);
        [start, end as u32]
    }

    #[inline(always)]
    fn run(&self, domain: usize) -> std::ops::Range<usize> {
        let [start, end] = self.runs[domain];
        start as usize..end as usize
    }
}

/// The direction that lines have in the mean: the axis of the largest eigenvalue of Σ V a ⊗ a, in which a and −a are one. Zero where
/// there are none.
fn mean_direction(tensor: &Matrix3<f64>) -> Vector3<f64> {
    if *tensor == Matrix3::zeros() {
        return Vector3::zeros();
    }
    let (values, axes) = symmetric_eigen(tensor);
    axes.column(values.imax()).into_owned()
}

/// The patch of each of these elements.
pub(crate) fn patches(mesh: &TetMesh, elements: &[u32]) -> Vec<u32> {
    const NONE: u32 = u32::MAX;
    let indices = || elements.iter().zip(0u32..);
    let edges = indices().flat_map(|(&element, index)| {
        mesh.element_edges(element as usize)
            .map(|edge| (edge, index))
    });
    let mut edges: Vec<([u32; 2], u32)> = edges.collect();
    edges.sort_unstable();
    let length =
        |[a, b]: [u32; 2]| (mesh.positions[a as usize] - mesh.positions[b as usize]).norm_squared();
    let rings = edges.chunk_by(|a, b| a.0 == b.0);
    let mut rings: Vec<_> = rings.map(|ring| (length(ring[0].0), ring)).collect();
    rings.sort_by(|(a, _), (b, _)| b.total_cmp(a));
    let most = rings.iter().map(|(_, ring)| ring.len()).max().unwrap_or(0);
    let mut patches = vec![NONE; elements.len()];
    let mut sizes: Vec<usize> = Vec::new();
    // A ring only shrinks, so going down the sizes sees every edge at its own.
    for size in (2..=most.min(LARGEST_PATCH)).rev() {
        for (_, ring) in &rings {
            let free = |(_, index): &&([u32; 2], u32)| patches[*index as usize] == NONE;
            if ring.len() < size || ring.iter().filter(free).count() < size {
                continue;
            }
            let members: Vec<u32> = ring.iter().filter(free).map(|m| m.1).take(size).collect();
            for index in members {
                patches[index as usize] = sizes.len() as u32;
            }
            sizes.push(size);
        }
    }
    if !patches.contains(&NONE) {
        return patches;
    }
    let faces_of = |element: u32| {
        let [a, b, c, d] = mesh.tets[element as usize];
        [[b, c, d], [a, c, d], [a, b, d], [a, b, c]].map(|mut face| {
            face.sort_unstable();
            face
        })
    };
    let faces = indices().flat_map(|(&element, index)| faces_of(element).map(|face| (face, index)));
    let mut faces: Vec<([u32; 3], u32)> = faces.collect();
    faces.sort_unstable();
    for index in 0..elements.len() {
        if patches[index] != NONE {
            continue;
        }
        let across = faces_of(elements[index])
            .into_iter()
            .flat_map(|face| {
                let first = faces.partition_point(|(other, _)| *other < face);
                faces[first..]
                    .iter()
                    .take_while(move |(other, _)| *other == face)
            })
            .map(|(_, other)| patches[*other as usize])
            .filter(|patch| *patch != NONE);
        patches[index] = across
            .min_by_key(|patch| (sizes[*patch as usize], *patch))
            .unwrap_or_else(|| {
                sizes.push(0);
                sizes.len() as u32 - 1
            });
        sizes[patches[index] as usize] += 1;
    }
    patches
}

impl Domains for SmoothingDomains {
    fn count(&self) -> usize {
        self.volumes.len()
    }

    fn nodes(&self, domain: usize) -> &[u32] {
        &self.nodes[self.run(domain)]
    }

    fn volume(&self, domain: usize) -> f64 {
        self.volumes[domain]
    }

    fn directions(&self, domain: usize) -> [Vector3<f64>; FAMILIES] {
        let directions = self.directions.get(domain);
        directions.copied().unwrap_or_default()
    }

    fn scale_volume(&mut self, domain: usize, factor: f64) {
        self.volumes[domain] *= factor;
    }

    fn shift_nodes(&mut self, by: u32) {
        self.nodes.iter_mut().for_each(|n| *n += by);
        let shift = |keys: &mut [Key]| {
            for key in keys {
                *key = key.shifted(by);
            }
        };
        match &mut self.keys {
            Keys::Around(keys) => shift(keys),
            Keys::Of(patches) => patches.iter_mut().for_each(|keys| shift(keys)),
        }
    }

    fn keys(&self, domain: usize, visit: &mut dyn FnMut(Key)) {
        match &self.keys {
            Keys::Around(keys) => visit(keys[domain]),
            Keys::Of(patches) => patches[domain].iter().for_each(|key| visit(*key)),
        }
    }

    fn splice(&mut self, removed: &[u32], added: &Self) -> bool {
        match (&mut self.keys, &added.keys) {
            (Keys::Around(keys), Keys::Around(added)) => splice(keys, removed, added),
            (Keys::Of(keys), Keys::Of(added)) => splice(keys, removed, added),
            (Keys::Around(_), Keys::Of(_)) | (Keys::Of(_), Keys::Around(_)) => return false,
        }
        for &place in removed {
            let [start, end] = self.runs[place as usize];
            let length = (end - start) as usize;
            if self.gaps.len() <= length {
                self.gaps.resize(length + 1, Vec::new());
            }
            self.gaps[length].push(start);
        }
        let runs = (0..added.count()).map(|domain| {
            let run = added.run(domain);
            self.enter(&added.nodes[run.clone()], &added.gradients[run])
        });
        let runs: Vec<[u32; 2]> = runs.collect();
        splice(&mut self.runs, removed, &runs);
        splice(&mut self.volumes, removed, &added.volumes);
        if !self.directions.is_empty() {
            splice(&mut self.directions, removed, &added.directions);
        }
        true
    }

    fn make_room(&mut self) {
        make_room(&mut self.runs);
        make_room(&mut self.nodes);
        make_room(&mut self.gradients);
        make_room(&mut self.volumes);
        make_room(&mut self.directions);
        match &mut self.keys {
            Keys::Around(keys) => make_room(keys),
            Keys::Of(keys) => make_room(keys),
        }
    }

    fn gradient(&self, domain: usize, i: usize) -> Vector3<f64> {
        self.gradients[self.run(domain)][i]
    }

    /// Differences to the first node keep the digits of a small domain far from the origin.
    #[inline(always)]
    fn deformation(&self, domain: usize, positions: &[Vector3<f64>]) -> Matrix3<f64> {
        let run = self.run(domain);
        let (nodes, gradients) = (&self.nodes[run.clone()], &self.gradients[run]);
        let origin = positions[nodes[0] as usize];
        let mut columns = [Vector3::zeros(); 3];
        for (node, b) in nodes[1..].iter().zip(&gradients[1..]) {
            let along = positions[*node as usize] - origin;
            columns[0] += along * b[0];
            columns[1] += along * b[1];
            columns[2] += along * b[2];
        }
        Matrix3::from_columns(&columns)
    }

    #[inline(always)]
    fn add_forces_of_four(
        &self,
        first: usize,
        range: &Range<usize>,
        stress: &[FourVectors; 3],
        forces: &mut NodeWindow<'_>,
    ) {
        for lane in lanes_in(first, range) {
            let run = self.run(first + lane);
            let (nodes, gradients) = (&self.nodes[run.clone()], &self.gradients[run]);
            let scaled = matrix_of(stress, lane) * -self.volumes[first + lane];
            add_balanced(&scaled, nodes, gradients, forces);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::block_mesh;

    #[test]
    fn the_patches_of_a_block_are_its_cells() {
        let mesh = block_mesh([4.0, 3.0, 2.0], [4, 3, 2]);
        let elements: Vec<u32> = (0..mesh.tets.len() as u32).collect();
        let patches = SmoothingDomains::of_patches(&mesh, &elements);
        assert_eq!(patches.count(), 24);
        for patch in 0..24 {
            // A unit cube of eight nodes; six volumes are summed.
            assert_eq!(patches.nodes(patch).len(), 8);
            assert!((patches.volume(patch) - 1.0).abs() < 1e-14);
        }
    }

    #[test]
    fn every_element_is_in_one_patch_and_few_are_alone() {
        // A corner of cells cut off: rings of many sizes.
        let mesh = block_mesh([5.0; 3], [5; 3]);
        let centre = |e: &u32| mesh.corners(*e as usize).iter().sum::<Vector3<f64>>() / 4.0;
        let elements: Vec<u32> = (0..mesh.tets.len() as u32)
            .filter(|e| centre(e).sum() < 0.3)
            .collect();
        let patches = patches(&mesh, &elements);
        let count = *patches.iter().max().unwrap() as usize + 1;
        let mut sizes = vec![0; count];
        patches.iter().for_each(|patch| sizes[*patch as usize] += 1);
        assert_eq!(sizes.iter().sum::<usize>(), elements.len());
        assert!(sizes.iter().all(|size| *size > 0));
        // What is left alone joins a neighbour, and there is one for every element of this body.
        assert!(sizes.iter().filter(|size| **size == 1).count() * 20 <= count);
        assert!(elements.len() > 4 * count, "{} in {count}", elements.len());
    }
}
