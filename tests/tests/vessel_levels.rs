//! The physics behind the scores of levels with vessels, against what holds outside of it: an ellipse, a volume, a balance of forces.

use microsim_bus::{Block, Frames};
use microsim_host::assemble::Input;
use microsim_host::engine::Engine;
use microsim_message::{
    ContactForce, ContactForces, TISSUE_ELEMENTS, TISSUE_SNAPSHOT, TrainingResult, decode,
};
use microsim_sdk::tissue::{Opening, VesselAxis, VesselWall};
use microsim_tests::in_process::{engine, plan, tick};
use microsim_tests::{scratch, tree};
use std::f64::consts::PI;

/// The blocks of a body after a tick.
struct Body {
    snapshot: Block,
    elements: Block,
}

impl Body {
    fn of(engine: &Engine, name: &str) -> Option<Self> {
        let blocks = engine.blocks();
        let of = |kind: &str| {
            let [kind, name] = [kind, name].map(microsim_bus::kind_id);
            let mut found = blocks.iter().filter(|block| {
                let view = block.view();
                view.kind() == kind && view.name() == name
            });
            found.next().cloned()
        };
        Some(Self {
            snapshot: of(TISSUE_SNAPSHOT)?,
            elements: of(TISSUE_ELEMENTS)?,
        })
    }

    /// What the surface of a region encloses at rest and now [m³]: a sixth of the determinants of its triangles.
    fn volume(&self, region: u32) -> [f64; 2] {
        let (snapshot, elements) = (self.snapshot.view(), self.elements.view());
        let triangles = snapshot.u32s("triangle").expect("triangles");
        let regions = elements.u32s("triangle_region").expect("regions");
        let places = [
            elements.f64s("rest").expect("places"),
            snapshot.f64s("position").expect("places"),
        ];
        places.map(|places| {
            let place = |row: u32| [0, 1, 2].map(|k| places[3 * row as usize + k]);
            let of_region = triangles.chunks(3).zip(regions);
            let parts = of_region.filter(|(_, of)| **of == region).map(|(rows, _)| {
                let [a, b, c] = [rows[0], rows[1], rows[2]].map(place);
                let cross = [
                    b[1] * c[2] - b[2] * c[1],
                    b[2] * c[0] - b[0] * c[2],
                    b[0] * c[1] - b[1] * c[0],
                ];
                (a[0] * cross[0] + a[1] * cross[1] + a[2] * cross[2]) / 6.0
            });
            parts.sum()
        })
    }
}

/// Plays the script that passes a level to its end; `look` sees the engine and the forces of tools on the tissue after every tick.
fn play(module: &str, level: u32, mut look: impl FnMut(&Engine, &[ContactForce])) {
    let folder = scratch();
    let script = tree().join(format!("modules/{module}/scripts/level{level}-pass.toml"));
    let session = folder.path().join("none.session");
    let plan = plan(module, level, Input::Script(script), session);
    let mut engine = engine(&plan);
    let ticks = 120_000_000_000 / plan.tick_ns;
    for _ in 0..ticks {
        let output = tick(&mut engine);
        let mut contacts = Vec::new();
        let mut result = None;
        for frame in Frames::new(&output.log) {
            let frame = frame.expect("a frame");
            if let Some(forces) = decode::<ContactForces>(&frame) {
                contacts = forces.expect("forces").contacts;
            }
            if let Some(found) = decode::<TrainingResult>(&frame) {
                result = Some(found.expect("a result"));
            }
        }
        look(&engine, &contacts);
        if let Some(result) = result {
            assert!(result.passed, "{:?}", result.failed);
            return;
        }
    }
    panic!("no result");
}

/// Blunt trimming, level 1. Plastic flow has no volume, so that only elastic pressure is left: volume strain is pressure over bulk modulus K = E/(3 (1 - 2ν)). When the tools are gone, what
/// acts on the adventitia is the shear of the media, τ at most, over its free length l at the radius r, and the clamp. The mean pressure of a body in equilibrium is a third of the virial
/// of its surface forces over its volume, with lengths from the clamp: τ 2π r l²/2 of A l, or p = τ π r l/(3 A) at most.
#[test]
fn adventitia_that_was_pushed_back_has_its_volume() {
    const SHEAR_STRENGTH: f64 = 100.0;
    const RADII: [f64; 2] = [0.5e-3, 0.65e-3];
    const FREE: f64 = 5.2e-3;
    const BULK: f64 = 5e3 / (3.0 * (1.0 - 2.0 * 0.45));
    let [inside, outside] = RADII;
    let section = PI * (outside * outside - inside * inside);
    let pressure = SHEAR_STRENGTH * PI * inside * FREE / (3.0 * section);
    let mut last = [0.0; 2];
    play("trim-blunt", 1, |engine, _| {
        last = Body::of(engine, "vessel").map_or(last, |body| body.volume(1));
    });
    let [rest, now] = last;
    let change = now / rest - 1.0;
    println!("{:+.4} of {:.4}", change, pressure / BULK);
    // The section is a polygon of ten corners or more, less than 7 % smaller than the ring.
    let ring = section * (FREE + 0.8e-3);
    assert!(rest > 0.93 * ring && rest < ring, "{rest} of {ring}");
    assert!(change.abs() <= pressure / BULK, "{change}");
}

