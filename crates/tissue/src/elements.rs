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
pub mod key;
mod matrix;
mod measure;
mod plastic;
mod plastic_flow;
mod plasticity;
mod quadratic;
mod smoothed;
pub mod splice;

pub use constraint::{Areas, Constraint, ConstraintSet, Springs, Volumes};
pub use continuum::{Continuum, ContinuumSet, Quadratic, Smoothed};
pub(crate) use coupling::Followed;
pub use coupling::{
    Bond, Cohesion, CoupleError, Coupling, CouplingConstants, Sliding, SlidingConstants, Support,
    Tie, couple, couple_sliding,
};
pub use domains::{Domains, Tetrahedra};
pub use matrix::{ElementMatrix, MatrixWindow, Slots};
pub(crate) use measure::{Area, Length, Measure, Volume};
pub use plastic::PlasticSet;
pub(crate) use plastic_flow::{BLOCKS, equivalent_strain};
pub use plastic_flow::{ContinuumPlasticity, PlasticState};
pub use plasticity::Plasticity;
pub use quadratic::QuadraturePoints;
pub use smoothed::SmoothingDomains;
pub(crate) use smoothed::{EDGE_FRACTION, NODE_FRACTION, patches};

use key::Key;
use nalgebra::Vector3;
use splice::{Blend, Inherited};
use std::any::Any;
use std::fmt::Debug;
use std::ops::Range;
use std::sync::Arc;

/// Where a body is, as its elements see it.
#[derive(Clone, Copy, Debug)]
pub struct Configuration<'a> {
    /// Node positions \[m\].
    pub positions: &'a [Vector3<f64>],
    /// Node velocities \[m/s\].
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
pub trait Elements: Any + Debug + Send + Sync {
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

