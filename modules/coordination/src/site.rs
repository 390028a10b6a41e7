//! What a level asks for, from its file: marks, clamps, ring, tray, and which tools hold.

use microsim_sdk::tissue::{MarkLine, Ring, mark_places, tissue_of};
use microsim_sdk::{CourseConfig, Fault, Object, Setup, Shape, Tray, least_way};
use serde::Deserialize;

/// The rigid thing of the level that is the tray, and the target of what is put into it.
pub(crate) const TRAY: &str = "tray";

/// The object of the level that is the ring.
const RING: &str = "ring";

/// The objects of the level that hold the ends of the tissue.
const CLAMPS: [&str; 2] = ["clamp-left", "clamp-right"];

/// What is to be done.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Task {
    /// Hold the tissue of the mark in the ring.
    Hold,
    /// Cut at all marks.
    Cut,
    /// Cut at both marks and put the piece between them into the tray.
    Deliver,
}

/// The level's keys of this module.
#[derive(Clone, Debug, Deserialize)]
pub(crate) struct Keys {
    pub task: Task,
    /// \[s\]
    pub dwell: f64,
    /// \[m\]
    pub mark_radius: f64,
    /// \[m\]
    pub mark_reach: f64,
    /// \[m\]
    pub cut_width: f64,
}

/// A line to be cut, or tissue to be held.
#[derive(Clone, Debug)]
pub(crate) struct Mark {
    pub name: String,
    pub line: MarkLine,
    /// \[m\]
    length: f64,
}

impl Mark {
    fn new(object: &Object) -> Result<Self, Fault> {
        let Shape::Capsule { length, .. } = object.shape else {
            return Err(Fault::new(format!(
                "[[object]] \"{}\": `shape` has to be \"capsule\", as it is a mark to cut along",
                object.name
            )));
        };
        Ok(Self {
            name: object.name.clone(),
            line: MarkLine::new(object)?,
            length,
        })
    }

    /// The ends of its line, at rest \[m\].
    pub fn ends(&self) -> [[f64; 3]; 2] {
        [-0.5, 0.5].map(|share| {
            let MarkLine { middle, along, .. } = &self.line;
            [0, 1, 2].map(|k| middle[k] + share * self.length * along[k])
        })
    }
}

/// A level.
#[derive(Clone, Debug)]
pub(crate) struct Site {
    pub keys: Keys,
    pub body: String,
    /// All tools, in the level's order.
    tools: Vec<String>,
    /// Tools that hold tissue and do not cut it.
    pub holders: Vec<String>,
    /// In their order from the first clamp to the second.
    pub marks: Vec<Mark>,
    pub ring: Option<Ring>,
    pub tray: Option<Tray>,
    clamps: [[f64; 3]; 2],
}

impl Site {
    /// From the set-up of a level.
    pub fn new(setup: &Setup, config: &CourseConfig) -> Result<Self, Fault> {
        let keys: Keys = serde_json::from_value(config.module.clone())?;
        let objects: Vec<Object> = serde_json::from_value(setup.config["objects"].clone())?;
        let marks = mark_places(&objects)?;
        let marks: Result<Vec<Mark>, Fault> = marks.iter().map(Mark::new).collect();
        let marks = marks?;
        let [left, right] = CLAMPS.map(|name| {
            let object = objects.iter().find(|object| object.name == name);
            let object = object.map(|object| object.position);
            object.ok_or_else(|| {
                Fault::new(format!(
                    "the level needs an [[object]] with `name` = \"{name}\" where the tissue is held"
                ))
            })
        });
        let wanted = match keys.task {
            Task::Hold => 1..=1,
            Task::Cut => 1..=usize::MAX,
            Task::Deliver => 2..=2,
        };
        if !wanted.contains(&marks.len()) {
            let count = marks.len();
            return Err(Fault::new(format!(
                "[module] `task`: `hold` needs one [[object]] whose `name` starts with \"mark-\", `deliver` two; the level has {count}"
            )));
        }
        Ok(Self {
            body: tissue_of(setup)?,
            tools: config.tools.iter().map(|tool| tool.name.clone()).collect(),
            holders: config.holders(),
            ring: match keys.task {
                Task::Hold => Some(Ring::named(&objects, RING)?),
                _ => None,
            },
            tray: match keys.task {
                Task::Deliver => Some(Tray::named(setup, TRAY)?),
                _ => None,
            },
            clamps: [left?, right?],
            marks,
            keys,
        })
    }

    /// Ids of the targets.
    pub fn targets(&self) -> Vec<String> {
        let marks = self.marks.iter().map(|mark| mark.name.clone());
        let tray = self.tray.as_ref().map(|_| TRAY.to_owned());
        marks.chain(tray).collect()
    }

    /// The least way of all tools that the task asks for, from where each was first seen \[m\]: of those that cut past the marks, in
    /// the better order; of those that hold from the mark to the ring, or from the piece to the tray. `None` before all of them
    /// were seen.
    pub fn least_way(&self, starts: &[Option<[f64; 3]>]) -> Option<f64> {
        let marks: Vec<[f64; 3]> = self.marks.iter().map(|mark| mark.line.middle).collect();
        let back: Vec<[f64; 3]> = marks.iter().rev().copied().collect();
        let held: Vec<[f64; 3]> = match (&self.ring, &self.tray) {
            (Some(ring), _) => vec![marks[0], ring.centre],
            (_, Some(tray)) => vec![self.parts()[1], tray.centre()],
            // Whether tissue is held while it is cut is left to the trainee.
            (None, None) => Vec::new(),
        };
        let mut sum = 0.0;
        for (index, tool) in self.tools.iter().enumerate() {
            let orders = match self.holders.contains(tool) {
                true => [&held, &held],
                false => [&marks, &back],
            };
            if !orders[0].is_empty() {
                let start = (*starts.get(index)?)?;
                let ways = orders.map(|goals| least_way(start, goals, self.keys.mark_reach));
                sum += ways[0].min(ways[1]);
            }
        }
        Some(sum)
    }

    /// A place in each part that the marks divide the tissue into, at rest \[m\].
    pub fn parts(&self) -> Vec<[f64; 3]> {
        let [left, right] = self.clamps;
        let mut parts = vec![left];
        for pair in self.marks.windows(2) {
            let [a, b] = [pair[0].line.middle, pair[1].line.middle];
            parts.push([0, 1, 2].map(|k| 0.5 * (a[k] + b[k])));
        }
        parts.push(right);
        parts
    }
}
