//! General coordination under the microscope (dissertation, 5.2.2): tissue is stretched between two clamps; it is gripped and
//! held in a ring, or cut at its marks, or cut, carried to a tray and dropped there.
//!
//! All that is measured comes from the physics plugin: snapshots of nodes, forces in newtons, cuts. Where the tools are matters only
//! as far as they touch.

#![forbid(unsafe_code)]

mod site;
mod state;

use microsim_sdk::message::{
    LocalText, ObjectSet, Pose, TISSUE_SNAPSHOT, TissueCut, ToolStates, ToolStatus,
};
use microsim_sdk::tissue::{Assignment, Grasp, Patch, Probes, colour, show_colour, show_mark};
use microsim_sdk::{
    BlockView, Exercise, Fault, LevelRun, ModuleConfig, Setup, Tick, Training, export_plugin,
    turned_to,
};
use microsim_training::DwellState;
use site::{Mark, Site, TRAY, Task};
use state::State;

/// The module.
#[derive(Debug)]
pub struct Coordination {
    site: Site,
}

/// The plugin of this module.
pub type Module = Training<Coordination>;

fn text(de: String, en: String) -> LocalText {
    LocalText::new(de, en)
}

impl Coordination {
    /// Which tissue carries the marks and what distinguishes the pieces, as the tissue lies in the first tick.
    fn find_tissue(&self, state: &mut State, block: &BlockView<'_>) -> Result<(), Fault> {
        for mark in &self.site.marks {
            let around = |end: [f64; 3]| Patch::around(end, self.site.keys.mark_radius, block);
            let [Some(first), Some(second)] = mark.ends().map(around) else {
                return Err(Fault::new(format!(
                    "no tissue within `mark_radius` of an end of \"{}\"",
                    mark.name
                )));
            };
            state.patches.push([first, second]);
        }
        let (parts, lines) = (self.site.parts(), self.site.lines());
        state.probes = Probes::nearest(&parts, block).unwrap_or_default();
        state.grasp = Grasp::between(&lines, parts[0], block).unwrap_or_default();
        Ok(())
    }

    /// Moves a mark with the tissue; returns where its middle is.
    fn follow(
        &self,
        mark: &Mark,
        ends: &[Patch; 2],
        block: &BlockView<'_>,
        tick: &mut Tick<'_>,
    ) -> Option<[f64; 3]> {
        let [a, b] = [ends[0].now(block)?.place, ends[1].now(block)?.place];
        let middle = [0, 1, 2].map(|k| 0.5 * (a[k] + b[k]));
        let length = microsim_sdk::tissue::distance(a, b);
        if length > 0.0 {
            tick.publish(&ObjectSet {
                name: mark.name.clone(),
                pose: Some(Pose {
                    position: middle,
                    orientation: turned_to([0, 1, 2].map(|k| (b[k] - a[k]) / length)),
                }),
                ..ObjectSet::default()
            });
        }
        Some(middle)
    }

    /// Where tools come into view while the level runs, for the economy of motion.
    fn see(&self, state: &mut State, run: &mut LevelRun, tick: &Tick<'_>) -> Result<(), Fault> {
        let tools = tick.latest::<ToolStates>()?.unwrap_or_default().tools;
        // A tick without a message about tools has as many of them as before.
        let count = state.starts.len().max(tools.len());
        state.starts.resize(count, None);
        for (tool, start) in tools.iter().zip(&mut state.starts) {
            if run.is_running() && start.is_none() && tool.status == ToolStatus::Tracked {
                *start = Some(tool.pose.position);
            }
        }
        if state.starts.iter().any(Option::is_some) {
            let shortest = self
                .site
                .shortest_path(&state.starts, state.contacts.was_held);
            run.set_shortest_path(shortest);
        }
        Ok(())
    }

    /// Grips and forces of a tick, with their events.
    fn update_contacts(
        &self,
        state: &mut State,
        run: &LevelRun,
        tick: &mut Tick<'_>,
    ) -> Result<(), Fault> {
        let was_too_hard = state.contacts.too_hard;
        state
            .contacts
            .update(tick, &self.site.body, &self.site.holders, run.is_running())?;
        if !run.is_running() {
            return Ok(());
        }
        let held = state.contacts.held_by_any();
        if state.grip_ends.watch(tick.time(), !held) {
            state.grip_told = false;
        }
        if held && !state.grip_told {
            state.grip_told = true;
            run.event(
                tick,
                "grip",
                text("Gewebe gegriffen".into(), "Tissue gripped".into()),
            );
        }
        if state.contacts.too_hard && !was_too_hard {
            run.event(
                tick,
                "excess-force",
                text(
                    "Zu viel Kraft auf das Gewebe".into(),
                    "Too much force on the tissue".into(),
                ),
            );
        }
        Ok(())
    }

