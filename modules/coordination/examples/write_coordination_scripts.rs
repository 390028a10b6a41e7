//! Writes the scripted trainees of this module: `cargo run --release -p microsim-module-coordination --example
//! write_coordination_scripts`. Per level one that passes and some that fail, each for one reason.

use microsim_host::assemble::known_metrics;
use microsim_settings::{Level, Shape};
use std::fmt::Write;
use std::path::Path;

/// Of the forceps: around the tissue, on it, and far into it.
const OPEN: f64 = 0.75;
const GRIP: f64 = 0.13;
const CRUSH: f64 = 0.03;

/// Of the scissors.
const WIDE: f64 = 0.8;

/// Where tools wait \[m\].
const AWAY: f64 = -0.010;

/// Direction from tip to handle of the forceps of a left hand.
const TOWARDS_HAND: [f64; 3] = [-0.35, -0.9367496997597597, 0.0];

/// How far the forceps' tips lie beyond the middle line of the tissue, and the scissors' \[m\].
const ACROSS: f64 = 0.0007;
const BEYOND: f64 = 0.0013;

/// A level as its trainees see it. Everything is written for a right-handed trainee; `side` is −1 where the hands are exchanged.
struct Place {
    level: u32,
    side: f64,
    /// Slots of the forceps and of the scissors, if there are some.
    forceps: String,
    scissors: Option<String>,
    marks: Vec<[f64; 3]>,
    ring: Option<[f64; 3]>,
    tray: Option<[f64; 3]>,
    dwell: f64,
}

/// The rotation whose x axis is up and whose z axis is `h`, which is horizontal.
fn upright(h: [f64; 3]) -> [f64; 4] {
    // Columns: x = (0, 0, 1), y = z × x, z = h.
    let (x, y, z) = ([0.0, 0.0, 1.0], [h[1], -h[0], 0.0], h);
    let m = [[x[0], y[0], z[0]], [x[1], y[1], z[1]], [x[2], y[2], z[2]]];
    // The trace is h_x of y's row: the largest component decides which root is safe.
    let squares = [
        1.0 + m[0][0] - m[1][1] - m[2][2],
        1.0 - m[0][0] + m[1][1] - m[2][2],
        1.0 - m[0][0] - m[1][1] + m[2][2],
        1.0 + m[0][0] + m[1][1] + m[2][2],
    ];
    let k = (0..4).max_by(|a, b| squares[*a].total_cmp(&squares[*b])).unwrap_or(3);
    let r = 2.0 * squares[k].sqrt();
    let mut q = match k {
        0 => [0.0, m[0][1] + m[1][0], m[0][2] + m[2][0], m[2][1] - m[1][2]],
        1 => [m[0][1] + m[1][0], 0.0, m[1][2] + m[2][1], m[0][2] - m[2][0]],
        2 => [m[0][2] + m[2][0], m[1][2] + m[2][1], 0.0, m[1][0] - m[0][1]],
        _ => [m[2][1] - m[1][2], m[0][2] - m[2][0], m[1][0] - m[0][1], 0.0],
    }
    .map(|c| c / r);
    q[k] = 0.25 * r;
    q
}

/// Both hands, key by key.
struct Hands<'a> {
    place: &'a Place,
    doc: &'static str,
    time: f64,
    text: [String; 2],
    forceps: ([f64; 3], f64),
    scissors: ([f64; 3], f64),
    /// Angle of the scissors to the marks \[rad\].
    askew: f64,
}

impl<'a> Hands<'a> {
    fn new(place: &'a Place, doc: &'static str) -> Self {
        let mut hands = Self {
            place,
            doc,
            time: 0.0,
            text: [String::new(), String::new()],
            forceps: ([-0.003, AWAY, 0.0], OPEN),
            scissors: ([0.003, AWAY, 0.0], 0.0),
            askew: 0.0,
        };
        hands.key(0.0);
        hands
    }

    fn write_key(&mut self, tool: usize, (place, opening): ([f64; 3], f64), towards: [f64; 3]) {
        let side = self.place.side;
        let [x, y, z] = [side * place[0], place[1], place[2]].map(|c| 1e3 * c);
        let [a, b, c, d] = upright([side * towards[0], towards[1], towards[2]]);
        let _ = write!(
            self.text[tool],
            "\n[[tool.key]]\nt = \"{:.3} s\"\nposition = [\"{x:.4} mm\", \"{y:.4} mm\", \"{z:.4} mm\"]\norientation = [{a}, {b}, {c}, {d}]\nopening = {opening}\n",
            self.time,
        );
    }

    /// Both are where they are to be after `seconds`.
    fn key(&mut self, seconds: f64) {
        self.time += seconds;
        self.write_key(0, self.forceps, TOWARDS_HAND);
        if self.place.scissors.is_some() {
            let towards = [libm::sin(self.askew), -libm::cos(self.askew), 0.0];
            self.write_key(1, self.scissors, towards);
        }
    }

