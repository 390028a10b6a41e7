//! From motion logs to the metrics of the catalogue.
//!
//! Each log is split at its gaps, and each metric is formed inside segments. Sums (path, angle, movements) add up over
//! segments; fractions, LDLJ and tremor are the mean over the segments that allow them, weighted by their duration.
//! SPARC is that of single movements, as its authors define it, and its mean over them, each of which counts alike, as in
//! their tables: a run of many is otherwise judged by its rhythm. A movement is what the number of movements counts, found
//! in the speed that is smoothed as for the idle fraction, with its feet, if it is whole (`signal::whole_movements`).
//! Several tools are combined alike: sums add up (the working volume too, box by box), means run over the
//! segments of all tools. With more than one tracked tool each metric also stands for every tool by itself.

use microsim_message::ToolPose;
use serde::{Deserialize, Serialize};

use crate::catalogue::{MOTION_METRICS, id};
use crate::metric::{MetricValue, NotApplicable};
use crate::motion::{MotionLog, path_length, rotation_angle};
use crate::parameter::{MetricParameters, ParameterError};
use crate::signal;
use crate::smoothness::{ldlj, sparc};
use crate::tremor::tremor_rms;

/// Relative slack of the sample rate: times rounded to a microsecond must not turn 60 samples a second into fewer.
const RATE_SLACK: f64 = 1e-6;

/// Fraction of v0 by which a speed must vary (root mean square) to be correlated with another: below it is round-off.
const VARIATION_MIN: f64 = 1e-3;

/// Shorter movements have no SPARC \[s\]: the spectrum of a bell of duration T ends near 2/T, which for 0.2 s are the 10 Hz that SPARC
/// looks at.
const SPARC_MOVEMENT_MIN_S: f64 = 0.2;

/// Longer ones have none either \[s\]: motion that does not come to rest for a minute is no discrete movement.
const SPARC_MOVEMENT_MAX_S: f64 = 60.0;

/// One line of a result.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Measurement {
    /// Id of the definition.
    pub metric: String,
    /// The tool that it belongs to; `None` for the run as a whole, which is what limits apply to.
    pub tool: Option<String>,
    /// Value in the SI unit of the definition.
    pub value: MetricValue,
}

/// Measures a run by every metric of [`MOTION_METRICS`], in that order, then tool by tool in the order of `logs` if more than
/// one was tracked.
///
/// `logs`: name and motion of each tool; times of all tools come from one clock. A log without samples belongs to a tool that
/// never came into view and counts as no hand. `duration_s`: running time of the level \[s\]. `shortest_path_m`: the shortest
/// sensible path of all tools together \[m\]; economy exceeds 1 when a run stops early.
pub fn motion_metrics(
    logs: &[(&str, &MotionLog)],
    duration_s: f64,
    shortest_path_m: Option<f64>,
    parameters: &MetricParameters,
) -> Result<Vec<Measurement>, ParameterError> {
    parameters.check()?;
    let tools: Vec<Tool> = logs
        .iter()
        .filter(|(_, log)| !log.samples().is_empty())
        .map(|(name, log)| {
            let segments = log.segments(parameters.gap_s);
            Tool {
                name,
                tally: Tally::of_tool(&segments, parameters),
                segments,
            }
        })
        .collect();
    let mut all = Tally::default();
    for tool in &tools {
        all.merge(&tool.tally);
    }
    let hands = bimanual(&tools, parameters);

    let mut measurements = Vec::new();
    for definition in &MOTION_METRICS {
        let value = match definition.id.as_ref() {
            id::TIME => duration(duration_s),
            id::ECONOMY => economy(shortest_path_m, all.path.total()),
            id::BIMANUAL_FRACTION => hands.fraction.clone(),
            id::SPEED_CORRELATION => hands.correlation.clone(),
            id::PATH_ASYMMETRY => hands.asymmetry.clone(),
            of_one_tool => all.value(of_one_tool),
        };
        measurements.push(Measurement {
            metric: definition.id.to_string(),
            tool: None,
            value: value.into(),
        });
    }
    if tools.len() > 1 {
        for tool in &tools {
            for metric in TOOL_METRICS {
                let value = tool.tally.value(metric).into();
                measurements.push(Measurement {
                    metric: metric.to_string(),
                    tool: Some(tool.name.to_string()),
                    value,
                });
            }
        }
    }
    Ok(measurements)
}

