//! The shortest path of a tool past its goals, for the economy of motion.

use crate::tissue::distance;

/// Length of a path of the tip that no run can undercut: straight from `start` \[m\] to one goal after the other, each of which counts as reached
/// within `margin` \[m\].
///
/// ```
/// // 5 mm to the only goal, which counts as reached 1 mm before its middle.
/// let length = microsim_sdk::shortest_path([0.0; 3], &[[3e-3, 4e-3, 0.0]], 1e-3);
/// assert!((length - 4e-3).abs() < 1e-15);
/// ```
pub fn shortest_path(start: [f64; 3], goals: &[[f64; 3]], margin: f64) -> f64 {
    let (mut from, mut near) = (start, margin);
    let mut length = 0.0;
    for goal in goals {
        length += (distance(from, *goal) - near).max(0.0);
        (from, near) = (*goal, 2.0 * margin);
    }
    length
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 5 mm to the first goal and 4 mm on to the second: the margin counts once at the first and at both ends of the second leg.
    #[test]
    fn a_goal_is_reached_within_the_margin() {
        let goals = [[3e-3, 4e-3, 0.0], [3e-3, 0.0, 0.0]];
        let length = shortest_path([0.0; 3], &goals, 0.5e-3);
        assert!((length - (4.5e-3 + 3e-3)).abs() < 1e-15, "{length}");
        assert_eq!(
            shortest_path([0.0; 3], &goals[..1], 6e-3),
            0.0,
            "it is there already"
        );
    }
}
