//! Push, grip or separate: when tissue gets over a line of no return (dissertation 4.4.3).
//!
//! The axis of a capsule can be a line of no return. The dissertation lets penalty forces push tissue into the capsule and asks how
//! deep it is; here contact keeps it outside exactly, so that what stands for depth is what contact would have to do:
//!
//! - A line of a tool that does not touch the body goes through it: an ideal blade.
//! - A single edge (`edge`) is held off until it presses on the tissue with more than toughness / sharpness per length. From then on it is in
//!   the tissue, which closes over the line and is cut by it (cases 1 and 2), until the capsule is free of tissue again. Its back is
//!   blunt: only forces within 60° of the edge count. Tissue that was not cut is pushed back by contact (case 2).
//! - Lines of two jaws cut where the gap between their capsules is below max(sharpness, brittleness) · (r₁ + r₂) (case 3): at the
//!   ends of the part that is closed, not along the whole blade. A place is open again when the gap has grown to half as much more
//!   (hysteresis).
//!
//! What is in a blade is not touched by it: contact with those parts of the capsules is left out, as long as they cut.

use crate::spec::Jaw;
use crate::tool::{Line, Tool, ToolMotion};
use crate::touching::GroupTouching;
use microsim_contact::{CapsuleMotion, Partner, Point};
use microsim_cutting::Stroke;
use nalgebra::Vector3;

/// Cosine of the angle around the edge within which a blade is sharp.
const SHARP_SIDE: f64 = 0.5;

/// Jaws are open again at this multiple of the gap at which they cut.
const REOPENED: f64 = 1.5;

/// How a tool cuts a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Ability {
    /// Force per length from which on a single edge cuts [N/m]; infinite for never.
    pub line_force: f64,
    /// Gap between jaws, as a share of the sum of their radii, below which they cut.
    pub pinch: f64,
    /// Whether the two do not touch, so that lines go through.
    pub free: bool,
}

impl Ability {
    pub fn new(sharpness: f64, toughness: f64, brittleness: f64, free: bool) -> Self {
        Self {
            line_force: if sharpness > 0.0 {
                toughness / sharpness
            } else {
                f64::INFINITY
            },
            pinch: sharpness.max(brittleness),
            free,
        }
    }
}

/// What is remembered of a tool that cuts a body.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct BladeMemory {
    /// Capsules whose single edge is in the tissue, ascending.
    pub inside: Vec<u32>,
    /// Per couple of jaws' lines, in their order: the part along the lines, from 0 (`a`) to 1 (`b`), that is closed.
    pub closed: Vec<Option<[f64; 2]>>,
    /// What is under way, per line.
    pub strokes: Vec<(u32, Stroke)>,
    /// Lines that leave the tissue in this tick; empty between ticks.
    pub leaving: Vec<u32>,
}

/// The way of a blade through the tissue: a segment before and after.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Path {
    /// The capsule whose axis it is; of the two ends of a part that is closed the left jaw's and the right one's.
    pub line: u32,
    pub from: [Vector3<f64>; 2],
    pub to: [Vector3<f64>; 2],
}

/// Part of a capsule that touches nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Passed {
    /// The body, by its place in its group.
    pub body: u32,
    pub tool: u32,
    pub capsule: u32,
    /// Range along the axis, from 0 to 1; all of it if it goes beyond.
    pub range: [f64; 2],
}

impl Passed {
    /// Whether a point of contact at the share `way` of the tools' motion is of this part.
    pub fn has(&self, point: &Point, tools: &[Option<Vec<CapsuleMotion>>], way: f64) -> bool {
        let partner = Partner::Tool {
            tool: self.tool,
            capsule: self.capsule,
        };
        if point.key.body != self.body || point.key.partner != partner {
            return false;
        }
        let capsules = tools.get(self.tool as usize).and_then(Option::as_ref);
        let Some(motion) = capsules.and_then(|all| all.get(self.capsule as usize)) else {
            return false;
        };
        let [a, b] = [
            motion.start.a.lerp(&motion.end.a, way),
            motion.start.b.lerp(&motion.end.b, way),
        ];
        let along = (point.place - a).dot(&(b - a)) / (b - a).norm_squared();
        self.range[0] <= along && along <= self.range[1]
    }
}

/// What single edges press with over a tick.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct EdgeLoads(Vec<EdgeLoad>);

#[derive(Clone, Copy, Debug, PartialEq)]
struct EdgeLoad {
    at: Touched,
    /// On the sharp side [N·s].
    impulse: f64,
    /// Range of the points along the axis [m].
    range: [f64; 2],
}

/// A capsule at a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Touched {
    pub group: usize,
    /// The body, by its place in its group.
    pub body: u32,
    pub tool: u32,
    pub capsule: u32,
}

