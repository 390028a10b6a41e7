//! The built tree with the levels of a module changed.

use crate::{command, finish, scratch, tree};
use std::fmt::Write as _;
use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::Command;
use toml::{Table, Value};

/// A tree of its own, gone with this value. All but the levels are links.
#[derive(Debug)]
pub struct ChangedLevels {
    folder: tempfile::TempDir,
    module: String,
}

/// A link in a new folder for each entry of another, but for one.
pub(crate) fn link_all(from: &Path, to: &Path, but: &str) {
    fs::create_dir(to).expect("a folder");
    for entry in fs::read_dir(from).expect("a folder of the tree") {
        let entry = entry.expect("an entry");
        if entry.file_name() != but {
            symlink(entry.path(), to.join(entry.file_name())).expect("a link");
        }
    }
}

impl ChangedLevels {
    /// With the text of each level of `module` passed through `change`.
    ///
    /// # Panics
    /// If the folder cannot be made.
    pub fn new(module: &str, change: impl Fn(&str) -> String) -> Self {
        let folder = scratch();
        let (tree, root) = (tree(), folder.path());
        for name in ["assets", "config", "plugins", "installed.b3"] {
            symlink(tree.join(name), root.join(name)).expect("a link");
        }
        link_all(&tree.join("modules"), &root.join("modules"), module);
        let (of_tree, own) = (
            tree.join("modules").join(module),
            root.join("modules").join(module),
        );
        link_all(&of_tree, &own, "levels");
        fs::create_dir(own.join("levels")).expect("a folder");
        for entry in fs::read_dir(of_tree.join("levels")).expect("the levels") {
            let path = entry.expect("an entry").path();
            let file = own.join("levels").join(path.file_name().expect("a name"));
            if path.is_dir() {
                // Meshes.
                symlink(&path, file).expect("a link");
                continue;
            }
            let text = fs::read_to_string(&path).expect("a level");
            fs::write(file, change(&text)).expect("a level");
        }
        Self {
            folder,
            module: module.to_owned(),
        }
    }

    /// Puts limits, the text of tables `[[limit]]`, in the place of those of a level.
    ///
    /// # Panics
    /// If the level cannot be read or written.
    pub fn set_limits(&self, level: u32, limits: &str) {
        let name = format!("modules/{}/levels/level{level}.toml", self.module);
        let path = self.folder.path().join(name);
        let text = fs::read_to_string(&path).expect("a level");
        fs::write(path, with_limits(&text, limits)).expect("a level");
    }

    /// `microsim run MODULE --json ARGS…` on this tree; its standard output.
    #[track_caller]
    pub fn run(&self, session: &Path, args: &[&str]) -> serde_json::Value {
        let mut command = self.command(&["run", &self.module, "--json", "--session"]);
        finish(command.arg(session).args(args)).expect(0).json()
    }

    /// The program on this tree.
    pub fn command(&self, args: &[&str]) -> Command {
        let mut command = command(["--root".as_ref(), self.folder.path().as_os_str()]);
        command.args(args);
        command
    }
}

/// A level with the text of other limits in place of its own.
fn with_limits(level: &str, limits: &str) -> String {
    let mut kept = String::new();
    let mut is_limit = false;
    for line in level.lines() {
        if line.starts_with('[') {
            is_limit = line == "[[limit]]";
        }
        if !is_limit {
            let _ = writeln!(kept, "{line}");
        }
    }
    format!("{kept}\n{limits}")
}

/// A level whose solver gets nowhere: one iteration for a tick of 48 ms, near the longest that a level may have, with no second try and the least budget, so that it has no more where it needs more. Levels whose method has no
/// iterations stay as they are.
pub fn crippled(level: &str) -> String {
    if !has_iterations(level) {
        return level.to_owned();
    }
    let line = |line: &str| match line.split(" = ").next() {
        Some("tick") => "tick = \"48 ms\"\n".to_owned(),
        Some("iterations") => "iterations = 1\nrepeat_invalid = false\n".to_owned(),
        Some("[physics]") => "[physics]\nbudget = 0.01\n".to_owned(),
        Some("budget") => String::new(),
        _ => format!("{line}\n"),
    };
    level.lines().map(line).collect()
}

