//! A real audio server without a device: what is played comes out of it.

use microsim_audio::{Player, RATE, Tone};
use std::io::Read;
use std::os::unix::net::UnixListener;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, Instant};

/// A process that ends with this value.
struct Peer(Child);

impl Drop for Peer {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// A server in a folder whose only device is one that plays nothing; `None` where PulseAudio is not installed.
fn server(folder: &Path) -> Option<Peer> {
    let mut program = Command::new("pulseaudio");
    program
        .args([
            "-n",
            "--daemonize=no",
            "--exit-idle-time=-1",
            "--use-pid-file=no",
        ])
        .arg("--load=module-null-sink sink_name=silent format=float32le rate=48000 channels=1")
        .arg(format!(
            "--load=module-native-protocol-unix auth-anonymous=1 socket={}",
            folder.join("socket").display()
        ));
    program.env("XDG_RUNTIME_DIR", folder).env("HOME", folder);
    program.stdout(Stdio::null()).stderr(Stdio::null());
    program.spawn().ok().map(Peer)
}

/// What its device would play, from now on.
fn monitor(folder: &Path) -> Option<Peer> {
    let mut program = Command::new("parec");
    program.arg(format!("--server=unix:{}", folder.join("socket").display()));
    program.args(["--device=silent.monitor", "--raw", "--format=float32le"]);
    program.args(["--rate=48000", "--channels=1", "--latency-msec=20"]);
    program.env("XDG_RUNTIME_DIR", folder).env("HOME", folder);
    program.stdout(Stdio::piped()).stderr(Stdio::null());
    program.spawn().ok().map(Peer)
}

/// The next samples of it.
fn samples(monitor: &mut Peer, seconds: f64) -> Vec<f32> {
    let output = monitor.0.stdout.as_mut().expect("piped");
    let mut bytes = vec![0; 4 * (seconds * f64::from(RATE)) as usize];
    output.read_exact(&mut bytes).expect("the monitor goes on");
    let samples = bytes.chunks_exact(4);
    samples
        .map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]))
        .collect()
}

fn wait_for<T>(what: &str, mut found: impl FnMut() -> Option<T>) -> T {
    let begin = Instant::now();
    loop {
        if let Some(found) = found() {
            return found;
        }
        assert!(begin.elapsed() < Duration::from_secs(20), "no {what}");
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// The samples of a tone come out of the server as they are, times the volume, once, and nothing before them.
#[test]
fn a_tone_arrives_sample_by_sample() {
    let folder = tempfile::tempdir().expect("a folder");
    let (Some(_server), true) = (server(folder.path()), has("parec")) else {
        println!("skipped: pulseaudio and parec (pulseaudio-utils) are not installed");
        return;
    };
    let socket = folder.path().join("socket");
    wait_for("socket", || socket.exists().then_some(()));
    let player = Player::open_at(&socket, Vec::new(), 0.5, |why| panic!("{why}"));
    wait_for("server", || player.is_open().then_some(()));
    let mut monitor = monitor(folder.path()).expect("parec starts");
    let before = samples(&mut monitor, 0.3);
    assert!(before.iter().all(|s| *s == 0.0), "silence before");

    for tone in [Tone::Cut, Tone::Tear, Tone::Touch] {
        let begin = Instant::now();
        player.play(tone);
        let mut arrived = samples(&mut monitor, 0.1);
        let is_played = |s: &f32| *s != 0.0;
        while !arrived.iter().any(is_played) {
            assert!(begin.elapsed() < Duration::from_secs(5), "{tone:?} is lost");
            arrived = samples(&mut monitor, 0.1);
        }
        println!("{tone:?} after {:?}", begin.elapsed());
        arrived.extend(samples(&mut monitor, 0.4));
        let first = arrived.iter().position(is_played).expect("it is there");
        let expected: Vec<f32> = tone.samples().iter().map(|s| s * 0.5).collect();
        let skipped = expected
            .iter()
            .position(is_played)
            .expect("it is not silent");
        let expected = &expected[skipped..];
        let (played, after) = arrived[first..].split_at(expected.len());
        for (played, expected) in played.iter().zip(expected) {
            // The server multiplies with a volume of 1.
            assert!((played - expected).abs() < 1e-6, "{tone:?}");
        }
        assert!(after.iter().all(|s| *s == 0.0), "silence after {tone:?}");
    }
}

fn has(program: &str) -> bool {
    let mut version = Command::new(program);
    version.arg("--version").stdout(Stdio::null());
    version.status().is_ok_and(|status| status.success())
}

/// Opens what listens at a path, and where the reason comes if it fails.
fn opened(socket: &Path) -> (Player, Receiver<String>) {
    let (sender, reasons) = channel();
    let failed = move |why| sender.send(why).expect("somebody asks");
    (Player::open_at(socket, Vec::new(), 0.5, failed), reasons)
}

const PATIENCE: Duration = Duration::from_secs(20);

/// Where nobody listens there is one sentence, and one where a server leaves before it has answered.
#[test]
fn a_server_that_is_not_there_is_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let socket = folder.path().join("socket");
    let (player, reasons) = opened(&socket);
    let why = reasons.recv_timeout(PATIENCE).expect("nobody listens");
    assert!(
        why.contains(&socket.display().to_string()) && !why.contains('\n'),
        "{why}"
    );
    assert!(!player.is_open());
    // What asks for tones need not know.
    player.play(Tone::Cut);
    // One that takes the connection and leaves.
    let listener = UnixListener::bind(&socket).expect("a socket");
    let leave = std::thread::spawn(move || drop(listener.accept()));
    let (_player, reasons) = opened(&socket);
    let why = reasons.recv_timeout(PATIENCE).expect("it has left");
    assert!(why.contains(&socket.display().to_string()), "{why}");
    leave.join().expect("it has left");
}

/// A server that accepts and never answers delays nobody: the call returns before it has read a byte of what it is asked, and so does leaving it. The reason comes later, where nobody left.
#[test]
fn a_server_that_never_answers_delays_nobody() {
    let folder = tempfile::tempdir().expect("a folder");
    let socket = folder.path().join("socket");
    let listener = UnixListener::bind(&socket).expect("a socket");
    let (player, reasons) = opened(&socket);
    // It accepts only now, so nothing was answered before.
    let (mut peer, _) = listener.accept().expect("a connection");
    assert!(!player.is_open());
    player.play(Tone::Cut);
    let mut asked = [0; 1];
    peer.read_exact(&mut asked).expect("it is asked who it is");
    drop(player);
    // Whoever left has closed the connection: what comes ends, and nobody is informed.
    peer.read_to_end(&mut Vec::new()).expect("an end");
    assert_eq!(
        reasons.recv_timeout(PATIENCE),
        Err(RecvTimeoutError::Disconnected)
    );

    let (player, reasons) = opened(&socket);
    let _peer = listener.accept().expect("a connection");
    let why = reasons.recv_timeout(PATIENCE).expect("it gives up");
    assert!(why.contains(&socket.display().to_string()), "{why}");
    assert!(!player.is_open());
}
