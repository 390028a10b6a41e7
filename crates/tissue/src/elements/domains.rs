//! Domains with a constant deformation gradient, and the plain ones: tetrahedra.

use super::key::Key;
use super::splice::{make_room, splice};
use crate::elements::NodeWindow;
use crate::lanes::{FourVectors, LANES, Lanes, lanes, set_matrix, set_vector, vector_of};
use crate::law::{Constants, Law};
use crate::number::{self, columns, columns_of, components_of, cross, dot, three};
use microsim_mesh::{FAMILIES, TetMesh};
use nalgebra::{Matrix3, Vector3};
use std::fmt::Debug;
use std::ops::Range;

/// Domains over which F = Σ x_i ⊗ b_i, with Σ b_i = 0: the deformation gradient from the natural state, which is the place in the mesh unless that has
/// prestretches.
pub trait Domains: Clone + Debug + Send + Sync + 'static {
    /// Number of domains.
    fn count(&self) -> usize;

    /// Nodes of a domain, each once.
    fn nodes(&self, domain: usize) -> &[u32];

    /// Volume in the natural state \[m³\].
    fn volume(&self, domain: usize) -> f64;

    /// Fibre directions in the natural state, unit vectors; zero where the mesh has none.
    fn directions(&self, domain: usize) -> [Vector3<f64>; FAMILIES];

    /// The fibre directions of four domains from `first` on, a multiple of four; beyond the end those of the last one.
    #[inline(always)]
    fn directions_of_four(&self, first: usize) -> [FourVectors; FAMILIES] {
        let mut four = NO_DIRECTIONS;
        for lane in 0..LANES {
            let domain = (first + lane).min(self.count() - 1);
            for (four, direction) in four.iter_mut().zip(&self.directions(domain)) {
                set_vector(four, lane, direction);
            }
        }
        four
    }

    /// The same where a law has directions; zero where it has none.
    #[inline(always)]
    fn directions_for<C: Constants>(&self, first: usize) -> [FourVectors; FAMILIES] {
        match C::DIRECTIONS {
            0 => NO_DIRECTIONS,
            _ => self.directions_of_four(first),
        }
    }

    /// The deformation gradients of four domains, as [`directions_of_four`](Self::directions_of_four).
    #[inline(always)]
    fn deformations_of_four(&self, first: usize, positions: &[Vector3<f64>]) -> [FourVectors; 3] {
        let mut four = [[Lanes::splat(0.0); 3]; 3];
        for lane in 0..LANES {
            let domain = (first + lane).min(self.count() - 1);
            set_matrix(&mut four, lane, &self.deformation(domain, positions));
        }
        four
    }

    /// Gradients and volumes of four domains from `first` on, a multiple of four, if all domains are tetrahedra; those of what is beyond the end
    /// mean nothing. None by default.
    #[inline(always)]
    fn tetrahedra_of_four(&self, _first: usize) -> Option<FourTetrahedra> {
        None
    }

    /// Takes a volume times a factor; all that a domain does is in proportion to its volume.
    fn scale_volume(&mut self, domain: usize, factor: f64);

    /// Takes each node so many further on.
    fn shift_nodes(&mut self, by: u32);

    /// Calls `visit` with each key of a domain, as [`Elements::keys`](super::Elements::keys).
    fn keys(&self, domain: usize, visit: &mut dyn FnMut(Key));

    /// Takes domains out and puts others in, as [`Elements::splice`](super::Elements::splice).
    fn splice(&mut self, removed: &[u32], added: &Self) -> bool;

    /// As [`Elements::make_room`](super::Elements::make_room).
    fn make_room(&mut self);

    /// b_i \[1/m\] of the i-th node of a domain.
    fn gradient(&self, domain: usize, i: usize) -> Vector3<f64>;

    /// F of positions \[m\], or Ḟ of velocities \[m/s\].
    fn deformation(&self, domain: usize, positions: &[Vector3<f64>]) -> Matrix3<f64>;

    /// Adds the forces −V P b_i of the stresses P \[Pa\] of four domains from `first` on to the nodes, of those in `range` and in ascending order.
    fn add_forces_of_four(
        &self,
        first: usize,
        range: &Range<usize>,
        stress: &[FourVectors; 3],
        forces: &mut NodeWindow<'_>,
    );

    /// Adds the forces of a law in the domains of `range`, in ascending order.
    #[inline]
    fn add_elastic_forces<L: Law>(
        &self,
        range: Range<usize>,
        positions: &[Vector3<f64>],
        constants: &L::Constants,
        forces: &mut NodeWindow<'_>,
    ) {
        for first in (range.start / LANES * LANES..range.end).step_by(LANES) {
            let f = self.deformations_of_four(first, positions);
            let directions = self.directions_for::<L::Constants>(first);
            let stress = L::stress_of_four(&f, &directions, constants);
            self.add_forces_of_four(first, &range, &stress, forces);
        }
    }
}

