//! `microsim tune`: the cheapest method, mesh and step that keep what a scene or level states, written into its file.

mod document;
mod edit;
mod level;

use crate::chart::{plan_path, thread_seconds};
use crate::cli::{Place, TuneArgs};
use crate::output::{Exit, Problem, complain, print, print_json};
use crate::progress::Progress;
use crate::replace_file::{must_be_writable, replace};
use crate::scene_file::{SceneFile, find};
use crate::session_file::{installation, program_folder};
use microsim_drawing::{percent, significant};
use microsim_scene::{Serial, scene_spec};
use microsim_settings::{
    self as settings, Chart, ChartScene, ExactKind, Expect, Override, in_words,
};
use microsim_study::{
    AsLevel, Candidates, Context, Goal, LoadedScene, Trial, TuneStep, Tuning, candidates, doubt,
    locking, measure, tune as choose,
};
use std::cell::RefCell;
use std::path::{Path, PathBuf};

/// What is tuned.
struct Target {
    /// The file that is written.
    path: PathBuf,
    /// What is measured.
    what: Measured,
    /// The folder of the vessels that its bodies name.
    vessels: PathBuf,
    /// How it is named on the command line.
    name: String,
}

/// What is being computed.
#[derive(Default)]
struct Now {
    what: String,
    /// Which part of all is over.
    part: Option<f64>,
}

/// What is measured.
enum Measured {
    /// The text of a scene.
    Scene(String),
    /// A level, as a scene that depends on the mesh.
    Level(level::Level),
}

impl Target {
    /// The scene with overrides; files of meshes lie in the folder of the target.
    fn load(&self, set: &[String]) -> Result<LoadedScene, String> {
        let file = self.path.display().to_string();
        let folder = self.path.parent().unwrap_or(Path::new(""));
        let load = |text: &str| load(text, &file, folder, &self.vessels, set);
        match &self.what {
            Measured::Scene(text) => load(text),
            Measured::Level(level) => {
                let text = level.scene(set).map_err(|e| format!("{file}: {e}"))?;
                load(&text)
            }
        }
    }

    /// What it demands if it is a level.
    fn as_level(&self) -> Option<AsLevel> {
        match &self.what {
            Measured::Scene(_) => None,
            Measured::Level(level) => Some(AsLevel {
                tick: level.tick,
                contact: level.contact,
                cuts: level.cuts,
            }),
        }
    }
}

