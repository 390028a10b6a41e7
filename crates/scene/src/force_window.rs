//! The forces of a contact pair on the time scale of a hand.

use nalgebra::Vector3;

/// Time over which the forces of a tool are averaged before a metric takes their peak \[s\]: half a period of 10 Hz, above which the motion of a hand
/// has no part that is meant (Balasubramanian 2012, whose measure of smoothness ends there; finger forces are commanded at 5 to 10 Hz at
/// most, Brooks 1990). The mean over it is the impulse that the tissue took, whatever the tick; what a single tick shows depends on the tick.
pub const FORCE_WINDOW: f64 = 0.05;

/// The last ticks of a contact pair that were valid, up to [`FORCE_WINDOW`].
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct ForceWindow {
    /// Oldest first; together at least as long as the window, from the first tick on.
    pub ticks: Vec<WindowTick>,
}

/// A tick in a window.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct WindowTick {
    /// Its length \[s\].
    pub length: f64,
    /// Mean force on the body \[N\].
    pub force: Vector3<f64>,
    /// Mean grip \[N\].
    pub grip: f64,
}

impl ForceWindow {
    /// Adds a tick, and removes those that have left the window.
    pub fn push(&mut self, tick: WindowTick) {
        self.ticks.push(tick);
        let mut after = 0.0;
        let first = self.ticks.iter().rposition(|tick| {
            after += tick.length;
            after >= FORCE_WINDOW
        });
        self.ticks.drain(..first.unwrap_or(0));
    }

    /// Size of the mean force, and the mean grip \[N\]; before the first tick nothing acted.
    pub fn mean(&self) -> (f64, f64) {
        let (mut force, mut grip, mut left) = (Vector3::zeros(), 0.0, FORCE_WINDOW);
        for tick in self.ticks.iter().rev() {
            let length = tick.length.min(left);
            force += tick.force * (length / FORCE_WINDOW);
            grip += tick.grip * (length / FORCE_WINDOW);
            left -= length;
        }
        (force.norm(), grip)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tick(length: f64, force: f64) -> WindowTick {
        WindowTick {
            length,
            force: Vector3::z() * force,
            grip: 2.0 * force,
        }
    }

    /// By hand: 8 ms of 100 mN are an impulse of 0.8 mN s, over 50 ms 16 mN, until they have left the window; the same impulse in two ticks of half the
    /// length is the same mean, also while the window divides a tick.
    #[test]
    fn a_peak_is_the_impulse_over_the_window_whatever_the_tick() {
        let at = |length: f64, count: usize| {
            let mut window = ForceWindow::default();
            let ticks = (0..count).map(|index| {
                let now = (index as f64 + 0.5) * length;
                let acts = (0.016..0.024).contains(&now);
                window.push(tick(length, if acts { 0.1 } else { 0.0 }));
                window.mean()
            });
            ticks.collect::<Vec<_>>()
        };
        let (whole, halves) = (at(0.008, 10), at(0.004, 20));
        for (index, (force, grip)) in whole.iter().enumerate() {
            assert!((force - halves[2 * index + 1].0).abs() < 1e-15, "{index}");
            assert!((grip - 2.0 * force).abs() < 1e-15, "{index}");
        }
        assert!((whole[2].0 - 0.016).abs() < 1e-15 && (whole[7].0 - 0.016).abs() < 1e-15);
        // From 66 ms on only a part of it is within, at 72 ms 2 of 8 ms, at 80 ms nothing.
        assert!((whole[8].0 - 0.004).abs() < 1e-15 && whole[9].0 == 0.0);
    }

    /// A constant force is its own mean from 50 ms on; a tick longer than the window is its own mean at once.
    #[test]
    fn a_constant_force_is_its_own_mean() {
        let mut window = ForceWindow::default();
        (0..7).for_each(|_| window.push(tick(0.008, 0.02)));
        assert!((window.mean().0 - 0.02).abs() < 1e-15 && window.ticks.len() == 7);
        window.push(tick(0.06, 0.01));
        assert_eq!((window.mean().0, window.ticks.len()), (0.01, 1));
    }
}
