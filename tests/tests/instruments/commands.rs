//! `microsim calibrate`, `devices`, `record-input`: what they write is what runs use.

use microsim_host::record::Session;
use microsim_message::{ToolSample, decode};
use microsim_tests::{RECORDING, command, finish, scratch};
use nalgebra::{UnitQuaternion, Vector3};
use std::fmt::Write;
use std::fs;
use std::path::Path;
use std::process::Command;

/// A tip as that of forceps `[m]`.
const TIP: [f64; 3] = [4e-3, -2e-3, -0.13];

fn in_folder(data: &Path) -> Command {
    command(["--data".as_ref(), data.as_os_str()])
}

const MAP: &str = "licence = \"none\"\nsource = \"made by a test\"\n[time]\ncolumn = \"t\"\nunit = \"s\"\n[[device]]\nname = \"right\"\n\
    position = [\"x\", \"y\", \"z\"]\nposition_unit = \"m\"\nquaternion = [\"qx\", \"qy\", \"qz\", \"qw\"]\n";

/// A recording of poses, 10 ms apart.
fn recording(path: &Path, poses: impl Iterator<Item = (UnitQuaternion<f64>, Vector3<f64>)>) {
    let mut csv = String::from("t,x,y,z,qx,qy,qz,qw\n");
    for (step, (turn, place)) in poses.enumerate() {
        let q = turn.coords;
        let numbers = [place.x, place.y, place.z, q.x, q.y, q.z, q.w];
        let numbers = numbers.map(|x| format!("{x:?}"));
        let _ = writeln!(csv, "{:?},{}", step as f64 * 0.01, numbers.join(","));
    }
    fs::write(path, csv).expect("the recording");
    fs::write(path.with_extension("toml"), MAP).expect("the column map");
}

/// A handle that is tilted to all sides and turned about its axis, its tip standing at a point.
fn turned(step: u32) -> (UnitQuaternion<f64>, Vector3<f64>) {
    let time = f64::from(step) * 0.01;
    let tilt = Vector3::new(
        0.5 * libm::sin(1.1 * time),
        0.5 * libm::sin(1.7 * time + 1.0),
        0.0,
    );
    let turn = UnitQuaternion::from_scaled_axis(tilt)
        * UnitQuaternion::from_scaled_axis(Vector3::new(0.0, 0.0, libm::sin(0.7 * time)));
    let place = Vector3::new(0.05, -0.2, 0.8) - turn * Vector3::from(TIP);
    (turn, place)
}

/// A tip from a recording, written into the data folder, is what a run uses and shows; too little rotation, and a tip that moves, write nothing.
#[test]
fn a_calibrated_tip_is_used_and_shown() {
    let folder = scratch();
    let at = |name: &str| folder.path().join(name);
    let data = at("data");
    recording(&at("turned.csv"), (0..600).map(turned));
    let pivot = |file: &str, more: &[&str]| {
        let mut calibrate = in_folder(&data);
        calibrate.args(["calibrate", "pivot", "right", "--json", "--input"]);
        finish(calibrate.arg(at(file)).args(more))
    };
    let dry = pivot("turned.csv", &["--dry-run"]).expect(0).json();
    assert_eq!(
        (dry["good"].as_bool(), dry["written"].is_null()),
        (Some(true), true),
        "{dry}"
    );
    assert!(!data.join("config/calibration.toml").exists());

    recording(
        &at("one.csv"),
        (0..600).map(|step| {
            let turn =
                UnitQuaternion::from_scaled_axis(Vector3::new(0.0, 0.0, f64::from(step) * 0.01));
            (
                turn,
                Vector3::new(0.05, -0.2, 0.8) - turn * Vector3::from(TIP),
            )
        }),
    );
    let refused = pivot("one.csv", &[]).expect(2);
    assert!(
        refused.err.contains("tilt the handle by 30°"),
        "{refused:?}"
    );
    recording(
        &at("moved.csv"),
        (0..600).map(|step| {
            let (turn, place) = turned(step);
            (
                turn,
                place + Vector3::x() * 4e-3 * libm::sin(f64::from(step)),
            )
        }),
    );
    let moved = pivot("moved.csv", &[]).expect(1).json();
    assert_eq!(
        (moved["good"].as_bool(), moved["written"].is_null()),
        (Some(false), true),
        "{moved}"
    );
    assert!(!data.join("config/calibration.toml").exists());

    let found = pivot("turned.csv", &[]).expect(0).json();
    for (axis, expected) in TIP.iter().enumerate() {
        let tip = found["tip_m"][axis].as_f64().expect("a number");
        assert!((tip - expected).abs() < 1e-12, "{found}");
    }

    // A run on the recording of the rotation: the tip stands at one point although the handle moves.
    let input = format!("recording:{}", at("turned.csv").display());
    let mut explain = in_folder(&data);
    explain.args(["run", "touch-spheres", "--explain", "--input", &input]);
    let shown = finish(&mut explain).expect(0).out;
    assert!(
        shown.contains("(4.00, -2.00, -130.00) mm of the handle"),
        "{shown}"
    );
    let mut run = in_folder(&data);
    run.args([
        "run",
        "touch-spheres",
        "--json",
        "--input",
        &input,
        "--session",
    ]);
    finish(run.arg(at("x.session"))).expect(0);
    let tips = tips(&at("x.session"));
    assert!(tips.len() > 100, "{}", tips.len());
    for tip in &tips {
        let off = Vector3::from(*tip) - Vector3::new(0.05, -0.2, 0.8);
        assert!(off.norm() < 1e-12, "{tip:?}");
    }
    // Without the calibration of this station it is the handle that is shown; the session goes by what it was recorded with.
    let mut verify = command(["replay", "--verify", "--json"]);
    let verified = finish(verify.arg(at("x.session"))).expect(0).json();
    assert_eq!(verified["verified"], true, "{verified}");
}

