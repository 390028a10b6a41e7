//! Dilatation of a vessel's end (dissertation, 2.3 and 5.2.2): its opening hangs shut; the vessel is held by its adventitia, a closed dilator is put into the lumen and
//! spread there, in more than one direction. What is left once nothing touches the vessel any more counts.
//!
//! All that is measured comes from the physics plugin: the opening as its nodes lie, stretches of elements, forces by layer and by jaw, tears. Where the dilator is
//! decides only when the vessel has to be held.

#![forbid(unsafe_code)]

mod dilator;
mod site;
mod state;

use microsim_sdk::message::{
    ContactForce, ContactForces, GRIP_MIN, LocalText, Pose, SolverTick, TISSUE_ELEMENTS,
    TISSUE_SNAPSHOT, TissueCut, ToolPlacements, ToolStates, ToolStatus,
};
use microsim_sdk::tissue::{Opening, Rim, VesselWall, colour, mark_colour, show_colour};
use microsim_sdk::{Exercise, Fault, LevelRun, ModuleConfig, Setup, Tick, Training, export_plugin};
use microsim_training::DwellState;
use site::{ADVENTITIA, DILATED, ENTERED, GAUGE, MEDIA, Site};
use state::{Left, State};
use std::f64::consts::PI;

/// Below it the dilator is closed, as it has to be on its path into the lumen: what it does to the vessel then it does with its tip.
const CLOSED: f64 = 0.05;

/// The module.
#[derive(Debug)]
pub struct Dilatation {
    site: Site,
}

/// The plugin of this module.
pub type Module = Training<Dilatation>;

/// What is left of an opening.
fn left(opening: &Rim) -> Left {
    let circle = opening.circumference * opening.circumference / (4.0 * PI);
    Left {
        diameter: 2.0 * (opening.area / PI).sqrt(),
        roundness: opening.area / circle,
    }
}

impl Dilatation {
    /// Where the dilator is and how far it is open, as far as tissue lets it be so; `None` while it is not tracked.
    fn dilator(&self, tick: &Tick<'_>) -> Result<Option<(Pose, f64)>, Fault> {
        let tools = tick.latest::<ToolStates>()?.unwrap_or_default().tools;
        let tracked = tools
            .iter()
            .find(|t| t.tool == self.site.dilator && t.status == ToolStatus::Tracked);
        let placed = tick.latest::<ToolPlacements>()?.unwrap_or_default();
        let placed = placed
            .tools
            .iter()
            .find(|t| t.tool == self.site.dilator && placed.tick == tick.index());
        Ok(tracked.map(|tool| {
            let as_tracked = (tool.pose, tool.opening);
            placed.map_or(as_tracked, |placed| (placed.pose, placed.opening))
        }))
    }

    /// Forces of a tick; those that mean nothing count as touch alone.
    fn update_forces(
        &self,
        state: &mut State,
        run: &LevelRun,
        tick: &mut Tick<'_>,
        inside: bool,
        closed: bool,
    ) -> Result<(), Fault> {
        let forces = tick.messages::<ContactForces>()?;
        let of_it = |contact: &&ContactForce| contact.body == self.site.body;
        let contacts: Vec<&ContactForce> = forces
            .iter()
            .flat_map(|f| &f.contacts)
            .filter(of_it)
            .collect();
        state.touched = !contacts.is_empty();
        let (site, running) = (&self.site, run.is_running());
        state
            .contacts
            .update(tick, &site.body, &site.holders, running)?;
        if !running {
            return Ok(());
        }
        state.grips.update(tick, &site.body, &site.holders)?;
        let solver = tick.messages::<SolverTick>()?;
        if inside {
            let adventitia = state.grips.layer(ADVENTITIA).map_or(0.0, |grip| grip.force);
            let steadied = state.contacts.held_by_any() && adventitia >= GRIP_MIN;
            state.inside += tick.length();
            state.steadied += if steadied { tick.length() } else { 0.0 };
        }
        if solver.iter().all(|solver| solver.valid) {
            for contact in contacts.iter().filter(|of| of.partner == site.dilator) {
                state.peak_force = state.peak_force.max(contact.sustained_force);
                if closed {
                    state.push = state.push.max(contact.sustained_force);
                }
                if inside {
                    state.spreads.update(contact, &site.axis);
                }
            }
        }
        Ok(())
    }

    /// The wall's injury in a tick.
    fn update_injury(
        state: &mut State,
        run: &LevelRun,
        wall: &VesselWall<'_>,
        elements: &microsim_sdk::BlockView<'_>,
        body: &str,
        tick: &mut Tick<'_>,
    ) -> Result<(), Fault> {
        let mut cuts = tick.messages::<TissueCut>()?;
        cuts.retain(|cut| cut.body == body);
        let solver = tick.messages::<SolverTick>()?;
        let valid = solver.iter().all(|solver| solver.valid);
        let was_torn = state.is_torn();
        state.injury.update(elements, wall, &cuts, valid);
        if state.is_torn() && !was_torn {
            let text = LocalText::new("Gefäßwand eingerissen", "The vessel's wall has torn");
            run.event(tick, "tear", text);
        }
        Ok(())
    }

