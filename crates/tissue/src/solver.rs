//! What every solver is: one step, and its report.

use crate::executor::Executor;
use crate::model::TissueModel;
use crate::state::{Control, NodeTarget, State};
use crate::work;
use microsim_contact_solver::ContactStep;
use std::fmt::Debug;

/// How much effort steps take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Effort {
    /// Multiple of the iterations of the method.
    pub iterations: u32,
    /// Whether contacts of an early-terminated step take the augmented Lagrangian method, as what the interior-point method cannot compute this one often
    /// can; such a step does not end for stagnation either.
    pub augmented_lagrangian: bool,
}

impl Default for Effort {
    /// What is usual.
    fn default() -> Self {
        Self {
            iterations: 1,
            augmented_lagrangian: false,
        }
    }
}

/// Advances a body by one step.
///
/// A solver holds working memory for one model and nothing that evolves: from equal states come equal bits, whatever was
/// computed before.
///
/// ```
/// use microsim_mesh::{Block, CellSplit};
/// use microsim_tissue::{
///     Behaviour, Contact, ContactSource, ContactStep, Control, Material, Method, Serial, SpringConstants, State,
///     build_model,
/// };
/// use nalgebra::Vector3;
///
/// // A floor that every node of the low face of a body may touch.
/// struct Floor(f64);
/// impl ContactSource for Floor {
///     fn find(&mut self, _: f64, positions: &[Vector3<f64>], contacts: &mut Vec<Contact>) {
///         contacts.clear();
///         let low = (0..positions.len()).filter(|&node| positions[node].z < self.0 + 1e-4);
///         contacts.extend(low.map(|node| Contact::of_node(node as u32, Vector3::z(), self.0)));
///     }
/// }
///
/// // A free block of soft tissue, 2 mm in each direction, on a floor.
/// let block = Block { center: [0.0; 3], size: [2e-3; 3], cells: [2; 3], split: CellSplit::Kuhn };
/// let mesh = block.mesh().unwrap();
/// let springs = Behaviour::Springs(SpringConstants::scaled(25e3, 5e4));
/// let tissue = Material { density: 1060.0, relaxation_time: 0.0, behaviour: springs };
/// let free = vec![false; mesh.positions.len()];
/// let model = build_model(&mesh, &[(0, tissue)], &free, 0.0, Vec::new()).unwrap();
///
/// let mut state = State::at_rest(&model);
/// let control = Control { gravity: [0.0, 0.0, -9.81].into(), ..Control::default() };
/// let mut solver = Method::StoermerVerlet.solver(&model).unwrap();
/// let mut floor = Floor(-1e-3);
/// let mut contact = ContactStep { source: &mut floor, contacts: Vec::new() };
/// solver.advance(&model, &mut state, &control, &[], Some(&mut contact), 1e-5, &Serial)?;
/// assert!(contact.contacts.iter().all(|contact| contact.normal_force > 0.0));
/// assert!(state.positions.iter().all(|x| x.z >= -1e-3 - 1e-12));
/// # Ok::<(), microsim_tissue::StepFailure>(())
/// ```
pub trait Solver: Debug + Send {
    /// Advances `state` by `h` \[s\] with the nodes of `targets` prescribed and the gaps of `contact` enforced. After a failure the state is
    /// as it was.
    #[expect(clippy::too_many_arguments, reason = "the parts of a step stay apart")]
    fn advance(
        &mut self,
        model: &TissueModel,
        state: &mut State,
        control: &Control,
        targets: &[NodeTarget],
        contact: Option<&mut ContactStep<'_>>,
        h: f64,
        exec: &dyn Executor,
    ) -> Result<StepReport, StepFailure>;

    /// Advances `state` by `h` \[s\] where there is no contact. After a failure the state is as it was.
    fn step(
        &mut self,
        model: &TissueModel,
        state: &mut State,
        control: &Control,
        targets: &[NodeTarget],
        h: f64,
        exec: &dyn Executor,
    ) -> Result<StepReport, StepFailure> {
        self.advance(model, state, control, targets, None, h, exec)
    }

    /// Updates it after an edit of its model: from then on it does what a solver made for the model as it is now does, to the bit. Working
    /// memory of explicit and position-based methods is retained; an implicit one is rebuilt, with all analysis of its
    /// system, in a time in proportion to the body: some milliseconds for 3,000 tetrahedra.
    fn follow(&mut self, model: &TissueModel);

    /// How much effort the steps from now on take. Of no effect on a method without iterations.
    fn set_effort(&mut self, effort: Effort) {
        let _ = effort;
    }

    /// The work that a step may take from now on \[s\], by the count of its operations and not by a clock: an equation begins no further iteration
    /// beyond it, and has one in any case. Of no effect where a step must converge, nor on a method without iterations.
    fn limit_work(&mut self, most: f64) {
        let _ = most;
    }

    /// What a step in which so many contacts act takes at least, about \[s\].
    fn least_work(&self, model: &TissueModel, contacts: usize) -> f64 {
        let _ = contacts;
        work::of_explicit_step(model)
    }

