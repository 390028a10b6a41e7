//! Bodies with residual stress: they begin in equilibrium, draw back when they are let go, and are refused where nothing holds them.

use super::*;
use microsim_tissue::law::LawName;
use microsim_tissue::{ContinuumConstants, Discretisation};
use nalgebra::Matrix3;

const YOUNG: f64 = 30e3;
const POISSON: f64 = 0.45;
const LENGTH: f64 = 6e-3;
const STRETCH: f64 = 1.4;

/// q of a neo-Hookean bar that is stretched by ℓ along its axis with free sides: μ (q² − 1) + λ ln(ℓ q²) = 0, by bisection.
fn side() -> f64 {
    let mu = YOUNG / (2.0 * (1.0 + POISSON));
    let lambda = 2.0 * mu * POISSON / (1.0 - 2.0 * POISSON);
    let (mut low, mut high) = (0.5f64, 1.0f64);
    for _ in 0..60 {
        let q = 0.5 * (low + high);
        match mu * (q * q - 1.0) + lambda * (STRETCH * q * q).ln() > 0.0 {
            true => high = q,
            false => low = q,
        }
    }
    0.5 * (low + high)
}

/// A bar along x that is clamped at its left end and held at the right one until `release`, stretched from its natural state by ℓ.
fn bar(discretisation: Discretisation, release: Option<f64>) -> BodySpec {
    let block = Block {
        center: [0.0; 3],
        size: [LENGTH, 1e-3, 1e-3],
        cells: [12, 2, 2],
        split: CellSplit::Kuhn,
    };
    let mut mesh = block.mesh().unwrap();
    if discretisation.is_quadratic() {
        mesh = mesh.refined().mesh;
    }
    let prestretch = Matrix3::from_diagonal(&Vector3::new(STRETCH, side(), side()));
    mesh.prestretches = vec![prestretch; mesh.tets.len()];
    let constants = ContinuumConstants {
        law: LawName::NeoHookean.into(),
        young: YOUNG,
        poisson: POISSON,
        discretisation,
        plasticity: None,
    };
    let material = Material {
        density: 1060.0,
        relaxation_time: 0.0,
        behaviour: Behaviour::Continuum(constants),
    };
    let end = |x: f64, release| ClampSpec {
        nodes: Selection::Box(BoxSpec {
            min: [x - 1e-6, -1.0, -1.0],
            max: [x + 1e-6, 1.0, 1.0],
        }),
        motion: None,
        release,
    };
    BodySpec {
        drag: 50.0,
        clamps: vec![end(-0.5 * LENGTH, None), end(0.5 * LENGTH, release)],
        ..BodySpec::new("bar", mesh, material)
    }
}

fn scene(body: BodySpec) -> Result<Scene, SceneError> {
    let newton = Newton {
        iterations: 20,
        tolerance: 1e-9,
        must_converge: false,
    };
    let mut spec = SceneSpec::new(vec![body], Method::ImplicitEuler(newton));
    spec.gravity = [0.0; 3];
    Scene::new(&spec)
}

/// With sides that are free of stress the state is in equilibrium as it lies, with any elements: nothing moves, and the clamp bears P = μ (ℓ −
/// 1/ℓ) + λ ln(ℓ q²)/ℓ times the section q² smaller than that of the mesh.
#[test]
fn a_stretched_bar_is_at_rest_between_its_clamps() {
    let mu = YOUNG / (2.0 * (1.0 + POISSON));
    let lambda = 2.0 * mu * POISSON / (1.0 - 2.0 * POISSON);
    let stress =
        mu * (STRETCH - 1.0 / STRETCH) + lambda * (STRETCH * side() * side()).ln() / STRETCH;
    let expected = stress * 1e-6 / (side() * side());
    for discretisation in Discretisation::ALL {
        let mut scene = scene(bar(discretisation, None)).unwrap();
        let begins = scene.body(0).initial_equilibrium().expect("prestretched");
        // Nothing to move, but for rounding of the forces.
        assert!(begins.shift < 1e-11 && begins.residual < 1e-9, "{begins:?}");
        scene.tick(&[], 5e-3, 1, &Serial).unwrap();
        let body = scene.body(0);
        let forces = body.forces();
        let held = body.mesh().positions.iter().zip(&forces);
        let held = held.filter(|(place, _)| place.x > 0.4999 * LENGTH);
        let force: f64 = held.map(|(_, force)| force.x).sum();
        assert!(
            (force + expected).abs() < 1e-6 * expected,
            "{discretisation:?} {force} {expected}"
        );
        let moved = body.positions().iter().zip(&body.mesh().positions);
        let moved = moved.map(|(now, rest)| (now - rest).norm());
        assert!(moved.fold(0.0, f64::max) < 1e-10);
    }
}

/// Let go it draws back to its natural length L/ℓ; near the clamp, where the section cannot grow, it is as St Venant has it, so the end is at
/// least half a width off at most.
#[test]
fn a_stretched_bar_draws_back_when_it_is_let_go() {
    let mut scene = scene(bar(Discretisation::Selective, Some(5e-3))).unwrap();
    for _ in 0..60 {
        scene.tick(&[], 5e-3, 1, &Serial).unwrap();
    }
    let end = scene
        .body(0)
        .positions()
        .iter()
        .map(|p| p.x)
        .fold(f64::MIN, f64::max);
    let expected = -0.5 * LENGTH + LENGTH / STRETCH;
    let width = 1e-3 / side();
    assert!((end - expected).abs() < 0.1 * width, "{end} {expected}");
    let speed = scene.body(0).velocities().iter().map(|v| v.norm());
    assert!(speed.fold(0.0, f64::max) < 1e-4);
}

#[test]
fn without_equilibrium_it_is_refused() {
    let mut loose = bar(Discretisation::Tetrahedra, None);
    loose.clamps.clear();
    let error = scene(loose).unwrap_err();
    assert!(
        error.to_string().contains("nothing holds a part"),
        "{error}"
    );
    // Held at one end it would draw back by 1.7 mm.
    let mut held = bar(Discretisation::Tetrahedra, None);
    held.clamps.truncate(1);
    let error = scene(held).unwrap_err();
    assert!(error.to_string().contains("beside their places"), "{error}");
    let mut torn = bar(Discretisation::Tetrahedra, None);
    torn.mesh.prestretches[7] = -Matrix3::identity();
    let error = scene(torn).unwrap_err();
    assert!(
        error.to_string().contains("prestretch of element 7"),
        "{error}"
    );
}
