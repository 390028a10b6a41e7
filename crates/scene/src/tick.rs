//! One tick: sub-steps, contact, solver, containment.

use crate::body::Body;
use crate::budget::{Budget, IterationWork};
use crate::containment::{self, Failure, Watch};
use crate::cut_report::CutReport;
use crate::cutting::TornBodies;
use crate::divergence::{Diverged, Divergence};
use crate::division::Division;
use crate::group::Group;
use crate::group_contact::ContactState;
use crate::jet::Jet;
use crate::lonor::EdgeLoads;
use crate::placement::Course;
use crate::report::{ContactReport, MANY_SUBSTEPS, Recovery, SolverReport, TickReport};
use crate::scene::Scene;
use crate::stretch_guard::StretchGuard;
use crate::tally::{Tally, Work, sum_up};
use crate::tool::ToolMotion;
use microsim_contact::CapsuleMotion;
use microsim_tissue::{ContactStep, Effort, Executor, State, StepFailure, StepReport, flow};
use nalgebra::Vector3;
use std::collections::BTreeSet;

/// How a tick is tried.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Try {
    /// Tools follow their hands, in steps that are divided by this.
    Follow(u32),
    /// Tools stay where they were.
    Stand,
    /// Tools touch nothing.
    LetGo,
}

/// The tries when a body diverged. A tick whose forces mean nothing is repeated as the second one.
const TRIES: [Try; 6] = [
    Try::Follow(1),
    Try::Follow(2),
    Try::Follow(4),
    Try::Follow(8),
    Try::Stand,
    Try::LetGo,
];

/// The steps of a repeated tick may take so many times the iterations of the method.
const REPEATED_EFFORT: u32 = 4;

/// Work of a point of contact in a step \[s\]: finding it, and in explicit steps its forces.
const POINT: f64 = 2e-6;

/// How often a tick whose forces mean nothing is computed again without the shreds that fail in it.
const MAX_ROUNDS: u32 = 4;

/// What came of a try.
struct Attempted {
    contacts: Vec<ContactReport>,
    loads: EdgeLoads,
    solver: SolverReport,
    /// Of each body with any, ids of nodes.
    overlaps_undone: Vec<(usize, Vec<u32>)>,
}

