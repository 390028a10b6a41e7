//! A reference run as ghost: where its tools were at which simulated time, and how they are drawn, translucent and in a colour that no instrument has.

use microsim_message::{Pose, ToolPlacements, ToolStates, ToolStatus};
use microsim_render::{Item, snapshot};
use microsim_settings::RendererConfig;
use microsim_vocabulary::Finish;

/// Colour of a ghost, sRGB: a violet that neither instruments nor tissue nor the ground below it have.
const COLOUR: [f32; 3] = [0.78, 0.47, 1.0];
/// How much of what lies behind it a ghost hides.
const OPACITY: f32 = 0.55;

/// Where a tool was.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Placed {
    pose: Pose,
    opening: f64,
}

/// A tool of a reference at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GhostTool<'a> {
    /// Its model.
    pub model: &'a str,
    /// Of its tip, in the field frame.
    pub pose: Pose,
    /// From 0, closed, to 1.
    pub opening: f64,
}

/// The tools of a run over simulated time.
#[derive(Clone, Debug, Default)]
pub struct Track {
    /// Slot and model of each tool.
    tools: Vec<(String, String)>,
    /// In ascending order \[s\].
    times: Vec<f64>,
    /// At each time one for each tool; `None` before it was seen.
    placed: Vec<Option<Placed>>,
}

impl Track {
    /// Adds where the tools were at a time \[s\], which is later than those before: where they were placed, else where they were tracked. Tools that the
    /// first time does not have are left out.
    pub fn add(&mut self, time: f64, states: &ToolStates, placements: Option<&ToolPlacements>) {
        if self.times.is_empty() {
            let tools = states.tools.iter();
            self.tools = tools
                .map(|tool| (tool.tool.clone(), tool.model.clone()))
                .collect();
        }
        self.times.push(time);
        for (slot, _) in &self.tools {
            let state = states.tools.iter().find(|state| state.tool == *slot);
            let seen = state.filter(|state| state.status != ToolStatus::NeverSeen);
            let mut placed = placements.iter().flat_map(|placements| &placements.tools);
            let placed = placed.find(|placed| placed.tool == *slot);
            self.placed.push(seen.map(|state| Placed {
                pose: placed.map_or(state.pose, |placed| placed.pose),
                opening: placed.map_or(state.opening, |placed| placed.opening),
            }));
        }
    }

    /// The last time \[s\]; 0 without any.
    pub fn end(&self) -> f64 {
        self.times.last().copied().unwrap_or_default()
    }

    /// The tools at a time \[s\]; nothing before the first time and after the last one.
    pub fn at(&self, time: f64) -> impl Iterator<Item = GhostTool<'_>> {
        let later = self.times.partition_point(|known| *known <= time);
        let is_over = time > self.end();
        let place = later.checked_sub(1).filter(|_| !is_over);
        let count = self.tools.len();
        let placed = place.map_or(&[][..], |place| {
            &self.placed[place * count..(place + 1) * count]
        });
        let tools = self.tools.iter().zip(placed);
        tools.filter_map(|((_, model), placed)| {
            let Placed { pose, opening } = (*placed)?;
            Some(GhostTool {
                model,
                pose,
                opening,
            })
        })
    }

    /// What is drawn of it at a time \[s\].
    pub fn items(&self, config: &RendererConfig, time: f64) -> Vec<Item> {
        let drawn = self.at(time).filter_map(|tool| {
            let model = config.models.get(tool.model)?;
            let (pose, opening) = (tool.pose, tool.opening);
            Some(snapshot::tool(tool.model, model, pose, opening, OPACITY))
        });
        let ghost = |item: Item| Item {
            colour: COLOUR,
            finish: Finish::Matte,
            ..item
        };
        drawn.flatten().map(ghost).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use microsim_message::{ToolPlacement, ToolState};
    use microsim_render::Shape;
    use microsim_settings::{View, read_tool};

    const ROD: &str = r##"doc = "A rod."
colour = "#ff0000"
[title]
de = "Stab"
en = "Rod"
[[capsule]]
name = "rod"
a = [0, 0, 0]
b = [0, 0, "5 mm"]
radius = "0.5 mm"
"##;

    fn at(x: f64) -> Pose {
        Pose {
            position: [x, 0.0, 0.0],
            orientation: [0.0, 0.0, 0.0, 1.0],
        }
    }

    fn states(left: f64, status: ToolStatus) -> ToolStates {
        let state = |tool: &str, status, x| ToolState {
            tool: tool.into(),
            model: "rod".into(),
            status,
            pose: at(x),
            opening: 0.0,
        };
        ToolStates {
            tools: vec![
                state("left", ToolStatus::Tracked, left),
                state("right", status, 5.0),
            ],
        }
    }

    /// Where the drawn capsules begin along x \[m\], with their look.
    fn drawn(track: &Track, time: f64) -> Vec<f64> {
        let rod = read_tool(ROD, "rod.toml").expect("a tool").settings;
        let config = RendererConfig {
            view: View {
                field: 0.02,
                centre: [0.0; 3],
                tilt: 0.0,
            },
            models: [("rod".to_owned(), rod)].into(),
            bodies: Vec::new(),
            width: 64,
            height: 64,
            caption: None,
            mirrored: false,
            views: Vec::new(),
        };
        let items = track.items(&config, time).into_iter();
        let begin = |item: Item| {
            assert_eq!(
                (item.colour, item.opacity, item.finish),
                (COLOUR, OPACITY, Finish::Matte)
            );
            match item.shape {
                Shape::Capsule { a, .. } => a[0],
                shape => panic!("{shape:?}"),
            }
        };
        items.map(begin).collect()
    }

    /// The latest known place counts, a placement before the tracked pose; a tool that was never seen is not there, and neither is the ghost before its first and after
    /// its last time.
    #[test]
    fn a_ghost_is_where_its_tools_were_at_that_time() {
        let mut track = Track::default();
        track.add(0.008, &states(1.0, ToolStatus::NeverSeen), None);
        track.add(0.016, &states(2.0, ToolStatus::Tracked), None);
        let placements = ToolPlacements {
            tick: 2,
            tools: vec![ToolPlacement {
                tool: "left".into(),
                pose: at(7.0),
                opening: 0.0,
            }],
        };
        track.add(0.024, &states(3.0, ToolStatus::Occluded), Some(&placements));
        assert_eq!(drawn(&track, 0.001), [] as [f64; 0]);
        assert_eq!(drawn(&track, 0.008), [1.0]);
        assert_eq!(drawn(&track, 0.0159), [1.0]);
        assert_eq!(drawn(&track, 0.016), [2.0, 5.0]);
        assert_eq!(drawn(&track, 0.024), [7.0, 5.0]);
        assert_eq!(drawn(&track, 0.025), [] as [f64; 0]);
        assert_eq!(track.end(), 0.024);
        assert_eq!(drawn(&Track::default(), 0.0), [] as [f64; 0]);
    }
}
