//! A film of a replay: a section of the session is computed again in a thread of its own, drawn as the viewer sees it, and handed to the station picture by picture.

use crate::films::{Film, Filmed};
use crate::live::Snapshot;
use crate::station::{Computation, Recording};
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;

/// Pictures in a second of simulated time.
pub const RATE: f64 = 25.0;
/// Width and height of the pictures \[pixels\].
pub const SIZE: [u32; 2] = [1280, 720];

/// Draws a snapshot as a PNG.
pub type Camera = Box<dyn FnMut(&Snapshot) -> Result<Vec<u8>, String>>;
/// Makes a camera, in the thread that draws.
pub type MakeCamera = Box<dyn FnOnce() -> Result<Camera, String> + Send>;

/// The ticks of a film from one to another, both included: the last one that is over at each of its times, [`RATE`] of them in a second.
pub fn ticks(from: u64, to: u64, tick_s: f64) -> impl Iterator<Item = u64> {
    // Rounding must not take the tick that ends just then.
    let ended = move |k: u64| (from + 1) as f64 + k as f64 / (RATE * tick_s) + 1e-6;
    (0..)
        .map(ended)
        .take_while(move |ended| *ended < (to + 1) as f64 + 1e-3)
        .map(|ended| (ended as u64).saturating_sub(1))
}

/// How far it is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Part {
    /// Pictures that are written.
    pub written: u32,
    /// Pictures that there will be; 0 before that is known.
    pub of: u32,
    /// Which part of all ticks is computed, from 0 to 1.
    pub computed: f64,
}

/// A film that is being made.
pub struct Filming {
    is_stopped: Arc<AtomicBool>,
    part: Arc<Mutex<Part>>,
    /// There until it ended.
    thread: Option<JoinHandle<Result<Filmed, String>>>,
}

/// What a film is made of.
pub struct Scene {
    /// The session.
    pub recording: Box<dyn Recording>,
    /// First and last tick.
    pub section: [u64; 2],
    /// Whether pictures show what has to be computed for them alone.
    pub shows_fields: bool,
    /// What draws.
    pub camera: MakeCamera,
    /// Where the pictures go.
    pub film: Box<dyn Film>,
}

impl Filming {
    /// Starts it; `wake` is called whenever there is something new to show.
    ///
    /// # Errors
    /// If the system has no thread for it.
    pub fn start(scene: Scene, wake: impl Fn() + Send + 'static) -> Result<Self, String> {
        let is_stopped = Arc::new(AtomicBool::new(false));
        let part = Arc::new(Mutex::new(Part::default()));
        let (seat, seen) = (Arc::clone(&is_stopped), Arc::clone(&part));
        let run = move || {
            let made = make(scene, &seat, &mut |part| {
                *seen.lock().unwrap_or_else(PoisonError::into_inner) = part;
                wake();
            });
            wake();
            made
        };
        // It has the priority of drawing: what is played meanwhile goes before.
        let thread = std::thread::Builder::new().name("film".into()).spawn(run);
        let thread = thread.map_err(|e| format!("no thread for the film: {e}"))?;
        Ok(Self {
            is_stopped,
            part,
            thread: Some(thread),
        })
    }

