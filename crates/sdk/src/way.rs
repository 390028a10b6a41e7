//! The least way of a tool past its goals, for the economy of motion.

use crate::tissue::distance;

/// A way of a tip that no run can undercut: straight from `start` \[m\] to one goal after the other, each of which counts as reached
/// within `margin` \[m\].
pub fn least_way(start: [f64; 3], goals: &[[f64; 3]], margin: f64) -> f64 {
    let (mut from, mut near) = (start, margin);
    let mut way = 0.0;
    for goal in goals {
        way += (distance(from, *goal) - near).max(0.0);
        (from, near) = (*goal, 2.0 * margin);
    }
    way
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 5 mm to the first goal and 4 mm on to the second: the margin counts once at the first and at both ends of the second leg.
    #[test]
    fn a_goal_is_reached_within_the_margin() {
        let goals = [[3e-3, 4e-3, 0.0], [3e-3, 0.0, 0.0]];
        let way = least_way([0.0; 3], &goals, 0.5e-3);
        assert!((way - (4.5e-3 + 3e-3)).abs() < 1e-15, "{way}");
        assert_eq!(
            least_way([0.0; 3], &goals[..1], 6e-3),
            0.0,
            "it is there already"
        );
    }
}
