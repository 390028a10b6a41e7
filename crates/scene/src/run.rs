//! A scene from its start to its end: samples of what is watched, when it rests, and whether what was expected came out.
//!
//! What is here: the loop over samples, probes, features of a series. What is not: CPU time (the caller measures it around
//! [`Runner::advance`]), files, output. Pure: the same scene gives the same series on any executor.

mod energy_balance;
mod feature;
mod probe;

use crate::cut_report::{CutReport, RejectedCut};
use crate::divergence::Diverged;
use crate::overlap::Overlap;
use crate::report::{Recovery, TickReport};
use crate::scene::Scene;
use energy_balance::EnergyBalance;
use microsim_settings as settings;
use microsim_tissue::Executor;
use nalgebra::Vector3;
use probe::Probe;

pub use energy_balance::EnergyGrowth;
pub use probe::ProbeError;

/// A relative slack for the numbers of samples and steps, far above the rounding of times and far below a step.
const ROUNDING: f64 = 1e-9;

/// Sampled values of a run: lists of equal length, an entry per sample.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Series {
    /// Simulated time \[s\].
    pub time: Vec<f64>,
    /// Kinetic energy of all bodies \[J\].
    pub kinetic: Vec<f64>,
    /// Elastic energy of all bodies \[J\].
    pub elastic: Vec<f64>,
    /// Dissipated energy of all bodies \[J\]: what plastic flow of continua, softening of bonds and friction of ties have taken, of elements that
    /// are still there.
    pub dissipated: Vec<f64>,
    /// Momentum of all bodies \[kg m/s\].
    pub momentum: Vec<[f64; 3]>,
    /// Fraction of all nodes that are inside what their bodies touch ([`Overlap`](crate::Overlap)); empty without contact.
    pub inside_fraction: Vec<f64>,
    /// Depth of the deepest of them, or of the deepest point of an edge or a face in a tool \[m\]; empty without contact.
    pub max_depth: Vec<f64>,
    /// The forces between two that touch, in the order of the settings.
    pub contacts: Vec<ContactSeries>,
    /// Values of each probe, in the order of the settings, in SI.
    pub probes: Vec<Vec<f64>>,
}

/// Sampled values of a contact pair.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ContactSeries {
    /// Force on the body, mean over the sample before \[N\].
    pub force: Vec<[f64; 3]>,
    /// Largest size of the force in a step of it \[N\].
    pub peak: Vec<f64>,
    /// Time with a force above the limit in it \[s\].
    pub over_limit: Vec<f64>,
    /// Fraction of the normal force that acted where nothing slid.
    pub stick_fraction: Vec<f64>,
    /// Force with which both jaws squeezed the body between them, mean over the sample before \[N\].
    pub grip: Vec<f64>,
    /// Largest mean pressure of a jaw \[Pa\].
    pub grip_pressure: Vec<f64>,
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

/// Result of an `[[expect]]` of a scene's file.
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

/// Runs a scene of a settings file to its end: samples, probes, expected values.
///
/// ```
/// use microsim_scene::{End, Runner, Scene, Serial, scene_spec};
///
/// let text = r#"
/// title = {de = "Balken", en = "Beam"}
/// summary = {de = "Ein Balken hängt durch.", en = "A beam sags."}
/// [run]
/// duration = "0.2 s"
/// step = "1 ms"
/// [method]
/// name = "implicit-euler"
/// [[body]]
/// name = "beam"
/// generator = "block"
/// size = ["20 mm", "5 mm", "5 mm"]
/// cells = [4, 1, 1]
/// material = [{density = 1000, law = "stable-neo-hookean", youngs_modulus = "100 kPa", poisson_ratio = 0.3}]
/// [[body.clamp]]
/// nodes = {min = ["-10 mm", -1, -1], max = ["-10 mm", 1, 1]}
/// [[probe]]
/// name = "sag"
/// body = "beam"
/// nodes = {min = ["10 mm", -1, -1], max = ["10 mm", 1, 1]}
/// quantity = "displacement"
/// direction = [0, 0, -1]
/// [[expect]]
/// probe = "sag"
/// what = "largest"
/// value = "2 mm"
/// tolerance = 1
/// source = "an order of magnitude"
/// "#;
/// let settings = microsim_settings::read_scene(text, "beam.toml", &[])?.settings;
/// let load = &mut |_: &std::path::Path| Err(std::io::ErrorKind::NotFound.into());
/// let scene = Scene::new(&scene_spec(&settings, load)?.spec)?;
/// let mut runner = Runner::new(&settings, scene)?;
/// runner.run(&Serial, &mut |_| true);
/// assert_eq!(runner.end(), Some(&End::Duration));
/// assert!(runner.series().probes[0].iter().all(|sag| *sag > -1e-6));
/// assert!(runner.verdicts()[0].met);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Runner {
    scene: Scene,
    /// Time between two samples \[s\].
    sample: f64,
    /// Solver's steps between two samples.
    steps: u32,
    /// Samples after the one at the start.
    samples: u64,
    taken: u64,
    /// Speed of rest \[m/s\], if the scene ends at rest, and the time before which it does not \[s\].
    rest: Option<(f64, f64)>,
    /// Whether the scene is to end with the divergence of a body.
    is_to_diverge: bool,
    probes: Vec<Probe>,
    expect: Vec<settings::Expect>,
    series: Series,
    recoveries: Vec<(f64, Recovery)>,
    /// What contact did since the last sample, an entry per pair.
    contacts: Vec<Contact>,
    /// Positions at the last sample, if the scene ends at rest.
    before: Vec<Vec<Vector3<f64>>>,
    /// What else is to be known of the run.
    remarks: Remarks,
    energy: EnergyBalance,
    end: Option<End>,
}

