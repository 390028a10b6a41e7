//! Values from the command line that take the place of those of a file: `run.step=5ms`, `body.0.cells=[35,7,7]`; nothing
//! behind the sign takes a key out: `run.rest_speed=`.
//!
//! They are put into the tree before it is read by its schema, so they are held to the same rules; a complaint about one
//! names the override instead of a line of the file.

use crate::error::{ConfigError, KeyPath, Position};
use crate::tree::{Entry, Item, Node};

/// A value that takes the place of one in a file, or the absence of one.
#[derive(Clone, Debug)]
pub struct Override {
    text: String,
    steps: Vec<String>,
    /// `None` takes the key out.
    item: Option<Item>,
}

/// The place of what an override brings: no line of a file is the 0th; the column counts the overrides.
pub(crate) fn place(index: usize) -> Position {
    Position {
        line: 0,
        column: index,
    }
}

impl Override {
    /// Reads `KEY=VALUE`: a path of keys and indices (from 0) joined by dots, and a value in TOML; what is no TOML is a text.
    /// Without a value the key is taken out.
    pub fn parse(text: &str) -> Result<Self, String> {
        let wrong = || {
            format!(
                "`{text}`: expected KEY=VALUE with a path of keys and indices, such as run.step=5ms or body.0.cells=[35,7,7], or KEY= to take a key out"
            )
        };
        let (path, value) = text.split_once('=').ok_or_else(wrong)?;
        let steps: Vec<String> = path.trim().split('.').map(str::to_owned).collect();
        if steps.iter().any(String::is_empty) {
            return Err(wrong());
        }
        let value = value.trim();
        // Braces and brackets decide nothing here: a value that ends early is no TOML, and so a text.
        let item = match Node::parse(&format!("v = {value}"), "") {
            Ok(Node {
                item: Item::Table(mut entries),
                ..
            }) if entries.len() == 1 && entries[0].key == "v" => Some(entries.remove(0).node.item),
            _ if value.is_empty() => None,
            _ => Some(Item::Text(value.to_owned())),
        };
        Ok(Self {
            text: text.to_owned(),
            steps,
            item,
        })
    }

    /// As it was written.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Whether its path ends with this key.
    pub(crate) fn is_of_key(&self, key: &str) -> bool {
        self.steps.last().is_some_and(|last| last == key)
    }

    /// Puts the value into a tree, as the `index`-th override.
    pub(crate) fn apply(&self, root: &mut Node, index: usize) -> Result<(), ConfigError> {
        let at = place(index);
        let (last, path_to_last) = self
            .steps
            .split_last()
            .unwrap_or_else(|| unreachable!("`parse` finds at least one step"));
        let mut node = root;
        let mut path = KeyPath::root();
        for step in path_to_last.iter().chain([last]) {
            let parent = path.clone();
            let wrong = |found: String, expected: String| ConfigError {
                file: format!("--set {}", self.text),
                position: None,
                key: parent.clone(),
                found,
                expected,
            };
            let described = node.describe();
            node = match &mut node.item {
                Item::List(nodes) => {
                    let count = nodes.len();
                    let index = step.parse::<usize>().ok().filter(|index| *index < count);
                    let Some(index) = index else {
                        let expected = match count {
                            0 => "a list with elements".to_owned(),
                            _ => format!("an index from 0 to {}", count - 1),
                        };
                        return Err(wrong(format!("`{step}`"), expected));
                    };
                    path = path.at(index);
                    if self.item.is_none() && path.steps().len() == self.steps.len() {
                        nodes.remove(index);
                        return Ok(());
                    }
                    &mut nodes[index]
                }
                Item::Table(entries) => {
                    path = path.key(step);
                    let found = entries.iter().position(|entry| entry.key == *step);
                    if self.item.is_none() {
                        let Some(found) = found else {
                            let expected = "a key that is there, to take it out".to_owned();
                            return Err(wrong(format!("no key `{step}`"), expected));
                        };
                        if path.steps().len() == self.steps.len() {
                            entries.remove(found);
                            return Ok(());
                        }
                    }
                    let found = found.unwrap_or_else(|| {
                        entries.push(Entry {
                            key: step.clone(),
                            at,
                            node: Node {
                                at,
                                item: Item::Table(Vec::new()),
                            },
                        });
                        entries.len() - 1
                    });
                    &mut entries[found].node
                }
                _ => {
                    return Err(wrong(
                        described,
                        format!("a table or a list, to hold `{step}`"),
                    ));
                }
            };
        }
        if let Some(mut item) = self.item.clone() {
            move_to(&mut item, at);
            *node = Node { at, item };
        }
        Ok(())
    }
}

