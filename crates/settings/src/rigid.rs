//! Obstacles of levels and scenes, and the solid parts of which they are made.
//!
//! Frames: an obstacle lies in the frame of its level or scene by `position` and `orientation`, about its centre unless its
//! shape defines otherwise. Everything is in SI.

use crate::colour::Colour;
use crate::kinds::{identifier, point, quantity, rotation, size, size3};
use crate::schema::Kind;
use crate::table::{Setting, choices, table};
use microsim_vocabulary::Finish;
use microsim_vocabulary::{Unit, terms};
use serde::{Deserialize, Serialize};

/// An obstacle: a rigid object that stands.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "RigidFile", into = "RigidFile")]
pub struct Rigid {
    /// Its name.
    pub name: String,
    /// Form and size.
    pub shape: RigidShape,
    /// Of its centre \[m\].
    pub position: [f64; 3],
    /// Rotation x, y, z, w from its own frame.
    pub orientation: [f64; 4],
    /// Colour.
    pub colour: Colour,
    /// How its surface answers light.
    pub finish: Finish,
}

/// Form and size of an obstacle in its own frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RigidShape {
    /// Everything below z = 0.
    Plane,
    /// A box along its axes.
    Box {
        /// Half of each side \[m\].
        half_size: [f64; 3],
        /// Radius of its edges and corners, within the box \[m\].
        rounding: f64,
    },
    /// A floor and four walls around an inner space that is open towards +z.
    Tray {
        /// Half of each side of the inner space \[m\].
        half_size: [f64; 3],
        /// Thickness of floor and walls \[m\].
        wall: f64,
        /// Radius of the edges of floor and walls \[m\].
        rounding: f64,
    },
    /// Two equal plates that face each other along x.
    Clamp {
        /// Half of each side of a plate \[m\].
        half_size: [f64; 3],
        /// Between the plates \[m\].
        gap: f64,
        /// Radius of the edges of the plates \[m\].
        rounding: f64,
    },
    /// A solid cylinder along z.
    Cylinder {
        /// \[m\]
        radius: f64,
        /// From end to end \[m\].
        length: f64,
    },
}

impl RigidShape {
    /// The solid parts of which it is made: one, or several where it is hollow.
    pub fn parts(&self) -> Vec<RigidPart> {
        let cuboid = |half_size, rounding, centre| RigidPart {
            solid: Solid::Cuboid {
                half_size,
                rounding,
            },
            centre,
        };
        match *self {
            Self::Plane => vec![RigidPart {
                solid: Solid::HalfSpace,
                centre: [0.0; 3],
            }],
            Self::Box {
                half_size,
                rounding,
            } => vec![cuboid(half_size, rounding, [0.0; 3])],
            Self::Tray {
                half_size: [x, y, z],
                wall,
                rounding,
            } => {
                let half = 0.5 * wall;
                let (outer_x, outer_y) = (x + wall, y + wall);
                // Walls stand on the floor's level, so that no edge lies in the path along the floor.
                vec![
                    cuboid([outer_x, outer_y, half], rounding, [0.0, 0.0, -z - half]),
                    cuboid([half, outer_y, z + half], rounding, [x + half, 0.0, -half]),
                    cuboid([half, outer_y, z + half], rounding, [-x - half, 0.0, -half]),
                    cuboid([outer_x, half, z + half], rounding, [0.0, y + half, -half]),
                    cuboid([outer_x, half, z + half], rounding, [0.0, -y - half, -half]),
                ]
            }
            Self::Clamp {
                half_size,
                gap,
                rounding,
            } => {
                let x = 0.5 * gap + half_size[0];
                vec![
                    cuboid(half_size, rounding, [x, 0.0, 0.0]),
                    cuboid(half_size, rounding, [-x, 0.0, 0.0]),
                ]
            }
            Self::Cylinder { radius, length } => vec![RigidPart {
                solid: Solid::Cylinder { radius, length },
                centre: [0.0; 3],
            }],
        }
    }
}

/// A solid part of an obstacle, turned as it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigidPart {
    /// Form and size.
    pub solid: Solid,
    /// Origin of the form in the frame of the obstacle \[m\].
    pub centre: [f64; 3],
}

/// Form and size of a solid part, about its origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Solid {
    /// Everything below z = 0.
    HalfSpace,
    /// A box along the axes.
    Cuboid {
        /// Half of each side \[m\].
        half_size: [f64; 3],
        /// Radius of its edges and corners, within the box \[m\].
        rounding: f64,
    },
    /// A cylinder along z.
    Cylinder {
        /// \[m\]
        radius: f64,
        /// From end to end \[m\].
        length: f64,
    },
}

terms! {
    /// Forms of obstacles.
    pub(crate) enum RigidName {
        /// Everything below z = 0.
        Plane = "plane",
        /// A box along its axes.
        Box = "box",
        /// A floor and four walls.
        Tray = "tray",
        /// Two plates that face each other.
        Clamp = "clamp",
        /// A cylinder along z.
        Cylinder = "cylinder",
    }
}

choices!(RigidName);

