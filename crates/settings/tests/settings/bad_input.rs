//! Bad inputs and the exact words about them: `tests/examples/bad-input.txt`.
//!
//! Each case there is a kind of file, a part of its full example (`- `), what stands there instead (`+ `, `\n` for a line
//! break), and then every complaint. The complaints were taken from the reader and read through against the examples;
//! since then they hold it to its words. `{laws}` and `{methods}` stand for the lists of all names, which grow.

use crate::{KNOWN_METRICS, example, manifest, read};
use microsim_settings::*;

#[test]
fn each_mistake_is_named_with_its_place() {
    let cases = include_str!("../examples/bad-input.txt");
    let laws: Vec<&str> = Law::all().map(Law::name).collect();
    let cases = cases.replace("{laws}", &listed(&laws));
    let cases = cases.replace("{methods}", &listed(&MethodName::NAMES));
    let mut count = 0;
    let mut wrong = Vec::new();
    for case in cases.trim_end().split("\n\n") {
        let lines: Vec<&str> = case.lines().collect();
        let [kind, from, to, expected @ ..] = lines.as_slice() else {
            panic!("a case of fewer than three lines: {case}");
        };
        let part = |line: &str, sign: &str| -> String {
            let part = line.strip_prefix(sign).expect("`-` or `+`");
            let part = part.strip_prefix(' ').unwrap_or_default();
            part.replace("\\n", "\n")
        };
        let (from, to) = (part(from, "-"), part(to, "+"));
        assert!(example(kind).contains(&from), "not in the example: {case}");
        let errors = read(kind, &example(kind).replacen(&from, &to, 1)).expect_err(case);
        let printed: Vec<String> = errors.0.iter().map(ToString::to_string).collect();
        if printed != expected {
            wrong.push(format!("{case}\nfound instead:\n{}", printed.join("\n")));
        }
        count += 1;
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n\n"));
    // A separator lost in the file would hide cases.
    assert_eq!(
        count,
        cases.lines().filter(|line| line.starts_with("- ")).count()
    );
}

/// Names as complaints list them.
fn listed(names: &[&str]) -> String {
    let quoted: Vec<String> = names.iter().map(|name| format!("\"{name}\"")).collect();
    let (last, others) = quoted.split_last().expect("a name");
    format!("{} or {last}", others.join(", "))
}

/// The error of `load_*` for a file that cannot be read as text.
#[test]
fn a_file_that_is_missing_or_no_text_is_named_with_what_it_should_be() {
    let folder = tempfile::tempdir().expect("a folder");
    let missing = folder.path().join("x.toml");
    let name = missing.display();
    let csv = folder.path().join("x.csv");
    let message = |errors: Option<ConfigErrors>| errors.expect("no file").to_string();
    let cases = [
        (
            message(load_manifest(&missing).err()),
            "the manifest of a plugin (plugin.toml) or module (module.toml)".to_owned(),
        ),
        (
            message(load_level(&missing, &manifest(), &KNOWN_METRICS).err()),
            "a level of the module `touch-spheres` (level<N>.toml)".to_owned(),
        ),
        (
            message(load_scene(&missing, &[]).err()),
            "a scene (config/scenes/NAME.toml)".to_owned(),
        ),
        (
            message(load_tool(&missing).err()),
            "the shape of a tool (config/tools/NAME.toml)".to_owned(),
        ),
        (
            message(load_vessel(&missing).err()),
            "a vessel (config/vessels/NAME.toml)".to_owned(),
        ),
        (
            message(load_translator(&missing).err()),
            "the map from devices to tools (config/translator.toml)".to_owned(),
        ),
        (
            message(load_recording_map(&csv).err()),
            format!("the column map of {}", csv.display()),
        ),
        (
            message(load_script(&missing).err()),
            "a scripted trainee (TOML)".to_owned(),
        ),
        (
            message(load_trainees(&missing).err()),
            "the kinds of synthetic trainees (config/trainees.toml)".to_owned(),
        ),
        (
            message(load_course(&missing).err()),
            "a course (config/courses/NAME.toml)".to_owned(),
        ),
        (
            message(load_host(&missing).err()),
            "the settings of the host (config/host.toml)".to_owned(),
        ),
    ];
    for (message, expected) in cases {
        assert_eq!(
            message,
            format!("{name}: found no such file, expected {expected}")
        );
    }

    std::fs::write(&missing, b"a = \"\xff\"").expect("a file can be written");
    let message = message(load_host(&missing).err());
    let found = "a file that is not UTF-8 at byte 5";
    let expected = "the settings of the host (config/host.toml)";
    assert_eq!(
        message,
        format!("{name}: found {found}, expected {expected}")
    );
}
