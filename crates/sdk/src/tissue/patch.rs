//! A patch of tissue that belongs to a mark, by stable node ids, and where it is now.

use super::{place_of, row_of};
use microsim_bus::BlockView;
use serde::{Deserialize, Serialize};

/// Nodes within this fraction of the tissue's thickness from its top belong to the upper surface.
const TOP_LAYER: f64 = 0.25;

/// The upper surface of the tissue around a mark.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Patch {
    nodes: Vec<u32>,
    /// Reference height of each node \[m\].
    heights: Vec<f64>,
    /// From the mean place of the nodes to the mark \[m\].
    offset: [f64; 3],
}

/// Where a patch is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PatchPlace {
    /// Depth of the deepest of its nodes below their reference heights \[m\].
    pub depth: f64,
    /// Place of its mark, carried along by its mean node \[m\].
    pub place: [f64; 3],
}

impl Patch {
    /// The nodes of the upper surface within `radius` \[m\] of `mark`, seen from above, as the tissue lies now. `None` if
    /// there are none.
    pub fn around(mark: [f64; 3], radius: f64, block: &BlockView<'_>) -> Option<Self> {
        let (ids, positions) = (block.u32s("node_id")?, block.f64s("position")?);
        let near = |p: &[f64; 3]| {
            let (x, y) = (p[0] - mark[0], p[1] - mark[1]);
            x * x + y * y <= radius * radius
        };
        let places = (0..ids.len()).map(|row| place_of(positions, row));
        let all: Vec<(u32, [f64; 3])> = ids
            .iter()
            .copied()
            .zip(places)
            .filter(|(_, p)| near(p))
            .collect();
        let heights = all.iter().map(|(_, p)| p[2]);
        let top = heights.clone().fold(f64::NEG_INFINITY, f64::max);
        let bottom = heights.fold(f64::INFINITY, f64::min);
        let highest = all
            .into_iter()
            .filter(|(_, p)| top - p[2] <= TOP_LAYER * (top - bottom));
        let (nodes, heights) = highest.map(|(id, p)| (id, p[2])).unzip();
        let mut patch = Self {
            nodes,
            heights,
            offset: [0.0; 3],
        };
        let mean = patch.now(block)?.place;
        patch.offset = [0, 1, 2].map(|k| mark[k] - mean[k]);
        Some(patch)
    }

    /// Depth counts from where the tissue lies now.
    pub fn set_reference(&mut self, block: &BlockView<'_>) -> Option<()> {
        let (ids, positions) = (block.u32s("node_id")?, block.f64s("position")?);
        for (id, height) in self.nodes.iter().zip(&mut self.heights) {
            if let Some(row) = row_of(ids, *id) {
                *height = place_of(positions, row)[2];
            }
        }
        Some(())
    }

    /// Where it is. `None` if none of its nodes is left.
    pub fn now(&self, block: &BlockView<'_>) -> Option<PatchPlace> {
        let (ids, positions) = (block.u32s("node_id")?, block.f64s("position")?);
        let mut depth = f64::NEG_INFINITY;
        let (mut sum, mut found) = ([0.0; 3], 0_u32);
        for (id, height) in self.nodes.iter().zip(&self.heights) {
            let Some(row) = row_of(ids, *id) else {
                continue;
            };
            let p = place_of(positions, row);
            depth = depth.max(height - p[2]);
            sum = [0, 1, 2].map(|k| sum[k] + p[k]);
            found += 1;
        }
        let place = [0, 1, 2].map(|k| sum[k] / f64::from(found) + self.offset[k]);
        (found > 0).then_some(PatchPlace { depth, place })
    }
}
