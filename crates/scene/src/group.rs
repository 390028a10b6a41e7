//! Bodies that can touch one another are advanced together: one model, one solver, one state while a tick runs.

use crate::body::Body;
use crate::divergence::Divergence;
use crate::error::SceneError;
use crate::group_contact::{ContactState, GroupContact};
use crate::irrigation::Irrigation;
use crate::jet::Jet;
use crate::member::Member;
use crate::pairs::{Pair, PairPartner};
use crate::stretch_guard::StretchGuard;
use crate::surface_edits::SurfaceDiff;
use microsim_contact::{BroadPhaseMethod, CapsuleMotion, ObstaclePart};
use microsim_tissue::{
    Control, Effort, Method, NodeTarget, Pressure, Solver, State, StepFailure, TissueModel,
};
use nalgebra::Vector3;

/// Bodies that are advanced together. One that touches no other is alone in its group.
#[derive(Clone, Debug)]
pub(crate) struct Group {
    /// Its bodies, ascending.
    pub members: Vec<Member>,
    /// The model of all of them; `None` for a body that is alone and has its own.
    union: Option<TissueModel>,
    pub solver: Box<dyn Solver>,
    /// What is touched; `None` where nothing is.
    pub contact: Option<GroupContact>,
    /// How what may touch is found.
    broad_phase: BroadPhaseMethod,
    /// What looks after the step; `None` where stretch does not make it too long.
    guard: Option<StretchGuard>,
    /// What jets press on.
    irrigation: Irrigation,
    /// Iterations of the solver since the scene was built; no part of what evolves.
    pub iterations: u64,
}

impl Group {
    /// The groups of a scene, in the order of their first bodies.
    pub fn all(
        bodies: &[Body],
        pairs: &[Pair],
        obstacles: &[ObstaclePart],
        broad_phase: BroadPhaseMethod,
        method: &Method,
    ) -> Result<Vec<Self>, SceneError> {
        // Each body points to the first one of its group; a few passes reach the end of every chain.
        let mut first: Vec<usize> = (0..bodies.len()).collect();
        loop {
            let mut changed = false;
            for pair in pairs {
                if let PairPartner::Body(other) = pair.with {
                    let least = first[pair.body].min(first[other]);
                    changed |= first[pair.body] != least || first[other] != least;
                    first[pair.body] = least;
                    first[other] = least;
                }
            }
            if !changed {
                break;
            }
        }
        let leaders = (0..bodies.len()).filter(|body| first[*body] == *body);
        let groups = leaders.map(|leader| {
            let members: Vec<usize> = (0..bodies.len())
                .filter(|body| first[*body] == leader)
                .collect();
            Self::new(&members, bodies, pairs, obstacles, broad_phase, method)
        });
        groups.collect()
    }

    fn new(
        indices: &[usize],
        bodies: &[Body],
        pairs: &[Pair],
        obstacles: &[ObstaclePart],
        broad_phase: BroadPhaseMethod,
        method: &Method,
    ) -> Result<Self, SceneError> {
        let mut members = Vec::with_capacity(indices.len());
        let mut first_node = 0;
        for &body in indices {
            members.push(Member { body, first_node });
            first_node += bodies[body].model.node_count();
        }
        let models: Vec<&TissueModel> = indices.iter().map(|&body| &bodies[body].model).collect();
        let union = (models.len() > 1).then(|| TissueModel::union(&models));
        let model = union.as_ref().unwrap_or(models[0]);
        let solver = method.solver(model).map_err(|source| SceneError::Method {
            body: bodies[indices[0]].name.clone(),
            source,
        })?;
        Ok(Self {
            solver,
            contact: GroupContact::new(
                &members,
                bodies,
                pairs,
                obstacles,
                broad_phase,
                method,
                model,
            ),
            broad_phase,
            guard: StretchGuard::new(method, model),
            members,
            union,
            irrigation: Irrigation::default(),
            iterations: 0,
        })
    }

    /// First nodes of bodies whose meshes have changed, before all else is updated.
    pub fn renumber(&mut self, bodies: &[Body]) {
        let mut first_node = 0;
        for member in &mut self.members {
            member.first_node = first_node;
            first_node += bodies[member.body].mesh.positions.len();
        }
    }

    /// The model and the solver of bodies whose meshes have changed.
    fn update_models(&mut self, bodies: &[Body]) {
        let models = self.members.iter().map(|member| &bodies[member.body].model);
        let models: Vec<&TissueModel> = models.collect();
        self.union = (models.len() > 1).then(|| TissueModel::union(&models));
        self.solver.follow(self.union.as_ref().unwrap_or(models[0]));
    }

