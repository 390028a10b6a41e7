//! The lumen of a vessel: whether a point is in it, and how pressure falls along it from there.
//!
//! The inner surface of the wall is divided into sections along the axis at rest. Fluid that is held at a pressure at one place flows
//! slowly to the ends of the lumen and to where a cut has opened the wall, and leaves there without pressure. In each section the
//! pressure falls by the law of Hagen and Poiseuille for the area A that it has now, dp/dx ∝ 1/A²: up to where a clamp or an
//! instrument presses the walls together the lumen has the whole pressure, behind it none; an empty vein opens from where the fluid comes.
//! What is not here: fluid that flows with inertia, or is sucked; where the pressure comes from (`irrigation`).

use crate::edits::nodes_after_edit;
use crate::spec::LumenSpec;
use microsim_mesh::{Surface, TetMesh, TopologyEdit};
use nalgebra::{Unit, Vector3};
use std::f64::consts::PI;

/// Pressed flat, a section has this fraction of its area at rest: what fluid still finds between two walls that touch at nodes. Closed it
/// has a million times the resistance of one at rest.
const FLAT: f64 = 1e-3;

/// The lumen of a body.
#[derive(Clone, Debug)]
pub(crate) struct Lumen {
    axis: Unit<Vector3<f64>>,
    /// Coordinate along the axis at rest of its beginning, and the length of a section \[m\].
    start: f64,
    length: f64,
    /// Its nodes, ascending.
    nodes: Vec<u32>,
    triangles: Vec<LumenTriangle>,
    /// Area of each section at rest \[m²\].
    areas: Vec<f64>,
    /// Whether a cut has opened the wall there, or taken it away.
    open: Vec<bool>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LumenTriangle {
    /// Outward of the wall: into the lumen.
    pub nodes: [u32; 3],
    pub section: u32,
}

/// A section of a lumen in the shape that it has now.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Section {
    /// Centre of its wall \[m\].
    centre: Vector3<f64>,
    /// Area of its wall \[m²\].
    wall: f64,
    /// Area of its cross-section \[m²\].
    area: f64,
    /// Along the lumen \[m\].
    length: f64,
    /// What the pressure falls by in it, up to a common factor \[1/m³\].
    resistance: f64,
    /// \[Pa\]
    pub pressure: f64,
}

