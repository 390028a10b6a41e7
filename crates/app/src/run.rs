//! `microsim run`.

use crate::cli::{Place, RunArgs};
use crate::folders::{self, Folders};
use crate::key_pictures::{key_pictures, not_asked, not_yet};
use crate::log;
use crate::motion_length::motion_length;
use crate::names::name_or_id;
use crate::output::{Exit, Problem, complain, print, print_json};
use crate::progress::Progress;
use crate::records::{Attempt, RunRecord};
use crate::replace_file::write_new;
use crate::report::{summary, write_beside, write_page};
use crate::session_file::{installation, is_session, read_around, report_of, verdict_word};
use crate::sessions::files_beside;
use crate::station;
use crate::views;
use microsim_host::Checkpoint;
use microsim_host::assemble::{Installation, Request, assemble};
use microsim_host::picture::{PicturePlan, PictureReport, PictureTimes};
use microsim_host::plan::{PluginKind, RunPlan};
use microsim_host::run::{Realtime, RunOptions, RunOutcome, run as run_plan};
use microsim_message::{decode_bytes, encode};
use microsim_report::{Page, Report};
use microsim_settings::{read_regular, unwritable};
use serde_json::json;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, SystemTime};

/// Signals that end a run; the last one is that of a terminal that was closed.
pub const ENDING: [i32; 3] = [
    signal_hook::consts::SIGINT,
    signal_hook::consts::SIGTERM,
    signal_hook::consts::SIGHUP,
];

/// Which pictures to draw.
pub fn picture_plan(
    installation: &Installation,
    folder: &Path,
    rate: Option<f64>,
    tick_ns: u64,
) -> PicturePlan {
    let rate = rate.unwrap_or(installation.host.picture.rate);
    let every = (1e9 / (rate * tick_ns as f64)).round();
    PicturePlan {
        folder: folder.to_path_buf(),
        when: PictureTimes::Every((every as u64).max(1)),
    }
}

/// What came of the pictures, in one line.
pub fn picture_line(report: &PictureReport, folder: Option<&Path>) -> String {
    let folder = folder.map(|f| f.display().to_string()).unwrap_or_default();
    let late = match report.left_out {
        0 => String::new(),
        n => format!(", {n} left out because drawing was slower than the run"),
    };
    match &report.off {
        None => format!("Pictures: {} in {folder}{late}", report.written),
        Some(reason) if report.written == 0 => format!("Pictures are off: {reason}"),
        Some(reason) => format!(
            "Pictures: {} in {folder}{late}, then off: {reason}",
            report.written
        ),
    }
}

/// A new name for a session in the folder of the user: module, level, wall clock and process.
fn new_session(place: &Place, args: &RunArgs) -> Result<PathBuf, Problem> {
    let folder = Folders::of(place)?.sessions();
    if !args.explain {
        folders::make(&folder)?;
    }
    let now = SystemTime::now()
        .duration_since(SystemTime::UNIX_EPOCH)
        .unwrap_or_default();
    let variant = args.variant.as_ref().map(|name| format!(".{name}"));
    let name = format!(
        "{}-level{}{}-{}-{}",
        args.module,
        args.level,
        variant.unwrap_or_default(),
        now.as_millis(),
        std::process::id()
    );
    Ok(folder.join(format!("{name}.session")))
}

/// Runs a level.
pub fn run(place: &Place, args: &RunArgs) -> Result<Exit, Problem> {
    let installation = installation(place)?;
    let session = match &args.session {
        Some(path) => path.clone(),
        None => new_session(place, args)?,
    };
    if session.exists() && !args.explain {
        return Err(format!(
            "session {} exists already; nothing is overwritten",
            session.display()
        )
        .into());
    }
    views::check(&args.view)?;
    let mut plan = assemble(
        &installation,
        &Request {
            module: args.module.clone(),
            level: args.level,
            variant: args.variant.clone(),
            input: args.input.clone(),
            hand: args.hand,
            seed: args.seed,
            without: args.without.clone(),
            pictures: args.frames.is_some(),
            session: session.clone(),
        },
    )?;
    let renderers = plan.plugins.iter_mut();
    for renderer in renderers.filter(|p| p.kind == PluginKind::Renderer && !args.view.is_empty()) {
        renderer.show(&args.view)?;
    }
    if args.explain {
        return explain(&installation, &plan, args.json);
    }
    refuse_existing(args, &session)?;
    let resume = args.resume.as_deref().map(read_checkpoint).transpose()?;
    let stop_tick = args
        .stop_at
        .map(|s| (s * 1e9 / plan.tick_ns as f64).round() as u64);
    if let (Some(stop), Some(from)) = (stop_tick, resume.as_ref().map(|c| c.tick))
        && stop <= from
    {
        return Err("--stop-at lies before the checkpoint that the run goes on from".into());
    }
    let record = RunRecord::begin(place, &attempt(args), &session)?;
    let outcome = carry_out(place, &installation, &plan, args, resume, &record)?;
    finish(&installation, &plan, args, &session, &outcome, &record)
}

