//! References of a replay: the script that passes its level, and other sessions of it.

use super::AtThisPlace;
use crate::date;
use crate::names::name_or_id;
use crate::output::Problem;
use crate::records;
use microsim_bus::Frames;
use microsim_host::record::SessionReader;
use microsim_message::{
    InputSample, LocalText, Message, Pose, ToolPlacements, ToolState, ToolStates, ToolStatus,
    decode,
};
use microsim_settings::{self as settings, ToolSlot, load_script, open_regular};
use microsim_store::{Filter, Id, NamedSession, Verdict};
use microsim_window::{Debrief, Motion, ReadTrack, Reference, References, Track};
use std::collections::BTreeMap;
use std::io::{BufReader, Read};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

/// Most sessions that are offered besides the best own one.
const OTHERS: usize = 30;

impl References for AtThisPlace {
    fn references(&self, debrief: &Debrief) -> (Vec<Reference>, Option<String>) {
        let script = self.passing_script(debrief).map(|path| Reference {
            title: LocalText::fixed("Skript, das besteht", "a script that passes"),
            motion: Motion::Script(path),
        });
        let mut found: Vec<Reference> = script.into_iter().collect();
        // The store has sessions of levels, and none of their variants.
        if debrief.variant.is_some() {
            return (found, None);
        }
        match self.other_sessions(debrief) {
            Ok(sessions) => {
                found.extend(offered(sessions, debrief));
                (found, None)
            }
            Err(Problem::Text(why)) => (found, Some(why)),
            Err(Problem::BrokenPipe) => (found, None),
        }
    }

    fn track(&self, debrief: &Debrief, reference: &Reference) -> Result<ReadTrack, String> {
        match &reference.motion {
            Motion::Session(path) => {
                let path = path.clone();
                Ok(Box::new(move |is_left| of_session(&path, is_left)))
            }
            Motion::Script(path) => {
                let (path, session) = (path.clone(), &debrief.report.session);
                let variant = debrief.variant.as_deref();
                let level = self
                    .installation
                    .variant(&session.module, session.level, variant);
                let tools = level.map_err(|e| e.to_string())?.settings.tool.clone();
                Ok(Box::new(move |_| of_script(&path, &tools)))
            }
        }
    }
}

impl AtThisPlace {
    /// The script that passes the level of a session, if its module has one.
    fn passing_script(&self, debrief: &Debrief) -> Option<PathBuf> {
        let session = &debrief.report.session;
        let module = self.installation.module(&session.module).ok()?;
        let scripts = module.manifest.document.path().with_file_name("scripts");
        let path = scripts.join(format!("level{}-pass.toml", session.level));
        path.is_file().then_some(path)
    }

    /// The other sessions of a level that are on the disk, the newest first.
    fn other_sessions(&self, debrief: &Debrief) -> Result<Vec<NamedSession>, Problem> {
        let Some(store) = records::open_to_read(&self.place)? else {
            return Ok(Vec::new());
        };
        let filter = Filter {
            module: Some(debrief.report.session.module.clone()),
            level: Some(debrief.report.session.level),
            ..Filter::default()
        };
        let mut found = store.results(&filter, false)?;
        let own = debrief.session.canonicalize().ok();
        found.retain(|named| {
            let path = Path::new(&named.session.path).canonicalize();
            path.is_ok_and(|path| Some(&path) != own.as_ref())
        });
        let began = |named: &NamedSession| {
            let session = &named.session;
            (session.started, session.started_subsec_ns)
        };
        found.sort_by_key(|named| std::cmp::Reverse(began(named)));
        Ok(found)
    }
}

