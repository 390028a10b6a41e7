//! Pictures of a scene as seen through an operating microscope, drawn into memory.
//!
//! A [`Picture`] is a plain list of shaped, placed and coloured [`Item`]s and a [`View`]; a [`Renderer`] turns it into an
//! [`Image`]. Who calls it: the renderer plugin, tests and examples, each with one renderer per thread.
//!
//! What is drawn: surfaces lit by the microscope's coaxial light and one oblique key light whose shadows make height readable
//! (see [`key_light_direction`]), matte, moist or metal; the round field, black outside. Not here: windows, text, stereo,
//! depth of field, model and texture files. Drawing reads the picture and changes nothing else, so nothing of a simulation
//! can depend on it.
//!
//! Frames: a picture is in the **field frame** of the caller, in metres; the **view frame** has its origin in the focus
//! point, x to the right and y up in the picture, z towards the eye, and the radius of the field as its unit, so that no
//! number in here depends on whether a vessel or a hand is looked at.
//!
//! The same picture drawn twice by one renderer has the same bytes; another driver may differ in single pixels.

#![forbid(unsafe_code)]

mod error;
mod image;
mod light;
mod models;
mod picture;
mod pipelines;
mod renderer;
pub mod snapshot;
mod surface;
mod targets;
#[cfg(test)]
mod testing;
mod upload;

pub use error::RenderError;
pub use image::Image;
pub use light::{KEY_LIGHT_AZIMUTH, KEY_LIGHT_ZENITH, SHADOW_LEVEL, key_light_direction};
pub use microsim_vocabulary::Finish;
pub use models::Models;
pub use picture::{DRAPE, Item, Picture, Shape, View};
pub use renderer::Renderer;
