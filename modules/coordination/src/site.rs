//! What a level asks for, from its file: marks, clamps, ring, tray, and which tools hold.

use microsim_sdk::tissue::{MarkLine, Ring, mark_places, tissue_of};
use microsim_sdk::{Fault, ModuleConfig, Object, Shape, Tray, shortest_path};
use serde::Deserialize;

/// The obstacle of the level that is the tray, and the target of what is put into it.
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
        [-0.5, 0.5].map(|fraction| {
            let MarkLine { middle, along, .. } = &self.line;
            [0, 1, 2].map(|k| middle[k] + fraction * self.length * along[k])
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
    /// From the configuration of a level.
    pub fn new(config: &ModuleConfig) -> Result<Self, Fault> {
        let keys: Keys = serde_json::from_value(config.module.clone())?;
        let objects = &config.objects;
        let marks = mark_places(objects)?;
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
        let clamps = [left?, right?];
        in_order(&marks, clamps)?;
        let holders = config.holders();
        let (holds, cuts) = (!holders.is_empty(), holders.len() < config.tools.len());
        if keys.task != Task::Cut && !holds {
            return Err(Fault::new(
                "[module] `task`: `hold` and `deliver` need a [[tool]] that does not cut",
            ));
        }
        if keys.task != Task::Hold && !cuts {
            return Err(Fault::new(
                "[module] `task`: `cut` and `deliver` need a [[tool]] that cuts",
            ));
        }
        Ok(Self {
            body: tissue_of(config)?,
            tools: config.tools.iter().map(|tool| tool.name.clone()).collect(),
            holders,
            ring: match keys.task {
                Task::Hold => Some(Ring::named(objects, RING)?),
                _ => None,
            },
            tray: match keys.task {
                Task::Deliver => Some(Tray::named(&config.rigid, TRAY)?),
                _ => None,
            },
            clamps,
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

    /// The shortest path of all tools that the task asks for, from where each was first seen \[m\]; one that was not has none.
    /// Whether tissue is held while it is cut is left to the trainee: only if it `was_held`, that is part of the task `cut`.
    pub fn shortest_path(&self, starts: &[Option<[f64; 3]>], was_held: bool) -> f64 {
        let paths = self.tools.iter().zip(starts).filter_map(|(tool, start)| {
            let holds = self.holders.contains(tool);
            let idle = holds && self.keys.task == Task::Cut && !was_held;
            Some(self.shortest_path_of(holds, (*start)?)).filter(|_| !idle)
        });
        paths.sum()
    }

    /// That of one tool. If it cuts, past the marks, in the better order; if it `holds`, from the mark to the ring, or from the piece to
    /// where it falls into the tray, or just to the tissue.
    fn shortest_path_of(&self, holds: bool, start: [f64; 3]) -> f64 {
        let path = |goals: &[[f64; 3]]| shortest_path(start, goals, self.keys.mark_reach);
        let marks: Vec<[f64; 3]> = self.marks.iter().map(|mark| mark.line.middle).collect();
        match (holds, &self.ring, &self.tray) {
            (true, Some(ring), _) => path(&[marks[0], ring.centre]),
            (true, None, Some(tray)) => {
                let piece = self.parts()[1];
                path(&[piece, tray.nearest(piece)])
            }
            (true, None, None) => path(&[between(self.clamps, start)]),
            (false, Some(_), _) => 0.0,
            (false, None, _) => {
                let back: Vec<[f64; 3]> = marks.iter().rev().copied().collect();
                path(&marks).min(path(&back))
            }
        }
    }

    /// The lines of the marks, in their order.
    pub fn lines(&self) -> Vec<MarkLine> {
        self.marks.iter().map(|mark| mark.line.clone()).collect()
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

/// A fault unless each mark lies farther from the first clamp towards the second than the one before, and short of it.
fn in_order(marks: &[Mark], [left, right]: [[f64; 3]; 2]) -> Result<(), Fault> {
    let line = [0, 1, 2].map(|k| right[k] - left[k]);
    let along = |place: [f64; 3]| -> f64 { (0..3).map(|k| (place[k] - left[k]) * line[k]).sum() };
    let mut last = 0.0;
    for mark in marks {
        let here = along(mark.line.middle);
        if here <= last || here >= along(right) {
            return Err(Fault::new(format!(
                "[[object]] \"{}\": its `position` has to lie between the clamps, and marks have to follow each other from \"{}\" to \"{}\"",
                mark.name, CLAMPS[0], CLAMPS[1]
            )));
        }
        last = here;
    }
    Ok(())
}

/// The place nearest to `place` on the line between two others \[m\].
fn between([a, b]: [[f64; 3]; 2], place: [f64; 3]) -> [f64; 3] {
    let line = [0, 1, 2].map(|k| b[k] - a[k]);
    let along: f64 = (0..3).map(|k| (place[k] - a[k]) * line[k]).sum();
    let size: f64 = line.iter().map(|c| c * c).sum();
    let fraction = (along / size).clamp(0.0, 1.0);
    [0, 1, 2].map(|k| a[k] + fraction * line[k])
}
