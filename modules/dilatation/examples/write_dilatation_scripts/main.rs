//! Writes the meshes of this module's vessels and its scripted trainees: `cargo run --release -p microsim-module-dilatation --example write_dilatation_scripts`.

mod frame;
mod hands;
mod vessel_mesh;

use frame::{Frame, Local};
use hands::{ACROSS_THE_SLIT, ALONG_THE_SLIT, FORCEPS, Hands, Held};
use std::path::Path;
use vessel_mesh::VesselEnd;

/// How far before the opening the dilator waits \[mm\].
const BEFORE: f64 = 3.0;

/// From the dilator's axis to the outer side of a jaw: closed, and what a full opening adds (config/tools/dilator.toml) \[mm\].
const HALF_WIDTH: f64 = 0.25;
const HALF_SPREAD: f64 = 1.3;

/// From the middle of the tuft to the tips of the forceps that grip it, so that their jaws lie along all of it and below its top, tremor or not \[mm\].
const BEYOND: Local = [0.35, -0.15, 0.0];

/// How far away the forceps wait: so many times [`FORCEPS`] \[mm\].
const AWAY: f64 = 3.0;

/// Openings of the forceps: around the tuft, on it, and far into it.
const OPEN: f64 = 0.35;
const GRIP: f64 = 0.09;
const CRUSH: f64 = 0.0;

/// Opening around the whole vessel.
const WIDE: f64 = 0.62;

/// How far the dilator is pushed on where it meets the wall \[mm\].
const STUMBLE: f64 = 1.4;

/// How much higher it enters where it catches the upper wall \[mm\].
const TOO_HIGH: f64 = 0.14;

/// A level: its vessel, how it lies, its tools' slots (the dilator's first), and what the passing script does.
struct Level {
    number: u32,
    mesh: &'static str,
    vessel: VesselEnd,
    frame: Frame,
    slots: [&'static str; 2],
    forceps: bool,
    /// How deep the dilator goes \[mm\], and how it is spread: angle and opening, one after the other.
    depth: f64,
    spreads: &'static [(f64, f64)],
    /// How far the forceps lift the tuft, and where the opening is then: upwards and across \[mm\].
    lift: f64,
    aim: [f64; 2],
    /// What others do: spreads that are too small, and whether the opening stays wide enough and is only not round; a factor of openings that are too large; in one direction alone; where the rim is, upwards and across \[mm\],
    /// where pushing on it meets the wall.
    little: &'static [(f64, f64)],
    little_is_wide: bool,
    far: f64,
    across: f64,
    rim: Option<[f64; 2]>,
    /// How far the forceps close on the wall, and whether it tears when it is spread too far, before too much of it is stretched.
    narrow: f64,
    tears: bool,
}

/// How a script differs from the one that passes.
#[derive(Clone, Copy)]
struct Variant<'a> {
    spreads: &'a [(f64, f64)],
    /// Where it aims beside the axis: upwards and across \[mm\].
    aside: [f64; 2],
    depth: f64,
    /// Where it spreads, once it has been in \[mm\].
    spread_depth: f64,
    /// Whether the forceps close completely on the tuft before they let it go.
    crushes: bool,
    /// Whether the forceps hold, from before the dilator enters.
    holds: bool,
    /// Multiplies all times.
    pace: f64,
    /// Whether the dilator is taken out in the end.
    withdraws: bool,
    /// Beside the axis, where it is pushed against the wall before anything holds it: upwards and across \[mm\].
    stumbles: Option<[f64; 2]>,
    /// Whether the forceps grip the wall at its end before they grip the tuft.
    pinches: bool,
}

