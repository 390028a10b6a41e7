//! States around the tick that is shown, in bounded memory.

use microsim_host::playback::Moment;
use std::collections::BTreeMap;

/// Most states, and most bytes of them.
const MOST: usize = 1000;
const MOST_BYTES: usize = 128 << 20;

/// States around the one that is shown, by their ticks.
#[derive(Debug, Default)]
pub struct Nearby {
    moments: BTreeMap<u64, Moment>,
    bytes: usize,
}

/// What a state takes in memory at most: blocks that did not change are in the states before as well.
fn size(moment: &Moment) -> usize {
    let blocks = moment.blocks.iter().map(|block| 8 * block.words().len());
    let messages = moment.messages.values().map(|bytes| bytes.len());
    blocks.chain(messages).sum()
}

impl Nearby {
    /// The state after a tick, if it is here.
    pub fn get(&self, tick: u64) -> Option<&Moment> {
        self.moments.get(&tick)
    }

    /// Takes one, and drops those that are the furthest from `shown` where they are too many.
    pub fn insert(&mut self, moment: Moment, shown: u64) {
        self.bytes += size(&moment);
        if let Some(before) = self.moments.insert(moment.tick, moment) {
            self.bytes -= size(&before);
        }
        while self.moments.len() > MOST || (self.bytes > MOST_BYTES && self.moments.len() > 2) {
            let ends = self.moments.keys().next().zip(self.moments.keys().last());
            let Some((first, last)) = ends else { break };
            let furthest = match first.abs_diff(shown) > last.abs_diff(shown) {
                true => *first,
                false => *last,
            };
            if let Some(gone) = self.moments.remove(&furthest) {
                self.bytes -= size(&gone);
            }
        }
    }

    /// The first tick from `tick` on that is not here.
    pub fn missing(&self, tick: u64) -> u64 {
        let mut missing = tick;
        for (there, _) in self.moments.range(tick..) {
            if *there != missing {
                break;
            }
            missing += 1;
        }
        missing
    }

    /// Whether a state can be taken that is computed ahead of what is shown, without another one going that is nearer to it.
    pub fn has_room(&self, ahead: u64, shown: u64) -> bool {
        let is_full = self.moments.len() >= MOST || self.bytes >= MOST_BYTES;
        let first = self.moments.keys().next();
        !is_full || first.is_some_and(|first| first.abs_diff(shown) > ahead.abs_diff(shown))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use microsim_host::playback::Messages;

    fn moment(tick: u64, bytes: usize) -> Moment {
        let messages = Messages::from([(1, vec![0; bytes].into())]);
        Moment {
            tick,
            messages,
            blocks: Vec::new(),
        }
    }

    #[test]
    fn what_is_furthest_from_the_shown_tick_goes_first() {
        let mut nearby = Nearby::default();
        (0..3000).for_each(|tick| nearby.insert(moment(tick, 0), 1000));
        assert_eq!(nearby.moments.len(), MOST);
        assert!(nearby.get(1000).is_some() && nearby.get(700).is_some());
        assert!(nearby.get(0).is_none() && nearby.get(2999).is_none());
        let first = *nearby.moments.keys().next().expect("some");
        let last = *nearby.moments.keys().last().expect("some");
        assert!(last - 1000 <= 1000 - first + 1, "{first} to {last}");
        assert_eq!(nearby.missing(1000), last + 1);
        // Further ahead than any is behind.
        assert!(!nearby.has_room(last + 200, 1000) && nearby.has_room(last + 1, last));
    }

    #[test]
    fn large_states_are_few() {
        let mut nearby = Nearby::default();
        let large = MOST_BYTES / 10;
        (0..50).for_each(|tick| nearby.insert(moment(tick, large), tick));
        assert_eq!(nearby.moments.len(), 10);
        assert!(nearby.bytes <= MOST_BYTES);
        // One that is computed again is there once.
        nearby.insert(moment(49, large), 49);
        assert_eq!((nearby.moments.len(), nearby.missing(45)), (10, 50));
        // However large they are, the last two are there.
        (50..53).for_each(|tick| nearby.insert(moment(tick, 2 * MOST_BYTES), tick));
        assert_eq!(nearby.moments.len(), 2);
        assert!(nearby.get(52).is_some());
    }
}
