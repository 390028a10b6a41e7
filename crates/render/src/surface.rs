//! All triangles of a picture in the view frame, in the order of drawing, ready for upload.

mod tessellate;

use nalgebra::{Matrix3, Vector3};
use std::ops::Range;

use crate::picture::{Item, Shape, View};
use tessellate::Tessellator;

/// What the vertex shader reads, in its order.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub(crate) struct Vertex {
    /// View frame \[field radii\].
    pub position: [f32; 3],
    /// Unit length, view frame, outwards.
    pub normal: [f32; 3],
    /// Linear light and opacity.
    pub colour: [f32; 4],
    /// 0 matte, 1 moist, 2 metal.
    pub finish: f32,
}

/// Triangles of all items of a picture.
#[derive(Clone, Debug, Default)]
pub(crate) struct Surfaces {
    pub vertices: Vec<Vertex>,
    pub indices: Vec<u32>,
    /// Parts of `indices` in the order of drawing: solid ones first.
    pub layers: Vec<Layer>,
}

/// Triangles that are drawn in one go.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Layer {
    pub indices: Range<u32>,
    /// Hides what is behind it and casts a shadow.
    pub solid: bool,
    /// Wound anticlockwise as seen from outside and without an edge, so that no inner side is ever seen.
    pub closed: bool,
}

impl Surfaces {
    /// Triangulates `items` (checked before) for `view` on a field of `field_pixels` radius.
    pub(crate) fn build(items: &[Item], view: &View, field_pixels: f64) -> Self {
        let mut surfaces = Self::default();
        let is_closed = |item: &Item| !matches!(item.shape, Shape::Mesh { .. });
        let (mut closed, open): (Vec<&Item>, Vec<&Item>) = items
            .iter()
            .filter(|item| item.opacity >= 1.0)
            .partition(|item| is_closed(item));
        // What is nearer to the eye comes first: it spares shading what it hides, the mat above all.
        let to_eye = view_from_field(view.tilt).row(2).transpose();
        let height = |item: &Item| to_eye.dot(&Vector3::from(item.position));
        closed.sort_by(|a, b| height(b).total_cmp(&height(a)));
        surfaces.layer(&closed, true, true, view, field_pixels);
        surfaces.layer(&open, true, false, view, field_pixels);
        for item in items
            .iter()
            .filter(|item| item.opacity > 0.0 && item.opacity < 1.0)
        {
            surfaces.layer(&[item], false, is_closed(item), view, field_pixels);
        }
        surfaces
    }

    fn layer(
        &mut self,
        items: &[&Item],
        solid: bool,
        closed: bool,
        view: &View,
        field_pixels: f64,
    ) {
        let start = self.indices.len() as u32;
        for item in items {
            Tessellator::new(item, view, field_pixels, self).shape(&item.shape);
        }
        self.layers.push(Layer {
            indices: start..self.indices.len() as u32,
            solid,
            closed,
        });
    }
}

/// Rotation from the field frame to the view frame.
pub(crate) fn view_from_field(tilt: f64) -> Matrix3<f64> {
    let (sine, cosine) = (libm::sin(tilt), libm::cos(tilt));
    // Rows: picture's right, picture's up, towards the eye.
    Matrix3::new(1.0, 0.0, 0.0, 0.0, cosine, sine, 0.0, -sine, cosine)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::VIEW;
    use microsim_vocabulary::Finish;

    /// The view frame: a tilt of 30° lifts what is high by sin 30° towards the top of the picture, for the eye leans to −y.
    #[test]
    fn tilt_leans_the_eye_towards_the_operator() {
        let view = View {
            tilt: std::f64::consts::PI / 6.0,
            ..VIEW
        };
        let item = Item::new(
            Shape::Box { half: [0.0; 3] },
            [0.0, 0.0, 1.0],
            [1.0; 3],
            Finish::Matte,
        );
        let [x, y, z] = Surfaces::build(&[item], &view, 400.0).vertices[0].position;
        assert!(
            x.abs() < 1e-6
                && (y - 0.5).abs() < 1e-6
                && (f64::from(z) - 0.75_f64.sqrt()).abs() < 1e-6
        );
    }

    /// Layers: closed solids (the nearer first), solid meshes, then each translucent item by itself; an invisible item has none.
    #[test]
    fn layers_follow_the_order_of_drawing() {
        let ball = |height: f64, opacity| Item {
            opacity,
            ..Item::new(
                Shape::Sphere { radius: 0.1 },
                [0.0, 0.0, height],
                [1.0; 3],
                Finish::Matte,
            )
        };
        let mesh = Shape::Mesh {
            positions: vec![[0.0; 3]; 3],
            triangles: vec![[0, 1, 2]],
        };
        let sheet = Item::new(mesh, [0.0; 3], [1.0; 3], Finish::Matte);
        let surfaces = Surfaces::build(
            &[
                sheet,
                ball(0.0, 0.5),
                ball(-0.5, 1.0),
                ball(0.0, 0.0),
                ball(0.5, 1.0),
            ],
            &VIEW,
            400.0,
        );
        let per_ball = surfaces.layers[2].indices.len() as u32;
        let layer = |indices, solid, closed| Layer {
            indices,
            solid,
            closed,
        };
        let expected = [
            layer(0..2 * per_ball, true, true),
            layer(2 * per_ball..2 * per_ball + 3, true, false),
            layer(2 * per_ball + 3..3 * per_ball + 3, false, true),
        ];
        assert_eq!(surfaces.layers, expected);
        let height =
            |place: u32| surfaces.vertices[surfaces.indices[place as usize] as usize].position[2];
        assert!(height(0) > height(per_ball), "the nearer ball first");
    }
}
