//! Newton's method for the positions at the end of a step: what all implicit methods share.
//!
//! Every stage of the implicit methods here, and static equilibrium, is one equation for positions x,
//!
//! ```text
//! m ((v − ṽ)/η + c v) = f(x, v)        v = (x − x̃)/η
//! ```
//!
//! with a span η, a base x̃, ṽ that is known, all forces f of elements, weight and loads, and the drag c; in statics the left
//! side and v are zero. Prescribed nodes stand where they are told.
//!
//! # The iteration
//! The matrix is K + D/η + (1/η² + c/η) M, with K exact where that is positive definite, else the nearest one per element
//! without negative eigenvalues: then the step goes down the potential
//!
//! ```text
//! Φ(x) = E(x) + Σ m/2 (|x − x̃ − ηṽ|²/η² + c |x − x̃|²/η) − n·x
//! ```
//!
//! with all forces that have no energy (viscous ones, pressures that follow a surface) taken into n as they are at the start
//! of the iteration. A line search backs off until Φ falls enough (Armijo), or, where it falls by no more than rounding or all forces
//! fall to a tenth, until its slope does (the approximate Wolfe condition of Hager & Zhang 2005).
//!
//! Far from the solution an iteration goes a bent way, x + s d + s² c with the direction d of Newton's method and K c = ½ ∂²f/∂s² along
//! it, for one more solution with the same factor: the forces along the way then deviate from their linear decrease by s³ only. A
//! beam that swings by a third of its length needs four iterations so, nine on straight ways. (Of the methods of Chebyshev and
//! Halley; the second derivative is a difference of forces.)
//!
//! In the first iteration prescribed nodes jump to their places and the linear system says how all others go along; where that
//! raises Φ over the jump alone, less of it is taken.
//!
//! # Contact
//! Contacts (`gaps`) are found where an iteration starts; its direction keeps them, its potential has their energy, and its way is
//! straight. After a few iterations of one equation they keep their features and normals. Where gaps found at the end are far below their
//! floors, iterations are made beyond those asked for.
//!
//! Quick steps are those of time that need not converge, of small bodies with contacts. Their tangents are positive, so that contacts can
//! be settled among themselves. An iteration at whose end surfaces have turned so much that gaps are far below their floors is gone back, up to an
//! eighth of it. After a short one the matrix is kept for the next; one that moves hardly anything ends the step.
//!
//! # Limitations
//! The derivative of viscous forces by positions is left out, so with viscosity the last iterations converge linearly, by a
//! factor of the order of the strain in one step, not quadratically. Of the derivative of pressures the symmetric part alone
//! is taken, which is all of it for a closed surface or one with a prescribed rim.

mod descent;
mod gaps;
mod known;
mod touch;

use crate::contact::{Contact, ContactSource};
use crate::elements::Tangent;
use crate::executor::Executor;
use crate::model::TissueModel;
use crate::parts::Parts;
use crate::solver::{StepFailure, StepReport};
use crate::state::{Control, State};
use crate::system::{Shares, System};
use gaps::Gaps;
use known::KnownForces;
use microsim_sparse::NotPositive;
use nalgebra::Vector3;

/// The share of a step at which the curvature of the forces along it is measured.
const PROBE: f64 = 1.0 / 64.0;

/// The way of an iteration is bent only while at least this share of the forces is left, and where curvature changes at least
/// [`CURVED`] of what is left: straight steps converge quadratically below, and differences have no digits there.
const FAR: f64 = 1e-3;
const CURVED: f64 = 0.02;

/// The residual at which linear systems are solved, as a share of the tolerance of Newton's method, and the least and the largest
/// one, as shares of the right-hand side; for the curvature of the way, and for friction that need not converge, two digits are enough.
const LINEAR: f64 = 0.1;
const LINEAR_TOLERANCES: [f64; 2] = [1e-8, 1e-3];
const ROUGH: f64 = 1e-2;

/// A static body with less than this share of its forces left takes no work, however large the tolerance: forces of clamps are among
/// them, and may be many times those of a load that is to move it.
const AT_REST: f64 = 1e-6;

