//! Implicit one-step methods: backward Euler, implicit midpoint, and a second-order L-stable method.
//!
//! All are diagonally implicit Runge–Kutta methods with one coefficient on the diagonal, so each stage is an equation of the
//! same form (`newton`) with the span η, for positions x_n, velocities v_n and a step h:
//!
//! ```text
//! backward Euler     η = h      x̃ = x_n                     ṽ = v_n
//! implicit midpoint  η = h/2    x̃ = x_n                     ṽ = v_n                 then x_{n+1} = 2x − x_n, v_{n+1} = 2v − v_n
//! SDIRK2, stage 1    η = γh     x̃ = x_n                     ṽ = v_n
//!         stage 2    η = γh     x̃ = x_n + (1−γ)h v_1        ṽ = v_n + (1−γ)h a_1    a_1 = (v_1 − v_n)/γh
//! guarded midpoint   as implicit midpoint; where that distorts a tetrahedron
//!         stage 2    η = h/2    x̃ = x                       ṽ = 0                   then x_{n+1} is its solution, v_{n+1} = 0
//! ```
//!
//! The stage of implicit midpoint is backward Euler over half the step; guarded midpoint goes over the other half in the same manner
//! when a tetrahedron has less than half of its volume, or edges 1.5 times as long as at rest (root mean square), in the middle
//! of the step or at the end to which implicit midpoint would go on.
//!
//! With γ = 1 − 1/√2 (Alexander 1977). On linear problems SDIRK2 is TR-BDF2 (Bank et al. 1985), whose amplification is the
//! only one of second order with that denominator that damps stiff modes entirely; without TR-BDF2's explicit first half it
//! does not need the forces at the start, which are large right after a contact or a jump.
//!
//! Non-penetration is enforced at the end of each stage, with restitution 0. What has a force at the end of the first stage of SDIRK2 may be
//! an impact, which must not be extrapolated: the second stage is then backward Euler over the rest of the step. Implicit midpoint would
//! reflect what touches: a step in which something is or comes near is made by SDIRK2 instead. So contact is of first order in all.
//!
//! Drag −c v and viscous forces are taken at the stage, so they are stable for every h. Clamps and targets move evenly
//! during the step and are exactly at their ends in the end.
//!
//! # Limitations
//! An oscillation of frequency ω is multiplied per step by
//!
//! ```text
//! backward Euler     1/√(1 + h²ω²)
//! implicit midpoint  1
//! SDIRK2             √(1 + (1−2γ)²h²ω²)/(1 + γ²h²ω²) = 1 − 0.0037 (hω)⁴ + …, 0 for hω → ∞
//! ```
//!
//! Backward Euler loses 10 % of the amplitude per period already at 200 steps per period, and with it the first peak of a
//! released body: it is for coming to rest. Implicit midpoint keeps the energy of linear bodies; stiff modes ring on in it, and
//! large steps of a nonlinear body, above all from a torn or inverted shape, may feed it until it blows up: there SDIRK2 goes
//! on, and backward Euler comes to rest. Guarded midpoint is implicit midpoint to the bit while nothing is distorted; where something
//! is, the body creeps out of it and loses its speed. That costs a second equation in such steps and, with tissue that is meant to
//! stretch so far, its swing.
//!
//! All conserve linear momentum up to the tolerance; angular momentum only implicit midpoint does. Backward Euler is of first
//! order. With one iteration backward Euler stays of first order and implicit midpoint and SDIRK2 of second, but what is conserved
//! then holds only up to the error of the linearisation. Loads are those of the end of the step in every stage: a load that
//! changes is followed to first order only.

use crate::executor::Executor;
use crate::model::TissueModel;
use crate::newton::{
    Equation, EquationContact, Newton, NewtonOptions, NewtonSolver, SlipReference,
};
use crate::prescribed::Prescribed;
use crate::solver::{Effort, Solver, StepFailure, StepReport};
use crate::state::{Control, NodeTarget, State};
use microsim_contact_solver::{Contact, ContactStep};
use nalgebra::Vector3;

