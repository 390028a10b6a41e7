//! Sparse symmetric positive definite matrices of 3×3 blocks: assembly, ordering, Cholesky factor, a preconditioner of two levels,
//! conjugate gradients, and the choice among them. Small dense matrices use the same kernels.
//!
//! One block row per node of a mesh, one block per pair of coupled nodes. Its use by an implicit solver:
//!
//! ```
//! use std::sync::Arc;
//! use microsim_sparse::{BlockMatrix, LinearSolver, Pattern};
//! use nalgebra::{Matrix3, Vector3};
//!
//! // Once per mesh: where the blocks are, and how to solve.
//! let pattern = Arc::new(Pattern::from_cliques(3, [[0, 1], [1, 2]]));
//! let positions = [0.0, 1.0, 2.0].map(|x| Vector3::new(x, 0.0, 0.0));
//! let mut solver = LinearSolver::new(&pattern, &positions);
//! let mut matrix = BlockMatrix::zeros(pattern);
//!
//! // Each step: numbers, preparation, solution to a residual relative to the right-hand side.
//! matrix.clear();
//! for (i, j) in [(0, 1), (1, 2)] {
//!     matrix.add_diagonal(i, &Matrix3::identity());
//!     matrix.add_diagonal(j, &Matrix3::identity());
//!     matrix.add(i, j, &-Matrix3::identity());
//! }
//! let mut x = [Vector3::zeros(), Vector3::zeros(), Vector3::x()];
//! solver.factorise(&matrix, &[true, false, false])?;
//! solver.solve(&matrix, &mut x, 1e-12)?;
//! assert!((x[2].x - 2.0).abs() < 1e-11);
//! # Ok::<(), microsim_sparse::NotPositive>(())
//! ```
//!
//! What is not here: nonlinear iterations, where the numbers come from, matrices that are not positive definite. Pure
//! and on one thread; the same numbers give the same bits on any machine.

#![forbid(unsafe_code)]

mod assembly;
mod dense;
mod elimination;
mod factor;
mod gradients;
mod kernels;
mod lattice;
mod matrix;
mod minimum_degree;
mod ordering;
mod pattern;
mod real;
mod separator;
mod solver;
mod symbolic;
mod two_level;

pub use dense::DenseFactor;
pub use factor::{Factor, NotPositive};
pub use gradients::{CgOutcome, ConjugateGradients};
pub use lattice::Lattice;
pub use matrix::BlockMatrix;
pub use ordering::{NotPermutation, Ordering};
pub use pattern::Pattern;
pub use real::Real;
pub use solver::LinearSolver;
pub use symbolic::Symbolic;
pub use two_level::TwoLevel;

#[cfg(test)]
mod testing;
