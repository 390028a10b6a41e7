//! Abstract module 1 (dissertation, chapter 5, Figure 5.2 a): touch spheres with the forceps at a given angle and stay
//! until they change their colour. No tissue, no physics.
//!
//! One sphere after the other is the current one: orange, with a light blue needle that shows the direction. It turns
//! yellow while a touch counts, red while the tip is in it at a wrong angle, green when it is done.

#![forbid(unsafe_code)]

mod placement;

pub use placement::{Place, places};

use microsim_sdk::message::{
    Colour, LocalText, ObjectSet, Pose, ToolState, ToolStates, ToolStatus,
};
use microsim_sdk::tissue::{colour, distance, mark_colour, show_colour};
use microsim_sdk::{
    Exercise, Fault, LevelRun, ModuleConfig, Setup, Shape, Tick, Training, axis, export_plugin,
    shortest_path, turned_to,
};
use microsim_training::{Dwell, DwellState};
use serde::{Deserialize, Serialize};

/// Name of the needle that shows the direction.
const NEEDLE: &str = "needle";

/// The level's keys of this module.
#[derive(Clone, Debug, Deserialize)]
pub struct Keys {
    /// \[rad\]
    pub angle_tolerance: f64,
    /// \[s\]
    pub dwell: f64,
    /// \[m\]
    pub spread: [f64; 3],
    /// \[rad\]
    pub direction_max: f64,
}

/// What evolves here besides the run of the level.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct State {
    current: usize,
    dwell: Dwell,
    colour: Colour,
    /// Time in the current sphere at a wrong angle \[s\].
    wrong: f64,
    /// Whether a touch of the current sphere has counted for a while.
    touched: bool,
    losses: u32,
    /// Number of ticks, sum of angle \[rad\] and of distance \[m\], over all touches that counted.
    counted: (u64, f64, f64),
    /// First tracked position of the tip \[m\].
    start: Option<[f64; 3]>,
}

/// The module.
#[derive(Debug)]
pub struct TouchSpheres {
    keys: Keys,
    tool: String,
    radius: f64,
    needle: f64,
    places: Vec<Place>,
}

/// The plugin of this module.
pub type Module = Training<TouchSpheres>;

fn target(index: usize) -> String {
    format!("sphere-{}", index + 1)
}

impl TouchSpheres {
    fn show_needle(&self, tick: &mut Tick<'_>, place: Option<&Place>) {
        let pose = place.map(|place| {
            let offset = self.radius + 0.5 * self.needle;
            let at = |i: usize| place.centre[i] + offset * place.direction[i];
            Pose {
                position: [at(0), at(1), at(2)],
                orientation: turned_to(place.direction),
            }
        });
        tick.publish(&ObjectSet {
            name: NEEDLE.into(),
            active: Some(pose.is_some()),
            pose,
            colour: None,
        });
    }

    /// One tick of the task: the tool against the current sphere.
    fn touch(
        &self,
        state: &mut State,
        run: &mut LevelRun,
        tool: &ToolState,
        tick: &mut Tick<'_>,
    ) -> Result<(), Fault> {
        let Some(place) = self.places.get(state.current) else {
            return Ok(());
        };
        if tool.status != ToolStatus::Tracked {
            // Nothing is known of the tip: what it held is neither continued nor counted as lost.
            state.dwell.reset();
            let name = target(state.current);
            show_colour(&mut state.colour, tick, &name, colour::CURRENT);
            return Ok(());
        }
        let tip = tool.pose.position;
        let start = *state.start.get_or_insert(tip);
        let away = distance(tip, place.centre);
        let toward: f64 = axis(tool.pose.orientation)
            .iter()
            .zip(place.direction)
            .map(|(a, d)| a * d)
            .sum();
        let angle = libm::acos(toward.clamp(-1.0, 1.0));
        let inside = away <= self.radius;
        let counts = inside && angle <= self.keys.angle_tolerance;
        if counts {
            let (n, angles, distances) = state.counted;
            state.counted = (n + 1, angles + angle, distances + away);
            state.touched = true;
        } else if inside {
            state.wrong += tick.length();
        }
        match state.dwell.update(tick.time(), counts) {
            DwellState::Complete => {
                run.target_done(
                    tick,
                    &target(state.current),
                    LocalText::new(
                        format!("Kugel {} geschafft", state.current + 1),
                        format!("Sphere {} done", state.current + 1),
                    ),
                )?;
                run.set_shortest_path(self.shortest_path(start));
                mark_colour(tick, &target(state.current), colour::DONE);
                state.current += 1;
                state.dwell.reset();
                (state.wrong, state.touched, state.colour) = (0.0, false, colour::CURRENT);
                if state.current < self.places.len() {
                    mark_colour(tick, &target(state.current), colour::CURRENT);
                }
                self.show_needle(tick, self.places.get(state.current));
                return Ok(());
            }
            DwellState::Lost(held) => {
                state.losses += 1;
                run.event(
                    tick,
                    "touch-lost",
                    LocalText::new(
                        format!("Kugel {} nach {held:.2} s verloren", state.current + 1),
                        format!("Sphere {} lost after {held:.2} s", state.current + 1),
                    ),
                );
            }
            DwellState::Holding(_) | DwellState::Idle => {}
        }
        let shown = match (counts, inside) {
            (true, _) => colour::HOLDING,
            (false, true) => colour::TOO_FAR,
            (false, false) => colour::CURRENT,
        };
        show_colour(&mut state.colour, tick, &target(state.current), shown);
        Ok(())
    }

