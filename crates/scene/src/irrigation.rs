//! What jets of tools press on: in the lumen that surrounds the opening, else on the surface that faces it.

use crate::body::Body;
use crate::jet::Jet;
use crate::lumen::Section;
use microsim_geometry::Aabb;
use microsim_tissue::PressedTriangle;
use nalgebra::Vector3;

/// Working memory for the pressures on the bodies of a group.
#[derive(Clone, Debug, Default)]
pub(crate) struct Irrigation {
    /// Where there is a pressure.
    pub pressed: Vec<PressedTriangle>,
    sections: Vec<Section>,
}

impl Irrigation {
    /// Adds what jets press on a body at these positions of its nodes \[m\], the first of which is node `first` of the group.
    pub fn add(&mut self, jets: &[Jet], body: &Body, positions: &[Vector3<f64>], first: u32) {
        if jets.is_empty() {
            return;
        }
        // Triangles have their middles in it, and lumens what they surround.
        let bounds = Aabb::of(positions);
        for jet in jets.iter().filter(|jet| jet.bounds().overlaps(&bounds)) {
            match &body.lumen {
                Some(lumen) if lumen.holds(&jet.tip, positions) => {
                    lumen.pressures(&jet.tip, jet.pressure, positions, &mut self.sections);
                    let sections = &self.sections;
                    let pressed = lumen.triangles().iter().map(|triangle| PressedTriangle {
                        nodes: triangle.nodes.map(|node| node + first),
                        pressure: sections[triangle.section as usize].pressure,
                    });
                    self.pressed.extend(pressed);
                }
                _ => {
                    let triangles = &body.surface.triangles;
                    let stop = jet.stop(triangles, positions);
                    let pressed = triangles.iter().filter_map(|nodes| {
                        let corners = nodes.map(|node| positions[node as usize]);
                        let pressure = jet.pressure_on(corners, stop);
                        (pressure > 0.0).then(|| PressedTriangle {
                            nodes: nodes.map(|node| node + first),
                            pressure,
                        })
                    });
                    self.pressed.extend(pressed);
                }
            }
        }
    }
}
