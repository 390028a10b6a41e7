//! A recorded session that is computed again, forth and back, for a viewer.
//!
//! Forth as [`replay`](crate::replay::replay) does it: recorded inputs are fed by tick, everything else is computed and compared with what was recorded. Back
//! by checkpoints in memory, so that a tick that was computed is reached again from one not long before it. What is computed from a checkpoint on is
//! compared like all else. Memory for checkpoints is bounded: where they are too many, every second one goes.
//!
//! After a tick that differs it goes on with what was recorded from outside, and the difference stays in [`Standing`]: what is shown from then on is computed, and
//! not what was recorded. Nothing is written.

use crate::engine::{Checkpoint, Engine};
use crate::error::RunError;
use crate::parallel::Parallel;
use crate::plan::{PlannedPlugin, RunPlan};
use crate::record::{
    Place, Session, SessionError, SessionReader, TickRecord, hex, kind, parse, unreadable,
};
use crate::replay::{
    Difference, engine_of, parallel, recompute_end, recompute_tick, use_installed,
};
use microsim_bus::frame::push_stamped;
use microsim_bus::{Block, Frames, kind_id};
use microsim_session::Reader;
use std::collections::{BTreeMap, BTreeSet};
use std::io::{Read, Seek, SeekFrom};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Ticks from one that is found in the file at once to the next.
const INDEXED: u64 = 64;
/// Simulated time between two checkpoints at first \[ns\].
const SPACING_NS: u64 = 250_000_000;

/// How to play a session.
#[derive(Clone, Debug)]
pub struct PlaybackOptions<'a> {
    /// Threads of the parallel loop.
    pub threads: usize,
    /// Kinds of messages that are shown.
    pub shown: &'a [&'a str],
    /// Most memory for checkpoints \[byte\]; the first and the newest one are there in any case.
    pub memory: usize,
    /// Set from elsewhere while the session is read: it is not played after all.
    pub stop: &'a AtomicBool,
}

/// The latest message of each kind that is shown, stamped, by the id of the kind.
pub type Messages = BTreeMap<u64, Arc<[u8]>>;

/// The state after a tick.
#[derive(Clone, Debug)]
pub struct Moment {
    /// The tick.
    pub tick: u64,
    /// What was published of it and before it.
    pub messages: Messages,
    /// The latest blocks.
    pub blocks: Vec<Block>,
}

/// What the comparison with the recording shows so far.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Standing {
    /// Ticks before this one are compared.
    pub compared: u64,
    /// The first place that is not what was recorded.
    pub difference: Option<Difference>,
    /// Whether all ticks, and what stands behind them, are compared.
    pub is_complete: bool,
    /// Why the ticks may not be all that were computed when it was recorded: the file is torn or damaged, or was cut while it is played.
    pub complaint: Option<String>,
}

/// A checkpoint with what was shown then.
struct Saved {
    checkpoint: Checkpoint,
    messages: Messages,
    bytes: usize,
}

/// A session that is played.
pub struct Playback<R> {
    plan: RunPlan,
    parallel: Option<Parallel>,
    /// All but the ticks.
    session: Session,
    rebuilt: Vec<String>,
    shown: BTreeSet<u64>,
    /// `None` after an error of the source.
    recorded: Option<Reader<R>>,
    /// Whether the reader stands at the next tick, and not somewhere before it.
    is_aligned: bool,
    places: Vec<(u64, Place)>,
    first: u64,
    end: u64,
    /// The next tick.
    tick: u64,
    /// `None` after a failure: it must not be called any more.
    engine: Option<Engine>,
    /// Whether the engine is beyond the last tick, where no tick can follow.
    is_beyond: bool,
    /// Whether the file was cut while it is played: what stands behind its ticks does not belong to the last one.
    is_cut: bool,
    messages: Messages,
    checkpoints: Vec<Saved>,
    memory: usize,
    /// Whether states have what pictures of the computation show.
    shows_fields: bool,
    /// Ticks from one checkpoint to the next.
    spacing: u64,
    standing: Standing,
}

