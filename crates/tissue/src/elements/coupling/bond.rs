//! How the pull of a tie goes with the distance of its ends, and when it comes off.
//!
//! Everything here is for a tie of stiffness 1 N/m: energies, forces and slopes are proportional to the stiffness of a tie.
//!
//! # Cohesive bonds
//! The bilinear law of traction and separation (Alfano & Crisfield 2001): with the separation δ = |d|, in any direction,
//!
//! ```text
//! t(δ) = k δ                          δ ≤ δ_0 = strength / stiffness           intact
//! t(δ) = k δ_0 (δ_f − δ)/(δ_f − δ_0)  δ_0 < δ < δ_f = 2 energy / strength      softens
//! t(δ) = 0                            δ ≥ δ_f                                  off for ever
//! ```
//!
//! Below the largest separation r so far a tie is elastic with the secant t(r)/r, towards the origin. The area below t is the energy
//! per area times the area of the tie. During a step r is that of its start and the energy is that of the incremental problem
//! (Ortiz & Pandolfi 1999): the stored one up to r, and beyond it what the law takes as well. So forces have a potential, whose
//! tangent is exact, and a line search works; that r grows is stated by [`Bond::past`] once a step is accepted.
//!
//! The mode does not matter, and compression counts as separation: layers that are pressed together need contact, which bears them.

use crate::range::{MaterialError, not_negative, require};

/// What a tie does as its ends move apart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Bond {
    /// Elastic; off for ever beyond a distance.
    Elastic {
        /// Distance at which a tie breaks \[m\], ≥ 0; infinite for one that holds.
        break_distance: f64,
    },
    /// Elastic up to a strength, then softer and softer, until an energy has been spent.
    Cohesive(Cohesion),
}

/// The separations at which a cohesive bond changes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cohesion {
    /// δ_0, from which on it softens \[m\].
    onset: f64,
    /// δ_f, at which it is off \[m\].
    end: f64,
}

impl Cohesion {
    /// Of a bond of this stiffness per area \[N/m³\], strength \[Pa\] and energy per area \[J/m²\]; the energy is at least that which is
    /// stored at the strength, strength²/(2 stiffness).
    pub fn new(stiffness_per_area: f64, strength: f64, energy: f64) -> Self {
        Self {
            onset: strength / stiffness_per_area,
            end: 2.0 * energy / strength,
        }
    }

    /// t/δ on the law itself.
    fn secant(&self, separation: f64) -> f64 {
        if separation <= self.onset {
            1.0
        } else if separation >= self.end {
            0.0
        } else {
            self.onset * (self.end - separation) / ((self.end - self.onset) * separation)
        }
    }

    /// Area below t between two separations, from `from` ≥ δ_0 on.
    fn work(&self, from: f64, to: f64) -> f64 {
        let left = |separation: f64| (self.end - separation).max(0.0);
        let (before, after) = (left(from), left(to));
        match before > 0.0 {
            true => 0.5 * self.onset * (before * before - after * after) / (self.end - self.onset),
            false => 0.0,
        }
    }
}

/// The pull of a tie, by its stiffness.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Pull {
    /// Energy \[m²\].
    pub energy: f64,
    /// Force over distance.
    pub secant: f64,
    /// Derivative of the force by the distance.
    pub slope: f64,
}

impl Pull {
    const OFF: Self = Self::elastic(0.0, 0.0);

    const fn elastic(secant: f64, distance: f64) -> Self {
        Self {
            energy: 0.5 * secant * distance * distance,
            secant,
            slope: secant,
        }
    }
}

impl Bond {
    /// Whether all values are in range, for this stiffness per area \[N/m³\].
    pub(super) fn check(&self, stiffness_per_area: f64) -> Result<(), MaterialError> {
        match *self {
            Self::Elastic { break_distance } if break_distance == f64::INFINITY => Ok(()),
            Self::Elastic { break_distance } => {
                not_negative("break_distance", break_distance, ">= 0 m")
            }
            Self::Cohesive(Cohesion { onset, end }) => {
                let strength = onset * stiffness_per_area;
                let holds = strength.is_finite() && strength > 0.0;
                require(holds, "strength", strength, "> 0 Pa")?;
                let holds = end.is_finite() && end >= onset;
                let energy = 0.5 * strength * end;
                require(holds, "energy", energy, ">= strength^2/(2 stiffness) J/m²")
            }
        }
    }

    /// The pull at a distance \[m\] of a tie with this past.
    pub(super) fn pull(&self, distance: f64, past: f64) -> Pull {
        match self {
            Self::Elastic { .. } if past == 0.0 => Pull::elastic(1.0, distance),
            Self::Elastic { .. } => Pull::OFF,
            Self::Cohesive(cohesion) => {
                let reached = past.max(cohesion.onset);
                let secant = cohesion.secant(reached);
                if distance <= reached {
                    return Pull::elastic(secant, distance);
                }
                let softens = distance < cohesion.end;
                Pull {
                    energy: 0.5 * secant * reached * reached + cohesion.work(reached, distance),
                    secant: cohesion.secant(distance),
                    slope: match softens {
                        true => -cohesion.onset / (cohesion.end - cohesion.onset),
                        false => 0.0,
                    },
                }
            }
        }
    }

