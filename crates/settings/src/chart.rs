//! `config/chart.toml`: which runs `microsim chart` makes and compares, and from which methods `microsim tune` chooses.
//!
//! A run is a scene with overrides: those of a resolution, of a variant, of a material and of a method, and a step. A sweep
//! is the product of its lists; the runs of a scene are those of its sweeps in their order, each run once.

use crate::body::Discretisation;
use crate::check::{items, refers, texts, unique};
use crate::document::{Loaded, Reading, load_text};
use crate::error::{ConfigErrors, KeyPath};
use crate::overrides::Override;
use crate::scene::Feature;
use crate::schema::{Form, Key, Kind, Schema};
use crate::unit::Unit;
use serde::Deserialize;
use std::path::Path;

/// What is run and compared.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Chart {
    /// How much time is allowed.
    pub budget: ChartBudget,
    /// How exact solutions are made.
    pub exact: ChartExact,
    /// What `microsim tune` chooses from.
    pub tune: ChartTune,
    /// Materials with their discretisations.
    pub material: Vec<ChartMaterial>,
    /// Methods.
    pub method: Vec<ChartMethod>,
    /// Scenes.
    pub scene: Vec<ChartScene>,
}

/// How much time is allowed.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ChartBudget {
    /// CPU time of a run \[s\]; a run that needs more is cut off and said to be over budget.
    pub run: f64,
    /// The same for the quick chart \[s\].
    pub quick_run: f64,
    /// Time of the quick chart \[s\]; what does not fit is left out and named.
    pub quick_total: f64,
}

/// How the exact solution on a mesh with a material is made.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ChartExact {
    /// Overrides for the equilibrium, `KEY=VALUE`.
    pub rest: Vec<String>,
    /// Overrides for the motion, `KEY=VALUE`: an explicit method.
    pub motion: Vec<String>,
    /// Step of the motion as a share of the stability limit.
    pub share: f64,
}

/// What `microsim tune` chooses from.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ChartTune {
    /// Numbers of cells as multiples of those of the file, from coarse to fine.
    pub scales: Vec<f64>,
    /// Number of cells of the mesh that is the measure where nothing is known from outside, as a multiple of those of the file.
    pub reference_scale: f64,
    /// Discretisations of continua; the first one is that of the measure.
    pub discretisations: Vec<Discretisation>,
    /// Names of methods, with the steps and iterations that the chart tries.
    pub methods: Vec<String>,
    /// Names of methods for levels with contact.
    pub contact_methods: Vec<String>,
}

/// A material with its discretisation.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ChartMaterial {
    /// Its name in sweeps.
    pub name: String,
    /// For people.
    pub title: String,
    /// Overrides, `KEY=VALUE`.
    pub set: Vec<String>,
}

/// A method with the parameters that are tried.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ChartMethod {
    /// Its name in sweeps.
    pub name: String,
    /// For people.
    pub title: String,
    /// Overrides, `KEY=VALUE`.
    pub set: Vec<String>,
    /// Steps \[s\].
    pub steps: Vec<f64>,
    /// Steps as shares of the estimated stability limit of explicit methods.
    pub shares: Vec<f64>,
    /// Numbers of iterations in a step; empty for the method's own.
    pub iterations: Vec<u32>,
}

/// A scene of the chart.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ChartScene {
    /// Its name on the command line.
    pub name: String,
    /// For people.
    pub title: String,
    /// The scene's file, from the folder of the chart's file.
    pub file: String,
    /// What the exact solution on the same mesh is.
    pub exact: ExactKind,
    /// Overrides for it instead of those of the plan; none for those.
    pub exact_set: Vec<String>,
    /// Step for it \[s\], for a method without a stability limit.
    pub exact_step: Option<f64>,
    /// What is compared; the error of a run is the largest of them.
    pub measure: Vec<ChartMeasure>,
    /// Meshes, from coarse to fine.
    pub resolution: Vec<ChartResolution>,
    /// Values of the scene's parameters.
    pub variant: Vec<ChartVariant>,
    /// Products of lists.
    pub sweep: Vec<ChartSweep>,
}

/// What the exact solution on the same mesh, with the same material, is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ExactKind {
    /// The equilibrium.
    Rest,
    /// The motion at a small step.
    Motion,
}

