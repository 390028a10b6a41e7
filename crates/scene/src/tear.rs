//! Tearing: tissue that is stretched too far comes apart.
//!
//! Stretches are those from the natural state: with the prestretch of an element where it has one, and with what has flowed. Tissue that was drawn
//! out for good bears as much less until it tears as it is longer already.
//!
//! Whole elements come apart at their faces. The stretch across a face is that of the fibre along its normal n in the natural state in the elements on both sides, |F n|: the root of the
//! mean square by volume, as energy grows with the square and is stored in volume, so that a small element does not open the face of a large one. A face fails when this exceeds
//! 1 + the strain that its region bears; between two regions the weaker one counts. Of the faces that do in one tick only those near the worst fail:
//! what is torn takes the load off the others.
//!
//! Shreds, elements far smaller than the others, as cuts leave them, rupture themselves, at their largest principal stretch, before what their few fibres store could pay for a
//! face of a whole element (Griffith 1921).

use crate::body::Body;
use crate::scene::Scene;
use microsim_cutting::{Fibre, Settings, Topology};
use microsim_tissue::law::decomposition::SignedSvd;
use nalgebra::{Matrix3, Vector3};
use std::collections::BTreeMap;

/// Faces with at least this fraction of the worst excess fail together.
const TOGETHER: f64 = 0.8;

/// An element with less than this fraction of the mean volume of the whole mesh is a shred.
const SHRED_VOLUME: f64 = 0.2;

/// By this fraction less than the limit nothing fails, however stretches are rounded.
const ROUNDING: f64 = 1e-12;

/// What came apart in a body, with the numbers of pieces that came off.
type Torn = Option<(microsim_cutting::Cut, Vec<u32>)>;

/// Shreds that rupture, each with the direction in which it is stretched most.
pub(crate) type Shreds = BTreeMap<u32, Fibre>;

impl Scene {
    /// Tears what is stretched too far in a body: its shreds, or where none is, faces.
    pub(crate) fn tear(&mut self, body: usize) -> Torn {
        let positions = &self.state.bodies[body].positions;
        let of = &self.bodies[body];
        let shreds = shreds(of, positions, Stretched::is_too_far);
        if !shreds.is_empty() {
            return self.come_apart(body, &[], &shreds);
        }
        let faces = overstretched(of, positions);
        self.come_apart(body, &faces, &Shreds::new())
    }

    /// The shreds of each body that are stretched too far or turned inside out, which no tissue can be; of the bodies that have any.
    pub(crate) fn failing_shreds(&self) -> Vec<(usize, Shreds)> {
        let of = |(body, of): (usize, &Body)| {
            let positions = &self.state.bodies[body].positions;
            let fails = |of: &Stretched| of.is_too_far() || of.inverted;
            (body, shreds(of, positions, fails))
        };
        let bodies = self.bodies.iter().enumerate().map(of);
        bodies.filter(|(_, shreds)| !shreds.is_empty()).collect()
    }

    /// Opens faces of a body and takes away shreds.
    pub(crate) fn come_apart(&mut self, body: usize, faces: &[(u32, u8)], shreds: &Shreds) -> Torn {
        let of = &mut self.bodies[body];
        let current = &self.state.bodies[body].positions;
        let topology = of.topology.as_mut()?;
        let torn = topology.tear(&of.mesh, faces, shreds, current, &Settings::default());
        let torn = torn.expect("inner faces of this mesh")?;
        self.update_strokes(body, None, &torn.edit);
        let pieces = self.apply_cut(body, &torn);
        Some((torn, pieces))
    }
}

/// How an element is stretched.
struct Stretched {
    /// Largest principal stretch, and what the element bears.
    stretch: f64,
    limit: f64,
    /// Its direction at rest and now.
    fibre: Fibre,
    /// Whether it is turned inside out.
    inverted: bool,
}