    /// Grips the tissue at `x`.
    fn grip(&mut self, x: f64, opening: f64) {
        self.forceps = ([x, AWAY, 0.0], OPEN);
        self.key(0.5);
        self.forceps.0[1] = ACROSS;
        self.key(1.0);
        self.forceps.1 = opening;
        self.key(0.8);
        self.forceps.1 = GRIP;
        self.key(0.2);
    }

    /// Leads the open scissors around the tissue at `x`, closes them there and takes them away.
    fn cut(&mut self, x: f64, z: f64, closed: f64) {
        self.scissors = ([x, AWAY, z], 0.0);
        self.key(0.6);
        self.scissors = ([x, -0.005, z], WIDE);
        self.key(0.4);
        self.scissors.0[1] = BEYOND;
        self.key(0.8);
        self.scissors.1 = closed;
        self.key(1.2);
        self.scissors.0[1] = AWAY;
        self.key(0.8);
    }

    /// Carries what the forceps hold by `way`, lets it go there and withdraws.
    fn put(&mut self, [x, y, z]: [f64; 3]) {
        self.scissors.0[0] += 0.006;
        self.forceps.0[2] += 0.0005;
        self.key(0.5);
        let [from_x, from_y, _] = self.forceps.0;
        self.forceps.0 = [from_x + x, from_y + y, 0.0];
        self.key(1.5);
        self.forceps.0[2] = z;
        self.key(1.0);
        self.forceps.1 = 0.5;
        self.key(0.5);
        self.forceps.0[1] -= 0.004;
        self.key(0.8);
    }

    fn write(mut self, folder: &Path, name: &str, stay: f64) {
        self.key(stay);
        let place = self.place;
        let mut text = format!(
            "# {}\n# Written by the example write_coordination_scripts of this module.\nrate = \"62.5 Hz\"\ninterpolation = \"minimum-jerk\"\n",
            self.doc
        );
        let _ = write!(text, "\n[[tool]]\nname = \"{}\"\n{}", place.forceps, self.text[0]);
        if let Some(scissors) = &place.scissors {
            let _ = write!(text, "\n[[tool]]\nname = \"{scissors}\"\n{}", self.text[1]);
        }
        let file = folder.join(format!("level{}-{name}.toml", place.level));
        std::fs::write(file, text).expect("the scripts folder can be written");
    }
}

/// Cut at both marks, carry, drop in the tray.
fn deliver(folder: &Path, place: &Place) {
    let tray = place.tray.expect("a tray");
    let way = [tray[0], tray[1], tray[2] + 0.002];
    let stay = place.dwell + 0.5;
    let [first, second] = [place.marks[1][0], place.marks[0][0]];

    let mut pass = Hands::new(place, "Steadies the tissue, cuts at both marks and drops the piece in the tray.");
    pass.grip(0.0, GRIP);
    pass.cut(first, 0.0, 0.0);
    pass.cut(second, 0.0, 0.0);
    pass.put(way);
    pass.write(folder, "pass", stay);
}

fn read(module: &Path, level: u32) -> Option<Place> {
    let path = module.join("levels").join(format!("level{level}.toml"));
    if !path.is_file() {
        return None;
    }
    let manifest = microsim_settings::load_manifest(&module.join("module.toml"));
    let manifest = manifest.expect("a good manifest").settings;
    let level_file = microsim_settings::load_level(&path, &manifest, &known_metrics());
    let Level { tool, object, rigid, module: keys, .. } = level_file.expect("a good level").settings;
    let slot = |model: &str| tool.iter().find(|t| t.model == model).map(|t| t.name.clone());
    let forceps = slot("forceps").expect("forceps");
    let side = if forceps == "left" { 1.0 } else { -1.0 };
    let mirrored = |[x, y, z]: [f64; 3]| [side * x, y, z];
    let marks = object.iter().filter(|o| o.name.starts_with("mark-"));
    let ring = object.iter().find(|o| matches!(o.shape, Shape::Ring { .. }));
    let tray = rigid.iter().find(|thing| thing.name == "tray");
    let mut marks: Vec<_> = marks.map(|mark| mirrored(mark.position)).collect();
    marks.sort_by(|a, b| a[0].total_cmp(&b[0]));
    Some(Place {
        level,
        side,
        forceps,
        scissors: slot("micro-scissors"),
        marks,
        ring: ring.map(|object| mirrored(object.position)),
        tray: tray.map(|thing| mirrored(thing.position)),
        dwell: keys["dwell"].as_f64().expect("a quantity"),
    })
}

fn main() {
    let module = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = module.join("scripts");
    for level in 1..=6 {
        if let Some(place) = read(module, level) {
            deliver(&folder, &place);
        }
    }
}
