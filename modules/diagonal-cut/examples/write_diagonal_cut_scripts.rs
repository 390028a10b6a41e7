//! Writes the scripted trainees of this module: `cargo run --release -p microsim-module-diagonal-cut --example
//! write_diagonal_cut_scripts`. Per level some that pass and some that fail, each for one reason.

use std::fmt::Write;
use std::path::{Path, PathBuf};

/// How far the scissors are open around the vessel, of 1.
const WIDE: f64 = 0.8;

/// The same of the forceps: around the vessel, on it, and far into it.
const OPEN: f64 = 0.75;
const GRIP: f64 = 0.13;
const CRUSH: f64 = 0.09;

/// Where the scissors wait, before the vessel \[mm\].
const AWAY: f64 = -7.0;

/// How far beyond the axis the tips of the scissors reach \[mm\].
const BEYOND: f64 = 1.1;

/// Where along the vessel, which ends at -0.5 mm, the cuts cross its axis \[mm\].
const CUT: f64 = 0.9;

/// Angle of the blades with which the openings of levels 1 and 2, and of level 4, match \[degrees\]: less than that of the ellipse (45 and 52), as they flatten the vessel before
/// they cut. Measured.
const MATCHING: f64 = 34.0;
const STEEPER: f64 = 42.0;

/// How far the dilator is open to spread the vessel of level 3 as far as it should, of 1. Measured.
const SPREAD: f64 = 0.22;

/// Angle of the dilator to the axis of the vessel \[rad\], and how far its tips go in \[mm\].
const TILT: f64 = 0.14;
const DEPTH: f64 = 1.0;

/// Where the forceps of level 2 and of level 4 grip the end \[mm\], and the sine of the angle by which their handle is to the left.
const NEAR: ([f64; 3], f64) = ([-0.1, 0.0, 0.0], 0.2);
const ASIDE: ([f64; 3], f64) = ([-0.2, 0.05, 0.0], 0.8);

/// Where a tool is \[mm\], how it is turned, and how far it is open.
#[derive(Clone, Copy)]
struct Key {
    place: [f64; 3],
    /// From tip to handle, and in which the jaws open: across each other, of length 1.
    towards: [f64; 3],
    opens: [f64; 3],
    opening: f64,
}

/// Scissors that cut in an upright plane through the axis at a place, turned from a straight cut by so many degrees, below 0 to the other side.
#[derive(Clone, Copy)]
struct Plane {
    at: f64,
    angle: f64,
}

impl Plane {
    /// The scissors with their tips at `y` beyond the axis.
    fn scissors(self, y: f64, opening: f64) -> Key {
        let angle = self.angle.to_radians();
        Key {
            place: [self.at - y * libm::tan(angle), y, 0.0],
            towards: [libm::sin(angle), -libm::cos(angle), 0.0],
            opens: [0.0, 0.0, 1.0],
            opening,
        }
    }
}

/// Forceps with a jaw above and one below.
fn forceps(place: [f64; 3], left: f64, opening: f64) -> Key {
    Key {
        place,
        towards: [-left, -(1.0 - left * left).sqrt(), 0.0],
        opens: [0.0, 0.0, 1.0],
        opening,
    }
}

/// The dilator with its tips at `x` in line with the lumen, turned about itself by a right angle or not.
fn dilator(x: f64, is_turned: bool, opening: f64) -> Key {
    let (sine, cosine) = (libm::sin(TILT), libm::cos(TILT));
    Key {
        place: [x, (x - DEPTH + 0.5) * sine / cosine, 0.0],
        towards: [-cosine, -sine, 0.0],
        opens: match is_turned {
            false => [0.0, 0.0, 1.0],
            true => [-sine, cosine, 0.0],
        },
        opening,
    }
}

/// The unit quaternion of a tool.
fn orientation(towards: [f64; 3], opens: [f64; 3]) -> [f64; 4] {
    let (x, z) = (opens, towards);
    let y = [
        z[1] * x[2] - z[2] * x[1],
        z[2] * x[0] - z[0] * x[2],
        z[0] * x[1] - z[1] * x[0],
    ];
    let m = |row: usize, column: usize| [x, y, z][column][row];
    // The largest component decides which root is safe.
    let squares = [
        1.0 + m(0, 0) - m(1, 1) - m(2, 2),
        1.0 - m(0, 0) + m(1, 1) - m(2, 2),
        1.0 - m(0, 0) - m(1, 1) + m(2, 2),
        1.0 + m(0, 0) + m(1, 1) + m(2, 2),
    ];
    let largest = (0..4).max_by(|a, b| squares[*a].total_cmp(&squares[*b]));
    let k = largest.expect("four of them");
    let r = 2.0 * squares[k].sqrt();
    let sum = |a, b| (m(a, b) + m(b, a)) / r;
    let difference = |a, b| (m(a, b) - m(b, a)) / r;
    match k {
        0 => [0.25 * r, sum(0, 1), sum(0, 2), difference(2, 1)],
        1 => [sum(0, 1), 0.25 * r, sum(1, 2), difference(0, 2)],
        2 => [sum(0, 2), sum(1, 2), 0.25 * r, difference(1, 0)],
        _ => [
            difference(2, 1),
            difference(0, 2),
            difference(1, 0),
            0.25 * r,
        ],
    }
}

