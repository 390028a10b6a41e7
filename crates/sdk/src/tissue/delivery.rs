//! A piece that has come off, is carried to a tray and let go there.

use super::{Contacts, PieceView, Releases};
use crate::fault::Fault;
use crate::tray::Tray;
use microsim_training::{Dwell, DwellState};
use serde::{Deserialize, Serialize};

/// How far a piece has got towards a tray.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Delivery {
    /// How often it was let go where it does not fall into the tray.
    pub drops: Releases,
    /// Whether a tool has had it since it came off, and since it was last dropped.
    carried: bool,
    dwell: Dwell,
}

/// What a tick has brought.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Delivered {
    /// Whether the piece counts as dropped from this tick on.
    pub dropped: bool,
    /// Whether it lies in the tray and nobody holds it.
    pub lies: bool,
    /// Whether it has lain there for long enough.
    pub done: bool,
}

impl Delivery {
    /// Of a piece that has to lie in the tray for `dwell` \[s\].
    pub fn new(dwell: f64) -> Result<Self, Fault> {
        Ok(Self {
            drops: Releases::default(),
            carried: false,
            dwell: Dwell::new(dwell)?,
        })
    }

    /// Where the piece is at `time` \[s\], in every tick from when it is off until it is delivered. What is let go in the tray or
    /// straight above it is let go where it belongs; what was dropped elsewhere, or never gripped, and
    /// was pushed there or fell was not delivered.
    pub fn watch(
        &mut self,
        time: f64,
        piece: &PieceView,
        contacts: &Contacts,
        tray: &Tray,
    ) -> Delivered {
        let held = contacts.holds(piece.number);
        let dropped = self
            .drops
            .watch(time, !held && !tray.is_above(piece.centre));
        self.carried = held || (self.carried && !dropped);
        let lies = self.carried
            && !held
            && tray.contains(piece.centre)
            && contacts.is_on(tray.name(), piece.number);
        Delivered {
            dropped,
            lies,
            done: self.dwell.update(time, lies) == DwellState::Complete,
        }
    }
}
