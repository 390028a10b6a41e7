//! Where tools are: between where a hand holds them and where what they touch lets them be.
//!
//! A tracked pose and opening are a target, not a wall. Six causes keep a tool from it:
//!
//! - **Jaws bend.** Opening q, its target T and the moment Q of the contact forces on the jaws, per unit of opening, are in equilibrium,
//!   k (q − T) = Q, with the stiffness k of both jaws. The solver has the jaws at rest in a step; the moment of the next one is
//!   predicted from that of the last and its secant stiffness K, so q' = (k T' + Q + K q) / (k + K). Without force q is T, to the bit.
//! - **Tissue is not squeezed to nothing.** Laws of soft tissue bear any compression with forces that hardly bend a jaw. Bending jaws of a tool that cuts nothing close on what both of them
//!   press no further than to [`SQUEEZED`] of the opening at which they began to.
//! - **A hand yields.** It pushes with at most the force F of the scene: a tool goes against what it touches no further than until that is reached, by
//!   the force P of the last step and its secant stiffness K a distance of (F − P)/K in a step, and back where P is above F.
//! - **Tools do not pass through each other.** Where capsules of two overlap, or have gone through each other in a step, both yield by half; jaws
//!   open where that is how they yield.
//! - **What cannot be computed is not forced.** A tick in which a body diverges is computed again with the tools where they were, and if that diverges too with
//!   tools that touch nothing, where the bodies go only so large a part of the motion that was found as none diverges in. From then on, and after a tick whose forces mean nothing, they go only a fraction of what is left to their targets in a tick, which doubles whenever a tick succeeds.
//!   Only methods with inertia do so; a quasi-static tick that diverges is left at its start.
//! - **What does not fit in the work of a tick waits.** A tool that is too fast for it makes only a part of its motion, and one whose steps take more than was foreseen
//!   stops in it ([`budget`](crate::budget)); the next tick goes on from there.
//!
//! Limitations: of a jaw the tip's compliance counts wherever it is touched, both jaws bend alike, and shafts do not bend under tissue. A hand yields
//! along its force and does not turn; where a single step closes on something rigid, its force shows before the hand has yielded.
//! What is hollow or folded is squeezed to a tenth of its outer thickness as well, so that a thin vessel cannot be pressed shut; and where tools have touched nothing for a tick, they begin to press again.

use crate::jet::Jet;
use crate::spec::Jaw;
use crate::tool::{Tool, ToolMotion};
use microsim_contact::{CapsuleMotion, Partner, Point};
use microsim_geometry::{Capsule, Motion, Pose, closest_segments, first_contact_edges};
use microsim_tissue::Contact;
use nalgebra::Vector3;

/// The fraction of the motion to its target that a tool makes in a tick after one that could not be computed.
const SLOWED: f64 = 0.25;

/// It becomes no smaller.
const SLOWEST: f64 = 1.0 / 64.0;

/// The secant stiffness is at most so many times that of the jaws: what moves tissue besides the jaws would make it arbitrary.
const STIFFEST: f64 = 100.0;

/// Secant stiffness of what a whole tool pushes against \[N/m\]: at least that of soft tissue under a shaft, a judgement, and at most so much. Where it is
/// taken too large a hand yields more slowly, where too small it is thrown back.
const RESISTANCE: [f64; 2] = [2e3, 1e7];

/// A force and a displacement that are too small for an estimate of it \[N, m\].
const FELT: f64 = 0.1;
const SHIFTED: f64 = 1e-6;

/// A tool is pushed back by at most so much in a step \[m\].
const RETREAT: f64 = 0.25e-3;

/// A change of the opening that is too small for an estimate of stiffness.
const STILL: f64 = 1e-7;

/// What jaws that close completely leave of the opening at which they began to press, of the thickness of solid tissue therefore: what is not fluid, a judgement. Without it a tuft of loose
/// tissue, 0.6 mm thick, that a trembling hand squeezed turned inside out, and hung on a jaw after it had opened (`tests/tests/trainees.rs`).
const SQUEEZED: f64 = 0.1;

/// Passes over all pairs of capsules of two tools.
const PASSES: usize = 8;