/// The tools of a level, key by key.
struct Play {
    level: u32,
    doc: &'static str,
    time: f64,
    tools: Vec<(&'static str, Key, String)>,
}

impl Play {
    fn new(level: u32, doc: &'static str, tools: &[(&'static str, Key)]) -> Self {
        let tools = tools.iter().map(|(name, key)| (*name, *key, String::new()));
        let mut play = Self {
            level,
            doc,
            time: 0.0,
            tools: tools.collect(),
        };
        play.wait(0.0);
        play
    }

    /// A tool comes to a place in so many seconds, while the others stay.
    fn go(&mut self, tool: &str, seconds: f64, key: Key) {
        let slot = self.tools.iter_mut().find(|(name, ..)| *name == tool);
        slot.expect("a tool of the level").1 = key;
        self.wait(seconds);
    }

    fn wait(&mut self, seconds: f64) {
        self.time += seconds;
        for (_, key, text) in &mut self.tools {
            let [x, y, z] = key.place;
            let [a, b, c, d] = orientation(key.towards, key.opens);
            let _ = write!(
                text,
                "\n[[tool.key]]\nt = \"{:.3} s\"\nposition = [\"{x:.4} mm\", \"{y:.4} mm\", \"{z:.4} mm\"]\norientation = [{a}, {b}, {c}, {d}]\nopening = {}\n",
                self.time, key.opening,
            );
        }
    }

    /// The scissors come around the vessel, close in a plane and go.
    fn cut(&mut self, plane: Plane) {
        self.bite(plane, BEYOND);
    }

    /// The same with the tips at `y`: short of the far side they cut a part of the vessel.
    fn bite(&mut self, plane: Plane, y: f64) {
        self.go("right", 0.6, plane.scissors(-4.5, WIDE));
        self.go("right", 0.7, plane.scissors(y, WIDE));
        self.go("right", 0.8, plane.scissors(y, 0.0));
        self.go("right", 0.5, plane.scissors(-4.5, 0.0));
        self.go("right", 0.4, plane.scissors(AWAY, 0.0));
    }

    /// The forceps come to the end of the vessel, open, and close as far as this.
    fn grip(&mut self, (place, left): ([f64; 3], f64), opening: f64) {
        self.go("left", 0.8, forceps(place, left, OPEN));
        self.go("left", 0.8, forceps(place, left, opening));
    }

    /// The forceps carry off what they have gripped there.
    fn carry_off(&mut self, ([x, y, _], left): ([f64; 3], f64)) {
        let held = self.tools.iter().find(|(name, ..)| *name == "left");
        let opening = held.expect("forceps").1.opening;
        let away = |by: f64| forceps([x - by * (left + 0.4), y - by, 0.5], left, opening);
        self.go("left", 0.8, away(1.6));
        self.go("left", 0.8, away(6.0));
    }

    /// The dilator goes in closed, opens in two directions across each other, and comes out.
    fn spread(&mut self, opening: f64) {
        let inside = DEPTH - 0.5;
        self.go("dilator", 0.6, dilator(-2.0, false, 0.0));
        self.go("dilator", 0.8, dilator(inside, false, 0.0));
        for is_turned in [false, true] {
            self.go("dilator", 0.4, dilator(inside, is_turned, 0.0));
            self.go("dilator", 0.6, dilator(inside, is_turned, opening));
            self.wait(0.3);
            self.go("dilator", 0.4, dilator(inside, is_turned, 0.0));
        }
        self.go("dilator", 0.8, dilator(-3.0, true, 0.0));
    }

    fn write(mut self, name: &str, stay: f64) {
        self.wait(stay);
        let mut text = format!(
            "# {}\n# Written by the example write_diagonal_cut_scripts of this module.\nmodule = \"diagonal-cut\"\nlevel = {}\nrate = \"62.5 Hz\"\ninterpolation = \"minimum-jerk\"\n",
            self.doc, self.level
        );
        for (tool, _, keys) in &self.tools {
            let _ = write!(text, "\n[[tool]]\nname = \"{tool}\"\n{keys}");
        }
        let file = folder().join(format!("level{}-{name}.toml", self.level));
        std::fs::write(file, text).expect("the scripts folder can be written");
    }
}

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scripts")
}

fn plane(at: f64, angle: f64) -> Plane {
    Plane { at, angle }
}

