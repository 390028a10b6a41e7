//! As much of Rust's grammar as the checks need: code without comments and strings, paths, public names.

use std::collections::{BTreeMap, BTreeSet};

/// A source without its comments, strings, characters and tests; line breaks stay.
pub fn code(source: &str) -> String {
    without_tests(&without_comments(source))
}

/// A source whose comments, strings and characters are blank; line breaks stay.
pub fn without_comments(source: &str) -> String {
    let chars: Vec<char> = source.chars().collect();
    let mut out = String::with_capacity(source.len());
    let mut at = 0;
    while at < chars.len() {
        let end = match (chars[at], chars.get(at + 1)) {
            ('/', Some('/')) => find(&chars, at, "\n"),
            ('/', Some('*')) => find(&chars, at, "*/") + 2,
            ('"', _) => string_end(&chars, at + 1),
            ('r', Some('"' | '#')) if !ends_in_word(&out) => raw_end(&chars, at + 1),
            ('\'', _) => character_end(&chars, at),
            _ => at,
        };
        if end == at {
            out.push(chars[at]);
            at += 1;
            continue;
        }
        let end = end.min(chars.len());
        out.extend(
            chars[at..end]
                .iter()
                .map(|&c| if c == '\n' { c } else { ' ' }),
        );
        at = end;
    }
    out
}

fn ends_in_word(text: &str) -> bool {
    text.ends_with(|c: char| c.is_alphanumeric() || c == '_')
}

/// Where a text begins, from a place on; the end of the source if nowhere.
fn find(chars: &[char], from: usize, wanted: &str) -> usize {
    let wanted: Vec<char> = wanted.chars().collect();
    let mut places = from..chars.len();
    places
        .find(|&at| chars[at..].starts_with(&wanted))
        .unwrap_or(chars.len())
}

/// Behind the string that begins before `at`.
fn string_end(chars: &[char], mut at: usize) -> usize {
    while at < chars.len() && chars[at] != '"' {
        at += if chars[at] == '\\' { 2 } else { 1 };
    }
    at + 1
}

/// Behind the raw string whose `r` stands before `at`; that `r` if it is none.
fn raw_end(chars: &[char], at: usize) -> usize {
    let hashes = chars[at..].iter().take_while(|&&c| c == '#').count();
    if chars.get(at + hashes) != Some(&'"') {
        return at - 1;
    }
    let close = format!("\"{}", "#".repeat(hashes));
    find(chars, at + hashes + 1, &close) + close.len()
}

/// Behind a character; its own place if the apostrophe begins a lifetime.
fn character_end(chars: &[char], at: usize) -> usize {
    match (chars.get(at + 1), chars.get(at + 2)) {
        (Some('\\'), _) => find(chars, at + 3, "'") + 1,
        (Some(_), Some('\'')) => at + 3,
        _ => at,
    }
}

/// Code without the items behind `#[cfg(test)]`; their lines are blank.
fn without_tests(code: &str) -> String {
    let mut out = String::new();
    let mut lines = code.lines();
    while let Some(line) = lines.next() {
        if line.trim() != "#[cfg(test)]" {
            out += line;
            out.push('\n');
            continue;
        }
        out.push('\n');
        let mut end = None;
        // The item's last line is as far to the left as its first.
        for line in lines.by_ref() {
            out.push('\n');
            let indent = line.len() - line.trim_start().len();
            match end {
                None if line.trim_start().starts_with("#[") => {}
                None if line.trim_end().ends_with([';', '}']) => break,
                None => end = Some(indent),
                Some(first) if indent == first && line.trim_start().starts_with('}') => break,
                Some(_) => {}
            }
        }
    }
    out
}

/// What a source declares and uses.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct Declarations {
    /// Modules in files of their own.
    pub modules: Vec<String>,
    /// What `use` declarations bring in: name and path.
    pub imports: BTreeMap<String, Vec<String>>,
    /// Exported macros, which have the crate's root as their path wherever they are defined.
    pub macros: Vec<String>,
    /// All paths of two names and more, those of `use` declarations among them.
    pub paths: BTreeSet<Vec<String>>,
}

