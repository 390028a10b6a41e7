//! `microsim check`.

use crate::cli::{CheckArgs, Place};
use crate::discretisation::{self, Meshes};
use crate::listing::{files_below, files_in};
use crate::mesh_file;
use crate::output::{Exit, Problem, print_if_read as print};
use crate::progress::Progress;
use crate::scene_file::{self, SceneFile};
use crate::session_file::{installation, is_session};
use crate::working_step;
use microsim_host::assemble::{
    ASSETS, Assets, Input, Installation, OF_STATION, Request, assemble, check_library,
    known_metrics,
};
use microsim_host::record::Session;
use microsim_host::run::RunError;
use microsim_host::{Engine, loader};
use microsim_settings::{self as settings, Level, Loaded, Override};
use serde_json::json;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// What was looked at, and what is wrong with it.
#[derive(Default)]
struct Findings {
    checked: Vec<String>,
    problems: Vec<String>,
    /// What is not wrong, but should be known.
    warnings: Vec<String>,
    /// What is so: asked for by name only.
    statements: Vec<String>,
}

impl Findings {
    fn note(&mut self, what: String, result: Result<Vec<String>, String>) {
        match result {
            Ok(warnings) => self.warnings.extend(warnings),
            // A plugin that several levels use is to be blamed once.
            Err(problem) if self.problems.contains(&problem) => {}
            Err(problem) => self.problems.push(problem),
        }
        self.checked.push(what);
    }
}

/// Validates files, or the whole installation.
pub fn check(place: &Place, args: &CheckArgs) -> Result<Exit, Problem> {
    let mut findings = Findings::default();
    if args.paths.is_empty() {
        check_installation(&installation(place)?, &mut findings);
    } else {
        for path in &args.paths {
            if path.is_dir() {
                check_folder(place, path, &mut findings);
            } else {
                let checked = check_file(place, path, &mut findings.statements);
                findings.note(path.display().to_string(), checked);
            }
        }
    }
    if args.json {
        let document = json!({
            "checked": findings.checked,
            "problems": findings.problems,
            "warnings": findings.warnings,
            "statements": findings.statements,
        });
        print(format!("{document:#}"))?;
    } else {
        for statement in &findings.statements {
            print(statement)?;
        }
        for warning in &findings.warnings {
            print(format!("warning: {warning}"))?;
        }
        for problem in &findings.problems {
            print(problem)?;
        }
        print(format!(
            "{} checked, {} with problems",
            findings.checked.len(),
            findings.problems.len()
        ))?;
    }
    Ok(if findings.problems.is_empty() {
        Exit::Done
    } else {
        Exit::Negative
    })
}

fn check_installation(installation: &Installation, findings: &mut Findings) {
    for complaint in &installation.complaints {
        findings.problems.push(complaint.to_string());
    }
    check_libraries(installation, findings);
    let config = &installation.config;
    // Shipped files count too where those of this station take their place: others use the same installation.
    let replaced = installation.replaced();
    let shipped = OF_STATION.iter().map(|name| config.join(name));
    for path in shipped.chain(replaced) {
        findings.note(path.display().to_string(), check_setting(&path));
    }
    findings.warnings.extend(not_replaced(installation));
    findings.warnings.extend(idle_clutches(installation));
    for path in files_in(&config.join("tools"), "toml") {
        let tool = settings::load_tool(&path);
        findings.note(
            path.display().to_string(),
            tool.map(nothing).map_err(|e| e.to_string()),
        );
    }
    for path in files_in(&config.join("vessels"), "toml") {
        let vessel = settings::load_vessel(&path);
        findings.note(
            path.display().to_string(),
            vessel.map(nothing).map_err(|e| e.to_string()),
        );
    }
    for path in files_in(&config.join("courses"), "toml") {
        findings.note(
            path.display().to_string(),
            check_course(installation, &path),
        );
    }
    let scenes = files_in(&config.join("scenes"), "toml");
    let levels = installation.tree.modules.iter().map(|m| m.levels.len());
    let count = (levels.sum::<usize>() + scenes.len()) as f64;
    let (progress, mut done) = (Progress::new(), 0.0);
    let mut show = |path: &Path| {
        progress.show(Some(done / count), || {
            format!("checking {}", path.display())
        });
        done += 1.0;
    };
    for path in scenes {
        show(&path);
        findings.note(
            path.display().to_string(),
            check_scene(&path, Meshes::Stated, &mut Vec::new()),
        );
    }
    let chart = config.join("chart.toml");
    if chart.is_file() {
        findings.note(chart.display().to_string(), check_chart(&chart));
    }
    for folder in &installation.tree.modules {
        let name = &folder.manifest.settings.name;
        let scripts = folder.manifest.document.path().with_file_name("scripts");
        let scripts = files_in(&scripts, "toml");
        let (variants, errors) = installation.variants(folder);
        for error in errors {
            findings.note(error.file.clone(), Err(error.to_string()));
        }
        for (index, path) in folder.levels.iter().enumerate() {
            show(path);
            let level = index as u32 + 1;
            let script = scripts.iter().find(|s| {
                s.file_name()
                    .is_some_and(|n| n == format!("level{level}-pass.toml").as_str())
            });
            findings.note(
                path.display().to_string(),
                check_level(installation, name, level, None, script),
            );
            for variant in variants.iter().filter(|of| of.level == level) {
                findings.note(
                    variant.path.display().to_string(),
                    check_level(installation, name, level, Some(&variant.name), script),
                );
            }
        }
        for path in &scripts {
            let script = settings::load_script(path);
            findings.note(
                path.display().to_string(),
                script.map(nothing).map_err(|e| e.to_string()),
            );
        }
    }
    for path in recordings(&installation.root.join("assets").join("recordings")) {
        findings.note(
            path.display().to_string(),
            check_recording(installation, &path),
        );
    }
}

