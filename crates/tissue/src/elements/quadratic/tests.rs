use super::*;
use crate::build::{BuildError, build_model};
use crate::elements::{Configuration, ElementMatrix, Elements, Quadratic, Tangent};
use crate::law::{Lame, LawName, StVenantKirchhoff};
use crate::material::{Behaviour, ContinuumConstants, Material};
use crate::testing::{block_mesh, numbers};
use crate::{EditError, ModelEdit, TissueModel};
use microsim_vocabulary::Discretisation;
use nalgebra::DMatrix;

/// Two cells of six tetrahedra, with every corner moved by up to a tenth of a cell; straight edges.
fn straight() -> TetMesh {
    let mut mesh = block_mesh([2.0, 1.0, 1.0], [2, 1, 1]);
    let mut next = numbers();
    for position in &mut mesh.positions {
        *position += Vector3::from_fn(|_, _| next()) * 0.1;
    }
    mesh.refined().mesh
}

/// The same with every middle moved by up to a fiftieth of a cell.
fn curved() -> TetMesh {
    let mut mesh = straight();
    let mut next = numbers();
    for position in mesh.positions.iter_mut().skip(12) {
        *position += Vector3::from_fn(|_, _| next()) * 0.02;
    }
    mesh
}

fn all(mesh: &TetMesh) -> Vec<u32> {
    (0..mesh.tets.len() as u32).collect()
}

fn material(discretisation: Discretisation, poisson: f64) -> Material {
    Material {
        density: 1000.0,
        relaxation_time: 0.0,
        behaviour: Behaviour::Continuum(ContinuumConstants {
            law: LawName::NeoHookean.into(),
            young: 1e4,
            poisson,
            discretisation,
            plasticity: None,
        }),
    }
}

fn body(mesh: &TetMesh, discretisation: Discretisation, poisson: f64) -> TissueModel {
    let clamped = vec![false; mesh.positions.len()];
    let materials = [(0, material(discretisation, poisson))];
    build_model(mesh, &materials, &clamped, 0.0, Vec::new()).unwrap()
}

/// On straight elements F is that of a quadratic displacement itself, on curved ones that of a linear one; the shares are the volume.
#[test]
fn quadratic_displacements_have_their_own_gradient() {
    let linear = Matrix3::new(1.1, 0.3, -0.2, -0.4, 0.9, 0.1, 0.2, 0.1, 1.05);
    let bend = Matrix3::new(0.2, -0.1, 0.0, 0.3, 0.1, -0.2, 0.1, 0.0, -0.3);
    // x ↦ linear x + (x·bend x) (1, 2, 3), with the gradient linear + (1, 2, 3) ⊗ (bend + bendᵀ) x.
    let direction = Vector3::new(1.0, 2.0, 3.0);
    for (mesh, size) in [(straight(), 1.0), (curved(), 0.0)] {
        let points = QuadraturePoints::of(&mesh, &all(&mesh));
        assert_eq!(points.count(), 4 * 12);
        let map = |p: &Vector3<f64>| linear * p + direction * (size * p.dot(&(bend * p)));
        let moved: Vec<_> = mesh.positions.iter().map(map).collect();
        for point in 0..points.count() {
            let at = |corner: usize| COORDINATES[usize::from(corner != point % 4)];
            let nodes = points.nodes(point);
            let place: Vector3<f64> = (0..4)
                .map(|corner| mesh.positions[nodes[corner] as usize] * at(corner))
                .sum();
            let slope = (bend + bend.transpose()) * place * size;
            let expected = linear + direction * slope.transpose();
            let found = points.deformation(point, &moved);
            assert!((found - expected).norm() < 1e-13, "{found} {expected}");
        }
        let means = points.means();
        let volume: f64 = (0..means.count()).map(|mean| means.volume(mean)).sum();
        let whole: f64 = mesh.volumes().iter().sum();
        // The parts of a curved element have other volumes than the element.
        assert!((volume - whole).abs() < if size > 0.0 { 1e-13 } else { 1e-2 });
    }
}

/// Of 30 motions six are rigid, and all others have energy.
#[test]
fn the_stiffness_of_an_element_has_rank_24() {
    let corners = vec![
        Vector3::zeros(),
        Vector3::new(1.0, 0.1, 0.0),
        Vector3::new(0.2, 0.9, 0.1),
        Vector3::new(0.1, -0.1, 1.2),
    ];
    let mesh = TetMesh::new(corners, vec![[0, 1, 2, 3]], vec![0])
        .refined()
        .mesh;
    for (lambda, means) in [(1.5, false), (0.0, true)] {
        let mut dense = DMatrix::<f64>::zeros(30, 30);
        let points = QuadraturePoints::of(&mesh, &all(&mesh));
        let mut sets = vec![(points.clone(), Lame { mu: 1.0, lambda })];
        if means {
            let volumetric = Lame {
                mu: 0.0,
                lambda: 50.0,
            };
            sets.push((points.means(), volumetric));
        }
        for (points, lame) in sets {
            let set = Quadratic::<StVenantKirchhoff>::new(points, lame, 0.0);
            let at = Configuration {
                positions: &mesh.positions,
                velocities: &mesh.positions,
                internal: &[],
            };
            let mut matrix = ElementMatrix::new();
            for point in 0..set.count() {
                set.stiffness(point, &at, Tangent::Exact, &mut matrix);
                let nodes = set.nodes(point);
                for (i, row) in nodes.iter().enumerate() {
                    for (j, column) in nodes.iter().enumerate() {
                        let (row, column) = (3 * *row as usize, 3 * *column as usize);
                        let mut place = dense.fixed_view_mut::<3, 3>(row, column);
                        place += matrix.block(i, j);
                    }
                }
            }
        }
        let mut values: Vec<f64> = dense.symmetric_eigenvalues().iter().copied().collect();
        values.sort_by(f64::total_cmp);
        assert!(values[5].abs() < 1e-13 * values[29], "{values:?}");
        assert!(values[6] > 1e-3 * values[29].min(10.0), "{values:?}");
    }
}