table! {
    /// An obstacle as the file has it: the sizes that its shape needs are checked before.
    pub(crate) struct RigidFile {
        /// Its name.
        name: String = identifier(),
        /// Its form, in its own frame: a `plane` with everything below z = 0, a `box`, a `tray` that is open towards
        /// +z, a `clamp` of two plates that face each other along x, a `cylinder` along z.
        shape: RigidName,
        /// Half of each side \[m\]: of a box, of the inner space of a tray, of a plate of a clamp, and only there.
        half_size: Option<[f64; 3]> = size3(),
        /// Radius of the edges of a box, tray or clamp, and only there \[m\]; 0 if left out.
        rounding: Option<f64> = quantity(Unit::Length, 0.0, 1.0),
        /// Thickness of floor and walls of a tray, and only there \[m\].
        wall: Option<f64> = size(),
        /// Between the plates of a clamp, and only there \[m\].
        gap: Option<f64> = size(),
        /// Of a cylinder, and only there \[m\].
        radius: Option<f64> = size(),
        /// Of a cylinder, and only there \[m\].
        length: Option<f64> = size(),
        /// Of its centre \[m\].
        position: [f64; 3] = point() => [0.0, 0.0, 0.0],
        /// Rotation [x, y, z, w] from its own frame.
        orientation: [f64; 4] = rotation() => [0.0, 0.0, 0.0, 1.0],
        /// Colour, sRGB.
        colour: Colour => "#9aa4ae",
        /// How its surface answers light.
        finish: Finish => "matte",
    }
}

impl Setting for Rigid {
    fn kind() -> Kind {
        RigidFile::kind()
    }
}

impl TryFrom<RigidFile> for Rigid {
    type Error = String;

    fn try_from(file: RigidFile) -> Result<Self, String> {
        let rounding = file.rounding.unwrap_or(0.0);
        let sizes = (
            file.half_size,
            file.wall,
            file.gap,
            file.radius,
            file.length,
        );
        let shape = match (file.shape, sizes) {
            (RigidName::Plane, (None, None, None, None, None)) => RigidShape::Plane,
            (RigidName::Box, (Some(half_size), None, None, None, None)) => RigidShape::Box {
                half_size,
                rounding,
            },
            (RigidName::Tray, (Some(half_size), Some(wall), None, None, None)) => {
                RigidShape::Tray {
                    half_size,
                    wall,
                    rounding,
                }
            }
            (RigidName::Clamp, (Some(half_size), None, Some(gap), None, None)) => {
                RigidShape::Clamp {
                    half_size,
                    gap,
                    rounding,
                }
            }
            (RigidName::Cylinder, (None, None, None, Some(radius), Some(length))) => {
                RigidShape::Cylinder { radius, length }
            }
            _ => {
                return Err(format!(
                    "sizes of `{}` that do not fit its shape",
                    file.name
                ));
            }
        };
        Ok(Rigid {
            name: file.name,
            shape,
            position: file.position,
            orientation: file.orientation,
            colour: file.colour,
            finish: file.finish,
        })
    }
}

impl From<Rigid> for RigidFile {
    fn from(rigid: Rigid) -> Self {
        let mut file = Self {
            name: rigid.name,
            shape: RigidName::Plane,
            half_size: None,
            rounding: None,
            wall: None,
            gap: None,
            radius: None,
            length: None,
            position: rigid.position,
            orientation: rigid.orientation,
            colour: rigid.colour,
            finish: rigid.finish,
        };
        file.shape = match rigid.shape {
            RigidShape::Plane => RigidName::Plane,
            RigidShape::Box {
                half_size,
                rounding,
            } => {
                (file.half_size, file.rounding) = (Some(half_size), Some(rounding));
                RigidName::Box
            }
            RigidShape::Tray {
                half_size,
                wall,
                rounding,
            } => {
                (file.half_size, file.rounding) = (Some(half_size), Some(rounding));
                file.wall = Some(wall);
                RigidName::Tray
            }
            RigidShape::Clamp {
                half_size,
                gap,
                rounding,
            } => {
                (file.half_size, file.rounding) = (Some(half_size), Some(rounding));
                file.gap = Some(gap);
                RigidName::Clamp
            }
            RigidShape::Cylinder { radius, length } => {
                (file.radius, file.length) = (Some(radius), Some(length));
                RigidName::Cylinder
            }
        };
        file
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A tray's inner space is free of all its parts and enclosed by them but from above: points just within and just beyond each
    /// face, which its definition gives.
    #[test]
    fn a_tray_encloses_its_inner_space() {
        let ([x, y, z], wall) = ([4.0, 3.0, 1.0], 0.5);
        let tray = RigidShape::Tray {
            half_size: [x, y, z],
            wall,
            rounding: 0.2,
        };
        let solid = |p: [f64; 3]| {
            tray.parts().iter().any(|part| {
                let Solid::Cuboid { half_size, .. } = part.solid else {
                    panic!("{:?}", part.solid);
                };
                (0..3).all(|k| (p[k] - part.centre[k]).abs() <= half_size[k])
            })
        };
        let little = 0.01;
        for (axis, half) in [(0, x), (1, y), (2, z)] {
            for side in [-1.0, 1.0] {
                let at = |distance: f64| {
                    let mut p = [0.0; 3];
                    p[axis] = side * distance;
                    p
                };
                let open = axis == 2 && side > 0.0;
                assert!(!solid(at(half - little)));
                assert_eq!(solid(at(half + little)), !open);
                assert_eq!(solid(at(half + wall - little)), !open);
                assert!(!solid(at(half + wall + little)));
            }
        }
    }
}