/// The lanes of those of four domains that are in a range.
#[inline(always)]
pub(super) fn lanes_in(first: usize, range: &Range<usize>) -> Range<usize> {
    let from_first = |end: usize| end.saturating_sub(first).min(LANES);
    from_first(range.start)..from_first(range.end)
}

/// Gradients of the last three corners \[1/m\] and volumes \[m³\] of four tetrahedra.
#[derive(Clone, Copy, Debug)]
pub struct FourTetrahedra {
    /// That of the first corner is minus their sum.
    pub gradients: [FourVectors; 3],
    /// In the natural state.
    pub volumes: Lanes,
}

/// Linear tetrahedra, as arrays.
#[derive(Clone, Debug)]
pub struct Tetrahedra {
    nodes: Vec<[u32; 4]>,
    /// Gradients of the last three corners, of four elements each; that of the first is minus their sum.
    gradients: Vec<[FourVectors; 3]>,
    volumes: Vec<Lanes>,
    shapes: Vec<FourShapes>,
    /// Fibre directions of four elements each, if the mesh has any.
    directions: Vec<[FourVectors; FAMILIES]>,
}

/// What is held of one element: see [`FourShapes`].
#[derive(Clone, Copy, Debug)]
struct Element {
    gradients: [Vector3<f64>; 3],
    volume: f64,
    metric: [f64; 6],
    per_volume: f64,
    sixth: f64,
    directions: [Vector3<f64>; FAMILIES],
}

/// What forces by areas need of four elements.
#[derive(Clone, Copy, Debug)]
struct FourShapes {
    /// V g_i·g_j of the last three corners \[m\]: 11, 22, 33, 23, 31, 12.
    metric: [Lanes; 6],
    /// Reciprocal of six volumes, before any factor \[1/m³\].
    per_volume: Lanes,
    /// A sixth of the factor.
    sixth: Lanes,
}

/// Blocks of four elements that are gathered before they are worked on: a whole register is read only when the single numbers in it have
/// long been written.
const BLOCKS: usize = 16;

impl Tetrahedra {
    /// The elements of `mesh` with the indices `elements`.
    pub fn new(mesh: &TetMesh, elements: &[u32]) -> Self {
        let blocks = elements.len().div_ceil(LANES);
        let none = Lanes::splat(0.0);
        let mut tetrahedra = Self {
            nodes: Vec::with_capacity(elements.len()),
            gradients: vec![[[none; 3]; 3]; blocks],
            volumes: vec![none; blocks],
            shapes: vec![FourShapes::NONE; blocks],
            directions: match mesh.directions.is_empty() {
                true => Vec::new(),
                false => vec![NO_DIRECTIONS; blocks],
            },
        };
        for (index, &element) in elements.iter().enumerate() {
            let (gradients, volume) = natural_shape(mesh, element as usize);
            tetrahedra.nodes.push(mesh.tets[element as usize]);
            let [g1, g2, g3] = &gradients;
            let products = [(g1, g1), (g2, g2), (g3, g3), (g2, g3), (g3, g1), (g1, g2)];
            tetrahedra.set_element(
                index,
                &Element {
                    metric: products.map(|(a, b)| volume * a.dot(b)),
                    gradients,
                    volume,
                    per_volume: 1.0 / (6.0 * volume),
                    sixth: 1.0 / 6.0,
                    directions: mesh
                        .directions
                        .get(element as usize)
                        .copied()
                        .unwrap_or_default(),
                },
            );
        }
        tetrahedra
    }

