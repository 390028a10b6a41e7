//! pyigtl and the C++ library of Debian with the built program and with the codec, in both directions. Where they are not there the tests are skipped, with the reason on standard error;
//! `cargo xtask soak trackers` fails instead.

use microsim_igtl::{Decoder, Matrix, Message, Text, Timestamp, Tracked, encode};
use microsim_tests::peers::{
    Peer, examples, free_port, or_skipped, python, start_example, start_script,
};
use microsim_tests::{Finished, command, config_with, finish, scratch};
use serde_json::{Value, json};
use std::fs;
use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::time::{Duration, Instant};

const PATIENCE: Duration = Duration::from_secs(30);
/// Python takes some seconds to start where other work is beside it, an example of the library none.
const OF_PYTHON: u32 = 15;
const OF_LIBRARY: u32 = 3;

/// What the program receives with these settings of the connection in so many seconds.
fn heard(settings: &str, input: &str, seconds: u32) -> Finished {
    let folder = scratch();
    let config = config_with(folder.path(), "openigtlink.toml", settings);
    let mut devices = command(["--config".as_ref(), config.as_os_str()]);
    devices.args(["devices", "--json", "--input", input]);
    finish(devices.arg("--seconds").arg(seconds.to_string()))
}

/// The device of this name.
#[track_caller]
fn device<'a>(heard: &'a Value, name: &str) -> &'a Value {
    let list = heard["devices"].as_array().expect("a list");
    let found = list.iter().find(|device| device["name"] == name);
    found.unwrap_or_else(|| panic!("{name} is not in {heard}"))
}

#[track_caller]
fn assert_near(found: &Value, expected: &[f64], tolerance: f64) {
    let found: Vec<f64> = found
        .as_array()
        .expect("numbers")
        .iter()
        .filter_map(Value::as_f64)
        .collect();
    assert_eq!(found.len(), expected.len());
    for (a, b) in found.iter().zip(expected) {
        assert!(
            (a - b).abs() <= tolerance,
            "{found:?}, expected {expected:?}"
        );
    }
}

/// A motion that stands still, at a place whose numbers all differ.
fn still() -> Value {
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let row = |step: u32| {
        json!([
            f64::from(step) * 0.01,
            "left",
            1.5,
            -2.25,
            300.0,
            0.0,
            0.0,
            half,
            half
        ])
    };
    Value::Array((0..200).map(row).collect())
}

/// pyigtl as a server whose tool stands still, and as a client of the program as a server: pose, orientation and rate as they were sent.
#[test]
fn pyigtl_is_heard_as_server_and_as_client() {
    let Some(python) = or_skipped("pyigtl", python()) else {
        return;
    };
    let folder = scratch();
    let motion = folder.path().join("motion.json");
    fs::write(&motion, still().to_string()).expect("the motion");
    let half = std::f64::consts::FRAC_1_SQRT_2;
    // Single precision of 300 mm is 1.5e-8 m, of the matrix 6e-8.
    let check = |heard: &Value| {
        let left = device(heard, "left");
        assert_near(&left["position_m"], &[0.0015, -0.00225, 0.3], 2e-8);
        assert_near(&left["orientation"], &[0.0, 0.0, half, half], 2e-7);
    };
    let port = free_port().to_string();
    let server = start_script(
        &python,
        "play.py",
        [&port[..], motion.to_str().expect("UTF-8"), "--server"],
    );
    let settings = "stream = \"none\"\nretry = \"50 ms\"";
    check(
        &heard(
            settings,
            &format!("openigtlink://127.0.0.1:{port}"),
            OF_PYTHON,
        )
        .expect(0)
        .json(),
    );
    drop(server);
    let port = free_port().to_string();
    let settings = format!("role = \"server\"\naddress = \"127.0.0.1:{port}\"");
    let client = start_script(
        &python,
        "play.py",
        [&port[..], motion.to_str().expect("UTF-8")],
    );
    let heard = heard(&settings, "plugin:openigtlink", OF_PYTHON)
        .expect(0)
        .json();
    check(&heard);
    // All 200, by the clock of the sender.
    assert_eq!(device(&heard, "left")["visible"], 200);
    let rate = device(&heard, "left")["rate_hz"].as_f64().expect("a rate");
    assert!((rate - 100.0).abs() < 1e-3, "{rate}");
    drop(client);
}

