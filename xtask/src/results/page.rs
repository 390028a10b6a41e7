//! The head of a page of results: one row of a table with what made the page, where, and of which code.

use std::path::{Path, PathBuf};

/// The table's first two lines.
pub const COLUMNS: &str =
    "| command | commit | machine | measures | made again |\n|---|---|---|---|---|\n";

/// Who makes a page again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Again {
    /// Its command, in less than a few minutes; the figures are the same on every machine.
    Light,
    /// Its command, long or with times that are a machine's.
    Heavy,
    /// A person, from what its commands print.
    ByHand,
    /// Nobody: it records what was tried at its commit.
    Never,
}

/// What made a page.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Head {
    /// Commands, each as one would type it in the repository.
    pub commands: Vec<String>,
    /// The commit whose code was measured.
    pub commit: String,
    /// Where.
    pub machine: String,
    /// Packages, with all of the workspace that they depend on, and paths.
    pub measures: Vec<String>,
    /// Who makes it again.
    pub again: Again,
}

/// A page of results.
#[derive(Clone, Debug)]
pub struct Page {
    /// Its file.
    pub path: PathBuf,
    /// Its bytes.
    pub text: String,
    /// Its head, or what is wrong with it.
    pub head: Result<Head, String>,
}

impl Page {
    /// Reads a page.
    pub fn read(path: &Path) -> Result<Self, String> {
        let text = std::fs::read_to_string(path).map_err(|e| format!("{}: {e}", path.display()))?;
        let head = Head::of(&text);
        Ok(Self {
            path: path.to_path_buf(),
            text,
            head,
        })
    }
}

impl Head {
    /// The head of a page.
    pub fn of(text: &str) -> Result<Self, String> {
        let Some((before, after)) = text.split_once(COLUMNS) else {
            let columns = COLUMNS.lines().next().unwrap_or_default();
            return Err(format!("line 3: expected the head `{columns}`"));
        };
        let line = before.lines().count() + 3;
        Self::row(after.lines().next().unwrap_or_default())
            .map_err(|error| format!("line {line}: {error}"))
    }

    fn row(row: &str) -> Result<Self, String> {
        let cells: Vec<_> = row.trim().trim_matches('|').split('|').collect();
        let cells: Vec<_> = cells.iter().map(|cell| cell.trim()).collect();
        let [command, commit, machine, measures, again] = cells[..] else {
            return Err(format!("expected a row of 5 cells, found {}", cells.len()));
        };
        let commit = commit.trim_matches('`');
        if commit.len() < 7 || !commit.bytes().all(|byte| byte.is_ascii_hexdigit()) {
            return Err(format!(
                "expected a commit of at least 7 digits, found \"{commit}\""
            ));
        }
        let again = match again {
            "light" => Again::Light,
            "heavy" => Again::Heavy,
            "by hand" => Again::ByHand,
            "never" => Again::Never,
            other => {
                return Err(format!(
                    "expected \"light\", \"heavy\", \"by hand\" or \"never\", found \"{other}\""
                ));
            }
        };
        let commands: Vec<_> = command.split('`').skip(1).step_by(2).collect();
        if commands.is_empty() || machine.is_empty() || measures.is_empty() {
            return Err("expected a command in backticks, a machine and what is measured".into());
        }
        Ok(Self {
            commands: commands.into_iter().map(str::to_owned).collect(),
            commit: commit.to_owned(),
            machine: machine.to_owned(),
            measures: measures.split_whitespace().map(str::to_owned).collect(),
            again,
        })
    }

    /// Whether commands make the whole page: all of its own are among them.
    pub fn is_made_by(&self, commands: &[String]) -> bool {
        self.commands.iter().all(|own| commands.contains(own))
    }

    /// The head of the page when it is made again at a commit on a machine. Where no figure depends on the machine it stays so.
    pub fn made(self, commit: String, machine: String) -> Self {
        let machine = match self.machine.starts_with("any") {
            true => self.machine,
            false => machine,
        };
        Self {
            commit,
            machine,
            ..self
        }
    }

    /// The page with this head: instead of the one that it has, or below its title.
    pub fn put(&self, text: &str) -> String {
        let table = format!("{COLUMNS}{}\n", self.line());
        if let Some((before, after)) = text.split_once(COLUMNS) {
            let rest = after.split_once('\n').map_or("", |(_, rest)| rest);
            return format!("{before}{table}{rest}");
        }
        let (title, rest) = text.split_once('\n').unwrap_or((text, ""));
        format!("{title}\n\n{table}\n{}", rest.trim_start_matches('\n'))
    }

    fn line(&self) -> String {
        let again = match self.again {
            Again::Light => "light",
            Again::Heavy => "heavy",
            Again::ByHand => "by hand",
            Again::Never => "never",
        };
        format!(
            "| `{}` | `{}` | {} | {} | {again} |",
            self.commands.join("`, `"),
            self.commit,
            self.machine,
            self.measures.join(" ")
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_head_is_put_and_read_again() {
        let head = Head {
            commands: vec!["cargo xtask bench host".into(), "microsim atlas".into()],
            commit: "0123abc".into(),
            machine: "Linux, 2 cores".into(),
            measures: vec!["microsim-host".into(), "config/scenes".into()],
            again: Again::Heavy,
        };
        let page = head.put("# Title\n\nText.\n");
        assert_eq!(Head::of(&page), Ok(head.clone()));
        assert!(
            page.starts_with("# Title\n\n| command") && page.ends_with("|\n\nText.\n"),
            "{page}"
        );
        // A second time it takes the place of the first.
        assert_eq!(head.put(&page), page);
        assert!(head.is_made_by(&head.commands));
        assert!(!head.is_made_by(&head.commands[..1]));
        let made = head.clone().made("4567def".into(), "a laptop".into());
        assert_eq!([&made.commit[..], &made.machine], ["4567def", "a laptop"]);
        let machine = "any: no figure depends on it".to_owned();
        let everywhere = Head { machine, ..head };
        let made = everywhere.made("4567def".into(), "a laptop".into());
        assert_eq!(made.machine, "any: no figure depends on it");
    }

    #[test]
    fn a_wrong_head_is_told_with_its_line() {
        let wrong = |row: &str| Head::of(&format!("# T\n\n{COLUMNS}{row}\n")).unwrap_err();
        assert!(Head::of("# T\n").unwrap_err().starts_with("line 3"));
        for (row, part) in [
            ("| `c` | `0123abc` | m | x |", "5 cells, found 4"),
            ("| `c` | `abc` | m | x | light |", "found \"abc\""),
            ("| `c` | `0123abc` | m | x | soon |", "found \"soon\""),
            (
                "| c | `0123abc` | m | x | light |",
                "a command in backticks",
            ),
        ] {
            let error = wrong(row);
            assert!(
                error.starts_with("line 5") && error.contains(part),
                "{error}"
            );
        }
    }
}
