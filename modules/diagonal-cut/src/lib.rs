//! Two vessel ends of unequal width are to be sewn together (dissertation, 2.3 and 5.2.2): the smaller one is cut obliquely, so that its opening becomes an ellipse of the
//! circumference of the larger one; where the difference is small, it is spread instead.
//!
//! All that is measured comes from the physics plugin: the surface of the vessels, forces by tool and layer, cuts, stretches. What an opening measures counts while nothing
//! touches the vessel.

#![forbid(unsafe_code)]

mod site;
mod state;

use microsim_sdk::message::{
    ContactForces, LocalText, ObjectSet, SolverTick, TISSUE_ELEMENTS, TISSUE_SNAPSHOT, TissueCut,
    ToolState, ToolStates,
};
use microsim_sdk::tissue::{
    LayerGrips, Opening, Probes, VesselWall, WallInjury, colour, show_mark,
};
use microsim_sdk::{Exercise, Fault, LevelRun, ModuleConfig, Setup, Tick, Training, export_plugin};
use microsim_training::DwellState;
use site::{CUT, FREE, MATCHED, Site, Solution, Vessel, matching_angle};
use state::{Found, Size, State};

/// Time without a grip after which tissue is no longer steadied \[s\]: a grip that trembles for a tick has not let go.
const LET_GO: f64 = 0.1;

/// The module.
#[derive(Debug)]
pub struct DiagonalCut {
    site: Site,
}

/// The plugin of this module.
pub type Module = Training<DiagonalCut>;

fn text(de: &'static str, en: &'static str) -> LocalText {
    LocalText::fixed(de, en)
}

/// The wall of a vessel in a tick, if there is one.
fn wall<'a>(vessel: &Vessel, tick: &Tick<'a>) -> Option<VesselWall<'a>> {
    let snapshot = tick.block(TISSUE_SNAPSHOT, &vessel.body)?;
    let elements = tick.block(TISSUE_ELEMENTS, &vessel.body)?;
    VesselWall::of(&snapshot, &elements, vessel.axis)
}

/// Whether the forces and cuts of a tick mean anything.
fn is_valid(tick: &Tick<'_>) -> Result<bool, Fault> {
    let solver = tick.messages::<SolverTick>()?;
    Ok(solver.iter().all(|solver| solver.valid))
}

impl DiagonalCut {
    /// What both vessels are like in the first tick.
    fn find(&self, of_smaller: &VesselWall<'_>, tick: &Tick<'_>) -> Result<Found, Fault> {
        let missing = |vessel: &Vessel| {
            Fault::new(format!(
                "[[body]] \"{}\" has no opening around the axis of its clamp: it has to be a tube that begins there",
                vessel.body
            ))
        };
        let Site {
            smaller, larger, ..
        } = &self.site;
        let opening = Opening::of(of_smaller)
            .ok_or_else(|| missing(smaller))?
            .at_rest;
        let of_larger = wall(larger, tick).as_ref().and_then(Opening::of);
        let of_larger = of_larger.ok_or_else(|| missing(larger))?.at_rest;
        let (end, reach) = (opening.centre, smaller.axis.along(opening.centre));
        // The axis begins in the clamp.
        let held = [0, 1, 2].map(|k| end[k] - reach * smaller.axis.direction()[k]);
        let snapshot = tick.block(TISSUE_SNAPSHOT, &smaller.body);
        let ends = snapshot.and_then(|block| Probes::nearest(&[held, end], &block));
        let media = of_smaller.lumen_region();
        Ok(Found {
            smaller: Size::of(&opening),
            larger: Size::of(&of_larger),
            reach,
            ends: ends.ok_or_else(|| missing(smaller))?,
            grips: LayerGrips::of(&[media]),
            injury: WallInjury::of(&[(media, self.site.keys.injury_stretch)]),
            media,
        })
    }

