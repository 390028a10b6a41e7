//! From one shape to its triangles, in the frame of its item.
//!
//! Everything round is a surface of revolution, made by one function from a profile; the number of steps follows the size on
//! the screen.

use nalgebra::{Matrix3, Vector3};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

use crate::colour_map::coordinates;
use crate::mesh::Mesh;
use crate::shape::Shape;

/// A chord may leave the circle that it stands for by this much \[pixels\]: a quarter is below what the eye sees.
const CHORD_ERROR: f64 = 0.25;

/// Point of a profile: distance from the axis, place on the axis, and the normal in these two directions.
#[derive(Clone, Copy)]
struct ProfilePoint {
    rho: f64,
    z: f64,
    normal: [f64; 2],
}

/// Triangulates a shape (checked before) of which a metre takes this many pixels.
pub(crate) fn triangulate(shape: &Shape, pixels: f64) -> Mesh {
    let mut mesh = Mesh::default();
    Tessellator::new(pixels, &mut mesh).shape(shape);
    mesh
}

/// Makes the triangles of one shape.
struct Tessellator<'a> {
    /// Pixels per metre in the plane of focus.
    pixels: f64,
    out: &'a mut Mesh,
}

impl<'a> Tessellator<'a> {
    pub fn new(pixels: f64, out: &'a mut Mesh) -> Self {
        Self { pixels, out }
    }

    /// Adds the triangles of `shape`.
    pub fn shape(&mut self, shape: &Shape) {
        match shape {
            Shape::Sphere { radius } => {
                self.taper(Vector3::zeros(), Vector3::zeros(), *radius, *radius)
            }
            Shape::Capsule { a, b, radius } => {
                self.taper((*a).into(), (*b).into(), *radius, *radius)
            }
            Shape::Taper {
                a,
                b,
                radius_a,
                radius_b,
            } => self.taper((*a).into(), (*b).into(), *radius_a, *radius_b),
            Shape::Box { half } => self.cuboid(half),
            Shape::RoundedBox { half, radius } => self.rounded_box(half, *radius),
            Shape::Model(model) => self.out.clone_from(model.mesh()),
            Shape::Cylinder { radius, height } => {
                self.along_z(&cone_profile(*radius, *radius, 0.0, *height))
            }
            Shape::Cone { radius, height } => {
                self.along_z(&cone_profile(*radius, 0.0, 0.0, *height))
            }
            Shape::Arrow { radius, length } => {
                let neck = length * 2.0 / 3.0;
                self.along_z(&cone_profile(*radius, *radius, 0.0, neck));
                self.along_z(&cone_profile(3.0 * radius, 0.0, neck, *length));
            }
            Shape::Ring {
                radius,
                tube,
                fraction,
            } => self.ring(*radius, *tube, *fraction),
            Shape::Mesh {
                positions,
                triangles,
            } => self.mesh(positions, triangles),
            Shape::Field {
                positions,
                triangles,
                values,
            } => {
                let first = self.out.details.len();
                self.mesh(positions, triangles);
                for (detail, value) in self.out.details[first..].iter_mut().zip(values) {
                    detail.coordinates = coordinates(*value);
                }
            }
        }
    }

    /// Adds a corner \[m\] and returns its index.
    fn corner(&mut self, point: Vector3<f64>, normal: Vector3<f64>) -> u32 {
        self.out.push(point, normal)
    }

    /// Even number of straight steps for a full circle of `radius` \[m\].
    ///
    /// A chord over the angle 2π/n leaves its circle by r(1 − cos(π/n)).
    fn circle_steps(&self, radius: f64) -> usize {
        let relative = (CHORD_ERROR / (radius * self.pixels)).min(1.0);
        let steps = PI / libm::acos(1.0 - relative);
        2 * (0.5 * steps.clamp(12.0, 128.0)).ceil() as usize
    }

    fn along_z(&mut self, profile: &[ProfilePoint]) {
        self.lathe(Vector3::zeros(), Matrix3::identity(), profile);
    }

    /// Surface of revolution: `profile` around the third column of `frame` through `base`.
    fn lathe(&mut self, base: Vector3<f64>, frame: Matrix3<f64>, profile: &[ProfilePoint]) {
        let widest = profile
            .iter()
            .fold(0.0_f64, |widest, point| widest.max(point.rho));
        let steps = self.circle_steps(widest);
        let first = self.out.vertices.len() as u32;
        for step in 0..=steps {
            let angle = TAU * step as f64 / steps as f64;
            let (sine, cosine) = (libm::sin(angle), libm::cos(angle));
            for point in profile {
                let place = Vector3::new(point.rho * cosine, point.rho * sine, point.z);
                let normal = Vector3::new(
                    point.normal[0] * cosine,
                    point.normal[0] * sine,
                    point.normal[1],
                );
                self.corner(base + frame * place, frame * normal);
            }
        }
        self.grid(first, steps as u32, profile.len() as u32);
    }

