//! A tube that is spread and released, against an independent solution in one dimension: rings of the wall in principal stretches with the same
//! law and flow rule, their equilibrium by Newton's method with numerical derivatives, flow within the equilibrium (backward Euler), not after it.

use microsim_mesh::{Arc, CellSplit, Layer, Tube};
use microsim_tissue::elements::ContinuumPlasticity;
use microsim_tissue::law::LawName;
use microsim_tissue::{
    Behaviour, ContinuumConstants, Control, Discretisation, Material, Method, Newton, NodeTarget,
    Serial, State, build_model, flow,
};
use nalgebra::{DMatrix, DVector, Vector3};

/// The vessel of the scene `dilate-keep`: its sizes \[m\], its modulus \[Pa\] and its yield.
const INNER: f64 = 0.5e-3;
const WALL: f64 = 0.12e-3;
const SPREAD: f64 = 0.7e-3;
const YOUNG: f64 = 300e3;
const POISSON: f64 = 0.45;
const PLASTICITY: ContinuumPlasticity = ContinuumPlasticity {
    yield_strain: 0.05,
    yield_growth: 0.5,
    creep_rate: None,
    max_strain: 1.0,
    hardening: 0.0,
    max_stiffening: 1.0,
};

/// The mean change of the inner, middle and outer radius that the scene `dilate-keep` expects after the release \[m\].
const RETAINED_IN_SCENE: f64 = 95.58e-6;

/// The wall as rings, each with the logarithms of its plastic stretches (radial, around, along) and its accumulated plastic strain.
#[derive(Clone)]
struct Rings {
    /// At rest, between the rings \[m\].
    rest: Vec<f64>,
    /// Now; the last entry is the stretch along the axis.
    now: Vec<f64>,
    plastic: Vec<[f64; 3]>,
    strain: Vec<f64>,
}

impl Rings {
    fn new(count: usize) -> Self {
        let radius = |k: usize| INNER + WALL * k as f64 / count as f64;
        let rest: Vec<f64> = (0..=count).map(radius).collect();
        let mut now = rest.clone();
        now.push(1.0);
        Self {
            rest,
            now,
            plastic: vec![[0.0; 3]; count],
            strain: vec![0.0; count],
        }
    }

