//! Where a hand held still: points that were touched are recognised in a motion by that.

use crate::statistics::distance;
use nalgebra::Vector3;

/// A time during which a point did not move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dwell {
    /// When it began `[s]`.
    pub start: f64,
    /// When it ended `[s]`.
    pub end: f64,
    /// Mean of the positions `[m]`.
    pub position: [f64; 3],
    /// Standard deviation of the positions, root mean square over the axes `[m]`.
    pub jitter: f64,
    /// How many positions.
    pub samples: usize,
}

/// The stretches of at least `duration` `[s]` in which all positions are within `radius` `[m]` of the first of them. Times are in order; a motion that is not
/// known for a while comes as `None`, and ends a stretch. Of stretches that follow each other within four radii the longest counts: a hand that touches one point
/// with a short slip has touched one.
pub fn dwells(path: &[(f64, Option<[f64; 3]>)], radius: f64, duration: f64) -> Vec<Dwell> {
    let mut found: Vec<Dwell> = Vec::new();
    let mut start = 0;
    while start < path.len() {
        let Some(first) = path[start].1 else {
            start += 1;
            continue;
        };
        let near = |(_, position): &&(f64, Option<[f64; 3]>)| {
            position.is_some_and(|p| distance(&p.into(), &first.into()) <= radius)
        };
        let count = path[start..].iter().take_while(near).count();
        let stretch = &path[start..start + count];
        let (begin, end) = (stretch[0].0, stretch[count - 1].0);
        if end - begin < duration {
            start += 1;
            continue;
        }
        let dwell = mean(stretch, begin, end);
        start += count;
        match found.last_mut() {
            Some(last)
                if distance(&last.position.into(), &dwell.position.into()) <= 4.0 * radius =>
            {
                if dwell.end - dwell.start > last.end - last.start {
                    *last = dwell;
                }
            }
            _ => found.push(dwell),
        }
    }
    found
}

fn mean(stretch: &[(f64, Option<[f64; 3]>)], start: f64, end: f64) -> Dwell {
    let points: Vec<Vector3<f64>> = stretch
        .iter()
        .filter_map(|(_, p)| p.map(Vector3::from))
        .collect();
    let count = points.len() as f64;
    let mean = points.iter().sum::<Vector3<f64>>() / count;
    let squares: f64 = points
        .iter()
        .map(|point| (point - mean).norm_squared())
        .sum();
    Dwell {
        start,
        end,
        position: mean.into(),
        jitter: (squares / (3.0 * count)).sqrt(),
        samples: points.len(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Half a second at each of three points 50 mm apart, 0.1 s between them, at 100 Hz; the second one is interrupted by a slip of 1.5 mm.
    #[test]
    fn points_that_were_touched_are_found_once_each() {
        let mut path = Vec::new();
        for step in 0..300_i32 {
            let time = f64::from(step) * 0.01;
            let place = f64::from(step / 100) * 0.05;
            let slip = if step == 140 { 1.5e-3 } else { 0.0 };
            let moving = f64::from((step % 100 - 80).max(0)) * 2.5e-3;
            path.push((time, Some([place + slip + moving, 0.0, 0.0])));
        }
        let found = dwells(&path, 1e-3, 0.3);
        let places: Vec<f64> = found.iter().map(|dwell| dwell.position[0]).collect();
        assert_eq!(places.len(), 3, "{found:?}");
        for (place, expected) in places.iter().zip([0.0, 0.05, 0.1]) {
            assert!((place - expected).abs() < 1e-9, "{found:?}");
        }
        // Not seen in the middle: no stretch is long enough.
        let hidden: Vec<_> = path
            .iter()
            .map(|(t, p)| (*t, p.filter(|_| (t * 100.0).round() as i32 % 20 != 0)))
            .collect();
        assert!(dwells(&hidden, 1e-3, 0.3).is_empty());
    }
}
