//! Writes the scripted trainees of this module: `cargo run --release -p microsim-module-coordination --example
//! write_coordination_scripts`. Per level one that passes and some that fail, each for one reason.

use microsim_host::assemble::known_metrics;
use microsim_sdk::turned_to;
use microsim_settings::{Body, Level, Shape};
use std::fmt::Write;
use std::path::Path;

/// Of the forceps: around the tissue, on it, and far into it.
const OPEN: f64 = 0.75;
const GRIP: f64 = 0.13;
const FIRM: f64 = 0.11;
const CRUSH: f64 = 0.03;

/// Of the scissors.
const WIDE: f64 = 0.8;

/// Where the free end of elastic tissue hangs once it is cut at one mark (level 3, measured) \[m\].
const DROOP: f64 = -0.0005;

/// How far a mark has gone towards the forceps once the tissue is cut at the one close to it (level 5, measured) \[m\].
const GIVEN: f64 = -0.0001;

/// A rest that is too long \[s\].
const PAUSE: f64 = 14.0;

/// How far the tips of closed forceps are below the upper side of tissue that lies on them: its thickness, less what it yields
/// \[m\].
const UNDER: f64 = 0.00055;

/// Where tools wait \[m\].
const AWAY: f64 = -0.010;

/// Direction from tip to handle of the forceps of a left hand.
const TOWARDS_HAND: [f64; 3] = [-0.35, -0.9367496997597597, 0.0];

/// Where the tips of the forceps are when their jaws, which lie askew, are in the middle between the marks \[m\].
const BETWEEN: f64 = 0.0003;

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
    /// \[s\]
    dwell: f64,
    /// \[s\]
    time_limit: f64,
    /// How many times as long as at rest the tissue is between the clamps.
    stretch: f64,
    /// Where the clamp on the right begins \[m\].
    edge: f64,
}

impl Place {
    /// Where a mark is along the stretched tissue \[m\].
    fn now(&self, mark: [f64; 3]) -> f64 {
        self.stretch * mark[0]
    }

    /// Where the mark farthest from the scissors is once the tissue hangs from its own clamp alone \[m\].
    fn free(&self) -> f64 {
        self.marks[0][0] - (self.stretch - 1.0) * self.edge
    }

