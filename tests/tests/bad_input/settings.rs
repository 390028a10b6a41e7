//! Unknown keys, wrong units and missing files, in every kind of TOML file. What a sentence states of all other mistakes is
//! tested in the crate `settings`; here it has to arrive.

use crate::tree::Tree;
use crate::{assert_refused, run, tree};
use microsim_tests::Finished;
use serde_json::json;

/// A mistake in one file.
struct Case {
    file: &'static str,
    /// What is replaced, and by what.
    edit: (&'static str, &'static str),
    /// `LINE:COLUMN: ` and the sentence, seen from the replaced text: its line is counted.
    says: &'static str,
}

const SCRIPT: &str = "modules/touch-spheres/scripts/level1-pass.toml";
const MAP: &str = "hand.toml";

/// An unknown key and a wrong unit (or, where a kind of file has no units, a wrong type) in each.
const CASES: [Case; 16] = [
    Case {
        file: "config/host.toml",
        edit: ("width = ", "widht = "),
        says: ":1: key `picture.widht`: found an unknown key, expected `rate`, `width` or `height` (did you mean `width`?)",
    },
    Case {
        file: "config/host.toml",
        edit: ("give_up = \"250 ms\"", "give_up = \"250 mm\""),
        says: ":11: key `late.give_up`: found the text `250 mm` (a length), expected a time from 10 ms to 60 s",
    },
    Case {
        file: "config/translator.toml",
        edit: ("stale_after = ", "stale_afer = "),
        says: ":1: key `stale_afer`: found an unknown key, expected `stale_after`, `hand`, `dominant`, `device`, `box`, `markers`, `clutch` or `filter` (did you mean `stale_after`?)",
    },
    Case {
        file: "config/translator.toml",
        edit: ("stale_after = \"100 ms\"", "stale_after = \"100 Hz\""),
        says: ":15: key `stale_after`: found the text `100 Hz` (a frequency), expected a time",
    },
    Case {
        file: "config/tools/forceps.toml",
        edit: ("hinge = ", "hing = "),
        says: ":1: key `hing`: found an unknown key, expected `doc`, ",
    },
    Case {
        file: "config/tools/forceps.toml",
        edit: ("opening_angle = \"12 deg\"", "opening_angle = \"12 grad\""),
        says: ":17: key `opening_angle`: found the text `12 grad` (unknown unit), expected an angle from 0 deg to 90 deg",
    },
    Case {
        file: "modules/touch-spheres/levels/level1.toml",
        edit: ("dwell = ", "dwel = "),
        says: ":1: key `module.dwel`: found an unknown key, expected `angle_tolerance`, `dwell`, `spread` or `direction_max` \
               (did you mean `dwell`?)",
    },
    Case {
        file: "modules/touch-spheres/levels/level1.toml",
        edit: ("tick = \"8 ms\"", "tick = \"8 mm\""),
        says: ":8: key `clock.tick`: found the text `8 mm` (a length), expected a time from 1 ms to 50 ms",
    },
    Case {
        file: "modules/touch-spheres/module.toml",
        edit: ("licence = ", "license = "),
        says: ":1: key `license`: found an unknown key, expected ",
    },
    Case {
        file: "modules/touch-spheres/module.toml",
        edit: ("max = \"10 s\"", "max = \"10 kg\""),
        says: ":7: key `key[1].max`: found the text `10 kg` (a mass), expected a time",
    },
    Case {
        file: "plugins/translator/plugin.toml",
        edit: ("publishes = ", "publish = "),
        says: ":1: key `publish`: found an unknown key, expected ",
    },
    Case {
        file: "plugins/translator/plugin.toml",
        edit: ("abi = 2", "abi = \"2\""),
        says: ":7: key `abi`: found the text `2`, expected a whole number from 1 to 65535",
    },
    Case {
        file: SCRIPT,
        edit: ("interpolation = ", "interpolate = "),
        says: ":1: key `interpolate`: found an unknown key, expected `rate`, `interpolation`, `module`, `level`, `synthetic` or `tool` (did you mean \
               `interpolation`?)",
    },
    Case {
        file: SCRIPT,
        edit: ("rate = \"62.5 Hz\"", "rate = \"62.5 ms\""),
        says: ":8: key `rate`: found the text `62.5 ms` (a time), expected a frequency from 1 Hz to 1 kHz",
    },
    Case {
        file: MAP,
        edit: ("position_unit = ", "positions_unit = "),
        says: ":1: key `device[0].positions_unit`: found an unknown key, expected `name`, `position`, ",
    },
    Case {
        file: MAP,
        edit: ("position_unit = \"mm\"", "position_unit = \"ms\""),
        says: ":17: key `device[0].position_unit`: found the text `ms`, expected \"m\", \"cm\", \"mm\", \"um\" or \"nm\"",
    },
];

