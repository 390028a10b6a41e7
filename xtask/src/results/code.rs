//! What of a file is code: two versions that differ in comments, white space or tests alone compute and cost the same.

/// Whether a changed file can change a figure: documentation, and what only a crate's own tests and examples read, cannot.
pub fn counts(path: &str, named: bool) -> bool {
    let aside = ["tests/", "/examples/", "/benches/", "tests.rs"];
    !path.ends_with(".md") && (named || !aside.iter().any(|part| path.contains(part)))
}

/// What is left of a file for the comparison, by the ending of its name.
pub fn code(path: &str, text: &str) -> String {
    if path.ends_with(".rs") {
        rust(text)
    } else if path.ends_with(".toml") || path.ends_with(".py") {
        let lines = text
            .lines()
            .map(str::trim)
            .filter(|line| !line.starts_with('#'));
        lines.collect()
    } else {
        text.to_owned()
    }
}

/// Without comments, white space outside strings, and the tests at the end of the file.
fn rust(text: &str) -> String {
    let text = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or("");
    let mut code = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let taken = if rest.starts_with("//") {
            rest = &rest[rest.find('\n').unwrap_or(rest.len())..];
            continue;
        } else if rest.starts_with("/*") {
            rest = &rest[block_comment(rest)..];
            continue;
        } else if first.is_whitespace() {
            rest = &rest[first.len_utf8()..];
            continue;
        } else if let Some(length) = raw_string(rest, code.chars().last()) {
            length
        } else if first == '"' {
            quoted(rest)
        } else if rest.starts_with("'\"'") {
            3
        } else if rest.starts_with("'\\") {
            // The escaped character may be a quotation mark.
            3 + rest[3..].find('\'').map_or(0, |end| end + 1)
        } else {
            first.len_utf8()
        };
        code.push_str(&rest[..taken]);
        rest = &rest[taken..];
    }
    code
}

fn block_comment(text: &str) -> usize {
    let (mut depth, mut at) = (0, 0);
    while at < text.len() {
        if text[at..].starts_with("/*") {
            (depth, at) = (depth + 1, at + 2);
        } else if text[at..].starts_with("*/") {
            (depth, at) = (depth - 1, at + 2);
            if depth == 0 {
                break;
            }
        } else {
            at += text[at..].chars().next().map_or(1, char::len_utf8);
        }
    }
    at
}

/// Length of a raw string that begins here; after a letter (`before`) an r belongs to a name.
fn raw_string(text: &str, before: Option<char>) -> Option<usize> {
    if before.is_some_and(|c| c.is_alphanumeric() && c != 'b' || c == '_') {
        return None;
    }
    let hashes = text.strip_prefix('r')?;
    let count = hashes.bytes().take_while(|byte| *byte == b'#').count();
    let inner = hashes[count..].strip_prefix('"')?;
    let end = format!("\"{}", "#".repeat(count));
    Some(
        inner
            .find(&end)
            .map_or(text.len(), |at| text.len() - inner.len() + at + end.len()),
    )
}

fn quoted(text: &str) -> usize {
    let mut escaped = false;
    for (at, c) in text.char_indices().skip(1) {
        if !escaped && c == '"' {
            return at + 1;
        }
        escaped = !escaped && c == '\\';
    }
    text.len()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_space_and_tests_are_no_code_but_strings_are() {
        let one = "/// Doc.\nfn f() -> &str { /* a /* b */ c */ \"// a  b\" } // end\n";
        let other = "fn f()->&str{\n    \"// a  b\"\n}\n#[cfg(test)]\nmod tests { fn t() {} }";
        assert_eq!(code("a.rs", one), code("a.rs", other));
        for (a, b) in [
            ("let x = 1;", "let x = 2;"),
            ("\"a b\"", "\"ab\""),
            ("r#\"a \" // b\"#", "r#\"a \" // c\"#"),
            ("'\"'; // a\n1", "'\"'; // a\n2"),
            ("'\\''; 1", "'\\''; 2"),
            ("'\\\\'; 1", "'\\\\'; 2"),
            ("\"\\\"// a\"; 1", "\"\\\"// b\"; 1"),
            ("fn a<'a>(x: &'a str) {}", "fn a<'a>(y: &'a str) {}"),
        ] {
            assert_ne!(code("a.rs", a), code("a.rs", b), "{a}");
        }
        assert_eq!(code("a.toml", "# c\na = 1\n"), code("a.toml", "a = 1\n"));
        assert_ne!(code("a.toml", "a = 1\n"), code("a.toml", "a = 2\n"));
    }

    #[test]
    fn documentation_and_tests_change_no_figure() {
        for (path, named, expected) in [
            ("crates/tissue/src/law.rs", false, true),
            ("crates/tissue/README.md", true, false),
            ("crates/tissue/tests/beam.rs", false, false),
            ("crates/tissue/src/law/tests.rs", false, false),
            ("crates/tissue/src/contact_tests/implicit.rs", false, false),
            ("tests/examples/bench_host.rs", true, true),
        ] {
            assert_eq!(counts(path, named), expected, "{path}");
        }
    }
}
