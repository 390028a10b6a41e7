//! The motion of one tool as it was measured: an append-only log of samples, split into segments where tracking was lost.
//!
//! A gap is a gap: nothing in this crate joins the sample before it to the sample after it. The log is written by the
//! module once per tick and belongs to its saved state, hence the plain byte form.

use microsim_message::{Pose, ToolPose};
use nalgebra::Vector3;
use std::fmt;

/// Why a sample was refused. The log is unchanged.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum MotionError {
    /// The named field holds NaN or infinity.
    NotFinite(&'static str),
    /// The sample is not later than the last one.
    TimeNotIncreasing {
        /// Time of the last sample \[s\].
        last: f64,
        /// Time of the refused sample \[s\].
        next: f64,
    },
    /// The quaternion has no direction (zero, or so long that its square overflows).
    NoOrientation,
    /// The opening lies outside 0..1.
    OpeningOutOfRange(f64),
}

impl fmt::Display for MotionError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            MotionError::NotFinite(field) => {
                write!(f, "motion sample: {field} is not a finite number")
            }
            MotionError::TimeNotIncreasing { last, next } => {
                write!(
                    f,
                    "motion sample: time {next} s does not come after {last} s"
                )
            }
            MotionError::NoOrientation => {
                write!(f, "motion sample: the quaternion has no direction")
            }
            MotionError::OpeningOutOfRange(opening) => {
                write!(f, "motion sample: opening {opening} lies outside 0..1")
            }
        }
    }
}

impl std::error::Error for MotionError {}

/// Why bytes are not a motion log.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum MotionBytesError {
    /// The bytes are not as long as their header states.
    Length {
        /// Length by the header, `None` when the header itself is cut or absurd.
        expected: Option<usize>,
        /// Length found.
        found: usize,
    },
    /// A flag, or a gap mark, has a value that `to_bytes` never writes.
    Mark,
    /// A sample that `push` would refuse.
    Sample {
        /// Its index.
        index: usize,
        /// The reason.
        error: MotionError,
    },
}

impl fmt::Display for MotionBytesError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            MotionBytesError::Length {
                expected: Some(expected),
                found,
            } => {
                write!(f, "motion log: {found} bytes found, {expected} expected")
            }
            MotionBytesError::Length {
                expected: None,
                found,
            } => {
                write!(f, "motion log: the header in {found} bytes cannot be read")
            }
            MotionBytesError::Mark => write!(f, "motion log: a flag or gap mark is invalid"),
            MotionBytesError::Sample { index, error } => {
                write!(f, "motion log: sample {index}: {error}")
            }
        }
    }
}

impl std::error::Error for MotionBytesError {}

/// Everything that one tool did, in order of device time.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct MotionLog {
    samples: Vec<ToolPose>,
    /// Indices of samples before which tracking was marked as lost; strictly increasing, each in 1..samples.len().
    breaks: Vec<usize>,
    /// The next sample starts a new segment.
    gap_pending: bool,
    /// Over all samples so far and where segments were broken.
    digest: RunningDigest,
}

/// A digest that grows with the log, so that its cost per sample does not depend on how long the log is.
#[derive(Debug, Clone, Default)]
struct RunningDigest(blake3::Hasher);

impl PartialEq for RunningDigest {
    fn eq(&self, other: &Self) -> bool {
        self.0.finalize() == other.0.finalize()
    }
}

/// Sample count, break count, pending flag.
const HEADER_BYTES: usize = 8 + 8 + 1;
/// Nine numbers and a flag.
const SAMPLE_BYTES: usize = 9 * 8 + 1;
/// The flag after each sample: that the last of its numbers is an opening.
const HAS_OPENING: u8 = 1;
const BREAK_BYTES: usize = 8;

impl MotionLog {
    /// An empty log.
    pub fn new() -> Self {
        Self::default()
    }

    /// Appends a sample, tip in the field frame; its quaternion need not be of unit length, and must not be zero.
    pub fn push(&mut self, sample: ToolPose) -> Result<(), MotionError> {
        check(&sample, self.samples.last())?;
        let starts_segment = std::mem::take(&mut self.gap_pending);
        if starts_segment {
            self.breaks.push(self.samples.len());
        }
        self.add(sample, starts_segment);
        Ok(())
    }

    fn add(&mut self, sample: ToolPose, starts_segment: bool) {
        let digest = &mut self.digest.0;
        digest.update(&[u8::from(starts_segment)]);
        digest.update(&sample_bytes(&sample));
        self.samples.push(sample);
    }

