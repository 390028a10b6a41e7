//! Writes the meshes of this module's vessels and its scripted trainees: `cargo run --release -p microsim-module-trim-sharp --example write_trim_sharp_scripts`. Per level one
//! trainee that passes and some that fail, each for one reason.

mod hands;
mod vessel_mesh;

use hands::{Hands, Key, LEFT, RIGHT, Side};
use std::path::{Path, PathBuf};
use vessel_mesh::VesselEnd;

/// How far the forceps are open around a tongue, of 1, and how far closed on it.
const OPEN: f64 = 0.25;
const GRIP: f64 = 0.015;

/// How far they close on a tongue to pull it hard, and to crush it.
const FIRM: f64 = 0.012;
const FIRM_ON_VEIN: f64 = 0.007;
const CRUSH: f64 = 0.002;

/// How far the scissors are open around a tongue, of 1.
const WIDE: f64 = 0.3;

/// The vessels: an artery with one tongue and with two, and a vein.
const ARTERY: VesselEnd = VesselEnd {
    radii: [0.35, 0.5, 0.62],
    sections: &[4.0, 2.8, 1.9, 1.2, 0.7, 0.3, 0.0, -0.3, -0.6],
    covered: 5,
    tongues: &[0],
};
const RAGGED_ARTERY: VesselEnd = VesselEnd {
    tongues: &[1, 6],
    ..ARTERY
};
const VEIN: VesselEnd = VesselEnd {
    radii: [0.255, 0.315, 0.415],
    sections: &[3.0, 2.1, 1.5, 1.0, 0.6, 0.25, 0.0, -0.22, -0.45],
    covered: 5,
    tongues: &[1, 6],
};

/// How a tongue is gripped, drawn and cut. Lengths in mm, from the end of the vessel and from its axis.
#[derive(Clone, Copy)]
struct Bite {
    /// Where around the vessel \[degrees\].
    angle: f64,
    /// Where the scissors' handle is: 1 against the direction around the vessel, -1 along it.
    handle: f64,
    /// Where the tips of the forceps grip: along the vessel, and out from its axis.
    grip: [f64; 2],
    /// How far they close.
    closed: f64,
    /// How far they draw: along and out; and in which time \[s\].
    draw: [f64; 2],
    seconds: f64,
    /// Where the blades cross the middle of the tongue: along and out; how far beyond they reach.
    cut: [f64; 2],
    beyond: f64,
    /// How far the handle of the scissors is raised \[degrees\].
    raised: f64,
    /// In which time the scissors close \[s\].
    snip: f64,
    /// Factor of the times in which the forceps close and what was cut off is carried away.
    pace: f64,
}

/// As the levels on arteries are passed, with something to spare for hands that tremble by about 0.1 mm: the jaws hold firmly what is well between them, more is drawn over the end than
/// has to be bare, and the inner blade passes the edge of the media at a distance. The scissors close quickly, as hands tremble most while they do.
const ON_ARTERY: Bite = Bite {
    angle: 0.0,
    handle: 1.0,
    grip: [-0.08, 0.5],
    closed: GRIP,
    draw: [-0.58, 0.7],
    seconds: 1.5,
    cut: [-0.05, 0.76],
    beyond: 1.0,
    raised: 0.0,
    snip: 0.6,
    pace: 1.6,
};

/// As the vein's tongues are.
const ON_VEIN: Bite = Bite {
    grip: [-0.07, 0.33],
    closed: 0.007,
    pace: 1.0,
    draw: [-0.45, 0.42],
    cut: [-0.06, 0.54],
    beyond: 0.8,
    snip: 0.5,
    ..ON_ARTERY
};

/// The two tongues of the ragged vessels: on the far side, with the handle of the scissors towards the trainee; and below the near side, with it upwards.
const FAR: (f64, f64) = (-36.0, 1.0);
const NEAR: (f64, f64) = (144.0, -1.0);

/// Where the media is nipped by mistake: between all tongues [degrees].
const NIPPED: f64 = 72.0;

impl Bite {
    fn side(self, (angle, handle): (f64, f64)) -> Self {
        Self {
            angle,
            handle,
            ..self
        }
    }

