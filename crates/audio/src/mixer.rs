//! Tones that are played at once, as samples.

use crate::tone::{RATE, Tone};

/// How long a warning goes on after it was asked for last \[s\]: a few ticks, so that it ends when a run does, or pauses.
const HOLDS: f64 = 0.12;
/// In which it comes and goes \[s\].
const FADE: f64 = 0.01;

/// What is played.
#[derive(Clone, Debug)]
pub struct Mixer {
    volume: f32,
    /// Samples of each tone, in the order of [`Tone::ALL`], and where it is.
    tones: [(Vec<f32>, Option<usize>); 4],
    /// Samples for which the warning goes on.
    warning: u32,
    /// How far it has come, 0 to 1.
    fade: f32,
}

impl Mixer {
    /// Silence; the volume is from 0 to 1.
    pub fn new(volume: f64) -> Self {
        Self {
            volume: volume.clamp(0.0, 1.0) as f32,
            tones: Tone::ALL.map(|tone| (tone.samples(), None)),
            warning: 0,
            fade: 0.0,
        }
    }

    /// Begins a tone, unless it is playing; a warning goes on for as long as this is called again.
    pub fn play(&mut self, tone: Tone) {
        let (_, place) = &mut self.tones[tone as usize];
        place.get_or_insert(0);
        if tone == Tone::Warning {
            self.warning = (HOLDS * f64::from(RATE)) as u32;
        }
    }

    /// The next samples, of one channel.
    pub fn fill(&mut self, samples: &mut [f32]) {
        samples.iter_mut().for_each(|sample| *sample = self.next());
    }

    fn next(&mut self) -> f32 {
        let step = 1.0 / (FADE * f64::from(RATE)) as f32;
        self.fade = match self.warning {
            0 => (self.fade - step).max(0.0),
            _ => (self.fade + step).min(1.0),
        };
        self.warning = self.warning.saturating_sub(1);
        let mut sum = 0.0;
        for (tone, (samples, place)) in Tone::ALL.into_iter().zip(&mut self.tones) {
            let Some(at) = *place else { continue };
            let is_warning = tone == Tone::Warning;
            sum += samples[at] * if is_warning { self.fade } else { 1.0 };
            let next = at + 1;
            *place = match is_warning {
                true => (self.fade > 0.0).then_some(next % samples.len()),
                false => (next < samples.len()).then_some(next),
            };
        }
        sum * self.volume
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn samples(mixer: &mut Mixer, seconds: f64) -> Vec<f32> {
        let mut samples = vec![0.0; (seconds * f64::from(RATE)) as usize];
        mixer.fill(&mut samples);
        samples
    }

    fn most(samples: &[f32]) -> f64 {
        f64::from(samples.iter().fold(0.0_f32, |most, s| most.max(s.abs())))
    }

    #[test]
    fn a_tone_is_played_once_and_as_loud_as_it_is_set() {
        for volume in [0.0, 0.25, 1.0] {
            let mut mixer = Mixer::new(volume);
            assert_eq!(most(&samples(&mut mixer, 0.1)), 0.0);
            mixer.play(Tone::Cut);
            mixer.play(Tone::Cut);
            let heard = samples(&mut mixer, Tone::Cut.length());
            let expected = Tone::Cut.samples();
            for (heard, expected) in heard.iter().zip(expected) {
                assert_eq!(*heard, expected * volume as f32);
            }
            assert_eq!(most(&samples(&mut mixer, 0.1)), 0.0);
        }
    }

    /// A warning that is asked for at every tick of 8 ms goes on without a gap, and ends 0.13 s after the last one.
    #[test]
    fn a_warning_lasts_as_long_as_its_cause() {
        let mut mixer = Mixer::new(1.0);
        let mut heard = Vec::new();
        for _ in 0..250 {
            mixer.play(Tone::Warning);
            heard.extend(samples(&mut mixer, 0.008));
        }
        for part in heard[RATE as usize / 50..].chunks(RATE as usize / 100) {
            // Never softer than the least of its swelling: 0.4 of the amplitude.
            assert!(most(part) > 0.35 * Tone::Warning.amplitude());
        }
        let after = samples(&mut mixer, 1.0);
        let end = after.iter().rposition(|s| *s != 0.0).expect("it goes on");
        let end = end as f64 / f64::from(RATE);
        assert!((0.12..0.1301).contains(&end), "{end}");
        // No step is larger than those of the tone itself and its fade.
        let largest = Tone::Warning.amplitude()
            * (std::f64::consts::TAU * (660.0 + 6.0) / f64::from(RATE) + 1.0 / 480.0);
        heard.extend(after);
        for pair in heard.windows(2) {
            assert!(f64::from((pair[1] - pair[0]).abs()) <= largest);
        }
    }

    #[test]
    fn all_at_once_are_not_clipped() {
        let mut mixer = Mixer::new(1.0);
        let mut heard = Vec::new();
        for _ in 0..100 {
            Tone::ALL.into_iter().for_each(|tone| mixer.play(tone));
            heard.extend(samples(&mut mixer, 0.01));
        }
        assert!(most(&heard) < 1.0);
    }
}