/// The miss of the multipliers of contacts that may be left, as a share of an edge: where the method must converge, and where not.
const SLACK: [f64; 2] = [1e-5, 1e-3];

/// An overlap that is this share of an edge takes up to so many iterations more than were asked for: surfaces turn in large steps.
const OVERLAP: f64 = 0.02;
const MORE: u32 = 3;

/// How often an iteration of a quick step goes back half of its way where that led to such overlaps.
const RETREATS: u32 = 3;

/// How often contacts are found for an equation; then they keep their features and normals. Features of equal distance could
/// take turns for ever. In quick steps they then keep the bounds of friction too, so that only elements, and which contacts are closed or
/// stick, are left to the other iterations; cuts lie where they do with any such number (tests/results/tune_coordination.md).
const FINDS: u32 = 5;
const FINDS_QUICK: u32 = 4;

/// The step of an iteration, as a share of an edge, that ends a quick step, and the one after which it keeps the matrix for the next iteration.
/// What is held slides by what is left in every step, so the first is far below the slack of gaps.
const STILL: f64 = 1e-4;
const SHORT: f64 = 2e-2;

/// So many iterations in a row that do not halve the residual end a quick step.
const PATIENCE: u32 = 3;

/// Where contacts open and close for ever the last digits do not come: so many times the tolerance is enough then.
const STALLED: f64 = 100.0;

/// How far Newton's method goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Newton {
    /// Most iterations per equation, at least 1. One is the linearly implicit variant of a method.
    pub iterations: u32,
    /// The residual at which an equation is solved, as a share of the forces in it. One that is no more than the rounding of
    /// positions counts as 0.
    pub tolerance: f64,
    /// Whether a step that ends above the tolerance fails – above 100 times the tolerance where something is touched. If not, it is made: every iteration has gone down the potential, or part of that way where surfaces have turned.
    pub must_converge: bool,
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

/// One equation.
#[derive(Clone, Debug)]
pub(crate) struct Equation {
    /// 1/η \[1/s\]; 0 in statics.
    pub rate: f64,
    /// x̃ \[m\].
    pub base: Vec<Vector3<f64>>,
    /// ṽ \[m/s\].
    pub base_velocities: Vec<Vector3<f64>>,
    /// A force that does not depend on anything \[N\], for the steps of a static load; empty for none.
    pub extra: Vec<Vector3<f64>>,
    /// Springs from each node to its x̃ \[N/m\], in statics; empty for none.
    pub hold: Vec<f64>,
}

/// Contact in one equation.
pub(crate) struct Touch<'a> {
    pub source: &'a mut dyn ContactSource,
    /// Since when sliding counts.
    pub since: Since<'a>,
    /// The share of the step at which the equation is.
    pub way: f64,
}

/// A time in a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Since<'a> {
    /// Positions then \[m\].
    pub positions: &'a [Vector3<f64>],
    /// The share of the way of rigid things up to the equation that comes after it.
    pub drift: f64,
}

impl<'a> Since<'a> {
    /// The start of the step.
    pub fn all(positions: &'a [Vector3<f64>]) -> Self {
        Self {
            positions,
            drift: 1.0,
        }
    }
}

/// Working memory for one model.
#[derive(Clone, Debug)]
pub(crate) struct NewtonSolver {
    system: System,
    forces: KnownForces,
    viscous: bool,
    /// Drag per mass of each node \[1/s\].
    drags: Vec<f64>,
    /// Where the equation is being evaluated; its positions are the solution in the end.
    pub trial: State,
    /// Sum of all forces at `trial` minus the left side \[N\].
    residual: Vec<Vector3<f64>>,
    direction: Vec<Vector3<f64>>,
    /// c of the way x + s d + s² c \[m\].
    bend: Vec<Vector3<f64>>,
    /// Positions at the start of an iteration.
    from: Vec<Vector3<f64>>,
    /// n: the forces without energy at the start of an iteration \[N\].
    loads: Vec<Vector3<f64>>,
    scratch: Vec<Vector3<f64>>,
    gaps: Gaps,
    parts: Parts,
    /// Whether the momentum of free parts is kept to rounding.
    balanced: bool,
    /// How often contacts were found for this equation.
    finds: u32,
    /// Bound of the highest frequency \[1/s\].
    frequency: f64,
    /// The residual without the forces of contacts \[N\].
    others: Vec<Vector3<f64>>,
    /// The stiffness of each node by itself at rest \[N/m\].
    stiffness: Vec<f64>,
    /// Whether the matrix of the last iteration is good for the next one.
    keeps_matrix: bool,
    /// The residual at the start of an iteration, while others are computed \[N\].
    kept: Vec<Vector3<f64>>,
}

