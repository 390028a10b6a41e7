//! A scene from its start to its end: samples of what is watched, when it rests, and whether what was expected came out.
//!
//! What is here: the loop over samples, probes, features of a series. What is not: CPU time (the caller measures it around
//! [`Runner::advance`]), files, output. Pure: the same scene gives the same series on any executor.

mod feature;
mod probe;

use crate::containment::Diverged;
use crate::report::Recovery;
use crate::scene::Scene;
use microsim_settings as settings;
use microsim_tissue::Executor;
use nalgebra::Vector3;
use probe::Probe;

pub use probe::ProbeError;

/// A relative slack for the numbers of samples and steps, far above the rounding of times and far below a step.
const ROUNDING: f64 = 1e-9;

/// What was sampled: lists of equal length.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Series {
    /// Simulated time [s].
    pub time: Vec<f64>,
    /// Kinetic energy of all bodies [J].
    pub kinetic: Vec<f64>,
    /// Elastic energy of all bodies [J].
    pub elastic: Vec<f64>,
    /// Values of each probe, in the order of the settings, in SI.
    pub probes: Vec<Vec<f64>>,
}

/// Why a run has ended.
#[derive(Clone, Debug, PartialEq)]
pub enum End {
    /// Its duration is over; with `end = "rest"` it did not come to rest within it.
    Duration,
    /// It rests.
    Rest,
    /// A body diverged.
    Diverged(Diverged),
}

/// An expectation and what came out.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// Index of the expectation in the settings.
    pub expect: usize,
    /// What came out, in SI; `None` if the series does not hold it (no peak, no two crossings, diverged before).
    pub found: Option<f64>,
    /// (found − expected) / scale.
    pub error: Option<f64>,
    /// Whether the error is within the tolerance.
    pub met: bool,
}

/// A scene that is being run.
#[derive(Clone, Debug)]
pub struct Runner {
    scene: Scene,
    /// Time between two samples [s].
    sample: f64,
    /// Solver's steps between two samples.
    steps: u32,
    /// Samples after the one at the start.
    samples: u64,
    taken: u64,
    /// Speed of rest [m/s], if the scene ends at rest, and the time before which it does not [s].
    rest: Option<(f64, f64)>,
    probes: Vec<Probe>,
    expect: Vec<settings::Expect>,
    series: Series,
    recoveries: Vec<(f64, Recovery)>,
    end: Option<End>,
}

impl Runner {
    /// Makes ready to run `scene`, which was built from `settings`; the first sample is that of the start.
    pub fn new(settings: &settings::Scene, scene: Scene) -> Result<Self, ProbeError> {
        let run = &settings.run;
        let longest = run.sample.max(run.step).min(run.duration);
        let samples = (run.duration / longest * (1.0 - ROUNDING)).ceil().max(1.0);
        let sample = run.duration / samples;
        let steps = (sample / run.step * (1.0 - ROUNDING)).ceil().max(1.0) as u32;
        let probes = settings.probe.iter().enumerate();
        let probes = probes.map(|(index, probe)| Probe::new(index, probe, &scene));
        let mut runner = Self {
            sample,
            steps,
            samples: samples as u64,
            taken: 0,
            rest: run.rest_speed.map(|speed| (speed, last_event(settings))),
            probes: probes.collect::<Result<_, _>>()?,
            expect: settings.expect.clone(),
            series: Series {
                probes: vec![Vec::new(); settings.probe.len()],
                ..Series::default()
            },
            recoveries: Vec::new(),
            end: None,
            scene,
        };
        runner.take_sample();
        Ok(runner)
    }

    /// The scene as it is now.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Length of a solver's step [s].
    pub fn step(&self) -> f64 {
        self.sample / f64::from(self.steps)
    }

    /// Time between two samples [s].
    pub fn sample(&self) -> f64 {
        self.sample
    }

    /// Solver's steps between two samples.
    pub fn steps_per_sample(&self) -> u32 {
        self.steps
    }

    /// Solver's steps made so far; without those that containment or plastic flow added.
    pub fn steps(&self) -> u64 {
        self.taken * u64::from(self.steps)
    }

    /// How much of the duration is over, from 0 to 1.
    pub fn progress(&self) -> f64 {
        self.taken as f64 / self.samples as f64
    }

    /// What was sampled so far.
    pub fn series(&self) -> &Series {
        &self.series
    }

    /// The samples that were computed again because a body diverged, with the time at their end [s].
    pub fn recoveries(&self) -> &[(f64, Recovery)] {
        &self.recoveries
    }

    /// Why the run has ended; `None` while it goes on.
    pub fn end(&self) -> Option<&End> {
        self.end.as_ref()
    }

