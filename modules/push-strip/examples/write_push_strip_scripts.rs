//! Writes the scripted trainees of this module: `cargo run --release -p microsim-module-push-strip --example
//! write_push_strip_scripts`. Per level one that passes and one for each reason to fail.

use microsim_host::assemble::known_metrics;
use std::fmt::Write;
use std::path::Path;

/// Height above the strip from which a mark is approached \[m\].
const APPROACH: f64 = 0.003;

struct Trainee {
    text: String,
    time: f64,
}

impl Trainee {
    fn new(doc: &str) -> Self {
        let text = format!(
            "# {doc}\n# Written by the example write_push_strip_scripts of this module.\nrate = \"62.5 Hz\"\ninterpolation = \"minimum-jerk\"\n\n[[tool]]\nname = \"right\"\n"
        );
        Self { text, time: 0.0 }
    }

    /// Is at a height above (or, negative, below) a mark after `seconds`.
    fn reach(&mut self, seconds: f64, mark: [f64; 3], height: f64) {
        self.time += seconds;
        let [x, y, z] = mark.map(|c| 1e3 * c);
        let _ = write!(
            self.text,
            "\n[[tool.key]]\nt = \"{:.3} s\"\nposition = [\"{x:.4} mm\", \"{y:.4} mm\", \"{:.4} mm\"]\ndirection = [0, 0, 1]\nopening = 0\n",
            self.time,
            z + 1e3 * height
        );
    }

    fn push(&mut self, mark: [f64; 3], depth: f64, stay: f64) {
        self.reach(1.0, mark, APPROACH);
        self.reach(2.0, mark, -depth);
        self.reach(stay, mark, -depth);
        self.reach(1.0, mark, APPROACH);
    }

    fn write(self, folder: &Path, name: &str) {
        std::fs::write(folder.join(name), self.text).expect("the scripts folder can be written");
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
        let (depth, dwell) = (key("depth"), key("dwell"));
        let marks: Vec<[f64; 3]> = loaded
            .settings
            .object
            .iter()
            .filter(|o| o.name.starts_with("mark-"))
            .map(|o| o.position)
            .collect();
        let begin = |doc: &str| {
            let mut trainee = Trainee::new(doc);
            trainee.reach(0.0, marks[0], 2.0 * APPROACH);
            trainee
        };

        let mut pass = begin("Pushes every mark to its depth and holds it there.");
        for mark in &marks {
            pass.push(*mark, depth, dwell + 0.5);
        }
        pass.write(&folder, &format!("level{level}-pass.toml"));

        let mut shallow = begin("Pushes to half the depth.");
        shallow.push(marks[0], 0.5 * depth, dwell + 0.5);
        shallow.write(&folder, &format!("level{level}-fail-not-deep-enough.toml"));

        let mut short = begin("Pushes to the depth, but holds it for less than half of the time.");
        short.push(marks[0], depth, 0.1 * dwell);
        short.write(&folder, &format!("level{level}-fail-dwell-too-short.toml"));

        let mut hard = begin("Pushes twice too deep before it holds the right depth.");
        for mark in &marks {
            hard.reach(1.0, *mark, APPROACH);
            hard.reach(2.0, *mark, -2.2 * depth);
            hard.reach(1.5, *mark, -depth);
            hard.reach(dwell + 0.5, *mark, -depth);
            hard.reach(1.0, *mark, APPROACH);
        }
        hard.write(&folder, &format!("level{level}-fail-pushed-too-hard.toml"));
    }
}