/// What an iteration did.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Way {
    /// Prescribed nodes have jumped to their ends, the others along.
    Jump,
    /// This share of the step was taken.
    Share(f64),
    /// No way down.
    None,
}

/// What stays the same while one equation is solved.
struct Problem<'a> {
    model: &'a TissueModel,
    control: &'a Control,
    equation: &'a Equation,
    /// Marks of the prescribed nodes.
    fixed: &'a [bool],
    exec: &'a dyn Executor,
}

impl NewtonSolver {
    /// Working memory for `model`.
    pub fn new(model: &TissueModel) -> Self {
        Self::with_system(model, System::new(model))
    }

    /// That for the model of the same body after an edit.
    pub fn following(&self, model: &TissueModel) -> Self {
        Self::with_system(model, self.system.following(model))
    }

    fn with_system(model: &TissueModel, system: System) -> Self {
        let zeros = vec![Vector3::zeros(); model.node_count()];
        Self {
            stiffness: rest_stiffness(model),
            keeps_matrix: false,
            gaps: Gaps::new(model.node_count(), model.mean_edge_length()),
            others: zeros.clone(),
            parts: Parts::new(model),
            balanced: false,
            finds: 0,
            frequency: model.rate_bound().sqrt(),
            system,
            forces: KnownForces::new(model),
            drags: {
                let runs = model.drags().iter();
                runs.flat_map(|(nodes, drag)| std::iter::repeat_n(*drag, nodes.len()))
                    .collect()
            },
            viscous: model.sets().iter().any(|set| set.is_viscous()),
            trial: State::at_rest(model),
            residual: zeros.clone(),
            direction: zeros.clone(),
            bend: zeros.clone(),
            from: zeros.clone(),
            loads: zeros.clone(),
            scratch: zeros.clone(),
            kept: zeros,
        }
    }

    /// Takes over what elements see of `state` besides positions and velocities, and whether the momentum of free parts is to be kept to
    /// rounding, not only to the tolerance.
    pub fn begin(&mut self, state: &State, balanced: bool) {
        self.balanced = balanced;
        self.trial.internal.copy_from_slice(&state.internal);
        self.gaps.clear();
    }

    /// The contacts of the last solution.
    pub fn contacts(&mut self) -> &mut Vec<Contact> {
        &mut self.gaps.contacts
    }

    /// The stiffness of each node by itself at rest \[N/m\].
    pub fn stiffness(&self) -> &[f64] {
        &self.stiffness
    }

    /// All forces on the nodes at `positions` without speed \[N\].
    pub fn static_forces(
        &mut self,
        model: &TissueModel,
        positions: &[Vector3<f64>],
        control: &Control,
        exec: &dyn Executor,
    ) -> &[Vector3<f64>] {
        self.trial.positions.copy_from_slice(positions);
        self.trial.velocities.fill(Vector3::zeros());
        self.forces.compute(model, &self.trial, control, exec)
    }

