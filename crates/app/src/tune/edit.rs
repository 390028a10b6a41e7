//! Writing a choice into its file: only what was chosen changes, comments stay.

use super::{Measured, Target};
use microsim_settings::{self as settings, Unit, in_words};
use microsim_study::{Trial, Tuning};
use toml_edit::{Array, DocumentMut, InlineTable, Item, Table, Value, value};

/// The text of the target's file with the choice in it.
pub fn write(
    target: &Target,
    scene: &settings::Scene,
    choice: &Trial,
    tuning: &Tuning,
) -> Result<String, String> {
    let text = std::fs::read_to_string(&target.path);
    let text = text.map_err(|e| format!("{}: {}", target.path.display(), in_words(e)))?;
    let mut document: DocumentMut = text
        .parse()
        .map_err(|e| format!("{}: {e}", target.path.display()))?;
    for set in &choice.overrides {
        let (path, value) = set.split_once('=').unwrap_or((set, ""));
        replace(document.as_item_mut(), path, parsed(value))
            .ok_or_else(|| format!("{}: no place for `{set}`", target.path.display()))?;
    }
    match &target.what {
        Measured::Level(level) => {
            let steps = (level.tick / choice.step * (1.0 - 1e-9)).ceil().max(1.0) as i64;
            set_value(&mut document["clock"], "steps", steps.into());
        }
        Measured::Scene(_) => {
            set_value(&mut document["run"], "step", time(choice.step).into());
            for (key, now) in [("sample", scene.run.sample), ("frame", scene.run.frame)] {
                if choice.step > now {
                    set_value(&mut document["run"], key, time(choice.step).into());
                }
            }
        }
    }
    document["tuned"] = Item::Table(tuned(target, choice, tuning));
    Ok(document.to_string())
}

/// The table with the measured figures.
fn tuned(target: &Target, choice: &Trial, tuning: &Tuning) -> Table {
    let mut table = Table::new();
    table.insert("command", value(format!("microsim tune {}", target.name)));
    table.insert("method", value(choice.method.as_str()));
    table.insert("step", value(time(choice.step)));
    table.insert("elements", value(choice.elements as i64));
    for (key, number) in [
        ("error", choice.error),
        ("margin", choice.margin),
        ("cost", choice.cost),
        ("doubt", tuning.doubt),
        ("locking", tuning.locking),
    ] {
        if let Some(number) = number {
            table.insert(key, value(rounded(number)));
        }
    }
    if !tuning.measure.is_empty() {
        table.insert(
            "measure",
            value(tuning.measure.iter().copied().collect::<Array>()),
        );
    }
    let mut list = Array::new();
    for sentence in tuning.sentences() {
        let mut sentence = Value::from(sentence.as_str());
        sentence.decor_mut().set_prefix("\n  ");
        list.push_formatted(sentence);
    }
    list.set_trailing("\n");
    list.set_trailing_comma(true);
    table.insert("rejected", value(list));
    table
}

/// Four digits: more would not be the same tomorrow.
fn rounded(number: f64) -> f64 {
    format!("{number:.3e}").parse().unwrap_or(number)
}

/// A time as files write it; rounded down, so that a step stays stable.
fn time(seconds: f64) -> String {
    let digits = 1e4 / 10f64.powi(seconds.log10().floor() as i32 + 1);
    let down = (seconds * digits * (1.0 + 1e-12)).floor() / digits;
    Unit::Time.describe(rounded(down))
}

/// A value as TOML, or a text.
fn parsed(text: &str) -> Value {
    text.parse().unwrap_or_else(|_| Value::from(text))
}

/// Puts a value where a path of keys and indices leads; tables and lists along it must be there, keys need not.
fn replace(item: &mut Item, path: &str, new: Value) -> Option<()> {
    let (step, rest) = path
        .split_once('.')
        .map_or((path, None), |(s, r)| (s, Some(r)));
    let Some(rest) = rest else {
        // A table stays a table with its comments; only its values change.
        if let (Value::InlineTable(new), Some(table)) =
            (&new, item.get_mut(step).and_then(Item::as_table_mut))
        {
            change_table(table, new);
        } else {
            set_value(item, step, new);
        }
        return Some(());
    };
    let next = match step.parse::<usize>() {
        Ok(index) => match item {
            Item::ArrayOfTables(list) => {
                // A table of a list is no item of its own.
                let table = list.get_mut(index)?;
                return replace_in_table(table, rest, new);
            }
            other => return replace_in_value(other.as_array_mut()?.get_mut(index)?, rest, new),
        },
        Err(_) => {
            // Asking for a key to change it would make it.
            item.get(step).filter(|next| !next.is_none())?;
            item.get_mut(step)?
        }
    };
    replace(next, rest, new)
}

