//! {{title}}: touch the sphere with the tip of the tool and stay in it for a while.
//!
//! The sphere turns yellow while a touch counts and green when it is done. Targets, limits, motion metrics and the
//! result are the [`Course`]'s; here stands only what is this module's own.

use microsim_sdk::message::{
    Colour, LocalText, ObjectSet, ToolStates, ToolStatus, decode_bytes, encode,
};
use microsim_sdk::{Course, CourseConfig, Fault, Plugin, Services, Setup, Tick, export_plugin};
use microsim_training::{Dwell, DwellState};
use serde::{Deserialize, Serialize};
use serde_bytes::ByteBuf;

/// Name of the level's object, and of the target.
const SPHERE: &str = "sphere";

/// Declared in `module.toml`: touched, but not held for long enough.
const DWELL_TOO_SHORT: &str = "dwell-too-short";

const WAITING: Colour = [0.95, 0.50, 0.10];
const COUNTING: Colour = [0.98, 0.85, 0.15];
const DONE: Colour = [0.20, 0.70, 0.25];

/// The level's table `[module]`.
#[derive(Debug, Deserialize)]
struct Keys {
    /// \[s\]
    dwell: f64,
}

/// The level's objects, as far as they matter here.
#[derive(Debug, Deserialize)]
struct Object {
    name: String,
    /// \[m\], in the field.
    position: [f64; 3],
    /// \[m\]
    radius: Option<f64>,
}

/// What evolves besides the course.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct State {
    dwell: Dwell,
    touched: bool,
    losses: u32,
    colour: Colour,
}

/// A level that has been set up.
#[derive(Debug)]
struct Task {
    course: Course,
    tool: String,
    centre: [f64; 3],
    radius: f64,
    start: State,
    state: State,
}

impl Task {
    fn new(setup: &Setup) -> Result<Self, Fault> {
        let config = CourseConfig::new(setup)?;
        let keys: Keys = serde_json::from_value(config.module.clone())?;
        let objects: Vec<Object> = serde_json::from_value(setup.config["objects"].clone())?;
        let sphere = objects.iter().find(|o| o.name == SPHERE);
        let Some((centre, radius)) = sphere.and_then(|s| Some((s.position, s.radius?))) else {
            return Err(Fault::new("the level needs a sphere with the name \"sphere\""));
        };
        let tool = config.tools.first();
        let tool = tool.ok_or_else(|| Fault::new("the level needs a tool"))?;
        let start = State {
            dwell: Dwell::new(keys.dwell).map_err(|e| Fault::new(e.to_string()))?,
            touched: false,
            losses: 0,
            colour: WAITING,
        };
        Ok(Self {
            course: Course::new(&config, vec![SPHERE.into()])?,
            tool: tool.name.clone(),
            centre,
            radius,
            state: start.clone(),
            start,
        })
    }

    fn process(&mut self, tick: &mut Tick<'_>) -> Result<(), Fault> {
        self.course.hear(tick)?;
        if self.course.running() && !self.course.is_done(SPHERE) {
            self.touch(tick)?;
        }
        let losses = f64::from(self.state.losses);
        self.course.measure("losses", losses);
        let touched = self.state.touched;
        self.course.conclude(tick, |course| {
            if touched && !course.is_done(SPHERE) {
                course.speaks_against(DWELL_TOO_SHORT);
            }
        })
    }

    /// The tip against the sphere.
    fn touch(&mut self, tick: &mut Tick<'_>) -> Result<(), Fault> {
        let inside = self.is_inside(tick)?;
        self.state.touched |= inside;
        let colour = match self.state.dwell.update(tick.time(), inside) {
            DwellState::Complete => {
                let said = LocalText {
                    de: "Kugel geschafft".into(),
                    en: "Sphere done".into(),
                };
                self.course.target_done(tick, SPHERE, said)?;
                DONE
            }
            DwellState::Holding(_) => COUNTING,
            DwellState::Lost(_) => {
                self.state.losses += 1;
                WAITING
            }
            DwellState::Idle => WAITING,
        };
        if colour != self.state.colour {
            self.state.colour = colour;
            tick.publish(&ObjectSet {
                name: SPHERE.into(),
                colour: Some(colour),
                ..ObjectSet::default()
            });
        }
        Ok(())
    }

