//! How fast forceps draw what they grip. What slides through their jaws is drawn, too: a jerk tears tissue out of them.

use microsim_sdk::message::ToolState;
use serde::{Deserialize, Serialize};

/// Time over which a speed is the mean \[s\]: a period of 10 Hz, the middle of the band of tremor (8 to 12 Hz, Riviere 1997), of which little is left in such a mean. Over half a period tremor of
/// 133 µm alone makes more than what these levels admit.
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
            // The tick is no whole part of the window: the last place before it is retained.
            let old = |at: &(f64, [f64; 3])| time - at.0 >= WINDOW;
            let passed = course.places.iter().take_while(|at| old(at)).count();
            course.places.drain(..passed.saturating_sub(1));
            let (since, from) = course.places[0];
            if time - since >= WINDOW {
                let way = microsim_sdk::tissue::distance(from, tool.pose.position);
                self.peak = self.peak.max(way / (time - since));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use microsim_sdk::message::{Pose, ToolStatus};

    /// 3 mm/s for a second, 20 mm/s for a tick, and 50 mm/s without the vessel: the peak is that of a window of seven ticks of 16 ms, of which one is fast.
    #[test]
    fn a_jerk_counts_over_the_window_and_only_with_the_vessel() {
        let mut speed = DrawSpeed::default();
        let (mut x, tick) = (0.0, 0.016);
        for step in 1..100_u32 {
            let (of_step, holds) = match step {
                40 => (20e-3, true),
                60.. => (50e-3, false),
                _ => (3e-3, true),
            };
            x += of_step * tick;
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
            speed.update(f64::from(step) * tick, &[(Some(&state), holds)]);
        }
        let expected = (6.0 * 3e-3 + 20e-3) / 7.0;
        assert!((speed.peak - expected).abs() < 1e-12, "{}", speed.peak);
    }
}