    /// Updates the group after edits of bodies whose surfaces are updated already.
    pub fn update_after_edit(&mut self, bodies: &[Body], surface_diffs: &[Option<SurfaceDiff>]) {
        self.update_models(bodies);
        if let Some(contact) = &mut self.contact {
            contact.update_after_edit(&self.members, bodies, surface_diffs);
        }
    }

    /// Rebuilds what depends on meshes that have been replaced.
    pub fn rebuild(
        &mut self,
        bodies: &[Body],
        pairs: &[Pair],
        obstacles: &[ObstaclePart],
        method: &Method,
    ) {
        self.renumber(bodies);
        self.update_models(bodies);
        let model = self.model(bodies);
        self.contact = GroupContact::new(
            &self.members,
            bodies,
            pairs,
            obstacles,
            self.broad_phase,
            method,
            model,
        );
    }

    /// Puts elements that slide where a state of the group has put them.
    pub fn relocate(&mut self, bodies: &mut [Body], state: &State) {
        let model = match &mut self.union {
            Some(union) => union,
            None => &mut bodies[self.members[0].body].model,
        };
        if model.relocate(&state.internal) {
            self.solver.follow(model);
        }
    }

    /// The same in the model of each of its bodies.
    pub fn relocate_members(&mut self, bodies: &mut [Body], states: &[State]) {
        for member in &self.members {
            let model = &mut bodies[member.body].model;
            if model.relocate(&states[member.body].internal) && self.union.is_none() {
                self.solver.follow(model);
            }
        }
    }

    /// The model of its bodies.
    pub fn model<'a>(&'a self, bodies: &'a [Body]) -> &'a TissueModel {
        match &self.union {
            Some(union) => union,
            None => &bodies[self.members[0].body].model,
        }
    }

    /// The work that a step may take from now on \[s\].
    pub fn limit_work(&mut self, most: f64) {
        self.solver.limit_work(most);
    }

    /// What a step in which so many contacts act takes at least, about \[s\].
    pub fn least_work(&self, bodies: &[Body], contacts: usize) -> f64 {
        self.solver.least_work(self.model(bodies), contacts)
    }

    /// How much effort steps take ([`Solver::set_effort`](microsim_tissue::Solver::set_effort)).
    pub fn set_effort(&mut self, effort: Effort) {
        self.solver.set_effort(effort);
    }

    /// The longest step at rest, that of its stiffest body \[s\].
    pub fn step_at_rest(&self, bodies: &[Body]) -> f64 {
        let steps = self.members.iter().map(|of| bodies[of.body].stable_step);
        steps.fold(f64::INFINITY, f64::min)
    }

    /// The longest step as `state` is stretched before the step of `h` from `time`, if it is time to look; `allowed` are the longest
    /// steps of all bodies of the scene \[s\].
    pub fn longest_step(
        &self,
        bodies: &[Body],
        state: &State,
        time: f64,
        h: f64,
        allowed: &[f64],
    ) -> Option<f64> {
        let guard = self.guard.as_ref()?;
        let allowed = self.members.iter().map(|member| allowed[member.body]);
        let is_due = guard.is_due(time, h, allowed.fold(f64::INFINITY, f64::min));
        is_due.then(|| guard.longest_step(self.model(bodies), state, h))
    }