impl<R: Read + Seek> Playback<R> {
    /// Reads a session to its end and prepares what computes it. `locate` gives the installed plugin for a recorded one: library, manifest text and digest.
    ///
    /// # Errors
    /// What keeps the session from being read or computed; that it was stopped.
    pub fn open(
        source: R,
        options: &PlaybackOptions<'_>,
        mut locate: impl FnMut(&PlannedPlugin) -> Result<PlannedPlugin, RunError>,
    ) -> Result<Self, RunError> {
        let mut reader = SessionReader::open(source).map_err(host)?;
        reader.session().check_recomputable().map_err(host)?;
        let mut plan = reader.session().header.plan.clone();
        let rebuilt = use_installed(&mut plan, false, &mut locate)?;
        let parallel = parallel(options.threads)?;
        let mut engine = engine_of(&plan, parallel)?;
        if let Some(checkpoint) = &reader.session().resumed {
            engine.resume(checkpoint)?;
        }
        let first = engine.tick_index();
        let mut places = Vec::new();
        let mut end = first;
        while let Some((tick, _)) = reader.next_tick().map_err(host)? {
            if places.is_empty() || tick.is_multiple_of(INDEXED) {
                places.push((tick, reader.place()));
            }
            end = end.max(tick.saturating_add(1));
            if options.stop.load(Ordering::Relaxed) {
                return Err(RunError::Host("stopped while the session was read".into()));
            }
        }
        let (session, source) = reader.into_parts();
        let mut playback = Self {
            shown: options.shown.iter().map(|name| kind_id(name)).collect(),
            recorded: Some(Reader::at(source, 0, 0)),
            is_aligned: false,
            places,
            first,
            end,
            tick: first,
            engine: Some(engine),
            is_beyond: false,
            is_cut: false,
            messages: Messages::new(),
            checkpoints: Vec::new(),
            memory: options.memory,
            shows_fields: false,
            spacing: (SPACING_NS / plan.tick_ns.max(1)).max(1),
            standing: Standing {
                compared: first,
                complaint: session.complaint.clone(),
                ..Standing::default()
            },
            plan,
            parallel,
            session,
            rebuilt,
        };
        playback.save()?;
        Ok(playback)
    }

    /// All but the ticks.
    pub fn session(&self) -> &Session {
        &self.session
    }

    /// Plugins whose library is not the one that made the recording.
    pub fn rebuilt(&self) -> &[String] {
        &self.rebuilt
    }

    /// The first tick, and the one behind the last that can be computed.
    pub fn range(&self) -> (u64, u64) {
        (self.first, self.end)
    }

    /// The tick that [`Playback::step`] computes next.
    pub fn tick(&self) -> u64 {
        self.tick
    }

    /// What the comparison shows so far.
    pub fn standing(&self) -> &Standing {
        &self.standing
    }

    /// The state hash now, hexadecimal: after the end that of the session. `None` after a failure.
    pub fn state_hash(&self) -> Option<String> {
        self.engine.as_ref().map(|engine| hex(&engine.chain()))
    }

    /// Memory that checkpoints take \[byte\].
    pub fn memory(&self) -> usize {
        self.checkpoints.iter().map(|saved| saved.bytes).sum()
    }

    /// From the next tick on, states have what pictures of the computation show of bodies, or have it no longer.
    pub fn show_fields(&mut self, shows: bool) {
        self.shows_fields = shows;
    }

    /// Computes and compares a tick, and gives the state after it; `None` behind the last one.
    ///
    /// # Errors
    /// If the file cannot be read any more, or the state cannot be saved or restored.
    pub fn step(&mut self) -> Result<Option<Moment>, RunError> {
        if self.tick >= self.end {
            self.compare_end();
            return Ok(None);
        }
        if self.engine.is_none() || self.is_beyond {
            self.seek(self.tick)?;
        }
        let recorded = self.next_record()?;
        let (Some(engine), Some((tick, recorded))) = (&mut self.engine, recorded) else {
            self.end = self.tick;
            self.is_cut = true;
            let tick = self.tick;
            self.standing.complaint = Some(format!(
                "the file was cut while it is played: tick {tick} is not there any more"
            ));
            return Ok(None);
        };
        let computed = match recompute_tick(engine, tick, &recorded) {
            Ok(computed) => computed,
            Err(difference) => {
                self.take_difference(difference);
                (self.engine, self.end) = (None, self.tick);
                return Ok(None);
            }
        };
        let mut blocks = engine.blocks();
        if self.shows_fields {
            blocks.extend(engine.fields());
        }
        for frame in Frames::new(&computed.log).filter_map(Result::ok) {
            if self.shown.contains(&frame.header.kind) {
                let mut bytes = Vec::new();
                push_stamped(&mut bytes, &frame.header, frame.payload);
                self.messages.insert(frame.header.kind, bytes.into());
            }
        }
        if let Some(difference) = computed.difference {
            self.take_difference(difference);
        }
        self.tick = tick + 1;
        self.standing.compared = self.standing.compared.max(self.tick);
        let place = self.place_of(self.tick);
        if (self.tick - self.first).is_multiple_of(self.spacing) && place.is_err() {
            self.save()?;
        }
        Ok(Some(Moment {
            tick,
            messages: self.messages.clone(),
            blocks,
        }))
    }

