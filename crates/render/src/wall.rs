//! What a body's surface is of: layers of a vessel's wall, found from the shape of the body at rest and the regions behind its triangles, and where each node lies
//! in the body at rest.
//!
//! A body whose surface faces its own long axis somewhere is a tube: what does so is the lumen, the region behind it is the media, the region behind what faces
//! outwards the adventitia; another region, or the adventitia where it was opened, is loose tissue, of which what stays on the media is too thin to hide it. Where no regions are known, or there is only one, all that was opened
//! is media.
//!
//! Nodes that a cut has made have no place at rest of their own unless it is published: they get the mean of those of their neighbours on the
//! surface, each moved by where the node lies from the neighbour at the moment at which it appears, the nearer ones weighing more.

use nalgebra::{Matrix3, SymmetricEigen, Vector3};

use crate::tissue::Tissue;

/// What a triangle is of. The numbers are those of the shader.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub(crate) enum Layer {
    /// Tissue that is no vessel.
    Tissue = 0,
    /// Outer surface of a vessel.
    Adventitia = 1,
    /// Muscle of a vessel's wall, laid open.
    Media = 2,
    /// Inner surface of a vessel.
    Lumen = 3,
    /// Cut surface of tissue that is no vessel.
    Flesh = 4,
    /// Loose tissue, laid open.
    Loose = 5,
    /// Outer surface of a vein.
    Vein = 6,
}

/// A tube has at least this part of the area along its axis facing inwards: of radii r and R it is r/(r + R).
const INWARDS: f32 = 0.15;

/// A body at rest.
#[derive(Clone, Debug, Default)]
pub(crate) struct Wall {
    /// By id of a node.
    rest: Vec<Option<[f32; 3]>>,
    centre: Vector3<f32>,
    /// Rows: the axis, and two directions across it.
    frame: Matrix3<f32>,
    is_tube: bool,
    /// Regions that face outwards and inwards.
    outer: u32,
    inner: u32,
}

impl Wall {
    /// Of a body that is seen for the first time.
    pub fn new(tissue: &Tissue) -> Self {
        let mut wall = Self::default();
        wall.place(tissue);
        let places = wall.places(tissue);
        wall.look(tissue, &places);
        wall
    }

    /// Whether a body that was seen before is still the same one: nodes that both have lie at the same places at rest.
    pub fn is_of(&self, tissue: &Tissue) -> bool {
        let known = |id: u32| self.rest.get(id as usize).copied().flatten();
        let same = |(&id, place): (&u32, &[f32; 3])| {
            known(id).is_none_or(|rest| {
                let off = Vector3::from(rest) - Vector3::from(*place);
                // Bits differ where one was rounded; a micrometre is far below any mesh.
                off.amax() < 1e-6
            })
        };
        match tissue.rest.is_empty() {
            true => tissue.original_ids.iter().zip(&tissue.original).all(same),
            false => tissue.node_ids.iter().zip(&tissue.rest).all(same),
        }
    }

    /// Takes up nodes that are new.
    pub fn place(&mut self, tissue: &Tissue) {
        let last = tissue.node_ids.iter().chain(&tissue.original_ids).max();
        let size = last.map_or(0, |last| *last as usize + 1);
        self.rest.resize(self.rest.len().max(size), None);
        let given = match tissue.rest.is_empty() {
            true => tissue.original_ids.iter().zip(&tissue.original),
            false => tissue.node_ids.iter().zip(&tissue.rest),
        };
        for (&id, place) in given {
            self.rest[id as usize].get_or_insert(*place);
        }
        if self.rest.iter().all(Option::is_none) {
            // Nothing is known: as it lies now.
            for (&id, place) in tissue.node_ids.iter().zip(&tissue.positions) {
                self.rest[id as usize] = Some(*place);
            }
        }
        self.place_new(tissue);
    }

    /// Nodes that are nowhere yet, from their neighbours, until none is left that has one.
    fn place_new(&mut self, tissue: &Tissue) {
        let ids = &tissue.node_ids;
        loop {
            let mut sums: Vec<(u32, Vector3<f32>, f32)> = Vec::new();
            let missing = |node: u32| {
                let id = *ids.get(node as usize)?;
                self.rest[id as usize].is_none().then_some(id)
            };
            for triangle in &tissue.triangles {
                for corner in 0..3 {
                    let Some(id) = missing(triangle[corner]) else {
                        continue;
                    };
                    for other in [triangle[(corner + 1) % 3], triangle[(corner + 2) % 3]] {
                        let Some(rest) = self.rest[ids[other as usize] as usize] else {
                            continue;
                        };
                        let [here, there] = [triangle[corner], other]
                            .map(|node| Vector3::from(tissue.positions[node as usize]));
                        let off = here - there;
                        let weight = 1.0 / (off.norm() + 1e-9);
                        sums.push((id, (Vector3::from(rest) + off) * weight, weight));
                    }
                }
            }
            if sums.is_empty() {
                return;
            }
            sums.sort_by_key(|(id, _, _)| *id);
            for group in sums.chunk_by(|a, b| a.0 == b.0) {
                let place: Vector3<f32> = group.iter().map(|(_, place, _)| *place).sum();
                let weight: f32 = group.iter().map(|(_, _, weight)| weight).sum();
                self.rest[group[0].0 as usize] = Some((place / weight).into());
            }
        }
    }