impl Scene {
    /// Advances by one tick of `tick_s` \[s\] in `steps` solver's steps, divided further where a tool is fast.
    ///
    /// A tool without a motion touches nothing. Each step takes the tools' poses from the interpolated motion. When a body
    /// diverges, or, without containment, an implicit step does not converge, the tick is repeated from its start with shorter steps, and the report lists it; when that does not help it is computed with the tools where they were, and else with tools that touch nothing, and when that does not either the
    /// scene stays at the start of the tick, without shreds that ruptured meanwhile, and the error describes what happened; the next tick may go on from there. A tick whose forces
    /// mean nothing ([`SolverBounds`](crate::SolverBounds)) is repeated without the shreds that failed in it, and else once with steps of half the length, four times the iterations and, where the interior-point method has found no forces, the augmented Lagrangian method of contact, and not [`valid`](TickReport::valid) if
    /// that does not help; then those that follow are not repeated until one is valid, so that a scene beyond its solver costs no multiple.
    ///
    /// ```
    /// # use microsim_mesh::{Block, CellSplit};
    /// # use microsim_scene::{Behaviour, BodySpec, Material, Method, Scene, SceneSpec, Serial};
    /// # use microsim_tissue::SpringConstants;
    /// # let block = Block { center: [0.0; 3], size: [2e-3; 3], cells: [2; 3], split: CellSplit::Kuhn };
    /// # let behaviour = Behaviour::Springs(SpringConstants::scaled(25e3, 5e4));
    /// # let material = Material { density: 1060.0, relaxation_time: 0.0, behaviour };
    /// # let cube = BodySpec::new("cube", block.mesh()?, material);
    /// use microsim_scene::{CapsuleSpec, ContactSpec, PartnerSpec, Pose, ToolMotion, ToolSpec};
    /// use nalgebra::Vector3;
    ///
    /// // A sphere of 0.5 mm goes 0.2 mm down onto the cube, which falls meanwhile.
    /// let sphere = CapsuleSpec::new([0.0; 3], [0.0; 3], 0.5e-3);
    /// let probe = ToolSpec { name: "probe".into(), capsules: vec![sphere], sharpness: 0.0, jaw_stiffness: f64::INFINITY, irrigation: None, motion: vec![] };
    /// let with = PartnerSpec::Tool("probe".into());
    /// let contact = ContactSpec::new("cube", with);
    /// let mut scene = Scene::new(&SceneSpec {
    ///     tools: vec![probe],
    ///     contacts: vec![contact],
    ///     ..SceneSpec::new(vec![cube], Method::StoermerVerlet)
    /// })?;
    /// let at = |z: f64| Pose { position: Vector3::new(0.1e-3, 0.0, z), ..Pose::identity() };
    /// let motion = ToolMotion {
    ///     tool: 0,
    ///     from: at(1.55e-3),
    ///     to: at(1.35e-3),
    ///     opening_from: 0.0,
    ///     opening_to: 0.0,
    ///     active: true,
    /// };
    /// let steps = scene.required_steps(5e-3);
    /// let report = scene.tick(&[motion], 5e-3, steps, &Serial)?;
    /// let [contact] = &report.contacts[..] else { panic!("the two touch") };
    /// assert!(contact.force_on_tissue[2] < 0.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Panics
    /// When `tick_s` is not a positive time or `steps` is 0: [`check_step`](Scene::check_step) refuses both.
    pub fn tick(
        &mut self,
        motions: &[ToolMotion],
        tick_s: f64,
        steps: u32,
        exec: &dyn Executor,
    ) -> Result<TickReport, Diverged> {
        assert!(tick_s > 0.0 && tick_s.is_finite(), "a tick of {tick_s} s");
        assert!(steps > 0, "a tick without steps");
        // Plastic flow or stretch may have made a body stiffer than it was when the number of steps was chosen.
        let required = self.required_steps(tick_s);
        let mut stiffened = self.has_stiffened() && steps < required;
        let mut steps = if stiffened { required } else { steps };
        let (mut motions, invalid_motions) = self.valid_motions(motions);
        self.state.placements.resume(&mut motions);
        let (needed, jumped) = self.substeps(&mut motions, tick_s, steps);
        // Instruments that are slowed down go only a part of the way.
        let slowed = self.state.placements.pace;
        let needed = (slowed * needed).max(1.0);
        let parts: Vec<ToolMotion> = motions.iter().map(|of| of.first_part(slowed)).collect();
        let groups = self.groups.iter().zip(&self.state.contacts);
        let least = groups.map(|(group, of)| group.least_work(&self.bodies, of.forces.len()));
        let least: f64 = least.sum();
        let mut budget = Budget::new(self.budget.map(|part| part * tick_s), least);
        // The cast saturates.
        let mut division = self.division(&parts, tick_s, [steps, needed.ceil() as u32]);
        let mut reach = 1.0;
        if !budget.holds(division.count(), steps) {
            let (substeps, fraction) = budget.substeps(needed, steps);
            division = Division::even(steps.saturating_mul(substeps));
            reach = fraction;
        }
        let substeps = division.count().div_ceil(steps);
        let mut start = self.state.clone();
        self.forget(&jumped);
        let mut recoveries = Vec::new();
        let mut failure = None;
        let mut repetitions = 0;
        // Without containment only what did not converge is repeated.
        let mut doubted = start.doubtful || !self.repeat_invalid || !self.containment;
        let pace = slowed * reach;
        // Instruments that are slowed down already are not tried at length.
        let repeats = (self.containment || self.repeat_unconverged) && slowed >= 1.0;
        let is_tried = |(index, of): &(usize, Try)| match of {
            Try::Follow(_) => *index == 0 || repeats,
            // Without inertia nothing keeps tissue that is pressed ever further from an equilibrium that is not the right one.
            Try::Stand | Try::LetGo => self.containment && self.method.has_inertia(),
        };
        let tries = TRIES.into_iter().enumerate().filter(is_tried);
        let tries: Vec<Try> = tries.map(|(_, of)| of).collect();
        let follows = tries.iter().filter(|of| matches!(of, Try::Follow(_)));
        let follows = follows.count();
        let (mut torn, mut ruptured) = (TornBodies::default(), 0);
        let mut rounds = match (self.repeat_invalid && self.containment, start.doubtful) {
            (false, _) => 0,
            (true, false) => MAX_ROUNDS,
            (true, true) => 1,
        };
        // What one method of contact cannot compute another one often can.
        let mut augmented_lagrangian = false;
        let count_of = |index: usize, division: &Division, steps: u32| match tries[index] {
            Try::Follow(factor) => division.count().saturating_mul(factor),
            Try::Stand | Try::LetGo => steps,
        };
        let mut index = 0;
        while let Some(&this) = tries.get(index) {
            let count = count_of(index, &division, steps);
            let pace = match this {
                Try::Follow(_) => pace,
                Try::Stand | Try::LetGo => 0.0,
            };
            let effort = match this {
                Try::Follow(_) if index > 0 => Effort {
                    iterations: REPEATED_EFFORT,
                    augmented_lagrangian,
                },
                _ => Effort::default(),
            };
            let groups = self.groups.iter_mut();
            groups.for_each(|group| group.set_effort(effort));
            let touches = |motion: &&ToolMotion| match this {
                Try::Follow(_) => true,
                Try::Stand => !jumped.contains(&motion.tool),
                Try::LetGo => false,
            };
            let moved: Vec<ToolMotion> = motions.iter().filter(touches).copied().collect();
            let mut course = Course::new(&moved, &self.state.placements, pace);
            let divided = match this {
                Try::Follow(factor) => division.divided(factor),
                Try::Stand | Try::LetGo => Division::even(steps),
            };
            match self.attempt(&mut course, tick_s, steps, &divided, &mut budget, exec) {
                Ok(Attempted {
                    mut contacts,
                    loads,
                    solver,
                    overlaps_undone,
                }) => {
                    let valid = this != Try::LetGo && self.is_meaningful(&solver, &contacts);
                    if !valid && rounds > 0 && index < follows {
                        let shreds = self.failing_shreds();
                        if !shreds.is_empty() && budget.allows(count) {
                            rounds -= 1;
                            repetitions += 1;
                            ruptured += shreds.iter().map(|(_, of)| of.len() as u32).sum::<u32>();
                            self.state.clone_from(&start);
                            // An edit takes ties from model and state, so both are those of the start.
                            self.relocate();
                            self.rupture(&shreds, &mut torn);
                            start.clone_from(&self.state);
                            self.forget(&jumped);
                            continue;
                        }
                    }
                    let is_last = valid || doubted || index + 1 >= follows;
                    if !is_last && budget.allows(count_of(index + 1, &division, steps)) {
                        doubted = true;
                        augmented_lagrangian = solver.contact_failures > 0;
                        repetitions += 1;
                        self.state.clone_from(&start);
                        self.forget(&jumped);
                        index += 1;
                        continue;
                    }
                    self.state.doubtful = !valid;
                    budget.is_exceeded |= solver.cut_short > 0;
                    let placements = &mut self.state.placements;
                    course.store(placements);
                    match this {
                        Try::Follow(_) => placements.speed_up(),
                        Try::Stand | Try::LetGo => placements.slow_down(),
                    }
                    self.update_windows(&mut contacts, tick_s, valid);
                    let (start_bodies, moved) = (&start.bodies, course.motions());
                    let (mut cuts, rejected) =
                        self.cut(&moved, start_bodies, &loads, &contacts, tick_s, valid);
                    if valid {
                        self.tear_bodies(&mut torn);
                    }
                    cuts.extend(torn.reports());
                    cuts.iter_mut().for_each(|cut| cut.valid = valid);
                    self.state.time = start.time + tick_s;
                    return Ok(TickReport {
                        contacts,
                        cuts,
                        rejected,
                        substeps,
                        many_substeps: substeps > MANY_SUBSTEPS,
                        jumped,
                        stiffened,
                        recoveries,
                        repetitions,
                        ruptured,
                        solver,
                        valid,
                        stands: index >= follows,
                        over_budget: budget.is_exceeded,
                        work: budget.spent,
                        touching: course.touched,
                        overlaps_undone,
                        invalid_motions,
                    });
                }
                Err(found) => {
                    self.state.clone_from(&start);
                    self.forget(&jumped);
                    if self.shorten_steps(&found) {
                        start.stable_steps.clone_from(&self.state.stable_steps);
                        steps = steps.max(self.required_steps(tick_s));
                        division = Division::even(steps.saturating_mul(substeps));
                        stiffened = true;
                        // Tools that stand have to be computed in any case.
                        if index >= follows || budget.allows(count_of(index, &division, steps)) {
                            repetitions += 1;
                            continue;
                        }
                    }
                    failure = Some((found, tick_s / f64::from(count)));
                    if !self.containment && !found.what.is_unconverged() {
                        break;
                    }
                    index += 1;
                    if index < follows && !budget.allows(count_of(index, &division, steps)) {
                        index = follows;
                    }
                    repetitions += u32::from(index < tries.len());
                    if let Some(&Try::Follow(factor)) = tries.get(index) {
                        recoveries.push(Recovery {
                            body: found.body,
                            what: found.what,
                            factor,
                        });
                    }
                }
            }
        }
        match failure {
            Some((failure, step_s)) => {
                let cuts = torn.reports().into_iter();
                let cuts = cuts
                    .map(|cut| CutReport {
                        valid: false,
                        ..cut
                    })
                    .collect();
                let diverged = self.diverged(start, failure, step_s);
                Err(Diverged {
                    cuts,
                    repetitions,
                    ruptured,
                    ..diverged
                })
            }
            None => unreachable!("there is at least one try, and each returns or fails"),
        }
    }

