//! One try of a tick: its steps, each with contact, solver and what follows, and what was found amiss at its end.
//!
//! Which tries a tick makes, and what is done with them, is in [`tick`](crate::tick).

use crate::body::Body;
use crate::budget::{Budget, IterationWork};
use crate::containment::{Failure, HALVINGS, Watch};
use crate::divergence::Divergence;
use crate::division::Division;
use crate::group::Group;
use crate::group_contact::ContactState;
use crate::jet::Jet;
use crate::lonor::EdgeLoads;
use crate::placement::Course;
use crate::report::{ContactReport, SolverReport};
use crate::scene::Scene;
use crate::stretch_guard::StretchGuard;
use crate::tally::{Tally, Work, sum_up};
use crate::tool::ToolMotion;
use microsim_contact::CapsuleMotion;
use microsim_tissue::{ContactStep, Executor, State, StepFailure, StepReport, flow};
use nalgebra::Vector3;

/// Work of a point of contact in a step \[s\]: finding it, and in explicit steps its forces.
const POINT: f64 = 2e-6;

/// What came of a try.
pub(crate) struct Attempted {
    pub contacts: Vec<ContactReport>,
    pub loads: EdgeLoads,
    pub solver: SolverReport,
    /// Of each body with any, ids of nodes.
    pub overlaps_undone: Vec<(usize, Vec<u32>)>,
}

impl Scene {
    /// One try of a tick of `tick_s` \[s\] in the solver's `steps`, divided so. Where its work would exceed the budget the tools stop in their motion, and each of the
    /// solver's steps is made undivided from there.
    pub(crate) fn attempt(
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
        let jump_watches = self.jump_watches(&planned);
        for group in &mut self.groups {
            if let Some(contact) = &mut group.contact {
                contact.jump_watches.clone_from(&jump_watches);
            }
        }
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
        // What must converge takes no heed of its budget, and steps of explicit methods take what was foreseen.
        let may_stop = !self.method.must_converge() && !self.method.is_explicit();
        let (mut step, mut from, mut stops) = (0, 0, false);
        while from < parts {
            let undivided = (parts - from).div_ceil(of_step);
            if may_stop
                && !stops
                && step > 0
                && step + undivided < count
                && budget.leaves_no_more(undivided, work.mean())
            {
                (stops, count) = (true, step + undivided);
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
                if let Some(contact) = &mut group.contact {
                    contact.moves_on = step > 0 && !stops;
                }
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
        let end = self.state.time + tick_s;
        // Energy that grows in explicit steps is that of steps that are too long.
        let may_halve = course.is_let_go && !self.method.is_explicit();
        let mut halvings = vec![if may_halve { HALVINGS } else { 0 }; self.groups.len()];
        while let Some((body, what)) = self.first_diverged(&watches, &start, end) {
            let group = self.groups.iter().position(|of| of.holds(body));
            let Some(group) = group.filter(|group| halvings[*group] > 0) else {
                let step = division.count();
                return Err(Failure { body, step, what });
            };
            halvings[group] -= 1;
            self.halve_motion(group, &start, &mut watches);
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
