//! Sharp trimming as a whole: no level is passed without what it uses or by the script of the one before, and hands that misuse everything end with a reason or without a verdict.

use microsim_tests::{run, scratch, tree};
use serde_json::Value;
use std::f64::consts::FRAC_1_SQRT_2;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

const LEVELS: u32 = 4;

fn passing(level: u32) -> PathBuf {
    tree().join(format!("modules/trim-sharp/scripts/level{level}-pass.toml"))
}

/// What a level is like with a script; the name is that of its session.
fn played(folder: &Path, name: &str, level: u32, script: &Path, args: &[&str]) -> Value {
    let input = format!("script:{}", script.display());
    let level = level.to_string();
    let args = [
        &["--level", &level, "--input", &input, "--no-pictures"],
        args,
    ]
    .concat();
    run("trim-sharp", &folder.join(format!("{name}.session")), &args)
}

#[test]
fn no_level_is_passed_without_physics_friction_or_cutting() {
    let folder = scratch();
    for level in 1..=LEVELS {
        for what in ["physics", "friction", "lonor"] {
            let name = format!("{level}-{what}");
            let printed = played(
                folder.path(),
                &name,
                level,
                &passing(level),
                &["--without", what],
            );
            let verdict = printed["verdict"].as_str();
            assert!(
                matches!(verdict, Some("failed" | "not-judged")),
                "{level} without {what}: {printed}"
            );
            assert_eq!(printed["counts"], false, "{printed}");
            assert_eq!(
                printed["targets_done"], 0,
                "{level} without {what}: {printed}"
            );
        }
    }
}

#[test]
fn no_level_is_passed_as_the_one_before() {
    let folder = scratch();
    for level in 2..=LEVELS {
        let name = format!("on-{level}");
        let printed = played(folder.path(), &name, level, &passing(level - 1), &[]);
        assert_eq!(printed["verdict"], "failed", "{level}: {printed}");
    }
}

/// Where a tool is at a time \[s\]: place \[mm\], orientation, opening.
type Key = (f64, [f64; 3], [f64; 4], f64);

/// Forceps from the left with one jaw above the other, and from above with one on each side; scissors from the trainee with one blade above the other.
const FORCEPS: [f64; 4] = [0.0, -0.5, 0.0, 0.866_025_404];
const FROM_ABOVE: [f64; 4] = [0.0, 0.0, FRAC_1_SQRT_2, FRAC_1_SQRT_2];
const SCISSORS: [f64; 4] = [0.5, -0.5, 0.5, 0.5];

fn script(tools: [(&str, &[Key]); 2]) -> String {
    let mut text = "rate = \"62.5 Hz\"\n".to_owned();
    for (tool, keys) in tools {
        let _ = write!(text, "\n[[tool]]\nname = \"{tool}\"\n");
        for (time, [x, y, z], orientation, opening) in keys {
            let _ = write!(
                text,
                "\n[[tool.key]]\nt = \"{time} s\"\nposition = [\"{x} mm\", \"{y} mm\", \"{z} mm\"]\norientation = {orientation:?}\nopening = {opening}\n"
            );
        }
    }
    text
}

/// Both instruments in the tissue at the start, the wall gripped at once, the vessel pulled off its clamp, everything cut through, a piece carried out of the field: the program ends
/// as it should, and no such run is passed.
#[test]
fn misuse_ends_without_a_fault() {
    let away = |time: f64| (time, [-8.0, 0.0, 6.0], FORCEPS, 0.3);
    let before = |time: f64| (time, [0.0, -9.0, 1.0], SCISSORS, 0.3);
    let forceps = |x: f64, z: f64, opening: f64| ([x, 0.0, z], FORCEPS, opening);
    let at = |time: f64, (place, orientation, opening)| (time, place, orientation, opening);
    let around = |x: f64, y: f64, opening: f64| ([x, y, 0.0], SCISSORS, opening);
    let inside = [
        at(0.0, forceps(0.3, 0.5, 0.0)),
        at(1.0, forceps(0.3, 0.5, 0.3)),
        at(2.0, forceps(0.3, 0.5, 0.0)),
        away(4.0),
    ];
    let in_the_wall = [
        at(0.0, around(0.5, 0.3, 0.05)),
        at(1.0, around(0.5, 0.3, 0.5)),
        at(2.0, around(0.5, 0.3, 0.0)),
        before(4.0),
    ];
    let wall = [
        at(0.0, forceps(0.6, 0.45, 0.3)),
        at(0.2, forceps(0.6, 0.45, 0.0)),
        at(2.0, forceps(0.2, 1.5, 0.0)),
        away(4.0),
    ];
    let pulled = [
        (0.0, [-4.0, 0.0, 3.0], FROM_ABOVE, 0.5),
        (1.0, [1.2, 0.0, -0.3], FROM_ABOVE, 0.5),
        (2.0, [1.2, 0.0, -0.3], FROM_ABOVE, 0.02),
        (4.0, [-15.0, 0.0, 12.0], FROM_ABOVE, 0.02),
        (5.0, [-15.0, 0.0, 12.0], FROM_ABOVE, 0.5),
    ];
    let all = [
        before(0.0),
        at(1.0, around(1.2, 1.2, 0.6)),
        at(2.0, around(1.2, 1.2, 0.0)),
        at(3.0, around(0.2, 1.2, 0.6)),
        at(4.0, around(0.2, 1.2, 0.0)),
        before(6.0),
    ];
    let (still, idle) = ([away(0.0), away(6.0)], [before(0.0), before(6.0)]);
    let folder = scratch();
    for (name, left, right) in [
        ("inside", &inside[..], &in_the_wall[..]),
        ("wall", &wall[..], &idle[..]),
        ("pulled", &pulled[..], &idle[..]),
        ("all", &still[..], &all[..]),
    ] {
        let path = folder.path().join(format!("{name}.toml"));
        fs::write(&path, script([("left", left), ("right", right)])).expect("a script");
        for level in [2, 4] {
            let printed = played(folder.path(), &format!("{name}-{level}"), level, &path, &[]);
            let verdict = printed["verdict"].as_str();
            assert!(
                matches!(verdict, Some("failed" | "not-judged")),
                "{name} {level}: {printed}"
            );
            assert_eq!(printed["failure"], Value::Null, "{name} {level}: {printed}");
        }
    }
    // What a passing script has cut off is carried out of the field, 40 mm away.
    let text = fs::read_to_string(passing(2)).expect("the script");
    let far = text.replace("position = [\"-4.0000 mm\"", "position = [\"-40.0000 mm\"");
    assert_ne!(far, text);
    let path = folder.path().join("far.toml");
    fs::write(&path, far).expect("a script");
    let printed = played(folder.path(), "far", 2, &path, &[]);
    assert_eq!(printed["failure"], Value::Null, "{printed}");
}
