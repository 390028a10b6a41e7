//! Bodies of instruments: a skin over rounded sections.

use nalgebra::Vector3;
use std::f64::consts::TAU;

use crate::mesh::Mesh;

/// Corners of a section.
const AROUND: usize = 20;

/// A section across z: a superellipse, |x/width|ᵉ + |y/height|ᵉ = 1.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Section {
    /// Its place along z \[m\].
    pub z: f64,
    /// Of its middle \[m\].
    pub middle: [f64; 2],
    /// Half its size along x and y \[m\].
    pub half: [f64; 2],
    /// e: 2 is an ellipse, 4 and more a rounded rectangle.
    pub exponent: f64,
}

/// Section at z, middle x, half width and height, all \[mm\].
pub(crate) fn section(z: f64, x: f64, width: f64, height: f64, exponent: f64) -> Section {
    Section {
        z: 1e-3 * z,
        middle: [1e-3 * x, 0.0],
        half: [1e-3 * width, 1e-3 * height],
        exponent,
    }
}

impl Section {
    /// The same with its middle at y \[mm\].
    pub fn at_y(self, y: f64) -> Self {
        let middle = [self.middle[0], 1e-3 * y];
        Self { middle, ..self }
    }

    /// Its mirror image across x = 0.
    pub fn mirrored(self) -> Self {
        let middle = [-self.middle[0], self.middle[1]];
        Self { middle, ..self }
    }

    fn point(&self, corner: usize) -> Vector3<f64> {
        let angle = TAU * corner as f64 / AROUND as f64;
        let round = |value: f64| value.signum() * libm::pow(value.abs(), 2.0 / self.exponent);
        let x = self.middle[0] + self.half[0] * round(libm::cos(angle));
        let y = self.middle[1] + self.half[1] * round(libm::sin(angle));
        Vector3::new(x, y, self.z)
    }
}

/// The skin over sections in the order of rising z, with flat ends.
pub(crate) fn loft(mesh: &mut Mesh, sections: &[Section]) {
    let points: Vec<Vec<Vector3<f64>>> = sections
        .iter()
        .map(|section| (0..AROUND).map(|corner| section.point(corner)).collect())
        .collect();
    let first = mesh.vertices.len() as u32;
    let last = sections.len() - 1;
    for (row, ring) in points.iter().enumerate() {
        for corner in 0..AROUND {
            let around = ring[(corner + 1) % AROUND] - ring[(corner + AROUND - 1) % AROUND];
            let (above, below) = ((row + 1).min(last), row.saturating_sub(1));
            let along = points[above][corner] - points[below][corner];
            let normal = around.cross(&along).try_normalize(0.0);
            mesh.push(ring[corner], normal.unwrap_or_else(Vector3::x));
        }
    }
    let count = AROUND as u32;
    for row in 0..last as u32 {
        for corner in 0..count {
            let next = (corner + 1) % count;
            let [a, b] = [corner, next].map(|corner| first + row * count + corner);
            let (c, d) = (a + count, b + count);
            mesh.indices.extend([a, b, c, b, d, c]);
        }
    }
    for (ring, side) in [(&points[0], -1.0), (&points[last], 1.0)] {
        let normal = Vector3::new(0.0, 0.0, side);
        let corners: Vec<u32> = ring.iter().map(|point| mesh.push(*point, normal)).collect();
        for k in 1..AROUND - 1 {
            let fan = match side > 0.0 {
                true => [corners[0], corners[k], corners[k + 1]],
                false => [corners[0], corners[k + 1], corners[k]],
            };
            mesh.indices.extend(fan);
        }
    }
}

/// A round pin along y about a place \[mm\], with a bevel.
pub(crate) fn pin(mesh: &mut Mesh, z: f64, radius: f64, half_length: f64) {
    let mut upright = Mesh::default();
    let bevel = 0.3 * radius;
    let sections = [
        (-half_length, radius - bevel),
        (bevel - half_length, radius),
        (half_length - bevel, radius),
        (half_length, radius - bevel),
    ];
    loft(
        &mut upright,
        &sections.map(|(along, radius)| section(along, 0.0, radius, radius, 2.0)),
    );
    let base = mesh.vertices.len() as u32;
    for vertex in &upright.vertices {
        // A turn about x: z becomes y, y becomes −z.
        let turned = |v: [f32; 3]| Vector3::new(v[0], v[2], -v[1]).map(f64::from);
        let place = turned(vertex.position) + Vector3::new(0.0, 0.0, 1e-3 * z);
        mesh.push(place, turned(vertex.normal));
    }
    let indices = upright.indices.iter().map(|index| base + index);
    mesh.indices.extend(indices);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn volume(mesh: &Mesh) -> f64 {
        let point =
            |index: u32| Vector3::from(mesh.vertices[index as usize].position.map(f64::from));
        let of_triangle = |t: &[u32]| point(t[0]).dot(&point(t[1]).cross(&point(t[2]))) / 6.0;
        mesh.indices.chunks_exact(3).map(of_triangle).sum()
    }

    /// A loft between two ellipses is a cylinder, closed and seen anticlockwise from outside: its volume is π a b l, less the 1.6 % that a polygon of 20 corners lacks
    /// (1 − sin(2π/20)/(2π/20)). A pin along y is the same less its bevels, and lies about its place.
    #[test]
    fn skins_are_closed() {
        let mut mesh = Mesh::default();
        loft(
            &mut mesh,
            &[0.0, 5.0].map(|z| section(z, 0.3, 1.0, 2.0, 2.0)),
        );
        let relative = volume(&mesh) / (std::f64::consts::PI * 10e-9) - 1.0;
        assert!((-0.017..-0.016).contains(&relative), "{relative}");
        let mut mesh = Mesh::default();
        pin(&mut mesh, 8.0, 0.5, 1.0);
        let full = std::f64::consts::PI * 0.25 * 2.0 * 1e-9;
        let relative = volume(&mesh) / full;
        assert!((0.85..0.97).contains(&relative), "{relative}");
        let inside = mesh
            .vertices
            .iter()
            .all(|v| v.position[1].abs() <= 1.0001e-3 && (v.position[2] - 8e-3).abs() < 0.51e-3);
        assert!(inside);
    }
}
