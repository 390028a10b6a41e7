//! Recovery of a beam from shapes that no load makes: what a body does after a fault of a tool, a tracker or a plan.
//!
//! The beam is S of the reference (`cantilever.md`): 0.1 × 0.02 × 0.02 m, 810 tetrahedra, E = 10⁵ Pa, ν = 0.3, 1000 kg/m³, under
//! gravity. It has recovered when every node is within 3 % of the length of its resting place and no element is inverted, for
//! good, within 1.2 simulated seconds. The solver is called directly: no containment, no position is ever set back. Drag and
//! viscosity are part of each run, since an undamped beam swings for ever.

use super::subject::{Constants, Substance};
use microsim_mesh::{Block, CellSplit, TetMesh, signed_volume};
use microsim_tissue::{
    Control, Method, Newton, Serial, State, TissueModel, build_model, stability,
};
use nalgebra::Vector3;

/// Length of the beam \[m\].
const LENGTH: f64 = 0.1;
/// Height and width \[m\].
const HEIGHT: f64 = 0.02;
/// Cells.
const CELLS: [usize; 3] = [15, 3, 3];
/// Gravity \[m/s²\].
const GRAVITY: f64 = 9.81;
/// Largest distance from the resting place, as a fraction of the length.
const NEAR: f64 = 0.03;
/// Simulated time \[s\].
pub const SIMULATED: f64 = 1.2;
/// How often a run is looked at \[s\].
const LOOK: f64 = 5e-3;
/// CPU time after which a run is cut off \[s\].
const CPU_LIMIT: f64 = 12.0;

/// What has happened to the beam.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Damage {
    /// One node of the tip moved upwards by twice the length.
    Tip,
    /// All free nodes put to the middle of the height.
    Flat,
    /// All free nodes mirrored about the middle of the height.
    Mirror,
    /// The clamp jumps sideways by the length.
    Jump,
    /// The clamp turns by 90° about the vertical at once.
    Turn,
}

impl Damage {
    /// All kinds.
    pub const ALL: [Self; 5] = [Self::Tip, Self::Flat, Self::Mirror, Self::Jump, Self::Turn];

    /// Its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Tip => "tip moved",
            Self::Flat => "flattened",
            Self::Mirror => "mirrored",
            Self::Jump => "clamp jumps",
            Self::Turn => "clamp turns",
        }
    }

    /// Where the clamp puts a point of the rest shape afterwards \[m\].
    fn clamp(self, rest: &Vector3<f64>) -> Vector3<f64> {
        match self {
            Self::Jump => rest + Vector3::y() * LENGTH,
            Self::Turn => Vector3::new(-rest.y, rest.x, rest.z),
            _ => *rest,
        }
    }

    /// Where the free nodes start \[m\].
    fn apply(self, model: &TissueModel, positions: &mut [Vector3<f64>]) {
        let free = |node: &usize| !model.is_clamped(*node);
        match self {
            Self::Tip => {
                // The corner of the free end with the largest index.
                positions[model.node_count() - 1].z += 2.0 * LENGTH;
            }
            Self::Flat => {
                for node in (0..positions.len()).filter(free) {
                    positions[node].z = 0.5 * HEIGHT;
                }
            }
            Self::Mirror => {
                for node in (0..positions.len()).filter(free) {
                    positions[node].z = HEIGHT - positions[node].z;
                }
            }
            Self::Jump | Self::Turn => {}
        }
    }
}

/// How long a step is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StepLength {
    /// A fraction of the limit, as in [`stability::stable_step`].
    LimitFraction(f64),
    /// Seconds.
    Seconds(f64),
}

/// Method, material, viscosity and step with which the beam is computed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scheme {
    /// The method.
    pub method: Method,
    /// What the beam is made of.
    pub substance: Substance,
    /// How long a step is.
    pub step: StepLength,
    /// Drag per mass \[1/s\].
    pub drag: f64,
    /// Time of Kelvin–Voigt damping \[s\].
    pub relaxation_time: f64,
}