    /// How far it is.
    pub fn part(&self) -> Part {
        *self.part.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Ends it after the picture that is drawn now.
    pub fn stop(&self) {
        self.is_stopped.store(true, Ordering::Relaxed);
    }

    /// What came of it, once it has ended; `None` before, and after it was given.
    pub fn ended(&mut self) -> Option<Result<Filmed, String>> {
        if !self.thread.as_ref().is_some_and(JoinHandle::is_finished) {
            return None;
        }
        let ended = self.thread.take()?.join();
        let broke_off = |_| Err("the film broke off: a bug of MicroSim".to_owned());
        Some(ended.unwrap_or_else(broke_off))
    }
}

impl Drop for Filming {
    /// Whoever is not interested in a film any more makes none, and waits for its last picture: a thread that goes on while the process ends would leave behind what it has
    /// started. The pictures that are written stay.
    fn drop(&mut self) {
        self.stop();
        if let Some(thread) = self.thread.take() {
            // A panic was printed where it happened.
            let _ = thread.join();
        }
    }
}

/// Computes, draws and writes.
fn make(
    scene: Scene,
    is_stopped: &AtomicBool,
    progress: &mut dyn FnMut(Part),
) -> Result<Filmed, String> {
    let Scene {
        recording,
        section,
        shows_fields,
        camera,
        mut film,
    } = scene;
    let tick_s = recording.tick();
    let mut computation = recording.open(is_stopped)?;
    computation.show_fields(shows_fields);
    let wanted = section_of(&computation.range(), section, tick_s)?;
    let mut draw = camera()?;
    let first = computation.range().start;
    let last = wanted.last().copied().unwrap_or(first);
    let mut part = Part {
        of: wanted.len() as u32,
        ..Part::default()
    };
    let mut wanted = wanted.into_iter().peekable();
    while let Some(tick) = wanted.peek().copied() {
        if is_stopped.load(Ordering::Relaxed) {
            break;
        }
        let moment = next(&mut *computation)?;
        part.computed = (moment.tick - first) as f64 / (last - first).max(1) as f64;
        if moment.tick == tick {
            let snapshot = Snapshot::of(&moment, (tick + 1) as f64 * tick_s);
            // One picture stands for all times at which this tick is the last one.
            let png = draw(&snapshot)?;
            while wanted.next_if_eq(&tick).is_some() {
                film.add(&png)?;
                part.written += 1;
            }
        }
        progress(part);
    }
    Ok(film.finish(is_stopped))
}

/// The ticks of a section, as far as there are any.
fn section_of(range: &Range<u64>, [from, to]: [u64; 2], tick_s: f64) -> Result<Vec<u64>, String> {
    let to = to.min(range.end.saturating_sub(1));
    let from = from.max(range.start);
    let found: Vec<u64> = ticks(from, to, tick_s).collect();
    match range.is_empty() || found.is_empty() {
        true => Err("there is no tick in this section".to_owned()),
        false => Ok(found),
    }
}

/// The next tick.
fn next(computation: &mut dyn Computation) -> Result<microsim_host::playback::Moment, String> {
    let moment = computation.step()?;
    moment.ok_or_else(|| "the recording ends before the section".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::films::Video;
    use std::sync::mpsc::{Receiver, channel};
    use std::time::{Duration, Instant};

    /// 25 pictures a second are one in 40 ms: five ticks of 8 ms, two or three of 16 ms, and a tick of 50 ms stands for one or two.
    #[test]
    fn there_are_25_pictures_in_a_second() {
        let of = |from, to, tick_s| ticks(from, to, tick_s).collect::<Vec<_>>();
        assert_eq!(of(0, 20, 0.008), [0, 5, 10, 15, 20]);
        assert_eq!(of(3, 12, 0.008), [3, 8]);
        assert_eq!(of(0, 10, 0.016), [0, 2, 5, 7, 10]);
        assert_eq!(of(0, 4, 0.05), [0, 0, 1, 2, 3, 4]);
        assert_eq!(of(7, 7, 0.008), [7]);
        assert_eq!(of(7, 6, 0.008), [] as [u64; 0]);
        // A second from its first tick on: at its end as well.
        assert_eq!(of(0, 125, 0.008).len(), 26);
        assert_eq!(of(0, 1000, 0.001).len(), 26);
    }

    /// Where a test finds the pictures; a disk of `room` of them.
    struct Shelf {
        pictures: Arc<Mutex<Vec<Vec<u8>>>>,
        room: usize,
    }

    impl Film for Shelf {
        fn add(&mut self, png: &[u8]) -> Result<(), String> {
            let mut pictures = self.pictures.lock().expect("no panic");
            if pictures.len() == self.room {
                return Err("no space left on the device".into());
            }
            pictures.push(png.to_vec());
            Ok(())
        }

        fn finish(self: Box<Self>, is_stopped: &AtomicBool) -> Filmed {
            Filmed {
                folder: "there".into(),
                pictures: self.pictures.lock().expect("no panic").len() as u32,
                video: match is_stopped.load(Ordering::Relaxed) {
                    true => Video::Stopped,
                    false => Video::NoProgram,
                },
            }
        }
    }

    type Pictures = Arc<Mutex<Vec<Vec<u8>>>>;

    /// Films ticks of a session of 100 ticks of 16 ms; a picture is the number of its tick, drawn once the gate is open.
    fn film(section: [u64; 2], room: usize, gate: &Arc<Mutex<()>>) -> (Filming, Pictures) {
        let (filming, pictures, _) = announced(section, room, gate);
        (filming, pictures)
    }

    /// As [`film`], with a message whenever a picture comes to the gate.
    fn announced(
        section: [u64; 2],
        room: usize,
        gate: &Arc<Mutex<()>>,
    ) -> (Filming, Pictures, Receiver<()>) {
        let pictures = Pictures::default();
        let gate = Arc::clone(gate);
        let (comes, at_gate) = channel();
        let scene = Scene {
            recording: crate::tests::player::counted(100, 0.016),
            section,
            shows_fields: false,
            camera: Box::new(move || {
                let draw = move |seen: &Snapshot| {
                    // Nobody needs to listen.
                    let _ = comes.send(());
                    drop(gate.lock());
                    Ok(vec![seen.tick as u8])
                };
                Ok(Box::new(draw))
            }),
            film: Box::new(Shelf {
                pictures: Arc::clone(&pictures),
                room,
            }),
        };
        let filming = Filming::start(scene, || ()).expect("a thread");
        (filming, pictures, at_gate)
    }

    fn ended(filming: &mut Filming) -> Result<Filmed, String> {
        let since = Instant::now();
        loop {
            if let Some(ended) = filming.ended() {
                return ended;
            }
            assert!(since.elapsed() < Duration::from_secs(20), "it never ends");
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    #[test]
    fn a_section_is_drawn_in_order() {
        let open = Arc::default();
        let (mut filming, pictures) = film([40, 50], 1000, &open);
        let filmed = ended(&mut filming).expect("a film");
        assert_eq!(filmed.pictures, 5);
        assert_eq!(filmed.video, Video::NoProgram);
        let expected = [40, 42, 45, 47, 50].map(|tick| vec![tick]);
        assert_eq!(*pictures.lock().expect("no panic"), expected);
        let part = filming.part();
        assert_eq!((part.written, part.of, part.computed), (5, 5, 1.0));
        // What is asked for beyond the end ends there.
        let (mut filming, pictures) = film([95, u64::MAX], 1000, &open);
        ended(&mut filming).expect("a film");
        let expected = [95, 97].map(|tick| vec![tick]);
        assert_eq!(*pictures.lock().expect("no panic"), expected);
        let (mut filming, _) = film([200, 300], 1000, &open);
        let why = ended(&mut filming).expect_err("no tick");
        assert!(why.contains("no tick"), "{why}");
    }

    /// Whoever drops it has waited for its thread: nobody else has the pictures then.
    #[test]
    fn a_film_that_is_dropped_has_ended() {
        let open = Arc::default();
        let (filming, pictures) = film([0, 99], 1000, &open);
        drop(filming);
        assert_eq!(Arc::strong_count(&pictures), 1);
        let written = pictures.lock().expect("no panic").len();
        assert!(written <= 41, "25 in a second, of 1.6 s");
    }

    /// What the viewer leaves behind ends by itself, without anybody waiting: the gate is closed until it was left. What came of it is stated, once the picture that was drawn
    /// meanwhile is finished.
    #[test]
    fn a_film_that_is_left_is_stopped_and_states_what_came_of_it() {
        let gate = Arc::new(Mutex::new(()));
        let closed = gate.lock().expect("no panic");
        let (filming, pictures, at_gate) = announced([0, 99], 1000, &gate);
        at_gate
            .recv_timeout(Duration::from_secs(20))
            .expect("a first picture");
        let mut left = crate::left_films::LeftFilms::default();
        left.leave(Some(filming));
        left.look();
        assert!(left.is_ending());
        assert_eq!(left.outcome(), None);
        drop(closed);
        let since = Instant::now();
        while left.is_ending() {
            assert!(since.elapsed() < Duration::from_secs(20), "it never ends");
            std::thread::sleep(Duration::from_millis(1));
            left.look();
        }
        assert_eq!(Arc::strong_count(&pictures), 1);
        match left.outcome() {
            Some(Ok(filmed)) => assert_eq!(filmed.video, Video::Stopped),
            other => panic!("{other:?}"),
        }
        left.forget();
        assert_eq!(left.outcome(), None);
        // One that had ended has come to what it is, and nothing has to end.
        left.leave(None);
        assert!(!left.is_ending());
    }

    #[test]
    fn a_film_that_is_stopped_or_finds_no_room_leaves_what_it_has() {
        let gate = Arc::new(Mutex::new(()));
        let closed = gate.lock().expect("no panic");
        let (mut filming, pictures, at_gate) = announced([0, 99], 1000, &gate);
        at_gate
            .recv_timeout(Duration::from_secs(20))
            .expect("a first picture");
        filming.stop();
        drop(closed);
        let filmed = ended(&mut filming).expect("what there is");
        assert_eq!(filmed.video, Video::Stopped);
        // The one that was drawn then.
        assert_eq!(pictures.lock().expect("no panic").len(), 1);

        let (mut filming, pictures) = film([0, 99], 3, &gate);
        let why = ended(&mut filming).expect_err("no room");
        assert!(why.contains("no space left"), "{why}");
        assert_eq!(pictures.lock().expect("no panic").len(), 3);
    }
}
