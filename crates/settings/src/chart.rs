//! `config/chart.toml`: which runs `microsim chart` makes and compares, and from which methods `microsim tune` chooses.
//!
//! A run is a scene with overrides: those of a resolution, of a variant, of a material and of a method, and a step. A sweep
//! is the product of its lists; the runs of a scene are those of its sweeps in their order, each run once.

use crate::check::{items, refers, texts, unique};
use crate::document::{Loaded, Reading, load_text};
use crate::error::{ConfigErrors, KeyPath};
use crate::files::schema_of;
use crate::kinds::{identifier, list, number, quantity, relative_path, time, vector};
use crate::overrides::Override;
use crate::scene::Feature;
use crate::schema::Kind;
use crate::table::{choices, table};
use microsim_vocabulary::{Discretisation, Unit, terms};
use std::path::Path;

table! {
    /// What is run and compared.
    pub struct Chart {
        /// How much time is allowed.
        budget: ChartBudget,
        /// How the exact solution on a mesh with a material is made.
        exact: ChartExact,
        /// What `microsim tune` chooses from.
        tune: ChartTune,
        /// Materials with their discretisations.
        material: Vec<ChartMaterial> [1, 64],
        /// Methods with the parameters that are tried.
        method: Vec<ChartMethod> [1, 64],
        /// Methods that `microsim tune` tries on levels.
        level_method: Vec<ChartMethod> [0, 64],
        /// Scenes with what is compared.
        scene: Vec<ChartScene> [1, 64],
    }
}

table! {
    /// How much time is allowed.
    #[derive(Copy)]
    pub struct ChartBudget {
        /// CPU time of a run \[s\]; what needs more is cut off and reported as over budget.
        run: f64 = time(0.01, 1e6),
        /// The same for the short chart \[s\].
        quick_run: f64 = time(0.01, 1e6),
        /// Time of the short chart \[s\]; what does not fit is left out and named.
        quick_total: f64 = time(1.0, 1e6),
    }
}

table! {
    /// How the exact solution on a mesh with a material is made.
    pub struct ChartExact {
        /// Overrides for the equilibrium: `KEY=VALUE`, as with --set.
        rest: Vec<String> [0, 64],
        /// Overrides for the motion: those of an explicit method.
        motion: Vec<String> [0, 64],
        /// Step of the motion as a fraction of the estimated stability limit.
        fraction: f64 = quantity(Unit::Ratio, 0.001, 1.0) => 0.25,
    }
}

table! {
    /// What `microsim tune` chooses from.
    pub struct ChartTune {
        /// Numbers of cells as multiples of those of the file, from coarse to fine.
        scales: Vec<f64> = list(quantity(Unit::Ratio, 0.05, 20.0), 1, 32),
        /// Number of cells of the mesh that is the measure where nothing is known from outside, as a multiple of
        /// those of the file.
        reference_scale: f64 = quantity(Unit::Ratio, 0.05, 20.0),
        /// Numbers of cells of a level's bodies as multiples of those of the file: along x, y and z of a block;
        /// along, around and through a tube. From coarse to fine.
        level_scales: Vec<[f64; 3]> = list(vector(Unit::Ratio, 3, 0.05, 20.0), 1, 32),
        /// The same as `reference_scale` for levels.
        level_reference_scale: f64 = quantity(Unit::Ratio, 0.05, 20.0),
        /// Discretisations of continua; the first one is that of the measure.
        discretisations: Vec<Discretisation> [1, 32],
        /// Names of methods, with the steps and iterations that the chart tries.
        methods: Vec<String> [1, 32],
    }
}

table! {
    /// A material with its discretisation.
    pub struct ChartMaterial {
        /// Its name.
        name: String,
        /// Its name for people.
        title: String,
        /// Values that take the place of those of the scene: `KEY=VALUE`, as with --set.
        set: Vec<String> [0, 64],
        /// Whether it is a material of the dissertation; runs of such a material by such a method are drawn in a colour of their own.
        dissertation: bool => false,
    }
}

