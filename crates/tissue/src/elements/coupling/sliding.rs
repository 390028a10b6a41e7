//! Ties that slide on the other layer, with friction.
//!
//! The point of a tie is on a face of the other layer's surface, with a fixed height above it (that at rest, the gap between two divisions
//! of one surface). With n, the face's outward normal, d = x − Σ b_i x_i, its parts d_n along n and d_t across it, and the
//! bound b:
//!
//! ```text
//! E = k (½ d_n² + ½ |d_t|²)           |d_t| ≤ b    sticks
//! E = k (½ d_n² + b |d_t| − ½ b²)     |d_t| > b    slides: a force k b across n
//! ```
//!
//! # What happens in a step
//! Points, n and b are those of the start: forces have a potential that is convex, and its tangent is exact. Once the step is accepted
//! ([`Elements::flow`]) the point of a tie that slides follows until |d_t| = b, on a straightest path across the faces, with the
//! surface as it is then; the work k b per length of this path is lost. Then n is that of the face that was reached, and b is
//! τ/K + μ max(0, −d_n) with K the stiffness per area: the shear strength τ of what joins the layers, which slides on at that stress and does not wear, and
//! Coulomb's bound for the force with which they are pressed together now, so the friction of a step is that of the
//! pressure at its start. Layers that are pulled apart stay on each other, and slide against τ alone. A tie whose point leaves the
//! layer by more than a quarter of an edge, the mean one before any cut, is free for ever.
//!
//! A face has another tetrahedron behind it: [`TissueModel::relocate`](crate::TissueModel::relocate) then gives the tie other nodes.
//!
//! # Conservation
//! The two forces of a tie are opposite, so momentum is conserved. While it sticks they act along d, and angular momentum is, too. While
//! it slides a moment is left of the normal force times the slip of the step, |d_t| − b: of first order in the step.
//!
//! # Limitations
//! Faces are flat: on a curved surface a node that slides follows the chords. Faces are found one side alone: nodes of one layer on
//! faces of the other. An edit of the mesh looks at the whole layer.

use super::layer::{GOES_ON, Layer};
use super::{SlidingConstants, Stencil, Support, Tie, coordinates};
use crate::elements::key::Key;
use crate::elements::splice::{Inherited, make_room, splice};
use crate::elements::{
    Configuration, ElementMatrix, Elements, EnergyKind, Followed, NodeWindow, Tangent,
};
use microsim_geometry::closest_on_triangle;
use nalgebra::{Matrix3, Vector3};
use std::any::Any;
use std::ops::Range;
use std::sync::Arc;

/// Internal variables of a tie.
const BLOCKS: usize = 10;

/// What internal variables state of a tie, in their order.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Place {
    /// The number of the face; of a tie that is free −1 less that of its last one.
    face: f64,
    /// Weights of the last three nodes of the tetrahedron.
    weights: [f64; 3],
    /// Height above the face \[m\].
    height: f64,
    /// n.
    normal: Vector3<f64>,
    /// b \[m\].
    bound: f64,
    /// Work of friction over the stiffness \[m²\].
    lost: f64,
}

impl Place {
    fn is_free(&self) -> bool {
        self.face < 0.0
    }

    /// The face, or the last one.
    fn index(&self) -> u32 {
        match self.is_free() {
            true => (-1.0 - self.face) as u32,
            false => self.face as u32,
        }
    }

    fn read(internal: &[f64], element: usize) -> Self {
        let count = internal.len() / BLOCKS;
        let at = |block: usize| internal[block * count + element];
        Self {
            face: at(0),
            weights: [at(1), at(2), at(3)],
            height: at(4),
            normal: Vector3::new(at(5), at(6), at(7)),
            bound: at(8),
            lost: at(9),
        }
    }

    fn write(&self, internal: &mut [f64], element: usize) {
        let count = internal.len() / BLOCKS;
        for (block, value) in self.values().into_iter().enumerate() {
            internal[block * count + element] = value;
        }
    }

    fn values(&self) -> [f64; BLOCKS] {
        let ([b, c, d], n) = (self.weights, self.normal);
        let Self {
            face,
            height,
            bound,
            lost,
            ..
        } = *self;
        [face, b, c, d, height, n.x, n.y, n.z, bound, lost]
    }
}

/// A tie where it is now.
#[derive(Clone, Copy, Debug)]
struct Slide {
    stencil: Stencil,
    /// k \[N/m\].
    stiffness: f64,
    /// The face; the last one of a tie that is free.
    face: u32,
    is_free: bool,
    /// What the internal variables are at the start.
    start: Place,
}

/// The parts of d.
struct Offset {
    normal: Vector3<f64>,
    /// d_n \[m\].
    along: f64,
    /// d_t \[m\].
    across: Vector3<f64>,
    /// |d_t| \[m\].
    distance: f64,
    bound: f64,
}

