//! The interface of contact solvers, and the linear systems that they are given.

use crate::contact::Contact;
use microsim_sparse::NotPositive;
use nalgebra::{Matrix3, Vector3};

/// Finds the contact forces of one linearised step.
///
/// `Response` is what the solver knows of the bodies: how their nodes respond to forces. [`AugmentedLagrangian`] and
/// [`InteriorPoint`] take a linear solver ([`SystemResponse`]), [`GaussSeidel`] a compliance of each node ([`NodalResponse`]).
///
/// [`AugmentedLagrangian`]: crate::AugmentedLagrangian
/// [`InteriorPoint`]: crate::InteriorPoint
/// [`GaussSeidel`]: crate::GaussSeidel
/// [`NodalResponse`]: crate::NodalResponse
pub trait ContactSolver<Response> {
    /// The constraints, with what the method knows of each of them.
    type Contacts: ?Sized;

    /// Moves `motion`, one vector per node, by the response to contact forces that satisfy the laws of Signorini and Coulomb, and stores
    /// these forces in `contacts`.
    ///
    /// # Errors
    /// When the system shows not to be positive definite.
    fn solve(
        &mut self,
        contacts: &mut Self::Contacts,
        response: Response,
        motion: &mut [Vector3<f64>],
    ) -> Result<(), NotPositive>;
}

/// Adds the product of a symmetric matrix with the first vector to the second one.
pub type AddProduct<'a> = &'a mut dyn FnMut(&[Vector3<f64>], &mut [Vector3<f64>]);

/// A system of linear equations of 3×3 blocks, one row per node: K, symmetric and positive definite, as it was last factored.
pub trait LinearSystem {
    /// Whether an f64 Cholesky factor costs no more than a few solutions.
    fn is_small(&self) -> bool;

    /// Adds w_i w_j `block` for the nodes i, j of each side of a contact to the matrix, before it is factored. Returns whether these nodes
    /// are coupled; where they are not nothing is added.
    fn add_contact(&mut self, contact: &Contact, block: &Matrix3<f64>) -> bool;

    /// q = K p, without regard of prescribed nodes.
    fn multiply(&self, p: &[Vector3<f64>], q: &mut [Vector3<f64>]);

    /// Solves in place to a residual of `tolerance`, relative to the right-hand side. Prescribed nodes retain their entry, which has no
    /// effect on the others.
    ///
    /// # Errors
    /// When the matrix shows not to be positive definite.
    fn solve(&mut self, x: &mut [Vector3<f64>], tolerance: f64) -> Result<(), NotPositive>;

    /// As [`solve`](Self::solve), for the sum of the matrix and the one that `add` stands for.
    ///
    /// # Errors
    /// When the sum shows not to be positive definite.
    fn solve_with(
        &mut self,
        add: AddProduct<'_>,
        x: &mut [Vector3<f64>],
        tolerance: f64,
    ) -> Result<(), NotPositive>;

    /// Pairs of an addition and a multiplication so far: a count that only grows during a solution, by which solvers bound their work.
    fn operations(&self) -> f64;

    /// Sets `operator`, row after row, to the Delassus operator J K⁻¹ Jᵀ \[m/N\] of these rows of J, to the accuracy of the factor. Returns
    /// whether there is a factor; without one nothing is done.
    fn set_delassus(&mut self, rows: &[[(u32, Vector3<f64>); 4]], operator: &mut Vec<f64>) -> bool;
}

/// Bodies whose nodes respond to forces by a system of linear equations.
pub struct SystemResponse<'a> {
    /// K, factored.
    pub system: &'a mut dyn LinearSystem,
    /// The forces at the nodes that no contact has \[N\].
    pub forces: &'a [Vector3<f64>],
    /// Marks of the prescribed nodes, whose motion is given.
    pub fixed: &'a [bool],
    /// When the solution is accurate enough.
    pub tolerances: Tolerances,
    /// Operations of the system and the solver, beyond which the augmented Lagrangian method ends with the accuracy that it has. The interior-point method has few
    /// rounds and takes no heed of it.
    pub most_operations: f64,
}

/// When the solution of a linearised step is accurate enough.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerances {
    /// Residual relative to all forces (inexact-solve tolerance η).
    pub residual: f64,
    /// As [`residual`](Self::residual), for the forces of contacts that have opened, closed or begun to slide.
    pub changes: f64,
    /// Multiplier residual, relative to the mean edge length.
    pub multipliers: f64,
}