    /// Solves an equation from the better one of these guesses; `ends` are the places of the nodes marked in `fixed`. The solution
    /// is in `trial`, with the velocities of the equation.
    #[expect(clippy::too_many_arguments, reason = "the types of a step stay apart")]
    pub fn solve(
        &mut self,
        model: &TissueModel,
        control: &Control,
        equation: &Equation,
        fixed: &[bool],
        ends: &[Vector3<f64>],
        guesses: &[&[Vector3<f64>]],
        mut touch: Option<Touch<'_>>,
        options: &Newton,
        exec: &dyn Executor,
    ) -> Result<StepReport, StepFailure> {
        let problem = Problem {
            model,
            control,
            equation,
            fixed,
            exec,
        };
        self.start(&problem, guesses);
        self.finds = 0;
        self.gaps.need_not_converge = equation.rate > 0.0 && !options.must_converge;
        self.find(&problem, touch.as_mut());
        let slack = SLACK[usize::from(!options.must_converge)];
        let mut report = StepReport {
            iterations: 0,
            residual: self.evaluate(&problem, 0.0),
        };
        // In statics a body that has come to rest takes no work; a step of time always has its iteration.
        let moved = |node: usize| ends[node] != self.trial.positions[node];
        if equation.rate == 0.0
            && report.residual <= options.tolerance.min(AT_REST)
            && self.gaps.miss() <= slack
            && !(0..fixed.len()).any(|node| fixed[node] && moved(node))
        {
            self.tell(&problem);
            return Ok(report);
        }
        self.keeps_matrix = false;
        let mut tangent = Tangent::Exact;
        let more = |gaps: &Gaps, iterations| {
            iterations < options.iterations.saturating_add(MORE) && gaps.overlap() > OVERLAP
        };
        let (mut least, mut stalled) = (f64::INFINITY, 0);
        while report.iterations < options.iterations || more(&self.gaps, report.iterations) {
            report.iterations += 1;
            if !report.residual.is_finite() {
                return Err(StepFailure::NotFinite);
            }
            self.from.copy_from_slice(&self.trial.positions);
            self.set_loads(&problem);
            let before = report.residual;
            let rough = if options.must_converge { 0.0 } else { ROUGH };
            let tolerances = [options.tolerance, rough, slack];
            let quick = self.is_quick();
            if quick {
                tangent = Tangent::Positive;
            }
            let mut way = self.go(&problem, ends, &mut tangent, before, tolerances)?;
            match &mut way {
                Way::Share(share) => {
                    *share = self.find_ahead(&problem, touch.as_mut(), *share);
                }
                Way::Jump | Way::None => self.find(&problem, touch.as_mut()),
            }
            report.residual = self.evaluate(&problem, self.noise(fixed));
            if report.residual <= options.tolerance
                && report.residual.is_finite()
                && self.gaps.miss() <= slack
            {
                self.tell(&problem);
                return Ok(report);
            }
            let whole = way == Way::Share(1.0) && quick && self.is_quick();
            // Where forces are small their residual says little.
            let kept = report.residual.is_finite() && self.gaps.overlap() <= OVERLAP;
            if whole && kept && self.gaps.is_short(&self.direction, STILL) {
                self.tell(&problem);
                return Ok(report);
            }
            self.keeps_matrix = whole && self.gaps.is_short(&self.direction, SHORT);
            stalled = match report.residual < 0.5 * least {
                true => 0,
                false => stalled + 1,
            };
            least = least.min(report.residual);
            if stalled >= PATIENCE && self.is_quick() && self.gaps.overlap() <= OVERLAP {
                break;
            }
            match way {
                Way::None => break,
                Way::Share(1.0) if report.residual < 0.5 * before => tangent = Tangent::Exact,
                Way::Share(_) | Way::Jump => {}
            }
        }
        if !report.residual.is_finite() {
            return Err(StepFailure::NotFinite);
        }
        let enough = match self.gaps.is_empty() {
            true => options.tolerance,
            false => STALLED * options.tolerance,
        };
        if options.must_converge && report.residual > enough {
            return Err(StepFailure::NotConverged {
                iterations: report.iterations,
                residual: report.residual,
            });
        }
        self.tell(&problem);
        Ok(report)
    }

