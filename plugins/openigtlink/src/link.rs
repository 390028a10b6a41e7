//! Sockets and the threads that wait on them. What comes lies in a queue until the next tick takes it.

use crate::conversation::Conversation;
use microsim_igtl::Decoder;
use microsim_sdk::message::InputSample;
use microsim_sdk::{LogLevel, Tick};
use microsim_settings::{LinkClock, LinkRole, OpenIgtLink};
use std::collections::VecDeque;
use std::io::{ErrorKind, Read, Write};
use std::net::{TcpListener, TcpStream, ToSocketAddrs};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard};
use std::thread::JoinHandle;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// Samples that wait for a tick at most: a second of two tools at 500 Hz. Of more the oldest are dropped.
const MOST_SAMPLES: usize = 1000;
/// Notes that wait at most; more are dropped.
const MOST_NOTES: usize = 256;
/// Trackers that a server serves at the same time.
const MOST_PEERS: usize = 8;
/// How long a thread waits before it looks whether it should end.
const PAUSE: Duration = Duration::from_millis(20);
/// How long a connection may take to come about, and a message to be sent.
const PATIENCE: Duration = Duration::from_secs(1);

/// What has come since the last time.
#[derive(Debug, Default)]
pub struct Queue {
    /// Each with when it arrived.
    pub samples: VecDeque<(Instant, InputSample)>,
    /// For the operator; whether each is a warning.
    pub notes: Vec<(bool, String)>,
    /// Samples that found no place.
    pub dropped: u64,
    /// Whether a connection on which samples came has ended.
    pub ended: bool,
}

impl Queue {
    /// Adds samples; of more than there is place for the oldest are dropped, unless all are waited for.
    fn add(&mut self, samples: impl IntoIterator<Item = InputSample>, drops: bool) {
        let now = Instant::now();
        for sample in samples {
            if drops && self.samples.len() == MOST_SAMPLES {
                self.samples.pop_front();
                self.dropped += 1;
            }
            self.samples.push_back((now, sample));
        }
    }

    /// Hands the notes to the log.
    pub fn log(&mut self, tick: &mut Tick<'_>) {
        for (is_warning, note) in self.notes.drain(..) {
            let level = match is_warning {
                true => LogLevel::Warn,
                false => LogLevel::Info,
            };
            tick.log(level, note);
        }
    }

    fn note(&mut self, is_warning: bool, note: String) {
        if self.notes.len() < MOST_NOTES {
            self.notes.push((is_warning, note));
        }
    }
}

#[derive(Debug)]
struct Shared {
    config: OpenIgtLink,
    queue: Mutex<Queue>,
    stopped: AtomicBool,
    peers: AtomicUsize,
}

impl Shared {
    /// What another thread left in the queue is whole, also if it panicked.
    fn queue(&self) -> MutexGuard<'_, Queue> {
        self.queue
            .lock()
            .unwrap_or_else(|poisoned| poisoned.into_inner())
    }

    fn is_stopped(&self) -> bool {
        self.stopped.load(Ordering::Relaxed)
    }

    /// Whether samples are dropped where they come faster than ticks take them. Those of a peer whose clock decides are not: it has to wait.
    fn drops(&self) -> bool {
        self.config.clock == LinkClock::Arrival
    }

    fn wait(&self, seconds: f64) {
        let end = Instant::now() + Duration::from_secs_f64(seconds);
        while !self.is_stopped() && Instant::now() < end {
            std::thread::sleep(PAUSE.min(end.saturating_duration_since(Instant::now())));
        }
    }
}

/// An open connection, or one that is waited for.
#[derive(Debug)]
pub struct Link {
    shared: Arc<Shared>,
    thread: JoinHandle<()>,
}

impl Link {
    /// Begins to connect, or to wait for trackers.
    ///
    /// # Errors
    /// If a server cannot wait at its address.
    pub fn open(config: OpenIgtLink) -> Result<Self, String> {
        let listener = match config.role {
            LinkRole::Client => None,
            LinkRole::Server => {
                let listener = TcpListener::bind(&config.address[..]);
                let listener = listener.and_then(|l| l.set_nonblocking(true).map(|()| l));
                Some(listener.map_err(|e| format!("waiting at {}: {e}", config.address))?)
            }
        };
        let shared = Arc::new(Shared {
            config,
            queue: Mutex::default(),
            stopped: AtomicBool::new(false),
            peers: AtomicUsize::new(0),
        });
        let own = Arc::clone(&shared);
        let thread = std::thread::spawn(move || match listener {
            None => connect(&own),
            Some(listener) => serve(&own, &listener),
        });
        Ok(Self { shared, thread })
    }

    /// What has come since the last time.
    pub fn take(&self) -> Queue {
        let mut queue = std::mem::take(&mut *self.shared.queue());
        // A connection that has ended stays so.
        self.shared.queue().ended = queue.ended;
        if queue.dropped > 0 {
            let dropped = queue.dropped;
            queue.note(
                true,
                format!("samples came faster than ticks: {dropped} were dropped"),
            );
        }
        queue
    }

    /// Ends all threads; whether none had panicked.
    pub fn close(self) -> bool {
        self.shared.stopped.store(true, Ordering::Relaxed);
        self.thread.join().is_ok()
    }
}

