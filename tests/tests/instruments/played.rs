//! A level played over a socket by a pyigtl script: with `clock = "device"` it has the score and the physics digest of the same poses by `script:`.
//!
//! The protocol has single precision, so the same poses are those that came: they are read from the recorded session, compared with what was sent, and played by a script with
//! a key for each.

use microsim_bus::Frames;
use microsim_host::record::Session;
use microsim_message::{InputSample, decode};
use microsim_settings::load_script;
use microsim_tests::peers::{free_port, or_skipped, python, start_script};
use microsim_tests::{command, config_with, finish, repository, scratch};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fmt::Write;
use std::fs;
use std::path::Path;

/// What a run of a level gives.
fn played(module: &str, level: &str, config: Option<&Path>, input: &str, session: &Path) -> Value {
    let mut run = match config {
        Some(config) => command(["--config".as_ref(), config.as_os_str()]),
        None => command::<[&str; 0], &str>([]),
    };
    run.args([
        "run",
        module,
        "--level",
        level,
        "--json",
        "--input",
        input,
        "--session",
    ]);
    finish(run.arg(session)).expect(0).json()
}

fn samples(session: &Path) -> Vec<InputSample> {
    let session = Session::read(&fs::read(session).expect("a session")).expect("a session");
    let logs = session.ticks.iter().map(|(_, tick)| &tick.log[..]);
    let frames = logs.flat_map(|log| Frames::new(log).filter_map(Result::ok));
    let samples = frames.filter_map(|frame| decode::<InputSample>(&frame));
    samples.map(|sample| sample.expect("a sample")).collect()
}

/// Samples per second \[Hz\]: their times are multiples of 2⁻⁶ s, which are exact in the stamps of the protocol and come through pyigtl, whose conversion of other times is
/// off by some nanoseconds.
const RATE: f64 = 64.0;

/// The samples of a script that the level has.
fn scripted(script: &Path) -> Vec<InputSample> {
    let script = load_script(script).expect("a script").settings;
    let motion = script.motion().expect("a motion");
    motion.samples(RATE).collect()
}

/// As pyigtl sends them: the opening of a tool as the x coordinate of a device of its own, before its pose.
fn sent(samples: &[InputSample]) -> Value {
    let mut rows = Vec::new();
    for sample in samples {
        let [x, y, z] = sample.pose.position.map(|x| 1e3 * x);
        let [qx, qy, qz, qw] = sample.pose.orientation;
        let opening = 1e3 * sample.opening.expect("an opening");
        let (time, device) = (sample.device_time, &sample.device);
        rows.push(json!([
            time,
            format!("{device}-opening"),
            opening,
            0.0,
            0.0,
            0.0,
            0.0,
            0.0,
            1.0
        ]));
        rows.push(json!([time, device, x, y, z, qx, qy, qz, qw]));
    }
    Value::Array(rows)
}

/// A script with a key for each sample.
fn script_of(samples: &[InputSample]) -> String {
    let mut tools: BTreeMap<&str, String> = BTreeMap::new();
    for sample in samples {
        let keys = tools.entry(&sample.device).or_default();
        let _ = write!(
            keys,
            "[[tool.key]]\nt = {:?}\nposition = {:?}\norientation = {:?}\nopening = {:?}\n",
            sample.device_time,
            sample.pose.position,
            sample.pose.orientation,
            sample.opening.expect("an opening")
        );
    }
    let tools = tools
        .iter()
        .map(|(name, keys)| format!("[[tool]]\nname = \"{name}\"\n{keys}"));
    format!(
        "rate = {RATE:?}\ninterpolation = \"linear\"\n{}",
        tools.collect::<String>()
    )
}

fn check(module: &str, level: &str, script: &str) {
    let Some(python) = or_skipped("pyigtl", python()) else {
        return;
    };
    let folder = scratch();
    let at = |name: &str| folder.path().join(name);
    let scripts = repository().join("modules").join(module).join("scripts");
    let wanted = scripted(&scripts.join(script));
    fs::write(at("motion.json"), sent(&wanted).to_string()).expect("the motion");

    let port = free_port();
    let tools: BTreeMap<&str, ()> = wanted
        .iter()
        .map(|sample| (&sample.device[..], ()))
        .collect();
    let tools = tools.keys().map(|name| {
        format!("[[device]]\nname = \"{name}\"\ndevice = \"{name}\"\nopening = {{ name = \"{name}-opening\", open = \"1 m\" }}\n")
    });
    let settings = format!(
        "role = \"server\"\naddress = \"127.0.0.1:{port}\"\nclock = \"device\"\n{}",
        tools.collect::<String>()
    );
    let config = config_with(folder.path(), "openigtlink.toml", &settings);
    // Devices drive the tools of their own names; the shipped file has another one for the right hand.
    let translator = config.join("translator.toml");
    fs::remove_file(&translator).expect("a link");
    fs::write(translator, "stale_after = \"100 ms\"\n").expect("the settings");
    let motion = at("motion.json");
    let peer = start_script(
        &python,
        "play.py",
        [port.to_string(), motion.display().to_string()],
    );
    let live = played(
        module,
        level,
        Some(&config),
        "plugin:openigtlink",
        &at("live.session"),
    );
    drop(peer);

    // What came is what was sent, to single precision, at exactly its time.
    let came = samples(&at("live.session"));
    assert!(
        came.len() * 2 >= wanted.len(),
        "{} of {}",
        came.len(),
        wanted.len()
    );
    for (found, expected) in came.iter().zip(&wanted) {
        assert_eq!(
            (&found.device, found.device_time),
            (&expected.device, expected.device_time)
        );
        for axis in 0..3 {
            let off = found.pose.position[axis] - expected.pose.position[axis];
            // Half a unit in the last place of 16 mm in single precision.
            assert!(off.abs() <= 0.5e-9, "{found:?} {expected:?}");
        }
    }
    // The level may have ended before the motion did: the rest as it was sent has no part in it.
    let mut all = came.clone();
    for sample in &wanted[came.len().min(wanted.len())..] {
        all.push(sample.clone());
    }
    fs::write(at("same.toml"), script_of(&all)).expect("the script");
    let input = format!("script:{}", at("same.toml").display());
    let same = played(module, level, None, &input, &at("same.session"));
    for key in ["verdict", "score", "ticks", "physics_digest"] {
        assert_eq!(live[key], same[key], "{key}: {live} {same}");
    }
    assert_eq!(live["verdict"], "passed", "{live}");
    assert_verified_with(&config, &at("live.session"));
}

/// The session of a tracker replays without it.
fn assert_verified_with(config: &Path, session: &Path) {
    let mut verify = command(["--config".as_ref(), config.as_os_str()]);
    verify.args(["replay", "--verify", "--json"]).arg(session);
    let printed = finish(&mut verify).expect(0).json();
    assert_eq!(printed["verified"], true, "{printed}");
}

#[test]
fn touch_spheres_over_a_socket_is_that_of_a_script() {
    check("touch-spheres", "1", "level1-pass.toml");
}

#[test]
fn coordination_over_a_socket_is_that_of_a_script() {
    check("coordination", "2", "level2-pass.toml");
}
