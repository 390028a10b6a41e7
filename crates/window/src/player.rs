//! A recorded session, played in a thread of its own: it computes tick by tick, ahead of what is shown, and paces what is shown by the wall clock. What is computed
//! around the shown tick stays in memory, so that single ticks back need nothing computed again.

use crate::live::Snapshot;
use crate::nearby::Nearby;
use crate::station::{Computation, Recording};
use crate::threads;
use microsim_host::playback::Standing;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Speeds that can be chosen, of simulated time by the wall clock.
pub const SPEEDS: [f64; 5] = [0.25, 0.5, 1.0, 2.0, 4.0];
/// Place of the speed of the recording.
const RECORDED: usize = 2;
/// Ticks that are computed ahead of the one that is shown.
const AHEAD: u64 = 125;
/// Behind by more than this, the schedule moves.
const GIVE_UP: Duration = Duration::from_millis(200);
/// Time over which the rate is measured.
const RATED: Duration = Duration::from_millis(1000);

/// What the viewer asked for.
#[derive(Clone, Debug, Default, PartialEq)]
struct Wish {
    /// The tick to be shown; `None` until there is one.
    goal: Option<u64>,
    plays: bool,
    /// Place in [`SPEEDS`].
    speed: usize,
    /// Whether states have what pictures of the computation show.
    shows_fields: bool,
    ends: bool,
}

/// How far it is.
#[derive(Clone, Debug, Default)]
pub struct State {
    /// Whether the session is read and what computes it is prepared.
    pub is_open: bool,
    /// The ticks that can be shown.
    pub range: Range<u64>,
    /// The tick that is shown.
    pub shown: Option<u64>,
    /// The tick that is to be shown, and which part of what lies before it is computed, from 0 to 1.
    pub working: Option<(u64, f64)>,
    /// What the comparison shows.
    pub standing: Standing,
    /// Plugins whose library is not the one that made the recording.
    pub rebuilt: Vec<String>,
    /// Simulated time by the wall clock, measured over the last second of playing.
    pub rate: Option<f64>,
    /// Why it ended.
    pub failure: Option<String>,
}

/// What both threads see.
#[derive(Default)]
struct Exchange {
    wish: Mutex<Wish>,
    /// The viewer asked for something.
    asked: Condvar,
    /// Nobody looks at it any more, not even at its beginning.
    is_left: AtomicBool,
    state: Mutex<State>,
    latest: Mutex<Option<Snapshot>>,
}

/// A panic of the other thread leaves data that can be read all the same.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A session that is played.
pub struct Player {
    exchange: Arc<Exchange>,
    /// There until it is left.
    thread: Option<JoinHandle<()>>,
}

/// Wakes the window when the thread ends, and states why if it panicked.
struct Ending<'a, F: Fn()> {
    exchange: &'a Exchange,
    wake: &'a F,
}

impl<F: Fn()> Drop for Ending<'_, F> {
    fn drop(&mut self) {
        if std::thread::panicking() {
            let mut state = lock(&self.exchange.state);
            state.failure = Some("the replay panicked: a bug of MicroSim".into());
        }
        (self.wake)();
    }
}

impl Player {
    /// Opens it, and shows a tick once it is computed; `wake` is called whenever there is something new to draw.
    ///
    /// # Errors
    /// If the system has no thread for it.
    pub fn start(
        recording: Box<dyn Recording>,
        tick: u64,
        wake: impl Fn() + Send + 'static,
    ) -> Result<Self, String> {
        let exchange = Arc::new(Exchange {
            wish: Mutex::new(Wish {
                goal: Some(tick),
                speed: RECORDED,
                ..Wish::default()
            }),
            ..Exchange::default()
        });
        let seat = Arc::clone(&exchange);
        let play = move || {
            let ending = Ending {
                exchange: &seat,
                wake: &wake,
            };
            let tick_s = recording.tick();
            let ended = recording.open(&seat.is_left).and_then(|computation| {
                let mut player = Seat {
                    exchange: &seat,
                    computation,
                    tick_s,
                    nearby: Nearby::default(),
                    work: None,
                    shows_fields: false,
                    is_stale: false,
                    has_compared_end: false,
                    wake: &wake,
                };
                player.play()
            });
            if let Err(why) = ended {
                lock(&seat.state).failure = Some(why);
            }
            drop(ending);
        };
        let thread =
            threads::start("replay", play).map_err(|e| format!("no thread for the replay: {e}"))?;
        Ok(Self {
            exchange,
            thread: Some(thread),
        })
    }