/// Words and punctuation of code, `::` as one, with the numbers of their lines.
pub fn tokens(code: &str) -> Vec<(usize, &str)> {
    let lines = code.lines().zip(1..);
    lines
        .flat_map(|(line, number)| line_tokens(line).into_iter().map(move |t| (number, t)))
        .collect()
}

fn line_tokens(line: &str) -> Vec<&str> {
    let mut tokens = Vec::new();
    let mut rest = line.trim_start();
    while let Some(first) = rest.chars().next() {
        let is_word = |c: char| c.is_alphanumeric() || c == '_';
        let length = match first {
            _ if is_word(first) => rest.find(|c| !is_word(c)).unwrap_or(rest.len()),
            _ if rest.starts_with("::") => 2,
            _ => first.len_utf8(),
        };
        let (token, after) = rest.split_at(length);
        tokens.push(token);
        rest = after.trim_start();
    }
    tokens
}

/// Whether a token is a name.
pub fn is_name(token: &str) -> bool {
    token.starts_with(|c: char| c.is_alphabetic() || c == '_')
}

/// Reads code without comments.
pub fn declarations(code: &str) -> Declarations {
    let tokens: Vec<&str> = tokens(code).into_iter().map(|(_, token)| token).collect();
    let mut found = Declarations::default();
    // Braces that are open, and at which depths modules within the file began.
    let (mut depth, mut inline) = (0_usize, Vec::new());
    let mut at = 0;
    while at < tokens.len() {
        match tokens[at] {
            "mod" if tokens.get(at + 2) == Some(&"{") => {
                inline.push(depth);
                depth += 1;
                at += 3;
            }
            "macro_rules" => {
                found
                    .macros
                    .extend(tokens.get(at + 2).map(|&name| name.to_owned()));
                at += 3;
            }
            "{" => {
                depth += 1;
                at += 1;
            }
            "}" => {
                depth = depth.saturating_sub(1);
                if inline.last() == Some(&depth) {
                    inline.pop();
                }
                at += 1;
            }
            "mod" if tokens.get(at + 2) == Some(&";") => {
                found.modules.push(tokens[at + 1].to_owned());
                at += 3;
            }
            "use" if tokens.get(at + 1).is_some_and(|next| is_name(next)) => {
                let mut brought = Declarations::default();
                at = use_tree(&tokens, at + 1, &[], &mut brought);
                let paths = brought.paths.into_iter();
                found
                    .paths
                    .extend(paths.map(|path| outside(path, inline.len())));
                if inline.is_empty() {
                    found.imports.extend(brought.imports);
                }
            }
            // `a.b::<C>()` is no path, nor is what a macro finds in its own crate.
            name if is_name(name) && (at == 0 || !["::", ".", "$"].contains(&tokens[at - 1])) => {
                let mut path = vec![name.to_owned()];
                at += 1;
                while tokens.get(at) == Some(&"::")
                    && tokens.get(at + 1).is_some_and(|t| is_name(t))
                {
                    path.push(tokens[at + 1].to_owned());
                    at += 2;
                }
                if path.len() > 1 {
                    found.paths.insert(outside(path, inline.len()));
                }
            }
            _ => at += 1,
        }
    }
    found
}

/// A path inside as many modules of one file, as it is outside of them.
fn outside(mut path: Vec<String>, inline: usize) -> Vec<String> {
    let up = path.iter().take(inline).take_while(|name| *name == "super");
    let up = up.count();
    if up > 0 {
        path.splice(..up, ["self".to_owned()]);
    }
    path
}

