//! Installations with the plugin of the fixture `awkward` in the place of another one.

use crate::tree::Tree;
use microsim_host::record::{Ended, Session};
use microsim_tests::{Finished, finish, fixture_library};
use std::path::{Path, PathBuf};
use std::process::Command;

/// A tool that sinks by 2 mm in 0.8 s: 101 ticks of 8 ms with the one in which the end of the input is handled.
pub const SCRIPT: &str = r#"
rate = "62.5 Hz"

[[tool]]
name = "right"

[[tool.key]]
t = 0
position = [0, 0, "12 mm"]
direction = [0, 0, 1]

[[tool.key]]
t = "0.8 s"
position = [0, 0, "10 mm"]
direction = [0, 0, 1]
"#;

/// The level of the awkward module.
const LEVEL: &str = r#"
[title]
de = "Nichts"
en = "Nothing"

[summary]
de = "Nichts zu tun."
en = "Nothing to do."

[clock]
tick = "8 ms"

[view]
field = "25 mm"

[[tool]]
name = "right"
model = "forceps"
"#;

/// What the awkward plugin stands for.
#[derive(Clone, Copy, Debug)]
pub struct Role {
    pub kind: &'static str,
    pub name: &'static str,
    pub publishes: &'static str,
    pub subscribes: &'static str,
    /// The module that is run, and its input.
    pub run: [&'static str; 3],
}

const TOUCH: [&str; 3] = ["touch-spheres", "--input", "script:script.toml"];

pub const SOURCE: Role = Role {
    kind: "source",
    name: "awkward",
    publishes: r#""input.sample", "input.end""#,
    subscribes: "",
    run: ["touch-spheres", "--input", "plugin:awkward"],
};
pub const TRANSLATOR: Role = Role {
    kind: "translator",
    name: "translator",
    publishes: r#""tool.sample", "tool.states""#,
    subscribes: r#""input.sample""#,
    run: TOUCH,
};
pub const PHYSICS: Role = Role {
    kind: "physics",
    name: "physics",
    publishes: r#""tissue.snapshot""#,
    subscribes: r#""tool.states""#,
    run: ["push-strip", "--input", "script:script.toml"],
};
pub const MODULE: Role = Role {
    kind: "module",
    name: "awkward",
    publishes: r#""training.result""#,
    subscribes: r#""level.control""#,
    run: ["awkward", "--input", "script:script.toml"],
};
pub const OBJECTS: Role = Role {
    kind: "objects",
    name: "objects",
    publishes: r#""object.scene""#,
    subscribes: r#""object.set""#,
    run: TOUCH,
};
pub const RENDERER: Role = Role {
    kind: "renderer",
    name: "renderer",
    publishes: "",
    subscribes: r#""object.scene", "picture.request""#,
    run: TOUCH,
};
pub const RECORDER: Role = Role {
    kind: "recorder",
    name: "recorder",
    publishes: "",
    subscribes: r#""session.record""#,
    run: TOUCH,
};

impl Role {
    /// Folder in the installation.
    pub fn folder(&self) -> String {
        let kind = if self.kind == "module" {
            "modules"
        } else {
            "plugins"
        };
        format!("{kind}/{}", self.name)
    }

    /// Manifest, as a path in the installation.
    pub fn manifest_file(&self) -> String {
        let file = if self.kind == "module" {
            "module.toml"
        } else {
            "plugin.toml"
        };
        format!("{}/{file}", self.folder())
    }

    /// Text of the manifest for a library.
    pub fn manifest(&self, library: &str) -> String {
        let Self {
            kind,
            name,
            publishes,
            subscribes,
            ..
        } = self;
        let plugins = if *kind == "module" {
            "plugins = [\"translator\", \"objects\"]\n"
        } else {
            ""
        };
        format!(
            "name = \"{name}\"\nkind = \"{kind}\"\nversion = \"0.1.0\"\nabi = 2\nlicence = \"MIT OR Apache-2.0\"\n\
             library = \"{library}\"\npublishes = [{publishes}]\nsubscribes = [{subscribes}]\n{plugins}\n\
             [title]\nde = \"Quer\"\nen = \"Awkward\"\n\n\
             [summary]\nde = \"Geht schief.\"\nen = \"Goes wrong.\"\n"
        )
    }
}

/// An installation in which the library of a fixture stands for a role.
pub struct Installed {
    pub tree: Tree,
    pub role: Role,
}

impl Installed {
    /// The awkward plugin in a role.
    pub fn awkward(role: Role) -> Self {
        Self::library(role, "microsim-fixture-awkward")
    }

