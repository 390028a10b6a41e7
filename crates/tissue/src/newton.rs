//! Newton's method for the positions at the end of a step: the part that all implicit methods have in common.
//!
//! Every stage of the implicit methods here, and static equilibrium, is one equation for positions x,
//!
//! ```text
//! m ((v − ṽ)/η + c v) = f(x, v)        v = (x − x̃)/η
//! ```
//!
//! with a span η, a base x̃, ṽ that is known, all forces f of elements, weight and loads, and the drag c; in statics the left
//! side and v are zero. The positions of prescribed nodes are given.
//!
//! # The iteration
//! The matrix is K + D/η + (1/η² + c/η) M, with K exact where that is positive definite, else the nearest one per element
//! without negative eigenvalues: then the step descends the potential
//!
//! ```text
//! Φ(x) = E(x) + Σ m/2 (|x − x̃ − ηṽ|²/η² + c |x − x̃|²/η) − n·x
//! ```
//!
//! with all forces that have no energy (viscous ones, pressures that follow a surface) taken into n as they are at the start
//! of the iteration. A line search backs off until Φ falls enough (Armijo), or, where it falls by no more than rounding or all forces
//! fall to a tenth, until its slope does (the approximate Wolfe condition of Hager & Zhang 2005). Where ties slide, a step that is long enough to pass, but at whose end Φ
//! rises by more than a fifth of its slope at the start, is shortened to where a straight slope would vanish, unless Φ is higher there.
//!
//! Far from the solution an iteration has a second-order correction: its path is x + α d + α² c with the step length α, the direction d of
//! Newton's method and K c = ½ ∂²f/∂α² along it, for one more solution with the same factor. The forces along the path then deviate from
//! their linear decrease by α³ only. A beam that swings by a third of its length needs four iterations so, nine without. (Of the methods
//! of Chebyshev and Halley; the second derivative is a difference of forces.)
//!
//! In the first iteration prescribed nodes go to their ends and the linear system predicts how all others go along; where that raises Φ
//! over the displacement of the prescribed nodes alone, less of it is taken.
//!
//! # Contact
//! Contacts (crate `contact-solver`) are found where an iteration starts; its direction enforces non-penetration, its potential has their
//! energy, and it has no second-order correction. After a few iterations of one equation they retain their features and normals. Where
//! gaps found at the end are far below their floors, iterations are made beyond those asked for.
//!
//! In early-terminated steps, those of time that need not converge, small bodies with contacts have positive tangents, so that
//! the interior-point method can solve contacts among themselves. An iteration at whose end surfaces have turned so much that gaps are far
//! below their floors goes back, to an eighth of its length at least. After a short one the matrix is retained for the next; one that moves
//! hardly anything ends the step. Where the interior-point method finds no forces, those of before stay, and the iteration is a short one.
//! A step that is to take the augmented Lagrangian method ([`Effort`](crate::Effort)) has none of this.
//!
//! # Limitations
//! The derivative of viscous forces by positions is left out, so with viscosity the last iterations converge linearly, by a
//! factor of the order of the strain in one step, not quadratically. Of the derivative of pressures the symmetric part alone
//! is taken, which is all of it for a closed surface or one with a prescribed rim.

mod contact;
mod direction;
mod equation;
mod iteration;
mod known_forces;
mod line_search;
mod options;
mod predictor;
mod residual;
mod second_order;
mod workspace;

pub(crate) use equation::{Equation, EquationContact, SlipReference};
pub use options::{
    LineSearchOptions, Newton, NewtonContactOptions, NewtonOptions, SecondOrderOptions,
};
pub(crate) use workspace::NewtonSolver;