    /// Nominal stresses of a ring at these places \[Pa\], and its plastic logarithms and strain there.
    fn ring(&self, k: usize, at: &DVector<f64>) -> ([f64; 3], [f64; 3], f64) {
        let stretches = [
            (at[k + 1] - at[k]) / (self.rest[k + 1] - self.rest[k]),
            (at[k + 1] + at[k]) / (self.rest[k + 1] + self.rest[k]),
            at[self.now.len() - 1],
        ];
        let volume = libm::log(stretches.iter().product());
        let mut plastic = self.plastic[k];
        let elastic: [f64; 3] = std::array::from_fn(|i| libm::log(stretches[i]) - plastic[i]);
        let deviator = elastic.map(|log| log - volume / 3.0);
        let norm: f64 = deviator.iter().map(|d| d * d).sum();
        let equivalent = (norm * 2.0 / 3.0).sqrt();
        let growth = PLASTICITY.yield_growth;
        let over = equivalent - PLASTICITY.yield_strain - growth * self.strain[k];
        let flowing = (over / (1.0 + growth)).max(0.0);
        if flowing > 0.0 {
            for (log, d) in plastic.iter_mut().zip(deviator) {
                *log += flowing / equivalent * d;
            }
        }
        // Neo-Hookean (Bonet & Wood 2008, 6.4): Kirchhoff stresses μ (s² − 1) + λ ln J.
        let mu = YOUNG / (2.0 * (1.0 + POISSON));
        let lambda = YOUNG * POISSON / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON));
        let nominal = std::array::from_fn(|i| {
            let square = libm::exp(2.0 * (libm::log(stretches[i]) - plastic[i]));
            (mu * (square - 1.0) + lambda * volume) / stretches[i]
        });
        (nominal, plastic, self.strain[k] + flowing)
    }

    /// The derivative of the work by each place, over the angle and the length.
    fn forces(&self, at: &DVector<f64>) -> DVector<f64> {
        let mut forces = DVector::zeros(at.len());
        for k in 0..self.strain.len() {
            let ([radial, around, along], _, _) = self.ring(k, at);
            let thickness = self.rest[k + 1] - self.rest[k];
            let middle = 0.5 * (self.rest[k + 1] + self.rest[k]);
            forces[k] += 0.5 * thickness * around - middle * radial;
            forces[k + 1] += 0.5 * thickness * around + middle * radial;
            forces[at.len() - 1] += middle * thickness * along;
        }
        forces
    }

    /// Finds equilibrium with flow: with the inner radius and the length given, or with neither.
    fn solve(&mut self, inner: Option<f64>) {
        let last = self.now.len() - 1;
        let mut at = DVector::from_vec(self.now.clone());
        let free: Vec<usize> = match inner {
            Some(radius) => {
                at[0] = radius;
                at[last] = 1.0;
                (1..last).collect()
            }
            None => (0..=last).collect(),
        };
        // Radii are of the size of the wall, the stretch of the size of one.
        let scale = |entry: usize| if entry == last { 1.0 } else { WALL };
        for iteration in 0.. {
            assert!(iteration < 50, "no equilibrium of the rings");
            let forces = self.forces(&at);
            let mut jacobian = DMatrix::zeros(free.len(), free.len());
            for (column, &entry) in free.iter().enumerate() {
                let delta = 1e-7 * scale(entry);
                let [above, below] = [delta, -delta].map(|delta| {
                    let mut moved = at.clone();
                    moved[entry] += delta;
                    self.forces(&moved)
                });
                for (row, &of) in free.iter().enumerate() {
                    jacobian[(row, column)] = (above[of] - below[of]) / (2.0 * delta);
                }
            }
            let rest = DVector::from_iterator(free.len(), free.iter().map(|&of| forces[of]));
            let step = jacobian.lu().solve(&rest).expect("a stiff wall");
            let mut size = 0.0_f64;
            for (&entry, step) in free.iter().zip(step.iter()) {
                at[entry] -= step;
                size = size.max((step / scale(entry)).abs());
            }
            if size < 1e-11 {
                break;
            }
        }
        for k in 0..self.strain.len() {
            let (_, plastic, strain) = self.ring(k, &at);
            (self.plastic[k], self.strain[k]) = (plastic, strain);
        }
        self.now = at.as_slice().to_vec();
    }
}

/// Outer radius of the spread wall, inner radius of the released one, and the mean change of its inner, middle and outer radius \[m\].
fn by_rings(count: usize, steps: usize) -> [f64; 3] {
    let mut rings = Rings::new(count);
    for step in 1..=steps {
        rings.solve(Some(INNER + (SPREAD - INNER) * step as f64 / steps as f64));
    }
    let spread = rings.now[count];
    rings.solve(None);
    let changes = [0, count / 2, count].map(|k| rings.now[k] - rings.rest[k]);
    [spread, rings.now[0], changes.iter().sum::<f64>() / 3.0]
}

