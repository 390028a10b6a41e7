//! Axes: from values to places in a drawing, with round numbers along them.

use crate::number::{exponent, significant};

/// A linear map from values to places in a drawing.
#[derive(Clone, Copy, Debug)]
pub struct ValueAxis {
    /// The two ends; finite and different.
    pub values: (f64, f64),
    /// Where the ends are in the drawing.
    pub places: (f64, f64),
}

/// Round numbers along an axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Ticks {
    /// The numbers, ascending.
    pub values: Vec<f64>,
    /// Digits after the point that they need.
    pub decimals: usize,
}

impl ValueAxis {
    /// An axis from the first to the second of `values`, which must be finite and differ.
    pub fn new(values: (f64, f64), places: (f64, f64)) -> Self {
        Self { values, places }
    }

    /// An axis from 0 to a little above `largest`; never empty.
    pub fn from_zero(largest: f64, places: (f64, f64)) -> Self {
        let end = if largest > 0.0 { 1.05 * largest } else { 1.0 };
        Self::new((0.0, end), places)
    }

    /// Place of a value.
    pub fn at(&self, value: f64) -> f64 {
        let fraction = (value - self.values.0) / (self.values.1 - self.values.0);
        self.places.0 + fraction * (self.places.1 - self.places.0)
    }

    /// Round numbers along it, at least `apart` units of the drawing from each other.
    pub fn ticks(&self, apart: f64) -> Ticks {
        let (lo, hi) = self.values;
        let scale = (hi - lo) / (self.places.1 - self.places.0).abs();
        Ticks::between(lo, hi, apart * scale)
    }
}

impl Ticks {
    /// The round numbers between `lo` and `hi` at a distance of 1, 2 or 5 times a power of ten: the smallest one that is
    /// at least `least`. All finite, `least` above 0.
    pub fn between(lo: f64, hi: f64, least: f64) -> Self {
        let mut power = exponent(least);
        let factor = match least / power_of_ten(power) {
            m if m <= 1.0 => 1.0,
            m if m <= 2.0 => 2.0,
            m if m <= 5.0 => 5.0,
            _ => {
                power += 1;
                1.0
            }
        };
        let step = factor * power_of_ten(power);
        // A tick that round-off puts beside an end is meant to be on it.
        let slack = 1e-9;
        let first = (lo / step - slack).ceil() as i64;
        let last = (hi / step + slack).floor() as i64;
        Self {
            values: (first..=last).map(|k| k as f64 * step).collect(),
            decimals: (-power).max(0) as usize,
        }
    }
}

fn power_of_ten(exponent: i32) -> f64 {
    format!("1e{exponent}").parse().expect("a decimal number")
}

/// The smallest and the largest of the finite values.
pub fn value_range(values: impl IntoIterator<Item = f64>) -> Option<(f64, f64)> {
    values
        .into_iter()
        .filter(|value| value.is_finite())
        .fold(None, |range, value| match range {
            None => Some((value, value)),
            Some((lo, hi)) => Some((value.min(lo), value.max(hi))),
        })
}

/// A logarithmic map from values to places.
#[derive(Clone, Copy, Debug)]
pub struct LogAxis {
    /// From decimal logarithms of values to places.
    logs: ValueAxis,
}

impl LogAxis {
    /// An axis that holds all of `values` that are finite and positive; at least `least` decades long.
    pub fn around(values: impl IntoIterator<Item = f64>, least: f64, places: (f64, f64)) -> Self {
        let positive = values.into_iter().filter(|v| v.is_finite() && *v > 0.0);
        let (low, high) = value_range(positive.map(libm::log10)).unwrap_or((0.0, 0.0));
        let (middle, half) = ((low + high) / 2.0, (high - low) / 2.0);
        // A little air, so that no marker lies on the frame.
        let half = (1.08 * half + 0.06).max(least / 2.0);
        Self {
            logs: ValueAxis::new((middle - half, middle + half), places),
        }
    }

    /// Place of a value; what lies beyond the ends lies on them.
    pub fn at(&self, value: f64) -> f64 {
        let (low, high) = self.logs.values;
        self.logs.at(libm::log10(value).clamp(low, high))
    }

    /// Round values on the axis and whether each carries a number: powers of ten, thinned when there are many, with twos
    /// and fives between when there are few.
    pub fn ticks(&self) -> Vec<(f64, bool)> {
        let (low, high) = self.logs.values;
        let decades = high - low;
        let (first, last) = (low.floor() as i32, high.ceil() as i32);
        let every = if decades > 7.0 { 2 } else { 1 };
        let mut ticks = Vec::new();
        for power in first..=last {
            for factor in [1.0, 2.0, 5.0] {
                let value: f64 = format!("{factor}e{power}").parse().unwrap_or(f64::NAN);
                if !(low..=high).contains(&libm::log10(value)) {
                    continue;
                }
                let whole = factor == 1.0;
                let named = (whole && power % every == 0) || (!whole && decades <= 2.0);
                if whole || decades <= 4.0 {
                    ticks.push((value, named));
                }
            }
        }
        ticks
    }

    /// The number of a tick.
    pub fn label(value: f64) -> String {
        if (1e-4..1e5).contains(&value) {
            format!("{value}")
        } else {
            significant(value, 1).replace("1·10", "10")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::number::fixed;

    #[test]
    fn ticks_are_round() {
        // By hand.
        for (lo, hi, least, values, decimals) in [
            (0.0, 10.0, 2.0, vec![0.0, 2.0, 4.0, 6.0, 8.0, 10.0], 0),
            (0.0, 0.3, 0.07, vec![0.0, 0.1, 0.2, 0.3], 1),
            (-7.0, 12.0, 4.75, vec![-5.0, 0.0, 5.0, 10.0], 0),
            (98.3, 99.1, 0.4, vec![98.5, 99.0], 1),
            (1.0, 9.0, 20.0, vec![], 0),
        ] {
            let got = Ticks::between(lo, hi, least);
            assert_eq!(got.decimals, decimals, "{lo}..{hi}");
            let shown: Vec<_> = got.values.iter().map(|v| fixed(*v, decimals)).collect();
            let expected: Vec<_> = values.iter().map(|v| fixed(*v, decimals)).collect();
            assert_eq!(shown, expected, "{lo}..{hi}");
        }
    }

    #[test]
    fn ranges() {
        assert_eq!(value_range([2.0, f64::NAN, -1.0]), Some((-1.0, 2.0)));
        assert_eq!(value_range([f64::INFINITY]), None);
        let empty = ValueAxis::from_zero(0.0, (10.0, 0.0));
        assert_eq!((empty.at(0.0), empty.at(1.0)), (10.0, 0.0));
    }

    #[test]
    fn a_logarithmic_axis_holds_its_values_and_names_round_ones() {
        let axis = LogAxis::around([0.01, 1.0, f64::NAN, 0.0], 1.0, (0.0, 100.0));
        assert!(axis.at(0.01) > 0.0 && axis.at(1.0) < 100.0);
        assert_eq!(axis.at(1e-9), 0.0, "beyond the end is on the end");
        assert!((axis.at(0.1) - 50.0).abs() < 1e-9, "the middle decade");
        let named: Vec<f64> = axis.ticks().iter().filter(|t| t.1).map(|t| t.0).collect();
        assert_eq!(named, [0.01, 0.1, 1.0]);
        assert_eq!(LogAxis::label(0.01), "0.01");
        assert_eq!(LogAxis::label(1e-7), "10⁻⁷");
    }
}
