//! A rigid sphere on an elastic block, without friction (Hertz 1882).
//!
//! Three expectations of different kinds: the force on the same mesh from the compliance matrix of its surface nodes with
//! complementarity, which shares no line with contact and its solvers; the closed form for a half-space; the exponent 3/2.

use microsim_geometry::Pose;
use microsim_mesh::{Block, CellSplit, TetMesh};
use microsim_scene::{
    BodySpec, BoxSpec, CapsuleSpec, ClampSpec, ContactSpec, PartnerSpec, Scene, SceneSpec,
    Selection, Serial, ToolMotion, ToolSpec,
};
use microsim_tests::system::System;
use microsim_tissue::elements::Tangent;
use microsim_tissue::law::LawName;
use microsim_tissue::{
    Behaviour, ContinuumConstants, Discretisation, Material, Method, Newton, State,
};
use nalgebra::Vector3;

/// Young's modulus \[Pa\] and Poisson's ratio.
const YOUNG: f64 = 1e5;
const POISSON: f64 = 0.3;

/// Radius of the sphere \[m\]. The contact is a fiftieth of it at most: strains below one per cent, where every law is that of Hooke.
const RADIUS: f64 = 0.02;

/// The largest contact radius a \[m\]; the indentation is a²/R.
const CONTACT_RADIUS: f64 = 0.4e-3;

/// Half the width of the block, and its height, in contact radii: at six the closed form may be asked for, and is 15 % off.
const SIZE: f64 = 12.0;

/// The edge of the cells under the sphere in contact radii, and by how much each next cell is longer.
const FINEST: f64 = 0.25;
const GROWTH: f64 = 1.3;

/// The coordinates of a graded half-axis: 0, then cells that grow, the last at `SIZE` radii.
fn graded() -> Vec<f64> {
    let mut at = vec![0.0];
    let mut cell = FINEST;
    while at[at.len() - 1] < SIZE {
        let last = at[at.len() - 1];
        at.push(last + cell);
        // The first four cells are equal: they are those the sphere touches.
        if at.len() > 5 {
            cell *= GROWTH;
        }
    }
    let scale = SIZE * CONTACT_RADIUS / at[at.len() - 1];
    at.iter().map(|x| x * scale).collect()
}

/// The block: its top is z = 0, fine around the origin.
fn block() -> TetMesh {
    let half = graded();
    let n = half.len() - 1;
    let mut mesh = Block {
        center: [0.0, 0.0, -0.5 * n as f64],
        size: [2.0 * n as f64, 2.0 * n as f64, n as f64],
        cells: [2 * n, 2 * n, n],
        split: CellSplit::Mirrored,
    }
    .mesh()
    .expect("a block");
    // Its coordinates are whole numbers of cells.
    for p in &mut mesh.positions {
        *p = p.map(|c| half[c.abs().round() as usize].copysign(c));
    }
    mesh
}

fn spec(mesh: TetMesh) -> SceneSpec {
    let depth = SIZE * CONTACT_RADIUS;
    let material = Material {
        density: 1000.0,
        relaxation_time: 0.0,
        behaviour: Behaviour::Continuum(ContinuumConstants {
            law: LawName::StableNeoHookean.into(),
            young: YOUNG,
            poisson: POISSON,
            discretisation: Discretisation::Tetrahedra,
            plasticity: None,
        }),
    };
    SceneSpec {
        bodies: vec![BodySpec {
            clamps: vec![ClampSpec {
                nodes: Selection::Box(BoxSpec {
                    min: [-1.0, -1.0, -1.0],
                    max: [1.0, 1.0, -depth * (1.0 - 1e-9)],
                }),
                motion: None,
                release: None,
            }],
            ..BodySpec::new("block", mesh, material)
        }],
        tools: vec![ToolSpec {
            name: "sphere".into(),
            capsules: vec![CapsuleSpec::new(
                [0.0, 0.0, RADIUS],
                [0.0, 0.0, 2.0 * RADIUS],
                RADIUS,
            )],
            sharpness: 0.0,
            jaw_stiffness: f64::INFINITY,
            irrigation: None,
            motion: Vec::new(),
        }],
        contacts: vec![ContactSpec::new(
            "block",
            PartnerSpec::Tool("sphere".into()),
        )],
        gravity: [0.0; 3],
        containment: false,
        repeat_unconverged: false,
        ..SceneSpec::new(
            Vec::new(),
            Method::QuasiStatic(Newton {
                iterations: 10,
                tolerance: 1e-5,
                must_converge: false,
            }),
        )
    }
}

/// The force at which a sphere stands `depth` \[m\] deep in the block \[N\], by the scene.
fn by_contact(scene: &mut Scene, depth: f64) -> f64 {
    scene.reset();
    let at = |z: f64| Pose {
        position: Vector3::new(0.0, 0.0, z),
        ..Pose::identity()
    };
    let mut force = 0.0;
    // Down in small ways, then a step in which nothing moves.
    let ways = 4;
    for step in 0..=ways {
        let height = |step: u32| -depth * f64::from(step.min(ways)) / f64::from(ways);
        let motion = ToolMotion {
            tool: 0,
            from: at(height(step)),
            to: at(height(step + 1)),
            opening_from: 0.0,
            opening_to: 0.0,
            active: true,
        };
        let report = scene.tick(&[motion], 0.01, 1, &Serial).expect("a tick");
        force = -report
            .contacts
            .first()
            .map_or(0.0, |c| c.force_on_tissue[2]);
    }
    force
}