/// What contact did to a pair since the last sample.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Contact {
    /// \[N·s\].
    pub impulse: Vector3<f64>,
    peak: f64,
    over_limit: f64,
    stick: f64,
    weight: f64,
    /// \[m\].
    depth: f64,
    /// Of the jaws \[N·s\].
    pub grip: f64,
    pressure: f64,
}

/// What should be known of a run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Remarks {
    /// Largest number of sub-steps that a fast tool took.
    pub most_substeps: u32,
    /// Steps that ended above the tolerance of the method.
    pub unconverged: u64,
    /// Tools that jumped, with the time at the end of the tick \[s\].
    pub jumps: Vec<(f64, usize)>,
    /// What was cut, with the time at the end of the tick \[s\].
    pub cuts: Vec<(f64, CutReport)>,
    /// What could not be cut.
    pub rejected: Vec<(f64, RejectedCut)>,
    /// That steps were shortened as tissue had stiffened.
    pub stiffened: Option<Stiffened>,
}

/// Steps that were shortened as plastic flow or stretch had made tissue stiffer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stiffened {
    /// In how many ticks.
    pub ticks: u64,
    /// The first of them \[s\].
    pub since: f64,
    /// The shortest \[s\].
    pub shortest_step: f64,
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
            is_to_diverge: run.end == settings::End::Divergence,
            probes: probes.collect::<Result<_, _>>()?,
            expect: settings.expect.clone(),
            series: Series {
                probes: vec![Vec::new(); settings.probe.len()],
                contacts: vec![ContactSeries::default(); scene.pair_count()],
                ..Series::default()
            },
            recoveries: Vec::new(),
            contacts: vec![Contact::default(); scene.pair_count()],
            before: Vec::new(),
            remarks: Remarks {
                most_substeps: 1,
                ..Remarks::default()
            },
            energy: EnergyBalance::new(
                &scene,
                last_event(settings),
                settings.body.iter().any(|body| !body.load.is_empty()) || scene.irrigates(),
            ),
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

    /// Length of a solver's step \[s\].
    pub fn step(&self) -> f64 {
        self.sample / f64::from(self.steps)
    }

    /// Time between two samples \[s\].
    pub fn sample(&self) -> f64 {
        self.sample
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

    /// The samples that were computed again because a body diverged, with the time at their end \[s\].
    pub fn recoveries(&self) -> &[(f64, Recovery)] {
        &self.recoveries
    }

    /// Why the run has ended; `None` while it goes on.
    pub fn end(&self) -> Option<&End> {
        self.end.as_ref()
    }

    /// What else should be known of the run so far.
    pub fn remarks(&self) -> &Remarks {
        &self.remarks
    }

    /// Whether the bodies have more than twice the energy that they can have, as nothing did work on them: what the run shows is the
    /// integrator's.
    pub fn energy_growth(&self) -> Option<EnergyGrowth> {
        self.energy.growth()
    }

    /// Advances to the next sample and takes it; returns whether there is more to come. After a divergence the scene is at the
    /// sample before, or, where tools turn at times within a sample, at the last of these.
    pub fn advance(&mut self, exec: &dyn Executor) -> bool {
        self.compute(exec) && self.observe()
    }

    /// The first half of [`advance`](Self::advance), which is what a simulation costs: to the next sample. Returns whether there is
    /// a sample to be taken.
    pub fn compute(&mut self, exec: &dyn Executor) -> bool {
        if self.end.is_some() {
            return false;
        }
        if self.rest.is_some() {
            self.before = self.positions().map(<[_]>::to_vec).collect();
        }
        self.contacts.fill(Contact::default());
        let from = self.taken as f64 * self.sample;
        for (start, length) in self.parts(from) {
            // Between two keys of a motion a tool moves evenly.
            let motions = self.scene.own_motions(start, start + length);
            let steps = f64::from(self.steps) * length / self.sample;
            let steps = (steps * (1.0 - ROUNDING)).ceil().max(1.0) as u32;
            let edits = self.scene.edits.len();
            match self.scene.tick(&motions, length, steps, exec) {
                Ok(report) => {
                    for edit in &self.scene.edits[edits..] {
                        let probes = self.probes.iter_mut();
                        probes.for_each(|probe| probe.update_after_edit(edit, &self.scene));
                    }
                    self.note(report, length);
                }
                Err(diverged) => {
                    self.end = Some(End::Diverged(diverged));
                    return false;
                }
            }
        }
        self.taken += 1;
        true
    }

    /// The parts of the sample that begins at `from` \[s\]: their starts and lengths \[s\]. It is divided where tools turn.
    fn parts(&self, from: f64) -> Vec<(f64, f64)> {
        let least = ROUNDING * self.sample;
        let keys = self.scene.tools.iter().flat_map(|tool| &tool.motion);
        let mut turns: Vec<f64> = keys
            .map(|key| key.time - from)
            .filter(|turn| (least..self.sample - least).contains(turn))
            .collect();
        turns.sort_by(f64::total_cmp);
        turns.dedup_by(|later, first| *later - *first < least);
        turns.push(self.sample);
        let mut start = 0.0;
        let parts = turns.into_iter().map(|turn| {
            let part = (from + start, turn - start);
            start = turn;
            part
        });
        parts.collect()
    }

    fn note(&mut self, report: TickReport, length: f64) {
        let time = self.scene.time();
        let recoveries = report.recoveries.into_iter();
        self.recoveries.extend(recoveries.map(|r| (time, r)));
        self.remarks.most_substeps = self.remarks.most_substeps.max(report.substeps);
        self.remarks.unconverged += u64::from(report.solver.unconverged);
        if report.stiffened {
            let bodies = self.scene.bodies();
            let step = bodies
                .map(|body| body.stable_step())
                .fold(f64::INFINITY, f64::min);
            let of = self.remarks.stiffened.get_or_insert(Stiffened {
                ticks: 0,
                since: time - length,
                shortest_step: step,
            });
            of.ticks += 1;
            of.shortest_step = of.shortest_step.min(step);
        }
        let jumps = report.jumped.into_iter();
        self.remarks.jumps.extend(jumps.map(|tool| (time, tool)));
        let cuts = report.cuts.into_iter();
        self.remarks.cuts.extend(cuts.map(|cut| (time, cut)));
        let rejected = report.rejected.into_iter();
        self.remarks
            .rejected
            .extend(rejected.map(|cut| (time, cut)));
        for contact in &report.contacts {
            let index = self.scene.pair_of(contact.body, contact.with);
            let Some(sum) = index.map(|index| &mut self.contacts[index]) else {
                continue;
            };
            sum.impulse += Vector3::from(contact.force_on_tissue) * length;
            sum.peak = sum.peak.max(contact.peak_force_n);
            sum.over_limit += contact.over_limit_s;
            sum.stick += contact.stick_fraction * contact.impulse_ns;
            sum.weight += contact.impulse_ns;
            sum.depth = sum.depth.max(contact.max_depth_m);
            sum.grip += contact.grip_n * length;
            sum.pressure = sum.pressure.max(contact.jaw_pressure_pa);
        }
    }

    /// The second half of [`advance`](Self::advance): takes the sample; returns whether there is more to come.
    pub fn observe(&mut self) -> bool {
        self.take_sample();
        let rests = self.rest.is_some_and(|(speed, not_before)| {
            self.scene.time() >= not_before && self.rests(&self.before, speed)
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
        let end_missed = (self.rest.is_some() && self.end != Some(End::Rest))
            || (self.is_to_diverge && self.end == Some(End::Duration));
        let diverged = matches!(self.end, Some(End::Diverged(_)));
        let verdicts = self.expect.iter().enumerate().map(|(index, expect)| {
            let probe = self.probes.iter().position(|p| p.name == expect.probe);
            let values = probe.map(|probe| self.series.probes[probe].as_slice());
            let at_end = expect.what == settings::Feature::AtEnd;
            let is_peak = matches!(
                expect.what,
                settings::Feature::FirstPeak | settings::Feature::FirstPeakTime
            );
            let found = values
                // What was to come could still change all but a peak that had passed; a run that is to diverge is at its end then.
                .filter(|_| is_peak || !diverged || self.is_to_diverge)
                .and_then(|v| feature::find(expect, &self.series.time, v));
            let scale = expect.scale.unwrap_or(expect.value.abs());
            let error = found.map(|found| (found - expect.value) / scale);
            Verdict {
                expect: index,
                found,
                error,
                met: error.is_some_and(|e| e.abs() <= expect.tolerance) && !(at_end && end_missed),
            }
        });
        verdicts.collect()
    }

    fn positions(&self) -> impl Iterator<Item = &[Vector3<f64>]> {
        (0..self.scene.body_count()).map(|body| self.scene.body(body).positions())
    }

    /// Whether no node is faster than `speed`, now and on the mean over the last sample. A body that swings stands still for a
    /// moment at its turning points, and comes back to where it was around them; never both at once.
    fn rests(&self, before: &[Vec<Vector3<f64>>], speed: f64) -> bool {
        // What was cut has other nodes.
        if self.was_cut() {
            return false;
        }
        let distance = speed * self.sample;
        let mut bodies = self.positions().zip(before).enumerate();
        bodies.all(|(body, (now, before))| {
            let moved = now
                .iter()
                .zip(before)
                .any(|(a, b)| (a - b).norm() > distance);
            let velocities = self.scene.body(body).velocities().iter();
            !moved && velocities.map(|v| v.norm()).all(|v| v <= speed)
        })
    }

    /// Whether anything was cut since the last sample.
    fn was_cut(&self) -> bool {
        let last = self.remarks.cuts.last();
        last.is_some_and(|(time, _)| *time > self.scene.time() - self.sample)
    }

    fn take_sample(&mut self) {
        let recovered = self.recoveries.last();
        let edited = self.was_cut()
            || recovered.is_some_and(|(time, _)| *time > self.scene.time() - self.sample);
        self.series.time.push(self.scene.time());
        let (mut kinetic, mut elastic, mut dissipated) = (0.0, 0.0, 0.0);
        let mut momentum = Vector3::zeros();
        for body in 0..self.scene.body_count() {
            let energies = self.scene.body(body).energies();
            kinetic += energies.kinetic;
            elastic += energies.elastic();
            dissipated += energies.dissipated;
            momentum += self.scene.body(body).momentum();
        }
        self.series.kinetic.push(kinetic);
        self.series.elastic.push(elastic);
        self.series.dissipated.push(dissipated);
        self.series.momentum.push(momentum.into());
        self.energy.add(
            &self.scene,
            kinetic + elastic,
            dissipated,
            &self.contacts,
            edited,
        );
        if self.scene.pair_count() > 0 {
            let bodies = 0..self.scene.body_count();
            let overlaps: Vec<Overlap> =
                bodies.map(|body| self.scene.body(body).overlap()).collect();
            let inside: usize = overlaps.iter().map(|overlap| overlap.nodes).sum();
            let nodes: usize = self.positions().map(<[_]>::len).sum();
            let depths = overlaps.iter().map(|overlap| overlap.depth);
            let depth = depths.fold(0.0, f64::max);
            self.series
                .inside_fraction
                .push(inside as f64 / nodes as f64);
            self.series.max_depth.push(depth);
        }
        for (series, contact) in self.series.contacts.iter_mut().zip(&self.contacts) {
            series.force.push((contact.impulse / self.sample).into());
            series.peak.push(contact.peak);
            series.over_limit.push(contact.over_limit);
            let fraction = contact.stick / contact.weight;
            series
                .stick_fraction
                .push(if contact.weight > 0.0 { fraction } else { 0.0 });
            series.grip.push(contact.grip / self.sample);
            series.grip_pressure.push(contact.pressure);
        }
        let forces = self.contacts.iter();
        let forces: Vec<(Vector3<f64>, f64)> = forces
            .map(|contact| (contact.impulse / self.sample, contact.grip / self.sample))
            .collect();
        for (probe, values) in self.probes.iter().zip(&mut self.series.probes) {
            values.push(probe.value(&self.scene, &forces));
        }
    }
}

/// When the last event occurs that disturbs a rest \[s\]: a load has grown, a clamp or tool has moved, a clamp is released.
fn last_event(settings: &settings::Scene) -> f64 {
    let bodies = settings.body.iter();
    let times = bodies.flat_map(|body| {
        let clamps = body.clamp.iter().flat_map(|clamp| {
            let moved = clamp.motion.iter().map(|key| key.time);
            moved.chain(clamp.release)
        });
        clamps.chain(body.load.iter().map(|load| load.ramp))
    });
    let tools = settings.tool.iter().flat_map(|tool| &tool.motion);
    let times = times.chain(tools.map(|key| key.time));
    times.fold(0.0, f64::max)
}

#[cfg(test)]
mod tests;
