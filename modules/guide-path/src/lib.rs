//! Abstract module 2 (dissertation, chapter 5, Figure 5.2 b): the forceps along a bent wire, after the game of the hot wire. The wire passes
//! between the open jaws, which must not touch it. No tissue, no physics.
//!
//! The wire is divided into sections. That to be done is orange, done ones are green; a link that is touched is red. With two tools the first
//! guides to the middle and hands over there: both have the wire between their jaws at once.

#![forbid(unsafe_code)]

mod hand;
mod wire;

pub use wire::{Bends, Wire};

use hand::{Held, look};
use microsim_sdk::message::{Colour, LocalText, ObjectSet, Pose, ToolStates, ToolStatus};
use microsim_sdk::tissue::{colour, mark_colour};
use microsim_sdk::{
    Exercise, Fault, LevelRun, Microscope, ModuleConfig, Object, Setup, Shape, Tick, ToolShape,
    Training, View, export_plugin, turned_to,
};
use microsim_training::{Dwell, DwellState};
use serde::{Deserialize, Serialize};

/// The object whose copies are the links.
const WIRE: &str = "wire";
/// The object whose two copies carry the ends of the wire.
const POST: &str = "post";
/// The target of two tools.
const HANDED_OVER: &str = "handed-over";
/// The wire counts as guided on only from where it was left, give or take so much \[m\]: nothing can be left out.
const WINDOW: f64 = 1.5e-3;
/// Touches that follow each other within this time are one: a jaw that trembles along the wire \[s\].
const APART: f64 = 0.2;

/// The level's keys of this module.
#[derive(Clone, Debug, Deserialize)]
pub struct Keys {
    /// \[m\]
    pub swing: [f64; 2],
    /// From end to end.
    pub waves: f64,
    /// Targets along the wire.
    pub sections: u32,
    /// \[m\]
    pub gap: f64,
    /// \[s\]
    pub handover: f64,
}

/// What evolves here besides the run of the level.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// How far the wire has been guided \[m\].
    reached: f64,
    hands: Vec<HandState>,
    handover: Dwell,
    handed_over: bool,
    touches: u32,
    /// \[s\]
    touch_time: f64,
    losses: u32,
    /// Time in which the wire went through jaws that were opened too wide \[s\].
    wide: f64,
    /// Number of ticks with the wire between the jaws of the tool whose turn it is, sums of its distance from their middle \[m\] and of
    /// its angle to the normal of their plane \[rad\].
    guided: (u64, f64, f64),
    /// The microscope as it is set; none in sessions from before it was followed.
    microscope: Option<Microscope>,
    /// Times in which the wire was guided out of view, and out of focus \[s\], and the sum of the magnification over the ticks in which it was guided.
    seen: (f64, f64, f64),
    /// Colours of the links, by the numbers of [`shown`].
    colours: Vec<u8>,
}

/// Of one tool.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct HandState {
    last: Option<Held>,
    /// Whether the wire is between its jaws, where it is to be guided on.
    guides: bool,
    /// When it last touched the wire \[s\].
    touched: Option<f64>,
}

/// The module.
#[derive(Debug)]
pub struct GuidePath {
    keys: Keys,
    wire: Wire,
    /// Half the length of a post \[m\].
    post: f64,
    tools: Vec<(String, ToolShape)>,
    /// How the level sets the microscope; none in sessions from before it was followed.
    view: Option<View>,
}

/// The plugin of this module.
pub type Module = Training<GuidePath>;

fn section(index: usize) -> String {
    format!("section-{}", index + 1)
}

/// Colours of links by number: waiting, to be done, done, touched.
fn shown(number: u8) -> Colour {
    match number {
        0 => colour::WAITING,
        1 => colour::CURRENT,
        2 => colour::DONE,
        _ => colour::TOO_FAR,
    }
}

/// The wire that a level asks for; scripts are written for it.
///
/// # Errors
/// Where the level has no object `wire` of capsules with a `count`.
pub fn wire_of(seed: u64, objects: &[Object], keys: &Keys) -> Result<Wire, Fault> {
    let object = objects.iter().find(|object| object.name == WIRE);
    let (Some(count), Some(Shape::Capsule { radius, length })) = (
        object.and_then(|object| object.count),
        object.map(|object| object.shape.clone()),
    ) else {
        return Err(Fault::new(
            "the level needs an [[object]] with `name` = \"wire\", `shape` = \"capsule\" and a `count`",
        ));
    };
    Wire::bent(
        seed,
        Bends {
            links: count as usize,
            link: length,
            radius,
            swing: keys.swing,
            waves: keys.waves,
        },
    )
}

impl GuidePath {
    /// The end of a section \[m\]; the last link, in the post, is left out as the first is.
    fn end_of(&self, index: usize) -> f64 {
        let usable = self.wire.length() - 2.0 * self.wire.link();
        self.wire.link() + usable * (index + 1) as f64 / f64::from(self.keys.sections)
    }

    fn sections(&self) -> usize {
        self.keys.sections as usize
    }

