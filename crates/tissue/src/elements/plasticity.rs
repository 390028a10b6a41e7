//! Plastic flow of rest values, for dilatation (4.2; NUMERICS 6).
//!
//! With the size L of an element (a length, the square root of an area, the cube root of a volume) stretched by more than
//! the yield strain e_y, its rest size creeps towards the one at which the strain is e_y: L0' = r (L − L0 (1 + e_y)), within
//! the bound L0/L0_start − 1 ≤ e_max (after Müller & Gross 2004: yield, creep, max). What has flowed is stiffer: k grows by
//! the factor 1 + β e_p, e_p = L0/L0_start − 1, up to a bound (isotropic hardening).
//!
//! Flow dissipates: the factor grows only as far as the energy ½ k (q − q0)² of the element does not rise; what is held back
//! comes with later flow. Compression does not flow: a vessel that is dilated stays wide, one that is squeezed recovers.

use crate::range::{MaterialError, not_negative};

/// Constants of plastic flow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plasticity {
    /// Strain e_y from which on the rest size flows, ≥ 0.
    pub yield_strain: f64,
    /// Rate r of the flow \[1/s\], ≥ 0.
    pub creep_rate: f64,
    /// Largest plastic strain e_max, ≥ 0.
    pub max_strain: f64,
    /// Growth β of the stiffness per plastic strain, ≥ 0.
    pub hardening: f64,
    /// Largest factor of the stiffness, ≥ 1.
    pub max_stiffening: f64,
}

/// Plastic flow of elements whose rest value scales with one power of a length, over one step.
pub(crate) struct Flow {
    exponent: u32,
    /// (1 + e_y) to the power: beyond this ratio of value and rest value an element yields.
    yield_ratio: f64,
    yield_stretch: f64,
    /// Fraction of the remaining flow that happens in the step.
    share: f64,
    max_stretch: f64,
    hardening: f64,
    max_stiffening: f64,
}

impl Plasticity {
    /// Whether all values are in range.
    pub fn check(&self) -> Result<(), MaterialError> {
        not_negative("yield_strain", self.yield_strain, ">= 0")?;
        not_negative("creep_rate", self.creep_rate, ">= 0 1/s")?;
        not_negative("max_strain", self.max_strain, ">= 0")?;
        not_negative("hardening", self.hardening, ">= 0")?;
        if self.max_stiffening.is_finite() && self.max_stiffening >= 1.0 {
            return Ok(());
        }
        Err(MaterialError {
            value_name: "max_stiffening",
            value: self.max_stiffening,
            allowed: ">= 1",
        })
    }

    /// The flow over `h` \[s\] of rest values that scale with the power `exponent` of a length.
    pub(crate) fn over(&self, exponent: u32, h: f64) -> Flow {
        let yield_stretch = 1.0 + self.yield_strain;
        Flow {
            exponent,
            yield_ratio: power(yield_stretch, exponent),
            yield_stretch,
            // The exact solution of the creep law for an element that stands still: it never overshoots.
            share: 1.0 - libm::exp(-self.creep_rate * yield_stretch * h),
            max_stretch: 1.0 + self.max_strain,
            hardening: self.hardening,
            max_stiffening: self.max_stiffening,
        }
    }
}

impl Flow {
    /// Lets one rest value flow, and the factor of its stiffness grow; `value` is the size now, `start` the rest value
    /// before any flow. Returns whether the stiffness has grown.
    #[inline]
    pub(crate) fn apply(&self, value: f64, start: f64, rest: &mut f64, factor: &mut f64) -> bool {
        if value <= *rest * self.yield_ratio {
            return false;
        }
        self.yielded(value, start, rest, factor)
    }

    fn yielded(&self, value: f64, start: f64, rest: &mut f64, factor: &mut f64) -> bool {
        let old = *rest;
        let (size, start_size, old_size) = (self.size(value), self.size(start), self.size(old));
        let end = size / self.yield_stretch;
        let flowed = old_size + (end - old_size) * self.share;
        let flowed = flowed.min(start_size * self.max_stretch).max(old_size);
        *rest = power(flowed, self.exponent);

        let stiffer = 1.0 + self.hardening * (flowed / start_size - 1.0);
        let stiffer = stiffer.min(self.max_stiffening);
        // What the flow has set free, as a factor: k may grow by it and the energy is as before. Flow ends at the yield
        // strain; without one nothing may be left, and no bound is needed.
        let (before, after) = (value - old, value - *rest);
        let stiffer = match after > 0.0 {
            true => stiffer.min(*factor * (before / after) * (before / after)),
            false => stiffer,
        };
        let grown = stiffer > *factor;
        *factor = factor.max(stiffer);
        grown
    }

    /// The linear size of a rest value that is not negative.
    fn size(&self, value: f64) -> f64 {
        match self.exponent {
            1 => value,
            2 => value.sqrt(),
            _ => libm::cbrt(value),
        }
    }
}