fn attempt(args: &RunArgs) -> Attempt<'_> {
    Attempt {
        module: &args.module,
        level: args.level,
        trainee: args.trainee.as_deref(),
        // Another task than that of this number.
        no_store: args.no_store || args.variant.is_some(),
    }
}

/// Refuses what a run would otherwise overwrite, before it begins.
fn refuse_existing(args: &RunArgs, session: &Path) -> Result<(), Problem> {
    let checkpoint = args.checkpoint.as_ref();
    if checkpoint.is_some_and(|c| c == session) {
        return Err("--checkpoint and --session name the same file".into());
    }
    for path in std::iter::once(session).chain(checkpoint.map(PathBuf::as_path)) {
        let folder = path.parent().filter(|f| !f.as_os_str().is_empty());
        if let Some(folder) = folder.filter(|f| !f.is_dir()) {
            let folder = folder.display();
            return Err(format!("{}: there is no folder {folder}", path.display()).into());
        }
    }
    // A report of a session that is gone is replaced; a session never is.
    if let Some(path) = files_beside(session).iter().find(|p| is_session(p)) {
        let path = path.display();
        return Err(format!("{path} is a session, and the report would take its place").into());
    }
    if let Some(path) = checkpoint.filter(|p| p.exists()) {
        let path = path.display();
        return Err(format!("{path} exists already; nothing is overwritten").into());
    }
    args.frames.as_deref().map_or(Ok(()), refuse_old_pictures)?;
    for (what, path) in [
        ("session", Some(session)),
        ("checkpoint", checkpoint.map(PathBuf::as_path)),
    ] {
        let made = path.map_or(Ok(()), try_to_make);
        made.map_err(|why| format!("{what} {why}"))?;
    }
    Ok(())
}

/// Makes a file that is not there and removes it again: that it cannot be written is known before the run.
fn try_to_make(path: &Path) -> Result<(), String> {
    let made = std::fs::File::create_new(path).and_then(|_| std::fs::remove_file(path));
    made.map_err(|e| unwritable(path, e))
}

/// Pictures of two runs in one folder cannot be distinguished.
pub fn refuse_old_pictures(folder: &Path) -> Result<(), Problem> {
    let mut entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let old = entries.find(|e| {
        let name = e.file_name().to_string_lossy().into_owned();
        name.starts_with("frame-") && name.ends_with(".png")
    });
    match old {
        Some(_) => {
            let folder = folder.display();
            Err(format!("{folder} holds pictures already; name another folder").into())
        }
        None => Ok(()),
    }
}

fn carry_out(
    place: &Place,
    installation: &Installation,
    plan: &RunPlan,
    args: &RunArgs,
    resume: Option<Checkpoint>,
    record: &RunRecord,
) -> Result<RunOutcome, Problem> {
    let stop = Arc::new(AtomicBool::new(false));
    for signal in ENDING {
        // The second one ends the process at once; the first closes the session.
        signal_hook::flag::register_conditional_shutdown(signal, 2, Arc::clone(&stop))?;
        signal_hook::flag::register(signal, Arc::clone(&stop))?;
    }
    let progress = Progress::new();
    // The level may end sooner, and later never by much.
    let end = [args.stop_at, motion_length(plan)].into_iter().flatten();
    let end = end.reduce(f64::min);
    let begin = resume
        .as_ref()
        .map(|from| from.tick as f64 * plan.tick_ns as f64 * 1e-9);
    let begin = begin.unwrap_or(0.0);
    let late = installation.host.late;
    let is_live = args.input.is_tracked_live() && !plan.waits_for_peer();
    let is_paced = args.realtime || is_live;
    let options = RunOptions {
        threads: args.threads.into(),
        realtime: is_paced.then(|| Realtime {
            tolerance: Duration::from_secs_f64(late.tolerance),
            give_up: Duration::from_secs_f64(late.give_up),
        }),
        pictures: args
            .frames
            .as_deref()
            .map(|f| picture_plan(installation, f, args.frame_rate, plan.tick_ns)),
        resume,
        stop_at: args
            .stop_at
            .map(|s| (s * 1e9 / plan.tick_ns as f64).round() as u64),
        stop: &stop,
        operator: None,
        trainee: record.trainee.map(|id| id.to_string()),
        session_id: Some(record.id.to_string()),
        unlisted: args.no_store,
        key: station::key(place)
            .inspect_err(|why| complain(format!("the recording is not signed: {why}")))
            .ok(),
        progress: &mut |time, reported| {
            let part = end.map(|end| (time - begin) / (end - begin));
            progress.show(part, || match (reported, end) {
                (Some(reported), _) => format!(
                    "{time:.1} s simulated, {} {:.0} %",
                    reported.what.en,
                    100.0 * reported.fraction
                ),
                (None, Some(end)) => format!("{time:.1} s simulated of {end:.1} s at most"),
                (None, None) => format!("{time:.1} s simulated"),
            });
        },
    };
    Ok(run_plan(plan, options)?)
}

