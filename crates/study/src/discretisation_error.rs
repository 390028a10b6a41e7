//! How far the mesh and the elements of a body are off, by the body itself: against quadratic tetrahedra on the same mesh.
//!
//! Both solve linear elasticity under the weight of the body along the axis in which it yields most, held as it is at the start. What is
//! compared is the compliance, the work of the weight on the displacement it causes: displacements on average. Quadratic tetrahedra neither
//! are stiff in bending nor lock at the Poisson's ratios of tissue, and their mid-edge nodes are those of a uniform refinement: of a mesh that
//! is not far too coarse they are exact beside its own error. That holds for structured and unstructured meshes alike, as no constant is
//! fitted to either.
//!
//! What is not estimated: bodies that nothing holds, springs, the error at large strain, under residual stress, of fibres, of contact, or of single points.

use microsim_mesh::TetMesh;
use microsim_sparse::{BlockMatrix, LinearSolver, Pattern};
use microsim_tissue::law::{Lame, LawName};
use microsim_tissue::{
    Behaviour, Control, Discretisation, Material, Method, Newton, Serial, State, build_model,
};
use nalgebra::{Matrix3, Vector3};
use std::sync::Arc;

/// More tetrahedra are not estimated \[-\]: the quadratic solution would take longer than all else that is checked. Measured: 12,000 take 4 s.
pub const MOST_ELEMENTS: usize = 12_000;
/// Residual of the quadratic solution relative to its loads.
const TOLERANCE: f64 = 1e-8;
/// Strain in the order of which the body is deformed: linear, far above rounding.
const STRAIN: f64 = 1e-7;

/// Displacements of a body as its mesh and elements have them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiscretisationError {
    /// Displacement with the elements of the body, relative to the quadratic solution: below 1 it is too stiff.
    pub displacement: f64,
    /// The same with selective elements.
    pub selective: f64,
    /// The axis of the world along which the weight acts: 0 x, 1 y, 2 z.
    pub axis: usize,
}

/// The estimate for a body of `materials` by region, whose nodes marked in `held` do not move; `None` where there is none: nothing is held,
/// a material is no continuum, there are more than [`MOST_ELEMENTS`], or the mesh cannot be solved on.
pub fn discretisation_error(
    mesh: &TetMesh,
    materials: &[(u32, Material)],
    held: &[bool],
) -> Option<DiscretisationError> {
    if mesh.tets.len() > MOST_ELEMENTS || !held.iter().any(|held| *held) {
        return None;
    }
    // Residual stress would stiffen it, or make it buckle, on both sides of the comparison.
    let mut mesh = mesh.clone();
    mesh.prestretches.clear();
    let mesh = &mesh;
    let fixed = with_free_parts(mesh, held);
    if fixed.iter().all(|fixed| *fixed) {
        return None;
    }
    let of_region: Vec<(u32, Material)> = materials
        .iter()
        .map(|(region, material)| Some((*region, isotropic(material)?)))
        .collect::<Option<_>>()?;
    let quadratic = quadratic_compliances(mesh, &of_region, &fixed)?;
    let axis = (0..3).max_by(|a, b| quadratic[*a].total_cmp(&quadratic[*b]))?;
    let displacement = |discretisation: Option<Discretisation>| {
        let compliance = compliance(mesh, &of_region, &fixed, axis, discretisation)?;
        Some(compliance / quadratic[axis])
    };
    let all_selective = of_region.iter().all(|(_, material)| {
        matches!(material.behaviour, Behaviour::Continuum(c) if c.discretisation == Discretisation::Selective)
    });
    let own = displacement(None)?;
    Some(DiscretisationError {
        displacement: own,
        selective: match all_selective {
            true => own,
            false => displacement(Some(Discretisation::Selective))?,
        },
        axis,
    })
}

/// The material without fibres, of a law that is linear elasticity at small strain; `None` if it is no continuum.
fn isotropic(material: &Material) -> Option<Material> {
    let Behaviour::Continuum(mut constants) = material.behaviour else {
        return None;
    };
    constants.law = LawName::StableNeoHookean.into();
    Some(Material {
        behaviour: Behaviour::Continuum(constants),
        relaxation_time: 0.0,
        ..*material
    })
}