    /// Sections that are done.
    fn done(&self, state: &State) -> usize {
        let done = (0..self.sections()).take_while(|i| state.reached >= self.end_of(*i));
        done.count()
    }

    /// How far the wire can be guided now \[m\]: of two tools the first gets to the middle.
    fn farthest(&self, state: &State) -> f64 {
        match self.tools.len() {
            2 if !state.handed_over => self.end_of(self.sections() / 2 - 1),
            _ => f64::INFINITY,
        }
    }

    /// The tool whose turn it is, and whether it has to hand the wire over now.
    fn turn(&self, state: &State) -> (usize, bool) {
        let first_half = self.done(state) < self.sections() / 2;
        match self.tools.len() {
            2 if state.handed_over => (1, false),
            2 => (0, !first_half),
            _ => (0, false),
        }
    }

    /// One tool in a tick of the running level.
    fn guide(
        &self,
        state: &mut State,
        run: &mut LevelRun,
        index: usize,
        held: Option<Held>,
        tick: &mut Tick<'_>,
    ) -> Option<usize> {
        let Some(held) = held else {
            // Nothing is known of the tool: what it did in between is neither touch nor loss.
            state.hands[index] = HandState::default();
            return None;
        };
        let (turn, _) = self.turn(state);
        let before = state.hands[index];
        let found = look(
            &self.tools[index].1,
            &self.wire,
            before.last.unwrap_or(held),
            held,
            state.reached,
        );
        if found.touched.is_some() {
            state.touch_time += tick.length();
            let again = before.touched.is_some_and(|at| tick.time() - at <= APART);
            if !again {
                state.touches += 1;
                run.event(
                    tick,
                    "wire-touched",
                    LocalText::fixed("Draht berührt", "Wire touched"),
                );
            }
            state.hands[index].touched = Some(tick.time());
        }
        let near = found
            .passage
            .filter(|(place, _)| (place - state.reached).abs() <= WINDOW);
        let guides = near.is_some();
        if let (true, Some((place, passage))) = (index == turn, near) {
            let (n, distances, angles) = state.guided;
            self.watch(state, run, held, tick);
            state.guided = (
                n + 1,
                distances + passage.off_centre,
                angles + passage.angle,
            );
            if passage.gap > self.keys.gap {
                if state.wide == 0.0 {
                    let text = LocalText::fixed("Pinzette zu weit offen", "Jaws too wide");
                    run.event(tick, "jaws-too-wide", text);
                }
                state.wide += tick.length();
            }
            state.reached = state.reached.max(place.min(self.farthest(state)));
        }
        let lost = index == turn && before.guides && !guides && self.done(state) < self.sections();
        if lost {
            state.losses += 1;
            let text = LocalText::fixed("Draht verlassen", "Wire left");
            run.event(tick, "wire-left", text);
        }
        state.hands[index].guides = guides;
        state.hands[index].last = Some(held);
        found.touched
    }

    /// Whether the trainee sees the tips that guide the wire.
    fn watch(&self, state: &mut State, run: &mut LevelRun, held: Held, tick: &mut Tick<'_>) {
        let Some(microscope) = &state.microscope else {
            return;
        };
        let (out_of_view, out_of_focus, magnification) = &mut state.seen;
        *magnification += microscope.magnification();
        let tip = held.pose.position;
        if !microscope.shows(tip) {
            if *out_of_view == 0.0 {
                let text = LocalText::fixed("Spitzen außerhalb des Bildes", "Tips out of view");
                run.event(tick, "out-of-view", text);
            }
            *out_of_view += tick.length();
        }
        if !microscope.is_sharp(tip) {
            *out_of_focus += tick.length();
        }
    }

    /// Colours of the links that have changed.
    fn colour(&self, state: &mut State, touched: &[usize], tick: &mut Tick<'_>) {
        let current = self.end_of(self.done(state));
        for index in 0..self.wire.len() {
            let middle = (index as f64 + 0.5) * self.wire.link();
            let number = match () {
                () if touched.contains(&index) => 3,
                () if middle <= state.reached => 2,
                () if middle <= current => 1,
                () => 0,
            };
            if state.colours[index] != number {
                state.colours[index] = number;
                mark_colour(tick, &link(index), shown(number));
            }
        }
    }
}

/// Name of the object of a link.
fn link(index: usize) -> String {
    format!("{WIRE}-{}", index + 1)
}

impl Exercise for GuidePath {
    type State = State;