/// What lies among the settings of the station as if it took the place of something shipped, and does not.
fn not_replaced(installation: &Installation) -> Vec<String> {
    let station = installation.station.as_ref();
    let Some(station) = station.filter(|station| **station != installation.config) else {
        return Vec::new();
    };
    let entries = std::fs::read_dir(&installation.config)
        .into_iter()
        .flatten();
    let mut names: Vec<_> = entries.flatten().map(|entry| entry.file_name()).collect();
    names.sort();
    let others = names
        .iter()
        .filter(|name| !OF_STATION.iter().any(|replaced| *name == replaced));
    let there = others
        .map(|name| station.join(name))
        .filter(|path| path.exists());
    let sentence = |path: PathBuf| {
        format!(
            "{}: not used: a station may replace {} alone; `--config` names a whole folder",
            path.display(),
            OF_STATION.join(", ")
        )
    };
    there.map(sentence).collect()
}

/// Tools that clutches of this station hold and that no level has, and clutches that drive a tool of a level by their own name.
fn idle_clutches(installation: &Installation) -> Vec<String> {
    let path = installation.setting("translator.toml");
    let Ok(translator) = settings::load_translator(&path) else {
        // Complained of where it is checked.
        return Vec::new();
    };
    let mut slots = BTreeSet::new();
    for folder in &installation.tree.modules {
        let name = &folder.manifest.settings.name;
        let levels = (1..).zip(&folder.levels);
        let levels = levels.filter_map(|(number, _)| installation.level(name, number).ok());
        for level in levels {
            slots.extend(level.settings.tool.iter().map(|slot| slot.name.clone()));
        }
    }
    let mut found = Vec::new();
    let clutches = translator.settings.clutch.iter().enumerate();
    for (index, clutch) in clutches {
        let key = settings::KeyPath::root().key("clutch").at(index);
        let mut warn = |field: &str, sentence: String| {
            let place = translator.document.place(&key.key(field));
            found.push(format!("{place}: {sentence}"));
        };
        let idle = clutch.tool.iter().filter(|tool| !slots.contains(*tool));
        for tool in idle {
            warn(
                "tool",
                format!("no level has a tool `{tool}`, which the clutch would hold"),
            );
        }
        if slots.contains(&clutch.device) {
            warn(
                "device",
                format!(
                    "`{}` drives the tool of its own name as well",
                    clutch.device
                ),
            );
        }
    }
    found
}

/// A file of those that a station may replace.
fn check_setting(path: &Path) -> Result<Vec<String>, String> {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let checked = match name.as_ref() {
        "host.toml" => settings::load_host(path).map(nothing),
        "translator.toml" => settings::load_translator(path).map(nothing),
        "openigtlink.toml" => settings::load_openigtlink(path).map(nothing),
        "desktop.toml" => settings::load_desktop(path).map(nothing),
        "window.toml" => settings::load_window(path).map(nothing),
        _ => settings::load_trainees(path).map(nothing),
    };
    checked.map_err(|e| e.to_string())
}

