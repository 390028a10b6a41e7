//! The report of a tick.

use crate::cut_report::{CutReport, RejectedCut};
use crate::divergence::Divergence;
use microsim_tissue::StepReport;

/// The report of one tick.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TickReport {
    /// One entry per contact pair that touched, in the order of the scene's pairs.
    pub contacts: Vec<ContactReport>,
    /// One entry per body and tool that cut it, and per body that tore.
    pub cuts: Vec<CutReport>,
    /// Cuts that could not be made: the body is as it was.
    pub rejected: Vec<RejectedCut>,
    /// By how much the solver's step was to be divided so that no tool moves too far in one: 1 when it was not.
    pub substeps: u32,
    /// Whether a tool was so fast that it took more than [`MANY_SUBSTEPS`].
    pub many_substeps: bool,
    /// The tools that moved so far near tissue that they cannot have been moved by a hand: they were not swept through what lies
    /// between, but are at once where they went, and push from there.
    pub jumped: Vec<usize>,
    /// Whether plastic flow or stretch has made a body so stiff that it needs more steps than were asked for.
    pub stiffened: bool,
    /// Repetitions with more sub-steps because a body diverged.
    pub recoveries: Vec<Recovery>,
    /// All repetitions: those, and those of a tick whose forces meant nothing.
    pub repetitions: u32,
    /// Shreds that were taken away, as the forces of the tick meant nothing with them.
    pub ruptured: u32,
    /// How far the solver came.
    pub solver: SolverReport,
    /// Whether the forces mean anything.
    pub valid: bool,
    /// Whether the tick could only be computed with the tools where they were, or touching nothing, which is never valid; then they follow the hand more slowly for a while.
    pub stands: bool,
    /// Whether its work was bounded by its budget.
    pub over_budget: bool,
    /// The work of all its tries \[s\], as [`SolverReport::work`] is that of the last.
    pub work: f64,
    /// Of each body at which an overlap from before a step was undone, its index and the ids of the nodes, ascending; of one that is watched alone.
    pub overlaps_undone: Vec<(usize, Vec<u32>)>,
    /// Pairs of tools that touched each other, the smaller index first, ascending.
    pub touching: Vec<[usize; 2]>,
    /// Indices of motions that were left out: unknown tool, a second motion of one tool, or a number that is not finite.
    pub invalid_motions: Vec<usize>,
}

/// How far the solver came in the steps of a tick, of all bodies; of the attempt that the tick ended with. Bodies that may touch are
/// solved together, and a step of each of these groups counts as one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SolverReport {
    /// Steps.
    pub steps: u32,
    /// Steps that ended above the tolerance of the method.
    pub unconverged: u32,
    /// Iterations of all steps.
    pub iterations: u32,
    /// Largest residual of a step, relative to the forces in it.
    pub residual: f64,
    /// Largest residual itself, a norm over all free nodes \[N\].
    pub force_residual: f64,
    /// Largest multiplier residual of a step's contacts, relative to the mean edge length.
    pub contact_residual: f64,
    /// Halvings of iterations after which surfaces had turned too far.
    pub backtracks: u32,
    /// Iterations in which contact forces could not be found and remained those of before.
    pub contact_failures: u32,
    /// Work \[s\]: what the operations of the steps take on a core of a usual kind, by their count.
    pub work: f64,
    /// Steps that ended above the tolerance because they had taken the work that they may take.
    pub cut_short: u32,
}

impl SolverReport {
    /// Adds a step.
    pub(crate) fn add(&mut self, step: &StepReport) {
        self.steps += 1;
        self.unconverged += u32::from(!step.converged);
        self.iterations += step.iterations;
        self.residual = self.residual.max(step.residual);
        self.force_residual = self.force_residual.max(step.force_residual);
        self.contact_residual = self.contact_residual.max(step.contact_residual);
        self.backtracks += step.backtracks;
        self.contact_failures += step.contact_failures;
        self.work += step.work;
        self.cut_short += u32::from(step.is_cut_short);
    }
}

/// Sub-steps from which on a tick reports them as many (NUMERICS 6).
pub const MANY_SUBSTEPS: u32 = 16;

