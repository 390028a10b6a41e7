//! A comb: a band of tissue that scissors cut in from its rim, snip after snip.

use crate::live::{LiveTree, NewLevel};
use microsim_bus::Frames;
use microsim_host::record::Session;
use microsim_message::{Message, TissueCut, decode};
use serde_json::{Value, json};
use std::path::Path;

/// The module of the level.
pub const MODULE: &str = "push-strip";

/// Ticks in which the jaws close, and as many in which they open and go on. In half as many the soft band often slips out between them.
const HALF: u32 = 8;

/// Ticks before the first snip, with the jaws open around the rim.
const APPROACH: u32 = 4;

/// Distance of two snips \[m\]: an edge of the mesh.
const PITCH: f64 = 0.5e-3;

/// Where the first one is \[m\]: not through nodes.
const FIRST: f64 = -25.3e-3;

/// Opening from which the jaws close.
const OPEN: f64 = 0.4;

/// Length of a tick of the level \[s\].
pub const TICK: f64 = 0.008;

/// What the source gives in each tick, for a number of snips. Tools point to the far rim, their jaws open upwards and downwards; the tips stay over the
/// middle of the band, so that each snip is half its width deep.
fn samples(snips: u32) -> Vec<Value> {
    let sample = |x: f64, opening: f64| {
        json!({
            "position": [x, 0.0, 0.0],
            "orientation": [0.5, -0.5, 0.5, 0.5],
            "opening": opening,
        })
    };
    let mut samples = vec![sample(FIRST, OPEN); APPROACH as usize];
    for snip in 0..snips {
        let x = FIRST + PITCH * f64::from(snip);
        for k in 1..=HALF {
            samples.push(sample(x, OPEN * f64::from(HALF - k) / f64::from(HALF)));
        }
        for k in 1..=HALF {
            let share = f64::from(k) / f64::from(HALF);
            // Sideways once the jaws are off the tissue.
            let way = (2.0 * share - 1.0).max(0.0);
            samples.push(sample(x + PITCH * way, OPEN * share));
        }
    }
    samples
}

/// What the source does for this number of snips.
pub fn behaviour(snips: u32) -> Value {
    json!({ "duration": 0.0, "delay": 0, "samples": samples(snips) })
}

/// The built tree with the level of the comb.
pub fn tree(behaviour: &Value) -> LiveTree {
    let level = NewLevel {
        module: MODULE,
        text: include_str!("../data/comb/level.toml"),
    };
    LiveTree::with_level(behaviour, Some(&level))
}

/// The cuts that a session holds, each with its tick.
///
/// # Panics
/// If the session cannot be read.
pub fn cuts(session: &Path) -> Vec<(u64, TissueCut)> {
    let bytes = std::fs::read(session).expect("a session");
    let session = Session::read(&bytes).expect("a session");
    let mut cuts = Vec::new();
    for (tick, record) in &session.ticks {
        for frame in Frames::new(&record.log) {
            if let Some(cut) = decode::<TissueCut>(&frame.expect("a good log")) {
                cuts.push((*tick, cut.expect(TissueCut::KIND)));
            }
        }
    }
    cuts
}

/// In how many snips something was cut.
pub fn snips(cuts: &[(u64, TissueCut)]) -> usize {
    let period = u64::from(2 * HALF);
    let snip = |(tick, _): &(u64, TissueCut)| tick.saturating_sub(u64::from(APPROACH)) / period;
    let mut snips: Vec<u64> = cuts.iter().map(snip).collect();
    snips.dedup();
    snips.len()
}