table! {
    /// A method with the parameters that are tried.
    pub struct ChartMethod {
        /// Its name.
        name: String,
        /// Its name for people.
        title: String,
        /// Values that take the place of those of the scene: `KEY=VALUE`, as with --set.
        set: Vec<String> [0, 64],
        /// Whether it is a method of the dissertation, as with materials.
        dissertation: bool => false,
        /// Steps of the solver \[s\].
        steps: Vec<f64> = list(time(1e-9, 1.0), 0, 32),
        /// Steps as fractions of the estimated stability limit of explicit methods.
        fractions: Vec<f64> = list(quantity(Unit::Ratio, 0.001, 10.0), 0, 32),
        /// Numbers of iterations in a step; the method's own if empty.
        iterations: Vec<u32> = list(Kind::Integer { min: 1, max: 100_000 }, 0, 32),
    }
}

table! {
    /// A scene of the chart.
    pub struct ChartScene {
        /// Its name on the command line.
        name: String = identifier(),
        /// Its name for people.
        title: String,
        /// The scene's file, from the folder of this file.
        file: String = relative_path(),
        /// What the exact solution on the same mesh is: the equilibrium at `rest`, or the `motion` at a small step.
        exact: ExactKind,
        /// Overrides for it instead of those of `exact` at the top; those if empty.
        exact_set: Vec<String> [0, 64],
        /// Step for the exact motion, where its method has no stability limit \[s\].
        exact_step: Option<f64> = time(1e-9, 1.0),
        /// What is compared; the error of a run is the largest of them.
        measure: Vec<ChartMeasure> [1, 16],
        /// Meshes, from coarse to fine.
        resolution: Vec<ChartResolution> [1, 16],
        /// Values of the scene's parameters.
        variant: Vec<ChartVariant> [1, 16],
        /// Products of lists.
        sweep: Vec<ChartSweep> [1, 64],
    }
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

choices!(ExactKind);

table! {
    /// Something of a probe's series that is compared.
    pub struct ChartMeasure {
        /// Its name for people.
        title: String,
        /// The scene's probe.
        probe: String = identifier(),
        /// What of its series.
        what: Feature,
        /// A first peak counts when the curve has stayed below it for this time \[s\].
        fall_time: f64 = time(0.0, 1e3) => 0.05,
    }
}

table! {
    /// A mesh.
    pub struct ChartResolution {
        /// Its name.
        name: String,
        /// Values that take the place of those of the scene: `KEY=VALUE`, as with --set.
        set: Vec<String> [0, 64],
    }
}

table! {
    /// Values of the scene's parameters.
    pub struct ChartVariant {
        /// Its name.
        name: String,
        /// Values that take the place of those of the scene: `KEY=VALUE`, as with --set.
        set: Vec<String> [0, 64],
        /// Poisson's ratio, for the comparison of discretisations over it.
        poisson_ratio: Option<f64> = quantity(Unit::Ratio, -1.0, 0.5),
        /// The right values of the first measures, in their order and in SI; of the others nothing is known from
        /// outside.
        reference: Vec<f64> = list(number(), 0, 16),
        /// Where the right values come from, in a sentence.
        source: Option<String>,
    }
}

table! {
    /// A product of lists.
    pub struct ChartSweep {
        /// Whether it belongs to the short chart (`--quick`).
        quick: bool => false,
        /// Names of resolutions.
        resolutions: Vec<String> [1, 64],
        /// Names of variants; all if empty.
        variants: Vec<String> [0, 64],
        /// Names of materials.
        materials: Vec<String> [1, 64],
        /// Names of methods.
        methods: Vec<String> [1, 64],
        /// Steps of the solver \[s\].
        steps: Vec<f64> = list(time(1e-9, 1.0), 0, 32),
        /// Steps as fractions of the estimated stability limit of explicit methods.
        fractions: Vec<f64> = list(quantity(Unit::Ratio, 0.001, 10.0), 0, 32),
        /// Numbers of iterations in a step; the method's own if empty.
        iterations: Vec<u32> = list(Kind::Integer { min: 1, max: 100_000 }, 0, 32),
    }
}

/// Reads the chart's file from a text; `file` is the name that complaints use.
pub fn read_chart(text: &str, file: &str) -> Result<Loaded<Chart>, ConfigErrors> {
    let mut reading = Reading::new(text, file, &schema_of::<Chart>("chart"))?;
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
            reading.complain(&key, "0", "values to which an error can be relative");
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