/// γ of SDIRK2, 1 − 1/√2.
const GAMMA: f64 = 1.0 - std::f64::consts::FRAC_1_SQRT_2;

/// Which implicit integrator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ImplicitScheme {
    /// Backward Euler.
    BackwardEuler,
    /// Implicit midpoint.
    Midpoint,
    /// Alexander's method of two stages.
    Sdirk2,
    /// Implicit midpoint, that drops speed in a step in which a tetrahedron is distorted.
    GuardedMidpoint,
}

/// When guarded midpoint takes a tetrahedron for distorted. Stricter values drop the speed of more steps; laxer ones let large steps blow
/// up. Measured on torn and inverted beams (`microsim atlas`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DistortionOptions {
    /// Below this ratio of its volume to that at rest; in 0..0.9.
    pub least_volume: f64,
    /// Or above this root mean square of the stretches of three of its edges; in 1.1..3.
    pub most_stretch: f64,
}

impl Default for DistortionOptions {
    fn default() -> Self {
        Self {
            least_volume: 0.5,
            most_stretch: 1.5,
        }
    }
}

/// The implicit solver, with its working memory for one model.
///
/// ```
/// # use microsim_mesh::{Block, CellSplit};
/// # use microsim_tissue::{Behaviour, Material, SpringConstants, build_model};
/// # let block = Block { center: [0.0; 3], size: [4e-3, 2e-3, 2e-3], cells: [4, 2, 2], split: CellSplit::Kuhn };
/// # let mesh = block.mesh().unwrap();
/// # let springs = Behaviour::Springs(SpringConstants::scaled(25e3, 5e4));
/// # let tissue = Material { density: 1060.0, relaxation_time: 0.0, behaviour: springs };
/// # let clamped: Vec<bool> = mesh.positions.iter().map(|x| x.x < -1.9e-3).collect();
/// # let model = build_model(&mesh, &[(0, tissue)], &clamped, 0.0, Vec::new()).unwrap();
/// use microsim_tissue::{Control, ImplicitScheme, Newton, Serial, Solver, SolverImplicit, State};
///
/// // A block that is clamped at one end, under its weight: steps of time that no explicit method could take.
/// let mut state = State::at_rest(&model);
/// let control = Control { gravity: [0.0, 0.0, -9.81].into(), ..Control::default() };
/// let mut solver = SolverImplicit::new(&model, ImplicitScheme::Sdirk2, Newton::default());
/// let report = solver.step(&model, &mut state, &control, &[], 5e-3, &Serial)?;
/// assert!(report.residual <= 1e-6);
/// assert!(state.energies(&model).kinetic > 0.0);
/// # Ok::<(), microsim_tissue::StepFailure>(())
/// ```
#[derive(Clone, Debug)]
pub struct SolverImplicit {
    scheme: ImplicitScheme,
    newton: Newton,
    distortion: DistortionOptions,
    solver: NewtonSolver,
    equation: Equation,
    prescribed: Prescribed,
    /// Where the prescribed nodes are at the end of a stage \[m\].
    ends: Vec<Vector3<f64>>,
    /// x̃ + ηṽ \[m\].
    ballistic: Vec<Vector3<f64>>,
    /// End of the first of two stages \[m\].
    first_positions: Vec<Vector3<f64>>,
    /// Contacts of the first of two stages.
    first: Vec<Contact>,
    /// Whether the step is one with contact.
    balanced: bool,
}

impl SolverImplicit {
    /// Working memory for `model`.
    pub fn new(model: &TissueModel, scheme: ImplicitScheme, newton: Newton) -> Self {
        let distortion = DistortionOptions::default();
        Self::with_options(model, scheme, newton, &NewtonOptions::default(), distortion)
    }

    /// As [`new`](Self::new), with other constants of Newton's method and of guarded midpoint.
    pub fn with_options(
        model: &TissueModel,
        scheme: ImplicitScheme,
        newton: Newton,
        options: &NewtonOptions,
        distortion: DistortionOptions,
    ) -> Self {
        let solver = NewtonSolver::new(model, options);
        Self::with_solver(model, scheme, newton, distortion, solver)
    }

