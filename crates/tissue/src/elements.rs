//! What holds a body together, as sets of elements of one kind.
//!
//! An element is a function of a few nodes with an energy; a set holds many of one kind as arrays. Solvers, bounds of the
//! step and reports see only the trait [`Elements`], so a new kind of element is one file. Calls cross the trait once per
//! range of elements for forces, and once per element for matrices.

mod constraint;
mod continuum;
mod continuum_constraints;
mod continuum_matrix;
mod coupling;
mod domains;
mod measure;
mod plasticity;
mod smoothed;

pub use constraint::{Areas, Constraint, ConstraintSet, Springs, Volumes};
pub use continuum::{Continuum, ContinuumSet, Smoothed};
pub use coupling::{CoupleError, Coupling, CouplingConstants, Support, Tie, couple};
pub use domains::{Domains, Tetrahedra};
pub(crate) use measure::{Area, Length, Measure, Volume};
pub use plasticity::Plasticity;
pub use smoothed::SmoothingDomains;

use nalgebra::{Matrix3, Vector3};
use std::fmt::Debug;
use std::ops::Range;
use std::sync::Arc;

/// Where a body is, as its elements see it.
#[derive(Clone, Copy, Debug)]
pub struct Configuration<'a> {
    /// Node positions [m].
    pub positions: &'a [Vector3<f64>],
    /// Node velocities [m/s].
    pub velocities: &'a [Vector3<f64>],
    /// The internal variables of this set (plasticity); empty for a set without any.
    pub internal: &'a [f64],
}

/// Kinds of energy, for reports.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum EnergyKind {
    /// Springs along edges.
    Length,
    /// Triangles.
    Area,
    /// Tetrahedra's volumes.
    Volume,
    /// Strain energy of a continuum.
    Strain,
    /// Soft couplings between parts.
    Coupling,
}

/// Which second derivative of the energy is wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tangent {
    /// The exact one, which may be indefinite under compression.
    Exact,
    /// The nearest one (per element) without negative eigenvalues: a system with it can always be solved.
    Positive,
}

/// A set of elements of one kind.
pub trait Elements: Debug + Send + Sync {
    /// Which energy it is.
    fn kind(&self) -> EnergyKind;

    /// Number of elements.
    fn count(&self) -> usize;

    /// Nodes of one element, each once.
    fn nodes(&self, element: usize) -> &[u32];

    /// Internal variables at the start; empty for elements without any.
    fn initial_internal(&self) -> Vec<f64> {
        Vec::new()
    }

    /// Energy of all elements [J], summed in ascending order.
    fn energy(&self, at: &Configuration<'_>) -> f64;

    /// Adds elastic and viscous forces −∂E/∂x − D v of the elements in `range` to `forces` [N].
    fn add_forces(&self, range: Range<usize>, at: &Configuration<'_>, forces: &mut NodeWindow<'_>);

    /// Sets `out` to the second derivative of an element's energy by its nodes [N/m].
    fn stiffness(
        &self,
        element: usize,
        at: &Configuration<'_>,
        tangent: Tangent,
        out: &mut ElementMatrix,
    );

    /// Whether any element resists speed: [`damping`](Self::damping) is zero otherwise.
    fn is_viscous(&self) -> bool;

    /// Sets `out` to minus the derivative of an element's viscous force by the velocities of its nodes [N·s/m]; symmetric,
    /// no negative eigenvalue.
    fn damping(&self, element: usize, at: &Configuration<'_>, out: &mut ElementMatrix);

    /// The same set with the energy and the viscous forces of each element times its factor, > 0: the stiffness cap of NUMERICS
    /// 3.5 d.
    fn scaled(&self, factors: &[f64]) -> Arc<dyn Elements>;

    /// Lets internal variables flow for a time `h` [s]; returns whether a stiffness has grown, which may shorten the stable
    /// step.
    fn flow(&self, _positions: &[Vector3<f64>], _internal: &mut [f64], _h: f64) -> bool {
        false
    }

    /// The set as constraints with compliance, if position-based methods can treat it.
    fn constraints(&self) -> Option<&dyn Constraints> {
        None
    }
}

/// A set of elements that position-based methods can treat (XPBD; Macklin, Müller, Chentanez 2016).
pub trait Constraints {
    /// Number of multipliers per element.
    fn multipliers(&self) -> usize;

    /// Projects one element: moves its nodes, and updates its multipliers, for a step of `h` [s].
    ///
    /// `previous` are the positions at the start of the step, for damping.
    #[expect(clippy::too_many_arguments, reason = "the parts of a state stay apart")]
    fn project(
        &self,
        element: usize,
        positions: &mut [Vector3<f64>],
        previous: &[Vector3<f64>],
        inverse_masses: &[f64],
        internal: &[f64],
        multipliers: &mut [f64],
        h: f64,
    );
}

/// A run of nodes with a vector each: what one part of a parallel loop may write.
#[derive(Debug)]
pub struct NodeWindow<'a> {
    /// The first node.
    pub first: u32,
    /// One vector per node from there on.
    pub values: &'a mut [Vector3<f64>],
}

impl NodeWindow<'_> {
    /// Adds to a node of the window.
    #[inline]
    pub fn add(&mut self, node: u32, value: Vector3<f64>) {
        self.values[(node - self.first) as usize] += value;
    }
}

/// A dense matrix of 3×3 blocks over the nodes of one element.
#[derive(Clone, Debug, Default)]
pub struct ElementMatrix {
    nodes: usize,
    blocks: Vec<Matrix3<f64>>,
}

impl ElementMatrix {
    /// An empty matrix; its memory is kept from element to element.
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

#[cfg(test)]
pub(crate) mod contract;

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
