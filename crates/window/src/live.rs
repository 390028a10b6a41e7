//! A run in a thread of its own, and what the window exchanges with it: wishes for the tools go there, the newest snapshot comes back. No queue of snapshots:
//! one that was not drawn when the next is finished is dropped.

use crate::hands;
use crate::ledger::Debrief;
use crate::pace::Pace;
use crate::station::LiveSession;
use crate::steering::Steering;
use crate::threads;
use microsim_audio::{Cues, Player};
use microsim_bus::{Block, BlockView, Frames, kind_id};
use microsim_host::playback::{Messages, Moment};
use microsim_host::run::{Operator, Seen};
use microsim_message::{
    ContactForces, DesktopInput, InputSample, InputTiming, LevelEvent, LevelState, Message,
    MicroscopeView, ObjectScene, SolverTick, TissueCut, ToolPlacements, ToolStates, decode, push,
};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// The newest state of a run.
#[derive(Clone, Debug)]
pub struct Snapshot {
    /// Its tick.
    pub tick: u64,
    /// Simulated time \[s\].
    pub time: f64,
    /// When it was finished.
    pub finished: Instant,
    /// The latest message of each kind that is shown, stamped.
    messages: Messages,
    blocks: Vec<Block>,
}

/// For so long no picture begins while ticks are overdue.
const LONGEST_WAIT: Duration = Duration::from_millis(500);

/// Kinds of messages of which a screen shows the latest.
pub const SHOWN: [&str; 5] = [
    ObjectScene::KIND,
    ToolStates::KIND,
    ToolPlacements::KIND,
    ContactForces::KIND,
    LevelState::KIND,
];

impl Snapshot {
    /// A tick of a recording, at this simulated time \[s\].
    pub fn of(moment: &Moment, time: f64) -> Self {
        Self {
            tick: moment.tick,
            time,
            finished: Instant::now(),
            messages: moment.messages.clone(),
            blocks: moment.blocks.clone(),
        }
    }

    /// The latest message of a kind.
    pub fn latest<M: Message>(&self) -> Option<M> {
        let bytes = self.messages.get(&kind_id(M::KIND))?;
        let frame = Frames::new(bytes).next()?.ok()?;
        decode::<M>(&frame)?.ok()
    }

    /// What is known of the bodies.
    pub fn bodies(&self) -> impl Iterator<Item = BlockView<'_>> {
        self.blocks.iter().map(Block::view)
    }
}

/// What came of a run that has ended.
pub type Ended = Result<Box<Debrief>, String>;

/// What mouse and keyboard ask for with the next tick.
#[derive(Default)]
struct Wishes {
    of_tools: Vec<DesktopInput>,
    /// When the first of it was asked for.
    since: Option<Instant>,
}

/// What both threads see.
#[derive(Default)]
struct Exchange {
    /// When the newest snapshot was taken to be drawn.
    taken: Mutex<Option<Instant>>,
    /// Whether the last tick began late by more than a tick.
    is_overdue: AtomicBool,
    wishes: Mutex<Wishes>,
    /// What gamepads and SpaceMice move: asked with each tick, so that it does not depend on pictures.
    steering: Mutex<Option<Steering>>,
    view: Mutex<Option<MicroscopeView>>,
    /// What has tones, and who plays them.
    tones: Mutex<Option<(Cues, Player)>>,
    latest: Mutex<Option<Snapshot>>,
    pace: Mutex<Pace>,
    events: Mutex<Vec<LevelEvent>>,
    /// From the beginning: the first tick is computed, so that there is something to see.
    is_paused: AtomicBool,
    has_first_tick: AtomicBool,
    stop: AtomicBool,
    /// Whether snapshots have what pictures of the computation show.
    shows_fields: AtomicBool,
}

impl Exchange {
    /// Whether a picture may begin. A software driver draws on the cores that compute: while ticks are overdue they have these for themselves, but for a picture now and then.
    fn draws(&self) -> bool {
        let waits = |at: Instant| at.elapsed() < LONGEST_WAIT;
        !self.is_overdue.load(Ordering::Relaxed)
            || self.is_paused.load(Ordering::Relaxed)
            || !lock(&self.taken).is_some_and(waits)
    }
}

/// A panic of the other thread leaves data that can be read all the same.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A run that goes on.
pub struct Live {
    exchange: Arc<Exchange>,
    thread: Option<JoinHandle<Ended>>,
}

