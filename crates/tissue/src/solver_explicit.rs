//! The explicit integrators of 3.5 beside leapfrog (Störmer–Verlet): explicit Euler, symplectic Euler, velocity Verlet, and velocity
//! Verlet as the dissertation loops it. They differ in one rule per node; forces, clamps and targets are shared.
//!
//! With a = F/m at the positions and velocities that are known, c the drag per mass, E = e^(−ch/2):
//!
//! ```text
//! explicit Euler     p' = p + h v                          v' = v + h (a − c v)
//! symplectic Euler   v' = v + h (a − c v)                  p' = p + h v'
//! velocity Verlet    u = E v + ½h a     p' = p + h u       v' = E (u + ½h a')
//! lagged             v = v₋ + ½h₋ (a₋ + a)                 p' = p + h v + ½h² a
//! ```
//!
//! Velocity Verlet (3.19, 3.20 as corrected in NUMERICS 1.2) carries its accelerations in the state; a' is taken at p' and the
//! velocity E (u + ½h a) expected there, so that viscous forces keep second order. A body with internal variables computes its
//! accelerations at the start of each step again, since these may have flowed in between. The lagged loop stores velocity and
//! acceleration of the positions before the last step (v₋, a₋, h₋ the step from them), as 3.19 and 3.20 are printed;
//! its a holds viscous forces and drag −c v₋ of that old velocity.
//!
//! The force that lands a node on its target p*, for p̃ where the step would bring it without (NUMERICS 2), is
//! (m/h²)(p* − p̃) with symplectic Euler, (2m/h²)(p* − p̃) with velocity Verlet and (m/(h·½(h₋ + h)))(p* − p̃) in the lagged
//! loop (4.10): all others are known before it.
//!
//! # Limitations
//! All: the step is bounded ([`stability::limit`](crate::stability::limit)). Internal forces conserve momentum to rounding.
//! Explicit Euler multiplies the energy of a mode by 1 + h²ω² in each step: without drag it is never stable; first order;
//! nodes cannot be prescribed, [`NodeTarget`]s are ignored and contact is refused. Symplectic Euler does not conserve energy but ½v² + ½ω²x² − ½hω²xv of a
//! mode: energy oscillates and does not drift; first order; its drag lowers the limit. Velocity Verlet: energy oscillates and
//! does not drift; second order; prescribed nodes and those in contact have the velocity of what holds them, and the accelerations that the state carries
//! are then those with which the next step goes on in the joint form (NUMERICS 2.4). Lagged: the limit falls from 2/ω to √2/ω with any drag, which also makes it first order; the velocities of
//! the state are one step old. Loads and clamps are taken as given for the end of the step: a load that changes is followed to
//! first order only, but for velocity Verlet without internal variables, which has those of both ends. A step that changes from call to call is not symplectic in any of them.

use crate::components::{follow, projection};
use crate::executor::Executor;
use crate::forces::Forces;
use crate::model::TissueModel;
use crate::solver::{Solver, StepFailure, StepReport};
use crate::state::{Control, NodeTarget, State};
use microsim_contact_solver::{Contact, ContactStep, Projection, Response};
use nalgebra::Vector3;

/// Which explicit integrator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scheme {
    /// Explicit Euler.
    ExplicitEuler,
    /// Symplectic Euler.
    SymplecticEuler,
    /// Velocity Verlet, standard form.
    VelocityVerlet,
    /// Velocity Verlet, lagged loop.
    VelocityVerletLagged,
}