    /// Removes the contact state of these tools, which have jumped.
    fn forget(&mut self, tools: &[usize]) {
        for &tool in tools {
            let contacts = self.state.contacts.iter_mut();
            contacts.for_each(|contact_state| contact_state.remove_tool(tool as u32));
        }
        self.state.placements.forget(tools);
    }

    /// The active motions of known tools, and the indices of those that cannot be used.
    fn valid_motions(&self, motions: &[ToolMotion]) -> (Vec<ToolMotion>, Vec<usize>) {
        let mut seen = BTreeSet::new();
        let (mut valid, mut invalid) = (Vec::new(), Vec::new());
        for (index, motion) in motions.iter().enumerate() {
            let usable =
                motion.tool < self.tools.len() && motion.is_finite() && seen.insert(motion.tool);
            if !usable {
                invalid.push(index);
            } else if motion.active {
                valid.push(*motion);
            }
        }
        (valid, invalid)
    }

    /// Puts elements that slide where the states of their bodies have put them.
    pub(crate) fn relocate(&mut self) {
        for group in &mut self.groups {
            group.relocate_members(&mut self.bodies, &self.state.bodies);
        }
    }

    /// One try of a tick of `tick_s` \[s\] in the solver's `steps`, divided so. Where its work exceeds the budget on the way the tools stop, and each of the
    /// solver's steps is made in one from there.
    fn attempt(
        &mut self,
        course: &mut Course,
        tick_s: f64,
        steps: u32,
        division: &Division,
        budget: &mut Budget,
        exec: &dyn Executor,
    ) -> Result<Attempted, Failure> {
        self.relocate();
        let start = self.state.bodies.clone();
        let planned = course.planned();
        let edges = self.edges(&planned);
        let mut loads = EdgeLoads::default();
        let mut solver = SolverReport::default();
        self.exempt_blades(&planned);
        // Without containment nobody asks what was there at the start: energies of all elements are not free.
        let watched = match self.containment {
            true => self.bodies.as_slice(),
            false => &[],
        };
        let irrigates = |motion: &ToolMotion| self.tools[motion.tool].irrigates(motion);
        let irrigated = planned.iter().any(irrigates);
        let mut watches: Vec<Watch> = watched
            .iter()
            .zip(&start)
            .map(|(body, state)| Watch::new(body, state, self.state.time, tick_s, irrigated))
            .collect();
        for pair in self.pairs.iter().filter(|pair| !pair.grip.is_empty()) {
            if let Some(watch) = watches.get_mut(pair.body) {
                watch.is_held();
            }
        }
        let mut tallies = vec![Tally::default(); self.pairs.len()];
        let mut stiffer = vec![false; self.groups.len()];
        let mut longest_steps = vec![None; self.groups.len()];
        let mut work = IterationWork::new(self.groups.len());
        let (parts, mut count) = (division.parts(), division.count());
        let (part, of_step) = (tick_s / f64::from(parts), (parts / steps).max(1));
        let states = &mut self.state.bodies;
        let mut joined: Vec<State> = self.groups.iter().map(|g| g.join(states)).collect();
        let mut tools: Vec<Option<Vec<CapsuleMotion>>> = vec![None; self.tools.len()];
        let mut jets = Vec::with_capacity(self.tools.len());
        let (mut step, mut from, mut stops) = (0, 0, false);
        while from < parts {
            let undivided = step + (parts - from).div_ceil(of_step);
            if !stops && step > 0 && undivided < count && budget.ends_with_next(work.mean()) {
                (stops, count) = (true, undivided);
                course.stop();
            }
            let to = match stops {
                true => ((from / of_step + 1) * of_step).min(parts),
                false => division.step(step)[1],
            };
            let h = part * f64::from(to - from);
            course.advance(
                &self.tools,
                [from, to, division.parts()],
                self.hand_force,
                self.tools_touch,
                &mut tools,
            );
            course.jets(&self.tools, &mut jets);
            let end = self.state.time + f64::from(to) * part;
            for (index, state) in joined.iter().enumerate() {
                let (of, allowed) = (&self.groups[index], &self.state.stable_steps);
                let Some(longest) = of.longest_step(&self.bodies, state, end - h, h, allowed)
                else {
                    continue;
                };
                if StretchGuard::is_too_long(h, longest) {
                    let what = Divergence::Stiffened {
                        longest_step_s: longest,
                    };
                    let body = of.members[0].body;
                    return Err(Failure { body, step, what });
                }
                longest_steps[index] = Some(longest);
            }
            for (index, state) in joined.iter_mut().enumerate() {
                let group = &mut self.groups[index];
                group.limit_work(budget.part(count - step));
                group.relocate(&mut self.bodies, state);
                let stepped = step_group(
                    group,
                    &self.bodies,
                    &mut self.state.contacts[index],
                    state,
                    &tools,
                    &jets,
                    &self.gravity,
                    end,
                    h,
                    exec,
                );
                let (body, what) = match stepped {
                    Ok((report, grown)) if state.is_finite() => {
                        budget.spend(report.work);
                        work.add(index, report.work, report.iterations);
                        solver.add(&report);
                        stiffer[index] |= grown;
                        let mut works = vec![Work::default(); group.members.len()];
                        sum_up(
                            group,
                            &self.bodies,
                            &self.pairs,
                            &self.tools,
                            &state.positions,
                            h,
                            &mut tallies,
                            &mut works,
                        );
                        for (member, work) in group.members.iter().zip(&works) {
                            if let Some(watch) = watches.get_mut(member.body) {
                                watch.add(work, &self.bodies[member.body]);
                            }
                        }
                        if let Some(contact) = &group.contact {
                            let (points, contacts) = (&contact.points, &contact.contacts);
                            course.load(&self.tools, points, contacts, &state.positions);
                            if !edges.is_empty() {
                                loads.add(index, contact, &tools, &edges, h);
                            }
                        }
                        continue;
                    }
                    Ok(_) => (group.not_finite(state), Divergence::NotFinite),
                    Err(failure) => {
                        budget.spend(group.least_work(&self.bodies, 0));
                        group.failed(failure)
                    }
                };
                return Err(Failure { body, step, what });
            }
            course.finish_step(&self.tools);
            (step, from) = (step + 1, to);
        }
        budget.expect(work.mean());
        for (group, state) in self.groups.iter().zip(joined) {
            group.split(state, &self.bodies, &mut self.state.bodies);
        }
        self.relocate();
        for (index, body) in self.bodies.iter().enumerate() {
            let end = &self.state.bodies[index];
            let found = match watches.get(index) {
                Some(watch) => watch.evaluate(
                    body,
                    &start[index],
                    end,
                    &self.gravity,
                    self.state.time + tick_s,
                ),
                None => containment::escaped(body, end),
            };
            if let Some(what) = found {
                return Err(Failure {
                    body: index,
                    step: count,
                    what,
                });
            }
        }
        for (group, _) in stiffer.iter().enumerate().filter(|(_, stiffer)| **stiffer) {
            for member in 0..self.groups[group].members.len() {
                self.update_stable_step(self.groups[group].members[member].body);
            }
        }
        for (group, longest) in longest_steps.into_iter().enumerate() {
            if let Some(longest) = longest {
                self.lengthen_steps(group, longest);
            }
        }
        // Cuts give nodes other places.
        let undone = self.bodies.iter().zip(watches).enumerate();
        let undone = undone.filter(|(_, (_, watch))| !watch.undone.is_empty());
        let undone = undone.map(|(index, (body, watch))| {
            let nodes = watch.undone.iter();
            let ids = nodes.map(|node| body.mesh.node_ids[*node as usize]);
            (index, ids.collect())
        });
        Ok(Attempted {
            overlaps_undone: undone.collect(),
            contacts: self.contact_reports(&tallies, &course.motions(), tick_s),
            loads,
            solver,
        })
    }
}

