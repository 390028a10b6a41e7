//! The report of a tick.

use crate::divergence::Divergence;

/// The report of one tick.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TickReport {
    /// One entry per contact pair that touched, in the order of the scene's pairs.
    pub contacts: Vec<ContactReport>,
    /// One entry per body and tool that cut it, and per body that tore.
    pub cuts: Vec<CutReport>,
    /// Cuts that could not be made: the body is as it was.
    pub rejected: Vec<RejectedCut>,
    /// By how much the solver's step was divided so that no tool moves too far in one: 1 when it was not.
    pub substeps: u32,
    /// Whether a tool was so fast that it took more than [`MANY_SUBSTEPS`].
    pub many_substeps: bool,
    /// The tools that moved so far near tissue that they cannot have been moved by a hand: they were not swept through what lies
    /// between, but are at once where they went, and push from there.
    pub jumped: Vec<usize>,
    /// Whether plastic flow has made a body so stiff that it needs more steps than were asked for.
    pub stiffened: bool,
    /// Ticks that had to be repeated with more sub-steps.
    pub recoveries: Vec<Recovery>,
    /// Indices of motions that were left out: unknown tool, a second motion of one tool, or a number that is not finite.
    pub invalid_motions: Vec<usize>,
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
    /// How long the force was above the limit of the pair \[s\].
    pub over_limit_s: f64,
    /// Fraction of the normal force that acted where nothing slid, 0 (all slides, or there is no friction) to 1 (all sticks).
    pub stick_fraction: f64,
    /// Force with which both jaws of a tool squeezed the body between them, mean over the tick \[N\]: the smaller of what each pushed
    /// it towards the other one, without friction; 0 where they pushed to the same side.
    pub grip_n: f64,
    /// Larger mean pressure of the two jaws over the surface that each touched \[Pa\], by the areas at rest; 0 of a tool without jaws.
    pub jaw_pressure_pa: f64,
}

/// What a tool cut in a tick, or what tore.
#[derive(Clone, Debug, PartialEq)]
pub struct CutReport {
    /// Index of the body.
    pub body: usize,
    /// Index of the tool; `None` of tissue that tore by itself.
    pub tool: Option<usize>,
    /// Elements that were divided in this tick. A tick that divides and lays nothing open is not reported: all that were divided are counted by
    /// [`BodyView::cut_tally`](crate::BodyView::cut_tally).
    pub divided: usize,
    /// Area that was opened, of one side, at rest \[m²\].
    pub area: f64,
    /// Its centroid at rest, in the world \[m\].
    pub rest_centroid: [f64; 3],
    /// Its mean normal at rest, of length 1.
    pub rest_normal: [f64; 3],
    /// Its centroid now \[m\].
    pub centroid: [f64; 3],
    /// Its mean normal now, of length 1.
    pub normal: [f64; 3],
    /// Size of the mean force of the tool on the body in the tick \[N\]; 0 where the two do not touch.
    pub force_n: f64,
    /// Numbers of the pieces that came off.
    pub pieces: Vec<u32>,
}

/// A cut that could not be made.
#[derive(Clone, Debug, PartialEq)]
pub struct RejectedCut {
    /// Index of the body.
    pub body: usize,
    /// Index of the tool.
    pub tool: usize,
    /// Why.
    pub why: String,
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
