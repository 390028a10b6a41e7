//! Scene files: finding one, building it, and saying with its place what is wrong with it.

use crate::cli::Place;
use crate::output::Problem;
use crate::session_file::program_folder;
use microsim_mesh::{Severity, defects};
use microsim_scene::{
    Behaviour, BuildError, FromSettingsError, ProbeError, Runner, Scene, SceneError, SceneSpec, scene_spec,
};
use microsim_settings as settings;
use settings::{Document, KeyPath, Loaded, Override};
use std::path::{Path, PathBuf};

/// Most defects of one mesh that are printed.
const PRINTED: usize = 10;

/// A scene that can run.
#[derive(Debug)]
pub struct SceneFile {
    /// What its file says.
    pub loaded: Loaded<settings::Scene>,
    /// What it is made of.
    pub spec: SceneSpec,
    /// Ready to run.
    pub runner: Runner,
    /// What is not wrong, but should be known: a sentence each.
    pub warnings: Vec<String>,
    /// The step that the bodies do not allow, in a sentence.
    pub step_too_long: Option<String>,
}

/// A scene by a path, or by its name in the folder of scenes.
pub fn find(place: &Place, given: &Path) -> Result<PathBuf, Problem> {
    if given.is_file() {
        return Ok(given.to_path_buf());
    }
    let folder = folder(place)?;
    let named = folder.join(given).with_extension("toml");
    if given.components().count() == 1 && named.is_file() {
        return Ok(named);
    }
    let names: Vec<String> = crate::check::files_in(&folder, "toml")
        .iter()
        .filter_map(|path| Some(path.file_stem()?.to_string_lossy().into_owned()))
        .collect();
    let there = match names.as_slice() {
        [] => "there is none".to_owned(),
        names => format!("there are: {}", names.join(", ")),
    };
    Err(format!(
        "no scene file {}, and no scene of this name in {}; {there}",
        given.display(),
        folder.display()
    )
    .into())
}

/// The folder of scenes.
pub fn folder(place: &Place) -> Result<PathBuf, Problem> {
    let config = match (&place.config, &place.root) {
        (Some(config), _) => config.clone(),
        (None, Some(root)) => root.join("config"),
        (None, None) => program_folder()?.join("config"),
    };
    Ok(config.join("scenes"))
}

impl SceneFile {
    /// Reads and builds the scene at `path`; the error is a sentence per line.
    pub fn open(path: &Path, overrides: &[Override]) -> Result<Self, String> {
        let loaded = settings::load_scene(path, overrides).map_err(|e| e.to_string())?;
        let document = &loaded.document;
        let folder = path.parent().unwrap_or(Path::new(""));
        let described = scene_spec(&loaded.settings, &mut |file| std::fs::read(folder.join(file)));
        let described = described
            .map_err(|FromSettingsError { key, cause }| format!("{}: {cause}", document.place(&key)))?;
        let mut warnings: Vec<String> = described
            .notes
            .iter()
            .map(|note| format!("{}: {note}", path.display()))
            .collect();
        check_meshes(&loaded, &described.spec, &mut warnings)?;
        warnings.extend(locking(&loaded, &described.spec));
        let scene = Scene::new(&described.spec)
            .map_err(|e| format!("{}: {e}", document.place(&key_of(&e, &loaded.settings))))?;
        let runner = Runner::new(&loaded.settings, scene).map_err(|error: ProbeError| {
            let key = KeyPath::root().key("probe").at(error.probe).key("nodes");
            format!("{}: {error}", document.place(&key))
        })?;
        let step_too_long = step_too_long(document, &runner);
        Ok(Self {
            spec: described.spec,
            runner,
            warnings,
            step_too_long,
            loaded,
        })
    }
}