/// One step of a group: solver with contact, plastic flow. Returns also whether a body has become stiffer.
#[expect(clippy::too_many_arguments, reason = "a step has this many sides")]
fn step_group(
    group: &mut Group,
    bodies: &[Body],
    contact_state: &mut ContactState,
    state: &mut State,
    tools: &[Option<Vec<CapsuleMotion>>],
    jets: &[Jet],
    gravity: &Vector3<f64>,
    end: f64,
    h: f64,
    exec: &dyn Executor,
) -> Result<(StepReport, bool), StepFailure> {
    let _span = tracing::debug_span!("solve").entered();
    let mut control = group.control(bodies, gravity, end);
    group.irrigate(bodies, jets, &state.positions, &mut control);
    group.hold(tools, contact_state, &state.positions, &mut control);
    let targets = group.targets(bodies, end);
    let (model, solver, contact) = group.parts(bodies);
    let report = match contact {
        None => solver.step(model, state, &control, &targets, h, exec),
        Some(of) if !of.is_active(tools) => {
            of.clear();
            contact_state.clear();
            solver.step(model, state, &control, &targets, h, exec)
        }
        Some(of) => {
            let contacts = std::mem::take(&mut of.contacts);
            let mut source = of.source(&state.positions, tools, contact_state);
            let mut contact = ContactStep {
                source: &mut source,
                contacts,
            };
            let report = solver.advance(
                model,
                state,
                &control,
                &targets,
                Some(&mut contact),
                h,
                exec,
            );
            let contacts = contact.contacts;
            if report.is_ok() {
                of.finish(contacts, contact_state);
            }
            report
        }
    }?;
    group.end_irrigation(control);
    let points = group.contact.as_ref().map_or(0, |of| of.points.len());
    let work = report.work.max(group.least_work(bodies, 0)) + POINT * points as f64;
    let report = StepReport { work, ..report };
    group.iterations += u64::from(report.iterations);
    let grown = flow(group.model(bodies), state, h);
    Ok((report, grown))
}