    fn with_solver(
        model: &TissueModel,
        scheme: ImplicitScheme,
        newton: Newton,
        distortion: DistortionOptions,
        solver: NewtonSolver,
    ) -> Self {
        let zeros = vec![Vector3::zeros(); model.node_count()];
        Self {
            scheme,
            newton,
            distortion,
            solver,
            equation: Equation {
                rate: 0.0,
                base: zeros.clone(),
                base_velocities: zeros.clone(),
                extra: Vec::new(),
                regularisation: Vec::new(),
            },
            prescribed: Prescribed::new(model.node_count()),
            ends: zeros.clone(),
            ballistic: zeros.clone(),
            first_positions: zeros,
            first: Vec::new(),
            balanced: false,
        }
    }

    /// Solves a stage with the span η \[s\] and the base already set; prescribed nodes are at `step_fraction` of their
    /// displacement from `start` \[m\]. `near` is a guess of the solution.
    #[expect(clippy::too_many_arguments, reason = "the types of a step stay apart")]
    fn stage(
        &mut self,
        model: &TissueModel,
        control: &Control,
        span: f64,
        step_fraction: f64,
        start: &[Vector3<f64>],
        near: &[Vector3<f64>],
        contact: Option<(&mut ContactStep<'_>, SlipReference<'_>)>,
        exec: &dyn Executor,
    ) -> Result<StepReport, StepFailure> {
        self.equation.rate = 1.0 / span;
        for (node, start) in start.iter().enumerate() {
            let base = self.equation.base[node];
            self.ballistic[node] = base + self.equation.base_velocities[node] * span;
            // At the end itself for the whole step, so that it is met to the last bit.
            self.ends[node] = if step_fraction == 1.0 {
                self.prescribed.ends[node]
            } else {
                start + (self.prescribed.ends[node] - start) * step_fraction
            };
        }
        let contact = contact.map(|(step, slip_since)| EquationContact {
            source: &mut *step.source,
            slip_since,
            step_fraction,
            most_searches: u32::MAX,
        });
        self.solver.solve(
            model,
            control,
            &self.equation,
            &self.prescribed.fixed,
            &self.ends,
            &[near, &self.ballistic],
            contact,
            &self.newton,
            exec,
        )
    }

    /// Whether an element is flat, inverted or far stretched in the middle of the step or would be so at its end.
    fn is_distorted(&self, model: &TissueModel, state: &State) -> bool {
        let middle = &self.solver.trial.positions;
        let rest = model.rest_positions();
        let DistortionOptions {
            least_volume,
            most_stretch,
        } = self.distortion;
        let squares =
            |[a, b, c]: [Vector3<f64>; 3]| a.norm_squared() + b.norm_squared() + c.norm_squared();
        let edges = |x: &dyn Fn(usize) -> Vector3<f64>, tet: &[u32; 4]| {
            let [a, b, c, d] = tet.map(|node| x(node as usize));
            [b - a, c - a, d - a]
        };
        model
            .tets()
            .iter()
            .zip(model.rest_volumes())
            .any(|(tet, volume)| {
                let most = most_stretch * most_stretch * squares(edges(&|n| rest[n], tet));
                let least = 6.0 * least_volume * volume;
                let bad = |e: [Vector3<f64>; 3]| {
                    !(e[0].dot(&e[1].cross(&e[2])) > least && squares(e) < most)
                };
                bad(edges(&|n| middle[n], tet))
                    || bad(edges(
                        &|n| {
                            if self.prescribed.fixed[n] {
                                self.prescribed.ends[n]
                            } else {
                                middle[n] * 2.0 - state.positions[n]
                            }
                        },
                        tet,
                    ))
            })
    }

