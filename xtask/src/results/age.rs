//! Whether code is the same as at a commit, as git knows it.

use super::code::{code, counts};
use super::page::{Again, Head};
use crate::failure::Failure;
use std::collections::BTreeMap;
use std::fmt;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A page beside its code.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Age {
    /// The code is what was measured.
    Same,
    /// These files have other code now.
    Older(Vec<String>),
    /// It is of the code of its commit, whatever that is now.
    Record,
    /// Why it is not known.
    Unknown(String),
    /// What is wrong with the head of the page.
    NoHead(String),
    /// These commits, named in the text, are not in the history.
    NamesMissing(Vec<String>),
}

impl Age {
    /// Whether the page holds for other code than is there, or may.
    pub fn is_older(&self) -> bool {
        !matches!(self, Self::Same | Self::Record)
    }
}

impl fmt::Display for Age {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Same => f.write_str("as its code"),
            Self::Record => f.write_str("a record of its commit"),
            Self::Older(files) => {
                let first: Vec<_> = files.iter().take(3).map(String::as_str).collect();
                write!(f, "OLDER than its code: {}", first.join(", "))?;
                match files.len() {
                    0..=3 => Ok(()),
                    count => write!(f, " and {} more", count - 3),
                }
            }
            Self::Unknown(why) => write!(f, "UNKNOWN age: {why}"),
            Self::NoHead(error) => write!(f, "NO HEAD: {error}"),
            Self::NamesMissing(commits) => {
                let commits = commits.join(", ");
                write!(f, "WRONG COMMITS: the history has no {commits}")
            }
        }
    }
}

/// The history of a repository.
#[derive(Debug)]
pub struct History {
    root: PathBuf,
    folders: BTreeMap<String, Vec<String>>,
}

impl History {
    /// Of the repository in a folder.
    pub fn of(root: &Path) -> Self {
        Self {
            root: root.to_path_buf(),
            folders: BTreeMap::new(),
        }
    }

    /// The commit of the working tree.
    pub fn head(&self) -> Result<String, Failure> {
        match self.git(&["rev-parse", "--short=10", "HEAD"]) {
            Some(commit) => Ok(commit.trim().to_owned()),
            None => Err(Failure::Cannot(format!(
                "{} has no git history: a page of results names its commit",
                self.root.display()
            ))),
        }
    }

    /// The age of a page; `packages` gives the folders that a package consists of.
    pub fn age(
        &mut self,
        head: &Head,
        packages: &mut dyn FnMut(&str) -> Result<Vec<String>, Failure>,
    ) -> Result<Age, Failure> {
        let commit = &head.commit;
        if self.git(&["rev-parse", "HEAD"]).is_none() {
            return Ok(Age::Unknown("git knows no history here".into()));
        }
        if !self.has(commit) {
            let advice = match self.is_shallow() {
                true => "this clone is shallow; `git fetch --unshallow` brings the rest",
                false => "it was made in another repository, or its branch is gone",
            };
            return Ok(Age::Unknown(format!(
                "commit {commit} is not in the history: {advice}"
            )));
        }
        if head.again == Again::Never {
            return Ok(Age::Record);
        }
        let mut changed = Vec::new();
        for measured in &head.measures {
            // A path may be gone since; names of packages have no slash.
            let there = self.root.join(measured).exists();
            let named = there || measured.contains('/');
            if named
                && !there
                && self
                    .git(&["show", &format!("{commit}:{measured}")])
                    .is_none()
            {
                return Ok(Age::NoHead(format!(
                    "it measures {measured}, which is not there and was not at {commit}"
                )));
            }
            let paths = match (named, self.folders.get(measured)) {
                (true, _) => vec![measured.clone()],
                (false, Some(known)) => known.clone(),
                (false, None) => match packages(measured) {
                    Ok(folders) => {
                        self.folders.insert(measured.clone(), folders.clone());
                        folders
                    }
                    Err(Failure::Cannot(error)) => return Ok(Age::NoHead(error)),
                    Err(other) => return Err(other),
                },
            };
            for path in self.changed(commit, &paths)? {
                if counts(&path, named) && !changed.contains(&path) && self.differs(commit, &path) {
                    changed.push(path);
                }
            }
        }
        changed.sort();
        Ok(if changed.is_empty() {
            Age::Same
        } else {
            Age::Older(changed)
        })
    }