/// The same by tetrahedra: inner nodes are moved outwards, and let go. Their radius counts in the middle of the length, where ends are not felt.
fn by_elements(around: usize, through: usize, steps: usize) -> [f64; 2] {
    let length = 0.8e-3;
    let tube = Tube {
        center: [0.0; 3],
        axis: [0.0, 0.0, 1.0],
        inner_radius: INNER,
        layers: vec![Layer {
            thickness: WALL,
            cells: through,
            region: 0,
        }],
        length,
        around,
        along: 6,
        arc: Arc::Full,
        split: CellSplit::Kuhn,
    };
    let mesh = tube.mesh().unwrap();
    let material = Material {
        density: 1060.0,
        relaxation_time: 0.0,
        behaviour: Behaviour::Continuum(ContinuumConstants {
            law: LawName::NeoHookean.into(),
            young: YOUNG,
            poisson: POISSON,
            discretisation: Discretisation::Selective,
            plasticity: Some(PLASTICITY),
        }),
    };
    let clamped = vec![false; mesh.positions.len()];
    let model = build_model(&mesh, &[(0, material)], &clamped, 0.0, Vec::new()).unwrap();
    let mut state = State::at_rest(&model);
    // A step of a second is long beside the milliseconds of waves: inertia only holds what is free.
    let newton = Newton {
        iterations: 40,
        tolerance: 1e-8,
        must_converge: true,
    };
    let mut solver = Method::ImplicitEuler(newton).solver(&model).unwrap();
    let mut advance = |state: &mut State, targets: &[NodeTarget]| {
        let control = Control::default();
        solver
            .step(&model, state, &control, targets, 1.0, &Serial)
            .unwrap();
        flow(&model, state, 1.0);
    };
    let radius = |x: &Vector3<f64>| x.xy().norm();
    let nodes = |of: f64| -> Vec<usize> {
        let rest = mesh.positions.iter().enumerate();
        let there = rest.filter(|(_, x)| (radius(x) - of).abs() < 1e-3 * WALL);
        there.map(|(node, _)| node).collect()
    };
    let mean = |state: &State, of: f64| {
        let middle = |node: &usize| mesh.positions[*node].z.abs() < 0.01 * length;
        let radii: Vec<f64> = nodes(of)
            .into_iter()
            .filter(middle)
            .map(|node| radius(&state.positions[node]))
            .collect();
        radii.iter().sum::<f64>() / radii.len() as f64
    };
    let inner = nodes(INNER);
    for step in 1..=steps {
        let stretch = 1.0 + (SPREAD / INNER - 1.0) * step as f64 / steps as f64;
        let target = |&node: &usize| {
            let x = mesh.positions[node];
            NodeTarget {
                node: node as u32,
                target: Vector3::new(stretch * x.x, stretch * x.y, x.z),
                overlap: Vector3::zeros(),
            }
        };
        let targets: Vec<_> = inner.iter().map(target).collect();
        advance(&mut state, &targets);
    }
    let spread = mean(&state, INNER + WALL);
    // Without speed from before.
    state.velocities.fill(Vector3::zeros());
    for _ in 0..12 {
        advance(&mut state, &[]);
    }
    [spread, mean(&state, INNER)]
}

/// Tetrahedra with two cells through the wall and 24 around it, in 20 steps, each with its flow after it: 0.5 % of the spread is found at the outer wall,
/// 0.2 % after the release, 0.3 and 0.2 % with 40 steps. The part of the step, which is of first order, is therefore 0.4 and 0.1 % at 20 steps, and what
/// is left is the mesh: 1 % is allowed.
#[test]
fn a_spread_tube_retains_what_the_rings_do() {
    // With twice the rings and steps the solution in one dimension moves by less than 1e-4 of the spread.
    let (coarse, exact) = (by_rings(20, 100), by_rings(40, 200));
    let size = SPREAD - INNER;
    for (a, b) in coarse.iter().zip(&exact) {
        assert!((a - b).abs() < 1e-4 * size, "{coarse:?} {exact:?}");
    }
    let retained = (exact[1] - INNER) / size;
    assert!(retained > 0.5 && retained < 0.95, "{exact:?}");
    assert!(
        (exact[2] - RETAINED_IN_SCENE).abs() < 1e-3 * size,
        "{exact:?}"
    );
    let runs = [20, 40].map(|steps| by_elements(24, 2, steps));
    for [spread, released] in runs {
        assert!(
            (spread - exact[0]).abs() < 0.01 * size,
            "{spread} {exact:?}"
        );
        assert!(
            (released - exact[1]).abs() < 0.01 * size,
            "{released} {exact:?}"
        );
    }
    assert!((runs[0][1] - runs[1][1]).abs() < 0.005 * size, "{runs:?}");
}
