//! Marked tetrahedra and their bisection (Arnold, Mukherjee & Pouly 2000, *Locally adapted tetrahedral meshes using bisection*,
//! SIAM J. Sci. Comput. 22).
//!
//! Every face has one marked edge, the same for both of its elements, and every element one among those of its faces, its refinement edge. It is
//! halved at that one; the marks of the halves follow from its own, so that neighbours always agree on how a face is divided, and the shapes
//! of all descendants of an element are finite in number.

use crate::tet_mesh::EDGES;
use nalgebra::Vector3;

/// An edge, smaller node first.
pub(super) type Edge = [u32; 2];

/// The edge between two nodes.
pub(super) fn edge(a: u32, b: u32) -> Edge {
    [a.min(b), a.max(b)]
}

/// Two edges of an element that are its longest have one that comes first all the same: that of the larger node indices.
type Length = (f64, Edge);

fn longest(edges: impl Iterator<Item = Edge>, positions: &[Vector3<f64>]) -> Edge {
    let longest = edges.fold((f64::NEG_INFINITY, [0; 2]), |best: Length, [a, b]| {
        let squared = (positions[b as usize] - positions[a as usize]).norm_squared();
        let longer = squared > best.0 || squared == best.0 && [a, b] > best.1;
        if longer { (squared, [a, b]) } else { best }
    });
    longest.1
}

/// A tetrahedron with marked edges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Marked {
    /// Corners in their order, which orients it.
    pub nodes: [u32; 4],
    /// The edge at which it is halved.
    pub refinement: Edge,
    /// The marked edge of the face opposite to each corner. Faces with the refinement edge have that one.
    faces: [Edge; 4],
    /// Of one whose marked edges lie in a plane: whether its parent's did as well.
    flag: bool,
}

impl Marked {
    /// An element of the mesh that is to be refined: the longest edges are marked.
    pub fn new(nodes: [u32; 4], positions: &[Vector3<f64>]) -> Self {
        let edges = EDGES.map(|[i, j]| edge(nodes[i], nodes[j]));
        let faces = nodes.map(|apex| {
            let of_face = edges.into_iter().filter(|edge| !edge.contains(&apex));
            longest(of_face, positions)
        });
        Self {
            nodes,
            refinement: longest(edges.into_iter(), positions),
            faces,
            flag: false,
        }
    }

    /// Its edges.
    pub fn edges(&self) -> [Edge; 6] {
        EDGES.map(|[i, j]| edge(self.nodes[i], self.nodes[j]))
    }

    /// The length of its longest edge \[m\].
    pub fn size(&self, positions: &[Vector3<f64>]) -> f64 {
        let squared = EDGES.map(|[i, j]| {
            let [a, b] = [i, j].map(|corner| positions[self.nodes[corner] as usize]);
            (b - a).norm_squared()
        });
        squared.into_iter().fold(0.0, f64::max).sqrt()
    }

    /// Its halves, that with the first end of the refinement edge first; `middle` is the node in the middle of that edge.
    pub fn halves(&self, middle: u32) -> [Self; 2] {
        let [a, b] = self.refinement;
        // Marked edges of the two faces without the refinement edge that lie in one plane with it: they meet, each at one end of it.
        let place = |node: u32| self.nodes.iter().position(|other| *other == node);
        let (Some(of_a), Some(of_b)) = (place(a), place(b)) else {
            unreachable!("a refinement edge joins two corners");
        };
        let (opposite_a, opposite_b) = (self.faces[of_a], self.faces[of_b]);
        let others = |edge: Edge, end: u32| edge.into_iter().find(|n| *n != end);
        let touches = opposite_a.contains(&b) && opposite_b.contains(&a);
        let common = match touches {
            true => others(opposite_a, b).filter(|node| Some(*node) == others(opposite_b, a)),
            false => None,
        };
        let between = match common {
            Some(node) if self.flag => edge(middle, node),
            _ => {
                let mut rest = self
                    .nodes
                    .into_iter()
                    .filter(|node| *node != a && *node != b);
                match (rest.next(), rest.next()) {
                    (Some(c), Some(d)) => edge(c, d),
                    _ => unreachable!("a tetrahedron has two corners beside an edge"),
                }
            }
        };
        let flag = common.is_some() && !self.flag;
        // `gone` gives its place to the middle, `stays` is the other end.
        let half = |gone: usize, stays: usize| {
            let mut half = Self { flag, ..*self };
            half.nodes[gone] = middle;
            half.refinement = self.faces[gone];
            let [c, d] = others_of(gone, stays);
            // Of the two halved faces the edge opposite to the middle; of the new one `between`; the fourth is as it was.
            half.faces[stays] = between;
            half.faces[c] = edge(self.nodes[stays], self.nodes[d]);
            half.faces[d] = edge(self.nodes[stays], self.nodes[c]);
            half
        };
        [half(of_b, of_a), half(of_a, of_b)]
    }
}