/// The explicit solver, with its working memory for one model; it has no state of its own between steps.
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
/// use microsim_tissue::{Control, Method, Scheme, Serial, Solver, SolverExplicit, State, stability};
///
/// // A block that is clamped at one end, under its weight, in steps below the limit of stability.
/// let mut state = State::at_rest(&model);
/// let control = Control { gravity: [0.0, 0.0, -9.81].into(), ..Control::default() };
/// let highest = stability::power_iteration(&model, stability::Part::Stiffness, 50);
/// let h = 0.5 * stability::limit(&Method::SymplecticEuler, highest, 0.0);
/// let mut solver = SolverExplicit::new(&model, Scheme::SymplecticEuler);
/// for _ in 0..10 {
///     solver.step(&model, &mut state, &control, &[], h, &Serial)?;
/// }
/// assert!(state.energies(&model).elastic() > 0.0);
/// # Ok::<(), microsim_tissue::StepFailure>(())
/// ```
#[derive(Clone, Debug)]
pub struct SolverExplicit {
    scheme: Scheme,
    forces: Forces,
    /// State after the step \[m, m/s, m/s²\]; with velocity Verlet the accelerations are those before it.
    positions: Vec<Vector3<f64>>,
    velocities: Vec<Vector3<f64>>,
    accelerations: Vec<Vector3<f64>>,
    /// E of each node.
    factors: Vec<f64>,
    projection: Projection,
    /// Marks of the nodes with a target.
    prescribed: Vec<bool>,
}

impl SolverExplicit {
    /// Working memory for `model`.
    pub fn new(model: &TissueModel, scheme: Scheme) -> Self {
        let zeros = vec![Vector3::zeros(); model.node_count()];
        Self {
            scheme,
            forces: Forces::new(model),
            positions: zeros.clone(),
            velocities: zeros.clone(),
            accelerations: zeros,
            factors: vec![1.0; model.node_count()],
            projection: projection(model),
            prescribed: vec![false; model.node_count()],
        }
    }

    /// F/m at the state into `accelerations`, with the drag −c v where it is wanted; zero for clamped nodes.
    fn accelerate(
        &mut self,
        model: &TissueModel,
        state: &State,
        control: &Control,
        with_drag: bool,
        exec: &dyn Executor,
    ) {
        let forces = self.forces.compute(model, state, control, exec);
        for (nodes, drag) in model.drags() {
            let drag = if with_drag { *drag } else { 0.0 };
            for node in nodes.clone() {
                let w = model.inverse_masses()[node];
                self.accelerations[node] = match w > 0.0 {
                    true => forces[node] * w - state.velocities[node] * drag,
                    false => Vector3::zeros(),
                };
            }
        }
    }

    /// Sets position, velocity and acceleration after the step to `rule(p, v, a)`, a the acceleration so far.
    fn apply(
        &mut self,
        state: &State,
        rule: impl Fn(&Vector3<f64>, &Vector3<f64>, &Vector3<f64>) -> [Vector3<f64>; 2],
    ) {
        let before = state.positions.iter().zip(&state.velocities);
        let after = self.positions.iter_mut().zip(&mut self.velocities);
        for (((p, v), (p_new, v_new)), a) in before.zip(after).zip(&self.accelerations) {
            [*p_new, *v_new] = rule(p, v, a);
        }
    }

    /// Puts clamped nodes where the control wants them.
    fn clamp(&mut self, model: &TissueModel, state: &State, control: &Control, h: f64) {
        for (place, &node) in model.clamped().iter().enumerate() {
            let node = node as usize;
            let from = state.positions[node];
            let to = control
                .clamped_positions
                .get(place)
                .copied()
                .unwrap_or(from);
            self.positions[node] = to;
            self.velocities[node] = (to - from) / h;
        }
    }

    /// Puts nodes on their targets. Their displacement times `to_velocity` goes on as velocity and times `to_acceleration` as
    /// acceleration; what only undoes an overlap does not.
    fn apply_targets(
        &mut self,
        model: &TissueModel,
        targets: &[NodeTarget],
        to_velocity: f64,
        to_acceleration: f64,
    ) {
        self.prescribed.fill(false);
        for target in targets {
            let node = target.node as usize;
            if model.is_clamped(node) {
                continue;
            }
            self.prescribed[node] = true;
            let displacement = target.target - self.positions[node] - target.overlap;
            self.positions[node] = target.target;
            self.velocities[node] += displacement * to_velocity;
            self.accelerations[node] += displacement * to_acceleration;
        }
    }

