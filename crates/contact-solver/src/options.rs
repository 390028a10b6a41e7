//! The constants of the methods, each with what it is, its range, what it trades and where it comes from.
//!
//! "Measured" means: chosen by runs of the shipped scenes and of `cargo xtask bench contact`; a value that is half or twice as large
//! changes cost or accuracy there as described. Lengths are relative to the mean edge length of the body.

/// Of the augmented Lagrangian method ([`AugmentedLagrangian`](crate::AugmentedLagrangian)).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AugmentedLagrangianOptions {
    /// Penalty ρ over the stiffness of the nodes of a contact by themselves, where its block is in the factor; in 1..100. Larger values
    /// need fewer updates of multipliers and lose digits of an f32 factor: with 100 a vessel between jaws takes twice the linear
    /// solutions. Measured.
    pub penalty: f64,
    /// As [`penalty`](Self::penalty), for a contact of which both sides can move, whose block is not in the factor; in 1..20. Larger values
    /// need fewer updates and more iterations of conjugate gradients. Measured.
    pub penalty_between_bodies: f64,
    /// Tangential penalty over ρ; in 0.01..1. Larger values make friction stiffer before it slides, and the problem worse conditioned.
    /// Measured.
    pub tangential_penalty: f64,
    /// Most inner Newton iterations with the same multipliers; at least 1. A bound, hardly ever reached.
    pub inner_iterations: u32,
    /// Most updates of the multipliers; at least 1. A bound, hardly ever reached but between bodies that both move.
    pub updates: u32,
    /// Bisections of the search along an inner direction; in 10..50. Each halves the uncertainty of the step length.
    pub bisections: u32,
    /// A full inner step is taken where the slope at its end is at most this fraction of that at its start; in 0..0.5. Larger values save
    /// searches and make steps less exact. As the curvature condition of Wolfe, Nocedal & Wright (2006) 3.1.
    pub flat_slope: f64,
    /// Sweeps over the contacts that predict which ones close where surfaces have moved; at least 1. More give a better start and take
    /// time. Measured.
    pub prediction_sweeps: u32,
    /// The relative residual of an inner linear solution over what may be left, and its bounds; the first in 0.1..0.9, the others in
    /// (0, 1). Smaller values cost iterations of conjugate gradients, larger ones inner iterations (Eisenstat & Walker 1996).
    pub inexactness: f64,
    /// See [`inexactness`](Self::inexactness).
    pub linear_tolerances: [f64; 2],
    /// Of the solution among the contacts alone.
    pub reduced: ReducedOptions,
}

/// Of the reduced problem of the augmented Lagrangian method: contacts among themselves, by the Delassus operator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReducedOptions {
    /// Most directions, three per contact with friction: beyond, conjugate gradients on the whole system take less time; in 30..300.
    /// Measured.
    pub directions: usize,
    /// Most solutions, each with the contacts that the one before has closed; at least 1. Measured.
    pub rounds: u32,
    /// Residual that may be left, relative to that at the start; in (0, 1). Smaller values cost rounds.
    pub decrease: f64,
    /// Tolerance of the parts of a round, relative to what may be left at its end; in (0, 1).
    pub inexactness: f64,
}

/// Of the interior-point method ([`InteriorPoint`](crate::InteriorPoint)).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InteriorPointOptions {
    /// How often contacts that the last solution has closed join; at least 1. What closes in the last round pushes as a spring until the
    /// next iteration of Newton's method. Measured.
    pub rounds: u32,
    /// Most directions, three per contact with friction, as the work grows with their third power; in 48..1000. Where there are more, contacts
    /// take part along their normals alone, those with the largest forces and overlaps first, and those that are left push as springs until the next
    /// iteration. Levels reach it only where tissue is crushed or in shreds. Measured.
    pub directions: usize,
    /// How often friction bounds are those of the normal forces of the last solution; at least 1. Coulomb's law is met as iterations of
    /// Newton's method converge (a fixed-point iteration on Tresca's law; Panagiotopoulos 1975). Measured.
    pub bound_updates: u32,
    /// Relative residual of linear solutions; that of an f64 Cholesky factor.
    pub linear_tolerance: f64,
    /// Gaps further below their floor than this take part \[mean edge length\]; in 1e-9..1e-4. What does not would push as a spring.
    pub gap_tolerance: f64,
    /// Regularisation: compliance of each contact against the change of its force, relative to 1/ρ, along the normal and across; in
    /// 1e-4..1e-1. Contacts of the same nodes leave open which has how much of a force; with it they retain what they had.
    pub regularisation: [f64; 2],
    /// Change of a friction bound that ends their updates, relative to the largest normal force; in 1e-6..1e-1.
    pub bound_tolerance: f64,
    /// Most iterations; ten to twenty were enough in all runs.
    pub iterations: u32,
    /// What may be left of displacements, relative to the largest of them, and of complementarity products, relative to those at the
    /// start; in 1e-12..1e-4. Each digit costs one or two iterations.
    pub tolerance: f64,
    /// What may be left of them where rounding ends the iterations; in 1e-8..1e-4.
    pub rounding: f64,
    /// Fraction of the step to the boundary of the admissible set that is taken; in 0.9..1. Larger values converge faster until iterates
    /// stick to the boundary (Mehrotra 1992; Nocedal & Wright 2006, 14.2).
    pub step_to_boundary: f64,
}