/// `held`, and the nodes of all parts of the mesh that no held node belongs to: they would fall.
fn with_free_parts(mesh: &TetMesh, held: &[bool]) -> Vec<bool> {
    let mut part: Vec<usize> = (0..held.len()).collect();
    fn root(part: &mut [usize], mut node: usize) -> usize {
        while part[node] != node {
            part[node] = part[part[node]];
            node = part[node];
        }
        node
    }
    for tet in &mesh.tets {
        let first = root(&mut part, tet[0] as usize);
        for node in &tet[1..] {
            let other = root(&mut part, *node as usize);
            part[other] = first;
        }
    }
    let mut is_held = vec![false; held.len()];
    for node in (0..held.len()).filter(|node| held[*node]) {
        let root = root(&mut part, node);
        is_held[root] = true;
    }
    (0..held.len())
        .map(|node| held[node] || !is_held[root(&mut part, node)])
        .collect()
}

/// Weights of a body: such that its strain is in the order of [`STRAIN`] \[m/s²\].
fn gravity(mesh: &TetMesh, materials: &[(u32, Material)]) -> Option<f64> {
    let length = mesh
        .positions
        .iter()
        .map(|x| (x - mesh.positions[0]).norm())
        .fold(0.0, f64::max);
    let least = materials
        .iter()
        .filter_map(|(_, material)| match material.behaviour {
            Behaviour::Continuum(constants) => Some(constants.young / material.density),
            Behaviour::Springs(_) => None,
        });
    let gravity = STRAIN * least.fold(f64::INFINITY, f64::min) / length;
    (gravity.is_finite() && gravity > 0.0).then_some(gravity)
}

/// Work of the weight along an axis on the displacement of the body's own elements, or in a discretisation \[J\].
fn compliance(
    mesh: &TetMesh,
    materials: &[(u32, Material)],
    fixed: &[bool],
    axis: usize,
    discretisation: Option<Discretisation>,
) -> Option<f64> {
    let mut materials = materials.to_vec();
    for (_, material) in &mut materials {
        if let (Behaviour::Continuum(constants), Some(discretisation)) =
            (&mut material.behaviour, discretisation)
        {
            constants.discretisation = discretisation;
        }
    }
    let model = build_model(mesh, &materials, fixed, 0.0, Vec::new()).ok()?;
    let mut weight = Vector3::zeros();
    weight[axis] = gravity(mesh, &materials)?;
    let control = Control {
        gravity: weight,
        ..Control::default()
    };
    let mut state = State::at_rest(&model);
    let mut solver = Method::QuasiStatic(Newton::default()).solver(&model).ok()?;
    solver
        .step(&model, &mut state, &control, &[], 1.0, &Serial)
        .ok()?;
    let moved = state.positions.iter().zip(model.rest_positions());
    let work = moved
        .zip(model.masses())
        .map(|((now, rest), mass)| mass * weight.dot(&(now - rest)));
    Some(work.sum())
}

