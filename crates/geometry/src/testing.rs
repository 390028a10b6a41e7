//! Random configurations for the tests: the same on every machine.

use microsim_random::SplitMix64;
use nalgebra::Vector3;

/// Configurations of points for the tests.
pub trait Points {
    /// One of the points −1, −1/2, .., 1 on each axis: equal, collinear and coplanar ones are frequent.
    fn lattice(&mut self) -> Vector3<f64>;

    /// Points as they meet in a scene and in its worst corners: random ones and ones of a lattice, copies of one another,
    /// points on the lines of others (exactly, to rounding, or beside them by a little), at any scale, far from the origin.
    fn points<const N: usize>(&mut self) -> [Vector3<f64>; N];
}

impl Points for SplitMix64 {
    fn lattice(&mut self) -> Vector3<f64> {
        Vector3::from_fn(|_, _| self.below(5) as f64 / 2.0 - 1.0)
    }

    fn points<const N: usize>(&mut self) -> [Vector3<f64>; N] {
        let on_lattice = self.below(3) == 0;
        let related = self.below(2) == 0;
        let mut points = [Vector3::zeros(); N];
        for i in 0..N {
            points[i] = if on_lattice {
                self.lattice()
            } else {
                self.vector()
            };
            if related && i >= 2 && self.below(2) == 0 {
                let (j, k) = (self.below(i as u64) as usize, self.below(i as u64) as usize);
                let fraction = [0.0, 0.25, 0.5, 1.0, 2.0, self.number()][self.below(6) as usize];
                let beside = [0.0, 1e-16, 1e-15, 1e-12, 1e-9, 1e-6, 1e-3][self.below(7) as usize];
                points[i] = points[j] + (points[k] - points[j]) * fraction + self.vector() * beside;
            }
        }
        let scale = [1.0, 1.0, 1e-3, 1e4, 1.0 / 1024.0][self.below(5) as usize];
        let offset = [0.0, 0.0, 0.0, 1.0, 1e3, 1e6][self.below(6) as usize];
        let offset = self.vector() * offset;
        points.map(|p| (p + offset) * scale)
    }
}

/// Rounding of lengths for these points: the distance of neighbouring numbers at the largest coordinate.
pub fn rounding(points: &[Vector3<f64>]) -> f64 {
    points.iter().map(Vector3::amax).fold(0.0, f64::max) * f64::EPSILON
}

/// The largest distance of two of the points on an axis.
pub fn extent(points: &[Vector3<f64>]) -> f64 {
    let bounds = crate::Aabb::of(points);
    (bounds.max - bounds.min).amax()
}

/// The same questions as in this crate, answered with whole numbers of any length: nothing is rounded, and nothing is fast.
pub mod exact {
    use nalgebra::Vector3;
    use num_bigint::BigInt;
    use std::cmp::Ordering;

    pub type Point = [BigInt; 3];

    /// A quotient that is not reduced; the denominator is positive.
    #[derive(Clone)]
    pub struct Ratio(pub BigInt, pub BigInt);

    impl Ratio {
        fn order(&self, other: &Self) -> Ordering {
            (&self.0 * &other.1).cmp(&(&other.0 * &self.1))
        }

        pub fn is_zero(&self) -> bool {
            self.0 == zero()
        }

        /// The nearest number of 64 bits, or one beside it.
        pub fn rounded(&self) -> f64 {
            // Both may be too long for a number of their own: they lose the same tail of bits.
            let bits = self.0.bits().max(self.1.bits());
            let shift = bits.saturating_sub(1000);
            let [n, d] = [&self.0, &self.1].map(|v| {
                let text = (v >> shift).to_string();
                text.parse::<f64>().expect("a number")
            });
            n / d
        }
    }

    /// The points in units of 2 to the returned power, in which all coordinates are whole numbers.
    pub fn points<const N: usize>(points: &[Vector3<f64>; N]) -> ([Point; N], i32) {
        let decode = |x: f64| -> (i64, i32) {
            let bits = x.to_bits();
            let exponent = (bits >> 52 & 0x7ff) as i32;
            let fraction = (bits & ((1 << 52) - 1)) as i64;
            // Numbers below 2^-1022 are 0 here.
            let mantissa = if exponent == 0 { 0 } else { fraction | 1 << 52 };
            (if x < 0.0 { -mantissa } else { mantissa }, exponent - 1075)
        };
        let unit = points
            .iter()
            .flat_map(|p| p.iter().map(|&x| decode(x)))
            .filter_map(|(mantissa, exponent)| (mantissa != 0).then_some(exponent))
            .min()
            .unwrap_or(0);
        let whole = |x: f64| {
            let (mantissa, exponent) = decode(x);
            BigInt::from(mantissa) << (exponent - unit).max(0)
        };
        let whole_points = points
            .each_ref()
            .map(|p| [whole(p.x), whole(p.y), whole(p.z)]);
        (whole_points, unit)
    }

