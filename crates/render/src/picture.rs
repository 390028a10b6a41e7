//! What to draw: a view and a list of items. Plain data, checked once before it is drawn.

use microsim_vocabulary::Finish;
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use std::f64::consts::FRAC_PI_2;

use crate::shape::{Shape, finite};
use crate::stereo::Stereo;
use crate::tissue::Tissue;

/// The background of the field: the colour of a wet drape, sRGB.
pub const DRAPE: [f32; 3] = [0.07, 0.16, 0.17];

/// From the main lens to the focus \[m\]: a usual focal length of surgical microscopes.
const WORKING_DISTANCE: f64 = 0.25;
/// Half the width, and half the thickness, of the slab that stands for a half-space, in fields of view.
const SLAB: [f64; 2] = [2.0, 0.02];

/// One picture: size, view, items.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Width \[pixels\], at least 1.
    pub width: u32,
    /// Height \[pixels\], at least 1.
    pub height: u32,
    /// Where the microscope looks.
    pub view: View,
    /// Colour where the field shows no item: sRGB, each 0..1.
    pub background: [f32; 3],
    /// What there is to see. The order matters only for translucent items that cover each other: the later one is in front.
    pub items: Vec<Item>,
    /// Bodies, which are drawn with detail of their own.
    pub tissues: Vec<Tissue>,
    /// One picture, or one per eye.
    pub stereo: Stereo,
    /// Whether all but the eyes and the lamps is mirrored in the plane through the middle of the view that has x fixed: right is left.
    pub mirrored: bool,
}

impl Picture {
    /// Of items over a drape, for one eye.
    pub fn new((width, height): (u32, u32), view: View, items: Vec<Item>) -> Self {
        Self {
            width,
            height,
            view,
            background: DRAPE,
            items,
            tissues: Vec::new(),
            stereo: Stereo::default(),
            mirrored: false,
        }
    }
}

/// A microscope that looks down the field frame's −z, or tilted from it, with the long focus of its main lens.
///
/// The round field touches the nearer pair of the picture's edges; outside it the picture is black.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Focus point: what appears in the middle, field frame \[m\].
    pub centre: [f64; 3],
    /// Diameter of the round field in the plane of focus \[m\]; surgical microscopes: 17 to 38 mm.
    pub field_diameter: f64,
    /// From the main lens to the focus point \[m\]; surgical microscopes: 0.2 to 0.45 m. At least one field diameter.
    pub working_distance: f64,
    /// Angle by which the eye leans from +z towards −y, that is towards the operator \[rad\], within ±π/2.
    pub tilt: f64,
}

impl View {
    /// A view with the focal length of a usual surgical microscope, or a longer one where the field needs it.
    pub fn of_microscope(centre: [f64; 3], field_diameter: f64, tilt: f64) -> Self {
        Self {
            centre,
            field_diameter,
            working_distance: WORKING_DISTANCE.max(field_diameter),
            tilt,
        }
    }
}

/// One object to see.
#[derive(Clone, Debug, PartialEq)]
pub struct Item {
    /// Its form, in the item's own frame.
    pub shape: Shape,
    /// Origin of the item's frame in the field frame \[m\].
    pub position: [f64; 3],
    /// Rotation from the item's frame to the field frame: quaternion x, y, z, w; normalised on use.
    pub orientation: [f64; 4],
    /// Colour: sRGB, each 0..1. A matte surface that faces the microscope in full light shows exactly this.
    pub colour: [f32; 3],
    /// How the surface answers light.
    pub finish: Finish,
    /// 1 is solid, 0 invisible. A translucent item casts no shadow and hides nothing.
    pub opacity: f32,
    /// What a matte surface is made of.
    pub pattern: Pattern,
}

/// What a matte surface shows besides its colour.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Pattern {
    /// Nothing.
    #[default]
    Plain,
    /// The weave of a cloth, with shades and a thread of other colour here and there: background mats.
    Cloth,
}

impl Item {
    /// A solid item of `shape` at `position` \[m\], unrotated.
    pub fn new(shape: Shape, position: [f64; 3], colour: [f32; 3], finish: Finish) -> Self {
        Self {
            shape,
            position,
            orientation: [0.0, 0.0, 0.0, 1.0],
            colour,
            finish,
            opacity: 1.0,
            pattern: Pattern::Plain,
        }
    }

    /// This item at a position \[m\] and orientation (quaternion x, y, z, w) in the field frame.
    pub fn at(self, position: [f64; 3], orientation: [f64; 4]) -> Self {
        Self {
            position,
            orientation,
            ..self
        }
    }

