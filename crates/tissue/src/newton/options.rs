//! The constants of Newton's method, each with what it is, its range, what it trades and where it comes from.
//!
//! "Measured" means: chosen by runs of the shipped scenes and of `cargo xtask bench solvers`. Lengths are relative to the mean edge length
//! of the body, forces to all forces of the equation.

use crate::solver::{ResidualBounds, SolutionBounds};
use microsim_contact_solver::ContactOptions;

/// How far Newton's method iterates in a step: number of iterations, tolerance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Newton {
    /// Most iterations per equation, at least 1; there may be [a few more](NewtonContactOptions::more_iterations) where bodies overlap, and in early-terminated steps of time whose
    /// forces would mean nothing. One is the linearly implicit variant of a method.
    pub iterations: u32,
    /// The residual at which an equation is solved, relative to the forces in it, in early-terminated steps of time to [a tenth of a millinewton](NewtonOptions::least_scale) at least. One that is no
    /// more than the rounding of positions counts as 0.
    pub tolerance: f64,
    /// Whether a step that ends above the tolerance fails – above 100 times the tolerance where there is contact. If not, it is an
    /// early-terminated step: every iteration has descended the potential, or part of that path where surfaces have turned.
    pub must_converge: bool,
}

/// Options of Newton's method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NewtonOptions {
    /// Inexact-solve tolerance: the relative residual of linear systems over the tolerance of the method, relative to the present
    /// residual; in 0.01..0.5. Smaller values cost iterations of conjugate gradients, larger ones quadratic convergence (Dembo et al.
    /// 1982).
    pub linear_inexactness: f64,
    /// Its least and largest value; in 1e-12..1e-1.
    pub linear_tolerances: [f64; 2],
    /// A static body with a smaller residual takes no iteration, however large the tolerance; in 1e-9..1e-3. Forces of clamps count in the
    /// scale, and may be many times those of a load that is to move it.
    pub rest_tolerance: f64,
    /// The residual has fallen where it is below this ratio of what it was; in 0.1..0.9. The exact tangent is tried again then, and an
    /// iteration without it counts as stagnation; in an early-terminated step of time one in which neither the residual relative to the forces nor the one in newtons has fallen.
    pub decrease: f64,
    /// That ratio of an early-terminated step whose forces would mean nothing yet; in `decrease`..1. Measured.
    pub slow_decrease: f64,
    /// An early-terminated step of time is solved, too, where the residual is below its tolerance times this force \[N\], however small all forces are: a body at rest takes one iteration.
    pub least_scale: f64,
    /// Iterations in a row without such a decrease that end an early-terminated step; at least 1. More cost time and gain no digits.
    /// Measured.
    pub stagnation: u32,
    /// Where contact is, this multiple of the tolerance is enough after the last iteration; in 1..1e4: contacts that open and close for
    /// ever leave the last digits open. Measured.
    pub stagnated_tolerance: f64,
    /// Of the line search.
    pub line_search: LineSearchOptions,
    /// Of the second-order correction.
    pub second_order: SecondOrderOptions,
    /// Parts of the common displacement that are tried in the first iteration, in which prescribed nodes go to their ends, in this order;
    /// each in 0..1. More try harder and cost an energy each.
    pub predictor_lengths: [f64; 5],
    /// Of contact in an iteration.
    pub contact: NewtonContactOptions,
    /// Of the contact solvers.
    pub contact_solvers: ContactOptions,
}

/// Options of the line search of Newton's method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LineSearchOptions {
    /// Sufficient decrease of the potential, relative to that of the slope (Armijo); in 1e-6..0.1. The usual value (Nocedal & Wright 2006,
    /// 3.1).
    pub sufficient_decrease: f64,
    /// Differences of the potential below this part of its terms are rounding; in 1e-14..1e-10. Larger values trust the slope earlier
    /// (approximate Wolfe condition; Hager & Zhang 2005).
    pub rounding: f64,
    /// The residual, squared and relative to its square before, at which a full step is taken by its forces alone; in 1e-4..0.5.
    pub force_decrease: f64,
    /// Where ties slide: the upward slope of the potential at the end of a step, relative to the downward one at its start, above which the step is
    /// shortened to where a straight slope vanishes; in 0.1..1, infinite for never. The tangent of a tie that slides has no slope along its path, and
    /// steps that all descend may cross the lowest point again and again. Larger values save energies and cost iterations. Measured with clumsy and
    /// jittering hands on the last level of blunt trimming.
    pub overshoot: f64,
    /// The shortest step length that is tried; in 1e-16..1e-3. Below, the direction counts as none of descent.
    pub shortest: f64,
    /// A step length is followed by the lowest point of a parabola between these parts of it, by the last one where that is not finite; in
    /// (0, 1), the first below the second. The usual safeguards (Dennis & Schnabel 1996, 6.3).
    pub shortening: [f64; 3],
}

