//! How fast what is deflected moves: nothing in a dead zone around the middle, then slow, so that small motions are exact, then fast.

/// Deflection of sticks below which nothing moves. Sticks of worn gamepads rest up to an eighth off their middle.
pub const STICK: f64 = 0.15;
/// Deflection of a SpaceMouse below which nothing moves: a hand that lies on it.
pub const CAP: f64 = 0.08;
/// Fraction up to which triggers count as released.
pub const TRIGGER: f64 = 0.05;

/// The rate, from −1 to 1, of each of the axes that are deflected together. Their direction stays; the size of the deflection d becomes
/// ((d − dead) / (1 − dead))², at most 1, so that rate and slope are zero at the edge of the dead zone.
pub fn rates<const N: usize>(deflection: [f64; N], dead: f64) -> [f64; N] {
    let size = deflection.iter().map(|d| d * d).sum::<f64>().sqrt();
    if size <= dead {
        return [0.0; N];
    }
    let beyond = ((size - dead) / (1.0 - dead)).min(1.0);
    deflection.map(|d| d / size * beyond * beyond)
}

/// The fraction by which a trigger is pressed, beyond its dead zone.
pub fn pressed(fraction: f64) -> f64 {
    ((fraction - TRIGGER) / (1.0 - TRIGGER)).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_moves_in_the_dead_zone_and_all_at_the_end() {
        assert_eq!(rates([0.15, 0.0], STICK), [0.0, 0.0]);
        assert_eq!(rates([-0.1, 0.1], STICK), [0.0, 0.0]);
        assert_eq!(rates([1.0, 0.0], STICK), [1.0, 0.0]);
        assert_eq!(rates([0.0, -1.0], STICK), [0.0, -1.0]);
        // Into the corner of a square gate: no faster than to its sides.
        let [x, y] = rates([1.0, 1.0], STICK);
        assert!((x.hypot(y) - 1.0).abs() < 1e-15 && x == y);
        // Halfway beyond the dead zone: a quarter.
        let [x, _] = rates([0.575, 0.0], STICK);
        assert!((x - 0.25).abs() < 1e-15);
        assert_eq!((pressed(0.05), pressed(0.0), pressed(1.0)), (0.0, 0.0, 1.0));
    }

    /// Rate and slope have no step anywhere: between neighbours a thousandth apart the rate differs by no more than the steepest slope, 2 / (1 − dead), allows.
    #[test]
    fn the_response_is_smooth() {
        for dead in [STICK, CAP] {
            let rate = |n: i32| rates([f64::from(n) / 1000.0], dead)[0];
            let steepest = 2.0 / (1.0 - dead) / 1000.0;
            for n in -1000..1000 {
                let step = rate(n + 1) - rate(n);
                assert!(step >= 0.0 && step <= steepest + 1e-12, "{n}");
                assert!((rate(n) + rate(-n)).abs() < 1e-15);
            }
            for n in -999..999 {
                let bend = rate(n + 1) - 2.0 * rate(n) + rate(n - 1);
                let most = 2.0 / (1.0 - dead) / (1.0 - dead) / 1e6;
                assert!(bend.abs() <= most + 1e-12, "{n}");
            }
        }
    }
}