    fn new(setup: &Setup, config: &ModuleConfig) -> Result<(Self, Vec<String>), Fault> {
        let keys: Keys = serde_json::from_value(config.module.clone())?;
        let post = config.objects.iter().find(|object| object.name == POST);
        let Some(Shape::Capsule { length: post, .. }) = post.map(|post| post.shape.clone()) else {
            return Err(Fault::new(
                "the level needs an [[object]] with `name` = \"post\", `shape` = \"capsule\" and `count` = 2",
            ));
        };
        if !(1..=2).contains(&config.tools.len()) {
            return Err(Fault::new(
                "the level needs one [[tool]], or two that hand the wire over",
            ));
        }
        if config.tools.len() == 2 && !keys.sections.is_multiple_of(2) {
            return Err(Fault::new(
                "[module] `sections`: with two tools an even number, as they hand the wire over in the middle",
            ));
        }
        let tools = config.tools.iter().map(|tool| {
            let shape = ToolShape::with_jaws(config, &tool.name)?;
            Ok((tool.name.clone(), shape))
        });
        let exercise = Self {
            wire: wire_of(setup.seed, &config.objects, &keys)?,
            post: 0.5 * post,
            tools: tools.collect::<Result<_, Fault>>()?,
            view: config.view,
            keys,
        };
        let mut targets: Vec<String> = (0..exercise.sections()).map(section).collect();
        if exercise.tools.len() == 2 {
            targets.push(HANDED_OVER.into());
        }
        Ok((exercise, targets))
    }

    fn start(&self) -> Result<State, Fault> {
        Ok(State {
            reached: self.wire.link(),
            hands: vec![HandState::default(); self.tools.len()],
            handover: Dwell::new(self.keys.handover)?,
            handed_over: false,
            touches: 0,
            touch_time: 0.0,
            losses: 0,
            wide: 0.0,
            guided: (0, 0.0, 0.0),
            microscope: self.view.map(Microscope::new),
            seen: (0.0, 0.0, 0.0),
            colours: vec![0; self.wire.len()],
        })
    }

    /// Shows the wire where it lies, and the posts under its ends.
    fn show(&self, tick: &mut Tick<'_>) {
        for (index, pair) in self.wire.joints().windows(2).enumerate() {
            let along = (pair[1] - pair[0]) / self.wire.link();
            tick.publish(&ObjectSet {
                name: link(index),
                active: Some(true),
                pose: Some(Pose {
                    position: (0.5 * (pair[0] + pair[1])).into(),
                    orientation: turned_to(along.into()),
                }),
                colour: Some(shown(0)),
            });
        }
        let ends = [self.wire.joints()[0], self.wire.joints()[self.wire.len()]];
        for (index, end) in ends.iter().enumerate() {
            tick.publish(&ObjectSet {
                name: format!("{POST}-{}", index + 1),
                active: Some(true),
                pose: Some(Pose {
                    position: [end.x, end.y, end.z - self.post],
                    ..Pose::default()
                }),
                colour: None,
            });
        }
    }

    fn update(
        &self,
        state: &mut State,
        run: &mut LevelRun,
        tick: &mut Tick<'_>,
    ) -> Result<(), Fault> {
        if let Some(microscope) = &mut state.microscope {
            microscope.update(tick)?;
        }
        let tools = tick.latest::<ToolStates>()?.unwrap_or_default().tools;
        if run.is_running() {
            let mut touched = Vec::new();
            for (index, (name, _)) in self.tools.iter().enumerate() {
                let tool = tools.iter().find(|tool| tool.tool == *name);
                let held = tool.filter(|tool| tool.status == ToolStatus::Tracked);
                let held = held.map(|tool| Held {
                    pose: tool.pose,
                    opening: tool.opening,
                });
                touched.extend(self.guide(state, run, index, held, tick));
            }
            for index in (0..self.done(state))
                .filter(|i| !run.is_done(&section(*i)))
                .collect::<Vec<_>>()
            {
                let (n, of) = (index + 1, self.sections());
                run.target_done(
                    tick,
                    &section(index),
                    LocalText::new(
                        format!("Abschnitt {n} von {of} geschafft"),
                        format!("Section {n} of {of} done"),
                    ),
                )?;
            }
            let (_, hands_over) = self.turn(state);
            let both = hands_over && state.hands.iter().all(|hand| hand.guides);
            if hands_over && state.handover.update(tick.time(), both) == DwellState::Complete {
                state.handed_over = true;
                run.target_done(
                    tick,
                    HANDED_OVER,
                    LocalText::fixed("Draht übergeben", "Wire handed over"),
                )?;
            }
            self.colour(state, &touched, tick);
        }
        run.measure("touches", f64::from(state.touches));
        run.measure("touch-time", state.touch_time);
        run.measure("losses", f64::from(state.losses));
        run.measure("wide-time", state.wide);
        let (out_of_view, out_of_focus, magnification) = state.seen;
        if let (n @ 1.., distances, angles) = state.guided {
            if state.microscope.is_some() {
                run.measure("out-of-view", out_of_view);
                run.measure("out-of-focus", out_of_focus);
                run.measure("magnification", magnification / n as f64);
            }
            run.measure("off-centre", distances / n as f64);
            run.measure("askew", angles / n as f64);
        }
        Ok(())
    }

    fn reasons(&self, state: &State, run: &mut LevelRun) {
        if self.done(state) == self.sections() {
            return;
        }
        let (_, hands_over) = self.turn(state);
        if hands_over {
            run.add_reason("not-handed-over");
        } else if state.guided.0 > 0 {
            run.add_reason("left-the-wire");
        }
        // Never between the jaws: the course reports that targets were missed.
    }
}

export_plugin!(Module, "../module.toml");