/// Reads one tree of a `use` declaration behind a prefix; returns the place behind it.
fn use_tree(tokens: &[&str], mut at: usize, prefix: &[String], found: &mut Declarations) -> usize {
    let mut path = prefix.to_vec();
    loop {
        match tokens.get(at) {
            Some(&"{") => {
                at += 1;
                while tokens.get(at).is_some_and(|&token| token != "}") {
                    at = use_tree(tokens, at, &path, found);
                    if tokens.get(at) == Some(&",") {
                        at += 1;
                    }
                }
                return at + 1;
            }
            // What it brings in is not known here: the module is used.
            Some(&"*") => {
                found.paths.insert(path);
                return at + 1;
            }
            Some(name) if is_name(name) => {
                path.push((*name).to_owned());
                at += 1;
            }
            _ => return at + 1,
        }
        if tokens.get(at) == Some(&"::") {
            at += 1;
            continue;
        }
        if path.last().is_some_and(|last| last == "self") && path.len() > 1 {
            path.pop();
        }
        let mut name = path.last().cloned().unwrap_or_default();
        if tokens.get(at) == Some(&"as") {
            name = tokens[at + 1].to_owned();
            at += 2;
        }
        found.paths.insert(path.clone());
        found.imports.insert(name, path);
        return at;
    }
}

/// Public names of a source without comments and tests, with their lines: items, fields, variants, methods of traits, new names
/// of re-exports.
pub fn public_names(code: &str) -> Vec<(usize, String)> {
    let tokens = tokens(code);
    let word = |at: usize| tokens.get(at).map_or("", |&(_, token)| token);
    let mut found = Vec::new();
    let mut add = |at: usize| found.push((tokens[at].0, tokens[at].1.to_owned()));
    for at in 0..tokens.len() {
        if word(at) == "macro_rules" {
            add(at + 2);
        }
        if word(at) != "pub" || word(at + 1) == "(" {
            continue;
        }
        let mut item = at + 1;
        while ["async", "unsafe", "extern"].contains(&word(item))
            || (word(item) == "const" && !is_name_of_item(word(item + 1), word(item + 2)))
        {
            item += 1;
        }
        match word(item) {
            "fn" | "struct" | "union" | "type" | "const" | "static" | "mod" => add(item + 1),
            "enum" => {
                add(item + 1);
                let body = body(&tokens, item);
                for place in body.clone() {
                    let begins = ["{", ",", "]"].contains(&word(place - 1));
                    let depth = depth(&tokens, body.start, place);
                    let variant =
                        depth == 1 && ["{", "(", ",", "}", "="].contains(&word(place + 1));
                    let field = depth == 2 && word(place + 1) == ":";
                    if begins && is_name(word(place)) && (variant || field) {
                        add(place);
                    }
                }
            }
            "trait" => {
                add(item + 1);
                let body = body(&tokens, item);
                for place in body.clone() {
                    let begins = ["fn", "type", "const"].contains(&word(place - 1));
                    if begins && depth(&tokens, body.start, place) == 1 && is_name(word(place)) {
                        add(place);
                    }
                }
            }
            "use" => {
                let end = (item..tokens.len()).find(|&place| word(place) == ";");
                for place in item..end.unwrap_or(item) {
                    if word(place) == "as" && word(place + 1) != "_" {
                        add(place + 1);
                    }
                }
            }
            name if is_name(name) && word(item + 1) == ":" => add(item),
            _ => {}
        }
    }
    found
}

/// `const NAME:` is an item, `const fn` is not.
fn is_name_of_item(name: &str, next: &str) -> bool {
    is_name(name) && next == ":"
}

/// The places between the braces of the item that begins at `item`, the opening one first.
fn body(tokens: &[(usize, &str)], item: usize) -> std::ops::Range<usize> {
    let open = (item..tokens.len()).find(|&at| ["{", ";"].contains(&tokens[at].1));
    let Some(open) = open.filter(|&at| tokens[at].1 == "{") else {
        return item..item;
    };
    let end = (open + 1..tokens.len()).find(|&at| depth(tokens, open, at + 1) == 0);
    open + 1..end.unwrap_or(open + 1)
}

/// Braces that are open before a place, from the item's first one on (which stands before or at `from`).
fn depth(tokens: &[(usize, &str)], from: usize, place: usize) -> usize {
    let first = from - usize::from(tokens[from].1 != "{");
    let mut depth = 0;
    for (_, token) in &tokens[first..place] {
        match *token {
            "{" => depth += 1,
            "}" => depth -= 1,
            _ => {}
        }
    }
    depth
}
