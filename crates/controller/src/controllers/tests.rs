//! Devices of a folder: pipes, into which the test writes what the kernel would.

use super::*;
use crate::code::{EV_ABS, EV_KEY, EV_SYN, NORTH, RZ, SYN_DROPPED, SYN_REPORT, X, Z};
use crate::event::bytes;
use crate::probe::Probed;
use crate::range::Range;
use std::fs::{self, OpenOptions};
use std::io::{self, Write};
use std::sync::atomic::{AtomicUsize, Ordering};

/// An Xbox gamepad at rest, or one that nobody may open.
struct AtRest {
    is_refused: bool,
}

impl Probe for AtRest {
    fn probe(&self, _: &File, capabilities: &Capabilities) -> io::Result<Probed> {
        if self.is_refused {
            return Err(io::Error::from(ErrorKind::PermissionDenied));
        }
        let range = |axis: u16| match axis {
            Z | RZ => Range {
                least: 0,
                most: 255,
            },
            _ => Range {
                least: -32768,
                most: 32767,
            },
        };
        let axes = capabilities.absolute.iter();
        Ok(Probed {
            axes: axes.map(|&axis| (axis, range(axis), 0)).collect(),
            buttons: Vec::new(),
        })
    }
}

/// A folder of devices.
struct Machine(tempfile::TempDir);

impl Machine {
    fn new() -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        for name in ["input", "class"] {
            fs::create_dir(folder.path().join(name)).expect("a folder");
        }
        Self(folder)
    }

    fn folders(&self) -> Folders {
        Folders {
            devices: self.0.path().join("input"),
            published: self.0.path().join("class"),
        }
    }

    /// Plugs a device in; it is there as long as the pipe is open.
    fn plug(&self, event: &str, name: &str, buttons: &str) -> File {
        let pipe = self.0.path().join("input").join(event);
        rustix::fs::mknodat(
            rustix::fs::CWD,
            &pipe,
            rustix::fs::FileType::Fifo,
            rustix::fs::Mode::from_raw_mode(0o600),
            0,
        )
        .expect("a pipe");
        let device = OpenOptions::new().read(true).write(true).open(&pipe);
        let published = self.0.path().join("class").join(event);
        let hidden = self.0.path().join(event);
        let write = |file: &str, text: &str| {
            let file = hidden.join("device").join(file);
            fs::create_dir_all(file.parent().expect("a folder")).expect("a folder");
            fs::write(file, text).expect("a file");
        };
        write("name", &format!("{name}\n"));
        write("id/vendor", "045e\n");
        write("id/product", "02ea\n");
        write("capabilities/key", buttons);
        write("capabilities/rel", "0\n");
        write("capabilities/abs", "3003f\n");
        // All at once, as it is with the system.
        fs::rename(hidden, published).expect("published");
        device.expect("the pipe opens")
    }

    fn unplug(&self, event: &str, device: File) {
        fs::remove_file(self.0.path().join("input").join(event)).expect("it was there");
        fs::remove_dir_all(self.0.path().join("class").join(event)).expect("it was there");
        drop(device);
    }
}

/// The buttons of an Xbox gamepad as the system publishes them, and those of a keyboard.
const PAD: &str = "7cdb000000000000 0 0 0 0\n";
const KEYBOARD: &str = "fffffffffffffffe\n";

fn wait_for(what: &str, mut is_so: impl FnMut() -> bool) {
    let begin = Instant::now();
    while !is_so() {
        assert!(begin.elapsed() < Duration::from_secs(20), "not {what}");
        thread::sleep(Duration::from_millis(2));
    }
}

fn write(device: &mut File, records: &[(u16, u16, i32)]) {
    let records: Vec<u8> = records
        .iter()
        .flat_map(|&(kind, code, value)| bytes(kind, code, value))
        .collect();
    device.write_all(&records).expect("written");
}

const COMPLETE: (u16, u16, i32) = (EV_SYN, SYN_REPORT, 0);

