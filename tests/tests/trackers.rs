//! Trackers on the network: peers of these tests speak OpenIGTLink with the built program, break off, come back, flood it and send rubbish.

use microsim_bus::Frames;
use microsim_host::record::Session;
use microsim_igtl::{Decoder, Matrix, Message, Start, Stream, Timestamp, Tracked, encode};
use microsim_message::{InputSample, decode};
use microsim_tests::{Finished, command, config_with, finish, microsim, scratch};
use std::fs;
use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// The settings of the connection.
const LINK: &str = "openigtlink.toml";
/// Longest wait for another process.
const PATIENCE: Duration = Duration::from_secs(20);

/// A run whose motion comes from a tracker, with a folder of its own.
struct Run {
    folder: tempfile::TempDir,
    child: Child,
}

impl Run {
    fn new(settings: &str, input: &str) -> Self {
        let folder = scratch();
        let config = config_with(folder.path(), LINK, settings);
        let mut run = command(["--config".as_ref(), config.as_os_str()]);
        run.args(["run", "touch-spheres", "--json", "--input", input]);
        run.arg("--session").arg(folder.path().join("run.session"));
        run.stdout(Stdio::piped()).stderr(Stdio::piped());
        let child = run.spawn().expect("the built program starts");
        Self { folder, child }
    }

    fn session(&self) -> PathBuf {
        self.folder.path().join("run.session")
    }

    /// The session as far as it is written.
    fn read(&self) -> Option<Session> {
        Session::read(&fs::read(self.session()).ok()?).ok()
    }

    /// Waits until something holds for the samples that have come.
    #[track_caller]
    fn wait_for(&self, what: &str, holds: impl Fn(&[InputSample]) -> bool) {
        let start = Instant::now();
        while !self.read().is_some_and(|session| holds(&samples(&session))) {
            assert!(start.elapsed() < PATIENCE, "{what}");
            std::thread::sleep(Duration::from_millis(10));
        }
    }

    /// Ends the run as Ctrl-C does: its session is whole and is replayed without a tracker. What it printed, and all samples.
    fn end(self) -> (Finished, Vec<InputSample>) {
        let ended = Command::new("sh")
            .args(["-c", &format!("kill -INT {}", self.child.id())])
            .status();
        assert!(ended.expect("a shell").success());
        let session = self.session();
        let printed: Finished = self.child.wait_with_output().expect("the run ends").into();
        let printed = printed.expect(0);
        let config = self.folder.path().join("config");
        let mut verify = command(["--config".as_ref(), config.as_os_str()]);
        verify.arg("replay").arg(&session).arg("--verify");
        finish(&mut verify).expect(0);
        let read = Session::read(&fs::read(&session).expect("a session")).expect("a session");
        (printed, samples(&read))
    }
}

fn samples(session: &Session) -> Vec<InputSample> {
    let logs = session.ticks.iter().map(|(_, tick)| &tick.log);
    let frames = logs.flat_map(|log| Frames::new(log).filter_map(Result::ok));
    frames.filter_map(|frame| decode(&frame)?.ok()).collect()
}

/// A place on the x axis.
fn at(millimetres: f32) -> Matrix {
    Matrix {
        axes: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        translation: [millimetres, 0.0, 0.0],
    }
}

fn tools(names: &[&str], millimetres: f32) -> Message {
    let tool = |name: &&str| Tracked {
        name: (*name).to_owned(),
        kind: 2,
        place: at(millimetres),
    };
    Message::Matrices(names.iter().map(tool).collect())
}

/// In second `second` of the tracker's clock.
fn send(stream: &mut TcpStream, device: &str, second: u64, message: &Message) {
    let bytes = encode(1, device, Timestamp(second << 32), message).expect("bytes");
    stream.write_all(&bytes).expect("the program listens");
}

/// The next message that the program sends.
fn heard(stream: &mut TcpStream) -> Message {
    stream.set_read_timeout(Some(PATIENCE)).expect("a timeout");
    let mut decoder = Decoder::new();
    let mut bytes = [0; 1000];
    loop {
        let count = stream.read(&mut bytes).expect("the program speaks");
        assert_ne!(count, 0, "the program has closed the connection");
        decoder.push(&bytes[..count]);
        if let Some(received) = decoder.next_message().expect("OpenIGTLink") {
            return received.message.expect("a body").expect("a type");
        }
    }
}