/// Of the projected Gauss–Seidel method ([`GaussSeidel`](crate::GaussSeidel)).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GaussSeidelOptions {
    /// Most sweeps over the contacts; at least 1. Stacks of contacts through light nodes converge slowly: what is left after them stays.
    pub sweeps: u32,
    /// The largest displacement in a sweep that ends them \[mean edge length\]; in 1e-14..1e-4.
    pub tolerance: f64,
}

/// How old overlaps are undone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OverlapOptions {
    /// Undone where that strains the tissue, in the time that the fastest mode takes for a third of its period, in which waves travel
    /// about an edge \[mean edge length\]; in 1e-4..1e-2. Faster adds energy: two tubes that collide had 0.6 % more at most with twice
    /// the value, 23 % with twenty times.
    pub rate: f64,
    /// Most in a step \[mean edge length\]; in 0.05..0.5 (NUMERICS 2.7). With 0.2 what was undone of one or two nodes strained a wall that trembling scissors squeezed so far that no tick could be
    /// computed any more; with 0.05 closed blades pressed on what had not left them in time. Measured with trainees of the oblique cut.
    pub most: f64,
    /// How far a node goes at most in an implicit step for it \[mean edge length\], beyond what free components go as wholes; in 0.5..2. What lies askew in slivers of a cut would take many times what is to be
    /// undone, and more strain than a hand could bring; the rest is left to the steps that follow. Seen with trembling hands that cut obliquely.
    pub longest: f64,
}

impl OverlapOptions {
    /// How far an old overlap is undone in a step of `h` \[s\] \[mean edge length\]; `frequency` is that of the fastest mode \[1/s\].
    pub fn undone(&self, frequency: f64, h: f64) -> f64 {
        (0.5 * h * frequency * self.rate).clamp(0.0, self.most)
    }
}

/// Of [`RigidComponents`](crate::RigidComponents).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigidComponentOptions {
    /// Most sweeps over the contacts; at least 1. Components that are not apart after them stay where they are.
    pub sweeps: u32,
    /// The largest displacement in a sweep that ends them \[mean edge length\]; in 1e-14..1e-4.
    pub tolerance: f64,
    /// A component on which a contact force acts that would move it this far in a step stays where it is \[mean edge length\]: it would
    /// lose its strain; in 1e-12..1e-6.
    pub pressed: f64,
    /// The largest displacement of a component that balances its forces \[mean edge length\]; in 1e-9..1e-3. What linear systems leave is far
    /// below. More than that is the residual of a step
    /// that is not solved, which contacts would have to balance; a component moved by it leaves the jaws that hold it.
    pub balancing: f64,
}

/// All of them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ContactOptions {
    /// Of the augmented Lagrangian method.
    pub augmented_lagrangian: AugmentedLagrangianOptions,
    /// Of the interior-point method.
    pub interior_point: InteriorPointOptions,
    /// Of the projected Gauss–Seidel method.
    pub gauss_seidel: GaussSeidelOptions,
    /// How old overlaps are undone.
    pub overlap: OverlapOptions,
    /// Of rigid components.
    pub rigid_components: RigidComponentOptions,
}

impl Default for AugmentedLagrangianOptions {
    fn default() -> Self {
        Self {
            penalty: 10.0,
            penalty_between_bodies: 8.0,
            tangential_penalty: 0.1,
            inner_iterations: 12,
            updates: 12,
            bisections: 30,
            flat_slope: 0.1,
            prediction_sweeps: 4,
            inexactness: 0.5,
            linear_tolerances: [1e-9, 0.1],
            reduced: ReducedOptions::default(),
        }
    }
}

impl Default for ReducedOptions {
    fn default() -> Self {
        Self {
            directions: 96,
            rounds: 4,
            decrease: 0.1,
            inexactness: 0.25,
        }
    }
}

impl Default for InteriorPointOptions {
    fn default() -> Self {
        Self {
            rounds: 4,
            directions: 192,
            bound_updates: 2,
            linear_tolerance: 1e-9,
            gap_tolerance: 1e-6,
            regularisation: [1e-3, 1e-2],
            bound_tolerance: 1e-3,
            iterations: 50,
            tolerance: 1e-9,
            rounding: 1e-6,
            step_to_boundary: 0.99,
        }
    }
}

impl Default for GaussSeidelOptions {
    fn default() -> Self {
        Self {
            sweeps: 50,
            tolerance: 1e-10,
        }
    }
}

impl Default for OverlapOptions {
    fn default() -> Self {
        Self {
            rate: 1e-3,
            most: 0.1,
            longest: 1.0,
        }
    }
}

impl Default for RigidComponentOptions {
    fn default() -> Self {
        Self {
            sweeps: 50,
            tolerance: 1e-10,
            pressed: 1e-9,
            balancing: 1e-4,
        }
    }
}
