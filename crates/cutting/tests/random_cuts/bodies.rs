//! Bodies to cut: of size about 1, irregular, with numbers in no order.

use microsim_cutting::{Measures, Settings, SurfaceChange, SurfaceTriangle, Topology, check};
use microsim_mesh::{Arc, Block, CellSplit, Layer, TetMesh, TriangleSurface, Tube, fill};
use microsim_random::SplitMix64;
use nalgebra::{Matrix3, Vector3};
use std::collections::BTreeSet;

type V3 = Vector3<f64>;

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    Block,
    Tube,
    Filled,
}

pub struct Body {
    pub mesh: TetMesh,
    pub topology: Topology,
    pub measures: Measures,
    pub settings: Settings,
    surface: BTreeSet<SurfaceTriangle>,
    /// The mesh of the first generation, with a fibre direction in each element.
    original: TetMesh,
    /// The smallest identity that an element of the next edit can have.
    next_element: u32,
}

fn block(random: &mut SplitMix64) -> TetMesh {
    let cells = 2 + random.below(3) as usize;
    let block = Block {
        center: [0.0; 3],
        size: [1.0; 3],
        cells: [cells; 3],
        split: CellSplit::Kuhn,
    };
    let mut mesh = block.mesh().expect("a block");
    for p in &mut mesh.positions {
        *p += random.vector() * (0.15 / cells as f64);
    }
    mesh
}

fn tube(random: &mut SplitMix64) -> TetMesh {
    let tube = Tube {
        center: [0.0; 3],
        axis: [1.0, 0.3, -0.2],
        inner_radius: 0.3,
        layers: vec![Layer {
            thickness: 0.15,
            cells: 1,
            region: 0,
        }],
        length: 1.2,
        around: 8 + random.below(5) as usize,
        along: 6,
        arc: Arc::Full,
        split: CellSplit::Kuhn,
    };
    tube.mesh().expect("a tube")
}