    /// Cuts of a tick. One is steadied by what holds the tissue beside its mark, as far as the next mark or clamp.
    fn assign(
        &self,
        state: &mut State,
        run: &LevelRun,
        block: &BlockView<'_>,
        tick: &mut Tick<'_>,
    ) -> Result<(), Fault> {
        let now = tick.time();
        state
            .grasp
            .watch(now, &state.contacts, &state.probes, block);
        let grasp = &state.grasp;
        let steadied = |mark: usize| grasp.steadies(mark, now);
        let lines = self.site.lines();
        for cut in tick.messages::<TissueCut>()? {
            if cut.body != self.site.body {
                continue;
            }
            match state
                .cuts
                .assign(&cut, &lines, self.site.keys.mark_reach, steadied)
            {
                Assignment::Mark { index, first: true } => {
                    let n = index + 1;
                    run.event(
                        tick,
                        "cut",
                        text(
                            format!("Schnitt an Marke {n} begonnen"),
                            format!("Cut at mark {n} begun"),
                        ),
                    );
                }
                Assignment::Stray => {
                    run.event(
                        tick,
                        "stray-cut",
                        text(
                            "Schnitt abseits der Marken".into(),
                            "Cut away from the marks".into(),
                        ),
                    );
                }
                Assignment::Tear => {
                    run.event(
                        tick,
                        "tear",
                        text("Gewebe eingerissen".into(), "Tissue torn".into()),
                    );
                }
                Assignment::Mark { first: false, .. } | Assignment::Nothing => {}
            }
        }
        Ok(())
    }

    /// The task `hold`: the tissue of the first mark in the ring.
    fn hold(
        &self,
        state: &mut State,
        run: &mut LevelRun,
        place: Option<[f64; 3]>,
        tick: &mut Tick<'_>,
    ) -> Result<(), Fault> {
        let (Some(ring), Some(place)) = (self.site.ring, place) else {
            return Ok(());
        };
        let mark = &self.site.marks[0];
        let held = state.contacts.held_by_all();
        let hold = &mut state.hold;
        hold.had |= held;
        if hold.drops.watch(tick.time(), hold.had && !held) {
            hold.had = false;
            run.event(
                tick,
                "drop",
                text("Gewebe entglitten".into(), "Tissue slipped away".into()),
            );
        }
        let away = ring.away(place);
        let inside = away <= ring.opening;
        let holds = held && inside;
        hold.loose |= inside && !held;
        if holds {
            hold.reached = true;
            hold.counted = (hold.counted.0 + 1, hold.counted.1 + away);
        }
        let done = hold.dwell.update(tick.time(), holds) == DwellState::Complete;
        let colour = colour::of(done, holds);
        show_colour(&mut state.colour, tick, &mark.name, colour);
        if done {
            run.target_done(
                tick,
                &mark.name,
                text(
                    "Marke im Ring gehalten".into(),
                    "Mark held in the ring".into(),
                ),
            )?;
        }
        Ok(())
    }

    /// The tasks `cut` and `deliver`: which marks are cut through.
    fn part(
        &self,
        state: &mut State,
        run: &mut LevelRun,
        block: &BlockView<'_>,
        tick: &mut Tick<'_>,
    ) -> Result<(), Fault> {
        for (index, mark) in self.site.marks.iter().enumerate() {
            if run.is_done(&mark.name)
                || state.probes.apart(index, index + 1, block) != Some(true)
                || !state.cuts.is_cut_at(index)
            {
                continue;
            }
            let n = index + 1;
            run.target_done(
                tick,
                &mark.name,
                text(
                    format!("Marke {n} durchtrennt"),
                    format!("Mark {n} cut through"),
                ),
            )?;
            tick.publish(&ObjectSet {
                name: mark.name.clone(),
                active: Some(false),
                ..ObjectSet::default()
            });
        }
        Ok(())
    }

