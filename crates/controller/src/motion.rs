//! What states of a device ask for over time. The sum is the same, however often somebody asks for it.

/// What is asked for while a state holds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Held {
    /// Rates of the tip, −1 to 1: to the right, away from the trainee, up.
    pub shift: [f64; 3],
    /// Rates of azimuth and elevation of the handle and of its roll, −1 to 1.
    pub turn: [f64; 3],
    /// How far the instrument is closed, 0 to 1.
    pub closing: f64,
    /// Until when the rates of tip and angles hold, where nothing states that they end \[s\].
    pub until: [Option<f64>; 2],
}

/// What was asked for since it was taken last.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Motion {
    /// Motion of the tip to the right, away from the trainee and up, as the time that it would take at full deflection \[s\].
    pub shift: [f64; 3],
    /// Change of azimuth, elevation and roll of the handle, as the time that it would take at full deflection \[s\].
    pub turn: [f64; 3],
    /// How far the instrument is to be closed from now on, 0 to 1, if that has changed.
    pub closing: Option<f64>,
}

impl Motion {
    /// Both.
    pub fn and(mut self, other: Self) -> Self {
        for k in 0..3 {
            self.shift[k] += other.shift[k];
            self.turn[k] += other.turn[k];
        }
        self.closing = other.closing.or(self.closing);
        self
    }

    /// Whether nothing is asked for.
    pub fn is_none(&self) -> bool {
        *self == Self::default()
    }
}

/// Sums up.
#[derive(Clone, Copy, Debug, Default)]
pub struct Integral {
    held: Held,
    /// Up to when it is summed up \[s\].
    at: f64,
    sum: Motion,
}

impl Integral {
    /// Another state holds from now on; times are since any fixed moment \[s\].
    pub fn hold(&mut self, held: Held, now: f64) {
        self.advance(now);
        if held.closing != self.held.closing {
            self.sum.closing = Some(held.closing);
        }
        self.held = held;
    }

    /// What is summed up.
    pub fn take(&mut self, now: f64) -> Motion {
        self.advance(now);
        std::mem::take(&mut self.sum)
    }

    /// Nothing moves any more; jaws stay as they are.
    pub fn let_go(&mut self, now: f64) {
        self.advance(now);
        self.held = Held {
            closing: self.held.closing,
            ..Held::default()
        };
    }

    /// Nothing is asked for up to now; how far the instrument is closed is.
    pub fn skip(&mut self, now: f64) {
        self.advance(now);
        self.sum = Motion {
            closing: self.sum.closing,
            ..Motion::default()
        };
    }

    fn advance(&mut self, now: f64) {
        let [shift, turn] = self
            .held
            .until
            .map(|until| (until.map_or(now, |until| until.min(now)) - self.at).max(0.0));
        for k in 0..3 {
            self.sum.shift[k] += self.held.shift[k] * shift;
            self.sum.turn[k] += self.held.turn[k] * turn;
        }
        self.at = self.at.max(now);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FULL: Held = Held {
        shift: [1.0, -0.5, 0.0],
        turn: [0.0, 0.0, 0.25],
        closing: 0.0,
        until: [None; 2],
    };

    /// A second of full deflection is 1 s, half of it 0.5 s, however many pictures there are: the sum of n equal parts is exact but for rounding.
    #[test]
    fn the_sum_does_not_depend_on_how_often_it_is_taken() {
        for pictures in [1, 5, 25, 60, 997] {
            let mut integral = Integral::default();
            integral.hold(FULL, 3.0);
            let mut sum = Motion::default();
            for picture in 1..=pictures {
                let now = 3.0 + f64::from(picture) / f64::from(pictures);
                sum = sum.and(integral.take(now));
            }
            // Released between two pictures: nothing more comes.
            integral.hold(Held::default(), 4.0);
            sum = sum.and(integral.take(9.0));
            let expected = [1.0, -0.5, 0.0, 0.0, 0.0, 0.25];
            for (found, expected) in sum.shift.iter().chain(&sum.turn).zip(expected) {
                assert!((found - expected).abs() < 1e-12, "{pictures}: {sum:?}");
            }
        }
    }

    /// Whole between two pictures: pressed for 40 ms.
    #[test]
    fn nothing_is_lost_between_two_pictures() {
        let mut integral = Integral::default();
        integral.hold(FULL, 0.03);
        integral.hold(Held::default(), 0.07);
        let motion = integral.take(0.2);
        assert!((motion.shift[0] - 0.04).abs() < 1e-15);
        assert!(integral.take(0.4).is_none());
    }

    #[test]
    fn rates_without_an_end_hold_as_long_as_they_may() {
        let mut integral = Integral::default();
        let until = [Some(0.25), None];
        integral.hold(Held { until, ..FULL }, 0.0);
        let first = integral.take(0.2);
        let second = integral.take(1.0);
        assert!((first.shift[0] + second.shift[0] - 0.25).abs() < 1e-15);
        assert!((first.turn[2] + second.turn[2] - 0.25).abs() < 1e-15);
        assert_eq!(integral.take(2.0).shift, [0.0; 3]);
    }

    #[test]
    fn what_was_asked_for_in_a_pause_is_left_out() {
        let mut integral = Integral::default();
        let closing = 0.5;
        integral.hold(Held { closing, ..FULL }, 0.0);
        integral.skip(7.0);
        let motion = integral.take(7.1);
        assert!((motion.shift[0] - 0.1).abs() < 1e-12);
        assert_eq!(motion.closing, Some(0.5), "jaws are as the hand has them");
        assert_eq!(integral.take(7.2).closing, None, "and stay so");
    }
}
