//! Whether a run gains energy although nothing does work on it.
//!
//! Watched is the time in which nothing moves but what is free, nothing touches, is cut, or is computed again, and no body has a load: there
//! kinetic, elastic and potential energy together can only fall, by what viscosity and drag take, flow of springs, and what is counted as dissipated
//! energy: what plastic flow of continua, softening of bonds and friction of ties have taken, of elements that are still there. That is added, so
//! it cannot hide what an integrator gains. What grows all the same is the integrator's.

use super::Contact;
use crate::scene::Scene;

/// Energy may grow by this multiple of the largest kinetic and elastic energy that there was. The measure itself oscillates by hω/2, which is
/// 0.6 for the fastest modes at the recommended step of an explicit method.
const MARGIN: f64 = 1.0;

/// A run that gains energy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EnergyGrowth {
    /// Since when \[s\].
    pub since: f64,
    /// Energy at the end of the run over the largest that can be explained, ≥ 2 when it was found.
    pub factor: f64,
}

/// The balance so far.
#[derive(Clone, Debug)]
pub(super) struct EnergyBalance {
    /// Whether the balance of the scene is known at all.
    applies: bool,
    /// The last event that does work \[s\].
    last_event: f64,
    /// Potential of gravity at the start \[J\].
    start: f64,
    /// Least total energy since the last work \[J\], and its time \[s\].
    least: Option<(f64, f64)>,
    /// Largest kinetic and elastic energy that can be explained \[J\].
    scale: f64,
    growth: Option<EnergyGrowth>,
}

impl EnergyBalance {
    pub fn new(scene: &Scene, last_event: f64, has_loads: bool) -> Self {
        Self {
            applies: !has_loads && scene.method().has_inertia(),
            last_event,
            start: potential(scene),
            least: None,
            scale: 0.0,
            growth: None,
        }
    }

    /// Looks at a sample with this kinetic and elastic energy \[J\], the energy dissipated until then \[J\], and what contact did before it;
    /// `edited` if bodies were cut or computed again before it.
    pub fn add(
        &mut self,
        scene: &Scene,
        energy: f64,
        dissipated: f64,
        contacts: &[Contact],
        edited: bool,
    ) {
        if !self.applies {
            return;
        }
        // Old overlaps are undone without a force.
        let touched = contacts
            .iter()
            .any(|contact| contact.weight > 0.0 || contact.depth > 0.0);
        let total = energy + dissipated + potential(scene) - self.start;
        if touched || edited || scene.time() <= self.last_event {
            self.least = None;
        }
        let time = scene.time();
        let (least, since) = *self.least.get_or_insert((total, time));
        if total < least {
            self.least = Some((total, time));
        }
        let rise = (total - least).max(0.0);
        self.scale = self.scale.max(energy - rise);
        if rise > MARGIN * self.scale && self.scale > 0.0 {
            self.growth = Some(EnergyGrowth {
                since,
                factor: 1.0 + rise / self.scale,
            });
        }
    }

    pub fn growth(&self) -> Option<EnergyGrowth> {
        self.growth
    }
}

/// Potential energy of weight \[J\].
fn potential(scene: &Scene) -> f64 {
    let bodies = scene.bodies().map(|body| {
        let masses = body.masses().iter().zip(body.positions());
        -masses
            .map(|(mass, x)| mass * scene.gravity.dot(x))
            .sum::<f64>()
    });
    bodies.sum()
}