    /// The past of a tie after a step that ends at this distance \[m\]: of an elastic one 0 whole, else the distance at which it broke \[m\]; of a
    /// cohesive one the largest separation so far \[m\].
    pub(super) fn past(&self, distance: f64, before: f64) -> f64 {
        match *self {
            Self::Elastic { break_distance } if before == 0.0 && distance > break_distance => {
                distance
            }
            Self::Elastic { .. } => before,
            Self::Cohesive(_) => before.max(distance),
        }
    }

    /// Whether a tie with this past is off.
    pub(super) fn is_off(&self, past: f64) -> bool {
        match self {
            Self::Elastic { .. } => past != 0.0,
            Self::Cohesive(cohesion) => past >= cohesion.end,
        }
    }

    /// What softening has taken so far by the stiffness \[m²\]; of an elastic tie that broke what it held then.
    pub(super) fn dissipated(&self, past: f64) -> f64 {
        match self {
            Self::Elastic { .. } => 0.5 * past * past,
            Self::Cohesive(cohesion) => {
                let reached = past.max(cohesion.onset);
                let all =
                    0.5 * cohesion.onset * cohesion.onset + cohesion.work(cohesion.onset, reached);
                all - 0.5 * cohesion.secant(reached) * reached * reached
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Adventitia on media: K = 1e9 N/m³, 40 kPa, 15 J/m².
    fn cling() -> Bond {
        Bond::Cohesive(Cohesion::new(1e9, 40e3, 15.0))
    }

    const ONSET: f64 = 40e-6;
    const END: f64 = 0.75e-3;

    #[test]
    fn the_law_is_the_two_lines_through_onset_and_end() {
        // Traction by K: δ up to the onset, then the line to zero at the end.
        for (separation, traction) in [
            (0.0, 0.0),
            (0.5 * ONSET, 0.5 * ONSET),
            (ONSET, ONSET),
            (0.5 * (ONSET + END), 0.5 * ONSET),
            (END, 0.0),
            (2.0 * END, 0.0),
        ] {
            let pull = cling().pull(separation, 0.0);
            let found = pull.secant * separation;
            assert!((found - traction).abs() < 1e-15 * ONSET, "{separation}");
        }
    }

    #[test]
    fn a_tie_that_is_pulled_off_has_taken_exactly_the_energy_per_area() {
        // In steps of any size: work against the forces is energy plus what is lost, and all of it in the end.
        for steps in [1, 7, 1000] {
            let (mut past, mut work) = (0.0, 0.0);
            for step in 0..steps {
                let [from, to] =
                    [step, step + 1].map(|i| 1.1 * END * f64::from(i) / f64::from(steps));
                let start = cling().pull(from, past);
                work += cling().pull(to, past).energy - start.energy;
                past = cling().past(to, past);
                let balance = cling().pull(to, past).energy + cling().dissipated(past) - work;
                assert!(balance.abs() < 1e-13 * ONSET * END, "{step} {balance}");
            }
            // K times it are 15 J/m².
            assert!((1e9 * cling().dissipated(past) / 15.0 - 1.0).abs() < 1e-12);
            assert!(cling().is_off(past));
        }
    }

    #[test]
    fn it_unloads_to_the_origin_and_never_heals() {
        let past = cling().past(0.4 * END, 0.0);
        let at_past = cling().pull(0.4 * END, past);
        let half = cling().pull(0.2 * END, past);
        assert_eq!(half.secant, at_past.secant);
        assert_eq!(half.slope, half.secant);
        assert_eq!(cling().past(0.1 * END, past), past);
        assert!(!cling().is_off(past));
        assert!(cling().dissipated(past) > 0.0);
        // Below the onset nothing is lost.
        assert_eq!(cling().dissipated(0.9 * ONSET), 0.0);
    }

    #[test]
    fn forces_are_the_slope_of_the_energy_and_slopes_that_of_forces() {
        for past in [0.0, 0.3 * END] {
            for separation in [0.6 * ONSET, 3.0 * ONSET, 0.5 * END, 0.9 * END, 1.5 * END] {
                // Central differences of pieces that are quadratic have no truncation, only rounding.
                let h = 1e-4 * END;
                let at = |s: f64| cling().pull(s, past);
                let force = |s: f64| at(s).secant * s;
                let slope = (at(separation + h).energy - at(separation - h).energy) / (2.0 * h);
                assert!((slope - force(separation)).abs() < 1e-10 * ONSET);
                let slope = (force(separation + h) - force(separation - h)) / (2.0 * h);
                assert!((slope - at(separation).slope).abs() < 1e-10);
            }
        }
    }

    #[test]
    fn what_cannot_be_a_bond_is_refused_by_name() {
        let wrong = |strength, energy| {
            let bond = Bond::Cohesive(Cohesion::new(1e9, strength, energy));
            bond.check(1e9).map_err(|error| error.value_name)
        };
        assert_eq!(wrong(40e3, 15.0), Ok(()));
        // 40 kPa store 0.8 J/m² at 1e9 N/m³.
        assert_eq!(wrong(40e3, 0.79), Err("energy"));
        assert_eq!(wrong(0.0, 15.0), Err("strength"));
        assert_eq!(wrong(-40e3, 15.0), Err("strength"));
        assert_eq!(wrong(f64::NAN, 15.0), Err("strength"));
    }
}