/// Opens the library of every plugin and module that is installed, in a process of its own.
fn check_libraries(installation: &Installation, findings: &mut Findings) {
    for (manifest, checked) in libraries(installation) {
        findings.note(manifest, checked.map(nothing));
    }
}

/// Every plugin and module with what is wrong with its library.
pub fn libraries(installation: &Installation) -> Vec<(String, Result<(), String>)> {
    let tree = &installation.tree;
    let modules = tree.modules.iter().map(|folder| &folder.manifest);
    let manifests = tree.plugins.iter().chain(modules);
    let checked = manifests.map(|manifest| {
        let path = manifest.document.path().display().to_string();
        let checked = check_library(installation, manifest);
        (path, checked.map_err(|e| e.to_string()))
    });
    checked.collect()
}

/// Builds a scene without running it.
fn check_scene(
    path: &Path,
    meshes: Meshes,
    statements: &mut Vec<String>,
) -> Result<Vec<String>, String> {
    let scene = SceneFile::open(path, &[], &[])?;
    if let Some(sentence) = scene.step_too_long {
        return Err(sentence);
    }
    let document = &scene.loaded.document;
    let mut warnings = scene.warnings;
    let place = document.place(&settings::KeyPath::root().key("run").key("step"));
    let (step, of) = (scene.runner.step(), scene.runner.scene());
    warnings.extend(working_step::warnings(&place, step, of));
    if meshes == Meshes::Estimated {
        let stated = working_step::statements(&scene.spec, scene.runner.scene());
        statements.extend(stated.map_err(|e| e.to_string())?);
        warnings.extend(discretisation::warnings(
            document,
            &scene.spec,
            scene.runner.scene(),
        ));
    }
    Ok(warnings)
}

/// Reads a course, whose levels have to be installed.
fn check_course(installation: &Installation, path: &Path) -> Result<Vec<String>, String> {
    let course = settings::load_course(path).map_err(|e| e.to_string())?;
    let unknown = course
        .settings
        .step
        .iter()
        .enumerate()
        .filter_map(|(at, step)| {
            let missing = installation.level(&step.module, step.level).err()?;
            let key = settings::KeyPath::root().key("step").at(at);
            Some(format!("{}: {missing}", course.document.place(&key)))
        });
    let unknown: Vec<String> = unknown.collect();
    match unknown.is_empty() {
        true => Ok(Vec::new()),
        false => Err(unknown.join("\n")),
    }
}

/// Reads the plan of the chart, and each of its scenes with the meshes and parameters that it names.
fn check_chart(path: &Path) -> Result<Vec<String>, String> {
    let chart = settings::load_chart(path).map_err(|e| e.to_string())?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut problems = Vec::new();
    for scene in &chart.settings.scene {
        let file = folder.join(&scene.file);
        let resolutions = scene.resolution.iter().map(|r| (&r.name, &r.set));
        let variants = scene.variant.iter().map(|v| (&v.name, &v.set));
        for (name, set) in resolutions.chain(variants) {
            let overrides: Result<Vec<_>, _> = set.iter().map(|t| Override::parse(t)).collect();
            let loaded = overrides.and_then(|overrides| {
                settings::load_scene(&file, &overrides).map_err(|e| e.to_string())
            });
            let at = || format!("{}: scene `{}`, `{name}`", path.display(), scene.name);
            match loaded {
                Err(error) => problems.push(format!("{}: {error}", at())),
                Ok(loaded) => {
                    let probes = &loaded.settings.probe;
                    let unknown = |m: &&settings::ChartMeasure| {
                        probes.iter().all(|probe| probe.name != m.probe)
                    };
                    let missing = scene.measure.iter().filter(unknown);
                    problems.extend(
                        missing.map(|m| format!("{}: the scene has no probe `{}`", at(), m.probe)),
                    );
                }
            }
        }
    }
    match problems.is_empty() {
        true => Ok(Vec::new()),
        false => Err(problems.join("\n")),
    }
}