/// What is offered of other sessions: the best of the same trainee, then the newest.
fn offered(sessions: Vec<NamedSession>, debrief: &Debrief) -> Vec<Reference> {
    let trainee = debrief
        .report
        .session
        .trainee
        .as_deref()
        .and_then(Id::parse);
    let is_own = |named: &&NamedSession| trainee.is_some() && named.session.trainee == trainee;
    let passed = |named: &&NamedSession| named.session.verdict == Verdict::Passed;
    let score = |named: &NamedSession| named.session.score.unwrap_or_default();
    let best = sessions.iter().filter(is_own).filter(passed);
    // Of equal ones the newest, which comes first.
    let best = best.reduce(|best, other| match score(other) > score(best) {
        true => other,
        false => best,
    });
    let best = best.map(|named| {
        let what = words(named);
        Reference {
            title: LocalText::new(
                format!("eigener bester Versuch: {}", what.de),
                format!("best own attempt: {}", what.en),
            ),
            motion: Motion::Session(named.session.path.clone().into()),
        }
    });
    let others = sessions.iter().take(OTHERS).map(|named| Reference {
        title: words(named),
        motion: Motion::Session(named.session.path.clone().into()),
    });
    best.into_iter().chain(others).collect()
}

/// When, who, how well.
fn words(named: &NamedSession) -> LocalText {
    let session = &named.session;
    let who = name_or_id(named.name.as_deref(), session.trainee);
    let when = format!("{} · {who}", date::shown(session.started));
    match session.score {
        None => LocalText::new(when.clone(), when),
        Some(score) => LocalText::new(
            format!("{when} · {score:.0} Punkte"),
            format!("{when} · score {score:.0}"),
        ),
    }
}

/// The tools of a recorded session, as it was recorded: nothing is computed again.
fn of_session(path: &Path, is_left: &AtomicBool) -> Result<Track, String> {
    let named = |e: &dyn std::fmt::Display| format!("session {}: {e}", path.display());
    let file = open_regular(path).map_err(|e| named(&e))?;
    let reader = SessionReader::open(BufReader::new(file)).map_err(|e| named(&e))?;
    read_tools(reader, is_left).map_err(|e| named(&e))
}

fn read_tools<R: Read>(
    mut reader: SessionReader<R>,
    is_left: &AtomicBool,
) -> Result<Track, String> {
    let tick_s = reader.session().header.plan.tick_ns as f64 * 1e-9;
    let mut track = Track::default();
    while let Some((tick, record)) = reader.next_tick().map_err(|e| e.to_string())? {
        if is_left.load(Ordering::Relaxed) {
            return Err("it was left".into());
        }
        let states = latest::<ToolStates>(&record.log)?;
        let placements = latest::<ToolPlacements>(&record.log)?;
        if let Some(states) = states {
            let placements = placements.filter(|placed| placed.tick == tick);
            track.add((tick + 1) as f64 * tick_s, &states, placements.as_ref());
        }
    }
    Ok(track)
}

/// The last message of a kind in the log of a tick.
fn latest<M: Message>(log: &[u8]) -> Result<Option<M>, String> {
    let frames = Frames::new(log).filter_map(Result::ok);
    let found = frames.filter_map(|frame| decode::<M>(&frame)).last();
    found.transpose().map_err(|e| e.to_string())
}

/// The tools of a script, which states them in the field: devices of their names drive them as they are.
fn of_script(path: &Path, tools: &[ToolSlot]) -> Result<Track, String> {
    let script: settings::Script = load_script(path).map_err(|e| e.to_string())?.settings;
    let motion = script.motion();
    let motion = motion.map_err(|e| format!("{}: {e}", path.display()))?;
    let mut track = Track::default();
    let mut last: BTreeMap<String, InputSample> = BTreeMap::new();
    let mut time = None;
    for sample in motion.samples(script.rate) {
        if let Some(before) = time.filter(|before| *before != sample.device_time) {
            track.add(before, &states(tools, &last), None);
        }
        time = Some(sample.device_time);
        last.insert(sample.device.clone(), sample);
    }
    if let Some(time) = time {
        track.add(time, &states(tools, &last), None);
    }
    Ok(track)
}

