//! Abstract module 1 (dissertation, chapter 5, Figure 5.2 a): touch spheres with the forceps at a given angle and stay
//! until they change their colour. No tissue, no physics.
//!
//! One sphere after the other is the current one: orange, with a light blue needle that shows the direction. It turns
//! yellow while a touch counts, red while the tip is in it at a wrong angle, green when it is done.

mod placement;

pub use placement::{Place, distance, places};

use microsim_sdk::message::{
    Colour, LocalText, ObjectSet, Pose, ToolState, ToolStates, ToolStatus, decode_bytes, encode,
};
use microsim_sdk::{Course, CourseConfig, Fault, Plugin, Services, Setup, Tick, export_plugin};
use microsim_training::{Dwell, DwellState};
use serde::{Deserialize, Serialize};

const WAITING: Colour = [0.55, 0.58, 0.60];
const CURRENT: Colour = [0.95, 0.50, 0.10];
const COUNTING: Colour = [0.98, 0.85, 0.15];
const WRONG: Colour = [0.85, 0.12, 0.12];
const DONE: Colour = [0.20, 0.70, 0.25];

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

/// What of the level's objects matters here.
#[derive(Debug, Deserialize)]
struct ObjectKeys {
    name: String,
    count: Option<u32>,
    radius: Option<f64>,
    length: Option<f64>,
}

/// What evolves here besides the course.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct State {
    shown: bool,
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
#[derive(Debug, Default)]
pub struct TouchSpheres {
    course: Option<Course>,
    keys: Option<Keys>,
    tool: String,
    radius: f64,
    needle: f64,
    places: Vec<Place>,
    state: Option<State>,
}

fn target(index: usize) -> String {
    format!("sphere-{}", index + 1)
}

/// The shortest rotation that turns +z into `direction`.
fn orientation(direction: [f64; 3]) -> [f64; 4] {
    let [x, y, z] = direction;
    let q = [-y, x, 0.0, 1.0 + z];
    let length = (q[0] * q[0] + q[1] * q[1] + q[3] * q[3]).sqrt();
    q.map(|c| c / length)
}

/// Direction from tip to handle of a tool: its z axis in the field.
fn axis(tool: &ToolState) -> [f64; 3] {
    let [x, y, z, w] = tool.pose.orientation;
    [
        2.0 * (x * z + w * y),
        2.0 * (y * z - w * x),
        1.0 - 2.0 * (x * x + y * y),
    ]
}

