//! How often scissors were closed on tissue and cut it.

use serde::{Deserialize, Serialize};

/// How far a tool has to open, as a part of its whole opening, to count as opened again.
const REOPENED: f64 = 0.1;

/// Counts bites of scissors: cuts with the blades opened again between them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Bites {
    /// How many so far.
    pub count: u32,
    /// Smallest opening since the last cut.
    least: f64,
    reopened: bool,
}

impl Bites {
    /// In a tick in which the scissors are open so far, from 0 to 1, and have cut or not.
    pub fn update(&mut self, opening: f64, has_cut: bool) {
        self.reopened |= opening > self.least + REOPENED;
        if has_cut && (self.count == 0 || self.reopened) {
            self.count += 1;
        }
        if has_cut {
            (self.least, self.reopened) = (opening, false);
        }
        self.least = self.least.min(opening);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Blades that close, with ticks in which nothing comes apart and a hand that trembles: one bite; opened again and closed: another one.
    #[test]
    fn a_bite_ends_where_the_blades_open() {
        let mut bites = Bites::default();
        let closing = [
            (0.8, false),
            (0.6, true),
            (0.55, false),
            (0.58, false),
            (0.4, true),
            (0.0, false),
        ];
        for (opening, has_cut) in closing {
            bites.update(opening, has_cut);
        }
        assert_eq!(bites.count, 1);
        for (opening, has_cut) in [(0.3, false), (0.1, true), (0.0, true)] {
            bites.update(opening, has_cut);
        }
        assert_eq!(bites.count, 2);
    }
}