/// A tool at the end of a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Placement {
    /// `world_from_tool`.
    pub pose: Pose,
    /// Target of the opening.
    pub target: f64,
    /// The opening itself.
    pub opening: f64,
    /// Moment of the contact forces on the jaws that opens them, per unit of opening \[J\].
    pub moment: f64,
    /// Secant stiffness of what is between the jaws \[J\].
    pub stiffness: f64,
    /// Opening at the end of the step in which both jaws began to press what is between them; 0 once neither does.
    pub grasped: f64,
    /// Sum of the contact forces on the whole tool \[N\].
    pub push: Vector3<f64>,
    /// Secant stiffness of what it pushes against \[N/m\].
    pub resistance: f64,
    /// Whether it is where the hand holds it.
    pub is_free: bool,
}

/// What evolves of the tools.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Placements {
    /// Per tool; `None` while it is away.
    pub tools: Vec<Option<Placement>>,
    /// The fraction of the motion to their targets that tools make in a tick.
    pub pace: f64,
}

impl Placements {
    pub fn new(tools: usize) -> Self {
        Self {
            tools: vec![None; tools],
            pace: 1.0,
        }
    }

    /// After a tick that could not be computed but with the tools where they were.
    pub fn slow_down(&mut self) {
        self.pace = (self.pace * SLOWED).max(SLOWEST);
    }

    /// After one whose forces mean nothing: no more than a part, but slower and slower would leave them where they are what cannot be computed.
    pub fn ease(&mut self) {
        self.pace = (2.0 * self.pace).min(SLOWED);
    }

    /// After one that could be computed.
    pub fn speed_up(&mut self) {
        self.pace = (2.0 * self.pace).min(1.0);
    }

    /// Motions begin where tools are, not where they were to be.
    pub fn resume(&self, motions: &mut [ToolMotion]) {
        for motion in motions {
            let held_off = self.tools[motion.tool].filter(|placement| !placement.is_free);
            if let Some(placement) = held_off {
                (motion.from, motion.opening_from) = (placement.pose, placement.target);
            }
        }
    }

    /// A tool that has jumped does not go on from where it was.
    pub fn forget(&mut self, tools: &[usize]) {
        tools.iter().for_each(|&tool| self.tools[tool] = None);
    }
}

/// The course of all tools over a tick.
#[derive(Clone, Debug)]
pub(crate) struct Course {
    tools: Vec<PlacedTool>,
    /// Pairs of tools that touched, the smaller index first, ascending.
    pub touched: Vec<[usize; 2]>,
    /// Whether tools touch nothing, so that the bodies may go a part of their motion.
    pub is_let_go: bool,
}

#[derive(Clone, Copy, Debug)]
struct PlacedTool {
    /// From where it was to what it is to come to in this tick.
    motion: ToolMotion,
    /// At the start of the tick, at that of the step, and now.
    start: Placement,
    before: Placement,
    now: Placement,
    /// Whether nothing has pushed it off the straight line of its motion.
    is_straight: bool,
    /// Whether the motion ends at the target.
    is_whole: bool,
    /// Moment \[J\] and sum \[N\] of the contact forces of the step, and what of the moment opens each jaw \[J\].
    moment: f64,
    opening_moments: [f64; 2],
    push: Vector3<f64>,
}

impl Course {
    /// The course of these motions, which begin where tools are ([`Placements::resume`]); of each it makes the fraction `pace`, 0..1.
    pub fn new(motions: &[ToolMotion], placements: &Placements, pace: f64) -> Self {
        let tools = motions.iter().map(|motion| {
            let last = placements.tools[motion.tool];
            let held = last.filter(|placement| !placement.is_free);
            let start = held.unwrap_or(Placement {
                pose: motion.from,
                target: motion.opening_from,
                opening: motion.opening_from,
                moment: 0.0,
                stiffness: 0.0,
                grasped: 0.0,
                push: last.map_or_else(Vector3::zeros, |last| last.push),
                resistance: last.map_or(RESISTANCE[0], |last| last.resistance),
                is_free: true,
            });
            PlacedTool {
                motion: motion.first_part(pace),
                start,
                before: start,
                now: start,
                is_straight: true,
                is_whole: pace >= 1.0,
                moment: 0.0,
                opening_moments: [0.0; 2],
                push: Vector3::zeros(),
            }
        });
        Self {
            tools: tools.collect(),
            touched: Vec::new(),
            is_let_go: false,
        }
    }

