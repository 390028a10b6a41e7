//! Bounding volumes of the triangles and tetrahedra of a body, retained while its nodes move little.

use crate::broad_phase::{Boxes, BroadPhaseMethod, CELL_OF_TETS, CELL_OF_TRIANGLES};
use crate::frame::Frame;
use crate::surface::ContactSurface;
use microsim_geometry::Aabb;
use nalgebra::Vector3;

/// Boxes are larger than what is in them by this fraction of the mean edge length, so that they hold it until a node has moved by that much.
const MARGIN: f64 = 0.1;

/// Boxes around the features of a body, and how those that overlap are found.
#[derive(Clone, Debug)]
pub(crate) struct Tree {
    /// Grows with every change of the boxes.
    pub version: u64,
    /// What boxes are larger than what they hold \[m\].
    pub margin: f64,
    /// Positions before the step and now, for which the boxes were made.
    start: Vec<Vector3<f64>>,
    now: Vec<Vector3<f64>>,
    /// The box around the surface over the step.
    pub bounds: Aabb,
    /// The triangles over the step; right after [`build`](Self::build).
    pub triangles: Boxes,
    /// The tetrahedra now, where they are wanted; right after [`build`](Self::build).
    pub tets: Option<Boxes>,
    boxes: Vec<Aabb>,
    /// The version that triangles and tetrahedra are of.
    built: u64,
}

impl Tree {
    /// Without tetrahedra.
    pub fn new(surface: &ContactSurface) -> Self {
        Self {
            version: 0,
            margin: MARGIN * surface.mean_edge,
            start: Vec::new(),
            now: Vec::new(),
            bounds: Aabb::empty(),
            triangles: Boxes::new(BroadPhaseMethod::default(), 0.0),
            tets: None,
            boxes: Vec::new(),
            built: 0,
        }
    }

    /// The tetrahedra are wanted.
    pub fn want_tets(&mut self) {
        self.tets = Some(Boxes::new(BroadPhaseMethod::default(), 0.0));
    }

    /// From the next [`build`](Self::build) on boxes are found like this.
    pub fn set_broad_phase(&mut self, broad_phase: BroadPhaseMethod, surface: &ContactSurface) {
        let of = |edges: f64| Boxes::new(broad_phase, edges * surface.mean_edge);
        self.triangles = of(CELL_OF_TRIANGLES);
        if self.tets.is_some() {
            self.tets = Some(of(CELL_OF_TETS));
        }
        self.built = 0;
    }

    /// Updates the boxes after an edit: triangles have these indices now, [`u32::MAX`] where they are gone.
    pub fn update_after_edit(&mut self, to: &[u32]) {
        self.triangles.renumber(to);
        // The positions that it was built for are of other nodes.
        self.start.clear();
    }

    /// Makes sure that the box around all holds what it should.
    pub fn update(&mut self, surface: &ContactSurface, frame: &Frame<'_>) {
        let (start, now) = (&frame.start[surface.range()], &frame.now[surface.range()]);
        if within(start, &self.start, self.margin) && within(now, &self.now, self.margin) {
            return;
        }
        self.version += 1;
        self.start.clear();
        self.start.extend_from_slice(start);
        self.now.clear();
        self.now.extend_from_slice(now);
        self.bounds = Aabb::empty();
        for &node in &surface.nodes {
            let bounds = self.swept(surface, &[node]);
            if bounds.is_valid() {
                self.bounds = self.bounds.union(&bounds);
            }
        }
    }

    /// Makes sure that the boxes of all triangles and tetrahedra hold what they should: only needed where something is near.
    pub fn build(&mut self, surface: &ContactSurface) {
        if self.built == self.version {
            return;
        }
        self.built = self.version;
        self.boxes.clear();
        for nodes in &surface.triangles {
            self.boxes.push(self.swept(surface, nodes));
        }
        self.triangles.set(&self.boxes);
        if let Some(tets) = &mut self.tets {
            self.boxes.clear();
            for nodes in &surface.tets {
                let corners = nodes.map(|node| self.now[(node - surface.offset) as usize]);
                self.boxes.push(Aabb::of(&corners).inflated(self.margin));
            }
            tets.set(&self.boxes);
        }
    }

    /// The box around a node now.
    pub fn place(&self, surface: &ContactSurface, node: u32) -> Aabb {
        let at = self.now[(node - surface.offset) as usize];
        Aabb { min: at, max: at }.inflated(self.margin)
    }

    /// The box around nodes over the step.
    pub fn swept(&self, surface: &ContactSurface, nodes: &[u32]) -> Aabb {
        let mut bounds = Aabb::empty();
        for node in nodes {
            let place = (node - surface.offset) as usize;
            bounds.include(&self.start[place]);
            bounds.include(&self.now[place]);
        }
        bounds.inflated(self.margin)
    }
}

/// Whether no position is further than `margin` from the other on any axis.
fn within(a: &[Vector3<f64>], b: &[Vector3<f64>], margin: f64) -> bool {
    // Written so that a NaN is not within, and without an early exit of the loop.
    let mut all = a.len() == b.len();
    for (a, b) in a.iter().zip(b) {
        let near = |k: usize| (a[k] - b[k]).abs() <= margin;
        all &= near(0) & near(1) & near(2);
    }
    all
}