    /// Goes the way of one iteration from `trial`, whose residual is the share `residual` of the forces: with the matrix asked for in
    /// `tangent`, or with the positive one where that is indefinite or shows no way down. `tangent` becomes the one that was used.
    fn go(
        &mut self,
        problem: &Problem<'_>,
        ends: &[Vector3<f64>],
        tangent: &mut Tangent,
        residual: f64,
        [tolerance, rough, slack]: [f64; 3],
    ) -> Result<Way, StepFailure> {
        let linear_tolerance =
            (LINEAR * tolerance / residual).clamp(LINEAR_TOLERANCES[0], LINEAR_TOLERANCES[1]);
        let tolerances = [linear_tolerance, rough, slack];
        loop {
            let exact = *tangent == Tangent::Exact;
            let jumps = self.set_jumps(problem.fixed, ends);
            let direction = self
                .factorise(problem, *tangent)
                .and_then(|()| self.set_direction(problem.fixed, jumps, tolerances))
                .map(|()| jumps);
            match direction {
                Ok(true) => {
                    self.lift(problem, ends);
                    return Ok(Way::Jump);
                }
                Ok(false) => {
                    // A bent way would not keep gaps.
                    let far = exact && residual >= FAR && self.gaps.is_empty();
                    self.set_bend(problem, far);
                    let share = self.search(problem);
                    if share > 0.0 {
                        return Ok(Way::Share(share));
                    }
                    if !exact && !self.keeps_matrix {
                        return Ok(Way::None);
                    }
                    self.evaluate(problem, 0.0);
                }
                Err(_) if exact || self.keeps_matrix => {}
                Err(failure) => return Err(self.why_not_positive(failure)),
            }
            *tangent = Tangent::Positive;
            self.keeps_matrix = false;
        }
    }

    /// Sets `trial` to the guess with the lowest potential.
    fn start(&mut self, problem: &Problem<'_>, guesses: &[&[Vector3<f64>]]) {
        let mut lowest = f64::INFINITY;
        let mut best = 0;
        if guesses.len() > 1 {
            self.from.copy_from_slice(guesses[0]);
            self.place(problem, guesses[0]);
            self.set_loads(problem);
            for (index, guess) in guesses.iter().enumerate() {
                self.place(problem, guess);
                let potential = self.potential(problem).value;
                if potential < lowest {
                    lowest = potential;
                    best = index;
                }
            }
        }
        self.place(problem, guesses[best]);
    }

    fn place(&mut self, problem: &Problem<'_>, positions: &[Vector3<f64>]) {
        self.trial.positions.copy_from_slice(positions);
        self.set_velocities(problem);
    }

    /// v = (x − x̃)/η.
    fn set_velocities(&mut self, problem: &Problem<'_>) {
        let equation = problem.equation;
        if equation.rate == 0.0 {
            self.trial.velocities.fill(Vector3::zeros());
            return;
        }
        for ((v, x), base) in self
            .trial
            .velocities
            .iter_mut()
            .zip(&self.trial.positions)
            .zip(&equation.base)
        {
            *v = (x - base) * equation.rate;
        }
    }

    /// The left side of the equation at a node of `trial` \[N\].
    #[inline]
    fn inertia(&self, problem: &Problem<'_>, node: usize) -> Vector3<f64> {
        let Equation {
            rate,
            base_velocities,
            ..
        } = problem.equation;
        if *rate == 0.0 {
            return Vector3::zeros();
        }
        let v = self.trial.velocities[node];
        ((v - base_velocities[node]) * *rate + v * self.drags[node]) * problem.model.inertia(node)
    }

