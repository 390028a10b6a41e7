//! Which kind a file is, by what stands in it, where neither its name nor its folder decides.

use crate::tree::{Item, Node};

/// The kind of a TOML text, by a name of [`KINDS`](crate::KINDS): a scene or the plan of a chart by its tables at the top;
/// `None` for all that could be anything, or is no TOML.
pub fn guess_kind(text: &str) -> Option<&'static str> {
    let Ok(Node {
        item: Item::Table(entries),
        ..
    }) = Node::parse(text, "")
    else {
        return None;
    };
    let has = |name: &str| entries.iter().any(|entry| entry.key == name);
    match () {
        () if has("run") && has("body") => Some("scene"),
        () if has("budget") && has("scene") => Some("chart"),
        () => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scenes_and_charts_are_known_by_their_tables() {
        for (text, kind) in [
            ("[run]\n[[body]]\n", Some("scene")),
            ("body = 1\nrun = 2", Some("scene")),
            ("[[scene]]\n[budget]\n", Some("chart")),
            ("[[body]]\n[clock]\n", None),
            ("", None),
            ("[run", None),
        ] {
            assert_eq!(guess_kind(text), kind, "{text}");
        }
    }
}
