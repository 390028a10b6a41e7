//! Models of instruments, made here from a few sizes: straight and angled jeweller's forceps, micro-scissors, dilator, needle holder, double clamp.
//!
//! They are drawn; what touches tissue are the capsules of `config/tools`. So that both agree, the pivot, the angle of opening and the radius of the tips are those of the
//! tool, and jaws lie about its capsules. Frame: that of the tool, origin at the tip, +z towards the handle, jaws opening along x. Parts: what stands still, and two jaws that turn about the
//! pivot. All shapes are of this project (its licence); sizes beyond those of the tools are judgements of how such instruments look.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use microsim_geometry::Pose;
use microsim_settings::{Jaw, Tool};

use crate::loft::{Section, loft, pin, section};
use crate::mesh::Mesh;
use crate::shape::Model;

/// What an instrument is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// Straight jeweller's forceps.
    Forceps,
    /// The same with tips at 45°.
    AngledForceps,
    /// Micro-scissors with spring handles.
    Scissors,
    /// Vessel dilator.
    Dilator,
    /// Needle holder with curved handles.
    NeedleHolder,
    /// One clip of a double clamp.
    Clamp,
}

/// Sizes that a tool gives its model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sizes {
    /// From the tip to the pivot \[m\].
    pub pivot: f64,
    /// Radius of the tip of a jaw \[m\].
    pub tip: f64,
}

/// Parts of an instrument.
#[derive(Clone, Debug)]
pub struct Instrument {
    /// What stands still.
    pub fixed: Arc<Model>,
    /// The jaw that opens towards +x.
    pub left: Arc<Model>,
    /// The jaw that opens towards −x.
    pub right: Arc<Model>,
}

impl Kind {
    /// That of a tool of `config/tools`, by its name; others are drawn as their capsules.
    pub fn of_tool(name: &str) -> Option<Self> {
        match name {
            "forceps" => Some(Self::Forceps),
            "forceps-angled" => Some(Self::AngledForceps),
            "micro-scissors" => Some(Self::Scissors),
            "dilator" => Some(Self::Dilator),
            "needle-holder" => Some(Self::NeedleHolder),
            "double-clamp" => Some(Self::Clamp),
            _ => None,
        }
    }
}

impl Sizes {
    /// Of a tool with jaws whose pivot lies on its axis; of another one there is no model.
    pub fn of_tool(tool: &Tool) -> Option<Self> {
        let [x, y, pivot] = tool.hinge?;
        let jaws = tool.capsule.iter().filter(|part| part.jaw != Jaw::Fixed);
        let tip = jaws.map(|part| (part.a[2].min(part.b[2]), part.radius));
        let (_, tip) = tip.min_by(|a, b| a.0.total_cmp(&b.0))?;
        (x == 0.0 && y == 0.0 && pivot > 4e-3).then_some(Self { pivot, tip })
    }
}

impl Instrument {
    /// The model of a kind and sizes. Each is made once per process.
    pub fn of(kind: Kind, sizes: Sizes) -> Arc<Self> {
        type Made = BTreeMap<(Kind, u64, u64), Arc<Instrument>>;
        static MADE: Mutex<Made> = Mutex::new(BTreeMap::new());
        let key = (kind, sizes.pivot.to_bits(), sizes.tip.to_bits());
        let mut made = MADE.lock().unwrap_or_else(PoisonError::into_inner);
        made.entry(key)
            .or_insert_with(|| Arc::new(Self::make(kind, sizes)))
            .clone()
    }

    /// The parts with their pose in the frame of the tool, at an opening from 0 to 1 of a tool with this angle between fully open jaws \[rad\].
    pub fn posed(
        &self,
        pivot: f64,
        opening_angle: f64,
        opening: f64,
    ) -> [(&Arc<Model>, [f64; 3], [f64; 4]); 3] {
        let jaw = |model, side: f64| {
            // Half the angle each, about y through the pivot.
            let half = 0.25 * opening_angle * opening * side;
            let turn = [0.0, libm::sin(half), 0.0, libm::cos(half)];
            let pose = Pose::from_arrays([0.0; 3], turn);
            let moved = pose.apply(&nalgebra::Point3::new(0.0, 0.0, -pivot).coords);
            (model, [moved.x, moved.y, moved.z + pivot], turn)
        };
        [
            (&self.fixed, [0.0; 3], [0.0, 0.0, 0.0, 1.0]),
            jaw(&self.left, -1.0),
            jaw(&self.right, 1.0),
        ]
    }

