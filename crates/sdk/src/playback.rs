//! Samples that are known beforehand, published as simulated time goes by: what sources of files have in common.

use crate::fault::Fault;
use crate::tick::Tick;
use microsim_message::{InputEnd, InputSample, decode_bytes, encode};

/// Plays samples, each at the time at which it is due: a source calls [`Playback::play`] in `process`, and takes its state from here.
///
/// ```
/// use microsim_sdk::Playback;
/// use microsim_sdk::message::{InputSample, Pose};
///
/// let sample = |device_time| InputSample {
///     device: "stylus".into(),
///     device_time,
///     visible: true,
///     pose: Pose::default(),
///     opening: None,
/// };
/// // The device's clock may begin anywhere: the first sample is due at the start.
/// let playback = Playback::by_device_time("my-source", vec![sample(100.0), sample(100.01)]);
/// let mut again = playback.clone();
/// again.restore(&playback.save())?;
/// assert_eq!(again, playback);
/// # Ok::<(), microsim_sdk::Fault>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Playback {
    source: String,
    samples: Vec<(f64, InputSample)>,
    next: usize,
    ended: bool,
}

impl Playback {
    /// A playback by the plugin `source` of samples with the simulated time at which each is due \[s\], in that order.
    pub fn new(source: &str, samples: Vec<(f64, InputSample)>) -> Self {
        Self {
            source: source.into(),
            samples,
            next: 0,
            ended: false,
        }
    }

    /// A playback of samples by their device time, the first one due at the start.
    pub fn by_device_time(source: &str, samples: Vec<InputSample>) -> Self {
        let start = samples.first().map_or(0.0, |s| s.device_time);
        let due = |sample: InputSample| (sample.device_time - start, sample);
        Self::new(source, samples.into_iter().map(due).collect())
    }

    /// Publishes what has become due by the end of the tick, and the end of input once after the last sample.
    pub fn play(&mut self, tick: &mut Tick<'_>) {
        while let Some((due, sample)) = self.samples.get(self.next) {
            if *due > tick.time() {
                return;
            }
            tick.publish(sample);
            self.next += 1;
        }
        if !self.ended {
            self.ended = true;
            let source = self.source.clone();
            tick.publish(&InputEnd { source });
        }
    }

    /// Back to the first sample.
    pub fn reset(&mut self) {
        (self.next, self.ended) = (0, false);
    }

    /// All that changes.
    pub fn save(&self) -> Vec<u8> {
        encode(&(self.next, self.ended))
    }

    /// The opposite of [`Playback::save`], for the same samples.
    pub fn restore(&mut self, state: &[u8]) -> Result<(), Fault> {
        let (next, ended) = decode_bytes(state)?;
        if next > self.samples.len() {
            return Err(Fault::new("the saved state belongs to a longer recording"));
        }
        (self.next, self.ended) = (next, ended);
        Ok(())
    }
}