impl EdgeLoads {
    /// Adds the contacts that a step of `h` [s] of a group ended with. `edges` are the single edges: tool and line.
    pub fn add(
        &mut self,
        group: usize,
        touching: &GroupTouching,
        tools: &[Option<Vec<CapsuleMotion>>],
        edges: &[(u32, Line)],
        h: f64,
    ) {
        for (point, contact) in touching.points.iter().zip(&touching.contacts) {
            let Partner::Tool { tool, capsule } = point.key.partner else {
                continue;
            };
            let line = edges
                .iter()
                .find(|(t, line)| (*t, line.capsule) == (tool, capsule));
            let edge = line.and_then(|(_, line)| line.edge);
            let motion = tools[tool as usize].as_ref();
            let (Some(edge), Some(motion)) = (edge, motion.map(|all| all[capsule as usize])) else {
                continue;
            };
            let share = contact.normal.dot(&edge);
            if contact.pressure <= 0.0 || share < SHARP_SIDE {
                continue;
            }
            let axis = motion.end.b - motion.end.a;
            let along = (point.place - motion.end.a).dot(&axis) / axis.norm();
            let at = Touched {
                group,
                body: point.key.body,
                tool,
                capsule,
            };
            let impulse = contact.pressure * share * h;
            match self.0.iter_mut().find(|load| load.at == at) {
                Some(load) => {
                    load.impulse += impulse;
                    load.range = [load.range[0].min(along), load.range[1].max(along)];
                }
                None => self.0.push(EdgeLoad {
                    at,
                    impulse,
                    range: [along; 2],
                }),
            }
        }
    }

    /// Mean force per length of an edge over a time [N/m]; the length is at least `least` [m].
    fn per_length(&self, at: Touched, time: f64, least: f64) -> f64 {
        let load = self.0.iter().find(|load| load.at == at);
        load.map_or(0.0, |load| {
            load.impulse / time / (load.range[1] - load.range[0]).max(least)
        })
    }
}

/// The tool, the body (by its place in its group) and the time of a decision.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Case<'a> {
    pub tool: &'a Tool,
    pub motion: &'a ToolMotion,
    /// The group and, by its place in it, the body.
    pub at: (usize, u32),
    pub ability: Ability,
    /// Mean edge of the body [m].
    pub edge: f64,
    /// [s]
    pub tick: f64,
    pub loads: &'a EdgeLoads,
    /// Capsules of the tool that still reach into the tissue.
    pub reach: &'a [u32],
}

impl BladeMemory {
    /// Decides what a tick has brought over a line: the ways that cut, in order.
    pub fn decide(&mut self, case: &Case<'_>) -> Vec<Path> {
        let lines = [0.0, 1.0].map(|t| case.tool.lines(case.motion, t));
        let both = || lines[0].iter().zip(&lines[1]);
        let straight = |(from, to): (&Line, &Line)| Path {
            line: to.capsule,
            from: [from.a, from.b],
            to: [to.a, to.b],
        };
        if case.ability.free {
            return both().map(straight).collect();
        }
        let mut paths = Vec::new();
        for (from, to) in both().filter(|(_, to)| to.edge.is_some()) {
            match self.inside.binary_search(&to.capsule) {
                Ok(place) => {
                    // Tissue may have sprung over the line and be gone at the end.
                    paths.push(straight((from, to)));
                    if !case.reach.contains(&to.capsule) {
                        self.inside.remove(place);
                        self.leaving.push(to.capsule);
                    }
                }
                Err(place) => {
                    let at = Touched {
                        group: case.at.0,
                        body: case.at.1,
                        tool: case.motion.tool as u32,
                        capsule: to.capsule,
                    };
                    let force = case.loads.per_length(at, case.tick, case.edge);
                    if force >= case.ability.line_force {
                        self.inside.insert(place, to.capsule);
                    }
                }
            }
        }
        if case.ability.pinch > 0.0 {
            self.close(&lines, case.ability.pinch, &mut paths);
        }
        paths
    }

    /// Adds the ways of closing points: of each couple both ends of the part that is closed, which grows as the jaws close and is swept along
    /// with them.
    fn close(&mut self, lines: &[Vec<Line>; 2], pinch: f64, paths: &mut Vec<Path>) {
        let couples = [couples(&lines[0]), couples(&lines[1])];
        self.closed.resize(couples[0].len(), None);
        for (index, (from, to)) in couples[0].iter().zip(&couples[1]).enumerate() {
            let reach = pinch * (to[0].radius + to[1].radius);
            // What has opened again is closed no more.
            let open = to.closed_part(REOPENED * reach);
            let before = self.closed[index].zip(open).and_then(|(closed, still)| {
                let part = [closed[0].max(still[0]), closed[1].min(still[1])];
                (part[0] <= part[1]).then_some(part)
            });
            let now = match (before, to.closed_part(reach)) {
                (Some(before), Some(now)) => Some([before[0].min(now[0]), before[1].max(now[1])]),
                (before, now) => before.or(now),
            };
            let lines = [0, 1].map(|end| to[end].capsule);
            if let Some(now) = now {
                // What closes for the first time does so from one end to the other.
                let starts = before.unwrap_or([now[0], now[0]]);
                let ends = if before.is_some() { &[0, 1][..] } else { &[1] };
                for &end in ends {
                    paths.push(Path {
                        line: lines[end],
                        from: from.across(starts[end]),
                        to: to.across(now[end]),
                    });
                }
            } else if self.closed[index].is_some() {
                self.leaving.extend(lines);
            }
            self.closed[index] = now;
        }
    }

