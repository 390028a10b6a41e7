//! Solvers that follow, against new ones; real cuts.

use super::*;
use crate::executor::Serial;
use crate::method::Method;
use crate::newton::Newton;
use crate::stability::stable_step;
use crate::state::Control;
use microsim_cutting::{Blade, Settings, Sheet, Stroke, Topology};
use microsim_mesh::TopologyEdit;

/// Cuts a mesh by a quad where its nodes are; none where it crosses nothing.
fn try_cut(
    mesh: &mut TetMesh,
    topology: &mut Topology,
    positions: &[Vector3<f64>],
    quad: [[f64; 3]; 4],
) -> Option<TopologyEdit> {
    let [a, b, c, d] = quad.map(Vector3::from);
    let sheet = Sheet::quad([a, b], [c, d]);
    let blade = Blade::Sheet {
        sheet: &sheet,
        positions,
    };
    let cut = topology.cut(mesh, &mut Stroke::new(), &blade, &Settings::default());
    let edit = cut.unwrap()?.edit;
    mesh.apply(&edit).unwrap();
    Some(edit)
}

fn cut(
    mesh: &mut TetMesh,
    topology: &mut Topology,
    positions: &[Vector3<f64>],
    quad: [[f64; 3]; 4],
) -> TopologyEdit {
    try_cut(mesh, topology, positions, quad).expect("the quad crosses the body")
}

const INTO: [[f64; 3]; 4] = [
    [0.07, -1.0, 0.11],
    [0.07, -1.0, 1.0],
    [0.1, 0.13, 0.07],
    [0.1, 0.13, 1.0],
];
const THROUGH: [[f64; 3]; 4] = [
    [-1.0, 0.21, -1.0],
    [1.0, 0.17, -1.0],
    [-1.0, 0.24, 1.0],
    [1.0, 0.19, 1.0],
];

/// Swinging bodies are cut in part and then through. A solver that follows goes on like a new one, to the bit, and the body stays whole where
/// no blade was.
#[test]
fn a_solver_that_follows_is_a_new_one() {
    let newton = Newton::default();
    let springs = springs(SpringForm::Fitted {
        young: 2e4,
        poisson: 0.4,
    });
    let once = Newton {
        iterations: 1,
        must_converge: false,
        ..newton
    };
    let methods = [
        Method::StoermerVerlet,
        Method::SymplecticEuler,
        Method::VelocityVerlet,
        Method::VelocityVerletLagged,
        Method::Xpbd {
            substeps: 2,
            iterations: 1,
        },
        Method::ImplicitEuler(once),
        Method::GuardedMidpoint(once),
        Method::Sdirk2(once),
        Method::QuasiStatic(once),
    ];
    for method in methods {
        let mut mesh = layers([3, 3, 3]);
        let clamped = clamps(&mesh);
        let mut model = build(&mesh, [springs; 2], &clamped);
        let h = stable_step(&model, 0.2);
        let (mut state, mut topology) = (State::at_rest(&model), Topology::new(&mesh));
        let mut solver = method.solver(&model).unwrap();
        let mut control = Control::default();
        control.gravity.z = -0.1;
        for quad in [INTO, THROUGH] {
            for _ in 0..3 {
                solver
                    .step(&model, &mut state, &control, &[], h, &Serial)
                    .unwrap();
            }
            let edit = cut(&mut mesh, &mut topology, &state.positions, quad);
            let change = model
                .edit(&ModelEdit::new(&mesh, &edit, model.clamped()))
                .unwrap();
            state.edit(&change);
            solver.follow(&model);
            let mut anew = method.solver(&model).unwrap();
            let mut other = state.clone();
            for _ in 0..3 {
                let now = solver.step(&model, &mut state, &control, &[], h, &Serial);
                let then = anew.step(&model, &mut other, &control, &[], h, &Serial);
                assert_eq!(now, then, "{method:?}");
                assert_eq!(state, other, "{method:?}");
            }
            assert_eq!(**model.components(), anew_components(&model));
        }
        // The half that no clamp holds has come off.
        assert!(model.components().lowest.len() > 1, "{method:?}");
    }
}

fn anew_components(model: &TissueModel) -> microsim_contact_solver::Components {
    let mut copy = model.clone();
    copy.components = std::sync::OnceLock::new();
    (**copy.components()).clone()
}

/// The same contract as for edits by hand, for cuts with all that comes with them: two that are planned, then random ones.
#[test]
fn a_cut_body_is_the_one_built_of_the_mesh_after_the_cut() {
    cut_and_compare(3);
}

/// Cuts bodies of all materials so many times, and compares each time with one that is rebuilt.
fn cut_and_compare(cuts: usize) {
    for (number, material) in materials().into_iter().enumerate() {
        let mut mesh = layers([3, 3, 2]);
        let clamped = clamps(&mesh);
        let mut model = build(&mesh, [material; 2], &clamped);
        let (mut state, mut topology) = (State::at_rest(&model), Topology::new(&mesh));
        let mut next = numbers();
        for round in 0..cuts {
            let quad = match round {
                0 => INTO,
                1 => THROUGH,
                _ => [0; 4].map(|_| [next(), next(), next()]),
            };
            let Some(edit) = try_cut(&mut mesh, &mut topology, &state.positions, quad) else {
                continue;
            };
            let edit = ModelEdit::new(&mesh, &edit, model.clamped());
            let change = model.edit(&edit).unwrap();
            state.edit(&change);
            // Nodes between clamped ones are clamped.
            let clamped = clamps(&mesh);
            let mut anew = build(&mesh, [material; 2], &clamped);
            if number == materials().len() - 1 {
                for set in [1, 3] {
                    check_patches(&model, &mut anew, &mesh, set);
                }
            }
            check_same(&model, &anew, &state.internal);
            check_index(&model);
            assert_eq!(**model.components(), anew_components(&model));
        }
    }
}

/// Edited members make the union that rebuilt members make.
#[test]
fn a_union_is_made_anew_of_edited_members() {
    let mut mesh = layers([3, 3, 2]);
    let clamped = clamps(&mesh);
    let material = continuum(Discretisation::Selective);
    let mut model = build(&mesh, [material; 2], &clamped);
    let other = build(
        &layers([2, 1, 2]),
        [material; 2],
        &clamps(&layers([2, 1, 2])),
    );
    let joint = TissueModel::union(&[&model, &other]);
    let before = bits(&joint);
    let mut topology = Topology::new(&mesh);
    let positions = mesh.positions.clone();
    let edit = cut(&mut mesh, &mut topology, &positions, THROUGH);
    let edit = ModelEdit::new(&mesh, &edit, model.clamped());
    model.edit(&edit).unwrap();
    assert_eq!(bits(&joint), before);
    let joint = TissueModel::union(&[&other, &model]);
    assert_eq!(
        joint.components().lowest.len(),
        1 + model.components().lowest.len()
    );
    assert_eq!(**joint.components(), anew_components(&joint));
    let mut energies = [0.0; 2];
    for (energy, model) in energies.iter_mut().zip([&joint, &model]) {
        let mut state = State::at_rest(model);
        let first = model.node_count() - mesh.positions.len();
        for p in &mut state.positions[first..] {
            p.x *= 1.1;
        }
        *energy = state.energies(model).strain;
    }
    assert!(energies[1] > 0.0 && (energies[0] / energies[1] - 1.0).abs() < ROUNDING);
}
