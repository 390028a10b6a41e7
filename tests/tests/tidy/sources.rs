//! What must not stand in the code that simulates and scores: the same build gives the same bits on any machine.

use crate::{assert_none, files_below, text};
use microsim_tests::repository;
use std::path::{Path, PathBuf};

/// Crates and plugins on which state and score of a run depend; all modules besides.
const CRATES: [&str; 18] = [
    "random",
    "geometry",
    "mesh",
    "sparse",
    "contact-solver",
    "tissue",
    "contact",
    "cutting",
    "scene",
    "tracking",
    "igtl",
    "training",
    "sdk",
    "bus",
    "message",
    "session",
    "settings",
    "host",
];
const PLUGINS: [&str; 5] = [
    "translator",
    "objects",
    "physics",
    "source-recording",
    "source-script",
];

/// Functions that the system's library computes, with other last bits on another system.
const TRANSCENDENTAL: [&str; 25] = [
    "sin", "cos", "tan", "sin_cos", "asin", "acos", "atan", "atan2", "sinh", "cosh", "tanh",
    "asinh", "acosh", "atanh", "exp", "exp2", "exp_m1", "ln", "ln_1p", "log2", "log10", "powf",
    "powi", "hypot", "cbrt",
];

/// A line of code, without its comment.
struct Line {
    number: usize,
    code: String,
}

/// The lines of a source that are no comments and no tests.
fn lines(source: &str) -> Vec<Line> {
    let mut lines = Vec::new();
    let mut numbered = source.lines().enumerate().map(|(n, line)| (n + 1, line));
    while let Some((number, line)) = numbered.next() {
        if line.trim() == "#[cfg(test)]" {
            skip_item(&mut numbered);
            continue;
        }
        let code = line.split("//").next().unwrap_or_default();
        if !code.trim().is_empty() {
            lines.push(Line {
                number,
                code: code.to_owned(),
            });
        }
    }
    lines
}

/// Skips the item that begins with the next line; its last line is as far to the left as its first.
fn skip_item<'a>(lines: &mut impl Iterator<Item = (usize, &'a str)>) {
    let Some((_, first)) = lines.find(|(_, line)| !line.trim_start().starts_with("#[")) else {
        return;
    };
    if first.trim_end().ends_with(';') || first.trim_end().ends_with('}') {
        return;
    }
    let indent = first.len() - first.trim_start().len();
    let _ = lines.find(|(_, line)| line.starts_with(&format!("{}}}", " ".repeat(indent))));
}

/// Whether a source below the repository holds nothing but tests.
pub fn is_test(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let below = path.strip_prefix(repository()).unwrap_or(path);
    let inside = below.components().any(|part| part.as_os_str() == "tests");
    inside || name == "tests.rs" || name.ends_with("_tests.rs") || name == "testing.rs"
}

/// Sources of all that simulates and scores.
fn simulation() -> Vec<PathBuf> {
    let root = repository();
    let mut folders: Vec<PathBuf> = CRATES.map(|name| root.join("crates").join(name)).into();
    folders.extend(PLUGINS.map(|name| root.join("plugins").join(name)));
    folders.push(root.join("modules"));
    let sources = folders.iter().flat_map(|folder| {
        assert!(
            folder.is_dir(),
            "{} is gone: correct the list",
            folder.display()
        );
        files_below(folder, ".rs")
    });
    sources.filter(|path| !is_test(path)).collect()
}

/// Complaints about every line of these sources in which `find` finds something.
fn complaints(sources: &[PathBuf], find: impl Fn(&Path, &str) -> Option<String>) -> Vec<String> {
    let mut complaints = Vec::new();
    for path in sources {
        for line in lines(&text(path)) {
            if let Some(what) = find(path, &line.code) {
                complaints.push(format!(
                    "{}:{}: {what}: {}",
                    path.display(),
                    line.number,
                    line.code.trim()
                ));
            }
        }
    }
    complaints
}

/// Where a word stands as a whole.
pub fn has_word(code: &str, word: &str) -> bool {
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    code.match_indices(word).any(|(at, _)| {
        !code[..at].ends_with(is_word) && !code[at + word.len()..].starts_with(is_word)
    })
}

/// `libm::exp(x)` is right, `x.exp()` and `f64::exp(x)` are not.
fn calls(code: &str, name: &str) -> bool {
    code.contains(&format!(".{name}("))
        || ["f64", "f32", "$number"]
            .into_iter()
            .any(|number| code.contains(&format!("{number}::{name}")))
}

fn transcendental(code: &str) -> Option<&'static str> {
    TRANSCENDENTAL.into_iter().find(|name| calls(code, name))
}