impl Level {
    fn pass(&self) -> Variant<'_> {
        Variant {
            spreads: self.spreads,
            aside: self.aim,
            depth: self.depth,
            spread_depth: self.depth,
            holds: true,
            crushes: false,
            pace: 1.0,
            withdraws: true,
            stumbles: None,
            pinches: false,
        }
    }

    /// How high the forceps hold the tuft while the dilator is open: they follow the wall that is spread upwards \[mm\].
    fn height(&self, angle: f64, opening: f64) -> f64 {
        let wall = self.aim[0] + HALF_WIDTH + HALF_SPREAD * opening - self.vessel.half_height();
        match angle == ACROSS_THE_SLIT {
            true => self.lift.max(wall),
            false => self.lift,
        }
    }

    /// Plays a variant and writes it.
    fn write(&self, folder: &Path, name: &str, doc: &str, of: Variant<'_>) {
        let tuft = self.vessel.tuft_place();
        let grip = [0, 1, 2].map(|k| tuft[k] + BEYOND[k]);
        // Along their own axis.
        let away = [0, 1, 2].map(|k| grip[k] + AWAY * FORCEPS[k]);
        let before = [BEFORE, of.aside[0], of.aside[1]];
        let start = Held {
            place: before,
            opening: 0.0,
        };
        let forceps = Held {
            place: away,
            opening: OPEN,
        };
        let mut hands = Hands::new(&self.frame, doc, start, self.forceps.then_some(forceps));
        let step = |hands: &mut Hands<'_>, seconds: f64| hands.key(of.pace * seconds);
        let put = |hands: &mut Hands<'_>, seconds: f64, place, opening| {
            if let Some(forceps) = &mut hands.forceps {
                *forceps = Held { place, opening };
                hands.key(of.pace * seconds);
            }
        };
        if of.pinches {
            // Over the end, one jaw on either side of the vessel.
            let wall = [-0.3, -0.1, 0.0];
            let above = [wall[0], tuft[1] + 1.2, 0.0];
            for (place, opening) in [
                (above, WIDE),
                (wall, WIDE),
                (wall, self.narrow),
                (wall, WIDE),
                (above, WIDE),
                (away, OPEN),
            ] {
                put(&mut hands, 0.8, place, opening);
            }
        }
        if let Some([up, side]) = of.stumbles {
            for out in [BEFORE, -STUMBLE, BEFORE] {
                hands.dilator.place = [out, up, side];
                step(&mut hands, 1.0);
            }
            hands.dilator.place = before;
            step(&mut hands, 0.8);
        }
        if of.holds {
            put(&mut hands, 1.0, grip, OPEN);
            put(&mut hands, 0.6, grip, GRIP);
            let up = [grip[0], grip[1] + self.lift, grip[2]];
            put(&mut hands, 0.5, up, GRIP);
        }
        hands.dilator.place = [-of.depth, of.aside[0], of.aside[1]];
        step(&mut hands, 1.5);
        if of.spread_depth != of.depth {
            hands.dilator.place[0] = -of.spread_depth;
            step(&mut hands, 0.6);
        }
        for (angle, opening) in of.spreads {
            if hands.turn != *angle {
                hands.turn = *angle;
                step(&mut hands, 0.8);
            }
            for (seconds, opening) in [(1.2, *opening), (0.3, *opening), (0.8, 0.0)] {
                hands.dilator.opening = opening;
                if let (Some(forceps), true) = (&mut hands.forceps, of.holds) {
                    forceps.place[1] = grip[1] + self.height(*angle, opening);
                }
                step(&mut hands, seconds);
            }
        }
        if of.withdraws {
            hands.dilator.place = before;
            step(&mut hands, 1.2);
        }
        if of.holds {
            put(&mut hands, 0.4, grip, GRIP);
            if of.crushes {
                put(&mut hands, 0.6, grip, CRUSH);
            }
            put(&mut hands, 0.5, grip, OPEN);
        }
        put(&mut hands, 1.0, away, OPEN);
        hands.key(1.5);
        hands.write(folder, self.number, self.slots, name);
    }
}

fn levels() -> Vec<Level> {
    let (azimuth, elevation) = (50_f64.to_radians(), 15_f64.to_radians());
    let artery = VesselEnd {
        radius: 0.5,
        wall: 0.1,
        flat: 0.4,
        length: 4.0,
        flat_length: 1.6,
        adventitia: 0.08,
        tuft: 0.9,
        around: 12,
        along: 8,
        through: 1,
    };
    let vein = VesselEnd {
        radius: 0.6,
        wall: 0.06,
        flat: 0.25,
        ..artery
    };
    let right = Frame::new(azimuth, elevation, false);
    vec![
        Level {
            number: 1,
            mesh: "artery-wide",
            vessel: VesselEnd {
                radius: 0.55,
                flat: 0.6,
                ..artery
            },
            frame: right,
            slots: ["right", "left"],
            forceps: false,
            depth: 1.5,
            spreads: &[(ACROSS_THE_SLIT, 0.55)],
            lift: 0.0,
            aim: [0.0; 2],
            little: &[(ACROSS_THE_SLIT, 0.25)],
            little_is_wide: false,
            far: 1.5,
            across: 0.0,
            rim: Some([0.0, 0.7]),
            narrow: 0.24,
            tears: false,
        },
        Level {
            number: 2,
            mesh: "artery",
            vessel: artery,
            frame: right,
            slots: ["right", "left"],
            forceps: true,
            depth: 1.5,
            spreads: &[(ACROSS_THE_SLIT, 0.5), (ALONG_THE_SLIT, 0.5)],
            lift: 0.2,
            aim: [0.0; 2],
            little: &[(ACROSS_THE_SLIT, 0.3), (ALONG_THE_SLIT, 0.42)],
            little_is_wide: false,
            far: 1.35,
            across: 0.57,
            rim: Some([0.0, 0.7]),
            narrow: 0.24,
            tears: false,
        },
        Level {
            number: 3,
            mesh: "vein",
            vessel: vein,
            frame: right,
            slots: ["right", "left"],
            forceps: true,
            depth: 1.5,
            spreads: &[(ACROSS_THE_SLIT, 0.53), (ALONG_THE_SLIT, 0.65)],
            lift: 0.3,
            aim: [0.06, 0.0],
            little: &[(ALONG_THE_SLIT, 0.65), (ACROSS_THE_SLIT, 0.4)],
            little_is_wide: true,
            far: 1.08,
            across: 0.55,
            rim: None,
            narrow: 0.16,
            tears: false,
        },
        Level {
            number: 4,
            mesh: "small-artery",
            vessel: VesselEnd {
                radius: 0.4,
                wall: 0.08,
                flat: 0.35,
                adventitia: 0.07,
                tuft: 0.85,
                ..artery
            },
            frame: right,
            slots: ["right", "left"],
            forceps: true,
            depth: 1.3,
            spreads: &[(ACROSS_THE_SLIT, 0.34), (ALONG_THE_SLIT, 0.34)],
            lift: 0.25,
            aim: [0.05, 0.0],
            little: &[(ALONG_THE_SLIT, 0.25), (ACROSS_THE_SLIT, 0.18)],
            little_is_wide: false,
            far: 1.4,
            across: 0.42,
            rim: Some([0.0, 0.58]),
            narrow: 0.2,
            tears: true,
        },
        Level {
            number: 5,
            mesh: "vein-left",
            vessel: vein,
            frame: Frame::new(azimuth, elevation, true),
            slots: ["left", "right"],
            forceps: true,
            depth: 1.5,
            spreads: &[(ACROSS_THE_SLIT, 0.53), (ALONG_THE_SLIT, 0.65)],
            lift: 0.3,
            aim: [0.06, 0.0],
            little: &[(ALONG_THE_SLIT, 0.65), (ACROSS_THE_SLIT, 0.4)],
            little_is_wide: true,
            far: 1.08,
            across: 0.55,
            rim: None,
            narrow: 0.16,
            tears: false,
        },
    ]
}