    /// Grips and forces of a tick.
    fn update_contacts(
        &self,
        state: &mut State,
        found: &mut Found,
        wall: &VesselWall<'_>,
        run: &LevelRun,
        tick: &mut Tick<'_>,
    ) -> Result<(), Fault> {
        let (body, holders) = (&self.site.smaller.body, &self.site.holders);
        let was_held = state.contacts.was_held;
        state.contacts.update(tick, body, holders, true)?;
        found.grips.update(tick, body, holders)?;
        if state.contacts.held_by_any() {
            state.gripped = Some(tick.time());
        }
        if state.contacts.was_held && !was_held {
            run.event(tick, "grip", text("Gefäß gegriffen", "Vessel gripped"));
        }
        if is_valid(tick)? {
            let forces = tick.messages::<ContactForces>()?;
            let mut contacts = forces.iter().flat_map(|of| &of.contacts);
            let held = wall.held_piece();
            state.touched = contacts.any(|of| of.body == *body && of.pieces.contains(&held));
        }
        Ok(())
    }

    /// Cuts of a tick, and what it did to the wall.
    fn update_cuts(
        &self,
        state: &mut State,
        found: &mut Found,
        wall: &VesselWall<'_>,
        run: &LevelRun,
        tick: &mut Tick<'_>,
    ) -> Result<(), Fault> {
        let cuts = tick.messages::<TissueCut>()?;
        let is_steadied = state
            .gripped
            .is_some_and(|last| tick.time() - last < LET_GO);
        let first_of_other = state.other == 0.0;
        let mut by_tools = false;
        // What is known of a tick that is not valid is only that something came apart.
        for cut in cuts.iter().filter(|cut| cut.valid) {
            if cut.body == self.site.larger.body {
                state.other += cut.area;
            } else if cut.tool.is_empty() {
                state.torn += cut.area;
            } else {
                by_tools |= cut.area > 0.0;
                state.cut += cut.area;
                state.steadied += if is_steadied { cut.area } else { 0.0 };
            }
        }
        let bites = state.bites.count;
        let tools = tick.latest::<ToolStates>()?.unwrap_or_default().tools;
        let cuts_tissue = |tool: &&ToolState| !self.site.holders.contains(&tool.tool);
        if let Some(scissors) = tools.iter().find(cuts_tissue) {
            state.bites.update(scissors.opening, by_tools);
        }
        if state.bites.count > bites {
            run.event(tick, "cut", text("Schnitt begonnen", "Cut begun"));
        }
        if first_of_other && state.other > 0.0 {
            let cut = text(
                "Das größere Gefäß angeschnitten",
                "The larger vessel was cut",
            );
            run.event(tick, "other-vessel", cut);
        }
        let body = &self.site.smaller.body;
        if let Some(elements) = tick.block(TISSUE_ELEMENTS, body) {
            let own = cuts.into_iter().filter(|cut| cut.body == *body);
            let own: Vec<TissueCut> = own.collect();
            found.injury.update(&elements, wall, &own, is_valid(tick)?);
        }
        Ok(())
    }

    /// Which targets are reached, and what the opening is like while nothing touches the vessel.
    fn progress(
        &self,
        state: &mut State,
        found: &Found,
        wall: &VesselWall<'_>,
        run: &mut LevelRun,
        tick: &mut Tick<'_>,
    ) -> Result<(), Fault> {
        let Some(opening) = Opening::of(wall) else {
            return Ok(());
        };
        let growth = opening.now.girth / found.smaller.girth - 1.0;
        let is_free = !state.touched;
        let mismatch = opening.now.girth / found.larger.girth - 1.0;
        match self.site.keys.solution {
            Solution::Cut => {
                if !run.is_done(CUT) {
                    let snapshot = tick.block(TISSUE_SNAPSHOT, &self.site.smaller.body);
                    let apart = snapshot.and_then(|block| found.ends.apart(0, 1, &block));
                    // An end that is gone altogether has come off as well.
                    if apart == Some(false) {
                        state.spread = state.spread.max(growth);
                        return Ok(());
                    }
                    self.hide_marks(tick);
                    let done = text("Gefäßende abgeschnitten", "The end was cut off");
                    run.target_done(tick, CUT, done)?;
                }
                if is_free {
                    self.measure_cut(found, &opening, run);
                }
                if state.dwell.update(tick.time(), is_free) == DwellState::Complete {
                    let done = text("Gefäß losgelassen", "The vessel was let go");
                    run.target_done(tick, FREE, done)?;
                }
            }
            Solution::Dilate => {
                let matches = is_free && mismatch.abs() <= self.site.keys.tolerance;
                if state.dwell.update(tick.time(), matches) == DwellState::Complete {
                    let done = text("Die Öffnungen passen zueinander", "The openings match");
                    run.target_done(tick, MATCHED, done)?;
                }
            }
        }
        if is_free {
            let area = opening.now.area / found.larger.area - 1.0;
            run.measure("circumference-mismatch", mismatch.abs());
            run.measure("area-mismatch", area.abs());
        }
        Ok(())
    }