    /// Joins `columns + 1` columns of `rows` corners each by two triangles per cell.
    fn grid(&mut self, first: u32, columns: u32, rows: u32) {
        for column in 0..columns {
            for row in 0..rows - 1 {
                let a = first + column * rows + row;
                let b = a + rows;
                self.out
                    .indices
                    .extend_from_slice(&[a, b, a + 1, a + 1, b, b + 1]);
            }
        }
    }

    /// Two balls and their common tangent cone; a capsule when the radii agree, a ball when the centres do.
    fn taper(&mut self, a: Vector3<f64>, b: Vector3<f64>, radius_a: f64, radius_b: f64) {
        let length = (b - a).norm();
        // The tangent cone's normal leans by this sine towards b; it exists while neither ball holds the other.
        let lean = (radius_a - radius_b) / length;
        let (start, end, axis, from, to, lean) = if lean.abs() < 1.0 {
            (a, b, (b - a) / length, radius_a, radius_b, lean)
        } else if radius_a >= radius_b {
            (a, a, Vector3::z(), radius_a, radius_a, 0.0)
        } else {
            (b, b, Vector3::z(), radius_b, radius_b, 0.0)
        };
        let tangent = libm::asin(lean);
        let mut profile = Vec::new();
        self.arc(&mut profile, 0.0, from, -FRAC_PI_2, tangent);
        self.arc(&mut profile, (end - start).norm(), to, tangent, FRAC_PI_2);
        self.lathe(start, frame_along(axis), &profile);
    }

    /// Appends the circle of `radius` around `z` on the axis, over latitudes `from`..`to` \[rad\].
    fn arc(&self, profile: &mut Vec<ProfilePoint>, z: f64, radius: f64, from: f64, to: f64) {
        let steps = ((to - from) / TAU * self.circle_steps(radius) as f64)
            .ceil()
            .max(1.0) as usize;
        for step in 0..=steps {
            let latitude = from + (to - from) * step as f64 / steps as f64;
            let (sine, cosine) = (libm::sin(latitude), libm::cos(latitude));
            profile.push(ProfilePoint {
                rho: radius * cosine,
                z: z + radius * sine,
                normal: [cosine, sine],
            });
        }
    }

    fn cuboid(&mut self, half: &[f64; 3]) {
        for axis in 0..3 {
            for side in [-1.0, 1.0] {
                let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
                let mut normal = Vector3::zeros();
                normal[axis] = side;
                let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(
                    |(along_u, along_v)| {
                        let mut point = Vector3::zeros();
                        point[axis] = side * half[axis];
                        // Anticlockwise as seen from outside, on either side.
                        point[u] = side * along_u * half[u];
                        point[v] = along_v * half[v];
                        self.corner(point, normal)
                    },
                );
                let [a, b, c, d] = corners;
                self.out.indices.extend_from_slice(&[a, b, c, a, c, d]);
            }
        }
    }

    /// A cuboid whose edges and corners are rounded: each face of a cube is divided at the same places, and what lies in the rim of a face goes out to the
    /// ball about the nearest point of the inner cuboid.
    fn rounded_box(&mut self, half: &[f64; 3], radius: f64) {
        let radius = half.iter().fold(radius, |least, side| least.min(*side));
        let places = [-1.0_f64, -0.5, 0.0, 0.0, 0.5, 1.0];
        for axis in 0..3 {
            for side in [-1.0, 1.0] {
                let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
                let first = self.out.vertices.len() as u32;
                for (column, along_u) in places.iter().enumerate() {
                    for (row, along_v) in places.iter().enumerate() {
                        // Which corner of the inner cuboid, and how far in the rim: an eighth of a turn at its end.
                        let sign = |place: usize| if place < 3 { -1.0 } else { 1.0 };
                        let mut centre = Vector3::zeros();
                        let mut outward = Vector3::zeros();
                        centre[axis] = side * (half[axis] - radius);
                        outward[axis] = side;
                        for (k, place, along) in [(u, column, along_u), (v, row, along_v)] {
                            centre[k] = sign(place) * (half[k] - radius);
                            outward[k] = libm::tan(0.25 * PI * along.abs()) * sign(place);
                        }
                        let normal = outward.normalize();
                        self.corner(centre + normal * radius, normal);
                    }
                }
                let side_of = |a: u32, b: u32, c: u32| match side > 0.0 {
                    true => [a, b, c],
                    false => [a, c, b],
                };
                let count = places.len() as u32;
                for column in 0..count - 1 {
                    for row in 0..count - 1 {
                        let a = first + column * count + row;
                        let (b, c, d) = (a + count, a + count + 1, a + 1);
                        self.out.indices.extend(side_of(a, b, c));
                        self.out.indices.extend(side_of(a, c, d));
                    }
                }
            }
        }
    }

