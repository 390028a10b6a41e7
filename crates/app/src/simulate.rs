//! `microsim simulate`: a scene from start to end, and what came out.

mod cpu;
mod document;
mod frames;
mod pictures;
mod pool;
mod probe_table;
mod table;

use crate::cli::{Place, SimulateArgs};
use crate::output::{Exit, Problem, print_if_read as print};
use crate::progress::Progress;
use crate::replace_file;
use crate::run::refuse_old_pictures;
use crate::scene_file::{SceneFile, find};
use crate::views;
use cpu::cpu_seconds;
use document::{Result as Outcome, document};
use frames::Frames;
use microsim_scene::{End, Executor, Serial};
use microsim_session::Chain;
use microsim_settings as settings;
use pictures::Pictures;
use pool::Pool;
use std::path::{Path, PathBuf};

/// Runs a scene.
pub fn simulate(place: &Place, args: &SimulateArgs) -> Result<Exit, Problem> {
    let given = args.scene.as_ref().ok_or(
        "no scene: name it before the options, as in `microsim simulate cantilever --json result.json`",
    )?;
    views::check_of_scene(&args.view)?;
    let path = find(place, given)?;
    let mut scene = SceneFile::open(&path, &args.set, &args.without)?;
    for warning in &scene.warnings {
        tracing::warn!("{warning}");
    }
    match (&scene.step_too_long, args.any_step) {
        (Some(sentence), false) => {
            return Err(format!("{sentence} (--any-step runs it nevertheless)").into());
        }
        (Some(sentence), true) => tracing::warn!("{sentence}"),
        (None, _) => {}
    }
    let quiet = args.json.as_deref() == Some(Path::new("-"));
    if let Some(folder) = &args.frames {
        refuse_old_pictures(folder)?;
    }
    // A file that cannot be written is reported before the time is spent; the old one stays until there is a new one.
    let json_file = args.json.as_deref().filter(|_| !quiet);
    for file in json_file.into_iter().chain(args.csv.as_deref()) {
        replace_file::must_be_writable(file)?;
    }
    if !quiet {
        print(table::heading(&scene, &path))?;
    }

    let pool = match args.threads {
        1 => None,
        threads => Some(Pool::new(threads.into())?),
    };
    let exec: &dyn Executor = match &pool {
        Some(pool) => pool,
        None => &Serial,
    };
    let mut frames = match &args.vtu {
        Some(folder) => Some(Frames::new(&folder_of(folder, &path), &scene)?),
        None => None,
    };
    let mut pictures = match &args.frames {
        Some(folder) => Some(Pictures::new(folder, &scene, &args.view)?),
        None => None,
    };
    let progress = Progress::new();
    let mut cpu = 0.0;
    let (mut values, mut samples) = (Chain::new(), 0);
    loop {
        // What is measured and exported is not counted.
        let before = cpu_seconds();
        let sampled = {
            let _span = tracing::debug_span!("sample", number = samples).entered();
            scene.runner.compute(exec)
        };
        cpu += cpu_seconds() - before;
        let goes_on = sampled && scene.runner.observe();
        values.add(samples, [scene.runner.scene().digest().as_slice()]);
        samples += 1;
        let runner = &scene.runner;
        progress.show(Some(runner.progress()), || {
            let time = runner.scene().time();
            format!("{time:.4} s simulated, {cpu:.0} CPU s")
        });
        if let Some(frames) = &mut frames {
            frames.after_sample(&scene.runner)?;
        }
        if let Some(pictures) = &mut pictures {
            pictures.after_sample(&scene.runner)?;
        }
        if !goes_on {
            break;
        }
    }
    progress.clear();
    let files = frames.map(Frames::finish).transpose()?;
    let drawn = pictures.map(Pictures::finish);

    let outcome = Outcome {
        given: given.clone(),
        set: args.set.clone(),
        without: args.without.clone(),
        cpu_s: cpu,
        physics_digest: values.value(),
        threads: args.threads,
    };
    if args.json.is_some() {
        let document = format!("{:#}\n", document(&scene, &outcome));
        match json_file {
            None => print(document.trim_end())?,
            Some(file) => replace_file::replace(file, document.as_bytes())?,
        }
    }
    if let Some(file) = &args.csv {
        let text = probe_table::csv(&scene.loaded.settings.probe, scene.runner.series());
        replace_file::replace(file, text.as_bytes())?;
    }
    if !quiet {
        print(table::result(&scene, cpu))?;
        if let Some(sentence) = table::of_another_scene(&scene.runner, &args.set, &args.without) {
            print(sentence)?;
        }
        if let Some(file) = &args.json {
            print(format!("Everything in {}", file.display()))?;
        }
        if let Some(file) = &args.csv {
            print(format!("Series of the probes in {}", file.display()))?;
        }
        if let Some((folder, count)) = files {
            print(format!(
                "{count} meshes in {}; open the .pvd in ParaView",
                folder.display()
            ))?;
        }
        if let Some((folder, count)) = drawn {
            print(format!("{count} pictures in {}", folder.display()))?;
        }
    }
    let missed = scene.runner.verdicts().iter().any(|verdict| !verdict.met);
    let negative = match scene.loaded.settings.run.end {
        settings::End::Divergence => !scene.diverged_as_expected(),
        settings::End::Time | settings::End::Rest => {
            matches!(scene.runner.end(), Some(End::Diverged(_)))
                || scene.restless()
                || scene.runner.energy_growth().is_some()
        }
    };
    Ok(match negative || (args.require && missed) {
        true => Exit::Negative,
        false => Exit::Done,
    })
}

/// The folder for meshes: as given, or here and named after the scene.
fn folder_of(given: &Path, scene: &Path) -> PathBuf {
    if !given.as_os_str().is_empty() {
        return given.to_path_buf();
    }
    let mut name = scene.file_stem().unwrap_or_default().to_os_string();
    name.push("-vtu");
    name.into()
}
