//! A ring of the level that marked tissue is brought into.

use super::distance;
use crate::fault::Fault;
use microsim_settings::{Object, Shape};

/// The opening of an object of the shape `ring`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ring {
    /// \[m\]
    pub centre: [f64; 3],
    /// Radius of its opening \[m\].
    pub opening: f64,
}

impl Ring {
    /// The ring of this name. A fault where there is none.
    pub fn named(objects: &[Object], name: &str) -> Result<Self, Fault> {
        let object = objects.iter().find(|object| object.name == name);
        match object.map(|object| (object.position, object.shape.clone())) {
            Some((centre, Shape::Ring { radius, tube })) => Ok(Self {
                centre,
                opening: radius - tube,
            }),
            _ => Err(Fault::new(format!(
                "the level needs an [[object]] \"{name}\" of the shape \"ring\""
            ))),
        }
    }

    /// Distance of a place from its middle \[m\].
    pub fn away(&self, place: [f64; 3]) -> f64 {
        distance(place, self.centre)
    }
}
