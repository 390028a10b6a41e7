//! Scenes in files: finding one, building it, and saying with its place what is wrong with it; the bodies of levels likewise.

use crate::cli::Place;
use crate::discretisation::{self, Meshes};
use crate::output::Problem;
use crate::session_file::program_folder;
use crate::working_step::{self, microseconds};
use microsim_host::assemble::Installation;
use microsim_mesh::{Severity, TetMesh, defects_but_detached};
use microsim_scene::{
    Behaviour, BodyView, BuildError, Diverged, End, FromSettingsError, LevelParts, ProbeError,
    Runner, Scene, SceneError, SceneSpec, level_spec, scene_spec,
};
use microsim_settings as settings;
use settings::{Document, KeyPath, Loaded, Override};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Most sentences of one kind about one file.
const PRINTED: usize = 10;

/// Fraction of the largest step of an explicit method up to which no warning is given for a law that is not stable in large strain. Measured on
/// a beam that starts stretched, compressed or sheared by 25 to 40 %, six cases each of the four laws, 0.3 s: with the largest step 18 of 24
/// diverge, with half of it 10, with this 6, all of them of the logarithmic and the fibrous law.
const LARGE_STRAIN: f64 = 0.3;

/// A free piece that falls with at least this fraction of gravity falls well enough.
const NEARLY_FREE_FALL: f64 = 0.98;

/// A scene that can run.
#[derive(Debug)]
pub struct SceneFile {
    /// What its file holds.
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
    let names: Vec<String> = crate::listing::files_in(&folder, "toml")
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
    /// Reads and builds the scene at `path`, without what is named (`friction`, `lonor`); the error is a sentence per line.
    pub fn open(path: &Path, overrides: &[Override], without: &[String]) -> Result<Self, String> {
        let loaded = settings::load_scene(path, overrides).map_err(|e| e.to_string())?;
        let document = &loaded.document;
        let folder = path.parent().unwrap_or(Path::new(""));
        let described = scene_spec(&loaded.settings, &mut |file| {
            settings::read_regular(&folder.join(file))
        });
        let mut described = described.map_err(|e| placed(document, e))?;
        let left_out = |what: &str| without.iter().any(|named| named == what);
        if left_out("lonor") {
            described.spec.cuts.clear();
            let bodies = described.spec.bodies.iter_mut();
            bodies.for_each(|body| body.tear_strains.clear());
        }
        if left_out("friction") {
            let contacts = described.spec.contacts.iter_mut();
            contacts.for_each(|contact| contact.friction = 0.0);
        }
        let mut warnings: Vec<String> = described
            .notes
            .iter()
            .map(|note| format!("{}: {note}", path.display()))
            .collect();
        let bodies = &loaded.settings.body;
        warnings.extend(check_bodies(document, bodies, &described.spec)?);
        let scene = Scene::new(&described.spec)
            .map_err(|e| blame(document, &e, bodies, &described.spec))?;
        let runner = Runner::new(&loaded.settings, scene).map_err(|error: ProbeError| {
            let key = KeyPath::root().key("probe").at(error.probe).key("nodes");
            format!("{}: {error}", document.place(&key))
        })?;
        let step_too_long = step_too_long(document, &runner);
        if step_too_long.is_none() {
            warnings.extend(step_under_strain(document, &runner, bodies));
        }
        Ok(Self {
            spec: described.spec,
            runner,
            warnings,
            step_too_long,
            loaded,
        })
    }
}

impl SceneFile {
    /// Whether it should have come to rest and has not.
    pub fn restless(&self) -> bool {
        self.loaded.settings.run.end == settings::End::Rest
            && self.runner.end() == Some(&End::Duration)
    }

    /// Whether it is to diverge and has done so.
    pub fn diverged_as_expected(&self) -> bool {
        self.loaded.settings.run.end == settings::End::Divergence
            && matches!(self.runner.end(), Some(End::Diverged(_)))
    }

    /// Whether it is to diverge and has not.
    pub fn stable_unexpectedly(&self) -> bool {
        self.loaded.settings.run.end == settings::End::Divergence
            && self.runner.end() == Some(&End::Duration)
    }

    /// That it has not come to rest, and what helps.
    pub fn restless_sentence(&self) -> String {
        format!(
            "Does not rest within {}: give it a longer duration, drag, or a larger rest_speed",
            settings::Unit::Time.describe(self.loaded.settings.run.duration)
        )
    }