/// How a run ended.
#[derive(Clone, Debug, PartialEq)]
pub enum Outcome {
    /// Recovered at this simulated time \[s\].
    Recovered(f64),
    /// It came to the end of the time elsewhere.
    Elsewhere {
        /// Distance of the farthest node from its resting place, as a fraction of the length.
        distance: f64,
        /// Number of inverted elements.
        inverted: usize,
        /// Whether it has come to rest there: no node is faster than a length per 10 s.
        still: bool,
    },
    /// The solver gave up at this simulated time \[s\].
    Failed {
        /// Simulated time \[s\].
        time: f64,
        /// Why.
        reason: String,
    },
    /// It was cut off at this simulated time \[s\]: too much CPU time.
    TooSlow(f64),
    /// The method cannot treat the material, or the body has no resting place.
    NotApplicable(String),
}

/// One run.
#[derive(Clone, Debug, PartialEq)]
pub struct Recovery {
    /// What had happened.
    pub damage: Damage,
    /// How it was computed.
    pub scheme: Scheme,
    /// Length of a step \[s\].
    pub step: f64,
    /// How it ended.
    pub outcome: Outcome,
    /// CPU time of the whole simulated time \[s\], of which there may be less than planned where it failed.
    pub cpu: f64,
}

impl Outcome {
    /// Whether it recovered.
    pub fn is_recovered(&self) -> bool {
        matches!(self, Self::Recovered(_))
    }
}

/// A beam computed with one scheme.
struct Beam {
    model: TissueModel,
    gravity: Vector3<f64>,
}

impl Beam {
    fn new(scheme: &Scheme) -> Result<Self, String> {
        let constants = Constants {
            relaxation_time: scheme.relaxation_time,
            ..Constants::default()
        };
        let mesh = mesh();
        let clamped: Vec<bool> = mesh.positions.iter().map(|p| p.x < 1e-3 * LENGTH).collect();
        let material = scheme.substance.material(&constants);
        let model = build_model(&mesh, &[(0, material)], &clamped, scheme.drag, Vec::new())
            .map_err(|error| error.to_string())?;
        Ok(Self {
            model,
            gravity: Vector3::new(0.0, 0.0, -GRAVITY),
        })
    }

    /// The load, with the clamps where `damage` leaves them.
    fn control(&self, damage: Damage) -> Control {
        let rest = self.model.rest_positions();
        let clamped = self.model.clamped().iter();
        Control {
            gravity: self.gravity,
            clamped_positions: clamped
                .map(|&node| damage.clamp(&rest[node as usize]))
                .collect(),
            ..Control::default()
        }
    }

    /// Static equilibrium under gravity, sought from the undeformed shape \[m\].
    fn resting_place(&self, damage: Damage) -> Result<Vec<Vector3<f64>>, String> {
        let mut state = State::at_rest(&self.model);
        for position in &mut state.positions {
            *position = damage.clamp(position);
        }
        let newton = Newton {
            iterations: 100,
            tolerance: 1e-9,
            must_converge: true,
        };
        let mut solver = Method::QuasiStatic(newton)
            .solver(&self.model)
            .map_err(|error| error.to_string())?;
        solver
            .step(
                &self.model,
                &mut state,
                &self.control(damage),
                &[],
                1.0,
                &Serial,
            )
            .map_err(|failure| format!("no resting place: {failure}"))?;
        Ok(state.positions)
    }

    /// Largest distance from `places` as a fraction of the length, and the number of inverted elements.
    fn distance(&self, state: &State, places: &[Vector3<f64>]) -> (f64, usize) {
        let nodes = state.positions.iter().zip(places);
        let distance = nodes.map(|(p, q)| (p - q).norm()).fold(0.0, f64::max);
        let inverted = self.model.tets().iter().filter(|tet| {
            let [a, b, c, d] = tet.map(|node| &state.positions[node as usize]);
            signed_volume(a, b, c, d) <= 0.0
        });
        (distance / LENGTH, inverted.count())
    }
}

