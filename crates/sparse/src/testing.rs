//! What the tests of several modules use: vectors of random numbers, grids, matrices, their dense form.

use std::sync::Arc;

use microsim_random::Congruential;
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

use crate::{BlockMatrix, Pattern};

pub(crate) fn vectors(random: &mut Congruential, count: usize) -> Vec<Vector3<f64>> {
    (0..count).map(|_| random.vector()).collect()
}

/// `count` cliques of one to four nodes.
pub(crate) fn cliques(random: &mut Congruential, nodes: usize, count: usize) -> Vec<Vec<u32>> {
    let mut clique = || {
        (0..1 + random.below(4))
            .map(|_| random.below(nodes) as u32)
            .collect()
    };
    (0..count).map(|_| clique()).collect()
}

/// Nodes of a grid of unit cells and the edges of six tetrahedra per cell: all pairs of nodes that differ by 0 or 1 in
/// each coordinate, none by −1.
pub(crate) fn grid(size: [usize; 3]) -> (Vec<Vector3<f64>>, Vec<[u32; 2]>) {
    let node = |x: usize, y: usize, z: usize| ((x * size[1] + y) * size[2] + z) as u32;
    let mut positions = Vec::new();
    let mut edges = Vec::new();
    for x in 0..size[0] {
        for y in 0..size[1] {
            for z in 0..size[2] {
                positions.push(Vector3::new(x as f64, y as f64, z as f64));
                for step in 1..8 {
                    let to = [x + step / 4, y + step / 2 % 2, z + step % 2];
                    if to.iter().zip(&size).all(|(at, size)| at < size) {
                        edges.push([node(x, y, z), node(to[0], to[1], to[2])]);
                    }
                }
            }
        }
    }
    (positions, edges)
}

/// Springs along the edges, with some stiffness across: a free elastic body, semidefinite.
pub(crate) fn elastic(positions: &[Vector3<f64>], edges: &[[u32; 2]]) -> BlockMatrix {
    let pattern = Arc::new(Pattern::from_cliques(positions.len(), edges));
    let mut matrix = BlockMatrix::zeros(pattern);
    for edge in edges {
        let [i, j] = edge.map(|node| node as usize);
        let along = (positions[j] - positions[i]).normalize();
        let block = along * along.transpose() + Matrix3::identity() * 0.1;
        matrix.add_diagonal(i, &block);
        matrix.add_diagonal(j, &block);
        matrix.add(i, j, &-block);
    }
    matrix
}

/// Σ over random cliques of G Gᵀ, G a random column of blocks, plus `shift` on the diagonal: definite for `shift` > 0.
pub(crate) fn random_matrix(
    random: &mut Congruential,
    nodes: usize,
    cliques: usize,
    shift: f64,
) -> BlockMatrix {
    let cliques = self::cliques(random, nodes, cliques);
    let mut matrix = BlockMatrix::zeros(Arc::new(Pattern::from_cliques(nodes, &cliques)));
    for clique in &cliques {
        let mut clique = clique.clone();
        clique.sort_unstable();
        clique.dedup();
        let blocks: Vec<Matrix3<f64>> = clique
            .iter()
            .map(|_| Matrix3::from_fn(|_, _| random.number()))
            .collect();
        for (i, a) in clique.iter().zip(&blocks) {
            for (j, b) in clique.iter().zip(&blocks).filter(|(j, _)| *j <= i) {
                matrix.add(*i as usize, *j as usize, &(a * b.transpose()));
            }
        }
    }
    (0..nodes).for_each(|i| matrix.add_diagonal(i, &(Matrix3::identity() * shift)));
    matrix
}

pub(crate) fn dense(matrix: &BlockMatrix) -> DMatrix<f64> {
    let pattern = matrix.pattern();
    let mut dense = DMatrix::zeros(3 * pattern.nodes(), 3 * pattern.nodes());
    for i in 0..pattern.nodes() {
        for (k, &j) in pattern.row(i).iter().enumerate() {
            let block = matrix.values()[pattern.first_slot(i) + k];
            let j = j as usize;
            dense
                .fixed_view_mut::<3, 3>(3 * j, 3 * i)
                .copy_from(&block.transpose());
            dense.fixed_view_mut::<3, 3>(3 * i, 3 * j).copy_from(&block);
        }
    }
    dense
}

pub(crate) fn dense_vector(x: &[Vector3<f64>]) -> DVector<f64> {
    DVector::from_iterator(3 * x.len(), x.iter().flat_map(|x| x.iter().copied()))
}

/// Bits of vectors, for exact comparison.
pub(crate) fn bits(x: &[Vector3<f64>]) -> Vec<u64> {
    x.iter()
        .flat_map(|x| x.iter().map(|v| v.to_bits()))
        .collect()
}