/// An octahedron whose faces are divided and blown up, filled.
fn filled(random: &mut SplitMix64) -> TetMesh {
    let mut points: Vec<V3> = vec![V3::x(), V3::y(), V3::z(), -V3::x(), -V3::y(), -V3::z()];
    let mut triangles: Vec<[u32; 3]> = vec![
        [0, 1, 2],
        [1, 3, 2],
        [3, 4, 2],
        [4, 0, 2],
        [1, 0, 5],
        [3, 1, 5],
        [4, 3, 5],
        [0, 4, 5],
    ];
    for _ in 0..2 {
        let mut next = Vec::new();
        let mut middles: Vec<([u32; 2], u32)> = Vec::new();
        for [a, b, c] in triangles {
            let [ab, bc, ca] = [[a, b], [b, c], [c, a]].map(|[i, j]| {
                let edge = [i.min(j), i.max(j)];
                if let Some((_, middle)) = middles.iter().find(|(e, _)| *e == edge) {
                    return *middle;
                }
                points.push((points[i as usize] + points[j as usize]).normalize());
                middles.push((edge, points.len() as u32 - 1));
                points.len() as u32 - 1
            });
            next.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        triangles = next;
    }
    let stretch = V3::new(0.6, 0.5 + 0.1 * random.number(), 0.4);
    let points = points.iter().map(|p| p.component_mul(&stretch)).collect();
    fill(
        &TriangleSurface {
            positions: points,
            triangles,
        },
        0.3,
    )
    .expect("a mesh")
}

/// Fibres of a helix that widens along z, unlike at any two places.
fn fibre_at(place: &V3) -> V3 {
    let angle = 3.0 * place.z + 5.0 * place.norm_squared();
    V3::new(libm::cos(angle), libm::sin(angle), 0.5 + place.x * place.y).normalize()
}

/// Barycentric coordinates of a place in a tetrahedron.
fn barycentric([a, b, c, d]: &[V3; 4], place: &V3) -> [f64; 4] {
    let volume = |a: &V3, b: &V3, c: &V3, d: &V3| (b - a).cross(&(c - a)).dot(&(d - a));
    let parts = [
        volume(place, b, c, d),
        volume(a, place, c, d),
        volume(a, b, place, d),
        volume(a, b, c, place),
    ];
    parts.map(|part| part / volume(a, b, c, d))
}

/// The same mesh with nodes and elements in another order.
fn shuffled(mesh: &TetMesh, random: &mut SplitMix64) -> TetMesh {
    let mut order = |n: usize| {
        let mut order: Vec<usize> = (0..n).collect();
        for i in (1..n).rev() {
            order.swap(i, random.below(i as u64 + 1) as usize);
        }
        order
    };
    let nodes = order(mesh.positions.len());
    let elements = order(mesh.tets.len());
    let mut new = vec![0; nodes.len()];
    for (place, &node) in nodes.iter().enumerate() {
        new[node] = place as u32;
    }
    TetMesh::new(
        nodes.iter().map(|&n| mesh.positions[n]).collect(),
        elements
            .iter()
            .map(|&e| mesh.tets[e].map(|n| new[n as usize]))
            .collect(),
        elements.iter().map(|&e| mesh.regions[e]).collect(),
    )
}

impl Body {
    pub fn new(kind: Kind, random: &mut SplitMix64) -> Self {
        let mesh = match kind {
            Kind::Block => block(random),
            Kind::Tube => tube(random),
            Kind::Filled => filled(random),
        };
        let mut mesh = shuffled(&mesh, random);
        let centre = |element| mesh.corners(element).iter().sum::<V3>() / 4.0;
        let fibres: Vec<V3> = (0..mesh.tets.len()).map(|e| fibre_at(&centre(e))).collect();
        mesh.directions = fibres.iter().map(|a| [*a, -a]).collect();
        // Each element has one of its own too, small beside what cuts do to the body where it moves.
        let prestretch = |a: &V3| Matrix3::identity() + a * a.transpose() * 1e-4;
        mesh.prestretches = fibres.iter().map(prestretch).collect();
        let topology = Topology::new(&mesh);
        let measures = check(&mesh, &topology).expect("a valid mesh");
        let surface = topology.surface().into_iter().collect();
        Self {
            original: mesh.clone(),
            next_element: mesh.element_ids.iter().max().map_or(0, |id| id + 1),
            mesh,
            topology,
            measures,
            settings: Settings::default(),
            surface,
        }
    }

    /// A surface that is updated by the changes alone is that of the mesh.
    pub fn follow_surface(&mut self, change: &SurfaceChange) -> Result<(), String> {
        for t in &change.removed {
            if !self.surface.remove(t) {
                return Err(format!("{t:?} was not on the surface"));
            }
        }
        for t in &change.added {
            if !self.surface.insert(*t) {
                return Err(format!("{t:?} was on the surface"));
            }
        }
        if self.surface != self.topology.surface().into_iter().collect() {
            return Err("the surface that was followed is another".into());
        }
        Ok(())
    }

    /// Each element that an edit has made has the fibre directions and the prestretch of the element of the first generation in which its centroid lies; positions of a
    /// mesh are those at rest, and no edit moves them. Where the centroid lies on a face to rounding, of one of the two.
    pub fn check_fibres(&mut self) -> Result<(), String> {
        if self.mesh.directions.len() != self.mesh.tets.len() {
            return Err(format!(
                "{} fibre directions of {} elements",
                self.mesh.directions.len(),
                self.mesh.tets.len()
            ));
        }
        let mut next = self.next_element;
        for (element, &id) in self.mesh.element_ids.iter().enumerate() {
            next = next.max(id + 1);
            if id < self.next_element {
                continue;
            }
            let centre = self.mesh.corners(element).iter().sum::<V3>() / 4.0;
            let found = (
                self.mesh.directions[element],
                self.mesh.prestretches[element],
            );
            let holds = |parent: usize| {
                let parts = barycentric(&self.original.corners(parent), &centre);
                parts.iter().all(|part| *part > -1e-9)
            };
            let mut parents = (0..self.original.tets.len()).filter(|parent| holds(*parent));
            let of = |parent: usize| {
                let original = &self.original;
                (original.directions[parent], original.prestretches[parent])
            };
            if !parents.any(|parent| of(parent) == found) {
                return Err(format!(
                    "element {element} has the fibres and prestretch {found:?} of another"
                ));
            }
        }
        self.next_element = next;
        Ok(())
    }

    pub fn longest_edge(&self) -> f64 {
        let edges = self.mesh.edges();
        let length = |[a, b]: &[u32; 2]| {
            (self.mesh.positions[*a as usize] - self.mesh.positions[*b as usize]).norm()
        };
        edges.iter().map(length).fold(0.0, f64::max)
    }

    /// No part has corners on both sides of a plane and further from it than the tolerance. In the `first` stroke the nodes that were there
    /// before count: new ones lie on the cut.
    pub fn separated(
        &self,
        center: &V3,
        normal: &V3,
        tolerance: f64,
        first: bool,
    ) -> Result<(), String> {
        let count = self.mesh.tets.len();
        let mut part = vec![usize::MAX; count];
        for start in 0..count {
            if part[start] != usize::MAX {
                continue;
            }
            part[start] = start;
            let mut open = vec![start];
            let (mut least, mut most) = (0.0_f64, 0.0_f64);
            while let Some(element) = open.pop() {
                for corner in 0..4 {
                    let node = self.mesh.tets[element][corner] as usize;
                    if !first || self.is_original(node) {
                        let height = (self.mesh.positions[node] - center).dot(normal);
                        least = least.min(height);
                        most = most.max(height);
                    }
                    if let Some(other) = self.topology.neighbour(element as u32, corner)
                        && part[other as usize] == usize::MAX
                    {
                        part[other as usize] = start;
                        open.push(other as usize);
                    }
                }
            }
            if least < -tolerance && most > tolerance {
                return Err(format!(
                    "a bridge: a part from {least} to {most}, tolerance {tolerance}"
                ));
            }
        }
        Ok(())
    }

    /// Whether a node was there in the first generation.
    fn is_original(&self, node: usize) -> bool {
        (self.mesh.node_ids[node] as usize) < self.original.positions.len()
    }
}