    /// The course of tools that touch nothing.
    pub fn let_go() -> Self {
        Self {
            tools: Vec::new(),
            touched: Vec::new(),
            is_let_go: true,
        }
    }

    /// Ends the motions where the tools are now.
    pub fn stop(&mut self) {
        for one in &mut self.tools {
            one.motion.to = one.now.pose;
            one.motion.opening_to = one.now.target;
            (one.is_straight, one.is_whole) = (false, false);
        }
    }

    /// The motions as they are planned: to the targets of this tick, with jaws bent as they are.
    pub fn planned(&self) -> Vec<ToolMotion> {
        let plan = |one: &PlacedTool| ToolMotion {
            opening_from: one.start.opening,
            opening_to: one.motion.opening_to + (one.start.opening - one.start.target),
            ..one.motion
        };
        self.tools.iter().map(plan).collect()
    }

    /// The motions from the start of the tick to where the tools are now.
    pub fn motions(&self) -> Vec<ToolMotion> {
        let motion = |one: &PlacedTool| ToolMotion {
            from: one.start.pose,
            to: one.now.pose,
            opening_from: one.start.opening,
            opening_to: one.now.opening,
            ..one.motion
        };
        self.tools.iter().map(motion).collect()
    }

    /// Moves the tools in the step from the first to the second of so many even parts of the tick, pushed with at most `hand_force` \[N\] and without passing through each other if they
    /// `do_touch`, and sets the motions of their capsules.
    pub fn advance(
        &mut self,
        tools: &[Tool],
        step: [u32; 3],
        hand_force: f64,
        do_touch: bool,
        capsules: &mut [Option<Vec<CapsuleMotion>>],
    ) {
        for one in &mut self.tools {
            one.advance(&tools[one.motion.tool], step);
            one.hold_back(hand_force);
        }
        if do_touch {
            self.separate(tools);
        }
        for one in &self.tools {
            let motions = one.capsules(&tools[one.motion.tool], step);
            capsules[one.motion.tool] = Some(motions);
        }
    }

    /// The jets of the tools where they are now.
    pub fn jets(&self, tools: &[Tool], jets: &mut Vec<Jet>) {
        jets.clear();
        jets.extend(self.tools.iter().filter_map(|one| {
            let tool = &tools[one.motion.tool];
            tool.jet(&one.now.pose, one.now.opening)
        }));
    }

    /// Adds the forces with which the contacts of a group of bodies ended a step at `positions` \[m\].
    pub fn load(
        &mut self,
        tools: &[Tool],
        points: &[Point],
        contacts: &[Contact],
        positions: &[Vector3<f64>],
    ) {
        for (point, contact) in points.iter().zip(contacts) {
            let Partner::Tool { tool, capsule } = point.key.partner else {
                continue;
            };
            let tool = tool as usize;
            let of_tool = |one: &&mut PlacedTool| one.motion.tool == tool;
            if contact.normal_force <= 0.0 {
                continue;
            }
            if let Some(one) = self.tools.iter_mut().find(of_tool) {
                let place = contact.interpolate(positions);
                let path = tools[tool].path_of_opening(capsule, &one.now.pose, &place);
                let moment = -contact.force().dot(&path);
                one.moment += moment;
                if let Some(jaw) = tools[tool].jaw(capsule) {
                    one.opening_moments[usize::from(jaw == Jaw::Right)] += moment;
                }
                one.push -= contact.force();
            }
        }
    }

    /// Ends a step whose contacts have been added: what is between jaws is as stiff as it has shown.
    pub fn finish_step(&mut self, tools: &[Tool]) {
        for one in &mut self.tools {
            one.feel();
            let moment = std::mem::take(&mut one.moment);
            let opening_moments = std::mem::take(&mut one.opening_moments);
            let jaws = tools[one.motion.tool].jaw_stiffness;
            if !jaws.is_finite() {
                continue;
            }
            let change = one.now.opening - one.before.opening;
            if moment == 0.0 {
                one.now.stiffness = 0.0;
            } else if change.abs() > STILL {
                let secant = (one.now.moment - moment) / change;
                let least = 0.5 * one.now.stiffness;
                one.now.stiffness = secant.clamp(least, STIFFEST * jaws);
            }
            one.now.moment = moment;
            one.now.grasped = match opening_moments.map(|moment| moment > 0.0) {
                [true, true] if one.now.grasped == 0.0 => one.now.opening,
                [false, false] => 0.0,
                // A hand that trembles takes one jaw off for a moment.
                _ => one.now.grasped,
            };
        }
    }

