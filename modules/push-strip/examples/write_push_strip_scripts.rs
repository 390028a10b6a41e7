//! Writes the scripted trainees of this module: `cargo run --release -p microsim-module-push-strip --example
//! write_push_strip_scripts`. Per level one that passes and one for each reason to fail.

use microsim_host::assemble::known_metrics;
use std::fmt::Write;
use std::path::Path;

/// Height above the strip from which a mark is approached \[m\].
const APPROACH: f64 = 0.003;

/// A script: the keys of each tool.
struct Trainee {
    doc: String,
    tools: Vec<(&'static str, String)>,
    time: f64,
}

impl Trainee {
    fn new(doc: &str, tools: &[&'static str]) -> Self {
        Self {
            doc: doc.to_owned(),
            tools: tools.iter().map(|tool| (*tool, String::new())).collect(),
            time: 0.0,
        }
    }

    /// A key of a tool now.
    fn key(&mut self, tool: usize, position: [f64; 3], turn: &str, opening: f64) {
        let [x, y, z] = position.map(|c| 1e3 * c);
        let _ = write!(
            self.tools[tool].1,
            "\n[[tool.key]]\nt = \"{:.3} s\"\nposition = [\"{x:.4} mm\", \"{y:.4} mm\", \"{z:.4} mm\"]\n{turn}\nopening = {opening}\n",
            self.time,
        );
    }

    fn write(self, folder: &Path, level: u32, name: &str) {
        let mut text = format!(
            "# {}\n# Written by the example write_push_strip_scripts of this module.\nmodule = \"push-strip\"\nlevel = {level}\nrate = \"62.5 Hz\"\ninterpolation = \"minimum-jerk\"\n",
            self.doc
        );
        for (tool, keys) in self.tools {
            let _ = write!(text, "\n[[tool]]\nname = \"{tool}\"\n{keys}");
        }
        let file = folder.join(format!("level{level}-{name}.toml"));
        std::fs::write(file, text).expect("the scripts folder can be written");
    }
}

/// Levels in which a probe pushes marks.
mod push {
    use super::{APPROACH, Path, Trainee};

    /// Is at a height above (or, negative, below) a mark after `seconds`.
    fn reach(trainee: &mut Trainee, seconds: f64, mark: [f64; 3], height: f64) {
        trainee.time += seconds;
        let [x, y, z] = mark;
        trainee.key(0, [x, y, z + height], "direction = [0, 0, 1]", 0.0);
    }

    fn push(trainee: &mut Trainee, mark: [f64; 3], depth: f64, stay: f64) {
        reach(trainee, 1.0, mark, APPROACH);
        reach(trainee, 2.0, mark, -depth);
        reach(trainee, stay, mark, -depth);
        reach(trainee, 1.0, mark, APPROACH);
    }

    pub fn write(folder: &Path, level: u32, marks: &[[f64; 3]], depth: f64, dwell: f64) {
        let begin = |doc: &str| {
            let mut trainee = Trainee::new(doc, &["right"]);
            reach(&mut trainee, 0.0, marks[0], 2.0 * APPROACH);
            trainee
        };

        let mut pass = begin("Pushes every mark to its depth and holds it there.");
        for mark in marks {
            push(&mut pass, *mark, depth, dwell + 0.5);
        }
        pass.write(folder, level, "pass");

        let mut shallow = begin("Pushes to half the depth.");
        push(&mut shallow, marks[0], 0.5 * depth, dwell + 0.5);
        shallow.write(folder, level, "fail-not-deep-enough");

        let mut short = begin("Pushes to the depth, but holds it for less than half of the time.");
        push(&mut short, marks[0], depth, 0.1 * dwell);
        short.write(folder, level, "fail-dwell-too-short");

        let mut hard = begin("Pushes twice too deep before it holds the right depth.");
        for mark in marks {
            reach(&mut hard, 1.0, *mark, APPROACH);
            reach(&mut hard, 2.0, *mark, -2.2 * depth);
            reach(&mut hard, 1.5, *mark, -depth);
            reach(&mut hard, dwell + 0.5, *mark, -depth);
            reach(&mut hard, 1.0, *mark, APPROACH);
        }
        hard.write(folder, level, "fail-pushed-too-hard");
    }
}

/// Levels in which two forceps lift the free end into a ring.
mod hold {
    use super::{Path, Trainee};

    /// Handles towards +x, jaws above one another: tool z is +x, tool x is up.
    const TURN: &str = "orientation = [0.7071067811865476, 0, 0.7071067811865476, 0]";

    /// Distance of each forceps from the middle of the strip \[m\].
    const ASIDE: f64 = 0.0012;