/// Chooses, or verifies an earlier choice.
pub fn tune(place: &Place, args: &TuneArgs) -> Result<Exit, Problem> {
    let target = target(place, args)?;
    let out = out(place, args, &target)?;
    let plan = plan_path(place)?;
    let chart = settings::load_chart(&plan)?.settings;
    let file = target.path.display().to_string();
    let load = |_: &str, set: &[String]| target.load(set);
    // What `check` refuses is no ground to tune on.
    if let Measured::Scene(_) = target.what
        && let Some(sentence) = SceneFile::open(&target.path, &[], &[])?.step_too_long
    {
        return Err(sentence.into());
    }
    let scene = target.load(&[])?.settings;
    let Some(accuracy) = scene.accuracy else {
        return Err(format!(
            "{file} states no accuracy to keep; add a table [accuracy] with `error`, such as error = \"3 %\""
        )
        .into());
    };
    let of_plan = of_plan(&chart, &plan, &target.path);
    let goal = Goal {
        expect: expectations(&scene, of_plan),
        error: accuracy.error,
        margin: accuracy.stability_margin,
        cost: accuracy.cost.unwrap_or(f64::INFINITY),
        ends_at_rest: scene.run.end == settings::End::Rest,
    };
    // A scene that ends by time is about its motion.
    let kind = match scene.run.end {
        settings::End::Rest => ExactKind::Rest,
        settings::End::Time | settings::End::Divergence => ExactKind::Motion,
    };
    let mut candidates = candidates(&chart, &scene, kind, of_plan, target.as_level());
    if args.keep_mesh {
        candidates.keep_mesh();
    }
    let (line, now) = (Progress::new(), RefCell::new(Now::default()));
    let context = Context {
        chart: &chart,
        load: &load,
        clock: &thread_seconds,
        budget: chart.budget.run,
        remaining: &|| f64::INFINITY,
        exec: &Serial,
        progress: &|part| {
            let now = now.borrow();
            line.show(now.part, || {
                format!("{}: {:.0} % of a run", now.what, 100.0 * part)
            });
        },
    };
    if args.verify {
        return verify(
            &context,
            goal,
            &scene,
            &candidates,
            args.json.then_some(&target),
        );
    }
    let tuning = choose(&context, &goal, &candidates, &mut |step| match step {
        TuneStep::Begins(what) => now.borrow_mut().what = what.to_owned(),
        TuneStep::Over(part) => now.borrow_mut().part = Some(part),
        TuneStep::Done(trial) => {
            let verdict = trial.rejected.as_deref().unwrap_or("the best so far");
            line.clear();
            complain(format!("{}: {verdict}", trial.description));
            now.borrow_mut().what = "the next runs".into();
        }
    });
    line.clear();
    if let Some(reason) = &tuning.no_measure {
        return Err(format!("{file}: nothing to compare with: {reason}").into());
    }
    if !args.json {
        report(&tuning, &goal)?;
    }
    let written = match (tuning.choice(), &out) {
        (Some(choice), Some(out)) => {
            let written = edit::write(&target, &scene, choice, &tuning)?;
            replace(out, written.as_bytes())?;
            Some(out)
        }
        _ => None,
    };
    if args.json {
        print_json(&document::tuning(&target, &tuning, &goal, written))?;
    } else {
        print(match (tuning.choice(), written) {
            (None, _) => format!(
                "{file}: nothing keeps an error of {}; the file is as it was",
                percent(goal.error)
            ),
            (Some(_), None) => format!("{file} is as it was (--dry-run)"),
            (Some(_), Some(out)) if args.out.is_some() => {
                format!("Written into {}; {file} is as it was", out.display())
            }
            (Some(_), Some(_)) => format!(
                "Written into {file}; `microsim tune {} --verify` measures it again",
                target.name
            ),
        })?;
    }
    Ok(match tuning.choice() {
        Some(_) => Exit::Done,
        None => Exit::Negative,
    })
}

/// Where the file as tuned is written; `None` if it is not. Known before the time is spent.
fn out(place: &Place, args: &TuneArgs, target: &Target) -> Result<Option<PathBuf>, Problem> {
    if args.dry_run || args.verify {
        return Ok(None);
    }
    if let Some(out) = &args.out {
        must_be_writable(out)?;
        return Ok(Some(out.clone()));
    }
    // The file that a link names is the one to be tuned.
    let path = target.path.canonicalize();
    let path = path.unwrap_or_else(|_| target.path.clone());
    let root = match &place.root {
        Some(root) => root.clone(),
        None => program_folder()?,
    };
    if root.canonicalize().is_ok_and(|root| path.starts_with(root)) {
        return Err(format!(
            "{} belongs to the installation, which is never written: name another place with --out FILE, or --dry-run",
            path.display()
        )
        .into());
    }
    must_be_writable(&path)?;
    Ok(Some(path))
}