/// Where tools wait: scissors, forceps, dilator.
fn waiting() -> [(&'static str, Key); 3] {
    [
        ("right", plane(CUT, 45.0).scissors(AWAY, 0.0)),
        ("left", forceps([-3.0, -7.0, 0.0], 0.2, OPEN)),
        ("dilator", dilator(-5.0, false, 0.0)),
    ]
}

/// An oblique cut at the mark.
fn level_1() {
    let begin = |doc| Play::new(1, doc, &waiting()[..1]);

    let mut pass = begin("Cuts the end off at the mark.");
    pass.cut(plane(CUT, MATCHING));
    pass.write("pass", 1.5);

    let mut straight = begin("Cuts the end off straight.");
    straight.cut(plane(CUT, 0.0));
    straight.write("fail-wrong-size", 1.5);

    let mut half = begin("Cuts the near half of the vessel alone.");
    half.bite(plane(CUT, MATCHING), -0.0);
    half.write("fail-not-cut", 1.5);

    let mut other = begin("Cuts into the larger vessel first.");
    other.bite(plane(-2.2, 0.0), -0.2);
    other.cut(plane(CUT, MATCHING));
    other.write("fail-other-vessel-cut", 1.5);
}

/// Gripped by its adventitia.
fn level_2() {
    let begin = |doc| Play::new(2, doc, &waiting()[..2]);
    let gripped = |doc, opening| {
        let mut play = begin(doc);
        play.grip(NEAR, opening);
        play
    };
    let end = |mut play: Play, name, angle| {
        play.cut(plane(CUT, angle));
        play.carry_off(NEAR);
        play.write(name, 1.5);
    };

    let pass = gripped("Grips the end by its adventitia and cuts it off.", GRIP);
    end(pass, "pass", MATCHING);

    let mut alone = begin("Cuts the end off with the scissors alone.");
    alone.cut(plane(CUT, MATCHING));
    alone.write("fail-not-steadied", 1.5);

    let hard = gripped("Crushes the end with the forceps.", CRUSH);
    end(hard, "fail-crushed", MATCHING);

    let mut wall = begin("Grips the wall, with one jaw in the lumen.");
    let at = |x: f64, opening| forceps([x, 0.2 * x, 0.48], 0.98, opening);
    wall.go("left", 0.8, at(-2.0, 0.15));
    wall.go("left", 0.6, at(0.1, 0.15));
    wall.go("left", 0.6, at(0.1, 0.035));
    wall.cut(plane(CUT, MATCHING));
    wall.go("left", 0.8, at(-2.5, 0.035));
    wall.write("fail-wall-gripped", 1.5);

    let mut twice = gripped(
        "Cuts the near half first, opens the scissors and cuts the rest.",
        GRIP,
    );
    twice.bite(plane(CUT, MATCHING), -0.1);
    end(twice, "fail-jagged", MATCHING);

    let straight = gripped("Cuts the end off nearly straight.", GRIP);
    end(straight, "fail-wrong-size", 10.0);
}

/// Spread instead of cut.
fn level_3() {
    let begin = |doc| Play::new(3, doc, &waiting());

    let mut pass = begin("Spreads the end in two directions.");
    pass.spread(SPREAD);
    pass.write("pass", 1.5);

    let mut little = begin("Spreads the end too little.");
    little.spread(0.15);
    little.write("fail-not-matched", 1.5);

    let mut cut = begin("Notches the end with the scissors before it spreads it.");
    cut.bite(plane(-0.3, 0.0), -0.4);
    cut.spread(SPREAD);
    cut.write("fail-wrong-choice", 1.5);

    let mut slow = begin("Moves the dilator about before the vessel until the time is over.");
    for turn in 0..21 {
        slow.go("dilator", 3.0, dilator(-2.0, turn % 2 == 0, 0.0));
    }
    slow.write("fail-too-slow", 0.5);
}

/// To the side that the level wants.
fn level_4() {
    let begin = |doc| Play::new(4, doc, &waiting());
    let end = |mut play: Play, name, plane| {
        play.grip(ASIDE, GRIP);
        play.cut(plane);
        play.carry_off(ASIDE);
        play.write(name, 1.5);
    };
    let right = plane(CUT, -STEEPER);

    end(
        begin("Grips the end and cuts it off, away from the trainee."),
        "pass",
        right,
    );
    let side = begin("Cuts so that the opening faces the trainee.");
    end(side, "fail-wrong-side", plane(CUT, STEEPER));
    end(
        begin("Cuts too straight."),
        "fail-wrong-size",
        plane(CUT, -20.0),
    );
    let short = begin("Cuts half a millimetre farther from the end.");
    end(short, "fail-too-short", plane(CUT + 0.5, -STEEPER));

    let mut alone = begin("Cuts the end off with the scissors alone.");
    alone.cut(right);
    alone.write("fail-not-steadied", 1.5);

    let mut spread = begin("Tries to spread the end first.");
    spread.spread(0.33);
    end(spread, "fail-wrong-choice", right);
}

fn main() {
    level_1();
    level_2();
    level_3();
    level_4();
}
