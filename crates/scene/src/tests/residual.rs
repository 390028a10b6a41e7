//! Bodies with residual stress: they begin in equilibrium, draw back when they are let go, and are refused where nothing holds them.

use super::*;
use microsim_tissue::elements::ContinuumPlasticity;
use microsim_tissue::law::LawName;
use microsim_tissue::{BuildError, ContinuumConstants, Discretisation};
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

/// The same with plastic flow from this strain on.
fn flowing_bar(discretisation: Discretisation, yield_strain: f64) -> BodySpec {
    let mut body = bar(discretisation, None);
    if let Behaviour::Continuum(constants) = &mut body.materials[0].1.behaviour {
        constants.plasticity = Some(ContinuumPlasticity {
            yield_strain,
            yield_growth: 0.0,
            creep_rate: None,
            max_strain: 1.0,
            hardening: 0.0,
            max_stiffening: 1.0,
        });
    }
    body
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

/// The equivalent strain of stretches ℓ, q, q is ⅔ ln(ℓ/q). A bar that yields beyond it stays under its stress; one that yields before it
/// would lose it in the first step, and is refused.
#[test]
fn residual_stress_does_not_flow_away() {
    let strain = 2.0 / 3.0 * (STRETCH / side()).ln();
    for discretisation in Discretisation::ALL {
        let mut scene = scene(flowing_bar(discretisation, strain + 1e-3)).unwrap();
        let start = scene.body(0).energies();
        for _ in 0..3 {
            scene.tick(&[], 5e-3, 1, &Serial).unwrap();
        }
        let now = scene.body(0).energies();
        assert_eq!(now.dissipated, 0.0, "{discretisation:?}");
        assert!((now.elastic() / start.elastic() - 1.0).abs() < 1e-6);
    }
    let refused = scene(flowing_bar(Discretisation::Selective, strain - 1e-3)).unwrap_err();
    let SceneError::Build {
        source: BuildError::YieldsAtRest { strain: found, .. },
        ..
    } = refused
    else {
        panic!("{refused}");
    };
    assert!((found - strain).abs() < 1e-12, "{found} {strain}");
}

/// Cut through by a blade between its clamps, with an explicit method, each part draws back to its natural length. Energy only falls: Störmer–Verlet measures a
/// mode too high by hω/2 at most, and the modes that carry it are those of a length of 3 mm, ω = π/2 √(E/ρ)/3 mm = 2.8e3 1/s, with steps below 0.05 ms
/// 7 %. What is left of it is where clamps hold the section wide, a width at each end of six, with (1 − q)² / (ℓ − 1)² of the energy density: 6 %.
#[test]
fn a_stretched_bar_that_is_cut_draws_back_into_its_parts() {
    let mut body = bar(Discretisation::Selective, None);
    body.drag = 400.0;
    let edge = CapsuleSpec {
        lonor: true,
        ..CapsuleSpec::new([0.0, -2e-3, 0.0], [0.0, 2e-3, 0.0], 5e-5)
    };
    let blade = ToolSpec {
        name: "blade".into(),
        capsules: vec![edge],
        sharpness: 0.0,
        jaw_stiffness: f64::INFINITY,
        irrigation: None,
        motion: Vec::new(),
    };
    let mut scene = Scene::new(&SceneSpec {
        tools: vec![blade],
        cuts: vec![CutSpec::new("bar", "blade")],
        gravity: [0.0; 3],
        ..SceneSpec::new(vec![body], Method::StoermerVerlet)
    })
    .unwrap();
    // Room for what cuts add.
    let prestretches = &scene.bodies[0].mesh.prestretches;
    assert!(prestretches.capacity() >= prestretches.len() * 3 / 2);
    let first = scene.body(0).energies().total();
    let mut last = first;
    for k in 0..120 {
        let at = |k: usize| Pose {
            position: Vector3::new(0.12e-3, 0.0, 1e-3 - 1e-4 * k.min(20) as f64),
            ..Pose::identity()
        };
        let motion = ToolMotion {
            tool: 0,
            from: at(k),
            to: at(k + 1),
            opening_from: 0.0,
            opening_to: 0.0,
            active: true,
        };
        let steps = scene.required_steps(1e-3);
        assert!(1e-3 / f64::from(steps) < 0.05e-3);
        scene.tick(&[motion], 1e-3, steps, &Serial).unwrap();
        last = scene.body(0).energies().total();
        assert!(last < 1.07 * first, "{k} {last} {first}");
    }
    assert_eq!(scene.body(0).piece_count(), 2);
    assert!(last < 0.06 * first, "{last} {first}");
    let body = scene.body(0);
    let width = 1e-3 / side();
    for (piece, side) in [(0, -1.0), (1, 1.0)] {
        // From the clamp on: the far end at rest, and now.
        let nodes = body.pieces().iter().zip(body.rest_positions());
        let nodes = nodes.zip(body.positions());
        let of = nodes.filter(|((of, _), _)| **of == piece);
        let from_clamp = |x: f64| 0.5 * LENGTH - side * x;
        let lengths = of.map(|((_, rest), now)| (from_clamp(rest.x), from_clamp(now.x)));
        let longest = lengths.fold([0.0f64; 2], |[a, b], (rest, now)| [a.max(rest), b.max(now)]);
        let [rest, now] = longest;
        assert!((now - rest / STRETCH).abs() < 0.1 * width, "{rest} {now}");
    }
}
