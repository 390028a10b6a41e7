//! Push, grip or separate: when tissue gets over a line of no return (dissertation 4.4.3).
//!
//! The axis of a capsule can be a line of no return. The dissertation lets penalty forces push tissue into the capsule and asks how
//! deep it is; here contact holds it outside exactly, so that in place of depth there is what contact would have to do:
//!
//! - A line of a tool that does not touch the body goes through it: an ideal blade.
//! - A single edge (`edge`) is held off until it presses on the tissue with more than toughness / sharpness per length. From then on it is in
//!   the tissue, which closes over the line and is cut by it (cases 1 and 2), until the capsule is free of tissue again. Its back is
//!   blunt: only forces within 60° of the edge count. Tissue that was not cut is pushed back by contact (case 2).
//! - Lines of two jaws ([`Jaws`]) cut where the gap between their capsules is below max(sharpness, brittleness) · (r₁ + r₂) (case 3): at the
//!   ends of the part that is closed, not along the whole blade. A place is open again when the gap has grown to half as much more
//!   (hysteresis).
//!
//! The dissertation's own rule is there as well ([`CutTrigger::Penetration`]): with penalties or forces of single nodes tissue does come into a capsule, and
//! what passes its line is cut, of one jaw alone too (cases 1 and 2), unless it moves back towards the line (the rule of the velocities' sign).
//!
//! What is in a blade is not touched by it: contact with those parts of the capsules is left out, as long as they cut.

use crate::exemption::Exemption;
use crate::group_contact::GroupContact;
use crate::jaws::{self, Jaws};
use crate::spec::CutTrigger;
use crate::tool::{Lonor, Tool, ToolMotion};
use microsim_contact::{CapsuleMotion, Partner};
use microsim_cutting::{Stroke, Sweep};

/// Cosine of the angle around the edge within which a blade is sharp.
const SHARP_SIDE: f64 = 0.5;

/// Jaws are open again at this multiple of the gap at which they cut.
const REOPENED: f64 = 1.5;

/// How a tool cuts a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Ability {
    /// Force per length from which on a single edge cuts \[N/m\]; infinite for never.
    pub line_force: f64,
    /// Gap between jaws, relative to the sum of their radii, below which they cut.
    pub pinch: f64,
    /// Whether the two do not touch, so that lines go through.
    pub free: bool,
    /// What cuts where the two touch.
    pub trigger: CutTrigger,
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
            trigger: CutTrigger::Force,
        }
    }

    /// The same with another trigger.
    pub fn by(self, trigger: CutTrigger) -> Self {
        Self { trigger, ..self }
    }
}

/// State of a tool that cuts a body.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct BladeState {
    /// Capsules whose single edge is in the tissue, ascending.
    pub inside: Vec<u32>,
    /// Per couple of jaws' lines, in their order: the part along the lines, from 0 (`a`) to 1 (`b`), that is closed.
    pub closed: Vec<Option<[f64; 2]>>,
    /// What is in progress, per line; of jaws there is one, by the left one's first line.
    pub strokes: Vec<(u32, Stroke)>,
    /// Lines that leave the tissue in this tick; empty between ticks.
    pub leaving: Vec<u32>,
}

/// The path of a blade through the tissue.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Path {
    /// The capsule whose axis it is; of jaws the left one's first.
    pub line: u32,
    /// Of a line itself, or of all closing points of jaws.
    pub sweeps: Vec<Sweep>,
    /// Of jaws, what was closed before.
    pub closed: Option<Vec<Option<[f64; 2]>>>,
}

/// What single edges press with over a tick.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct EdgeLoads(Vec<EdgeLoad>);