    /// A path that no run can undercut: straight from the start to the first surface, then from surface to surface.
    fn shortest_path(&self, start: [f64; 3]) -> f64 {
        let centres: Vec<[f64; 3]> = self.places.iter().map(|place| place.centre).collect();
        shortest_path(start, &centres, self.radius)
    }
}

/// Why the current sphere was not done: exactly the first of these that holds.
fn reason(state: &State, keys: &Keys) -> Option<&'static str> {
    match state {
        state if state.wrong >= keys.dwell => Some("wrong-angle"),
        state if state.touched => Some("dwell-too-short"),
        // Not touched for long enough at all: the course reports that targets were missed.
        _ => None,
    }
}

impl Exercise for TouchSpheres {
    type State = State;

    fn new(setup: &Setup, config: &ModuleConfig) -> Result<(Self, Vec<String>), Fault> {
        let keys: Keys = serde_json::from_value(config.module.clone())?;
        let object = |name: &str| {
            let found = config.objects.iter().find(|o| o.name == name);
            found.ok_or_else(|| Fault::new(format!("the level needs an object \"{name}\"")))
        };
        let sphere = object("sphere")?;
        let (Some(count), Shape::Sphere { radius }) = (sphere.count, sphere.shape.clone()) else {
            return Err(Fault::new(
                "the level's object \"sphere\" has to be a sphere with a `count`",
            ));
        };
        let count = count as usize;
        let places = places(setup.seed, count, radius, keys.spread, keys.direction_max)?;
        let tool = config.tools.first();
        let tool = tool.ok_or_else(|| Fault::new("the level needs a tool"))?;
        let exercise = Self {
            needle: match object(NEEDLE)?.shape {
                Shape::Capsule { length, .. } => length,
                _ => 0.0,
            },
            tool: tool.name.clone(),
            keys,
            radius,
            places,
        };
        Ok((exercise, (0..count).map(target).collect()))
    }

    fn start(&self) -> Result<State, Fault> {
        Ok(State {
            current: 0,
            dwell: Dwell::new(self.keys.dwell)?,
            colour: colour::CURRENT,
            wrong: 0.0,
            touched: false,
            losses: 0,
            counted: (0, 0.0, 0.0),
            start: None,
        })
    }

    /// Shows the spheres where they lie, and the first needle.
    fn show(&self, tick: &mut Tick<'_>) {
        for (index, place) in self.places.iter().enumerate() {
            tick.publish(&ObjectSet {
                name: target(index),
                active: Some(true),
                pose: Some(Pose {
                    position: place.centre,
                    ..Pose::default()
                }),
                colour: Some(match index {
                    0 => colour::CURRENT,
                    _ => colour::WAITING,
                }),
            });
        }
        self.show_needle(tick, self.places.first());
    }

    fn update(
        &self,
        state: &mut State,
        run: &mut LevelRun,
        tick: &mut Tick<'_>,
    ) -> Result<(), Fault> {
        let tools = tick.latest::<ToolStates>()?.unwrap_or_default().tools;
        if let (true, Some(tool)) = (run.is_running(), tools.iter().find(|t| t.tool == self.tool)) {
            self.touch(state, run, tool, tick)?;
        }
        run.measure("losses", f64::from(state.losses));
        if let (n @ 1.., angles, distances) = state.counted {
            run.measure("angle-error", angles / n as f64);
            run.measure("centre-distance", distances / n as f64);
        }
        Ok(())
    }

    fn reasons(&self, state: &State, run: &mut LevelRun) {
        let unfinished = state.current < self.places.len();
        if let (true, Some(reason)) = (unfinished, reason(state, &self.keys)) {
            run.add_reason(reason);
        }
    }
}

export_plugin!(Module, "../module.toml");
