//! Bodies on the device: what is prepared for the triangles of each stays while these do.

use nalgebra::Vector3;
use std::collections::BTreeMap;

use crate::display::Display;
use crate::mesh::{Detail, Vertex};
use crate::store::Triangles;
use crate::tissue::Tissue;
use crate::wall::Wall;

/// A body that was drawn before.
struct Body {
    wall: Wall,
    display: Display,
    /// What the display was made of.
    triangles: Vec<[u32; 3]>,
    inner: Vec<bool>,
    regions: Vec<u32>,
    steps: usize,
    on_device: Triangles,
}

/// All bodies that the last picture had.
#[derive(Default)]
pub(crate) struct Bodies {
    bodies: BTreeMap<u64, Body>,
    /// Vertices of one body, which stays to spare the allocation.
    vertices: Vec<Vertex>,
}

impl Bodies {
    /// Takes up the bodies of a picture, with at most so many steps of refinement; those that are gone are forgotten.
    pub fn update(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        tissues: &[Tissue],
        steps: usize,
    ) {
        self.bodies
            .retain(|id, _| tissues.iter().any(|tissue| tissue.body == *id));
        for tissue in tissues {
            let body = match self.bodies.remove(&tissue.body) {
                Some(body) if body.wall.is_of(tissue) => body,
                _ => Body::new(device, tissue),
            };
            let body = body.updated(device, queue, tissue, steps, &mut self.vertices);
            self.bodies.insert(tissue.body, body);
        }
    }

    /// The triangles of a body.
    pub fn of(&self, body: u64) -> Option<&Triangles> {
        self.bodies.get(&body).map(|body| &body.on_device)
    }
}

impl Body {
    fn new(device: &wgpu::Device, tissue: &Tissue) -> Self {
        Self {
            wall: Wall::new(tissue),
            display: Display::default(),
            triangles: Vec::new(),
            inner: Vec::new(),
            regions: Vec::new(),
            steps: usize::MAX,
            on_device: Triangles::new(device),
        }
    }

    fn updated(
        mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        tissue: &Tissue,
        steps: usize,
        vertices: &mut Vec<Vertex>,
    ) -> Self {
        let same = self.steps == steps
            && self.triangles == tissue.triangles
            && self.inner == tissue.inner
            && self.regions == tissue.regions;
        if !same {
            self.wall.place(tissue);
            let places: Vec<Vector3<f32>> = self.wall.places(tissue);
            let layers = self.wall.layers(tissue, &places);
            self.display = Display::new(&tissue.triangles, &layers, &places, steps);
            let rest = self.display.interpolated(&self.wall.in_frame(&places));
            let details: Vec<Detail> = rest
                .into_iter()
                .zip(self.display.layers())
                .map(|(rest, layer)| Detail {
                    rest,
                    layer: f32::from(*layer),
                    ..Detail::default()
                })
                .collect();
            let indices = self.display.triangles().as_flattened();
            self.on_device.write_rest(device, queue, &details, indices);
            self.triangles.clone_from(&tissue.triangles);
            self.inner.clone_from(&tissue.inner);
            self.regions.clone_from(&tissue.regions);
            self.steps = steps;
        }
        self.display.evaluate(&tissue.positions, vertices);
        self.on_device.write_vertices(device, queue, vertices);
        self
    }
}