    /// The second stage of SDIRK2, after the first.
    fn second_stage(
        &mut self,
        model: &TissueModel,
        state: &State,
        control: &Control,
        mut contact: Option<&mut ContactStep<'_>>,
        h: f64,
        exec: &dyn Executor,
    ) -> Result<StepReport, StepFailure> {
        // What an impact has done must not be extrapolated: it would throw the body back.
        self.first.clone_from(self.solver.contacts());
        let touched = self.first.iter().any(|contact| contact.normal_force > 0.0);
        let span = if touched { 1.0 - GAMMA } else { GAMMA };
        for node in 0..model.node_count() {
            let (velocity, start) = (self.solver.trial.velocities[node], state.velocities[node]);
            if touched {
                self.equation.base[node] = self.first_positions[node];
                self.equation.base_velocities[node] = velocity;
            } else {
                self.equation.base[node] = state.positions[node] + velocity * ((1.0 - GAMMA) * h);
                self.equation.base_velocities[node] =
                    start + (velocity - start) * ((1.0 - GAMMA) / GAMMA);
            }
        }
        let near = std::mem::take(&mut self.first_positions);
        // What has slid in the first stage, whose forces are spent, is not to slide back.
        let since = match touched {
            true => SlipReference {
                positions: &near,
                drift: 1.0 - GAMMA,
            },
            false => SlipReference::start(&state.positions),
        };
        let result = self.stage(
            model,
            control,
            span * h,
            1.0,
            &state.positions,
            &near,
            contact.as_deref_mut().map(|contact| (contact, since)),
            exec,
        );
        self.first_positions = near;
        if contact.is_some() {
            // The mean over the step.
            for contact in self.solver.contacts() {
                // Two partners may touch the same nodes, from different sides.
                let same = |first: &Contact| {
                    first.nodes == contact.nodes
                        && first.first == contact.first
                        && first.normal.dot(&contact.normal) > 0.0
                };
                contact.normal_force *= span;
                contact.friction_force *= span;
                if let Some(place) = self.first.iter().position(same) {
                    let first = self.first.remove(place);
                    contact.normal_force += GAMMA * first.normal_force;
                    contact.friction_force += first.friction_force * GAMMA;
                }
            }
        }
        result
    }

    /// Whether anything is or will be touched where nodes fly on.
    fn is_touched(&mut self, state: &State, contact: &mut ContactStep<'_>, h: f64) -> bool {
        for (node, x) in self.ballistic.iter_mut().enumerate() {
            *x = match self.prescribed.fixed[node] {
                true => self.prescribed.ends[node],
                false => state.positions[node] + state.velocities[node] * h,
            };
        }
        contact.contacts.clear();
        let source = &mut contact.source;
        source.find(1.0, &self.ballistic, &mut contact.contacts);
        !contact.contacts.is_empty()
    }