    /// Openings: around the strip, on it, and far into it.
    const OPEN: f64 = 0.75;
    const GRIP: f64 = 0.43;
    const CRUSH: f64 = 0.1;

    /// How far the strip sags where it is gripped \[m\] (level 3, measured).
    const SAG: f64 = 0.00105;

    fn reach(trainee: &mut Trainee, seconds: f64, x: f64, z: f64, opening: f64) {
        trainee.time += seconds;
        trainee.key(0, [x, ASIDE, z], TURN, opening);
        trainee.key(1, [x, -ASIDE, z], TURN, opening);
    }

    /// Grips at `x` and goes `out` and up by `height` \[m\].
    fn lift(trainee: &mut Trainee, x: f64, grip: f64, [out, height]: [f64; 2]) {
        reach(trainee, 1.5, x, -SAG, OPEN);
        reach(trainee, 1.0, x, -SAG, grip);
        reach(trainee, 2.0, x + out, height - SAG, GRIP);
    }

    fn put_down(trainee: &mut Trainee, x: f64) {
        reach(trainee, 1.5, x, -SAG, GRIP);
        reach(trainee, 0.5, x, -SAG, OPEN);
        reach(trainee, 1.0, x + 0.005, -SAG, OPEN);
    }

    pub fn write(folder: &Path, level: u32, mark: [f64; 3], ring: [f64; 3], dwell: f64) {
        let x = mark[0] + 0.0004;
        let path = [ring[0] - mark[0], ring[2] - (mark[2] - SAG)];
        let low = [path[0], 0.4 * path[1]];
        let begin = |doc: &str| {
            let mut trainee = Trainee::new(doc, &["left", "right"]);
            reach(&mut trainee, 0.0, x + 0.005, -SAG, OPEN);
            trainee
        };
        let stay = |trainee: &mut Trainee, seconds: f64, [out, height]: [f64; 2]| {
            reach(trainee, seconds, x + out, height - SAG, GRIP);
        };

        let mut pass = begin("Grips the free end with both forceps and holds it in the ring.");
        lift(&mut pass, x, GRIP, path);
        stay(&mut pass, dwell + 0.5, path);
        put_down(&mut pass, x);
        pass.write(folder, level, "pass");

        let mut too_low = begin("Lifts the end to less than half of the height.");
        lift(&mut too_low, x, GRIP, low);
        stay(&mut too_low, dwell + 0.5, low);
        put_down(&mut too_low, x);
        too_low.write(folder, level, "fail-not-in-ring");

        let mut short = begin("Puts the end down again at once.");
        lift(&mut short, x, GRIP, path);
        put_down(&mut short, x);
        short.write(folder, level, "fail-dwell-too-short");

        let mut hard = begin("Crushes the end before it lifts it.");
        lift(&mut hard, x, CRUSH, path);
        stay(&mut hard, dwell + 0.5, path);
        put_down(&mut hard, x);
        hard.write(folder, level, "fail-gripped-too-hard");
    }
}

/// Levels in which forceps hold the free end, scissors cut it off and a tray takes it.
mod cut {
    use super::{Path, Trainee};

    /// Of the forceps: handle towards −x and 10° up, jaws above one another.
    const HOLD: &str = "orientation = [0, -0.6427876096865394, 0, 0.766044443118978]";

    /// Of the scissors: handle towards −y, blades above one another.
    const CUT: &str = "orientation = [0.5, -0.5, 0.5, 0.5]";

    /// Openings of the forceps: around the strip, on it, and far into it.
    const OPEN: f64 = 0.75;
    const GRIP: f64 = 0.13;
    const CRUSH: f64 = 0.045;

    /// How far the strip sags where it is gripped \[m\] (level 4, measured).
    const SAG: f64 = 0.0012;

    /// Where the free end is gripped, and how far the scissors' tips reach beyond the mark \[m\].
    const END: f64 = -0.0031;
    const BEYOND: f64 = 0.00165;

    /// Where the scissors wait, beside the mark \[m\].
    const AWAY: f64 = -0.010;

    struct Hands {
        trainee: Trainee,
        forceps: ([f64; 3], f64),
        scissors: ([f64; 3], f64),
    }

    impl Hands {
        fn new(doc: &str, mark: [f64; 3]) -> Self {
            let mut hands = Self {
                trainee: Trainee::new(doc, &["left", "right"]),
                forceps: ([END - 0.006, 0.0, 0.002], OPEN),
                scissors: ([mark[0], AWAY, 0.0], 0.0),
            };
            hands.key(0.0);
            hands
        }

        /// Both are where they are to be after `seconds`.
        fn key(&mut self, seconds: f64) {
            self.trainee.time += seconds;
            let (place, opening) = self.forceps;
            self.trainee.key(0, place, HOLD, opening);
            let (place, opening) = self.scissors;
            self.trainee.key(1, place, CUT, opening);
        }