/// Files in TOML that are none of ours.
const OF_CARGO: [&str; 6] = [
    "Cargo.toml",
    "clippy.toml",
    "deny.toml",
    "rust-toolchain.toml",
    "rustfmt.toml",
    ".rustfmt.toml",
];

/// All files of a folder and those below it that are of a kind that is known.
fn check_folder(place: &Place, folder: &Path, findings: &mut Findings) {
    let before = findings.checked.len();
    for path in files_below(folder) {
        let extension = path.extension().unwrap_or_default().to_string_lossy();
        // What cargo and its tools read, beside the sources of a module.
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        if OF_CARGO.contains(&&*name) {
            continue;
        }
        // The two files of a TetGen mesh are checked together.
        let half = extension == "node" && path.with_extension("ele").is_file();
        let known = match extension.as_ref() {
            "toml" | "session" | "glb" | "gltf" => true,
            "csv" => path.with_extension("toml").is_file(),
            _ => mesh_file::is_mesh(&path),
        };
        if known && !half {
            let checked = check_file(place, &path, &mut findings.statements);
            findings.note(path.display().to_string(), checked);
        }
    }
    if findings.checked.len() == before {
        let problem = format!(
            "{}: nothing in this folder that could be checked",
            folder.display()
        );
        findings.note(folder.display().to_string(), Err(problem));
    }
}

/// Loads everything that the level uses and initialises it, as a run would, without a single tick: libraries, layouts,
/// manifests, topics, set-ups, stable steps.
fn check_level(
    installation: &Installation,
    module: &str,
    level: u32,
    variant: Option<&str>,
    script: Option<&PathBuf>,
) -> Result<Vec<String>, String> {
    let loaded = installation
        .variant(module, level, variant)
        .map_err(|e| e.to_string())?;
    let folder = installation.module(module).map_err(|e| e.to_string())?;
    let models = scene_file::models_of(installation, &loaded.settings);
    let folder = folder.level_folder();
    let warnings = scene_file::check_level(&loaded, &models, &folder, Meshes::Stated)?;
    let script = script.ok_or_else(|| {
        format!("module \"{module}\": level {level} has no script scripts/level{level}-pass.toml that passes it")
    })?;
    let request = Request {
        module: module.into(),
        level,
        variant: variant.map(str::to_owned),
        input: Input::Script(script.clone()),
        hand: None,
        seed: 1,
        without: Vec::new(),
        pictures: false,
        session: PathBuf::new(),
    };
    let plan = assemble(installation, &request).map_err(|e| e.to_string())?;
    let place = format!("module \"{module}\", level {level}");
    let engine = Engine::new(&plan, plan.limits(), None, |planned| {
        loader::load(planned).map(Some).map_err(RunError::from)
    });
    let mut engine = engine.map_err(|e| format!("{place}: {e}"))?;
    match engine.stop().first() {
        Some(failure) => Err(format!("{place}: {failure}")),
        None => Ok(warnings),
    }
}

fn check_recording(installation: &Installation, path: &Path) -> Result<Vec<String>, String> {
    let checked = microsim_host::assemble::check_recording(installation, path);
    checked.map(nothing).map_err(|e| e.to_string())
}

/// Nothing to be known.
fn nothing<T>(_: T) -> Vec<String> {
    Vec::new()
}

