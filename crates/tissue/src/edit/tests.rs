//! Edited models against models built of the mesh after the edit, for every material; what is refused.

mod by_hand;
mod remedies;
mod sliding;
mod solvers;
mod states;

use super::*;
use crate::build::build_model;
use crate::elements::key::Key;
use crate::elements::{ContinuumPlasticity, Elements, NodeWindow, Plasticity, Tangent};
use crate::law::LawName;
use crate::material::{
    Behaviour, Coefficients, ContinuumConstants, KindConstants, Material, SpringConstants,
    SpringForm, SpringModuli,
};
use crate::state::State;
use crate::testing::{block_mesh, fibres, numbers};
use by_hand::ByHand;
use microsim_vocabulary::Discretisation;
use nalgebra::{DMatrix, Vector3};

/// Sums of some hundred terms in another order.
const ROUNDING: f64 = 1e-12;

/// A block of two regions, one on top of the other.
fn layers(cells: [usize; 3]) -> TetMesh {
    let mut mesh = block_mesh([1.0; 3], cells);
    for element in 0..mesh.tets.len() {
        let centre = mesh.corners(element).iter().sum::<Vector3<f64>>() / 4.0;
        mesh.regions[element] = if centre.z > 0.0 { 7 } else { 3 };
    }
    fibres(&mut mesh);
    mesh
}

fn springs(form: SpringForm) -> Material {
    Material {
        density: 1060.0,
        relaxation_time: 1e-3,
        behaviour: Behaviour::Springs(SpringConstants {
            form,
            plasticity: None,
        }),
    }
}

fn continuum(discretisation: Discretisation) -> Material {
    Material {
        density: 900.0,
        relaxation_time: 2e-3,
        behaviour: Behaviour::Continuum(ContinuumConstants {
            law: LawName::StableNeoHookean.into(),
            young: 2e4,
            poisson: 0.45,
            discretisation,
            plasticity: None,
        }),
    }
}

/// With a fibre direction in each element.
fn fibrous(discretisation: Discretisation) -> Material {
    let mut material = continuum(discretisation);
    if let Behaviour::Continuum(constants) = &mut material.behaviour {
        constants.law = LawName::TransverselyIsotropic.into();
    }
    material
}

fn plastic(mut material: Material) -> Material {
    match &mut material.behaviour {
        Behaviour::Springs(constants) => {
            constants.plasticity = Some(Plasticity {
                yield_strain: 0.05,
                creep_rate: 3.0,
                max_strain: 0.5,
                hardening: 4.0,
                max_stiffening: 2.0,
            });
        }
        Behaviour::Continuum(constants) => {
            constants.plasticity = Some(ContinuumPlasticity {
                yield_strain: 0.05,
                yield_growth: 0.5,
                creep_rate: None,
                max_strain: 0.5,
                hardening: 4.0,
                max_stiffening: 2.0,
            });
        }
    }
    material
}

/// All forms of springs and all discretisations, these with fibres and without.
fn materials() -> Vec<Material> {
    let coefficients = |stiffness| Coefficients {
        stiffness,
        damping: 1e-3 * stiffness,
    };
    let kinds = KindConstants {
        length: coefficients(2.0),
        area: coefficients(3.0),
        volume: coefficients(5.0),
    };
    let moduli = SpringModuli {
        stretch: 25e3,
        area: 1e4,
        volume: 5e4,
    };
    let fitted = SpringForm::Fitted {
        young: 2e4,
        poisson: 0.4,
    };
    let mut all = vec![
        springs(SpringForm::Plain(kinds)),
        springs(SpringForm::Normalised(kinds)),
        springs(SpringForm::Scaled(moduli)),
        springs(fitted),
        plastic(springs(SpringForm::Scaled(moduli))),
        plastic(continuum(Discretisation::Tetrahedra)),
        plastic(continuum(Discretisation::NodeSmoothed)),
        plastic(fibrous(Discretisation::Selective)),
    ];
    all.extend(Discretisation::ALL[..5].iter().map(|one| fibrous(*one)));
    let cut = |one: &Discretisation| !one.is_quadratic();
    all.extend(Discretisation::ALL.into_iter().filter(cut).map(continuum));
    all
}

