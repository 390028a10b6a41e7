//! A display without a screen, and a program at it that knows keys, mouse and what it sees: nothing of the window's inside.

use crate::command;
use crate::peers::{Peer, done};
use std::io::{BufRead, BufReader, Cursor, Write as _};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Debian's packages of what is used here.
const PACKAGES: [&str; 3] = ["xvfb", "xdotool", "imagemagick"];
/// And of what manages windows.
const MANAGERS: [&str; 2] = ["openbox", "x11-xserver-utils"];
/// Windows have no frames, so that a place in a window is a place on the display; keys are the program's.
const MANAGED: &str = "<?xml version=\"1.0\"?><openbox_config xmlns=\"http://openbox.org/3.4/rc\"><keyboard/><mouse/>\
    <applications><application class=\"*\"><decor>no</decor><position force=\"yes\"><x>0</x><y>0</y></position></application></applications></openbox_config>";

/// A virtual display.
#[derive(Debug)]
pub struct Display {
    /// Ends before the server does.
    _manager: Option<Peer>,
    _server: Peer,
    name: String,
}

/// Installs what is missing of programs, if it can be.
fn require(programs: &[&str], packages: &[&str]) -> Result<(), String> {
    let is_there = |program: &&str| done(Command::new("which").arg(program)).is_ok();
    if programs.iter().all(is_there) {
        return Ok(());
    }
    let mut install = Command::new("apt-get");
    install.args(["install", "-y", "-q"]).args(packages);
    install.env("DEBIAN_FRONTEND", "noninteractive");
    done(&mut install).map_err(|why| {
        let packages = packages.join(" ");
        format!("one of {programs:?} is missing and cannot be installed (apt-get install {packages}): {why}")
    })
}

/// A picture of all of the display.
#[derive(Clone, Debug)]
pub struct Shot {
    /// Width and height \[pixels\].
    pub size: [usize; 2],
    /// Red, green, blue of each pixel, row by row.
    pub pixels: Vec<[u8; 3]>,
}

/// Pixels of a kind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Blob {
    /// How many.
    pub count: usize,
    /// Their mean place \[pixels\].
    pub centre: [f64; 2],
    /// The uppermost of them \[pixels\].
    pub top: [f64; 2],
}

impl Shot {
    /// The pixels of a part of the picture, from `min` to `max` \[pixels\], that are such; `None` if there is none.
    pub fn find(
        &self,
        [min, max]: [[usize; 2]; 2],
        is_such: impl Fn([u8; 3]) -> bool,
    ) -> Option<Blob> {
        let mut blob: Option<Blob> = None;
        for y in min[1]..max[1].min(self.size[1]) {
            for x in min[0]..max[0].min(self.size[0]) {
                if !is_such(self.pixels[y * self.size[0] + x]) {
                    continue;
                }
                let place = [x as f64, y as f64];
                let found = blob.get_or_insert(Blob {
                    count: 0,
                    centre: [0.0; 2],
                    top: place,
                });
                found.count += 1;
                for (sum, part) in found.centre.iter_mut().zip(place) {
                    *sum += part;
                }
            }
        }
        let mut blob = blob?;
        blob.centre = blob.centre.map(|sum| sum / blob.count as f64);
        Some(blob)
    }
}

impl Display {
    /// Opens a display of 1280 × 720 pixels; what it needs is installed if it can be.
    ///
    /// # Errors
    /// What is missing.
    pub fn open() -> Result<Self, String> {
        Self::open_of([1280, 720])
    }

    /// The same of another size \[pixels\].
    ///
    /// # Errors
    /// What is missing.
    pub fn open_of([width, height]: [u32; 2]) -> Result<Self, String> {
        require(&["Xvfb", "xdotool", "import"], &PACKAGES)?;
        let screen = format!("{width}x{height}x24");
        let mut server = Command::new("Xvfb");
        server.args([
            "-displayfd",
            "1",
            "-screen",
            "0",
            &screen,
            "-nolisten",
            "tcp",
        ]);
        let server = server.stdout(Stdio::piped()).stderr(Stdio::null()).spawn();
        let mut server = Peer(server.map_err(|e| format!("Xvfb: {e}"))?);
        let output = server.0.stdout.take().ok_or("Xvfb has no output")?;
        let mut number = String::new();
        let read = BufReader::new(output).read_line(&mut number);
        read.map_err(|e| format!("Xvfb: {e}"))?;
        match number.trim() {
            "" => Err("Xvfb did not start".into()),
            number => Ok(Self {
                _manager: None,
                _server: server,
                name: format!(":{number}"),
            }),
        }
    }