/// Connects, again and again.
fn connect(shared: &Shared) {
    let address = &shared.config.address;
    let mut last = String::new();
    while !shared.is_stopped() {
        match open(address) {
            Ok(stream) => {
                last.clear();
                shared
                    .queue()
                    .note(false, format!("connected to {address}"));
                talk(shared, stream, address);
                if shared.queue().ended {
                    return;
                }
            }
            // The same once.
            Err(error) if error != last => {
                let seconds = shared.config.retry;
                let note = format!("{address}: {error}; tried again every {seconds} s");
                shared.queue().note(true, note);
                last = error;
            }
            Err(_) => {}
        }
        shared.wait(shared.config.retry);
    }
}

fn open(address: &str) -> Result<TcpStream, String> {
    let mut last = "the name has no address".to_owned();
    for socket in address.to_socket_addrs().map_err(|e| e.to_string())? {
        match TcpStream::connect_timeout(&socket, PATIENCE) {
            Ok(stream) => return Ok(stream),
            Err(error) => last = error.to_string(),
        }
    }
    Err(last)
}

/// Takes connections, a thread for each.
fn serve(shared: &Arc<Shared>, listener: &TcpListener) {
    let mut threads: Vec<JoinHandle<()>> = Vec::new();
    while !shared.is_stopped() {
        let (stream, peer) = match listener.accept() {
            Ok((stream, peer)) => (stream, peer.to_string()),
            Err(error) => {
                if error.kind() != ErrorKind::WouldBlock {
                    shared
                        .queue()
                        .note(true, format!("a tracker could not connect: {error}"));
                }
                std::thread::sleep(PAUSE);
                continue;
            }
        };
        threads.retain(|thread| !thread.is_finished());
        if shared.peers.load(Ordering::Relaxed) >= MOST_PEERS {
            let note = format!("{peer} is refused: {MOST_PEERS} trackers are connected");
            shared.queue().note(true, note);
            continue;
        }
        shared.peers.fetch_add(1, Ordering::Relaxed);
        shared.queue().note(false, format!("{peer} has connected"));
        let own = Arc::clone(shared);
        threads.push(std::thread::spawn(move || {
            talk(&own, stream, &peer);
            own.peers.fetch_sub(1, Ordering::Relaxed);
        }));
    }
    for thread in threads {
        // A thread that panicked has left its tools as they were last seen, and they become stale.
        let _ = thread.join();
    }
}

/// Talks on a connection until it ends; then no tool of it is seen.
fn talk(shared: &Shared, mut stream: TcpStream, peer: &str) {
    let mut conversation = Conversation::new(shared.config.clone());
    let end = receive(shared, &mut stream, &mut conversation);
    let lost = conversation.lost(now());
    let mut queue = shared.queue();
    match shared.drops() {
        true => {
            queue.add(lost, true);
            if let Err(why) = end {
                queue.note(true, format!("{peer}: {why}"));
            }
        }
        // The motion is over; nothing of it was lost.
        false => {
            queue.ended |= !lost.is_empty();
            if let Err(why) = end {
                queue.note(false, format!("{peer}: {why}"));
            }
        }
    }
}

/// Receives until the connection ends: the error is why, unless this program ended it.
fn receive(
    shared: &Shared,
    stream: &mut TcpStream,
    conversation: &mut Conversation,
) -> Result<(), String> {
    let failed = |e: std::io::Error| format!("the connection failed: {e}");
    stream.set_nonblocking(false).map_err(failed)?;
    stream.set_read_timeout(Some(PAUSE)).map_err(failed)?;
    stream.set_write_timeout(Some(PATIENCE)).map_err(failed)?;
    // Messages are small and late ones are worth nothing.
    stream.set_nodelay(true).map_err(failed)?;
    if let Some(bytes) = conversation.begin() {
        stream.write_all(&bytes).map_err(failed)?;
    }
    let mut decoder = Decoder::new();
    let mut bytes = vec![0; 1 << 16];
    let mut last = Instant::now();
    while !shared.is_stopped() {
        if !shared.drops() && shared.queue().samples.len() >= MOST_SAMPLES {
            std::thread::sleep(Duration::from_millis(1));
            last = Instant::now();
            continue;
        }
        let count = match stream.read(&mut bytes) {
            Ok(0) => return Err("the connection was closed".to_owned()),
            Ok(count) => count,
            Err(error) if is_pause(&error) => {
                if last.elapsed().as_secs_f64() > shared.config.silence {
                    return Err(format!("nothing came for {} s", shared.config.silence));
                }
                continue;
            }
            Err(error) => return Err(failed(error)),
        };
        last = Instant::now();
        decoder.push(&bytes[..count]);
        while let Some(message) = decoder.next_message().map_err(|e| e.to_string())? {
            let arrived = conversation.receive(message, now());
            if let Some(answer) = &arrived.answer {
                stream.write_all(answer).map_err(failed)?;
            }
            let mut queue = shared.queue();
            queue.add(arrived.samples, shared.drops());
            for (is_warning, note) in arrived.notes {
                queue.note(is_warning, note);
            }
        }
    }
    if let Some(bytes) = conversation.end() {
        // The session is over; whether the tracker receives it makes no difference to it.
        let _ = stream.write_all(&bytes);
    }
    Ok(())
}

fn is_pause(error: &std::io::Error) -> bool {
    matches!(
        error.kind(),
        ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted
    )
}

/// Seconds since 1970 UTC.
fn now() -> f64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH);
    since.map_or(0.0, |since| since.as_secs_f64())
}