    /// Where the nodes lie at rest \[m\]; one that no neighbour leads to, where it is.
    pub fn places(&self, tissue: &Tissue) -> Vec<Vector3<f32>> {
        let known = |node: usize| {
            let id = *tissue.node_ids.get(node)?;
            self.rest.get(id as usize).copied().flatten()
        };
        let nodes = tissue.positions.iter().enumerate();
        nodes
            .map(|(node, place)| known(node).unwrap_or(*place).into())
            .collect()
    }

    /// Axis, and which regions face where.
    fn look(&mut self, tissue: &Tissue, places: &[Vector3<f32>]) {
        let count = places.len().max(1) as f32;
        self.centre = places.iter().sum::<Vector3<f32>>() / count;
        let spread: Matrix3<f32> = places
            .iter()
            .map(|p| (p - self.centre) * (p - self.centre).transpose())
            .sum();
        // In mm², lest small numbers end the iteration at once.
        let eigen = SymmetricEigen::new(spread * (1e6 / count));
        let mut order = [0, 1, 2];
        order.sort_by(|a, b| eigen.eigenvalues[*b].total_cmp(&eigen.eigenvalues[*a]));
        let axis: Vector3<f32> = eigen.eigenvectors.column(order[0]).into();
        let axis = axis * axis[axis.iamax()].signum();
        let across: Vector3<f32> = eigen.eigenvectors.column(order[1]).into();
        self.frame = Matrix3::from_rows(&[
            axis.transpose(),
            across.transpose(),
            axis.cross(&across).transpose(),
        ]);
        let (mut side, mut inwards) = (0.0, 0.0);
        let mut areas: [Vec<(u32, f32)>; 2] = Default::default();
        for (index, triangle) in tissue.triangles.iter().enumerate() {
            if tissue.inner.get(index) == Some(&true) {
                continue;
            }
            let (normal, outwards) = self.facing(triangle, places);
            let area = normal.norm();
            if normal.dot(&axis).abs() > 0.3 * area {
                continue;
            }
            side += area;
            if !outwards {
                inwards += area;
            }
            let region = tissue.regions.get(index).copied().unwrap_or_default();
            areas[usize::from(outwards)].push((region, area));
        }
        self.is_tube = inwards > INWARDS * side;
        // The region with most of the area.
        let largest = |areas: &[(u32, f32)]| {
            let regions = areas.iter().map(|(region, _)| *region);
            let area = |region: u32| -> f32 {
                let of_region = areas.iter().filter(|(r, _)| *r == region);
                of_region.map(|(_, area)| area).sum()
            };
            let mut best = (0, -1.0);
            let mut seen: Vec<u32> = regions.collect();
            seen.sort_unstable();
            seen.dedup();
            for region in seen {
                if area(region) > best.1 {
                    best = (region, area(region));
                }
            }
            best.0
        };
        (self.inner, self.outer) = (largest(&areas[0]), largest(&areas[1]));
    }

    /// Normal of a triangle at rest, twice its area long, and whether it faces away from the axis.
    fn facing(&self, triangle: &[u32; 3], places: &[Vector3<f32>]) -> (Vector3<f32>, bool) {
        let [a, b, c] = triangle.map(|node| places[node as usize]);
        let normal = (b - a).cross(&(c - a));
        let axis: Vector3<f32> = self.frame.row(0).transpose();
        let off = (a + b + c) / 3.0 - self.centre;
        let radial = off - axis * off.dot(&axis);
        (normal, normal.dot(&radial) >= 0.0)
    }

    /// What each triangle is of, by its place at rest.
    pub fn layers(&self, tissue: &Tissue, places: &[Vector3<f32>]) -> Vec<u8> {
        let axis: Vector3<f32> = self.frame.row(0).transpose();
        let layered = !tissue.regions.is_empty() && self.inner != self.outer;
        let triangles = tissue.triangles.iter().enumerate();
        let layer = |(index, triangle): (usize, &[u32; 3])| {
            let opened = tissue.inner.get(index) == Some(&true);
            if !self.is_tube {
                return if opened { Layer::Flesh } else { Layer::Tissue };
            }
            let region = tissue.regions.get(index).copied();
            let of_region = match region {
                Some(region) if layered && region == self.outer => Layer::Loose,
                Some(region) if layered && region != self.inner => Layer::Loose,
                _ => Layer::Media,
            };
            let (normal, outwards) = self.facing(triangle, places);
            let end = normal.dot(&axis).abs() > 0.7 * normal.norm();
            let is_between = layered && region != Some(self.inner) && region != Some(self.outer);
            match (opened || end, outwards) {
                // Where the adventitia came off: what is left of the loose tissue is thin, and the media shows through it.
                (true, true) if is_between && !end => Layer::Media,
                (true, _) => of_region,
                (false, false) => Layer::Lumen,
                (false, true) if tissue.vein => Layer::Vein,
                // Where the wall was stripped from the start, its outer surface is the media's.
                (false, true) if layered && region != Some(self.outer) => of_region,
                (false, true) => Layer::Adventitia,
            }
        };
        triangles.map(|triangle| layer(triangle) as u8).collect()
    }