/// The same of quadratic tetrahedra, along each axis \[J\].
fn quadratic_compliances(
    mesh: &TetMesh,
    materials: &[(u32, Material)],
    fixed: &[bool],
) -> Option<[f64; 3]> {
    let gravity = gravity(mesh, materials)?;
    let edges = mesh.edges();
    let corners = mesh.positions.len();
    let nodes = corners + edges.len();
    let mut positions = mesh.positions.clone();
    let ends = |edge: &[u32; 2]| edge.map(|node| node as usize);
    positions.extend(edges.iter().map(|edge| {
        let [a, b] = ends(edge);
        (mesh.positions[a] + mesh.positions[b]) / 2.0
    }));
    let mut all_fixed = fixed.to_vec();
    all_fixed.extend(edges.iter().map(|edge| {
        let [a, b] = ends(edge);
        fixed[a] && fixed[b]
    }));
    let cliques: Vec<[u32; 10]> = mesh
        .tets
        .iter()
        .map(|tet| {
            let middles = PAIRS.map(|[a, b]| {
                let edge = [tet[a].min(tet[b]), tet[a].max(tet[b])];
                edges
                    .binary_search(&edge)
                    .ok()
                    .map(|found| (corners + found) as u32)
            });
            let mut clique = [0; 10];
            clique[..4].copy_from_slice(tet);
            for (place, middle) in clique[4..].iter_mut().zip(middles) {
                *place = middle?;
            }
            Some(clique)
        })
        .collect::<Option<_>>()?;
    let pattern = Arc::new(Pattern::from_cliques(nodes, &cliques));
    let mut solver = LinearSolver::new(&pattern, &positions);
    let mut matrix = BlockMatrix::zeros(pattern);
    let mut weights = vec![0.0; nodes];
    let volumes = mesh.volumes();
    for (element, clique) in cliques.iter().enumerate() {
        let material = materials
            .iter()
            .find(|(region, _)| *region == mesh.regions[element]);
        let (_, material) = material?;
        let Behaviour::Continuum(constants) = material.behaviour else {
            return None;
        };
        let lame = Lame::from_young_poisson(constants.young, constants.poisson);
        let gradients = corner_gradients(&mesh.corners(element))?;
        add_element(&mut matrix, clique, &gradients, volumes[element], &lame);
        // ∫ N over a quadratic tetrahedron: −V/20 of a corner, V/5 of the middle of an edge.
        let weight = material.density * gravity * volumes[element];
        for (place, node) in clique.iter().enumerate() {
            weights[*node as usize] += weight * if place < 4 { -0.05 } else { 0.2 };
        }
    }
    solver.factorise(&matrix, &all_fixed).ok()?;
    let mut compliances = [0.0; 3];
    for (axis, compliance) in compliances.iter_mut().enumerate() {
        let load = |node: usize| match all_fixed[node] {
            true => 0.0,
            false => weights[node],
        };
        let mut x: Vec<Vector3<f64>> = (0..nodes)
            .map(|node| Vector3::ith(axis, load(node)))
            .collect();
        solver.solve(&matrix, &mut x, TOLERANCE).ok()?;
        *compliance = (0..nodes).map(|node| load(node) * x[node][axis]).sum();
    }
    Some(compliances)
}

/// The corners between which the nodes 4 to 9 lie.
const PAIRS: [[usize; 2]; 6] = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];

/// Gradients of the barycentric coordinates \[1/m\]; `None` of a flat tetrahedron.
fn corner_gradients(corners: &[Vector3<f64>; 4]) -> Option<[Vector3<f64>; 4]> {
    let [a, b, c, d] = corners;
    let inverse = Matrix3::from_columns(&[b - a, c - a, d - a]).try_inverse()?;
    let [x, y, z] = [0, 1, 2].map(|row| inverse.row(row).transpose());
    Some([-(x + y + z), x, y, z])
}

/// Adds the stiffness of a quadratic tetrahedron with straight edges, integrated exactly by four points.
fn add_element(
    matrix: &mut BlockMatrix,
    clique: &[u32; 10],
    gradients: &[Vector3<f64>; 4],
    volume: f64,
    lame: &Lame,
) {
    // Points of degree 2: a coordinate of (5 + 3 √5)/20, the others (5 − √5)/20.
    let (near, far) = (0.585_410_196_624_968_5, 0.138_196_601_125_010_5);
    for point in 0..4 {
        let mut at = [far; 4];
        at[point] = near;
        let mut shape = [Vector3::zeros(); 10];
        for corner in 0..4 {
            shape[corner] = gradients[corner] * (4.0 * at[corner] - 1.0);
        }
        for (place, [a, b]) in shape[4..].iter_mut().zip(PAIRS) {
            *place = (gradients[b] * at[a] + gradients[a] * at[b]) * 4.0;
        }
        let weight = volume / 4.0;
        for i in 0..10 {
            for j in 0..=i {
                let (b_i, b_j) = (&shape[i], &shape[j]);
                let mut block =
                    b_i * b_j.transpose() * lame.lambda + b_j * b_i.transpose() * lame.mu;
                block += Matrix3::from_diagonal_element(lame.mu * b_i.dot(b_j));
                block *= weight;
                match i == j {
                    true => matrix.add_diagonal(clique[i] as usize, &block),
                    false => matrix.add(clique[i] as usize, clique[j] as usize, &block),
                }
            }
        }
    }
}

#[cfg(test)]
mod tests;
