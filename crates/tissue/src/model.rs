//! The constant part of a body: springs, volume elements, masses, clamps.

use crate::material::SpringVolume;
use microsim_mesh::TetMesh;
use nalgebra::Vector3;

/// Bodies with at least this many volume elements compute forces in parallel parts. Below it, handing work to threads
/// (13–21 µs with rayon, measured) costs more than it saves.
const PARALLEL_ELEMENTS: usize = 4096;

/// Parts of a parallel body. It depends on the model alone, never on the number of threads.
const PARALLEL_PARTS: usize = 16;

/// A spring along a mesh edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spring {
    /// End nodes.
    pub nodes: [u32; 2],
    /// Rest length L0 [m].
    pub rest_length: f64,
    /// Stiffness k [N/m].
    pub stiffness: f64,
}

/// The volume energy of one tetrahedron.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VolumeElement {
    /// Corner nodes, positively oriented at rest.
    pub nodes: [u32; 4],
    /// Rest volume V0 [m³].
    pub rest_volume: f64,
    /// Stiffness k [N/m⁵].
    pub stiffness: f64,
}

/// Everything about a body that does not evolve.
#[derive(Clone, Debug)]
pub struct TissueModel {
    rest_positions: Vec<Vector3<f64>>,
    masses: Vec<f64>,
    inverse_masses: Vec<f64>,
    springs: Vec<Spring>,
    volumes: Vec<VolumeElement>,
    drag: f64,
    mean_edge_length: f64,
    incidence: Incidence,
}

/// For each node, where its forces stand in the element buffers: a compressed list in ascending element order, so that
/// every sum has a fixed order.
#[derive(Clone, Debug)]
struct Incidence {
    spring_starts: Vec<u32>,
    /// Spring index · 2 + end.
    spring_ends: Vec<u32>,
    volume_starts: Vec<u32>,
    /// Element index · 4 + corner.
    volume_corners: Vec<u32>,
}

/// Why a model cannot be built from a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ModelError {
    /// One clamp flag per node is needed.
    ClampCount {
        /// Number of flags.
        flags: usize,
        /// Number of nodes.
        nodes: usize,
    },
    /// An element has no positive volume at rest.
    Volume {
        /// Its index.
        element: usize,
        /// Its volume [m³].
        volume: f64,
    },
    /// A node belongs to no element and so has no mass.
    LooseNode {
        /// Its index.
        node: usize,
    },
}

impl std::fmt::Display for ModelError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::ClampCount { flags, nodes } => write!(f, "{flags} clamp flags for {nodes} nodes"),
            Self::Volume { element, volume } => {
                write!(
                    f,
                    "element {element} has the rest volume {volume} m³; it must be positive"
                )
            }
            Self::LooseNode { node } => write!(f, "node {node} belongs to no element"),
        }
    }
}

impl std::error::Error for ModelError {}

impl TissueModel {
    /// The model of `mesh` made of `material`; `clamped[i]` fixes node `i` in space.
    pub fn new(
        mesh: &TetMesh,
        material: &SpringVolume,
        clamped: &[bool],
    ) -> Result<Self, ModelError> {
        if clamped.len() != mesh.positions.len() {
            return Err(ModelError::ClampCount {
                flags: clamped.len(),
                nodes: mesh.positions.len(),
            });
        }
        let volumes = mesh.volumes();
        for (element, &volume) in volumes.iter().enumerate() {
            if volume.is_nan() || volume <= 0.0 {
                return Err(ModelError::Volume { element, volume });
            }
        }
        let masses = mesh.lumped_masses(material.spec().density);
        if let Some(node) = masses.iter().position(|&m| m == 0.0) {
            return Err(ModelError::LooseNode { node });
        }

        // One spring per unique edge; its stiffness is the sum over the elements around it, in element order.
        let mut springs: Vec<Spring> = mesh
            .edges()
            .into_iter()
            .map(|nodes| {
                let rest_length =
                    (mesh.positions[nodes[1] as usize] - mesh.positions[nodes[0] as usize]).norm();
                Spring {
                    nodes,
                    rest_length,
                    stiffness: 0.0,
                }
            })
            .collect();
        for element in 0..mesh.tets.len() {
            for edge in mesh.element_edges(element) {
                if let Ok(index) = springs.binary_search_by_key(&edge, |spring| spring.nodes) {
                    springs[index].stiffness +=
                        material.spring_stiffness(springs[index].rest_length);
                }
            }
        }
        let volumes = mesh
            .tets
            .iter()
            .zip(volumes)
            .map(|(&nodes, rest_volume)| VolumeElement {
                nodes,
                rest_volume,
                stiffness: material.volume_stiffness(rest_volume),
            })
            .collect();
        Ok(Self::assemble(
            mesh.positions.clone(),
            masses,
            clamped,
            springs,
            volumes,
            material.spec().drag,
        ))
    }