/// The same from the linear compliance of the surface nodes near the contact and complementarity, by projected Gauss–Seidel.
struct Compliance {
    /// Places at rest of the nodes that may touch \[m\].
    places: Vec<Vector3<f64>>,
    /// Displacements of all of them by a unit force along the normal at each.
    normals: Vec<Vector3<f64>>,
    columns: Vec<Vec<Vector3<f64>>>,
}

impl Compliance {
    fn new(scene: &Scene) -> Self {
        let model = scene.body(0).model();
        let mut system = System::new(model);
        system.assemble(model, &State::at_rest(model), Tangent::Exact);
        let fixed: Vec<bool> = (0..model.node_count())
            .map(|node| model.is_clamped(node))
            .collect();
        system
            .solver
            .factorise(&system.matrix, &fixed)
            .expect("a clamped block");
        let rest = model.rest_positions();
        let near = |p: &Vector3<f64>| p.z.abs() < 1e-9 && p.xy().norm() < 1.15 * CONTACT_RADIUS;
        let nodes: Vec<usize> = (0..rest.len()).filter(|&node| near(&rest[node])).collect();
        let centre = Vector3::new(0.0, 0.0, RADIUS);
        let normals: Vec<_> = nodes
            .iter()
            .map(|&node| (rest[node] - centre).normalize())
            .collect();
        let columns = nodes
            .iter()
            .zip(&normals)
            .map(|(&node, normal)| {
                let mut x = vec![Vector3::zeros(); rest.len()];
                x[node] = *normal;
                system
                    .solver
                    .solve(&system.matrix, &mut x, 1e-8)
                    .expect("a positive matrix");
                nodes.iter().map(|&node| x[node]).collect()
            })
            .collect();
        Self {
            places: nodes.iter().map(|&node| rest[node]).collect(),
            normals,
            columns,
        }
    }

    /// The vertical force \[N\] and the number of touching nodes.
    fn force(&self, depth: f64) -> (f64, usize) {
        let n = self.places.len();
        let centre = Vector3::new(0.0, 0.0, RADIUS - depth);
        // Gap of each node along its normal, which points into the block; forces press along it.
        let gaps: Vec<f64> = self
            .places
            .iter()
            .zip(&self.normals)
            .map(|(place, normal)| (place - centre).dot(normal) - RADIUS)
            .collect();
        let entry = |i: usize, j: usize| self.normals[i].dot(&self.columns[j][i]);
        let mut forces = vec![0.0; n];
        for _ in 0..20_000 {
            let mut change = 0.0f64;
            let largest = forces.iter().copied().fold(0.0, f64::max);
            for i in 0..n {
                let gap = gaps[i] + (0..n).map(|j| entry(i, j) * forces[j]).sum::<f64>();
                let new = (forces[i] - gap / entry(i, i)).max(0.0);
                change = change.max((new - forces[i]).abs());
                forces[i] = new;
            }
            if change <= 1e-10 * largest {
                break;
            }
        }
        let vertical = forces
            .iter()
            .zip(&self.normals)
            .map(|(f, normal)| -f * normal.z)
            .sum();
        (vertical, forces.iter().filter(|f| **f > 0.0).count())
    }
}

/// F = 4/3 E* √R δ^(3/2).
fn hertz(depth: f64) -> f64 {
    let modulus = YOUNG / (1.0 - POISSON * POISSON);
    4.0 / 3.0 * modulus * RADIUS.sqrt() * depth * depth.sqrt()
}

#[test]
fn a_sphere_on_a_block_has_the_force_of_hertz() {
    let mut scene = Scene::new(&spec(block())).expect("a scene");
    let compliance = Compliance::new(&scene);
    let deepest = CONTACT_RADIUS * CONTACT_RADIUS / RADIUS;
    let mut found = Vec::new();
    for share in [0.5, 0.7, 1.0] {
        let depth = share * deepest;
        let force = by_contact(&mut scene, depth);
        let (exact, touching) = compliance.force(depth);
        println!(
            "{:.2} um: {:.4} uN, on the same mesh {:.4} ({touching} nodes), Hertz {:.4}",
            depth * 1e6,
            force * 1e6,
            exact * 1e6,
            hertz(depth) * 1e6
        );
        // 1 %: the issue's. What differs is strain (below 1 %) and, through it, the law.
        assert!(
            (force / exact - 1.0).abs() < 0.01,
            "{force} against {exact}"
        );
        // 15 %: the issue's, for a contact radius of three edges or more in a block of finite size.
        assert!((force / hertz(depth) - 1.0).abs() < 0.15);
        found.push((depth, force));
    }
    let (first, last) = (found[0], found[2]);
    let exponent = libm::log(last.1 / first.1) / libm::log(last.0 / first.0);
    println!("exponent {exponent:.3}");
    assert!((exponent - 1.5).abs() < 0.1, "{exponent}");
}