    /// Brings carried nodes to their places, from where contact may move them; their displacement goes on as in [`apply_targets`](Self::apply_targets).
    fn carry(&mut self, model: &TissueModel, control: &Control, to: [f64; 2]) {
        for (node, target) in &control.carried {
            let node = *node as usize;
            if !model.is_clamped(node) {
                let displacement = target - self.positions[node];
                self.positions[node] = *target;
                self.velocities[node] += displacement * to[0];
                self.accelerations[node] += displacement * to[1];
            }
        }
    }

    /// Enforces non-penetration. A force moves a node by h (E² `before` + `after`) times its acceleration, with `times` = [h, before, after]
    /// \[s\]; that displacement goes on as in [`apply_targets`](Self::apply_targets).
    fn enforce_contact(
        &mut self,
        model: &TissueModel,
        state: &State,
        contact: &mut ContactStep<'_>,
        [h, before, after]: [f64; 3],
        [to_velocity, to_acceleration]: [f64; 2],
    ) -> Result<(), StepFailure> {
        if !is_finite(&self.positions) {
            return Err(StepFailure::NotFinite);
        }
        let (prescribed, factors, w) = (&self.prescribed, &self.factors, model.inverse_masses());
        let mobility = |node: usize| match prescribed[node] {
            true => 0.0,
            false => h * (factors[node] * factors[node] * before + after) * w[node],
        };
        self.projection
            .project(contact, &state.positions, mobility, h, &mut self.positions);
        for (node, change) in self.projection.changes().iter().enumerate() {
            self.velocities[node] += change * to_velocity;
            self.accelerations[node] += change * to_acceleration;
        }
        match is_finite(&self.positions) {
            true => Ok(()),
            false => Err(StepFailure::NotFinite),
        }
    }

    /// Adds penalty forces of explicit Euler, which change velocities alone.
    fn penalise(
        &mut self,
        model: &TissueModel,
        state: &State,
        contact: &mut ContactStep<'_>,
        h: f64,
    ) -> Result<(), StepFailure> {
        self.enforce_contact(model, state, contact, [h, 0.0, h], [1.0 / h, 0.0])?;
        for (position, change) in self.positions.iter_mut().zip(self.projection.changes()) {
            *position -= change;
        }
        let is_penalty = |contact: &Contact| matches!(contact.response, Response::Penalty { .. });
        match contact.contacts.iter().all(is_penalty) {
            true => Ok(()),
            false => Err(StepFailure::NoContact {
                reason: "a force of explicit Euler moves a node one step later only; use `response = \"penalty\"`, symplectic-euler, or any other method",
            }),
        }
    }