    /// The stroke of a line, a new one where none is under way.
    pub fn stroke(&mut self, line: u32) -> &mut Stroke {
        let place = self.strokes.iter().position(|(of, _)| *of == line);
        let place = place.unwrap_or_else(|| {
            self.strokes.push((line, Stroke::new()));
            self.strokes.len() - 1
        });
        &mut self.strokes[place].1
    }

    /// Ends the strokes of the lines that have left the tissue in this tick, once all is cut.
    pub fn leave(&mut self) {
        let leaving = std::mem::take(&mut self.leaving);
        leaving.into_iter().for_each(|line| self.end_stroke(line));
    }

    /// A line has left the tissue.
    pub fn end_stroke(&mut self, line: u32) {
        self.strokes.retain(|(of, _)| *of != line);
    }

    /// The parts of a tool's capsules that touch nothing, as what they cut lies around them.
    pub fn passed(&self, body: u32, tool: u32, lines: &[Line]) -> Vec<Passed> {
        let part = |capsule, range| Passed {
            body,
            tool,
            capsule,
            range,
        };
        const ALL: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];
        let mut parts: Vec<Passed> = self.inside.iter().map(|&c| part(c, ALL)).collect();
        for (couple, closed) in couples(lines).iter().zip(&self.closed) {
            let cuts = |jaw: usize| {
                let of_line = |(line, stroke): &&(u32, Stroke)| {
                    *line == couple[jaw].capsule && stroke.sheet != 0
                };
                self.strokes.iter().any(|stroke| of_line(&stroke))
            };
            // Jaws that have closed on nothing are as solid as before.
            if let (Some([first, last]), true) = (*closed, cuts(0) || cuts(1)) {
                // Closed to an end the cap of the capsule there is passed too.
                let first = if first <= 0.0 {
                    f64::NEG_INFINITY
                } else {
                    first
                };
                let last = if last >= 1.0 { f64::INFINITY } else { last };
                let range = [first, last];
                parts.extend([0, 1].map(|jaw| part(couple[jaw].capsule, range)));
            }
        }
        parts
    }
}

/// Lines of both jaws that cut against each other.
#[derive(Clone, Copy, Debug)]
struct Couple<'a>([&'a Line; 2]);

impl std::ops::Index<usize> for Couple<'_> {
    type Output = Line;

    fn index(&self, jaw: usize) -> &Line {
        self.0[jaw]
    }
}

/// The first line of the left jaw with the first of the right one, and so on; single edges are in no couple.
fn couples(lines: &[Line]) -> Vec<Couple<'_>> {
    let of = |jaw| {
        lines
            .iter()
            .filter(move |line| line.jaw == Some(jaw) && line.edge.is_none())
    };
    let both = of(Jaw::Left).zip(of(Jaw::Right));
    both.map(|(left, right)| Couple([left, right])).collect()
}

impl Couple<'_> {
    /// The lines' points at a place along them.
    fn points(&self, along: f64) -> [Vector3<f64>; 2] {
        self.0.map(|line| line.a.lerp(&line.b, along))
    }

    /// Between the capsules at a place along them [m].
    fn gap(&self, along: f64) -> f64 {
        let [left, right] = self.points(along);
        (left - right).norm() - self[0].radius - self[1].radius
    }

    /// The part along which the gap is below `reach` [m]; `None` if it is nowhere. The distance of two points that move linearly is convex,
    /// so it is one part.
    fn closed_part(&self, reach: f64) -> Option<[f64; 2]> {
        let [left, right] = [self.points(0.0), self.points(1.0)];
        let (start, turn) = (
            left[1] - left[0],
            (right[1] - right[0]) - (left[1] - left[0]),
        );
        let square = turn.norm_squared();
        let nearest = if square > 0.0 {
            (-start.dot(&turn) / square).clamp(0.0, 1.0)
        } else {
            0.0
        };
        if self.gap(nearest) >= reach {
            return None;
        }
        let bound = |end: f64| {
            if self.gap(end) < reach {
                return end;
            }
            let (mut closed, mut open) = (nearest, end);
            for _ in 0..f64::MANTISSA_DIGITS {
                let middle = 0.5 * (closed + open);
                match self.gap(middle) < reach {
                    true => closed = middle,
                    false => open = middle,
                }
            }
            closed
        };
        Some([bound(0.0), bound(1.0)])
    }

    /// The segment from beyond one line to beyond the other at a place along them: as far as their capsules reach.
    fn across(&self, along: f64) -> [Vector3<f64>; 2] {
        let [left, right] = self.points(along);
        let way = right - left;
        let length = way.norm();
        if length == 0.0 {
            return [left, right];
        }
        let way = way / length;
        [left - way * self[0].radius, right + way * self[1].radius]
    }
}
