//! The constants of a law: their keys, units and ranges, and coordinates in which a search has no bounds.

use microsim_settings::{LawName, Material, QuantityError, Unit};
use std::f64::consts::{FRAC_PI_2, PI};
use std::fmt;

/// Key of the angle of the fibres to the first axis.
pub const ANGLE: &str = "fibres.angle";
/// Poisson's ratio where none is given: that of soft tissue, which hardly changes its volume, as the discretisations against locking take it.
/// Stresses along two axes of a nearly incompressible specimen do not determine it.
pub const ASSUMED_POISSON: f64 = 0.49;

/// Widest range of a ratio of which both bounds matter to a search.
const NARROW: f64 = 10.0;

/// A constant of a law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Constant {
    /// Its key in a `[[body.material]]`.
    pub key: &'static str,
    /// Its unit.
    pub unit: Unit,
    /// Smallest value, in SI.
    pub min: f64,
    /// Largest value, in SI.
    pub max: f64,
}

/// Why a text gives no constant.
#[derive(Clone, Debug, PartialEq)]
pub enum ConstantError {
    /// The law has no constant of this key; those that it has.
    Unknown {
        /// What was named.
        key: String,
        /// The keys of the law.
        keys: Vec<&'static str>,
    },
    /// No value of the unit of the constant.
    Value {
        /// The constant.
        constant: Constant,
        /// What was given.
        text: String,
    },
}

impl fmt::Display for ConstantError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unknown { key, keys } => {
                write!(
                    f,
                    "found `{key}`, expected a constant of the law: {}",
                    keys.join(", ")
                )
            }
            Self::Value { constant, text } => {
                let [min, max] = [constant.min, constant.max].map(|v| constant.unit.describe(v));
                let (key, noun) = (constant.key, constant.unit.noun());
                write!(
                    f,
                    "{key}: found `{text}`, expected {noun} from {min} to {max}"
                )
            }
        }
    }
}

impl std::error::Error for ConstantError {}

/// All constants of a law, in the order in which values of them stand.
pub fn constants(law: LawName) -> Vec<Constant> {
    let keys = ["youngs_modulus", "poisson_ratio"].into_iter();
    let keys = keys.chain(law.parameters().iter().map(|(key, _)| *key));
    let with_range = |key| {
        let (unit, min, max) = Material::range(key)?;
        Some(Constant {
            key,
            unit,
            min,
            max,
        })
    };
    let mut constants: Vec<Constant> = keys.filter_map(with_range).collect();
    if law.families() > 0 {
        // A specimen without shear does not distinguish an angle from its mirror images.
        constants.push(Constant {
            key: ANGLE,
            unit: Unit::Angle,
            min: 0.0,
            max: FRAC_PI_2,
        });
    }
    constants
}

impl Constant {
    /// The index of a constant among those of a law, and its value, from texts such as `poisson_ratio` and `0.49`.
    pub fn parse(of_law: &[Self], key: &str, text: &str) -> Result<(usize, f64), ConstantError> {
        let index = of_law.iter().position(|constant| constant.key == key);
        let index = index.ok_or_else(|| ConstantError::Unknown {
            key: key.to_owned(),
            keys: of_law.iter().map(|constant| constant.key).collect(),
        })?;
        let constant = of_law[index];
        let value = match constant.unit.parse(text.trim()) {
            // A number alone is in SI, as in files.
            Err(QuantityError::NoUnit) => text.trim().parse().ok(),
            value => value.ok(),
        };
        let within = |value: &f64| (constant.min..=constant.max).contains(value);
        let value = value.filter(within).ok_or_else(|| ConstantError::Value {
            constant,
            text: text.to_owned(),
        })?;
        Ok((index, value))
    }

    /// Whether both bounds are near: then x = min + (max − min) (1 + sin u)/2, else x = min + s exp u, with u any number.
    fn is_narrow(&self) -> bool {
        self.unit == Unit::Angle || self.unit == Unit::Ratio && self.max - self.min <= NARROW
    }

    /// s above: `stress` \[Pa\] is that of the data.
    fn scale(&self, stress: f64) -> f64 {
        match self.unit {
            Unit::Pressure => stress,
            _ => 1.0,
        }
    }