    /// Computes the residual at `trial`; returns its size as a share of the forces, 0 where it is not above `noise`.
    fn evaluate(&mut self, problem: &Problem<'_>, noise: f64) -> f64 {
        self.forces
            .compute(problem.model, &self.trial, problem.control, problem.exec);
        let weight = problem.control.gravity.norm();
        let (mut left, mut scale) = (0.0, 0.0);
        for node in 0..problem.model.node_count() {
            let mut force = self.forces.last()[node];
            if let Some(extra) = problem.equation.extra.get(node) {
                force += extra;
            }
            let mass = problem.model.masses()[node];
            scale += force.norm_squared() + (mass * weight) * (mass * weight);
            self.residual[node] = Vector3::zeros();
            if !problem.fixed[node] {
                let mut inertia = self.inertia(problem, node);
                if let Some(hold) = problem.equation.hold.get(node) {
                    let way = self.trial.positions[node] - problem.equation.base[node];
                    inertia += way * *hold;
                }
                scale += inertia.norm_squared();
                let residual = force - inertia;
                self.residual[node] = residual;
                left += residual.norm_squared();
            }
        }
        // Loads count by themselves too: where they are in equilibrium nothing is left of them in the sums above.
        self.scratch.fill(Vector3::zeros());
        problem
            .control
            .add_loads(&self.trial.positions, &mut self.scratch);
        scale += self.scratch.iter().map(Vector3::norm_squared).sum::<f64>();
        if !self.gaps.is_empty() {
            self.others.copy_from_slice(&self.residual);
            self.add_contacts(problem.fixed);
            left = 0.0;
            for (residual, others) in self.residual.iter().zip(&self.others) {
                left += residual.norm_squared();
                scale += (residual - others).norm_squared();
            }
        }
        let left = left.sqrt();
        if left <= noise {
            0.0
        } else {
            left / scale.sqrt()
        }
    }

    /// The size of a residual that is only rounding: what the last digits of positions are worth in the last matrix \[N\].
    fn noise(&self, fixed: &[bool]) -> f64 {
        let reach = self
            .trial
            .positions
            .iter()
            .map(|x| x.amax())
            .fold(0.0, f64::max);
        let stiffness: f64 = fixed
            .iter()
            .enumerate()
            .filter(|(_, fixed)| !**fixed)
            .map(|(node, _)| self.system.matrix().diagonal(node).norm_squared())
            .sum();
        // A node sums the forces of some twenty elements, each with a few roundings.
        16.0 * f64::EPSILON * reach * stiffness.sqrt()
    }

    /// Sets n, from `trial`.
    fn set_loads(&mut self, problem: &Problem<'_>) {
        let Problem { model, control, .. } = problem;
        for (load, mass) in self.loads.iter_mut().zip(model.masses()) {
            *load = control.gravity * *mass;
        }
        control.add_loads(&self.trial.positions, &mut self.loads);
        for (load, extra) in self.loads.iter_mut().zip(&problem.equation.extra) {
            *load += extra;
        }
        if self.viscous && problem.equation.rate > 0.0 {
            let all = self
                .forces
                .compute(model, &self.trial, control, problem.exec);
            self.scratch.copy_from_slice(all);
            self.trial.velocities.fill(Vector3::zeros());
            let elastic = self
                .forces
                .compute(model, &self.trial, control, problem.exec);
            for ((load, all), elastic) in self.loads.iter_mut().zip(&self.scratch).zip(elastic) {
                *load += all - elastic;
            }
            self.set_velocities(problem);
        }
    }

    /// Assembles and factors the matrix at `trial`: with the contacts that are closed along the direction, in a quick step without any. Does nothing
    /// where the matrix is kept.
    fn factorise(&mut self, problem: &Problem<'_>, tangent: Tangent) -> Result<(), NotPositive> {
        if self.keeps_matrix {
            return Ok(());
        }
        let rate = problem.equation.rate;
        let shares = Shares {
            damping: rate,
            rate,
        };
        self.system
            .assemble(problem.model, &self.trial, shares, tangent);
        if tangent == Tangent::Exact {
            self.system
                .add_pressures(&problem.control.pressures, &self.trial.positions);
        }
        for (node, hold) in problem.equation.hold.iter().enumerate() {
            self.system.add_diagonal(node, *hold);
        }
        self.gaps.stiffen(&self.direction, &mut self.system);
        match self.is_quick() {
            true => self.system.factorise_double(problem.fixed),
            false => self.system.factorise(problem.fixed),
        }
    }

    /// Whether contacts are among the forces of a quick step.
    fn is_quick(&self) -> bool {
        !self.gaps.is_empty() && self.gaps.is_quick(&self.system)
    }

