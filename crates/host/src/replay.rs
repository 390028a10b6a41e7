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
    let mut rebuilt = Vec::new();
    // The input is in the ticks, and nothing is recorded again.
    for plugin in &mut plan.plugins {
        let drawn = plugin.kind == PluginKind::Renderer && options.pictures.is_some();
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
    let parallel = match options.threads {
        0 | 1 => None,
        n => Some(Parallel::new(n).map_err(RunError::Host)?),
    };
    let mut engine = Engine::new(&plan, plan.limits(), parallel, |planned| {
        if planned.kind == PluginKind::Source {
            return Ok(None);
        }
        load(planned).map(Some).map_err(RunError::from)
    })?;
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

fn recompute<R: Read>(
    engine: &mut Engine,
    plan: &RunPlan,
    reader: &mut SessionReader<R>,
    pictures: &mut Option<Pictures>,
) -> Result<Option<Difference>, SessionError> {
    while let Some((tick, recorded)) = reader.next_tick()? {
        let difference = recompute_tick(engine, plan, (tick, &recorded), pictures);
        if difference.is_some() {
            // To the end all the same: its signatures stand there.
            while reader.next_tick()?.is_some() {}
            return Ok(difference);
        }
    }
    Ok(recompute_end(engine, reader.session()))
}

fn differs(tick: u64, what: String) -> Option<Difference> {
    Some(Difference { tick, what })
}

fn failed(failure: &Failure) -> Option<Difference> {
    differs(failure.tick, failure.to_string())
}

fn recompute_tick(
    engine: &mut Engine,
    plan: &RunPlan,
    (tick, recorded): (u64, &TickRecord),
    pictures: &mut Option<Pictures>,
) -> Option<Difference> {
    if tick != engine.tick_index() {
        let missing = engine.tick_index();
        let what = format!("the recording goes on at tick {tick}, tick {missing} is missing");
        return differs(tick, what);
    }
    let _tick = span::of_tick(tick);
    let output = match engine.tick(Feed::Recorded { log: &recorded.log }) {
        Ok(output) => output,
        Err(failure) => return failed(&failure),
    };
    if let Some(pictures) = pictures {
        pictures.handle(tick, plan.tick_ns, &output.log, || engine.blocks());
    }
    // The hash alone is not enough: whoever changes a recorded message need not touch it.
    if output.chain.as_slice() != recorded.chain || output.log != recorded.log {
        return differs(tick, describe(engine, recorded, &output.log));
    }
    let states = recorded.states.as_ref()?;
    match engine.state_digests(states) {
        Err(failure) => failed(&failure),
        Ok(computed) if computed != *states => {
            let names: Vec<&str> = computed
                .iter()
                .zip(states)
                .filter(|(a, b)| a != b)
                .map(|(a, _)| a.plugin.as_str())
                .collect();
            differs(tick, format!("the state of {} differs", names.join(", ")))
        }
        Ok(_) => None,
    }
}

/// What stands behind the ticks: one in which a plugin failed, and how the run ended.
fn recompute_end(engine: &mut Engine, session: &Session) -> Option<Difference> {
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
        return differs(tick, "the end and the recorded failures contradict".into());
    }
    if end.ended != Ended::Failure
        && let Err(failure) = engine.state_digests(&end.states)
    {
        return failed(&failure);
    }
    match engine.chain().as_slice() == end.chain {
        true => None,
        false => differs(tick, "the state hash at the end differs".into()),
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
    Some(Difference { tick, what })
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
