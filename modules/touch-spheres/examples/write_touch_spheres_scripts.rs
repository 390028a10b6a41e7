//! Writes the scripted trainees of this module: `cargo run --release -p microsim-module-touch-spheres --example
//! write_touch_spheres_scripts`. Per level one that passes and one for each reason to fail, for seed 1, where the level puts spheres.

use microsim_host::assemble::known_metrics;
use microsim_module_touch_spheres::{Keys, Place, places};
use std::fmt::Write;
use std::path::Path;

/// Seed of `microsim run` where none is given.
const SEED: u64 = 1;
/// Distance along the direction shown from which a sphere is approached and to which the tool retreats \[m\].
const APPROACH: f64 = 0.008;

struct Trainee {
    text: String,
    level: u32,
    time: f64,
}

impl Trainee {
    fn new(doc: &str, level: u32) -> Self {
        let text = format!(
            "# {doc}\n# Written by the example write_touch_spheres_scripts of this module, for seed {SEED}.\nmodule = \"touch-spheres\"\nlevel = {level}\nrate = \"62.5 Hz\"\ninterpolation = \"minimum-jerk\"\n\n[[tool]]\nname = \"right\"\n"
        );
        Self {
            text,
            level,
            time: 0.0,
        }
    }

    /// Is at a distance along `direction` from a centre after `seconds`.
    fn reach(
        &mut self,
        seconds: f64,
        centre: [f64; 3],
        direction: [f64; 3],
        away: f64,
        tilted: [f64; 3],
    ) {
        self.time += seconds;
        let at: Vec<String> = (0..3)
            .map(|i| format!("\"{:.4} mm\"", 1e3 * (centre[i] + away * direction[i])))
            .collect();
        let [x, y, z] = tilted;
        let _ = write!(
            self.text,
            "\n[[tool.key]]\nt = \"{:.3} s\"\nposition = [{}]\ndirection = [{x:.6}, {y:.6}, {z:.6}]\nopening = 0.2\n",
            self.time,
            at.join(", ")
        );
    }

    fn touch(&mut self, place: &Place, tilted: [f64; 3], stay: f64) {
        self.reach(1.5, place.centre, place.direction, APPROACH, tilted);
        self.reach(1.0, place.centre, place.direction, 0.0, tilted);
        self.reach(stay, place.centre, place.direction, 0.0, tilted);
        self.reach(0.7, place.centre, place.direction, APPROACH, tilted);
    }

    fn write(self, folder: &Path, name: &str) {
        let file = folder.join(format!("level{}-{name}.toml", self.level));
        std::fs::write(file, self.text).expect("the scripts folder can be written");
    }
}

/// A direction turned away from `direction` by `angle` \[rad\], towards the vertical plane's side where there is room.
fn turned(direction: [f64; 3], angle: f64) -> [f64; 3] {
    // A horizontal axis at right angles to the direction; for a vertical one, x.
    let [x, y, z] = direction;
    let flat = (x * x + y * y).sqrt();
    let side = if flat > 1e-9 {
        [-y / flat, x / flat, 0.0]
    } else {
        [1.0, 0.0, 0.0]
    };
    let (c, s) = (libm::cos(angle), libm::sin(angle));
    // Turning within the plane of direction and side keeps the angle exact.
    [
        c * x + s * side[0],
        c * y + s * side[1],
        c * z + s * side[2],
    ]
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
        let sphere = loaded
            .settings
            .object
            .iter()
            .find(|o| o.name == "sphere")
            .expect("an object sphere");
        let microsim_settings::Shape::Sphere { radius } = sphere.shape else {
            panic!("not a sphere")
        };
        let count = sphere.count.expect("a count") as usize;
        let places = places(SEED, count, radius, keys.spread, keys.direction_max).expect("room");
        let start = [0.0, 0.0, 0.012];
        let begin = |doc: &str| {
            let mut trainee = Trainee::new(doc, level);
            trainee.reach(0.0, start, [0.0, 0.0, 1.0], 0.0, [0.0, 0.0, 1.0]);
            trainee
        };

        let mut pass =
            begin("Touches every sphere in turn, at the direction shown, for long enough.");
        for place in &places {
            pass.touch(place, place.direction, keys.dwell + 0.3);
        }
        pass.write(&folder, "pass");

        let first = &places[0];
        let mut wrong = begin(
            "Stays in the first sphere for long enough, but 25 degrees beyond the tolerance.",
        );
        wrong.touch(
            first,
            turned(first.direction, keys.angle_tolerance + 25_f64.to_radians()),
            keys.dwell + 0.5,
        );
        wrong.write(&folder, "fail-wrong-angle");

        let mut short =
            begin("Touches the first sphere rightly, and leaves it after a fifth of the time.");
        let (at, from) = (first.centre, first.direction);
        short.reach(1.5, at, from, APPROACH, from);
        short.reach(0.5, at, from, 0.7 * radius, from);
        short.reach(0.2 * keys.dwell, at, from, 0.7 * radius, from);
        short.reach(0.5, at, from, APPROACH, from);
        short.write(&folder, "fail-dwell-too-short");

        let mut slow = begin("Waits above the field until the time is up.");
        slow.reach(125.0, start, [0.0, 0.0, 1.0], 0.0, [0.0, 0.0, 1.0]);
        slow.write(&folder, "fail-too-slow");

        let mut missed = begin("Never touches a sphere.");
        missed.reach(
            3.0,
            [0.0, 0.0, 0.014],
            [0.0, 0.0, 1.0],
            0.0,
            [0.0, 0.0, 1.0],
        );
        missed.write(&folder, "fail-targets-missed");
    }
}
