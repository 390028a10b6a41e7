//! Push a clamped strip of tissue to a marked depth and hold it there; or pick its free end up with two forceps and hold it in a
//! ring; or cut it at the mark and put the piece into a tray. All that is measured comes
//! from the physics plugin alone, as snapshots of the nodes, forces in newtons and cuts.
//!
//! One mark after the other is the current one: orange, yellow while it is held right, red when it is too deep, green when done.
//! Marks move with the tissue.

#![forbid(unsafe_code)]

mod cut;
mod task;

use cut::{Progress, Site, TRAY};
use microsim_sdk::message::{
    Colour, LocalText, ObjectSet, Pose, TISSUE_SNAPSHOT, TissueCut, ToolStates, ToolStatus,
};
use microsim_sdk::tissue::{
    Contacts, Patch, Releases, Ring, colour, mark_colour, mark_places, show_colour, show_mark,
    tissue_of,
};
use microsim_sdk::{
    BlockView, Exercise, Fault, LevelRun, ModuleConfig, Object, Setup, Shape, Tick, Training, Tray,
    export_plugin, shortest_path,
};
use microsim_training::{Dwell, DwellState};
use serde::{Deserialize, Serialize};
use task::{Keys, Task, TaskName};

/// Fraction of its radius by which a mark's centre lies below the tissue's surface.
const SUNK: f64 = 0.7;

/// The object of the level that is the ring.
const RING: &str = "ring";

/// What evolves here besides the run of the level.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct State {
    patches: Vec<Patch>,
    /// Number of targets done, and so the current one.
    current: usize,
    dwell: Dwell,
    colour: Colour,
    /// Whether the current mark has counted as held at any time.
    reached: bool,
    /// Greatest depth at the current mark so far \[m\].
    deepest: f64,
    contacts: Contacts,
    overshoot: f64,
    /// Number of ticks and sum of distances from what is asked for \[m\], over all holding that counted.
    counted: (u64, f64),
    /// Whether every tool that holds has had the tissue since it was last lost, and how often it was.
    had: bool,
    drops: Releases,
    /// Of the task `cut`.
    progress: Progress,
    /// First tracked position of the tip \[m\].
    start: Option<[f64; 3]>,
}

/// The module.
#[derive(Debug)]
pub struct PushStrip {
    keys: Keys,
    task: Task,
    marks: Vec<Object>,
    targets: Vec<String>,
    body: String,
    /// Those that hold tissue and do not cut it.
    tools: Vec<String>,
}

/// The plugin of this module.
pub type Module = Training<PushStrip>;

