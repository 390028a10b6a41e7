//! Push a clamped strip of tissue to a marked depth and hold it there; or pick its free end up with two forceps and hold it in a
//! ring; or cut it at the mark and put the piece into a tray. The thin end of tissue, contact and cutting: what it judges by comes
//! from the physics plugin alone, as snapshots of the nodes, forces in newtons and cuts.
//!
//! One mark after the other is the current one: orange, yellow while it is held right, red when it is too deep, green when done.
//! Marks move with the tissue.

mod cut;
mod patch;
mod task;

use cut::{Progress, Site, TRAY};

use microsim_sdk::message::{
    Colour, ContactForce, ContactForces, LocalText, ObjectSet, Pose, TISSUE_SNAPSHOT, TissueCut,
    ToolStates, ToolStatus, decode_bytes, encode,
};
use microsim_sdk::{
    BlockView, Course, CourseConfig, Fault, Plugin, Services, Setup, Tick, Tray, export_plugin,
};
use microsim_training::{Dwell, DwellState};
use patch::Patch;
use serde::{Deserialize, Serialize};
use task::{CURRENT, DONE, HOLDING, Keys, Ring, Task, TaskName, WAITING, distance};

/// Share of its radius by which a mark's centre lies below the tissue's surface.
const SUNK: f64 = 0.7;

/// Objects of the level whose name starts so are marks.
const MARK: &str = "mark-";

/// The object of the level that is the ring.
const RING: &str = "ring";

/// An object of the level.
#[derive(Clone, Debug, Deserialize)]
struct Object {
    name: String,
    #[serde(default)]
    radius: f64,
    #[serde(default)]
    tube: f64,
    position: [f64; 3],
    #[serde(default = "unturned")]
    orientation: [f64; 4],
}

fn unturned() -> [f64; 4] {
    Pose::default().orientation
}

/// What evolves here besides the course.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct State {
    shown: bool,
    /// Whether the strip has been touched.
    touched: bool,
    patches: Vec<Patch>,
    /// Number of targets done, and so the current one.
    current: usize,
    dwell: Dwell,
    colour: Colour,
    /// Whether the current mark has counted as held at any time.
    reached: bool,
    /// Greatest depth at the current mark so far \[m\].
    deepest: f64,
    peak_force: f64,
    peak_grip: f64,
    overshoot: f64,
    /// Number of ticks and sum of distances from what is asked for \[m\], over all holding that counted.
    counted: (u64, f64),
    /// Whether every tool that can hold the tissue had it in the last tick, and how often one lost it.
    held: bool,
    drops: u32,
    /// Of the task `cut`; whether anything of the strip touched the tray in the last tick.
    progress: Progress,
    on_tray: bool,
    /// First tracked position of the tip \[m\].
    start: Option<[f64; 3]>,
}

/// The module.
#[derive(Debug, Default)]
pub struct PushStrip {
    course: Option<Course>,
    keys: Option<Keys>,
    task: Option<Task>,
    marks: Vec<Object>,
    targets: Vec<String>,
    body: String,
    /// Those that hold tissue and do not cut it.
    tools: Vec<String>,
    state: Option<State>,
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
            reached: false,
            deepest: 0.0,
            peak_force: 0.0,
            peak_grip: 0.0,
            overshoot: 0.0,
            counted: (0, 0.0),
            held: false,
            drops: 0,
            progress: Progress::default(),
            on_tray: false,
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

    /// Lets marks move with the tissue.
    fn move_marks(&self, state: &State, block: &BlockView<'_>, tick: &mut Tick<'_>) {
        for (mark, patch) in self.marks.iter().zip(&state.patches) {
            if let Some((_, [x, y, z])) = patch.now(block) {
                // Sunk so far that a cap shows around the tool that stands on it.
                let pose = Some(Pose {
                    position: [x, y, z - SUNK * mark.radius],
                    orientation: mark.orientation,
                });
                tick.publish(&ObjectSet {
                    name: mark.name.clone(),
                    pose,
                    ..ObjectSet::default()
                });
            }
        }
    }