    /// The commits that a text names in backticks and the history lacks; none where the history is not whole.
    pub fn missing_commits(&self, text: &str) -> Vec<String> {
        let is_commit = |word: &&str| {
            let letters = word.bytes().filter(u8::is_ascii_lowercase).count();
            let is_hex = word.bytes().all(|b| matches!(b, b'0'..=b'9' | b'a'..=b'f'));
            (7..=40).contains(&word.len()) && is_hex && (1..word.len()).contains(&letters)
        };
        let words = text.split('`').skip(1).step_by(2).filter(is_commit);
        let mut missing: Vec<String> = words
            .filter(|commit| !self.has(commit))
            .map(str::to_owned)
            .collect();
        missing.sort();
        missing.dedup();
        if !missing.is_empty() && self.is_shallow() {
            missing.clear();
        }
        missing
    }

    fn has(&self, commit: &str) -> bool {
        let commit = format!("{commit}^{{commit}}");
        self.git(&["cat-file", "-e", &commit]).is_some()
    }

    fn is_shallow(&self) -> bool {
        let answer = self.git(&["rev-parse", "--is-shallow-repository"]);
        answer.is_some_and(|answer| answer.trim() == "true")
    }

    /// Files that are not byte for byte what they were: changed, new, gone.
    fn changed(&self, commit: &str, paths: &[String]) -> Result<Vec<String>, Failure> {
        let paths: Vec<&str> = paths.iter().map(String::as_str).collect();
        let mut files = Vec::new();
        for before in [
            &["diff", "--name-only", "-z", "--no-renames", commit, "--"][..],
            &["ls-files", "--others", "--exclude-standard", "-z", "--"],
        ] {
            let listed = self
                .git(&[before, &paths].concat())
                .ok_or_else(|| Failure::Cannot(format!("`git {}` failed", before.join(" "))))?;
            files.extend(
                listed
                    .split('\0')
                    .filter(|file| !file.is_empty())
                    .map(str::to_owned),
            );
        }
        Ok(files)
    }

    fn differs(&self, commit: &str, path: &str) -> bool {
        let now = std::fs::read(self.root.join(path)).ok();
        let now = now.map(|bytes| code(path, &String::from_utf8_lossy(&bytes)));
        let then = self.git(&["show", &format!("{commit}:{path}")]);
        now != then.map(|text| code(path, &text))
    }

    /// What git prints; nothing if it fails.
    fn git(&self, arguments: &[&str]) -> Option<String> {
        let mut git = Command::new("git");
        let output = git.current_dir(&self.root).args(arguments).output().ok()?;
        output
            .status
            .success()
            .then(|| String::from_utf8_lossy(&output.stdout).into_owned())
    }
}

#[cfg(test)]
mod tests {
    use super::super::page::Again;
    use super::*;

    fn repository() -> tempfile::TempDir {
        let folder = tempfile::tempdir().expect("a folder");
        let root = folder.path();
        std::fs::create_dir_all(root.join("crates/a/src")).expect("folders");
        write(root, "crates/a/src/lib.rs", "// One.\nfn f() -> u8 { 1 }\n");
        write(root, "crates/b.rs", "fn g() {}\n");
        git(root, &["init", "-q"]);
        commit(root);
        folder
    }

    fn write(root: &Path, path: &str, text: &str) {
        std::fs::write(root.join(path), text).expect(path);
    }

    fn git(root: &Path, arguments: &[&str]) {
        let mut git = Command::new("git");
        git.current_dir(root)
            .args(["-c", "user.name=t", "-c", "user.email=t@t"]);
        let done = git.args(arguments).output().expect("git");
        assert!(done.status.success(), "{arguments:?} {done:?}");
    }

    fn commit(root: &Path) {
        git(root, &["add", "-A"]);
        git(root, &["commit", "-q", "-m", "x"]);
    }

    fn age(root: &Path, commit: &str, measures: &str) -> Age {
        let head = Head {
            commands: vec!["microsim atlas".into()],
            commit: commit.into(),
            machine: "m".into(),
            measures: vec![measures.into()],
            again: Again::Light,
        };
        let mut packages = |_: &str| Ok(vec!["crates/a".to_owned()]);
        History::of(root)
            .age(&head, &mut packages)
            .expect("an answer")
    }

