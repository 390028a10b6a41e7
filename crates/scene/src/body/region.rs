//! On which regions of a body a point of contact acts.

use super::Body;
use crate::surface_edits::triangles_at;
use microsim_cutting::{SurfaceTriangle, Topology};
use microsim_mesh::TetMesh;

/// The surface of a body by its nodes, as far as regions need it.
#[derive(Clone, Debug)]
pub(crate) enum SurfaceRegions {
    /// All of the body is of one region.
    One(u32),
    /// The triangles at each node, of a body that is never cut.
    Fixed(Vec<Vec<SurfaceTriangle>>),
    /// The topology of the body knows them.
    Cut,
}

impl SurfaceRegions {
    /// Of a mesh with elements; `cut`: whether it can be cut.
    pub fn new(mesh: &TetMesh, cut: bool) -> Self {
        let first = mesh.regions.first().copied().unwrap_or_default();
        if mesh.regions.iter().all(|region| *region == first) {
            return Self::One(first);
        }
        if cut {
            return Self::Cut;
        }
        let mut at = vec![Vec::new(); mesh.positions.len()];
        for triangle in Topology::new(mesh).surface() {
            for node in triangle.nodes {
                at[node as usize].push(triangle);
            }
        }
        Self::Fixed(at)
    }
}

impl Body {
    /// The region of the element behind each triangle of the surface.
    pub(crate) fn triangle_regions(&self) -> impl Iterator<Item = u32> + '_ {
        let region = |of: &SurfaceTriangle| self.mesh.regions[of.element as usize];
        let triangles = self.surface.triangles.iter().enumerate();
        triangles.map(move |(index, nodes)| match &self.surface_regions {
            SurfaceRegions::One(region) => *region,
            // Both lists are of one order.
            SurfaceRegions::Cut => region(&self.triangles[index]),
            SurfaceRegions::Fixed(at) => {
                let mut there = at[nodes[0] as usize].iter();
                let same = there.find(|t| nodes.iter().all(|node| t.nodes.contains(node)));
                region(same.expect("it is of this surface"))
            }
        })
    }

    /// The regions of the surface at a vertex, on an edge or on a triangle, given by its nodes, each with its weight in what acts there: by the
    /// areas at rest of the triangles that have all these nodes, and evenly by triangles where none has an area. Ascending; the weights sum up to 1.
    pub(crate) fn region_weights(&self, nodes: &[u32]) -> Vec<(u32, f64)> {
        let Some(&node) = nodes.first() else {
            return Vec::new();
        };
        match (&self.surface_regions, &self.topology) {
            (SurfaceRegions::One(region), _) => vec![(*region, 1.0)],
            (SurfaceRegions::Fixed(at), _) => {
                self.weights(nodes, at[node as usize].iter().copied())
            }
            (SurfaceRegions::Cut, topology) => {
                let topology = topology.iter();
                self.weights(nodes, topology.flat_map(|of| triangles_at(of, node)))
            }
        }
    }

    fn weights(
        &self,
        nodes: &[u32],
        triangles: impl Iterator<Item = SurfaceTriangle>,
    ) -> Vec<(u32, f64)> {
        let holding = triangles.filter(|t| nodes.iter().all(|node| t.nodes.contains(node)));
        let mut of_triangles: Vec<(u32, f64)> = holding
            .map(|triangle| {
                let corners = triangle
                    .nodes
                    .map(|node| self.mesh.positions[node as usize]);
                let [a, b, c] = corners;
                let area = 0.5 * (b - a).cross(&(c - a)).norm();
                (self.mesh.regions[triangle.element as usize], area)
            })
            .collect();
        if of_triangles.iter().all(|(_, area)| *area == 0.0) {
            of_triangles.iter_mut().for_each(|(_, area)| *area = 1.0);
        }
        let mut weights: Vec<(u32, f64)> = Vec::new();
        for (region, area) in of_triangles {
            match weights.binary_search_by_key(&region, |(of, _)| *of) {
                Ok(at) => weights[at].1 += area,
                Err(at) => weights.insert(at, (region, area)),
            }
        }
        let whole: f64 = weights.iter().map(|(_, area)| area).sum();
        weights.iter_mut().for_each(|(_, weight)| *weight /= whole);
        weights
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spec::BodySpec;
    use microsim_mesh::{Block, CellSplit};
    use microsim_tissue::{Behaviour, Material, Method, SpringConstants};

    /// A block of cubes of two regions that meet at x = 0, with its upper face at z = 1 mm.
    fn halves(cut: bool) -> Body {
        let block = Block {
            center: [0.0; 3],
            size: [4e-3, 4e-3, 2e-3],
            cells: [4, 4, 2],
            split: CellSplit::Kuhn,
        };
        let mut mesh = block.mesh().unwrap();
        mesh.regions = (0..mesh.tets.len())
            .map(|e| {
                let sum: f64 = mesh.tets[e]
                    .iter()
                    .map(|&n| mesh.positions[n as usize].x)
                    .sum();
                if sum < 0.0 { 3 } else { 7 }
            })
            .collect();
        let material = Material {
            density: 1000.0,
            relaxation_time: 0.0,
            behaviour: Behaviour::Springs(SpringConstants::scaled(25e3, 5e4)),
        };
        let spec = BodySpec {
            materials: vec![(3, material), (7, material)],
            ..BodySpec::new("block", mesh, material)
        };
        Body::new(&spec, &Method::StoermerVerlet, true, cut).unwrap()
    }

    /// By counting triangles of half a square: of the six at an inner node three lie on either side, of the two at an edge one; a triangle
    /// is of one region even where its corners lie on the border.
    #[test]
    fn points_on_a_border_are_shared_by_areas_and_triangles_are_of_one_region() {
        for cut in [false, true] {
            let body = halves(cut);
            let node = |x: f64, y: f64| {
                let at = nalgebra::Vector3::new(x, y, 1e-3);
                let mut positions = body.mesh.positions.iter();
                positions.position(|p| (p - at).norm() < 1e-9).unwrap() as u32
            };
            let border = [node(0.0, 0.0), node(0.0, 1e-3)];
            for nodes in [&border[..1], &border] {
                let weights = body.region_weights(nodes);
                let regions: Vec<u32> = weights.iter().map(|(region, _)| *region).collect();
                assert_eq!(regions, [3, 7]);
                for (_, weight) in weights {
                    assert!((weight - 0.5).abs() < 1e-12, "{weight}");
                }
            }
            assert_eq!(body.region_weights(&[node(1e-3, 0.0)]), [(7, 1.0)]);
            assert_eq!(
                body.region_weights(&[node(-1e-3, 0.0), border[0]]),
                [(3, 1.0)]
            );
            // A triangle of the surface lies on one side of x = 0, as its element does.
            let left = |t: &[u32; 3]| {
                let x = |node: &u32| body.mesh.positions[*node as usize].x;
                t.iter().map(x).sum::<f64>() < 0.0
            };
            let by_place = body.surface.triangles.iter();
            let by_place: Vec<u32> = by_place.map(|t| if left(t) { 3 } else { 7 }).collect();
            assert_eq!(body.triangle_regions().collect::<Vec<_>>(), by_place);
            let triangles = body.surface.triangles.iter();
            let beside = triangles.filter(|t| border.iter().all(|node| t.contains(node)));
            let of: Vec<_> = beside.map(|t| body.region_weights(t)).collect();
            assert_eq!(of.len(), 2);
            assert!(
                of.contains(&vec![(3, 1.0)]) && of.contains(&vec![(7, 1.0)]),
                "{of:?}"
            );
        }
    }

    /// A needle of a mesh on file has faces without area; its force goes to some region all the same.
    #[test]
    fn triangles_without_area_have_equal_weights() {
        let mut body = halves(false);
        body.mesh.positions.fill(nalgebra::Vector3::zeros());
        for node in body.surface.triangles.concat() {
            let weights = body.region_weights(&[node]);
            let whole: f64 = weights.iter().map(|(_, weight)| weight).sum();
            assert!((whole - 1.0).abs() < 1e-12, "{weights:?}");
        }
    }
}
