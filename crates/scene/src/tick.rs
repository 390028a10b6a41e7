//! One tick: how it is divided, the tries that it takes, and what is reported of the one that counts.

use crate::attempt::Attempted;
use crate::budget::Budget;
use crate::cut_report::CutReport;
use crate::cutting::TornBodies;
use crate::divergence::Diverged;
use crate::division::Division;
use crate::placement::Course;
use crate::report::{MANY_SUBSTEPS, Recovery, TickReport};
use crate::scene::Scene;
use crate::tool::ToolMotion;
use microsim_tissue::{Effort, Executor};
use std::collections::BTreeSet;

/// How a tick is tried.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Try {
    /// Tools follow their hands, in steps that are divided by this.
    Follow(u32),
    /// Tools stay where they were.
    Stand,
    /// Tools touch nothing. Where a body diverges all the same in implicit steps, it goes only a part of the motion that was found.
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

/// How often a tick whose forces mean nothing is computed again without the shreds that fail in it.
const MAX_ROUNDS: u32 = 4;

impl Scene {
    /// Advances by one tick of `tick_s` \[s\] in `steps` solver's steps, divided further where a tool is fast.
    ///
    /// A tool without a motion touches nothing. Each step takes the tools' poses from the interpolated motion. When a body
    /// diverges, or, without containment, an implicit step does not converge, the tick is repeated from its start with shorter steps, and the report lists it; when that does not help it is computed with the tools where they were, and else with tools that touch nothing, of which the bodies go as large a part, halved and halved again, as none diverges in; when there is no such part either the
    /// scene stays at the start of the tick, where after implicit steps the bodies are at rest that diverged, without shreds that ruptured meanwhile, and the error describes what happened; the next tick may go on from there. A tick whose forces
    /// mean nothing ([`SolverBounds`](crate::SolverBounds)) is repeated without the shreds that failed in it, and else once with steps of half the length, four times the iterations and, where the interior-point method has found no forces, the augmented Lagrangian method of contact, and not [`valid`](TickReport::valid) if
    /// that does not help; then those that follow are not repeated until one is valid, so that a scene beyond its solver costs no multiple; where there is inertia tools make a quarter of their motions in the next tick, so that less has to be computed, twice as much after each valid one, and ticks are repeated again where it is all.
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
        // instruments that are slowed down make only a part of their motion.
        let slowed = self.state.placements.pace;
        let needed = (slowed * needed).max(1.0);
        let parts: Vec<ToolMotion> = motions.iter().map(|of| of.first_part(slowed)).collect();
        let groups = self.groups.iter().zip(&self.state.contacts);
        let least = groups.map(|(group, of)| group.least_work(&self.bodies, of.forces.len()));
        let least: f64 = least.sum();
        let overspent = self.state.overspent;
        let mut budget = Budget::new(self.budget.map(|of| of.left(tick_s, overspent)), least);
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
        let eases = self.repeat_invalid && self.containment && self.method.has_inertia();
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
        // What one method of contact cannot compute another one often can. Of a try that diverged that is not known.
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
            let mut course = match this {
                Try::LetGo => Course::let_go(),
                Try::Follow(_) | Try::Stand => Course::new(&moved, &self.state.placements, pace),
            };
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
                    self.spend(tick_s, budget.spent);
                    budget.is_exceeded |= solver.cut_short > 0;
                    let placements = &mut self.state.placements;
                    course.store(placements);
                    // What is too much for one tick is divided among several.
                    match this {
                        Try::Follow(_) if !valid && eases => placements.ease(),
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
                    if cuts.is_empty() {
                        self.coarsen(start.time, budget.spent);
                    }
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
                    budget.release_reserve();
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
                self.spend(tick_s, budget.spent);
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

    /// Adds the work of a tick \[s\] to what its successors have to make up for.
    fn spend(&mut self, tick_s: f64, work: f64) {
        if let Some(budget) = self.budget {
            self.state.overspent = budget.overspent(tick_s, self.state.overspent, work);
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
}
