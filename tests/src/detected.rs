//! Contact without a scene: what the detector finds, given to a solver, and remembered from step to step as a scene does.

use microsim_contact::{
    CapsuleMotion, ContactPair, ContactSurface, Detector, Frame, Key, Point, Sides,
};
use microsim_mesh::TetMesh;
use microsim_tissue::{Contact, ContactSource, Response};
use nalgebra::Vector3;

type V3 = Vector3<f64>;

/// At most this fraction of an edge of an old overlap is undone in one step.
const OVERLAP_PER_STEP: f64 = 0.2;

/// The contacts of bodies whose nodes are numbered body after body, all with one coefficient of friction.
#[derive(Clone, Debug)]
pub struct Detected {
    detector: Detector,
    tools: Vec<Option<Vec<CapsuleMotion>>>,
    friction: f64,
    reach: f64,
    overlap: f64,
    start: Vec<V3>,
    sides: Sides,
    points: Vec<Point>,
    guesses: Vec<(Key, f64)>,
    forces: Vec<(Key, f64, V3)>,
}

impl Detected {
    /// For these bodies, pairs and tools. Points are found from `reach` on, a multiple of the mean edge length `edge` \[m\].
    pub fn new(
        bodies: &[&TetMesh],
        pairs: Vec<ContactPair>,
        tools: Vec<Option<Vec<CapsuleMotion>>>,
        friction: f64,
        reach: f64,
        edge: f64,
    ) -> Self {
        let mut offset = 0;
        let skins = bodies.iter().map(|mesh| {
            let skin = ContactSurface::new(mesh, offset);
            offset += mesh.positions.len() as u32;
            skin
        });
        Self {
            detector: Detector::new(skins.collect(), Vec::new(), pairs),
            tools,
            friction,
            reach: reach * edge,
            overlap: OVERLAP_PER_STEP * edge,
            start: Vec::new(),
            sides: Sides::new(),
            points: Vec::new(),
            guesses: Vec::new(),
            forces: Vec::new(),
        }
    }

    /// Nothing was ever touched. The lists of the detector stay: they are no part of a result.
    pub fn forget(&mut self) {
        self.sides.remember(&[]);
        self.forces.clear();
        self.points.clear();
    }

    /// A step begins at `start` \[m\].
    pub fn begin(&mut self, start: &[V3]) {
        self.start.clear();
        self.start.extend_from_slice(start);
        self.points.clear();
    }

    /// A step has ended with these contacts.
    pub fn end(&mut self, contacts: &[Contact]) {
        self.forces.clear();
        let both = self.points.iter().zip(contacts);
        let acting = both.filter(|(_, contact)| contact.normal_force > 0.0);
        let force = |(point, c): (&Point, &Contact)| (point.key, c.normal_force, c.friction_force);
        self.forces.extend(acting.map(force));
        self.sides.remember(&self.points);
    }

    /// The points at `positions` \[m\], when the step began there too.
    pub fn points(&mut self, positions: &[V3]) -> usize {
        let frame = Frame {
            start: positions,
            now: positions,
            tools: &self.tools,
            fraction: 1.0,
            reach: self.reach,
            sides: &self.sides,
        };
        self.detector.find(&frame, &mut self.points);
        self.points.len()
    }
}

impl ContactSource for Detected {
    fn find(&mut self, step_fraction: f64, positions: &[V3], contacts: &mut Vec<Contact>) {
        self.guesses.clear();
        let known = self.points.iter().zip(contacts.iter());
        let guesses = known.map(|(point, contact)| (point.key, contact.normal_force));
        self.guesses.extend(guesses);
        let frame = Frame {
            start: &self.start,
            now: positions,
            tools: &self.tools,
            fraction: step_fraction,
            reach: self.reach,
            sides: &self.sides,
        };
        self.detector.find(&frame, &mut self.points);
        contacts.clear();
        for point in &self.points {
            let last = self.forces.binary_search_by_key(&point.key, |f| f.0);
            let last = last.map(|place| self.forces[place]);
            let guess = self.guesses.binary_search_by_key(&point.key, |g| g.0);
            let (_, normal_force, friction_force) = last.unwrap_or((point.key, 0.0, V3::zeros()));
            let normal = point.normal;
            let mut contact = Contact {
                nodes: point.nodes,
                weights: point.weights,
                first: point.first,
                normal,
                offset: 0.0,
                floor: (point.start_gap + self.overlap).min(0.0),
                start_gap: point.start_gap,
                response: Response::Constraint,
                friction: self.friction,
                drift: point.drift,
                normal_force: guess.map_or(normal_force, |place| self.guesses[place].1),
                friction_force: friction_force - normal * normal.dot(&friction_force),
                is_sliding: false,
            };
            contact.offset = contact.gap(positions) - point.gap;
            contacts.push(contact);
        }
    }
}
