//! Fluid from tools: on what faces it, in a lumen, saved.

use super::*;
use microsim_mesh::{Arc, Layer, Tube, TubeSide};
use microsim_tissue::law::LawName;
use microsim_tissue::{ContinuumConstants, Discretisation};
use std::f64::consts::PI;

const PRESSURE: f64 = 1000.0;
const JET: f64 = 1e-3;
const REACH: f64 = 4e-3;

/// A thin tool whose fluid flows along its −z axis.
fn irrigator() -> ToolSpec {
    ToolSpec {
        name: "irrigator".into(),
        capsules: vec![CapsuleSpec::new(
            [0.0, 0.0, 0.1e-3],
            [0.0, 0.0, 10e-3],
            0.1e-3,
        )],
        sharpness: 0.0,
        jaw_stiffness: f64::INFINITY,
        irrigation: Some(IrrigationSpec {
            position: [0.0; 3],
            direction: [0.0, 0.0, -1.0],
            pressure: PRESSURE,
            radius: JET,
            reach: REACH,
        }),
        motion: Vec::new(),
    }
}

fn soft() -> Material {
    Material {
        density: 1000.0,
        relaxation_time: 0.0,
        behaviour: Behaviour::Continuum(ContinuumConstants {
            law: LawName::StableNeoHookean.into(),
            young: 1e5,
            poisson: 0.3,
            discretisation: Discretisation::Tetrahedra,
            plasticity: None,
        }),
    }
}

fn still(position: [f64; 3], opening: f64) -> ToolMotion {
    let at = Pose {
        position: position.into(),
        ..Pose::identity()
    };
    ToolMotion {
        tool: 0,
        from: at,
        to: at,
        opening_from: opening,
        opening_to: opening,
        active: true,
    }
}

/// A free block of which the upper face is 2 mm below the opening, half of the reach. The force on it is the integral of the pressure
/// over the face, half open p/2 (1 − 1/4)² ∫ (1 − (r/R)²)² dA = p/2 · 9/16 · π R²/3, and what it gives the block in a short time its
/// momentum. At cells of a sixteenth of the radius the sum over triangles has an error of the order of (1/16)².
#[test]
fn a_jet_presses_with_the_integral_of_its_pressure() {
    let block = Block {
        center: [0.0, 0.0, -0.5e-3],
        size: [3e-3, 3e-3, 1e-3],
        cells: [48, 48, 2],
        split: CellSplit::Kuhn,
    };
    let body = BodySpec::new("block", block.mesh().unwrap(), soft());
    let spec = SceneSpec {
        tools: vec![irrigator()],
        gravity: [0.0; 3],
        ..SceneSpec::new(vec![body], Method::SymplecticEuler)
    };
    let mut scene = Scene::new(&spec).unwrap();
    let tick = 20e-6;
    let steps = scene.required_steps(tick);
    let force = 0.5 * PRESSURE * (9.0 / 16.0) * PI * JET * JET / 3.0;
    for (position, opening, expected) in [
        ([0.1e-3, 0.0, 2e-3], 0.0, 0.0),
        ([0.1e-3, 0.0, 2e-3], 0.5, force),
        // Out of reach, and from below, where the other face is 1 mm away but the jet flows away from it.
        ([0.1e-3, 0.0, 4.1e-3], 0.5, 0.0),
        ([0.1e-3, 0.0, -2e-3], 0.5, 0.0),
    ] {
        scene.reset();
        let motion = still(position, opening);
        scene.tick(&[motion], tick, steps, &Serial).unwrap();
        let momentum = Vector3::from(scene.body(0).momentum());
        let error = (momentum + Vector3::z() * expected * tick).norm();
        assert!(error <= force * tick / 256.0, "{momentum} {expected}");
    }
}

/// A real cut through a section of the lumen: the pieces are then put apart, at rest but for a gap of 2 mm. From the middle of section 2 the
/// pressure falls evenly to the beginning of section 5, which is open, and there is none in the other piece.
#[test]
fn fluid_leaves_where_a_blade_has_divided_the_vessel() {
    let mut spec = vessel(Method::StoermerVerlet);
    let edge = CapsuleSpec {
        lonor: true,
        ..CapsuleSpec::new([0.0, -3e-3, 0.0], [0.0, 3e-3, 0.0], 0.05e-3)
    };
    spec.tools[0] = ToolSpec {
        name: "blade".into(),
        capsules: vec![edge],
        irrigation: None,
        ..irrigator()
    };
    spec.cuts = vec![CutSpec::new("vessel", "blade")];
    let mut scene = Scene::new(&spec).unwrap();
    let (tick, steps) = (1e-3, scene.required_steps(1e-3));
    let place = |k: i32| Pose {
        position: Vector3::new(2e-3 - 0.1e-3 * f64::from(k), 0.0, 1.5e-3),
        ..Pose::identity()
    };
    for k in 0..40 {
        let motion = ToolMotion {
            from: place(k),
            to: place(k + 1),
            ..still([0.0; 3], 0.0)
        };
        scene.tick(&[motion], tick, steps, &Serial).unwrap();
    }
    let body = &scene.bodies[0];
    assert_eq!(body.pieces.count(), 2);
    let held = body.pieces.of_nodes[body.model.clamped()[0] as usize];
    let nodes = body.mesh.positions.iter().zip(&body.pieces.of_nodes);
    let apart = |(place, piece): (&Vector3<f64>, &u32)| match *piece == held {
        true => *place,
        false => place + Vector3::z() * 2e-3,
    };
    let apart: Vec<Vector3<f64>> = nodes.map(apart).collect();
    let (lumen, mut sections) = (body.lumen.as_ref().unwrap(), Vec::new());
    let source = Vector3::new(0.0, 0.0, -1.5e-3);
    assert!(lumen.holds(&source, &apart));
    lumen.pressures(&source, 1.0, &apart, &mut sections);
    for (k, section) in sections.iter().enumerate() {
        let expected = match k {
            0..=2 => (k as f64 + 0.5) / 2.5,
            _ => ((4.5 - k as f64) / 2.5).max(0.0),
        };
        let error = (section.pressure - expected).abs();
        assert!(error < 1e-9, "{k}: {section:?} {expected}");
    }
}

