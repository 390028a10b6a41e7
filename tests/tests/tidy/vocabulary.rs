//! `crates/GLOSSARY.md`: its terms exist, and the words that it rules out occur in no public name and no doc comment.

use crate::rust::{code, public_names};
use crate::sources::{has_word, is_test};
use crate::{assert_none, files_below, sources, text};
use microsim_tests::repository;
use std::collections::BTreeSet;
use std::path::PathBuf;

/// Where such a word may stand: end of the file's path, word, reason.
const ALLOWED: &[(&str, &str, &str)] = &[];

/// Most entries of that list.
const MOST_ALLOWED: usize = 20;

/// The cells of a table's row.
fn cells(row: &str) -> Vec<String> {
    let row = row.trim().trim_matches('|').replace("\\|", "\u{1}");
    let cells = row.split('|');
    cells
        .map(|cell| cell.trim().replace('\u{1}', "|"))
        .collect()
}

/// The words and phrases that are not used, from the glossary's last table.
fn banned(glossary: &str) -> Vec<String> {
    let table = glossary.rsplit("|---|---|\n").next().unwrap_or_default();
    let rows = table.lines().take_while(|line| line.starts_with('|'));
    let mut banned = Vec::new();
    for row in rows {
        let mut words = cells(row)[0].clone();
        // What stands in brackets says of which meaning the word is.
        while let (Some(open), Some(close)) = (words.find('('), words.find(')')) {
            words.replace_range(open..=close, "");
        }
        banned.extend(words.split(',').map(|word| word.trim().to_owned()));
    }
    banned
}

/// The terms that are public items: what stands in backquotes in the second column.
fn terms(glossary: &str) -> Vec<String> {
    let rows = glossary.lines().filter(|line| line.starts_with("| "));
    let names = rows.filter_map(|row| {
        let cells = cells(row);
        let name = cells.get(1)?.strip_prefix('`')?.strip_suffix('`')?;
        Some(name.to_owned())
    });
    names.collect()
}

/// The words of a name, in small letters: `GapTolerance` and `gap_tolerance` have two.
fn words(name: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let chars: Vec<char> = name.chars().collect();
    for (i, &c) in chars.iter().enumerate() {
        let after_small = i > 0 && !chars[i - 1].is_uppercase();
        let before_small = chars.get(i + 1).is_some_and(|next| next.is_lowercase());
        if c == '_' || (c.is_uppercase() && (after_small || before_small)) {
            words.push(String::new());
        }
        if c != '_' {
            words.last_mut().expect("one").extend(c.to_lowercase());
        }
    }
    words.retain(|word| !word.is_empty());
    words
}

/// Lines of documentation, with their numbers.
fn documentation(source: &str) -> Vec<(usize, &str)> {
    let lines = (1..).zip(source.lines().map(str::trim_start));
    lines
        .filter(|(_, line)| {
            line.starts_with("//!") || (line.starts_with("///") && !line.starts_with("////"))
        })
        .collect()
}

fn complaints(banned: &[String], source: &str) -> Vec<(usize, String)> {
    let mut found = Vec::new();
    for (line, name) in public_names(&code(source)) {
        for word in words(&name).into_iter().filter(|w| banned.contains(w)) {
            found.push((line, format!("`{name}`: \"{word}\"")));
        }
    }
    for (line, doc) in documentation(source) {
        // The flag of a command is no word.
        let small = doc.to_lowercase().replace("--quick", "");
        for word in banned.iter().filter(|word| has_word(&small, word)) {
            found.push((line, format!("\"{word}\" in: {doc}")));
        }
    }
    found.sort();
    found
}

/// Words that the glossary rules out, in sources without exceptions.
pub fn words_not_used(sources: &[PathBuf]) -> Vec<String> {
    let banned = banned(&text(&repository().join("crates/GLOSSARY.md")));
    let found = sources.iter().flat_map(|path| {
        let found = complaints(&banned, &text(path)).into_iter();
        found.map(|(line, complaint)| format!("{}:{line}: {complaint}", path.display()))
    });
    found.collect()
}

