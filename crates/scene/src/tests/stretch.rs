//! Tissue that stiffens as it is drawn out, in explicit methods.

use super::*;
use crate::body::limited_step;
use microsim_tissue::law::LawName;
use microsim_tissue::{ContinuumConstants, Discretisation};

const YOUNG: f64 = 1e5;
const LENGTH: f64 = 10e-3;
const SIDE: f64 = 2e-3;
/// From rest to the largest stretch, and back again \[s\].
const DRAWN: f64 = 60e-3;
const MOST: f64 = 2.5;

/// A bar of St Venant–Kirchhoff without lateral contraction that is drawn out to 2.5 times its length, held, and let go back. It is
/// damped so that it follows.
fn bar(method: Method) -> SceneSpec {
    let block = Block {
        center: [0.5 * LENGTH, 0.0, 0.0],
        size: [LENGTH, SIDE, SIDE],
        cells: [6, 2, 2],
        split: CellSplit::Mirrored,
    };
    let material = Material {
        density: 1000.0,
        relaxation_time: 0.0,
        behaviour: Behaviour::Continuum(ContinuumConstants {
            law: LawName::StVenantKirchhoff.into(),
            young: YOUNG,
            poisson: 0.0,
            discretisation: Discretisation::Tetrahedra,
            plasticity: None,
        }),
    };
    let end = |x: f64, motion| ClampSpec {
        nodes: Selection::Box(BoxSpec {
            min: [x - 1e-6, -1.0, -1.0],
            max: [x + 1e-6, 1.0, 1.0],
        }),
        motion,
        release: None,
    };
    let key = |time, shift: f64| MotionKey {
        time,
        shift: [shift, 0.0, 0.0],
        angle: 0.0,
    };
    let far = (MOST - 1.0) * LENGTH;
    let drawn = MotionSpec {
        pivot: [0.0; 3],
        axis: [1.0, 0.0, 0.0],
        keys: vec![
            key(DRAWN, far),
            key(1.5 * DRAWN, far),
            key(2.5 * DRAWN, 0.0),
        ],
    };
    SceneSpec {
        gravity: [0.0; 3],
        containment: false,
        ..SceneSpec::new(
            vec![BodySpec {
                drag: 2000.0,
                clamps: vec![end(0.0, None), end(LENGTH, Some(drawn))],
                ..BodySpec::new("bar", block.mesh().unwrap(), material)
            }],
            method,
        )
    }
}

/// Held at the stretch λ the clamp bears A E (λ³ − λ)/2, the first Piola–Kirchhoff stress of this law along a bar times its area at
/// rest. The steps are then between 0.4 and 0.8 of the limit of the drawn shape, and those at rest again when the bar is.
#[test]
fn steps_become_shorter_where_tissue_stiffens_and_longer_where_it_softens() {
    for method in [Method::StoermerVerlet, Method::SymplecticEuler] {
        let mut scene = Scene::new(&bar(method)).unwrap();
        let tick = 1e-3;
        let steps = scene.required_steps(tick);
        let at_rest = scene.body(0).stable_step();
        let run = |scene: &mut Scene, until: f64| {
            let mut stiffened = false;
            while scene.time() < until - 0.5 * tick {
                stiffened |= scene.tick(&[], tick, steps, &Serial).unwrap().stiffened;
            }
            stiffened
        };
        assert!(run(&mut scene, 1.5 * DRAWN));
        let force: f64 = {
            let body = scene.body(0);
            let forces = body.forces().into_iter().zip(body.positions());
            forces
                .filter(|(_, p)| p.x > 2.4 * LENGTH)
                .map(|(f, _)| f.x)
                .sum()
        };
        let expected = SIDE * SIDE * YOUNG * (MOST.powi(3) - MOST) / 2.0;
        assert!((-force / expected - 1.0).abs() < 1e-3, "{force} {expected}");
        let now = scene.body(0).stable_step();
        let longest = limited_step(&method, &scene.bodies[0].model, &scene.state.bodies[0]);
        assert!(now < 0.75 * at_rest, "{now} {at_rest}");
        assert!(
            now < 0.8 / 0.6 * longest && now > 0.4 / 0.6 * longest,
            "{now} {longest}"
        );

        // Saved while its steps are short, it goes on with the same bits.
        let mut copy = Scene::new(&bar(method)).unwrap();
        copy.restore(&scene.save()).unwrap();
        run(&mut scene, 3.0 * DRAWN);
        run(&mut copy, 3.0 * DRAWN);
        assert_eq!(scene.save(), copy.save());
        assert_eq!(scene.body(0).stable_step(), at_rest);
    }
}

/// A law that hardly stiffens (neo-Hookean: 1.5 times at the working stretch) has no guard: its steps are those at rest, and cost no look.
#[test]
fn what_the_safety_factor_covers_is_not_looked_at() {
    let mut spec = bar(Method::StoermerVerlet);
    let Behaviour::Continuum(constants) = &mut spec.bodies[0].materials[0].1.behaviour else {
        panic!("a continuum");
    };
    constants.law = LawName::StableNeoHookean.into();
    let mut scene = Scene::new(&spec).unwrap();
    let (tick, steps) = (1e-3, scene.required_steps(1e-3));
    let at_rest = scene.body(0).stable_step();
    for _ in 0..60 {
        assert!(!scene.tick(&[], tick, steps, &Serial).unwrap().stiffened);
    }
    assert_eq!(scene.body(0).stable_step(), at_rest);
}
