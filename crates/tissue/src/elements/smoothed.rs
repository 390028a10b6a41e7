//! Smoothing domains: the deformation gradient is the mean over the tetrahedra around an edge or a node, or of a patch.
//!
//! A tetrahedron gives a sixth of its volume to each of its edges, or a quarter to each of its nodes; the gradients of a domain
//! are the means of those of its tetrahedra, weighted with these volumes, so that F = Σ x_i ⊗ b_i still is exact for a linear
//! displacement (Liu, Nguyen-Thoi 2010: ES-FEM-T4, NS-FEM-T4). Fewer constraints of volume than tetrahedra remain, which is what
//! keeps nearly incompressible tissue from locking. Domains are made of the elements that are given: those of one region, so
//! nothing is smoothed across a layer.
//!
//! Each domain gathers F from its nodes and scatters its force to them. The other way, F once per tetrahedron and means of those,
//! takes the same time around edges (39 ns per tetrahedron, both measured), but a pass and memory more.

use super::domains::{Domains, product, shape};
use crate::elements::NodeWindow;
use microsim_mesh::TetMesh;
use nalgebra::{Matrix3, Vector3};
use std::collections::BTreeMap;

/// More elements than that around an edge make more than one patch.
const LARGEST_PATCH: usize = 6;

/// Domains of any number of nodes, as arrays: those of domain d are `starts[d]..starts[d + 1]`.
#[derive(Clone, Debug)]
pub struct SmoothingDomains {
    starts: Vec<u32>,
    nodes: Vec<u32>,
    gradients: Vec<Vector3<f64>>,
    volumes: Vec<f64>,
}

impl SmoothingDomains {
    /// One domain per edge of these elements, in ascending order of the edges.
    pub fn around_edges(mesh: &TetMesh, elements: &[u32]) -> Self {
        let around = elements.iter().flat_map(|&element| {
            mesh.element_edges(element as usize)
                .map(|edge| (edge, element))
        });
        Self::new(mesh, around.collect(), 1.0 / 6.0)
    }

    /// One domain per node of these elements, in ascending order.
    pub fn around_nodes(mesh: &TetMesh, elements: &[u32]) -> Self {
        let around = elements
            .iter()
            .flat_map(|&element| mesh.tets[element as usize].map(|node| (node, element)));
        Self::new(mesh, around.collect(), 0.25)
    }

    /// One domain per patch of about five elements around a common edge.
    ///
    /// Edges are taken by the number of their elements that are not in a patch yet, the longest first among equals (of the six
    /// tetrahedra of a cell that is their common diagonal); elements that are left alone go to the smallest patch across a face.
    pub fn of_patches(mesh: &TetMesh, elements: &[u32]) -> Self {
        let patches = patches(mesh, elements);
        let around = patches.into_iter().zip(elements.iter().copied());
        Self::new(mesh, around.collect(), 1.0)
    }

    /// One domain per key: of each of its elements the share `share` of the volume.
    fn new<K: Ord + Copy>(mesh: &TetMesh, mut around: Vec<(K, u32)>, share: f64) -> Self {
        around.sort_unstable();
        let mut domains = Self {
            starts: vec![0],
            nodes: Vec::new(),
            gradients: Vec::new(),
            volumes: Vec::new(),
        };
        let mut shares: Vec<(u32, Vector3<f64>)> = Vec::new();
        for members in around.chunk_by(|a, b| a.0 == b.0) {
            shares.clear();
            let mut volume = 0.0;
            for &(_, element) in members {
                let ([g1, g2, g3], of_element) = shape(&mesh.corners(element as usize));
                let part = share * of_element;
                volume += part;
                let gradients = [-(g1 + g2 + g3), g1, g2, g3];
                shares.extend(
                    mesh.tets[element as usize]
                        .into_iter()
                        .zip(gradients.map(|g| g * part)),
                );
            }
            // Stable: the shares of a node are summed in the order of the elements.
            shares.sort_by_key(|(node, _)| *node);
            for of_node in shares.chunk_by(|a, b| a.0 == b.0) {
                let sum: Vector3<f64> = of_node.iter().map(|(_, share)| share).sum();
                domains.nodes.push(of_node[0].0);
                domains.gradients.push(sum / volume);
            }
            domains.volumes.push(volume);
            domains.starts.push(domains.nodes.len() as u32);
        }
        domains
    }

