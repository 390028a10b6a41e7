//! Sharp trimming of a vessel's end (dissertation, 5.2.2, Trimm-Modul 2): adventitia that hangs over the end is gripped with forceps, drawn over it and cut off with scissors;
//! what is left draws back along the media, to which it is tied.
//!
//! All that is measured comes from the physics plugin: surfaces of the layers, stretches of elements, cuts, forces in newtons. Region
//! 0 of the body is its media, region 1 its adventitia. Not here: what a level allows, which its limits state.

#![forbid(unsafe_code)]

mod draw;
mod layers;
mod state;
mod tilt;
mod trimmed;

use layers::{ADVENTITIA, MEDIA};
use microsim_sdk::message::{
    ContactForce, ContactForces, GRIP_MIN, LocalText, SolverTick, TISSUE_ELEMENTS, TISSUE_SNAPSHOT,
    TissueCut, ToolStates,
};
use microsim_sdk::tissue::{VesselAxis, VesselWall, colour, mark_places, show_colour, tissue_of};
use microsim_sdk::{
    Exercise, Fault, LevelRun, ModuleConfig, Setup, Tick, Training, axis, export_plugin,
};
use microsim_training::DwellState;
use state::State;
use trimmed::{Keys, Trimmed};

/// The object of the level that holds the vessel; its z axis is that of the vessel, towards the free end.
const CLAMP: &str = "clamp";

/// The only target.
const TRIMMED: &str = "trimmed";

/// Time without a grip after which tissue is no longer held \[s\]: a grip that trembles for a tick has not let go.
const LET_GO: f64 = 0.1;

/// The module.
#[derive(Debug)]
pub struct TrimSharp {
    keys: Keys,
    body: String,
    axis: VesselAxis,
    /// The object around the vessel that shows how far it is trimmed.
    mark: String,
    /// Tools that hold tissue and do not cut it.
    holders: Vec<String>,
}

/// The plugin of this module.
pub type Module = Training<TrimSharp>;

fn text(de: &'static str, en: &'static str) -> LocalText {
    LocalText::fixed(de, en)
}

/// Whether the forces and cuts of a tick mean anything.
fn is_valid(tick: &Tick<'_>) -> Result<bool, Fault> {
    let solver = tick.messages::<SolverTick>()?;
    Ok(solver.iter().all(|solver| solver.valid))
}

impl TrimSharp {
    /// Grips and forces of a tick, and how fast what is gripped is drawn.
    fn touch(
        &self,
        state: &mut State,
        wall: &VesselWall<'_>,
        run: &LevelRun,
        tick: &mut Tick<'_>,
    ) -> Result<(), Fault> {
        let (was_too_hard, was_held) = (state.contacts.too_hard, state.contacts.was_held);
        state
            .contacts
            .update(tick, &self.body, &self.holders, true)?;
        state.grips.update(tick, &self.body, &self.holders)?;
        let held_piece = wall.held_piece();
        if state.contacts.holds(held_piece) {
            state.held_at = Some(tick.time());
        }
        if is_valid(tick)? {
            let forces = tick.messages::<ContactForces>()?;
            let contacts = forces.iter().flat_map(|of| &of.contacts);
            let of_vessel: Vec<&ContactForce> = contacts
                .filter(|of| of.body == self.body && of.pieces.contains(&held_piece))
                .collect();
            state.touched = !of_vessel.is_empty();
            let is_gripped = |name: &String| {
                let mut contacts = of_vessel.iter();
                contacts.any(|of| of.partner == *name && of.grip_force >= GRIP_MIN)
            };
            state.gripped = self.holders.iter().map(is_gripped).collect();
        }
        let tools = tick.latest::<ToolStates>()?.unwrap_or_default().tools;
        let of_holders: Vec<_> = self
            .holders
            .iter()
            .enumerate()
            .map(|(k, name)| {
                let tool = tools.iter().find(|tool| tool.tool == *name);
                (tool, state.gripped.get(k).copied().unwrap_or(false))
            })
            .collect();
        state.draw.update(tick.time(), &of_holders);
        state.started |= state.contacts.touched;
        if state.contacts.was_held && !was_held {
            run.event(tick, "grip", text("Gegriffen", "Gripped"));
        }
        if state.contacts.too_hard && !was_too_hard {
            let hard = text(
                "Zu viel Kraft auf das Gefäß",
                "Too much force on the vessel",
            );
            run.event(tick, "excess-force", hard);
        }
        Ok(())
    }