        /// Grips the end and holds it straight.
        fn grip(&mut self, grip: f64) {
            self.forceps.0 = [END, 0.0, -SAG];
            self.key(1.5);
            self.forceps.1 = grip;
            self.key(1.0);
            self.forceps = ([END - 0.0002, 0.0, 0.0], GRIP);
            self.key(1.0);
        }

        /// Leads the open scissors around the strip at `x`, closes them, and takes them away.
        fn cut(&mut self, x: f64, closed: f64) {
            self.scissors = ([x, AWAY, 0.0], 0.8);
            self.key(0.5);
            self.scissors.0[1] = BEYOND;
            self.key(1.0);
            self.scissors.1 = closed;
            self.key(1.5);
            self.forceps.0[0] -= 0.0005;
            self.key(0.5);
            self.scissors.0[1] = AWAY;
            self.key(1.0);
        }

        /// Carries what it holds by `path` and releases it there.
        fn put(&mut self, [out, height]: [f64; 2]) {
            self.forceps.0[2] += 0.001;
            self.key(0.5);
            self.forceps.0[0] += out;
            self.key(1.5);
            self.forceps.0[2] = height;
            self.key(1.5);
            self.forceps.1 = 0.5;
            self.key(0.5);
            self.forceps.0[0] -= 0.003;
            self.forceps.0[2] += 0.001;
            self.key(1.0);
        }

        fn write(mut self, folder: &Path, level: u32, name: &str, stay: f64) {
            self.key(stay);
            self.trainee.write(folder, level, name);
        }
    }

    pub fn write(folder: &Path, level: u32, mark: [f64; 3], tray: [f64; 3], dwell: f64) {
        // From the middle of the piece to that of the tray; the tips of the forceps end above its walls.
        let path = [tray[0] - 0.5 * (mark[0] - 0.004), tray[2] + 0.00175];
        let stay = dwell + 0.5;

        let mut pass = Hands::new(
            "Holds the free end, cuts at the mark and puts the piece into the tray.",
            mark,
        );
        pass.grip(GRIP);
        pass.cut(mark[0], 0.0);
        pass.put(path);
        pass.write(folder, level, "pass", stay);

        let mut uncut = Hands::new(
            "Leads the scissors around the strip, but hardly closes them.",
            mark,
        );
        uncut.grip(GRIP);
        uncut.cut(mark[0], 0.8);
        uncut.write(folder, level, "fail-not-cut", stay);

        let mut beside = Hands::new("Cuts 1.5 mm beside the mark.", mark);
        beside.grip(GRIP);
        beside.cut(mark[0] - 0.0015, 0.0);
        beside.put(path);
        beside.write(folder, level, "fail-cut-beside-the-mark", stay);

        let mut dropped = Hands::new("Lets the piece go beside the tray.", mark);
        dropped.grip(GRIP);
        dropped.cut(mark[0], 0.0);
        dropped.put([0.0, -0.001]);
        dropped.write(folder, level, "fail-not-in-tray", stay);

        let mut hard = Hands::new("Crushes the end before it lifts it.", mark);
        hard.grip(CRUSH);
        hard.cut(mark[0], 0.0);
        hard.put(path);
        hard.write(folder, level, "fail-gripped-too-hard", stay);
    }
}

fn main() {
    let module = Path::new(env!("CARGO_MANIFEST_DIR"));
    let manifest =
        microsim_settings::load_manifest(&module.join("module.toml")).expect("a good manifest");
    let folder = module.join("scripts");
    for level in 1.. {
        let path = module.join("levels").join(format!("level{level}.toml"));
        if !path.is_file() {
            break;
        }
        let loaded = microsim_settings::load_level(&path, &manifest.settings, &known_metrics())
            .expect("a good level");
        let key = |name: &str| loaded.settings.module[name].as_f64().expect("a quantity");
        let objects = &loaded.settings.object;
        let marks: Vec<[f64; 3]> = objects
            .iter()
            .filter(|object| object.name.starts_with("mark-"))
            .map(|object| object.position)
            .collect();
        let ring = objects.iter().find(|object| object.name == "ring");
        let tray = loaded.settings.rigid.iter().find(|r| r.name == "tray");
        let dwell = key("dwell");
        match (ring, tray) {
            (Some(ring), _) => hold::write(&folder, level, marks[0], ring.position, dwell),
            (None, Some(tray)) => cut::write(&folder, level, marks[0], tray.position, dwell),
            (None, None) => push::write(&folder, level, &marks, key("depth"), dwell),
        }
    }
}
