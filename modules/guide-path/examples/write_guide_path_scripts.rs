//! Writes the scripted trainees of this module: `cargo run --release -p microsim-module-guide-path --example
//! write_guide_path_scripts`. Per level one that passes and one for each reason to fail, for seed 1, which bends the level's wire.

use microsim_host::assemble::known_metrics;
use microsim_module_guide_path::{Keys, Wire, wire_of};
use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};
use std::fmt::Write;
use std::path::Path;

/// Seed of `microsim run` where none is given.
const SEED: u64 = 1;
/// Height of the wire above the tips while it is guided \[m\].
const DEPTH: f64 = 1.2e-3;
/// How far above the wire tools come and go \[m\].
const ABOVE: f64 = 9e-3;
/// Free width between the jaws at `DEPTH` per opening, about \[m\]: 3.7 mm fully open.
const WIDTH: f64 = 3.55e-3;
/// Speed along the wire \[m/s\].
const SPEED: f64 = 1.6e-3;

/// One tool of a script.
struct Hand {
    name: &'static str,
    keys: String,
    time: f64,
}

/// How a wire is guided along.
#[derive(Clone, Copy)]
struct Manner {
    /// Free width between the jaws \[m\].
    gap: f64,
    /// How far the middle between the jaws lies beside the wire \[m\].
    beside: f64,
    /// Whether the tool turns with the wire's direction.
    turns: bool,
}

impl Hand {
    fn new(name: &'static str) -> Self {
        Self {
            name,
            keys: String::new(),
            time: 0.0,
        }
    }

    /// From tip to handle, at rest.
    fn lean(&self) -> Vector3<f64> {
        let side = if self.name == "left" { -0.35 } else { 0.35 };
        Vector3::new(side, -0.25, 0.9).normalize()
    }

    /// Where the tool is when the wire passes between its jaws at a length along it: its y axis is along the wire.
    fn pose(
        &self,
        wire: &Wire,
        length: f64,
        manner: Manner,
    ) -> (Vector3<f64>, UnitQuaternion<f64>) {
        let (place, along) = wire.at(length);
        let y = if manner.turns { along } else { Vector3::x() };
        let z = (self.lean() - y * self.lean().dot(&y)).normalize();
        let x = y.cross(&z);
        let rotation = Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[x, y, z]));
        (
            place - z * DEPTH + x * manner.beside,
            UnitQuaternion::from_rotation_matrix(&rotation),
        )
    }

    fn key(&mut self, seconds: f64, (place, turn): (Vector3<f64>, UnitQuaternion<f64>), gap: f64) {
        self.time += seconds;
        let at: Vec<String> = place
            .iter()
            .map(|c| format!("\"{:.4} mm\"", 1e3 * c))
            .collect();
        let [x, y, z, w] = <[f64; 4]>::from(turn.coords);
        let _ = write!(
            self.keys,
            "\n[[tool.key]]\nt = \"{:.3} s\"\nposition = [{}]\norientation = [{x:.7}, {y:.7}, {z:.7}, {w:.7}]\nopening = {:.3}\n",
            self.time,
            at.join(", "),
            gap / WIDTH
        );
    }

    /// Above a place of the wire.
    fn above(&mut self, seconds: f64, wire: &Wire, length: f64, manner: Manner) {
        let (place, turn) = self.pose(wire, length, manner);
        self.key(
            seconds,
            (place + turn * Vector3::new(0.0, 0.0, ABOVE), turn),
            manner.gap,
        );
    }

    /// Takes the wire between the jaws from above.
    fn take(&mut self, wire: &Wire, length: f64, manner: Manner) {
        self.above(1.0, wire, length, manner);
        let pose = self.pose(wire, length, manner);
        self.key(1.5, pose, manner.gap);
    }

    /// Along the wire, a key for each link.
    fn guide(&mut self, wire: &Wire, from: f64, to: f64, manner: Manner) {
        let steps = ((to - from) / wire.link()).ceil().max(1.0);
        for step in 1..=steps as usize {
            let length = from + (to - from) * step as f64 / steps;
            let pose = self.pose(wire, length, manner);
            self.key((to - from) / steps / SPEED, pose, manner.gap);
        }
    }

    fn stay(&mut self, seconds: f64, wire: &Wire, length: f64, manner: Manner) {
        let pose = self.pose(wire, length, manner);
        self.key(seconds, pose, manner.gap);
    }
}