impl TouchSpheres {
    fn fresh_state(keys: &Keys) -> Result<State, Fault> {
        Ok(State {
            shown: false,
            current: 0,
            dwell: Dwell::new(keys.dwell).map_err(|e| Fault::new(e.to_string()))?,
            colour: CURRENT,
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
                colour: Some(if index == 0 { CURRENT } else { WAITING }),
            });
        }
        self.show_needle(tick, self.places.first());
    }

    fn show_needle(&self, tick: &mut Tick<'_>, place: Option<&Place>) {
        let pose = place.map(|place| {
            let way = self.radius + 0.5 * self.needle;
            let at = |i: usize| place.centre[i] + way * place.direction[i];
            Pose {
                position: [at(0), at(1), at(2)],
                orientation: orientation(place.direction),
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
        course: &mut Course,
        keys: &Keys,
        tool: &ToolState,
        tick: &mut Tick<'_>,
    ) -> Result<(), Fault> {
        let Some(place) = self.places.get(state.current) else {
            return Ok(());
        };
        if tool.status != ToolStatus::Tracked {
            // Nothing is known of the tip: what it held is neither kept nor counted as lost.
            state.dwell.reset();
            if state.colour != CURRENT {
                state.colour = CURRENT;
                self.colour(tick, state.current, CURRENT);
            }
            return Ok(());
        }
        let tip = tool.pose.position;
        let start = *state.start.get_or_insert(tip);
        let away = distance(tip, place.centre);
        let toward: f64 = axis(tool)
            .iter()
            .zip(place.direction)
            .map(|(a, d)| a * d)
            .sum();
        let angle = libm::acos(toward.clamp(-1.0, 1.0));
        let inside = away <= self.radius;
        let counts = inside && angle <= keys.angle_tolerance;
        if counts {
            let (n, angles, distances) = state.counted;
            state.counted = (n + 1, angles + angle, distances + away);
            state.touched = true;
        } else if inside {
            state.wrong += tick.length();
        }
        match state.dwell.update(tick.time(), counts) {
            DwellState::Complete => {
                course.target_done(
                    tick,
                    &target(state.current),
                    LocalText {
                        de: format!("Kugel {} geschafft", state.current + 1),
                        en: format!("Sphere {} done", state.current + 1),
                    },
                )?;
                course.set_shortest_path(self.shortest_path(start));
                self.colour(tick, state.current, DONE);
                state.current += 1;
                state.dwell.reset();
                (state.wrong, state.touched, state.colour) = (0.0, false, CURRENT);
                if state.current < self.places.len() {
                    self.colour(tick, state.current, CURRENT);
                }
                self.show_needle(tick, self.places.get(state.current));
                return Ok(());
            }
            DwellState::Lost(held) => {
                state.losses += 1;
                course.event(
                    tick,
                    "touch-lost",
                    LocalText {
                        de: format!("Kugel {} nach {held:.2} s verloren", state.current + 1),
                        en: format!("Sphere {} lost after {held:.2} s", state.current + 1),
                    },
                );
            }
            DwellState::Holding(_) | DwellState::Idle => {}
        }
        let colour = match (counts, inside) {
            (true, _) => COUNTING,
            (false, true) => WRONG,
            (false, false) => CURRENT,
        };
        if colour != state.colour {
            state.colour = colour;
            self.colour(tick, state.current, colour);
        }
        Ok(())
    }

    fn colour(&self, tick: &mut Tick<'_>, index: usize, colour: Colour) {
        tick.publish(&ObjectSet {
            name: target(index),
            colour: Some(colour),
            ..ObjectSet::default()
        });
    }

    /// A way that no run can undercut: straight from the start to the first surface, then from surface to surface.
    fn shortest_path(&self, start: [f64; 3]) -> f64 {
        let first = self
            .places
            .first()
            .map_or(0.0, |p| distance(start, p.centre) - self.radius);
        let between = self
            .places
            .windows(2)
            .map(|pair| distance(pair[0].centre, pair[1].centre) - 2.0 * self.radius);
        first.max(0.0) + between.map(|way| way.max(0.0)).sum::<f64>()
    }
}

/// Why the current sphere was not done: exactly the first of these that holds.
fn reason(state: &State, keys: &Keys) -> Option<&'static str> {
    match state {
        state if state.wrong >= keys.dwell => Some("wrong-angle"),
        state if state.touched => Some("dwell-too-short"),
        // Not touched for long enough at all: the course says that targets were missed.
        _ => None,
    }
}

impl Plugin for TouchSpheres {
    fn new() -> Self {
        Self::default()
    }

    fn initialise(&mut self, setup: &Setup, _: Services) -> Result<(), Fault> {
        let config = CourseConfig::new(setup)?;
        let keys: Keys = serde_json::from_value(config.module.clone())?;
        let objects: Vec<ObjectKeys> = serde_json::from_value(setup.config["objects"].clone())?;
        let object = |name: &str| {
            let found = objects.iter().find(|o| o.name == name);
            found.ok_or_else(|| Fault::new(format!("the level needs an object \"{name}\"")))
        };
        let sphere = object("sphere")?;
        let (Some(count), Some(radius)) = (sphere.count, sphere.radius) else {
            return Err(Fault::new(
                "the level's object \"sphere\" needs `count` and `radius`",
            ));
        };
        self.needle = object(NEEDLE)?.length.unwrap_or_default();
        self.radius = radius;
        self.places = places(
            setup.seed,
            count as usize,
            radius,
            keys.spread,
            keys.direction_max,
        )?;
        let tool = config
            .tools
            .first()
            .ok_or_else(|| Fault::new("the level needs a tool"))?;
        self.tool = tool.name.clone();
        self.course = Some(Course::new(
            &config,
            (0..count as usize).map(target).collect(),
        )?);
        self.state = Some(Self::fresh_state(&keys)?);
        self.keys = Some(keys);
        Ok(())
    }

    fn reset(&mut self) -> Result<(), Fault> {
        if let (Some(course), Some(keys)) = (&mut self.course, &self.keys) {
            course.reset()?;
            self.state = Some(Self::fresh_state(keys)?);
        }
        Ok(())
    }

    fn process(&mut self, tick: &mut Tick<'_>) -> Result<(), Fault> {
        let (Some(mut course), Some(mut state), Some(keys)) =
            (self.course.take(), self.state.take(), self.keys.clone())
        else {
            return Err(Fault::new("not initialised"));
        };
        course.hear(tick)?;
        if !state.shown {
            state.shown = true;
            self.show(tick);
        }
        let tools = tick.latest::<ToolStates>()?.unwrap_or_default().tools;
        if let (true, Some(tool)) = (course.running(), tools.iter().find(|t| t.tool == self.tool)) {
            self.touch(&mut state, &mut course, &keys, tool, tick)?;
        }
        course.measure("losses", f64::from(state.losses));
        if let (n @ 1.., angles, distances) = state.counted {
            course.measure("angle-error", angles / n as f64);
            course.measure("centre-distance", distances / n as f64);
        }
        let unfinished = state.current < self.places.len();
        course.conclude(tick, |course| {
            if let (true, Some(reason)) = (unfinished, reason(&state, &keys)) {
                course.speaks_against(reason);
            }
        })?;
        self.course = Some(course);
        self.state = Some(state);
        Ok(())
    }

    fn save(&self) -> Vec<u8> {
        let course = self.course.as_ref().map(Course::save).unwrap_or_default();
        encode(&(serde_bytes::ByteBuf::from(course), &self.state))
    }

    fn restore(&mut self, state: &[u8]) -> Result<(), Fault> {
        let (course, state): (serde_bytes::ByteBuf, Option<State>) = decode_bytes(state)?;
        if let Some(own) = &mut self.course {
            own.restore(&course)?;
        }
        self.state = state;
        Ok(())
    }
}

export_plugin!(TouchSpheres, "../module.toml");
