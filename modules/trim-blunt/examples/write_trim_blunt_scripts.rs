//! Writes the scripted trainees of this module: `cargo run --release -p microsim-module-trim-blunt --example
//! write_trim_blunt_scripts`. Per level one that passes and those that fail, each for one reason.

use microsim_host::assemble::known_metrics;
use microsim_settings::Level;
use std::fmt::Write;
use std::path::Path;

/// How wide the jaws are open \[1\] per gap between them at the tips \[m\]: `config/tools/forceps.toml`, 2 × 17.9 mm × sin 6°.
const OPENING_PER_GAP: f64 = 1.0 / 3.74e-3;

/// Jaws that push: so far apart that they touch the media, whose section is a polygon, at its corners.
const ON_MEDIA: f64 = 0.95;

/// Jaws that push the end of the media with them: of an artery, and of a vein, whose thin wall yields.
const PINCHED: [f64; 2] = [0.75, 0.68];

/// Jaws that hold the vessel by all of its wall: of an artery, and of a vein.
const CRUSHED: [f64; 2] = [0.27, 0.23];

/// Thinner than that is the wall of a vein \[m\].
const VEIN: f64 = 0.1e-3;

/// Jaws that have let go.
const WIDE: f64 = 0.6;

/// How far beyond the end pushing begins \[m\].
const BEFORE: f64 = 0.7e-3;

/// How a forceps stands to the vessel, which lies along x with its free end at +x.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Stand {
    /// Handle upwards, one jaw on each side.
    Above,
    /// Handle towards the trainee, one jaw above and one below.
    Aside,
}

impl Stand {
    fn orientation(self) -> &'static str {
        match self {
            Self::Above => "[0, 0, 0.7071067811865476, 0.7071067811865476]",
            Self::Aside => "[0.5, -0.5, 0.5, 0.5]",
        }
    }

    /// The place at `x` along the vessel, `beyond` the axis as seen from the handle; negative values are on its side \[m\].
    fn place(self, x: f64, beyond: f64) -> [f64; 3] {
        match self {
            Self::Above => [x, 0.0, -beyond],
            Self::Aside => [x, beyond, 0.0],
        }
    }
}

/// The vessel of a level \[m\].
#[derive(Clone, Copy)]
struct Vessel {
    /// x of its free end.
    end: f64,
    /// Thickness of the media.
    wall: f64,
    /// Outer radius of the media.
    media: f64,
    /// Of the adventitia.
    outer: f64,
}

impl Vessel {
    fn of(level: &Level) -> Self {
        let body = &level.body[0];
        let inner = body.inner_radius.expect("a tube");
        let layers: Vec<f64> = body.layer.iter().map(|of| of.thickness).collect();
        let [media, adventitia] = layers[..] else {
            panic!("a vessel of two layers");
        };
        Self {
            end: 0.5 * body.length.expect("a tube"),
            wall: media,
            media: inner + media,
            outer: inner + media + adventitia,
        }
    }

    /// That of the two which is for this vessel.
    fn choose(&self, [artery, vein]: [f64; 2]) -> f64 {
        match self.wall < VEIN {
            true => vein,
            false => artery,
        }
    }

    /// Opening of jaws whose gap is this part of the media's diameter.
    fn opening(&self, part: f64) -> f64 {
        part * 2.0 * self.media * OPENING_PER_GAP
    }
}

/// A script: the keys of each tool.
struct Trainee {
    doc: String,
    vessel: Vessel,
    tools: Vec<(String, String)>,
    time: f64,
}

impl Trainee {
    fn new(doc: &str, level: &Level) -> Self {
        let vessel = Vessel::of(level);
        let tools = level.tool.iter();
        let mut trainee = Self {
            doc: doc.to_owned(),
            vessel,
            tools: tools
                .map(|tool| (tool.name.clone(), String::new()))
                .collect(),
            time: 0.0,
        };
        for tool in 0..trainee.tools.len() {
            trainee.away(tool, 0.0);
        }
        trainee
    }

    /// The tool that works from above, or from the side.
    fn tool(&self, stand: Stand) -> usize {
        match (stand, self.tools.len()) {
            (Stand::Above, 2) => 1,
            _ => 0,
        }
    }