fn write(folder: &Path, level: u32, name: &str, doc: &str, hands: Vec<Hand>) {
    let mut text = format!(
        "# {doc}\n# Written by the example write_guide_path_scripts of this module, for seed {SEED}.\nmodule = \"guide-path\"\nlevel = {level}\nrate = \"62.5 Hz\"\ninterpolation = \"linear\"\n"
    );
    for hand in hands {
        let _ = write!(text, "\n[[tool]]\nname = \"{}\"\n{}", hand.name, hand.keys);
    }
    let file = folder.join(format!("level{level}-{name}.toml"));
    std::fs::write(file, text).expect("the scripts folder can be written");
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
        let keys: Keys = serde_json::from_value(loaded.document.value()["module"].clone())
            .expect("the module's keys");
        let wire = wire_of(SEED, &loaded.settings.object, &keys).expect("a wire");
        let names: Vec<&str> = loaded
            .settings
            .tool
            .iter()
            .map(|tool| tool.name.as_str())
            .collect();
        let name = |index: usize| match names[index] {
            "left" => "left",
            _ => "right",
        };
        let good = Manner {
            gap: 0.9 * keys.gap,
            beside: 0.0,
            turns: true,
        };
        // The first link and the last are in the posts.
        let (start, end) = (1.2 * wire.link(), wire.length() - 0.8 * wire.link());
        let middle = 0.5 * wire.length();

        // One tool from end to end, or two that meet in the middle.
        let whole = |manner: Manner| {
            let mut first = Hand::new(name(0));
            first.above(0.0, &wire, start, manner);
            first.take(&wire, start, manner);
            if names.len() == 1 {
                first.guide(&wire, start, end, manner);
                first.above(1.0, &wire, end, manner);
                return vec![first];
            }
            let mut second = Hand::new(name(1));
            second.above(0.0, &wire, end, manner);
            first.guide(&wire, start, middle + 0.1e-3, manner);
            // Its jaws are as thick as half a millimetre: it enters a little farther on.
            second.above(first.time - 1.0, &wire, middle + 1.0e-3, manner);
            second.take(&wire, middle + 1.0e-3, manner);
            let both = second.time - first.time + keys.handover + 0.5;
            first.stay(both, &wire, middle + 0.1e-3, manner);
            second.stay(keys.handover + 0.5, &wire, middle + 1.0e-3, manner);
            first.above(1.5, &wire, middle, manner);
            second.stay(1.0, &wire, middle + 1.0e-3, manner);
            second.guide(&wire, middle + 1.0e-3, end, manner);
            second.above(1.0, &wire, end, manner);
            let rest = second.time - first.time;
            first.above(rest, &wire, middle, manner);
            vec![first, second]
        };
        write(
            &folder,
            level,
            "pass",
            "Guides the forceps along the wire, in its middle, turning with it.",
            whole(good),
        );

        let beside = 0.5 * good.gap - wire.capsule(0).radius + 0.05e-3;
        let doc = "Guides to the end with one jaw on the wire.";
        write(
            &folder,
            level,
            "fail-touched",
            doc,
            whole(Manner { beside, ..good }),
        );
        if loaded
            .settings
            .limit
            .iter()
            .any(|limit| limit.metric == "askew")
        {
            let doc = "Guides to the end without turning the forceps with the wire.";
            let stiff = Manner {
                turns: false,
                ..good
            };
            write(&folder, level, "fail-not-turned", doc, whole(stiff));
        }
        write(
            &folder,
            level,
            "fail-jaws-too-wide",
            "Guides to the end with jaws a quarter wider than the level allows.",
            whole(Manner {
                gap: (1.25 * keys.gap).min(WIDTH),
                ..good
            }),
        );

        let mut left = Hand::new(name(0));
        left.above(0.0, &wire, start, good);
        left.take(&wire, start, good);
        left.guide(&wire, start, 0.4 * wire.length(), good);
        left.above(1.0, &wire, 0.4 * wire.length(), good);
        write(
            &folder,
            level,
            "fail-left-the-wire",
            "Guides over less than half of the wire and goes away.",
            vec![left],
        );

        let mut slow = Hand::new(name(0));
        slow.above(0.0, &wire, start, good);
        slow.above(125.0, &wire, start, good);
        write(
            &folder,
            level,
            "fail-too-slow",
            "Waits above the wire until the time is up.",
            vec![slow],
        );

        let mut missed = Hand::new(name(0));
        missed.above(0.0, &wire, start, good);
        missed.above(2.0, &wire, end, good);
        write(
            &folder,
            level,
            "fail-targets-missed",
            "Moves above the wire and never takes it between the jaws.",
            vec![missed],
        );

        if names.len() == 2 {
            let mut alone = Hand::new(name(0));
            alone.above(0.0, &wire, start, good);
            alone.take(&wire, start, good);
            alone.guide(&wire, start, end, good);
            alone.above(1.0, &wire, end, good);
            write(
                &folder,
                level,
                "fail-not-handed-over",
                "Guides from end to end with one hand.",
                vec![alone],
            );
        }
    }
}
