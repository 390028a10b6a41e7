//! What follows a mesh that is cut: the model, a solver that steps it, and contact. After each edit each is compared with one rebuilt of the mesh.

use crate::bodies::Body;
use crate::soak::Watch;
use microsim_contact::{
    ContactPair, ContactSurface, Detector, Frame, ObstaclePart, ObstacleShape, Point, Sides,
    SurfaceUpdate,
};
use microsim_cutting::{Cut, SurfaceTriangle};
use microsim_geometry::Pose;
use microsim_mesh::{Surface, TetMesh};
use microsim_random::SplitMix64;
use microsim_tissue::law::LawName;
use microsim_tissue::stability::{SAFETY, floor_nodes, stable_step};
use microsim_tissue::{
    Behaviour, ContinuumConstants, Control, Discretisation, Forces, Material, Method, ModelEdit,
    Serial, Solver, SpringConstants, State, TissueModel, build_model,
};
use nalgebra::Vector3;

/// Fraction of the stability limit that the mass floor leaves, as in scenes.
const FLOOR: f64 = 0.9;

/// Steps after each edit.
const STEPS: usize = 4;

/// By how much the energy of a body may have grown after [`STEPS`] steps: Störmer–Verlet preserves v² + (1 − s²) ω² x² of a mode at the fraction s of its
/// limit, so that its energy swings between that and 1/(1 − s²) times it.
const SWING: f64 = 1.0 / (1.0 - FLOOR * FLOOR);

/// Forces and energies of equal elements, summed in another order: some hundred terms at a node.
const ROUNDING: f64 = 1e-10;

/// Patches of patch-pressure are formed again where an edit was, and so are others than those of a mesh as a whole.
const DISCRETISATIONS: [Discretisation; 4] = [
    Discretisation::Tetrahedra,
    Discretisation::EdgeSmoothed,
    Discretisation::NodeSmoothed,
    Discretisation::Selective,
];

/// The same of tissue with fibres, whose domains have directions beside their shape.
const FIBROUS: [Discretisation; 3] = [
    Discretisation::Tetrahedra,
    Discretisation::EdgeSmoothed,
    Discretisation::Selective,
];

/// What was followed.
#[derive(Clone, Copy, Debug, Default)]
pub struct Tally {
    /// Bodies of each material: springs, then the discretisations, then those with fibres.
    pub materials: [usize; 1 + DISCRETISATIONS.len() + FIBROUS.len()],
    pub edits: usize,
    /// Edits with which elements left.
    pub crumbs: usize,
    /// Points of contact.
    pub points: usize,
    /// Nodes that got inertia.
    pub floored: usize,
}

struct Follower {
    behaviour: Behaviour,
    relaxation_time: f64,
    model: TissueModel,
    state: State,
    solver: Box<dyn Solver>,
    /// Of the uncut body \[s\].
    step: f64,
    mesh: TetMesh,
    triangles: Vec<SurfaceTriangle>,
    mean_edge: f64,
    detector: Detector,
}

pub struct Followers {
    random: SplitMix64,
    follower: Option<Follower>,
    pub tally: Tally,
}

impl Followers {
    pub fn new(seed: u64) -> Self {
        Self {
            random: SplitMix64(seed),
            follower: None,
            tally: Tally::default(),
        }
    }
}

fn model_of(mesh: &TetMesh, behaviour: Behaviour, relaxation_time: f64) -> TissueModel {
    let material = Material {
        density: 1000.0,
        relaxation_time,
        behaviour,
    };
    let free = vec![false; mesh.positions.len()];
    // Springs have no prestretch, and are refused on a mesh that has.
    let mut natural = mesh.clone();
    if matches!(material.behaviour, Behaviour::Springs(_)) {
        natural.prestretches.clear();
    }
    build_model(&natural, &[(0, material)], &free, 0.0, Vec::new()).expect("a sound mesh is a body")
}

/// A table through the body, and the body itself.
fn detector_of(mesh: &TetMesh, triangles: &[SurfaceTriangle], mean_edge: f64) -> Detector {
    let contact_surface = ContactSurface::of_surface(mesh, &surface(triangles), mean_edge, 0, true);
    let table = ObstaclePart {
        shape: ObstacleShape::HalfSpace,
        pose: Pose::identity(),
    };
    let touches = vec![
        ContactPair::Obstacle { body: 0, part: 0 },
        ContactPair::Itself { body: 0 },
    ];
    Detector::new(vec![contact_surface], vec![table], touches)
}

fn surface(triangles: &[SurfaceTriangle]) -> Surface {
    Surface::new(triangles.iter().map(|t| t.nodes).collect())
}