    /// Stores where the tools are; the others are away.
    pub fn store(&self, placements: &mut Placements) {
        placements.tools.fill(None);
        for one in &self.tools {
            let is_free = one.is_whole && one.is_straight && one.now.opening == one.now.target;
            let is_free = is_free && one.now.moment == 0.0;
            placements.tools[one.motion.tool] = Some(Placement { is_free, ..one.now });
        }
    }

    /// Pushes tools apart that overlap, or have gone through each other in this step.
    fn separate(&mut self, tools: &[Tool]) {
        for first in 0..self.tools.len() {
            for second in first + 1..self.tools.len() {
                let touched = (0..PASSES).take_while(|_| self.push_apart(tools, [first, second]));
                if touched.count() > 0 {
                    let both = [first, second].map(|k| self.tools[k].motion.tool);
                    let pair = [both[0].min(both[1]), both[0].max(both[1])];
                    if let Err(place) = self.touched.binary_search(&pair) {
                        self.touched.insert(place, pair);
                    }
                }
            }
        }
    }

    /// Undoes the deepest overlap of two tools; whether there was any.
    fn push_apart(&mut self, tools: &[Tool], pair: [usize; 2]) -> bool {
        let [first, second] = pair.map(|k| {
            let one = &self.tools[k];
            one.ends(&tools[one.motion.tool])
        });
        let mut deepest: Option<Overlap> = None;
        for (i, a) in first.iter().enumerate() {
            for (j, b) in second.iter().enumerate() {
                if let Some(found) = Overlap::of([a, b], [i as u32, j as u32])
                    && deepest.as_ref().is_none_or(|most| found.depth > most.depth)
                {
                    deepest = Some(found);
                }
            }
        }
        let Some(overlap) = deepest else {
            return false;
        };
        for (k, sign) in [(0, 0.5), (1, -0.5)] {
            let one = &mut self.tools[pair[k]];
            let tool = &tools[one.motion.tool];
            let shift = overlap.normal * (sign * overlap.depth);
            one.yield_by(tool, overlap.capsules[k], &overlap.places[k], &shift);
        }
        true
    }
}

impl PlacedTool {
    /// Goes on in a step.
    fn advance(&mut self, tool: &Tool, [from, to, parts]: [u32; 3]) {
        self.before = self.now;
        let Self { motion, now, .. } = self;
        if self.is_straight {
            let t = f64::from(to) / f64::from(parts);
            now.target = motion.opening_from + (motion.opening_to - motion.opening_from) * t;
            now.pose = match to == parts {
                true => motion.to,
                false => motion.from.interpolate(&motion.to, t),
            };
        } else {
            let t = f64::from(to - from) / f64::from(parts - from);
            now.target += (motion.opening_to - now.target) * t;
            now.pose = now.pose.interpolate(&motion.to, t);
        }
        now.opening = if now.moment == 0.0 {
            now.target
        } else {
            let (jaws, tissue) = (tool.jaw_stiffness, now.stiffness);
            let moments = jaws * now.target + now.moment + tissue * self.before.opening;
            // Closed jaws hold each other up.
            let closed = now.target.min(0.0);
            let least = match now.grasped > 0.0 && !tool.cuts {
                true => closed.max((SQUEEZED * now.grasped).min(self.before.opening)),
                false => closed,
            };
            (moments / (jaws + tissue)).max(least)
        };
    }

    /// Goes less far, or back, where the hand would have to push harder than `most` \[N\].
    fn hold_back(&mut self, most: f64) {
        let force = self.now.push.norm();
        if force == 0.0 || most == f64::INFINITY {
            return;
        }
        let back = self.now.push / force;
        let advance = (self.before.pose.position - self.now.pose.position).dot(&back);
        let room = ((most - force) / self.now.resistance).max(-RETREAT);
        if advance > room {
            self.now.pose.position += back * (advance - room);
            self.is_straight = false;
        }
    }