#[derive(Clone, Copy, Debug, PartialEq)]
struct EdgeLoad {
    at: Touched,
    /// On the sharp side \[N·s\].
    impulse: f64,
    /// Range of the points along the axis \[m\].
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
    /// Adds the contacts that a step of `h` \[s\] of a group ended with. `edges` are the single edges: tool and line.
    pub fn add(
        &mut self,
        group: usize,
        of: &GroupContact,
        tools: &[Option<Vec<CapsuleMotion>>],
        edges: &[(u32, Lonor)],
        h: f64,
    ) {
        for (point, contact) in of.points.iter().zip(&of.contacts) {
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
            let cosine = contact.normal.dot(&edge);
            if contact.normal_force <= 0.0 || cosine < SHARP_SIDE {
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
            let impulse = contact.normal_force * cosine * h;
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

    /// Mean force per length of an edge over a time \[N/m\]; the length is at least `least` \[m\].
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
    /// Mean edge of the body \[m\].
    pub edge: f64,
    /// \[s\]
    pub tick: f64,
    pub loads: &'a EdgeLoads,
    /// Capsules of the tool that still reach into the tissue.
    pub reach: &'a [u32],
}

impl BladeState {
    /// Decides what a tick has brought over a line: the paths that cut, in order.
    pub fn decide(&mut self, case: &Case<'_>) -> Vec<Path> {
        let lines = [0.0, 1.0].map(|t| case.tool.lines(case.motion, t));
        let both = || lines[0].iter().zip(&lines[1]);
        let straight = |(from, to): (&Lonor, &Lonor)| Path {
            line: to.capsule,
            sweeps: vec![Sweep {
                before: [from.a, from.b],
                now: [to.a, to.b],
            }],
            closed: None,
        };
        if case.ability.free {
            return both().map(straight).collect();
        }
        let mut paths = Vec::new();
        if case.ability.trigger == CutTrigger::Penetration {
            paths.extend(both().map(straight));
            if case.ability.pinch > 0.0 {
                self.close(&lines, case.ability.pinch, &mut paths);
            }
            return paths;
        }
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

    /// Adds the path of the closing points: both ends of each part that is closed, which grows as the jaws close and is swept along with them.
    fn close(&mut self, lines: &[Vec<Lonor>; 2], pinch: f64, paths: &mut Vec<Path>) {
        let jaws = [Jaws::new(&lines[0]), Jaws::new(&lines[1])];
        let Some(line) = jaws[1].line() else {
            return;
        };
        // What has opened again is closed no more.
        let open = jaws[1].closed(pinch * REOPENED);
        self.closed.resize(open.len(), None);
        let still = self.closed.iter().zip(open).map(|(closed, open)| {
            let (closed, open) = (closed.as_ref()?, open?);
            let part = [closed[0].max(open[0]), closed[1].min(open[1])];
            (part[0] <= part[1]).then_some(part)
        });
        let before: Vec<_> = still.collect();
        let both = before.iter().zip(jaws[1].closed(pinch));
        let now: Vec<_> = both
            .map(|(before, now)| match (*before, now) {
                (Some(before), Some(now)) => Some([before[0].min(now[0]), before[1].max(now[1])]),
                (before, now) => before.or(now),
            })
            .collect();
        // Jaws that stay as they are cut what is drawn over their ends, as long as what they have cut lies around them; else they are solid.
        if now != before || self.is_under_way(line) {
            let parts = [&self.closed, &before, &now].map(|parts| jaws::parts(parts));
            let sweeps = jaws::sweeps(&jaws, &parts);
            if !sweeps.is_empty() {
                let closed = Some(self.closed.clone());
                paths.push(Path {
                    line,
                    sweeps,
                    closed,
                });
            }
        }
        let none = |parts: &[Option<_>]| parts.iter().all(Option::is_none);
        if none(&now) && !none(&self.closed) {
            self.leaving.push(line);
        }
        self.closed = now;
    }

    /// The lines of all strokes in progress.
    pub fn lines(&self) -> Vec<u32> {
        self.strokes.iter().map(|(line, _)| *line).collect()
    }

    /// The stroke of a line, a new one where none is in progress.
    pub fn stroke(&mut self, line: u32) -> &mut Stroke {
        let place = self.strokes.iter().position(|(of, _)| *of == line);
        let place = place.unwrap_or_else(|| {
            self.strokes.push((line, Stroke::new()));
            self.strokes.len() - 1
        });
        &mut self.strokes[place].1
    }

    /// A path that was not cut: jaws go on from what was closed before it, so that the next one holds it.
    pub fn revert(&mut self, path: Path) {
        if let Some(closed) = path.closed {
            self.closed = closed;
            self.leaving.retain(|line| *line != path.line);
        }
    }

    /// Whether a line has cut something and is not clear of it.
    fn is_under_way(&self, line: u32) -> bool {
        let of_line = |(of, stroke): &(u32, Stroke)| *of == line && stroke.sheet != 0;
        self.strokes.iter().any(of_line)
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

    /// The parts of a tool's capsules that touch nothing, as what they cut lies around them; of jaws that are clear of it or have closed on nothing, what would be pressed from one to the
    /// other: what is between closed blades is cut.
    pub fn exemptions(&self, body: u32, tool: u32, lines: &[Lonor]) -> Vec<Exemption> {
        let part = |capsule, range, towards| Exemption {
            body,
            tool,
            capsule,
            range,
            towards,
        };
        const ALL: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];
        let inside = self.inside.iter().map(|&c| part(c, ALL, None));
        let mut parts: Vec<Exemption> = inside.collect();
        let jaws = Jaws::new(lines);
        let Some(line) = jaws.line() else {
            return parts;
        };
        let is_under_way = self.is_under_way(line);
        for (capsules, closed) in jaws.capsules().zip(&self.closed) {
            let Some([first, last]) = *closed else {
                continue;
            };
            // Closed to an end the cap of the capsule there is passed too.
            let first = if first <= 0.0 {
                f64::NEG_INFINITY
            } else {
                first
            };
            let last = if last >= 1.0 { f64::INFINITY } else { last };
            for (capsule, other) in [(capsules[0], capsules[1]), (capsules[1], capsules[0])] {
                let towards = (!is_under_way).then_some(other);
                parts.push(part(capsule, [first, last], towards));
            }
        }
        parts
    }
}