    /// The forceps with their tips at a place along and out from the axis.
    fn forceps(&self, [x, out]: [f64; 2], opening: f64) -> Key {
        let side = Side::at(self.angle);
        Key {
            place: side.place(x, out, 0.0),
            towards: side.direction(-0.85, 0.5, 0.0),
            opens: side.out,
            opening,
        }
    }

    /// The scissors with their tips so far beyond the middle of the tongue.
    fn scissors(&self, beyond: f64, opening: f64) -> Key {
        let side = Side::at(self.angle);
        let [x, out] = self.cut;
        let raised = self.raised.to_radians();
        let (sine, cosine) = (libm::sin(raised), libm::cos(raised));
        Key {
            place: side.place(x, out - beyond * sine, self.handle * beyond * cosine),
            towards: side.direction(0.0, sine, -self.handle * cosine),
            opens: side.direction(0.5, 0.85, 0.0),
            opening,
        }
    }

    /// Both hands before anything happens.
    fn begin(&self, level: u32, doc: &str) -> Hands {
        Hands::new(
            level,
            doc,
            self.forceps([-4.0, 2.5], OPEN),
            self.scissors(-6.0, WIDE),
        )
    }

    /// The forceps come around the tongue and close on it.
    fn grip(&self, hands: &mut Hands) {
        hands.go(LEFT, 0.8, self.forceps([-5.7, 3.5], OPEN));
        hands.go(LEFT, 0.8, self.forceps([-1.4, self.grip[1] + 0.25], OPEN));
        hands.go(LEFT, 0.6, self.forceps(self.grip, OPEN));
        hands.go(LEFT, 0.6 * self.pace, self.forceps(self.grip, self.closed));
    }

    fn drawn(&self) -> Key {
        let [[x, out], [along, up]] = [self.grip, self.draw];
        self.forceps([x + along, out + up], self.closed)
    }

    fn draw(&self, hands: &mut Hands) {
        hands.go(LEFT, self.seconds, self.drawn());
        hands.wait(0.2);
    }

    /// The forceps go back to where they gripped, no faster than they drew, and open.
    fn let_go(&self, hands: &mut Hands) {
        hands.go(
            LEFT,
            self.seconds.max(1.5),
            self.forceps(self.grip, self.closed),
        );
        hands.go(LEFT, 0.5, self.forceps(self.grip, OPEN));
    }

    /// The scissors come around the tongue, close and go.
    fn cut(&self, hands: &mut Hands) {
        hands.go(RIGHT, 0.6, self.scissors(-6.0, WIDE));
        hands.go(RIGHT, 0.8, self.scissors(self.beyond, WIDE));
        hands.go(RIGHT, self.snip, self.scissors(self.beyond, 0.0));
        hands.go(RIGHT, 0.6, self.scissors(-3.0, 0.0));
        hands.go(RIGHT, 0.4, self.scissors(-6.0, 0.0));
    }

    /// The forceps carry off what they hold, and open.
    fn carry_off(&self, hands: &mut Hands) {
        let away = [-4.0, 2.5];
        hands.go(LEFT, 0.8 * self.pace, self.forceps(away, self.closed));
        hands.go(LEFT, 0.3, self.forceps(away, OPEN));
        // Back along the handle, so that what was carried off stays where it is.
        hands.go(LEFT, 0.4, self.forceps([-5.7, 3.5], OPEN));
    }

    /// All of it.
    fn trim(&self, hands: &mut Hands) {
        self.grip(hands);
        self.draw(hands);
        self.cut(hands);
        self.carry_off(hands);
    }

    /// Grips the wall with one jaw in the lumen, and lets go.
    fn grip_wall(&self, hands: &mut Hands, at: [f64; 2], closed: f64) {
        hands.go(LEFT, 0.6, self.forceps([-1.4, at[1] + 0.1], OPEN));
        hands.go(LEFT, 0.6, self.forceps(at, OPEN));
        hands.go(LEFT, 0.6, self.forceps(at, closed));
        hands.go(LEFT, 0.5, self.forceps(at, OPEN));
        hands.go(LEFT, 0.6, self.forceps([-1.4, at[1] + 0.1], OPEN));
    }
}

