//! A left-handed trainee: what the mirror image of a motion does in a mirrored level is what the motion does in the level, to the bit.

use microsim_settings::load_script;
use microsim_tests::{assert_verified, command, finish, report_beside, repository, scratch};
use serde_json::Value;
use std::fmt::Write;
use std::fs;
use std::path::Path;

/// A run of coordination, level 2.
fn played(input: &str, hand: &str, session: &Path) -> Value {
    let mut run = command(["run", "coordination", "--level", "2", "--json", "--hand"]);
    run.args([hand, "--input", input, "--session"]).arg(session);
    finish(&mut run).expect(0).json()
}

/// Samples per second of the recordings \[Hz\].
const RATE: f64 = 100.0;

/// The passing script as recordings of both hands: as they are, or seen in the mirror x → −x with the devices exchanged.
fn record(script: &Path, mirrored: bool, file: &Path) {
    let script = load_script(script).expect("a script").settings;
    let motion = script.motion().expect("a motion");
    let mut text = "t".to_owned();
    for device in ["left", "right"] {
        for column in ["x", "y", "z", "qx", "qy", "qz", "qw", "open", "seen"] {
            let _ = write!(text, ",{device}-{column}");
        }
    }
    text.push('\n');
    let samples: Vec<_> = motion.samples(RATE).collect();
    for row in samples.chunk_by(|a, b| a.device_time == b.device_time) {
        let _ = write!(text, "{:?}", row[0].device_time);
        for device in ["left", "right"] {
            let held = match (mirrored, device) {
                (false, device) => device,
                (true, "left") => "right",
                (true, _) => "left",
            };
            let Some(sample) = row.iter().find(|sample| sample.device == held) else {
                text.push_str(",0,0,0,0,0,0,1,0,0");
                continue;
            };
            let [x, y, z] = sample.pose.position;
            let [qx, qy, qz, qw] = sample.pose.orientation;
            let side = if mirrored { -1.0 } else { 1.0 };
            let opening = sample.opening.expect("an opening");
            let (x, qy, qz) = (side * x, side * qy, side * qz);
            let _ = write!(
                text,
                ",{x:?},{y:?},{z:?},{qx:?},{qy:?},{qz:?},{qw:?},{opening:?},1"
            );
        }
        text.push('\n');
    }
    fs::write(file, text).expect("a recording");
    let mut map =
        "licence = \"MIT\"\nsource = \"a script\"\n[time]\ncolumn = \"t\"\nunit = \"s\"\n"
            .to_owned();
    for device in ["left", "right"] {
        let at = |column: &str| format!("\"{device}-{column}\"");
        let all = |columns: &[&str]| columns.iter().map(|c| at(c)).collect::<Vec<_>>().join(", ");
        let _ = write!(
            map,
            "[[device]]\nname = \"{device}\"\nposition = [{}]\nposition_unit = \"m\"\nquaternion = [{}]\nopening = {{ column = {}, closed = 0, open = 1 }}\nvisible = {}\n",
            all(&["x", "y", "z"]),
            all(&["qx", "qy", "qz", "qw"]),
            at("open"),
            at("seen"),
        );
    }
    fs::write(file.with_extension("toml"), map).expect("its columns");
}

/// Negating a number is exact: pieces, forces and score are the same to the bit. Without the mirror the same recording touches something else.
#[test]
fn the_mirror_image_of_a_motion_does_the_same_in_a_mirrored_level() {
    let folder = scratch();
    let at = |name: &str| folder.path().join(name);
    let script = repository().join("modules/coordination/scripts/level2-pass.toml");
    let run = |name: &str, mirrored: bool, hand: &str| {
        let file = at(&format!("{name}.csv"));
        record(&script, mirrored, &file);
        let input = format!("recording:{}", file.display());
        played(&input, hand, &at(&format!("{name}.session")))
    };
    let right = run("right", false, "right");
    let left = run("left", true, "left");
    assert_eq!(right["verdict"], "passed", "{right}");
    for key in ["verdict", "score", "ticks", "physics_digest"] {
        assert_eq!(left[key], right[key], "{key}: {left} {right}");
    }
    let unmirrored = run("unmirrored", true, "right");
    assert_ne!(unmirrored["physics_digest"], right["physics_digest"]);

    assert_verified(&at("left.session"));
    let report = report_beside(&at("left.session"));
    assert_eq!(report["session"]["mirrored"], true);
    assert_eq!(
        report_beside(&at("right.session"))["session"].get("mirrored"),
        None
    );
}

/// A script moves in the level's own field: the level is computed as for a right hand, and shown mirrored.
#[test]
fn a_script_is_shown_mirrored_and_moves_as_it_is() {
    let folder = scratch();
    let played = |hand: &str| {
        let session = folder.path().join(format!("{hand}.session"));
        let run = played("script:level2-pass.toml", hand, &session);
        let report = report_beside(&session);
        (
            run["physics_digest"].clone(),
            report["session"]["mirrored"].clone(),
        )
    };
    let (right, left) = (played("right"), played("left"));
    assert_eq!(right.0, left.0);
    assert_eq!((right.1, left.1), (Value::Null, Value::Bool(true)));
}