    /// Makes room for so many elements, and no more.
    fn reserve(&mut self, count: usize) {
        let blocks = count.div_ceil(LANES);
        let none = Lanes::splat(0.0);
        self.gradients.resize(blocks, [[none; 3]; 3]);
        self.volumes.resize(blocks, none);
        self.shapes.resize(blocks, FourShapes::NONE);
        if !self.directions.is_empty() {
            self.directions.resize(blocks, NO_DIRECTIONS);
        }
    }

    /// What is held of one element, but its nodes.
    fn element(&self, element: usize) -> Element {
        let (block, lane) = (element / LANES, element % LANES);
        let FourShapes {
            metric,
            per_volume,
            sixth,
        } = &self.shapes[block];
        Element {
            gradients: self.gradients(element),
            volume: self.volumes[block].0[lane],
            metric: metric.map(|lanes| lanes.0[lane]),
            per_volume: per_volume.0[lane],
            sixth: sixth.0[lane],
            directions: self.directions(element),
        }
    }

    fn set_element(&mut self, element: usize, one: &Element) {
        let (block, lane) = (element / LANES, element % LANES);
        for (lanes, gradient) in self.gradients[block].iter_mut().zip(&one.gradients) {
            for (lanes, component) in lanes.iter_mut().zip(gradient) {
                lanes.0[lane] = *component;
            }
        }
        self.volumes[block].0[lane] = one.volume;
        let shapes = &mut self.shapes[block];
        for (lanes, entry) in shapes.metric.iter_mut().zip(&one.metric) {
            lanes.0[lane] = *entry;
        }
        shapes.per_volume.0[lane] = one.per_volume;
        shapes.sixth.0[lane] = one.sixth;
        if let Some(directions) = self.directions.get_mut(block) {
            for (four, direction) in directions.iter_mut().zip(&one.directions) {
                set_vector(four, lane, direction);
            }
        }
    }

    /// Gradients of the last three corners of an element.
    #[inline(always)]
    fn gradients(&self, element: usize) -> [Vector3<f64>; 3] {
        let gradients = &self.gradients[element / LANES];
        gradients.each_ref().map(|g| vector_of(g, element % LANES))
    }

    /// Adds the forces of the elements of some blocks of four, of which those in `range` count.
    #[inline(always)]
    fn add_blocks<L: Law>(
        &self,
        corners: &mut [[FourVectors; 4]; BLOCKS],
        blocks: Range<usize>,
        range: &Range<usize>,
        positions: &[Vector3<f64>],
        constants: &L::Constants,
        forces: &mut NodeWindow<'_>,
    ) {
        // In the last block what was there before stands in for elements that are missing.
        let end = (LANES * blocks.end).min(self.nodes.len());
        let nodes = &self.nodes[LANES * blocks.start..end];
        for (fours, corners) in nodes.chunks(LANES).zip(&mut *corners) {
            for (lane, nodes) in fours.iter().enumerate() {
                for (corner, &node) in corners.iter_mut().zip(nodes) {
                    let place = &positions[node as usize];
                    corner[0].0[lane] = place[0];
                    corner[1].0[lane] = place[1];
                    corner[2].0[lane] = place[2];
                }
            }
        }
        for (corners, block) in corners.iter_mut().zip(blocks) {
            if !forces_by_areas::<L>(corners, &self.shapes[block], constants) {
                let (gradients, volumes) = (&self.gradients[block], &self.volumes[block]);
                let directions = self.directions.get(block).unwrap_or(&NO_DIRECTIONS);
                forces_by_stress::<L>(corners, gradients, volumes, directions, constants);
            }
        }
        let mut element = end - nodes.len();
        for (fours, corners) in nodes.chunks(LANES).zip(&*corners) {
            for (lane, nodes) in fours.iter().enumerate() {
                if range.contains(&element) {
                    for (force, &node) in corners.iter().zip(nodes) {
                        let [x, y, z] = force;
                        forces.add(node, Vector3::new(x.0[lane], y.0[lane], z.0[lane]));
                    }
                }
                element += 1;
            }
        }
    }
}

