//! Blunt trimming of a vessel's end (dissertation, 5.2.2, Trimm-Modul 1): the loose adventitia is pushed back along the media with
//! forceps and stays where it was pushed.
//!
//! All that is measured comes from the physics plugin: surfaces of the layers, stretches of elements, forces in newtons. Region
//! 0 of the body is its media, region 1 its adventitia. Not here: what a level allows, which its limits state.

#![forbid(unsafe_code)]

mod bare;
mod layers;
mod state;

use bare::{Bare, Keys};
use layers::MEDIA;
use microsim_sdk::message::{
    ContactForces, LocalText, ObjectSet, Pose, SolverTick, TISSUE_ELEMENTS, TISSUE_SNAPSHOT,
    ToolStates, ToolStatus,
};
use microsim_sdk::tissue::{VesselAxis, VesselWall, colour, mark_places, show_colour, tissue_of};
use microsim_sdk::{
    BlockView, Exercise, Fault, LevelRun, ModuleConfig, Setup, Tick, Training, export_plugin,
    shortest_path, turned_to,
};
use microsim_training::DwellState;
use state::{Found, State};

/// The object of the level that holds the vessel, in the middle of its section.
const CLAMP: &str = "clamp";

/// The only target.
const BARE: &str = "bare";

/// The module.
#[derive(Debug)]
pub struct TrimBlunt {
    keys: Keys,
    body: String,
    mark: String,
    /// Middle of the clamp \[m\].
    clamp: [f64; 3],
    tools: Vec<String>,
}

/// The plugin of this module.
pub type Module = Training<TrimBlunt>;

impl TrimBlunt {
    /// Where the vessel lies at rest; shows the mark around it, at the length that is to be bare.
    fn find(&self, block: &BlockView<'_>, tick: &mut Tick<'_>) -> Result<Found, Fault> {
        let found = Found::of(block, self.clamp)
            .ok_or_else(|| Fault::new("the vessel has no length from the object \"clamp\" on"))?;
        let direction = found.axis.direction();
        let back = self.keys.free_length;
        tick.publish(&ObjectSet {
            name: self.mark.clone(),
            pose: Some(Pose {
                position: [0, 1, 2].map(|k| found.end[k] - back * direction[k]),
                orientation: turned_to(direction),
            }),
            active: Some(true),
            colour: Some(colour::CURRENT),
        });
        Ok(found)
    }

    /// Injuries of the layers, what tore, and how far the end is bare.
    fn look(
        &self,
        state: &mut State,
        axis: VesselAxis,
        run: &LevelRun,
        tick: &mut Tick<'_>,
    ) -> Result<(), Fault> {
        let (Some(snapshot), Some(elements)) = (
            tick.block(TISSUE_SNAPSHOT, &self.body),
            tick.block(TISSUE_ELEMENTS, &self.body),
        ) else {
            return Ok(());
        };
        let Some(wall) = VesselWall::of(&snapshot, &elements, axis) else {
            return Ok(());
        };
        state.bare = Bare::of(&wall);
        let solver = tick.messages::<SolverTick>()?;
        let valid = solver.iter().all(|solver| solver.valid) && run.is_running();
        // Nothing tears in these levels.
        state.injury.update(&elements, &wall, &[], valid);
        Ok(())
    }

    /// Whether some tool presses on the vessel in this tick.
    fn is_touched(&self, tick: &Tick<'_>) -> Result<bool, Fault> {
        let forces = tick.messages::<ContactForces>()?;
        let mut contacts = forces.iter().flat_map(|of| &of.contacts);
        Ok(contacts.any(|c| c.body == self.body && c.peak_force > 0.0))
    }

    /// How the end stands to what is asked for.
    fn judge(
        &self,
        state: &mut State,
        run: &mut LevelRun,
        tick: &mut Tick<'_>,
    ) -> Result<(), Fault> {
        let Some(bare) = state.bare.filter(|_| run.is_running()) else {
            return Ok(());
        };
        let holds = bare.suffices(&self.keys);
        let left = holds && !self.is_touched(tick)?;
        if holds && !state.reached {
            let text = LocalText::new("Ende bis zur Marke frei", "End bare as far as the mark");
            run.event(tick, "bare", text);
        }
        state.reached |= holds;
        let done = state.stay.update(tick.time(), left) == DwellState::Complete;
        show_colour(&mut state.colour, tick, &self.mark, colour::of(done, holds));
        if done {
            let text = LocalText::new("Gefäßende bleibt frei", "The vessel's end stays bare");
            run.target_done(tick, BARE, text)?;
        }
        Ok(())
    }

