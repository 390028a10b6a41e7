//! The player, with a computation that counts.

use crate::player::{Player, State};
use crate::station::{Computation, Recording};
use microsim_bus::{Block, BlockBuilder};
use microsim_host::playback::{Messages, Moment, Standing};
use microsim_host::replay::Difference;
use microsim_message::{SetupFile, TISSUE_FIELDS};
use microsim_settings::RendererConfig;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// Longest wait for the player on a machine that has other work.
const PATIENCE: Duration = Duration::from_secs(60);
/// Ticks from one checkpoint to the next.
const SPACING: u64 = 50;

/// What it is asked to do.
#[derive(Clone)]
struct Counted {
    range: Range<u64>,
    tick: u64,
    /// The ticks that were computed, in this order.
    computed: Arc<Mutex<Vec<u64>>>,
    standing: Standing,
    /// From here on no tick can be computed.
    breaks_at: Option<u64>,
    /// A panic comes from here on.
    panics_at: Option<u64>,
    /// Reading lasts until this is set.
    is_read: Arc<AtomicBool>,
    /// How often the player went round, at least.
    rounds: Arc<AtomicUsize>,
    /// Reading fails from here on.
    fails_at: Option<u64>,
    tick_s: f64,
    /// Whether states have a block for pictures of the computation.
    shows_fields: bool,
    picture: RendererConfig,
}

impl Counted {
    fn new() -> Self {
        let picture = super::renderer();
        Self {
            range: 0..200,
            tick: 0,
            computed: Arc::default(),
            standing: Standing::default(),
            breaks_at: None,
            fails_at: None,
            panics_at: None,
            is_read: Arc::new(AtomicBool::new(true)),
            rounds: Arc::default(),
            tick_s: 0.001,
            shows_fields: false,
            picture,
        }
    }

    fn play(&self, tick: u64) -> Player {
        Player::start(Box::new(self.clone()), tick, || ()).expect("a thread")
    }
}

/// A session of so many ticks of a length \[s\].
pub(crate) fn counted(ticks: u64, tick_s: f64) -> Box<dyn Recording> {
    Box::new(Counted {
        range: 0..ticks,
        tick_s,
        ..Counted::new()
    })
}

impl Recording for Counted {
    fn picture(&self) -> &RendererConfig {
        &self.picture
    }
    fn files(&self) -> &[SetupFile] {
        &[]
    }
    fn tick(&self) -> f64 {
        self.tick_s
    }
    fn open(self: Box<Self>, is_left: &AtomicBool) -> Result<Box<dyn Computation>, String> {
        while !self.is_read.load(Ordering::Relaxed) {
            if is_left.load(Ordering::Relaxed) {
                return Err("it was left".into());
            }
            std::thread::sleep(Duration::from_millis(1));
        }
        match self.range.end {
            7 => Err("session a.session: it has no header".into()),
            _ => Ok(self),
        }
    }
}

impl Computation for Counted {
    fn range(&self) -> Range<u64> {
        self.rounds.fetch_add(1, Ordering::Relaxed);
        self.range.clone()
    }
    fn tick(&self) -> u64 {
        self.tick
    }
    fn standing(&self) -> Standing {
        self.standing.clone()
    }
    fn rebuilt(&self) -> Vec<String> {
        vec!["counted".into()]
    }
    fn show_fields(&mut self, shows: bool) {
        self.shows_fields = shows;
    }
    fn seek(&mut self, tick: u64) -> Result<(), String> {
        let reached = tick.min(self.standing.compared);
        let checkpoint = reached / SPACING * SPACING;
        if self.tick > tick || self.tick < checkpoint {
            self.tick = checkpoint;
        }
        Ok(())
    }
    fn step(&mut self) -> Result<Option<Moment>, String> {
        if self.fails_at == Some(self.tick) {
            return Err("the disk is gone".into());
        }
        assert_ne!(self.panics_at, Some(self.tick), "a bug");
        if self.breaks_at == Some(self.tick) {
            self.range.end = self.tick;
            let (tick, what) = (self.tick, "tick 120 is missing".into());
            self.standing.difference = Some(Difference { tick, what });
            return Ok(None);
        }
        if self.tick == self.range.end {
            self.standing.is_complete = self.standing.compared == self.range.end;
            return Ok(None);
        }
        let tick = self.tick;
        self.computed.lock().expect("no panic").push(tick);
        self.tick += 1;
        self.standing.compared = self.standing.compared.max(self.tick);
        Ok(Some(Moment {
            tick,
            messages: Messages::new(),
            blocks: match self.shows_fields {
                true => {
                    let words = BlockBuilder::new(TISSUE_FIELDS, "body", 0, tick).finish();
                    vec![Block::new(&words).expect("a block")]
                }
                false => Vec::new(),
            },
        }))
    }
}

