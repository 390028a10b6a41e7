//! `config/chart.toml`: which runs `microsim chart` makes and compares, and from which methods `microsim tune` chooses.
//!
//! A run is a scene with overrides: those of a resolution, of a variant, of a material and of a method, and a step. A sweep
//! is the product of its lists; the runs of a scene are those of its sweeps in their order, each run once.

use crate::chart_schema::chart_schema;
use crate::check::{items, refers, texts, unique};
use crate::document::{Loaded, Reading, load_text};
use crate::error::{ConfigErrors, KeyPath};
use crate::overrides::Override;
use crate::scene::Feature;
use microsim_vocabulary::{Discretisation, terms};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// What is run and compared.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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
    /// Methods that `tune` tries on levels.
    pub level_method: Vec<ChartMethod>,
    /// Scenes.
    pub scene: Vec<ChartScene>,
}

/// How much time is allowed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
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
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ChartTune {
    /// Numbers of cells as multiples of those of the file, from coarse to fine.
    pub scales: Vec<f64>,
    /// Number of cells of the mesh that is the measure where nothing is known from outside, as a multiple of those of the file.
    pub reference_scale: f64,
    /// The same for levels, along x, y and z of blocks; along, around and through tubes.
    pub level_scales: Vec<[f64; 3]>,
    /// The same as `reference_scale` for levels.
    pub level_reference_scale: f64,
    /// Discretisations of continua; the first one is that of the measure.
    pub discretisations: Vec<Discretisation>,
    /// Names of methods, with the steps and iterations that the chart tries.
    pub methods: Vec<String>,
}

/// A material with its discretisation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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

terms! {
    /// What the exact solution on the same mesh, with the same material, is.
    pub enum ExactKind {
        /// The equilibrium.
        Rest = "rest",
        /// The motion at a small step.
        Motion = "motion",
    }
}

/// Something of a probe's series that is compared.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ChartResolution {
    /// Its name.
    pub name: String,
    /// Overrides, `KEY=VALUE`.
    pub set: Vec<String>,
}

/// Values of the scene's parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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

/// Reads the chart's file from a text; `file` is the name that complaints use.
pub fn read_chart(text: &str, file: &str) -> Result<Loaded<Chart>, ConfigErrors> {
    let mut reading = Reading::new(text, file, &chart_schema())?;
    let root = KeyPath::root();
    for list in ["material", "method", "level_method", "scene"] {
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
    let tune = reading.value()["tune"].clone();
    for (i, name) in items(&tune, "methods") {
        let Some(name) = name.as_str() else { continue };
        refers(
            &mut reading,
            &root.key("tune").key("methods").at(i),
            name,
            "a method",
            &methods,
        );
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
