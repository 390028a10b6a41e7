//! Whoever changes a session, checksums included, is found out, and the tick is named.

use crate::{pushed_strip, recorded_hand};
use microsim_host::record::Session;
use microsim_message::{InputSample, ToolStates, TrainingResult};
use microsim_tests::alter::{
    change_end, change_message, change_tick, last_bit_flipped, rewrite, ticks_with_samples,
};
use microsim_tests::{scratch, verify};
use std::fs;
use std::path::Path;

/// Fails the test unless the replay of these bytes names `tick`; returns its output.
#[track_caller]
fn first_difference(folder: &Path, bytes: &[u8], tick: u64) -> String {
    let session = folder.join("altered.session");
    fs::write(&session, bytes).expect("a file");
    let printed = verify(&session, &[]).expect(1).json();
    assert_eq!(printed["verified"], false, "{printed}");
    // The file itself is in order: only the recomputation can find the change.
    assert_eq!(printed["complaint"], serde_json::Value::Null, "{printed}");
    let difference = &printed["first_difference"];
    assert_eq!(difference["tick"], tick, "{printed}");
    difference["what"].as_str().unwrap_or_default().to_owned()
}

/// Five ticks from the first to the last of a list.
fn spread(ticks: &[u64]) -> [u64; 5] {
    [0, 1, 2, 3, 4].map(|n| ticks[n * (ticks.len() - 1) / 4])
}

/// One coordinate of one sample, by its last bit.
fn one_altered_sample_is_named(bytes: &[u8]) {
    let folder = scratch();
    let read = Session::read(bytes).expect("a session");
    for (n, tick) in spread(&ticks_with_samples(&read)).into_iter().enumerate() {
        let altered = change_tick(bytes, tick, |record| {
            change_message(&mut record.log, |sample: &mut InputSample| {
                let coordinate = &mut sample.pose.position[n % 3];
                *coordinate = last_bit_flipped(*coordinate);
            });
        });
        first_difference(folder.path(), &altered, tick);
    }
}

#[test]
fn one_altered_input_sample_is_named_by_its_tick() {
    one_altered_sample_is_named(recorded_hand());
    one_altered_sample_is_named(pushed_strip());
}

/// Writing a session again without a change is no change: what the other tests find is what they have altered.
#[test]
fn a_session_written_anew_is_the_same_file() {
    let bytes = recorded_hand();
    assert!(rewrite(bytes, |_, _, payload| Some(payload.to_vec())) == bytes);
    assert!(change_tick(bytes, 100, |_| ()) == bytes);
    assert!(change_end(bytes, |_| ()) == bytes);
}

#[test]
fn an_altered_message_of_a_plugin_is_named_with_kind_and_sender() {
    let folder = scratch();
    let bytes = recorded_hand();
    let altered = change_tick(bytes, 1234, |record| {
        change_message(&mut record.log, |states: &mut ToolStates| {
            states.tools[0].opening = 0.5
        });
    });
    let what = first_difference(folder.path(), &altered, 1234);
    assert!(
        what.contains("message \"tool.states\" of \"translator\" differs"),
        "{what}"
    );
}

/// The score of a report is that of the recorded result: it cannot be made better.
#[test]
fn an_altered_score_is_named() {
    let folder = scratch();
    let bytes = recorded_hand();
    let last = Session::read(bytes).expect("a session").ticks.len() as u64 - 1;
    let altered = change_tick(bytes, last, |record| {
        change_message(&mut record.log, |result: &mut TrainingResult| {
            result.score = 100.0
        });
    });
    let what = first_difference(folder.path(), &altered, last);
    assert!(
        what.contains("message \"training.result\" of \"touch-spheres\" differs"),
        "{what}"
    );
}

#[test]
fn an_altered_hash_is_named() {
    let folder = scratch();
    let bytes = recorded_hand();
    let read = Session::read(bytes).expect("a session");
    for tick in [0, 777, read.ticks.len() as u64 - 1] {
        let altered = change_tick(bytes, tick, |record| record.chain[7] ^= 4);
        first_difference(folder.path(), &altered, tick);
    }
    let altered = change_end(bytes, |end| end.chain[0] ^= 1);
    let what = first_difference(folder.path(), &altered, read.ticks.len() as u64);
    assert!(what.contains("at the end"), "{what}");
}

/// The digest of a plugin's state, at the end of an interval of state hashes. A source is not run again; that its
/// digest was altered shows in the running hash of the next tick.
#[test]
fn an_altered_state_digest_is_named_with_its_plugin() {
    let folder = scratch();
    let bytes = pushed_strip();
    let read = Session::read(bytes).expect("a session");
    let hashed: Vec<_> = read
        .ticks
        .iter()
        .filter(|(_, r)| r.states.is_some())
        .collect();
    let (tick, record) = hashed[hashed.len() / 2];
    let plugins = record.states.as_deref().unwrap_or_default();
    assert_eq!(
        plugins.len(),
        5,
        "source, translator, physics, module, objects: {plugins:?}"
    );
    for (n, plugin) in plugins.iter().enumerate() {
        let altered = change_tick(bytes, *tick, |record| {
            record.states.as_mut().expect("states")[n].digest[31] ^= 128;
        });
        if plugin.plugin.starts_with("source-") {
            first_difference(folder.path(), &altered, tick + 1);
        } else {
            let what = first_difference(folder.path(), &altered, *tick);
            assert_eq!(what, format!("the state of {} differs", plugin.plugin));
        }
    }
}

#[test]
fn a_missing_tick_is_named() {
    let folder = scratch();
    let bytes = recorded_hand();
    let is_tick = |kind| kind == microsim_host::record::kind::TICK;
    let altered = rewrite(bytes, |kind, tick, payload| {
        (!is_tick(kind) || tick != 4321).then(|| payload.to_vec())
    });
    let what = first_difference(folder.path(), &altered, 4322);
    assert!(what.contains("tick 4321 is missing"), "{what}");
}