    /// Leaves it; its thread, which ends after what it computes now.
    pub fn leave(mut self) -> Option<JoinHandle<()>> {
        self.thread.take()
    }

    /// The state that is to be shown, if it was not taken yet.
    pub fn take(&self) -> Option<Snapshot> {
        lock(&self.exchange.latest).take()
    }

    /// How far it is.
    pub fn state(&self) -> State {
        lock(&self.exchange.state).clone()
    }

    /// The tick that is to be shown.
    pub fn goal(&self) -> Option<u64> {
        lock(&self.exchange.wish).goal
    }

    /// Whether it plays.
    pub fn plays(&self) -> bool {
        lock(&self.exchange.wish).plays
    }

    /// Place of the chosen speed in [`SPEEDS`].
    pub fn speed(&self) -> usize {
        lock(&self.exchange.wish).speed
    }

    fn ask(&self, ask: impl FnOnce(&mut Wish, Range<u64>)) {
        let range = lock(&self.exchange.state).range.clone();
        ask(&mut lock(&self.exchange.wish), range);
        self.exchange.asked.notify_all();
    }

    /// Plays, or pauses. At the end it plays from the beginning.
    pub fn play(&self, plays: bool) {
        self.ask(|wish, range| {
            let is_at_end = wish
                .goal
                .is_some_and(|goal| goal.saturating_add(1) >= range.end);
            if plays && is_at_end && !range.is_empty() {
                wish.goal = Some(range.start);
            }
            wish.plays = plays;
        });
    }

    /// Plays at another one of [`SPEEDS`].
    pub fn set_speed(&self, speed: usize) {
        self.ask(|wish, _| wish.speed = speed.min(SPEEDS.len() - 1));
    }

    /// States have what pictures of the computation show of bodies, or have it no longer; the one that is shown is computed again with it.
    pub fn show_fields(&self, shows: bool) {
        self.ask(|wish, _| wish.shows_fields = shows);
    }

    /// Goes to a tick, or the nearest that there is, and goes on from there as before.
    pub fn go_to(&self, tick: u64) {
        self.ask(|wish, range| wish.goal = Some(clamped(tick, &range)));
    }

    /// Goes to a tick after the one that is to be shown, or before it, and pauses.
    pub fn step(&self, by: i64) {
        self.ask(|wish, range| {
            // What was asked for may lie where there is no tick.
            let goal = clamped(wish.goal.unwrap_or_default(), &range);
            wish.goal = Some(clamped(goal.saturating_add_signed(by), &range));
            wish.plays = false;
        });
    }
}

/// The nearest tick of a range. Before it is known, any.
fn clamped(tick: u64, range: &Range<u64>) -> u64 {
    match range.is_empty() {
        true => tick,
        false => tick.clamp(range.start, range.end - 1),
    }
}

impl Drop for Player {
    /// Its thread ends by itself after what it computes now: preparing tissue may take seconds.
    fn drop(&mut self) {
        self.exchange.is_left.store(true, Ordering::Relaxed);
        self.ask(|wish, _| wish.ends = true);
    }
}

/// Work towards a tick: that tick, and where it began.
struct Towards {
    goal: u64,
    from: u64,
}

/// The side of the thread that computes.
struct Seat<'a> {
    exchange: &'a Exchange,
    computation: Box<dyn Computation>,
    tick_s: f64,
    nearby: Nearby,
    work: Option<Towards>,
    shows_fields: bool,
    /// Whether what is shown lacks something that was asked for since.
    is_stale: bool,
    /// Whether what stands behind the last tick was compared.
    has_compared_end: bool,
    wake: &'a dyn Fn(),
}