impl Stretched {
    /// `None` for an element without a limit, or without volume at rest, which no mesh has.
    fn new(body: &Body, positions: &[Vector3<f64>], element: u32) -> Option<Self> {
        let limit = 1.0 + limit_of(body, element)?;
        let gradient = deformation_gradient(body, positions, element)?;
        let svd = SignedSvd::new(&gradient);
        // No axis of an element without any extent, and of one that is not finite.
        let stretch = svd.stretches[0];
        if !(stretch > 0.0 && stretch.is_finite()) {
            return None;
        }
        let (along, now) = (svd.v.column(0).into_owned(), svd.u.column(0).into_owned());
        let at_rest = match body.mesh.prestretches.get(element as usize) {
            None => along,
            Some(prestretch) => (prestretch * along).normalize(),
        };
        Some(Self {
            stretch,
            limit,
            fibre: [at_rest, now],
            inverted: gradient.determinant() <= 0.0,
        })
    }

    fn is_too_far(&self) -> bool {
        self.stretch > self.limit
    }
}

/// The topology of a body of which something can tear.
fn of_what_can_tear(body: &Body) -> Option<&Topology> {
    let topology = body.topology.as_ref();
    topology.filter(|_| !body.tear_strains.is_empty())
}

/// The strain that an element bears, if it is limited.
fn limit_of(body: &Body, element: u32) -> Option<f64> {
    let region = body.mesh.regions[element as usize];
    let mut strains = body.tear_strains.iter();
    strains
        .find(|(of, _)| *of == region)
        .map(|(_, strain)| *strain)
}

/// The shreds of a body for which `fails` is true, but those that hang on nothing.
fn shreds(body: &Body, positions: &[Vector3<f64>], fails: impl Fn(&Stretched) -> bool) -> Shreds {
    let Some(topology) = of_what_can_tear(body) else {
        return Shreds::new();
    };
    let hangs = |element: &u32| (0..4).any(|k| topology.neighbour(*element, k).is_some());
    let elements = 0..body.mesh.tets.len() as u32;
    let shreds = elements.filter(|element| is_shred(body, topology, *element));
    let failing = shreds.filter(hangs).filter_map(|element| {
        let stretched = Stretched::new(body, positions, element)?;
        fails(&stretched).then_some((element, stretched.fibre))
    });
    failing.collect()
}

/// Whether an element is a shred: so small, and of tissue that can tear.
fn is_shred(body: &Body, topology: &Topology, element: u32) -> bool {
    rest_volume(body, element) < SHRED_VOLUME * topology.mean_volume()
        && limit_of(body, element).is_some()
}

/// Volume of an element at rest \[m³\].
fn rest_volume(body: &Body, element: u32) -> f64 {
    let [a, b, c, d] = body.mesh.corners(element as usize);
    microsim_geometry::signed_volume(&a, &b, &c, &d)
}

/// What a face takes of an element beside it.
struct Side {
    /// At rest \[m³\].
    volume: f64,
    /// The strain that it bears, if it is limited.
    limit: Option<f64>,
    is_shred: bool,
    /// From the natural state; `None` without volume at rest.
    gradient: Option<Matrix3<f64>>,
    /// Whether no fibre in it is stretched as far as anything in the body tears.
    holds: bool,
}

impl Side {
    /// `weakest` is the least strain that anything in the body bears.
    fn new(
        body: &Body,
        topology: &Topology,
        positions: &[Vector3<f64>],
        element: u32,
        weakest: f64,
    ) -> Self {
        let gradient = deformation_gradient(body, positions, element);
        Self {
            volume: rest_volume(body, element),
            limit: limit_of(body, element),
            is_shred: is_shred(body, topology, element),
            gradient,
            holds: gradient
                .is_none_or(|f| is_stretched_less(&f, (1.0 + weakest) * (1.0 - ROUNDING))),
        }
    }
}

/// Whether all principal stretches of F are below `limit`: all eigenvalues of limit² 1 − FᵀF are positive (Sylvester).
fn is_stretched_less(f: &Matrix3<f64>, limit: f64) -> bool {
    let left = Matrix3::from_diagonal_element(limit * limit) - f.tr_mul(f);
    let minor = left[(0, 0)] * left[(1, 1)] - left[(0, 1)] * left[(1, 0)];
    left[(0, 0)] > 0.0 && minor > 0.0 && left.determinant() > 0.0
}