    /// What else should be known of how the run went: that it gains energy, that steps were shortened, or that cut pieces fall too slowly.
    pub fn run_sentences(&self) -> Vec<String> {
        let growth = self.runner.energy_growth().map(|growth| {
            format!(
                "Gains energy though nothing does work on it: {:.3} times what there was, since {}. What the run shows is the integrator's: use a shorter step, relaxation_time, or method.name = \"implicit-euler\" or \"sdirk2\"",
                growth.factor,
                settings::Unit::Time.describe(growth.since)
            )
        });
        let stiffened = self.runner.remarks().stiffened.map(|stiffened| {
            format!(
                "Tissue stiffened as it was stretched or flowed: since {} steps were shortened in {} ticks, from {} to {} at the shortest",
                settings::Unit::Time.describe(stiffened.since),
                stiffened.ticks,
                microseconds(self.runner.step()),
                microseconds(stiffened.shortest_step)
            )
        });
        let slow = self.slow_pieces();
        growth.into_iter().chain(stiffened).chain(slow).collect()
    }

    /// That pieces that were cut off fall more slowly than they would, as the inertia that explicit methods give nodes at a cut has no
    /// weight; a sentence for each body.
    fn slow_pieces(&self) -> Vec<String> {
        let scene = self.runner.scene();
        let of_body = |body: BodyView<'_>| {
            let (masses, added) = (body.masses(), body.model().added_inertia());
            let mut pieces = vec![(0.0, 0.0, false); body.piece_count() as usize];
            for (node, piece) in body.pieces().iter().enumerate() {
                let (mass, inertia, held) = &mut pieces[*piece as usize];
                *mass += masses[node];
                *inertia += masses[node] + added[node];
                *held |= body.model().is_clamped(node);
            }
            let free = pieces.iter().filter(|(mass, _, held)| !held && *mass > 0.0);
            let slowest = free
                .map(|(mass, inertia, _)| mass / inertia)
                .fold(1.0, f64::min);
            (slowest < NEARLY_FREE_FALL).then(|| {
                format!(
                    "Pieces cut from body '{}' fall with {:.0} % of gravity at the slowest: the inertia that {} needs at small elements of a cut has no weight. Use an implicit method where the fall matters",
                    body.name(),
                    100.0 * slowest,
                    scene.method().name()
                )
            })
        };
        scene.bodies().filter_map(of_body).collect()
    }

    /// Whole steps of the run before a body diverged, as far as containment did not divide them.
    pub fn step_of(&self, diverged: &Diverged) -> u64 {
        (diverged.time / self.runner.step()).round() as u64
    }
}

/// The shapes of a level's tools that can be read.
pub fn models_of(
    installation: &Installation,
    level: &settings::Level,
) -> BTreeMap<String, settings::Tool> {
    let model = |slot: &settings::ToolSlot| {
        let model = settings::load_tool(&installation.tool_file(&slot.model)).ok()?;
        Some((slot.model.clone(), model.settings))
    };
    level.tool.iter().filter_map(model).collect()
}

/// Looks at the bodies of a level as a scene would be looked at: meshes, materials, method, step. Gives what should be
/// known; the error is a sentence per line. Meshes are those of a folder.
pub fn check_level(
    level: &Loaded<settings::Level>,
    models: &BTreeMap<String, settings::Tool>,
    folder: &Path,
    meshes: Meshes,
) -> Result<Vec<String>, String> {
    let (document, of) = (&level.document, &level.settings);
    let (Some(physics), Some(method)) = (&of.physics, &of.method) else {
        return Ok(Vec::new());
    };
    // Without the tools' shapes there is nothing that could touch.
    let known = of.tool.iter().all(|slot| models.contains_key(&slot.model));
    let parts = LevelParts {
        physics,
        method,
        bodies: &of.body,
        rigid: &of.rigid,
        contacts: if known { &of.contact } else { &[] },
        cuts: if known { &of.cut } else { &[] },
        tools: if known { &of.tool } else { &[] },
        models,
    };
    let path = document.path();
    let described = level_spec(&parts, &mut |file| {
        settings::read_regular(&folder.join(file))
    });
    let described = described.map_err(|e| placed(document, e))?;
    let notes = described.notes.iter();
    let mut warnings: Vec<String> = notes
        .map(|note| format!("{}: {note}", path.display()))
        .collect();
    warnings.extend(check_bodies(document, &of.body, &described.spec)?);
    let scene =
        Scene::new(&described.spec).map_err(|e| blame(document, &e, &of.body, &described.spec))?;
    let steps = KeyPath::root().key("clock").key("steps");
    scene
        .check_step(of.clock.tick, of.clock.steps)
        .map_err(|e| format!("{}: {e}", document.place(&steps)))?;
    let step = of.clock.tick / f64::from(of.clock.steps);
    warnings.extend(working_step::warnings(
        &document.place(&steps),
        step,
        &scene,
    ));
    if meshes == Meshes::Estimated {
        warnings.extend(discretisation::warnings(document, &described.spec, &scene));
    }
    Ok(warnings)
}