/// Gives everything inside a value one place.
fn move_to(item: &mut Item, at: Position) {
    match item {
        Item::List(nodes) => {
            for node in nodes {
                node.at = at;
                move_to(&mut node.item, at);
            }
        }
        Item::Table(entries) => {
            for entry in entries {
                (entry.at, entry.node.at) = (at, at);
                move_to(&mut entry.node.item, at);
            }
        }
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn item(text: &str) -> Item {
        Override::parse(text).expect(text).item.expect(text)
    }

    #[test]
    fn a_value_is_toml_or_else_a_text() {
        assert!(matches!(item("a=1"), Item::Integer(1)));
        assert!(matches!(item("a.b = 0.5"), Item::Float(x) if x == 0.5));
        assert!(matches!(item("a=true"), Item::Bool(true)));
        for (text, expected) in [
            ("a=5ms", "5ms"),
            ("a=\"5 ms\"", "5 ms"),
            ("a=implicit-euler", "implicit-euler"),
            ("a=[1,", "[1,"),
            ("a=1\nb=2", "1\nb=2"),
            ("a=b=c", "b=c"),
        ] {
            assert!(
                matches!(item(text), Item::Text(t) if t == expected),
                "{text}"
            );
        }
        assert!(matches!(item("a=[1,2]"), Item::List(nodes) if nodes.len() == 2));
        for wrong in ["", "a", "=1", "a..b=1", ".a=1"] {
            assert!(Override::parse(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn values_are_replaced_or_added_where_the_path_leads() {
        let mut root = Node::parse("a = 1\n[[b]]\nc = [1, 2]\n", "f").expect("TOML");
        for (index, text) in ["a=x", "b.0.c.1=7", "b.0.d.e=3"].into_iter().enumerate() {
            let done = Override::parse(text).expect(text).apply(&mut root, index);
            assert_eq!(done, Ok(()), "{text}");
        }
        let path = |keys: &[&str]| keys.iter().fold(KeyPath::root(), |p, k| p.key(k));
        let b = path(&["b"]).at(0);
        fn get<'a>(root: &'a Node, path: &KeyPath) -> &'a Node {
            root.get(path).expect("there")
        }
        assert!(matches!(&get(&root, &path(&["a"])).item, Item::Text(t) if t == "x"));
        assert!(matches!(
            get(&root, &b.key("c").at(0)).item,
            Item::Integer(1)
        ));
        let set = get(&root, &b.key("c").at(1));
        assert!(matches!(set.item, Item::Integer(7)) && set.at == place(1));
        assert!(matches!(
            get(&root, &b.key("d").key("e")).item,
            Item::Integer(3)
        ));

        for (index, text) in ["b.0.c.0=", "b.0.d="].into_iter().enumerate() {
            let done = Override::parse(text).expect(text).apply(&mut root, index);
            assert_eq!(done, Ok(()), "{text}");
        }
        assert!(matches!(
            get(&root, &b.key("c").at(0)).item,
            Item::Integer(7)
        ));
        assert!(root.get(&b.key("c").at(1)).is_none() && root.get(&b.key("d")).is_none());

        for (text, expected) in [
            (
                "b.0.d=",
                "--set b.0.d=: key `b[0]`: found no key `d`, expected a key that is there, to take it out",
            ),
            (
                "b.1.c=1",
                "--set b.1.c=1: key `b`: found `1`, expected an index from 0 to 0",
            ),
            (
                "a.z=1",
                "--set a.z=1: key `a`: found the text `x`, expected a table or a list, to hold `z`",
            ),
        ] {
            let done = Override::parse(text).expect(text).apply(&mut root, 0);
            assert_eq!(done.expect_err(text).to_string(), expected);
        }
    }
}