    /// The library of a fixture in a role.
    pub fn library(role: Role, package: &str) -> Self {
        let tree = Tree::new();
        let library = package.replace('-', "_");
        tree.write(&role.manifest_file(), role.manifest(&library));
        let file = fixture_library(package);
        let name = file.file_name().expect("a name");
        std::fs::copy(&file, tree.path(role.folder()).join(name)).expect("the library is copied");
        if role.kind == "module" {
            tree.write(&format!("{}/levels/level1.toml", role.folder()), LEVEL);
        }
        tree.write("script.toml", SCRIPT);
        Self { tree, role }
    }

    /// The program on this installation, with the plugin's misbehaviour prescribed.
    pub fn command(&self, told: &str, args: &[&str]) -> Command {
        let mut command = self.tree.command(args);
        command.env("MICROSIM_AWKWARD", told);
        command.env(
            "MICROSIM_AWKWARD_MANIFEST",
            self.tree.path(self.role.manifest_file()),
        );
        command
    }

    /// Runs the role's module with the plugin's misbehaviour prescribed; the session file is named after that.
    pub fn run(&self, told: &str, more: &[&str]) -> Run {
        let session = self
            .tree
            .path(format!("{}.session", told.replace(' ', "-")));
        let mut command = self.command(told, &["run"]);
        command
            .args(self.role.run)
            .args(more)
            .arg("--session")
            .arg(&session);
        Run {
            output: finish(&mut command),
            session,
        }
    }
}

/// A run that was tried.
#[derive(Debug)]
pub struct Run {
    pub output: Finished,
    pub session: PathBuf,
}

/// Reads a session file.
pub fn read(path: &Path) -> Session {
    let bytes = std::fs::read(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    Session::read(&bytes).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

impl Run {
    /// The run did not begin: exit status 2, one sentence, no session.
    #[track_caller]
    pub fn assert_refused(&self, sentence: &str) {
        assert_eq!(self.output.code, Some(2), "{self:?}");
        assert_eq!(self.output.out, "", "{self:?}");
        let printed: Vec<&str> = self.complaints();
        assert_eq!(printed.len(), 1, "{self:?}");
        assert!(
            printed[0].contains(sentence),
            "expected {sentence:?} in {self:?}"
        );
        assert!(!self.session.exists(), "{self:?}");
    }

    /// The run ended by a failure after `ticks` ticks: exit status 2, the plugin named in one sentence, and a closed
    /// session that holds all these ticks and the failure; `report` shows them. Returns what it reports of the verdict.
    #[track_caller]
    pub fn assert_preserved(&self, ticks: u64, sentence: &str) -> serde_json::Value {
        assert_eq!(self.output.code, Some(2), "{self:?}");
        let printed = self.complaints();
        assert_eq!(printed.len(), 1, "{self:?}");
        let safe = format!("; the session so far is safe in {}", self.session.display());
        let reason = printed[0]
            .strip_prefix("microsim: ")
            .and_then(|s| s.strip_suffix(&safe));
        let reason = reason.unwrap_or_else(|| panic!("{self:?}"));
        assert!(
            reason.starts_with(sentence),
            "expected {sentence:?} in {self:?}"
        );

        let session = read(&self.session);
        assert_eq!(session.complaint, None, "{self:?}");
        assert_eq!(
            session.end.as_ref().map(|e| e.ended),
            Some(Ended::Failure),
            "{self:?}"
        );
        let numbers: Vec<u64> = session.ticks.iter().map(|(tick, _)| *tick).collect();
        assert_eq!(numbers, (0..ticks).collect::<Vec<_>>(), "{self:?}");
        let failures: Vec<String> = session.failures.iter().map(ToString::to_string).collect();
        assert_eq!(failures, [reason], "{self:?}");

        let report = microsim_tests::microsim([
            "report".as_ref(),
            self.session.as_os_str(),
            "--json".as_ref(),
        ]);
        let report = report.expect(0).json();
        assert_eq!(report["session"]["failures"][0], reason, "{report}");
        report["verdict"].clone()
    }

    /// What the program itself printed on standard error; the log has other lines.
    fn complaints(&self) -> Vec<&str> {
        self.output
            .err
            .lines()
            .filter(|line| line.starts_with("microsim: "))
            .collect()
    }
}
