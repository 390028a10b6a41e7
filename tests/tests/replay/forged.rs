//! Forged sessions, every chain and checksum computed again as somebody without the key would: none is called verified.

use crate::tree::Tree;
use crate::{recorded_hand, session};
use microsim_bus::frame::push_stamped;
use microsim_bus::{Frames, HOST};
use microsim_host::engine::plan_digest;
use microsim_host::plan::PluginKind;
use microsim_host::record::{Ended, Header, Session, kind};
use microsim_message::{Message, TrainingResult, decode, encode};
use microsim_session::Chain;
use microsim_tests::alter::{change_end, change_header, change_records, insert_before_end};
use microsim_tests::{Finished, scratch, verify};
use std::fs;
use std::sync::OnceLock;
use std::time::{Duration, Instant};

/// A run of touch-spheres that failed.
pub fn failed() -> &'static [u8] {
    static SESSION: OnceLock<Vec<u8>> = OnceLock::new();
    let args = ["--input", "script:level1-fail-wrong-angle.toml"];
    SESSION.get_or_init(|| session("touch-spheres", &args))
}

/// The session with every message passed through `change`, the header through `header`, and all hashes computed again. The module and its
/// objects publish no blocks, so that the chain over messages and states is the state hash.
pub fn forged(
    bytes: &[u8],
    header: impl Fn(&mut Header),
    mut change: impl FnMut(&microsim_bus::Frame<'_>, &mut Vec<u8>),
) -> Vec<u8> {
    let bytes = change_header(bytes, header);
    let plan = Session::read(&bytes).expect("a session").header.plan;
    let mut chain = Chain::from_value(plan_digest(&plan));
    change_records(
        &bytes,
        |tick, record| {
            let mut log = Vec::new();
            for frame in Frames::new(&record.log) {
                change(&frame.expect("a good log"), &mut log);
            }
            record.log = log;
            chain.add(tick, [record.log.as_slice()]);
            record.chain = chain.value().to_vec();
            if let Some(states) = &record.states {
                chain.add(tick + 1, states.iter().map(|s| s.digest.as_slice()));
            }
            chain
        },
        |tick, end, mut chain| {
            chain.add(tick, end.states.iter().map(|s| s.digest.as_slice()));
            end.chain = chain.value().to_vec();
        },
    )
}

/// As it is.
pub fn unchanged(frame: &microsim_bus::Frame<'_>, log: &mut Vec<u8>) {
    push_stamped(log, &frame.header, frame.payload);
}

/// A result that passed with every point.
pub fn passed(frame: &microsim_bus::Frame<'_>, log: &mut Vec<u8>) {
    let Some(result) = decode::<TrainingResult>(frame) else {
        return unchanged(frame, log);
    };
    let mut result = result.expect("a good message");
    result.passed = true;
    result.failed.clear();
    result.reasons.clear();
    result.score = 100.0;
    push_stamped(log, &frame.header, &encode(&result));
}

fn verified(bytes: &[u8]) -> Finished {
    let folder = scratch();
    let path = folder.path().join("forged.session");
    fs::write(&path, bytes).expect("a file");
    verify(&path, &[])
}

/// Not verified: refused, or another outcome found.
#[track_caller]
fn found_out(bytes: &[u8]) -> Finished {
    let printed = verified(bytes);
    assert_ne!(printed.code, Some(0), "{printed:?}");
    if printed.code == Some(1) {
        assert_eq!(printed.json()["recomputed"], false, "{printed:?}");
    }
    printed
}

/// The forger's own tool is right: without a change it writes the same file.
#[test]
fn the_hashes_are_those_of_the_program() {
    let bytes = failed();
    assert!(forged(bytes, |_| (), unchanged) == bytes);
}

/// The kinds of plugins in the file once decided what was computed: declared as sources, none was.
#[test]
fn a_failed_run_does_not_pass_because_its_plugins_are_called_sources() {
    let every = |header: &mut Header| {
        for plugin in &mut header.plan.plugins {
            if !plugin.kind.is_observer() {
                plugin.kind = PluginKind::Source;
            }
        }
    };
    let printed = found_out(&forged(failed(), every, passed));
    assert!(
        printed.err.contains("is recorded as a source"),
        "{printed:?}"
    );
    for kind in [
        PluginKind::Source,
        PluginKind::Recorder,
        PluginKind::Objects,
    ] {
        let module = |header: &mut Header| {
            let plugins = &mut header.plan.plugins;
            let module = plugins.iter_mut().find(|p| p.kind == PluginKind::Module);
            module.expect("a module").kind = kind;
        };
        found_out(&forged(failed(), module, passed));
    }
}

#[test]
fn a_result_of_the_host_or_of_the_source_is_none() {
    for sender in [HOST, 0] {
        let printed = found_out(&forged(
            failed(),
            |_| (),
            |frame, log| {
                unchanged(frame, log);
                if let Some(Ok(_)) = decode::<TrainingResult>(frame) {
                    let mut second = Vec::new();
                    passed(frame, &mut second);
                    let second = Frames::new(&second).next().expect("one").expect("good");
                    let mut header = second.header;
                    header.sender = sender;
                    push_stamped(log, &header, second.payload);
                }
            },
        ));
        let what = printed.json()["first_difference"]["what"].clone();
        let what = what.as_str().unwrap_or_default();
        let named = match sender {
            HOST => "a message of the host that it never publishes",
            _ => TrainingResult::KIND,
        };
        assert!(what.contains(named), "{printed:?}");
    }
}

/// A session that ends with a failure once had its last hash skipped.
#[test]
fn an_end_that_states_a_failure_is_compared_too() {
    let altered = change_end(recorded_hand(), |end| {
        end.ended = Ended::Failure;
        end.chain[3] ^= 1;
    });
    let printed = found_out(&altered);
    assert!(printed.out.contains("contradict"), "{printed:?}");
    let failure = microsim_host::Failure::found("touch-spheres", "stop", 0, "made up");
    let with_failure = insert_before_end(&altered, kind::FAILURE, &encode(&failure));
    let printed = found_out(&with_failure);
    assert!(printed.out.contains("at the end"), "{printed:?}");
}

/// A run of a level with another limit is computed again to the bit, and its verdict is not that of the installed level.
#[test]
fn a_run_of_a_level_with_other_limits_is_not_verified() {
    let tree = Tree::new();
    let level = "modules/touch-spheres/levels/level1.toml";
    let text = fs::read_to_string(tree.path(level)).expect("a level");
    let line = text
        .lines()
        .find(|l| l.starts_with("max = \"120 s"))
        .expect("a limit");
    tree.edit(level, line, "max = \"110 s\"");
    let args = [
        "run",
        "touch-spheres",
        "--session",
        "other.session",
        "--input",
    ];
    let args = [&args[..], &["script:level1-fail-wrong-angle.toml"]].concat();
    tree.microsim(&args).expect(0);
    tree.microsim(&["replay", "other.session", "--verify"])
        .expect(0);
    let bytes = fs::read(tree.path("other.session")).expect("a session");
    let printed = verified(&bytes).expect(1).json();
    assert_eq!(
        printed["first_difference"],
        serde_json::Value::Null,
        "{printed}"
    );
    let settings = serde_json::json!([
        "which files of the level are not as installed",
        "the settings of touch-spheres"
    ]);
    assert_eq!(printed["other_settings"], settings, "{printed}");
}

/// With 2³² − 1 steps in a tick a replay never ended.
#[test]
fn numbers_that_no_run_has_are_refused_at_once() {
    let changes: [fn(&mut Header); 4] = [
        |header| header.plan.steps = u32::MAX,
        |header| header.plan.tick_ns = 1,
        |header| header.plan.tick_ns = u64::MAX,
        |header| header.plan.plugins[1].setup.steps = u32::MAX,
    ];
    for change in changes {
        let altered = forged(failed(), change, unchanged);
        let start = Instant::now();
        let printed = verified(&altered).expect(2);
        assert!(printed.err.contains("no run has "), "{printed:?}");
        assert!(start.elapsed() < Duration::from_secs(10));
    }
}