    /// Makes a step by `scheme`; prescribed nodes are set.
    #[expect(clippy::too_many_arguments, reason = "the types of a step stay apart")]
    fn make(
        &mut self,
        scheme: ImplicitScheme,
        model: &TissueModel,
        state: &mut State,
        control: &Control,
        mut contact: Option<&mut ContactStep<'_>>,
        h: f64,
        exec: &dyn Executor,
    ) -> Result<StepReport, StepFailure> {
        self.solver.begin(state, self.balanced);
        self.equation.base.copy_from_slice(&state.positions);
        self.equation
            .base_velocities
            .copy_from_slice(&state.velocities);
        let (span, step_fraction) = match scheme {
            ImplicitScheme::BackwardEuler => (h, 1.0),
            ImplicitScheme::Midpoint | ImplicitScheme::GuardedMidpoint => (0.5 * h, 0.5),
            ImplicitScheme::Sdirk2 => (GAMMA * h, GAMMA),
        };
        let start = &state.positions;
        let mut report = self.stage(
            model,
            control,
            span,
            step_fraction,
            start,
            start,
            contact
                .as_deref_mut()
                .map(|contact| (contact, SlipReference::start(start))),
            exec,
        )?;
        if scheme == ImplicitScheme::Sdirk2 {
            self.first_positions
                .copy_from_slice(&self.solver.trial.positions);
            let second =
                self.second_stage(model, state, control, contact.as_deref_mut(), h, exec)?;
            report.join(&second);
        }
        // The stage of implicit midpoint is a step of backward Euler over half the time: where the other half would be nonsense,
        // it is made in the same manner.
        let guarded = scheme == ImplicitScheme::GuardedMidpoint && self.is_distorted(model, state);
        if guarded {
            let trial = &self.solver.trial;
            self.equation.base.copy_from_slice(&trial.positions);
            self.equation.base_velocities.fill(Vector3::zeros());
            let mut half = std::mem::take(&mut self.first_positions);
            half.copy_from_slice(&trial.positions);
            let result = self.stage(model, control, 0.5 * h, 1.0, &half, &half, None, exec);
            self.first_positions = half;
            let second = result?;
            report.join(&second);
        }
        if let Some(contact) = contact {
            let (equation, fixed) = (&self.equation, &self.prescribed.fixed);
            self.solver
                .undo_overlaps(model, control, equation, fixed, h, exec)?;
            std::mem::swap(self.solver.contacts(), &mut contact.contacts);
        }
        let trial = &mut self.solver.trial;
        if guarded {
            trial.velocities.fill(Vector3::zeros());
        }
        if matches!(
            scheme,
            ImplicitScheme::Midpoint | ImplicitScheme::GuardedMidpoint
        ) && !guarded
        {
            for node in 0..model.node_count() {
                trial.positions[node] = if self.prescribed.fixed[node] {
                    self.prescribed.ends[node]
                } else {
                    trial.positions[node] * 2.0 - state.positions[node]
                };
                trial.velocities[node] = trial.velocities[node] * 2.0 - state.velocities[node];
            }
        }
        self.prescribed
            .set_velocities(&state.positions, h, &mut trial.velocities);
        if !trial.is_finite() {
            return Err(StepFailure::NotFinite);
        }
        state.positions.copy_from_slice(&trial.positions);
        state.velocities.copy_from_slice(&trial.velocities);
        state.accelerations.clear();
        state.step = h;
        Ok(report)
    }
}

impl Solver for SolverImplicit {
    fn advance(
        &mut self,
        model: &TissueModel,
        state: &mut State,
        control: &Control,
        targets: &[NodeTarget],
        contact: Option<&mut ContactStep<'_>>,
        h: f64,
        exec: &dyn Executor,
    ) -> Result<StepReport, StepFailure> {
        if !state.is_finite() {
            return Err(StepFailure::NotFinite);
        }
        self.prescribed.set(model, state, control, targets);
        let midpoint = matches!(
            self.scheme,
            ImplicitScheme::Midpoint | ImplicitScheme::GuardedMidpoint
        );
        self.balanced = contact.is_some();
        let Some(contact) = contact else {
            return self.make(self.scheme, model, state, control, None, h, exec);
        };
        let mut scheme = self.scheme;
        if midpoint {
            if !self.is_touched(state, contact, h) {
                let before = state.clone();
                let report = self.make(scheme, model, state, control, None, h, exec)?;
                contact.contacts.clear();
                let source = &mut contact.source;
                source.find(1.0, &state.positions, &mut contact.contacts);
                if contact.contacts.is_empty() {
                    return Ok(report);
                }
                *state = before;
            }
            scheme = ImplicitScheme::Sdirk2;
        }
        self.make(scheme, model, state, control, Some(contact), h, exec)
    }

    fn follow(&mut self, model: &TissueModel) {
        let solver = self.solver.following(model);
        *self = Self::with_solver(model, self.scheme, self.newton, self.distortion, solver);
    }

    fn set_effort(&mut self, effort: Effort) {
        self.solver.effort = effort;
    }

    fn limit_work(&mut self, most: f64) {
        let stages = match self.scheme {
            ImplicitScheme::BackwardEuler | ImplicitScheme::Midpoint => 1.0,
            ImplicitScheme::Sdirk2 | ImplicitScheme::GuardedMidpoint => 2.0,
        };
        self.solver.most_work = most / stages;
    }

    fn least_work(&self, _: &TissueModel, contacts: usize) -> f64 {
        self.solver.iteration_work(contacts)
    }

    fn boxed_clone(&self) -> Box<dyn Solver> {
        Box::new(self.clone())
    }
}

#[cfg(test)]
mod tests;