    /// What the end that a cut has left is like.
    fn measure_cut(&self, found: &Found, opening: &Opening, run: &mut LevelRun) {
        let axis = &self.site.smaller.axis;
        let rim = &opening.now;
        let lost = found.reach - axis.along(opening.at_rest.centre);
        let wanted = matching_angle(found.larger.girth / found.smaller.girth);
        let angle = rim.angle_to(axis.direction());
        run.measure("length-lost", lost);
        run.measure("unevenness", rim.unevenness);
        run.measure("raggedness", rim.circumference / rim.girth - 1.0);
        run.measure("angle-error", (angle - wanted).abs());
        if let Some(error) = self.site.facing_error(rim) {
            run.measure("facing-error", error);
        }
    }

    /// What has been measured so far, however the opening is.
    fn measure(&self, state: &State, found: &Found, run: &mut LevelRun) {
        run.measure("peak-force", state.contacts.peak_force);
        run.measure("peak-grip", state.contacts.peak_grip);
        run.measure("torn", state.torn);
        run.measure("other-vessel", state.other);
        if let Some(media) = found.grips.layer(found.media) {
            run.measure("media-grip", media.peak);
        }
        match self.site.keys.solution {
            Solution::Cut => {
                run.measure("needless-spread", state.spread);
                if state.cut > 0.0 {
                    run.measure("bites", f64::from(state.bites.count));
                    run.measure("steadied", state.steadied / state.cut);
                }
            }
            Solution::Dilate => {
                run.measure("needless-cut", state.cut);
                if let Some(media) = found.injury.layer(found.media) {
                    run.measure("overstretched", media.fraction);
                }
            }
        }
    }

    fn hide_marks(&self, tick: &mut Tick<'_>) {
        for mark in &self.site.marks {
            tick.publish(&ObjectSet {
                name: mark.clone(),
                active: Some(false),
                ..ObjectSet::default()
            });
        }
    }
}

impl Exercise for DiagonalCut {
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
            show_mark(tick, mark, colour::CURRENT);
        }
    }

    fn update(
        &self,
        state: &mut State,
        run: &mut LevelRun,
        tick: &mut Tick<'_>,
    ) -> Result<(), Fault> {
        // Without tissue there is nothing to measure, and what was not measured is not zero.
        let Some(wall) = wall(&self.site.smaller, tick) else {
            return Ok(());
        };
        let mut found = match state.found.take() {
            Some(found) => found,
            None => self.find(&wall, tick)?,
        };
        if run.is_running() {
            self.update_contacts(state, &mut found, &wall, run, tick)?;
            self.update_cuts(state, &mut found, &wall, run, tick)?;
            self.progress(state, &found, &wall, run, tick)?;
            self.measure(state, &found, run);
        }
        state.found = Some(found);
        Ok(())
    }

    fn reasons(&self, state: &State, run: &mut LevelRun) {
        // Who has not touched anything has not begun.
        if !state.contacts.touched {
            return;
        }
        let open = self
            .site
            .targets()
            .into_iter()
            .find(|target| !run.is_done(target));
        match open.as_deref() {
            Some(CUT) => run.add_reason("not-cut"),
            Some(FREE) => run.add_reason("still-touched"),
            Some(_) => run.add_reason("not-matched"),
            None => {}
        }
    }
}

export_plugin!(Module, "../module.toml");