#[track_caller]
fn until(player: &Player, what: &str, is_so: impl Fn(&State) -> bool) -> State {
    let start = Instant::now();
    loop {
        let state = player.state();
        if is_so(&state) {
            return state;
        }
        assert!(start.elapsed() < PATIENCE, "{what}: {state:?}");
        std::thread::sleep(Duration::from_millis(2));
    }
}

#[track_caller]
fn shown(player: &Player, tick: u64) -> State {
    until(player, "the tick is shown", |state| {
        state.shown == Some(tick)
    })
}

/// What is shown is computed again with what pictures of the computation show, from the checkpoint before it on, and without it again; no other tick is shown meanwhile.
#[test]
fn what_is_shown_has_fields_once_they_are_asked_for() {
    let counted = Counted::new();
    let player = counted.play(120);
    shown(&player, 120);
    let first = player.take().expect("a state");
    assert_eq!(first.bodies().count(), 0);
    for (shows, blocks) in [(true, 1), (false, 0)] {
        counted.computed.lock().expect("no panic").clear();
        player.show_fields(shows);
        let since = Instant::now();
        let again = loop {
            if let Some(snapshot) = player.take() {
                break snapshot;
            }
            assert!(since.elapsed() < PATIENCE, "nothing is shown");
            std::thread::sleep(Duration::from_millis(2));
        };
        assert_eq!((again.tick, again.bodies().count()), (120, blocks));
        let computed = counted.computed.lock().expect("no panic").clone();
        assert_eq!(computed, (100..=120).collect::<Vec<u64>>());
    }
    // Later ticks have what is asked for then.
    player.show_fields(true);
    player.go_to(121);
    shown(&player, 121);
    let later = player.take().expect("a state");
    assert_eq!((later.tick, later.bodies().count()), (121, 1));
}

#[test]
fn it_opens_at_a_tick_and_steps_back_without_computing() {
    let counted = Counted::new();
    let player = counted.play(37);
    let state = shown(&player, 37);
    assert_eq!(
        (state.range, state.rebuilt),
        (0..200, vec!["counted".into()])
    );
    assert_eq!(state.standing.compared, 38);
    let snapshot = player.take().expect("a state");
    assert_eq!(snapshot.tick, 37);
    assert!((snapshot.time - 0.038).abs() < 1e-12);
    assert!(player.take().is_none(), "each is taken once");

    // Two in quick succession are two.
    player.step(-1);
    player.step(-1);
    shown(&player, 35);
    player.step(1);
    shown(&player, 36);
    assert!(!player.plays());
    let computed: Vec<u64> = (0..=37).collect();
    assert_eq!(*counted.computed.lock().expect("no panic"), computed);
}

#[test]
fn it_plays_to_the_end_pauses_there_and_begins_again() {
    let player = Counted::new().play(0);
    shown(&player, 0);
    player.set_speed(4);
    player.play(true);
    shown(&player, 199);
    let state = until(&player, "the end is compared", |s| s.standing.is_complete);
    assert_eq!(state.standing.compared, 200);
    until(&player, "it pauses", |_| !player.plays());
    player.set_speed(0);
    player.play(true);
    until(&player, "it begins again", |s| s.shown < Some(199));
}

/// Twenty ticks of 10 ms last 0.2 s at the speed of the recording: slower on a busy machine, never faster.
#[test]
fn it_is_paced_by_the_wall_clock() {
    let counted = Counted {
        tick_s: 0.01,
        ..Counted::new()
    };
    let player = counted.play(0);
    shown(&player, 0);
    let start = Instant::now();
    player.play(true);
    until(&player, "it goes on", |s| s.shown >= Some(20));
    // The first tick is due at once.
    assert!(
        start.elapsed() >= Duration::from_millis(185),
        "{:?}",
        start.elapsed()
    );
}

/// While a tick is shown, what lies ahead is computed: a tick of a minute is long enough for all of it.
#[test]
fn it_computes_ahead_of_what_is_shown() {
    let counted = Counted {
        tick_s: 60.0,
        ..Counted::new()
    };
    let player = counted.play(0);
    player.play(true);
    until(&player, "it computes ahead", |_| {
        counted.computed.lock().expect("no panic").len() > 100
    });
    assert!(player.state().shown <= Some(1));
}

/// A session that goes on at a checkpoint has no tick 0, where every replay begins.
#[test]
fn a_session_that_goes_on_is_played() {
    let counted = Counted {
        range: 310..400,
        tick: 310,
        standing: Standing {
            compared: 310,
            ..Standing::default()
        },
        ..Counted::new()
    };
    let player = counted.play(0);
    shown(&player, 310);
    until(&player, "the goal is one that there is", |_| {
        player.goal() == Some(310)
    });
    player.play(true);
    until(&player, "it plays", |state| state.shown > Some(320));
}