    /// Its model, its solver, and what is touched.
    pub fn parts<'a>(
        &'a mut self,
        bodies: &'a [Body],
    ) -> (
        &'a TissueModel,
        &'a mut dyn Solver,
        Option<&'a mut GroupContact>,
    ) {
        let model = match &self.union {
            Some(union) => union,
            None => &bodies[self.members[0].body].model,
        };
        (model, self.solver.as_mut(), self.contact.as_mut())
    }

    /// The body to which a failure of the solver belongs, and the failure in its own numbers of nodes.
    pub fn failed(&self, failure: StepFailure) -> (usize, Divergence) {
        let (member, failure) = match failure {
            StepFailure::Singular { node } => {
                let member = self.members[self.member_of(node)];
                let node = node - member.first_node as u32;
                (member, StepFailure::Singular { node })
            }
            other => (self.members[0], other),
        };
        (member.body, Divergence::Step(failure))
    }

    /// The body that has a number that is not finite.
    pub fn not_finite(&self, state: &State) -> usize {
        let wrong = |p: &Vector3<f64>| !p.iter().all(|c| c.is_finite());
        let mut both = state.positions.iter().zip(&state.velocities);
        let node = both.position(|(p, v)| wrong(p) || wrong(v));
        let node = node.unwrap_or_default() as u32;
        self.members[self.member_of(node)].body
    }

    /// Whether this body is one of it.
    pub fn holds(&self, body: usize) -> bool {
        self.members.iter().any(|member| member.body == body)
    }

    /// Takes the states of its bodies out of those of the scene, joined body after body.
    pub fn join(&self, states: &mut [State]) -> State {
        let mut members = self.members.iter();
        let mut joined = match members.next() {
            Some(first) => std::mem::replace(&mut states[first.body], EMPTY),
            None => EMPTY,
        };
        for member in members {
            let state = std::mem::replace(&mut states[member.body], EMPTY);
            joined.positions.extend(state.positions);
            joined.velocities.extend(state.velocities);
            joined.accelerations.extend(state.accelerations);
            joined.internal.extend(state.internal);
        }
        joined
    }

    /// Puts them back.
    pub fn split(&self, mut joined: State, bodies: &[Body], states: &mut [State]) {
        // From the last to the first: what is cut off is the last one's, and the first retains its memory.
        for member in self.members.iter().skip(1).rev() {
            let internal = joined.internal.len() - bodies[member.body].start.internal.len();
            let accelerations = member.first_node.min(joined.accelerations.len());
            states[member.body] = State {
                positions: joined.positions.split_off(member.first_node),
                velocities: joined.velocities.split_off(member.first_node),
                step: joined.step,
                accelerations: joined.accelerations.split_off(accelerations),
                internal: joined.internal.split_off(internal),
            };
        }
        if let Some(first) = self.members.first() {
            states[first.body] = joined;
        }
    }

    /// The member that has node `node` of the group.
    pub fn member_of(&self, node: u32) -> usize {
        let node = node as usize;
        self.members.partition_point(|m| m.first_node <= node) - 1
    }

    /// What drives its bodies in the step that ends at `time` \[s\].
    pub fn control(&self, bodies: &[Body], gravity: &Vector3<f64>, time: f64) -> Control {
        let alone = self.union.is_none();
        let mut all = Control {
            gravity: *gravity,
            ..Control::default()
        };
        let moved = |member: &Member| bodies[member.body].drive.moves_clamps();
        let clamps_move = self.members.iter().any(moved);
        for member in &self.members {
            let body = &bodies[member.body];
            let control = body.drive.control(gravity, time);
            if alone {
                return control;
            }
            let shift = member.first_node as u32;
            let forces = control.forces.into_iter();
            all.forces.extend(forces.map(|(node, f)| (node + shift, f)));
            let pressures = control.pressures.into_iter();
            all.pressures.extend(pressures.map(|load| {
                Pressure {
                    triangles: load
                        .triangles
                        .iter()
                        .map(|triangle| triangle.map(|node| node + shift))
                        .collect(),
                    pressure: load.pressure,
                }
            }));
            if control.clamped_positions.is_empty() && clamps_move {
                let rest = body.model.rest_positions();
                let clamped = body.model.clamped().iter();
                all.clamped_positions
                    .extend(clamped.map(|&node| rest[node as usize]));
            } else {
                all.clamped_positions.extend(control.clamped_positions);
            }
        }
        all
    }

    /// Adds what jets press on to what drives a step that begins at these positions \[m\].
    pub fn irrigate(
        &mut self,
        bodies: &[Body],
        jets: &[Jet],
        positions: &[Vector3<f64>],
        control: &mut Control,
    ) {
        for member in &self.members {
            let body = &bodies[member.body];
            let of_body = &positions[member.first_node..][..body.model.node_count()];
            let first = member.first_node as u32;
            self.irrigation.add(jets, body, of_body, first);
        }
        control.pressed = std::mem::take(&mut self.irrigation.pressed);
    }

    /// Takes the memory back that a step had.
    pub fn end_irrigation(&mut self, control: Control) {
        self.irrigation.pressed = control.pressed;
        self.irrigation.pressed.clear();
    }

    /// Adds the nodes that jaws bring along in a step.
    pub fn hold(
        &self,
        tools: &[Option<Vec<CapsuleMotion>>],
        state: &ContactState,
        positions: &[Vector3<f64>],
        control: &mut Control,
    ) {
        if let Some(contact) = &self.contact {
            control.carried = contact.carried(&self.members, tools, state, positions);
        }
    }

    /// The targets of gripped nodes at the end of the step that ends at `time` \[s\].
    pub fn targets(&self, bodies: &[Body], time: f64) -> Vec<NodeTarget> {
        let mut all = Vec::new();
        for member in &self.members {
            let targets = bodies[member.body].drive.targets(time);
            all.extend(targets.into_iter().map(|target| NodeTarget {
                node: target.node + member.first_node as u32,
                ..target
            }));
        }
        all
    }
}

const EMPTY: State = State {
    positions: Vec::new(),
    velocities: Vec::new(),
    step: 0.0,
    accelerations: Vec::new(),
    internal: Vec::new(),
};