    /// A digest of the whole log: equal for equal logs. Unlike [`to_bytes`](Self::to_bytes) it costs the same however long the log is.
    pub fn digest(&self) -> [u8; 33] {
        let mut digest = [u8::from(self.gap_pending); 33];
        digest[1..].copy_from_slice(self.digest.0.finalize().as_bytes());
        digest
    }

    /// Marks that the tool was not tracked (or the level paused) since the last sample: the next one starts a new segment,
    /// however close its time. Without an earlier sample there is nothing to separate from, and nothing happens.
    pub fn mark_gap(&mut self) {
        self.gap_pending = !self.samples.is_empty();
    }

    /// All samples.
    pub fn samples(&self) -> &[ToolPose] {
        &self.samples
    }

    /// The contiguous stretches: split wherever two samples lie more than `gap` \[s\] apart, and at every marked gap.
    pub fn segments(&self, gap: f64) -> Vec<&[ToolPose]> {
        let mut segments = Vec::new();
        let mut breaks = self.breaks.iter().copied().peekable();
        let mut start = 0;
        for index in 1..self.samples.len() {
            let marked = breaks.next_if_eq(&index).is_some();
            if marked || self.samples[index].time - self.samples[index - 1].time > gap {
                segments.push(&self.samples[start..index]);
                start = index;
            }
        }
        if start < self.samples.len() {
            segments.push(&self.samples[start..]);
        }
        segments
    }

    /// The log as bytes, little-endian: sample count u64, break count u64, pending flag u8; per sample time, position,
    /// orientation, opening (9 f64) and a u8 of 1; the breaks as u64.
    pub fn to_bytes(&self) -> Vec<u8> {
        let length =
            HEADER_BYTES + self.samples.len() * SAMPLE_BYTES + self.breaks.len() * BREAK_BYTES;
        let mut bytes = Vec::with_capacity(length);
        bytes.extend((self.samples.len() as u64).to_le_bytes());
        bytes.extend((self.breaks.len() as u64).to_le_bytes());
        bytes.push(u8::from(self.gap_pending));
        for sample in &self.samples {
            bytes.extend(sample_bytes(sample));
        }
        for &index in &self.breaks {
            bytes.extend((index as u64).to_le_bytes());
        }
        bytes
    }

    /// The log that [`to_bytes`](Self::to_bytes) wrote. Accepts nothing else: the bytes of an accepted log are the same again.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, MotionBytesError> {
        let mut reader = Reader { bytes };
        let header = (reader.take_u64(), reader.take_u64(), reader.take_u8());
        let (Some(sample_count), Some(break_count), Some(pending)) = header else {
            return Err(MotionBytesError::Length {
                expected: None,
                found: bytes.len(),
            });
        };
        let expected = length_of(sample_count, break_count);
        if expected != Some(bytes.len()) {
            return Err(MotionBytesError::Length {
                expected,
                found: bytes.len(),
            });
        }

        // From here on the length is right, so that every read succeeds; a cut is still an error, never a panic.
        let cut = MotionBytesError::Length {
            expected,
            found: bytes.len(),
        };
        let mut log = MotionLog {
            samples: Vec::with_capacity(sample_count as usize),
            ..Self::default()
        };
        for index in 0..sample_count as usize {
            let mut values = [0.0; 9];
            for value in &mut values {
                *value = f64::from_bits(reader.take_u64().ok_or(cut)?);
            }
            let [time, x, y, z, qx, qy, qz, qw, opening] = values;
            if reader.take_u8().ok_or(cut)? != HAS_OPENING {
                return Err(MotionBytesError::Mark);
            }
            let sample = ToolPose {
                pose: Pose {
                    position: [x, y, z],
                    orientation: [qx, qy, qz, qw],
                },
                opening,
                time,
            };
            check(&sample, log.samples.last())
                .map_err(|error| MotionBytesError::Sample { index, error })?;
            log.samples.push(sample);
        }
        let samples = std::mem::take(&mut log.samples);
        let mut previous = 0;
        for _ in 0..break_count {
            let index = reader.take_u64().ok_or(cut)?;
            if index <= previous || index >= sample_count {
                return Err(MotionBytesError::Mark);
            }
            log.breaks.push(index as usize);
            previous = index;
        }
        let mut breaks = log.breaks.clone().into_iter().peekable();
        for (index, sample) in samples.into_iter().enumerate() {
            let starts_segment = breaks.next_if_eq(&index).is_some();
            log.add(sample, starts_segment);
        }
        log.gap_pending = match pending {
            0 => false,
            1 if sample_count > 0 => true,
            _ => return Err(MotionBytesError::Mark),
        };
        Ok(log)
    }
}