    /// Where to cut: the mark on the side of the scissors first \[m\].
    fn order(&self) -> [f64; 2] {
        [self.now(self.marks[1]), self.now(self.marks[0])]
    }
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
    let k = (0..4)
        .max_by(|a, b| squares[*a].total_cmp(&squares[*b]))
        .unwrap_or(3);
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
    /// Direction from tip to handle of the forceps, and whether their jaws lie side by side instead of one above the other.
    towards: [f64; 3],
    rolled: bool,
    /// Angle of the scissors to the marks \[rad\].
    askew: f64,
    /// Height at which the scissors work \[m\].
    droop: f64,
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
            towards: TOWARDS_HAND,
            rolled: false,
            askew: 0.0,
            droop: 0.0,
        };
        hands.key(0.0);
        hands
    }

    fn write_key(
        &mut self,
        tool: usize,
        (place, opening): ([f64; 3], f64),
        towards: [f64; 3],
        rolled: bool,
    ) {
        let side = self.place.side;
        let [x, y, z] = [side * place[0], place[1], place[2]].map(|c| 1e3 * c);
        let towards = [side * towards[0], towards[1], towards[2]];
        let [a, b, c, d] = match rolled {
            true => turned_to(towards),
            false => upright(towards),
        };
        let _ = write!(
            self.text[tool],
            "\n[[tool.key]]\nt = \"{:.3} s\"\nposition = [\"{x:.4} mm\", \"{y:.4} mm\", \"{z:.4} mm\"]\norientation = [{a}, {b}, {c}, {d}]\nopening = {opening}\n",
            self.time,
        );
    }

    /// Both are where they are to be after `seconds`.
    fn key(&mut self, seconds: f64) {
        self.time += seconds;
        self.write_key(0, self.forceps, self.towards, self.rolled);
        if self.place.scissors.is_some() {
            let towards = [libm::sin(self.askew), -libm::cos(self.askew), 0.0];
            self.write_key(1, self.scissors, towards, false);
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

    /// Leads the closed forceps below the tissue at `x`, without gripping it.
    fn reach_below(&mut self, x: f64) {
        (self.towards, self.rolled) = ([0.0, -1.0, 0.0], true);
        self.forceps = ([x, AWAY, -0.0015], 0.0);
        self.key(0.8);
        self.forceps.0[1] = 0.0016;
        self.key(1.0);
    }

    /// Goes up or down with what the forceps hold, to `height` above where the tissue is stretched.
    fn lift(&mut self, height: f64) {
        self.forceps.0[2] = height;
        self.key(1.2);
    }

    /// Leads the open scissors around the tissue at `x`, closes them there and takes them away.
    fn cut(&mut self, x: f64, closed: f64) {
        self.scissor(x, BEYOND, closed);
    }

    /// Cuts the near edge at `x`.
    fn snip(&mut self, x: f64) {
        self.scissor(x, 0.0002, 0.0);
    }

    /// A cut at `x` with the tips at `y`.
    fn scissor(&mut self, x: f64, y: f64, closed: f64) {
        // The marks' middle is on the blades' line, however they are turned.
        let at = |y: f64| [x - y * libm::tan(self.askew), y, self.droop];
        let (away, near, around) = (at(AWAY), at(-0.005), at(y));
        self.scissors = (away, 0.0);
        self.key(0.5);
        self.scissors = (near, WIDE);
        self.key(0.4);
        self.scissors.0 = around;
        self.key(0.7);
        self.scissors.1 = closed;
        self.key(1.0);
        self.scissors.0 = near;
        self.key(0.4);
        self.scissors.0 = away;
        self.key(0.3);
    }

    /// Goes to and fro with what the forceps hold, for more than `seconds`.
    fn wander(&mut self, seconds: f64) {
        let begin = self.time;
        let middle = self.forceps.0;
        for turn in 0.. {
            if self.time - begin > seconds {
                break;
            }
            let aside = if turn % 2 == 0 { 0.0004 } else { -0.0004 };
            self.forceps.0 = [middle[0] + aside, middle[1], middle[2]];
            self.scissors.0[2] = aside;
            self.key(1.0);
        }
    }

    /// Carries what the forceps hold by `path`, releases it there and withdraws.
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

    /// Stays so for a while, and writes all of it.
    fn write(mut self, folder: &Path, name: &str, stay: f64) {
        self.key(stay);
        let place = self.place;
        let mut text = format!(
            "# {}\n# Written by the example write_coordination_scripts of this module.\nmodule = \"coordination\"\nlevel = {}\nrate = \"62.5 Hz\"\ninterpolation = \"minimum-jerk\"\n",
            self.doc, place.level
        );
        let _ = write!(
            text,
            "\n[[tool]]\nname = \"{}\"\n{}",
            place.forceps, self.text[0]
        );
        if let Some(scissors) = &place.scissors {
            let _ = write!(text, "\n[[tool]]\nname = \"{scissors}\"\n{}", self.text[1]);
        }
        let file = folder.join(format!("level{}-{name}.toml", place.level));
        std::fs::write(file, text).expect("the scripts folder can be written");
    }
}

/// Grip at the mark, lift it into the ring.
fn hold(folder: &Path, place: &Place) {
    let ring = place.ring.expect("a ring");
    let height = ring[2] - place.marks[0][2];
    let begin = |doc, closed| {
        let mut hands = Hands::new(place, doc);
        hands.grip(0.0, closed);
        hands
    };
    let dwell = place.dwell;

    let mut pass = begin("Grips at the mark and holds it in the ring.", GRIP);
    pass.lift(height);
    pass.write(folder, "pass", dwell + 0.5);

    let mut low = begin("Lifts the mark to less than half of the height.", GRIP);
    low.lift(0.3 * height);
    low.write(folder, "fail-not-in-ring", dwell + 0.5);

    let mut short = begin("Lets the mark down again at once.", GRIP);
    short.lift(height);
    short.lift(0.0);
    short.write(folder, "fail-dwell-too-short", 0.5);

    let mut hard = begin("Crushes the tissue before it lifts it.", CRUSH);
    hard.lift(height);
    hard.write(folder, "miss-crushed", dwell + 0.5);

    let mut far = begin("Pulls the tissue far beyond the ring first.", FIRM);
    far.lift(2.6 * height);
    far.lift(height);
    far.write(folder, "fail-too-hard", dwell + 0.5);

    let mut hooked = Hands::new(
        place,
        "Lifts the tissue into the ring from below, with closed forceps.",
    );
    hooked.reach_below(0.0);
    hooked.lift(height - UNDER);
    hooked.write(folder, "fail-not-gripped", dwell + 0.5);

    let mut slow = begin(
        "Holds the tissue below the ring and wanders about until the time is over.",
        GRIP,
    );
    slow.wander(place.time_limit);
    slow.write(folder, "fail-too-slow", 0.5);
}

/// One cut in stiff tissue.
fn cut_once(folder: &Path, place: &Place) {
    let x = place.now(place.marks[0]);
    let stay = 0.5;

    let mut pass = Hands::new(place, "Cuts at the mark.");
    pass.cut(x, 0.0);
    pass.write(folder, "pass", stay);

    let mut beside = Hands::new(place, "Cuts 0.7 mm beside the mark.");
    beside.cut(x + 0.0007, 0.0);
    beside.write(folder, "miss-cut-beside-the-mark", stay);

    let mut askew = Hands::new(place, "Cuts askew through the mark.");
    askew.askew = 0.45;
    askew.cut(x, 0.0);
    askew.write(folder, "miss-cut-askew", stay);

    let mut stray = Hands::new(
        place,
        "Snips the edge 1 mm beside the mark, then cuts at the mark.",
    );
    stray.snip(x + 0.001);
    stray.cut(x, 0.0);
    stray.write(folder, "miss-stray-cut", stay);

    let mut uncut = Hands::new(
        place,
        "Leads the scissors around the tissue, but hardly closes them.",
    );
    uncut.cut(x, WIDE);
    uncut.write(folder, "fail-not-cut", stay);

    let mut idle = Hands::new(place, "Waits before it cuts at the mark.");
    idle.key(PAUSE);
    idle.cut(x, 0.0);
    idle.write(folder, "fail-tool-idle", stay);
}

/// Two cuts in elastic tissue.
fn cut_twice(folder: &Path, place: &Place) {
    let [first, second] = place.order();
    let steadied = |doc| {
        let mut hands = Hands::new(place, doc);
        hands.grip(BETWEEN, GRIP);
        hands
    };
    let stay = 0.3;

    let mut pass = steadied("Steadies the tissue between the marks and cuts at both.");
    pass.cut(first, 0.0);
    pass.cut(second, 0.0);
    pass.write(folder, "pass", stay);

    let mut alone = Hands::new(place, "Cuts at both marks with the scissors alone.");
    alone.cut(first, 0.0);
    alone.droop = DROOP;
    alone.cut(place.free(), 0.0);
    alone.write(folder, "fail-not-steadied", stay);

    let mut beside = steadied("Cuts 0.6 mm beside the first mark.");
    beside.cut(first + 0.0006, 0.0);
    beside.cut(second, 0.0);
    beside.write(folder, "miss-cut-beside-the-mark", stay);

    let mut one = steadied("Cuts at the first mark alone.");
    one.cut(first, 0.0);
    one.write(folder, "fail-not-cut", stay);

    let mut hard = Hands::new(place, "Crushes the tissue before it cuts.");
    hard.grip(BETWEEN, CRUSH);
    hard.cut(first, 0.0);
    hard.cut(second, 0.0);
    hard.write(folder, "miss-crushed", stay);

    let mut stray = steadied("Snips the edge of the tissue far from the marks before it cuts.");
    stray.snip(first + 0.0017);
    stray.cut(first, 0.0);
    stray.cut(second, 0.0);
    stray.write(folder, "miss-stray-cut", stay);
}

/// Cut at both marks, carry, drop in the tray.
fn deliver(folder: &Path, place: &Place) {
    let tray = place.tray.expect("a tray");
    let [first, mut second] = place.order();
    if place.level == 5 {
        second += GIVEN;
    }
    let path = [tray[0], tray[1] + 0.0003, tray[2] + 0.002];
    let stay = place.dwell + 0.5;
    let begin = |doc| {
        let mut hands = Hands::new(place, doc);
        hands.grip(BETWEEN, GRIP);
        hands
    };
    let cut_both = |hands: &mut Hands<'_>| {
        hands.cut(first, 0.0);
        hands.cut(second, 0.0);
    };

    let mut pass =
        begin("Steadies the tissue, cuts at both marks and drops the piece in the tray.");
    cut_both(&mut pass);
    pass.put(path);
    pass.write(folder, "pass", stay);

    let mut outside = begin("Drops the piece beside the tray.");
    cut_both(&mut outside);
    outside.put([path[0] + 0.0075, path[1], path[2]]);
    outside.write(folder, "fail-not-in-tray", stay);

    let beside = || {
        let mut beside = begin("Cuts beside the first mark.");
        beside.cut(first + 0.0006, 0.0);
        beside.cut(second, 0.0);
        beside.put(path);
        beside.write(folder, "miss-cut-beside-the-mark", stay);
    };
    let idle = || {
        let mut idle = begin("Rests between the cuts.");
        idle.cut(first, 0.0);
        idle.key(PAUSE);
        idle.cut(second, 0.0);
        idle.put(path);
        idle.write(folder, "fail-tool-idle", stay);
    };
    match place.level {
        4 => {
            beside();
            let mut hard = Hands::new(
                place,
                "Pulls the tissue far up, and for long, before it cuts.",
            );
            hard.grip(BETWEEN, FIRM);
            hard.lift(0.0045);
            hard.key(0.8);
            hard.lift(0.0);
            hard.forceps.1 = GRIP;
            cut_both(&mut hard);
            hard.put(path);
            hard.write(folder, "miss-too-hard", stay);
            idle();
        }
        5 => {
            beside();
            let mut slow = begin("Wanders about with the held tissue until the time is over.");
            slow.wander(place.time_limit);
            slow.write(folder, "fail-too-slow", 0.5);
        }
        _ => {
            let mut askew = begin("Cuts askew at both marks.");
            askew.askew = 0.45;
            cut_both(&mut askew);
            askew.put(path);
            askew.write(folder, "miss-cut-askew", stay);

            let mut hard = Hands::new(place, "Crushes the tissue before it cuts.");
            hard.grip(BETWEEN, CRUSH);
            cut_both(&mut hard);
            hard.put(path);
            hard.write(folder, "miss-crushed", stay);
            idle();
        }
    }
}

