//! The tremor of a hand: noise between 8 and 12 Hz, a sum of sines with random frequencies and phases.

use crate::random::Stream;
use nalgebra::Vector3;
use std::f64::consts::PI;

/// Sines of each axis.
const SINES: usize = 24;
/// Their band \[Hz\]: that of the tremor, 8 to 12 Hz, less what a window of some seconds blurs.
const BAND: [f64; 2] = [8.3, 11.7];
/// How much of its own part of the band each frequency may lie in: neighbours stay apart.
const JITTER: f64 = 0.5;

/// A tremor of RMS 1.
pub(super) struct Tremor {
    /// Angular frequency \[rad/s\] and phase \[rad\] of each sine, axis by axis.
    sines: [Vec<[f64; 2]>; 3],
}

impl Tremor {
    pub fn new(stream: &mut Stream) -> Self {
        let part = (BAND[1] - BAND[0]) / SINES as f64;
        let mut axis = || -> Vec<[f64; 2]> {
            let sines = (0..SINES).map(|k| {
                let within = 0.5 + JITTER * (stream.unit() - 0.5);
                let frequency = BAND[0] + (k as f64 + within) * part;
                [2.0 * PI * frequency, 2.0 * PI * stream.unit()]
            });
            sines.collect()
        };
        Self {
            sines: [axis(), axis(), axis()],
        }
    }

    /// The displacement at time `t` \[s\] of a tremor of this RMS, all axes together \[m\].
    pub fn at(&self, t: f64, rms: f64) -> Vector3<f64> {
        // A sine of amplitude a has the mean square a²/2.
        let amplitude = rms * (2.0 / (3 * SINES) as f64).sqrt();
        Vector3::from([0, 1, 2].map(|axis| {
            let sines = self.sines[axis].iter();
            amplitude
                * sines
                    .map(|[omega, phase]| libm::sin(omega * t + phase))
                    .sum::<f64>()
        }))
    }
}
