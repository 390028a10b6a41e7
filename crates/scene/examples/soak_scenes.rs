//! `cargo xtask soak scenes [-- NAME...]`: every scene of `config/scenes` from its start to its end, and what became of what it expects. All
//! of them at once write `tests/results/scenes.md`. Fails if an expectation is missed or a scene diverges.

use microsim_scene::{End, Runner, Scene, Serial, Verdict, scene_spec};
use microsim_settings::{self as settings, load_scene};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

fn main() -> ExitCode {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let asked: Vec<String> = std::env::args().skip(1).collect();
    let scenes = match scenes(&root.join("config/scenes"), &asked) {
        Ok(scenes) => scenes,
        Err(error) => {
            eprintln!("soak scenes: {error}");
            return ExitCode::from(2);
        }
    };
    let mut tally = Tally::default();
    let mut rows = String::new();
    for path in &scenes {
        match row(path, &mut tally) {
            Ok(row) => {
                print!("{row}");
                rows.push_str(&row);
            }
            Err(error) => {
                eprintln!("soak scenes: {error}");
                return ExitCode::from(2);
            }
        }
    }
    let sums = tally.sentence();
    println!("{sums}");
    if asked.is_empty() {
        let page = root.join("tests/results/scenes.md");
        let text = format!("{HEAD}{sums}\n\n{COLUMNS}{rows}");
        if let Err(error) = std::fs::write(&page, text) {
            eprintln!("soak scenes: {}: {error}", page.display());
            return ExitCode::from(2);
        }
    }
    ExitCode::from(u8::from(tally.missed > 0))
}

const HEAD: &str = "\
# Every shipped scene, to its end

`cargo xtask soak scenes`. What each scene of `config/scenes` expects, and whether it came out. *Expected* is known from elsewhere: a closed form, geometry, a conservation law, an
independent code. A *regression* is our own output, of shorter steps or of an earlier day: it says that the result is the same, not that it is right.
Where the model error is not stated the scene's file says why. Up to version 0.2 all were called expectations, and 31 scenes said neither.

";

const COLUMNS: &str = "\
| scene | verdict | expected, met | regressions, met | largest error / tolerance | stated model error | CPU [s] |
|---|---|---|---|---|---|---|
";

#[derive(Default)]
struct Tally {
    scenes: usize,
    expected: usize,
    regressions: usize,
    missed: usize,
    stated: usize,
}

impl Tally {
    fn sentence(&self) -> String {
        let Self {
            scenes,
            expected,
            regressions,
            missed,
            stated,
        } = self;
        format!(
            "{scenes} scenes: {expected} expectations, {regressions} regressions, {missed} missed; {stated} state a model error, {} say why none is stated.",
            scenes - stated
        )
    }
}

fn scenes(folder: &Path, asked: &[String]) -> Result<Vec<PathBuf>, String> {
    if !asked.is_empty() {
        let path = |name: &String| folder.join(name).with_extension("toml");
        return Ok(asked.iter().map(path).collect());
    }
    let listing = std::fs::read_dir(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let paths = listing.map(|entry| entry.map(|entry| entry.path()));
    let paths: Result<Vec<_>, _> = paths.collect();
    let mut paths = paths.map_err(|e| format!("{}: {e}", folder.display()))?;
    paths.retain(|path| path.extension().is_some_and(|ending| ending == "toml"));
    paths.sort();
    Ok(paths)
}

fn row(path: &Path, tally: &mut Tally) -> Result<String, String> {
    let name = path.file_stem().unwrap_or_default().to_string_lossy();
    let loaded = load_scene(path, &[]).map_err(|errors| errors.to_string())?;
    let scene = loaded.settings;
    let folder = path.parent().unwrap_or(path);
    let spec = scene_spec(&scene, &mut |file| std::fs::read(folder.join(file)));
    let spec = spec.map_err(|e| format!("{name}: {e}"))?.spec;
    let built = Scene::new(&spec).map_err(|e| format!("{name}: {e}"))?;
    let mut runner = Runner::new(&scene, built).map_err(|e| format!("{name}: {e}"))?;
    let start = cpu_time();
    runner.run(&Serial, &mut |_| true);
    let cpu = cpu_time() - start;
    let verdicts = runner.verdicts();
    let (regressions, expected): (Vec<&Verdict>, Vec<&Verdict>) = verdicts
        .iter()
        .partition(|verdict| scene.expect[verdict.expect].regression);
    let met = |of: &[&Verdict]| of.iter().filter(|verdict| verdict.met).count();
    let diverged = matches!(runner.end(), Some(End::Diverged(_)));
    let is_to_diverge = scene.run.end == settings::End::Divergence;
    let gains_energy = runner.energy_growth().is_some();
    let missed = verdicts.iter().filter(|verdict| !verdict.met).count();
    tally.scenes += 1;
    tally.expected += expected.len();
    tally.regressions += regressions.len();
    let wrong_end = match is_to_diverge {
        true => !diverged,
        false => diverged || gains_energy,
    };
    tally.missed += missed + usize::from(wrong_end && missed == 0);
    tally.stated += usize::from(scene.accuracy.is_some());
    if scene.accuracy.is_none() && scene.no_stated_error.is_none() {
        return Err(format!("{name}: neither `accuracy` nor `no_stated_error`"));
    }
    let verdict = match (is_to_diverge, diverged, gains_energy, missed) {
        (true, false, ..) => "STABLE",
        (true, true, _, 0) => "diverges, as it is to",
        (false, true, ..) => "DIVERGED",
        (false, _, true, _) => "GAINS ENERGY",
        (.., 0) => "met",
        _ => "MISSED",
    };
    let mut row = format!(
        "| {name} | {verdict} | {} of {} | {} of {} | {} | {} | {cpu:.1} |",
        met(&expected),
        expected.len(),
        met(&regressions),
        regressions.len(),
        fraction(&scene, &verdicts),
        stated(&scene),
    );
    let _ = writeln!(row);
    Ok(row)
}

fn fraction(scene: &settings::Scene, verdicts: &[Verdict]) -> String {
    let fractions = verdicts.iter().map(|verdict| {
        let error = verdict.error.map(f64::abs);
        error.map_or(f64::INFINITY, |e| {
            e / scene.expect[verdict.expect].tolerance
        })
    });
    fractions
        .reduce(f64::max)
        .map_or("–".into(), |largest| format!("{largest:.2}"))
}

fn stated(scene: &settings::Scene) -> String {
    scene.accuracy.as_ref().map_or_else(
        || "no".into(),
        |accuracy| format!("{} %", 1e-3 * (1e5 * accuracy.error).round()),
    )
}

/// CPU time of this process [s].
fn cpu_time() -> f64 {
    let now = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    now.tv_sec as f64 + 1e-9 * now.tv_nsec as f64
}
