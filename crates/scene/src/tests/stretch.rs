//! Tissue that stiffens as it is drawn out, in explicit methods.

use super::*;
use crate::body::limited_step;
use crate::{Runner, scene_spec};
use microsim_settings as settings;
use microsim_tissue::elements::ContinuumPlasticity;
use microsim_tissue::law::LawName;
use microsim_tissue::stability::WORKING_STRETCH;
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

/// A bar of a wall of collagen, fibres along it, that is drawn out in 60 ms to a length of `stretch` times that at rest, with steps of `step` \[s\].
fn wall(stretch: f64, step: f64) -> Runner {
    let shift = (stretch - 1.0) * LENGTH;
    let text = format!(
        "title = {{ en = 'a' }}\nsummary = {{ en = 'b' }}\n\
         run = {{ duration = 0.08, step = {step:?}, sample = 0.001, gravity = [0, 0, 0] }}\n\
         method = {{ name = 'stoermer-verlet' }}\n[[body]]\nname = 'wall'\ngenerator = 'block'\nsize = [{LENGTH:?}, 0.002, 0.002]\n\
         cells = [6, 2, 2]\ndrag = 2000\n\
         material = [{{ density = 1000, law = 'holzapfel-gasser-ogden', youngs_modulus = 10e3, poisson_ratio = 0.3, \
         fibre_stiffness = 20e3, fibre_exponent = 0.84, fibre_dispersion = 0, \
         fibres = {{ direction = [1, 0, 0], second_direction = [1, 0, 0] }} }}]\n\
         clamp = [{{ nodes = {{ min = [-0.005, -1, -1], max = [-0.005, 1, 1] }} }}, \
         {{ nodes = {{ min = [0.005, -1, -1], max = [0.005, 1, 1] }}, motion = [{{ time = 0.06, shift = [{shift:?}, 0, 0] }}] }}]\n"
    );
    let read = settings::read_scene(&text, "wall.toml", &[]);
    let read = read.unwrap_or_else(|errors| panic!("{errors}")).settings;
    let none = &mut |_: &std::path::Path| Err(std::io::ErrorKind::NotFound.into());
    let spec = scene_spec(&read, none).expect("a scene").spec;
    let scene = Scene::new(&spec).expect("a wall");
    Runner::new(&read, scene).expect("no probes")
}

/// With the planned step the wall is drawn out to the working stretch without a shorter one. With that which is stable at rest it is not, and the
/// run has it that steps became shorter, at the end to between 0.4 and 0.8 of the limit of the drawn shape.
#[test]
fn the_planned_step_lasts_up_to_the_working_stretch() {
    let (at_rest, planned) = {
        let runner = wall(WORKING_STRETCH, 1e-5);
        let body = runner.scene().body(0);
        assert_eq!(body.working_stretch(), WORKING_STRETCH);
        (body.stable_step(), body.planned_step())
    };
    // 4 λ² (1 + 2 k2 E²) exp(k2 E²) = 118 times as stiff along the fibres at E = λ² − 1 = 1.25 as they are at rest, 4; with the
    // matrix, and the step that goes with the root, between a half and a tenth.
    assert!(planned < 0.5 * at_rest && planned > 0.1 * at_rest);
    let run = |step: f64| {
        let mut runner = wall(WORKING_STRETCH, step);
        runner.run(&Serial, &mut |_| true);
        assert_eq!(runner.end(), Some(&crate::End::Duration));
        runner
    };
    assert_eq!(run(planned).remarks().stiffened, None);
    let runner = run(at_rest);
    let stiffened = runner.remarks().stiffened.expect("too long at work");
    let scene = runner.scene();
    let longest = limited_step(
        &scene.method,
        &scene.bodies[0].model,
        &scene.state.bodies[0],
    );
    let shortest = stiffened.shortest_step;
    assert!(stiffened.ticks > 10 && stiffened.since < 0.06);
    assert!(shortest < 0.8 / 0.6 * longest && shortest > 0.4 / 0.6 * longest);
}

/// Drawn out by the scene to twice its length a wall works at that stretch; drawn out to less than the working stretch, at this.
#[test]
fn what_a_scene_prescribes_beyond_it_is_the_working_stretch() {
    for (prescribed, working) in [(2.0, 2.0), (1.2, WORKING_STRETCH), (0.8, WORKING_STRETCH)] {
        let runner = wall(prescribed, 1e-5);
        let body = runner.scene().body(0);
        assert!((body.prescribed_stretch() - f64::max(prescribed, 1.0)).abs() < 1e-12);
        assert!((body.working_stretch() - working).abs() < 1e-12);
        assert_eq!(
            body.working_step(),
            body.stretched_step(body.working_stretch())
        );
    }
}