/// Of elements without fibres.
const NO_DIRECTIONS: [FourVectors; FAMILIES] = [[Lanes([0.0; LANES]); 3]; FAMILIES];

impl FourShapes {
    const NONE: Self = Self {
        metric: [Lanes([0.0; LANES]); 6],
        per_volume: Lanes([0.0; LANES]),
        sixth: Lanes([0.0; LANES]),
    };
}

/// F = Σ e_i ⊗ g_i of the edges from the first corner and the gradients of the others.
#[inline(always)]
fn deformation_of_edges(
    edges: &[FourVectors; 3],
    [g1, g2, g3]: &[FourVectors; 3],
) -> [FourVectors; 3] {
    three(|k| number::product(edges, &[g1[k], g2[k], g3[k]]))
}

/// Differences of the last three corners to the first.
#[inline(always)]
fn edges_of_four(corners: &[FourVectors; 4]) -> [FourVectors; 3] {
    three(|k| three(|i| corners[k + 1][i] - corners[0][i]))
}

/// The forces on the corners, of which the last three are given.
#[inline(always)]
fn balanced([f1, f2, f3]: [FourVectors; 3]) -> [FourVectors; 4] {
    [three(|i| -(f1[i] + f2[i] + f3[i])), f1, f2, f3]
}

/// The forces −V P b_i on the corners.
#[inline(always)]
fn forces_of_stress(
    stress: &[FourVectors; 3],
    gradients: &[FourVectors; 3],
    volumes: &Lanes,
) -> [FourVectors; 4] {
    let scaled = columns(|k, i| -(stress[k][i] * *volumes));
    balanced(three(|corner| number::product(&scaled, &gradients[corner])))
}

/// Replaces the corners of four elements by the forces on them, by P = μ F + b' cof F; returns false for a law of another form.
/// With the edges e_j from the first corner, V F g_i = Σ_j V g_i·g_j e_j, and V cof(F) g_i is a third of the area vector of
/// the face opposite to the corner.
///
/// A function of its own, which is not inlined: between memory and memory the compiler works on whole registers, while next to the
/// gathering of single numbers it does not.
#[inline(never)]
fn forces_by_areas<L: Law>(
    corners: &mut [FourVectors; 4],
    shapes: &FourShapes,
    constants: &L::Constants,
) -> bool {
    let [e1, e2, e3] = edges_of_four(corners);
    let doubled = [cross(&e2, &e3), cross(&e3, &e1), cross(&e1, &e2)];
    let j = dot(&e1, &doubled[0]) * shapes.per_volume;
    let Some(slope) = L::slope_of_four(j, constants) else {
        return false;
    };
    let mu = constants.elasticity().lame.mu;
    let (along, across) = (Lanes::splat(-mu), -(slope * shapes.sixth));
    let [k11, k22, k33, k23, k31, k12] = shapes.metric;
    let force = |[a, b, c]: [Lanes; 3], doubled: &FourVectors| -> FourVectors {
        let entry = |i: usize| (e1[i] * a + e2[i] * b + e3[i] * c) * along + doubled[i] * across;
        [entry(0), entry(1), entry(2)]
    };
    let forces = [
        force([k11, k12, k31], &doubled[0]),
        force([k12, k22, k23], &doubled[1]),
        force([k31, k23, k33], &doubled[2]),
    ];
    *corners = balanced(forces);
    true
}