    /// A key of a tool after `seconds`.
    fn key(
        &mut self,
        tool: usize,
        seconds: f64,
        stand: Stand,
        [x, beyond]: [f64; 2],
        opening: f64,
    ) {
        self.time += seconds;
        let [x, y, z] = stand.place(x, beyond).map(|c| 1e3 * c);
        let _ = write!(
            self.tools[tool].1,
            "\n[[tool.key]]\nt = \"{:.3} s\"\nposition = [\"{x:.4} mm\", \"{y:.4} mm\", \"{z:.4} mm\"]\norientation = {}\nopening = {opening:.4}\n",
            self.time,
            stand.orientation(),
        );
    }

    /// Where nothing is touched: of two forceps the first one beside the vessel, the other above.
    fn away(&mut self, tool: usize, seconds: f64) {
        let stand = match (tool, self.tools.len()) {
            (0, 2) => Stand::Aside,
            _ => Stand::Above,
        };
        let place = [self.vessel.end + 2.0 * BEFORE, -6e-3];
        self.key(tool, seconds, stand, place, WIDE);
    }

    /// Takes the vessel's end between jaws with a gap of `part` of the media, and pushes them back to `depth` behind the end with `speed` \[m/s\].
    fn stroke(&mut self, stand: Stand, part: f64, depth: f64, speed: f64) {
        let tool = self.tool(stand);
        let Vessel { end, outer, .. } = self.vessel;
        let (across, opening) = (outer + 0.25e-3, self.vessel.opening(part));
        let (before, back) = (end + BEFORE, end - depth);
        self.key(tool, 1.0, stand, [before, -4e-3], opening);
        self.key(tool, 0.8, stand, [before, across], opening);
        let seconds = (before - back) / speed;
        self.key(tool, seconds, stand, [back, across], opening);
    }

    /// As [`Trainee::stroke`], and lets go.
    fn push(&mut self, stand: Stand, part: f64, depth: f64, speed: f64) {
        self.stroke(stand, part, depth, speed);
        let tool = self.tool(stand);
        let Vessel { end, outer, .. } = self.vessel;
        let (across, back) = (outer + 0.25e-3, end - depth);
        self.key(tool, 0.5, stand, [back, across], WIDE);
        self.key(tool, 0.8, stand, [back, -4e-3], WIDE);
    }

    /// Grips the vessel by all of its wall behind the end, with a gap of `part` of the media, for `seconds`, and lets go.
    fn grip(&mut self, part: f64, seconds: f64) {
        let (tool, stand) = (self.tool(Stand::Above), Stand::Above);
        let Vessel { end, outer, .. } = self.vessel;
        let (across, opening) = (outer + 0.25e-3, self.vessel.opening(part));
        let at = end - 0.5e-3;
        self.key(tool, 1.0, stand, [at, -4e-3], WIDE);
        self.key(tool, 0.8, stand, [at, across], WIDE);
        self.key(tool, 0.6, stand, [at, across], opening);
        self.key(tool, seconds, stand, [at, across], opening);
        self.key(tool, 0.5, stand, [at, across], WIDE);
        self.key(tool, 0.8, stand, [at, -4e-3], WIDE);
    }

    /// Stays away for a while.
    fn wait(&mut self, seconds: f64) {
        for tool in 0..self.tools.len() {
            self.away(tool, 1.0);
            self.away(tool, seconds);
        }
    }

    fn write(self, folder: &Path, level: u32, name: &str) {
        let mut text = format!(
            "# {}\n# Written by the example write_trim_blunt_scripts of this module.\nmodule = \"trim-blunt\"\nlevel = {level}\nrate = \"62.5 Hz\"\ninterpolation = \"minimum-jerk\"\n",
            self.doc
        );
        for (tool, keys) in self.tools {
            let _ = write!(text, "\n[[tool]]\nname = \"{tool}\"\n{keys}");
        }
        let file = folder.join(format!("level{level}-{name}.toml"));
        std::fs::write(file, text).expect("the scripts folder can be written");
    }
}

/// How the passing script of a level pushes: from where, how far behind the end \[m\], in this order.
struct Plan {
    strokes: Vec<(Stand, f64)>,
    /// What is to be bare \[m\].
    length: f64,
    /// \[m/s\]
    speed: f64,
}

