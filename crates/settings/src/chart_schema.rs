//! The keys of the plan of the chart.

use crate::chart::ExactKind;
use crate::scene::Feature;
use crate::schema::{Form, Key, Kind, Schema};
use microsim_vocabulary::{Discretisation, Unit};

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
            Key::list("level_method", Kind::Table(method_keys()), 64, "Methods that `microsim tune` tries on levels."),
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
            "level_scales",
            some(Kind::Vector {
                unit: Unit::Ratio,
                len: 3,
                min: 0.05,
                max: 20.0,
            }),
            "Numbers of cells of a level's bodies as multiples of those of the file: along x, y and z of a block; along, around and through a tube. From coarse to fine.",
        ),
        Key::required(
            "level_reference_scale",
            Kind::quantity(Unit::Ratio, 0.05, 20.0),
            "The same as `reference_scale` for levels.",
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