    #[expect(clippy::too_many_arguments, reason = "the parts of a step stay apart")]
    fn velocity_verlet(
        &mut self,
        model: &TissueModel,
        state: &mut State,
        control: &Control,
        targets: &[NodeTarget],
        contact: Option<&mut ContactStep<'_>>,
        h: f64,
        exec: &dyn Executor,
    ) -> Result<(), StepFailure> {
        // Internal variables may have flowed, or ties torn, since the last step: the accelerations carried from there would still
        // pull with the old ones.
        let carried = state.accelerations.len() == state.positions.len();
        if carried && state.internal.is_empty() {
            self.accelerations.copy_from_slice(&state.accelerations);
        } else {
            self.accelerate(model, state, control, false, exec);
            if carried {
                for (a, carried) in self.accelerations.iter_mut().zip(&state.accelerations) {
                    *a += carried;
                }
            }
        }
        for (nodes, drag) in model.drags() {
            let factor = libm::exp(-0.5 * drag * h);
            for node in nodes.clone() {
                let middle = state.velocities[node] * factor + self.accelerations[node] * (0.5 * h);
                self.positions[node] = state.positions[node] + middle * h;
                self.velocities[node] = middle;
                self.factors[node] = factor;
            }
        }
        self.clamp(model, state, control, h);
        self.apply_targets(model, targets, 1.0 / h, 0.0);
        self.carry(model, control, [1.0 / h, 0.0]);
        if !is_finite(&self.positions) {
            return Err(StepFailure::NotFinite);
        }
        let mut touched: &[Contact] = &[];
        if let Some(contact) = contact {
            self.enforce_contact(model, state, contact, [h, 0.5 * h, 0.5 * h], [1.0 / h, 0.0])?;
            touched = &contact.contacts;
        }

        // From here on the solver holds the state before, to go back to.
        std::mem::swap(&mut state.positions, &mut self.positions);
        std::mem::swap(&mut state.velocities, &mut self.velocities);
        let w = model.inverse_masses();
        let free = |node: &usize| w[*node] > 0.0;
        for node in (0..w.len()).filter(free) {
            let middle = state.velocities[node];
            state.velocities[node] =
                (middle + self.accelerations[node] * (0.5 * h)) * self.factors[node];
        }
        let forces = self.forces.compute(model, state, control, exec);
        for node in (0..w.len()).filter(free) {
            let acceleration = forces[node] * w[node];
            let change = acceleration - self.accelerations[node];
            state.velocities[node] += change * (0.5 * h * self.factors[node]);
            self.accelerations[node] = acceleration;
        }
        if !is_finite(&state.velocities) {
            std::mem::swap(&mut state.positions, &mut self.positions);
            std::mem::swap(&mut state.velocities, &mut self.velocities);
            return Err(StepFailure::NotFinite);
        }
        self.match_velocities(model, state, targets, touched, h);
        Ok(())
    }

    /// Gives prescribed nodes and those in contact the velocity of what holds them, and the state the accelerations with which the next
    /// step goes on as if it had not been given.
    fn match_velocities(
        &mut self,
        model: &TissueModel,
        state: &mut State,
        targets: &[NodeTarget],
        touched: &[Contact],
        h: f64,
    ) {
        if !state.internal.is_empty() {
            self.accelerations.fill(Vector3::zeros());
        }
        for target in targets {
            let node = target.node as usize;
            if !model.is_clamped(node) {
                let displacement = target.target - target.overlap - self.positions[node];
                let change = displacement / h - state.velocities[node];
                state.velocities[node] += change;
                self.accelerations[node] -= change * (2.0 * self.factors[node] / h);
            }
        }
        if touched.iter().any(|contact| contact.normal_force > 0.0) {
            let (prescribed, w) = (&self.prescribed, model.inverse_masses());
            let inverse_mass = |node: usize| if prescribed[node] { 0.0 } else { w[node] };
            self.projection
                .match_velocities(touched, h, inverse_mass, &mut state.velocities);
            for ((a, change), factor) in self
                .accelerations
                .iter_mut()
                .zip(self.projection.changes())
                .zip(&self.factors)
            {
                *a -= change * (2.0 * factor / h);
            }
        }
        state.accelerations.clone_from(&self.accelerations);
    }