/// The level with tissue that does not flow: without the tables `plasticity` of its materials.
///
/// # Panics
/// If it is no level.
pub fn without_plasticity(level: &str) -> String {
    without_key(level, "material", "plasticity")
}

/// The level with layers that slide on each other with no more than their friction.
///
/// # Panics
/// If it is no level.
pub fn without_shear_strength(level: &str) -> String {
    without_key(level, "coupling", "shear_strength")
}

/// The level without a key of the tables `of` of its bodies.
fn without_key(level: &str, of: &str, key: &str) -> String {
    let mut table: Table = level.parse().expect("TOML");
    let bodies = table.get_mut("body").and_then(Value::as_array_mut);
    for body in bodies.into_iter().flatten() {
        let entries = body.get_mut(of).and_then(Value::as_array_mut);
        for entry in entries.into_iter().flatten() {
            entry.as_table_mut().map(|entry| entry.remove(key));
        }
    }
    table.to_string()
}

fn has_iterations(level: &str) -> bool {
    level.contains("\niterations = ")
}

/// The level without a bound of the work of its ticks. One computed otherwise takes more, and were it cut short the comparison would be one of budgets: at half the tick each has half the work, and most trainees
/// had no verdict.
fn without_budget(level: &str) -> String {
    let line = |line: &str| match line.split(" = ").next() {
        Some("[physics]") => "[physics]\nbudget = 1000\nmean_budget = 1000\n".to_owned(),
        Some("budget" | "mean_budget") => String::new(),
        _ => format!("{line}\n"),
    };
    level.lines().map(line).collect()
}

