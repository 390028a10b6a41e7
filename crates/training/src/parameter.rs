//! The constants that the motion metrics depend on. They are published with the result ([`MetricParameters::listed`]):
//! a count of movements means nothing without its threshold and filter.

use std::fmt;

use serde::{Deserialize, Serialize};

/// Constants of the motion metrics. The defaults suit micro-instruments: fine work is done at 0.1–0.5 mm/s
/// (PMC3559009), a tool is carried to its place at up to some ten mm/s.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct MetricParameters {
    /// Samples further apart than this lie in different segments \[s\], 0.001..10. Default 0.1: six lost samples at 60 Hz.
    pub gap_s: f64,
    /// Rate to which segments are resampled \[Hz\], 25..1000. Default 60: trackers deliver at least this, and interpolating
    /// to a higher rate than the tracker's would add kinks (LDLJ sees them), not information.
    pub resample_hz: f64,
    /// Segments with fewer samples a second, (n − 1)/duration, get no SPARC, LDLJ and tremor \[Hz\], 20..1000. Default 60:
    /// five samples per period of the tremor's upper end. SPARC's 10 Hz alone would do with 20, but a profile drawn through
    /// so few points is smooth by interpolation; one rule for all three is also easier to explain to a trainee.
    pub sample_rate_min_hz: f64,
    /// Shorter segments get no SPARC, LDLJ, tremor and speed correlation \[s\], 0.25..60. Default 1: the window of the tremor
    /// analysis then blurs the band's edges by its half width, 2 Hz.
    pub segment_min_s: f64,
    /// v0: slower is idle \[m/s\], 10⁻⁶..1. Default 0.1 mm/s, the lower end of fine work.
    pub idle_speed_m_s: f64,
    /// v_th: a movement begins above it and ends below half of it \[m/s\], 10⁻⁶..1. Default 1 mm/s: half of it is the upper
    /// end of fine work, so that movements are those from place to place. SPARC is formed of movements by the same threshold.
    pub movement_speed_m_s: f64,
    /// Standard deviation of the Gaussian that smooths positions before the speed for movements and the correlation of speeds is
    /// formed \[s\], 0..1. Default 0.05: 30 % less at 2.65 Hz, where deliberate motion ends; 4 % left of a tremor at 8 Hz.
    pub smoothing_s: f64,
    /// The same for the idle and the bimanual fraction \[s\], 0..1. Default 0.08: of a tremor of amplitude A and frequency f it leaves a
    /// speed of at most A·2πf·exp(−2π²σ²f²), for the largest and slowest tremor of hands, 200 µm at 6 Hz (DOMAIN 1), 0.080 mm/s: below
    /// v0. With 0.05 it would be 1.3 mm/s, and a hand that only trembles would count as one that works. A higher v0 in its place would
    /// call fine work idle.
    pub idle_smoothing_s: f64,
}

impl Default for MetricParameters {
    fn default() -> Self {
        MetricParameters {
            gap_s: 0.1,
            resample_hz: 60.0,
            sample_rate_min_hz: 60.0,
            segment_min_s: 1.0,
            idle_speed_m_s: 1e-4,
            movement_speed_m_s: 1e-3,
            smoothing_s: 0.05,
            idle_smoothing_s: 0.08,
        }
    }
}

/// A parameter's name, value and legal range, for reports and messages.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameter {
    /// Name of the field; its end is the unit.
    pub name: &'static str,
    /// Value in the unit of the field.
    pub value: f64,
    /// Smallest legal value.
    pub min: f64,
    /// Largest legal value.
    pub max: f64,
}

/// A parameter that is not a number within its range.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ParameterError(pub Parameter);

impl fmt::Display for ParameterError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Parameter {
            name,
            value,
            min,
            max,
        } = self.0;
        write!(
            f,
            "metric parameter {name} = {value} lies outside {min}..{max}"
        )
    }
}

impl std::error::Error for ParameterError {}

impl MetricParameters {
    /// All parameters with their ranges, in the order of the fields.
    pub fn listed(&self) -> [Parameter; 8] {
        let parameter = |name, value, min, max| Parameter {
            name,
            value,
            min,
            max,
        };
        [
            parameter("gap_s", self.gap_s, 1e-3, 10.0),
            parameter("resample_hz", self.resample_hz, 25.0, 1000.0),
            parameter("sample_rate_min_hz", self.sample_rate_min_hz, 20.0, 1000.0),
            parameter("segment_min_s", self.segment_min_s, 0.25, 60.0),
            parameter("idle_speed_m_s", self.idle_speed_m_s, 1e-6, 1.0),
            parameter("movement_speed_m_s", self.movement_speed_m_s, 1e-6, 1.0),
            parameter("smoothing_s", self.smoothing_s, 0.0, 1.0),
            parameter("idle_smoothing_s", self.idle_smoothing_s, 0.0, 1.0),
        ]
    }

    /// Refuses the first parameter outside its range.
    pub fn check(&self) -> Result<(), ParameterError> {
        match self
            .listed()
            .into_iter()
            .find(|p| !(p.min..=p.max).contains(&p.value))
        {
            Some(parameter) => Err(ParameterError(parameter)),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn defaults_are_legal_and_other_values_are_refused_by_name() {
        let defaults = MetricParameters::default();
        assert_eq!(defaults.check(), Ok(()));
        let cases = [
            (
                MetricParameters {
                    gap_s: 0.0,
                    ..defaults
                },
                "gap_s",
            ),
            (
                MetricParameters {
                    resample_hz: 24.0,
                    ..defaults
                },
                "resample_hz",
            ),
            (
                MetricParameters {
                    segment_min_s: f64::NAN,
                    ..defaults
                },
                "segment_min_s",
            ),
            (
                MetricParameters {
                    smoothing_s: f64::INFINITY,
                    ..defaults
                },
                "smoothing_s",
            ),
        ];
        for (parameters, name) in cases {
            assert_eq!(parameters.check().expect_err(name).0.name, name);
        }
    }
}
