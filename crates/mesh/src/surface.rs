//! The boundary of a mesh and parts of it.

use nalgebra::Vector3;

/// Outward triangles of a boundary and the nodes on it.
///
/// ```
/// use microsim_mesh::{Block, CellSplit};
///
/// let block = Block { center: [0.0; 3], size: [1.0; 3], cells: [2; 3], split: CellSplit::Kuhn };
/// let mesh = block.mesh()?;
/// // The upper face: eight triangles with nine nodes and an area of 1 m².
/// let top = mesh.surface().select(&mesh.positions, |_, normal| normal.z > 0.9);
/// assert_eq!((top.triangles.len(), top.nodes.len()), (8, 9));
/// let area: f64 = top.node_areas(&mesh.positions).iter().sum();
/// assert!((area - 1.0).abs() < 1e-14);
/// # Ok::<(), microsim_mesh::BlockError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    /// Three node indices per triangle, outward by the right-hand rule.
    pub triangles: Vec<[u32; 3]>,
    /// The nodes of the triangles, each once, ascending.
    pub nodes: Vec<u32>,
}

impl Surface {
    /// The surface made of `triangles`.
    pub fn new(triangles: Vec<[u32; 3]>) -> Self {
        let mut nodes: Vec<u32> = triangles.iter().flatten().copied().collect();
        nodes.sort_unstable();
        nodes.dedup();
        Self { triangles, nodes }
    }

    /// The triangles whose centroid \[m\] and outward unit normal satisfy `predicate`, in their order. The normal of a
    /// triangle without area is zero. `positions` \[m\] are those of the mesh's nodes.
    pub fn select(
        &self,
        positions: &[Vector3<f64>],
        mut predicate: impl FnMut(&Vector3<f64>, &Vector3<f64>) -> bool,
    ) -> Self {
        let chosen = self.triangles.iter().filter(|triangle| {
            let [a, b, c] = triangle.map(|node| positions[node as usize]);
            let normal = microsim_geometry::triangle_normal(&[a, b, c]).unwrap_or_default();
            predicate(&((a + b + c) / 3.0), &normal)
        });
        Self::new(chosen.copied().collect())
    }

    /// The triangles all of whose nodes satisfy `predicate`, in their order.
    pub fn within(&self, mut predicate: impl FnMut(u32) -> bool) -> Self {
        let chosen = self
            .triangles
            .iter()
            .filter(|triangle| triangle.iter().all(|&node| predicate(node)));
        Self::new(chosen.copied().collect())
    }

    /// Outward normal of each triangle, as long as its area \[m²\].
    pub fn area_vectors(&self, positions: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
        self.triangles
            .iter()
            .map(|triangle| {
                let [a, b, c] = triangle.map(|node| positions[node as usize]);
                (b - a).cross(&(c - a)) / 2.0
            })
            .collect()
    }

    /// A third of the area of the triangles at each of `nodes` \[m²\], in the order of `nodes`.
    pub fn node_areas(&self, positions: &[Vector3<f64>]) -> Vec<f64> {
        let mut areas = vec![0.0; self.nodes.len()];
        for (triangle, area) in self.triangles.iter().zip(self.area_vectors(positions)) {
            for node in triangle {
                // Every node of a triangle is in the list; the constructor put it there.
                if let Ok(place) = self.nodes.binary_search(node) {
                    areas[place] += area.norm() / 3.0;
                }
            }
        }
        areas
    }
}

#[cfg(test)]
mod tests {
    use crate::{Block, CellSplit};
    use nalgebra::Vector3;

    /// One face of a block: its triangles, area and area vector are known in closed form; a corner node of a Kuhn face
    /// has one or two of the triangles of its cell.
    #[test]
    fn a_face_of_a_block_is_selected_by_normal_or_by_nodes() {
        let block = Block {
            center: [0.0; 3],
            size: [4.0, 3.0, 2.0],
            cells: [4, 3, 2],
            split: CellSplit::Kuhn,
        };
        let mesh = block.mesh().unwrap();
        let surface = mesh.surface();
        let top = surface.select(&mesh.positions, |_, normal| normal.z > 0.5);
        assert_eq!(top.triangles.len(), 2 * 4 * 3);
        assert_eq!(top.nodes.len(), 5 * 4);
        assert_eq!(
            top,
            surface.within(|node| mesh.positions[node as usize].z == 1.0)
        );
        let above = surface.select(&mesh.positions, |centroid, _| centroid.z > 0.999);
        assert_eq!(top, above);

        let sum: Vector3<f64> = top.area_vectors(&mesh.positions).iter().sum();
        assert!((sum - Vector3::new(0.0, 0.0, 12.0)).norm() < 1e-13);
        let areas = top.node_areas(&mesh.positions);
        assert!((areas.iter().sum::<f64>() - 12.0).abs() < 1e-13);
        // Unit cells: inner nodes have six of the half-unit triangles.
        let inner = top.nodes.iter().position(|&n| {
            (mesh.positions[n as usize] - Vector3::new(0.0, 0.5, 1.0)).norm() < 1e-12
        });
        assert!((areas[inner.unwrap()] - 1.0).abs() < 1e-14);
    }
}
