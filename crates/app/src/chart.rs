//! `microsim chart`: speed against accuracy, as CSV, SVG and one HTML page.

use crate::cli::{ChartArgs, Place};
use crate::output::{Exit, Problem, print, print_json};
use crate::progress;
use crate::scene_file::folder;
use crate::table_rows::table_rows;
use microsim_scene::{Serial, scene_spec};
use microsim_settings::{self as settings, Chart, Override, unwritable};
use microsim_study::{
    Context, Group, GroupResult, LoadedScene, PageInfo, Results, Step, groups, panel_svg, run_group,
};
use rustix::time::{ClockId, clock_gettime};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

/// Makes the chart.
pub fn chart(place: &Place, args: &ChartArgs) -> Result<Exit, Problem> {
    let start = Instant::now();
    let plan = plan_path(place)?;
    let chart = settings::load_chart(&plan)?.settings;
    let unknown = args
        .scene
        .iter()
        .find(|name| chart.scene.iter().all(|s| s.name != **name));
    if let Some(unknown) = unknown {
        let names: Vec<&str> = chart
            .scene
            .iter()
            .map(|scene| scene.name.as_str())
            .collect();
        return Err(format!(
            "no scene `{unknown}` in {}; there are: {}",
            plan.display(),
            names.join(", ")
        )
        .into());
    }
    std::fs::create_dir_all(&args.out).map_err(|e| unwritable(&args.out, e))?;
    let groups = groups(&chart, args.short, &args.scene);
    let scenes = plan.parent().unwrap_or(Path::new("")).to_path_buf();
    let limit = if args.short {
        chart.budget.quick_total
    } else {
        f64::INFINITY
    };
    let budget = if args.short {
        chart.budget.quick_run
    } else {
        chart.budget.run
    };
    let remaining = || limit - start.elapsed().as_secs_f64();
    let progress = Progress::new(&chart, &groups);
    let left_out = Mutex::new(Vec::new());
    let (next, done) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
    let work = || {
        let load = |file: &str, set: &[String]| load(&scenes, file, set);
        let context = Context {
            chart: &chart,
            load: &load,
            clock: &thread_seconds,
            budget,
            remaining: &remaining,
            exec: &Serial,
            progress: &|_| {},
        };
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            let Some(group) = groups.get(index) else {
                break;
            };
            let result = run_group(&context, group, &mut |step| {
                if let Step::LeftOut(run) = &step {
                    let method = &chart.method[run.method].title;
                    lock(&left_out).push((index, format!("{method}, {}", name(&chart, group))));
                }
                progress.step(&chart, group, &step);
            });
            lock(&done).push((index, result));
        }
    };
    std::thread::scope(|scope| {
        for _ in 1..args.jobs {
            scope.spawn(work);
        }
        work();
    });
    progress.line.clear();
    // Which thread made a group does not matter.
    let ordered = |list: Mutex<Vec<(usize, GroupResult)>>| {
        let mut list = list.into_inner().unwrap_or_else(|e| e.into_inner());
        list.sort_by_key(|(index, _)| *index);
        list.into_iter().map(|(_, result)| result).collect()
    };
    let mut left_out = left_out.into_inner().unwrap_or_else(|e| e.into_inner());
    left_out.sort();
    let results = Results {
        groups: ordered(done),
        chart,
    };
    let info = PageInfo {
        machine: machine(),
        command: command(args),
        date: args.date.clone(),
        notes: match args.jobs {
            1 => Vec::new(),
            jobs => vec![format!(
                "{jobs} runs at a time: they divide the caches and the memory between them of the machine, so times are longer than those of single runs."
            )],
        },
        left_out: left_out.into_iter().map(|(_, text)| text).collect(),
    };
    write(&results, &info, &args.out)?;
    if args.json {
        print_json(&document(&results, &info, args, start)?)?;
        return Ok(Exit::Done);
    }
    for panel in results.panels() {
        print(format!("{}: {}", panel.title(), panel.sentence()))?;
    }
    for text in &info.left_out {
        print(format!("Left out for lack of time: {text}"))?;
    }
    let page = args.out.join("chart.html");
    print(format!(
        "{} after {:.0} s",
        page.display(),
        start.elapsed().as_secs_f64()
    ))?;
    Ok(Exit::Done)
}