    /// Advances to the next sample; returns whether there is more to come. After a divergence the scene stands at the sample
    /// before.
    pub fn advance(&mut self, exec: &dyn Executor) -> bool {
        if self.end.is_some() {
            return false;
        }
        let before: Vec<Vec<Vector3<f64>>> = match self.rest {
            Some(_) => self.positions().map(<[_]>::to_vec).collect(),
            None => Vec::new(),
        };
        match self.scene.tick(&[], self.sample, self.steps, exec) {
            Ok(report) => {
                let time = self.scene.time();
                let recoveries = report.recoveries.into_iter();
                self.recoveries.extend(recoveries.map(|r| (time, r)));
            }
            Err(diverged) => {
                self.end = Some(End::Diverged(diverged));
                return false;
            }
        }
        self.taken += 1;
        self.take_sample();
        let rests = self.rest.is_some_and(|(speed, not_before)| {
            self.scene.time() >= not_before && self.rests(&before, speed)
        });
        self.end = if rests {
            Some(End::Rest)
        } else if self.taken == self.samples {
            Some(End::Duration)
        } else {
            None
        };
        self.end.is_none()
    }

    /// Advances to the end; `after_sample` is called after each sample, and ends the run early if it returns false.
    pub fn run(
        &mut self,
        exec: &dyn Executor,
        after_sample: &mut dyn FnMut(&Self) -> bool,
    ) -> Option<&End> {
        while self.advance(exec) && after_sample(self) {}
        self.end()
    }

    /// What came out of each expectation, as far as the run has come.
    pub fn verdicts(&self) -> Vec<Verdict> {
        let rest_missed = self.rest.is_some() && self.end != Some(End::Rest);
        let diverged = matches!(self.end, Some(End::Diverged(_)));
        let verdicts = self.expect.iter().enumerate().map(|(index, expect)| {
            let probe = self.probes.iter().position(|p| p.name == expect.probe);
            let values = probe.map(|probe| self.series.probes[probe].as_slice());
            let at_end = expect.what == settings::Feature::AtEnd;
            let settled = matches!(
                expect.what,
                settings::Feature::FirstPeak | settings::Feature::FirstPeakTime
            );
            let found = values
                // What was to come could still change all but a peak that had settled.
                .filter(|_| settled || !diverged)
                .and_then(|v| feature::find(expect, &self.series.time, v));
            let scale = expect.scale.unwrap_or(expect.value.abs());
            let error = found.map(|found| (found - expect.value) / scale);
            Verdict {
                expect: index,
                found,
                error,
                met: error.is_some_and(|e| e.abs() <= expect.tolerance) && !(at_end && rest_missed),
            }
        });
        verdicts.collect()
    }

    fn positions(&self) -> impl Iterator<Item = &[Vector3<f64>]> {
        (0..self.scene.body_count()).map(|body| self.scene.positions(body))
    }

    /// Whether no node is faster than `speed`, now and on the mean over the last sample. A body that swings stands still for a
    /// moment at its turning points, and comes back to where it was around them; never both at once.
    fn rests(&self, before: &[Vec<Vector3<f64>>], speed: f64) -> bool {
        let way = speed * self.sample;
        let mut bodies = self.positions().zip(before).enumerate();
        bodies.all(|(body, (now, before))| {
            let moved = now.iter().zip(before).any(|(a, b)| (a - b).norm() > way);
            let velocities = self.scene.velocities(body).iter();
            !moved && velocities.map(|v| v.norm()).all(|v| v <= speed)
        })
    }

    fn take_sample(&mut self) {
        self.series.time.push(self.scene.time());
        let (mut kinetic, mut elastic) = (0.0, 0.0);
        for body in 0..self.scene.body_count() {
            let energies = self.scene.energies(body);
            kinetic += energies.kinetic;
            elastic += energies.elastic();
        }
        self.series.kinetic.push(kinetic);
        self.series.elastic.push(elastic);
        for (probe, values) in self.probes.iter().zip(&mut self.series.probes) {
            values.push(probe.value(&self.scene));
        }
    }
}

/// When the last thing happens that disturbs a rest [s]: a load has grown, a clamp has moved or lets go.
fn last_event(settings: &settings::Scene) -> f64 {
    let bodies = settings.body.iter();
    let times = bodies.flat_map(|body| {
        let clamps = body.clamp.iter().flat_map(|clamp| {
            let moved = clamp.motion.iter().map(|key| key.time);
            moved.chain(clamp.release)
        });
        clamps.chain(body.load.iter().map(|load| load.ramp))
    });
    times.fold(0.0, f64::max)
}

#[cfg(test)]
mod tests;