/// When the next tick is due, and how fast it goes.
struct Pace {
    next: Instant,
    speed: usize,
    /// When, and from which tick on, the rate is measured.
    since: (Instant, u64),
}

impl Seat<'_> {
    fn play(&mut self) -> Result<(), String> {
        let rebuilt = self.computation.rebuilt();
        self.publish(|state| state.rebuilt = rebuilt);
        let mut pace: Option<Pace> = None;
        loop {
            let wish = lock(&self.exchange.wish).clone();
            if wish.ends {
                return Ok(());
            }
            if wish.shows_fields != self.shows_fields {
                self.shows_fields = wish.shows_fields;
                self.computation.show_fields(wish.shows_fields);
                // What is there without them is computed again.
                (self.nearby, self.work) = (Nearby::default(), None);
                self.is_stale = true;
            }
            let range = self.computation.range();
            let shown = lock(&self.exchange.state).shown;
            let goal = wish.goal.filter(|_| !range.is_empty());
            if let Some(goal) = goal
                && clamped(goal, &range) != goal
            {
                // For both sides: what plays on compares with it.
                let mut wish = lock(&self.exchange.wish);
                if wish.goal == Some(goal) {
                    wish.goal = Some(clamped(goal, &range));
                }
                continue;
            }
            match goal {
                Some(goal) if shown != Some(goal) || self.is_stale => {
                    pace = None;
                    self.approach(goal)?;
                }
                Some(goal) if wish.plays && goal + 1 < range.end => {
                    let going = pace.take().filter(|pace| pace.speed == wish.speed);
                    let mut going = going.unwrap_or_else(|| {
                        lock(&self.exchange.state).rate = None;
                        Pace::new(wish.speed, goal)
                    });
                    self.go_on(goal, &mut going, &wish)?;
                    pace = Some(going);
                }
                Some(goal) if goal + 1 == range.end && (wish.plays || !self.has_compared_end) => {
                    pace = None;
                    self.end(goal)?;
                }
                None if range.is_empty() && !self.has_compared_end => self.compare_end()?,
                _ => {
                    pace = None;
                    self.wait(&wish, None);
                }
            }
        }
    }

    /// Publishes how far it is, with a change.
    fn publish(&self, change: impl FnOnce(&mut State)) {
        let mut state = lock(&self.exchange.state);
        state.is_open = true;
        state.range = self.computation.range();
        state.standing = self.computation.standing();
        change(&mut state);
        let range = state.range.clone();
        state.working = state.working.filter(|(goal, _)| range.contains(goal));
        drop(state);
        (self.wake)();
    }

    /// Waits until something else is asked for than `wish`, or until a moment.
    fn wait(&self, wish: &Wish, until: Option<Instant>) {
        let asked = &self.exchange.asked;
        let now = lock(&self.exchange.wish);
        let is_same = |now: &mut Wish| now == wish;
        match until {
            Some(until) => {
                let left = until.saturating_duration_since(Instant::now());
                drop(asked.wait_timeout_while(now, left, is_same));
            }
            None => drop(asked.wait_while(now, is_same)),
        }
    }

    /// Shows a tick, or computes one tick more of what lies before it.
    fn approach(&mut self, goal: u64) -> Result<(), String> {
        if self.show(goal) {
            return Ok(());
        }
        self.work_towards(goal)?;
        self.show(goal);
        Ok(())
    }

    /// Computes one tick more of those that lead to one, and publishes how far it is.
    fn work_towards(&mut self, goal: u64) -> Result<(), String> {
        if self.work.as_ref().is_none_or(|work| work.goal != goal) {
            // Restoring a state takes a moment, too.
            if self.computation.tick() != goal {
                self.publish(|state| state.working = Some((goal, 0.0)));
            }
            self.computation.seek(goal)?;
            let from = self.computation.tick();
            self.work = Some(Towards { goal, from });
        }
        let from = self.work.as_ref().map_or(goal, |work| work.from);
        self.compute(goal, goal)?;
        if self.computation.tick() <= goal {
            let done = self.computation.tick().saturating_sub(from) as f64;
            let part = (done / (goal + 1 - from.min(goal)) as f64).min(1.0);
            self.publish(|state| state.working = Some((goal, part)));
        }
        Ok(())
    }

    /// Computes one tick of those that lead to one.
    fn compute(&mut self, tick: u64, shown: u64) -> Result<(), String> {
        self.computation.seek(tick)?;
        if let Some(moment) = self.computation.step()? {
            self.nearby.insert(moment, shown);
        }
        Ok(())
    }

    /// Shows a tick if its state is here.
    fn show(&mut self, tick: u64) -> bool {
        let Some(moment) = self.nearby.get(tick) else {
            return false;
        };
        let snapshot = Snapshot::of(moment, (tick + 1) as f64 * self.tick_s);
        *lock(&self.exchange.latest) = Some(snapshot);
        (self.work, self.is_stale) = (None, false);
        self.publish(|state| (state.shown, state.working) = (Some(tick), None));
        true
    }

    /// Plays on from the tick that is shown: the next one if it is due, otherwise what comes later is computed, or the time is waited for.
    fn go_on(&mut self, shown: u64, pace: &mut Pace, wish: &Wish) -> Result<(), String> {
        let now = Instant::now();
        let missing = self.nearby.missing(shown + 1);
        let has_next = missing > shown + 1;
        if now < pace.next && has_next {
            let is_ahead = missing > shown + AHEAD || missing >= self.computation.range().end;
            match is_ahead || !self.nearby.has_room(missing, shown) {
                true => self.wait(wish, Some(pace.next)),
                false => self.compute(missing, shown)?,
            }
            return Ok(());
        }
        if !has_next {
            return self.compute(missing, shown);
        }
        pace.advance(self.tick_s, now);
        if let Some(rate) = pace.rate(shown + 1, self.tick_s, now) {
            lock(&self.exchange.state).rate = Some(rate);
        }
        let mut wish = lock(&self.exchange.wish);
        // Unless something else was asked for meanwhile.
        if wish.goal == Some(shown) && wish.plays {
            wish.goal = Some(shown + 1);
            drop(wish);
            self.show(shown + 1);
        }
        Ok(())
    }

    /// Behind the last tick, which is shown: what stands there is compared as well, and it pauses. Where what computes stands before it, this is one tick more.
    fn end(&mut self, last: u64) -> Result<(), String> {
        if !self.has_compared_end && self.computation.tick() <= last {
            return self.work_towards(last);
        }
        let mut wish = lock(&self.exchange.wish);
        wish.plays &= wish.goal != Some(last);
        drop(wish);
        self.compare_end()
    }

    /// Compares what stands behind all ticks.
    fn compare_end(&mut self) -> Result<(), String> {
        if !self.has_compared_end {
            self.computation.step()?;
            self.has_compared_end = true;
        }
        self.work = None;
        self.publish(|state| state.working = None);
        Ok(())
    }
}

impl Pace {
    fn new(speed: usize, shown: u64) -> Self {
        let now = Instant::now();
        Self {
            next: now,
            speed,
            since: (now, shown),
        }
    }

    fn advance(&mut self, tick_s: f64, now: Instant) {
        if now.saturating_duration_since(self.next) > GIVE_UP {
            self.next = now;
        }
        self.next += Duration::from_secs_f64(tick_s / SPEEDS[self.speed]);
    }

    /// A rate, once it was measured long enough.
    fn rate(&mut self, shown: u64, tick_s: f64, now: Instant) -> Option<f64> {
        let (begin, from) = self.since;
        let passed = now.saturating_duration_since(begin);
        if passed < RATED {
            return None;
        }
        self.since = (now, shown);
        Some((shown - from) as f64 * tick_s / passed.as_secs_f64())
    }
}
