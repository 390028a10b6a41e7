//! How fast forceps draw what they grip. What slides through their jaws is drawn, too: a jerk tears tissue out of them.

use microsim_sdk::message::ToolState;
use serde::{Deserialize, Serialize};

/// Time over which a speed is the mean \[s\]: a period of 10 Hz, the middle of the band of tremor (8 to 12 Hz; 133 µm RMS of an instrument that is actuated, Riviere 1997). A sine of that size leaves at most
/// 2.2 mm/s in it, at the ends of the band, and up to 7.5 mm/s in the mean over half a period.
const WINDOW: f64 = 0.1;

/// The motion of one tool since it has gripped the vessel without interruption.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Course {
    /// Times \[s\] and places of the tip \[m\], over [`WINDOW`] and the last one before it.
    places: Vec<(f64, [f64; 3])>,
}

/// The speeds of all tools that grip.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct DrawSpeed {
    courses: Vec<Course>,
    /// Largest so far \[m/s\].
    pub peak: f64,
}

impl DrawSpeed {
    /// In a tick that ends at `time` \[s\]; for each tool that can grip its state, and whether it grips the vessel.
    pub fn update(&mut self, time: f64, tools: &[(Option<&ToolState>, bool)]) {
        self.courses.resize(tools.len(), Course::default());
        for (course, (tool, grips)) in self.courses.iter_mut().zip(tools) {
            let Some(tool) = tool.filter(|_| *grips) else {
                course.places.clear();
                continue;
            };
            course.places.push((time, tool.pose.position));
            // It was somewhere between the last place before the window and the one after it: that a tick is no whole part of the window makes no difference.
            let then = time - WINDOW;
            let passed = course.places.iter().take_while(|at| at.0 <= then).count();
            course.places.drain(..passed.saturating_sub(1));
            if let (1.., [(before, from), (after, to), ..]) = (passed, &course.places[..]) {
                let part = (then - before) / (after - before);
                let was = [0, 1, 2].map(|k| from[k] + (to[k] - from[k]) * part);
                let way = microsim_sdk::tissue::distance(was, tool.pose.position);
                self.peak = self.peak.max(way / WINDOW);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use microsim_sdk::message::{Pose, ToolStatus};

    /// The largest speed of a tool that is at a place on x \[m\], and grips or not, by the step.
    fn drawn(tick: f64, steps: u32, place: impl Fn(u32) -> (f64, bool)) -> f64 {
        let mut speed = DrawSpeed::default();
        for step in 0..steps {
            let (x, grips) = place(step);
            let state = ToolState {
                tool: "left".into(),
                model: "forceps".into(),
                status: ToolStatus::Tracked,
                pose: Pose {
                    position: [x, 0.0, 0.0],
                    ..Pose::default()
                },
                opening: 0.0,
            };
            speed.update(f64::from(step) * tick, &[(Some(&state), grips)]);
        }
        speed.peak
    }

    /// 3 mm/s for a second, 20 mm/s for a tick of 16 ms, and 50 mm/s without the vessel: of the window of 100 ms 16 ms are fast.
    #[test]
    fn a_jerk_counts_over_the_window_and_only_with_the_vessel() {
        let tick = 0.016;
        let place = |step: u32| {
            let slow = 3e-3 * f64::from(step);
            let fast = if step > 40 { 17e-3 } else { 0.0 };
            let free = 50e-3 * f64::from(step.saturating_sub(60));
            ((slow + fast + free) * tick, step < 60)
        };
        let expected = (0.084 * 3e-3 + 0.016 * 20e-3) / WINDOW;
        let found = drawn(tick, 100, place);
        assert!((found - expected).abs() < 1e-12, "{found}");
    }

    /// A sine of amplitude A and frequency f has moved by at most 2 A sin(π f T) over a time T; the place T ago is found by linear interpolation, with an error of at most A (2 π f Δt)²/8.
    #[test]
    fn little_of_a_tremor_is_left_for_any_tick() {
        let amplitude = 133e-6 * std::f64::consts::SQRT_2;
        for (tick, hertz) in [(0.016, 8.0), (0.016, 10.0), (0.008, 10.0), (0.008, 12.0)] {
            let angle = 2.0 * std::f64::consts::PI * hertz;
            let place = |step: u32| (amplitude * libm::sin(angle * f64::from(step) * tick), true);
            let found = drawn(tick, 1000, place);
            let exact = 2.0 * amplitude * libm::sin(0.5 * angle * WINDOW).abs() / WINDOW;
            let error = amplitude * (angle * tick).powi(2) / 8.0 / WINDOW;
            assert!(found <= exact + error, "{tick} {hertz}: {found} of {exact}");
            // Samples come within half a tick of where it is largest.
            let least = exact * libm::cos(0.5 * angle * tick) - error;
            assert!(found >= least, "{tick} {hertz}: {found} of {exact}");
        }
    }
}