fn folder(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(name)
}

fn write(hands: Hands, name: &str) {
    hands.write(&folder("scripts"), name, 1.8);
}

fn write_meshes() {
    let meshes = folder("levels").join("meshes");
    for (name, vessel) in [
        ("artery", ARTERY),
        ("ragged-artery", RAGGED_ARTERY),
        ("vein", VEIN),
    ] {
        std::fs::write(meshes.join(format!("{name}.vtk")), vessel.vtk())
            .expect("the folder of meshes can be written");
    }
}

/// The scissors nip the edge of the media on the side away from the tongues, with one blade in the lumen, along the vessel.
fn nip_media(hands: &mut Hands, radius: f64) {
    let side = Side::at(NIPPED);
    let key = |x: f64, opening: f64| Key {
        place: side.place(x, radius, 0.0),
        towards: side.direction(-1.0, 0.0, 0.0),
        opens: side.out,
        opening,
    };
    hands.go(RIGHT, 0.8, key(-3.0, 0.12));
    hands.go(RIGHT, 0.8, key(0.25, 0.12));
    hands.go(RIGHT, 0.6, key(0.25, 0.0));
    hands.go(RIGHT, 0.8, key(-3.0, 0.0));
}

/// What levels have in common: how their tongues are trimmed, and where the wall is gripped by mistake.
struct Plan {
    level: u32,
    bites: Vec<Bite>,
    /// Where the forceps grip the wall by mistake, along the vessel and out from its axis, and how far they close; the middle radius of the media \[mm\].
    wall: [f64; 2],
    closed: f64,
    media: f64,
}

impl Plan {
    fn first(&self) -> &Bite {
        &self.bites[0]
    }

    /// All bites, of which `change` makes others.
    fn played(&self, doc: &str, change: impl Fn(&mut Bite)) -> Hands {
        let mut hands = self.first().begin(self.level, doc);
        for bite in &self.bites {
            let mut bite = *bite;
            change(&mut bite);
            bite.trim(&mut hands);
        }
        hands
    }

    /// What goes wrong first, and then all as it should be.
    fn after(&self, doc: &str, wrong: impl Fn(&Bite, &mut Hands)) -> Hands {
        let mut hands = self.first().begin(self.level, doc);
        wrong(self.first(), &mut hands);
        for bite in &self.bites {
            bite.trim(&mut hands);
        }
        hands
    }

    fn pass(&self) {
        let doc = match self.bites.len() {
            1 => "Grips the tongue, draws it and cuts it off.",
            _ => "Grips, draws and cuts off one tongue after the other.",
        };
        write(self.played(doc, |_| ()), "pass");
    }

    fn too_fast(&self) {
        let doc = "Draws in a third of the time, lets go, and trims as it should be.";
        let hands = self.after(doc, |bite, hands| {
            let fast = Bite {
                seconds: 0.3 * bite.seconds,
                ..*bite
            };
            fast.grip(hands);
            fast.draw(hands);
            fast.let_go(hands);
        });
        write(hands, "fail-too-fast");
    }

    /// Where what is drawn too fast slips out of the forceps before they are too fast: lax it does not.
    fn back_too_fast(&self) {
        let doc = "Draws, lets it back in a third of the time, and trims as it should be.";
        let hands = self.after(doc, |bite, hands| {
            bite.grip(hands);
            bite.draw(hands);
            let fast = 0.3 * bite.seconds;
            hands.go(LEFT, fast, bite.forceps(bite.grip, bite.closed));
            bite.let_go(hands);
        });
        write(hands, "fail-too-fast");
    }

    fn media_gripped(&self) {
        let doc = "Grips the wall with one jaw in the lumen, and then trims as it should be.";
        let hands = self.after(doc, |bite, hands| {
            bite.grip_wall(hands, self.wall, self.closed)
        });
        write(hands, "fail-media-gripped");
    }

    fn media_cut(&self) {
        let doc = "Nips the edge of the media, and then trims as it should be.";
        let hands = self.after(doc, |_, hands| nip_media(hands, self.media));
        write(hands, "fail-media-cut");
    }