fn accept(listener: &TcpListener) -> TcpStream {
    listener.set_nonblocking(true).expect("a listener");
    let start = Instant::now();
    loop {
        match listener.accept() {
            Ok((stream, _)) => {
                stream.set_nonblocking(false).expect("a stream");
                return stream;
            }
            Err(_) => assert!(start.elapsed() < PATIENCE, "the program does not connect"),
        }
        std::thread::sleep(Duration::from_millis(5));
    }
}

fn listener() -> (TcpListener, String) {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    let address = listener.local_addr().expect("an address").to_string();
    (listener, address)
}

/// Device, seconds of its clock and whether it is seen.
fn facts(samples: &[InputSample]) -> Vec<(&str, f64, bool)> {
    let fact = |sample: &InputSample| (sample.device_time, sample.visible);
    let with_name = |sample| (fact(sample), sample);
    let all = samples.iter().map(with_name);
    all.map(|((time, visible), sample)| (&sample.device[..], time, visible))
        .collect()
}

/// Every sample arrives once, in order, with its numbers; what is not seen is not there; a tracker that has gone is looked for until it is back.
#[test]
fn a_tracker_drives_the_tools_and_may_come_back() {
    let (listener, address) = listener();
    let run = Run::new("retry = \"20 ms\"", &format!("openigtlink://{address}"));
    let mut tracker = accept(&listener);
    let start = Start {
        interval: 10,
        coordinates: String::new(),
    };
    assert_eq!(heard(&mut tracker), Message::Start(Stream::Matrices, start));
    for second in 1..=20 {
        send(
            &mut tracker,
            "x",
            second,
            &tools(&["left", "right"], second as f32),
        );
        std::thread::sleep(Duration::from_millis(4));
    }
    send(&mut tracker, "x", 21, &tools(&["left"], 21.0));
    run.wait_for("43 samples", |samples| samples.len() >= 42);
    drop(tracker);
    let mut tracker = accept(&listener);
    run.wait_for("tools that are lost", |samples| samples.len() >= 44);
    send(&mut tracker, "x", 30, &tools(&["right"], 30.0));
    run.wait_for("the tracker back", |samples| samples.len() >= 45);
    let (printed, samples) = run.end();
    assert!(
        printed.err.contains("the connection was closed"),
        "{printed:?}"
    );

    // Each sample waited for its tick of 8 ms, and no longer than for a few late ones.
    let arrivals = &printed.json()["arrivals"];
    let counted = ["samples", "dropped", "late"].map(|key| arrivals[key].as_u64());
    assert_eq!(counted, [Some(45), Some(0), Some(0)], "{arrivals}");
    let p99 = arrivals["wait"]["p99"].as_f64().expect("a time");
    assert!(p99 > 0.0 && p99 < 1.0, "{arrivals}");
    assert!(
        arrivals["tick"]["p50"].as_f64().expect("a time") > 0.0,
        "{arrivals}"
    );

    let mut expected = Vec::new();
    for second in 1..=20 {
        expected.extend(["left", "right"].map(|device| (device, f64::from(second), true)));
    }
    expected.extend([("left", 21.0, true), ("right", 21.0, false)]);
    let found = facts(&samples);
    assert_eq!(found[..42], expected);
    // Lost at the time of this machine, which is later.
    let lost: Vec<_> = found[42..44]
        .iter()
        .map(|(device, _, seen)| (*device, *seen))
        .collect();
    assert_eq!(lost, [("left", false), ("right", false)]);
    assert_eq!(found[44..], [("right", 30.0, true)]);
    for sample in samples.iter().filter(|sample| sample.visible) {
        // In these units the second is the millimetre.
        let off = (sample.pose.position[0] - 1e-3 * sample.device_time).abs();
        assert!(off < 1e-12, "{sample:?}");
    }
}