/// The places of the two corners that are not at `i` and `j`.
fn others_of(i: usize, j: usize) -> [usize; 2] {
    let pair = EDGES
        .into_iter()
        .find(|pair| !pair.contains(&i) && !pair.contains(&j));
    pair.unwrap_or([0, 0])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::signed_volume;
    use microsim_random::SplitMix64;

    /// Squared lengths of the edges relative to their sum, ascending, and those of the faces: equal for similar tetrahedra (and mirrored ones).
    fn shape(corners: &[Vector3<f64>; 4]) -> Vec<f64> {
        let squared = |i: usize, j: usize| (corners[j] - corners[i]).norm_squared();
        let sum: f64 = EDGES.iter().map(|[i, j]| squared(*i, *j)).sum();
        let mut shape: Vec<f64> = EDGES.iter().map(|[i, j]| squared(*i, *j) / sum).collect();
        shape.sort_by(f64::total_cmp);
        let mut faces: Vec<f64> = [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]]
            .iter()
            .map(|[i, j, k]| (squared(*i, *j) + squared(*j, *k) + squared(*k, *i)) / sum)
            .collect();
        faces.sort_by(f64::total_cmp);
        shape.extend(faces);
        shape
    }

    /// The numbers of shapes after each generation of bisections of one tetrahedron.
    fn shapes(corners: [Vector3<f64>; 4], generations: usize) -> Vec<usize> {
        let mut positions = corners.to_vec();
        let mut elements = vec![Marked::new([0, 1, 2, 3], &positions)];
        let mut known: Vec<Vec<f64>> = Vec::new();
        let mut counts = Vec::new();
        for _ in 0..generations {
            let mut next = Vec::new();
            for element in elements {
                let corners = element.nodes.map(|n| positions[n as usize]);
                let [a, b, c, d] = &corners;
                assert!(signed_volume(a, b, c, d) > 0.0);
                let shape = shape(&corners);
                let same =
                    |other: &Vec<f64>| other.iter().zip(&shape).all(|(x, y)| (x - y).abs() < 1e-9);
                if !known.iter().any(same) {
                    known.push(shape);
                }
                let [p, q] = element.refinement.map(|n| positions[n as usize]);
                positions.push((p + q) / 2.0);
                next.extend(element.halves(positions.len() as u32 - 1));
            }
            elements = next;
            counts.push(known.len());
        }
        counts
    }

    /// A corner of a cube cut along its diagonal has the three shapes of Maubach (1995) and no more; any other has a finite number:
    /// Arnold, Mukherjee & Pouly give 72 as bound.
    #[test]
    fn descendants_have_few_shapes() {
        let kuhn = [
            Vector3::zeros(),
            Vector3::x(),
            Vector3::new(1.0, 1.0, 0.0),
            Vector3::repeat(1.0),
        ];
        assert_eq!(shapes(kuhn, 12).last(), Some(&3));
        let mut random = SplitMix64(5);
        for _ in 0..20 {
            let mut corners = [(); 4].map(|()| random.vector());
            let [a, b, c, d] = &corners;
            if signed_volume(a, b, c, d) < 0.0 {
                corners.swap(0, 1);
            }
            let counts = shapes(corners, 13);
            assert!(counts[12] <= 72, "{counts:?}");
            assert_eq!(
                counts[12], counts[10],
                "none is new in the last two generations: {counts:?}"
            );
        }
    }
}