    /// Energy of all elements \[J\], summed in ascending order.
    fn energy(&self, at: &Configuration<'_>) -> f64;

    /// Adds elastic and viscous forces −∂E/∂x − D v of the elements in `range` to `forces` \[N\].
    fn add_forces(&self, range: Range<usize>, at: &Configuration<'_>, forces: &mut NodeWindow<'_>);

    /// Sets `out` to the second derivative of an element's energy by its nodes \[N/m\].
    fn stiffness(
        &self,
        element: usize,
        at: &Configuration<'_>,
        tangent: Tangent,
        out: &mut ElementMatrix,
    );

    /// Adds K + b·D of all elements to a matrix, in ascending order: [`stiffness`](Self::stiffness) and `damping` b \[1/s\] times
    /// [`damping`](Self::damping).
    fn add_tangent(
        &self,
        at: &Configuration<'_>,
        tangent: Tangent,
        damping: f64,
        matrix: &mut MatrixWindow<'_>,
    ) {
        let viscous = damping > 0.0 && self.is_viscous();
        let mut block = ElementMatrix::new();
        for element in 0..self.count() {
            self.stiffness(element, at, tangent, &mut block);
            matrix.add(element, &block, 1.0);
            if viscous {
                self.damping(element, at, &mut block);
                matrix.add(element, &block, damping);
            }
        }
    }

    /// Whether ties may begin to slide, turn round or stick in a step: forces have kinks there, and the line search shortens steps that go beyond the lowest
    /// point. Fibres that slacken and cohesive ties that soften have kinks too; whether that would help them has not been tried.
    fn slides(&self) -> bool {
        false
    }

    /// Whether any element resists speed: [`damping`](Self::damping) is zero otherwise.
    fn is_viscous(&self) -> bool;

    /// Sets `out` to minus the derivative of an element's viscous force by the velocities of its nodes \[N·s/m\]; symmetric,
    /// no negative eigenvalue.
    fn damping(&self, element: usize, at: &Configuration<'_>, out: &mut ElementMatrix);

    /// The time by which an element's damping is its stiffness in its natural state \[s\].
    fn relaxation_time(&self, element: usize) -> f64;

    /// Whether the natural state of an element is its place in the mesh: one with a prestretch is stretched there.
    fn is_natural(&self, _element: usize, _rest_positions: &[Vector3<f64>]) -> bool {
        true
    }

    /// Sets `out` to the norms of the blocks of an element's stiffness at rest, row after row \[N/m\]: with its prestretch, if it has one.
    fn rest_norms(&self, element: usize, rest_positions: &[Vector3<f64>], out: &mut Vec<f64>) {
        set_norms(&rest_stiffness(self, element, rest_positions), out);
    }

    /// Sets `out` to the traces of the blocks on the diagonal of an element's stiffness in its natural state, one for each node \[N/m\].
    fn rest_traces(&self, element: usize, rest_positions: &[Vector3<f64>], out: &mut Vec<f64>) {
        let matrix = rest_stiffness(self, element, rest_positions);
        out.clear();
        out.extend((0..matrix.nodes()).map(|i| matrix.block(i, i).trace()));
    }

    /// Takes the energy and the viscous forces of an element times a factor, > 0: the stiffness cap of NUMERICS 3.5 d.
    fn scale(&mut self, element: usize, factor: f64);

    /// The same set with each element [scaled](Self::scale) by its factor.
    fn scaled(&self, factors: &[f64]) -> Arc<dyn Elements> {
        let mut scaled = self.shifted(0);
        if let Some(set) = Arc::get_mut(&mut scaled) {
            for (element, factor) in factors.iter().enumerate() {
                set.scale(element, *factor);
            }
        }
        scaled
    }

    /// The same set with all its nodes so many further on: for a model of several bodies.
    fn shifted(&self, nodes: u32) -> Arc<dyn Elements>;

    /// Lets internal variables flow for a time `h` \[s\]; returns whether a stiffness has grown, which may shorten the stable
    /// step.
    fn flow(&self, _positions: &[Vector3<f64>], _internal: &mut [f64], _h: f64) -> bool {
        false
    }

    /// The most by which plastic flow may make an element thinner than at rest, 1 or more: by this factor its gradients grow, by the
    /// square of it its stiffness, though [`flow`](Self::flow) does not report that.
    fn most_thinning(&self) -> f64 {
        1.0
    }

    /// Whether these can be internal variables of this set: bytes that were saved may be those of another one.
    fn admits(&self, _internal: &[f64]) -> bool {
        true
    }

    /// Whether elements are where these internal variables state. Those that slide move on to other nodes in a [`flow`](Self::flow);
    /// [`TissueModel::relocate`](crate::TissueModel::relocate) then puts them there.
    fn is_in_place(&self, _internal: &[f64]) -> bool {
        true
    }

    /// The elements that have other nodes where these internal variables state, ascending.
    fn moved(&self, _internal: &[f64]) -> Vec<u32> {
        Vec::new()
    }

    /// Puts elements where internal variables state.
    fn relocate(&mut self, _internal: &[f64]) {}

    /// Dissipated energy \[J\] as these internal variables state: what plastic flow of continua, softening of bonds and friction of ties have
    /// taken, of elements that are still there. 0 for elements that count none.
    fn dissipated(&self, _internal: &[f64]) -> f64 {
        0.0
    }

    /// What has flowed in an element of a continuum; none of other elements.
    fn plastic_state(&self, _element: usize, _internal: &[f64]) -> Option<PlasticState> {
        None
    }

    /// Calls `visit` with each [`Key`] by which an edit of the mesh finds an element: its nodes, unless it overrides this.
    fn keys(&self, element: usize, visit: &mut dyn FnMut(Key)) {
        visit(Key::new(self.nodes(element)));
    }

    /// Takes the elements `removed`, ascending, out, and puts those of `added` in, as [`splice::splice`] does. Returns false, with
    /// nothing changed, where `added` is a set of another kind.
    fn splice(&mut self, removed: &[u32], added: &dyn Elements) -> bool;

    /// Makes room for half as many elements again, so that edits do not wait for memory.
    fn make_room(&mut self);

    /// The internal variables that the elements of `added` inherit from elements `ancestors[i]` of this set, in the order of those of
    /// `added`; empty for elements without any.
    fn inherited(&self, _added: &dyn Elements, _ancestors: &[Vec<u32>]) -> Vec<Inherited> {
        Vec::new()
    }

    /// What makes internal variables of sums that were inherited.
    fn blend(&self) -> Blend {
        Blend::Sum
    }

    /// The set as constraints with compliance, if position-based methods can treat it.
    fn constraints(&self) -> Option<&dyn Constraints> {
        None
    }
}

/// The stiffness of an element at rest \[N/m\].
pub(crate) fn rest_stiffness<E: Elements + ?Sized>(
    set: &E,
    element: usize,
    rest_positions: &[Vector3<f64>],
) -> ElementMatrix {
    let at = Configuration {
        positions: rest_positions,
        velocities: rest_positions,
        internal: &[],
    };
    let mut matrix = ElementMatrix::new();
    set.stiffness(element, &at, Tangent::Exact, &mut matrix);
    matrix
}

/// Sets `out` to the norms of the blocks of a matrix, row after row.
pub(crate) fn set_norms(matrix: &ElementMatrix, out: &mut Vec<f64>) {
    let blocks = (0..matrix.nodes()).flat_map(|i| (0..matrix.nodes()).map(move |j| (i, j)));
    out.clear();
    out.extend(blocks.map(|(i, j)| matrix.block(i, j).norm()));
}

/// A set of elements that position-based methods can treat (XPBD; Macklin, Müller, Chentanez 2016).
pub trait Constraints {
    /// Number of multipliers per element.
    fn multipliers(&self) -> usize;

    /// Projects one element: moves its nodes, and updates its multipliers, for a step of `h` \[s\].
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

#[cfg(test)]
pub(crate) mod contract;
