//! Two hands at a vessel's end: the left one with forceps, the right one with scissors. Lengths in mm; the vessel lies along x, with its free end at 0.

use std::fmt::Write;
use std::path::Path;

/// Where a tool is \[mm\], how it is turned, and how far it is open.
#[derive(Clone, Copy)]
pub struct Key {
    pub place: [f64; 3],
    /// From tip to handle, and in which the jaws open: made across each other and of length 1.
    pub towards: [f64; 3],
    pub opens: [f64; 3],
    pub opening: f64,
}

/// A direction across the vessel, upwards at 0 and towards the trainee at a right angle, and the one around the vessel there.
#[derive(Clone, Copy)]
pub struct Side {
    pub out: [f64; 3],
    pub around: [f64; 3],
}

impl Side {
    /// At an angle \[degrees\].
    pub fn at(angle: f64) -> Self {
        let (sine, cosine) = (libm::sin(angle.to_radians()), libm::cos(angle.to_radians()));
        Self {
            out: [0.0, -sine, cosine],
            around: [0.0, cosine, sine],
        }
    }

    /// The place at `x` along the vessel, `out` from its axis and `around` it.
    pub fn place(&self, x: f64, out: f64, around: f64) -> [f64; 3] {
        sum(
            [x, 0.0, 0.0],
            sum(times(out, self.out), times(around, self.around)),
        )
    }

    /// The direction of which these are the parts.
    pub fn direction(&self, x: f64, out: f64, around: f64) -> [f64; 3] {
        self.place(x, out, around)
    }
}

pub fn sum(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|k| a[k] + b[k])
}

pub fn times(factor: f64, a: [f64; 3]) -> [f64; 3] {
    a.map(|c| factor * c)
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn unit(a: [f64; 3]) -> [f64; 3] {
    times(1.0 / dot(a, a).sqrt(), a)
}

/// The unit quaternion of a tool.
fn orientation(towards: [f64; 3], opens: [f64; 3]) -> [f64; 4] {
    let z = unit(towards);
    let x = unit(sum(opens, times(-dot(opens, z), z)));
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
    let plus = |a, b| (m(a, b) + m(b, a)) / r;
    let minus = |a, b| (m(a, b) - m(b, a)) / r;
    match k {
        0 => [0.25 * r, plus(0, 1), plus(0, 2), minus(2, 1)],
        1 => [plus(0, 1), 0.25 * r, plus(1, 2), minus(0, 2)],
        2 => [plus(0, 2), plus(1, 2), 0.25 * r, minus(1, 0)],
        _ => [minus(2, 1), minus(0, 2), minus(1, 0), 0.25 * r],
    }
}

/// What both hands do, key by key.
pub struct Hands {
    level: u32,
    doc: String,
    time: f64,
    /// Forceps, then scissors.
    tools: [(&'static str, Key, String); 2],
}

pub const LEFT: usize = 0;
pub const RIGHT: usize = 1;

impl Hands {
    /// From where both wait.
    pub fn new(level: u32, doc: &str, forceps: Key, scissors: Key) -> Self {
        let mut hands = Self {
            level,
            doc: doc.to_owned(),
            time: 0.0,
            tools: [
                ("left", forceps, String::new()),
                ("right", scissors, String::new()),
            ],
        };
        hands.write_key(LEFT);
        hands.write_key(RIGHT);
        hands
    }

    /// A tool comes to a place in so many seconds, while the other stays.
    pub fn go(&mut self, tool: usize, seconds: f64, key: Key) {
        self.write_key(tool);
        self.time += seconds;
        self.tools[tool].1 = key;
        self.write_key(tool);
    }

    pub fn wait(&mut self, seconds: f64) {
        self.time += seconds;
    }

    fn write_key(&mut self, tool: usize) {
        let time = self.time;
        let (_, key, text) = &mut self.tools[tool];
        let [x, y, z] = key.place;
        let [a, b, c, d] = orientation(key.towards, key.opens);
        let begin = format!("\n[[tool.key]]\nt = \"{time:.3} s\"\n");
        // It stands there already.
        if text.contains(&begin) {
            return;
        }
        let _ = write!(
            text,
            "{begin}position = [\"{x:.4} mm\", \"{y:.4} mm\", \"{z:.4} mm\"]\norientation = [{a:.9}, {b:.9}, {c:.9}, {d:.9}]\nopening = {:.4}\n",
            key.opening,
        );
    }

    /// Both wait for so many seconds, and the script is written.
    pub fn write(mut self, folder: &Path, name: &str, stay: f64) {
        self.wait(stay);
        self.write_key(LEFT);
        self.write_key(RIGHT);
        let mut text = format!(
            "# {}\n# Written by the example write_trim_sharp_scripts of this module.\nmodule = \"trim-sharp\"\nlevel = {}\nrate = \"62.5 Hz\"\ninterpolation = \"minimum-jerk\"\n",
            self.doc, self.level
        );
        for (tool, _, keys) in &self.tools {
            let _ = write!(text, "\n[[tool]]\nname = \"{tool}\"\n{keys}");
        }
        let file = folder.join(format!("level{}-{name}.toml", self.level));
        std::fs::write(file, text).expect("the scripts folder can be written");
    }
}