    /// Cuts of a tick, and what it did to the layers.
    fn cut(
        &self,
        state: &mut State,
        wall: &VesselWall<'_>,
        run: &LevelRun,
        tick: &mut Tick<'_>,
    ) -> Result<(), Fault> {
        let cuts = tick.messages::<TissueCut>()?;
        let own: Vec<TissueCut> = cuts.into_iter().filter(|of| of.body == self.body).collect();
        let is_held = state
            .held_at
            .is_some_and(|last| tick.time() - last < LET_GO);
        let tools = tick.latest::<ToolStates>()?.unwrap_or_default().tools;
        let bites = state.bites.count;
        for tool in tools
            .iter()
            .filter(|tool| !self.holders.contains(&tool.tool))
        {
            // What is known of a tick that is not valid is only that something came apart.
            let by_it = own
                .iter()
                .filter(|cut| cut.valid && cut.tool == tool.tool && cut.area > 0.0);
            let by_it: Vec<&TissueCut> = by_it.collect();
            state.bites.update(tool.opening, !by_it.is_empty());
            for cut in by_it {
                let handle = axis(tool.pose.orientation);
                let bite = state.bites.count;
                state
                    .tilt
                    .update(bite, cut.area, cut.centroid, handle, &self.axis);
            }
        }
        if state.bites.count > bites {
            run.event(tick, "cut", text("Schnitt begonnen", "Cut begun"));
        }
        let of_media = |state: &State| {
            let media = state.injury.layer(MEDIA);
            media.map_or(0.0, |of| of.cut + of.torn)
        };
        let of_adventitia = |state: &State| state.injury.layer(ADVENTITIA).map_or(0.0, |of| of.cut);
        let [media, adventitia] = [of_media(state), of_adventitia(state)];
        if let Some(elements) = tick.block(TISSUE_ELEMENTS, &self.body) {
            state.injury.update(&elements, wall, &own, is_valid(tick)?);
        }
        let more = of_adventitia(state) - adventitia;
        state.cut += more;
        state.held_cut += if is_held { more } else { 0.0 };
        if media == 0.0 && of_media(state) > 0.0 {
            run.event(
                tick,
                "media-cut",
                text("Media angeschnitten", "The media was cut"),
            );
        }
        Ok(())
    }

    /// How the end stands to what is asked for.
    fn judge(
        &self,
        state: &mut State,
        wall: &VesselWall<'_>,
        run: &mut LevelRun,
        tick: &mut Tick<'_>,
    ) -> Result<(), Fault> {
        state.trimmed = Trimmed::of(wall);
        let done = state.trimmed.is_some_and(|end| end.suffices(&self.keys)) && !state.touched;
        let complete = state.stay.update(tick.time(), done) == DwellState::Complete;
        let shown = colour::of(complete, done);
        show_colour(&mut state.colour, tick, &self.mark, shown);
        if complete {
            run.target_done(
                tick,
                TRIMMED,
                text("Gefäßende getrimmt", "The vessel's end is trimmed"),
            )?;
        }
        Ok(())
    }

    /// What has been measured so far.
    fn measure(&self, state: &State, run: &mut LevelRun) {
        if let Some(end) = state.trimmed.filter(|_| !state.touched) {
            run.measure("overhang", end.overhang());
            run.measure("free-length", end.least);
        }
        run.measure("peak-force", state.contacts.peak_force);
        run.measure("peak-grip", state.contacts.peak_grip);
        run.measure("draw-speed", state.draw.peak);
        if let Some(media) = state.grips.layer(MEDIA) {
            run.measure("media-grip", media.peak);
        }
        if let Some(media) = state.injury.layer(MEDIA) {
            run.measure("media-injury", media.fraction);
            run.measure("media-cut", media.cut + media.torn);
        }
        if state.bites.count > 0 {
            run.measure("cuts", f64::from(state.bites.count));
            run.measure("scissors-tilt", state.tilt.largest());
        }
        if state.cut > 0.0 {
            run.measure("held", state.held_cut / state.cut);
        }
    }
}

impl Exercise for TrimSharp {
    type State = State;

    fn new(_: &Setup, config: &ModuleConfig) -> Result<(Self, Vec<String>), Fault> {
        let keys: Keys = serde_json::from_value(config.module.clone())?;
        let clamp = config.objects.iter().find(|object| object.name == CLAMP);
        let of_vessel = clamp.and_then(|of| VesselAxis::new(of.position, axis(of.orientation)));
        let of_vessel = of_vessel.ok_or_else(|| {
            Fault::new(format!(
                "the level needs an [[object]] \"{CLAMP}\" on the axis of the vessel, with its z axis towards the free end"
            ))
        })?;
        let exercise = Self {
            keys,
            body: tissue_of(config)?,
            axis: of_vessel,
            mark: mark_places(&config.objects)?[0].name.clone(),
            holders: config.holders(),
        };
        Ok((exercise, vec![TRIMMED.to_owned()]))
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
        if !run.is_running() {
            return Ok(());
        }
        // Without tissue there is nothing to measure, and what was not measured is not zero.
        let (Some(snapshot), Some(elements)) = (
            tick.block(TISSUE_SNAPSHOT, &self.body),
            tick.block(TISSUE_ELEMENTS, &self.body),
        ) else {
            return Ok(());
        };
        let Some(wall) = VesselWall::of(&snapshot, &elements, self.axis) else {
            return Ok(());
        };
        self.touch(state, &wall, run, tick)?;
        self.cut(state, &wall, run, tick)?;
        self.judge(state, &wall, run, tick)?;
        self.measure(state, run);
        Ok(())
    }

    fn reasons(&self, state: &State, run: &mut LevelRun) {
        // Who has not touched anything has not begun.
        if let Some(end) = state
            .trimmed
            .filter(|_| state.started && !run.is_done(TRIMMED))
        {
            run.add_reason(end.reason(&self.keys));
        }
    }
}

export_plugin!(Module, "../module.toml");
