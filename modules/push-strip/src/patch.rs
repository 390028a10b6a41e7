//! The tissue around a mark, by stable node ids, and where it is now.

use microsim_sdk::BlockView;
use serde::{Deserialize, Serialize};

/// Nodes within this share of the tissue's thickness from its top belong to the upper surface.
const TOP_LAYER: f64 = 0.25;

/// The tissue that belongs to a mark.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Patch {
    pub nodes: Vec<u32>,
    /// Height of each node before the first touch \[m\].
    pub heights: Vec<f64>,
}

/// Row of the node with an id in the arrays of a snapshot. Ids are stable, but not in order: a cut may move nodes to other rows.
pub(crate) fn node_of(ids: &[u32], id: u32) -> Option<usize> {
    ids.iter().position(|other| *other == id)
}

/// Place of a node of a snapshot \[m\].
pub(crate) fn position(positions: &[f64], node: usize) -> [f64; 3] {
    [
        positions[3 * node],
        positions[3 * node + 1],
        positions[3 * node + 2],
    ]
}

impl Patch {
    /// The nodes of the upper surface within `radius` \[m\] of `mark`, seen from above, as the tissue lies now.
    pub fn around(mark: [f64; 3], radius: f64, block: &BlockView<'_>) -> Option<Self> {
        let (ids, positions) = (block.u32s("node_id")?, block.f64s("position")?);
        let near = |p: [f64; 3]| {
            let (x, y) = (p[0] - mark[0], p[1] - mark[1]);
            x * x + y * y <= radius * radius
        };
        let all: Vec<(u32, [f64; 3])> = ids
            .iter()
            .enumerate()
            .map(|(i, id)| (*id, position(positions, i)))
            .filter(|(_, p)| near(*p))
            .collect();
        let heights = all.iter().map(|(_, p)| p[2]);
        let top = heights.clone().fold(f64::NEG_INFINITY, f64::max);
        let bottom = heights.fold(f64::INFINITY, f64::min);
        let highest = all
            .into_iter()
            .filter(|(_, p)| top - p[2] <= TOP_LAYER * (top - bottom));
        let (nodes, heights) = highest.map(|(id, p)| (id, p[2])).unzip();
        Some(Self { nodes, heights })
    }

    /// Depth of the deepest of its nodes below where they lay \[m\], and the mean place of all \[m\].
    pub fn now(&self, block: &BlockView<'_>) -> Option<(f64, [f64; 3])> {
        let (ids, positions) = (block.u32s("node_id")?, block.f64s("position")?);
        let mut deepest = f64::NEG_INFINITY;
        let (mut sum, mut found) = ([0.0; 3], 0_u32);
        for (id, height) in self.nodes.iter().zip(&self.heights) {
            let Some(node) = node_of(ids, *id) else {
                continue;
            };
            let p = position(positions, node);
            deepest = deepest.max(height - p[2]);
            sum = [sum[0] + p[0], sum[1] + p[1], sum[2] + p[2]];
            found += 1;
        }
        (found > 0).then(|| (deepest, sum.map(|s| s / f64::from(found))))
    }
}
