//! {{title}}: touch the sphere with the tip of the tool and stay in it for a while.
//!
//! The sphere turns yellow while a touch counts and green when it is done. Targets, limits, motion metrics, the result and the frame
//! of a plugin are the SDK's; here stands only what is this module's own.

#![forbid(unsafe_code)]

use microsim_sdk::message::{Colour, LocalText, ToolStates, ToolStatus};
use microsim_sdk::tissue::{colour, distance, show_colour};
use microsim_sdk::{
    LevelRun, ModuleConfig, Exercise, Fault, Object, Setup, Shape, Tick, Training, export_plugin,
};
use microsim_training::{Dwell, DwellState};
use serde::{Deserialize, Serialize};

/// Name of the level's object, and of the target.
const SPHERE: &str = "sphere";

/// Declared in `module.toml`: touched, but not held for long enough.
const DWELL_TOO_SHORT: &str = "dwell-too-short";

/// The level's table `[module]`.
#[derive(Debug, Deserialize)]
struct Keys {
    /// \[s\]
    dwell: f64,
}

/// What a level asks for.
#[derive(Debug)]
pub struct {{Name}} {
    keys: Keys,
    tool: String,
    /// \[m\]
    centre: [f64; 3],
    /// \[m\]
    radius: f64,
}

/// What evolves besides the run of the level.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct State {
    dwell: Dwell,
    touched: bool,
    losses: u32,
    colour: Colour,
}

impl {{Name}} {
    /// Whether the tip of a tool that is seen now lies in the sphere.
    fn is_inside(&self, tick: &Tick<'_>) -> Result<bool, Fault> {
        let tools = tick.latest::<ToolStates>()?.unwrap_or_default().tools;
        let tool = tools.iter().find(|t| t.tool == self.tool);
        let tool = tool.filter(|t| t.status == ToolStatus::Tracked);
        Ok(tool.is_some_and(|tool| distance(tool.pose.position, self.centre) <= self.radius))
    }
}

impl Exercise for {{Name}} {
    type State = State;

    fn new(_: &Setup, config: &ModuleConfig) -> Result<(Self, Vec<String>), Fault> {
        let objects = &config.objects;
        let sphere = objects.iter().find(|o| o.name == SPHERE);
        let Some((centre, Shape::Sphere { radius })) = sphere.map(|o| (o.position, o.shape)) else {
            return Err(Fault::new("the level needs an [[object]] \"sphere\" of the shape \"sphere\""));
        };
        let tool = config.tools.first();
        let exercise = Self {
            keys: serde_json::from_value(config.module.clone())?,
            tool: tool.ok_or_else(|| Fault::new("the level needs a [[tool]]"))?.name.clone(),
            centre,
            radius,
        };
        Ok((exercise, vec![SPHERE.into()]))
    }

    fn start(&self) -> Result<State, Fault> {
        Ok(State {
            dwell: Dwell::new(self.keys.dwell)?,
            touched: false,
            losses: 0,
            colour: colour::CURRENT,
        })
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
        let inside = self.is_inside(tick)?;
        state.touched |= inside;
        let shown = match state.dwell.update(tick.time(), inside) {
            DwellState::Complete => {
                let text = LocalText::new("Kugel geschafft", "Sphere done");
                run.target_done(tick, SPHERE, text)?;
                colour::DONE
            }
            DwellState::Holding(_) => colour::HOLDING,
            DwellState::Lost(_) => {
                state.losses += 1;
                colour::CURRENT
            }
            DwellState::Idle => colour::CURRENT,
        };
        show_colour(&mut state.colour, tick, SPHERE, shown);
        run.measure("losses", f64::from(state.losses));
        Ok(())
    }

    fn reasons(&self, state: &State, run: &mut LevelRun) {
        if state.touched && !run.is_done(SPHERE) {
            run.add_reason(DWELL_TOO_SHORT);
        }
    }
}

export_plugin!(Training<{{Name}}>, "../module.toml");

#[cfg(test)]
mod tests {
    use super::*;
    use microsim_sdk::TestHost;
    use microsim_sdk::message::{LevelControl, Pose, TrainingResult};
    use serde_json::json;

    /// A level with a sphere of 2 mm at the origin, to be held for 1 s, in ticks of 8 ms.
    fn host() -> TestHost<Training<{{Name}}>> {
        let config = json!({
            "tools": [{ "name": "right", "model": "forceps" }],
            "models": {},
            "limits": [],
            "metrics": {
                "idle_speed": 1e-4, "movement_speed": 1e-3, "smoothing": 0.05, "idle_smoothing": 0.08,
                "resample_rate": 60.0, "gap": 0.1, "shortest_path": null,
            },
            "own_metrics": [],
            "reasons": [],
            "module": { "dwell": 1.0 },
            "objects": [{
                "name": SPHERE, "shape": "sphere", "radius": 0.002, "position": [0.0, 0.0, 0.0],
                "orientation": [0.0, 0.0, 0.0, 1.0], "colour": "#f28019", "finish": "moist", "active": true,
            }],
        });
        let manifest = include_str!("../module.toml");
        let host = TestHost::of_module(manifest, 1, 1, config);
        // Moved to a fresh instance in every tick: what `save` leaves out would be lost.
        host.expect("a level that is complete").moving()
    }

    fn tip(host: &mut TestHost<Training<{{Name}}>>, x: f64) {
        let pose = Pose {
            position: [x, 0.0, 0.0],
            ..Pose::default()
        };
        host.send_tools(&[("right", pose)]);
    }

    /// The verdict on a tip that stays in the sphere for so many ticks and then leaves it.
    fn result(ticks_inside: u32) -> TrainingResult {
        let mut host = host();
        host.send(&LevelControl::Start);
        for _ in 0..ticks_inside {
            tip(&mut host, 0.0019);
            if let Some(result) = host.tick().expect("a good tick").last() {
                return result;
            }
        }
        tip(&mut host, 0.0021);
        host.end()
    }

    #[test]
    fn a_second_in_the_sphere_passes() {
        // Time counts from the first tick inside: 1 s = 125 ticks later.
        let held = result(126);
        assert!(held.passed, "{:?}", held.failed);
        assert_eq!(held.targets_done, 1);
    }

    #[test]
    fn less_than_a_second_fails_for_that_reason() {
        assert_eq!(result(125).failed, [DWELL_TOO_SHORT]);
    }

    #[test]
    fn doing_nothing_misses_the_target() {
        let nothing = result(0);
        assert_eq!(nothing.failed, ["targets-missed"]);
        assert_eq!(nothing.score, 0.0);
    }
}