impl ExactKind {
    /// As files write them.
    pub const NAMES: [&str; 2] = ["rest", "motion"];
}

/// Something of a probe's series that is compared.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ChartMeasure {
    /// For people.
    pub title: String,
    /// The scene's probe.
    pub probe: String,
    /// What of its series.
    pub what: Feature,
    /// How long a curve must have fallen after its first peak \[s\].
    pub settle: f64,
}

/// A mesh.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ChartResolution {
    /// Its name.
    pub name: String,
    /// Overrides, `KEY=VALUE`.
    pub set: Vec<String>,
}

/// Values of the scene's parameters.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ChartVariant {
    /// Its name.
    pub name: String,
    /// Overrides, `KEY=VALUE`.
    pub set: Vec<String>,
    /// Poisson's ratio, for the comparison of discretisations over it.
    pub poisson_ratio: Option<f64>,
    /// The right values of the first of the scene's measures, in their order and in SI; of the others nothing is known from
    /// outside.
    pub reference: Vec<f64>,
    /// Where they come from.
    pub source: Option<String>,
}

/// A product of lists.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ChartSweep {
    /// Whether it belongs to the quick chart.
    pub quick: bool,
    /// Names of resolutions.
    pub resolutions: Vec<String>,
    /// Names of variants; all if empty.
    pub variants: Vec<String>,
    /// Names of materials.
    pub materials: Vec<String>,
    /// Names of methods.
    pub methods: Vec<String>,
    /// Steps \[s\] instead of those of the methods that have any.
    pub steps: Vec<f64>,
    /// Shares of the stability limit instead of those of the methods that have any.
    pub shares: Vec<f64>,
    /// Numbers of iterations instead of those of the methods that have any.
    pub iterations: Vec<u32>,
}

/// The schema of the chart's file.
pub fn chart_schema() -> Schema {
    let some = |keys: Vec<Key>, max| Kind::List {
        of: Box::new(Kind::Table(keys)),
        min: 1,
        max,
    };
    let time = |min| Kind::quantity(Unit::Time, min, 1e6);
    let budget = vec![
        Key::required(
            "run",
            time(0.01),
            "CPU time of a run; what needs more is cut off and said to be over budget.",
        ),
        Key::required("quick_run", time(0.01), "The same for the quick chart."),
        Key::required(
            "quick_total",
            time(1.0),
            "Time of the quick chart; what does not fit is left out and named.",
        ),
    ];
    Schema {
        name: "chart".to_owned(),
        doc: "config/chart.toml: the runs that `microsim chart` compares, and what `microsim tune` chooses from.".to_owned(),
        keys: vec![
            Key::required("budget", Kind::Table(budget), "How much time is allowed."),
            Key::required("exact", Kind::Table(exact_keys()), "How the exact solution on a mesh with a material is made."),
            Key::required("tune", Kind::Table(tune_keys()), "What `microsim tune` chooses from."),
            Key::required("material", some(material_keys(), 64), "Materials with their discretisations."),
            Key::required("method", some(method_keys(), 64), "Methods with the parameters that are tried."),
            Key::required("scene", some(scene_keys(), 64), "Scenes with what is compared."),
        ],
    }
}

fn exact_keys() -> Vec<Key> {
    let overrides = |name: &str, doc: &str| Key::list(name, Kind::Text, 64, doc);
    vec![
        overrides(
            "rest",
            "Overrides for the equilibrium: `KEY=VALUE`, as with --set.",
        ),
        overrides(
            "motion",
            "Overrides for the motion: those of an explicit method.",
        ),
        Key::with_default(
            "share",
            Kind::quantity(Unit::Ratio, 0.001, 1.0),
            "Step of the motion as a share of the estimated stability limit.",
            0.25,
        ),
    ]
}

fn tune_keys() -> Vec<Key> {
    let some = |of: Kind| Kind::List {
        of: Box::new(of),
        min: 1,
        max: 32,
    };
    vec![
        Key::required(
            "scales",
            some(Kind::quantity(Unit::Ratio, 0.05, 20.0)),
            "Numbers of cells as multiples of those of the file, from coarse to fine.",
        ),
        Key::required(
            "reference_scale",
            Kind::quantity(Unit::Ratio, 0.05, 20.0),
            "Number of cells of the mesh that is the measure where nothing is known from outside, as a multiple of those of the file.",
        ),
        Key::required(
            "discretisations",
            some(Kind::choice(&Discretisation::NAMES)),
            "Discretisations of continua; the first one is that of the measure.",
        ),
        Key::required(
            "methods",
            some(Kind::Text),
            "Names of methods, with the steps and iterations that the chart tries.",
        ),
        Key::required(
            "contact_methods",
            some(Kind::Text),
            "Names of methods for levels with contact.",
        ),
    ]
}

