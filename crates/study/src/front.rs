//! Speed against accuracy: which runs no other run beats, and which is the cheapest for an error.

/// A run as cost and error; the index is the caller's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// CPU time per simulated time.
    pub cost: f64,
    /// Relative error.
    pub error: f64,
    /// Index of the run.
    pub index: usize,
}

/// The points that no other point beats in both cost and error, by ascending cost and so by descending error. Of equal points
/// the first counts. Points that are not finite beat nothing.
pub fn pareto_front(points: &[Point]) -> Vec<Point> {
    let mut sorted: Vec<Point> = points
        .iter()
        .filter(|p| p.cost.is_finite() && p.error.is_finite())
        .copied()
        .collect();
    sorted.sort_by(|a, b| {
        let by_cost = a.cost.total_cmp(&b.cost);
        by_cost
            .then(a.error.total_cmp(&b.error))
            .then(a.index.cmp(&b.index))
    });
    let mut front: Vec<Point> = Vec::new();
    for point in sorted {
        if front.last().is_none_or(|last| point.error < last.error) {
            front.push(point);
        }
    }
    front
}

/// The cheapest measured point with an error of at most `error`. Nothing is interpolated: between two runs there need not be a
/// third.
pub fn cheapest(front: &[Point], error: f64) -> Option<Point> {
    front.iter().find(|point| point.error <= error).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(values: &[(f64, f64)]) -> Vec<Point> {
        let point = |(index, &(cost, error))| Point { cost, error, index };
        values.iter().enumerate().map(point).collect()
    }

    /// By definition: a point is on the front if no other is at least as good in both and better in one.
    #[test]
    fn the_front_is_that_of_the_definition() {
        // Two fixed lists by hand, and one of 200 points random ones.
        let mut random = microsim_random::SplitMix64(7);
        let mut next = || random.below(16) as f64;
        let many: Vec<(f64, f64)> = (0..200).map(|_| (next(), next())).collect();
        let lists = [
            vec![(1.0, 5.0), (2.0, 3.0), (3.0, 4.0), (4.0, 1.0), (0.5, 9.0)],
            vec![(1.0, 1.0), (1.0, 1.0), (1.0, 0.5), (2.0, 0.5)],
            many,
        ];
        for list in lists {
            let all = points(&list);
            let beaten = |p: &Point| {
                all.iter().any(|q| {
                    let better = q.cost < p.cost || q.error < p.error;
                    let no_worse = q.cost <= p.cost && q.error <= p.error;
                    let same_before = q.cost == p.cost && q.error == p.error && q.index < p.index;
                    no_worse && better || same_before
                })
            };
            let mut expected: Vec<Point> = all.iter().filter(|p| !beaten(p)).copied().collect();
            expected.sort_by(|a, b| a.cost.total_cmp(&b.cost));
            assert_eq!(pareto_front(&all), expected);
        }
    }

    #[test]
    fn what_is_not_finite_is_no_answer() {
        let all = points(&[(f64::NAN, 0.0), (1.0, f64::INFINITY), (2.0, 0.1)]);
        assert_eq!(pareto_front(&all), [all[2]]);
        assert_eq!(pareto_front(&[]), []);
    }

    #[test]
    fn the_cheapest_is_a_run_that_was_made() {
        let front = pareto_front(&points(&[(0.1, 0.2), (1.0, 0.03), (10.0, 0.004)]));
        let index = |error| cheapest(&front, error).map(|p| p.index);
        assert_eq!(index(0.5), Some(0));
        assert_eq!(index(0.10), Some(1), "between two runs the better one");
        assert_eq!(index(0.03), Some(1), "an error that is just met");
        assert_eq!(index(0.01), Some(2));
        assert_eq!(index(0.001), None);
    }
}