    #[expect(clippy::too_many_arguments, reason = "the parts of a step stay apart")]
    fn lagged(
        &mut self,
        model: &TissueModel,
        state: &mut State,
        control: &Control,
        targets: &[NodeTarget],
        contact: Option<&mut ContactStep<'_>>,
        h: f64,
        exec: &dyn Executor,
    ) -> Result<(), StepFailure> {
        self.accelerate(model, state, control, true, exec);
        // Before the first step nothing is lagged: h₋ = 0.
        let lag = 0.5 * state.step;
        self.apply(state, |p, v, a| {
            let velocity = v + a * lag;
            [p + (velocity + a * (0.5 * h)) * h, velocity]
        });
        for (node, old) in state.accelerations.iter().enumerate() {
            let kick = old * lag;
            self.velocities[node] += kick;
            self.positions[node] += kick * h;
        }
        self.clamp(model, state, control, h);
        let per_displacement = 1.0 / (h * (lag + 0.5 * h));
        self.apply_targets(model, targets, lag * per_displacement, per_displacement);
        self.carry(model, control, [lag * per_displacement, per_displacement]);
        if let Some(contact) = contact {
            self.factors.fill(1.0);
            self.enforce_contact(
                model,
                state,
                contact,
                [h, lag, 0.5 * h],
                [lag * per_displacement, per_displacement],
            )?;
        }
        self.commit(state)?;
        state.accelerations.clone_from(&self.accelerations);
        Ok(())
    }

    #[expect(clippy::too_many_arguments, reason = "the parts of a step stay apart")]
    fn euler(
        &mut self,
        model: &TissueModel,
        state: &mut State,
        control: &Control,
        targets: &[NodeTarget],
        contact: Option<&mut ContactStep<'_>>,
        h: f64,
        exec: &dyn Executor,
    ) -> Result<(), StepFailure> {
        self.accelerate(model, state, control, true, exec);
        if self.scheme == Scheme::ExplicitEuler {
            self.apply(state, |p, v, a| [p + v * h, v + a * h]);
            self.clamp(model, state, control, h);
            if let Some(contact) = contact {
                self.penalise(model, state, contact, h)?;
            }
        } else {
            self.apply(state, |p, v, a| {
                let velocity = v + a * h;
                [p + velocity * h, velocity]
            });
            self.clamp(model, state, control, h);
            self.apply_targets(model, targets, 1.0 / h, 0.0);
            self.carry(model, control, [1.0 / h, 0.0]);
            if let Some(contact) = contact {
                self.enforce_contact(model, state, contact, [h, 0.0, h], [1.0 / h, 0.0])?;
            }
        }
        self.commit(state)?;
        state.accelerations.clear();
        Ok(())
    }

    /// Makes what was computed the state.
    fn commit(&mut self, state: &mut State) -> Result<(), StepFailure> {
        if !is_finite(&self.positions) || !is_finite(&self.velocities) {
            return Err(StepFailure::NotFinite);
        }
        std::mem::swap(&mut state.positions, &mut self.positions);
        std::mem::swap(&mut state.velocities, &mut self.velocities);
        Ok(())
    }
}

impl Solver for SolverExplicit {
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
        match self.scheme {
            Scheme::ExplicitEuler | Scheme::SymplecticEuler => {
                self.euler(model, state, control, targets, contact, h, exec)?;
            }
            Scheme::VelocityVerlet => {
                self.velocity_verlet(model, state, control, targets, contact, h, exec)?;
            }
            Scheme::VelocityVerletLagged => {
                self.lagged(model, state, control, targets, contact, h, exec)?;
            }
        }
        state.step = h;
        Ok(StepReport::without_residual(1))
    }

    fn follow(&mut self, model: &TissueModel) {
        let nodes = model.node_count();
        self.forces.follow(model);
        self.positions.resize(nodes, Vector3::zeros());
        self.velocities.resize(nodes, Vector3::zeros());
        self.accelerations.resize(nodes, Vector3::zeros());
        self.factors.resize(nodes, 1.0);
        follow(&mut self.projection, model);
        self.prescribed.resize(nodes, false);
    }

    fn boxed_clone(&self) -> Box<dyn Solver> {
        Box::new(self.clone())
    }
}

/// Whether every number is finite: a sum is finite only if all its terms are.
fn is_finite(values: &[Vector3<f64>]) -> bool {
    let sum: Vector3<f64> = values.iter().sum();
    sum.iter().all(|c| c.is_finite())
}

#[cfg(test)]
mod tests;
