//! Push a clamped strip of tissue to a marked depth and hold it there. The thin end of tissue and contact: what it
//! judges by comes from the physics plugin alone, as snapshots of the nodes and forces in newtons.
//!
//! One mark after the other is the current one: orange, yellow while the depth is right, red when it is too deep, green
//! when done. Marks move with the tissue.

use microsim_sdk::message::{
    Colour, ContactForces, LocalText, ObjectSet, Pose, TISSUE_SNAPSHOT, ToolStates, ToolStatus,
    decode_bytes, encode,
};
use microsim_sdk::{
    BlockView, Course, CourseConfig, Fault, Plugin, Services, Setup, Tick, export_plugin,
};
use microsim_training::{Dwell, DwellState};
use serde::{Deserialize, Serialize};

const WAITING: Colour = [0.55, 0.58, 0.60];
const CURRENT: Colour = [0.95, 0.50, 0.10];
const HOLDING: Colour = [0.98, 0.85, 0.15];
const TOO_DEEP: Colour = [0.85, 0.12, 0.12];
const DONE: Colour = [0.20, 0.70, 0.25];

/// Nodes within this share of the tissue's thickness from its top belong to the upper surface.
const TOP_LAYER: f64 = 0.25;

/// Share of its radius by which a mark's centre lies below the tissue's surface.
const SUNK: f64 = 0.7;

/// Objects of the level whose name starts so are marks.
const MARK: &str = "mark-";

/// The level's keys of this module.
#[derive(Clone, Debug, Deserialize)]
struct Keys {
    /// \[m\]
    depth: f64,
    /// \[m\]
    depth_tolerance: f64,
    /// \[s\]
    dwell: f64,
    /// \[m\]
    mark_radius: f64,
}

/// An object of the level.
#[derive(Clone, Debug, Deserialize)]
struct Mark {
    name: String,
    #[serde(default)]
    radius: f64,
    position: [f64; 3],
}

/// The tissue that belongs to a mark, by stable node ids.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Patch {
    nodes: Vec<u32>,
    /// Height of each node before the first touch \[m\].
    heights: Vec<f64>,
}

/// What evolves here besides the course.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct State {
    shown: bool,
    /// Whether the strip has been touched.
    touched: bool,
    patches: Vec<Patch>,
    current: usize,
    dwell: Dwell,
    colour: Colour,
    /// Greatest depth at the current mark so far \[m\].
    deepest: f64,
    peak_force: f64,
    overshoot: f64,
    /// Number of ticks and sum of depth errors \[m\], over all holding that counted.
    counted: (u64, f64),
    /// First tracked position of the tip \[m\].
    start: Option<[f64; 3]>,
}

/// The module.
#[derive(Debug, Default)]
pub struct PushStrip {
    course: Option<Course>,
    keys: Option<Keys>,
    marks: Vec<Mark>,
    body: String,
    tool: String,
    state: Option<State>,
}

/// Node positions of a snapshot \[m\].
fn position(positions: &[f64], node: usize) -> [f64; 3] {
    [
        positions[3 * node],
        positions[3 * node + 1],
        positions[3 * node + 2],
    ]
}

/// The nodes of the upper surface around a mark, as the tissue lies now.
fn patch(mark: &Mark, radius: f64, block: &BlockView<'_>) -> Option<Patch> {
    let (ids, positions) = (block.u32s("node_id")?, block.f64s("position")?);
    let near = |p: [f64; 3]| {
        let (x, y) = (p[0] - mark.position[0], p[1] - mark.position[1]);
        x * x + y * y <= radius * radius
    };
    let all: Vec<(u32, [f64; 3])> = ids
        .iter()
        .enumerate()
        .map(|(i, id)| (*id, position(positions, i)))
        .filter(|(_, p)| near(*p))
        .collect();
    let top = all
        .iter()
        .map(|(_, p)| p[2])
        .fold(f64::NEG_INFINITY, f64::max);
    let bottom = all.iter().map(|(_, p)| p[2]).fold(f64::INFINITY, f64::min);
    let highest: Vec<(u32, [f64; 3])> = all
        .into_iter()
        .filter(|(_, p)| top - p[2] <= TOP_LAYER * (top - bottom))
        .collect();
    Some(Patch {
        nodes: highest.iter().map(|(id, _)| *id).collect(),
        heights: highest.iter().map(|(_, p)| p[2]).collect(),
    })
}

/// Depth of the deepest node of a patch \[m\], and the mean place of its nodes \[m\].
fn depth(patch: &Patch, block: &BlockView<'_>) -> Option<(f64, [f64; 3])> {
    let (ids, positions) = (block.u32s("node_id")?, block.f64s("position")?);
    let mut deepest = f64::NEG_INFINITY;
    let (mut sum, mut found) = ([0.0; 3], 0_u32);
    for (id, height) in patch.nodes.iter().zip(&patch.heights) {
        // Ids are stable and ascending, whatever a cut does to their places.
        let Ok(node) = ids.binary_search(id) else {
            continue;
        };
        let p = position(positions, node);
        deepest = deepest.max(height - p[2]);
        sum = [sum[0] + p[0], sum[1] + p[1], sum[2] + p[2]];
        found += 1;
    }
    (found > 0).then(|| (deepest, sum.map(|s| s / f64::from(found))))
}