/// The mesh S: nodes from the origin, the height along z.
fn mesh() -> TetMesh {
    let size = [LENGTH, HEIGHT, HEIGHT];
    let block = Block {
        center: size.map(|s| 0.5 * s),
        size,
        cells: CELLS,
        split: CellSplit::Kuhn,
    };
    let mut mesh = block.mesh().expect("a block of positive size");
    // For laws that have a direction: along the beam.
    mesh.directions = vec![[Vector3::x(), Vector3::y()]; mesh.tets.len()];
    mesh
}

/// Runs a scheme on each of `damages`; `clock` gives CPU time \[s\].
pub fn recover(scheme: &Scheme, damages: &[Damage], clock: &dyn Fn() -> f64) -> Vec<Recovery> {
    let beam = Beam::new(scheme);
    let each = damages.iter().map(|&damage| {
        let made = beam
            .as_ref()
            .map_err(String::clone)
            .and_then(|beam| one(beam, scheme, damage, clock));
        let (step, outcome, cpu) =
            made.unwrap_or_else(|reason| (f64::NAN, Outcome::NotApplicable(reason), 0.0));
        Recovery {
            damage,
            scheme: *scheme,
            step,
            outcome,
            cpu,
        }
    });
    each.collect()
}

fn one(
    beam: &Beam,
    scheme: &Scheme,
    damage: Damage,
    clock: &dyn Fn() -> f64,
) -> Result<(f64, Outcome, f64), String> {
    let model = &beam.model;
    let mut solver = scheme
        .method
        .solver(model)
        .map_err(|error| error.to_string())?;
    let places = beam.resting_place(damage)?;
    // A whole number of steps between two looks.
    let longest = match scheme.step {
        StepLength::LimitFraction(fraction) => stability::stable_step(model, fraction),
        StepLength::Seconds(seconds) => seconds,
    };
    let per_look = (LOOK / longest).ceil().max(1.0);
    let h = if longest > LOOK {
        longest
    } else {
        LOOK / per_look
    };
    let looks = (SIMULATED / (h * per_look)).round() as u32;

    // The clamp jumps from where the body hangs at rest; everything else starts undeformed.
    let mut state = State::at_rest(model);
    if matches!(damage, Damage::Jump | Damage::Turn) {
        state.positions = beam.resting_place(Damage::Tip)?;
    }
    damage.apply(model, &mut state.positions);
    let control = beam.control(damage);
    let mut recovered = None;
    let mut cpu = 0.0;
    let (mut distance, mut inverted) = (f64::INFINITY, 0);
    for look in 0..looks {
        let time = f64::from(look) * per_look * h;
        let start = clock();
        for _ in 0..per_look as u32 {
            if let Err(failure) = solver.step(model, &mut state, &control, &[], h, &Serial) {
                let reason = failure.to_string();
                return Ok((h, Outcome::Failed { time, reason }, cpu + clock() - start));
            }
        }
        cpu += clock() - start;
        let time = time + per_look * h;
        (distance, inverted) = beam.distance(&state, &places);
        if distance > NEAR || inverted > 0 {
            recovered = None;
        } else if recovered.is_none() {
            recovered = Some(time);
        }
        if !distance.is_finite() || distance > 1e3 {
            let reason = "flew apart".into();
            return Ok((h, Outcome::Failed { time, reason }, cpu));
        }
        if cpu > CPU_LIMIT {
            return Ok((h, Outcome::TooSlow(time), cpu));
        }
    }
    let outcome = match recovered {
        Some(time) => Outcome::Recovered(time),
        None => {
            let fastest = state
                .velocities
                .iter()
                .map(|v| v.norm())
                .fold(0.0, f64::max);
            Outcome::Elsewhere {
                distance,
                inverted,
                still: fastest < 0.1 * LENGTH,
            }
        }
    };
    Ok((h, outcome, cpu))
}
