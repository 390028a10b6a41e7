//! One tool and the wire within a tick: where the wire goes through its jaws, and whether they touch it.

use crate::wire::Wire;
use microsim_sdk::geometry::{self, closest_segments};
use microsim_sdk::message::Pose;
use microsim_sdk::{Passage, ToolShape};
use serde::{Deserialize, Serialize};

/// Between two poses that are looked at no end of a jaw moves farther than this fraction of the wire's radius \[-\], so that nothing gets
/// through the wire unseen; but see [`MOST`].
const STEP: f64 = 0.5;
/// Poses within a tick at most: the fastest hands, of 1 m/s, move by 8 mm in one of 8 ms, 64 half radii of a wire of 0.25 mm.
const MOST: usize = 128;

/// Where a tool was.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Held {
    pub pose: Pose,
    pub opening: f64,
}

/// What was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Found {
    /// The link that a part of the tool touched in this tick, the last one.
    pub touched: Option<usize>,
    /// Where along the wire \[m\] and how it goes through the jaws at the end of the tick.
    pub passage: Option<(f64, Passage)>,
}

/// The tool on its path between two ticks. Of several places at which the wire goes through the jaws the one nearest to `near` \[m\] is taken.
pub(crate) fn look(shape: &ToolShape, wire: &Wire, from: Held, to: Held, near: f64) -> Found {
    let steps = steps(shape, wire, from, to);
    let pose = |held: Held| geometry::Pose::from_arrays(held.pose.position, held.pose.orientation);
    let (start, end) = (pose(from), pose(to));
    let mut touched = None;
    for step in 1..=steps {
        let t = step as f64 / steps as f64;
        let at = start.interpolate(&end, t);
        let pose = Pose {
            position: at.position.into(),
            orientation: at.orientation.coords.into(),
        };
        let opening = from.opening + t * (to.opening - from.opening);
        touched = touch(shape, wire, pose, opening).or(touched);
    }
    let mouth = shape.mouth(to.pose, to.opening);
    let passages = (0..wire.len()).filter_map(|index| {
        let link = wire.capsule(index);
        let passage = mouth.passage(&link.a, &link.b)?;
        Some(((index as f64 + passage.t) * wire.link(), passage))
    });
    let away = |passage: &(f64, Passage)| (passage.0 - near).abs();
    Found {
        touched,
        passage: passages.min_by(|a, b| away(a).total_cmp(&away(b))),
    }
}

/// How many poses between two ticks are looked at.
fn steps(shape: &ToolShape, wire: &Wire, from: Held, to: Held) -> usize {
    let ends = shape
        .parts(from.pose, from.opening)
        .zip(shape.parts(to.pose, to.opening));
    let moved = ends.map(|(a, b)| (b.a - a.a).norm().max((b.b - a.b).norm()));
    let farthest = moved.fold(0.0, f64::max);
    ((farthest / (STEP * wire.capsule(0).radius)).ceil() as usize).clamp(1, MOST)
}

/// The link that a part of the tool touches.
fn touch(shape: &ToolShape, wire: &Wire, pose: Pose, opening: f64) -> Option<usize> {
    shape.parts(pose, opening).find_map(|part| {
        (0..wire.len()).find(|index| {
            let link = wire.capsule(*index);
            let reach = part.radius + link.radius;
            closest_segments(&part.a, &part.b, &link.a, &link.b).distance_squared() <= reach * reach
        })
    })
}
