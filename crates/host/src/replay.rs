//! Recomputes a recorded session in this process: recorded inputs are fed by tick, everything else is computed again
//! and compared.

use crate::engine::{Engine, Feed};
use crate::error::RunError;
use crate::fault::Failure;
use crate::loader::load;
use crate::parallel::Parallel;
use crate::picture::{PicturePlan, PictureReport, Pictures, start_pictures};
use crate::plan::{PlannedPlugin, PluginKind, RunPlan};
use crate::record::{Ended, Session, SessionError, SessionReader, TickRecord, hex};
use crate::span;

use microsim_bus::Frames;
use std::io::Read;

/// How to replay.
#[derive(Clone, Debug)]
pub struct ReplayOptions {
    /// Threads of the parallel loop.
    pub threads: usize,
    /// Pictures, if wanted.
    pub pictures: Option<PicturePlan>,
    /// What draws them, where the recording has none.
    pub renderer: Option<PlannedPlugin>,
}

/// The first place where the replay is not what was recorded.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Difference {
    /// Tick.
    pub tick: u64,
    /// What differs, one sentence.
    pub what: String,
}

/// A replay that ended.
#[derive(Clone, Debug)]
pub struct ReplayOutcome {
    /// Ticks recomputed.
    pub ticks: u64,
    /// The first difference, if there is one; the replay ends there.
    pub difference: Option<Difference>,
    /// The state hash at the end, hexadecimal.
    pub state_hash: String,
    /// The state hash of the recording, if it was closed.
    pub recorded_hash: Option<String>,
    /// Plugins whose library is not the one that made the recording.
    pub rebuilt: Vec<String>,
    /// What came of the pictures.
    pub pictures: Option<PictureReport>,
}

/// Replays a session. `locate` gives the installed plugin for a recorded one: library, manifest text and digest.
pub fn replay<R: Read>(
    reader: &mut SessionReader<R>,
    options: ReplayOptions,
    mut locate: impl FnMut(&PlannedPlugin) -> Result<PlannedPlugin, RunError>,
) -> Result<ReplayOutcome, RunError> {
    let host = |e: SessionError| RunError::Host(e.to_string());
    reader.session().check_recomputable().map_err(host)?;
    let mut plan = reader.session().header.plan.clone();
    if let Some(renderer) = options.renderer {
        plan.plugins.retain(|p| p.kind != PluginKind::Renderer);
        plan.plugins.push(renderer);
    }
    let draws = options.pictures.is_some();
    let rebuilt = use_installed(&mut plan, draws, &mut locate)?;
    let mut engine = engine_of(&plan, parallel(options.threads)?)?;
    if let Some(checkpoint) = &reader.session().resumed {
        engine.resume(checkpoint)?;
    }
    let mut pictures = start_pictures(&plan, options.pictures, true)?;
    let difference = recompute(&mut engine, &plan, reader, &mut pictures).map_err(host)?;
    let end = &reader.session().end;
    let outcome = ReplayOutcome {
        ticks: engine.tick_index(),
        difference,
        state_hash: hex(&engine.chain()),
        recorded_hash: end.as_ref().map(|e| hex(&e.chain)),
        rebuilt,
        pictures: None,
    };
    engine.stop();
    Ok(ReplayOutcome {
        pictures: pictures.map(Pictures::finish),
        ..outcome
    })
}

/// Puts the installed plugins in the place of those of a recorded plan; those come back whose library is not the one that made the recording.
pub(crate) fn use_installed(
    plan: &mut RunPlan,
    draws: bool,
    locate: &mut dyn FnMut(&PlannedPlugin) -> Result<PlannedPlugin, RunError>,
) -> Result<Vec<String>, RunError> {
    let mut rebuilt = Vec::new();
    // The input is in the ticks, and nothing is recorded again.
    for plugin in &mut plan.plugins {
        let drawn = plugin.kind == PluginKind::Renderer && draws;
        if plugin.kind.is_observer() && !drawn {
            continue;
        }
        // Sources too: what is installed decides which plugins are sources, and what a source may publish.
        let mut located = locate(plugin)?;
        located.hosting.lift_deadline();
        if located.library_hash != plugin.library_hash && plugin.kind != PluginKind::Source {
            rebuilt.push(plugin.name.clone());
        }
        *plugin = located;
    }
    Ok(rebuilt)
}

/// The threads of a replay; `None` for one, that of the caller.
pub(crate) fn parallel(threads: usize) -> Result<Option<Parallel>, RunError> {
    match threads {
        0 | 1 => Ok(None),
        n => Parallel::new(n).map(Some).map_err(RunError::Host),
    }
}

/// An engine at the beginning of a plan, without its sources.
pub(crate) fn engine_of(plan: &RunPlan, parallel: Option<Parallel>) -> Result<Engine, RunError> {
    Engine::new(plan, plan.limits(), parallel, |planned| {
        if planned.kind == PluginKind::Source {
            return Ok(None);
        }
        load(planned).map(Some).map_err(RunError::from)
    })
}

fn recompute<R: Read>(
    engine: &mut Engine,
    plan: &RunPlan,
    reader: &mut SessionReader<R>,
    pictures: &mut Option<Pictures>,
) -> Result<Option<Difference>, SessionError> {
    while let Some((tick, recorded)) = reader.next_tick()? {
        let _tick = span::of_tick(tick);
        let difference = match recompute_tick(engine, tick, &recorded) {
            Err(difference) => Some(difference),
            Ok(computed) => {
                if let Some(pictures) = pictures {
                    pictures.handle(tick, plan.tick_ns, &computed.log, engine);
                }
                computed.difference
            }
        };
        if difference.is_some() {
            // To the end all the same: its signatures stand there.
            while reader.next_tick()?.is_some() {}
            return Ok(difference);
        }
    }
    Ok(recompute_end(engine, reader.session()))
}

