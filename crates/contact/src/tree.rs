//! Where the triangles and tetrahedra of a body are, kept while its nodes move little.

use crate::detector::Frame;
use crate::skin::Skin;
use microsim_geometry::{Aabb, Bvh};
use nalgebra::Vector3;

/// Boxes are larger than what is in them by this share of the mean edge length, so that they hold it until a node has moved by that much.
const MARGIN: f64 = 0.1;

/// Hierarchies of boxes around what belongs to a body.
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
    pub triangles: Bvh,
    /// The tetrahedra now, where they are wanted; right after [`build`](Self::build).
    pub tets: Option<Bvh>,
    boxes: Vec<Aabb>,
    /// The version that the hierarchies are of.
    built: u64,
}

impl Tree {
    /// Without tetrahedra.
    pub fn new(skin: &Skin) -> Self {
        Self {
            version: 0,
            margin: MARGIN * skin.mean_edge,
            start: Vec::new(),
            now: Vec::new(),
            bounds: Aabb::empty(),
            triangles: Bvh::new(),
            tets: None,
            boxes: Vec::new(),
            built: 0,
        }
    }

    /// The tetrahedra are wanted.
    pub fn want_tets(&mut self) {
        self.tets.get_or_insert_default();
    }

    /// Follows a cut: triangles have these numbers now, [`u32::MAX`] where they are gone.
    pub fn follow(&mut self, to: &[u32]) {
        self.triangles.renumber(to);
        // Whatever it was made for is of other nodes.
        self.start.clear();
    }

    /// Makes sure that the box around all holds what it should.
    pub fn update(&mut self, skin: &Skin, frame: &Frame<'_>) {
        let (start, now) = (&frame.start[skin.range()], &frame.now[skin.range()]);
        if within(start, &self.start, self.margin) && within(now, &self.now, self.margin) {
            return;
        }
        self.version += 1;
        self.start.clear();
        self.start.extend_from_slice(start);
        self.now.clear();
        self.now.extend_from_slice(now);
        self.bounds = Aabb::empty();
        for &node in &skin.nodes {
            let bounds = self.swept(skin, &[node]);
            if bounds.is_valid() {
                self.bounds = self.bounds.union(&bounds);
            }
        }
    }

    /// Makes sure that the boxes of all triangles and tetrahedra hold what they should: only asked for where something is near.
    pub fn build(&mut self, skin: &Skin) {
        if self.built == self.version {
            return;
        }
        self.built = self.version;
        self.boxes.clear();
        for nodes in &skin.triangles {
            self.boxes.push(self.swept(skin, nodes));
        }
        self.triangles.refit(&self.boxes);
        if let Some(tree) = &mut self.tets {
            self.boxes.clear();
            for nodes in &skin.tets {
                let corners = nodes.map(|node| self.now[(node - skin.offset) as usize]);
                self.boxes.push(Aabb::of(&corners).inflated(self.margin));
            }
            tree.refit(&self.boxes);
        }
    }

    /// The box around a node now.
    pub fn place(&self, skin: &Skin, node: u32) -> Aabb {
        let at = self.now[(node - skin.offset) as usize];
        Aabb { min: at, max: at }.inflated(self.margin)
    }

    /// The box around nodes over the step.
    pub fn swept(&self, skin: &Skin, nodes: &[u32]) -> Aabb {
        let mut bounds = Aabb::empty();
        for node in nodes {
            let place = (node - skin.offset) as usize;
            bounds.include(&self.start[place]);
            bounds.include(&self.now[place]);
        }
        bounds.inflated(self.margin)
    }
}

/// Whether no position is further than `margin` from the other on any axis.
fn within(a: &[Vector3<f64>], b: &[Vector3<f64>], margin: f64) -> bool {
    // Written so that what is not a number is not, and without a way out of the loop.
    let mut all = a.len() == b.len();
    for (a, b) in a.iter().zip(b) {
        let near = |k: usize| (a[k] - b[k]).abs() <= margin;
        all &= near(0) & near(1) & near(2);
    }
    all
}
