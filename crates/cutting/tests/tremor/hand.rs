//! The motion of a blade in a trembling hand.

use microsim_cutting::Sweep;
use microsim_random::SplitMix64;
use nalgebra::Vector3;
use std::f64::consts::TAU;

type V3 = Vector3<f64>;

/// Half the length of the blade \[m\]: longer than any body is wide.
const HALF_BLADE: f64 = 5e-3;

/// From where to where along its path a straight stroke goes \[m\].
const STRAIGHT: f64 = 4e-3;

/// Sines with frequencies between 6 and 12 Hz, phases at random, along each axis.
struct Tremor(Vec<Sine>);

struct Sine {
    amplitude: V3,
    frequency: f64,
    phase: f64,
}

impl Tremor {
    /// With a root mean square of `rms` along each axis.
    fn random(random: &mut SplitMix64, rms: f64) -> Self {
        const SINES: usize = 4;
        let mut sine = |axis: usize| {
            let mut amplitude = V3::zeros();
            amplitude[axis] = rms * (2.0 / SINES as f64).sqrt();
            Sine {
                amplitude,
                frequency: 9.0 + 3.0 * random.number(),
                phase: 0.5 * TAU * random.number(),
            }
        };
        Self((0..3 * SINES).map(|k| sine(k % 3)).collect())
    }

    fn at(&self, time: f64) -> V3 {
        let sines = self.0.iter();
        sines
            .map(|s| s.amplitude * libm::sin(TAU * s.frequency * time + s.phase))
            .sum()
    }
}

/// Where a hand leads the blade.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Course {
    /// Right through, back by up to 1 mm up to three times.
    Straight,
    /// In, around a loop, and out across its own path.
    Looped,
}

/// A stroke: a steady path, and what a trembling hand makes of it.
pub struct Hand {
    /// The middle of the blade without tremor at each tick \[m\].
    places: Vec<V3>,
    /// Direction of the blade without tremor.
    blade: V3,
    tick: f64,
    tremor: Tremor,
    /// Turn of the blade \[rad\].
    turn: Tremor,
}

impl Hand {
    /// Tremor of 49 to 133 µm (Riviere, Rader and Khosla 1997: standing still and actuating) and up to 3°, 1 to 20 mm/s.
    pub fn random(random: &mut SplitMix64, course: Course) -> Self {
        let rms = 91e-6 + 42e-6 * random.number();
        let tremor = Tremor::random(random, rms);
        let tilt = 0.02 + 0.02 * random.number();
        let turn = Tremor::random(random, tilt);
        let speed = [1e-3, 3e-3, 8e-3, 20e-3][random.below(4) as usize];
        let tick = [1e-3, 4e-3, 16e-3][random.below(3) as usize];
        // Across x, down along z, the blade along y.
        let normal = (V3::x() + random.vector() * 0.3).normalize();
        let blade = normal.cross(&(V3::z() + random.vector() * 0.2)).normalize();
        let ahead = blade.cross(&normal);
        let center = V3::new(1e-3, 0.2e-3, 0.0).component_mul(&random.vector());
        let corners = match course {
            Course::Straight => straight(random),
            Course::Looped => looped(random),
        };
        let corners = corners.map(|[s, n]| center + ahead * s + normal * n);
        Self {
            places: divided(&corners.collect::<Vec<_>>(), speed * tick),
            blade,
            tick,
            tremor,
            turn,
        }
    }

    /// Number of ticks.
    pub fn ticks(&self) -> usize {
        self.places.len() - 1
    }

    /// Path of the blade in a tick.
    pub fn sweep(&self, tick: usize) -> Sweep {
        Sweep {
            before: self.blade_at(tick),
            now: self.blade_at(tick + 1),
        }
    }

    /// Ends of the blade at the start of a tick \[m\].
    pub fn blade_at(&self, tick: usize) -> [V3; 2] {
        let time = tick as f64 * self.tick;
        let direction = (self.blade + self.turn.at(time).cross(&self.blade)).normalize();
        let middle = self.places[tick] + self.tremor.at(time);
        [-HALF_BLADE, HALF_BLADE].map(|along| middle + direction * along)
    }
}

/// Corners of a path along its direction and across \[m\].
type Corners = std::vec::IntoIter<[f64; 2]>;

/// Right through, back for a while up to three times.
fn straight(random: &mut SplitMix64) -> Corners {
    let count = random.below(4);
    let mut back: Vec<[f64; 2]> = (0..count)
        .map(|_| [1.5e-3 * random.number(), 1e-3 * random.number().abs()])
        .collect();
    back.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let mut corners = vec![[-STRAIGHT, 0.0]];
    for [at, by] in back {
        corners.extend([[at, 0.0], [at - by, 0.0]]);
    }
    corners.push([STRAIGHT, 0.0]);
    corners.into_iter()
}

/// In, around a loop of 2 to 3 mm, and out across its own path, at 70° to 110°.
fn looped(random: &mut SplitMix64) -> Corners {
    let length = 2e-3 + 0.4e-3 * random.number();
    let width = length * (1.1 + 0.3 * random.number());
    let corner = |k: i32| {
        let u = f64::from(k) / 40.0;
        [length * (1.0 - u * u), width * u * (1.0 - u * u)]
    };
    (-80..=80).map(corner).collect::<Vec<_>>().into_iter()
}

/// A path through these corners in steps of at most `step` \[m\].
fn divided(corners: &[V3], step: f64) -> Vec<V3> {
    let mut places = vec![corners[0]];
    for pair in corners.windows(2) {
        let steps = ((pair[1] - pair[0]).norm() / step).ceil().max(1.0) as usize;
        places.extend((1..=steps).map(|k| pair[0].lerp(&pair[1], k as f64 / steps as f64)));
    }
    places
}