/// Openings of some spreads, times a factor.
fn scaled(spreads: &[(f64, f64)], factor: f64) -> Vec<(f64, f64)> {
    let times = |(angle, opening): &(f64, f64)| (*angle, factor * opening);
    spreads.iter().map(times).collect()
}

fn main() {
    let module = Path::new(env!("CARGO_MANIFEST_DIR"));
    let scripts = module.join("scripts");
    for level in levels() {
        let mesh = module
            .join("levels/meshes")
            .join(format!("{}.vtk", level.mesh));
        let text = level.vessel.vtk(&level.frame);
        std::fs::write(mesh, text).expect("the folder of meshes can be written");
        let pass = level.pass();
        let write = |name: &str, doc: &str, of: Variant<'_>| level.write(&scripts, name, doc, of);
        write("pass", "Holds, enters closed, spreads and withdraws.", pass);
        let name = if level.little_is_wide {
            "fail-not-round"
        } else {
            "fail-not-wide-enough"
        };
        write(
            name,
            "Spreads too little.",
            Variant {
                spreads: level.little,
                ..pass
            },
        );
        let far = scaled(level.spreads, level.far);
        let name = if level.tears {
            "fail-torn"
        } else {
            "fail-overstretched"
        };
        write(
            name,
            "Spreads too far.",
            Variant {
                spreads: &far,
                ..pass
            },
        );
        let name = "fail-wall-caught";
        let stumbles = level.rim;
        let (doc, aside) = match stumbles {
            Some(_) => (
                "Meets the wall beside the opening and pushes on, before it enters.",
                pass.aside,
            ),
            None => (
                "Enters too high and catches the upper wall.",
                [pass.aside[0] + TOO_HIGH, pass.aside[1]],
            ),
        };
        write(
            name,
            doc,
            Variant {
                stumbles,
                aside,
                ..pass
            },
        );
        if level.number == 1 {
            let name = "fail-not-entered";
            let aside = [0.0, -2.4];
            write(
                name,
                "Opens the dilator beside the vessel.",
                Variant { aside, ..pass },
            );
            let name = "fail-too-slow";
            write(
                name,
                "Takes sixteen times as long.",
                Variant { pace: 16.0, ..pass },
            );
            let name = "fail-not-withdrawn";
            write(
                name,
                "Leaves the dilator where it is.",
                Variant {
                    withdraws: false,
                    ..pass
                },
            );
            continue;
        }
        let across = [(ACROSS_THE_SLIT, level.across)];
        let name = "fail-one-direction";
        write(
            name,
            "Spreads in one direction alone.",
            Variant {
                spreads: &across,
                ..pass
            },
        );
        let name = "fail-not-held";
        write(
            name,
            "Enters without holding the vessel.",
            Variant {
                holds: false,
                ..pass
            },
        );
        let name = "fail-media-gripped";
        write(
            name,
            "Grips the wall before the adventitia.",
            Variant {
                pinches: true,
                ..pass
            },
        );
        let name = "fail-crushed";
        write(
            name,
            "Closes the forceps completely on the adventitia.",
            Variant {
                crushes: true,
                ..pass
            },
        );
    }
}
