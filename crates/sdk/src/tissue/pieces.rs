//! Which parts of a body still hang together, and where a piece lies.

use super::{distance, place_of, row_of};
use microsim_bus::BlockView;
use serde::{Deserialize, Serialize};

/// Nodes that distinguish pieces: one in each part that may come off.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Probes {
    nodes: Vec<u32>,
}

/// A piece.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PieceView {
    /// Its number in the snapshot.
    pub number: u32,
    /// Mean place of its nodes \[m\].
    pub centre: [f64; 3],
}

impl Probes {
    /// The nodes nearest to some places \[m\], as the tissue lies now. `None` if the snapshot has no nodes.
    pub fn nearest(places: &[[f64; 3]], block: &BlockView<'_>) -> Option<Self> {
        let (ids, positions) = (block.u32s("node_id")?, block.f64s("position")?);
        let nearest = |place: &[f64; 3]| {
            let away = |row: &usize| distance(place_of(positions, *row), *place);
            let row = (0..ids.len()).min_by(|a, b| away(a).total_cmp(&away(b)))?;
            Some(ids[row])
        };
        let nodes: Option<Vec<u32>> = places.iter().map(nearest).collect();
        Some(Self { nodes: nodes? })
    }

    /// Whether two probes lie in different pieces. `None` if one is not there any more.
    pub fn apart(&self, a: usize, b: usize, block: &BlockView<'_>) -> Option<bool> {
        Some(self.number(a, block)? != self.number(b, block)?)
    }

    /// The number of the piece of a probe. `None` if the probe is not there any more.
    pub(crate) fn number(&self, probe: usize, block: &BlockView<'_>) -> Option<u32> {
        let row = row_of(block.u32s("node_id")?, *self.nodes.get(probe)?)?;
        block.u32s("piece")?.get(row).copied()
    }

    /// The piece of a probe. `None` if the probe is not there any more.
    pub fn piece(&self, probe: usize, block: &BlockView<'_>) -> Option<PieceView> {
        let number = self.number(probe, block)?;
        let (positions, pieces) = (block.f64s("position")?, block.u32s("piece")?);
        let (mut sum, mut count) = ([0.0; 3], 0_u32);
        for (row, _) in pieces.iter().enumerate().filter(|(_, p)| **p == number) {
            let place = place_of(positions, row);
            sum = [0, 1, 2].map(|k| sum[k] + place[k]);
            count += 1;
        }
        Some(PieceView {
            number,
            centre: sum.map(|c| c / f64::from(count)),
        })
    }
}