    /// Takes over the contact forces of a step: what the tool pushes against is as stiff as it has shown.
    fn feel(&mut self) {
        let push = std::mem::take(&mut self.push);
        let force = push.norm();
        let now = &mut self.now;
        if force < FELT {
            now.resistance = RESISTANCE[0];
        } else {
            let back = push / force;
            let advance = (self.before.pose.position - now.pose.position).dot(&back);
            if advance.abs() > SHIFTED {
                let secant = (force - now.push.dot(&back)) / advance;
                let least = (0.5 * now.resistance).max(RESISTANCE[0]);
                now.resistance = secant.clamp(least, RESISTANCE[1]);
            }
        }
        now.push = push;
    }

    /// The motions of its capsules in a step.
    fn capsules(&self, tool: &Tool, [from, to, parts]: [u32; 3]) -> Vec<CapsuleMotion> {
        let unbent =
            [&self.before, &self.now].map(|placement| placement.opening == placement.target);
        if self.is_straight && unbent == [true; 2] {
            let t = |part: u32| f64::from(part) / f64::from(parts);
            return tool.step(&self.motion, t(from), t(to));
        }
        let motion = ToolMotion {
            from: self.before.pose,
            to: self.now.pose,
            opening_from: self.before.opening,
            opening_to: self.now.opening,
            ..self.motion
        };
        tool.step(&motion, 0.0, 1.0)
    }

    /// Its capsules at the start and at the end of the step.
    fn ends(&self, tool: &Tool) -> Vec<[Capsule; 2]> {
        let [before, now] = [&self.before, &self.now]
            .map(|placement| tool.capsules_of(&placement.pose, placement.opening));
        before.zip(now).map(|(before, now)| [before, now]).collect()
    }

    /// Yields by `shift` \[m\] where something pushes a capsule at `place` \[m\]: its jaws open where that is how the jaw yields.
    fn yield_by(&mut self, tool: &Tool, capsule: u32, place: &Vector3<f64>, shift: &Vector3<f64>) {
        let path = tool.path_of_opening(capsule, &self.now.pose, place);
        let along = path.dot(shift);
        let opens = tool.jaw_stiffness.is_finite() && along > 0.5 * path.norm() * shift.norm();
        if opens {
            self.now.opening += shift.norm_squared() / along;
        } else {
            self.now.pose.position += shift;
            self.is_straight = false;
        }
    }
}

/// Two capsules of different tools that overlap at the end of a step.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Overlap {
    capsules: [u32; 2],
    /// Where, on the axes \[m\].
    places: [Vector3<f64>; 2],
    /// From the second to the first.
    normal: Vector3<f64>,
    depth: f64,
}

impl Overlap {
    /// Of two capsules, each at the start and at the end of a step; `None` where they are apart on the side on which they were.
    fn of(both: [&[Capsule; 2]; 2], capsules: [u32; 2]) -> Option<Self> {
        let [a, b] = both.map(|ends| ends[0].bounds().union(&ends[1].bounds()));
        if !a.overlaps(&b) {
            return None;
        }
        let reach = both[0][0].radius + both[1][0].radius;
        let axes = both.map(|[before, now]| Motion {
            start: [before.a, before.b],
            end: [now.a, now.b],
        });
        let contact = first_contact_edges(&axes[0], &axes[1], reach)?;
        let normal = contact.normal?;
        let [[p, q], [r, s]] = [axes[0].end, axes[1].end];
        let closest = closest_segments(&p, &q, &r, &s);
        let apart = closest.first.point - closest.second.point;
        let distance = apart.norm();
        if apart.dot(&normal) > 0.0 {
            // On the side on which they were.
            return (distance < reach).then(|| Self {
                capsules,
                places: [closest.first.point, closest.second.point],
                normal: apart / distance,
                depth: reach - distance,
            });
        }
        let place = |[a, b]: [Vector3<f64>; 2], weights: [f64; 2]| a * weights[0] + b * weights[1];
        let places = [place([p, q], contact.first), place([r, s], contact.second)];
        let depth = reach - (places[0] - places[1]).dot(&normal);
        (depth > 0.0).then_some(Self {
            capsules,
            places,
            normal,
            depth,
        })
    }
}