/// Found, read, unplugged while deflected, and plugged in again at another place.
#[test]
fn a_gamepad_comes_and_goes() {
    let machine = Machine::new();
    let woken = Arc::new(AtomicUsize::new(0));
    let wake = {
        let woken = Arc::clone(&woken);
        move || {
            woken.fetch_add(1, Ordering::Relaxed);
        }
    };
    let probe = Arc::new(AtRest { is_refused: false });
    let look = Duration::from_millis(5);
    let controllers = Controllers::look_in(machine.folders(), probe, look, wake);
    let controllers = controllers.expect("a thread");
    let _keyboard = machine.plug("event0", "Keyboard", KEYBOARD);
    let mut pad = machine.plug("event3", "Pad", PAD);
    let presence = |seen| Presence {
        name: "Pad".to_owned(),
        kind: Kind::Gamepad,
        seen,
    };
    wait_for("found", || {
        controllers.presences() == [presence(Seen::Here)]
    });
    assert!(controllers.take().is_none(), "nothing moves by itself");

    // Deflected for some time, which this test sees from outside and from inside.
    let mut sum = Motion::default();
    let outer = Instant::now();
    write(&mut pad, &[(EV_ABS, X, 32767), COMPLETE]);
    wait_for("moved", || {
        sum = sum.and(controllers.take());
        sum.shift[0] > 0.0
    });
    let (before, inner) = (sum.shift[0], Instant::now());
    thread::sleep(Duration::from_millis(50));
    write(&mut pad, &[(EV_KEY, NORTH, 1), COMPLETE]);
    wait_for("pressed", || {
        let presses = controllers.presses();
        presses == [Press::OtherHand] || {
            assert_eq!(presses, []);
            false
        }
    });
    sum = sum.and(controllers.take());
    let [inner, outer] = [inner, outer].map(|begin| begin.elapsed().as_secs_f64());
    assert!(sum.shift[0] <= outer, "{} of {outer}", sum.shift[0]);
    // A pause of this thread between `take` and its own clock makes the inner time shorter, never longer.
    let moved = sum.shift[0] - before;
    // The other axis of the stick rests half a step off its middle, which bends the direction by some 1e-10.
    assert!(moved >= 0.05 - 1e-6, "{moved} of {inner}");
    assert!(sum.shift[1].abs() < 1e-4 * sum.shift[0]);
    assert_eq!((sum.shift[2], sum.turn), (0.0, [0.0; 3]));

    // Records were lost: what the device is asked is that it rests.
    write(
        &mut pad,
        &[(EV_SYN, SYN_DROPPED, 0), (EV_ABS, X, -32768), COMPLETE],
    );
    wait_for("at rest", || controllers.take().is_none());

    write(&mut pad, &[(EV_ABS, X, 32767), COMPLETE]);
    wait_for("moved", || controllers.take().shift[0] > 0.0);
    machine.unplug("event3", pad);
    wait_for("gone", || controllers.presences() == [presence(Seen::Gone)]);
    controllers.take();
    thread::sleep(Duration::from_millis(20));
    assert!(controllers.take().is_none(), "the tool stays where it is");

    let before = woken.load(Ordering::Relaxed);
    let mut pad = machine.plug("event5", "Pad", PAD);
    wait_for("found again", || {
        controllers.presences() == [presence(Seen::Here)]
    });
    write(&mut pad, &[(EV_ABS, X, -32768), COMPLETE]);
    wait_for("moved", || controllers.take().shift[0] < 0.0);
    assert!(woken.load(Ordering::Relaxed) > before);
    machine.unplug("event5", pad);
    wait_for("gone", || controllers.presences() == [presence(Seen::Gone)]);
}

#[test]
fn what_may_not_be_read_is_named_with_what_to_do() {
    let machine = Machine::new();
    let probe = Arc::new(AtRest { is_refused: true });
    let look = Duration::from_millis(5);
    let controllers = Controllers::look_in(machine.folders(), probe, look, || {});
    let controllers = controllers.expect("a thread");
    let pad = machine.plug("event3", "Pad", PAD);
    let mut why = String::new();
    wait_for("refused", || {
        let presences = controllers.presences();
        presences.iter().any(|presence| match &presence.seen {
            Seen::Refused(text) => {
                why.clone_from(text);
                true
            }
            _ => false,
        })
    });
    assert!(
        why.contains("event3 may not be read") && why.contains("group `input`"),
        "{why}"
    );
    machine.unplug("event3", pad);
    wait_for("gone", || {
        controllers.presences().iter().all(|p| p.seen == Seen::Gone)
    });
}
