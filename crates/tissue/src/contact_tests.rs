//! Contact in all methods: closed forms, conservation, rest.

use crate::executor::Serial;
use crate::method::Method;
use crate::model::TissueModel;
use crate::solver::{StepFailure, StepReport};
use crate::state::{Control, NodeTarget, State};
use crate::testing::{block_mesh, build, soft};
use crate::{Newton, build_model};
use microsim_contact_solver::{Contact, ContactSource, ContactStep};
use nalgebra::Vector3;
use std::collections::BTreeMap;

mod bodies;
mod early_terminated;
mod explicit;
mod implicit;

/// What is remembered of a contact.
type Memory = BTreeMap<[u32; 2], (f64, Vector3<f64>)>;

/// A half-space below n·x = height, that moves; it touches nodes.
#[derive(Clone, Debug)]
pub struct Plane {
    pub normal: Vector3<f64>,
    pub height: f64,
    /// During the step \[m\].
    pub motion: Vector3<f64>,
    pub friction: f64,
    /// Which nodes it sees.
    pub sees: fn(&Vector3<f64>) -> bool,
    /// How much higher it is for a node with this rest position \[m\].
    pub bump: fn(&Vector3<f64>) -> f64,
}

impl Plane {
    pub fn floor(height: f64) -> Self {
        Self {
            normal: Vector3::z(),
            height,
            motion: Vector3::zeros(),
            friction: 0.0,
            sees: |_| true,
            bump: |_| 0.0,
        }
    }
}

/// A scene for one model.
pub struct World {
    pub model: TissueModel,
    pub state: State,
    pub control: Control,
    pub planes: Vec<Plane>,
    /// Pairs of nodes that must not pass one another along x; the first stays on the side of larger x.
    pub pairs: Vec<[u32; 2]>,
    /// Gaps smaller than this are given \[m\].
    pub reach: f64,
    /// A contact that presses harder has jumped \[N\].
    pub jump: f64,
    /// Whether planes are taken to move on as in the step before.
    pub moves_on: bool,
    pub memory: Memory,
    pub contacts: Vec<Contact>,
    solver: Box<dyn crate::Solver>,
}

struct Source<'a> {
    world: &'a World,
    last: Memory,
}

impl ContactSource for Source<'_> {
    fn find(
        &mut self,
        step_fraction: f64,
        positions: &[Vector3<f64>],
        contacts: &mut Vec<Contact>,
    ) {
        let World {
            state,
            planes,
            pairs,
            reach,
            memory,
            ..
        } = self.world;
        self.last.extend(remember(planes, contacts));
        contacts.clear();
        let start = &state.positions;
        let mut push = |nodes: [u32; 2], contact: Contact| {
            let start_gap = contact.gap(start) + contact.normal.dot(&contact.drift);
            if contact.gap(positions) >= *reach {
                return;
            }
            let last = self.last.get(&nodes).or_else(|| memory.get(&nodes));
            contacts.push(Contact {
                start_gap,
                floor: (start_gap + 0.2 * self.world.model.mean_edge_length()).min(0.0),
                normal_force: last.map_or(0.0, |last| last.0),
                friction_force: memory.get(&nodes).map_or(Vector3::zeros(), |last| last.1),
                ..contact
            });
        };
        for (index, plane) in planes.iter().enumerate() {
            for node in 0..positions.len() as u32 {
                if !(plane.sees)(&self.world.model.rest_positions()[node as usize]) {
                    continue;
                }
                let drift = plane.motion * step_fraction;
                let bump = (plane.bump)(&self.world.model.rest_positions()[node as usize]);
                push(
                    [node, u32::MAX - index as u32],
                    Contact {
                        friction: plane.friction,
                        drift,
                        ..Contact::of_node(
                            node,
                            plane.normal,
                            plane.height + bump + plane.normal.dot(&drift),
                        )
                    },
                );
            }
        }
        for &[a, b] in pairs {
            push(
                [a, b],
                Contact {
                    nodes: [a, b, a, a],
                    weights: [1.0, -1.0, 0.0, 0.0],
                    ..Contact::of_node(a, Vector3::x(), 0.0)
                },
            );
        }
    }

    fn moves_on(&self) -> bool {
        self.world.moves_on
    }

    fn has_jumped(&self, contacts: &[Contact]) -> bool {
        contacts.iter().any(|of| of.normal_force > self.world.jump)
    }
}

/// The planes of a test are distinguished by their normals.
fn remember(
    planes: &[Plane],
    contacts: &[Contact],
) -> impl Iterator<Item = ([u32; 2], (f64, Vector3<f64>))> {
    contacts.iter().map(|c| {
        let other = c.other_side().unwrap_or_else(|| {
            let plane = planes.iter().position(|plane| plane.normal == c.normal);
            u32::MAX - plane.map_or(0, |index| index as u32)
        });
        ([c.nodes[0], other], (c.normal_force, c.friction_force))
    })
}