impl Offset {
    fn new(d: Vector3<f64>, place: &Place) -> Self {
        let along = d.dot(&place.normal);
        let across = d - place.normal * along;
        Self {
            normal: place.normal,
            along,
            across,
            distance: across.norm(),
            bound: place.bound,
        }
    }

    fn sticks(&self) -> bool {
        self.distance <= self.bound
    }

    /// Energy by the stiffness \[m²\].
    fn energy(&self) -> f64 {
        let across = match self.sticks() {
            true => 0.5 * self.distance * self.distance,
            false => self.bound * (self.distance - 0.5 * self.bound),
        };
        0.5 * self.along * self.along + across
    }

    /// Force over distance across the normal.
    fn secant(&self) -> f64 {
        match self.sticks() {
            true => 1.0,
            false => self.bound / self.distance,
        }
    }

    /// Derivative of the force by d, over the stiffness.
    fn tangent(&self) -> Matrix3<f64> {
        if self.sticks() {
            return Matrix3::identity();
        }
        let (n, t) = (&self.normal, self.across / self.distance);
        let nn = n * n.transpose();
        nn + (Matrix3::identity() - nn - t * t.transpose()) * self.secant()
    }
}

/// A set of ties that slide.
#[derive(Clone, Debug)]
pub struct Sliding {
    layer: Arc<Layer>,
    slides: Vec<Slide>,
    friction: f64,
    /// τ/K \[m\]: what a tie without pressure sticks over.
    least_bound: f64,
}

impl Sliding {
    /// Ties on faces of a layer, by their numbers.
    pub(super) fn new(
        layer: Layer,
        ties: &[(Tie, u32)],
        constants: &SlidingConstants,
        positions: &[Vector3<f64>],
    ) -> Self {
        let least_bound = constants.shear_strength / constants.stiffness_per_area;
        let slides = ties.iter().map(|(tie, face)| {
            let (corners, normal) = (
                layer.corners(*face, positions),
                layer.normal(*face, positions),
            );
            let height = (positions[tie.node as usize] - corners[0]).dot(&normal);
            let stencil = Stencil::of(tie);
            Slide {
                stencil,
                stiffness: tie.stiffness,
                face: *face,
                is_free: false,
                start: Place {
                    face: f64::from(*face),
                    weights: weights(&stencil),
                    height,
                    normal,
                    bound: least_bound,
                    lost: 0.0,
                },
            }
        });
        Self {
            slides: slides.collect(),
            layer: Arc::new(layer),
            friction: constants.friction,
            least_bound,
        }
    }

    /// Number of ties that are not free.
    pub fn held(internal: &[f64]) -> usize {
        let faces = &internal[..internal.len() / BLOCKS];
        faces.iter().filter(|face| **face >= 0.0).count()
    }

    /// d of a tie in its parts, with its stiffness; `None` of one that is free. Without internal variables it sticks: nothing is stiffer.
    fn offset(
        &self,
        element: usize,
        positions: &[Vector3<f64>],
        internal: &[f64],
    ) -> Option<(Offset, f64)> {
        let slide = &self.slides[element];
        let place = match internal.is_empty() {
            true => Place {
                bound: f64::INFINITY,
                ..slide.start
            },
            false => Place::read(internal, element),
        };
        let d = slide.stencil.offset(positions);
        (!place.is_free()).then(|| (Offset::new(d, &place), slide.stiffness))
    }

    /// Where a tie is after a step that ends at these positions.
    fn followed(&self, slide: &Slide, before: &Place, positions: &[Vector3<f64>]) -> Place {
        let d = slide.stencil.offset(positions);
        let offset = Offset::new(d, before);
        let x = &positions[slide.stencil.nodes[0] as usize];
        let (mut after, mut point) = (*before, x - d);
        let mut normal = self.layer.normal(slide.face, positions);
        if !offset.sticks() {
            after.lost += before.bound * (offset.distance - before.bound);
            let by = offset.across * (1.0 - before.bound / offset.distance);
            let corner = self.layer.corners(slide.face, positions)[0];
            let foot = point - normal * (point - corner).dot(&normal);
            let by = by - normal * by.dot(&normal);
            let Some((face, foot)) = self.layer.walk(positions, slide.face, &foot, &by) else {
                return Place {
                    face: -1.0 - before.face,
                    ..after
                };
            };
            normal = self.layer.normal(face, positions);
            point = foot + normal * before.height;
            let tet = self.layer.faces[face as usize].tet;
            let corners = tet.map(|node| positions[node as usize]);
            let [_, b, c, d] = coordinates(&corners, &point);
            (after.face, after.weights) = (f64::from(face), [b, c, d]);
        }
        after.normal = normal;
        after.bound = self.least_bound + self.friction * (point - x).dot(&normal).max(0.0);
        after
    }

