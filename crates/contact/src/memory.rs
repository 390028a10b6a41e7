//! The last valid normals.

use nalgebra::Vector3;
use std::collections::BTreeMap;

/// The last valid contact normal of each touched node, per capsule of one tool.
///
/// A point on the axis of a capsule has no direction of its own, and one that has crossed the axis has the wrong one: both
/// take the direction of the step before. A node that is no longer touched is forgotten.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ContactMemory {
    normals: BTreeMap<(u32, u32), Vector3<f64>>,
}

impl ContactMemory {
    /// Nothing touched.
    pub fn new() -> Self {
        Self::default()
    }

    /// The unit normal of `node` at `capsule`, from the capsule's axis towards the tissue.
    pub fn normal(&self, capsule: u32, node: u32) -> Option<&Vector3<f64>> {
        self.normals.get(&(capsule, node))
    }

    /// Remembers the unit normal of `node` at `capsule`.
    pub fn remember(&mut self, capsule: u32, node: u32, normal: Vector3<f64>) {
        self.normals.insert((capsule, node), normal);
    }

    /// Forgets all.
    pub fn clear(&mut self) {
        self.normals.clear();
    }

    /// All entries in ascending order: (capsule, node, normal).
    pub fn entries(&self) -> impl ExactSizeIterator<Item = (u32, u32, &Vector3<f64>)> {
        self.normals
            .iter()
            .map(|(&(capsule, node), normal)| (capsule, node, normal))
    }
}
