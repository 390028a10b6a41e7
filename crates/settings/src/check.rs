//! Checks that several kinds of file have in common, on values that may be incomplete because something in them was wrong.

use crate::document::Reading;
use crate::error::KeyPath;
use serde_json::Value;

/// The elements of a list; none if it is not there.
pub(crate) fn items<'a>(table: &'a Value, key: &str) -> impl Iterator<Item = (usize, &'a Value)> {
    table[key].as_array().into_iter().flatten().enumerate()
}

/// The texts under `field` in the elements of the list `list`, each with its index.
pub(crate) fn texts(table: &Value, list: &str, field: &str) -> Vec<(usize, String)> {
    items(table, list)
        .filter_map(|(i, item)| Some((i, item[field].as_str()?.to_owned())))
        .collect()
}

/// Complains about each name of `list` (below `table`) that an earlier element has already.
pub(crate) fn unique(
    reading: &mut Reading,
    table: &KeyPath,
    names: &[(usize, String)],
    list: &str,
    field: &str,
) {
    for (at, (i, name)) in names.iter().enumerate() {
        if names[..at].iter().any(|(_, earlier)| earlier == name) {
            let key = table.key(list).at(*i).key(field);
            let expected = format!("a `{field}` that no other `{list}` has");
            reading.complain(&key, &format!("`{name}` a second time"), &expected);
        }
    }
}

/// Complains if the text at `key` is none of the `known` names of an item, given with its article.
pub(crate) fn refers(reading: &mut Reading, key: &KeyPath, name: &str, item: &str, known: &[&str]) {
    if known.contains(&name) {
        return;
    }
    let hint = crate::read::did_you_mean(name, known.iter().copied());
    let quoted: Vec<String> = known.iter().map(|name| format!("`{name}`")).collect();
    let quoted: Vec<&str> = quoted.iter().map(String::as_str).collect();
    let expected = match quoted.as_slice() {
        [] => format!("the name of {item}, but there is none"),
        quoted => format!(
            "the name of {item}: {}{hint}",
            crate::schema::enumerate(quoted, "or")
        ),
    };
    reading.complain(key, &format!("`{name}`"), &expected);
}
