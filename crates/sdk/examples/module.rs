//! A whole training module in one file, run in-process: touch a sphere with the tip of the tool and stay in it for half a second.
//!
//! `cargo run --example module -p microsim-sdk`. In a folder of its own, with a manifest, levels and
//! `export_plugin!(Training<TouchOnce>, "../module.toml")`, it is a plugin; `cargo xtask new module NAME` makes such a folder.

use microsim_sdk::message::{LevelControl, LevelEvent, LocalText, Pose, ToolStates, ToolStatus};
use microsim_sdk::tissue::distance;
use microsim_sdk::{
    Exercise, Fault, LevelRun, ModuleConfig, Setup, Shape, TestHost, Tick, Training,
};
use microsim_training::{Dwell, DwellState};
use serde_json::json;
use std::error::Error;

/// What a manifest states: what flows in and out, and what a level may set.
const MANIFEST: &str = r#"
name = "touch-once"
kind = "module"
version = "0.1.0"
abi = 2
licence = "MIT OR Apache-2.0"
library = "touch_once"
title = { de = "Einmal berühren", en = "Touch once" }
summary = { de = "Eine Kugel berühren.", en = "Touch a sphere." }
publishes = ["object.set", "level.state", "level.event", "training.result"]
subscribes = ["level.control", "tool.sample", "tool.states"]
plugins = ["translator", "objects"]

[[key]]
name = "dwell"
type = "quantity"
unit = "s"
doc = "How long the tip has to stay in the sphere."
"#;

/// The level: one sphere.
#[derive(Debug)]
struct TouchOnce {
    centre: [f64; 3],
    radius: f64,
    dwell: f64,
}

impl Exercise for TouchOnce {
    /// How long the tip has been in the sphere.
    type State = Dwell;

    fn new(_: &Setup, config: &ModuleConfig) -> Result<(Self, Vec<String>), Fault> {
        let sphere = config.objects.iter().find(|object| object.name == "sphere");
        let Some((centre, Shape::Sphere { radius })) =
            sphere.map(|o| (o.position, o.shape.clone()))
        else {
            return Err(Fault::new("the level needs a sphere of this name"));
        };
        let exercise = Self {
            centre,
            radius,
            dwell: config.module["dwell"].as_f64().unwrap_or(0.5),
        };
        Ok((exercise, vec!["sphere".into()]))
    }

    fn start(&self) -> Result<Dwell, Fault> {
        Ok(Dwell::new(self.dwell)?)
    }

    fn update(
        &self,
        dwell: &mut Dwell,
        run: &mut LevelRun,
        tick: &mut Tick<'_>,
    ) -> Result<(), Fault> {
        let tools = tick.latest::<ToolStates>()?.unwrap_or_default().tools;
        let inside = tools.iter().any(|tool| {
            tool.status == ToolStatus::Tracked
                && distance(tool.pose.position, self.centre) <= self.radius
        });
        if run.is_running() && dwell.update(tick.time(), inside) == DwellState::Complete {
            let text = LocalText::fixed("Kugel berührt", "Sphere touched");
            run.target_done(tick, "sphere", text)?;
        }
        Ok(())
    }

    fn reasons(&self, _: &Dwell, _: &mut LevelRun) {}
}

fn main() -> Result<(), Box<dyn Error>> {
    let config = json!({
        "tools": [{ "name": "right", "model": "probe" }],
        "models": {},
        "limits": [],
        "metrics": {
            "idle_speed": 1e-4, "movement_speed": 1e-3, "smoothing": 0.05, "idle_smoothing": 0.08,
            "resample_rate": 60.0, "gap": 0.1, "shortest_path": null,
        },
        "own_metrics": [],
        "reasons": [],
        "module": { "dwell": 0.5 },
        "objects": [{
            "name": "sphere", "shape": "sphere", "radius": 0.002, "position": [0.0, 0.0, 0.0],
            "orientation": [0.0, 0.0, 0.0, 1.0], "colour": "#f28019", "finish": "moist", "active": true,
        }],
    });
    // Moved to a fresh instance in every tick: whatever the state leaves out would be lost.
    let mut host = TestHost::<Training<TouchOnce>>::of_module(MANIFEST, 1, 1, config)?.moving();
    host.send(&LevelControl::Start);
    let result = loop {
        host.send_tools(&[("right", Pose::default())]);
        let published = host.tick()?;
        for event in published.all::<LevelEvent>() {
            println!("{:6.3} s  {}", event.time, event.text.en);
        }
        if let Some(result) = published.last::<microsim_sdk::message::TrainingResult>() {
            break result;
        }
    };
    let verdict = if result.passed { "passed" } else { "failed" };
    println!("{verdict} after {:.3} s", result.duration);
    Ok(())
}