/// However far beyond the end was asked for, and whenever: it plays on, or pauses at the end, and does not compute in vain.
#[test]
fn beyond_the_end_it_pauses_at_the_end() {
    // The end, and then to play, before the session is open.
    let counted = Counted {
        is_read: Arc::default(),
        ..Counted::new()
    };
    let player = counted.play(0);
    player.go_to(u64::MAX);
    player.play(true);
    counted.is_read.store(true, Ordering::Relaxed);
    shown(&player, 199);
    until(&player, "it pauses", |_| !player.plays());
    assert_eq!(player.goal(), Some(199));
    // A plot ends one tick behind the last.
    let player = Counted::new().play(200);
    shown(&player, 199);
    until(&player, "the goal is one that there is", |_| {
        player.goal() == Some(199)
    });
    player.play(true);
    until(&player, "it begins again", |s| s.shown < Some(199));
    // What was asked for turns out to be behind the end while it plays.
    let counted = Counted {
        breaks_at: Some(120),
        ..Counted::new()
    };
    let player = counted.play(0);
    shown(&player, 0);
    player.play(true);
    player.go_to(150);
    let state = shown(&player, 119);
    until(&player, "it pauses", |_| !player.plays());
    assert_eq!(player.goal(), Some(119));
    assert_eq!(state.working, None);
}

/// Where the thread panics, the window is woken to show that.
#[test]
fn a_panic_is_stated_and_wakes_the_window() {
    let counted = Counted {
        panics_at: Some(30),
        ..Counted::new()
    };
    let woken = Arc::new(Mutex::new(Vec::new()));
    let exchange: Arc<Mutex<Option<Player>>> = Arc::default();
    let (wakes, seen) = (Arc::clone(&woken), Arc::clone(&exchange));
    let wake = move || {
        let player = seen.lock().expect("no panic");
        let failure = player.as_ref().and_then(|player| player.state().failure);
        wakes.lock().expect("no panic").push(failure);
    };
    let player = Player::start(Box::new(counted), 29, wake).expect("a thread");
    shown(&player, 29);
    *exchange.lock().expect("no panic") = Some(player);
    let ask = |tick| {
        let player = exchange.lock().expect("no panic");
        player.as_ref().expect("it is there").go_to(tick);
    };
    ask(31);
    let start = Instant::now();
    loop {
        let last = woken.lock().expect("no panic").last().cloned().flatten();
        if last.is_some_and(|why| why.contains("panicked")) {
            break;
        }
        assert!(start.elapsed() < PATIENCE, "it is not woken");
        std::thread::sleep(Duration::from_millis(2));
    }
    // Its wake refers to it.
    drop(exchange.lock().expect("no panic").take());
}

/// Whoever leaves it waits for its thread, which does not read on.
#[test]
fn a_replay_that_was_left_ends() {
    let counted = Counted {
        is_read: Arc::default(),
        ..Counted::new()
    };
    let left = counted.play(0).leave().expect("its thread");
    let start = Instant::now();
    while !left.is_finished() {
        assert!(start.elapsed() < PATIENCE, "it reads on");
        std::thread::sleep(Duration::from_millis(2));
    }
}

#[test]
fn it_goes_to_the_nearest_tick_that_there_is() {
    let player = Counted::new().play(500);
    shown(&player, 199);
    until(&player, "the end is compared", |s| s.standing.is_complete);
    player.go_to(100);
    shown(&player, 100);
    player.step(-1000);
    shown(&player, 0);
}

/// A tick that cannot be computed ends what can be shown, and what is before it can be shown still.
#[test]
fn it_ends_where_no_tick_can_be_computed() {
    let counted = Counted {
        breaks_at: Some(120),
        ..Counted::new()
    };
    let player = counted.play(150);
    let state = shown(&player, 119);
    assert_eq!(state.range, 0..120);
    assert_eq!(state.standing.difference.map(|found| found.tick), Some(120));
    player.step(-19);
    shown(&player, 100);
}

#[test]
fn why_it_ended_is_stated() {
    let short = Counted {
        range: 0..7,
        ..Counted::new()
    };
    let state = until(&short.play(0), "why", |state| state.failure.is_some());
    assert!(!state.is_open && state.failure.is_some_and(|why| why.contains("no header")));
    let failing = Counted {
        fails_at: Some(60),
        ..Counted::new()
    };
    let player = failing.play(59);
    shown(&player, 59);
    player.step(1);
    let state = until(&player, "why", |state| state.failure.is_some());
    assert_eq!(state.failure.as_deref(), Some("the disk is gone"));
}

/// A session that was killed before its first tick.
#[test]
fn there_may_be_no_tick() {
    let empty = Counted {
        range: 0..0,
        ..Counted::new()
    };
    let player = empty.play(3);
    until(&player, "the end is compared", |s| s.standing.is_complete);
    let asks: [&dyn Fn(); 3] = [&|| player.play(true), &|| player.go_to(5), &|| {
        player.step(-1)
    }];
    for ask in asks {
        let before = empty.rounds.load(Ordering::Relaxed);
        ask();
        until(&player, "it goes round", |_| {
            empty.rounds.load(Ordering::Relaxed) > before
        });
    }
    let state = player.state();
    assert_eq!((state.shown, state.failure), (None, None));
}