    /// A copy, for a scene that is copied.
    fn boxed_clone(&self) -> Box<dyn Solver>;
}

impl Clone for Box<dyn Solver> {
    fn clone(&self) -> Self {
        self.boxed_clone()
    }
}

/// Up to where the forces of a step mean something: below either of these. Where all forces are small the residual relative to them means
/// little, where they are large the residual itself does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ResidualBounds {
    /// Residual relative to the forces. By default a tenth.
    pub relative: f64,
    /// The residual itself \[N\]. By default 1 mN, from which on jaws count as gripping.
    pub force: f64,
}

impl Default for ResidualBounds {
    fn default() -> Self {
        Self {
            relative: 0.1,
            force: 1e-3,
        }
    }
}

impl ResidualBounds {
    /// Whether a residual, relative to the forces and itself \[N\], is within them; what is no number is within neither.
    pub fn hold(&self, relative: f64, force: f64) -> bool {
        relative <= self.relative || force <= self.force
    }
}

/// Up to where the forces of a step are those that the equations have as their solution: below all of these.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolutionBounds {
    /// Residual relative to the forces. By default a hundredth.
    pub relative: f64,
    /// The residual itself \[N\]. By default 3 mN, a tenth of what levels count as excess.
    pub force: f64,
    /// Multiplier residual of contacts, relative to the mean edge length. By default a hundredth.
    pub contact: f64,
}

impl Default for SolutionBounds {
    fn default() -> Self {
        Self {
            relative: 0.01,
            force: 3e-3,
            contact: 0.01,
        }
    }
}

impl SolutionBounds {
    /// Whether a residual, relative to the forces and itself \[N\], and that of the contacts are within them; what is no number is not.
    pub fn hold(&self, relative: f64, force: f64, contact: f64) -> bool {
        relative <= self.relative && force <= self.force && contact <= self.contact
    }
}

/// What a step took, and how far it is from the solution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepReport {
    /// Iterations; 1 for a method without any.
    pub iterations: u32,
    /// Residual of the equation that the method solves, relative to the forces in it; 0 for a method without any.
    pub residual: f64,
    /// The residual itself, a norm over all free nodes \[N\].
    pub force_residual: f64,
    /// Multiplier residual of the contacts, relative to the mean edge length: gaps below their floors, and forces across open ones; 0
    /// for a method without multipliers. Of a quasi-static step that must converge at least how far nodes go when it is solved again with the
    /// contacts of its solution.
    pub contact_residual: f64,
    /// Whether residual and contact residual met the tolerances of the method; true for a method without any. A quasi-static step that must
    /// converge fails by its residual alone: where its contacts are not those of its solution, this is false.
    pub converged: bool,
    /// Halvings of an iteration after which surfaces had turned too far.
    pub backtracks: u32,
    /// Iterations in which contact forces could not be found and remained those of before.
    pub contact_failures: u32,
    /// Work \[s\]: what its operations take on a core of a usual kind, by their count.
    pub work: f64,
    /// Whether it ended above the tolerance because it had taken the work that it may take.
    pub is_cut_short: bool,
}

impl StepReport {
    /// The report of a method that solves no equation, or only estimates its solution, in so many iterations.
    pub fn without_residual(iterations: u32) -> Self {
        Self {
            iterations,
            residual: 0.0,
            force_residual: 0.0,
            contact_residual: 0.0,
            converged: true,
            backtracks: 0,
            contact_failures: 0,
            work: 0.0,
            is_cut_short: false,
        }
    }

    /// Joins the report of a further equation of the same step.
    pub fn join(&mut self, other: &Self) {
        self.iterations += other.iterations;
        self.residual = self.residual.max(other.residual);
        self.force_residual = self.force_residual.max(other.force_residual);
        self.contact_residual = self.contact_residual.max(other.contact_residual);
        self.converged &= other.converged;
        self.backtracks += other.backtracks;
        self.contact_failures += other.contact_failures;
        self.work += other.work;
        self.is_cut_short |= other.is_cut_short;
    }
}

/// Why a step was not made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StepFailure {
    /// A number is not finite.
    NotFinite,
    /// The iteration came to its end with this residual, relative to the forces.
    NotConverged {
        /// Iterations made.
        iterations: u32,
        /// What is left.
        residual: f64,
    },
    /// The linear system has no solution to rounding: a node, with others or alone, can move without resistance.
    Singular {
        /// The node.
        node: u32,
    },
    /// The method cannot enforce non-penetration.
    NoContact {
        /// Why, with the remedy.
        reason: &'static str,
    },
}

impl std::fmt::Display for StepFailure {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::NotFinite => f.write_str("a number is not finite"),
            Self::NotConverged {
                iterations,
                residual,
            } => write!(
                f,
                "not converged after {iterations} iterations, {residual:.1e} of the forces are left"
            ),
            Self::Singular { node } => write!(
                f,
                "node {node} can move without resistance: the body needs a clamp or something to rest on, or a method with inertia and a shorter step"
            ),
            Self::NoContact { reason } => {
                write!(f, "the method cannot keep bodies apart: {reason}")
            }
        }
    }
}

impl std::error::Error for StepFailure {}
