//! The task `cut`: where the strip was cut, what has come off, and whether it lies in the tray.

use microsim_sdk::tissue::{CutLog, Delivery, MarkLine, PieceView, Probes};
use microsim_sdk::{BlockView, Fault, Object, Tray};
use serde::{Deserialize, Serialize};

/// The obstacle of the level that is the tray.
pub(crate) const TRAY: &str = "tray";

/// The object of the level that holds the strip.
const CLAMP: &str = "clamp";

/// What a level asks for.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Site {
    /// Where to cut, at rest.
    pub mark: MarkLine,
    /// Where the strip is held \[m\].
    clamp: [f64; 3],
    pub tray: Tray,
}

impl Site {
    /// From a mark and the other objects of a level, and its tray.
    pub fn new(mark: &Object, objects: &[Object], tray: Tray) -> Result<Self, Fault> {
        let clamp = objects.iter().find(|object| object.name == CLAMP);
        let clamp = clamp
            .ok_or_else(|| Fault::new(format!("the task `cut` needs an object \"{CLAMP}\"")))?;
        Ok(Self {
            mark: MarkLine::new(mark)?,
            clamp: clamp.position,
            tray,
        })
    }

    /// The clamp, and a place as far on the other side of the mark \[m\].
    fn ends(&self) -> [[f64; 3]; 2] {
        let beyond = [0, 1, 2].map(|k| 2.0 * self.mark.middle[k] - self.clamp[k]);
        [self.clamp, beyond]
    }
}

/// How far the trainee is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Progress {
    /// A node at the clamp and one of the free end: what has come off is the piece of the second.
    probes: Option<Probes>,
    pub cuts: CutLog,
    pub delivery: Delivery,
    /// Whether the free end has come off.
    pub off: bool,
}

impl Progress {
    /// Before the first tick; the piece has to lie in the tray for `dwell` \[s\].
    pub fn new(dwell: f64) -> Result<Self, Fault> {
        Ok(Self {
            probes: None,
            cuts: CutLog::default(),
            delivery: Delivery::new(dwell)?,
            off: false,
        })
    }

    /// Where the free end is, once it has come off.
    pub fn piece(&mut self, block: &BlockView<'_>, site: &Site) -> Option<PieceView> {
        if self.probes.is_none() {
            self.probes = Probes::nearest(&site.ends(), block);
        }
        let probes = self.probes.as_ref()?;
        self.off = probes.apart(0, 1, block)?;
        probes.piece(1, block).filter(|_| self.off)
    }
}