/// Replaces the corners of four elements by the forces on them.
#[inline(never)]
fn forces_by_stress<L: Law>(
    corners: &mut [FourVectors; 4],
    gradients: &[FourVectors; 3],
    volumes: &Lanes,
    directions: &[FourVectors; FAMILIES],
    constants: &L::Constants,
) {
    let f = deformation_of_edges(&edges_of_four(corners), gradients);
    let stress = L::stress_of_four(&f, directions, constants);
    *corners = forces_of_stress(&stress, gradients, volumes);
}

/// Adds the forces S b_i of S = −V P to the nodes of a domain with these gradients, that on the first node as minus the sum of the others.
#[inline(always)]
pub(super) fn add_balanced(
    scaled: &Matrix3<f64>,
    nodes: &[u32],
    gradients: &[Vector3<f64>],
    forces: &mut NodeWindow<'_>,
) {
    let columns = columns_of(scaled);
    let mut sum = Vector3::zeros();
    for (node, b) in nodes[1..].iter().zip(&gradients[1..]) {
        let force = Vector3::from(number::product(&columns, &[b[0], b[1], b[2]]));
        sum += force;
        forces.add(*node, force);
    }
    forces.add(nodes[0], -sum);
}

/// Gradients of the shape functions of the last three corners \[1/m\], and the volume \[m³\].
pub(super) fn shape([a, b, c, d]: &[Vector3<f64>; 4]) -> ([Vector3<f64>; 3], f64) {
    let (e1, e2, e3) = (b - a, c - a, d - a);
    let normals = [e2.cross(&e3), e3.cross(&e1), e1.cross(&e2)];
    let six_volumes = e1.dot(&normals[0]);
    (normals.map(|n| n / six_volumes), six_volumes / 6.0)
}

/// As [`shape`], of an element of a mesh in its natural state: with its prestretch G the deformation gradient from there is
/// F G = Σ x_i ⊗ Gᵀ b_i, and the volume V/det G.
pub(super) fn natural_shape(mesh: &TetMesh, element: usize) -> ([Vector3<f64>; 3], f64) {
    let (gradients, volume) = shape(&mesh.corners(element));
    match mesh.prestretches.get(element) {
        None => (gradients, volume),
        Some(g) => (gradients.map(|b| g.tr_mul(&b)), volume / g.determinant()),
    }
}

impl Domains for Tetrahedra {
    fn count(&self) -> usize {
        self.nodes.len()
    }

    fn nodes(&self, domain: usize) -> &[u32] {
        &self.nodes[domain]
    }

    fn volume(&self, domain: usize) -> f64 {
        self.volumes[domain / LANES].0[domain % LANES]
    }

    fn directions(&self, domain: usize) -> [Vector3<f64>; FAMILIES] {
        let directions = self.directions.get(domain / LANES);
        let of_lane = |a: &FourVectors| vector_of(a, domain % LANES);
        directions.map_or_else(Default::default, |four| four.each_ref().map(of_lane))
    }

    fn scale_volume(&mut self, domain: usize, factor: f64) {
        let mut one = self.element(domain);
        one.volume *= factor;
        one.sixth *= factor;
        one.metric.iter_mut().for_each(|entry| *entry *= factor);
        self.set_element(domain, &one);
    }

    fn shift_nodes(&mut self, by: u32) {
        self.nodes.iter_mut().flatten().for_each(|n| *n += by);
    }

    fn keys(&self, domain: usize, visit: &mut dyn FnMut(Key)) {
        visit(Key::new(&self.nodes[domain]));
    }