impl Live {
    /// Starts it, paused after its first tick; `wake` is called whenever there is something new to draw.
    ///
    /// # Errors
    /// If the system has no thread for it.
    pub fn start(
        mut session: Box<dyn LiveSession>,
        wake: impl Fn() + Send + 'static,
    ) -> Result<Self, String> {
        let exchange = Arc::new(Exchange {
            is_paused: AtomicBool::new(true),
            ..Exchange::default()
        });
        let seat = Arc::clone(&exchange);
        let mirrored = session.picture().mirrored;
        let run = move || {
            let mut operator = Seat {
                exchange: &seat,
                messages: Messages::new(),
                mirrored,
                wake: &wake,
            };
            let outcome = session.run(&seat.stop, &mut operator);
            let ended = outcome.and_then(|outcome| session.finish(&outcome).map(Box::new));
            wake();
            ended
        };
        let thread = threads::start("simulation", run)
            .map_err(|e| format!("no thread for the simulation: {e}"))?;
        Ok(Self {
            exchange,
            thread: Some(thread),
        })
    }

    /// The newest snapshot, if there is one that was not taken yet and ticks leave time for a picture.
    pub fn take(&self) -> Option<Snapshot> {
        let has_ended = self.thread.as_ref().is_none_or(JoinHandle::is_finished);
        if !has_ended && !self.exchange.draws() {
            return None;
        }
        let newest = lock(&self.exchange.latest).take()?;
        *lock(&self.exchange.taken) = Some(Instant::now());
        Some(newest)
    }

    /// How well it follows the wall clock.
    pub fn pace(&self) -> Pace {
        lock(&self.exchange.pace).clone()
    }

    /// What happened so far.
    pub fn events(&self) -> Vec<LevelEvent> {
        lock(&self.exchange.events).clone()
    }

    /// Asks for a motion of a tool with the next tick.
    pub fn wish(&self, wish: DesktopInput) {
        let mut wishes = lock(&self.exchange.wishes);
        wishes.since.get_or_insert_with(Instant::now);
        let mut of_tools = wishes.of_tools.iter_mut();
        match of_tools.find(|earlier| earlier.tool == wish.tool) {
            None => wishes.of_tools.push(wish),
            Some(earlier) => {
                for k in 0..3 {
                    earlier.shift[k] += wish.shift[k];
                    earlier.turn[k] += wish.turn[k];
                }
                earlier.opening = wish.opening.or(earlier.opening);
            }
        }
    }

    /// What gamepads and SpaceMice move from now on; `None`: nothing.
    pub fn steer(&self, mut steering: Option<Steering>) {
        let mut current = lock(&self.exchange.steering);
        match (&*current, &mut steering) {
            (Some(before), Some(now)) if before.grasp.tool == now.grasp.tool => {
                now.grasp.is_closed = before.grasp.is_closed;
            }
            (before, _) => {
                let released = before.as_ref().and_then(|before| before.grasp.release());
                released.into_iter().for_each(|wish| self.wish(wish));
            }
        }
        if let (None, Some(now)) = (&*current, &steering) {
            now.controllers.skip();
        }
        *current = steering;
    }

    /// Plays tones of what happens from now on.
    pub fn play_tones(&self, cues: Cues, player: Player) {
        *lock(&self.exchange.tones) = Some((cues, player));
    }

    /// Records how the microscope is set, with the next tick.
    pub fn look(&self, view: MicroscopeView) {
        *lock(&self.exchange.view) = Some(view);
    }

    /// From the next tick on, snapshots have what pictures of the computation show of bodies, or have it no longer.
    pub fn show_fields(&self, shows: bool) {
        self.exchange.shows_fields.store(shows, Ordering::Relaxed);
    }

    /// Whether it pauses.
    pub fn is_paused(&self) -> bool {
        self.exchange.is_paused.load(Ordering::Relaxed)
    }

    /// Pauses it, or lets it go on.
    pub fn pause(&self, paused: bool) {
        self.exchange.is_paused.store(paused, Ordering::Relaxed);
    }

    /// Ends it without a verdict.
    pub fn abort(&self) {
        self.exchange.stop.store(true, Ordering::Relaxed);
    }

    /// What came of it, once it has ended; `None` before, and after it was given.
    pub fn ended(&mut self) -> Option<Ended> {
        if !self.thread.as_ref().is_some_and(JoinHandle::is_finished) {
            return None;
        }
        let joined = self.thread.take()?.join();
        Some(joined.unwrap_or_else(|_| {
            Err("the simulation panicked; what was recorded so far is safe".into())
        }))
    }
}