/// Pure bending of a prism, u = κ (x z, −ν y z, (ν (y² − z²) − x²)/2), is quadratic and in equilibrium without forces on the inside
/// (Timoshenko & Goodier 1970, 102); where λ ≤ μ, that is ν ≤ 1/4, the pressure is not averaged.
#[test]
fn pure_bending_is_in_equilibrium() {
    let mut mesh = block_mesh([2.0, 1.0, 1.0], [2, 2, 2]);
    let mut next = numbers();
    for position in &mut mesh.positions {
        *position += Vector3::from_fn(|_, _| next()) * 0.05;
    }
    let mesh = mesh.refined().mesh;
    let outer = mesh.surface().nodes;
    let curvature = 1e-7;
    for (discretisation, poisson) in [
        (Discretisation::Quadratic, 0.25),
        (Discretisation::Quadratic, 0.49),
        (Discretisation::QuadraticPressure, 0.25),
    ] {
        let model = body(&mesh, discretisation, poisson);
        let bent = |p: &Vector3<f64>| {
            let across = 0.5 * (poisson * (p.y * p.y - p.z * p.z) - p.x * p.x);
            p + Vector3::new(p.x * p.z, -poisson * p.y * p.z, across) * curvature
        };
        let positions: Vec<_> = mesh.positions.iter().map(bent).collect();
        let mut forces = vec![Vector3::zeros(); positions.len()];
        for set in model.sets() {
            let at = Configuration {
                positions: &positions,
                velocities: &positions,
                internal: &[],
            };
            let mut window = NodeWindow {
                first: 0,
                values: &mut forces,
            };
            set.add_forces(0..set.count(), &at, &mut window);
        }
        let largest = forces.iter().map(|f| f.amax()).fold(0.0, f64::max);
        let inner = (0..forces.len()).filter(|n| outer.binary_search(&(*n as u32)).is_err());
        let inner = inner.map(|n| forces[n].amax()).fold(0.0, f64::max);
        // Terms of second order are 1e-7 of those of first, rounding 1e-16/1e-7.
        assert!(
            inner < 1e-5 * largest,
            "{discretisation:?} {poisson}: {inner} {largest}"
        );
    }
}

#[test]
fn a_mesh_that_is_not_refined_and_an_edit_are_refused() {
    let mesh = block_mesh([1.0; 3], [1; 3]);
    let refined = mesh.refined().mesh;
    let materials = [(0, material(Discretisation::Quadratic, 0.3))];
    let clamped = |mesh: &TetMesh| vec![false; mesh.positions.len()];
    let build =
        |mesh: &TetMesh| build_model(mesh, &materials, &clamped(mesh), 0.0, Vec::new()).map(|_| ());
    assert_eq!(build(&refined), Ok(()));
    let refused = Err(BuildError::Quadratic { region: 0 });
    assert_eq!(build(&mesh), refused);
    // A part that is missing, parts in another order, an edge folded back on itself.
    let mut missing = refined.clone();
    missing.tets.pop();
    missing.regions.pop();
    assert_eq!(build(&missing), refused);
    let mut turned = refined.clone();
    turned.tets.swap(0, 1);
    assert_eq!(build(&turned), refused);
    let mut folded = refined.clone();
    let (corner, middle) = (folded.tets[0][0], folded.tets[0][1]);
    folded.positions[middle as usize] = folded.positions[corner as usize];
    assert_eq!(
        build(&folded)
            .map_err(|e| matches!(e, BuildError::Quadratic { .. } | BuildError::Model(_))),
        Err(true)
    );

    let mut model = body(&refined, Discretisation::QuadraticPressure, 0.3);
    let edit = ModelEdit {
        mesh: &refined,
        replaced: vec![],
        parents: vec![],
        new_nodes: vec![],
        clamped: vec![],
        removed_elements: vec![],
        removed_nodes: vec![],
    };
    assert_eq!(
        model.edit(&edit).map(|_| ()),
        Err(EditError::Quadratic { region: 0 })
    );
}

/// Each point has the direction of the part at its corner.
#[test]
fn points_have_the_fibres_of_their_parts() {
    let mut mesh = straight();
    mesh.directions = (0..mesh.tets.len())
        .map(|part| [part as f64, -(part as f64)].map(|x| Vector3::new(x, 1.0, 0.0).normalize()))
        .collect();
    let points = QuadraturePoints::of(&mesh, &all(&mesh));
    for point in 0..points.count() {
        assert_eq!(
            points.directions(point),
            mesh.directions[8 * (point / 4) + point % 4]
        );
    }
    assert_eq!(points.means().directions(0), [Vector3::zeros(); 2]);
}

/// Where λ ≤ μ there is nothing to average, and one set.
#[test]
fn only_the_excess_of_lambda_is_averaged() {
    let mesh = straight();
    for (poisson, sets) in [(0.2, 1), (0.25, 1), (0.3, 2), (0.49, 2)] {
        let model = body(&mesh, Discretisation::QuadraticPressure, poisson);
        assert_eq!(model.sets().len(), sets, "{poisson}");
        assert_eq!(
            body(&mesh, Discretisation::Quadratic, poisson).sets().len(),
            1
        );
    }
}