    #[test]
    fn a_page_made_older_on_purpose_is_found() {
        let folder = repository();
        let root = folder.path();
        let made = History::of(root).head().expect("a commit");
        assert_eq!(age(root, &made, "microsim-a"), Age::Same);
        // Other comments and other packages leave it what it is; committed or not.
        write(
            root,
            "crates/a/src/lib.rs",
            "// Two.\nfn f() -> u8 {\n    1\n}\n",
        );
        write(root, "crates/b.rs", "fn h() {}\n");
        assert_eq!(age(root, &made, "microsim-a"), Age::Same);
        assert_eq!(
            age(root, &made, "crates/b.rs"),
            Age::Older(vec!["crates/b.rs".into()])
        );
        commit(root);
        assert_eq!(age(root, &made, "microsim-a"), Age::Same);
        write(root, "crates/a/src/lib.rs", "fn f() -> u8 { 2 }\n");
        let older = Age::Older(vec!["crates/a/src/lib.rs".into()]);
        assert_eq!(age(root, &made, "microsim-a"), older);
        commit(root);
        assert_eq!(age(root, &made, "microsim-a"), older);
        // A new file that is not committed counts, one that is gone too.
        let now = History::of(root).head().expect("a commit");
        write(root, "crates/a/src/new.rs", "fn n() {}\n");
        assert_eq!(
            age(root, &now, "microsim-a"),
            Age::Older(vec!["crates/a/src/new.rs".into()])
        );
        std::fs::remove_file(root.join("crates/a/src/new.rs")).expect("gone");
        std::fs::remove_file(root.join("crates/a/src/lib.rs")).expect("gone");
        assert_eq!(age(root, &now, "microsim-a"), older);
        // So does one that the head itself names.
        std::fs::remove_file(root.join("crates/b.rs")).expect("gone");
        let gone = Age::Older(vec!["crates/b.rs".into()]);
        assert_eq!(age(root, &now, "crates/b.rs"), gone);
        let never = age(root, &now, "crates/c.rs");
        assert!(matches!(&never, Age::NoHead(why) if why.contains("crates/c.rs")));
    }

    #[test]
    fn without_its_commit_no_page_is_called_as_its_code() {
        let folder = repository();
        let unknown = age(folder.path(), "0123456789", "microsim-a");
        assert!(matches!(&unknown, Age::Unknown(why) if why.contains("not in the history")));
        // A clone of the last commit alone.
        let first = History::of(folder.path()).head().expect("a commit");
        write(folder.path(), "crates/b.rs", "fn h() {}\n");
        commit(folder.path());
        let shallow = tempfile::tempdir().expect("a folder");
        let from = format!("file://{}", folder.path().display());
        git(shallow.path(), &["clone", "-q", "--depth", "1", &from, "c"]);
        let unknown = age(&shallow.path().join("c"), &first, "microsim-a");
        assert!(matches!(&unknown, Age::Unknown(why) if why.contains("--unshallow")));
        let bare = tempfile::tempdir().expect("a folder");
        let nothing = age(bare.path(), &first, "microsim-a");
        assert!(matches!(&nothing, Age::Unknown(why) if why.contains("no history")));
    }

    /// Words in backticks that look like commits have to be some; numbers, names and whole digests are none.
    #[test]
    fn commits_that_a_page_names_are_in_the_history() {
        let folder = repository();
        let history = History::of(folder.path());
        let first = history.head().expect("a commit");
        let digest = "0123456789abcdef".repeat(4);
        let text = format!("`{first}`, `4001`, `1234567`, `defaced`, `torn`, `{digest}`, 0123abc");
        let none: [&str; 0] = [];
        assert_eq!(history.missing_commits(&text), none);
        assert_eq!(history.missing_commits("`0123abc` `0123abc`"), ["0123abc"]);
        write(folder.path(), "crates/b.rs", "fn h() {}\n");
        commit(folder.path());
        let shallow = tempfile::tempdir().expect("a folder");
        let from = format!("file://{}", folder.path().display());
        git(shallow.path(), &["clone", "-q", "--depth", "1", &from, "c"]);
        let history = History::of(&shallow.path().join("c"));
        assert_eq!(history.missing_commits(&format!("`{first}`")), none);
    }
}