/// The inner faces that fail: element and the corner opposite.
fn overstretched(body: &Body, positions: &[Vector3<f64>]) -> Vec<(u32, u8)> {
    let Some(topology) = of_what_can_tear(body) else {
        return Vec::new();
    };
    let strains = body.tear_strains.iter().map(|(_, strain)| *strain);
    let weakest = strains.fold(f64::INFINITY, f64::min);
    let elements = 0..body.mesh.tets.len() as u32;
    let side = |element| Side::new(body, topology, positions, element, weakest);
    let sides: Vec<Side> = elements.clone().map(side).collect();
    let mut found: Vec<(f64, u32, u8)> = Vec::new();
    for element in elements {
        let own = &sides[element as usize];
        if own.is_shred {
            continue;
        }
        for corner in 0..4 {
            let Some(other) = topology.neighbour(element, corner) else {
                continue;
            };
            // What has torn but holds together around it does not tear again.
            if topology.sheet(element, corner) != 0 {
                continue;
            }
            let beside = &sides[other as usize];
            if own.holds && beside.holds {
                continue;
            }
            let limit = [own.limit, beside.limit].into_iter().flatten();
            let first = element < other && !beside.is_shred;
            let (Some(limit), true) = (limit.reduce(f64::min), first) else {
                continue;
            };
            let normal = normal(topology, &body.mesh.positions, element, corner);
            let [one, two] = [(element, own), (other, beside)].map(|(element, side)| {
                let stretch = stretch(body, side, element, &normal);
                side.volume * (stretch * stretch)
            });
            let (volume, sum) = (own.volume + beside.volume, one + two);
            let excess = (sum / volume).sqrt() - 1.0 - limit;
            if excess > 0.0 {
                found.push((excess, element, corner as u8));
            }
        }
    }
    let worst = found
        .iter()
        .fold(0.0, |worst, (excess, _, _)| f64::max(worst, *excess));
    let near = found
        .iter()
        .filter(|(excess, _, _)| *excess >= TOGETHER * worst);
    near.map(|(_, element, corner)| (*element, *corner))
        .collect()
}

/// Normal at rest of the face opposite to a corner.
fn normal(topology: &Topology, rest: &[Vector3<f64>], element: u32, corner: usize) -> Vector3<f64> {
    let [a, b, c] = topology
        .face(element, corner)
        .map(|node| rest[node as usize]);
    (b - a).cross(&(c - a)).normalize()
}

/// The stretch of an element's fibre that is along the normal of a face in the natural state, 1 there; `normal` is that of the mesh.
fn stretch(body: &Body, side: &Side, element: u32, normal: &Vector3<f64>) -> f64 {
    let natural = match body.mesh.prestretches.get(element as usize) {
        None => *normal,
        Some(prestretch) => prestretch.tr_mul(normal).normalize(),
    };
    let gradient = side.gradient;
    gradient.map_or(1.0, |gradient| (gradient * natural).norm())
}

/// From the natural state; `None` for an element without volume at rest, which no mesh has.
fn deformation_gradient(
    body: &Body,
    positions: &[Vector3<f64>],
    element: u32,
) -> Option<Matrix3<f64>> {
    let edges = |[a, b, c, d]: [Vector3<f64>; 4]| Matrix3::from_columns(&[b - a, c - a, d - a]);
    let now = edges(body.mesh.tets[element as usize].map(|node| positions[node as usize]));
    let rest = edges(body.mesh.corners(element as usize)).try_inverse()?;
    Some(match body.mesh.prestretches.get(element as usize) {
        None => now * rest,
        Some(prestretch) => now * rest * prestretch,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use microsim_random::SplitMix64;

    /// By the singular values, which are found otherwise; what is not finite is never stretched less.
    #[test]
    fn stretched_less_is_what_singular_values_are() {
        let mut random = SplitMix64(3);
        let mut found = [0; 2];
        for _ in 0..2000 {
            let f = Matrix3::from_columns(&[0; 3].map(|_| random.vector()));
            let largest = SignedSvd::new(&f).stretches[0];
            let limit = 1.0 + 0.8 * random.number();
            let is_less = is_stretched_less(&f, limit);
            assert_eq!(is_less, largest < limit, "{largest} {limit} {f}");
            found[usize::from(is_less)] += 1;
        }
        assert!(found.iter().all(|count| *count > 200), "{found:?}");
        for broken in [f64::NAN, f64::INFINITY] {
            let f = Matrix3::from_diagonal(&Vector3::new(1.0, broken, 1.0));
            assert!(!is_stretched_less(&f, 2.0));
        }
    }
}
