//! The constraints of a region of a mesh, with plain constants.

use super::edges::edges;
use super::fit::{fitted_moduli, spring_stiffness};
use super::{Coefficients, SpringForm};
use crate::elements::Constraint;
use microsim_mesh::{TetMesh, signed_volume};

/// c of k = Σ c·E·L0, 2√2/25.
const SPRING_SHARE: f64 = 0.08 * std::f64::consts::SQRT_2;

/// Below this fraction of the size of a regular element one counts as flat (NUMERICS 1.1).
const FLAT: f64 = 1e-3;

/// The faces of a tetrahedron as corners.
const FACES: [[usize; 3]; 4] = [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]];

/// The part of a mesh that a material fills.
pub(super) struct Region<'a> {
    pub mesh: &'a TetMesh,
    pub elements: &'a [u32],
    pub form: &'a SpringForm,
    pub relaxation_time: f64,
}

impl Region<'_> {
    /// One spring per edge, its stiffness a sum over the elements around it in ascending order.
    pub(super) fn springs(&self) -> Vec<Constraint<2>> {
        let edges = |&element: &u32| {
            let edges = self.mesh.element_edges(element as usize);
            edges.map(|nodes| (nodes, element))
        };
        self.springs_around(&sorted(self.elements.iter().flat_map(edges)))
    }

    /// One spring per edge of these ascending pairs of edge and element.
    pub(super) fn springs_around(&self, around: &[([u32; 2], u32)]) -> Vec<Constraint<2>> {
        let spring = |nodes: [u32; 2], around: &[([u32; 2], u32)]| {
            let [i, j] = nodes.map(|node| self.mesh.positions[node as usize]);
            let rest = (j - i).norm();
            let coefficients = match self.form {
                SpringForm::Plain(constants) => constants.length,
                SpringForm::Normalised(constants) => over_square(constants.length, rest),
                SpringForm::Scaled(moduli) => {
                    elastic(around.len() as f64 * (SPRING_SHARE * moduli.stretch * rest))
                }
                SpringForm::Fitted { young, poisson } => {
                    let (stretch, _) = fitted_moduli(*young, *poisson);
                    let share = |(_, element): &([u32; 2], u32)| {
                        spring_stiffness(&self.mesh.corners(*element as usize), stretch)
                    };
                    elastic(around.iter().map(share).sum())
                }
            };
            self.constraint(nodes, rest, coefficients)
        };
        shared(around, spring)
    }

    /// One triangle per face.
    pub(super) fn areas(&self) -> Vec<Constraint<3>> {
        if let SpringForm::Fitted { .. } = self.form {
            return Vec::new();
        }
        let faces = |&element: &u32| {
            let tet = &self.mesh.tets[element as usize];
            FACES.map(|face| {
                let mut nodes = face.map(|corner| tet[corner]);
                nodes.sort_unstable();
                (nodes, element)
            })
        };
        self.areas_around(&sorted(self.elements.iter().flat_map(faces)))
    }

    /// One triangle per face of these ascending pairs of face and element.
    pub(super) fn areas_around(&self, around: &[([u32; 3], u32)]) -> Vec<Constraint<3>> {
        let area = |nodes: [u32; 3], around: &[([u32; 3], u32)]| {
            let [a, b, c] = nodes.map(|node| self.mesh.positions[node as usize]);
            let rest = 0.5 * (b - a).cross(&(c - a)).norm();
            let mean = ((b - a).norm() + (c - b).norm() + (a - c).norm()) / 3.0;
            let scale = scale(rest, 0.25 * f64::sqrt(3.0) * mean * mean);
            let coefficients = match self.form {
                SpringForm::Plain(constants) => constants.area,
                SpringForm::Normalised(constants) => over_square(constants.area, scale),
                SpringForm::Scaled(moduli) => {
                    let volume = |(_, element): &([u32; 3], u32)| self.volume(*element) / 4.0;
                    let volume: f64 = around.iter().map(volume).sum();
                    over_square(elastic(moduli.area * volume), scale)
                }
                SpringForm::Fitted { .. } => Coefficients::default(),
            };
            self.constraint(nodes, rest, coefficients)
        };
        shared(around, area)
    }

    /// One volume per element.
    pub(super) fn volumes(&self) -> Vec<Constraint<4>> {
        let volume = |&element: &u32| {
            let corners = self.mesh.corners(element as usize);
            let rest = self.volume(element);
            let mean = edges(&corners).map(|e| e.norm()).sum::<f64>() / 6.0;
            let regular = std::f64::consts::SQRT_2 / 12.0 * mean * mean * mean;
            let scale = scale(rest, regular);
            let scaled = |modulus: f64| over_square(elastic(modulus * rest.abs()), scale);
            let coefficients = match self.form {
                SpringForm::Plain(constants) => constants.volume,
                SpringForm::Normalised(constants) => over_square(constants.volume, scale),
                SpringForm::Scaled(moduli) => scaled(moduli.volume),
                SpringForm::Fitted { young, poisson } => scaled(fitted_moduli(*young, *poisson).1),
            };
            self.constraint(self.mesh.tets[element as usize], rest, coefficients)
        };
        self.elements.iter().map(volume).collect()
    }

    fn volume(&self, element: u32) -> f64 {
        let [a, b, c, d] = self.mesh.corners(element as usize);
        signed_volume(&a, &b, &c, &d)
    }

    fn constraint<const N: usize>(
        &self,
        nodes: [u32; N],
        rest: f64,
        coefficients: Coefficients,
    ) -> Constraint<N> {
        let Coefficients { stiffness, damping } = coefficients;
        Constraint {
            nodes,
            rest,
            stiffness,
            damping: damping + self.relaxation_time * stiffness,
        }
    }
}

/// Sets of nodes with their elements, ascending.
fn sorted<const N: usize>(parts: impl Iterator<Item = ([u32; N], u32)>) -> Vec<([u32; N], u32)> {
    let mut parts: Vec<_> = parts.collect();
    parts.sort_unstable();
    parts
}

/// Calls `make` once for each set of nodes, ascending, with all elements that have it.
fn shared<const N: usize>(
    parts: &[([u32; N], u32)],
    make: impl Fn([u32; N], &[([u32; N], u32)]) -> Constraint<N>,
) -> Vec<Constraint<N>> {
    let groups = parts.chunk_by(|a, b| a.0 == b.0);
    groups.map(|group| make(group[0].0, group)).collect()
}

/// q̃0 for the rest value q0 and the size of the regular element.
fn scale(rest: f64, regular: f64) -> f64 {
    if rest.abs() < FLAT * regular {
        regular
    } else {
        rest
    }
}

/// Coefficients without damping.
fn elastic(stiffness: f64) -> Coefficients {
    Coefficients {
        stiffness,
        damping: 0.0,
    }
}

/// The plain coefficients of normalised ones.
fn over_square(normalised: Coefficients, scale: f64) -> Coefficients {
    Coefficients {
        stiffness: normalised.stiffness / (scale * scale),
        damping: normalised.damping / (scale * scale),
    }
}