fn placed(document: &Document, FromSettingsError { key, cause }: FromSettingsError) -> String {
    format!("{}: {cause}", document.place(&key))
}

/// Defects of meshes from files, which may hold anything, and materials that lock: what should be known, or errors.
fn check_bodies(
    document: &Document,
    bodies: &[settings::Body],
    spec: &SceneSpec,
) -> Result<Vec<String>, String> {
    let (mut errors, mut warnings) = (Vec::new(), Vec::new());
    for (index, (body, of)) in bodies.iter().zip(&spec.bodies).enumerate() {
        let key = KeyPath::root().key("body").at(index);
        if body.generator == settings::Generator::File {
            let (bad, odd) = mesh_defects(&of.mesh, &body.detached);
            let place = document.place(&key.key("file"));
            errors.extend(bad.iter().map(|defect| format!("{place}: {defect}")));
            warnings.extend(odd.iter().map(|defect| format!("{place}: {defect}")));
            warnings.extend(too_large(&of.mesh).map(|sentence| format!("{place}: {sentence}")));
        }
        for (m, material) in body.material.iter().enumerate() {
            let Some(poisson) = material.poisson_ratio else {
                continue;
            };
            let locks = of.materials.iter().any(|(region, of)| {
                let own = material.region.is_none_or(|own| own == *region);
                match of.behaviour {
                    Behaviour::Continuum(constants) => {
                        let same = constants.poisson == poisson;
                        own && same && constants.discretisation.locks(poisson)
                    }
                    Behaviour::Springs(_) => false,
                }
            });
            if locks {
                let key = key.key("material").at(m).key("poisson_ratio");
                warnings.push(format!(
                    "{}: these tetrahedra lock at a Poisson's ratio of {poisson}, the body is too stiff: use discretisation = \"selective\"; \"patch-pressure\" and \"nodal-pressure\" do not lock either, but stay too stiff in bending on a coarse mesh",
                    document.place(&key)
                ));
            }
        }
    }
    match errors.is_empty() {
        true => Ok(warnings),
        false => Err(errors.join("\n")),
    }
}

/// That a mesh is larger than any length that files may state, which is that of its units.
fn too_large(mesh: &TetMesh) -> Option<String> {
    let extent = (0..3).map(|axis| {
        let along = mesh.positions.iter().map(|p| p[axis]);
        let (low, high) = along.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
            (low.min(x), high.max(x))
        });
        high - low
    });
    let size = extent.fold(0.0, f64::max);
    (size > settings::LENGTH_MAX).then(|| {
        format!(
            "the mesh is {} long: give with `scale` how long one unit of the file is, such as scale = \"1 mm\"",
            settings::Unit::Length.describe(format!("{size:.3e}").parse().unwrap_or(size))
        )
    })
}

/// What makes a mesh with these detached regions useless, and what should be known of it; of each at most a screenful.
pub fn mesh_defects(mesh: &TetMesh, detached: &[u32]) -> (Vec<String>, Vec<String>) {
    let found = defects_but_detached(mesh, detached);
    let list = |severity: Severity| {
        let all: Vec<String> = found
            .iter()
            .filter(|defect| defect.severity() == severity)
            .map(ToString::to_string)
            .collect();
        shortened(all)
    };
    (list(Severity::Error), list(Severity::Warning))
}

/// The first of many sentences, and how many there are besides.
pub fn shortened(mut sentences: Vec<String>) -> Vec<String> {
    if let Some(more) = sentences.len().checked_sub(PRINTED + 1) {
        sentences.truncate(PRINTED);
        sentences.push(format!("and {} more of the kind", more + 1));
    }
    sentences
}

/// The step if it is longer than the bodies allow, and what helps; not of a scene that is to diverge.
fn step_too_long(document: &Document, runner: &Runner) -> Option<String> {
    if document.value()["run"]["end"] == settings::End::Divergence.name() {
        return None;
    }
    let scene = runner.scene();
    let slowest = (0..scene.body_count()).min_by(|a, b| {
        scene
            .body(*a)
            .stable_step()
            .total_cmp(&scene.body(*b).stable_step())
    })?;
    let stable = scene.body(slowest).stable_step();
    (runner.step() > stable).then(|| {
        format!(
            "{}: a step of {} is beyond what {} allows for body '{}', {}: use a shorter step or an implicit method",
            document.place(&KeyPath::root().key("run").key("step")),
            microseconds(runner.step()),
            scene.method().name(),
            scene.body(slowest).name(),
            microseconds(stable),
        )
    })
}