impl PushStrip {
    fn fresh_state(keys: &Keys) -> Result<State, Fault> {
        Ok(State {
            shown: false,
            touched: false,
            patches: Vec::new(),
            current: 0,
            dwell: Dwell::new(keys.dwell).map_err(|e| Fault::new(e.to_string()))?,
            colour: CURRENT,
            deepest: 0.0,
            peak_force: 0.0,
            overshoot: 0.0,
            counted: (0, 0.0),
            start: None,
        })
    }

    fn show(&self, tick: &mut Tick<'_>) {
        for (index, mark) in self.marks.iter().enumerate() {
            tick.publish(&ObjectSet {
                name: mark.name.clone(),
                active: Some(true),
                colour: Some(if index == 0 { CURRENT } else { WAITING }),
                pose: None,
            });
        }
    }

    /// One tick of the task: the tissue at the current mark against the depth asked for.
    fn judge(
        &self,
        state: &mut State,
        course: &mut Course,
        keys: &Keys,
        block: &BlockView<'_>,
        tick: &mut Tick<'_>,
    ) -> Result<(), Fault> {
        for (mark, patch) in self.marks.iter().zip(&state.patches) {
            if let Some((_, [x, y, z])) = depth(patch, block) {
                // Sunk so far that a cap shows around the tool that stands on it.
                let pose = Some(Pose {
                    position: [x, y, z - SUNK * mark.radius],
                    ..Pose::default()
                });
                tick.publish(&ObjectSet {
                    name: mark.name.clone(),
                    pose,
                    ..ObjectSet::default()
                });
            }
        }
        let Some(patch) = state
            .patches
            .get(state.current)
            .filter(|_| course.running())
        else {
            return Ok(());
        };
        let Some((depth, _)) = depth(patch, block) else {
            return Ok(());
        };
        state.deepest = state.deepest.max(depth);
        state.overshoot = state.overshoot.max(depth - keys.depth);
        let error = (depth - keys.depth).abs();
        let holds = error <= keys.depth_tolerance;
        if holds {
            state.counted = (state.counted.0 + 1, state.counted.1 + error);
        }
        let colour = match (holds, depth > keys.depth) {
            (true, _) => HOLDING,
            (false, true) => TOO_DEEP,
            (false, false) => CURRENT,
        };
        if state.dwell.update(tick.time(), holds) == DwellState::Complete {
            let n = state.current + 1;
            course.target_done(
                tick,
                &self.marks[state.current].name,
                LocalText {
                    de: format!("Marke {n} gehalten"),
                    en: format!("Mark {n} held"),
                },
            )?;
            self.colour(tick, state.current, DONE);
            state.current = n;
            state.dwell.reset();
            (state.deepest, state.colour) = (0.0, CURRENT);
            if n < self.marks.len() {
                self.colour(tick, n, CURRENT);
            }
        } else if colour != state.colour {
            state.colour = colour;
            self.colour(tick, state.current, colour);
        }
        Ok(())
    }

    fn colour(&self, tick: &mut Tick<'_>, mark: usize, colour: Colour) {
        let name = self.marks[mark].name.clone();
        tick.publish(&ObjectSet {
            name,
            colour: Some(colour),
            ..ObjectSet::default()
        });
    }

    /// A way that no run can undercut: straight from the start to the least depth that counts, anywhere within
    /// `mark_radius` of each mark in turn \[m\].
    fn shortest_path(&self, start: [f64; 3], keys: &Keys) -> f64 {
        let mut from = start;
        let mut margin = keys.mark_radius;
        let mut length = 0.0;
        for mark in &self.marks {
            let [x, y, z] = mark.position;
            let to = [x, y, z - (keys.depth - keys.depth_tolerance)];
            let d = [to[0] - from[0], to[1] - from[1], to[2] - from[2]];
            length += ((d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt() - margin).max(0.0);
            from = to;
            margin = 2.0 * keys.mark_radius;
        }
        length
    }

    /// Whether a tool touches the strip in this tick.
    fn is_touched(&self, tick: &Tick<'_>) -> Result<bool, Fault> {
        let forces = tick.messages::<ContactForces>()?;
        let mut contacts = forces.iter().flat_map(|f| &f.contacts);
        Ok(contacts.any(|c| c.body == self.body))
    }

    fn hear_forces(
        &self,
        state: &mut State,
        course: &Course,
        tick: &Tick<'_>,
    ) -> Result<(), Fault> {
        for forces in tick.messages::<ContactForces>()? {
            for contact in forces
                .contacts
                .iter()
                .filter(|c| course.running() && c.body == self.body)
            {
                let [x, y, z] = contact.force;
                state.peak_force = state.peak_force.max((x * x + y * y + z * z).sqrt());
            }
        }
        Ok(())
    }
}

/// Why the current mark was not done.
fn reason(state: &State, keys: &Keys) -> &'static str {
    if state.deepest < keys.depth - keys.depth_tolerance {
        "not-deep-enough"
    } else {
        "dwell-too-short"
    }
}