    /// The value at a coordinate u of a search; it may be beyond `max`.
    pub(crate) fn at(&self, coordinate: f64, stress: f64) -> f64 {
        match self.is_narrow() {
            true => {
                let fraction = 0.5 * (1.0 + libm::sin(coordinate));
                self.min + (self.max - self.min) * fraction
            }
            false => self.min + self.scale(stress) * libm::exp(coordinate),
        }
    }

    /// Where a search starts, for a number in 0..1: all of a narrow range but its ends, where it would stay; four decades otherwise.
    pub(crate) fn start(&self, number: f64) -> f64 {
        match self.is_narrow() {
            true => 0.45 * PI * (2.0 * number - 1.0),
            // From a hundredth to a hundred times the scale.
            false => libm::log(100.0) * (2.0 * number - 1.0),
        }
    }

    /// Whether a value is one of its bounds, as near as a search comes.
    pub(crate) fn is_at_bound(&self, value: f64, stress: f64) -> bool {
        let width = match self.is_narrow() {
            true => self.max - self.min,
            false => self.scale(stress),
        };
        let near = |bound: f64| (value - bound).abs() <= 1e-5 * width;
        near(self.min) || near(self.max)
    }
}

/// A value for people: four digits, in degrees or in the unit that suits its size.
pub fn rounded(unit: Unit, value: f64) -> String {
    // A format of digits gives digits, which can be read.
    let digits = |value: f64| format!("{value:.3e}").parse().unwrap_or(value);
    match unit.from_si(value, "deg") {
        // Rounded in degrees, as they are shown.
        Some(degrees) => format!("{} deg", digits(degrees)),
        None => unit.describe(digits(value)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_law_has_its_parameters_with_unit_and_range() {
        for law in LawName::ALL {
            let constants = constants(law);
            let keys: Vec<&str> = constants.iter().map(|constant| constant.key).collect();
            for (key, unit) in law.parameters() {
                let constant = constants.iter().find(|constant| constant.key == *key);
                let constant = constant.unwrap_or_else(|| panic!("{key} has no range"));
                assert_eq!(constant.unit, *unit, "{key}");
            }
            assert_eq!(keys[..2], ["youngs_modulus", "poisson_ratio"]);
            assert_eq!(keys.contains(&ANGLE), law.families() > 0);
        }
    }

    #[test]
    fn coordinates_stay_in_range() {
        for law in LawName::ALL {
            for constant in constants(law) {
                for number in [0.0, 0.3, 0.99] {
                    let value = constant.at(constant.start(number), 1e4);
                    assert!(
                        (constant.min..=constant.max).contains(&value),
                        "{constant:?}: {value}"
                    );
                    assert!(!constant.is_at_bound(value, 1e4), "{constant:?}: {value}");
                }
                assert!(constant.is_at_bound(constant.min, 1e4));
            }
        }
    }

    #[test]
    fn values_are_shown_with_four_digits() {
        assert_eq!(rounded(Unit::Pressure, 8939.96), "8.94 kPa");
        assert_eq!(rounded(Unit::Angle, 0.506_145), "29 deg");
        assert_eq!(rounded(Unit::Ratio, 0.123_456), "0.1235");
    }

    #[test]
    fn a_fixed_constant_is_read_or_refused() {
        let of_law = constants(LawName::TransverselyIsotropic);
        let parse = |key, text| Constant::parse(&of_law, key, text);
        assert_eq!(parse("youngs_modulus", "20 kPa"), Ok((0, 2e4)));
        assert_eq!(parse("youngs_modulus", "20000"), Ok((0, 2e4)));
        assert_eq!(parse("fibres.angle", "45deg"), Ok((3, 0.5 * FRAC_PI_2)));
        for (key, text, expected) in [
            (
                "nu",
                "0.3",
                "found `nu`, expected a constant of the law: youngs_modulus, poisson_ratio, fibre_ratio, fibres.angle",
            ),
            (
                "poisson_ratio",
                "0.5",
                "poisson_ratio: found `0.5`, expected a number from -0.99 to 0.4999",
            ),
            (
                "fibres.angle",
                "1 mm",
                "fibres.angle: found `1 mm`, expected an angle from 0 deg to 90 deg",
            ),
        ] {
            let error = parse(key, text).expect_err(text);
            assert_eq!(error.to_string(), expected);
        }
    }
}
