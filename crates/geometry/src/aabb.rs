//! Axis-aligned boxes for the broad phase of collision detection.

use nalgebra::Vector3;

/// An axis-aligned box \[m\]; empty until it holds a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// Smallest coordinates \[m\].
    pub min: Vector3<f64>,
    /// Largest coordinates \[m\].
    pub max: Vector3<f64>,
}

impl Aabb {
    /// The box that holds nothing; it overlaps no other box.
    pub fn empty() -> Self {
        Self {
            min: Vector3::repeat(f64::INFINITY),
            max: Vector3::repeat(f64::NEG_INFINITY),
        }
    }

    /// The smallest box around `points` \[m\].
    pub fn of<'a>(points: impl IntoIterator<Item = &'a Vector3<f64>>) -> Self {
        let mut result = Self::empty();
        for point in points {
            result.include(point);
        }
        result
    }

    /// Grows the box to hold `point` \[m\].
    #[inline]
    pub fn include(&mut self, point: &Vector3<f64>) {
        self.min = self.min.inf(point);
        self.max = self.max.sup(point);
    }

    /// Whether the box holds a point: it is not empty, and its bounds are numbers.
    #[inline]
    pub fn is_valid(&self) -> bool {
        (0..3).all(|k| self.min[k] <= self.max[k])
    }

    /// The smallest box around `self` and `other`.
    pub fn union(&self, other: &Self) -> Self {
        Self {
            min: self.min.inf(&other.min),
            max: self.max.sup(&other.max),
        }
    }

    /// The box grown by `margin` \[m\] on each side.
    pub fn inflated(&self, margin: f64) -> Self {
        let margin = Vector3::repeat(margin);
        Self {
            min: self.min - margin,
            max: self.max + margin,
        }
    }

    /// Whether the two boxes have a common point; touching counts.
    #[inline]
    pub fn overlaps(&self, other: &Self) -> bool {
        self.min.x <= other.max.x
            && other.min.x <= self.max.x
            && self.min.y <= other.max.y
            && other.min.y <= self.max.y
            && self.min.z <= other.max.z
            && other.min.z <= self.max.z
    }

    /// On which sides of the box `point` lies, one bit each: below and above on x, y, z. 0 when it is in the box. Points with
    /// a common bit have all of their convex hull outside (Cohen–Sutherland).
    #[inline]
    pub fn sides(&self, point: &Vector3<f64>) -> u8 {
        let mut sides = 0;
        for k in 0..3 {
            sides |= u8::from(point[k] < self.min[k]) << (2 * k);
            sides |= u8::from(point[k] > self.max[k]) << (2 * k + 1);
        }
        sides
    }

    /// From which to which fraction of its length the segment from `a` to `b` lies in the box, if it does; the boundary counts.
    pub fn clip(&self, a: &Vector3<f64>, b: &Vector3<f64>) -> Option<[f64; 2]> {
        let [mut from, mut to] = [0.0f64, 1.0f64];
        for k in 0..3 {
            let along = b[k] - a[k];
            if along == 0.0 {
                if a[k] < self.min[k] || a[k] > self.max[k] {
                    return None;
                }
                continue;
            }
            let [one, other] = [self.min[k], self.max[k]].map(|side| (side - a[k]) / along);
            from = from.max(one.min(other));
            to = to.min(one.max(other));
        }
        (from <= to).then_some([from, to])
    }

    /// Whether `point` lies in the box; the boundary counts.
    #[inline]
    pub fn contains(&self, point: &Vector3<f64>) -> bool {
        self.sides(point) == 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_overlap_when_they_touch_and_not_when_a_gap_is_left_on_any_axis() {
        let unit = Aabb::of(&[Vector3::zeros(), Vector3::repeat(1.0)]);
        for axis in 0..3 {
            let mut shift = Vector3::zeros();
            shift[axis] = 1.0;
            let touching = Aabb {
                min: unit.min + shift,
                max: unit.max + shift,
            };
            let apart = Aabb {
                min: unit.min + shift * 1.5,
                max: unit.max + shift * 1.5,
            };
            assert!(unit.overlaps(&touching) && touching.overlaps(&unit));
            assert!(!unit.overlaps(&apart) && !apart.overlaps(&unit));
            assert!(unit.overlaps(&apart.inflated(0.5)));
        }
        assert!(!unit.overlaps(&Aabb::empty()));
        assert_eq!(unit.union(&Aabb::empty()), unit);
        // By the diagonal of a face from half of its length before it to as much beyond, and beside it.
        let diagonal = [Vector3::new(-0.5, -0.5, 0.5), Vector3::new(1.5, 1.5, 0.5)];
        assert_eq!(unit.clip(&diagonal[0], &diagonal[1]), Some([0.25, 0.75]));
        let beside = diagonal.map(|end| end + Vector3::z());
        assert_eq!(unit.clip(&beside[0], &beside[1]), None);
        assert_eq!(unit.sides(&Vector3::new(-0.1, 1.1, 0.5)), 0b00_10_01);
        assert_eq!(unit.sides(&Vector3::new(0.0, 1.0, 1.5)), 0b10_00_00);
        assert!(
            unit.contains(&Vector3::repeat(1.0)) && !unit.contains(&Vector3::new(0.5, 0.5, 1.1))
        );
    }
}