type Outcome = Result<f64, NotApplicable>;

/// The metrics that exist for a tool by itself.
const TOOL_METRICS: [&str; 8] = [
    id::PATH_LENGTH,
    id::ANGULAR_PATH,
    id::WORKING_VOLUME,
    id::IDLE_FRACTION,
    id::MOVEMENTS,
    id::SPARC,
    id::LDLJ,
    id::TREMOR,
];

struct Tool<'a> {
    name: &'a str,
    segments: Vec<&'a [ToolPose]>,
    tally: Tally,
}

/// One metric gathered over segments, weighted by their durations, or over movements, each with weight 1.
#[derive(Debug, Clone, Default)]
struct Pool {
    total: f64,
    weighted: f64,
    duration: f64,
    obstacle: Option<NotApplicable>,
}

impl Pool {
    /// Takes the outcome of a segment of that duration \[s\].
    fn add(&mut self, outcome: Outcome, duration: f64) {
        match outcome {
            Ok(value) => {
                self.total += value;
                self.weighted += value * duration;
                self.duration += duration;
            }
            Err(reason) => self.obstacle = self.obstacle.take().max(Some(reason)),
        }
    }

    fn merge(&mut self, other: &Pool) {
        self.total += other.total;
        self.weighted += other.weighted;
        self.duration += other.duration;
        self.obstacle = self.obstacle.take().max(other.obstacle.clone());
    }

    fn total(&self) -> Outcome {
        if self.duration > 0.0 {
            Ok(self.total)
        } else {
            Err(self.reason())
        }
    }

    fn mean(&self) -> Outcome {
        if self.duration > 0.0 {
            Ok(self.weighted / self.duration)
        } else {
            Err(self.reason())
        }
    }

    fn reason(&self) -> NotApplicable {
        self.obstacle.clone().unwrap_or(NotApplicable::NoSamples)
    }
}

/// What the segments of one tool, or of all tools, add up to.
#[derive(Debug, Clone, Default)]
struct Tally {
    path: Pool,
    angle: Pool,
    volume: Pool,
    idle: Pool,
    movements: Pool,
    sparc: Pool,
    ldlj: Pool,
    tremor: Pool,
}

impl Tally {
    fn of_tool(segments: &[&[ToolPose]], parameters: &MetricParameters) -> Self {
        let mut tally = Tally::default();
        for segment in segments {
            tally.add_segment(segment, parameters);
        }
        // One box around everything; weighted with the joined time, so that a tool seen only in single samples has none.
        let volume = if tally.path.duration > 0.0 {
            Ok(box_volume(segments))
        } else {
            Err(tally.path.reason())
        };
        tally.volume.add(volume, tally.path.duration);
        tally
    }

    fn add_segment(&mut self, segment: &[ToolPose], parameters: &MetricParameters) {
        let [first, .., last] = segment else {
            for pool in [&mut self.path, &mut self.angle] {
                pool.add(Err(NotApplicable::SegmentTooShort), 0.0);
            }
            self.add_even(segment, 0.0, parameters);
            return;
        };
        let duration = last.time - first.time;
        self.path.add(Ok(path_length(segment)), duration);
        let angle = segment
            .windows(2)
            .map(|pair| rotation_angle(pair[0].pose.orientation, pair[1].pose.orientation))
            .sum();
        self.angle.add(Ok(angle), duration);
        self.add_even(segment, duration, parameters);
    }

