//! How a tick is divided for tools that are fast: by what of them comes near tissue, and by how far jaws close beside it.

use crate::division::Division;
use crate::pairs::{Pair, PairPartner};
use crate::scene::Scene;
use crate::tool::ToolMotion;
use microsim_geometry::{Aabb, Capsule, closest_segment_triangle};
use microsim_tissue::State;
use nalgebra::Vector3;

/// In one step a part of a tool moves at most so many times its radius or the mean edge length, whichever is less: explicit methods
/// (NUMERICS 6), and implicit ones, which find contact again in every iteration and over the whole path of a capsule.
const TRAVEL_EXPLICIT: f64 = 0.25;
const TRAVEL_IMPLICIT: f64 = 2.0;

/// In an implicit step jaws beside tissue close by at most so many times its mean edge length, but those that cut it. What is between them is turned inside out where their distance
/// vanishes in one, and does not turn back when they open. Measured with forceps that twitch at different times (`tests/tests/outliers.rs`): without it a hold is lost.
const CLOSING_IMPLICIT: f64 = 0.25;

/// A tool that needs more sub-steps than this has jumped.
const MAX_SUBSTEPS: u32 = 256;

/// Where a body may be in a tick.
#[derive(Clone, Copy, Debug)]
struct Reach {
    /// The box around it at the start.
    bounds: Aabb,
    /// How far it goes by its own speed, at most \[m\].
    drift: f64,
}

impl Scene {
    /// Number of sub-steps for the fastest tool near a body that it may touch. A tool that needs too many is placed at the end of its
    /// motion, and listed.
    pub(crate) fn substeps(
        &self,
        motions: &mut [ToolMotion],
        tick_s: f64,
        steps: u32,
    ) -> (f64, Vec<usize>) {
        let (mut most, mut jumped) = (1.0f64, Vec::new());
        let reaches = self.reaches(tick_s);
        for motion in motions {
            let mut needed = 1.0f64;
            for body in self.touched_by(motion.tool) {
                let of_body = self.steps_near(motion, body, &reaches[body]);
                needed = needed.max(of_body / f64::from(steps));
            }
            if needed > f64::from(MAX_SUBSTEPS) {
                jumped.push(motion.tool);
                motion.from = motion.to;
                motion.opening_from = motion.opening_to;
            } else {
                most = most.max(needed);
            }
        }
        (most, jumped)
    }

    /// The steps of a tick, of which each is divided into so many where a tool is near tissue. Explicit methods, whose steps may not be longer than
    /// they are, and steps that are not divided have even ones.
    pub(crate) fn division(
        &self,
        motions: &[ToolMotion],
        tick_s: f64,
        [steps, substeps]: [u32; 2],
    ) -> Division {
        let parts = steps.saturating_mul(substeps);
        if substeps <= 1 || self.method.is_explicit() {
            return Division::even(parts);
        }
        let mut near = vec![false; parts as usize];
        let reaches = self.reaches(tick_s);
        for motion in motions {
            for body in self.touched_by(motion.tool) {
                // What is slow enough for the whole step divides none.
                if self.steps_near(motion, body, &reaches[body]) > f64::from(steps) {
                    self.mark_near(motion, body, &reaches[body], &mut near);
                }
            }
        }
        Division::around(&near, steps)
    }

    /// Number of steps for the motion of a tool near a body, any fraction; 0 where it does not come near it.
    fn steps_near(&self, motion: &ToolMotion, body: usize, of: &Reach) -> f64 {
        let tool = &self.tools[motion.tool];
        let edge = self.bodies[body].model.mean_edge_length();
        // Far from the body a tool may be as fast as it likes.
        let reach = of.bounds.inflated(edge + of.drift);
        if self.method.is_explicit() {
            return tool.steps_within(motion, &reach, edge, TRAVEL_EXPLICIT);
        }
        match tool.steps_within(motion, &reach, edge, TRAVEL_IMPLICIT) {
            0.0 => 0.0,
            travel => travel.max(tool.closing(motion) / (CLOSING_IMPLICIT * edge)),
        }
    }

    /// Marks the even parts of a tick in which the tool may come to the surface of a body.
    fn mark_near(&self, motion: &ToolMotion, body: usize, of: &Reach, near: &mut [bool]) {
        let tool = &self.tools[motion.tool];
        let positions = &self.state.bodies[body].positions;
        let Reach { bounds, drift } = *of;
        let parts = near.len() as f64;
        let at = |part: usize| tool.capsules_at(motion, part as f64 / parts);
        let mut start: Vec<Capsule> = at(0).collect();
        for (part, near) in near.iter_mut().enumerate() {
            let end: Vec<Capsule> = at(part + 1).collect();
            *near |= start.iter().zip(&end).any(|(from, to)| {
                // A point of the axis is no further from where it is in the middle of straight paths than half of the longer one, in a turn by less than that again.
                let path = (to.a - from.a).norm().max((to.b - from.b).norm());
                let reach = from.radius + path + drift;
                let middle = [(from.a + to.a) * 0.5, (from.b + to.b) * 0.5];
                let around = bounds.inflated(reach);
                let Some([first, last]) = around.clip(&middle[0], &middle[1]) else {
                    return false;
                };
                let axis = [first, last].map(|t| middle[0] + (middle[1] - middle[0]) * t);
                let box_of_axis = Aabb::of(&axis).inflated(reach);
                let triangles = self.bodies[body].surface.triangles.iter();
                let mut corners = triangles.map(|of| of.map(|node| positions[node as usize]));
                corners.any(|corners| {
                    Aabb::of(&corners).overlaps(&box_of_axis)
                        && closest_segment_triangle(&axis[0], &axis[1], &corners).distance()
                            <= reach
                })
            });
            start = end;
        }
    }

    /// The bodies that a tool may touch.
    fn touched_by(&self, tool: usize) -> impl Iterator<Item = usize> {
        let of_tool = move |pair: &&Pair| pair.with == PairPartner::Tool(tool);
        self.pairs.iter().filter(of_tool).map(|pair| pair.body)
    }

    /// Where all bodies may be in a tick.
    fn reaches(&self, tick_s: f64) -> Vec<Reach> {
        let bodies = self.state.bodies.iter();
        let of_body = |state: &State| {
            let squares = state.velocities.iter().map(Vector3::norm_squared);
            Reach {
                bounds: Aabb::of(&state.positions),
                drift: squares.fold(0.0, f64::max).sqrt() * tick_s,
            }
        };
        bodies.map(of_body).collect()
    }
}