fn clamps(mesh: &TetMesh) -> Vec<bool> {
    mesh.positions.iter().map(|p| p.x < -0.4999).collect()
}

/// The two layers of these materials.
fn build(mesh: &TetMesh, materials: [Material; 2], clamped: &[bool]) -> TissueModel {
    let materials = [(3, materials[0]), (7, materials[1])];
    build_model(mesh, &materials, clamped, 0.5, Vec::new()).unwrap()
}

/// Energy, forces and stiffness of sets at a random configuration.
struct Answer {
    energies: Vec<f64>,
    forces: Vec<Vector3<f64>>,
    stiffness: DMatrix<f64>,
}

fn answer(model: &TissueModel, internal: &[f64]) -> Answer {
    let mut next = numbers();
    let n = model.node_count();
    let mut cloud = |size: f64| -> Vec<Vector3<f64>> {
        (0..n)
            .map(|_| Vector3::new(next(), next(), next()) * size)
            .collect()
    };
    let mut state = State::at_rest(model);
    for (p, by) in state.positions.iter_mut().zip(cloud(0.03)) {
        *p += by;
    }
    state.velocities = cloud(0.5);
    answer_at(model, &state, internal)
}

fn answer_at(model: &TissueModel, state: &State, internal: &[f64]) -> Answer {
    let mut state = state.clone();
    let n = model.node_count();
    state.internal = internal.to_vec();
    let (mut energies, mut forces) = (Vec::new(), vec![Vector3::zeros(); n]);
    let mut stiffness = DMatrix::zeros(3 * n, 3 * n);
    let mut matrix = crate::elements::ElementMatrix::new();
    for (set, elements) in model.sets().iter().enumerate() {
        let at = state.configuration(model, set);
        energies.push(elements.energy(&at));
        let mut window = NodeWindow {
            first: 0,
            values: &mut forces,
        };
        elements.add_forces(0..elements.count(), &at, &mut window);
        for element in 0..elements.count() {
            elements.stiffness(element, &at, Tangent::Exact, &mut matrix);
            let nodes = elements.nodes(element);
            for (i, row) in nodes.iter().enumerate() {
                for (j, column) in nodes.iter().enumerate() {
                    let mut view =
                        stiffness.fixed_view_mut::<3, 3>(3 * *row as usize, 3 * *column as usize);
                    view += matrix.block(i, j);
                }
            }
        }
    }
    Answer {
        energies,
        forces,
        stiffness,
    }
}

/// Compares a model with one that is rebuilt.
fn check_same(edited: &TissueModel, anew: &TissueModel, internal: &[f64]) {
    let count = |model: &TissueModel| -> Vec<usize> {
        model.sets().iter().map(|set| set.count()).collect()
    };
    assert_eq!(count(edited), count(anew));
    assert_eq!(edited.rest_positions(), anew.rest_positions());
    assert_eq!(edited.tets(), anew.tets());
    assert_eq!(edited.clamped(), anew.clamped());
    assert_eq!(edited.rest_volumes(), anew.rest_volumes());
    assert_eq!(edited.drags(), anew.drags());
    for (a, b) in edited.masses().iter().zip(anew.masses()) {
        assert!((a - b).abs() <= ROUNDING * b, "{a} {b}");
    }
    let weights = edited.inverse_masses().iter().zip(anew.inverse_masses());
    for (a, b) in weights {
        assert!((a - b).abs() <= ROUNDING * b, "{a} {b}");
    }
    let initial: Vec<f64> = anew
        .sets()
        .iter()
        .flat_map(|set| set.initial_internal())
        .collect();
    assert_eq!(internal.len(), initial.len());
    for set in 0..edited.sets().len() {
        assert_eq!(edited.internal_range(set), anew.internal_range(set));
    }
    let (a, b) = (answer(edited, internal), answer(anew, &initial));
    for (a, b) in a.energies.iter().zip(&b.energies) {
        assert!((a - b).abs() <= ROUNDING * b.abs(), "{a} {b}");
    }
    let scale = b.forces.iter().map(|f| f.amax()).fold(0.0, f64::max);
    for (a, b) in a.forces.iter().zip(&b.forces) {
        assert!((a - b).amax() <= ROUNDING * scale, "{a} {b}");
    }
    let scale = b.stiffness.amax();
    assert!((a.stiffness - b.stiffness).amax() <= ROUNDING * scale);
}