fn read_checkpoint(path: &Path) -> Result<Checkpoint, Problem> {
    let bytes = read_regular(path).map_err(|e| format!("checkpoint {}: {e}", path.display()))?;
    let payload = microsim_session::read_checkpoint(&bytes)
        .map_err(|e| format!("checkpoint {}: {e}", path.display()))?;
    Ok(decode_bytes(payload).map_err(|e| format!("checkpoint {}: {e}", path.display()))?)
}

/// Writes what a run leaves behind, and prints it: verdict and page first, pictures of key moments after.
fn finish(
    installation: &Installation,
    plan: &RunPlan,
    args: &RunArgs,
    session: &Path,
    outcome: &RunOutcome,
    record: &RunRecord,
) -> Result<Exit, Problem> {
    for complaint in &outcome.complaints {
        tracing::warn!(target: log::FILE, "{complaint}");
        complain(complaint);
    }
    if let Some(failure) = &outcome.failure {
        tracing::error!(target: log::FILE, "{failure}");
    }
    // The report is made from the file, so that it shows what was really recorded.
    let recorded = match (read_around(session), &outcome.failure) {
        (Ok(recorded), _) => recorded,
        // Nothing readable was written, and this is why.
        (Err(_), Some(failure)) => return Err(failure.to_string().into()),
        (Err(problem), None) => return Err(problem),
    };
    let report = report_of(&recorded, session)?;
    let files = [&args.frames, &args.checkpoint, &args.trace];
    let files: Vec<PathBuf> = files.into_iter().flatten().cloned().collect();
    let entered = record.enter(&recorded, &report, session, &files);
    if let Some(Err(why)) = &entered {
        complain(why);
    }
    let stored = matches!(entered, Some(Ok(())));
    let draws = !args.json
        && !args.no_pictures
        && installation.host.report.pictures
        && outcome.failure.is_none();
    let page_with = |pictures| Page {
        language: installation.host.report.language,
        pictures,
    };
    let first = page_with(if draws { not_yet() } else { not_asked() });
    let page = write_beside(&report, &first, session);
    let printed = match (args.json, page.as_deref().ok()) {
        (true, page) => tell_json(plan, session, page, outcome, &report, (record, stored)),
        (false, page) => print_outcome(args, session, page, outcome, &report, record),
    };
    let is_written = page.is_ok();
    let ended = conclude(plan, args, session, outcome, page, printed)?;
    if draws && is_written {
        // All that counts is on the disk: from here on the first signal ends the program, with the status that it would have had.
        let drawing = Arc::new(AtomicBool::new(true));
        for signal in ENDING {
            let status = ended.status().into();
            signal_hook::flag::register_conditional_shutdown(signal, status, Arc::clone(&drawing))?;
        }
        let pictures = key_pictures(installation, session, &report, args.threads.into());
        write_page(&report, &page_with(pictures), session)?;
    }
    Ok(ended)
}

/// The end of a run whose report was written or not, and printed or not.
fn conclude(
    plan: &RunPlan,
    args: &RunArgs,
    session: &Path,
    outcome: &RunOutcome,
    page: Result<PathBuf, Problem>,
    printed: Result<(), Problem>,
) -> Result<Exit, Problem> {
    // What went wrong with the run comes last and counts most; a full disk, for example, keeps the report from being written, too.
    if let Some(failure) = &outcome.failure {
        if let Err(Problem::Text(problem)) = page {
            complain(problem);
        }
        return Err(format!(
            "{failure}; the session so far is safe in {}",
            session.display()
        )
        .into());
    }
    if let (Some(checkpoint), Some(path)) = (&outcome.checkpoint, &args.checkpoint) {
        write_new(
            path,
            &microsim_session::write_checkpoint(&encode(checkpoint)),
        )?;
    } else if let (Some(path), None) = (&args.checkpoint, &outcome.failure) {
        let path = path.display();
        complain(format!(
            "the level ended before --stop-at; {path} was not written"
        ));
    }
    if let Err(Problem::Text(problem)) = page {
        complain(format!(
            "{problem}; the session is safe in {}, and `microsim report` shows it",
            session.display()
        ));
        return Ok(Exit::NoReport);
    }
    match printed {
        Ok(()) | Err(Problem::BrokenPipe) => {}
        Err(problem) => return Err(problem),
    }
    let passed = outcome.result.as_ref().is_some_and(|r| r.passed) && plan.counts();
    Ok(if args.require_pass && !passed {
        Exit::Negative
    } else {
        Exit::Done
    })
}

