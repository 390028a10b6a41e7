//! Raw values of axes as deflections.

/// What an axis can state, as its device does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Range {
    /// Least value.
    pub least: i32,
    /// Greatest value.
    pub most: i32,
}

/// Deflection of a SpaceMouse whose device states no range.
pub const SPACE_MOUSE: Range = Range {
    least: -350,
    most: 350,
};

impl Range {
    fn length(self) -> f64 {
        f64::from(self.most) - f64::from(self.least)
    }

    /// From −1 to 1, 0 in the middle; an axis without a range is never deflected.
    pub fn deflection(self, value: i32) -> f64 {
        2.0 * self.fraction(value, 0.5) - 1.0
    }

    /// From 0 to 1, as a trigger is; one without a range is never pressed.
    pub fn pressed(self, value: i32) -> f64 {
        self.fraction(value, 0.0)
    }

    fn fraction(self, value: i32, without_range: f64) -> f64 {
        let length = self.length();
        if length <= 0.0 {
            return without_range;
        }
        ((f64::from(value) - f64::from(self.least)) / length).clamp(0.0, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ends and middles of the ranges that these devices state (xpad, hid-playstation, hid-microsoft, 3Dconnexion).
    #[test]
    fn ends_are_one_and_the_middle_is_none() {
        for (least, most) in [(-32768, 32767), (0, 255), (0, 65535), (-350, 350)] {
            let range = Range { least, most };
            assert_eq!(range.deflection(least), -1.0);
            assert_eq!(range.deflection(most), 1.0);
            let middle = (i64::from(least) + i64::from(most)).div_euclid(2) as i32;
            // Between two values where their number is even: half a step.
            let step = 1.0 / (f64::from(most) - f64::from(least));
            assert!(range.deflection(middle).abs() <= step);
            assert_eq!(range.pressed(least), 0.0);
            assert_eq!(range.pressed(most), 1.0);
        }
        // DualShock at rest: 128 of 0 to 255 is 1/255.
        let dual_shock = Range {
            least: 0,
            most: 255,
        };
        assert!((dual_shock.deflection(128) - 1.0 / 255.0).abs() < 1e-15);
    }

    #[test]
    fn nothing_comes_of_a_range_that_is_none() {
        for (least, most) in [(0, 0), (255, 255), (10, -10), (i32::MAX, i32::MIN)] {
            let range = Range { least, most };
            for value in [i32::MIN, -1, 0, 255, i32::MAX] {
                assert_eq!(range.deflection(value), 0.0);
                assert_eq!(range.pressed(value), 0.0);
            }
        }
        // The widest there is, and values beyond a range.
        let widest = Range {
            least: i32::MIN,
            most: i32::MAX,
        };
        assert_eq!(widest.deflection(i32::MIN), -1.0);
        assert_eq!(widest.deflection(i32::MAX), 1.0);
        assert_eq!(SPACE_MOUSE.deflection(500), 1.0);
    }
}