impl Drop for Live {
    /// A window that is closed ends the run and waits until its session is closed.
    fn drop(&mut self) {
        self.abort();
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// The operator's side in the thread of the run.
struct Seat<'a> {
    exchange: &'a Exchange,
    messages: Messages,
    /// Whether the picture is mirrored: what is asked for in it is not what the field has to do.
    mirrored: bool,
    wake: &'a dyn Fn(),
}

impl Seat<'_> {
    fn is_shown(kind: u64) -> bool {
        SHOWN.iter().any(|shown| kind_id(shown) == kind)
    }
}

impl Operator for Seat<'_> {
    fn send(&mut self, frames: &mut Vec<u8>) {
        let wishes = std::mem::take(&mut *lock(&self.exchange.wishes));
        let mut all = wishes.of_tools;
        if let Some(steering) = &mut *lock(&self.exchange.steering) {
            all.extend(steering.grasp.wish(steering.controllers.take()));
        }
        for wish in all {
            let wish = match self.mirrored {
                true => hands::mirrored(wish),
                false => wish,
            };
            push(frames, &wish);
        }
        if let Some(since) = wishes.since {
            lock(&self.exchange.pace)
                .waits
                .push(since.elapsed().as_secs_f64());
        }
        if let Some(view) = lock(&self.exchange.view).take() {
            push(frames, &view);
        }
    }

    fn is_paused(&self) -> bool {
        let exchange = self.exchange;
        let is_paused = exchange.has_first_tick.load(Ordering::Relaxed)
            && exchange.is_paused.load(Ordering::Relaxed);
        if let Some(steering) = lock(&exchange.steering).as_ref().filter(|_| is_paused) {
            steering.controllers.skip();
        }
        is_paused
    }

    fn see(&mut self, mut seen: Seen<'_>) {
        let mut solver: Option<SolverTick> = None;
        let mut tones = lock(&self.exchange.tones);
        let mut pace = lock(&self.exchange.pace);
        for frame in Frames::new(seen.log).filter_map(Result::ok) {
            if Self::is_shown(frame.header.kind) {
                let mut bytes = Vec::new();
                microsim_bus::frame::push_stamped(&mut bytes, &frame.header, frame.payload);
                self.messages.insert(frame.header.kind, bytes.into());
            }
            if let Some(Ok(event)) = decode::<LevelEvent>(&frame) {
                lock(&self.exchange.events).push(event);
            } else if let Some(Ok(tick)) = decode::<SolverTick>(&frame) {
                solver = Some(tick);
            } else if let Some(Ok(timing)) = decode::<InputTiming>(&frame) {
                pace.add(&timing);
            } else if let Some(Ok(sample)) = decode::<InputSample>(&frame) {
                pace.add_sample(&sample);
            } else if let Some((cues, player)) = &mut *tones {
                if let Some(Ok(forces)) = decode::<ContactForces>(&frame) {
                    let tones = cues.of_forces(&forces, seen.time).into_iter();
                    tones.for_each(|tone| player.play(tone));
                } else if let Some(Ok(cut)) = decode::<TissueCut>(&frame) {
                    let tone = cues.of_cut(&cut, seen.time).into_iter();
                    tone.for_each(|tone| player.play(tone));
                }
            }
        }
        drop(tones);
        // Ticks are counted from 0, and the time is that of their end.
        let length = seen.time / (seen.tick + 1) as f64;
        let is_overdue = pace.add_tick(length, seen.lateness, seen.duration);
        pace.late = seen.late_ticks;
        if let Some(solver) = solver {
            pace.unconverged += u64::from(solver.unconverged > 0);
            pace.held += u64::from(!solver.valid);
        }
        drop(pace);
        let exchange = self.exchange;
        exchange.is_overdue.store(is_overdue, Ordering::Relaxed);
        exchange.has_first_tick.store(true, Ordering::Relaxed);
        let mut blocks = seen.blocks();
        if exchange.shows_fields.load(Ordering::Relaxed) {
            blocks.extend(seen.fields());
        }
        *lock(&exchange.latest) = Some(Snapshot {
            tick: seen.tick,
            time: seen.time,
            finished: Instant::now(),
            messages: self.messages.clone(),
            blocks,
        });
        if exchange.draws() {
            (self.wake)();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// While ticks are overdue a picture begins only where none has for long, or nothing is computed.
    #[test]
    fn overdue_ticks_go_before_pictures() {
        let exchange = Exchange::default();
        let taken = |since: Duration| {
            *lock(&exchange.taken) = Instant::now().checked_sub(since);
            exchange.draws()
        };
        assert!(exchange.draws() && taken(Duration::ZERO));
        exchange.is_overdue.store(true, Ordering::Relaxed);
        assert!(!taken(Duration::ZERO) && taken(LONGEST_WAIT));
        exchange.is_paused.store(true, Ordering::Relaxed);
        assert!(taken(Duration::ZERO));
    }
}