/// Where those of `one` stand, ascending, that are not in `other`; both are sorted by what a triangle is of.
fn beyond(one: &[SurfaceTriangle], other: &[SurfaceTriangle]) -> Vec<u32> {
    let mut sorted = other.to_vec();
    sorted.sort_unstable();
    let places = 0..one.len() as u32;
    let is_new = |place: &u32| sorted.binary_search(&one[*place as usize]).is_err();
    places.filter(is_new).collect()
}

impl Watch for Followers {
    fn begins(&mut self, body: &Body) {
        let number = self.tally.materials.iter().sum::<usize>() % self.tally.materials.len();
        self.tally.materials[number] += 1;
        let continuum = |law: LawName, discretisation| {
            Behaviour::Continuum(ContinuumConstants {
                law: law.into(),
                young: 1e4,
                poisson: 0.4,
                discretisation,
                plasticity: None,
            })
        };
        let isotropic = DISCRETISATIONS.map(|one| continuum(LawName::StableNeoHookean, one));
        let fibrous = FIBROUS.map(|one| continuum(LawName::TransverselyIsotropic, one));
        let springs = Behaviour::Springs(SpringConstants::fitted(1e4, 0.25));
        let behaviour = [&[springs][..], &isotropic, &fibrous].concat()[number];
        // Half of the bodies are viscous, so much that it halves the step.
        let relaxation_time = match self.random.below(2) {
            0 => 0.0,
            _ => 0.75 * stable_step(&model_of(&body.mesh, behaviour, 0.0), 1.0),
        };
        let model = model_of(&body.mesh, behaviour, relaxation_time);
        let step = stable_step(&model, SAFETY);
        let mut state = State::at_rest(&model);
        let speed = 1e-3 * model.mean_edge_length() / step;
        for v in &mut state.velocities {
            *v = self.random.vector() * speed;
        }
        let triangles = body.topology.surface();
        let mean_edge = body.mesh.mean_edge_length();
        self.follower = Some(Follower {
            behaviour,
            relaxation_time,
            solver: Method::StoermerVerlet
                .solver(&model)
                .expect("any model has it"),
            model,
            state,
            step,
            detector: detector_of(&body.mesh, &triangles, mean_edge),
            mesh: body.mesh.clone(),
            triangles,
            mean_edge,
        });
    }

    fn edited(&mut self, body: &Body, cut: &Cut) -> Result<(), String> {
        let Some(follower) = &mut self.follower else {
            return Err("no body has begun".into());
        };
        self.tally.edits += 1;
        self.tally.crumbs += usize::from(!cut.edit.removed.is_empty());
        follower.follow_model(body, cut, &mut self.tally)?;
        follower.compare_models(&body.mesh, &mut self.random)?;
        follower.advance()?;
        follower.follow_contact(body)?;
        self.tally.points += follower.compare_contact(&mut self.random)?;
        Ok(())
    }
}

impl Follower {
    fn follow_model(&mut self, body: &Body, cut: &Cut, tally: &mut Tally) -> Result<(), String> {
        let edit = ModelEdit::new(&body.mesh, &cut.edit, &[]);
        let change = self.model.edit(&edit).map_err(|e| e.to_string())?;
        self.state.edit(&change);
        let remedied = floor_nodes(
            &mut self.model,
            &change.touched,
            &Method::StoermerVerlet,
            self.step,
            FLOOR,
        );
        tally.floored += remedied.nodes;
        self.solver.follow(&self.model);
        Ok(())
    }

