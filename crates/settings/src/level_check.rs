//! What a level must fulfil beyond its single values: names, references, the module's reasons, consistent limits.

use crate::body_check::{check_bodies, check_held};
use crate::check::{items, refers, texts, unique};
use crate::contact_check::{check_broad_phase, check_contacts, check_cuts, check_rigid};
use crate::document::Reading;
use crate::document::{Loaded, load_text};
use crate::error::ConfigErrors;
use crate::error::KeyPath;
use crate::files::schema_of;
use crate::level::Level;
use crate::level::{KnownMetric, expanded_names};
use crate::manifest::Manifest;
use crate::method::check_method;
use crate::schema::Kind;
use crate::schema::Schema;
use crate::vessel_body::read_bodies;
use microsim_vocabulary::{Direction, Unit};
use serde_json::Value;
use std::path::{Path, PathBuf};

/// The schema of a level; of the module whose manifest is given, or of any.
pub fn level_schema(manifest: Option<&Manifest>) -> Schema {
    let mut schema = schema_of::<Level>("level");
    if let (Some(manifest), Some(key)) = (manifest, schema.keys.last_mut()) {
        key.kind = Kind::Table(manifest.module_keys());
    }
    schema
}

/// Reads a level from a text, by the manifest of its module; `file` is the name that complaints use. Vessels that bodies name are
/// those of the tree that has the file as `modules/NAME/levels/level<N>.toml`.
pub fn read_level(
    text: &str,
    file: &str,
    manifest: &Manifest,
    known_metrics: &[KnownMetric<'_>],
) -> Result<Loaded<Level>, ConfigErrors> {
    let folder = vessels_of_tree(Path::new(file));
    read_level_with(text, file, manifest, known_metrics, &folder)
}

/// config/vessels of the tree that has a level.
fn vessels_of_tree(level: &Path) -> PathBuf {
    let folder = level.parent().unwrap_or(Path::new(""));
    folder.join("../../../config/vessels")
}

/// Reads a level from a text as [`read_level`] does, with the vessels in a folder.
pub fn read_level_with(
    text: &str,
    file: &str,
    manifest: &Manifest,
    known_metrics: &[KnownMetric<'_>],
    vessels: &Path,
) -> Result<Loaded<Level>, ConfigErrors> {
    let schema = level_schema(Some(manifest));
    let mut reading = read_bodies(text, file, &schema, &[], vessels)?;
    check(&mut reading, manifest, known_metrics);
    reading.finish()
}

/// Reads the level at `path`, with vessels as [`read_level`] has them.
pub fn load_level(
    path: &Path,
    manifest: &Manifest,
    known_metrics: &[KnownMetric<'_>],
) -> Result<Loaded<Level>, ConfigErrors> {
    load_level_with(path, manifest, known_metrics, &vessels_of_tree(path))
}

/// Reads the level at `path`, with the vessels in a folder.
pub fn load_level_with(
    path: &Path,
    manifest: &Manifest,
    known_metrics: &[KnownMetric<'_>],
    vessels: &Path,
) -> Result<Loaded<Level>, ConfigErrors> {
    let expected = format!("a level of the module `{}` (level<N>.toml)", manifest.name);
    let text = load_text(path, &expected)?;
    let file = path.display().to_string();
    read_level_with(&text, &file, manifest, known_metrics, vessels)
}

/// Complains about all that is wrong in a level that was read by its schema.
fn check(reading: &mut Reading, manifest: &Manifest, known_metrics: &[KnownMetric<'_>]) {
    check_tick(reading);
    check_names(reading);
    check_shapes(reading);
    check_parents(reading);
    check_bodies(reading);
    check_method(reading, &KeyPath::root().key("method"));
    check_held(reading);
    check_rigid(reading);
    check_contacts(reading);
    check_cuts(reading);
    check_physics(reading);
    check_limits(reading, manifest, known_metrics);
}

fn check_tick(reading: &mut Reading) {
    let Some(tick) = reading.value()["clock"]["tick"].as_f64() else {
        return;
    };
    // A decimal with at most six places is the f64 nearest to a whole number divided by 10⁶: no tolerance is needed.
    if (tick * 1e6).round() / 1e6 != tick {
        let found = Unit::Time.describe(tick);
        reading.complain(
            &KeyPath::root().key("clock").key("tick"),
            &found,
            "a whole number of microseconds",
        );
    }
}

/// Tools, objects, bodies and obstacles stand in one scene graph: no two have the same name.
fn check_names(reading: &mut Reading) {
    let mut taken: Vec<String> = Vec::new();
    for list in ["tool", "object", "body", "rigid"] {
        for (i, names) in scene_names(reading.value(), list) {
            if let Some(twice) = names.iter().find(|name| taken.contains(name)) {
                let found = format!("`{twice}` a second time");
                let key = KeyPath::root().key(list).at(i).key("name");
                reading.complain(
                    &key,
                    &found,
                    "a name that no other tool, object, body or obstacle has",
                );
            }
            taken.extend(names);
        }
    }
}

/// The names that each element of a list brings into the scene.
fn scene_names(level: &Value, list: &str) -> Vec<(usize, Vec<String>)> {
    items(level, list)
        .filter_map(|(i, item)| {
            Some((
                i,
                expanded_names(item["name"].as_str()?, item["count"].as_u64()),
            ))
        })
        .collect()
}

fn check_shapes(reading: &mut Reading) {
    for (i, shape) in texts(reading.value(), "object", "shape") {
        let object = KeyPath::root().key("object").at(i);
        let needed: &[&str] = match shape.as_str() {
            "sphere" => &["radius"],
            "capsule" => &["radius", "length"],
            "ring" => &["radius", "tube"],
            "model" => &["model"],
            _ => &["half_size"],
        };
        let may: &[&str] = match shape.as_str() {
            "model" => &["scale", "texture"],
            _ => &[],
        };
        let sizes = [
            "radius",
            "length",
            "tube",
            "half_size",
            "model",
            "scale",
            "texture",
        ];
        for size in sizes.into_iter().filter(|size| !may.contains(size)) {
            let key = object.key(size);
            match (needed.contains(&size), reading.is_written(&key)) {
                (true, false) => {
                    reading.complain(&key, "nothing", &format!("`{size}`, which a {shape} needs"))
                }
                (false, true) => reading.complain(
                    &key,
                    &format!("`{size}`"),
                    &format!("no `{size}`, as the object is a {shape}"),
                ),
                _ => {}
            }
        }
    }
}

fn check_parents(reading: &mut Reading) {
    let objects = scene_names(reading.value(), "object");
    let parents = texts(reading.value(), "object", "parent");
    let names: Vec<&str> = objects
        .iter()
        .flat_map(|(_, names)| names)
        .map(String::as_str)
        .collect();
    let owner = |name: &str| {
        objects
            .iter()
            .find(|(_, names)| names.iter().any(|n| n == name))
            .map(|(i, _)| *i)
    };
    for (i, parent) in &parents {
        let key = KeyPath::root().key("object").at(*i).key("parent");
        refers(reading, &key, parent, "an object", &names);
        // Up the chain of parents: whoever comes back to himself stands in a cycle. Longer than the list is a cycle too,
        // of others, which they complain about.
        let mut above = owner(parent);
        for _ in 0..objects.len() {
            if above == Some(*i) {
                reading.complain(
                    &key,
                    &format!("`{parent}`, which hangs on this object itself"),
                    "a parent outside of its own children",
                );
                break;
            }
            let next = parents.iter().find(|(child, _)| Some(*child) == above);
            above = next.and_then(|(_, parent)| owner(parent));
        }
    }
}

fn check_physics(reading: &mut Reading) {
    let root = KeyPath::root();
    let bodies = reading.is_written(&root.key("body"));
    for table in ["physics", "method"] {
        let key = root.key(table);
        match (reading.is_written(&key), bodies) {
            (false, true) => {
                let expected = format!("a table [{table}], which bodies need");
                reading.complain(&key, "nothing", &expected);
            }
            (true, false) => {
                let expected = format!("no {table}, as there are no bodies");
                reading.complain(&key, "a table", &expected);
            }
            _ => {}
        }
    }
    let search = reading.value()["physics"]["broad_phase"].clone();
    check_broad_phase(reading, &root.key("physics"), &search);
}

fn check_limits(reading: &mut Reading, manifest: &Manifest, known_metrics: &[KnownMetric<'_>]) {
    let root = KeyPath::root();
    let limits = texts(reading.value(), "limit", "metric");
    unique(reading, &root, &limits, "limit", "metric");

    let own = manifest.metric.iter().map(|metric| KnownMetric {
        id: &metric.id,
        unit: metric.unit,
        direction: metric.direction,
    });
    let metrics: Vec<KnownMetric<'_>> = known_metrics.iter().copied().chain(own).collect();
    let ids: Vec<&str> = metrics.iter().map(|metric| metric.id).collect();
    for (i, id) in limits {
        let limit = root.key("limit").at(i);
        match metrics.iter().find(|metric| metric.id == id) {
            Some(metric) => check_limit(reading, &limit, metric),
            None => refers(reading, &limit.key("metric"), &id, "a metric", &ids),
        }
    }

    let reasons: Vec<&str> = manifest
        .reason
        .iter()
        .map(|reason| reason.id.as_str())
        .collect();
    for (i, reason) in texts(reading.value(), "limit", "reason") {
        refers(
            reading,
            &root.key("limit").at(i).key("reason"),
            &reason,
            "a reason in the module's manifest",
            &reasons,
        );
    }
}

/// What a value of a limit may be, of a metric in this unit.
pub(crate) fn limit_kind(unit: Unit) -> Kind {
    match unit {
        Unit::Count => Kind::quantity(unit, 0.0, f64::INFINITY),
        unit => Kind::quantity(unit, f64::NEG_INFINITY, f64::INFINITY),
    }
}

/// Reads the values of a limit in the unit of its metric and compares them.
fn check_limit(reading: &mut Reading, limit: &KeyPath, metric: &KnownMetric<'_>) {
    let kind = limit_kind(metric.unit);
    let fields = ["min", "max", "full", "zero"];
    let [min, max, full, zero] = fields.map(|field| {
        let value = reading.refine(&limit.key(field), &kind);
        value.and_then(|value| value.as_f64())
    });
    let [has_min, has_max, has_full, has_zero] =
        fields.map(|field| reading.is_written(&limit.key(field)));

    if !has_min && !has_max {
        reading.complain(limit, "a limit without bounds", "`min` or `max`");
    }
    if min.zip(max).is_some_and(|(min, max)| min > max) {
        reading.complain(
            &limit.key("min"),
            "a `min` above `max`",
            "a range that is not empty",
        );
    }
    let decides = reading.value_at(&limit.key("decides"));
    if metric.id == "time" && decides == Some(&Value::Bool(false)) {
        let key = limit.key("decides");
        reading.complain(
            &key,
            "`false` for `time`",
            "`true`: its `max` ends the level",
        );
    }
    // Points are derived from the bound where a level gives none; nothing can be derived from 0.
    let bound = if has_max { max } else { min };
    if bound == Some(0.0) && !has_full && !has_zero {
        reading.complain(
            limit,
            "a limit of 0 without `full` and `zero`",
            "both of them, since 0 gives no scale for points",
        );
    }
    if has_full != has_zero {
        let (there, missing) = if has_full {
            ("full", "zero")
        } else {
            ("zero", "full")
        };
        reading.complain(
            &limit.key(there),
            &format!("`{there}` without `{missing}`"),
            "both or neither",
        );
    }
    let Some((full, zero)) = full.zip(zero) else {
        return;
    };
    let (consistent, expected) = match metric.direction {
        Direction::Lower => (
            full < zero,
            "`full` below `zero`, as lower values of the metric are better",
        ),
        Direction::Higher => (
            full > zero,
            "`full` above `zero`, as higher values of the metric are better",
        ),
        Direction::Range | Direction::Inform => (full != zero, "`full` other than `zero`"),
    };
    if !consistent {
        let found = format!(
            "{} for 100 points and {} for 0",
            metric.unit.describe(full),
            metric.unit.describe(zero)
        );
        reading.complain(&limit.key("full"), &found, expected);
    }
}