impl Lumen {
    /// The lumen of a mesh at rest.
    pub fn new(spec: &LumenSpec, mesh: &TetMesh) -> Option<Self> {
        let axis = Unit::try_new(Vector3::from(spec.axis), 0.0)?;
        let nodes = Surface::new(spec.triangles.clone()).nodes;
        let along = nodes
            .iter()
            .map(|&node| axis.dot(&mesh.positions[node as usize]));
        let (start, end) = along.fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), s| {
            (least.min(s), most.max(s))
        });
        let sections = spec.sections as usize;
        if nodes.is_empty() || sections == 0 || end <= start {
            return None;
        }
        let mut lumen = Self {
            axis,
            start,
            length: (end - start) / f64::from(spec.sections),
            nodes,
            triangles: Vec::new(),
            areas: vec![0.0; sections],
            open: vec![false; sections],
        };
        lumen.update(mesh, &spec.triangles, &[]);
        let mut work = Vec::new();
        lumen.measure(&mesh.positions, &mut work);
        lumen.areas = work.iter().map(|section| section.area).collect();
        Some(lumen)
    }

    /// Updates the nodes after an edit of a mesh of so many nodes.
    pub fn update_after_edit(&mut self, edit: &TopologyEdit, old: usize) {
        self.nodes = nodes_after_edit(self.nodes.iter().copied(), edit, old);
    }

    /// Takes its triangles from those on the outside of the body; `opened` are the nodes of those that a cut has opened, ascending.
    pub fn update(&mut self, mesh: &TetMesh, outside: &[[u32; 3]], opened: &[u32]) {
        let has = |list: &[u32], node: &u32| list.binary_search(node).is_ok();
        let last = self.areas.len() - 1;
        self.triangles.clear();
        let mut walls = vec![false; self.areas.len()];
        self.open.fill(false);
        for nodes in outside {
            if !nodes.iter().all(|node| has(&self.nodes, node)) {
                continue;
            }
            let sum: Vector3<f64> = nodes.iter().map(|&n| mesh.positions[n as usize]).sum();
            let along = (self.axis.dot(&sum) / 3.0 - self.start) / self.length;
            // The cast saturates.
            let section = (along as usize).min(last);
            walls[section] = true;
            self.open[section] |= nodes.iter().any(|node| has(opened, node));
            self.triangles.push(LumenTriangle {
                nodes: *nodes,
                section: section as u32,
            });
        }
        for (open, wall) in self.open.iter_mut().zip(walls) {
            *open |= !wall;
        }
    }

    /// Its nodes, ascending.
    pub fn nodes(&self) -> &[u32] {
        &self.nodes
    }

    /// Its triangles.
    pub fn triangles(&self) -> &[LumenTriangle] {
        &self.triangles
    }

    /// Whether its wall surrounds a point: seen from there, it fills more than half of all directions (solid angles of triangles:
    /// van Oosterom and Strackee 1983). In the plane of an open end it fills just half.
    pub fn holds(&self, point: &Vector3<f64>, positions: &[Vector3<f64>]) -> bool {
        let angles = self.triangles.iter().map(|triangle| {
            let [a, b, c] = triangle.nodes.map(|node| positions[node as usize] - point);
            let [x, y, z] = [a.norm(), b.norm(), c.norm()];
            let volume = a.dot(&b.cross(&c));
            let rest = x * y * z + a.dot(&b) * z + a.dot(&c) * y + b.dot(&c) * x;
            2.0 * libm::atan2(volume, rest)
        });
        angles.sum::<f64>().abs() > 2.0 * PI
    }

    /// The pressure in each section where it is `pressure` \[Pa\] at `point` \[m\], which it holds.
    pub fn pressures(
        &self,
        point: &Vector3<f64>,
        pressure: f64,
        positions: &[Vector3<f64>],
        sections: &mut Vec<Section>,
    ) {
        self.measure(positions, sections);
        let rest = self.areas.iter().zip(&self.open);
        for (section, (rest, open)) in sections.iter_mut().zip(rest) {
            // What has no closed wall has no cross-section to measure.
            let area = match open {
                true => *rest,
                false => section.area.max(FLAT * rest),
            };
            section.resistance = section.length / (area * area);
        }
        let distance = |section: &Section| (section.centre - point).norm_squared();
        let nearest = |best: usize, next: usize| match distance(&sections[next])
            < distance(&sections[best])
        {
            true => next,
            false => best,
        };
        let walled = (0..sections.len()).filter(|&index| sections[index].wall > 0.0);
        let Some(source) = walled.reduce(nearest) else {
            return;
        };
        sections[source].pressure = pressure;
        self.fall(source, source + 1..sections.len(), sections);
        self.fall(source, (0..source).rev(), sections);
    }

    /// Lets the pressure fall from the section `source` over others, up to where the first that is open begins: there the fluid leaves.
    fn fall(
        &self,
        source: usize,
        others: impl Iterator<Item = usize> + Clone,
        sections: &mut [Section],
    ) {
        let pressure = sections[source].pressure;
        let closed = others.take_while(|&section| !self.open[section]);
        let mut passed = 0.5 * sections[source].resistance;
        let resistances = closed.clone().map(|section| sections[section].resistance);
        let whole = resistances.fold(passed, |sum, resistance| sum + resistance);
        for section in closed {
            let half = 0.5 * sections[section].resistance;
            passed += half;
            sections[section].pressure = pressure * (1.0 - passed / whole).max(0.0);
            passed += half;
        }
    }

    /// Measures the sections in this shape. The volume of a section is that between its wall and the planes across the axis at its
    /// ends: ½ ∮ r·dS with r across the axis, whose divergence is 2, and to which the planes add nothing.
    fn measure(&self, positions: &[Vector3<f64>], sections: &mut Vec<Section>) {
        sections.clear();
        sections.resize(self.areas.len(), Section::default());
        let middle_and_area = |triangle: &LumenTriangle| {
            let [a, b, c] = triangle.nodes.map(|node| positions[node as usize]);
            ((a + b + c) / 3.0, (b - a).cross(&(c - a)) * 0.5)
        };
        for triangle in &self.triangles {
            let (middle, area) = middle_and_area(triangle);
            let section = &mut sections[triangle.section as usize];
            let area = area.norm();
            section.centre += middle * area;
            section.wall += area;
        }
        let mut before = Vector3::zeros();
        for section in sections.iter_mut() {
            if section.wall > 0.0 {
                section.centre /= section.wall;
                before = section.centre;
            } else {
                section.centre = before;
            }
        }
        for triangle in &self.triangles {
            let (middle, area) = middle_and_area(triangle);
            let index = triangle.section as usize;
            let (axis, _) = self.along(index, sections);
            let section = &mut sections[index];
            let from = middle - section.centre;
            let across = from - axis * axis.dot(&from);
            section.area -= 0.5 * across.dot(&area);
        }
        for index in 0..sections.len() {
            let (_, length) = self.along(index, sections);
            let section = &mut sections[index];
            section.length = length;
            section.area = (section.area / length).max(0.0);
        }
    }

    /// Direction and length of a section, from the centres of those beside it. A section that is open has those at rest, and nothing is measured
    /// across it: there its ends may be far apart.
    fn along(&self, index: usize, sections: &[Section]) -> (Vector3<f64>, f64) {
        if self.open[index] {
            return (self.axis.into_inner(), self.length);
        }
        let (before, after) = (index.saturating_sub(1), (index + 1).min(sections.len() - 1));
        let first = if self.open[before] { index } else { before };
        let last = if self.open[after] { index } else { after };
        let apart = sections[last].centre - sections[first].centre;
        let length = apart.norm() / (last - first).max(1) as f64;
        match length > 0.0 {
            true => (apart.normalize(), length),
            // The only one, or between two that are open.
            false => (self.axis.into_inner(), self.length),
        }
    }
}

#[cfg(test)]
mod tests;