    #[inline(always)]
    fn run(&self, domain: usize) -> std::ops::Range<usize> {
        self.starts[domain] as usize..self.starts[domain + 1] as usize
    }
}

/// The patch of each of these elements.
fn patches(mesh: &TetMesh, elements: &[u32]) -> Vec<u32> {
    const NONE: u32 = u32::MAX;
    let mut rings: BTreeMap<[u32; 2], Vec<u32>> = BTreeMap::new();
    for (index, &element) in elements.iter().enumerate() {
        for [a, b] in mesh.element_edges(element as usize) {
            let edge = [a.min(b), a.max(b)];
            rings.entry(edge).or_default().push(index as u32);
        }
    }
    let length =
        |[a, b]: [u32; 2]| (mesh.positions[a as usize] - mesh.positions[b as usize]).norm_squared();
    let mut edges: Vec<([u32; 2], Vec<u32>)> = rings.into_iter().collect();
    edges.sort_by(|(a, ..), (b, ..)| length(*b).total_cmp(&length(*a)));
    let most = edges.iter().map(|(_, ring)| ring.len()).max().unwrap_or(0);
    let mut patches = vec![NONE; elements.len()];
    let mut sizes: Vec<usize> = Vec::new();
    // A ring only shrinks, so going down the sizes sees every edge at its own.
    for size in (2..=most.min(LARGEST_PATCH)).rev() {
        for (_, ring) in &edges {
            let free = |index: &&u32| patches[**index as usize] == NONE;
            let mut members: Vec<u32> = ring.iter().filter(free).copied().collect();
            if members.len() < size {
                continue;
            }
            members.truncate(size);
            for index in members {
                patches[index as usize] = sizes.len() as u32;
            }
            sizes.push(size);
        }
    }
    let mut faces: BTreeMap<[u32; 3], Vec<u32>> = BTreeMap::new();
    for (index, &element) in elements.iter().enumerate() {
        let [a, b, c, d] = mesh.tets[element as usize];
        for mut face in [[b, c, d], [a, c, d], [a, b, d], [a, b, c]] {
            face.sort_unstable();
            faces.entry(face).or_default().push(index as u32);
        }
    }
    for index in 0..elements.len() {
        if patches[index] != NONE {
            continue;
        }
        let [a, b, c, d] = mesh.tets[elements[index] as usize];
        let across = [[b, c, d], [a, c, d], [a, b, d], [a, b, c]]
            .into_iter()
            .flat_map(|mut face| {
                face.sort_unstable();
                &faces[&face]
            })
            .map(|other| patches[*other as usize])
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

    fn scale_volumes(&mut self, factors: &[f64]) {
        for (volume, factor) in self.volumes.iter_mut().zip(factors) {
            *volume *= factor;
        }
    }

    fn shift_nodes(&mut self, by: u32) {
        self.nodes.iter_mut().for_each(|n| *n += by);
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
    fn add_forces(&self, domain: usize, stress: &Matrix3<f64>, forces: &mut NodeWindow<'_>) {
        let run = self.run(domain);
        let (nodes, gradients) = (&self.nodes[run.clone()], &self.gradients[run]);
        let scaled = stress * -self.volumes[domain];
        let mut sum = Vector3::zeros();
        for (node, b) in nodes[1..].iter().zip(&gradients[1..]) {
            let force = product(&scaled, b);
            sum += force;
            forces.add(*node, force);
        }
        forces.add(nodes[0], -sum);
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