/// A whole power of 1, 2 or 3.
fn power(size: f64, exponent: u32) -> f64 {
    match exponent {
        1 => size,
        2 => size * size,
        _ => size * size * size,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DILATATION: Plasticity = Plasticity {
        yield_strain: 0.05,
        creep_rate: 3.0,
        max_strain: 0.5,
        hardening: 4.0,
        max_stiffening: 2.0,
    };

    /// Flow of an element held at `stretch` of its first linear size 2, for `time` in `steps` steps: rest size, factor.
    fn hold(
        plasticity: &Plasticity,
        exponent: u32,
        stretch: f64,
        time: f64,
        steps: usize,
    ) -> (f64, f64) {
        let (value, start) = (power(2.0 * stretch, exponent), power(2.0, exponent));
        let (mut rest, mut factor) = (start, 1.0);
        let flow = plasticity.over(exponent, time / steps as f64);
        for _ in 0..steps {
            flow.apply(value, start, &mut rest, &mut factor);
        }
        (flow.size(rest) / 2.0, factor)
    }

    #[test]
    fn creep_follows_the_closed_form_in_any_number_of_steps() {
        // L0(t) = L_end + (1 − L_end) e^(−r (1 + e_y) t) with L_end = L/(1 + e_y), sizes as shares of the first one.
        for exponent in [1, 2, 3] {
            for (stretch, time) in [(1.2, 0.1), (1.2, 0.7), (1.4, 0.3)] {
                let end = stretch / 1.05;
                let expected = end + (1.0 - end) * libm::exp(-3.0 * 1.05 * time);
                for steps in [1, 10, 1000] {
                    let (rest, factor) = hold(&DILATATION, exponent, stretch, time, steps);
                    // Two to four roundings a step.
                    let rounding = 4.0 * steps as f64 * f64::EPSILON;
                    assert!((rest - expected).abs() < rounding, "{rest} {expected}");
                    let stiffer = (1.0 + 4.0 * (expected - 1.0)).min(2.0);
                    assert!(
                        (factor - stiffer).abs() < 4.0 * rounding,
                        "{factor} {stiffer}"
                    );
                }
            }
        }
    }

    #[test]
    fn nothing_flows_up_to_the_yield_strain_or_in_compression() {
        for exponent in [1, 2, 3] {
            for stretch in [0.3, 0.99, 1.0, 1.0499] {
                assert_eq!(hold(&DILATATION, exponent, stretch, 9.0, 9), (1.0, 1.0));
            }
        }
        // An inverted volume.
        let (mut rest, mut factor) = (1.0, 1.0);
        assert!(
            !DILATATION
                .over(3, 1.0)
                .apply(-8.0, 1.0, &mut rest, &mut factor)
        );
        assert_eq!((rest, factor), (1.0, 1.0));
    }

    #[test]
    fn plastic_strain_and_stiffness_are_bounded() {
        for exponent in [1, 2, 3] {
            for stretch in [1.65, 9.0] {
                let (rest, factor) = hold(&DILATATION, exponent, stretch, 99.0, 50);
                assert!((rest - 1.5).abs() < 1e-14, "{rest}");
                // Far beyond the bound the flow sets little free, and stiffens less.
                assert!(factor == 2.0 || stretch == 9.0 && factor < 2.0, "{factor}");
            }
        }
        let rigid = Plasticity {
            max_strain: 0.0,
            ..DILATATION
        };
        assert_eq!(hold(&rigid, 1, 9.0, 99.0, 3), (1.0, 1.0));
    }

    #[test]
    fn flow_never_raises_the_energy_of_an_element() {
        // Strong hardening: without its bound it would store more than the flow sets free.
        let plasticity = Plasticity {
            hardening: 500.0,
            max_stiffening: 1e9,
            ..DILATATION
        };
        let mut held_back = false;
        for exponent in [1, 2, 3] {
            for stretch in [1.06, 1.2, 2.0] {
                let (value, start) = (power(stretch, exponent), 1.0);
                let (mut rest, mut factor) = (start, 1.0);
                let flow = plasticity.over(exponent, 0.01);
                let energy =
                    |rest: f64, factor: f64| 0.5 * factor * (value - rest) * (value - rest);
                for _ in 0..400 {
                    let before = energy(rest, factor);
                    flow.apply(value, start, &mut rest, &mut factor);
                    assert!(energy(rest, factor) <= before * (1.0 + 1e-14));
                    held_back |= factor < 1.0 + 500.0 * (flow.size(rest) - 1.0);
                }
            }
        }
        assert!(held_back, "the bound was reached");
    }

    #[test]
    fn values_out_of_range_are_refused_by_name() {
        assert_eq!(DILATATION.check(), Ok(()));
        let wrong = |plasticity: Plasticity| plasticity.check().unwrap_err().value_name;
        assert_eq!(
            wrong(Plasticity {
                yield_strain: -0.1,
                ..DILATATION
            }),
            "yield_strain"
        );
        assert_eq!(
            wrong(Plasticity {
                creep_rate: f64::NAN,
                ..DILATATION
            }),
            "creep_rate"
        );
        assert_eq!(
            wrong(Plasticity {
                max_strain: f64::INFINITY,
                ..DILATATION
            }),
            "max_strain"
        );
        assert_eq!(
            wrong(Plasticity {
                hardening: -1.0,
                ..DILATATION
            }),
            "hardening"
        );
        assert_eq!(
            wrong(Plasticity {
                max_stiffening: 0.9,
                ..DILATATION
            }),
            "max_stiffening"
        );
    }
}