/// Sets as they are, elements in order, for comparisons of bits.
fn bits(model: &TissueModel) -> String {
    let sets: Vec<&dyn Elements> = model.sets().iter().map(|set| &**set).collect();
    let (masses, sums) = (model.masses(), model.row_sums());
    format!("{sets:?} {masses:?} {sums:?} {:?}", model.parts())
}

/// All materials in one layer, springs or tetrahedra in the other, after each of some random edits.
#[test]
fn an_edited_body_is_the_one_built_of_the_mesh_after_the_edit() {
    for (number, material) in materials().into_iter().enumerate() {
        let patches = number == materials().len() - 1;
        let other = match number % 2 {
            0 => continuum(Discretisation::Selective),
            _ => springs(SpringForm::Fitted {
                young: 1e4,
                poisson: 0.3,
            }),
        };
        let mut mesh = layers([2, 2, 2]);
        let mut clamped = clamps(&mesh);
        let mut edited = build(&mesh, [material, other], &clamped);
        let mut again = edited.clone();
        let mut state = State::at_rest(&edited);
        let mut next = numbers();
        for round in 0..6 {
            let mut edit = by_hand::random(&mesh, &clamped, &mut next);
            let after = edit.finish();
            let change = edit.apply(&after, &mut edited).unwrap();
            // A clone looks up in an index of its own, built anew.
            again = again.clone();
            assert_eq!(change, edit.apply(&after, &mut again).unwrap());
            assert_eq!(
                bits(&edited),
                bits(&again),
                "material {number}, round {round}"
            );
            state.edit(&change);
            clamped.extend(&edit.clamped);
            for &node in edit.removed_nodes.iter().rev() {
                clamped.swap_remove(node as usize);
            }
            mesh = after;
            let mut anew = build(&mesh, [material, other], &clamped);
            if patches {
                check_patches(&edited, &mut anew, &mesh, 1);
            }
            check_same(&edited, &anew, &state.internal);
            check_index(&edited);
            for (a, b) in state.positions.iter().zip(&mesh.positions) {
                assert!((a - b).norm() < 1e-14, "a body at rest stays at rest");
            }
            let total: f64 = edited.masses().iter().sum();
            let volumes = mesh.volumes().into_iter().zip(&mesh.regions);
            let expected: f64 = volumes
                .map(|(v, region)| v * edited.density(*region).unwrap())
                .sum();
            assert!((total / expected - 1.0).abs() < 1e-12);
        }
    }
}

/// A node in the middle of an edge that merges with an end of it leaves what was there before it, of all materials: the model is that of the mesh
/// with its first volumes, and a body at rest stays at rest.
#[test]
fn an_edge_that_was_divided_is_whole_again_when_its_node_has_merged() {
    for material in materials() {
        let other = continuum(Discretisation::Selective);
        let mut mesh = layers([2, 2, 2]);
        let whole = mesh.clone();
        let clamped = clamps(&mesh);
        let mut edited = build(&mesh, [material, other], &clamped);
        let mut state = State::at_rest(&edited);
        let edge = mesh.edges()[17];
        let mut edit = ByHand::new(&mesh);
        let node = edit.divide(edge, 0.4, false);
        mesh = edit.finish();
        state.edit(&edit.apply(&mesh, &mut edited).unwrap());
        let mut edit = ByHand::new(&mesh);
        edit.merge(node, edge[0]);
        mesh = edit.finish();
        state.edit(&edit.apply(&mesh, &mut edited).unwrap());

        let sorted = |mesh: &TetMesh| {
            let mut tets = mesh.tets.clone();
            tets.iter_mut().for_each(|tet| tet.sort_unstable());
            tets.sort_unstable();
            tets
        };
        assert_eq!(sorted(&mesh), sorted(&whole));
        assert_eq!(state.positions, whole.positions);
        let mut anew = build(&mesh, [material, other], &clamped);
        if material == *materials().last().unwrap() {
            check_patches(&edited, &mut anew, &mesh, 1);
        }
        check_same(&edited, &anew, &state.internal);
        check_index(&edited);
    }
}