impl PushStrip {
    /// Lets marks move with the tissue.
    fn move_marks(&self, state: &State, block: &BlockView<'_>, tick: &mut Tick<'_>) {
        for (mark, patch) in self.marks.iter().zip(&state.patches) {
            if let Some(now) = patch.now(block) {
                let [x, y, z] = now.place;
                let (Shape::Sphere { radius } | Shape::Capsule { radius, .. }) = mark.shape else {
                    continue;
                };
                // Sunk so far that a cap shows around the tool that stands on it.
                let pose = Some(Pose {
                    position: [x, y, z - SUNK * radius],
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
    fn update_mark(
        &self,
        state: &mut State,
        run: &mut LevelRun,
        block: &BlockView<'_>,
        tick: &mut Tick<'_>,
    ) -> Result<(), Fault> {
        let Some(patch) = state
            .patches
            .get(state.current)
            .filter(|_| run.is_running())
        else {
            return Ok(());
        };
        let Some(now) = patch.now(block) else {
            return Ok(());
        };
        state.deepest = state.deepest.max(now.depth);
        if let Task::Push { depth: wanted, .. } = self.task {
            state.overshoot = state.overshoot.max(now.depth - wanted);
        }
        let held = state.contacts.held_by_all();
        state.had |= held;
        if matches!(self.task, Task::Hold(_)) && state.drops.watch(tick.time(), state.had && !held)
        {
            state.had = false;
            let text = LocalText::new("Gewebe entglitten", "Tissue slipped away");
            run.event(tick, "drop", text);
        }
        let Some(standing) = self.task.standing(now, held) else {
            return Ok(());
        };
        let holds = standing.holds;
        if holds {
            state.reached = true;
            state.counted = (state.counted.0 + 1, state.counted.1 + standing.error);
        }
        if state.dwell.update(tick.time(), holds) == DwellState::Complete {
            let n = state.current + 1;
            run.target_done(
                tick,
                &self.marks[state.current].name,
                LocalText::new(format!("Marke {n} gehalten"), format!("Mark {n} held")),
            )?;
            mark_colour(tick, &self.marks[state.current].name, colour::DONE);
            state.current = n;
            state.dwell.reset();
            (state.deepest, state.reached, state.colour) = (0.0, false, colour::CURRENT);
            if let Some(next) = self.marks.get(n) {
                mark_colour(tick, &next.name, colour::CURRENT);
            }
        } else {
            let name = &self.marks[state.current].name;
            show_colour(&mut state.colour, tick, name, standing.colour);
        }
        Ok(())
    }

    /// One tick of the task `cut`.
    fn update_cut(
        &self,
        state: &mut State,
        run: &mut LevelRun,
        site: &Site,
        block: &BlockView<'_>,
        tick: &mut Tick<'_>,
    ) -> Result<(), Fault> {
        if !run.is_running() {
            return Ok(());
        }
        let steadied = state.contacts.held_by_all();
        for cut in tick.messages::<TissueCut>()? {
            // What is done to the piece once it is off does not count.
            if cut.body == self.body && !state.progress.off {
                let mark = std::slice::from_ref(&site.mark);
                state
                    .progress
                    .cuts
                    .assign(&cut, mark, f64::INFINITY, |_| steadied);
            }
        }
        let piece = state.progress.piece(block, site);
        if state.current == 0 && state.progress.off {
            (state.current, state.colour) = (1, colour::WAITING);
            let text = LocalText::new("Stück abgeschnitten", "Piece cut off");
            run.target_done(tick, &self.marks[0].name, text)?;
            tick.publish(&ObjectSet {
                name: self.marks[0].name.clone(),
                active: Some(false),
                ..ObjectSet::default()
            });
        }
        let Some(piece) = piece.filter(|_| state.current == 1) else {
            return Ok(());
        };
        let delivery = &mut state.progress.delivery;
        let delivered = delivery.watch(tick.time(), &piece, &state.contacts, &site.tray);
        if delivered.dropped {
            let text = LocalText::new("Stück fallen gelassen", "Piece dropped");
            run.event(tick, "drop", text);
        }
        let colour = colour::of(delivered.done, delivered.lies);
        show_colour(&mut state.colour, tick, TRAY, colour);
        if delivered.done {
            state.current = 2;
            let text = LocalText::new("Stück liegt in der Schale", "Piece lies in the tray");
            run.target_done(tick, TRAY, text)?;
        }
        Ok(())
    }

    /// What has been measured so far.
    fn measure(&self, state: &State, run: &mut LevelRun) {
        // Without tissue there is nothing to measure, and nothing is not zero.
        if !state.patches.is_empty() {
            if let Task::Push { .. } = self.task {
                run.measure("peak-force", state.contacts.peak_force);
                run.measure("overshoot", state.overshoot);
            } else {
                run.measure("peak-grip", state.contacts.peak_grip);
            }
            let drops = match self.task {
                Task::Push { .. } => None,
                Task::Hold(_) => Some(state.drops),
                Task::Cut(_) => Some(state.progress.delivery.drops),
            };
            // What was never in a grip cannot be dropped.
            if let Some(drops) = drops.filter(|_| state.contacts.was_held) {
                run.measure("drops", f64::from(drops.count));
            }
        }
        if let (n @ 1.., errors) = state.counted {
            let id = match self.task {
                Task::Push { .. } => "depth-error",
                _ => "place-error",
            };
            run.measure(id, errors / n as f64);
        }
        if let Task::Cut(_) = self.task {
            let found = state.progress.cuts.findings(f64::INFINITY);
            run.measure("stray-cut", found.stray);
            if let Some(distance) = found.distance {
                run.measure("cut-distance", distance);
            }
        }
    }

    /// A path of the tip that no run can undercut: straight from the start to the least depth that counts, anywhere within
    /// `mark_radius` of each mark in turn \[m\].
    fn shortest_path(&self, start: [f64; 3], depth: f64) -> f64 {
        let marks = self.marks.iter().map(|mark| mark.position);
        let goals: Vec<[f64; 3]> = marks.map(|[x, y, z]| [x, y, z - depth]).collect();
        shortest_path(start, &goals, self.keys.mark_radius)
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

impl Exercise for PushStrip {
    type State = State;

    fn new(_: &Setup, config: &ModuleConfig) -> Result<(Self, Vec<String>), Fault> {
        let keys: Keys = serde_json::from_value(config.module.clone())?;
        let objects = &config.objects;
        let marks = mark_places(objects)?;
        let task = match keys.task {
            TaskName::Push => Task::Push {
                depth: keys.depth,
                tolerance: keys.depth_tolerance,
            },
            TaskName::Hold => Task::Hold(Ring::named(objects, RING)?),
            TaskName::Cut => Task::Cut(Site::new(
                &marks[0],
                objects,
                Tray::named(&config.rigid, TRAY)?,
            )?),
        };
        let tools = config.holders();
        if tools.is_empty() {
            return Err(Fault::new("the level needs a [[tool]] that does not cut"));
        }
        if matches!(task, Task::Cut(_)) && tools.len() == config.tools.len() {
            return Err(Fault::new(
                "[module] `task`: `cut` needs a [[tool]] that cuts",
            ));
        }
        let targets: Vec<String> = match task {
            Task::Cut(_) => vec![marks[0].name.clone(), TRAY.to_owned()],
            _ => marks.iter().map(|m| m.name.clone()).collect(),
        };
        let exercise = Self {
            keys,
            task,
            marks,
            targets: targets.clone(),
            body: tissue_of(config)?,
            tools,
        };
        Ok((exercise, targets))
    }

    fn start(&self) -> Result<State, Fault> {
        Ok(State {
            patches: Vec::new(),
            current: 0,
            dwell: Dwell::new(self.keys.dwell)?,
            colour: colour::CURRENT,
            reached: false,
            deepest: 0.0,
            contacts: Contacts::default(),
            overshoot: 0.0,
            counted: (0, 0.0),
            had: false,
            drops: Releases::default(),
            progress: Progress::new(self.keys.dwell)?,
            start: None,
        })
    }

    fn show(&self, tick: &mut Tick<'_>) {
        for (index, mark) in self.marks.iter().enumerate() {
            let colour = match index {
                0 => colour::CURRENT,
                _ => colour::WAITING,
            };
            show_mark(tick, &mark.name, colour);
        }
    }

    fn update(
        &self,
        state: &mut State,
        run: &mut LevelRun,
        tick: &mut Tick<'_>,
    ) -> Result<(), Fault> {
        state
            .contacts
            .update(tick, &self.body, &self.tools, run.is_running())?;
        if let Some(block) = tick.block(TISSUE_SNAPSHOT, &self.body) {
            if state.patches.is_empty() {
                for mark in &self.marks {
                    let patch = Patch::around(mark.position, self.keys.mark_radius, &block);
                    let name = &mark.name;
                    state.patches.push(patch.ok_or_else(|| {
                        Fault::new(format!("no tissue within `mark_radius` of \"{name}\""))
                    })?);
                }
            }
            // The strip sags under gravity when the run begins: depth counts from where it lies when it is first touched.
            if !state.contacts.touched {
                for patch in &mut state.patches {
                    patch.set_reference(&block);
                }
            }
            self.move_marks(state, &block, tick);
            match &self.task {
                Task::Cut(site) => self.update_cut(state, run, site, &block, tick)?,
                _ => self.update_mark(state, run, &block, tick)?,
            }
        }
        let tools = tick.latest::<ToolStates>()?.unwrap_or_default().tools;
        let tool = tools
            .iter()
            .find(|t| t.tool == self.tools[0] && t.status == ToolStatus::Tracked);
        if let (true, None, Some(tool)) = (run.is_running(), state.start, tool) {
            state.start = Some(tool.pose.position);
            // Two hands divide a path as they like.
            if let Task::Push { depth, tolerance } = self.task {
                let least = depth - tolerance;
                run.set_shortest_path(self.shortest_path(tool.pose.position, least));
            }
        }
        self.measure(state, run);
        Ok(())
    }

    fn reasons(&self, state: &State, run: &mut LevelRun) {
        if state.current < self.targets.len() && state.start.is_some() {
            run.add_reason(reason(state, &self.task));
        }
    }
}

export_plugin!(Module, "../module.toml");
