//! What pictures of the computation show of a body: values of its elements at their nodes.

use crate::stress::{stresses, von_mises};
use crate::view::BodyView;
use microsim_geometry::signed_volume;
use microsim_mesh::ElementQuality;
use microsim_settings::Remedy;
use microsim_tissue::Material;

/// Of each node of a body, in the order of its nodes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NodeFields {
    /// Von Mises stress \[Pa\]: the mean of the elements at the node, by their volumes at rest. `None` of a body without any continuum.
    pub von_mises: Option<Vec<f64>>,
    /// The least radius ratio of the elements at the node, as they are now: 1 of a regular tetrahedron, 0 of a flat one, below inside out.
    pub quality: Vec<f64>,
    /// The bits of what [had to be done](Remedy), as far as it can be seen of the state: of a tick its report has the rest.
    pub remedies: Vec<u32>,
}

impl BodyView<'_> {
    /// What pictures show of it; `materials` are those of the regions of its mesh.
    pub fn node_fields(&self, materials: &[(u32, Material)]) -> NodeFields {
        let (mesh, positions) = (self.mesh(), self.positions());
        let flowed = self.model().plastic_states(mesh, self.state());
        let stresses = stresses(materials, mesh, positions, &flowed.unwrap_or_default());
        let nodes = positions.len();
        let von_mises = stresses.map(|stresses| {
            let equivalent = stresses.iter().map(von_mises);
            means(&mesh.tets, equivalent, self.model().rest_volumes(), nodes)
        });
        let mut quality = vec![1.0_f64; nodes];
        let mut remedies = vec![0; nodes];
        for tet in &mesh.tets {
            let corners = tet.map(|node| positions[node as usize]);
            let ratio = ElementQuality::of(&corners).radius_ratio;
            let [a, b, c, d] = &corners;
            let is_inverted = signed_volume(a, b, c, d) <= 0.0;
            for node in tet.map(|node| node as usize) {
                quality[node] = quality[node].min(ratio);
                remedies[node] |= bit(Remedy::Inverted, is_inverted);
            }
        }
        let has_stiffened = self.stable_step() < self.parts().stable_step;
        for (node, (remedy, mass)) in remedies.iter_mut().zip(self.masses()).enumerate() {
            let has_inertia = self.model().inertia(node) > *mass;
            *remedy |= bit(Remedy::Inertia, has_inertia) | bit(Remedy::Stiffened, has_stiffened);
        }
        NodeFields {
            von_mises,
            quality,
            remedies,
        }
    }
}

fn bit(remedy: Remedy, is_there: bool) -> u32 {
    if is_there { remedy.bit() } else { 0 }
}