    fn ring(&mut self, radius: f64, tube: f64, fraction: f64) {
        let around = (self.circle_steps(radius + tube) as f64 * fraction)
            .ceil()
            .max(1.0) as usize;
        let rows = self.circle_steps(tube);
        let first = self.out.vertices.len() as u32;
        let outward = |part: f64| {
            // Clockwise from +y.
            let angle = TAU * fraction * part;
            Vector3::new(libm::sin(angle), libm::cos(angle), 0.0)
        };
        for step in 0..=around {
            let outward = outward(step as f64 / around as f64);
            for row in 0..=rows {
                let turn = TAU * row as f64 / rows as f64;
                let normal = outward * libm::cos(turn) - Vector3::z() * libm::sin(turn);
                self.corner(outward * radius + normal * tube, normal);
            }
        }
        self.grid(first, around as u32, rows as u32 + 1);
        if fraction < 1.0 {
            // Round ends, so that the tube of a part of a ring is not hollow.
            for part in [0.0, 1.0] {
                let centre = outward(part) * radius;
                self.taper(centre, centre, tube, tube);
            }
        }
    }

    /// Corner normals are the sum of the adjacent triangles' normals, weighted by area, in the order of the triangles.
    fn mesh(&mut self, positions: &[[f32; 3]], triangles: &[[u32; 3]]) {
        let points: Vec<Vector3<f64>> = positions
            .iter()
            .map(|point| Vector3::from(point.map(f64::from)))
            .collect();
        let mut normals = vec![Vector3::zeros(); points.len()];
        for triangle in triangles {
            let [a, b, c] = triangle.map(|index| points[index as usize]);
            // Twice the area long.
            let normal = (b - a).cross(&(c - a));
            for &index in triangle {
                normals[index as usize] += normal;
            }
        }
        let first = self.out.vertices.len() as u32;
        for (point, normal) in points.iter().zip(&normals) {
            // A corner of flat triangles only has no normal; they cover no pixel, so any will do.
            let unit = normal.try_normalize(0.0).unwrap_or_else(Vector3::z);
            self.corner(*point, unit);
        }
        self.out
            .indices
            .extend(triangles.iter().flatten().map(|&index| first + index));
    }
}

/// Closed profile of a truncated cone from radius `bottom` at `from` to `top` at `to` on the axis.
fn cone_profile(bottom: f64, top: f64, from: f64, to: f64) -> Vec<ProfilePoint> {
    let (rise, run) = (to - from, bottom - top);
    let slant = (rise * rise + run * run).sqrt();
    let side = if slant > 0.0 {
        [rise / slant, run / slant]
    } else {
        [1.0, 0.0]
    };
    let point = |rho, z, normal| ProfilePoint { rho, z, normal };
    vec![
        point(0.0, from, [0.0, -1.0]),
        point(bottom, from, [0.0, -1.0]),
        point(bottom, from, side),
        point(top, to, side),
        point(top, to, [0.0, 1.0]),
        point(0.0, to, [0.0, 1.0]),
    ]
}