    /// The model made of these parts.
    pub(crate) fn assemble(
        rest_positions: Vec<Vector3<f64>>,
        masses: Vec<f64>,
        clamped: &[bool],
        springs: Vec<Spring>,
        volumes: Vec<VolumeElement>,
        drag: f64,
    ) -> Self {
        let inverse_masses = masses
            .iter()
            .zip(clamped)
            .map(|(m, &fixed)| if fixed { 0.0 } else { 1.0 / m })
            .collect();
        let mean_edge_length =
            springs.iter().map(|s| s.rest_length).sum::<f64>() / springs.len().max(1) as f64;
        let (spring_starts, spring_ends) =
            incidence(rest_positions.len(), springs.iter().map(|s| s.nodes));
        let (volume_starts, volume_corners) =
            incidence(rest_positions.len(), volumes.iter().map(|v| v.nodes));
        let incidence = Incidence {
            spring_starts,
            spring_ends,
            volume_starts,
            volume_corners,
        };
        Self {
            rest_positions,
            masses,
            inverse_masses,
            springs,
            volumes,
            drag,
            mean_edge_length,
            incidence,
        }
    }

    /// Number of nodes.
    pub fn node_count(&self) -> usize {
        self.rest_positions.len()
    }

    /// Rest positions [m].
    pub fn rest_positions(&self) -> &[Vector3<f64>] {
        &self.rest_positions
    }

    /// Node masses [kg], those of clamped nodes included.
    pub fn masses(&self) -> &[f64] {
        &self.masses
    }

    /// Inverse node masses as the solver sees them [1/kg]; 0 for a clamped node.
    pub fn inverse_masses(&self) -> &[f64] {
        &self.inverse_masses
    }

    /// Whether a node is fixed in space.
    pub fn is_clamped(&self, node: usize) -> bool {
        self.inverse_masses[node] == 0.0
    }

    /// The springs, one per edge.
    pub fn springs(&self) -> &[Spring] {
        &self.springs
    }

    /// The volume elements, one per tetrahedron.
    pub fn volumes(&self) -> &[VolumeElement] {
        &self.volumes
    }

    /// Drag per mass [1/s].
    pub fn drag(&self) -> f64 {
        self.drag
    }

    /// Mean rest length of the springs [m]: the characteristic length of the body.
    pub fn mean_edge_length(&self) -> f64 {
        self.mean_edge_length
    }

    /// Number of parts in which forces are computed.
    pub(crate) fn parts(&self) -> usize {
        if self.volumes.len() >= PARALLEL_ELEMENTS {
            PARALLEL_PARTS
        } else {
            1
        }
    }

    /// The spring ends at `node`: spring index · 2 + end.
    #[inline]
    pub(crate) fn spring_ends(&self, node: usize) -> &[u32] {
        let starts = &self.incidence.spring_starts;
        &self.incidence.spring_ends[starts[node] as usize..starts[node + 1] as usize]
    }

    /// The element corners at `node`: element index · 4 + corner.
    #[inline]
    pub(crate) fn volume_corners(&self, node: usize) -> &[u32] {
        let starts = &self.incidence.volume_starts;
        &self.incidence.volume_corners[starts[node] as usize..starts[node + 1] as usize]
    }
}