/// The tools of a level where samples of their names put them.
fn states(tools: &[ToolSlot], samples: &BTreeMap<String, InputSample>) -> ToolStates {
    let state = |slot: &ToolSlot| {
        let sample = samples.get(&slot.name).filter(|sample| sample.visible);
        ToolState {
            tool: slot.name.clone(),
            model: slot.model.clone(),
            status: match sample {
                Some(_) => ToolStatus::Tracked,
                None => ToolStatus::NeverSeen,
            },
            pose: sample.map_or_else(Pose::default, |sample| sample.pose),
            opening: sample.and_then(|sample| sample.opening).unwrap_or(1.0),
        }
    };
    ToolStates {
        tools: tools.iter().map(state).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use microsim_host::plan::RunPlan;
    use microsim_host::record::{Header, RECORD_FORMAT, TickRecord, kind, record};
    use microsim_message::{ToolPlacement, push};
    use microsim_report::{ReportBuilder, ReportInput};
    use microsim_session::Writer;
    use microsim_store::Session;

    fn debrief(trainee: Option<Id>) -> Debrief {
        let input = ReportInput {
            trainee: trainee.map(|id| id.to_string()),
            ..ReportInput::default()
        };
        Debrief {
            report: ReportBuilder::new(&input).finish(),
            variant: None,
            session: "now.session".into(),
            page: "now.html".into(),
            complaints: Vec::new(),
        }
    }

    fn session(path: &str, trainee: Option<Id>, verdict: Verdict, score: f64) -> NamedSession {
        NamedSession {
            session: Session {
                id: Id::from_random([7; 16]),
                path: path.into(),
                trainee,
                module: "push-strip".into(),
                level: 1,
                started: 0,
                started_subsec_ns: 0,
                simulated: 1.0,
                finished: true,
                seed: 1,
                input: String::new(),
                version: String::new(),
                realtime: true,
                synthetic: None,
                state_hash: None,
                verdict,
                counts: true,
                failed: Vec::new(),
                duration: 1.0,
                targets_done: 1,
                targets: 1,
                score: Some(score),
                categories: Vec::new(),
                metrics: Vec::new(),
            },
            name: None,
        }
    }

    /// The best is that of the same trainee which passed with the highest score; what failed with a higher one, or is of somebody else, is not. After it stand all, in
    /// their order. Whoever has no name has no best.
    #[test]
    fn the_best_own_attempt_comes_first() {
        let own = Some(Id::from_random([1; 16]));
        let other = Some(Id::from_random([2; 16]));
        let sessions = || {
            vec![
                session("d", own, Verdict::Failed, 99.0),
                session("c", own, Verdict::Passed, 70.0),
                session("b", other, Verdict::Passed, 95.0),
                session("a", own, Verdict::Passed, 80.0),
            ]
        };
        let paths = |found: Vec<Reference>| {
            let path = |reference: Reference| match reference.motion {
                Motion::Session(path) => path.display().to_string(),
                Motion::Script(path) => panic!("{path:?}"),
            };
            found.into_iter().map(path).collect::<Vec<_>>()
        };
        let found = offered(sessions(), &debrief(own));
        assert!(
            found[0]
                .title
                .en
                .starts_with("best own attempt: 1970-01-01")
        );
        assert!(found[0].title.de.ends_with("80 Punkte"));
        assert_eq!(paths(found), ["a", "d", "c", "b", "a"]);
        assert_eq!(
            paths(offered(sessions(), &debrief(None))),
            ["d", "c", "b", "a"]
        );
        let many = (0..2 * OTHERS).map(|_| session("x", other, Verdict::Passed, 1.0));
        assert_eq!(offered(many.collect(), &debrief(None)).len(), OTHERS);
    }

    /// A script of two keys, one second apart along x, at 10 Hz: the ghost goes evenly from one to the other, and is over then.
    #[test]
    fn a_script_is_a_track_of_its_tools() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("level1-pass.toml");
        let key = |t: &str, x: &str| {
            format!(
                "[[tool.key]]\nt = \"{t}\"\nposition = [\"{x}\", 0, 0]\norientation = [0, 0, 0, 1]\nopening = 0.5\n"
            )
        };
        let head = "module = \"push-strip\"\nlevel = 1\nrate = \"10 Hz\"\ninterpolation = \"linear\"\n[[tool]]\nname = \"right\"\n";
        let text = format!("{head}{}{}", key("0 s", "0 mm"), key("1 s", "10 mm"));
        std::fs::write(&path, text).expect("a script");
        let slot = |name: &str| ToolSlot {
            name: name.into(),
            model: "forceps".into(),
        };
        let track = of_script(&path, &[slot("left"), slot("right")]).expect("a track");
        assert_eq!(track.end(), 1.0);
        let x = |time: f64| {
            let seen: Vec<_> = track.at(time).collect();
            // The other tool has no motion, and is not there.
            assert_eq!(seen.len(), 1);
            assert_eq!((seen[0].model, seen[0].opening), ("forceps", 0.5));
            seen[0].pose.position[0]
        };
        assert_eq!((x(0.0), x(1.0)), (0.0, 0.01));
        assert!((x(0.35) - 0.003).abs() < 1e-12, "{}", x(0.35));
        assert_eq!(track.at(1.01).count(), 0);
    }

    fn plan() -> RunPlan {
        let words = LocalText::fixed("Streifen", "strip");
        RunPlan {
            module: "push-strip".into(),
            module_title: words.clone(),
            level: 1,
            variant: None,
            level_title: words.clone(),
            level_summary: words,
            seed: 1,
            tick_ns: 8_000_000,
            steps: 1,
            hash_every: 1,
            input: String::new(),
            synthetic: None,
            input_digest: String::new(),
            queue_messages: 1,
            queue_bytes: 1,
            model_error: None,
            changed_files: Vec::new(),
            without: Vec::new(),
            plugins: Vec::new(),
            parts: Vec::new(),
        }
    }

    /// A session of two ticks of 8 ms: a tool is where it was placed in that tick, or else where it was tracked.
    #[test]
    fn a_session_is_a_track_of_its_tools() {
        let header = Header {
            format: RECORD_FORMAT,
            version: String::new(),
            started: 0,
            started_subsec_ns: 0,
            trainee: None,
            id: None,
            unlisted: false,
            realtime: false,
            plan: plan(),
        };
        let pose = |x: f64| Pose {
            position: [x, 0.0, 0.0],
            ..Pose::default()
        };
        let tick = |x: f64| {
            let mut log = Vec::new();
            push(
                &mut log,
                &ToolStates {
                    tools: vec![ToolState {
                        tool: "right".into(),
                        model: "forceps".into(),
                        status: ToolStatus::Tracked,
                        pose: pose(x),
                        opening: 0.5,
                    }],
                },
            );
            push(
                &mut log,
                &ToolPlacements {
                    tick: 0,
                    tools: vec![ToolPlacement {
                        tool: "right".into(),
                        pose: pose(7.0),
                        opening: 0.25,
                    }],
                },
            );
            TickRecord {
                arrival_ns: 0,
                log,
                chain: vec![0; 32],
                states: None,
                failed: false,
            }
        };
        let mut writer = Writer::create(Vec::new()).expect("memory");
        let records = [
            record(kind::HEADER, 0, &header),
            record(kind::TICK, 0, &tick(1.0)),
            record(kind::TICK, 1, &tick(2.0)),
        ];
        for record in records {
            let written = writer.append(record.kind, record.tick, &record.bytes);
            written.expect("memory");
        }
        let bytes = writer.into_inner();
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.session");
        std::fs::write(&path, bytes).expect("written");
        let track = of_session(&path, &AtomicBool::new(false)).expect("a track");
        let seen = |time: f64| {
            let tools: Vec<_> = track.at(time).collect();
            tools
                .iter()
                .map(|tool| (tool.pose.position[0], tool.opening))
                .collect::<Vec<_>>()
        };
        assert_eq!(seen(0.008), [(7.0, 0.25)]);
        assert_eq!(seen(0.016), [(2.0, 0.5)]);
        assert_eq!(track.end(), 0.016);
        let left = of_session(&path, &AtomicBool::new(true)).expect_err("left");
        assert!(left.contains("it was left"), "{left}");
    }
}