    /// Goes to the nearest place from which a tick can be computed: there, or at a checkpoint before it. [`Playback::step`] leads on to it.
    ///
    /// # Errors
    /// If the state cannot be restored.
    pub fn seek(&mut self, tick: u64) -> Result<(), RunError> {
        let tick = tick.clamp(self.first, self.end);
        let index = match self.place_of(tick) {
            Ok(index) => index,
            Err(index) => index.saturating_sub(1),
        };
        let nearest = self.checkpoints[index].checkpoint.tick;
        let can_go_on = self.engine.is_some() && !self.is_beyond;
        if can_go_on && (nearest..=tick).contains(&self.tick) {
            return Ok(());
        }
        let mut engine = match self.engine.take() {
            Some(engine) => engine,
            None => engine_of(&self.plan, self.parallel)?,
        };
        let saved = &self.checkpoints[index];
        engine.resume(&saved.checkpoint)?;
        self.messages = saved.messages.clone();
        (self.engine, self.tick) = (Some(engine), nearest);
        (self.is_beyond, self.is_aligned) = (false, false);
        Ok(())
    }

    /// Where the checkpoint of a tick is, or would have to be.
    fn place_of(&self, tick: u64) -> Result<usize, usize> {
        let by_tick = |saved: &Saved| saved.checkpoint.tick.cmp(&tick);
        self.checkpoints.binary_search_by(by_tick)
    }

    /// The record of the next tick; where that is missing, of the one that follows in the file.
    fn next_record(&mut self) -> Result<Option<(u64, TickRecord)>, RunError> {
        let broken = || RunError::Host("the session could not be read before".into());
        let mut reader = self.recorded.take().ok_or_else(broken)?;
        if !self.is_aligned {
            let after = self.places.partition_point(|(tick, _)| *tick <= self.tick);
            if let Some((_, place)) = self.places.get(after.saturating_sub(1)) {
                reader = at(reader, *place)?;
            }
        }
        let found = read_from(&mut reader, self.is_aligned, self.tick);
        self.recorded = Some(reader);
        self.is_aligned = true;
        found
    }

    /// Of differences the first counts, in whatever order they are found.
    fn take_difference(&mut self, found: Difference) {
        let known = self.standing.difference.as_ref();
        if known.is_none_or(|known| found.tick < known.tick) {
            self.standing.difference = Some(found);
        }
    }

    /// Compares what stands behind the ticks, once all of them are the same.
    fn compare_end(&mut self) {
        let Some(engine) = &mut self.engine else {
            return;
        };
        let is_at_end = engine.tick_index() == self.end && self.standing.compared == self.end;
        let has_found = self.standing.is_complete || self.standing.difference.is_some();
        if has_found || self.is_cut || !is_at_end {
            return;
        }
        let found = recompute_end(engine, &self.session);
        self.standing.is_complete = true;
        self.is_beyond = true;
        // A plugin that has failed, as recorded or not, is not called again.
        if found.is_some() || self.session.failed_tick.is_some() {
            self.engine = None;
        }
        self.standing.difference = found;
    }

    /// Adds a checkpoint of the state now; where they take too much memory, every second one goes.
    fn save(&mut self) -> Result<(), RunError> {
        let place = self.place_of(self.tick);
        let (Some(engine), Err(index)) = (&mut self.engine, place) else {
            return Ok(());
        };
        let checkpoint = engine.checkpoint();
        let checkpoint = checkpoint.map_err(|failure| RunError::Host(failure.to_string()))?;
        let states: usize = checkpoint.states.iter().map(|state| state.len()).sum();
        let messages: usize = self.messages.values().map(|bytes| bytes.len()).sum();
        let saved = Saved {
            bytes: states + checkpoint.bus.len() + messages,
            checkpoint,
            messages: self.messages.clone(),
        };
        self.checkpoints.insert(index, saved);
        while self.memory() > self.memory && self.checkpoints.len() > 2 {
            self.spacing = self.spacing.saturating_mul(2);
            let (first, spacing, newest) = (self.first, self.spacing, self.tick);
            self.checkpoints.retain(|saved| {
                let tick = saved.checkpoint.tick;
                tick == newest || (tick - first).is_multiple_of(spacing)
            });
        }
        Ok(())
    }
}

fn host(error: SessionError) -> RunError {
    RunError::Host(error.to_string())
}

/// A reader that stands at a record.
fn at<R: Read + Seek>(reader: Reader<R>, place: Place) -> Result<Reader<R>, RunError> {
    let mut source = reader.into_source();
    let sought = source.seek(SeekFrom::Start(place.offset as u64));
    sought.map_err(|error| host(unreadable(error)))?;
    Ok(Reader::at(source, place.offset, place.sequence))
}

/// The next record of a tick that was computed to its end; where the reader is not aligned, the first one from `tick` on.
fn read_from<R: Read>(
    reader: &mut Reader<R>,
    is_aligned: bool,
    tick: u64,
) -> Result<Option<(u64, TickRecord)>, RunError> {
    loop {
        let frame = reader
            .next_frame()
            .map_err(|error| host(unreadable(error)))?;
        let Some(frame) = frame else {
            return Ok(None);
        };
        if frame.kind != kind::TICK || (!is_aligned && frame.tick < tick) {
            continue;
        }
        let record: TickRecord =
            parse(&frame).map_err(|error| RunError::Host(error.to_string()))?;
        if !record.failed {
            return Ok(Some((frame.tick, record)));
        }
    }
}
