//! One tick: sub-steps, contact, solver, containment.

use crate::containment::{self, Diverged, Divergence, Failure, Watch};
use crate::report::{ContactReport, Recovery, TickReport};
use crate::scene::{Advance, Body, Scene};
use crate::tool::ToolMotion;
use microsim_contact::{BodySurface, CapsuleMotion, Response, respond};
use microsim_geometry::Aabb;
use microsim_tissue::{Executor, NodeTarget, StepFailure, flow};
use nalgebra::Vector3;
use std::collections::BTreeSet;

/// In one step a tool moves at most this share of its radius or of the mean edge length, whichever is less (NUMERICS 6).
const TRAVEL_PER_STEP: f64 = 0.25;

/// Largest number of sub-steps for fast tools (NUMERICS 6).
const MAX_SUBSTEPS: u32 = 16;

/// By how much the steps of a tick are divided when a body diverged: first try, then the repetitions.
const TRIES: [u32; 4] = [1, 2, 4, 8];

impl Scene {
    /// Advances by one tick of `tick_s` [s] in `steps` solver's steps, divided further where a tool is fast.
    ///
    /// A tool without a motion touches nothing. Each step takes the tools' poses from the interpolated motion. When a body
    /// diverges the tick is repeated from its start with shorter steps, and the report says so; when that does not help the
    /// scene stays at the start of the tick and the error says what happened; the next tick may go on from there.
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
        // Plastic flow may have made a body stiffer than it was when the number of steps was chosen.
        let required = self.required_steps(tick_s);
        let stiffened = self.has_stiffened() && steps < required;
        let steps = if stiffened { required } else { steps };
        let (motions, invalid_motions) = self.valid_motions(motions);
        let (substeps, capped) = self.substeps(&motions, tick_s, steps);
        let start = self.state.clone();
        let mut recoveries = Vec::new();
        let mut failure = None;
        let tries = if self.containment {
            &TRIES[..]
        } else {
            &TRIES[..1]
        };
        for (index, &factor) in tries.iter().enumerate() {
            let count = steps.saturating_mul(substeps).saturating_mul(factor);
            match self.attempt(&motions, tick_s, count, exec) {
                Ok(contacts) => {
                    self.state.time = start.time + tick_s;
                    return Ok(TickReport {
                        contacts,
                        substeps,
                        capped,
                        stiffened,
                        recoveries,
                        invalid_motions,
                    });
                }
                Err(found) => {
                    self.state.clone_from(&start);
                    failure = Some((found, tick_s / f64::from(count)));
                    if let Some(&next) = tries.get(index + 1) {
                        recoveries.push(Recovery {
                            body: found.body,
                            what: found.what,
                            factor: next,
                        });
                    }
                }
            }
        }
        match failure {
            Some((failure, step_s)) => Err(self.diverged(start, failure, step_s)),
            None => unreachable!("there is at least one try, and each returns or fails"),
        }
    }

    /// Whether plastic flow has shortened the stable step of a body.
    fn has_stiffened(&self) -> bool {
        let steps = self.bodies.iter().zip(&self.state.stable_steps);
        steps.into_iter().any(|(body, now)| *now < body.stable_step)
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

    /// Number of sub-steps for the fastest tool near a body that it may touch, and whether it is less than needed.
    fn substeps(&self, motions: &[ToolMotion], tick_s: f64, steps: u32) -> (u32, bool) {
        let mut needed = 1.0f64;
        for motion in motions {
            let tool = &self.tools[motion.tool];
            let swept = tool.swept_bounds(motion);
            for pair in self.pairs.iter().filter(|pair| pair.tool == motion.tool) {
                let (body, state) = (&self.bodies[pair.body], &self.state.bodies[pair.body]);
                // Far from the body a tool may be as fast as it likes. The body itself may come nearer by its own speed.
                let speed = state
                    .velocities
                    .iter()
                    .map(|v| v.norm())
                    .fold(0.0, f64::max);
                let edge = body.model.mean_edge_length();
                let reach = Aabb::of(&state.positions).inflated(edge + speed * tick_s);
                if !reach.overlaps(&swept) {
                    continue;
                }
                let per_step = TRAVEL_PER_STEP * tool.smallest_radius().min(edge);
                needed = needed.max(tool.travel(motion) / f64::from(steps) / per_step);
            }
        }
        let needed = needed.ceil();
        (
            needed.min(f64::from(MAX_SUBSTEPS)) as u32,
            needed > f64::from(MAX_SUBSTEPS),
        )
    }

    /// One try of a tick in `count` steps.
    fn attempt(
        &mut self,
        motions: &[ToolMotion],
        tick_s: f64,
        count: u32,
        exec: &dyn Executor,
    ) -> Result<Vec<ContactReport>, Failure> {
        let start = self.state.bodies.clone();
        let mut watches: Vec<Watch> = self
            .bodies
            .iter()
            .zip(&start)
            .map(|(body, state)| Watch::new(body, state, self.state.time, tick_s))
            .collect();
        let mut tallies = vec![Tally::default(); self.pairs.len()];
        let mut stiffer = vec![false; self.bodies.len()];
        let h = tick_s / f64::from(count);
        for step in 0..count {
            let t0 = f64::from(step) / f64::from(count);
            let t1 = f64::from(step + 1) / f64::from(count);
            let mut tools: Vec<Option<Vec<CapsuleMotion>>> = vec![None; self.tools.len()];
            for motion in motions {
                tools[motion.tool] = Some(self.tools[motion.tool].step(motion, t0, t1));
            }
            let end = self.state.time + f64::from(step + 1) * h;
            for (body, watch) in watches.iter_mut().enumerate() {
                let failure = |what| Failure { body, step, what };
                stiffer[body] |= self
                    .step_body(body, &tools, end, h, exec, watch, &mut tallies)
                    .map_err(|what| failure(Divergence::Step(what)))?;
                if !self.state.bodies[body].is_finite() {
                    return Err(failure(Divergence::NotFinite));
                }
            }
        }
        for (index, watch) in watches.iter().enumerate() {
            let (body, end) = (&self.bodies[index], &self.state.bodies[index]);
            let found = if self.containment {
                watch.judge(
                    body,
                    &start[index],
                    end,
                    &self.gravity,
                    self.state.time + tick_s,
                )
            } else {
                containment::escaped(body, end)
            };
            if let Some(what) = found {
                return Err(Failure {
                    body: index,
                    step: count,
                    what,
                });
            }
        }
        for (body, _) in stiffer.iter().enumerate().filter(|(_, stiffer)| **stiffer) {
            self.renew_stable_step(body);
        }
        Ok(self.contact_reports(&tallies, tick_s))
    }

    /// One step of one body: forces and prediction, contact with each tool in turn, motion, plastic
    /// flow. Returns whether the body has become stiffer.
    #[expect(clippy::too_many_arguments, reason = "a step has this many sides")]
    fn step_body(
        &mut self,
        body_index: usize,
        tools: &[Option<Vec<CapsuleMotion>>],
        end: f64,
        h: f64,
        exec: &dyn Executor,
        watch: &mut Watch,
        tallies: &mut [Tally],
    ) -> Result<bool, StepFailure> {
        let Body {
            model,
            advance,
            drive,
            surface,
            iterations,
            ..
        } = &mut self.bodies[body_index];
        let state = &mut self.state.bodies[body_index];
        let control = drive.control(&self.gravity, end);
        let grips = drive.contacts(end);
        let solver = match advance {
            Advance::Contact(solver) => solver,
            Advance::Plain(solver) => {
                let report = solver.step(model, state, &control, &grips, h, exec)?;
                *iterations += u64::from(report.iterations);
                return Ok(flow(model, state, h));
            }
        };
        *iterations += 1;
        let predicted = solver.predict(model, state, &control, h, exec);

        // Each tool sees where grips and the tools before it have led the nodes. It cannot move what a grip holds.
        let mut targets: Vec<Vector3<f64>> = Vec::new();
        let mut movable = model.inverse_masses().to_vec();
        for grip in &grips.targets {
            movable[grip.node as usize] = 0.0;
        }
        let mut responses: Vec<(usize, Response)> = Vec::new();
        for (index, pair) in self
            .pairs
            .iter()
            .enumerate()
            .filter(|(_, pair)| pair.body == body_index)
        {
            let memory = &mut self.state.memories[index];
            let Some(capsules) = &tools[pair.tool] else {
                memory.clear();
                continue;
            };
            if targets.is_empty() {
                targets.extend_from_slice(predicted);
                for grip in &grips.targets {
                    targets[grip.node as usize] = grip.target;
                }
            }
            let surface = BodySurface {
                surface,
                start: &state.positions,
                inverse_masses: &movable,
                mean_edge_length: model.mean_edge_length(),
            };
            responses.push((index, respond(&surface, capsules, memory, &mut targets)));
        }

        let mut contacts = grips;
        for (_, response) in &responses {
            for moved in &response.nodes {
                contacts.targets.push(NodeTarget {
                    node: moved.node,
                    target: targets[moved.node as usize],
                    overlap: moved.overlap,
                });
            }
        }
        merge_targets(&mut contacts.targets);

        // The share of each tool in the force on a node is its share in the correction.
        for (index, response) in &responses {
            let tally = &mut tallies[*index];
            tally.max_depth = tally.max_depth.max(response.max_depth);
            let mut total = Vector3::zeros();
            for moved in &response.nodes {
                let node = moved.node as usize;
                let force =
                    solver.contact_force(model, moved.node, &(moved.correction - moved.overlap));
                total += force;
                tally.touched(moved.node, &force, &targets[node], h);
                watch.work += force.dot(&(targets[node] - state.positions[node])).abs();
                watch.overlap_undone |= moved.overlap != Vector3::zeros();
            }
            tally.impulse += total * h;
            tally.impulse_size += total.norm() * h;
            tally.peak = tally.peak.max(total.norm());
        }
        solver.finish(model, state, &contacts);
        Ok(flow(model, state, h))
    }

    fn contact_reports(&self, tallies: &[Tally], tick_s: f64) -> Vec<ContactReport> {
        let touched = self
            .pairs
            .iter()
            .zip(tallies)
            .filter(|(_, tally)| !tally.nodes.is_empty());
        let reports = touched.map(|(pair, tally)| {
            let positions = &self.state.bodies[pair.body].positions;
            let rest = self.bodies[pair.body].model.rest_positions();
            let direction = tally
                .impulse
                .try_normalize(0.0)
                .unwrap_or_else(Vector3::zeros);
            let indentation = tally
                .nodes
                .iter()
                .map(|&node| (positions[node as usize] - rest[node as usize]).dot(&direction))
                .fold(0.0, f64::max);
            let point = if tally.weight > 0.0 {
                tally.weighted_point / tally.weight
            } else {
                tally.last_point
            };
            ContactReport {
                tool: pair.tool,
                body: pair.body,
                force_on_tissue: (tally.impulse / tick_s).into(),
                peak_force_n: tally.peak,
                impulse_ns: tally.impulse_size,
                point: point.into(),
                max_depth_m: tally.max_depth,
                indentation_m: indentation,
                nodes: tally.nodes.len(),
            }
        });
        reports.collect()
    }
}

/// What one pair sums up over a tick.
#[derive(Clone, Debug, Default)]
struct Tally {
    /// Σ F h [N·s].
    impulse: Vector3<f64>,
    /// Σ |F| h [N·s].
    impulse_size: f64,
    peak: f64,
    /// Σ |F_i| h p_i and Σ |F_i| h over the nodes.
    weighted_point: Vector3<f64>,
    weight: f64,
    last_point: Vector3<f64>,
    max_depth: f64,
    nodes: BTreeSet<u32>,
}

impl Tally {
    fn touched(&mut self, node: u32, force: &Vector3<f64>, position: &Vector3<f64>, h: f64) {
        let weight = force.norm() * h;
        self.weighted_point += position * weight;
        self.weight += weight;
        self.last_point = *position;
        self.nodes.insert(node);
    }
}

/// Nodes touched by more than one tool get one target; the overlaps that each tool undid add up.
fn merge_targets(targets: &mut Vec<NodeTarget>) {
    targets.sort_by_key(|target| target.node);
    targets.dedup_by(|later, first| {
        let same = later.node == first.node;
        if same {
            first.overlap += later.overlap;
        }
        same
    });
}