/// The trackers of the C++ library: one that sends TRANSFORM unasked, as server and as client, and those that send TDATA and QTDATA once they are asked; the quaternions of the last are
/// none.
/// Their tools move on circles of 50 mm (TRANSFORM, `GetRandomTestMatrix`), with poses that are rigid.
#[test]
fn trackers_of_the_library_are_heard() {
    let Some(folder) = or_skipped("the C++ library of OpenIGTLink", examples()) else {
        return;
    };
    let norm = |position: &Value| {
        let sum: f64 = position
            .as_array()
            .expect("a position")
            .iter()
            .filter_map(Value::as_f64)
            .map(|x| x * x)
            .sum();
        sum.sqrt()
    };
    let unasked =
        "stream = \"none\"\nretry = \"50 ms\"\n[[device]]\nname = \"Tracker\"\ndevice = \"right\"";
    let port = free_port().to_string();
    let server = start_example(&folder, "TrackerServer", &[port.clone(), "100".into()]);
    let found = heard(
        unasked,
        &format!("openigtlink://127.0.0.1:{port}"),
        OF_LIBRARY,
    )
    .expect(0)
    .json();
    drop(server);
    let right = device(&found, "right");
    // Every pose is rigid; where the connection ends, one sample states that the tool is not seen any more.
    let count = |key: &str| right[key].as_u64().expect("a count");
    assert!(
        count("visible") > 0 && count("visible") + 1 >= count("samples"),
        "{right}"
    );
    // (cos φ, sin φ, cos φ) by 50 mm.
    let length = norm(&right["position_m"]);
    assert!((0.0499..=0.0708).contains(&length), "{right}");

    let port = free_port().to_string();
    let settings = format!(
        "role = \"server\"\naddress = \"127.0.0.1:{port}\"\n[[device]]\nname = \"Tracker\"\ndevice = \"right\""
    );
    // It gives up at once where nobody waits yet.
    let start = Instant::now();
    let (folder_of_client, port_of_client) = (folder.clone(), port.clone());
    let client = std::thread::spawn(move || {
        while start.elapsed() < PATIENCE {
            if TcpStream::connect(format!("127.0.0.1:{port_of_client}")).is_ok() {
                let args = ["127.0.0.1".into(), port_of_client, "100".into()];
                return Some(start_example(&folder_of_client, "TrackerClient", &args));
            }
            std::thread::sleep(Duration::from_millis(20));
        }
        None
    });
    let found = heard(&settings, "plugin:openigtlink", OF_LIBRARY)
        .expect(0)
        .json();
    drop(client.join().expect("no panic"));
    assert_eq!(device(&found, "right")["late"], 0, "{found}");

    for (program, stream) in [
        ("TrackingDataServer", "TDATA"),
        ("QuaternionTrackingDataServer", "QTDATA"),
    ] {
        let port = free_port().to_string();
        let server = start_example(&folder, program, std::slice::from_ref(&port));
        let named = ["Channel 0", "Channel 1", "Channel 2"];
        let named = named.iter().zip(["left", "right", "other"]);
        let named: String = named
            .map(|(name, device)| format!("[[device]]\nname = \"{name}\"\ndevice = \"{device}\"\n"))
            .collect();
        let settings =
            format!("stream = \"{stream}\"\ninterval = \"20 ms\"\nretry = \"50 ms\"\n{named}");
        let ended = heard(
            &settings,
            &format!("openigtlink://127.0.0.1:{port}"),
            OF_LIBRARY,
        )
        .expect(0);
        drop(server);
        let found = ended.json();
        for name in ["left", "right", "other"] {
            let tool = device(&found, name);
            if stream == "QTDATA" {
                // Its quaternions are (0, ⅔ cos θ, 1/√3, ⅔ sin θ), of length √7/3: no rotation, and named as such.
                assert_eq!(
                    (&tool["state"], &tool["visible"]),
                    (&json!("never seen"), &json!(0))
                );
                assert!(tool["samples"].as_u64() > Some(20), "{program}: {found}");
                assert!(
                    ended.err.contains("expected a rotation to within 0.001"),
                    "{ended:?}"
                );
                continue;
            }
            assert_eq!(tool["state"], "tracked", "{program}: {found}");
            // Asked for 50 per second; its clock is a sleep.
            let rate = tool["rate_hz"].as_f64().expect("a rate");
            assert!((10.0..=50.5).contains(&rate), "{program}: {found}");
        }
    }
}

