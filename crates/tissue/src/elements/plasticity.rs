//! Plastic flow of rest values, for dilatation (4.2; NUMERICS 6).
//!
//! With the strain e = L/L0 − 1 of the linear size L (the cube root of a volume, the square root of an area) beyond the yield
//! strain e_y the rest size creeps towards the size at which the strain is e_y, L0 ← L0 + r h (L − L0 (1 + e_y)), within the
//! bound |L0/L0_start − 1| ≤ e_max (after Müller & Gross 2004: yield, creep, max). What has flowed is stiffer: the factor of k
//! grows as 1 + β (stretch beyond yield), up to a bound.

/// Constants of plastic flow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plasticity {
    /// Strain e_y from which on the rest size flows, ≥ 0.
    pub yield_strain: f64,
    /// Rate r of the flow [1/s], ≥ 0.
    pub creep_rate: f64,
    /// Largest plastic strain e_max, ≥ 0.
    pub max_strain: f64,
    /// Growth β of the stiffness per plastic strain, ≥ 0.
    pub hardening: f64,
    /// Largest factor of the stiffness, ≥ 1.
    pub max_stiffening: f64,
}

impl Plasticity {
    /// Lets one rest value flow for `h` [s]; `value`, `start` and `rest` scale with the power `exponent` of a length. Returns
    /// whether the stiffness has grown.
    pub(crate) fn flow(
        &self,
        value: f64,
        start: f64,
        exponent: u32,
        rest: &mut f64,
        factor: &mut f64,
        h: f64,
    ) -> bool {
        let size = |value: f64| match exponent {
            1 => value,
            2 => value.max(0.0).sqrt(),
            _ => libm::cbrt(value.max(0.0)),
        };
        let (value, start, now) = (size(value), size(start), size(*rest));
        let beyond = value - now * (1.0 + self.yield_strain);
        if beyond <= 0.0 {
            return false;
        }
        // The exact solution of the creep law over the step for a value that stands still: it never overshoots.
        let share = 1.0 - libm::exp(-self.creep_rate * (1.0 + self.yield_strain) * h);
        let flowed = now + beyond / (1.0 + self.yield_strain) * share;
        let flowed = flowed.min(start * (1.0 + self.max_strain)).max(now);
        *rest = match exponent {
            1 => flowed,
            2 => flowed * flowed,
            _ => flowed * flowed * flowed,
        };
        let stiffer = (1.0 + self.hardening * (flowed / start - 1.0)).min(self.max_stiffening);
        let grown = stiffer > *factor;
        *factor = factor.max(stiffer);
        grown
    }
}