/// Of each node the mean of the values of the elements at it, by their weights; 0 of one at none.
fn means(
    tets: &[[u32; 4]],
    values: impl Iterator<Item = f64>,
    weights: &[f64],
    nodes: usize,
) -> Vec<f64> {
    let mut sums = vec![[0.0; 2]; nodes];
    for ((tet, value), weight) in tets.iter().zip(values).zip(weights) {
        for node in tet {
            let [sum, of] = &mut sums[*node as usize];
            *sum += weight * value;
            *of += weight;
        }
    }
    let mean = |[sum, of]: [f64; 2]| if of > 0.0 { sum / of } else { 0.0 };
    sums.into_iter().map(mean).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{BodySpec, Scene, SceneSpec, Selection, StartSpec};
    use microsim_mesh::{Block, CellSplit, TetMesh};
    use microsim_tissue::law::LawName;
    use microsim_tissue::{Behaviour, ContinuumConstants, Discretisation, Method, SpringConstants};
    use nalgebra::Vector3;

    const YOUNG: f64 = 1e5;

    /// A body whose nodes begin where `matrix` puts them, and what is shown of it.
    fn fields(mesh: TetMesh, behaviour: Behaviour, matrix: [f64; 3]) -> NodeFields {
        let material = Material {
            density: 1000.0,
            relaxation_time: 0.0,
            behaviour,
        };
        let mut body = BodySpec::new("body", mesh, material);
        body.start.push(StartSpec {
            nodes: Selection::All,
            matrix: [0, 1, 2]
                .map(|row| std::array::from_fn(|k| if k == row { matrix[k] } else { 0.0 })),
            pivot: [0.0; 3],
            shift: [0.0; 3],
            velocity: [0.0; 3],
        });
        let materials = body.materials.clone();
        let spec = SceneSpec::new(vec![body], Method::ImplicitEuler(Default::default()));
        let scene = Scene::new(&spec).expect("a scene");
        scene.body(0).node_fields(&materials)
    }

    fn continuum(poisson: f64) -> Behaviour {
        Behaviour::Continuum(ContinuumConstants {
            law: LawName::StVenantKirchhoff.into(),
            young: YOUNG,
            poisson,
            discretisation: Discretisation::Tetrahedra,
            plasticity: None,
        })
    }

    fn block() -> TetMesh {
        let block = Block {
            center: [0.0; 3],
            size: [1e-3; 3],
            cells: [2; 3],
            split: CellSplit::Kuhn,
        };
        block.mesh().expect("a block")
    }

    /// Uniaxial tension of St Venant–Kirchhoff with Green's strain e along the axis and −ν e across: σ = Y e a/b² there alone, a² = 1 + 2 e and
    /// b² = 1 − 2 ν e (see module `stress`). It is the same in every element, so in every mean; springs have no stress of a continuum.
    #[test]
    fn a_uniform_stretch_has_one_stress_at_every_node() {
        let (poisson, strain) = (0.3, 0.2_f64);
        let a = (1.0 + 2.0 * strain).sqrt();
        let b = (1.0 - 2.0 * poisson * strain).sqrt();
        let found = fields(block(), continuum(poisson), [b, a, b]);
        let expected = YOUNG * strain * a / (b * b);
        let stresses = found.von_mises.expect("a continuum");
        assert_eq!(stresses.len(), 27);
        for stress in stresses {
            assert!((stress / expected - 1.0).abs() < 1e-9, "{stress}");
        }
        assert!(found.remedies.iter().all(|bits| *bits == 0));
        let springs = Behaviour::Springs(SpringConstants::scaled(25e3, 5e4));
        assert_eq!(fields(block(), springs, [1.0; 3]).von_mises, None);
    }

    /// A regular tetrahedron has the ratio 1 and its mirror image −1. Pressed flat to a third of its height it has the diagonals of the faces of a box of 2 × 2 × ⅔ as edges: its
    /// volume is a third of the box, 8/9, its four faces have 2√11/3 each, so r = 3V/A = 1/√11, and R is half the diagonal of the box, √19/3: 3r/R = 9/√209.
    #[test]
    fn the_quality_is_that_of_the_shape_now() {
        let corners = [
            [1.0, 1.0, 1.0],
            [1.0, -1.0, -1.0],
            [-1.0, -1.0, 1.0],
            [-1.0, 1.0, -1.0],
        ];
        let corners = corners.map(|c| Vector3::from(c) * 1e-3);
        let regular = || TetMesh::new(corners.to_vec(), vec![[0, 1, 2, 3]], vec![0]);
        let found = fields(regular(), continuum(0.3), [1.0; 3]);
        assert!(
            found.quality.iter().all(|q| (q - 1.0).abs() < 1e-12),
            "{found:?}"
        );
        let flat = fields(regular(), continuum(0.3), [1.0, 1.0, 1.0 / 3.0]);
        let expected = 9.0 / 209_f64.sqrt();
        assert!(
            flat.quality.iter().all(|q| (q - expected).abs() < 1e-12),
            "{flat:?}"
        );
        let turned = fields(regular(), continuum(0.3), [1.0, 1.0, -1.0]);
        assert!(turned.quality.iter().all(|q| (q + 1.0).abs() < 1e-12));
        let bits = Remedy::Inverted.bit();
        assert!(
            turned.remedies.iter().all(|found| *found == bits),
            "{turned:?}"
        );
    }

    /// Two elements at node 1, of 1 and 3 units of volume with 4 and 8 units of stress: (1 · 4 + 3 · 8)/4 = 7 there; node 8 is of none.
    #[test]
    fn means_are_weighted_by_volume() {
        let tets = [[0, 1, 2, 3], [1, 5, 6, 7]];
        let found = means(&tets, [4.0, 8.0].into_iter(), &[1.0, 3.0], 9);
        assert_eq!(found, [4.0, 7.0, 4.0, 4.0, 0.0, 8.0, 8.0, 8.0, 0.0]);
    }
}