/// A sample in [`MotionLog::to_bytes`].
fn sample_bytes(sample: &ToolPose) -> [u8; SAMPLE_BYTES] {
    let [x, y, z] = sample.pose.position;
    let [qx, qy, qz, qw] = sample.pose.orientation;
    let values = [sample.time, x, y, z, qx, qy, qz, qw, sample.opening];
    let mut bytes = [HAS_OPENING; SAMPLE_BYTES];
    for (bytes, value) in bytes.chunks_exact_mut(8).zip(values) {
        bytes.copy_from_slice(&value.to_le_bytes());
    }
    bytes
}

/// Length of a contiguous stretch of samples \[m\]: Σ|p_{k+1} − p_k| (DOMAIN 2).
pub fn path_length(segment: &[ToolPose]) -> f64 {
    segment
        .windows(2)
        .map(|pair| distance(pair[0].pose.position, pair[1].pose.position))
        .sum()
}

/// Angle \[rad\], 0..π, of the rotation between two orientations: 2·acos|a·b| of the unit quaternions.
///
/// Computed as 4·atan2(|a ∓ b|, |a ± b|), the same angle without the cancellation of acos near 1: with quaternions
/// rounded to 10⁻⁶, as recordings have them, acos would turn every sample of a tool at rest into up to 10⁻³ rad.
pub fn rotation_angle(a: [f64; 4], b: [f64; 4]) -> f64 {
    let (a, b) = (unit(a), unit(b));
    let mut difference = 0.0;
    let mut sum = 0.0;
    for axis in 0..4 {
        difference += (a[axis] - b[axis]) * (a[axis] - b[axis]);
        sum += (a[axis] + b[axis]) * (a[axis] + b[axis]);
    }
    // q and −q are the same orientation: the nearer of the two is meant.
    4.0 * libm::atan2(difference.min(sum).sqrt(), difference.max(sum).sqrt())
}

pub(crate) fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (Vector3::from(a) - Vector3::from(b)).norm()
}

fn norm_squared(q: [f64; 4]) -> f64 {
    q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]
}

fn unit(q: [f64; 4]) -> [f64; 4] {
    let norm = norm_squared(q).sqrt();
    q.map(|component| component / norm)
}

fn check(sample: &ToolPose, last: Option<&ToolPose>) -> Result<(), MotionError> {
    if !sample.time.is_finite() {
        return Err(MotionError::NotFinite("time"));
    }
    if !sample.pose.position.iter().all(|value| value.is_finite()) {
        return Err(MotionError::NotFinite("position"));
    }
    if !sample
        .pose
        .orientation
        .iter()
        .all(|value| value.is_finite())
    {
        return Err(MotionError::NotFinite("orientation"));
    }
    if !norm_squared(sample.pose.orientation).is_normal() {
        return Err(MotionError::NoOrientation);
    }
    if sample.opening.is_nan() {
        return Err(MotionError::NotFinite("opening"));
    }
    if !(0.0..=1.0).contains(&sample.opening) {
        return Err(MotionError::OpeningOutOfRange(sample.opening));
    }
    match last {
        Some(last) if sample.time <= last.time => Err(MotionError::TimeNotIncreasing {
            last: last.time,
            next: sample.time,
        }),
        _ => Ok(()),
    }
}

fn length_of(sample_count: u64, break_count: u64) -> Option<usize> {
    let samples = usize::try_from(sample_count)
        .ok()?
        .checked_mul(SAMPLE_BYTES)?;
    let breaks = usize::try_from(break_count)
        .ok()?
        .checked_mul(BREAK_BYTES)?;
    HEADER_BYTES.checked_add(samples)?.checked_add(breaks)
}

struct Reader<'a> {
    bytes: &'a [u8],
}

impl Reader<'_> {
    fn take_u64(&mut self) -> Option<u64> {
        let (head, rest) = self.bytes.split_first_chunk()?;
        self.bytes = rest;
        Some(u64::from_le_bytes(*head))
    }

    fn take_u8(&mut self) -> Option<u8> {
        let (&head, rest) = self.bytes.split_first()?;
        self.bytes = rest;
        Some(head)
    }
}

#[cfg(test)]
pub(crate) mod tests;