/// Right-handed frame whose third column is the unit vector `axis`.
fn frame_along(axis: Vector3<f64>) -> Matrix3<f64> {
    // The coordinate axis that is furthest from `axis` gives the best conditioned first column.
    let helper = if axis.x.abs() < 0.6 {
        Vector3::x()
    } else {
        Vector3::y()
    };
    let first = helper.cross(&axis).normalize();
    Matrix3::from_columns(&[first, axis.cross(&first), axis])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn build(shape: Shape) -> Mesh {
        triangulate(&shape, 400.0)
    }

    fn point(mesh: &Mesh, index: u32) -> Vector3<f64> {
        Vector3::from(mesh.vertices[index as usize].position.map(f64::from))
    }

    /// Volume by the divergence theorem; positive when every triangle is seen anticlockwise from outside.
    fn volume(surfaces: &Mesh) -> f64 {
        surfaces
            .indices
            .chunks_exact(3)
            .map(|t| {
                point(surfaces, t[0]).dot(&point(surfaces, t[1]).cross(&point(surfaces, t[2])))
                    / 6.0
            })
            .sum()
    }

    /// Every solid of revolution, the box and the ring enclose their closed-form volume. Chords lie inside the circle: with the
    /// smallest n = 12 steps a circle loses 1 − sin(2π/n)/(2π/n) = 4.5 % of its area; profiles of arcs lose as much again.
    #[test]
    fn shapes_enclose_their_volume() {
        let (a, b) = ([0.1, -0.2, 0.3], [0.4, 0.2, -0.5]);
        let length = (0.09_f64 + 0.16 + 0.64).sqrt();
        let cases = [
            (Shape::Sphere { radius: 0.5 }, 4.0 / 3.0 * PI * 0.125),
            (
                Shape::Capsule { a, b, radius: 0.2 },
                PI * 0.04 * length + 4.0 / 3.0 * PI * 0.008,
            ),
            (
                Shape::Taper {
                    a: b,
                    b,
                    radius_a: 0.2,
                    radius_b: 0.3,
                },
                4.0 / 3.0 * PI * 0.027,
            ),
            (
                Shape::Box {
                    half: [0.1, 0.2, 0.3],
                },
                0.048,
            ),
            // Without the rim: a box less what rounding takes of edges and corners, Minkowski's sum of a cuboid and a ball.
            (
                Shape::RoundedBox {
                    half: [0.3, 0.4, 0.5],
                    radius: 0.1,
                },
                0.4 * 0.6 * 0.8
                    + 2.0 * 0.1 * (0.4 * 0.6 + 0.6 * 0.8 + 0.4 * 0.8)
                    + PI * 0.01 * (0.4 + 0.6 + 0.8)
                    + 4.0 / 3.0 * PI * 0.001,
            ),
            (
                Shape::Cylinder {
                    radius: 0.3,
                    height: 0.5,
                },
                PI * 0.09 * 0.5,
            ),
            (
                Shape::Cone {
                    radius: 0.3,
                    height: 0.6,
                },
                PI * 0.09 * 0.2,
            ),
            (
                Shape::Arrow {
                    radius: 0.1,
                    length: 0.9,
                },
                PI * 0.01 * 0.6 + PI * 0.09 * 0.1,
            ),
            (
                Shape::Ring {
                    radius: 0.5,
                    tube: 0.1,
                    fraction: 1.0,
                },
                2.0 * PI * PI * 0.5 * 0.01,
            ),
        ];
        for (shape, expected) in cases {
            let relative = volume(&build(shape.clone())) / expected - 1.0;
            assert!((-0.09..1e-5).contains(&relative), "{shape:?}: {relative}");
        }
    }

    /// Between the balls a taper is tangent to both: every normal of the cone is perpendicular to its side line, and every
    /// corner lies on the surface (distance to the segment's nearest interpolated ball centre equals its radius).
    #[test]
    fn taper_touches_both_balls() {
        let (radius_a, radius_b, length) = (0.3, 0.1, 0.8);
        let surfaces = build(Shape::Taper {
            a: [0.0; 3],
            b: [length, 0.0, 0.0],
            radius_a,
            radius_b,
        });
        for vertex in &surfaces.vertices {
            let place = Vector3::from(vertex.position.map(f64::from));
            let normal = Vector3::from(vertex.normal.map(f64::from));
            let to_a = (place - normal * radius_a).norm();
            let to_b = (place - normal * radius_b - Vector3::new(length, 0.0, 0.0)).norm();
            // f32 storage: 2⁻²⁴ relative per coordinate, three coordinates, positions and normals.
            assert!(to_a.min(to_b) < 1e-6, "{vertex:?}");
        }
        let between = surfaces.vertices.iter().filter(|v| {
            let sine = f64::from(v.normal[0]);
            (sine - (radius_a - radius_b) / length).abs() < 1e-6
        });
        assert!(
            between.count() > 2,
            "the two circles of tangency are part of the surface"
        );
    }

    /// A quarter of a ring stays in the quadrant between +y and +x, as a clock's hand does, up to its round ends.
    #[test]
    fn ring_runs_clockwise_from_the_top() {
        let surfaces = build(Shape::Ring {
            radius: 0.5,
            tube: 0.1,
            fraction: 0.25,
        });
        for vertex in &surfaces.vertices {
            assert!(
                vertex.position[0] > -0.1001 && vertex.position[1] > -0.1001,
                "{:?}",
                vertex.position
            );
        }
    }

    /// The corner normals of a regular octahedron point along its corners, by symmetry; turning a triangle round does not change
    /// what is drawn but its normal, so here all are anticlockwise.
    #[test]
    fn mesh_normals_are_smooth() {
        let mut positions = Vec::new();
        for axis in 0..3 {
            for side in [1.0_f32, -1.0] {
                let mut corner = [0.0; 3];
                corner[axis] = side;
                positions.push(corner);
            }
        }
        let triangles = vec![
            [0, 2, 4],
            [2, 1, 4],
            [1, 3, 4],
            [3, 0, 4],
            [2, 0, 5],
            [1, 2, 5],
            [3, 1, 5],
            [0, 3, 5],
        ];
        let surfaces = build(Shape::Mesh {
            positions,
            triangles,
        });
        for vertex in &surfaces.vertices {
            assert_eq!(vertex.normal, vertex.position);
        }
    }
}