/// As a server for two trackers; a third peer that speaks something else is let go, and the others stay.
#[test]
fn trackers_may_connect_and_who_speaks_otherwise_is_let_go() {
    let address = listener().1;
    let settings = format!(
        "role = \"server\"\naddress = \"{address}\"\n[[device]]\nname = \"Right Forceps\"\ndevice = \"right\"\n"
    );
    let run = Run::new(&settings, "plugin:openigtlink");
    let connect = || {
        let start = Instant::now();
        loop {
            if let Ok(stream) = TcpStream::connect(&address) {
                return stream;
            }
            assert!(start.elapsed() < PATIENCE, "the program does not wait");
            std::thread::sleep(Duration::from_millis(10));
        }
    };
    let (mut first, mut second, mut other) = (connect(), connect(), connect());
    send(&mut first, "left", 1, &Message::Transform(at(1.0)));
    run.wait_for("the first tracker", |samples| samples.len() == 1);
    send(
        &mut second,
        "Right Forceps",
        2,
        &Message::Transform(at(2.0)),
    );
    run.wait_for("the second tracker", |samples| samples.len() == 2);
    let request = format!("GET / HTTP/1.1\r\n{}\r\n\r\n", "x".repeat(60));
    other
        .write_all(request.as_bytes())
        .expect("the program listens");
    other.set_read_timeout(Some(PATIENCE)).expect("a timeout");
    // Closed, or reset as not all was read.
    let closed = other.read(&mut [0; 10]);
    assert!(matches!(closed, Ok(0) | Err(_)), "{closed:?}");
    send(&mut first, "left", 3, &Message::Transform(at(3.0)));
    run.wait_for("the first tracker still", |samples| samples.len() == 3);
    let (printed, samples) = run.end();
    assert!(
        printed
            .err
            .contains("expected a header of version 1 to 3, found 18245"),
        "{printed:?}"
    );
    assert_eq!(
        facts(&samples),
        [
            ("left", 1.0, true),
            ("right", 2.0, true),
            ("left", 3.0, true)
        ]
    );
}

/// A flood costs old samples, which the log names; ticks go on and the newest sample arrives. A tracker that falls silent is let go.
#[test]
fn a_flood_or_silence_holds_nothing_up() {
    let (listener, address) = listener();
    let settings = "retry = \"20 ms\"\nsilence = \"300 ms\"\nstream = \"none\"";
    let run = Run::new(settings, &format!("openigtlink://{address}"));
    let mut tracker = accept(&listener);
    send(&mut tracker, "right", 1, &Message::Transform(at(1.0)));
    run.wait_for("a sample", |samples| samples.len() == 1);
    let before = run.read().map_or(0, |session| session.ticks.len());
    let one = encode(1, "right", Timestamp(2 << 32), &Message::Transform(at(2.0)));
    let flood = one.expect("bytes").repeat(50_000);
    tracker.write_all(&flood).expect("the program listens");
    send(&mut tracker, "right", 3, &Message::Transform(at(3.0)));
    let has = |time: f64| {
        move |samples: &[InputSample]| samples.iter().any(|sample| sample.device_time == time)
    };
    run.wait_for("the sample behind the flood", has(3.0));
    // Silent now; its end of the connection stays open.
    let mut again = accept(&listener);
    send(&mut again, "right", 4, &Message::Transform(at(4.0)));
    run.wait_for("the tracker again", has(4.0));
    let after = run.read().map_or(0, |session| session.ticks.len());
    let (printed, samples) = run.end();
    drop(tracker);
    for part in ["samples came faster than ticks: ", "nothing came for 0.3 s"] {
        assert!(printed.err.contains(part), "{part}: {printed:?}");
    }
    assert!(samples.len() < 50_000, "{}", samples.len());
    let dropped = printed.json()["arrivals"]["dropped"].as_u64();
    let dropped = dropped.expect("a number") as usize;
    // One sample at each end of the flood, one after the silence; two connections were lost.
    assert!(
        (50_000..=50_006).contains(&(samples.len() + dropped)),
        "{dropped}"
    );
    // The silence alone is 300 ms of ticks of 8 ms.
    assert!(after - before > 30, "{before} to {after} ticks");
}

/// Nobody else in the network moves the tools unless the operator wants it, and a port that is taken is no silent tracker.
#[test]
fn addresses_that_cannot_be_used_are_refused_at_once() {
    let refused = microsim([
        "run",
        "touch-spheres",
        "--input",
        "openigtlink://192.0.2.1:18944",
    ]);
    let refused = refused.expect(2);
    assert!(
        refused
            .err
            .contains("`192.0.2.1`, which is not this machine alone"),
        "{refused:?}"
    );
    let wrong = microsim(["run", "touch-spheres", "--input", "openigtlink://localhost"]);
    let wrong = wrong.expect(2);
    assert!(wrong.err.contains("HOST:PORT"), "{wrong:?}");

    let (taken, address) = listener();
    let folder = scratch();
    let settings = format!("role = \"server\"\naddress = \"{address}\"");
    let config = config_with(folder.path(), LINK, &settings);
    let mut run = command(["--config".as_ref(), config.as_os_str()]);
    run.args(["run", "touch-spheres", "--input", "plugin:openigtlink"]);
    run.arg("--session").arg(folder.path().join("run.session"));
    let refused = finish(&mut run).expect(2);
    assert!(
        refused.err.contains(&format!("waiting at {address}: ")),
        "{refused:?}"
    );
    drop(taken);
}