#[test]
fn no_public_name_and_no_documentation_has_a_word_that_is_not_used() {
    let banned = banned(&text(&repository().join("crates/GLOSSARY.md")));
    assert!(banned.len() > 20, "{banned:?}");
    assert!(ALLOWED.len() <= MOST_ALLOWED);
    let mut open: BTreeSet<_> = ALLOWED.iter().collect();
    let mut complaints_of_all = Vec::new();
    for path in sources() {
        let name = path
            .strip_prefix(repository())
            .unwrap_or(&path)
            .display()
            .to_string();
        for (line, complaint) in complaints(&banned, &text(&path)) {
            let quoted = |word: &str| complaint.contains(&format!("\"{word}\""));
            let allowed = ALLOWED
                .iter()
                .find(|(file, word, _)| name.ends_with(file) && quoted(word));
            match allowed {
                Some(allowed) => {
                    open.remove(allowed);
                }
                None => complaints_of_all.push(format!("{name}:{line}: {complaint}")),
            }
        }
    }
    // An exception that nothing needs any more leaves the list.
    complaints_of_all.extend(open.iter().map(|(file, word, _)| {
        format!("the list allows \"{word}\" in {file}, where it does not stand")
    }));
    assert_none(&complaints_of_all);
}

#[test]
fn every_term_that_is_a_public_item_exists() {
    let sources = files_below(&repository().join("crates"), ".rs");
    let names: BTreeSet<String> = sources
        .iter()
        .filter(|path| !is_test(path))
        .flat_map(|path| public_names(&code(&text(path))))
        .map(|(_, name)| name)
        .collect();
    let terms = terms(&text(&repository().join("crates/GLOSSARY.md")));
    assert!(!terms.is_empty());
    let missing = terms.iter().filter(|term| !names.contains(*term));
    let missing = missing.map(|term| format!("`{term}` of crates/GLOSSARY.md is no public item"));
    assert_none(&missing.collect::<Vec<_>>());
}

#[test]
fn the_vocabulary_can_fail() {
    let glossary = "\
| term | in the code | what |
|---|---|---|
| gap | `gap` | a \\| b |
| body | – | all |

| not | but |
|---|---|
| way, ways | path |
| share (a number) | ratio |
| made anew, anew | again |

After.
";
    let banned = banned(glossary);
    assert_eq!(banned, ["way", "ways", "share", "made anew", "anew"]);
    assert_eq!(terms(glossary), ["gap"]);
    assert_eq!(words("leastWay_of3D"), ["least", "way", "of3", "d"]);
    assert_eq!(words("HTTPShare"), ["http", "share"]);

    // Marked so that this file's own lines are no documentation.
    let source = "\
DOC The ways of a Share.
pub struct Path {
    DOC Always away: \"anew\".
    pub share_of_time: f64,
    way: String,
}
pub(crate) fn way() {}
pub enum Kind {
    #[serde(rename = \"a\")]
    ByWay,
    Other { share: f64, more: Vec<u8> },
    Way(u8),
    Last = 3,
}
pub trait Walk {
    const WAY: f64 = 1.0;
    DOC Goes.
    fn ways(&self) {
        let way = 3;
    }
}
pub use other::{A as Way, b};
pub const SHARE: &str = \"way\";
pub const fn share() {}
pub unsafe extern \"C\" fn anew() {} // way
#[cfg(test)]
mod tests {
    pub fn way() {}
}
";
    let source = source.replace("DOC", "///");
    let found: Vec<String> = complaints(&banned, &source)
        .into_iter()
        .map(|(line, complaint)| {
            format!(
                "{line} {}",
                complaint.split(" in: ").next().unwrap_or_default()
            )
        })
        .collect();
    assert_eq!(
        found,
        [
            "1 \"share\"",
            "1 \"ways\"",
            "3 \"anew\"",
            "4 `share_of_time`: \"share\"",
            "10 `ByWay`: \"way\"",
            "11 `share`: \"share\"",
            "12 `Way`: \"way\"",
            "16 `WAY`: \"way\"",
            "18 `ways`: \"ways\"",
            "22 `Way`: \"way\"",
            "23 `SHARE`: \"share\"",
            "24 `share`: \"share\"",
            "25 `anew`: \"anew\"",
        ]
    );
}