fn target(place: &Place, args: &TuneArgs) -> Result<Target, Problem> {
    let read = |path: &Path| {
        std::fs::read_to_string(path).map_err(|e| format!("{}: {}", path.display(), in_words(e)))
    };
    let Some(number) = args.level else {
        let path = find(place, Path::new(&args.target))?;
        return Ok(Target {
            what: Measured::Scene(read(&path)?),
            vessels: path.parent().unwrap_or(Path::new("")).join("../vessels"),
            path,
            name: args.target.clone(),
        });
    };
    let installation = installation(place)?;
    let module = installation.module(&args.target)?;
    let path = (number as usize)
        .checked_sub(1)
        .and_then(|index| module.levels.get(index));
    let Some(path) = path else {
        return Err(format!("{} has levels 1 to {}", args.target, module.levels.len()).into());
    };
    let level = level::Level::of(&read(path)?).map_err(|e| format!("{}: {e}", path.display()))?;
    Ok(Target {
        path: path.clone(),
        what: Measured::Level(level),
        vessels: installation.config.join("vessels"),
        name: format!("{} --level {number}", args.target),
    })
}

/// The scene of a text, with overrides.
fn load(
    text: &str,
    file: &str,
    folder: &Path,
    vessels: &Path,
    set: &[String],
) -> Result<LoadedScene, String> {
    let overrides: Vec<Override> = set
        .iter()
        .map(|text| Override::parse(text))
        .collect::<Result<_, _>>()?;
    let loaded = settings::read_scene_with(text, file, &overrides, vessels);
    let loaded = loaded.map_err(|e| e.to_string())?;
    let described = scene_spec(&loaded.settings, &mut |file| {
        settings::read_regular(&folder.join(file))
    });
    let spec = described.map_err(|e| format!("{file}: {e}"))?.spec;
    Ok(LoadedScene {
        settings: loaded.settings,
        spec,
    })
}

/// The scene of the plan that has the same file.
fn of_plan<'a>(chart: &'a Chart, plan: &Path, path: &Path) -> Option<&'a ChartScene> {
    let folder = plan.parent().unwrap_or(Path::new(""));
    let own = path.canonicalize().ok()?;
    chart
        .scene
        .iter()
        .find(|scene| folder.join(&scene.file).canonicalize().ok().as_ref() == Some(&own))
}

/// What is compared: the measures of the plan with their references, or what the scene expects.
fn expectations(scene: &settings::Scene, of_plan: Option<&ChartScene>) -> Vec<Expect> {
    let Some(of_plan) = of_plan else {
        if !scene.expect.is_empty() {
            return scene.expect.clone();
        }
        // What is watched counts at the end, against the exact solution on a fine mesh.
        let watched = scene.probe.iter().map(|probe| Expect {
            regression: false,
            probe: probe.name.clone(),
            what: settings::Feature::AtEnd,
            value: f64::NAN,
            tolerance: 1.0,
            scale: None,
            fall_time: 0.0,
            source: String::new(),
        });
        return watched.collect();
    };
    let references = of_plan
        .variant
        .first()
        .map(|variant| variant.reference.as_slice());
    let references = references.unwrap_or_default();
    let expect = |(k, measure): (usize, &settings::ChartMeasure)| Expect {
        regression: false,
        probe: measure.probe.clone(),
        what: measure.what,
        value: references.get(k).copied().unwrap_or(f64::NAN),
        tolerance: 1.0,
        scale: None,
        fall_time: measure.fall_time,
        source: String::new(),
    };
    let all = of_plan.measure.iter().enumerate().map(expect);
    // Where something is known from outside, only that counts.
    if references.is_empty() {
        all.collect()
    } else {
        all.take(references.len()).collect()
    }
}

/// The table of what was tried.
fn report(tuning: &Tuning, goal: &Goal) -> Result<(), Problem> {
    print(format!(
        "Demanded: an error of at most {}, a margin of {}",
        percent(goal.error),
        goal.margin
    ))?;
    for sentence in tuning.sentences() {
        print(format!("  rejected  {sentence}"))?;
    }
    if let Some(choice) = tuning.choice() {
        print(format!("  chosen    {}", figures(choice, goal)))?;
    }
    if let Some(locking) = tuning.locking {
        print(format!(
            "  linear tetrahedra, which lock, on the chosen mesh: error {}",
            percent(locking)
        ))?;
    }
    if let Some(doubt) = tuning.doubt {
        print(format!(
            "  the measure itself may be off by {}",
            percent(doubt)
        ))?;
    }
    Ok(())
}