/// The crates in which fused products may stand: those of `sparse` and of the elements and laws of `tissue` round once, in a fixed order, by an
/// instruction that the build's target has, so their bits are those of every machine. Elsewhere they would be what a plain product and sum are
/// not, and which of both stands where is for these crates to know.
const FUSED: [&str; 2] = ["crates/sparse/src", "crates/tissue/src"];

fn may_fuse(path: &Path) -> bool {
    FUSED
        .iter()
        .any(|folder| path.starts_with(repository().join(folder)))
}

pub fn of_the_systems_library(sources: &[PathBuf]) -> Vec<String> {
    complaints(sources, |_, code| {
        transcendental(code).map(|name| format!("`{name}` of std: use the crate libm"))
    })
}

#[test]
fn no_function_of_the_systems_library_decides_a_bit() {
    assert_none(&of_the_systems_library(&simulation()));
}

#[test]
fn products_are_fused_in_two_crates_alone() {
    assert_none(&complaints(&simulation(), |path, code| {
        let fused = !may_fuse(path) && calls(code, "mul_add");
        fused.then(|| "`mul_add`: only crates/sparse and crates/tissue fuse products".into())
    }));
    // What the exceptions are for is there; and the instruction is in the build.
    for folder in FUSED {
        let files = files_below(&repository().join(folder), ".rs");
        assert!(files.iter().any(|path| {
            let source = text(path);
            lines(&source)
                .iter()
                .any(|line| calls(&line.code, "mul_add"))
        }));
    }
    assert!(text(&repository().join(".cargo/config.toml")).contains("target-cpu=x86-64-v3"));
}

pub fn left_to_chance(sources: &[PathBuf]) -> Vec<String> {
    complaints(sources, |_, code| {
        let map = ["HashMap", "HashSet"]
            .into_iter()
            .find(|word| has_word(code, word));
        map.map(|word| format!("`{word}` has another order in every process: use a BTree or a Vec"))
    })
}

#[test]
fn no_order_is_left_to_chance() {
    assert_none(&left_to_chance(&simulation()));
}

/// Where the host reads the wall clock: the pace of a run, and when a guest has ended, which is an input of the run.
const CLOCKS: [&str; 3] = [
    "crates/host/src/run.rs",
    "crates/host/src/guest.rs",
    "crates/host/src/guest/words.rs",
];

pub fn clocks(sources: &[PathBuf]) -> Vec<String> {
    complaints(sources, |path, code| {
        if CLOCKS.iter().any(|edge| path.ends_with(edge)) {
            return None;
        }
        let clock = ["Instant", "SystemTime"]
            .into_iter()
            .find(|word| has_word(code, word));
        clock.map(|word| format!("`{word}`: only {} read a clock", CLOCKS.join(", ")))
    })
}

/// The wall clock is read at the edge of the host alone.
#[test]
fn no_clock_is_read() {
    assert_none(&clocks(&simulation()));
}

/// The checks above find what they look for, and nothing in comments and tests.
#[test]
fn the_checks_can_fail() {
    assert_eq!(transcendental("let y = x.exp();"), Some("exp"));
    assert_eq!(
        transcendental("values.map(f64::sqrt).map(f64::hypot)"),
        Some("hypot")
    );
    assert_eq!(
        transcendental("let y = libm::exp(x).sqrt().max(x.expect(\"a number\"));"),
        None
    );
    assert!(calls("let y = a.mul_add(b, c);", "mul_add"));
    assert!(calls("a.map(f32::mul_add)", "mul_add"));
    assert!(!calls("fn mul_add(self, a: Self) -> Self;", "mul_add"));
    let root = repository();
    assert!(may_fuse(&root.join("crates/sparse/src/kernels.rs")));
    assert!(!may_fuse(&root.join("crates/scene/src/tick.rs")));
    assert!(!may_fuse(&root.join("crates/sparse-more/src/lib.rs")));
    assert!(has_word("use std::time::{Duration, Instant};", "Instant"));
    assert!(!has_word("let instant = Instantaneous;", "Instant"));

    let source = "\
//! x.sin()
fn a() {} // x.sin()
#[cfg(test)]
mod more;
#[cfg(test)]
#[rustfmt::skip]
mod tests {
    fn b() {
    }
}
fn c() {}
";
    let found: Vec<(usize, String)> = lines(source)
        .into_iter()
        .map(|line| (line.number, line.code.trim().to_owned()))
        .collect();
    assert_eq!(
        found,
        [(2, "fn a() {}".to_owned()), (11, "fn c() {}".to_owned())]
    );

    // Enough is read: a crate that moved would leave the checks without anything to find.
    assert!(simulation().len() > 80, "{}", simulation().len());
    assert!(is_test(Path::new("crates/bus/src/router_tests.rs")));
    assert!(is_test(Path::new("crates/training/src/level/tests.rs")));
    assert!(!is_test(Path::new("crates/training/src/level.rs")));
}