impl Plan {
    fn of(level: &Level) -> Self {
        use Stand::{Above, Aside};
        let length = level.module["free_length"].as_f64().expect("a length");
        let even = level.module["evenness"].as_f64().is_some_and(|of| of > 0.0);
        let strokes = match (even, level.tool.len()) {
            (false, _) => vec![(Above, 2.7 * length)],
            (true, 1) => vec![(Above, 1.7 * length), (Aside, 1.7 * length)],
            // In turn, in small steps.
            (true, _) => vec![
                (Above, 0.9 * length),
                (Aside, 0.9 * length),
                (Above, 1.7 * length),
                (Aside, 1.7 * length),
            ],
        };
        Self {
            strokes,
            length,
            speed: 1.2e-3,
        }
    }

    /// All strokes, each so much of its depth, with jaws whose gap is `part` of the media.
    fn play(&self, trainee: &mut Trainee, part: f64, of_depth: f64) {
        for (stand, depth) in &self.strokes {
            trainee.push(*stand, part, of_depth * depth, self.speed);
        }
    }

    /// All strokes, without letting go at the end of the last one.
    fn play_and_stay(&self, trainee: &mut Trainee) {
        let [before @ .., (stand, depth)] = &self.strokes[..] else {
            return;
        };
        for (stand, depth) in before {
            trainee.push(*stand, ON_MEDIA, *depth, self.speed);
        }
        trainee.stroke(*stand, ON_MEDIA, *depth, self.speed);
    }
}

fn write_level(folder: &Path, number: u32, level: &Level) {
    let plan = Plan::of(level);
    let wait = level.module["stay"].as_f64().expect("a time") + 1.0;
    let begin = |doc: &str| Trainee::new(doc, level);

    let mut pass = begin("Pushes the adventitia back past the mark and lets go.");
    plan.play(&mut pass, ON_MEDIA, 1.0);
    pass.wait(wait);
    pass.write(folder, number, "pass");

    let mut little = begin("Pushes half as far.");
    plan.play(&mut little, ON_MEDIA, 0.45);
    little.wait(wait);
    little.write(folder, number, "fail-not-bare");

    let mut gripped = begin("Grips the end by all of its wall, and then pushes.");
    gripped.grip(gripped.vessel.choose(CRUSHED), 0.5);
    // What was crushed has to be pushed all round.
    for stand in [Stand::Aside, Stand::Above, Stand::Aside, Stand::Above] {
        gripped.push(stand, ON_MEDIA, 1.9 * plan.length, plan.speed);
    }
    gripped.wait(wait);
    gripped.write(folder, number, "fail-media-gripped");

    let mut hard = begin(
        "Pushes the end of the media as well, with jaws that are too close, and then as it should.",
    );
    hard.push(
        Stand::Above,
        hard.vessel.choose(PINCHED),
        plan.length,
        plan.speed,
    );
    plan.play(&mut hard, ON_MEDIA, 1.0);
    plan.play(&mut hard, ON_MEDIA, 1.0);
    hard.wait(wait);
    hard.write(folder, number, "fail-pushed-too-hard");

    let mut held = begin("Pushes it back and stays there.");
    plan.play_and_stay(&mut held);
    held.write(folder, number, "fail-not-left");

    if plan.strokes.len() > 1 {
        let mut sides = begin("Pushes it back on two sides alone.");
        let (stand, depth) = plan.strokes[plan.strokes.len() - 2];
        sides.push(stand, ON_MEDIA, 1.25 * depth, plan.speed);
        sides.wait(wait);
        sides.write(folder, number, "fail-uneven");
    } else {
        let limit = level.limit.iter().find(|limit| limit.metric == "time");
        let limit = limit.and_then(|limit| limit.max).expect("a limit");
        let mut late = begin("Begins when the time is over.");
        late.wait(limit + 1.0);
        late.write(folder, number, "fail-too-slow");
    }
}

fn main() {
    let module = Path::new(env!("CARGO_MANIFEST_DIR"));
    let manifest =
        microsim_settings::load_manifest(&module.join("module.toml")).expect("a good manifest");
    let folder = module.join("scripts");
    for number in 1.. {
        let path = module.join("levels").join(format!("level{number}.toml"));
        if !path.is_file() {
            break;
        }
        let loaded = microsim_settings::load_level(&path, &manifest.settings, &known_metrics())
            .expect("a good level");
        write_level(&folder, number, &loaded.settings);
    }
}