    fn splice(&mut self, removed: &[u32], added: &Self) -> bool {
        let both = removed.len().min(added.count());
        for (new, &place) in removed[..both].iter().enumerate() {
            self.set_element(place as usize, &added.element(new));
        }
        let mut count = self.count();
        for new in both..added.count() {
            self.reserve(count + 1);
            self.set_element(count, &added.element(new));
            count += 1;
        }
        for &place in removed[both..].iter().rev() {
            count -= 1;
            let last = self.element(count);
            self.set_element(place as usize, &last);
        }
        self.reserve(count);
        splice(&mut self.nodes, removed, &added.nodes);
        true
    }

    fn make_room(&mut self) {
        make_room(&mut self.nodes);
        make_room(&mut self.gradients);
        make_room(&mut self.volumes);
        make_room(&mut self.shapes);
        make_room(&mut self.directions);
    }

    #[inline(always)]
    fn gradient(&self, domain: usize, i: usize) -> Vector3<f64> {
        let gradients = self.gradients(domain);
        match i {
            0 => -(gradients[0] + gradients[1] + gradients[2]),
            _ => gradients[i - 1],
        }
    }

    #[inline(always)]
    fn deformation(&self, domain: usize, positions: &[Vector3<f64>]) -> Matrix3<f64> {
        let [a, b, c, d] = self.nodes[domain];
        let at = |node: u32| &positions[node as usize];
        let (a, b, c, d) = (at(a), at(b), at(c), at(d));
        let [g1, g2, g3] = self.gradients(domain);
        let edges = components_of(&[b - a, c - a, d - a]);
        three(|k| number::product(&edges, &[g1[k], g2[k], g3[k]])).into()
    }

    #[inline(always)]
    fn deformations_of_four(&self, first: usize, positions: &[Vector3<f64>]) -> [FourVectors; 3] {
        let last = self.nodes.len() - 1;
        let nodes = lanes(|lane| &self.nodes[last.min(first + lane)]);
        let places = lanes(|lane| nodes[lane].each_ref().map(|n| &positions[*n as usize]));
        let edges =
            three(|k| three(|i| Lanes(lanes(|lane| places[lane][k + 1][i] - places[lane][0][i]))));
        let mut gradients = self.gradients[first / LANES];
        for lane in 1..LANES {
            // Beyond the end those of the last one.
            if first + lane > last {
                let last = self.gradients(last);
                for (lanes, gradient) in gradients.iter_mut().zip(&last) {
                    set_vector(lanes, lane, gradient);
                }
            }
        }
        deformation_of_edges(&edges, &gradients)
    }

    #[inline(always)]
    fn tetrahedra_of_four(&self, first: usize) -> Option<FourTetrahedra> {
        Some(FourTetrahedra {
            gradients: self.gradients[first / LANES],
            volumes: self.volumes[first / LANES],
        })
    }

    #[inline(always)]
    fn add_forces_of_four(
        &self,
        first: usize,
        range: &Range<usize>,
        stress: &[FourVectors; 3],
        forces: &mut NodeWindow<'_>,
    ) {
        let block = first / LANES;
        let of_corners = forces_of_stress(stress, &self.gradients[block], &self.volumes[block]);
        for lane in lanes_in(first, range) {
            for (node, force) in self.nodes[first + lane].iter().zip(&of_corners) {
                forces.add(*node, vector_of(force, lane));
            }
        }
    }

    fn add_elastic_forces<L: Law>(
        &self,
        range: Range<usize>,
        positions: &[Vector3<f64>],
        constants: &L::Constants,
        forces: &mut NodeWindow<'_>,
    ) {
        let mut corners = [[[Lanes::splat(0.0); 3]; 4]; BLOCKS];
        let end = range.end.div_ceil(LANES);
        for first in (range.start / LANES..end).step_by(BLOCKS) {
            let blocks = first..end.min(first + BLOCKS);
            self.add_blocks::<L>(&mut corners, blocks, &range, positions, constants, forces);
        }
    }
}

#[cfg(test)]
mod tests;