fn tips(session: &Path) -> Vec<[f64; 3]> {
    let session = Session::read(&fs::read(session).expect("a session")).expect("a session");
    let logs = session.ticks.iter().map(|(_, tick)| &tick.log[..]);
    let frames = logs.flat_map(|log| microsim_bus::Frames::new(log).filter_map(Result::ok));
    let samples = frames.filter_map(|frame| decode::<ToolSample>(&frame)?.ok());
    samples
        .filter(|sample| sample.tracked)
        .map(|sample| sample.pose.position)
        .collect()
}

/// A frame that was registered from pairs of points is where the tool is; with a point that was touched beside its place nothing is written.
#[test]
fn a_registered_frame_is_used() {
    let folder = scratch();
    let at = |name: &str| folder.path().join(name);
    let data = at("data");
    let turn = UnitQuaternion::from_scaled_axis(Vector3::new(0.4, -0.7, 1.1));
    let shift = Vector3::new(0.3, -0.1, 0.6);
    let points = [
        [0.0, 0.0, 0.0],
        [80.0, 0.0, 0.0],
        [80.0, 60.0, 0.0],
        [0.0, 60.0, 0.0],
        [40.0, 30.0, 20.0],
    ];
    // One of the points is touched so far beside its place [mm].
    let pairs = |beside: f64| {
        let mut csv = String::from("device_x,device_y,device_z,field_x,field_y,field_z\n");
        for (index, field) in points.into_iter().enumerate() {
            let mut d = turn.inverse() * (Vector3::from(field) * 1e-3 - shift) * 1e3;
            d.x += if index == 2 { beside } else { 0.0 };
            let [x, y, z] = field;
            let _ = writeln!(csv, "{:?},{:?},{:?},{x:?},{y:?},{z:?}", d.x, d.y, d.z);
        }
        csv
    };
    fs::write(at("beside.csv"), pairs(5.0)).expect("pairs");
    fs::write(at("good.csv"), pairs(0.0)).expect("pairs");
    let workspace = |file: &str| {
        let mut calibrate = in_folder(&data);
        calibrate.args([
            "calibrate",
            "workspace",
            "--json",
            "--devices",
            "right",
            "--pairs",
        ]);
        finish(calibrate.arg(at(file)))
    };
    workspace("beside.csv").expect(1);
    assert!(!data.join("config/calibration.toml").exists());
    let found = workspace("good.csv").expect(0).json();
    assert_eq!(
        found["residuals_m"].as_array().map(Vec::len),
        Some(5),
        "{found}"
    );

    let place = Vector3::new(0.002, 0.003, 0.012);
    let device = turn.inverse() * (place - shift);
    recording(&at("still.csv"), (0..100).map(|_| (turn.inverse(), device)));
    let mut run = in_folder(&data);
    let input = format!("recording:{}", at("still.csv").display());
    run.args([
        "run",
        "touch-spheres",
        "--json",
        "--input",
        &input,
        "--session",
    ]);
    finish(run.arg(at("x.session"))).expect(0);
    for tip in tips(&at("x.session")) {
        assert!((Vector3::from(tip) - place).norm() < 1e-12, "{tip:?}");
    }
}

/// The recorded hand, recorded once more from the input that plays it: the same samples, the same run to the bit; and `devices` counts it.
#[test]
fn an_input_that_is_recorded_plays_the_same_run() {
    let folder = scratch();
    let at = |name: &str| folder.path().join(name);
    let mut record = command(["record-input", "--json"]);
    record.arg(at("again.csv")).args(["--input", RECORDING]);
    let made = finish(&mut record).expect(0).json();
    assert_eq!(
        (made["left_out"].as_u64(), made["samples"].as_u64()),
        (Some(0), Some(3466)),
        "{made}"
    );
    let again = format!("recording:{}", at("again.csv").display());
    let mut refused = command(["record-input"]);
    let refused = finish(refused.arg(at("again.csv")).args(["--input", RECORDING])).expect(2);
    assert!(
        refused.err.contains("nothing is overwritten"),
        "{refused:?}"
    );
    let run = |input: &str, name: &str| {
        microsim_tests::run("touch-spheres", &at(name), &["--input", input])
    };
    let (first, second) = (run(RECORDING, "a.session"), run(&again, "b.session"));
    for key in ["physics_digest", "score", "ticks"] {
        assert_eq!(first[key], second[key], "{key}");
    }
    let mut devices = command(["devices", "--json", "--input", &again]);
    let heard = finish(&mut devices).expect(0).json();
    let stylus = &heard["devices"][0];
    assert_eq!(
        (
            stylus["name"].as_str(),
            stylus["samples"].as_u64(),
            stylus["late"].as_u64()
        ),
        (Some("stylus"), Some(3466), Some(0)),
        "{heard}"
    );
    let words = finish(&mut command(["devices", "--input", &again]))
        .expect(0)
        .out;
    assert!(
        words.contains("stylus") && words.contains("3466"),
        "{words}"
    );
}