/// Beside a body of a ten-thousandth of its modulus, whose steps at rest are about 100 times as long, the bar stiffens as it does alone; and both have
/// their steps at rest again when it is let go.
#[test]
fn a_soft_body_beside_what_stiffens_has_its_steps_back() {
    let method = Method::StoermerVerlet;
    let mut spec = bar(method);
    let mut soft = BodySpec {
        origin: [0.0, 10.0 * SIDE, 0.0],
        clamps: Vec::new(),
        ..spec.bodies[0].clone()
    };
    soft.name = "soft".into();
    for place in &mut soft.mesh.positions {
        place.y += 10.0 * SIDE;
    }
    let Behaviour::Continuum(constants) = &mut soft.materials[0].1.behaviour else {
        panic!("a continuum");
    };
    constants.young = 1e-4 * YOUNG;
    spec.bodies.insert(0, soft);
    spec.contacts = vec![ContactSpec::new(
        "soft",
        PartnerSpec::Body {
            name: "bar".into(),
            end_planes: false,
        },
    )];
    let mut scene = Scene::new(&spec).unwrap();
    let at_rest = [0, 1].map(|body| scene.body(body).stable_step());
    assert!(at_rest[0] > 64.0 * at_rest[1], "{at_rest:?}");
    let tick = 1e-3;
    let steps = scene.required_steps(tick);
    let mut stiffened = false;
    while scene.time() < 3.0 * DRAWN - 0.5 * tick {
        stiffened |= scene.tick(&[], tick, steps, &Serial).unwrap().stiffened;
    }
    assert!(stiffened);
    assert_eq!([0, 1].map(|body| scene.body(body).stable_step()), at_rest);
    assert!(!scene.has_stiffened());
}

/// A tick of which the first try takes all of the budget but less than a repetition needs is not repeated in shorter steps: it is computed with
/// tools that stand, as any that fails.
#[test]
fn a_tick_is_not_repeated_in_shorter_steps_beyond_the_budget() {
    let method = Method::StoermerVerlet;
    let tick = 1e-3;
    let mut spec = bar(method);
    spec.containment = true;
    let run = |spec: &SceneSpec| {
        let mut scene = Scene::new(spec).unwrap();
        let steps = scene.required_steps(tick);
        let mut found = Vec::new();
        while scene.time() < DRAWN - 0.5 * tick {
            let before = scene.body(0).stable_step();
            let report = scene.tick(&[], tick, steps, &Serial).unwrap();
            if scene.body(0).stable_step() < before {
                found.push((report.stands, report.over_budget));
            }
        }
        let least = scene.groups[0].least_work(&scene.bodies, 0);
        (found, least * f64::from(steps))
    };
    let (free, least) = run(&spec);
    assert!(
        !free.is_empty() && free.iter().all(|of| *of == (false, false)),
        "{free:?}"
    );
    // A step that is too long is so by a third at least.
    spec.budget = Some(WorkBudget {
        tick: 1.2 * least / tick,
        mean: f64::INFINITY,
    });
    let (bound, _) = run(&spec);
    assert_eq!(bound[0], (true, true), "{bound:?}");
}

/// Drawn out to four times its length at a yield strain that grows as fast as the flow, the bar is thinner by the root of what has flowed, and
/// nothing in it is stiffer than at rest: its steps are below 0.8 of the limit of the drawn shape all the same, at each look.
#[test]
fn steps_become_shorter_where_flow_thins_tissue() {
    let method = Method::StoermerVerlet;
    let mut spec = bar(method);
    let most = 4.0;
    let motion = spec.bodies[0].clamps[1].motion.as_mut().unwrap();
    for key in &mut motion.keys[..2] {
        key.shift[0] = (most - 1.0) * LENGTH;
    }
    let Behaviour::Continuum(constants) = &mut spec.bodies[0].materials[0].1.behaviour else {
        panic!("a continuum");
    };
    constants.law = LawName::StableNeoHookean.into();
    constants.plasticity = Some(ContinuumPlasticity {
        yield_strain: 0.02,
        yield_growth: 0.2,
        creep_rate: None,
        max_strain: 1.4,
        hardening: 0.0,
        max_stiffening: 1.0,
    });
    let mut scene = Scene::new(&spec).unwrap();
    let tick = 1e-3;
    let steps = scene.required_steps(tick);
    let at_rest = scene.body(0).stable_step();
    let mut stiffened = false;
    while scene.time() < 1.5 * DRAWN - 0.5 * tick {
        stiffened |= scene.tick(&[], tick, steps, &Serial).unwrap().stiffened;
        let longest = limited_step(&method, &scene.bodies[0].model, &scene.state.bodies[0]);
        let now = scene.body(0).stable_step();
        // From one look to the next, of 32 steps, the bar is drawn out by at most 6.6 % of its length at rest: its limit falls by 3.3 %.
        assert!(now < 0.85 / 0.6 * longest, "{now} {longest} {at_rest}");
    }
    assert!(stiffened && scene.body(0).stable_step() < 0.75 * at_rest);
}