    /// Whether the dilator is in the lumen, with the target that asks for it.
    fn enter(
        &self,
        state: &mut State,
        run: &mut LevelRun,
        depth: Option<f64>,
        tick: &mut Tick<'_>,
    ) -> Result<(), Fault> {
        if state.entered || depth.is_none_or(|depth| depth < self.site.keys.insertion) {
            return Ok(());
        }
        state.entered = true;
        let text = LocalText::new("Dilatator im Lumen", "Dilator in the lumen");
        run.target_done(tick, ENTERED, text)
    }

    /// What is left of the widening while nothing touches the vessel, with the target that asks for it.
    fn widen(
        &self,
        state: &mut State,
        run: &mut LevelRun,
        opening: Option<&Rim>,
        inside: bool,
        tick: &mut Tick<'_>,
    ) -> Result<(), Fault> {
        state.free = !state.touched && !inside;
        let untouched = state.entered && state.free;
        if untouched {
            state.left = opening.map(left).or(state.left);
        }
        let wide = |left: Left| left.diameter >= self.site.keys.diameter;
        let holds = untouched && opening.is_some() && state.left.is_some_and(wide);
        let done = state.dwell.update(tick.time(), holds) == DwellState::Complete;
        if self.site.gauge {
            show_colour(&mut state.colour, tick, GAUGE, colour::of(done, holds));
        }
        if done {
            let text = LocalText::new(
                "Die Öffnung bleibt weit genug",
                "The opening stays wide enough",
            );
            run.target_done(tick, DILATED, text)?;
        }
        Ok(())
    }

    /// What has been measured so far.
    fn measure(&self, state: &State, run: &mut LevelRun) {
        run.measure("push", state.push);
        run.measure("peak-force", state.peak_force);
        if let Some(media) = state.injury.layer(MEDIA) {
            run.measure("overstretch", media.fraction);
            run.measure("torn", media.torn);
        }
        if let Some(angle) = state.spreads.angle() {
            run.measure("spread-angle", angle);
        }
        // The rim of a torn opening is none of a ring.
        if let Some(left) = state.left.filter(|_| !state.is_torn()) {
            run.measure("diameter", left.diameter);
            run.measure("roundness", left.roundness);
        }
        if self.site.holders.is_empty() {
            return;
        }
        run.measure("peak-grip", state.contacts.peak_grip);
        if let Some(media) = state.grips.layer(MEDIA) {
            run.measure("media-grip", media.peak);
        }
        if state.inside > 0.0 {
            run.measure("held", state.steadied / state.inside);
        }
    }
}

impl Exercise for Dilatation {
    type State = State;

    fn new(_: &Setup, config: &ModuleConfig) -> Result<(Self, Vec<String>), Fault> {
        let site = Site::new(config)?;
        Ok((Self { site }, vec![ENTERED.into(), DILATED.into()]))
    }

    fn start(&self) -> Result<State, Fault> {
        State::new(&self.site.keys)
    }

    fn show(&self, tick: &mut Tick<'_>) {
        if self.site.gauge {
            mark_colour(tick, GAUGE, colour::CURRENT);
        }
    }

    fn update(
        &self,
        state: &mut State,
        run: &mut LevelRun,
        tick: &mut Tick<'_>,
    ) -> Result<(), Fault> {
        let tools = tick.latest::<ToolStates>()?.unwrap_or_default().tools;
        state.seen |= tools.iter().any(|tool| tool.status == ToolStatus::Tracked);
        let dilator = self.dilator(tick)?;
        let snapshot = tick.block(TISSUE_SNAPSHOT, &self.site.body);
        let elements = tick.block(TISSUE_ELEMENTS, &self.site.body);
        // Without tissue there is nothing to measure, and what was not measured is not zero.
        let (Some(snapshot), Some(elements)) = (snapshot, elements) else {
            return Ok(());
        };
        let Some(wall) = VesselWall::of(&snapshot, &elements, self.site.axis) else {
            return Ok(());
        };
        // A vessel that is slit along its whole length has none.
        let opening = Opening::of(&wall).map(|opening| opening.now);
        let depth = dilator
            .zip(opening)
            .and_then(|((pose, _), opening)| dilator::depth(&pose, &opening, &self.site.axis));
        let closed = dilator.is_some_and(|(_, opening)| opening < CLOSED);
        self.update_forces(state, run, tick, depth.is_some(), closed)?;
        if !run.is_running() {
            return Ok(());
        }
        Self::update_injury(state, run, &wall, &elements, &self.site.body, tick)?;
        self.enter(state, run, depth, tick)?;
        if !run.is_done(DILATED) {
            self.widen(state, run, opening.as_ref(), depth.is_some(), tick)?;
        }
        self.measure(state, run);
        Ok(())
    }

    fn reasons(&self, state: &State, run: &mut LevelRun) {
        if run.is_done(DILATED) || !state.seen {
            return;
        }
        run.add_reason(match state.entered {
            false => "not-entered",
            true if !state.free => "not-withdrawn",
            true if state.is_torn() => "torn",
            true => "not-wide-enough",
        });
    }
}

export_plugin!(Module, "../module.toml");