    /// Masses, and forces and energies of a shape at random: of each spring its length at rest, of each element its volume, is in them. Springs are
    /// the edges of the mesh, each once.
    fn compare_models(&self, mesh: &TetMesh, random: &mut SplitMix64) -> Result<(), String> {
        let rebuilt = model_of(mesh, self.behaviour, self.relaxation_time);
        let (model, control) = (&self.model, Control::default());
        if model.tets() != mesh.tets || model.rest_positions() != mesh.positions {
            return Err("the model is of another mesh".into());
        }
        for (set, other) in model.sets().iter().zip(rebuilt.sets()) {
            if set.count() != other.count() {
                return Err(format!(
                    "{} elements, rebuilt {}",
                    set.count(),
                    other.count()
                ));
            }
        }
        if let Behaviour::Springs(_) = self.behaviour {
            let springs = model.sets().iter().find(|set| set.nodes(0).len() == 2);
            let springs = springs.ok_or("no springs")?;
            let edge = |e: usize| {
                let nodes = springs.nodes(e);
                [nodes[0].min(nodes[1]), nodes[0].max(nodes[1])]
            };
            let mut edges: Vec<[u32; 2]> = (0..springs.count()).map(edge).collect();
            edges.sort_unstable();
            if edges != mesh.edges() {
                return Err("springs are not the edges of the mesh".into());
            }
        }
        let mass = rebuilt.masses().iter().copied().fold(0.0, f64::max);
        let masses = model.masses().iter().zip(rebuilt.masses());
        if let Some((a, b)) = masses.clone().find(|(a, b)| (*a - *b).abs() > 1e-12 * mass) {
            return Err(format!("a mass of {a}, rebuilt {b}"));
        }
        let shake = 0.02 * self.mean_edge;
        let place = |p: &Vector3<f64>| p * 1.05 + random.vector() * shake;
        let positions: Vec<_> = mesh.positions.iter().map(place).collect();
        let of = |model: &TissueModel| {
            let mut state = State::at_rest(model);
            state.positions.clone_from(&positions);
            let forces = Forces::new(model)
                .compute(model, &state, &control, &Serial)
                .to_vec();
            (forces, state.energies(model).elastic())
        };
        let ((forces, energy), (forces_rebuilt, energy_rebuilt)) = (of(model), of(&rebuilt));
        if (energy - energy_rebuilt).abs() > ROUNDING * energy_rebuilt {
            return Err(format!("an energy of {energy}, rebuilt {energy_rebuilt}"));
        }
        let largest = forces_rebuilt.iter().map(Vector3::norm).fold(0.0, f64::max);
        let off = forces
            .iter()
            .zip(&forces_rebuilt)
            .map(|(a, b)| (a - b).norm());
        let off = off.fold(0.0, f64::max);
        if off > ROUNDING * largest {
            return Err(format!("forces off by {off} of {largest}"));
        }
        Ok(())
    }

    /// The solver that followed steps as one rebuilt does, to the bit; undamped and damped bodies stay bounded at the step of the uncut one.
    fn advance(&mut self) -> Result<(), String> {
        let mut rebuilt = Method::StoermerVerlet
            .solver(&self.model)
            .expect("any model has it");
        let mut twin = self.state.clone();
        let control = Control::default();
        let before = self.state.energies(&self.model).total();
        for _ in 0..STEPS {
            let pairs = [
                (&mut self.solver, &mut self.state),
                (&mut rebuilt, &mut twin),
            ];
            for (solver, state) in pairs {
                solver
                    .step(&self.model, state, &control, &[], self.step, &Serial)
                    .map_err(|e| format!("a step: {e:?}"))?;
            }
        }
        if self.state.positions != twin.positions || self.state.velocities != twin.velocities {
            return Err("the solver that followed steps otherwise".into());
        }
        let after = self.state.energies(&self.model).total();
        if !self.state.is_finite() || after > SWING * before {
            return Err(format!("an energy of {after} from {before}"));
        }
        Ok(())
    }

    fn follow_contact(&mut self, body: &Body) -> Result<(), String> {
        let now = body.topology.surface();
        let (old, new) = (&self.mesh.tets, &body.mesh.tets);
        let changed = (0..old.len().max(new.len())).filter(|&e| old.get(e) != new.get(e));
        let corners = changed.flat_map(|e| [old.get(e), new.get(e)]);
        let touched: Vec<u32> = corners.flatten().flatten().copied().collect();
        self.detector.update_after_edit(
            0,
            &SurfaceUpdate {
                mesh: &body.mesh,
                surface: &surface(&now),
                offset: 0,
                removed: &beyond(&self.triangles, &now),
                added: &beyond(&now, &self.triangles),
                touched: &touched,
                elements_at: &|node| body.topology.elements_at(node),
            },
        );
        self.triangles = now;
        self.mesh = body.mesh.clone();
        Ok(())
    }

    /// The points that both find at a shape at random; their number.
    fn compare_contact(&mut self, random: &mut SplitMix64) -> Result<usize, String> {
        let mut rebuilt = detector_of(&self.mesh, &self.triangles, self.mean_edge);
        let squeeze = 1.0 - 0.5 * random.number().abs();
        let place = |p: &Vector3<f64>| Vector3::new(p.x, p.y * squeeze, p.z);
        let now: Vec<_> = self.mesh.positions.iter().map(place).collect();
        let frame = Frame {
            start: &now,
            now: &now,
            tools: &[],
            fraction: 1.0,
            reach: 0.1 * self.mean_edge,
            sides: &Sides::default(),
        };
        let mut points: [Vec<Point>; 2] = Default::default();
        self.detector.find(&frame, &mut points[0]);
        rebuilt.find(&frame, &mut points[1]);
        if points[0] != points[1] {
            return Err(format!(
                "{} points of contact, rebuilt {}",
                points[0].len(),
                points[1].len()
            ));
        }
        Ok(points[0].len())
    }
}