/// How much the clamp on the right stretches the tissue that begins at its edge, and where that is \[m\].
fn stretch(body: &Body) -> [f64; 2] {
    let clamp = &body.clamp[1];
    let edge = clamp.nodes.min.expect("a clamp's box")[0];
    let shift = clamp.motion.last().map_or(0.0, |place| place.shift[0]);
    [(edge + shift) / edge, edge]
}

fn read(module: &Path, level: u32) -> Option<Place> {
    let path = module.join("levels").join(format!("level{level}.toml"));
    if !path.is_file() {
        return None;
    }
    let manifest = microsim_settings::load_manifest(&module.join("module.toml"));
    let manifest = manifest.expect("a good manifest").settings;
    let level_file = microsim_settings::load_level(&path, &manifest, &known_metrics());
    let Level {
        tool,
        object,
        rigid,
        body,
        limit,
        module: keys,
        ..
    } = level_file.expect("a good level").settings;
    let slot = |model: &str| {
        tool.iter()
            .find(|t| t.model == model)
            .map(|t| t.name.clone())
    };
    let forceps = slot("forceps").expect("forceps");
    let side = if forceps == "left" { 1.0 } else { -1.0 };
    let mirrored = |[x, y, z]: [f64; 3]| [side * x, y, z];
    let marks = object.iter().filter(|o| o.name.starts_with("mark-"));
    let ring = object
        .iter()
        .find(|o| matches!(o.shape, Shape::Ring { .. }));
    let tray = rigid.iter().find(|obstacle| obstacle.name == "tray");
    let mut marks: Vec<_> = marks.map(|mark| mirrored(mark.position)).collect();
    marks.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let [stretch, edge] = stretch(&body[0]);
    Some(Place {
        level,
        side,
        forceps,
        scissors: slot("micro-scissors"),
        marks,
        ring: ring.map(|object| mirrored(object.position)),
        tray: tray.map(|obstacle| mirrored(obstacle.position)),
        dwell: keys["dwell"].as_f64().expect("a quantity"),
        time_limit: limit
            .iter()
            .find(|l| l.metric == "time")
            .and_then(|l| l.max)
            .expect("a time limit"),
        stretch,
        edge,
    })
}

fn main() {
    let module = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = module.join("scripts");
    for level in 1.. {
        let Some(place) = read(module, level) else {
            break;
        };
        match (place.ring, place.tray, place.marks.len()) {
            (Some(_), _, _) => hold(&folder, &place),
            (None, Some(_), _) => deliver(&folder, &place),
            (None, None, 1) => cut_once(&folder, &place),
            (None, None, _) => cut_twice(&folder, &place),
        }
    }
}