/// How a level is computed otherwise: what it is called, and the change. Levels without tissue, or whose method has no iterations, stay as they are; the others have no bound of their work.
pub type Change = (&'static str, fn(&str) -> String);

/// A level as it is, at twice the iterations, half the tick, and on a mesh one step finer: none of this is the trainee's doing.
pub const CHANGES: [Change; 4] = [
    ("as shipped", str::to_owned),
    ("twice the iterations", |level| {
        without_budget(&scaled(level, "iterations", 2.0))
    }),
    ("half the tick", |level| {
        without_budget(&scaled(level, "tick", 0.5))
    }),
    ("finer mesh", |level| without_budget(&finer(level))),
];

/// The same but for the mesh, which vessels have from generators and files of their own kinds. Half the tick also where there is no tissue: what a module does with its
/// tools is then computed twice as often.
pub const COMPUTATIONS: [Change; 3] = [
    CHANGES[0],
    CHANGES[1],
    (CHANGES[2].0, |level| {
        without_budget(&scaled_lines(level, "tick", 0.5))
    }),
];

/// By how much the finer mesh has more cells along each axis: two where there were one or two, half as many again where there were more.
fn finer_cells(cells: u32) -> u32 {
    match cells {
        0..=2 => cells + 1,
        more => more + more.div_ceil(2),
    }
}

/// The level with the number in the lines of a key multiplied; its unit stays.
fn scaled(level: &str, key: &str, factor: f64) -> String {
    match has_iterations(level) {
        true => scaled_lines(level, key, factor),
        false => level.to_owned(),
    }
}

/// The same, whether its method has iterations or not.
fn scaled_lines(level: &str, key: &str, factor: f64) -> String {
    changed(level, key, |value| {
        let number: String = value
            .chars()
            .filter(|c| "0123456789.".contains(*c))
            .collect();
        let scaled = number.parse::<f64>().expect("a number") * factor;
        value.replacen(&number, &scaled.to_string(), 1)
    })
}

/// The level with more cells in each direction.
fn finer(level: &str) -> String {
    if !has_iterations(level) {
        return level.to_owned();
    }
    changed(level, "cells", |value| {
        let list = value.trim().trim_start_matches('[').trim_end_matches(']');
        let cells = list
            .split(',')
            .map(|n| n.trim().parse().expect("a number of cells"));
        let finer: Vec<String> = cells.map(|n| finer_cells(n).to_string()).collect();
        format!("[{}]", finer.join(", "))
    })
}

/// The level with the value of each line `key = value` changed.
fn changed(level: &str, key: &str, change: impl Fn(&str) -> String) -> String {
    let mut out = String::new();
    let mut found = false;
    for line in level.lines() {
        match line.split_once(" = ").filter(|(name, _)| *name == key) {
            Some((name, value)) => {
                found = true;
                let _ = writeln!(out, "{name} = {}", change(value));
            }
            None => {
                let _ = writeln!(out, "{line}");
            }
        }
    }
    assert!(found, "no line `{key} = …` in the level");
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn other_limits_take_the_place_of_a_levels_own() {
        let level = "[clock]\ntick = \"8 ms\"\n[[limit]]\nmetric = \"time\"\nmax = 1\n\n[module]\ntask = \"cut\"\n[[limit]]\nmetric = \"torn\"\n";
        let other = "[[limit]]\nmetric = \"drops\"\n";
        let changed: toml::Table = with_limits(level, other).parse().expect("TOML");
        let expected =
            "[clock]\ntick = \"8 ms\"\n[module]\ntask = \"cut\"\n[[limit]]\nmetric = \"drops\"";
        assert_eq!(changed, expected.parse().expect("TOML"));
    }

    /// All else stays, and so does a level without any.
    #[test]
    fn one_key_is_left_out() {
        let rest = "[[body]]\nname = \"vessel\"\n[[body.material]]\nregion = 0\n";
        let more = "[[body.material]]\nregion = 1\nlaw = \"-\"\n[method]\niterations = 8\n";
        let flows = "plasticity = { yield_strain = \"5 %\" }\n";
        let changed = without_plasticity(&[rest, flows, more].concat());
        let changed: Table = changed.parse().expect("TOML");
        let expected: Table = [rest, more].concat().parse().expect("TOML");
        assert_eq!(changed, expected);
        let coupling = "[[body.coupling]]\nfriction = 0.2\n";
        let strong = [rest, coupling, "shear_strength = \"100 Pa\"\n"].concat();
        let changed: Table = without_shear_strength(&strong).parse().expect("TOML");
        let expected: Table = [rest, coupling].concat().parse().expect("TOML");
        assert_eq!(changed, expected);
        let same: Table = without_plasticity("tick = 1\n").parse().expect("TOML");
        assert_eq!(same, "tick = 1".parse().expect("TOML"));
    }

    /// By hand.
    #[test]
    fn levels_are_changed_line_by_line() {
        let level = "tick = \"8 ms\"\nsteps = 1\ncells = [20, 2, 1]\niterations = 10\n";
        assert_eq!(
            scaled(level, "tick", 0.5),
            "tick = \"4 ms\"\nsteps = 1\ncells = [20, 2, 1]\niterations = 10\n"
        );
        assert_eq!(
            scaled("steps = 1\niterations = 10\n", "iterations", 2.0),
            "steps = 1\niterations = 20\n"
        );
        assert_eq!(
            finer("cells = [20, 2, 1]\niterations = 10\n"),
            "cells = [30, 3, 2]\niterations = 10\n"
        );
        let explicit = "tick = \"8 ms\"\ncells = [20, 2, 1]\n";
        assert!(
            CHANGES
                .iter()
                .all(|(_, change)| change(explicit) == explicit)
        );
        assert_eq!(
            without_budget("[physics]\ngravity = 0\nbudget = 2\n[method]\n"),
            "[physics]\nbudget = 1000\nmean_budget = 1000\ngravity = 0\n[method]\n"
        );
        let halved = COMPUTATIONS.map(|(_, change)| change(explicit));
        assert_eq!(halved[..2], [explicit, explicit]);
        assert_eq!(halved[2], "tick = \"4 ms\"\ncells = [20, 2, 1]\n");
    }
}