const CSV: &str = "t_s,x_mm,y_mm,z_mm,qx,qy,qz,qw\n0,0,0,0,0,0,0,1\n0.016,1,0,0,0,0,0,1\n";

/// The recording's map as the program itself proposes it.
fn write_recording(tree: &Tree) {
    tree.write("hand.csv", CSV);
    let printed = run(tree, "recording:hand.csv", &[]);
    let (_, map) = printed.err.split_once("\n\n").expect("a proposal");
    tree.write(MAP, map);
}

/// The input that makes a run read the file.
fn input(file: &str) -> &'static str {
    match file {
        MAP => "recording:hand.csv",
        _ => "script:level1-pass.toml",
    }
}

#[test]
fn unknown_keys_and_wrong_units() {
    for case in &CASES {
        let tree = tree();
        write_recording(&tree);
        let text = std::fs::read_to_string(tree.path(case.file)).expect("the file is read");
        let before = text.split(case.edit.0).next().unwrap_or_default();
        let path = tree.edit(case.file, case.edit.0, case.edit.1);
        let line = 1 + before.matches('\n').count();
        let place = match case.file {
            SCRIPT => path.display().to_string(),
            // A recording is named as the operator named it.
            MAP => MAP.to_owned(),
            _ => path.display().to_string(),
        };
        let complaint = format!("{place}:{line}{}", case.says);
        assert_refused(&tree, input(case.file), &complaint);

        let check = tree.microsim(&["check", &place, "--json"]).expect(1).json();
        let problems = check["problems"].to_string();
        let quoted = json!(complaint).to_string();
        assert!(
            problems.contains(quoted.trim_matches('"')),
            "expected {complaint} in {problems}"
        );
    }
}

/// Those of the window keep it from opening, and no run from beginning. No display is needed for that.
#[test]
fn the_settings_of_the_window() {
    let file = "config/window.toml";
    for (from, to, says) in [
        (
            "stereo_base = ",
            "stereo_bas = ",
            ":1: key `stereo_bas`: found an unknown key, expected `language`, `quality`, `stereo`, `stereo_base`, `working_distance`, \
             `depth_of_field`, `full_screen`, `panels`, `audio`, `volume`, `controller_speed` or `pedal` (did you mean `stereo_base`?)",
        ),
        (
            "working_distance = \"250 mm\"",
            "working_distance = \"250 Hz\"",
            ":20: key `working_distance`: found the text `250 Hz` (a frequency), expected a length from 20 cm to 45 cm",
        ),
        (
            "stereo = \"mono\"",
            "stereo = \"both\"",
            ":10: key `stereo`: found the text `both`, expected \"mono\", \"side-by-side\", \"top-bottom\", \"row-interleaved\" or \"red-cyan\"",
        ),
    ] {
        let tree = tree();
        let path = tree.edit(file, from, to);
        let text = std::fs::read_to_string(&path).expect("it was written");
        let before = text.split(to).next().expect("the text");
        let complaint = format!("{}:{}{says}", path.display(), before.lines().count() + 1);
        let mut window = tree.command(&["window"]);
        let printed: Finished = window
            .env_remove("DISPLAY")
            .output()
            .expect("it runs")
            .into();
        let printed = printed.expect(2);
        assert!(
            printed.err.contains(&complaint),
            "expected {complaint} in {printed:?}"
        );
        let place = path.display().to_string();
        let check = tree.microsim(&["check", &place, "--json"]).expect(1).json();
        let quoted = json!(complaint).to_string();
        assert!(
            check["problems"]
                .to_string()
                .contains(quoted.trim_matches('"')),
            "{check}"
        );
        run(&tree, "script:short.toml", &[]).expect(0);
    }
}

