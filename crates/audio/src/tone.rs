//! The tones. Each begins and ends at zero, and all of them at once stay below 1, so that nothing is ever clipped.

use std::f64::consts::TAU;

/// Samples in a second \[Hz\].
pub const RATE: u32 = 48_000;

/// What a tone stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Tone {
    /// A tool touches tissue: a soft tick.
    Touch,
    /// A tool cuts: two blades that meet.
    Cut,
    /// Tissue tears: low and rough.
    Tear,
    /// The force is above its limit: for as long as it is.
    Warning,
}

impl Tone {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Touch, Self::Cut, Self::Tear, Self::Warning];

    /// Its length \[s\]; a warning is repeated after it, without a seam.
    pub fn length(self) -> f64 {
        match self {
            Self::Touch => 0.035,
            Self::Cut => 0.06,
            Self::Tear => 0.2,
            Self::Warning => 0.5,
        }
    }

    /// Its largest amplitude.
    pub fn amplitude(self) -> f64 {
        match self {
            Self::Touch | Self::Warning => 0.2,
            Self::Cut => 0.25,
            Self::Tear => 0.3,
        }
    }

    /// Its samples.
    pub fn samples(self) -> Vec<f32> {
        let rate = f64::from(RATE);
        let count = (self.length() * rate).round() as usize;
        let time = |k: usize| k as f64 / rate;
        let raw: Vec<f64> = match self {
            Self::Touch => (0..count)
                .map(|k| (TAU * 900.0 * time(k)).sin() * (-time(k) / 0.008).exp())
                .collect(),
            Self::Cut => {
                // A resonance at 4 kHz, which rings for some hundred microseconds.
                let (angle, radius) = (TAU * 4000.0 / rate, 0.85);
                let (mut last, mut before) = (0.0, 0.0);
                let ringing = noise(count).into_iter().enumerate();
                let ringing = ringing.map(|(k, value)| {
                    let next = value + 2.0 * radius * angle.cos() * last - radius * radius * before;
                    (before, last) = (last, next);
                    let since = |begin: f64| match time(k) - begin {
                        before if before < 0.0 => 0.0,
                        after => (-after / 0.006).exp(),
                    };
                    next * (since(0.0) + 0.7 * since(0.022))
                });
                ringing.collect()
            }
            Self::Tear => {
                let (mut low, mut lower) = (0.0, 0.0);
                // Two low passes of first order at 160 Hz.
                let smooth = 1.0 - (-TAU * 160.0 / rate).exp();
                let noise = noise(count).into_iter().enumerate();
                let rough = noise.map(|(k, value)| {
                    low += smooth * (value - low);
                    lower += smooth * (low - lower);
                    lower * (1.0 + 0.6 * (TAU * 35.0 * time(k)).sin())
                });
                rough.collect()
            }
            // Whole numbers of both within its length.
            Self::Warning => (0..count)
                .map(|k| (TAU * 660.0 * time(k)).sin() * (0.7 - 0.3 * (TAU * 6.0 * time(k)).cos()))
                .collect(),
        };
        let edge = match self {
            // Where it is repeated it goes on.
            Self::Warning => 0.0,
            Self::Touch | Self::Cut => 0.002,
            Self::Tear => 0.02,
        };
        let last = time(count - 1);
        let shaped = raw.into_iter().enumerate().map(|(k, value)| {
            let at = time(k).min(last - time(k));
            value * if at < edge { at / edge } else { 1.0 }
        });
        let shaped: Vec<f64> = shaped.collect();
        let most = shaped.iter().fold(0.0_f64, |most, s| most.max(s.abs()));
        let scale = self.amplitude() / most;
        shaped.into_iter().map(|s| (s * scale) as f32).collect()
    }
}

/// Numbers from −1 to 1 without order, the same ones always.
fn noise(count: usize) -> Vec<f64> {
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let next = |_| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    };
    (0..count).map(next).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Power at a frequency (Goertzel's sum, as the plain Fourier sum).
    fn power(samples: &[f32], frequency: f64) -> f64 {
        let (mut re, mut im) = (0.0, 0.0);
        for (k, sample) in samples.iter().enumerate() {
            let phase = TAU * frequency * k as f64 / f64::from(RATE);
            re += f64::from(*sample) * phase.cos();
            im += f64::from(*sample) * phase.sin();
        }
        re * re + im * im
    }

    /// Mean of the frequencies up to 20 kHz, weighted with their power.
    fn centre(samples: &[f32]) -> f64 {
        let (mut sum, mut weighted) = (0.0, 0.0);
        for frequency in (1..1000).map(|n| 20.0 * f64::from(n)) {
            let power = power(samples, frequency);
            sum += power;
            weighted += power * frequency;
        }
        weighted / sum
    }

    #[test]
    fn tones_begin_and_end_at_zero_and_have_their_length() {
        for tone in Tone::ALL {
            let samples = tone.samples();
            let length = samples.len() as f64 / f64::from(RATE);
            assert!((length - tone.length()).abs() < 1.0 / f64::from(RATE));
            assert_eq!(samples[0], 0.0, "{tone:?}");
            let most = samples.iter().fold(0.0_f32, |most, s| most.max(s.abs()));
            assert!((f64::from(most) - tone.amplitude()).abs() < 1e-6);
            // The warning goes on with its first sample, a step of its sine later.
            let step = match tone {
                Tone::Warning => tone.amplitude() * TAU * 660.0 / f64::from(RATE),
                _ => 0.0,
            };
            let last = f64::from(samples[samples.len() - 1].abs());
            assert!(last <= step + 1e-9, "{tone:?} ends at {last}");
        }
        let all: f64 = Tone::ALL.map(Tone::amplitude).iter().sum();
        assert!(all < 1.0, "all at once");
    }

    /// From the formulas: a sine of 900 Hz that fades, noise that rings at 4 kHz, noise below 160 Hz, a sine of 660 Hz with sides at
    /// 654 and 666 Hz.
    #[test]
    fn tones_differ_in_height() {
        let centres = Tone::ALL.map(|tone| centre(&tone.samples()));
        let [touch, cut, tear, warning] = centres;
        assert!((700.0..1500.0).contains(&touch), "{centres:?}");
        assert!((3000.0..6000.0).contains(&cut), "{centres:?}");
        assert!(tear < 400.0, "{centres:?}");
        assert!((600.0..720.0).contains(&warning), "{centres:?}");
        let samples = Tone::Warning.samples();
        // A side has 0.3/2 of 0.7 of the amplitude.
        let side = power(&samples, 666.0) / power(&samples, 660.0);
        assert!((side - (0.15_f64 / 0.7).powi(2)).abs() < 1e-3, "{side}");
    }
}