    fn make(kind: Kind, sizes: Sizes) -> Self {
        // All in millimetres from here.
        let (pivot, tip) = (1e3 * sizes.pivot, 1e3 * sizes.tip);
        let mut fixed = Mesh::default();
        let jaw = jaw_of(kind, pivot, tip);
        match kind {
            Kind::Forceps | Kind::AngledForceps => arms(&mut fixed, pivot, [0.9, 2.6], [1.3, 4.0]),
            Kind::Dilator => arms(&mut fixed, pivot, [0.6, 2.2], [1.0, 3.2]),
            Kind::Scissors => {
                pin(&mut fixed, pivot, 0.6, 0.62);
                joint(&mut fixed, pivot, 0.85, 0.34);
                arms(&mut fixed, pivot + 4.0, [0.75, 3.4], [0.7, 3.4]);
            }
            Kind::NeedleHolder => {
                pin(&mut fixed, pivot, 0.9, 1.35);
                joint(&mut fixed, pivot, 1.3, 0.95);
                arms(&mut fixed, pivot + 4.0, [1.0, 4.2], [1.2, 3.2]);
            }
            Kind::Clamp => {
                pin(&mut fixed, pivot, 0.5, 0.9);
                arms(&mut fixed, pivot, [0.5, 1.2], [0.7, 0.9]);
            }
        }
        let side = |mirrored: bool| {
            let mut mesh = Mesh::default();
            let sections: Vec<Section> = jaw
                .iter()
                .map(|section| match mirrored {
                    true => section.mirrored(),
                    false => *section,
                })
                .map(|section| match (kind, mirrored) {
                    // Blades slide past each other.
                    (Kind::Scissors, false) => section.at_y(1e3 * section.half[1]),
                    (Kind::Scissors, true) => section.at_y(-1e3 * section.half[1]),
                    _ => section,
                })
                .collect();
            loft(&mut mesh, &sections);
            if kind == Kind::NeedleHolder || kind == Kind::Clamp {
                teeth(&mut mesh, pivot, if mirrored { -1.0 } else { 1.0 });
            }
            Arc::new(Model::new(mesh))
        };
        Self {
            fixed: Arc::new(Model::new(fixed)),
            left: side(false),
            right: side(true),
        }
    }
}

/// The left jaw, closed: its inner face at x = 0.
fn jaw_of(kind: Kind, pivot: f64, tip: f64) -> Vec<Section> {
    // Middle x, half width, half height, exponent at parts of the length.
    let shape = |rows: &[[f64; 5]]| -> Vec<Section> {
        let row = |&[part, x, width, height, exponent]: &[f64; 5]| {
            section(part * pivot, x, width, height, exponent)
        };
        rows.iter().map(row).collect()
    };
    match kind {
        Kind::Forceps => shape(&[
            [0.000, 0.50 * tip, 0.35 * tip, 0.55 * tip, 2.0],
            [0.006, 0.85 * tip, 0.80 * tip, 0.95 * tip, 2.0],
            [0.030, tip, 0.98 * tip, 1.05 * tip, 2.4],
            [0.280, 1.9 * tip, 1.5 * tip, 2.1 * tip, 3.0],
            [0.450, 3.0 * tip, 2.0 * tip, 4.2 * tip, 3.6],
            [0.750, 5.2 * tip, 2.8 * tip, 7.5 * tip, 4.0],
            [1.010, 0.90, 0.42, 1.30, 4.0],
        ]),
        Kind::AngledForceps => {
            let mut bent = jaw_of(Kind::Forceps, pivot, tip);
            for section in &mut bent {
                // The front 6 mm lean by 45°.
                section.middle[1] = (6e-3 - section.z).max(0.0);
            }
            bent
        }
        Kind::Scissors => shape(&[
            [0.000, 0.3 * tip, 0.3 * tip, 0.3 * tip, 2.0],
            [0.020, 0.6 * tip, 0.7 * tip, 0.8 * tip, 3.0],
            [0.300, 1.6 * tip, 1.9 * tip, 1.2 * tip, 4.0],
            [0.700, 3.0 * tip, 3.4 * tip, 1.8 * tip, 5.0],
            [0.900, 3.4 * tip, 4.6 * tip, 2.4 * tip, 5.0],
            [1.080, 1.0 * tip, 5.6 * tip, 2.6 * tip, 4.0],
        ]),
        Kind::Dilator => shape(&[
            [0.000, 0.55 * tip, 0.35 * tip, 0.45 * tip, 2.0],
            [0.010, 0.85 * tip, 0.80 * tip, 0.85 * tip, 2.0],
            [0.030, tip, tip, tip, 2.0],
            [0.400, 1.05 * tip, 1.05 * tip, 1.1 * tip, 2.0],
            [0.560, 2.0 * tip, 1.8 * tip, 2.2 * tip, 2.2],
            [1.010, 0.60, 0.42, 0.95, 3.0],
        ]),
        Kind::NeedleHolder => shape(&[
            [0.000, 0.8 * tip, 0.5 * tip, 0.7 * tip, 2.2],
            [0.020, 1.2 * tip, 1.1 * tip, 1.2 * tip, 2.4],
            [0.500, 2.2 * tip, 2.1 * tip, 2.6 * tip, 3.0],
            [0.850, 3.2 * tip, 3.2 * tip, 3.8 * tip, 3.4],
            [1.050, 1.5 * tip, 4.0 * tip, 4.0 * tip, 3.0],
        ]),
        Kind::Clamp => shape(&[
            [0.000, 0.9 * tip, 0.7 * tip, 1.6 * tip, 3.0],
            [0.040, 1.0 * tip, tip, 2.4 * tip, 4.0],
            [0.600, 1.1 * tip, tip, 2.6 * tip, 4.0],
            [1.010, 0.40, 0.40, 0.70, 4.0],
        ]),
    }
}