fn print_outcome(
    args: &RunArgs,
    session: &Path,
    page: Option<&Path>,
    outcome: &RunOutcome,
    report: &Report,
    record: &RunRecord,
) -> Result<(), Problem> {
    if outcome.checkpoint.is_some() {
        print(format!(
            "Stopped after {} ticks with a checkpoint",
            outcome.ticks
        ))?;
    } else {
        print(summary(report))?;
    }
    if record.trainee.is_some() {
        let name = name_or_id(record.name.as_deref(), record.trainee);
        print(format!("  trainee {name}"))?;
    }
    if outcome.late_ticks > 0 {
        print(format!(
            "{} of {} ticks began late",
            outcome.late_ticks, outcome.ticks
        ))?;
    }
    if let Some(pictures) = &outcome.pictures {
        print(picture_line(pictures, args.frames.as_deref()))?;
    }
    print(format!("Session: {}", session.display()))?;
    match page {
        Some(page) => print(format!("Report:  {}", page.display())),
        None => Ok(()),
    }
}

fn tell_json(
    plan: &RunPlan,
    session: &Path,
    page: Option<&Path>,
    outcome: &RunOutcome,
    report: &Report,
    (record, stored): (&RunRecord, bool),
) -> Result<(), Problem> {
    print_json(&json!({
        "module": plan.module,
        "level": plan.level,
        "variant": plan.variant,
        "seed": plan.seed,
        "verdict": verdict_word(report.verdict),
        "counts": report.counts,
        "synthetic": report.session.synthetic,
        "failed": report.failed,
        "score": report.score,
        "targets_done": report.targets_done,
        "targets": report.targets,
        "ticks": outcome.ticks,
        "solver": report.solver,
        "implausible": report.implausible,
        "late_ticks": outcome.late_ticks,
        "arrivals": report.arrivals,
        "markers": report.markers,
        "state_hash": outcome.state_hash,
        "physics_digest": outcome.physics_digest,
        "session": session,
        "session_id": record.id,
        "trainee": record.trainee,
        "stored": stored,
        "report": page,
        "pictures": outcome.pictures.as_ref().map(|p| json!({
            "written": p.written, "left_out": p.left_out, "off": p.off,
        })),
        "failure": outcome.failure.as_ref().map(ToString::to_string),
    }))
}

/// What would be loaded and computed, and why.
fn explain(installation: &Installation, plan: &RunPlan, as_json: bool) -> Result<Exit, Problem> {
    if as_json {
        let plugins: Vec<_> = plan
            .plugins
            .iter()
            .map(|p| {
                json!({
                    "name": p.name, "kind": p.kind.name(), "why": p.why, "library": p.library,
                    "isolated": p.hosting.is_guest(),
                })
            })
            .collect();
        let parts: Vec<_> = plan
            .parts
            .iter()
            .map(|p| json!({ "what": p.what, "name": p.name, "why": p.why }))
            .collect();
        print_json(&json!({
            "module": plan.module, "level": plan.level, "variant": plan.variant, "tick_s": plan.tick_ns as f64 * 1e-9,
            "steps": plan.steps, "plugins": plugins, "parts": parts, "without": plan.without,
            "settings_of_station": installation.replaced(),
        }))?;
        return Ok(Exit::Done);
    }
    print(format!(
        "{}, level {}: {}",
        plan.module, plan.level, plan.level_title.en
    ))?;
    print(format!(
        "  tick {} ms, {} solver steps in each",
        plan.tick_ns as f64 * 1e-6,
        plan.steps
    ))?;
    print("Loaded, in the order of a tick")?;
    for plugin in &plan.plugins {
        let own = match plugin.hosting.is_guest() {
            true => "; in a process of its own",
            false => "",
        };
        print(format!(
            "  {:<10} {:<18} {}{own}",
            plugin.kind.name(),
            plugin.name,
            plugin.why
        ))?;
    }
    print("Computed and shown")?;
    for part in &plan.parts {
        print(format!(
            "  {:<10} {:<18} {}",
            part.what, part.name, part.why
        ))?;
    }
    print("Nothing else.")?;
    for file in installation.replaced() {
        print(format!(
            "Settings of this station, in place of the shipped ones: {}",
            file.display()
        ))?;
    }
    Ok(Exit::Done)
}
