//! Triangles of shapes on the device: each form once, found again from picture to picture.

use std::collections::BTreeMap;

use crate::mesh::{Detail, Mesh, Vertex};
use crate::picture::Item;
use crate::shape::Shape;
use crate::tessellate::triangulate;
use crate::upload::Upload;

/// Shapes that are not drawn are forgotten when there are more than this.
const MOST: usize = 512;
/// Lengths that differ by less than this part are one: a capsule's ends are rounded in every pose.
const SAME: f64 = 1e-5;

/// Vertices, details and indices on the device.
pub(crate) struct Triangles {
    pub vertices: Upload,
    pub details: Upload,
    pub indices: Upload,
    pub count: u32,
}

impl Triangles {
    pub fn new(device: &wgpu::Device) -> Self {
        let upload = |label, usage| Upload::new(device, label, usage, 1 << 10);
        Self {
            vertices: upload("vertices", wgpu::BufferUsages::VERTEX),
            details: upload("details", wgpu::BufferUsages::VERTEX),
            indices: upload("indices", wgpu::BufferUsages::INDEX),
            count: 0,
        }
    }

    /// Replaces all of it.
    pub fn write(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, mesh: &Mesh) {
        self.write_vertices(device, queue, &mesh.vertices);
        self.write_rest(device, queue, &mesh.details, &mesh.indices);
    }

    pub fn write_vertices(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        vertices: &[Vertex],
    ) {
        self.vertices.write(device, queue, vertices);
    }

    pub fn write_rest(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        details: &[Detail],
        indices: &[u32],
    ) {
        self.details.write(device, queue, details);
        self.indices.write(device, queue, indices);
        self.count = indices.len() as u32;
    }
}

/// What a form is found by: its kind, its lengths, and how finely it is divided.
type Key = (u8, [u64; 5]);

struct Stored {
    triangles: Triangles,
    /// Number of the picture in which it was last drawn.
    used: u64,
}

/// All shapes that are on the device.
#[derive(Default)]
pub(crate) struct Store {
    places: BTreeMap<Key, usize>,
    stored: Vec<Option<Stored>>,
    picture: u64,
}

impl Store {
    /// Begins a picture; shapes that were not drawn of late make room.
    pub fn begin(&mut self) {
        self.picture += 1;
        if self.places.len() > MOST {
            let (stored, picture) = (&mut self.stored, self.picture);
            self.places.retain(|_, place| {
                let recent = stored[*place]
                    .as_ref()
                    .is_some_and(|shape| shape.used + 1 >= picture);
                if !recent {
                    stored[*place] = None;
                }
                recent
            });
        }
    }

    /// The place of an item's triangles, and the item that is drawn with them: one whose form has a pose of its own is brought to its common form.
    /// `pixels` per metre. A mesh is none of them.
    pub fn place(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        item: &Item,
        pixels: f64,
    ) -> Option<(usize, Item)> {
        let item = common(item)?;
        // Steps of √2 in size: a zoom does not make each form again in each picture.
        let level = (2.0 * libm::log2(pixels)).ceil();
        let key = key_of(&item.shape, level)?;
        let place = match self.places.get(&key) {
            Some(place) => *place,
            None => {
                let finest = libm::exp2(0.5 * level);
                let mut triangles = Triangles::new(device);
                triangles.write(device, queue, &triangulate(&item.shape, finest));
                let stored = Some(Stored { triangles, used: 0 });
                let free = self.stored.iter().position(Option::is_none);
                let place = free.unwrap_or(self.stored.len());
                match free {
                    Some(place) => self.stored[place] = stored,
                    None => self.stored.push(stored),
                }
                self.places.insert(key, place);
                place
            }
        };
        if let Some(stored) = &mut self.stored[place] {
            stored.used = self.picture;
        }
        Some((place, item))
    }

    /// The triangles at a place of this picture.
    pub fn at(&self, place: usize) -> Option<&Triangles> {
        self.stored
            .get(place)?
            .as_ref()
            .map(|stored| &stored.triangles)
    }
}

/// The same item with its form at the origin and along z, where the form has ends of its own.
fn common(item: &Item) -> Option<Item> {
    let along = |a: [f64; 3], b: [f64; 3], radius_a: f64, radius_b: f64| {
        use nalgebra::{Quaternion, UnitQuaternion, Vector3};
        let (a, b) = (Vector3::from(a), Vector3::from(b));
        let [x, y, z, w] = item.orientation;
        let turn = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z));
        let length = (b - a).norm();
        let own = match (b - a).try_normalize(0.0) {
            // Half a turn about x where the axes are opposite.
            Some(axis) => {
                UnitQuaternion::rotation_between(&Vector3::z(), &axis).unwrap_or_else(|| {
                    UnitQuaternion::new_unchecked(Quaternion::new(0.0, 1.0, 0.0, 0.0))
                })
            }
            None => UnitQuaternion::identity(),
        };
        let shape = Shape::Taper {
            a: [0.0; 3],
            b: [0.0, 0.0, length],
            radius_a,
            radius_b,
        };
        let position = Vector3::from(item.position) + turn * a;
        Item {
            shape,
            position: position.into(),
            orientation: (turn * own).coords.into(),
            ..item.clone()
        }
    };
    match &item.shape {
        Shape::Capsule { a, b, radius } => Some(along(*a, *b, *radius, *radius)),
        Shape::Taper {
            a,
            b,
            radius_a,
            radius_b,
        } => Some(along(*a, *b, *radius_a, *radius_b)),
        Shape::Mesh { .. } | Shape::Field { .. } => None,
        _ => Some(item.clone()),
    }
}

fn key_of(shape: &Shape, level: f64) -> Option<Key> {
    let same = |length: f64| match length > 0.0 {
        true => (libm::log(length) / SAME).round().to_bits(),
        false => 0,
    };
    let key = |kind: u8, lengths: &[f64]| {
        let mut parts = [0; 5];
        parts[0] = level.to_bits();
        for (part, length) in parts[1..].iter_mut().zip(lengths) {
            *part = same(*length);
        }
        Some((kind, parts))
    };
    match shape {
        Shape::Sphere { radius } => key(0, &[*radius]),
        Shape::Taper {
            b,
            radius_a,
            radius_b,
            ..
        } => key(1, &[b[2], *radius_a, *radius_b]),
        Shape::Box { half } => key(2, half),
        Shape::RoundedBox { half, radius } => key(3, &[half[0], half[1], half[2], *radius]),
        Shape::Cylinder { radius, height } => key(4, &[*radius, *height]),
        Shape::Cone { radius, height } => key(5, &[*radius, *height]),
        Shape::Arrow { radius, length } => key(6, &[*radius, *length]),
        Shape::Ring {
            radius,
            tube,
            fraction,
        } => key(7, &[*radius, *tube, *fraction]),
        // As fine as it is, on any screen.
        Shape::Model(model) => Some((8, [model.id(), 0, 0, 0, 0])),
        Shape::Capsule { .. } | Shape::Mesh { .. } | Shape::Field { .. } => None,
    }
}

/// Smooth triangles of a mesh: its normals are the sums of the adjacent triangles', weighted by area, in the order of the triangles.
pub(crate) fn loose(shape: &Shape, out: &mut Mesh) {
    *out = triangulate(shape, 1.0);
}