/// Two flat arms from z on, which bow out and meet at the end: half distance and half height at z and at the widest place.
fn arms(mesh: &mut Mesh, z: f64, apart: [f64; 2], height: [f64; 2]) {
    let length = 118.0 - z;
    for side in [1.0, -1.0] {
        let row = |part: f64, x: f64, width: f64, height: f64| {
            section(z + part * length, side * x, width, height, 4.5)
        };
        let sections = [
            row(-0.004, apart[0], 0.40, 0.96 * height[0]),
            row(0.0, apart[0], 0.42, height[0]),
            row(
                0.10,
                0.6 * apart[0] + 0.4 * apart[1],
                0.42,
                0.6 * height[0] + 0.4 * height[1],
            ),
            row(0.30, apart[1], 0.45, height[1]),
            row(0.60, 0.95 * apart[1], 0.50, height[1]),
            row(0.90, 0.70, 0.60, 0.8 * height[1]),
            row(1.0, 0.50, 0.50, 0.7 * height[1]),
        ];
        loft(mesh, &sections);
    }
}

/// The block about a pivot from which handles go on.
fn joint(mesh: &mut Mesh, pivot: f64, width: f64, height: f64) {
    let row = |z: f64, width: f64| section(pivot + z, 0.0, width, height, 4.0);
    let sections = [
        row(-1.4, 0.6 * width),
        row(-0.9, 0.9 * width),
        row(0.6, width),
        row(4.5, 1.25 * width),
        row(5.2, 1.1 * width),
    ];
    loft(mesh, &sections);
}

/// Grooves of the inner face of a jaw, as thin ridges across it.
fn teeth(mesh: &mut Mesh, pivot: f64, side: f64) {
    for tooth in 1..8 {
        let z = 0.06 * f64::from(tooth) * pivot;
        let row = |dz: f64, width: f64| section(z + dz, side * 0.02, width, 0.16, 3.0);
        loft(mesh, &[row(-0.09, 0.01), row(0.0, 0.04), row(0.09, 0.01)]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZES: Sizes = Sizes {
        pivot: 18e-3,
        tip: 0.125e-3,
    };

    /// Closed jaws end within a tenth of a millimetre of the tip and lie on their own side of the plane between them, and opening turns the tips apart by the
    /// chord of the angle: 2 · 18 mm · sin(6°) = 3.76 mm for forceps of 12°.
    #[test]
    fn jaws_turn_about_the_pivot() {
        let forceps = Instrument::of(Kind::Forceps, SIZES);
        let tip_of = |opening: f64, part: usize| {
            let (model, position, turn) =
                forceps.posed(SIZES.pivot, 12_f64.to_radians(), opening)[part];
            let pose = Pose::from_arrays(position, turn);
            let places = model.mesh().vertices.iter();
            let lowest = places
                .map(|v| nalgebra::Vector3::from(v.position.map(f64::from)))
                .min_by(|a, b| a.z.total_cmp(&b.z))
                .unwrap();
            pose.apply(&lowest)
        };
        let (left, right) = (tip_of(0.0, 1), tip_of(0.0, 2));
        assert!(left.z.abs() < 1e-4 && left.x >= 0.0 && right.x <= 0.0);
        let apart = tip_of(1.0, 1).x - left.x - (tip_of(1.0, 2).x - right.x);
        let expected = 2.0 * 18e-3 * 6_f64.to_radians().sin();
        assert!((apart - expected).abs() < 0.02 * expected, "{apart}");
    }

    /// Each kind of shipped tool has a model, the same one when asked again; a rod has none.
    #[test]
    fn models_are_made_once() {
        let one = Instrument::of(Kind::Scissors, SIZES);
        let again = Instrument::of(Kind::Scissors, SIZES);
        assert!(Arc::ptr_eq(&one, &again));
        assert!(one.left.triangle_count() > 100);
        assert_eq!(Kind::of_tool("probe"), None);
        for kind in [
            Kind::AngledForceps,
            Kind::Dilator,
            Kind::NeedleHolder,
            Kind::Clamp,
        ] {
            assert!(Instrument::of(kind, SIZES).fixed.triangle_count() > 100);
        }
    }
}
