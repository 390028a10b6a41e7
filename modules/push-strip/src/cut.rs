//! The task `cut`: where the strip was cut, what has come off, and whether it lies in the tray.

use crate::patch::{node_of, position};
use crate::task::distance;
use crate::{MARK, Object};
use microsim_sdk::message::TissueCut;
use microsim_sdk::{BlockView, Fault, Tray};
use serde::{Deserialize, Serialize};

/// The rigid thing of the level that is the tray.
pub(crate) const TRAY: &str = "tray";

/// The object of the level that holds the strip.
const CLAMP: &str = "clamp";

/// Ticks without a grip after which a piece has been dropped.
const DROPPED: u32 = 12;

/// What a level asks for.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Site {
    /// Where to cut, at rest \[m\].
    mark: [f64; 3],
    /// Where the strip is held \[m\].
    clamp: [f64; 3],
    tray: Tray,
}

impl Site {
    /// From the objects of a level and its tray.
    pub fn new(objects: &[Object], tray: Tray) -> Result<Self, Fault> {
        let named = |name: &str| {
            let object = objects.iter().find(|object| object.name.starts_with(name));
            object.ok_or_else(|| {
                Fault::new(format!(
                    "the task `cut` needs an object whose name starts with \"{name}\""
                ))
            })
        };
        Ok(Self {
            mark: named(MARK)?.position,
            clamp: named(CLAMP)?.position,
            tray,
        })
    }
}

/// How far the trainee is.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Progress {
    /// Ids of the nodes nearest to the clamp and farthest from it at the start: what has come off is the piece of the second.
    ends: Option<[u32; 2]>,
    /// Area of all cuts so far \[m²\], and times its distance from the mark \[m³\].
    cut: [f64; 2],
    /// Whether the free end has come off.
    pub off: bool,
    /// Whether it is in the tray.
    pub inside: bool,
    /// Number of ticks for which nobody has held it, outside the tray.
    loose: u32,
}

impl Progress {
    /// A cut of the strip. What is done to the piece once it is off does not count.
    pub fn hear(&mut self, cut: &TissueCut, site: &Site) {
        if self.off {
            return;
        }
        let [x, y, z] = [0, 1, 2].map(|k| {
            let along = site.mark[k] - cut.rest_centroid[k];
            along * cut.rest_normal[k]
        });
        self.cut[0] += cut.area;
        self.cut[1] += cut.area * (x + y + z).abs();
    }

    /// Mean distance of the mark from the planes of the cuts \[m\]; `None` if there are none.
    pub fn cut_distance(&self) -> Option<f64> {
        let [area, moment] = self.cut;
        (area > 0.0).then(|| moment / area)
    }

    /// Whether the piece counts as dropped in this tick; `held` tells whether it is in a grip. A grip that trembles for a tick has not let go.
    pub fn dropped(&mut self, held: bool) -> bool {
        let loose = self.off && !self.inside && !held;
        self.loose = if loose { self.loose + 1 } else { 0 };
        self.loose == DROPPED
    }

    /// Looks where the pieces are.
    pub fn look(&mut self, block: &BlockView<'_>, site: &Site) -> Option<()> {
        let (ids, positions) = (block.u32s("node_id")?, block.f64s("position")?);
        let pieces = block.u32s("piece")?;
        let places = || (0..ids.len()).map(|node| position(positions, node));
        if self.ends.is_none() {
            let away = |node: &usize| distance(position(positions, *node), site.clamp);
            let nodes = || 0..ids.len();
            let near = nodes().min_by(|a, b| away(a).total_cmp(&away(b)))?;
            let far = nodes().max_by(|a, b| away(a).total_cmp(&away(b)))?;
            self.ends = Some([ids[near], ids[far]]);
        }
        let [held, free] = self.ends?.map(|id| node_of(ids, id));
        let (held, free) = (pieces[held?], pieces[free?]);
        self.off = held != free;
        let of_it = places().zip(pieces).filter(|(_, piece)| **piece == free);
        let (mut sum, mut count) = ([0.0; 3], 0_u32);
        for (place, _) in of_it {
            sum = [0, 1, 2].map(|k| sum[k] + place[k]);
            count += 1;
        }
        self.inside = self.off && site.tray.contains(sum.map(|c| c / f64::from(count)));
        Some(())
    }
}