impl World {
    pub fn new(model: TissueModel, method: Method) -> Self {
        Self {
            state: State::at_rest(&model),
            control: Control::default(),
            planes: Vec::new(),
            pairs: Vec::new(),
            reach: 0.0,
            jump: f64::INFINITY,
            moves_on: false,
            memory: Memory::new(),
            contacts: Vec::new(),
            solver: method.solver(&model).unwrap(),
            model,
        }
    }

    pub fn step(&mut self, h: f64) -> Result<StepReport, StepFailure> {
        self.step_with_targets(&[], h)
    }

    pub fn step_with_targets(
        &mut self,
        targets: &[NodeTarget],
        h: f64,
    ) -> Result<StepReport, StepFailure> {
        let mut state = self.state.clone();
        let mut solver = self.solver.boxed_clone();
        let mut contacts = std::mem::take(&mut self.contacts);
        contacts.clear();
        let mut source = Source {
            world: self,
            last: Memory::new(),
        };
        let mut touching = ContactStep {
            source: &mut source,
            contacts,
        };
        let control = &self.control;
        let touching_too = Some(&mut touching);
        let result = solver.advance(
            &self.model,
            &mut state,
            control,
            targets,
            touching_too,
            h,
            &Serial,
        );
        self.contacts = touching.contacts;
        self.memory = remember(&self.planes, &self.contacts).collect();
        self.state = state;
        for plane in &mut self.planes {
            plane.height += plane.normal.dot(&plane.motion);
        }
        result
    }

    /// Sum of the forces on first sides \[N\].
    pub fn force(&self) -> Vector3<f64> {
        self.contacts.iter().map(Contact::force).sum()
    }

    pub fn mass(&self) -> f64 {
        self.model.masses().iter().sum()
    }

    /// Mean velocity of all mass \[m/s\].
    pub fn velocity(&self) -> Vector3<f64> {
        let sum: Vector3<f64> = self
            .state
            .velocities
            .iter()
            .zip(self.model.masses())
            .map(|(v, m)| v * *m)
            .sum();
        sum / self.mass()
    }

    /// The deepest gap \[m\] below 0 of all planes and pairs.
    pub fn deepest(&self) -> f64 {
        let mut deepest = 0.0f64;
        for plane in &self.planes {
            for x in &self.state.positions {
                deepest = deepest.min(plane.normal.dot(x) - plane.height);
            }
        }
        for [a, b] in &self.pairs {
            let [a, b] = [a, b].map(|node| self.state.positions[*node as usize].x);
            deepest = deepest.min(a - b);
        }
        deepest
    }
}

/// A free block of soft tissue with 1 mm cells, its low face at z = 0.
pub fn free_block(cells: [usize; 3], drag: f64) -> TissueModel {
    let size = cells.map(|n| n as f64 * 1e-3);
    let mut mesh = block_mesh(size, cells);
    for x in &mut mesh.positions {
        x.z += 0.5 * size[2];
    }
    let free = vec![false; mesh.positions.len()];
    build_model(&mesh, &[(0, soft())], &free, drag, Vec::new()).unwrap()
}

pub fn gravity() -> Control {
    Control {
        gravity: Vector3::new(0.0, 0.0, -9.81),
        ..Control::default()
    }
}

/// The methods that keep gaps, with a step \[s\] that suits blocks of soft tissue with edges of 1 mm.
pub fn explicit() -> [(Method, f64); 4] {
    [
        Method::StoermerVerlet,
        Method::SymplecticEuler,
        Method::VelocityVerlet,
        Method::VelocityVerletLagged,
    ]
    .map(|method| (method, 2e-5))
}

#[test]
fn a_method_that_cannot_keep_gaps_says_so() {
    let model = free_block([1; 3], 0.0);
    for method in [
        Method::ExplicitEuler,
        Method::SymplecticEuler,
        Method::ImplicitEuler(Newton::default()),
    ] {
        let mut world = World::new(model.clone(), method);
        assert!(world.step(1e-5).is_ok(), "{method:?} touches nothing");

        world.planes.push(Plane::floor(1e-6));
        let before = world.state.clone();
        let result = world.step(1e-5);
        assert!(!world.contacts.is_empty(), "{method:?} touches the plane");
        if method.enforces_non_penetration() {
            assert!(result.is_ok(), "{method:?}: {result:?}");
        } else {
            let failure = result.unwrap_err();
            assert!(failure.to_string().contains("explicit Euler"));
            assert_eq!(world.state, before);
        }
    }
}