    /// Grips and forces of a tick, with their events.
    fn touch(&self, state: &mut State, run: &LevelRun, tick: &mut Tick<'_>) -> Result<(), Fault> {
        let was_too_hard = state.contacts.too_hard;
        let counts = run.is_running();
        state
            .contacts
            .update(tick, &self.body, &self.tools, counts)?;
        if !counts {
            return Ok(());
        }
        state.grips.update(tick, &self.body, &self.tools)?;
        if state.contacts.too_hard && !was_too_hard {
            let text = LocalText::new(
                "Zu viel Kraft auf das Gefäß",
                "Too much force on the vessel",
            );
            run.event(tick, "excess-force", text);
        }
        Ok(())
    }

    /// The shortest path: of one tool to the end of the vessel, and back along it over the bare length.
    fn see(&self, state: &mut State, run: &mut LevelRun, tick: &Tick<'_>) -> Result<(), Fault> {
        let Some(found) = &state.found else {
            return Ok(());
        };
        if !run.is_running() || state.started {
            return Ok(());
        }
        let tools = tick.latest::<ToolStates>()?.unwrap_or_default().tools;
        let tracked = tools.iter().filter(|t| t.status == ToolStatus::Tracked);
        let paths =
            tracked.map(|tool| shortest_path(tool.pose.position, &[found.end], found.radius));
        if let Some(least) = paths.reduce(f64::min) {
            state.started = true;
            run.set_shortest_path(least + self.keys.free_length);
        }
        Ok(())
    }

    /// What has been measured so far.
    fn measure(&self, state: &State, run: &mut LevelRun) {
        let Some(bare) = state.bare else {
            return;
        };
        run.measure("free-length", bare.mean);
        run.measure("evenness", bare.evenness);
        run.measure("peak-force", state.contacts.peak_force);
        if let Some(media) = state.grips.layer(MEDIA) {
            run.measure("media-grip", media.peak);
        }
        if let Some(media) = state.injury.layer(MEDIA) {
            run.measure("media-injury", media.fraction);
        }
    }
}

impl Exercise for TrimBlunt {
    type State = State;

    fn new(_: &Setup, config: &ModuleConfig) -> Result<(Self, Vec<String>), Fault> {
        let keys: Keys = serde_json::from_value(config.module.clone())?;
        let clamp = config.objects.iter().find(|object| object.name == CLAMP);
        let clamp = clamp.ok_or_else(|| {
            Fault::new(format!(
                "the level needs an object \"{CLAMP}\", which holds the vessel"
            ))
        })?;
        let exercise = Self {
            keys,
            body: tissue_of(config)?,
            mark: mark_places(&config.objects)?[0].name.clone(),
            clamp: clamp.position,
            tools: config.holders(),
        };
        Ok((exercise, vec![BARE.to_owned()]))
    }

    fn start(&self) -> Result<State, Fault> {
        State::new(&self.keys)
    }

    fn update(
        &self,
        state: &mut State,
        run: &mut LevelRun,
        tick: &mut Tick<'_>,
    ) -> Result<(), Fault> {
        self.touch(state, run, tick)?;
        // Without tissue there is nothing to measure, and what was not measured is not zero.
        let Some(block) = tick.block(TISSUE_SNAPSHOT, &self.body) else {
            return Ok(());
        };
        if state.found.is_none() {
            state.found = Some(self.find(&block, tick)?);
        }
        let axis = state.found.as_ref().map(|found| found.axis);
        if let Some(axis) = axis {
            self.look(state, axis, run, tick)?;
        }
        self.see(state, run, tick)?;
        self.judge(state, run, tick)?;
        self.measure(state, run);
        Ok(())
    }

    fn reasons(&self, state: &State, run: &mut LevelRun) {
        if let Some(bare) = state.bare.filter(|_| state.started && !run.is_done(BARE)) {
            run.add_reason(bare.reason(&self.keys, state.reached));
        }
    }
}

export_plugin!(Module, "../module.toml");
