//! Regions with nodes of their own: layers that hang together by a coupling and not by nodes.

use crate::TetMesh;
use crate::surface::Surface;

/// A mesh of which some regions have nodes of their own.
#[derive(Clone, Debug, PartialEq)]
pub struct Detached {
    /// The mesh. Nodes of before have their numbers; copies come behind them.
    pub mesh: TetMesh,
    /// The node of the mesh before that each one is, or is a copy of.
    pub origins: Vec<u32>,
}

impl TetMesh {
    /// Gives each of `regions` nodes of its own where it meets another region. A node stays with the regions that are not among
    /// them; one that only these have, with the first of them.
    ///
    /// ```
    /// use microsim_mesh::{Block, CellSplit};
    ///
    /// let block = Block { center: [0.0; 3], size: [1.0; 3], cells: [1, 1, 2], split: CellSplit::Kuhn };
    /// let mut mesh = block.mesh()?;
    /// mesh.regions[6..].fill(1);
    /// let detached = mesh.detached(&[1]);
    /// // The four nodes between the two cells are there twice.
    /// assert_eq!(detached.mesh.positions.len(), 16);
    /// assert_eq!(detached.mesh.surface().triangles.len(), 24);
    /// # Ok::<(), microsim_mesh::BlockError>(())
    /// ```
    pub fn detached(&self, regions: &[u32]) -> Detached {
        // Which nodes of its own a region uses: 0 those of all that are not listed.
        let owner = |element: usize| {
            let place = regions.iter().position(|of| *of == self.regions[element]);
            place.map_or(0, |place| place + 1)
        };
        let mut uses: Vec<(u32, usize)> = Vec::with_capacity(4 * self.tets.len());
        for (element, tet) in self.tets.iter().enumerate() {
            uses.extend(tet.map(|node| (node, owner(element))));
        }
        uses.sort_unstable();
        uses.dedup();
        let mut mesh = self.clone();
        let mut origins: Vec<u32> = (0..self.positions.len() as u32).collect();
        let mut copies: Vec<((u32, usize), u32)> = Vec::new();
        for owners in uses.chunk_by(|a, b| a.0 == b.0) {
            for &of in &owners[1..] {
                copies.push((of, origins.len() as u32));
                origins.push(of.0);
            }
        }
        for (element, tet) in mesh.tets.iter_mut().enumerate() {
            for node in tet {
                let of = (*node, owner(element));
                if let Ok(place) = copies.binary_search_by_key(&of, |(of, _)| *of) {
                    *node = copies[place].1;
                }
            }
        }
        for &((node, _), _) in &copies {
            mesh.positions.push(mesh.positions[node as usize]);
            mesh.node_ids.push(mesh.next_node_id);
            mesh.next_node_id += 1;
        }
        mesh.generation += u64::from(!copies.is_empty());
        Detached { mesh, origins }
    }
}

impl Detached {
    /// Boundary faces of the mesh before as they are now, in the order of the elements.
    pub fn faces(&self, faces: &[[u32; 3]]) -> Vec<[u32; 3]> {
        let mut wanted: Vec<[u32; 3]> = faces.iter().copied().map(sorted).collect();
        wanted.sort_unstable();
        let Surface { triangles, .. } = self.mesh.surface();
        let before = |triangle: &[u32; 3]| sorted(triangle.map(|n| self.origins[n as usize]));
        let of = |triangle: &[u32; 3]| wanted.binary_search(&before(triangle)).is_ok();
        triangles.into_iter().filter(of).collect()
    }
}

fn sorted(mut nodes: [u32; 3]) -> [u32; 3] {
    nodes.sort_unstable();
    nodes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Arc, Block, CellSplit, Layer, Tube, TubeSide};

    /// A wall of three layers of one, two and one cells.
    fn tube() -> Tube {
        let layer = |region, cells| Layer {
            thickness: 0.1,
            cells,
            region,
        };
        Tube {
            center: [0.0; 3],
            axis: [1.0, 0.0, 0.0],
            inner_radius: 0.5,
            layers: vec![layer(0, 1), layer(1, 2), layer(2, 1)],
            length: 2.0,
            around: 6,
            along: 4,
            arc: Arc::Full,
            split: CellSplit::Kuhn,
        }
    }

    #[test]
    fn each_detached_layer_has_its_own_nodes_and_the_wall_its_volume() {
        let mesh = tube().mesh().unwrap();
        let ring = 6 * 5;
        for (regions, interfaces) in [(&[][..], 0), (&[2], 1), (&[1], 2), (&[0, 2], 2)] {
            let Detached {
                mesh: apart,
                origins,
            } = mesh.detached(regions);
            assert_eq!(
                apart.positions.len(),
                mesh.positions.len() + interfaces * ring
            );
            assert_eq!(apart.volumes(), mesh.volumes());
            for (node, origin) in origins.iter().enumerate() {
                assert_eq!(apart.positions[node], mesh.positions[*origin as usize]);
            }
            for (element, tet) in apart.tets.iter().enumerate() {
                let before = tet.map(|node| origins[node as usize]);
                assert_eq!(before, mesh.tets[element]);
            }
            let mut ids = apart.node_ids.clone();
            ids.sort_unstable();
            ids.dedup();
            assert_eq!(ids.len(), apart.positions.len(), "ids are unique");
            // No node belongs to a detached region and another one.
            for region in regions {
                let nodes = |of: bool| -> Vec<u32> {
                    let tets = apart.tets.iter().zip(&apart.regions);
                    let own = tets.filter(|(_, r)| (*r == region) == of);
                    own.flat_map(|(tet, _)| *tet).collect()
                };
                let (inside, others) = (nodes(true), nodes(false));
                assert!(inside.iter().all(|node| !others.contains(node)));
            }
        }
    }

    #[test]
    fn the_ends_of_a_detached_tube_are_where_they_were() {
        let tube = tube();
        let mesh = tube.mesh().unwrap();
        let end = tube.side(&mesh, TubeSide::End).triangles;
        let apart = mesh.detached(&[1, 2]);
        let area = |mesh: &TetMesh, faces: &[[u32; 3]]| -> f64 {
            let corners = faces.iter().map(|f| f.map(|n| mesh.positions[n as usize]));
            corners
                .map(|[a, b, c]| 0.5 * (b - a).cross(&(c - a)).norm())
                .sum()
        };
        let now = apart.faces(&end);
        assert_eq!(now.len(), end.len());
        assert!((area(&apart.mesh, &now) - area(&mesh, &end)).abs() < 1e-14);
        let surface = apart.mesh.surface().triangles;
        assert!(now.iter().all(|face| surface.contains(face)));
    }

    #[test]
    fn a_node_of_listed_regions_alone_stays_with_the_first_of_them() {
        let block = Block {
            center: [0.0; 3],
            size: [1.0; 3],
            cells: [1, 1, 2],
            split: CellSplit::Kuhn,
        };
        let mut mesh = block.mesh().unwrap();
        mesh.regions[6..].fill(1);
        let apart = mesh.detached(&[1, 0]).mesh;
        assert_eq!(apart.positions.len(), 16);
        assert_eq!(apart.tets[6..], mesh.tets[6..], "region 1 comes first");
        assert_ne!(apart.tets[..6], mesh.tets[..6]);
    }
}