    /// All ties that are not free after an edit of the mesh, and which of these it was. A tie is on the face nearest to its point at rest, of those of the
    /// elements that its element has become, on the same side of the layer.
    pub(crate) fn follow(&self, edit: &Followed<'_>) -> (Self, Vec<Vec<u32>>) {
        let layer = self.layer.after_edit(edit.mesh);
        let (mut slides, mut ancestors) = (Vec::new(), Vec::new());
        let held = |(_, slide): &(usize, &Slide)| !slide.is_free;
        for (old, slide) in self.slides.iter().enumerate().filter(held) {
            let element = self.layer.faces[slide.face as usize].element;
            let (children, _) = (edit.children)(element);
            let mut point = Vector3::zeros();
            for (node, weight) in slide.stencil.weighted().skip(1) {
                point -= edit.rest_positions[node] * weight;
            }
            let side = self.layer.normal(slide.face, edit.rest_positions);
            let at_rest = &edit.mesh.positions;
            let of_children = (0u32..).zip(&layer.faces).filter(|(index, face)| {
                let normal = layer.normal(*index, at_rest);
                children.contains(&face.element) && normal.dot(&side) > GOES_ON
            });
            let apart = of_children.map(|(index, _)| {
                let closest = closest_on_triangle(&point, &layer.corners(index, at_rest)).point;
                ((closest - point).norm(), index)
            });
            let nearest = apart.reduce(|best, next| if next.0 < best.0 { next } else { best });
            let copies = (edit.copies)(slide.stencil.nodes[0]);
            let (Some((_, face)), false) = (nearest, copies.is_empty()) else {
                continue;
            };
            let element = layer.faces[face as usize].element;
            let support = Support::Tet(
                edit.mesh.tets[element as usize],
                coordinates(&edit.mesh.corners(element as usize), &point),
            );
            let part = slide.stiffness / copies.len() as f64;
            for node in copies {
                let stencil = Stencil::of(&Tie {
                    node,
                    support,
                    element,
                    stiffness: part,
                });
                slides.push(Slide {
                    stencil,
                    stiffness: part,
                    face,
                    is_free: false,
                    start: Place {
                        face: f64::from(face),
                        weights: weights(&stencil),
                        ..slide.start
                    },
                });
                ancestors.push(vec![old as u32]);
            }
        }
        let followed = Self {
            layer: Arc::new(layer),
            slides,
            friction: self.friction,
            least_bound: self.least_bound,
        };
        (followed, ancestors)
    }
}

/// The weights of the last three nodes of the tetrahedron.
fn weights(stencil: &Stencil) -> [f64; 3] {
    [2, 3, 4].map(|node| -stencil.weights[node])
}

impl Elements for Sliding {
    fn kind(&self) -> EnergyKind {
        EnergyKind::Coupling
    }

    fn slides(&self) -> bool {
        true
    }

    fn count(&self) -> usize {
        self.slides.len()
    }

    fn nodes(&self, element: usize) -> &[u32] {
        self.slides[element].stencil.nodes()
    }

    fn initial_internal(&self) -> Vec<f64> {
        let mut internal = vec![0.0; BLOCKS * self.slides.len()];
        for (element, slide) in self.slides.iter().enumerate() {
            slide.start.write(&mut internal, element);
        }
        internal
    }

    fn energy(&self, at: &Configuration<'_>) -> f64 {
        let offsets = (0..self.count()).map(|e| self.offset(e, at.positions, at.internal));
        offsets.flatten().map(|(of, k)| k * of.energy()).sum()
    }

    fn add_forces(&self, range: Range<usize>, at: &Configuration<'_>, forces: &mut NodeWindow<'_>) {
        for element in range {
            let Some((of, k)) = self.offset(element, at.positions, at.internal) else {
                continue;
            };
            let pull = (of.normal * of.along + of.across * of.secant()) * -k;
            for (node, weight) in self.slides[element].stencil.weighted() {
                forces.add(node as u32, pull * weight);
            }
        }
    }

    fn stiffness(
        &self,
        element: usize,
        at: &Configuration<'_>,
        _tangent: Tangent,
        out: &mut ElementMatrix,
    ) {
        let stencil = &self.slides[element].stencil;
        out.reset(stencil.count);
        let Some((of, k)) = self.offset(element, at.positions, at.internal) else {
            return;
        };
        let block = of.tangent() * k;
        for i in 0..stencil.count {
            for j in 0..stencil.count {
                *out.block_mut(i, j) = block * (stencil.weights[i] * stencil.weights[j]);
            }
        }
    }

