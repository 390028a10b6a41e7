//! Random configurations for the tests: the same on every machine.

use nalgebra::Vector3;

/// SplitMix64 (Steele, Lea, Flood 2014).
pub struct Random(pub u64);

impl Random {
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// One of 0..`count`.
    pub fn below(&mut self, count: u64) -> u64 {
        self.bits() % count
    }

    /// Uniform in −1..1.
    pub fn number(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    pub fn vector(&mut self) -> Vector3<f64> {
        Vector3::new(self.number(), self.number(), self.number())
    }

    /// One of the points −1, −1/2, .., 1 on each axis: equal, collinear and coplanar ones are frequent.
    pub fn lattice(&mut self) -> Vector3<f64> {
        Vector3::from_fn(|_, _| self.below(5) as f64 / 2.0 - 1.0)
    }
}

impl Random {
    /// Points as they meet in a scene and in its worst corners: random ones and ones of a lattice, copies of one another, points on
    /// the lines of others (exactly, to rounding, or beside them by a little), at any scale, far from the origin.
    pub fn points<const N: usize>(&mut self) -> [Vector3<f64>; N] {
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
                let share = [0.0, 0.25, 0.5, 1.0, 2.0, self.number()][self.below(6) as usize];
                let beside = [0.0, 1e-16, 1e-15, 1e-12, 1e-9, 1e-6, 1e-3][self.below(7) as usize];
                points[i] =
                    points[j] + (points[k] - points[j]) * share + self.vector() * beside;
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

/// The same questions as in this crate, answered with rational numbers: nothing is rounded, and nothing is quick.
pub mod exact {
    use nalgebra::Vector3;
    use num_rational::BigRational;

    pub type Number = BigRational;
    pub type Point = [Number; 3];

    pub fn number(value: f64) -> Number {
        Number::from_float(value).expect("a finite number")
    }

    pub fn point(p: &Vector3<f64>) -> Point {
        std::array::from_fn(|k| number(p[k]))
    }

    pub fn zero() -> Number {
        number(0.0)
    }

    pub fn one() -> Number {
        number(1.0)
    }

    /// The nearest number of 64 bits, or one beside it.
    pub fn rounded(value: &Number) -> f64 {
        // Numerator and denominator may be too long for a number of their own: both lose the same tail of bits.
        let bits = value.numer().bits().max(value.denom().bits());
        let shift = bits.saturating_sub(1000);
        let [n, d] = [value.numer(), value.denom()].map(|v| {
            let text = (v >> shift).to_string();
            text.parse::<f64>().expect("a number")
        });
        n / d
    }

    pub fn minus(a: &Point, b: &Point) -> Point {
        std::array::from_fn(|k| &a[k] - &b[k])
    }

    pub fn along(a: &Point, b: &Point, t: &Number) -> Point {
        std::array::from_fn(|k| &a[k] + (&b[k] - &a[k]) * t)
    }

    pub fn dot(a: &Point, b: &Point) -> Number {
        &a[0] * &b[0] + &a[1] * &b[1] + &a[2] * &b[2]
    }

    pub fn cross(a: &Point, b: &Point) -> Point {
        std::array::from_fn(|k| {
            let (i, j) = ((k + 1) % 3, (k + 2) % 3);
            &a[i] * &b[j] - &a[j] * &b[i]
        })
    }

    /// Six times the signed volume.
    pub fn volume(a: &Point, b: &Point, c: &Point, d: &Point) -> Number {
        dot(&minus(b, a), &cross(&minus(c, a), &minus(d, a)))
    }

    fn squared(a: &Point, b: &Point) -> Number {
        let d = minus(a, b);
        dot(&d, &d)
    }

    pub fn point_segment(p: &Point, a: &Point, b: &Point) -> Number {
        let length = squared(a, b);
        if length == zero() {
            return squared(p, a);
        }
        let t = dot(&minus(p, a), &minus(b, a)) / length;
        squared(p, &along(a, b, &t.clamp(zero(), one())))
    }

    pub fn segments(a: &[Point; 2], b: &[Point; 2]) -> Number {
        let (u, v, w) = (minus(&a[1], &a[0]), minus(&b[1], &b[0]), minus(&b[0], &a[0]));
        let n = cross(&u, &v);
        let nn = dot(&n, &n);
        if nn != zero() {
            let s = dot(&cross(&w, &v), &n) / &nn;
            let t = dot(&cross(&w, &u), &n) / &nn;
            let inside = zero()..=one();
            if inside.contains(&s) && inside.contains(&t) {
                return squared(&along(&a[0], &a[1], &s), &along(&b[0], &b[1], &t));
            }
        }
        let ends = [
            point_segment(&a[0], &b[0], &b[1]),
            point_segment(&a[1], &b[0], &b[1]),
            point_segment(&b[0], &a[0], &a[1]),
            point_segment(&b[1], &a[0], &a[1]),
        ];
        ends.into_iter().min().expect("four")
    }

    pub fn point_triangle(p: &Point, t: &[Point; 3]) -> Number {
        let n = cross(&minus(&t[1], &t[0]), &minus(&t[2], &t[0]));
        let nn = dot(&n, &n);
        if nn != zero() {
            let inside = (0..3).all(|k| {
                let (a, b) = (&t[k], &t[(k + 1) % 3]);
                dot(&cross(&minus(b, a), &minus(p, a)), &n) >= zero()
            });
            if inside {
                let height = dot(&minus(p, &t[0]), &n);
                return &height * &height / nn;
            }
        }
        (0..3)
            .map(|k| point_segment(p, &t[k], &t[(k + 1) % 3]))
            .min()
            .expect("three")
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

    pub fn segment_triangle(e: &[Point; 2], t: &[Point; 3]) -> Number {
        if goes_through(e, t) {
            return zero();
        }
        let ends = [0, 1].map(|k| point_triangle(&e[k], t));
        let edges = [0, 1, 2].map(|k| segments(e, &[t[k].clone(), t[(k + 1) % 3].clone()]));
        ends.into_iter().chain(edges).min().expect("five")
    }
}