    /// The metrics that need evenly spaced samples.
    fn add_even(&mut self, segment: &[ToolPose], duration: f64, parameters: &MetricParameters) {
        let rate = parameters.resample_hz;
        let positions = match segment {
            [first, .., last] => signal::resample(segment, first.time, last.time, rate),
            _ => Vec::new(),
        };

        let speed = signal::speed(
            &signal::smooth(&positions, rate, parameters.smoothing_s),
            rate,
        );
        let movements = match speed.is_empty() {
            true => Err(NotApplicable::SegmentTooShort),
            false => Ok(signal::movements(&speed, parameters.movement_speed_m_s).len() as f64),
        };
        self.movements.add(movements, duration);
        let calm = signal::speed(
            &signal::smooth(&positions, rate, parameters.idle_smoothing_s),
            rate,
        );
        let rests = |value: &&f64| **value < parameters.idle_speed_m_s;
        let idle = match calm.is_empty() {
            true => Err(NotApplicable::SegmentTooShort),
            false => Ok(calm.iter().filter(rests).count() as f64 / calm.len() as f64),
        };
        self.idle.add(idle, duration);

        let spectral = spectral_segment(segment.len(), duration, parameters);
        let speed = signal::speed(&positions, rate);
        let moved = spectral.clone().and_then(|()| {
            let moved = speed
                .iter()
                .any(|&value| value >= parameters.idle_speed_m_s);
            if moved {
                Ok(())
            } else {
                Err(NotApplicable::NoMotion)
            }
        });
        let formed = |value: Option<f64>| value.ok_or(NotApplicable::NoMotion);
        self.add_sparc(&moved, &speed, &calm, parameters);
        self.ldlj
            .add(moved.and_then(|()| formed(ldlj(&speed, rate))), duration);
        self.tremor.add(
            spectral.and_then(|()| formed(tremor_rms(&positions, rate))),
            duration,
        );
    }

    /// SPARC of each movement in a segment with that speed and the smoothed one.
    fn add_sparc(
        &mut self,
        moved: &Result<(), NotApplicable>,
        speed: &[f64],
        calm: &[f64],
        parameters: &MetricParameters,
    ) {
        let rate = parameters.resample_hz;
        let lasts = (SPARC_MOVEMENT_MIN_S * rate)..=(SPARC_MOVEMENT_MAX_S * rate);
        let movements = signal::whole_movements(calm, parameters.movement_speed_m_s);
        let mut values = movements
            .into_iter()
            .filter(|movement| lasts.contains(&(movement.len() as f64)))
            .filter_map(|movement| sparc(&speed[movement], rate))
            .peekable();
        let found = moved.clone().and(match values.peek() {
            Some(_) => Ok(()),
            None => Err(NotApplicable::NoMotion),
        });
        match found {
            Ok(()) => values.for_each(|value| self.sparc.add(Ok(value), 1.0)),
            Err(reason) => self.sparc.add(Err(reason), 0.0),
        }
    }

    fn merge(&mut self, other: &Tally) {
        self.path.merge(&other.path);
        self.angle.merge(&other.angle);
        self.volume.merge(&other.volume);
        self.idle.merge(&other.idle);
        self.movements.merge(&other.movements);
        self.sparc.merge(&other.sparc);
        self.ldlj.merge(&other.ldlj);
        self.tremor.merge(&other.tremor);
    }

    /// Value of one of [`TOOL_METRICS`].
    fn value(&self, metric: &str) -> Outcome {
        match metric {
            id::PATH_LENGTH => self.path.total(),
            id::ANGULAR_PATH => self.angle.total(),
            id::WORKING_VOLUME => self.volume.total(),
            id::IDLE_FRACTION => self.idle.mean(),
            id::MOVEMENTS => self.movements.total(),
            id::SPARC => self.sparc.mean(),
            id::LDLJ => self.ldlj.mean(),
            id::TREMOR => self.tremor.mean(),
            _ => Err(NotApplicable::NotMeasured),
        }
    }
}

/// Whether a segment holds enough for a spectrum: long enough, and sampled often enough.
fn spectral_segment(
    samples: usize,
    duration: f64,
    parameters: &MetricParameters,
) -> Result<(), NotApplicable> {
    if duration < parameters.segment_min_s {
        return Err(NotApplicable::SegmentTooShort);
    }
    let rate = samples.saturating_sub(1) as f64 / duration;
    if rate < parameters.sample_rate_min_hz * (1.0 - RATE_SLACK) {
        return Err(NotApplicable::SampleRateTooLow);
    }
    Ok(())
}