#[test]
fn missing_files() {
    for (file, says) in [
        (
            "config/host.toml",
            "found no such file, expected the settings of the host (config/host.toml)",
        ),
        ("config/translator.toml", "found no such file, expected "),
        ("config/tools/forceps.toml", "found no such file, expected "),
        (
            "modules/touch-spheres/module.toml",
            "found no such file, expected the manifest of a plugin (plugin.toml) or module",
        ),
        (
            "plugins/translator/plugin.toml",
            "found no such file, expected the manifest of a plugin (plugin.toml) or module",
        ),
    ] {
        let tree = tree();
        let path = tree.path(file);
        std::fs::remove_file(&path).expect("removed");
        assert_refused(
            &tree,
            "script:short.toml",
            &format!("{}: {says}", path.display()),
        );
    }
    let tree = tree();
    assert_refused(
        &tree,
        "script:no.toml",
        "no.toml: found no such file, expected a scripted trainee (TOML)",
    );
    assert_refused(
        &tree,
        "recording:no.csv",
        "input no.csv: there is no such file",
    );
}

/// No level takes the number of another one.
#[test]
fn a_missing_level() {
    let tree = tree();
    std::fs::remove_file(tree.path("modules/touch-spheres/levels/level2.toml")).expect("removed");
    let printed = run(&tree, "script:short.toml", &["--level", "2"]);
    let hole = tree.path("modules/touch-spheres/levels/level3.toml");
    let sentence = format!(
        "microsim: module \"touch-spheres\" has levels 1 to 1, not 2\n{}: found level 3, expected level2.toml before it, as \
         levels are numbered from 1 without holes\n",
        hole.display()
    );
    assert_eq!((printed.code, printed.err), (Some(2), sentence));
    run(&tree, "script:short.toml", &["--level", "1"]).expect(0);
}

/// A file of another kind has a mistake in each line: the first ones are reported.
#[test]
fn a_file_of_another_kind() {
    let tree = tree();
    let rows: String = (0..1000).map(|i| format!("{i},0,0\n")).collect();
    tree.write("rows.csv", rows);
    let printed = run(&tree, "script:rows.csv", &[]);
    assert_eq!(printed.code, Some(2), "{printed:?}");
    let lines: Vec<&str> = printed.err.lines().collect();
    assert_eq!(
        (lines.len(), lines[20]),
        (21, "and 980 more"),
        "{printed:?}"
    );
}

/// One broken module hides itself and nothing else; `list --json` stays one document.
#[test]
fn a_broken_module_hides_itself_alone() {
    let tree = tree();
    let names = |printed: &Finished| -> Vec<_> {
        let list = printed.json();
        let modules = list["modules"].as_array().expect("a list").iter();
        modules.map(|m| m["name"].clone()).collect()
    };
    let mut others = names(&tree.microsim(&["list", "--json"]).expect(0));
    others.retain(|name| name != "touch-spheres");
    assert!(!others.is_empty());
    tree.edit(
        "modules/touch-spheres/module.toml",
        "kind = \"module\"",
        "kind = \"modul\"",
    );
    let printed = tree.microsim(&["list", "--json"]).expect(0);
    assert_eq!(names(&printed), others);
    assert!(
        printed
            .err
            .contains("touch-spheres/module.toml:2:8: key `kind`: found the text `modul`"),
        "{printed:?}"
    );
    let check = tree.microsim(&["check", "--json"]).expect(1).json();
    let problems = check["problems"].as_array().expect("a list").iter();
    let problems: Vec<&str> = problems.filter_map(|problem| problem.as_str()).collect();
    // The module, and the shipped course that has a step of it.
    let [module, course] = problems.as_slice() else {
        panic!("{problems:?}");
    };
    assert!(module.contains("touch-spheres/module.toml:2:8"), "{module}");
    assert!(
        course.contains("courses/first-steps.toml")
            && course.contains("no module \"touch-spheres\""),
        "{course}"
    );
}

/// Tissue that is stiffer or a limit that is looser is another task: the report names the file.
#[test]
fn an_edited_level_is_not_the_installed_one() {
    let tree = tree();
    let changed = |file: &str| {
        for file in ["x.session", "x.json"] {
            let _ = std::fs::remove_file(tree.path(file));
        }
        let printed = run(&tree, "script:level1-pass.toml", &["--no-pictures"]).expect(0);
        assert_eq!(
            printed.out.contains("not the level that was installed"),
            !file.is_empty()
        );
        assert!(printed.out.contains(file), "{printed:?}");
        let text = std::fs::read_to_string(tree.path("x.json")).expect("a report");
        let report: serde_json::Value = serde_json::from_str(&text).expect("JSON");
        report["session"]["changed_files"].clone()
    };
    assert_eq!(changed(""), json!([]));
    let file = "modules/touch-spheres/levels/level1.toml";
    tree.edit(file, "max = \"120 s\"", "max = \"119 s\"");
    assert_eq!(changed(file), json!([file]));
}