/// Every element of the region is in one patch; puts the same patches into the rebuilt model, which forms its own.
fn check_patches(edited: &TissueModel, anew: &mut TissueModel, mesh: &TetMesh, set: usize) {
    let (number, part, set) = (set, edited.parts_made()[set], &edited.sets()[set]);
    let place = |tet: &Key| {
        let same = |t: &&[u32; 4]| Key::new(*t) == *tet;
        mesh.tets.iter().position(|t| same(&t)).unwrap() as u32
    };
    let mut members: Vec<(u32, u32)> = Vec::new();
    for patch in 0..set.count() {
        set.keys(patch, &mut |key| members.push((patch as u32, place(&key))));
    }
    let mut all: Vec<u32> = members.iter().map(|m| m.1).collect();
    all.sort_unstable();
    let region: Vec<u32> = (0..mesh.tets.len() as u32)
        .filter(|e| mesh.regions[*e as usize] == part.region)
        .collect();
    assert_eq!(all, region);
    // The edits of these tests leave many elements alone.
    assert!(
        region.len() > 2 * set.count(),
        "{} in {}",
        region.len(),
        set.count()
    );
    members.sort_unstable();
    anew.sets[number] = part.build_patches(mesh, &members).unwrap();
}

/// The index of an edited body is the rebuilt one, up to the order of its entries.
fn check_index(model: &TissueModel) {
    let mut kept = model.index().clone();
    let mut anew = Index::new(model.node_count(), model.tets(), model.sets());
    kept.sort();
    anew.sort();
    assert_eq!(kept, anew);
}

#[test]
fn a_large_body_is_edited_in_parts() {
    use crate::executor::Serial;
    use crate::forces::Forces;
    use crate::state::Control;
    let mut mesh = layers([9, 9, 9]);
    let mut clamped = vec![false; mesh.positions.len()];
    let material = springs(SpringForm::Fitted {
        young: 1e4,
        poisson: 0.3,
    });
    let mut edited = build(&mesh, [material; 2], &clamped);
    assert_eq!(edited.parts().len(), 8);
    let mut next = numbers();
    for _ in 0..20 {
        let mut edit = by_hand::random(&mesh, &clamped, &mut next);
        mesh = edit.finish();
        edit.apply(&mesh, &mut edited).unwrap();
        clamped = vec![false; mesh.positions.len()];
    }
    let anew = build(&mesh, [material; 2], &clamped);
    let mut state = State::at_rest(&edited);
    for p in &mut state.positions {
        *p += Vector3::new(next(), next(), next()) * 0.01;
    }
    let control = Control::default();
    let forces = |model: &TissueModel| {
        let mut forces = Forces::new(model);
        forces.compute(model, &state, &control, &Serial).to_vec()
    };
    let (a, b) = (forces(&edited), forces(&anew));
    let scale = b.iter().map(|f| f.amax()).fold(0.0, f64::max);
    for (a, b) in a.iter().zip(&b) {
        assert!((a - b).amax() <= ROUNDING * scale);
    }
}