/// Meshes from files may hold anything.
fn check_meshes(
    loaded: &Loaded<settings::Scene>,
    spec: &SceneSpec,
    warnings: &mut Vec<String>,
) -> Result<(), String> {
    let mut errors = Vec::new();
    for (index, (body, of)) in loaded.settings.body.iter().zip(&spec.bodies).enumerate() {
        if body.generator != settings::Generator::File {
            continue;
        }
        let place = loaded.document.place(&KeyPath::root().key("body").at(index).key("file"));
        let found = defects(&of.mesh);
        for severity in [Severity::Error, Severity::Warning] {
            let of_severity: Vec<_> = found.iter().filter(|d| d.severity() == severity).collect();
            let list = match severity {
                Severity::Error => &mut errors,
                Severity::Warning => &mut *warnings,
            };
            let shown = of_severity.iter().take(PRINTED);
            list.extend(shown.map(|defect| format!("{place}: {defect}")));
            if let Some(more) = of_severity.len().checked_sub(PRINTED + 1) {
                list.push(format!("{place}: and {} more of the kind", more + 1));
            }
        }
    }
    match errors.is_empty() {
        true => Ok(()),
        false => Err(errors.join("\n")),
    }
}

/// Where a Poisson's ratio makes the elements too stiff.
fn locking(loaded: &Loaded<settings::Scene>, spec: &SceneSpec) -> Vec<String> {
    let mut warnings = Vec::new();
    for (b, body) in loaded.settings.body.iter().enumerate() {
        for (m, material) in body.material.iter().enumerate() {
            let (Some(poisson), Some(body)) = (material.poisson_ratio, spec.bodies.get(b)) else {
                continue;
            };
            let mut regions = body.materials.iter();
            let locks = regions.any(|(region, of)| {
                let own = material.region.is_none_or(|own| own == *region);
                match of.behaviour {
                    Behaviour::Continuum(constants) => {
                        own && constants.poisson == poisson
                            && constants.discretisation.locks(poisson)
                    }
                    Behaviour::Springs(_) => false,
                }
            });
            if locks {
                let key = KeyPath::root().key("body").at(b).key("material").at(m);
                warnings.push(format!(
                    "{}: tetrahedra lock at a Poisson's ratio of {poisson}, the body is too stiff (NUMERICS 1.6): use discretisation = \"selective\" or \"nodal-pressure\"",
                    loaded.document.place(&key.key("poisson_ratio"))
                ));
            }
        }
    }
    warnings
}

/// The step if it is longer than the bodies allow, and what helps.
fn step_too_long(document: &Document, runner: &Runner) -> Option<String> {
    let scene = runner.scene();
    let slowest = (0..scene.body_count())
        .min_by(|a, b| scene.stable_step(*a).total_cmp(&scene.stable_step(*b)))?;
    let stable = scene.stable_step(slowest);
    (runner.step() > stable).then(|| {
        format!(
            "{}: a step of {} is beyond what {} allows for body '{}', {}: use a shorter step or an implicit method",
            document.place(&KeyPath::root().key("run").key("step")),
            settings::Unit::Time.describe(runner.step()),
            scene.method().name(),
            scene.body_name(slowest),
            settings::Unit::Time.describe(stable),
        )
    })
}

/// The key that is to blame for a scene that cannot be built.
fn key_of(error: &SceneError, scene: &settings::Scene) -> KeyPath {
    let root = KeyPath::root();
    let body = |name: &str| {
        let index = scene.body.iter().position(|body| body.name == name);
        root.key("body").at(index.unwrap_or_default())
    };
    match error {
        SceneError::Build { body: name, source } => match source {
            BuildError::Material { region, .. } | BuildError::Region { region, .. } => {
                let of = scene.body.iter().find(|body| body.name == *name);
                let materials = of.map(|of| of.material.as_slice()).unwrap_or_default();
                let index = materials.iter().position(|m| m.region == Some(*region));
                let index = index.or_else(|| materials.iter().position(|m| m.region.is_none()));
                match index {
                    Some(index) => body(name).key("material").at(index),
                    None => body(name).key("material"),
                }
            }
            _ => body(name).key("generator"),
        },
        SceneError::Empty {
            body: name,
            what,
            index,
        } => {
            let nodes = if *what == "load" { "surface" } else { "nodes" };
            body(name).key(what).at(*index).key(nodes)
        }
        SceneError::Method { .. } | SceneError::Contact { .. } | SceneError::Grip { .. } => {
            root.key("method").key("name")
        }
        SceneError::Name { .. } => root.key("body"),
        _ => root,
    }
}