fn replace_in_table(table: &mut Table, path: &str, new: Value) -> Option<()> {
    let mut item = Item::Table(std::mem::take(table));
    let done = replace(&mut item, path, new);
    if let Item::Table(changed) = item {
        *table = changed;
    }
    done
}

/// In an inline table of a list on one line.
fn replace_in_value(at: &mut Value, path: &str, new: Value) -> Option<()> {
    let table: &mut InlineTable = at.as_inline_table_mut()?;
    if path.contains('.') {
        return None;
    }
    table.insert(path, new);
    Some(())
}

/// Gives a key a value and keeps the comment behind it; one that is the same stays as it is written.
fn set_value(table: &mut Item, key: &str, mut new: Value) {
    let bare = |value: &Value| {
        let value = value.clone().decorated("", "");
        value.to_string().replace(char::is_whitespace, "")
    };
    if let Some(old) = table.get(key).and_then(Item::as_value) {
        if bare(old) == bare(&new) {
            return;
        }
        *new.decor_mut() = old.decor().clone();
    }
    table[key] = Item::Value(new);
}

/// Gives a table the values of another one: what the new one does not have goes.
fn change_table(table: &mut Table, new: &InlineTable) {
    let gone: Vec<String> = table
        .iter()
        .map(|(key, _)| key.to_owned())
        .filter(|key| !new.contains_key(key))
        .collect();
    for key in gone {
        table.remove(&key);
    }
    for (key, value) in new {
        let mut value = value.clone();
        match table.get(key).and_then(Item::as_value) {
            Some(old) => *value.decor_mut() = old.decor().clone(),
            None => value.decor_mut().clear(),
        }
        table.insert(key, Item::Value(value));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_was_chosen_changes() {
        let text = "# What it is.\n[run]\nstep = \"1 ms\" # short\n[method] # the best\nname = \"verlet\" # so far\n\
            iterations = 3\n[[body]]\ncells = [1, 2, 3] # few\nsize = [1, 2] # so far\nlayer = [{ cells = 1, region = 2 }]\n[[body.material]]\nlaw = \"springs\"\n";
        let mut document: DocumentMut = text.parse().expect("TOML");
        for (path, new) in [
            ("method", "{name=\"implicit-euler\",must_converge=false}"),
            ("method.iterations", "2"),
            ("body.0.cells", "[4,5,6]"),
            ("body.0.layer.0.cells", "7"),
            ("body.0.size", "[1,2]"),
            ("body.0.material.0.discretisation", "selective"),
        ] {
            assert_eq!(
                replace(document.as_item_mut(), path, parsed(new)),
                Some(()),
                "{path}"
            );
        }
        set_value(&mut document["run"], "step", "5 ms".into());
        let expected = "# What it is.\n[run]\nstep = \"5 ms\" # short\n[method] # the best\nname = \"implicit-euler\" # so far\n\
            must_converge = false\niterations = 2\n[[body]]\ncells = [4,5,6] # few\nsize = [1, 2] # so far\nlayer = [{ cells = 7, region = 2 }]\n[[body.material]]\nlaw = \"springs\"\ndiscretisation = \"selective\"\n";
        assert_eq!(document.to_string(), expected);
        for nowhere in ["body.1.cells", "nothing.at.all", "body.x.cells"] {
            assert_eq!(
                replace(document.as_item_mut(), nowhere, parsed("1")),
                None,
                "{nowhere}"
            );
        }
    }

    #[test]
    fn times_are_rounded_down_to_four_digits() {
        for (seconds, text) in [
            (0.005, "5 ms"),
            (7.41599e-5, "74.15 us"),
            (0.000249996, "249.9 us"),
        ] {
            assert_eq!(time(seconds), text);
        }
    }
}