/// Options of the second-order correction of Newton's method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SecondOrderOptions {
    /// The step length at which the curvature of the forces is measured by differences; in 1e-3..0.1. Smaller values lose digits, larger
    /// ones measure higher derivatives too.
    pub probe: f64,
    /// It is applied while the residual is at least this; in 1e-6..1e-1. Below, steps without it converge quadratically, and
    /// differences have no digits. Measured.
    pub least_residual: f64,
    /// And where curvature changes at least this part of the residual; in 1e-3..0.5. Measured.
    pub least_curvature: f64,
    /// Relative residual of its linear solution; two digits are enough.
    pub linear_tolerance: f64,
}

/// Options for contact within Newton's method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NewtonContactOptions {
    /// The multiplier residual that may be left, as a length \[mean edge length\], where the method must converge, and where not; in
    /// 1e-8..1e-2. Smaller values cost updates of multipliers; overlaps are as large as these.
    pub multiplier_tolerances: [f64; 2],
    /// Residual of friction that need not converge; in 1e-4..0.1.
    pub friction_tolerance: f64,
    /// Gap tolerance: a larger overlap at the end takes more iterations than were asked for \[mean edge length\]; in 1e-3..0.2. Surfaces
    /// turn in large steps. Measured.
    pub overlap: f64,
    /// In an early-terminated step of time a larger residual at the end does, too: its forces would mean nothing, and to begin again with
    /// shorter steps takes more. Where tools tremble it is what the first iterations leave of a surface that has turned.
    pub residual: ResidualBounds,
    /// In an early-terminated step of time a larger residual does, too, where [a force of contact has jumped](microsim_contact_solver::ContactSource::has_jumped).
    pub jump: SolutionBounds,
    /// So many iterations more.
    pub more_iterations: u32,
    /// How often contacts are found for one equation; at least 1. Then they retain features and normals: features of equal distance could
    /// take turns for ever. Measured.
    pub searches: u32,
    /// As [`searches`](Self::searches), in early-terminated steps, where contacts then retain friction bounds too, so that only elements,
    /// and which contacts are closed or stick, are left to the other iterations; cuts lie where they do with any such number
    /// (tests/results/tune_coordination.md). With 2 hardly any tick of a trembling hand in level 3 of dilatation (novice, seed 2) was repeated instead of 108,
    /// but a strip between two rods that cross did not come back, and a tuft between closed jaws slipped out. Measured.
    pub early_searches: u32,
    /// How often an iteration of an early-terminated step goes back by half of its length where overlaps came of it; 0 for never.
    pub retreats: u32,
    /// How far nodes go at most in an iteration whose contact forces were not found \[mean edge length\]; in 1e-3..1. With those of before nothing
    /// keeps a piece between jaws, and a longer one lets it out.
    pub without_forces: f64,
    /// The displacement of an iteration that ends an early-terminated step \[mean edge length\]; in 1e-6..1e-2. What is held slides by what
    /// is left in every step, so it is far below the multiplier tolerance.
    pub still: f64,
    /// The displacement after which the matrix is retained for the next iteration of an early-terminated step \[mean edge length\]; in
    /// 1e-4..0.1. Larger values save factors and cost iterations. Measured.
    pub short: f64,
}

impl Default for Newton {
    fn default() -> Self {
        Self {
            iterations: 20,
            tolerance: 1e-6,
            must_converge: true,
        }
    }
}

impl Default for NewtonOptions {
    fn default() -> Self {
        Self {
            linear_inexactness: 0.1,
            linear_tolerances: [1e-8, 1e-3],
            rest_tolerance: 1e-6,
            decrease: 0.5,
            slow_decrease: 0.9,
            least_scale: 1e-4,
            stagnation: 3,
            stagnated_tolerance: 100.0,
            line_search: LineSearchOptions {
                sufficient_decrease: 1e-4,
                rounding: 1e-12,
                force_decrease: 0.01,
                overshoot: 0.2,
                shortest: 1e-8,
                shortening: [0.1, 0.5, 0.25],
            },
            second_order: SecondOrderOptions {
                probe: 1.0 / 64.0,
                least_residual: 1e-3,
                least_curvature: 0.02,
                linear_tolerance: 1e-2,
            },
            predictor_lengths: [1.0, 0.5, 0.25, 0.125, 0.0],
            contact: NewtonContactOptions {
                multiplier_tolerances: [1e-5, 1e-3],
                friction_tolerance: 1e-2,
                overlap: 0.02,
                residual: ResidualBounds::default(),
                jump: SolutionBounds::default(),
                more_iterations: 6,
                searches: 5,
                early_searches: 4,
                retreats: 3,
                without_forces: 0.05,
                still: 1e-4,
                short: 2e-2,
            },
            contact_solvers: ContactOptions::default(),
        }
    }
}
