//! Which side of tools and obstacles nodes are on.

use crate::point::{Partner, Point};
use nalgebra::Vector3;

/// The last normals at each touched node, per partner.
///
/// A point on the axis of a capsule has no direction of its own, and one that has crossed the axis has the wrong one; within a step
/// the path since its start decides, over steps these normals do. Those of what is no longer touched are removed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sides {
    /// Sums of weighted normals, ascending by partner and node.
    entries: Vec<(Partner, u32, Vector3<f64>)>,
}

impl Sides {
    /// Nothing touched.
    pub fn new() -> Self {
        Self::default()
    }

    /// Replaces all entries by those of `points`, with which a step ended.
    pub fn remember<'a>(&mut self, points: impl IntoIterator<Item = &'a Point>) {
        self.entries.clear();
        for point in points {
            // Between two bodies the meshes themselves show what is inside.
            if matches!(point.key.partner, Partner::Body { .. }) {
                continue;
            }
            for k in 0..usize::from(point.first) {
                if point.weights[k] > 0.0 {
                    let normal = point.normal * point.weights[k];
                    let partner = point.key.partner;
                    self.entries.push((partner, point.nodes[k], normal));
                }
            }
        }
        // In an order of its own, so that sums do not depend on that of the points.
        self.entries.sort_unstable_by(|a, b| {
            let numbers = |n: &Vector3<f64>| n.map(f64::to_bits).data.0[0];
            (a.0, a.1, numbers(&a.2)).cmp(&(b.0, b.1, numbers(&b.2)))
        });
        self.entries.dedup_by(|later, first| {
            let same = (later.0, later.1) == (first.0, first.1);
            if same {
                first.2 += later.2;
            }
            same
        });
    }

    /// The normal of `node` at `partner`, from it to the node, not of unit length; the zero vector where the node touches nothing.
    pub fn normal(&self, partner: &Partner, node: u32) -> Vector3<f64> {
        self.entries
            .binary_search_by_key(&(*partner, node), |&(partner, node, _)| (partner, node))
            .map_or_else(|_| Vector3::zeros(), |place| self.entries[place].2)
    }

    /// All entries in ascending order: partner, node and normal, for [`Self::from_entries`].
    pub fn entries(&self) -> &[(Partner, u32, Vector3<f64>)] {
        &self.entries
    }

    /// With these entries.
    pub fn from_entries(mut entries: Vec<(Partner, u32, Vector3<f64>)>) -> Self {
        entries.sort_by_key(|&(partner, node, _)| (partner, node));
        Self { entries }
    }
}
