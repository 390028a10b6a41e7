//! Matrices of single elements, and how they enter the matrix of a body.

use super::Elements;
use microsim_sparse::Pattern;
use nalgebra::{Matrix3, Vector3};
use std::sync::Arc;

/// A dense matrix of 3×3 blocks over the nodes of one element.
#[derive(Clone, Debug, Default)]
pub struct ElementMatrix {
    nodes: usize,
    blocks: Vec<Matrix3<f64>>,
}

impl ElementMatrix {
    /// An empty matrix; its memory is retained from element to element.
    pub fn new() -> Self {
        Self::default()
    }

    /// Makes it a zero matrix over `nodes` nodes.
    pub fn reset(&mut self, nodes: usize) {
        self.nodes = nodes;
        self.blocks.clear();
        self.blocks.resize(nodes * nodes, Matrix3::zeros());
    }

    /// Number of nodes.
    pub fn nodes(&self) -> usize {
        self.nodes
    }

    /// The block of row node `i` and column node `j`.
    #[inline]
    pub fn block(&self, i: usize, j: usize) -> &Matrix3<f64> {
        &self.blocks[i * self.nodes + j]
    }

    /// The block of row node `i` and column node `j`.
    #[inline]
    pub fn block_mut(&mut self, i: usize, j: usize) -> &mut Matrix3<f64> {
        &mut self.blocks[i * self.nodes + j]
    }

    /// Adds factor·g gᵀ, `g` one vector per node.
    pub fn add_outer(&mut self, g: &[Vector3<f64>], factor: f64) {
        for (i, gi) in g.iter().enumerate() {
            let scaled = gi * factor;
            for (j, gj) in g.iter().enumerate() {
                *self.block_mut(i, j) += scaled * gj.transpose();
            }
        }
    }
}

/// Where the blocks of the elements of one set go in the matrix of a body.
#[derive(Clone, Debug)]
pub struct Slots {
    /// Those of element e are `places[starts[e]..starts[e + 1]]`.
    starts: Vec<u32>,
    /// For the pairs of nodes (i, j ≤ i) in ascending order: twice the slot of the matrix, plus one where the block (j, i) is
    /// stored there.
    places: Vec<u32>,
}

impl Slots {
    /// The pattern of a body of so many nodes, and of each of its sets the slots.
    pub fn of_sets<'a>(
        nodes: usize,
        sets: impl IntoIterator<Item = &'a dyn Elements> + Clone,
    ) -> (Arc<Pattern>, Vec<Self>) {
        let elements = |set: &'a dyn Elements| (0..set.count()).map(|element| set.nodes(element));
        let cliques = sets.clone().into_iter().flat_map(elements);
        let (pattern, all) = Pattern::with_slots(nodes, cliques);
        let mut rest = &all[..];
        let slots = sets.into_iter().map(|set| {
            let mut starts = Vec::with_capacity(set.count() + 1);
            starts.push(0);
            let mut end = 0;
            for nodes in elements(set) {
                end += (nodes.len() * (nodes.len() + 1) / 2) as u32;
                starts.push(end);
            }
            let places;
            (places, rest) = rest.split_at(end as usize);
            Self {
                starts,
                places: places.to_vec(),
            }
        });
        let slots = slots.collect();
        (Arc::new(pattern), slots)
    }

    /// Those of one element.
    #[inline]
    fn of(&self, element: usize) -> &[u32] {
        &self.places[self.starts[element] as usize..self.starts[element + 1] as usize]
    }
}

/// The matrix of a body, as the elements of one set see it.
#[derive(Debug)]
pub struct MatrixWindow<'a> {
    /// Where the blocks go.
    pub slots: &'a Slots,
    /// The blocks by slot.
    pub values: &'a mut [Matrix3<f64>],
}

impl MatrixWindow<'_> {
    /// Adds factor·`block`, the matrix of an element.
    pub fn add(&mut self, element: usize, block: &ElementMatrix, factor: f64) {
        self.add_pairs(element, block.nodes(), |i, j| block.block(i, j) * factor);
    }

    /// Adds the symmetric matrix of an element of so many nodes; `block` gives that of row node i and column node j.
    #[inline(always)]
    pub fn add_pairs(
        &mut self,
        element: usize,
        nodes: usize,
        block: impl Fn(usize, usize) -> Matrix3<f64>,
    ) {
        let mut places = self.slots.of(element).iter();
        for i in 0..nodes {
            for (j, place) in (0..=i).zip(&mut places) {
                let (row, column) = if place % 2 == 0 { (i, j) } else { (j, i) };
                self.values[(place / 2) as usize] += block(row, column);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_outer_product_is_symmetric_and_adds_up() {
        let g = [Vector3::new(1.0, 2.0, 3.0), Vector3::new(-4.0, 0.5, 2.0)];
        let mut matrix = ElementMatrix::new();
        matrix.reset(2);
        matrix.add_outer(&g, 2.0);
        matrix.add_outer(&g, 1.0);
        for i in 0..2 {
            for j in 0..2 {
                for (r, c) in (0..9).map(|k| (k / 3, k % 3)) {
                    assert_eq!(matrix.block(i, j)[(r, c)], 3.0 * g[i][r] * g[j][c]);
                }
            }
        }
        matrix.reset(1);
        assert_eq!((matrix.nodes(), *matrix.block(0, 0)), (1, Matrix3::zeros()));
    }
}