/// Dilatation, level 1. What its jaws do to the wall cancels in the force on the vessel as a whole, which is what the clamp bears; the forces of the parts show it. Trials had 2.9 mN of a dilator
/// whose jaws, as bars of their own, had 54 mN each.
#[test]
fn jaws_that_spread_a_vessel_press_against_each_other() {
    let mut strongest = ContactForce::default();
    let pressed = |of: &ContactForce| of.parts.iter().map(|part| part.normal_force).sum::<f64>();
    play("dilatation", 1, |_, contacts| {
        for contact in contacts {
            if pressed(contact) > pressed(&strongest) {
                strongest = contact.clone();
            }
        }
    });
    let jaw = |side: &str| {
        let parts = strongest
            .parts
            .iter()
            .filter(|part| part.part.starts_with(side));
        parts.fold([0.0; 3], |sum, of| [0, 1, 2].map(|k| sum[k] + of.force[k]))
    };
    let (left, right) = (jaw("left-"), jaw("right-"));
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let size = |a: [f64; 3]| dot(a, a).sqrt();
    println!(
        "left {:.2} mN, right {:.2} mN, together {:.2} mN",
        1e3 * size(left),
        1e3 * size(right),
        1e3 * size(strongest.force)
    );
    // Rounding of a sum of dozens of nodes.
    let rest = [0, 1, 2].map(|k| left[k] + right[k] - strongest.force[k]);
    assert!(size(rest) <= 1e-12 * size(left), "{rest:?}");
    assert!(dot(left, right) < -0.9 * size(left) * size(right));
    // Without parts each would be half of what is known.
    let least = size(left).min(size(right));
    assert!(size(strongest.force) < 0.5 * least, "{strongest:?}");
}

/// Diagonal cut, level 1: what the blades have left, at rest, against the ellipse in which a plane at the angle of the opening cuts a tube, times what a polygon of ten corners has of a
/// circle. The edge is not quite plane: what lies u off it is u tan α off along the long axis of the section in it, α the angle. The perimeter is the integral of the support function over
/// all directions; with the cosine of these to the long axis its error is √2 π u tan α at most for a root mean square u, if the points that bear it are off as all are (Cauchy and Schwarz). That
/// of the area is the same times the mean radius.
#[test]
fn an_oblique_opening_is_an_ellipse() {
    const RADIUS: f64 = 0.4e-3;
    const SIDES: f64 = 10.0;
    let mut found = None;
    let axis = VesselAxis::new([3.5e-3, 0.0, 0.0], [-1.0, 0.0, 0.0]).expect("a direction");
    play("diagonal-cut", 1, |engine, _| {
        let body = Body::of(engine, "smaller");
        let opening = body.and_then(|body| {
            let (snapshot, elements) = (body.snapshot.view(), body.elements.view());
            Opening::of(&VesselWall::of(&snapshot, &elements, axis)?)
        });
        found = opening.or(found);
    });
    let found = found.expect("an opening").at_rest;
    let angle = found.angle_to(axis.direction());
    let slope = libm::tan(angle);
    let polygon = SIDES / PI * libm::sin(PI / SIDES);
    let circumference = polygon * ellipse(RADIUS, RADIUS / libm::cos(angle));
    let straight = 0.5 * SIDES * RADIUS * RADIUS * libm::sin(2.0 * PI / SIDES);
    let area = straight / libm::cos(angle);
    println!(
        "{:.1} degrees: {:+.2} % of the circumference, {:+.2} % of the area",
        angle.to_degrees(),
        100.0 * (found.girth / circumference - 1.0),
        100.0 * (found.area / area - 1.0)
    );
    let off = 2f64.sqrt() * PI * found.unevenness * slope;
    assert!((found.girth - circumference).abs() <= off, "{found:?}");
    let mean_radius = (area / PI).sqrt();
    assert!((found.area - area).abs() <= off * mean_radius, "{found:?}");
    // What was asked for is far from straight, or nothing would be shown.
    assert!(circumference > 1.1 * 2.0 * PI * RADIUS * polygon, "{angle}");
}

/// Circumference of an ellipse with these half axes, by the arithmetic-geometric mean: 2π/M (a² − Σ 2ⁿ⁻¹ cₙ²).
fn ellipse(a: f64, b: f64) -> f64 {
    let (long, short) = (a.max(b), a.min(b));
    let (mut a, mut b) = (long, short);
    let mut sum = 0.5 * (a * a - b * b);
    let mut weight = 1.0;
    for _ in 0..6 {
        let c = 0.5 * (a - b);
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
        sum += weight * c * c;
        weight *= 2.0;
    }
    2.0 * PI * (long * long - sum) / a
}