    /// Places at rest in the frame of the body: along its axis, and across it \[mm\].
    pub fn in_frame(&self, places: &[Vector3<f32>]) -> Vec<[f32; 3]> {
        let place = |p: &Vector3<f32>| (self.frame * (p - self.centre) * 1e3).into();
        places.iter().map(place).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two rings of 16 nodes each at radii 1 and 0.6, from x = 0 to 4: a tube with a media, 0, and an adventitia, 1, as its two sides.
    fn tube() -> Tissue {
        let mut tissue = Tissue {
            colour: [0.8, 0.5, 0.5],
            ..Tissue::default()
        };
        for x in [0.0, 4.0] {
            for radius in [1.0, 0.6] {
                for k in 0..16 {
                    let angle = std::f32::consts::TAU * k as f32 / 16.0;
                    tissue
                        .positions
                        .push([x, radius * angle.cos(), radius * angle.sin()]);
                }
            }
        }
        tissue.node_ids = (0..64).collect();
        for k in 0..16_u32 {
            let next = (k + 1) % 16;
            for (base, region) in [(0, 1), (16, 0)] {
                let [a, b, c, d] = [k, next, 32 + k, 32 + next].map(|n| n + base);
                let quad = match region {
                    1 => [[a, b, d], [a, d, c]],
                    _ => [[a, d, b], [a, c, d]],
                };
                tissue.triangles.extend(quad);
                tissue.regions.extend([region, region]);
                tissue.inner.extend([false, false]);
            }
        }
        tissue
    }

    /// What faces outwards is adventitia, what faces the axis lumen; opened, the region decides: media, or loose tissue.
    #[test]
    fn layers_of_a_tube() {
        let mut tissue = tube();
        let wall = Wall::new(&tissue);
        let places = wall.places(&tissue);
        let layers = wall.layers(&tissue, &places);
        assert_eq!(layers[..2], [Layer::Adventitia as u8; 2]);
        assert_eq!(layers[2..4], [Layer::Lumen as u8; 2]);
        tissue.inner = vec![true; tissue.triangles.len()];
        let opened = wall.layers(&tissue, &places);
        assert_eq!(opened[..2], [Layer::Loose as u8; 2]);
        assert_eq!(opened[2..4], [Layer::Media as u8; 2]);
        // Loose tissue between both: on the media it shows that, from below the adventitia itself.
        tissue.regions.extend([2, 2]);
        tissue.inner.extend([true, true]);
        let outwards = tissue.triangles[0];
        let mut inwards = outwards;
        inwards.swap(0, 1);
        tissue.triangles.extend([outwards, inwards]);
        let bared = wall.layers(&tissue, &places);
        let last = bared.len() - 2;
        assert_eq!(bared[last..], [Layer::Media as u8, Layer::Loose as u8]);
        tissue.vein = true;
        tissue.inner.clear();
        assert_eq!(wall.layers(&tissue, &places)[0], Layer::Vein as u8);
    }

    /// A ball has no side that faces its axis: tissue, and where it was opened flesh.
    #[test]
    fn what_has_no_lumen_is_no_vessel() {
        let mut tissue = tube();
        tissue.triangles.truncate(2);
        tissue.inner = vec![false, true];
        tissue.regions.clear();
        let wall = Wall::new(&tissue);
        let layers = wall.layers(&tissue, &wall.places(&tissue));
        assert_eq!(layers, [Layer::Tissue as u8, Layer::Flesh as u8]);
    }

    /// A node that appears in the middle of an edge of a body that has moved and not turned is in the middle of the edge at rest; a body with other places
    /// at rest is another one.
    #[test]
    fn new_nodes_lie_between_their_neighbours() {
        let mut tissue = Tissue {
            node_ids: vec![0, 1, 2],
            positions: vec![[5.0, 0.0, 0.0], [7.0, 0.0, 0.0], [5.0, 2.0, 0.0]],
            original_ids: vec![0, 1, 2],
            original: vec![[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]],
            triangles: vec![[0, 1, 2]],
            ..Tissue::default()
        };
        let mut wall = Wall::new(&tissue);
        assert!(wall.is_of(&tissue));
        tissue.node_ids = vec![0, 1, 2, 7];
        tissue.positions.push([6.0, 0.0, 0.0]);
        tissue.triangles = vec![[0, 3, 2], [3, 1, 2]];
        wall.place(&tissue);
        let found = wall.places(&tissue)[3];
        assert!(
            (found - Vector3::new(1.0, 0.0, 0.0)).norm() < 1e-5,
            "{found}"
        );
        tissue.original[1] = [3.0, 0.0, 0.0];
        assert!(!wall.is_of(&tissue));
    }
}
