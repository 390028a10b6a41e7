//! The remedies of NUMERICS 3.5 on blocks with a bad element: the step is the recommended one of the good block, and stays.

use super::limits::survives;
use super::subject::{Constants, Substance, Variation, block, body};
use crate::eigen::eigenvalues;
use microsim_tissue::stability::{SAFETY, mass_floor, stable_step, stiffness_cap};
use microsim_tissue::{Method, State, TissueModel};

/// Fraction of the Gershgorin limit to which floor and cap go. The step of the good block is 0.92 to 1.13 of that limit (NUMERICS 3.2),
/// so a smaller fraction would change good elements too; the true limit is still further off.
const FRACTION: f64 = 1.0;
/// Random offsets at the start, as a fraction of a cell of the good block: small for the sliver too.
const OFFSET: f64 = 0.001;

/// What was done.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Remedy {
    /// Nothing.
    None,
    /// Inertia of nodes raised to a floor (3.5 c).
    MassFloor,
    /// Stiffness of elements capped (3.5 d).
    StiffnessCap,
    /// The step shortened to the recommended fraction of the limit.
    ShorterStep,
}

impl Remedy {
    /// All, nothing first.
    pub const ALL: [Self; 4] = [
        Self::None,
        Self::MassFloor,
        Self::StiffnessCap,
        Self::ShorterStep,
    ];

    /// Its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::MassFloor => "mass floor",
            Self::StiffnessCap => "stiffness cap",
            Self::ShorterStep => "shorter step",
        }
    }
}

/// A remedy on a block, and what it brought.
#[derive(Clone, Debug, PartialEq)]
pub struct Remedied {
    /// What the block is made of.
    pub substance: Substance,
    /// Its bad element.
    pub variation: Variation,
    /// What was done.
    pub remedy: Remedy,
    /// The step \[s\].
    pub step: f64,
    /// h·√λ_max over 2: unstable from 1 on.
    pub over_limit: f64,
    /// Whether 2000 steps from small random offsets conserved the energy.
    pub survived: bool,
    /// Total added inertia as a fraction of the mass of the block.
    pub added_mass: f64,
    /// Fraction of the elements, of all sets, whose stiffness was lowered.
    pub capped: f64,
    /// The smallest factor of a stiffness.
    pub smallest_factor: f64,
    /// Change of the first frequency of the block: what the remedy does to slow motion.
    pub frequency_change: f64,
}

/// All remedies on the block of `substance` with the bad element of `variation`.
pub fn remedies(substance: Substance, variation: Variation) -> Vec<Remedied> {
    let material = substance.material(&Constants::default());
    let (Ok(good), Ok(bad)) = (
        body(&block(Variation::Plain), &material, 0.0),
        body(&block(variation), &material, 0.0),
    ) else {
        return Vec::new();
    };
    let fixed = SAFETY * 2.0 / largest(&good).sqrt();
    let frequency = lowest(&bad).sqrt();
    let each = Remedy::ALL.into_iter().map(|remedy| {
        let (mut step, mut model) = (fixed, bad.clone());
        let (mut capped, mut smallest_factor) = (0.0, 1.0f64);
        let state = State::at_rest(&bad);
        match remedy {
            Remedy::None => {}
            Remedy::MassFloor => {
                model = model.with_added_inertia(mass_floor(&bad, &state, fixed, FRACTION));
            }
            Remedy::StiffnessCap => {
                let factors = stiffness_cap(&bad, &state, fixed, FRACTION);
                let all = || factors.iter().flatten();
                capped =
                    all().filter(|factor| **factor < 1.0).count() as f64 / all().count() as f64;
                smallest_factor = all().copied().fold(1.0, f64::min);
                model = model.with_scaled_elements(&factors);
            }
            Remedy::ShorterStep => step = stable_step(&bad, SAFETY),
        }
        Remedied {
            substance,
            variation,
            remedy,
            step,
            over_limit: 0.5 * step * largest(&model).sqrt(),
            survived: survives(&Method::StoermerVerlet, &model, OFFSET, step),
            added_mass: model.added_inertia().iter().sum::<f64>()
                / bad.masses().iter().sum::<f64>(),
            capped,
            smallest_factor,
            frequency_change: lowest(&model).sqrt() / frequency - 1.0,
        }
    });
    each.collect()
}

/// The lowest eigenvalue at rest \[1/s²\].
fn lowest(model: &TissueModel) -> f64 {
    let values = eigenvalues(model, &State::at_rest(model));
    values.first().copied().unwrap_or(0.0)
}

/// The largest eigenvalue at rest \[1/s²\].
fn largest(model: &TissueModel) -> f64 {
    let values = eigenvalues(model, &State::at_rest(model));
    values.last().copied().unwrap_or(0.0)
}