    /// One tick of a task at marks: the tissue at the current one against what is asked for.
    fn judge(
        &self,
        state: &mut State,
        course: &mut Course,
        task: &Task,
        block: &BlockView<'_>,
        tick: &mut Tick<'_>,
    ) -> Result<(), Fault> {
        let Some(patch) = state
            .patches
            .get(state.current)
            .filter(|_| course.running())
        else {
            return Ok(());
        };
        let Some((depth, place)) = patch.now(block) else {
            return Ok(());
        };
        state.deepest = state.deepest.max(depth);
        if let Task::Push { depth: wanted, .. } = task {
            state.overshoot = state.overshoot.max(depth - wanted);
        }
        let Some(standing) = task.standing(depth, place, state.held) else {
            return Ok(());
        };
        let (holds, colour) = (standing.holds, standing.colour);
        if holds {
            state.reached = true;
            state.counted = (state.counted.0 + 1, state.counted.1 + standing.error);
        }
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
            (state.deepest, state.reached, state.colour) = (0.0, false, CURRENT);
            if n < self.marks.len() {
                self.colour(tick, n, CURRENT);
            }
        } else if colour != state.colour {
            state.colour = colour;
            self.colour(tick, state.current, colour);
        }
        Ok(())
    }

    /// One tick of the task `cut`.
    fn judge_cut(
        &self,
        state: &mut State,
        course: &mut Course,
        site: &Site,
        block: &BlockView<'_>,
        tick: &mut Tick<'_>,
    ) -> Result<(), Fault> {
        if !course.running() {
            return Ok(());
        }
        for cut in tick.messages::<TissueCut>()? {
            if cut.body == self.body {
                state.progress.hear(&cut, site);
            }
        }
        state.progress.look(block, site);
        if state.current == 0 && state.progress.off {
            (state.current, state.colour) = (1, WAITING);
            let said = LocalText {
                de: "Stück abgeschnitten".into(),
                en: "Piece cut off".into(),
            };
            course.target_done(tick, &self.marks[0].name, said)?;
            tick.publish(&ObjectSet {
                name: self.marks[0].name.clone(),
                active: Some(false),
                ..ObjectSet::default()
            });
        }
        state.drops += u32::from(state.progress.dropped(state.held));
        let lies = state.progress.inside && state.on_tray && !state.held;
        let mut colour = if lies { HOLDING } else { CURRENT };
        if state.current == 1 && state.dwell.update(tick.time(), lies) == DwellState::Complete {
            state.current = 2;
            let said = LocalText {
                de: "Stück liegt in der Schale".into(),
                en: "Piece lies in the tray".into(),
            };
            course.target_done(tick, TRAY, said)?;
        }
        if state.current == 2 {
            colour = DONE;
        }
        if state.current > 0 && colour != state.colour {
            state.colour = colour;
            tick.publish(&ObjectSet {
                name: TRAY.into(),
                colour: Some(colour),
                ..ObjectSet::default()
            });
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

    /// A way of the tip that no run can undercut: straight from the start to the least depth that counts, anywhere within
    /// `mark_radius` of each mark in turn \[m\].
    fn shortest_path(&self, start: [f64; 3], depth: f64, radius: f64) -> f64 {
        let mut from = start;
        let mut margin = radius;
        let mut length = 0.0;
        for mark in &self.marks {
            let [x, y, z] = mark.position;
            let to = [x, y, z - depth];
            length += (distance(from, to) - margin).max(0.0);
            from = to;
            margin = 2.0 * radius;
        }
        length
    }

    /// What the tools do to the strip in this tick.
    fn hear_forces(
        &self,
        state: &mut State,
        course: &Course,
        tick: &Tick<'_>,
    ) -> Result<(), Fault> {
        let forces = tick.messages::<ContactForces>()?;
        let contacts: Vec<&ContactForce> = forces
            .iter()
            .flat_map(|forces| &forces.contacts)
            .filter(|contact| contact.body == self.body)
            .collect();
        state.touched |= !contacts.is_empty();
        let held = self
            .tools
            .iter()
            .all(|tool| contacts.iter().any(|c| c.tool == *tool && grip(c) > 0.0));
        if course.running() {
            let lost = state.held && !held && matches!(self.task, Some(Task::Hold(_)));
            state.drops += u32::from(lost);
            for contact in contacts {
                state.peak_force = state.peak_force.max(distance(contact.force, [0.0; 3]));
                if self.tools.contains(&contact.tool) {
                    state.peak_grip = state.peak_grip.max(grip(contact));
                }
            }
        }
        state.held = held;
        let between = forces.iter().flat_map(|forces| &forces.between);
        state.on_tray = between
            .filter(|contact| contact.body == self.body)
            .any(|contact| contact.tool == TRAY);
        Ok(())
    }
}

/// The force with which the jaws of a tool squeeze tissue \[N\]: that of the one that presses less, 0 where only one touches.
fn grip(contact: &ContactForce) -> f64 {
    match contact.jaws.as_slice() {
        [first, second] => first.force.min(second.force),
        _ => 0.0,
    }
}

/// Why the current mark was not done.
fn reason(state: &State, task: &Task) -> &'static str {
    match task {
        Task::Push { depth, tolerance } if state.deepest < depth - tolerance => "not-deep-enough",
        Task::Hold(_) if !state.reached => "not-in-ring",
        Task::Cut(_) if !state.progress.off => "not-cut",
        Task::Cut(_) => "not-in-tray",
        _ => "dwell-too-short",
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
        let objects: Vec<Object> = serde_json::from_value(setup.config["objects"].clone())?;
        let bodies: Vec<Named> = serde_json::from_value(setup.config["bodies"].clone())?;
        self.task = Some(match keys.task {
            TaskName::Push => Task::Push {
                depth: keys.depth,
                tolerance: keys.depth_tolerance,
            },
            TaskName::Hold => {
                let ring = objects.iter().find(|object| object.name == RING);
                let ring = ring.ok_or_else(|| {
                    Fault::new(format!("the task `hold` needs an object \"{RING}\""))
                })?;
                Task::Hold(Ring {
                    centre: ring.position,
                    opening: ring.radius - ring.tube,
                })
            }
            TaskName::Cut => Task::Cut(Site::new(&objects, Tray::named(setup, TRAY)?)?),
        });
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
        self.body = body.name;
        let cuts = |model: &str| config.models.get(model).is_some_and(|m| m.sharpness > 0.0);
        let holding = config.tools.iter().filter(|tool| !cuts(&tool.model));
        self.tools = holding.map(|tool| tool.name.clone()).collect();
        if self.tools.is_empty() {
            return Err(Fault::new("the level needs a tool"));
        }
        self.targets = self.marks.iter().map(|m| m.name.clone()).collect();
        if let Some(Task::Cut(_)) = self.task {
            self.targets = vec![self.marks[0].name.clone(), TRAY.to_owned()];
        }
        self.course = Some(Course::new(&config, self.targets.clone())?);
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
        let (Some(mut course), Some(mut state), Some(keys), Some(task)) = (
            self.course.take(),
            self.state.take(),
            self.keys.clone(),
            self.task.clone(),
        ) else {
            return Err(Fault::new("not initialised"));
        };
        course.hear(tick)?;
        if !state.shown {
            state.shown = true;
            self.show(tick);
        }
        self.hear_forces(&mut state, &course, tick)?;
        if let Some(block) = tick.block(TISSUE_SNAPSHOT, &self.body) {
            // The strip sags under gravity when the run begins: depth counts from where it lies when it is first touched.
            if state.patches.is_empty() || !state.touched {
                let patches = self
                    .marks
                    .iter()
                    .map(|mark| Patch::around(mark.position, keys.mark_radius, &block));
                state.patches = patches.map(Option::unwrap_or_default).collect();
                if let Some(empty) = state.patches.iter().position(|p| p.nodes.is_empty()) {
                    let name = &self.marks[empty].name;
                    return Err(Fault::new(format!(
                        "no tissue within `mark_radius` of \"{name}\""
                    )));
                }
            }
            self.move_marks(&state, &block, tick);
            match &task {
                Task::Cut(site) => {
                    self.judge_cut(&mut state, &mut course, site, &block, tick)?;
                }
                _ => self.judge(&mut state, &mut course, &task, &block, tick)?,
            }
        }
        let tools = tick.latest::<ToolStates>()?.unwrap_or_default().tools;
        let tool = tools
            .iter()
            .find(|t| t.tool == self.tools[0] && t.status == ToolStatus::Tracked);
        if let (true, None, Some(tool)) = (course.running(), state.start, tool) {
            state.start = Some(tool.pose.position);
            // Two hands share a way as they like.
            if let Task::Push { depth, tolerance } = task {
                let least = depth - tolerance;
                let path = self.shortest_path(tool.pose.position, least, keys.mark_radius);
                course.set_shortest_path(path);
            }
        }
        // Without tissue there is nothing to measure, and nothing is not zero.
        if !state.patches.is_empty() {
            if let Task::Push { .. } = task {
                course.measure("peak-force", state.peak_force);
                course.measure("overshoot", state.overshoot);
            } else {
                course.measure("peak-grip", state.peak_grip);
                course.measure("drops", f64::from(state.drops));
            }
        }
        if let (n @ 1.., errors) = state.counted {
            let id = match task {
                Task::Push { .. } => "depth-error",
                _ => "place-error",
            };
            course.measure(id, errors / n as f64);
        }
        if let Some(distance) = state.progress.cut_distance() {
            course.measure("cut-distance", distance);
        }
        let unfinished = state.current < self.targets.len();
        course.conclude(tick, |course| {
            if unfinished && state.start.is_some() {
                course.speaks_against(reason(&state, &task));
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