    /// The task `deliver`: where the piece is, once it is off.
    fn deliver(
        &self,
        state: &mut State,
        run: &mut LevelRun,
        block: &BlockView<'_>,
        tick: &mut Tick<'_>,
    ) -> Result<(), Fault> {
        let Some(tray) = &self.site.tray else {
            return Ok(());
        };
        if !self.site.marks.iter().all(|mark| run.is_done(&mark.name)) || run.is_done(TRAY) {
            return Ok(());
        }
        let Some(piece) = state.probes.piece(1, block) else {
            return Ok(());
        };
        if !state.off {
            state.off = true;
            run.event(
                tick,
                "piece",
                text("Stück ist frei".into(), "Piece is free".into()),
            );
        }
        let delivered = state
            .delivery
            .watch(tick.time(), &piece, &state.contacts, tray);
        if delivered.dropped {
            run.event(
                tick,
                "drop",
                text("Stück fallen gelassen".into(), "Piece dropped".into()),
            );
        }
        let colour = colour::of(delivered.done, delivered.lies);
        show_colour(&mut state.colour, tick, TRAY, colour);
        if delivered.done {
            run.target_done(
                tick,
                TRAY,
                text(
                    "Stück liegt in der Schale".into(),
                    "Piece lies in the tray".into(),
                ),
            )?;
        }
        Ok(())
    }

    /// What has been measured so far.
    fn measure(&self, state: &State, run: &mut LevelRun) {
        run.measure("peak-force", state.contacts.peak_force);
        run.measure("excess-time", state.contacts.excess);
        run.measure("peak-grip", state.contacts.peak_grip);
        if self.site.keys.task == Task::Hold {
            if let (n @ 1.., errors) = state.hold.counted {
                run.measure("place-error", errors / n as f64);
            }
        } else {
            let found = state.cuts.findings(self.site.keys.cut_width);
            let values = [
                ("stray-cut", Some(found.stray)),
                ("torn", Some(found.torn)),
                ("cut-distance", found.distance),
                ("cut-angle", found.angle),
                ("steadied", found.steadied),
            ];
            for (id, value) in values {
                value.into_iter().for_each(|value| run.measure(id, value));
            }
        }
        let drops = match self.site.keys.task {
            Task::Hold => Some(state.hold.drops),
            Task::Cut => None,
            Task::Deliver => Some(state.delivery.drops),
        };
        // What was never in a grip cannot be dropped.
        if let Some(drops) = drops.filter(|_| state.contacts.was_held) {
            run.measure("drops", f64::from(drops.count));
        }
    }
}

impl Exercise for Coordination {
    type State = State;

    fn new(_: &Setup, config: &ModuleConfig) -> Result<(Self, Vec<String>), Fault> {
        let site = Site::new(config)?;
        let targets = site.targets();
        Ok((Self { site }, targets))
    }

    fn start(&self) -> Result<State, Fault> {
        State::new(self.site.keys.dwell)
    }

    fn show(&self, tick: &mut Tick<'_>) {
        for mark in &self.site.marks {
            show_mark(tick, &mark.name, colour::CURRENT);
        }
    }

    fn update(
        &self,
        state: &mut State,
        run: &mut LevelRun,
        tick: &mut Tick<'_>,
    ) -> Result<(), Fault> {
        self.update_contacts(state, run, tick)?;
        self.see(state, run, tick)?;
        // Without tissue there is nothing to measure, and what was not measured is not zero.
        let Some(block) = tick.block(TISSUE_SNAPSHOT, &self.site.body) else {
            return Ok(());
        };
        if state.patches.is_empty() {
            self.find_tissue(state, &block)?;
        }
        let mut first = None;
        for (index, (mark, ends)) in self.site.marks.iter().zip(&state.patches).enumerate() {
            // One that is done is shown no more, or stays where it was held.
            if run.is_done(&mark.name) {
                continue;
            }
            let place = self.follow(mark, ends, &block, tick);
            if index == 0 {
                first = place;
            }
        }
        if !run.is_running() {
            return Ok(());
        }
        self.assign(state, run, &block, tick)?;
        match self.site.keys.task {
            Task::Hold => self.hold(state, run, first, tick)?,
            Task::Cut => self.part(state, run, &block, tick)?,
            Task::Deliver => {
                self.part(state, run, &block, tick)?;
                self.deliver(state, run, &block, tick)?;
            }
        }
        self.measure(state, run);
        Ok(())
    }

    fn reasons(&self, state: &State, run: &mut LevelRun) {
        let open = self
            .site
            .targets()
            .iter()
            .any(|target| !run.is_done(target));
        if !open || state.starts.iter().all(Option::is_none) {
            return;
        }
        let uncut = self.site.marks.iter().any(|mark| !run.is_done(&mark.name));
        run.add_reason(match self.site.keys.task {
            Task::Hold if state.hold.reached => "dwell-too-short",
            Task::Hold if state.hold.loose => "not-gripped",
            Task::Hold => "not-in-ring",
            _ if uncut => "not-cut",
            _ => "not-in-tray",
        });
    }
}

export_plugin!(Module, "../module.toml");
