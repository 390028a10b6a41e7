//! Recordings in CSV: without a column map, and with rows that cannot be.

use crate::tree::Tree;
use crate::{assert_refused, run, tree};
use std::fmt::Write;

const HEADER: &str = "t_s,x_mm,y_mm,z_mm,qx,qy,qz,qw\n";

const MAP: &str = r#"
licence = "none"
source = "made by a test"

[time]
column = "t_s"
unit = "s"

[[device]]
name = "right"
position = ["x_mm", "y_mm", "z_mm"]
position_unit = "mm"
quaternion = ["qx", "qy", "qz", "qw"]
"#;

/// 50 rows of 16 ms.
fn rows() -> Vec<String> {
    (0..50)
        .map(|i| format!("{:.3},{i},0,0,0,0,0,1\n", 0.016 * f64::from(i)))
        .collect()
}

fn tree_with(csv: &str) -> Tree {
    let tree = tree();
    tree.write("hand.csv", csv);
    tree.write("hand.toml", MAP);
    tree
}

/// What is proposed can be pasted, whatever stands between the columns.
#[test]
fn without_a_column_map() {
    for delimiter in [",", ";", "\t"] {
        let tree = tree();
        let csv = format!("{HEADER}{}", rows().concat()).replace(',', delimiter);
        tree.write("hand.csv", csv.replace('\n', "\r\n"));
        let help = "hand.csv: a recording needs a column map, the file hand.toml beside it.\n\
                    Its header is: t_s, x_mm, y_mm, z_mm, qx, qy, qz, qw\n\
                    Write into that file, and put right what is guessed wrong:\n\n";
        assert_refused(&tree, "recording:hand.csv", help);
        let check = tree.microsim(&["check", "hand.csv"]).expect(1);
        let (_, proposal) = check.out.split_once(help).expect("the same");
        let (map, _) = proposal.split_once("\n1 checked").expect("its end");
        tree.write("hand.toml", map);
        tree.microsim(&["check", "hand.csv", "hand.toml"]).expect(0);
        let report = run(&tree, "recording:hand.csv", &["--json"]).expect(0);
        assert!(
            report.json()["ticks"].as_u64().is_some_and(|t| t >= 98),
            "{report:?}"
        );
    }
}

#[test]
fn rows_that_cannot_be() {
    let good = rows();
    let with = |row: usize, text: &str| {
        let mut rows = good.clone();
        rows[row] = format!("{text}\n");
        format!("{HEADER}{}", rows.concat())
    };
    let header = |from: &str, to: &str| format!("{}{}", HEADER.replace(from, to), good.concat());
    let cases = [
        (
            header("qw", "q_w"),
            "hand.csv:1: column \"qw\" is missing; the header has t_s, x_mm, y_mm, z_mm, qx, qy, qz, q_w",
        ),
        (
            header("y_mm", "x_mm"),
            "hand.csv:1: column \"x_mm\" stands in the header more than once",
        ),
        // Row 10, after the header, is line 12.
        (
            with(10, "0.16,NaN,0,0,0,0,0,1"),
            "hand.csv:12: column \"x_mm\": expected a finite number, found \"NaN\"",
        ),
        (
            with(10, "0.16,0,inf,0,0,0,0,1"),
            "hand.csv:12: column \"y_mm\": expected a finite number, found \"inf\"",
        ),
        (
            with(10, "0.16,0,0,zero,0,0,0,1"),
            "hand.csv:12: column \"z_mm\": expected a number such as -1.25, found \"zero\"",
        ),
        (
            with(10, "0.16,0,0,0,0,0,0"),
            "hand.csv:12: expected 8 fields as in the header, found 7",
        ),
        (
            with(10, "0.16,0,0,0,0,0,0,"),
            "hand.csv:12: column \"qw\": expected a number such as -1.25, found \"\"",
        ),
        (
            with(10, "0.1,0,0,0,0,0,0,1"),
            "hand.csv:12: time 0.1 s does not come after 0.144 s of the row before",
        ),
        (
            with(10, "0.144,0,0,0,0,0,0,1"),
            "hand.csv:12: time 0.144 s does not come after 0.144 s of the row before",
        ),
        (
            with(10, "0.16,0,0,0,0,0,0,0"),
            "hand.csv:12: device \"right\": quaternion is zero, expected a unit quaternion",
        ),
        (
            with(10, "0.16,0,0,0,0,0,0,0.5"),
            "hand.csv:12: device \"right\": quaternion has norm 0.5, expected 1 within 0.001",
        ),
        (
            HEADER.to_owned(),
            "hand.csv:1: the header is followed by no sample",
        ),
        (
            String::new(),
            "hand.csv:1: the file is empty, expected a header with the names of the columns",
        ),
    ];
    for (csv, complaint) in cases {
        let tree = tree_with(&csv);
        assert_refused(&tree, "recording:hand.csv", complaint);
        let check = tree.microsim(&["check", "hand.csv"]).expect(1);
        assert!(
            check.out.contains(complaint),
            "expected {complaint:?} in {check:?}"
        );
    }
}

#[test]
fn a_million_rows() {
    let mut csv = String::from(HEADER);
    for i in 0..1_000_000 {
        writeln!(csv, "{}.{:03},{},0,40,0,0,0,1", i / 1000, i % 1000, i % 10)
            .expect("a string takes all");
    }
    let tree = tree_with(&csv);
    tree.microsim(&["check", "hand.csv"]).expect(0);
    // The level ends long before the recording.
    tree.edit(
        "modules/touch-spheres/levels/level1.toml",
        "max = \"120 s\"\nfull = \"30 s\"",
        "max = \"2 s\"\nfull = \"1 s\"",
    );
    let printed = run(&tree, "recording:hand.csv", &["--json"])
        .expect(0)
        .json();
    assert_eq!(printed["failed"], serde_json::json!(["too-slow"]));
    // The clock starts at the end of the first tick, 8 ms; 2.016 s is the first end of a tick that is more than 2 s later.
    assert_eq!(printed["ticks"], 252);
}