    /// Whether the tip of a tool that is seen now lies in the sphere.
    fn is_inside(&self, tick: &Tick<'_>) -> Result<bool, Fault> {
        let tools = tick.latest::<ToolStates>()?.unwrap_or_default().tools;
        let tool = tools.iter().find(|t| t.tool == self.tool);
        let tool = tool.filter(|t| t.status == ToolStatus::Tracked);
        Ok(tool.is_some_and(|tool| {
            let offsets = tool.pose.position.iter().zip(self.centre);
            let square: f64 = offsets.map(|(tip, centre)| (tip - centre) * (tip - centre)).sum();
            square <= self.radius * self.radius
        }))
    }
}

/// The module.
#[derive(Debug, Default)]
pub struct {{Name}} {
    task: Option<Task>,
}

impl {{Name}} {
    fn task(&mut self) -> Result<&mut Task, Fault> {
        self.task.as_mut().ok_or_else(|| Fault::new("not initialised"))
    }
}

impl Plugin for {{Name}} {
    fn new() -> Self {
        Self::default()
    }

    fn initialise(&mut self, setup: &Setup, _: Services) -> Result<(), Fault> {
        self.task = Some(Task::new(setup)?);
        Ok(())
    }

    fn reset(&mut self) -> Result<(), Fault> {
        let task = self.task()?;
        task.state = task.start.clone();
        task.course.reset()
    }

    fn process(&mut self, tick: &mut Tick<'_>) -> Result<(), Fault> {
        self.task()?.process(tick)
    }

    fn save(&self) -> Vec<u8> {
        let task = self.task.as_ref();
        encode(&task.map(|task| (ByteBuf::from(task.course.save()), &task.state)))
    }

    fn restore(&mut self, state: &[u8]) -> Result<(), Fault> {
        if let Some((course, state)) = decode_bytes::<Option<(ByteBuf, State)>>(state)? {
            let task = self.task()?;
            task.course.restore(&course)?;
            task.state = state;
        }
        Ok(())
    }
}

export_plugin!({{Name}}, "../module.toml");

#[cfg(test)]
mod tests {
    use super::*;
    use microsim_sdk::TestHost;
    use microsim_sdk::message::{LevelControl, Pose, ToolState, TrainingResult};
    use serde_json::json;

    /// A level with a sphere of 2 mm at the origin, to be held for 1 s, in ticks of 8 ms.
    fn host() -> TestHost<{{Name}}> {
        let config = json!({
            "tools": [{ "name": "right", "model": "forceps" }],
            "models": {},
            "limits": [],
            "metrics": {
                "idle_speed": 1e-4, "movement_speed": 1e-3, "smoothing": 0.05,
                "resample_rate": 60.0, "gap": 0.1, "shortest_path": null,
            },
            "own_metrics": [],
            "reasons": [],
            "module": { "dwell": 1.0 },
            "objects": [{ "name": SPHERE, "position": [0.0, 0.0, 0.0], "radius": 0.002 }],
        });
        let manifest = include_str!("../module.toml");
        let host = TestHost::of_module(manifest, 1, 1, config);
        // Moved to a fresh instance in every tick: what `save` leaves out would be lost.
        host.expect("a level that is complete").moving()
    }

    fn tip(x: f64) -> ToolStates {
        let pose = Pose {
            position: [x, 0.0, 0.0],
            ..Pose::default()
        };
        ToolStates {
            tools: vec![ToolState {
                tool: "right".into(),
                model: "forceps".into(),
                status: ToolStatus::Tracked,
                pose,
                opening: 0.0,
            }],
        }
    }

    /// The verdict on a tip that stays in the sphere for so many ticks and then leaves it.
    fn result(ticks_inside: u32) -> TrainingResult {
        let mut host = host();
        host.send(&LevelControl::Start);
        for _ in 0..ticks_inside {
            host.send(&tip(0.0019));
            if let Some(result) = host.tick().expect("a good tick").last() {
                return result;
            }
        }
        host.send(&tip(0.0021));
        host.send(&LevelControl::InputEnded);
        let heard = host.tick().expect("a good tick");
        heard.last().expect("a verdict when the input has ended")
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
