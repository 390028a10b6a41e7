//! What is drawn in one picture: which triangles, how often, where, in which order.

use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};

use crate::family::Family;
use crate::light::linear_from_srgb;
use crate::picture::{Item, Pattern, View};
use crate::shape::Shape;
use microsim_model::Mask;
use microsim_vocabulary::Finish;

/// One drawing of some triangles, as the vertex shader reads it.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub(crate) struct Instance {
    /// Rows from the item's frame \[m\] to the view frame \[field radii\].
    pub rows: [[f32; 4]; 3],
    /// Linear light and opacity.
    pub colour: [f32; 4],
    /// First: 1 of a cloth. Then, of a surface that is cut out by its texture, the opacity below which it is not there, and what that of the texture is multiplied by.
    pub pattern: [f32; 4],
}

impl Instance {
    /// Of an item.
    pub fn of_item(item: &Item, view: &View) -> Self {
        let [x, y, z, w] = item.orientation;
        let turn = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z));
        let turn = turn.to_rotation_matrix().into_inner();
        let cloth = match item.pattern {
            Pattern::Plain => 0.0,
            Pattern::Cloth => 1.0,
        };
        let [cutoff, factor] = mask_of(item).map_or([0.0; 2], |mask| [mask.cutoff, mask.factor]);
        Self {
            pattern: [cloth, cutoff, factor, 0.0],
            ..Self::new(turn, item.position, item.colour, item.opacity, view)
        }
    }

    /// Of what lies in the field frame.
    pub fn of_field(colour: [f32; 3], view: &View) -> Self {
        Self::new(Matrix3::identity(), [0.0; 3], colour, 1.0, view)
    }

    fn new(
        turn: Matrix3<f64>,
        position: [f64; 3],
        colour: [f32; 3],
        opacity: f32,
        view: &View,
    ) -> Self {
        // In f64, so that a field far from the caller's origin loses nothing.
        let scale = 2.0 / view.field_diameter;
        let tilted = view_from_field(view.tilt) * scale;
        let rotation = tilted * turn;
        let origin = tilted * (Vector3::from(position) - Vector3::from(view.centre));
        let row = |k: usize| {
            [
                rotation[(k, 0)],
                rotation[(k, 1)],
                rotation[(k, 2)],
                origin[k],
            ]
            .map(|part| part as f32)
        };
        let [red, green, blue] = colour.map(|part| linear_from_srgb(f64::from(part)) as f32);
        Self {
            rows: [row(0), row(1), row(2)],
            colour: [red, green, blue, opacity],
            pattern: [0.0; 4],
        }
    }

    /// Height above the plane of focus \[field radii\].
    pub fn height(&self) -> f32 {
        self.rows[2][3]
    }
}

/// Rotation from the field frame to the view frame.
fn view_from_field(tilt: f64) -> Matrix3<f64> {
    let (sine, cosine) = (libm::sin(tilt), libm::cos(tilt));
    // Rows: picture's right, picture's up, towards the eye.
    Matrix3::new(1.0, 0.0, 0.0, 0.0, cosine, sine, 0.0, -sine, cosine)
}

/// The triangles of a drawing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Source {
    /// Of the store of shapes.
    Shape(usize),
    /// Of a body, in the picture's order.
    Body(usize),
    /// A mesh that the picture brings.
    Loose(usize),
}

/// One drawing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Draw {
    pub source: Source,
    pub family: Family,
    /// Hides what is behind it and casts a shadow.
    pub solid: bool,
    /// Throws a shadow; the cloth below all does not.
    pub casts: bool,
    /// Wound anticlockwise as seen from outside and without an edge, so that no inner side is ever seen.
    pub closed: bool,
    /// Of the texture that its colour is multiplied by.
    pub texture: Option<u64>,
    /// Not there where its texture is translucent.
    pub is_masked: bool,
    pub instance: Instance,
}

/// What of an item is there; `None` if all of it is.
pub(crate) fn mask_of(item: &Item) -> Option<Mask> {
    match &item.shape {
        Shape::Model(model) => model.mask(),
        _ => None,
    }
}

/// Family of a finish.
pub(crate) fn family_of(finish: Finish) -> Family {
    match finish {
        Finish::Matte => Family::Matte,
        Finish::Moist => Family::Moist,
        Finish::Metal => Family::Metal,
    }
}

/// Solid ones first, closed before open, the nearer before the farther, which spares shading what they hide; translucent ones stay in their order.
pub(crate) fn sort(draws: &mut [Draw]) {
    draws.sort_by(|a, b| {
        let rank = |draw: &Draw| (!draw.solid, draw.solid && !draw.closed);
        let order = rank(a).cmp(&rank(b));
        let nearer = b.instance.height().total_cmp(&a.instance.height());
        match a.solid {
            true => order.then(nearer),
            false => order,
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::VIEW;

    fn ball(height: f64) -> Item {
        let shape = Shape::Sphere { radius: 0.1 };
        Item::new(shape, [0.0, 0.0, height], [1.0; 3], Finish::Matte)
    }

    /// The view frame: a tilt of 30° lifts what is high by sin 30° towards the top of the picture, for the eye leans to −y.
    #[test]
    fn tilt_leans_the_eye_towards_the_operator() {
        let view = View {
            tilt: std::f64::consts::PI / 6.0,
            ..VIEW
        };
        let rows = Instance::of_item(&ball(1.0), &view).rows;
        let [x, y, z] = rows.map(|row| f64::from(row[3]));
        assert!(x.abs() < 1e-6 && (y - 0.5).abs() < 1e-6 && (z - 0.75_f64.sqrt()).abs() < 1e-6);
    }

    /// Closed solids (the nearer first), solid meshes, then the translucent in their order.
    #[test]
    fn draws_follow_the_order_of_drawing() {
        let draw = |height, solid, closed| Draw {
            source: Source::Shape(0),
            family: Family::Matte,
            solid,
            casts: solid,
            closed,
            texture: None,
            is_masked: false,
            instance: Instance::of_item(&ball(height), &VIEW),
        };
        let mut draws = [
            draw(0.0, true, false),
            draw(0.1, false, true),
            draw(-0.5, true, true),
            draw(0.3, false, true),
            draw(0.5, true, true),
        ];
        sort(&mut draws);
        let found = draws.map(|draw| (draw.instance.height(), draw.solid, draw.closed));
        let expected = [
            (0.5, true, true),
            (-0.5, true, true),
            (0.0, true, false),
            (0.1, false, true),
            (0.3, false, true),
        ];
        assert_eq!(found, expected);
    }
}