/// What the command has made, as one document.
fn document(
    results: &Results,
    info: &PageInfo,
    args: &ChartArgs,
    start: Instant,
) -> Result<Value, Problem> {
    let panels = results.panels().into_iter().map(|panel| {
        let drawing = args.out.join(format!("{}.svg", panel.id()));
        json!({ "title": panel.title(), "sentence": panel.sentence(), "drawing": drawing })
    });
    Ok(json!({
        "command": info.command,
        "machine": info.machine,
        "seconds": start.elapsed().as_secs_f64(),
        "page": args.out.join("chart.html"),
        "table": args.out.join("chart.csv"),
        "panels": panels.collect::<Vec<_>>(),
        "left_out": info.left_out,
        "runs": table_rows(&results.to_csv())?,
    }))
}

/// The plan's file.
pub fn plan_path(place: &Place) -> Result<PathBuf, Problem> {
    let scenes = folder(place)?;
    Ok(scenes.parent().unwrap_or(Path::new("")).join("chart.toml"))
}

/// Loads the scene of a file below `folder`.
pub fn load(folder: &Path, file: &str, set: &[String]) -> Result<LoadedScene, String> {
    let path = folder.join(file);
    let overrides: Vec<Override> = set
        .iter()
        .map(|text| Override::parse(text))
        .collect::<Result<_, _>>()?;
    let settings = settings::load_scene(&path, &overrides)
        .map_err(|e| e.to_string())?
        .settings;
    let beside = path.parent().unwrap_or(Path::new(""));
    let described = scene_spec(&settings, &mut |file| {
        settings::read_regular(&beside.join(file))
    });
    let spec = described
        .map_err(|e| format!("{}: {e}", path.display()))?
        .spec;
    Ok(LoadedScene { settings, spec })
}

/// CPU time of this thread \[s\].
pub fn thread_seconds() -> f64 {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(|e| e.into_inner())
}

/// A mesh with a material in words.
fn name(chart: &Chart, group: &Group) -> String {
    let scene = &chart.scene[group.key.scene];
    format!(
        "{}, {}, mesh {}, {}",
        scene.title,
        scene.variant[group.key.variant].name,
        scene.resolution[group.key.resolution].name,
        chart.material[group.key.material].title
    )
}

fn write(results: &Results, info: &PageInfo, out: &Path) -> Result<(), Problem> {
    let mut files = vec![
        ("chart.csv".to_owned(), results.to_csv()),
        ("chart.html".to_owned(), results.to_html(info)),
    ];
    for panel in results.panels() {
        files.push((format!("{}.svg", panel.id()), panel_svg(&panel, true)));
    }
    for (name, text) in files {
        let path = out.join(name);
        std::fs::write(&path, text).map_err(|e| unwritable(&path, e))?;
    }
    Ok(())
}

/// The command that makes the same chart again.
fn command(args: &ChartArgs) -> String {
    let mut words = vec!["microsim chart".to_owned()];
    words.extend(args.short.then(|| "--quick".to_owned()));
    words.extend(args.scene.iter().map(|name| format!("--scene {name}")));
    words.extend((args.jobs > 1).then(|| format!("--jobs {}", args.jobs)));
    words.join(" ")
}

/// Processor and number of cores, as far as the system knows.
pub fn machine() -> String {
    let cpu = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = cpu
        .lines()
        .find_map(|line| line.strip_prefix("model name")?.split_once(": "));
    let model = model.map_or("unknown processor", |(_, name)| name.trim());
    let cores = std::thread::available_parallelism().map_or(1, |n| n.get());
    format!("{model}, {cores} cores, one thread per run")
}

/// How far the runs are.
struct Progress {
    total: f64,
    done: Mutex<f64>,
    line: progress::Progress,
}

impl Progress {
    fn new(chart: &Chart, groups: &[Group]) -> Self {
        let of = |group: &Group| (group.runs.len() + 1) as f64 * weight(chart, group);
        Self {
            total: groups.iter().map(of).sum(),
            done: Mutex::new(0.0),
            line: progress::Progress::new(),
        }
    }

    fn step(&self, chart: &Chart, group: &Group, step: &Step<'_>) {
        let done = {
            let mut done = lock(&self.done);
            *done += weight(chart, group);
            *done
        };
        if matches!(step, Step::LeftOut(_)) {
            return;
        }
        self.line
            .show(Some(done / self.total), || name(chart, group));
    }
}

/// How long a run takes compared with one on the coarsest mesh, roughly: halved edges are eight times the elements.
fn weight(chart: &Chart, group: &Group) -> f64 {
    let coarsest = chart.scene[group.key.scene].resolution.len() == 1;
    if coarsest {
        1.0
    } else {
        6f64.powi(group.key.resolution as i32)
    }
}
