//! The two measures, on readings of the sag alone; `tests/peers/beam.py` takes the same of the other engines.

/// The peak is the largest sag before the curve has fallen for this time \[s\]; given up after the second one.
const FALLEN: f64 = 0.05;
const NO_PEAK: f64 = 0.6;
/// At rest: within this fraction of the exact sag, for this time \[s\] and number of steps.
const BAND: f64 = 0.01;
const STAYS: (f64, usize) = (0.5, 5);

/// Readings of the sag until the first peak is over.
pub struct FirstPeak {
    /// Time between readings \[s\].
    interval: f64,
    sags: Vec<f64>,
    best: usize,
}

impl FirstPeak {
    /// A body just released, read every `interval` \[s\].
    pub fn new(interval: f64) -> Self {
        Self {
            interval,
            sags: vec![0.0],
            best: 0,
        }
    }

    /// Takes the next reading \[m\]; whether the peak is over.
    pub fn read(&mut self, sag: f64) -> Result<bool, String> {
        let last = self.sags.len();
        self.sags.push(sag);
        if sag > self.sags[self.best] {
            self.best = last;
        }
        let since = (last - self.best) as f64 * self.interval;
        if last > self.best && since >= FALLEN {
            // A body that only rises has its largest sag at release.
            return match self.best {
                0 => Err("it does not fall".into()),
                _ => Ok(true),
            };
        }
        if self.duration() > NO_PEAK {
            return Err(format!("no peak in {NO_PEAK} s"));
        }
        Ok(false)
    }

    /// Time since release \[s\].
    pub fn duration(&self) -> f64 {
        (self.sags.len() - 1) as f64 * self.interval
    }

    /// Height \[m\] and time \[s\] of the parabola through the three highest readings, once the peak is over.
    pub fn top(&self) -> [f64; 2] {
        let [before, top, after] = [-1, 0, 1].map(|k| self.sags[self.best.wrapping_add_signed(k)]);
        let bend = before - 2.0 * top + after;
        let slope = (after - before) / 2.0;
        let shift = if bend == 0.0 { 0.0 } else { -slope / bend };
        [
            top + slope * shift / 2.0,
            (self.best as f64 + shift) * self.interval,
        ]
    }
}

/// Readings of the sag until it has come to rest.
pub struct Resting {
    step: f64,
    exact: f64,
    inside: usize,
    entered: Option<f64>,
}

impl Resting {
    /// A body just released, read every `step` \[s\], with its exact sag at rest \[m\].
    pub fn new(step: f64, exact: f64) -> Self {
        Self {
            step,
            exact,
            inside: 0,
            entered: None,
        }
    }

    /// The error of a reading \[m\], relative to the exact sag.
    pub fn error(&self, sag: f64) -> f64 {
        sag / self.exact - 1.0
    }

    /// Takes the next reading \[m\] and what the steps have cost so far; the cost when the sag came to stay in the band.
    pub fn read(&mut self, sag: f64, cost: f64) -> Option<f64> {
        if self.error(sag).abs() > BAND {
            (self.inside, self.entered) = (0, None);
            return None;
        }
        self.inside += 1;
        self.entered = self.entered.or(Some(cost));
        let stays = self.inside >= STAYS.1 && self.inside as f64 * self.step >= STAYS.0;
        self.entered.filter(|_| stays)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    fn measured(interval: f64, sag: impl Fn(f64) -> f64) -> Result<[f64; 2], String> {
        let mut peak = FirstPeak::new(interval);
        for k in 1.. {
            if peak.read(sag(f64::from(k) * interval))? {
                break;
            }
        }
        Ok(peak.top())
    }

    /// One swing to 60 mm at 0.15 s. The remainder of the parabola through readings at phases θ apart is at most θ³/(9√3) of
    /// the amplitude, 30 mm; the slope there is at most θ²/3 off (its remainder), over the curvature 1 of the phase.
    #[test]
    fn the_peak_of_a_swing_is_found_between_readings() {
        for interval in [0.0005, 0.01, 0.022] {
            let angle = PI / 0.15 * interval;
            let [height, time] =
                measured(interval, |t| 0.03 * (1.0 - (PI / 0.15 * t).cos())).unwrap();
            let bound = 0.03 * angle.powi(3) / (9.0 * 3f64.sqrt());
            assert!((height - 0.06).abs() < bound, "{interval}: {height}");
            assert!(
                (time - 0.15).abs() < 0.15 / PI * angle * angle / 3.0,
                "{interval}: {time}"
            );
        }
    }

    /// Ripples fall for less than 50 ms; the curve after them counts.
    #[test]
    fn a_ripple_is_no_peak() {
        let rippled = |t: f64| 0.03 * (1.0 - (PI / 0.15 * t).cos()) + 0.004 * (PI / 0.02 * t).sin();
        let [_, time] = measured(0.0005, rippled).unwrap();
        assert!((time - 0.15).abs() < 0.02, "{time}");
    }

    #[test]
    fn no_peak_is_said() {
        assert_eq!(measured(0.01, |t| t), Err("no peak in 0.6 s".into()));
        assert_eq!(measured(0.01, |t| -t), Err("it does not fall".into()));
    }

    /// 1 − e^(−t) is within 1 % from ln 100 = 4.605 s on; the cost here is the time.
    #[test]
    fn rest_counts_from_where_the_sag_stays() {
        let settled = |sag: &dyn Fn(f64) -> f64| {
            let mut rest = Resting::new(0.1, 0.025);
            (1..200).find_map(|k| rest.read(sag(f64::from(k) * 0.1), f64::from(k) * 0.1))
        };
        let creeping = |t: f64| 0.025 * (1.0 - (-t).exp());
        assert_eq!(settled(&creeping), Some(47.0 * 0.1));
        // A visit of 0.4 s is too short, and what follows an excursion starts anew.
        let returning = |t: f64| match t {
            t if t < 0.45 => 0.025,
            t if t < 1.05 => 0.0,
            _ => 0.025,
        };
        assert_eq!(settled(&returning), Some(11.0 * 0.1));
        assert_eq!(settled(&|_| 0.0253), None);
    }
}