/// Start of each node's list, and the lists of (element · N + corner), for elements of N nodes.
fn incidence<const N: usize>(
    nodes: usize,
    elements: impl Iterator<Item = [u32; N]> + Clone,
) -> (Vec<u32>, Vec<u32>) {
    let mut starts = vec![0u32; nodes + 1];
    for node in elements.clone().flatten() {
        starts[node as usize + 1] += 1;
    }
    for node in 0..nodes {
        starts[node + 1] += starts[node];
    }
    let mut next = starts.clone();
    let mut entries = vec![0u32; starts[nodes] as usize];
    for (element, corners) in elements.enumerate() {
        for (corner, node) in corners.into_iter().enumerate() {
            let slot = &mut next[node as usize];
            entries[*slot as usize] = (element * N + corner) as u32;
            *slot += 1;
        }
    }
    (starts, entries)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::SpringVolumeSpec;
    use microsim_mesh::Block;

    fn material() -> SpringVolume {
        let spec = SpringVolumeSpec {
            stretch_modulus: 25e3,
            volume_modulus: 5e4,
            density: 1060.0,
            drag: 0.0,
        };
        SpringVolume::from_moduli(spec).unwrap()
    }

    #[test]
    fn springs_and_volumes_count_every_element_once() {
        let mesh = Block {
            center: [0.0; 3],
            size: [3e-3, 2e-3, 1e-3],
            cells: [3, 2, 1],
        }
        .mesh()
        .unwrap();
        let clamped: Vec<bool> = mesh.positions.iter().map(|p| p.x < -1.4e-3).collect();
        let model = TissueModel::new(&mesh, &material(), &clamped).unwrap();
        assert_eq!(model.springs().len(), mesh.edges().len());
        // Σ k = c·E·Σ_tets Σ_edges L0, summed here over elements instead of edges.
        let expected: f64 = (0..mesh.tets.len())
            .flat_map(|e| mesh.element_edges(e))
            .map(|[i, j]| (mesh.positions[j as usize] - mesh.positions[i as usize]).norm())
            .map(|length| 2.0 * 2f64.sqrt() / 25.0 * 25e3 * length)
            .sum();
        let sum: f64 = model.springs().iter().map(|s| s.stiffness).sum();
        assert!((sum / expected - 1.0).abs() < 1e-13);
        // Total mass ρV, clamps included.
        assert!((model.masses().iter().sum::<f64>() / (1060.0 * 6e-9) - 1.0).abs() < 1e-13);
        assert_eq!(
            (0..model.node_count())
                .filter(|&i| model.is_clamped(i))
                .count(),
            6
        );
        // Each list entry points back at its node.
        for node in 0..model.node_count() {
            assert!(model.spring_ends(node).iter().all(|&e| {
                model.springs()[e as usize / 2].nodes[e as usize % 2] as usize == node
            }));
            assert!(model.volume_corners(node).iter().all(|&c| {
                model.volumes()[c as usize / 4].nodes[c as usize % 4] as usize == node
            }));
        }
    }

    #[test]
    fn unusable_meshes_are_refused() {
        let mesh = Block {
            center: [0.0; 3],
            size: [1.0; 3],
            cells: [1; 3],
        }
        .mesh()
        .unwrap();
        let free = [false; 8];
        assert!(matches!(
            TissueModel::new(&mesh, &material(), &free[1..]),
            Err(ModelError::ClampCount { flags: 7, nodes: 8 })
        ));
        let mut inverted = mesh.clone();
        inverted.tets[3].swap(0, 1);
        assert!(matches!(
            TissueModel::new(&inverted, &material(), &free),
            Err(ModelError::Volume { element: 3, .. })
        ));
        let mut loose = mesh;
        loose.positions.push(Vector3::zeros());
        assert_eq!(
            TissueModel::new(&loose, &material(), &[false; 9]).unwrap_err(),
            ModelError::LooseNode { node: 8 }
        );
    }
}