    /// No element and no mass makes the positive matrix indefinite: it is singular to rounding, or has numbers that are not finite.
    fn why_not_positive(&self, failure: NotPositive) -> StepFailure {
        let mut values = self.system.matrix().values().iter();
        if values.all(|block| block.sum().is_finite()) {
            StepFailure::Singular {
                node: failure.node as u32,
            }
        } else {
            StepFailure::NotFinite
        }
    }

    /// Sets the direction to the jumps of prescribed nodes, with a guess of how surfaces move others; returns whether there are any.
    fn set_jumps(&mut self, fixed: &[bool], ends: &[Vector3<f64>]) -> bool {
        let mut jumps = false;
        for (node, d) in self.direction.iter_mut().enumerate() {
            *d = Vector3::zeros();
            if fixed[node] {
                *d = ends[node] - self.from[node];
                jumps |= *d != Vector3::zeros();
            }
        }
        if !self.is_quick() {
            self.gaps.predict(&mut self.direction);
        }
        jumps
    }

    /// Solves for the step; the direction holds the jumps of prescribed nodes.
    fn set_direction(
        &mut self,
        fixed: &[bool],
        jumps: bool,
        tolerances: [f64; 3],
    ) -> Result<(), NotPositive> {
        if !self.gaps.is_empty() {
            let Self {
                gaps,
                system,
                others,
                direction,
                ..
            } = self;
            gaps.set_direction(others, fixed, system, tolerances, direction)?;
            // Multipliers have changed.
            self.add_contacts(fixed);
            return Ok(());
        }
        if jumps {
            self.system
                .matrix()
                .multiply(&self.direction, &mut self.scratch);
        }
        for (node, d) in self.direction.iter_mut().enumerate() {
            if !fixed[node] {
                *d = self.residual[node];
                if jumps {
                    *d -= self.scratch[node];
                }
            }
        }
        self.system.solve(&mut self.direction, tolerances[0])
    }

    /// Sets c such that the forces left on the way x + s d + s² c, beyond their linear decrease, are of third order in s:
    /// K c = ½ ∂²r/∂s² along d, from a difference. The residual at the start is kept.
    fn set_bend(&mut self, problem: &Problem<'_>, far: bool) {
        if !far {
            self.bend.fill(Vector3::zeros());
            return;
        }
        self.kept.copy_from_slice(&self.residual);
        for (c, r) in self.bend.iter_mut().zip(&self.residual) {
            *c = r * -2.0;
        }
        for step in [PROBE, -PROBE] {
            for ((x, from), d) in self
                .trial
                .positions
                .iter_mut()
                .zip(&self.from)
                .zip(&self.direction)
            {
                *x = from + d * step;
            }
            self.set_velocities(problem);
            self.evaluate(problem, 0.0);
            for (c, r) in self.bend.iter_mut().zip(&self.residual) {
                *c += r;
            }
        }
        for c in &mut self.bend {
            *c *= 0.5 / (PROBE * PROBE);
        }
        self.residual.copy_from_slice(&self.kept);
        let size = |forces: &[Vector3<f64>]| forces.iter().map(|f| f.norm_squared()).sum::<f64>();
        let curvature = size(&self.bend);
        let mut bent = curvature > CURVED * CURVED * size(&self.residual) && curvature.is_finite();
        if bent {
            let solved = self.system.solve(&mut self.bend, ROUGH).is_ok();
            bent = solved && size(&self.bend) < size(&self.direction);
        }
        if !bent {
            self.bend.fill(Vector3::zeros());
        }
        self.advance(problem, 0.0);
    }
}

/// The stiffness of each node by itself at rest \[N/m\]: the mean of its directions.
fn rest_stiffness(model: &TissueModel) -> Vec<f64> {
    let mut stiffness = vec![0.0; model.node_count()];
    let mut traces = Vec::new();
    for set in model.sets() {
        for element in 0..set.count() {
            set.rest_traces(element, model.rest_positions(), &mut traces);
            for (&node, trace) in set.nodes(element).iter().zip(&traces) {
                stiffness[node as usize] += trace / 3.0;
            }
        }
    }
    stiffness
}