/// What a body touches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ContactPartner {
    /// A tool, by its index.
    Tool(usize),
    /// An obstacle, by its index.
    Obstacle(usize),
    /// Another body, by its index.
    Body(usize),
    /// Itself.
    Itself,
}

/// What a tool, an obstacle or another body did to a body in a tick.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactReport {
    /// Index of the body.
    pub body: usize,
    /// What it touched.
    pub with: ContactPartner,
    /// Force on the body, mean over the tick, in the world \[N\]; zero of a body that touches itself, of which peak and impulse are sums
    /// of sizes.
    pub force_on_tissue: [f64; 3],
    /// Largest size of the force in a solver's step \[N\]. A landing acts over one step: its peak grows as steps get shorter.
    pub peak_force_n: f64,
    /// Integral of the size of the force over the tick \[N·s\].
    pub impulse_ns: f64,
    /// Where the force acts, in the world: mean of the touched nodes' positions, weighted by their forces \[m\].
    pub point: [f64; 3],
    /// Depth of the deepest point that was still inside after a step \[m\].
    pub max_depth_m: f64,
    /// Largest displacement of a touched node from its rest position along the mean force, at the end of the tick \[m\].
    pub indentation_m: f64,
    /// Number of different nodes that were touched.
    pub nodes: usize,
    /// The pieces of the body that were touched, by their numbers, ascending.
    pub pieces: Vec<u32>,
    /// Size of the mean force over the last [`FORCE_WINDOW`](crate::FORCE_WINDOW) \[N\], of ticks that are valid.
    pub sustained_force_n: f64,
    /// Mean of the grip over that time \[N\].
    pub sustained_grip_n: f64,
    /// How long the sustained force was above the limit of the pair \[s\]: the tick or nothing.
    pub over_limit_s: f64,
    /// Fraction of the normal force that acted where nothing slid, 0 (all slides, or there is no friction) to 1 (all sticks).
    pub stick_fraction: f64,
    /// Force with which both jaws of a tool squeezed the body between them, mean over the tick \[N\]: the smaller of what each pushed
    /// it towards the other one, without friction; 0 where they pushed to the same side.
    pub grip_n: f64,
    /// The parts of a tool that touched, by their capsules, ascending.
    pub parts: Vec<PartReport>,
    /// The regions of the body that were touched, ascending.
    pub regions: Vec<RegionReport>,
    /// Larger mean pressure of the two jaws over the surface that each touched \[Pa\], by the areas at rest; 0 of a tool without jaws.
    pub jaw_pressure_pa: f64,
}

/// What one part of a tool did to a body in a tick. Forces of opposing jaws cancel in that of their tool, and not here.
#[derive(Clone, Debug, PartialEq)]
pub struct PartReport {
    /// Its index among the capsules of the tool.
    pub capsule: u32,
    /// Mean force on the tissue \[N\].
    pub force_on_tissue: [f64; 3],
    /// Mean of the sum of the sizes of its normal forces \[N\].
    pub normal_force_n: f64,
    /// Mean of the touched points, weighted by their forces \[m\].
    pub point: [f64; 3],
    /// How many nodes were touched.
    pub nodes: usize,
}

/// What acted on one region of a body in a tick. A point on the border of regions counts for each by the area at rest of its triangles there.
#[derive(Clone, Debug, PartialEq)]
pub struct RegionReport {
    /// The region of the mesh's elements.
    pub region: u32,
    /// Mean force on it \[N\]: those of all regions sum up to the force on the body, of a body that touches itself to zero.
    pub force_on_tissue: [f64; 3],
    /// Mean of the sum of the sizes of its normal forces \[N\].
    pub normal_force_n: f64,
    /// Mean of the touched points, weighted by their forces \[m\].
    pub point: [f64; 3],
}

/// A tick that was repeated because a body diverged.
#[derive(Clone, Debug, PartialEq)]
pub struct Recovery {
    /// Index of the body that diverged.
    pub body: usize,
    /// How.
    pub what: Divergence,
    /// By how much the steps were divided in the next try: 2, 4 or 8.
    pub factor: u32,
}