/// A model that is shared keeps what it was.
#[test]
fn an_edit_does_not_reach_clones() {
    let mesh = layers([2, 2, 2]);
    let clamped = clamps(&mesh);
    let material = continuum(Discretisation::Selective);
    let original = build(&mesh, [material; 2], &clamped);
    let (mut edited, before) = (original.clone(), bits(&original));
    let mut edit = ByHand::new(&mesh);
    edit.divide(mesh.edges()[20], 0.4, false);
    let after = edit.finish();
    edit.apply(&after, &mut edited).unwrap();
    assert_eq!(bits(&original), before);
    check_index(&original);
}

#[test]
fn what_cannot_be_is_refused_and_changes_nothing() {
    let mesh = layers([2, 2, 2]);
    let clamped = clamps(&mesh);
    let material = continuum(Discretisation::Selective);
    let mut model = build(&mesh, [material; 2], &clamped);
    let before = bits(&model);
    let mut edit = ByHand::new(&mesh);
    let edge = mesh.edges()[20];
    edit.divide(edge, 0.4, false);
    let after = edit.finish();
    let good = edit.edit(&after);
    let mut refused = |edit: &ModelEdit<'_>| {
        let error = model.edit(edit).unwrap_err();
        assert_eq!(bits(&model), before, "{error}");
        check_index(&model);
        error
    };
    let first = edit.replaced[0];
    for replaced in [vec![first, first], vec![10_000]] {
        let error = refused(&ModelEdit {
            replaced,
            ..good.clone()
        });
        assert!(matches!(error, EditError::Number { of: "element", .. }));
    }
    let new_nodes = vec![(edge, 1.5)];
    let error = refused(&ModelEdit {
        new_nodes,
        ..good.clone()
    });
    assert!(matches!(
        error,
        EditError::Fraction {
            node: 0,
            fraction: 1.5
        }
    ));
    let error = refused(&ModelEdit {
        clamped: Vec::new(),
        ..good.clone()
    });
    assert!(matches!(
        error,
        EditError::Count {
            of: "clamp flags",
            ..
        }
    ));
    let error = refused(&ModelEdit {
        mesh: &mesh,
        ..good.clone()
    });
    assert!(matches!(error, EditError::Count { of: "nodes", .. }));
    let mut other = after.clone();
    other.regions[first as usize] = 5;
    let error = refused(&ModelEdit {
        mesh: &other,
        ..good.clone()
    });
    assert_eq!(
        error,
        EditError::Region {
            element: first,
            region: 5
        }
    );
    let mut flat = after.clone();
    let node = *flat.positions.last().unwrap();
    let corner = flat.tets[first as usize]
        .iter()
        .find(|n| !edge.contains(n))
        .unwrap();
    *flat.positions.last_mut().unwrap() = flat.positions[*corner as usize] + (node - node);
    let error = refused(&ModelEdit {
        mesh: &flat,
        ..good.clone()
    });
    assert!(matches!(error, EditError::Volume { .. }), "{error}");
    // A new node that nothing uses.
    let mut loose = ByHand::new(&mesh);
    loose.new_nodes.push(([0, 0], 0.0));
    loose.clamped.push(false);
    let mut with = mesh.clone();
    with.positions.push(mesh.positions[0]);
    let error = refused(&loose.edit(&with));
    let node = mesh.positions.len() as u32;
    assert_eq!(error, EditError::Node { node, elements: 0 });
    // A node that leaves while elements stay at it.
    let mut taken = ByHand::new(&mesh);
    taken.removed_nodes.push(node - 1);
    let mut without = mesh.clone();
    without.positions.pop();
    assert!(matches!(
        refused(&taken.edit(&without)),
        EditError::Node { .. }
    ));

    let mut union = TissueModel::union(&[&model, &model]);
    assert_eq!(union.edit(&good).unwrap_err(), EditError::Union);
    let sets = model.sets().to_vec();
    let densities = vec![1.0; mesh.tets.len()];
    let mut foreign = TissueModel::new(&mesh, &densities, &clamped, sets, 0.0).unwrap();
    assert_eq!(
        foreign.edit(&good).unwrap_err(),
        EditError::Foreign { set: 0 }
    );
}