impl Plugin for PushStrip {
    fn new() -> Self {
        Self::default()
    }

    fn initialise(&mut self, setup: &Setup, _: Services) -> Result<(), Fault> {
        #[derive(Deserialize)]
        struct Named {
            name: String,
        }
        let config = CourseConfig::new(setup)?;
        let keys: Keys = serde_json::from_value(config.module.clone())?;
        let objects: Vec<Mark> = serde_json::from_value(setup.config["objects"].clone())?;
        let bodies: Vec<Named> = serde_json::from_value(setup.config["bodies"].clone())?;
        self.marks = objects
            .into_iter()
            .filter(|o| o.name.starts_with(MARK))
            .collect();
        if self.marks.is_empty() {
            return Err(Fault::new(format!(
                "the level needs an object whose name starts with \"{MARK}\""
            )));
        }
        let body = bodies
            .into_iter()
            .next()
            .ok_or_else(|| Fault::new("the level needs a body"))?;
        let tool = config
            .tools
            .first()
            .ok_or_else(|| Fault::new("the level needs a tool"))?;
        (self.body, self.tool) = (body.name, tool.name.clone());
        self.course = Some(Course::new(
            &config,
            self.marks.iter().map(|m| m.name.clone()).collect(),
        )?);
        self.state = Some(Self::fresh_state(&keys)?);
        self.keys = Some(keys);
        Ok(())
    }

    fn reset(&mut self) -> Result<(), Fault> {
        if let (Some(course), Some(keys)) = (&mut self.course, &self.keys) {
            course.reset()?;
            self.state = Some(Self::fresh_state(keys)?);
        }
        Ok(())
    }

    fn process(&mut self, tick: &mut Tick<'_>) -> Result<(), Fault> {
        let (Some(mut course), Some(mut state), Some(keys)) =
            (self.course.take(), self.state.take(), self.keys.clone())
        else {
            return Err(Fault::new("not initialised"));
        };
        course.hear(tick)?;
        if !state.shown {
            state.shown = true;
            self.show(tick);
        }
        state.touched |= self.is_touched(tick)?;
        if let Some(block) = tick.block(TISSUE_SNAPSHOT, &self.body) {
            // The strip sags under gravity when the run begins: depth counts from where it lies when it is first touched.
            if state.patches.is_empty() || !state.touched {
                let patches = self
                    .marks
                    .iter()
                    .map(|m| patch(m, keys.mark_radius, &block));
                state.patches = patches.map(Option::unwrap_or_default).collect();
                if let Some(empty) = state.patches.iter().position(|p| p.nodes.is_empty()) {
                    let name = &self.marks[empty].name;
                    return Err(Fault::new(format!(
                        "no tissue within `mark_radius` of \"{name}\""
                    )));
                }
            }
            self.judge(&mut state, &mut course, &keys, &block, tick)?;
        }
        self.hear_forces(&mut state, &course, tick)?;
        let tools = tick.latest::<ToolStates>()?.unwrap_or_default().tools;
        let tool = tools
            .iter()
            .find(|t| t.tool == self.tool && t.status == ToolStatus::Tracked);
        if let (true, None, Some(tool)) = (course.running(), state.start, tool) {
            state.start = Some(tool.pose.position);
            course.set_shortest_path(self.shortest_path(tool.pose.position, &keys));
        }
        // Without tissue there is nothing to measure, and nothing is not zero.
        if !state.patches.is_empty() {
            course.measure("peak-force", state.peak_force);
            course.measure("overshoot", state.overshoot);
        }
        if let (n @ 1.., errors) = state.counted {
            course.measure("depth-error", errors / n as f64);
        }
        let unfinished = state.current < self.marks.len();
        course.conclude(tick, |course| {
            if unfinished && state.start.is_some() {
                course.speaks_against(reason(&state, &keys));
            }
        })?;
        self.course = Some(course);
        self.state = Some(state);
        Ok(())
    }

    fn save(&self) -> Vec<u8> {
        let course = self.course.as_ref().map(Course::save).unwrap_or_default();
        encode(&(serde_bytes::ByteBuf::from(course), &self.state))
    }

    fn restore(&mut self, state: &[u8]) -> Result<(), Fault> {
        let (course, state): (serde_bytes::ByteBuf, Option<State>) = decode_bytes(state)?;
        if let Some(own) = &mut self.course {
            own.restore(&course)?;
        }
        self.state = state;
        Ok(())
    }
}

export_plugin!(PushStrip, "../module.toml");