fn name() -> Key {
    Key::required("name", Kind::Text, "Its name.")
}

fn title() -> Key {
    Key::required("title", Kind::Text, "Its name for people.")
}

fn set() -> Key {
    Key::list(
        "set",
        Kind::Text,
        64,
        "Values that take the place of those of the scene: `KEY=VALUE`, as with --set.",
    )
}

fn steps() -> Key {
    Key::list(
        "steps",
        Kind::quantity(Unit::Time, 1e-9, 1.0),
        32,
        "Steps of the solver.",
    )
}

fn shares() -> Key {
    let share = Kind::quantity(Unit::Ratio, 0.001, 10.0);
    Key::list(
        "shares",
        share,
        32,
        "Steps as shares of the estimated stability limit of explicit methods.",
    )
}

fn iterations() -> Key {
    let count = Kind::Integer {
        min: 1,
        max: 100_000,
    };
    Key::list(
        "iterations",
        count,
        32,
        "Numbers of iterations in a step; the method's own if empty.",
    )
}

fn material_keys() -> Vec<Key> {
    vec![name(), title(), set()]
}

fn method_keys() -> Vec<Key> {
    vec![name(), title(), set(), steps(), shares(), iterations()]
}

fn scene_keys() -> Vec<Key> {
    let measure = vec![
        title(),
        Key::required("probe", Kind::Name(Form::Identifier), "The scene's probe."),
        Key::required("what", Kind::choice(&Feature::NAMES), "What of its series."),
        Key::with_default(
            "settle",
            Kind::quantity(Unit::Time, 0.0, 1e3),
            "A first peak counts when the curve has stayed below it for this time.",
            0.05,
        ),
    ];
    let any = Kind::quantity(Unit::Ratio, f64::NEG_INFINITY, f64::INFINITY);
    let variant = vec![
        name(),
        set(),
        Key::optional(
            "poisson_ratio",
            Kind::quantity(Unit::Ratio, -1.0, 0.5),
            "Poisson's ratio, for the comparison of discretisations over it.",
        ),
        Key::list(
            "reference",
            any,
            16,
            "The right values of the first measures, in their order and in SI; of the others nothing is known from outside.",
        ),
        Key::optional(
            "source",
            Kind::Text,
            "Where the right values come from, in a sentence.",
        ),
    ];
    let names = |name: &str, doc: &str| {
        let of = Kind::List {
            of: Box::new(Kind::Text),
            min: 1,
            max: 64,
        };
        Key::required(name, of, doc)
    };
    let sweep = vec![
        Key::with_default(
            "quick",
            Kind::Bool,
            "Whether it belongs to the quick chart.",
            false,
        ),
        names("resolutions", "Names of resolutions."),
        Key::list(
            "variants",
            Kind::Text,
            64,
            "Names of variants; all if empty.",
        ),
        names("materials", "Names of materials."),
        names("methods", "Names of methods."),
        steps(),
        shares(),
        iterations(),
    ];
    let some = |keys: Vec<Key>, max| Kind::List {
        of: Box::new(Kind::Table(keys)),
        min: 1,
        max,
    };
    vec![
        Key::required(
            "name",
            Kind::Name(Form::Identifier),
            "Its name on the command line.",
        ),
        title(),
        Key::required(
            "file",
            Kind::Name(Form::RelativePath),
            "The scene's file, from the folder of this file.",
        ),
        Key::required(
            "exact",
            Kind::choice(&ExactKind::NAMES),
            "What the exact solution on the same mesh is: the equilibrium at `rest`, or the `motion` at a small step.",
        ),
        Key::list(
            "exact_set",
            Kind::Text,
            64,
            "Overrides for it instead of those of `exact` at the top; those if empty.",
        ),
        Key::optional(
            "exact_step",
            Kind::quantity(Unit::Time, 1e-9, 1.0),
            "Step for the exact motion, where its method has no stability limit.",
        ),
        Key::required(
            "measure",
            some(measure, 16),
            "What is compared; the error of a run is the largest of them.",
        ),
        Key::required(
            "resolution",
            some(vec![name(), set()], 16),
            "Meshes, from coarse to fine.",
        ),
        Key::required(
            "variant",
            some(variant, 16),
            "Values of the scene's parameters.",
        ),
        Key::required("sweep", some(sweep, 64), "Products of lists."),
    ]
}