/// That the step is stable at rest and not in large strain, as its law does not hold there: a sentence for each material.
fn step_under_strain(
    document: &Document,
    runner: &Runner,
    bodies: &[settings::Body],
) -> Vec<String> {
    let scene = runner.scene();
    if !scene.method().is_explicit() {
        return Vec::new();
    }
    let mut sentences = Vec::new();
    for (body, of) in bodies.iter().zip(scene.bodies()) {
        let laws = body
            .material
            .iter()
            .filter_map(|material| match material.law {
                settings::Law::Continuum(law) if !law.is_stable_in_large_strain() => Some(law),
                _ => None,
            });
        let limit = LARGE_STRAIN * of.stable_step();
        for law in laws.take(1).filter(|_| runner.step() > limit) {
            sentences.push(format!(
                "{}: a step of {} is stable for body '{}' at small strain, but with the law {} may diverge at strains from 25 % on: use {} where it is strained so far, or the law stable-neo-hookean",
                document.place(&KeyPath::root().key("run").key("step")),
                microseconds(runner.step()),
                body.name,
                law.name(),
                microseconds(limit),
            ));
        }
    }
    sentences
}

/// Why a scene cannot be built, with the key that is to blame.
fn blame(
    document: &Document,
    error: &SceneError,
    bodies: &[settings::Body],
    spec: &SceneSpec,
) -> String {
    let place = document.place(&key_of(error, bodies));
    if let (SceneError::Couple { body, .. }, Some([from, to])) = (error, error.uncoupled()) {
        let of = spec.bodies.iter().find(|of| of.name == *body);
        if of.is_some_and(|of| share_nodes(&of.mesh, from, to)) {
            return format!(
                "{place}: regions {from} and {to} of body '{body}' have common nodes, which joins them already: leave the coupling out, or give each region nodes of its own (`detached`)"
            );
        }
    }
    format!("{place}: {error}")
}

/// Whether two regions of a mesh have a node in common.
fn share_nodes(mesh: &TetMesh, one: u32, other: u32) -> bool {
    let nodes = |region: u32| -> Vec<u32> {
        let tets = mesh.tets.iter().zip(&mesh.regions);
        let of = tets.filter(|(_, r)| **r == region);
        let mut nodes: Vec<u32> = of.flat_map(|(tet, _)| *tet).collect();
        nodes.sort_unstable();
        nodes
    };
    let others = nodes(other);
    nodes(one)
        .iter()
        .any(|node| others.binary_search(node).is_ok())
}

/// The key that is to blame for a scene that cannot be built.
fn key_of(error: &SceneError, bodies: &[settings::Body]) -> KeyPath {
    let root = KeyPath::root();
    let body = |name: &str| {
        let index = bodies.iter().position(|body| body.name == name);
        root.key("body").at(index.unwrap_or_default())
    };
    match error {
        SceneError::Build { body: name, source } => match source {
            BuildError::Material { region, .. }
            | BuildError::PrestretchedSprings { region }
            | BuildError::Direction { region, .. }
            | BuildError::Plasticity { region }
            | BuildError::YieldsAtRest { region, .. }
            | BuildError::Region { region, .. } => {
                let of = bodies.iter().find(|body| body.name == *name);
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
        SceneError::Prestretch { body: name, .. } => body(name).key("layer"),
        SceneError::Couple { body: name, .. } => {
            let of = bodies.iter().find(|body| body.name == *name);
            let regions = error.uncoupled();
            let index = of.and_then(|of| {
                of.coupling
                    .iter()
                    .position(|c| Some([c.from, c.to]) == regions)
            });
            match index {
                Some(index) => body(name).key("coupling").at(index),
                None => body(name).key("coupling"),
            }
        }
        SceneError::Value {
            body: name,
            what,
            index,
            ..
        } if !["origin", "cutting"].contains(what) => body(name).key(what).at(*index),
        SceneError::Contacts { index, .. } => root.key("contact").at(*index),
        SceneError::Cuts { index, .. } => root.key("cut").at(*index),
        SceneError::HeldTwice { body: name, clamps } => body(name).key("clamp").at(clamps[1]),
        SceneError::NeverStable { .. } => root.key("method").key("name"),
        SceneError::Name { .. } => root.key("body"),
        _ => root,
    }
}