/// A vessel along z, its lower end held, with the opening in the middle of its lumen.
fn vessel(method: Method) -> SceneSpec {
    let tube = Tube {
        center: [0.0; 3],
        axis: [0.0, 0.0, 1.0],
        inner_radius: 1e-3,
        layers: vec![Layer {
            thickness: 0.2e-3,
            cells: 1,
            region: 0,
        }],
        length: 8e-3,
        around: 16,
        along: 8,
        arc: Arc::Full,
        split: CellSplit::Mirrored,
    };
    let mesh = tube.mesh().unwrap();
    let lumen = LumenSpec {
        triangles: tube.side(&mesh, TubeSide::Inner).triangles,
        axis: tube.axis,
        sections: 8,
    };
    let body = BodySpec {
        drag: 500.0,
        clamps: vec![ClampSpec {
            nodes: Selection::Box(BoxSpec {
                min: [-1.0, -1.0, -4.1e-3],
                max: [1.0, 1.0, -3.9e-3],
            }),
            motion: None,
            release: None,
        }],
        lumen: Some(lumen),
        ..BodySpec::new("vessel", mesh, soft())
    };
    SceneSpec {
        tools: vec![irrigator()],
        gravity: [0.0; 3],
        ..SceneSpec::new(vec![body], method)
    }
}

/// Mean change of the radius of the vessel at a height \[m\].
fn widening(scene: &Scene, z: f64) -> f64 {
    let body = scene.body(0);
    let nodes = body.positions().iter().zip(body.model().rest_positions());
    let at = nodes.filter(|(_, rest)| (rest.z - z).abs() < 1e-6);
    let radius = |p: &Vector3<f64>| p.xy().norm();
    let changes: Vec<f64> = at.map(|(now, rest)| radius(now) - radius(rest)).collect();
    changes.iter().sum::<f64>() / changes.len() as f64
}

/// The wall is widened where the fluid is, and less towards the free end, where it leaves; in explicit and implicit methods alike. Once
/// the valve is closed it comes back. Saved meanwhile, it goes on with the same bits.
#[test]
fn a_lumen_is_widened_and_comes_back() {
    let newton = Newton {
        iterations: 10,
        tolerance: 1e-8,
        must_converge: false,
    };
    let mut found = Vec::new();
    for method in [Method::ImplicitEuler(newton), Method::StoermerVerlet] {
        let spec = vessel(method);
        let mut scene = Scene::new(&spec).unwrap();
        let (tick, steps) = (1e-3, scene.required_steps(1e-3));
        let run = |scene: &mut Scene, ticks: u32, opening: f64| {
            for _ in 0..ticks {
                let motion = still([0.0, 0.0, -0.5e-3], opening);
                scene.tick(&[motion], tick, steps, &Serial).unwrap();
            }
        };
        run(&mut scene, 5, 0.0);
        assert!(widening(&scene, 0.0).abs() < 1e-15);
        run(&mut scene, 60, 1.0);
        let [middle, end] = [0.0, 4e-3].map(|z| widening(&scene, z));
        assert!(
            middle > 0.0 && end > 0.0 && end < 0.5 * middle,
            "{middle} {end}"
        );
        found.push(middle);

        let mut copy = Scene::new(&spec).unwrap();
        copy.restore(&scene.save()).unwrap();
        run(&mut scene, 5, 0.7);
        run(&mut copy, 5, 0.7);
        assert_eq!(scene.save(), copy.save());

        run(&mut scene, 100, 0.0);
        assert!(widening(&scene, 0.0).abs() < 1e-3 * middle);
    }
    // Both are at the same equilibrium.
    assert!((found[0] / found[1] - 1.0).abs() < 1e-2, "{found:?}");
}

#[test]
fn fluid_without_meaning_is_refused() {
    let mut spec = vessel(Method::StoermerVerlet);
    let mut refused = |change: &dyn Fn(&mut IrrigationSpec)| {
        spec.tools = vec![irrigator()];
        let of = spec.tools[0].irrigation.as_mut().unwrap();
        change(of);
        let text = Scene::new(&spec).unwrap_err().to_string();
        assert!(text.starts_with("the fluid of tool 'irrigator'"), "{text}");
    };
    refused(&|of| of.pressure = -1.0);
    refused(&|of| of.radius = 0.0);
    refused(&|of| of.reach = f64::NAN);
    refused(&|of| of.direction = [0.0; 3]);
    // Squares that are 0, or infinite.
    refused(&|of| of.direction = [0.0, 1e-200, 0.0]);
    refused(&|of| of.direction = [0.0, 1e200, 0.0]);
    refused(&|of| of.position[1] = f64::INFINITY);
    let mut spec = vessel(Method::StoermerVerlet);
    spec.bodies[0].lumen.as_mut().unwrap().sections = 0;
    let text = Scene::new(&spec).unwrap_err().to_string();
    assert!(text.starts_with("the lumen of body 'vessel'"), "{text}");
}
