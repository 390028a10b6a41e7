//! Cuts booked to the marks that they belong to: how far from a mark and how askew tissue was cut, and what was cut or tore
//! elsewhere. Everything is measured in the tissue at rest, so that stretching it does not make a cut better.

use super::{dot, length};
use microsim_message::TissueCut;
use serde::{Deserialize, Serialize};

/// A line on tissue along which it is to be cut.
#[derive(Clone, Debug, PartialEq)]
pub struct MarkLine {
    /// Its middle, at rest \[m\].
    pub middle: [f64; 3],
    /// Its direction, of length 1.
    pub along: [f64; 3],
}

/// What was cut at a mark: the area \[m²\], and times the distance \[m³\] and the sine of the angle \[m²\].
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Account {
    area: f64,
    distance: f64,
    sine: f64,
}

/// All cuts of a body so far.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CutLog {
    marks: Vec<Account>,
    /// Area that tools opened away from all marks \[m²\].
    pub stray: f64,
    /// Area that tore by itself \[m²\].
    pub torn: f64,
    /// Area that tools opened while the tissue was held \[m²\].
    pub steadied: f64,
}

/// Where a cut belongs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Booking {
    /// To a mark; `first` if nothing had been cut there before.
    Mark {
        /// Its index.
        index: usize,
        /// Whether it is the first cut there.
        first: bool,
    },
    /// To none.
    Stray,
    /// It tore by itself.
    Tear,
    /// A message without an opening.
    Nothing,
}

impl CutLog {
    /// Books a cut to the nearest of the marks, if it is within `reach` \[m\]. `steadied` tells whether the tissue was held.
    pub fn book(
        &mut self,
        cut: &TissueCut,
        marks: &[MarkLine],
        reach: f64,
        steadied: bool,
    ) -> Booking {
        self.marks.resize(marks.len(), Account::default());
        if cut.area <= 0.0 {
            return Booking::Nothing;
        }
        if cut.tool.is_empty() {
            self.torn += cut.area;
            return Booking::Tear;
        }
        self.steadied += if steadied { cut.area } else { 0.0 };
        let offset = |mark: &MarkLine| [0, 1, 2].map(|k| cut.rest_centroid[k] - mark.middle[k]);
        let away = |mark: &MarkLine| {
            let offset = offset(mark);
            let along = dot(offset, mark.along);
            length([0, 1, 2].map(|k| offset[k] - along * mark.along[k]))
        };
        let all = marks.iter().enumerate();
        let nearest = all.min_by(|(_, a), (_, b)| away(a).total_cmp(&away(b)));
        let Some((index, mark)) = nearest.filter(|(_, mark)| away(mark) <= reach) else {
            self.stray += cut.area;
            return Booking::Stray;
        };
        let account = &mut self.marks[index];
        let first = account.area == 0.0;
        account.area += cut.area;
        account.distance += cut.area * dot(offset(mark), cut.rest_normal).abs();
        account.sine += cut.area * dot(mark.along, cut.rest_normal).abs();
        Booking::Mark { index, first }
    }

    /// Largest over the marks: the distance of a mark's middle from the planes of the cuts booked to it, mean over their area
    /// \[m\]. `None` if there are none.
    pub fn distance(&self) -> Option<f64> {
        self.largest(|account| account.distance)
    }

    /// Largest over the marks: the angle between a mark's line and the planes of the cuts booked to it, of the mean sine over
    /// their area \[rad\]. `None` if there are none.
    pub fn angle(&self) -> Option<f64> {
        self.largest(|account| account.sine)
            .map(|sine| libm::asin(sine.min(1.0)))
    }

    /// Share of the area opened by tools that was opened while the tissue was held. `None` if nothing was cut.
    pub fn steadied_share(&self) -> Option<f64> {
        let at_marks: f64 = self.marks.iter().map(|account| account.area).sum();
        let all = at_marks + self.stray;
        (all > 0.0).then(|| self.steadied / all)
    }

    fn largest(&self, moment: impl Fn(&Account) -> f64) -> Option<f64> {
        let cut = self.marks.iter().filter(|account| account.area > 0.0);
        cut.map(|account| moment(account) / account.area)
            .max_by(f64::total_cmp)
    }
}