    /// Its name, for `DISPLAY`.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The program with a window here, with this data folder; what it prints is thrown away.
    pub fn program<'a>(
        &self,
        data: &Path,
        arguments: impl IntoIterator<Item = &'a str>,
    ) -> Command {
        let mut program = command(arguments);
        program
            .env("DISPLAY", &self.name)
            .env("MICROSIM_DATA", data);
        program.env("XDG_RUNTIME_DIR", data);
        program.stdout(Stdio::null()).stderr(Stdio::null());
        program
    }

    /// Has windows managed from now on, as a desktop does: they are minimised, and fill the screen. `folder` takes the settings of the manager.
    ///
    /// # Errors
    /// What is missing.
    pub fn manage(&mut self, folder: &Path) -> Result<(), String> {
        require(&["openbox", "xrdb"], &MANAGERS)?;
        let file = folder.join("openbox.xml");
        std::fs::write(&file, MANAGED).map_err(|e| format!("{}: {e}", file.display()))?;
        let mut manager = Command::new("openbox");
        manager.arg("--config-file").arg(file);
        manager.env("DISPLAY", &self.name);
        let manager = manager.stdout(Stdio::null()).stderr(Stdio::null()).spawn();
        self._manager = Some(Peer(manager.map_err(|e| format!("openbox: {e}"))?));
        Ok(())
    }

    /// Sets how many pixels a desktop's inch has, which windows learn at once: 96 are a scale of 1.
    ///
    /// # Errors
    /// What is missing.
    pub fn set_resolution(&self, per_inch: u32) -> Result<(), String> {
        let mut command = Command::new("xrdb");
        command.args(["-merge", "-"]).env("DISPLAY", &self.name);
        let child = command.stdin(Stdio::piped()).spawn();
        let mut child = child.map_err(|e| format!("xrdb: {e}"))?;
        let input = child.stdin.take().ok_or("xrdb has no input")?;
        let written = writeln!({ input }, "Xft.dpi: {per_inch}");
        written.map_err(|e| format!("xrdb: {e}"))?;
        let ended = child.wait().map_err(|e| format!("xrdb: {e}"))?;
        ended
            .success()
            .then_some(())
            .ok_or(format!("xrdb: {ended}"))
    }

    /// What xdotool answers; it is given twenty seconds.
    ///
    /// # Errors
    /// What it complains about, or that it took longer.
    pub fn ask(&self, arguments: &[&str]) -> Result<String, String> {
        let mut command = Command::new("timeout");
        command.args(["20", "xdotool"]).args(arguments);
        let output = command.env("DISPLAY", &self.name).output();
        let output = output.map_err(|e| format!("xdotool: {e}"))?;
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).trim().to_owned();
        match output.status.success() {
            true => Ok(text(&output.stdout)),
            false => Err(format!(
                "xdotool {arguments:?}: {}{}",
                output.status,
                text(&output.stderr)
            )),
        }
    }

    fn xdotool(&self, arguments: &[&str]) {
        self.ask(arguments).unwrap_or_else(|e| panic!("{e}"));
    }

    /// Gives the window of this title the keyboard, as a window manager would.
    pub fn focus(&self, title: &str) {
        self.xdotool(&[
            "search",
            "--sync",
            "--onlyvisible",
            "--name",
            title,
            "windowfocus",
            "--sync",
        ]);
    }

    /// Presses a key, as X11 calls it.
    pub fn key(&self, key: &str) {
        self.xdotool(&["key", key]);
    }

    /// Types a text.
    pub fn text(&self, text: &str) {
        self.xdotool(&["type", "--delay", "5", text]);
    }

    /// Puts the pointer somewhere \[pixels\].
    pub fn point(&self, [x, y]: [i32; 2]) {
        self.xdotool(&["mousemove", &x.to_string(), &y.to_string()]);
    }

    /// Moves the pointer by this much in so many steps, one in 30 ms.
    pub fn drag(&self, by: [f64; 2], steps: u32) {
        let mut done = [0; 2];
        for step in 1..=steps {
            let part = f64::from(step) / f64::from(steps);
            let to = by.map(|by| (by * part).round() as i32);
            let [dx, dy] = [to[0] - done[0], to[1] - done[1]].map(|d| d.to_string());
            self.xdotool(&["mousemove_relative", "--", &dx, &dy]);
            done = to;
            std::thread::sleep(Duration::from_millis(30));
        }
    }

    /// Presses a button, or releases it: 1 left, 3 right, 4 and 5 the wheel away from the hand and back.
    pub fn button(&self, button: u8, is_pressed: bool) {
        let action = if is_pressed { "mousedown" } else { "mouseup" };
        self.xdotool(&[action, &button.to_string()]);
    }

    /// Clicks on a widget that shows whether the pointer is above it. Waits until something there has changed: of all that comes before one picture the window knows the last place of
    /// the pointer alone. For the same reason whoever calls waits for what the click does before the pointer goes on. Where nothing answers, two seconds pass, and that is printed.
    pub fn click(&self, place: [i32; 2]) {
        let [x, y] = place.map(|c| usize::try_from(c).unwrap_or(0));
        let around = |shot: Shot| -> Vec<[u8; 3]> {
            let rows = y.saturating_sub(16)..(y + 16).min(shot.size[1]);
            let columns = x.saturating_sub(40)..(x + 40).min(shot.size[0]);
            rows.flat_map(|y| shot.pixels[y * shot.size[0]..][columns.clone()].to_vec())
                .collect()
        };
        let before = around(self.shot());
        self.point(place);
        let start = Instant::now();
        while around(self.shot()) == before {
            if start.elapsed() > Duration::from_secs(2) {
                eprintln!("nothing at {place:?} shows the pointer");
                break;
            }
            std::thread::sleep(Duration::from_millis(50));
        }
        self.button(1, true);
        self.button(1, false);
    }

    /// A picture of it.
    ///
    /// # Panics
    /// If none can be taken.
    pub fn shot(&self) -> Shot {
        let mut command = Command::new("import");
        command
            .args(["-window", "root", "png:-"])
            .env("DISPLAY", &self.name);
        let output = command.output().expect("import runs");
        let mut decoder = png::Decoder::new(Cursor::new(output.stdout));
        decoder.set_transformations(png::Transformations::normalize_to_color8());
        let mut reader = decoder.read_info().expect("a PNG file");
        let mut bytes = vec![0; reader.output_buffer_size().expect("a size")];
        let info = reader.next_frame(&mut bytes).expect("a picture");
        let samples = info.color_type.samples();
        let pixel = |c: &[u8]| match samples {
            1 | 2 => [c[0]; 3],
            _ => [c[0], c[1], c[2]],
        };
        Shot {
            size: [info.width as usize, info.height as usize],
            pixels: bytes[..info.buffer_size()]
                .chunks_exact(samples)
                .map(pixel)
                .collect(),
        }
    }

    /// Keeps this picture for people.
    pub fn keep(&self, file: &Path) {
        let mut command = Command::new("import");
        command
            .args(["-window", "root"])
            .arg(file)
            .env("DISPLAY", &self.name);
        done(&mut command).expect("a picture");
    }

    /// Looks at the display until something is there, for at most so long.
    ///
    /// # Panics
    /// If it does not come.
    pub fn wait_for<T>(
        &self,
        what: &str,
        most: Duration,
        seen: impl Fn(&Shot) -> Option<T>,
    ) -> (Shot, T) {
        let start = Instant::now();
        loop {
            let shot = self.shot();
            if let Some(found) = seen(&shot) {
                return (shot, found);
            }
            if start.elapsed() > most {
                let file = std::env::temp_dir().join(format!("{}.png", what.replace(' ', "-")));
                self.keep(&file);
                panic!(
                    "not seen within {most:?}: {what}; what was seen: {}",
                    file.display()
                );
            }
            std::thread::sleep(Duration::from_millis(100));
        }
    }
}