    fn pulled_too_hard(&self, far: [f64; 2], closed: f64) {
        let doc = "Draws much too far, goes back, and trims as it should be.";
        let hands = self.after(doc, |bite, hands| {
            let [x, out] = bite.grip;
            let pulled = Bite {
                grip: [x + 0.07, out],
                closed,
                draw: far,
                seconds: 2.5,
                ..*bite
            };
            pulled.grip(hands);
            pulled.draw(hands);
            pulled.let_go(hands);
        });
        write(hands, "fail-pulled-too-hard");
    }

    fn crushed(&self) {
        let doc = "Closes the forceps too far on the tongue, lets go, and trims as it should be.";
        let hands = self.after(doc, |bite, hands| {
            let hard = Bite {
                grip: [bite.grip[0] + 0.1, bite.grip[1]],
                closed: CRUSH,
                ..*bite
            };
            hard.grip(hands);
            hands.wait(0.3);
            hands.go(LEFT, 0.5, hard.forceps(hard.grip, OPEN));
        });
        write(hands, "fail-crushed");
    }

    fn overhang_left(&self) {
        let doc = "Cuts a part of the tongue off, far before the end.";
        let hands = self.played(doc, |bite| {
            bite.cut[0] -= 0.35;
            bite.grip[0] -= 0.25;
        });
        write(hands, "fail-overhang-left");
    }
}

fn main() {
    write_meshes();
    // Bare, but not as far as the next level asks for.
    let barely = Bite {
        grip: [-0.1, 0.5],
        draw: [-0.4, 0.5],
        seconds: 1.2,
        cut: [-0.15, 0.8],
        ..ON_ARTERY
    };
    let artery = |level: u32, bites: Vec<Bite>| Plan {
        level,
        bites,
        wall: [0.2, 0.47],
        closed: 0.036,
        media: 0.42,
    };
    let first = artery(1, vec![barely]);
    first.pass();
    first.media_gripped();
    first.media_cut();
    first.pulled_too_hard([-1.0, 1.2], FIRM);
    first.crushed();
    first.overhang_left();

    let second = artery(2, vec![ON_ARTERY]);
    second.pass();
    second.too_fast();
    second.media_cut();
    second.pulled_too_hard([-1.0, 1.2], FIRM);
    let doc = "Draws it less than half as far before it cuts.";
    let hands = second.played(doc, |bite| {
        bite.draw = [-0.22, 0.28];
        bite.cut = [-0.04, 0.66];
    });
    write(hands, "fail-drawn-too-little");
    let doc = "Cuts with the tips of the scissors towards the vessel.";
    let hands = second.played(doc, |bite| {
        bite.cut = [-0.03, 0.84];
        bite.raised = 28.0;
        bite.beyond = 0.9;
    });
    write(hands, "fail-towards-the-vessel");

    let third = artery(3, vec![ON_ARTERY.side(FAR), ON_ARTERY.side(NEAR)]);
    third.pass();
    third.media_gripped();
    third.crushed();
    let doc = "Trims the tongue on the far side alone.";
    let mut hands = third.first().begin(3, doc);
    third.first().trim(&mut hands);
    write(hands, "fail-overhang-left");
    let doc = "Cuts each tongue in two bites.";
    let mut hands = third.first().begin(3, doc);
    for bite in &third.bites {
        let bite = Bite {
            cut: [0.02, bite.cut[1]],
            ..*bite
        };
        bite.grip(&mut hands);
        bite.draw(&mut hands);
        let half = Bite {
            beyond: 0.03,
            raised: -8.0,
            ..bite
        };
        half.cut(&mut hands);
        bite.cut(&mut hands);
        bite.carry_off(&mut hands);
    }
    write(hands, "fail-too-many-cuts");

    let vein = Plan {
        level: 4,
        bites: vec![ON_VEIN.side(FAR), ON_VEIN.side(NEAR)],
        wall: [0.2, 0.33],
        closed: 0.012,
        media: 0.28,
    };
    vein.pass();
    vein.back_too_fast();
    vein.media_gripped();
    vein.media_cut();
    vein.pulled_too_hard([-0.8, 0.9], FIRM_ON_VEIN);
    vein.crushed();
}