/// Reads the chart's file from a text; `file` is the name that complaints use.
pub fn read_chart(text: &str, file: &str) -> Result<Loaded<Chart>, ConfigErrors> {
    let mut reading = Reading::new(text, file, &chart_schema())?;
    let root = KeyPath::root();
    for list in ["material", "method", "scene"] {
        let names = texts(reading.value(), list, "name");
        unique(&mut reading, &root, &names, list, "name");
        for i in 0..items(reading.value(), list).count() {
            check_set(&mut reading, &root.key(list).at(i), "set");
        }
    }
    for list in ["rest", "motion"] {
        check_set(&mut reading, &root.key("exact"), list);
    }
    let methods = texts(reading.value(), "method", "name");
    let methods: Vec<&str> = methods.iter().map(|(_, name)| name.as_str()).collect();
    for list in ["methods", "contact_methods"] {
        let tune = reading.value()["tune"].clone();
        for (i, name) in items(&tune, list) {
            let Some(name) = name.as_str() else { continue };
            refers(
                &mut reading,
                &root.key("tune").key(list).at(i),
                name,
                "a method",
                &methods,
            );
        }
    }
    for i in 0..items(reading.value(), "scene").count() {
        check_scene(&mut reading, i);
    }
    reading.finish()
}

/// Reads the chart's file at `path`.
pub fn load_chart(path: &Path) -> Result<Loaded<Chart>, ConfigErrors> {
    let text = load_text(path, "the plan of the chart (config/chart.toml)")?;
    read_chart(&text, &path.display().to_string())
}

/// Complains about overrides in the list `name` of the table at `key` that cannot be read.
fn check_set(reading: &mut Reading, key: &KeyPath, name: &str) {
    let table = reading.value_at(key).cloned().unwrap_or_default();
    for (i, value) in items(&table, name) {
        let Some(text) = value.as_str() else { continue };
        if let Err(expected) = Override::parse(text) {
            reading.complain(&key.key(name).at(i), &format!("`{text}`"), &expected);
        }
    }
}

fn check_scene(reading: &mut Reading, index: usize) {
    let key = KeyPath::root().key("scene").at(index);
    let Some(scene) = reading.value_at(&key).cloned() else {
        return;
    };
    check_set(reading, &key, "exact_set");
    for list in ["resolution", "variant"] {
        let names = texts(&scene, list, "name");
        unique(reading, &key, &names, list, "name");
        for i in 0..items(&scene, list).count() {
            check_set(reading, &key.key(list).at(i), "set");
        }
    }
    let measures = items(&scene, "measure").count();
    for (i, variant) in items(&scene, "variant") {
        let count = items(variant, "reference").count();
        let key = key.key("variant").at(i).key("reference");
        if count > measures {
            let expected = format!("at most one value for each of the {measures} measures");
            reading.complain(&key, &format!("{count} values"), &expected);
        }
        if items(variant, "reference").any(|(_, value)| value.as_f64() == Some(0.0)) {
            reading.complain(&key, "0", "values of which an error can be a share");
        }
    }
    let all = reading.value().clone();
    let lists = [
        (
            "resolutions",
            "a resolution",
            texts(&scene, "resolution", "name"),
        ),
        ("variants", "a variant", texts(&scene, "variant", "name")),
        ("materials", "a material", texts(&all, "material", "name")),
        ("methods", "a method", texts(&all, "method", "name")),
    ];
    for (i, sweep) in items(&scene, "sweep") {
        for (list, what, known) in &lists {
            let known: Vec<&str> = known.iter().map(|(_, name)| name.as_str()).collect();
            for (j, name) in items(sweep, list) {
                let Some(name) = name.as_str() else { continue };
                let key = key.key("sweep").at(i).key(list).at(j);
                refers(reading, &key, name, what, &known);
            }
        }
    }
}