fn difference(tick: u64, what: String) -> Difference {
    Difference { tick, what }
}

impl From<&Failure> for Difference {
    fn from(failure: &Failure) -> Self {
        difference(failure.tick, failure.to_string())
    }
}

/// A recorded tick that was computed again.
pub(crate) struct Recomputed {
    /// All messages that it gave.
    pub log: Vec<u8>,
    /// In what it is not what was recorded.
    pub difference: Option<Difference>,
}

/// Computes a recorded tick again. `Err`: it could not be computed, and none after it can be.
pub(crate) fn recompute_tick(
    engine: &mut Engine,
    tick: u64,
    recorded: &TickRecord,
) -> Result<Recomputed, Difference> {
    if tick != engine.tick_index() {
        let missing = engine.tick_index();
        let what = format!("the recording goes on at tick {tick}, tick {missing} is missing");
        return Err(difference(tick, what));
    }
    let output = engine.tick(Feed::Recorded { log: &recorded.log });
    let output = output.map_err(|failure| Difference::from(&failure))?;
    // The hash alone is not enough: whoever changes a recorded message need not touch it.
    let is_same = output.chain.as_slice() == recorded.chain && output.log == recorded.log;
    let mut found = (!is_same).then(|| difference(tick, describe(engine, recorded, &output.log)));
    if let Some(states) = &recorded.states {
        match engine.state_digests(states) {
            // What differs first is what counts.
            Err(failure) => return Err(found.unwrap_or_else(|| Difference::from(&failure))),
            Ok(computed) if computed != *states => {
                let pairs = computed.iter().zip(states);
                let names = pairs
                    .filter(|(a, b)| a != b)
                    .map(|(a, _)| a.plugin.as_str());
                let names = names.collect::<Vec<_>>().join(", ");
                let what = || difference(tick, format!("the state of {names} differs"));
                found.get_or_insert_with(what);
            }
            Ok(_) => {}
        }
    }
    Ok(Recomputed {
        log: output.log,
        difference: found,
    })
}

/// What stands behind the ticks: one in which a plugin failed, and how the run ended.
pub(crate) fn recompute_end(engine: &mut Engine, session: &Session) -> Option<Difference> {
    if let Some((tick, recorded)) = &session.failed_tick {
        let refailed = refail(engine, session, *tick, recorded);
        if refailed.is_some() {
            return refailed;
        }
    }
    let end = session.end.as_ref()?;
    let tick = engine.tick_index();
    // After a failure no states are saved, and the hash is that of the last tick.
    if (end.ended == Ended::Failure) == session.failures.is_empty() {
        let what = "the end and the recorded failures contradict";
        return Some(difference(tick, what.into()));
    }
    if end.ended != Ended::Failure
        && let Err(failure) = engine.state_digests(&end.states)
    {
        return Some(Difference::from(&failure));
    }
    match engine.chain().as_slice() == end.chain {
        true => None,
        false => Some(difference(tick, "the state hash at the end differs".into())),
    }
}

/// The tick in which a plugin failed must fail again, for the same plugin. One that failed outside of what a replay
/// computes (a source, the recorder) cannot, and proves nothing.
fn refail(
    engine: &mut Engine,
    session: &Session,
    tick: u64,
    recorded: &TickRecord,
) -> Option<Difference> {
    let failure = session.failures.first()?;
    let plan = &session.header.plan;
    let plugin = plan.plugins.iter().find(|p| p.name == failure.plugin)?;
    if plugin.kind == PluginKind::Source || plugin.kind.is_observer() {
        return None;
    }
    // That its process has ended is an input, and not computed again. Only a plugin that may have a process of its own can have lost it.
    if failure.ended && plugin.kind.can_be_isolated() {
        return None;
    }
    let what = match engine.tick(Feed::Recorded { log: &recorded.log }) {
        Err(again) if again.plugin == failure.plugin => return None,
        Err(again) => format!("recorded was: {failure}; computed: {again}"),
        Ok(_) => format!("recorded was: {failure}; computed without a failure"),
    };
    Some(difference(tick, what))
}

/// Which message is the first that differs.
fn describe(engine: &Engine, recorded: &TickRecord, log: &[u8]) -> String {
    let name = |frame: &microsim_bus::Frame<'_>| {
        let kind = engine.kind_name(frame.header.kind).unwrap_or("unknown");
        format!(
            "\"{kind}\" of \"{}\"",
            engine.sender_name(frame.header.sender)
        )
    };
    let mut old = Frames::new(&recorded.log).filter_map(Result::ok);
    let mut new = Frames::new(log).filter_map(Result::ok);
    loop {
        match (old.next(), new.next()) {
            (Some(a), Some(b)) if a == b => {}
            (Some(a), Some(b)) if a.header.kind == b.header.kind => {
                let json = |f: &microsim_bus::Frame<'_>| {
                    microsim_message::to_json(f.payload)
                        .map(|v| v.to_string())
                        .unwrap_or_default()
                };
                return format!(
                    "message {} differs: recorded {}, computed {}",
                    name(&a),
                    json(&a),
                    json(&b)
                );
            }
            (Some(a), Some(b)) => {
                return format!("message {} was recorded, {} computed", name(&a), name(&b));
            }
            (Some(a), None) => {
                return format!("message {} was recorded and not computed", name(&a));
            }
            (None, Some(b)) => {
                return format!("message {} was computed and not recorded", name(&b));
            }
            (None, None) => {
                return "an input, a block or the running hash differs from what was recorded"
                    .into();
            }
        }
    }
}