    /// This item, moved along its own z axis \[m\].
    pub fn raised(self, by: f64) -> Self {
        let [x, y, z, w] = self.orientation;
        let turn = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z));
        let position = Vector3::from(self.position) + turn * (Vector3::z() * by);
        Self {
            position: position.into(),
            ..self
        }
    }

    /// The half-space below z = 0 of a pose, as a slab wider than a field of this diameter \[m\]; a matte one is a cloth.
    pub fn half_space(
        position: [f64; 3],
        orientation: [f64; 4],
        field_diameter: f64,
        colour: [f32; 3],
        finish: Finish,
    ) -> Self {
        let [width, thickness] = SLAB.map(|part| part * field_diameter);
        let half = [width, width, thickness];
        let slab = Self::new(Shape::Box { half }, position, colour, finish);
        let pattern = match finish {
            Finish::Matte => Pattern::Cloth,
            _ => Pattern::Plain,
        };
        let slab = Self { pattern, ..slab };
        slab.at(position, orientation).raised(-thickness)
    }
}

impl View {
    /// What makes the view impossible, if anything.
    pub(crate) fn fault(&self) -> Option<&'static str> {
        if !finite(&self.centre) {
            Some("centre is not finite")
        } else if !(self.field_diameter.is_finite() && self.field_diameter > 0.0) {
            Some("field_diameter must be finite and greater than zero")
        } else if !(self.working_distance.is_finite()
            && self.working_distance >= self.field_diameter)
        {
            Some("working_distance must be finite and at least field_diameter")
        } else if !(-FRAC_PI_2..=FRAC_PI_2).contains(&self.tilt) {
            Some("tilt must lie within a quarter turn")
        } else {
            None
        }
    }
}

impl Item {
    /// What makes the item undrawable, if anything.
    pub(crate) fn fault(&self) -> Option<&'static str> {
        let norm_squared: f64 = self.orientation.iter().map(|part| part * part).sum();
        if !finite(&self.position) {
            Some("position is not finite")
        } else if !(norm_squared.is_finite() && norm_squared > 0.0) {
            Some("orientation is not a rotation")
        } else if !self.colour.iter().all(|part| (0.0..=1.0).contains(part)) {
            Some("colour must lie within 0..1")
        } else if !(0.0..=1.0).contains(&self.opacity) {
            Some("opacity must lie within 0..1")
        } else {
            self.shape.fault()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each kind of bad number is refused with the reason that names it; the unspoilt item is accepted.
    #[test]
    fn faults_are_named() {
        let good = Item::new(
            Shape::Sphere { radius: 1.0 },
            [0.0; 3],
            [0.5; 3],
            Finish::Matte,
        );
        assert_eq!(good.fault(), None);
        let mesh = |triangle| Shape::Mesh {
            positions: vec![[0.0; 3]; 3],
            triangles: vec![triangle],
        };
        assert_eq!(
            Item {
                shape: mesh([0, 1, 2]),
                ..good.clone()
            }
            .fault(),
            None
        );
        let cases = [
            (
                Item {
                    position: [0.0, f64::NAN, 0.0],
                    ..good.clone()
                },
                "position",
            ),
            (
                Item {
                    orientation: [0.0; 4],
                    ..good.clone()
                },
                "orientation",
            ),
            (
                Item {
                    colour: [0.0, 1.5, 0.0],
                    ..good.clone()
                },
                "colour",
            ),
            (
                Item {
                    opacity: f32::NAN,
                    ..good.clone()
                },
                "opacity",
            ),
            (
                Item {
                    shape: Shape::Sphere { radius: -1.0 },
                    ..good.clone()
                },
                "lengths",
            ),
            (
                Item {
                    shape: Shape::Ring {
                        radius: 1.0,
                        tube: 0.1,
                        fraction: 1.1,
                    },
                    ..good.clone()
                },
                "fraction",
            ),
            (
                Item {
                    shape: mesh([0, 1, 3]),
                    ..good
                },
                "does not exist",
            ),
        ];
        for (item, word) in cases {
            assert!(
                item.fault().is_some_and(|fault| fault.contains(word)),
                "{word}: {:?}",
                item.fault()
            );
        }
    }

    /// A view needs a field, and a distance that keeps the eye out of it.
    #[test]
    fn impossible_views_are_refused() {
        let good = View {
            centre: [0.0; 3],
            field_diameter: 0.025,
            working_distance: 0.2,
            tilt: 0.0,
        };
        assert_eq!(good.fault(), None);
        for bad in [
            View {
                centre: [f64::INFINITY, 0.0, 0.0],
                ..good
            },
            View {
                field_diameter: 0.0,
                ..good
            },
            View {
                working_distance: 0.02,
                ..good
            },
            View {
                tilt: f64::NAN,
                ..good
            },
        ] {
            assert!(bad.fault().is_some(), "{bad:?}");
        }
    }
}