fn figures(trial: &Trial, goal: &Goal) -> String {
    format!(
        "{}: error {}, {} {}, stable at {} times the step",
        trial.description,
        trial.error.map_or("unknown".into(), percent),
        trial
            .cost
            .map_or("unknown".into(), |cost| significant(cost, 2)),
        goal.cost_unit(),
        trial.margin.unwrap_or(1.0)
    )
}

/// A figure that was measured again.
struct Figure {
    name: &'static str,
    found: Option<f64>,
    stated: Option<f64>,
    confirmed: bool,
}

/// Whether a figure that was found agrees with the one that is stated.
type Agreement = fn(f64, f64) -> bool;

/// Runs the file as it is and compares with what stands in it.
fn verify(
    context: &Context<'_>,
    mut goal: Goal,
    scene: &settings::Scene,
    candidates: &Candidates,
    as_json: Option<&Target>,
) -> Result<Exit, Problem> {
    let Some(tuned) = &scene.tuned else {
        return Err("the file holds no [tuned]: run tune first".into());
    };
    if !tuned.measure.is_empty() {
        if tuned.measure.len() != goal.expect.len() {
            return Err(
                "the file's [tuned] measures something else than the file: run tune again".into(),
            );
        }
        for (expect, value) in goal.expect.iter_mut().zip(&tuned.measure) {
            expect.value = *value;
        }
    }
    let found = measure(context, &goal)?;
    let mut confirmed = found.error.is_some_and(|error| error <= goal.error);
    let mut figures = Vec::new();
    let mut compare =
        |name: &'static str, found: Option<f64>, stated: Option<f64>, same: Agreement| {
            let same = found.zip(stated).is_some_and(|(a, b)| same(a, b));
            confirmed &= same;
            figures.push(Figure {
                name,
                found,
                stated,
                confirmed: same,
            });
            if as_json.is_some() {
                return Ok(());
            }
            print(format!(
                "{name} {} (stated {}){}",
                found.map_or("unknown".into(), percent),
                stated.map_or("nothing".into(), percent),
                if same { "" } else { ": NOT CONFIRMED" }
            ))
        };
    // Figures are the same on every machine, but for the digits that the file leaves out.
    let equal = |a: f64, b: f64| (a - b).abs() <= 0.01 * b.max(1e-4);
    compare("error", found.error, tuned.error, equal)?;
    // Files may state an error alone.
    if tuned.doubt.is_some() {
        // The mesh that is compared with depends on that of the file, which may be the one that was chosen since.
        let near = |a: f64, b: f64| a <= 2.0 * b;
        let doubt = doubt(context, &goal, candidates);
        compare("doubt about the measure", doubt, tuned.doubt, near)?;
    }
    if tuned.locking.is_some() {
        let locking = locking(context, &goal, candidates, &[]);
        compare("error of linear tetrahedra", locking, tuned.locking, equal)?;
    }
    let exit = match confirmed {
        true => Exit::Done,
        false => Exit::Negative,
    };
    if let Some(target) = as_json {
        let costs = (found.cost, tuned.cost);
        print_json(&document::verification(
            target, &figures, costs, &goal, confirmed,
        ))?;
        return Ok(exit);
    }
    // Times are not the same: they are shown, and decide nothing.
    print(format!(
        "{} {} (stated {})",
        found
            .cost
            .map_or("unknown".into(), |cost| significant(cost, 2)),
        goal.cost_unit(),
        tuned
            .cost
            .map_or("nothing".into(), |cost| significant(cost, 2)),
    ))?;
    print(format!(
        "allowed is an error of {}: {}",
        percent(goal.error),
        if confirmed {
            "confirmed"
        } else {
            "NOT CONFIRMED"
        }
    ))?;
    Ok(exit)
}