    pub fn zero() -> BigInt {
        BigInt::from(0)
    }

    fn minus(a: &Point, b: &Point) -> Point {
        std::array::from_fn(|k| &a[k] - &b[k])
    }

    fn dot(a: &Point, b: &Point) -> BigInt {
        &a[0] * &b[0] + &a[1] * &b[1] + &a[2] * &b[2]
    }

    fn cross(a: &Point, b: &Point) -> Point {
        std::array::from_fn(|k| {
            let (i, j) = ((k + 1) % 3, (k + 2) % 3);
            &a[i] * &b[j] - &a[j] * &b[i]
        })
    }

    fn smallest<const N: usize>(ratios: [Ratio; N]) -> Ratio {
        ratios.into_iter().min_by(Ratio::order).expect("some")
    }

    /// Six times the signed volume.
    pub fn volume(a: &Point, b: &Point, c: &Point, d: &Point) -> BigInt {
        dot(&minus(b, a), &cross(&minus(c, a), &minus(d, a)))
    }

    /// Squared distances.
    pub fn point_segment(p: &Point, a: &Point, b: &Point) -> Ratio {
        let (ap, ab, bp) = (minus(p, a), minus(b, a), minus(p, b));
        let (along, length) = (dot(&ap, &ab), dot(&ab, &ab));
        if along <= zero() {
            Ratio(dot(&ap, &ap), BigInt::from(1))
        } else if along >= length {
            Ratio(dot(&bp, &bp), BigInt::from(1))
        } else {
            Ratio(dot(&ap, &ap) * &length - &along * &along, length)
        }
    }

    pub fn segments(a: &[Point; 2], b: &[Point; 2]) -> Ratio {
        let (u, v, w) = (
            minus(&a[1], &a[0]),
            minus(&b[1], &b[0]),
            minus(&b[0], &a[0]),
        );
        let n = cross(&u, &v);
        let nn = dot(&n, &n);
        if nn != zero() {
            let (s, t) = (dot(&cross(&w, &v), &n), dot(&cross(&w, &u), &n));
            let inside = zero()..=nn.clone();
            if inside.contains(&s) && inside.contains(&t) {
                let apart = dot(&w, &n);
                return Ratio(&apart * &apart, nn);
            }
        }
        smallest([
            point_segment(&a[0], &b[0], &b[1]),
            point_segment(&a[1], &b[0], &b[1]),
            point_segment(&b[0], &a[0], &a[1]),
            point_segment(&b[1], &a[0], &a[1]),
        ])
    }

    pub fn point_triangle(p: &Point, t: &[Point; 3]) -> Ratio {
        let n = cross(&minus(&t[1], &t[0]), &minus(&t[2], &t[0]));
        let nn = dot(&n, &n);
        let inside = (0..3).all(|k| {
            let (a, b) = (&t[k], &t[(k + 1) % 3]);
            dot(&cross(&minus(b, a), &minus(p, a)), &n) >= zero()
        });
        if nn != zero() && inside {
            let height = dot(&minus(p, &t[0]), &n);
            return Ratio(&height * &height, nn);
        }
        smallest([0, 1, 2].map(|k| point_segment(p, &t[k], &t[(k + 1) % 3])))
    }

    /// Whether the closed edge meets the closed triangle without lying in its plane.
    pub fn goes_through(e: &[Point; 2], t: &[Point; 3]) -> bool {
        let ends = [0, 1].map(|k| volume(&t[0], &t[1], &t[2], &e[k]));
        if &ends[0] * &ends[1] > zero() || (ends[0] == zero() && ends[1] == zero()) {
            return false;
        }
        let parts = [0, 1, 2].map(|k| volume(&e[0], &e[1], &t[k], &t[(k + 1) % 3]));
        parts.iter().all(|v| *v >= zero()) || parts.iter().all(|v| *v <= zero())
    }

    pub fn segment_triangle(e: &[Point; 2], t: &[Point; 3]) -> Ratio {
        if goes_through(e, t) {
            return Ratio(zero(), BigInt::from(1));
        }
        let edge = |k: usize| segments(e, &[t[k].clone(), t[(k + 1) % 3].clone()]);
        smallest([
            point_triangle(&e[0], t),
            point_triangle(&e[1], t),
            edge(0),
            edge(1),
            edge(2),
        ])
    }
}