    fn is_viscous(&self) -> bool {
        false
    }

    fn relaxation_time(&self, _: usize) -> f64 {
        0.0
    }

    fn damping(&self, element: usize, _at: &Configuration<'_>, out: &mut ElementMatrix) {
        out.reset(self.slides[element].stencil.count);
    }

    fn scale(&mut self, element: usize, factor: f64) {
        self.slides[element].stiffness *= factor;
    }

    fn shifted(&self, nodes: u32) -> Arc<dyn Elements> {
        let mut shifted = self.clone();
        for slide in &mut shifted.slides {
            slide.stencil.nodes.iter_mut().for_each(|n| *n += nodes);
        }
        if nodes > 0 {
            shifted.layer = Arc::new(self.layer.shifted(nodes));
        }
        Arc::new(shifted)
    }

    /// Each of its nodes.
    fn keys(&self, element: usize, visit: &mut dyn FnMut(Key)) {
        let nodes = self.nodes(element);
        nodes.iter().for_each(|node| visit(Key::new(&[*node])));
    }

    fn splice(&mut self, removed: &[u32], added: &dyn Elements) -> bool {
        let Some(added) = (added as &dyn Any).downcast_ref::<Self>() else {
            return false;
        };
        splice(&mut self.slides, removed, &added.slides);
        self.layer = added.layer.clone();
        true
    }

    fn make_room(&mut self) {
        make_room(&mut self.slides);
    }

    /// Face and weights are new; all else is that of the tie it was.
    fn inherited(&self, added: &dyn Elements, ancestors: &[Vec<u32>]) -> Vec<Inherited> {
        let Some(added) = (added as &dyn Any).downcast_ref::<Self>() else {
            return Vec::new();
        };
        let mut inherited = Vec::with_capacity(BLOCKS * ancestors.len());
        for block in 0..BLOCKS {
            for (slide, from) in added.slides.iter().zip(ancestors) {
                let old = (block * self.slides.len()) as u32 + from[0];
                inherited.push(match block {
                    0..4 => Inherited {
                        constant: slide.start.values()[block],
                        terms: Vec::new(),
                    },
                    _ => Inherited {
                        constant: 0.0,
                        terms: vec![(old, 1.0)],
                    },
                });
            }
        }
        inherited
    }

    fn flow(&self, positions: &[Vector3<f64>], internal: &mut [f64], _h: f64) -> bool {
        for (element, slide) in self.slides.iter().enumerate() {
            let before = Place::read(internal, element);
            if !before.is_free() {
                let after = self.followed(slide, &before, positions);
                after.write(internal, element);
            }
        }
        false
    }

    fn dissipated(&self, internal: &[f64]) -> f64 {
        let slides = self.slides.iter().enumerate();
        let lost = slides.map(|(e, slide)| slide.stiffness * Place::read(internal, e).lost);
        lost.sum()
    }

    fn admits(&self, internal: &[f64]) -> bool {
        let count = self.layer.faces.len() as f64;
        let is_face = |face: &f64| face.fract() == 0.0 && (-count..count).contains(face);
        let is_possible = |element: usize| {
            let place = Place::read(internal, element);
            is_face(&place.face) && place.bound >= 0.0 && place.lost >= 0.0
        };
        internal.iter().all(|value| value.is_finite()) && (0..self.slides.len()).all(is_possible)
    }

    fn is_in_place(&self, internal: &[f64]) -> bool {
        self.slides.iter().enumerate().all(|(element, slide)| {
            let place = Place::read(internal, element);
            (place.index(), place.is_free()) == (slide.face, slide.is_free)
                && place.weights == weights(&slide.stencil)
        })
    }

    fn moved(&self, internal: &[f64]) -> Vec<u32> {
        let slides = (0u32..).zip(&self.slides).filter(|(element, slide)| {
            let place = Place::read(internal, *element as usize);
            let tet = |face: u32| self.layer.faces[face as usize].tet;
            tet(place.index()) != tet(slide.face)
        });
        slides.map(|(element, _)| element).collect()
    }

    fn relocate(&mut self, internal: &[f64]) {
        for (element, slide) in self.slides.iter_mut().enumerate() {
            let place = Place::read(internal, element);
            (slide.face, slide.is_free) = (place.index(), place.is_free());
            let tet = self.layer.faces[slide.face as usize].tet;
            slide.stencil.nodes[1..].copy_from_slice(&tet);
            let [b, c, d] = place.weights;
            // Rounded as the coordinates of a tie that has never moved: the same place, the same bits.
            slide.stencil.weights = [1.0, -(1.0 - b - c - d), -b, -c, -d];
        }
    }
}

#[cfg(test)]
mod tests;