/// One file by what it is: its place and name give the kind, or else what stands in it.
fn check_file(
    place: &Place,
    path: &Path,
    statements: &mut Vec<String>,
) -> Result<Vec<String>, String> {
    if !path.exists() {
        return Err(format!("{}: no such file", path.display()));
    }
    let text = |e: settings::ConfigErrors| e.to_string();
    let name = path
        .file_name()
        .map(|n| n.to_string_lossy().into_owned())
        .unwrap_or_default();
    let folder = path
        .parent()
        .and_then(Path::file_name)
        .map(|n| n.to_string_lossy().into_owned());
    let extension = path
        .extension()
        .map(|e| e.to_string_lossy().into_owned())
        .unwrap_or_default();
    match (name.as_str(), folder.as_deref(), extension.as_str()) {
        ("plugin.toml" | "module.toml", _, _) => {
            settings::load_manifest(path).map(nothing).map_err(text)
        }
        (name, _, _) if OF_STATION.contains(&name) => check_setting(path),
        ("calibration.toml", _, _) => settings::load_calibration(path)
            .map(|_| Vec::new())
            .map_err(text),
        ("chart.toml", _, _) => check_chart(path),
        (_, Some("tools"), "toml") => settings::load_tool(path).map(nothing).map_err(text),
        (_, Some("courses"), "toml") => settings::load_course(path).map(nothing).map_err(text),
        (_, Some("vessels"), "toml") => settings::load_vessel(path).map(nothing).map_err(text),
        (_, Some("scenes"), "toml") => check_scene(path, Meshes::Estimated, statements),
        (_, Some("scripts"), "toml") => settings::load_script(path).map(nothing).map_err(text),
        (_, Some("levels"), "toml") => {
            let manifest = path
                .parent()
                .and_then(Path::parent)
                .map(|m| m.join("module.toml"));
            let manifest = settings::load_manifest(&manifest.unwrap_or_default()).map_err(text)?;
            let vessels = scene_file::folder(place).map_err(|problem| match problem {
                Problem::Text(text) => text,
                Problem::BrokenPipe => String::new(),
            });
            let vessels = vessels?.with_file_name("vessels");
            let manifest = &manifest.settings;
            let level = settings::load_level_with(path, manifest, &known_metrics(), &vessels);
            let level = level.map_err(text)?;
            check_assets(place, path, &level)?;
            let folder = path.parent().unwrap_or(Path::new(""));
            scene_file::check_level(&level, &BTreeMap::new(), folder, Meshes::Estimated)
        }
        (_, _, "toml") if path.with_extension("csv").is_file() => {
            settings::load_recording_map(&path.with_extension("csv"))
                .map(nothing)
                .map_err(text)
        }
        (_, _, "csv") => match installation(place) {
            Ok(installation) => check_recording(&installation, path),
            Err(Problem::Text(text)) => Err(text),
            Err(Problem::BrokenPipe) => Ok(Vec::new()),
        },
        (_, _, "toml") => {
            // Scenes, charts and scripts may lie anywhere.
            match settings::guess_kind(&std::fs::read_to_string(path).unwrap_or_default()) {
                Some("scene") => check_scene(path, Meshes::Estimated, statements),
                Some("chart") => check_chart(path),
                _ => settings::load_script(path).map(nothing).map_err(text),
            }
        }
        (_, _, "session") => check_session(path),
        (_, _, "glb" | "gltf" | "png") => Assets::check(path).map(nothing),
        _ if is_session(path) => check_session(path),
        _ if mesh_file::is_mesh(path) => mesh_file::check(path),
        _ => Err(format!(
            "{}: neither TOML, CSV, a mesh, a model, a texture nor a session",
            path.display()
        )),
    }
}

/// The files of models and textures that a level in a file by itself names.
fn check_assets(place: &Place, path: &Path, level: &Loaded<Level>) -> Result<(), String> {
    if level.settings.object_files().is_empty() {
        return Ok(());
    }
    let module = path.parent().and_then(Path::parent);
    let own = module.unwrap_or(Path::new("")).join(ASSETS);
    let root = installation(place).map_err(|problem| match problem {
        Problem::Text(text) => text,
        Problem::BrokenPipe => String::new(),
    });
    let folders = [own, root?.root.join(ASSETS)];
    let read = Assets::read(&folders, level);
    read.map(drop).map_err(|e| e.to_string())
}

fn check_session(path: &Path) -> Result<Vec<String>, String> {
    let name = path.display();
    let bytes = settings::read_regular(path).map_err(|e| format!("{name}: {e}"))?;
    let session = Session::read(&bytes).map_err(|e| format!("{name}: {e}"))?;
    let ticks = session.ticks.len();
    match (session.complaint, session.failures.first()) {
        (Some(complaint), _) => Err(format!(
            "{name}: {complaint}; {ticks} complete ticks can be used"
        )),
        (None, Some(failure)) => Err(format!(
            "{name}: {failure}; {ticks} complete ticks can be used"
        )),
        (None, None) => Ok(Vec::new()),
    }
}

/// The CSV files below the folder of recordings.
fn recordings(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder)
        .into_iter()
        .flatten()
        .filter_map(Result::ok);
    let mut folders: Vec<PathBuf> = entries.map(|e| e.path()).filter(|p| p.is_dir()).collect();
    folders.sort();
    folders.iter().flat_map(|f| files_in(f, "csv")).collect()
}