/// Volume \[m³\] of the axis-parallel box around all samples.
fn box_volume(segments: &[&[ToolPose]]) -> f64 {
    let mut low = [f64::INFINITY; 3];
    let mut high = [f64::NEG_INFINITY; 3];
    for sample in segments.iter().copied().flatten() {
        for axis in 0..3 {
            low[axis] = low[axis].min(sample.pose.position[axis]);
            high[axis] = high[axis].max(sample.pose.position[axis]);
        }
    }
    (high[0] - low[0]) * (high[1] - low[1]) * (high[2] - low[2])
}

fn duration(seconds: f64) -> Outcome {
    if seconds.is_finite() && seconds > 0.0 {
        Ok(seconds)
    } else {
        Err(NotApplicable::NotMeasured)
    }
}

fn economy(shortest: Option<f64>, path: Outcome) -> Outcome {
    let shortest = shortest
        .filter(|length| length.is_finite() && *length > 0.0)
        .ok_or(NotApplicable::NoShortestPath)?;
    let path = path?;
    if path > 0.0 {
        Ok(shortest / path)
    } else {
        Err(NotApplicable::NoMotion)
    }
}

struct Bimanual {
    fraction: Outcome,
    correlation: Outcome,
    asymmetry: Outcome,
}

/// The metrics of two hands: over the stretches in which both tools were tracked, asymmetry over all of each.
fn bimanual(tools: &[Tool], parameters: &MetricParameters) -> Bimanual {
    let [left, right] = tools else {
        let none = || {
            Err(if tools.is_empty() {
                NotApplicable::NoSamples
            } else {
                NotApplicable::NotTwoHands
            })
        };
        return Bimanual {
            fraction: none(),
            correlation: none(),
            asymmetry: none(),
        };
    };
    let mut fraction = Pool {
        obstacle: Some(NotApplicable::NotTogether),
        ..Pool::default()
    };
    let mut correlation = fraction.clone();
    for a in &left.segments {
        for b in &right.segments {
            let (Some(start), Some(end)) = (common_start(a, b), common_end(a, b)) else {
                continue;
            };
            if end <= start {
                continue;
            }
            let rate = parameters.resample_hz;
            let positions = [a, b].map(|segment| signal::resample(segment, start, end, rate));
            let speeds = |sigma| {
                let smooth = |positions: &Vec<_>| signal::smooth(positions, rate, sigma);
                positions
                    .each_ref()
                    .map(|p| signal::speed(&smooth(p), rate))
            };
            let [calm_a, calm_b] = speeds(parameters.idle_smoothing_s);
            if calm_a.is_empty() {
                continue;
            }
            let v0 = parameters.idle_speed_m_s;
            let both = calm_a
                .iter()
                .zip(&calm_b)
                .filter(|(x, y)| **x >= v0 && **y >= v0)
                .count();
            fraction.add(Ok(both as f64 / calm_a.len() as f64), end - start);
            if end - start >= parameters.segment_min_s {
                let [speed_a, speed_b] = speeds(parameters.smoothing_s);
                let value = signal::correlation(&speed_a, &speed_b, VARIATION_MIN * v0);
                correlation.add(value.ok_or(NotApplicable::NoMotion), end - start);
            }
        }
    }
    let asymmetry = left.tally.path.total().and_then(|left| {
        let right = right.tally.path.total()?;
        let sum = left + right;
        if sum > 0.0 {
            Ok((left - right).abs() / sum)
        } else {
            Err(NotApplicable::NoMotion)
        }
    });
    Bimanual {
        fraction: fraction.mean(),
        correlation: correlation.mean(),
        asymmetry,
    }
}

fn common_start(a: &[ToolPose], b: &[ToolPose]) -> Option<f64> {
    Some(a.first()?.time.max(b.first()?.time))
}

fn common_end(a: &[ToolPose], b: &[ToolPose]) -> Option<f64> {
    Some(a.last()?.time.min(b.last()?.time))
}

#[cfg(test)]
mod tests;
