//! Vessels as a user checks and describes them.

use std::path::Path;
use std::process::{Command, Output};

fn microsim(words: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_microsim"));
    command.args(words).output().expect("the program starts")
}

#[test]
fn vessels_are_checked_by_their_folder() {
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config/vessels");
    let run = microsim(&["check", shipped.to_str().expect("a path in UTF-8")]);
    let printed = String::from_utf8_lossy(&run.stdout);
    assert_eq!(printed.trim_end(), "4 checked, 0 with problems", "{run:?}");

    let folder = tempfile::tempdir().expect("a folder");
    let vessels = folder.path().join("vessels");
    std::fs::create_dir(&vessels).expect("a folder");
    let text = std::fs::read_to_string(shipped.join("rat-femoral-vein.toml")).expect("a vessel");
    let wrong = text.replacen("basis = \"judgement\"", "basis = \"hearsay\"", 1);
    let file = vessels.join("vein.toml");
    std::fs::write(&file, wrong).expect("a file");
    let run = microsim(&["check", file.to_str().expect("a path in UTF-8")]);
    let printed = String::from_utf8_lossy(&run.stdout);
    let expected = "key `axial_stretch.basis`: found the text `hearsay`, expected \"measured\", \"derived\" or \"judgement\"";
    assert!(printed.contains(expected), "{run:?}");
    assert_eq!(run.status.code(), Some(1));
}

#[test]
fn the_schema_of_vessels_states_what_a_value_rests_on() {
    let run = microsim(&["schema", "vessel", "--markdown"]);
    let printed = String::from_utf8_lossy(&run.stdout);
    for row in [
        "| `inner_radius.source` |",
        "| `layer[].thickness.basis` | \"measured\", \"derived\" or \"judgement\" |",
    ] {
        assert!(printed.contains(row), "{printed}");
    }
}