/// Accepts a peer and sends it frames until it goes, and no longer than is patient. What it has sent itself.
fn serve(listener: &TcpListener, messages: &[(&str, Message)]) -> Vec<Message> {
    let (mut stream, _) = listener.accept().expect("the peer connects");
    stream
        .set_read_timeout(Some(Duration::from_millis(20)))
        .expect("a timeout");
    let start = Instant::now();
    let mut decoder = Decoder::new();
    let mut received = Vec::new();
    while start.elapsed() < PATIENCE {
        for (device, message) in messages {
            let bytes = encode(1, device, Timestamp(5 << 32), message).expect("bytes");
            if stream.write_all(&bytes).is_err() {
                return received;
            }
        }
        let mut bytes = [0; 1000];
        match stream.read(&mut bytes) {
            Ok(0) => return received,
            Ok(count) => decoder.push(&bytes[..count]),
            Err(_) => {}
        }
        while let Ok(Some(message)) = decoder.next_message() {
            received.extend(message.message.ok().flatten());
        }
    }
    received
}

fn turned() -> Matrix {
    Matrix {
        axes: [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]],
        translation: [1.5, -2.25, 300.0],
    }
}

/// What the codec writes pyigtl reads: a matrix with its rows and columns where they belong, the time, a text.
#[test]
fn pyigtl_reads_what_is_written() {
    let Some(python) = or_skipped("pyigtl", python()) else {
        return;
    };
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    let port = listener
        .local_addr()
        .expect("an address")
        .port()
        .to_string();
    let mut peer = start_script(&python, "hear.py", [&port[..], "Forceps", "Note"]);
    let messages = [
        ("Forceps", Message::Transform(turned())),
        (
            "Note",
            Message::Text(Text {
                encoding: 3,
                bytes: b"ready".to_vec(),
            }),
        ),
    ];
    serve(&listener, &messages);
    let mut printed = String::new();
    peer.0
        .stdout
        .take()
        .expect("a pipe")
        .read_to_string(&mut printed)
        .expect("UTF-8");
    let lines: Vec<Value> = printed
        .lines()
        .map(|line| serde_json::from_str(line).expect("JSON"))
        .collect();
    let matrix = json!([
        [0.0, -1.0, 0.0, 1.5],
        [1.0, 0.0, 0.0, -2.25],
        [0.0, 0.0, 1.0, 300.0],
        [0.0, 0.0, 0.0, 1.0]
    ]);
    assert_eq!(
        lines,
        [
            json!(["Forceps", "TransformMessage", 5.0, matrix]),
            json!(["Note", "StringMessage", 5.0, "ready"]),
        ]
    );
}

/// What the codec writes the C++ library reads: its receiver prints pose, quaternion and text of every type that it is sent, and no error.
#[test]
fn the_library_reads_what_is_written() {
    let Some(folder) = or_skipped("the C++ library of OpenIGTLink", examples()) else {
        return;
    };
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    let port = listener
        .local_addr()
        .expect("an address")
        .port()
        .to_string();
    let mut receiver = std::process::Command::new(folder.join("ReceiveClient"));
    receiver.args(["127.0.0.1", &port]);
    let log = scratch();
    let file = |name: &str| fs::File::create(log.path().join(name)).expect("a file");
    receiver.stdout(file("out")).stderr(file("err"));
    let peer = Peer(receiver.spawn().expect("it starts"));
    let position = microsim_igtl::Position {
        position: [1.5, -2.25, 300.0],
        orientation: Some([0.0, 0.0, 0.6, 0.8]),
    };
    let tool = |place| Tracked {
        name: "left".to_owned(),
        kind: 2,
        place,
    };
    let messages = [
        ("Forceps", Message::Transform(turned())),
        ("Forceps", Message::Position(position)),
        ("Forceps", Message::Matrices(vec![tool(turned())])),
        (
            "Forceps",
            Message::Quaternions(vec![Tracked {
                name: "left".to_owned(),
                kind: 2,
                place: position,
            }]),
        ),
        (
            "Note",
            Message::Text(Text {
                encoding: 3,
                bytes: b"ready".to_vec(),
            }),
        ),
        ("Forceps", Message::Capability(vec!["TRANSFORM".to_owned()])),
    ];
    let stop = std::thread::spawn(move || {
        std::thread::sleep(Duration::from_secs(2));
        drop(peer);
    });
    serve(&listener, &messages);
    stop.join().expect("no panic");
    let read = |name: &str| fs::read_to_string(log.path().join(name)).expect("UTF-8");
    let all = format!("{}{}", read("out"), read("err"));
    for part in [
        "position   = (1.5, -2.25, 300)",
        "quaternion = (0, 0, 0.6, 0.8",
        "Receiving TDATA data type.",
        "Receiving QTDATA data type.",
        "ready",
        "Typename #0: TRANSFORM",
    ] {
        assert!(all.contains(part), "{part}: {all}");
    }
    // The rows of the matrix.
    assert!(all.contains("-2.25") && all.contains("300"), "{all}");
}
