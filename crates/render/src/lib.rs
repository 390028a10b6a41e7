//! Pictures of a scene as seen through an operating microscope.
//!
//! A [`Picture`] is a plain list of shaped, placed and coloured [`Item`]s, bodies of [`Tissue`] and a [`View`]; a [`Renderer`] draws it into a texture
//! ([`Renderer::render`], which does not wait) and to memory ([`Renderer::read_back`]). [`snapshot`] makes a picture of what a tick publishes. Who calls it: the renderer
//! plugin, windows, tests and examples, each with one renderer per thread.
//!
//! What is drawn: surfaces lit by the microscope's coaxial light and one oblique key light whose shadows make height readable
//! (see [`key_light_direction`]), matte, moist, metal, or layers of tissue; instruments as models ([`instruments`]); the round field, black outside; for one eye or for two
//! ([`Stereo`]). [`Quality`] decides how much is done for it. Not here: windows, text but for the caption of a finished picture, model and texture files. Drawing reads the picture and changes nothing else, so nothing of a
//! simulation can depend on it.
//!
//! Light: a matte surface shows its colour where all lamps reach it. What shines (moist, metal, tissue) has no upper limit; its brightness above 0.65 is compressed towards 1
//! before the samples of a pixel are averaged, so that the edges of highlights stay smooth.
//!
//! Frames: a picture is in the **field frame** of the caller, in metres; the **view frame** has its origin in the focus
//! point, x to the right and y up in the picture, z towards the eye, and the radius of the field as its unit, so that no
//! number in here depends on whether a vessel or a hand is looked at.
//!
//! The same picture drawn twice by one renderer has the same bytes; another driver may differ in single pixels.

#![forbid(unsafe_code)]

mod batch;
mod bodies;
mod caption;
mod colour_map;
pub mod debug;
mod display;
mod error;
mod family;
mod fields;
mod frame;
mod image;
pub mod instrument_file;
pub mod instruments;
mod layouts;
mod legend;
mod light;
mod loft;
mod mesh;
mod models;
mod picture;
mod pipelines;
mod proposal;
mod quality;
mod renderer;
mod shape;
pub mod snapshot;
mod stereo;
mod store;
mod targets;
mod tessellate;
#[cfg(test)]
mod testing;
mod textures;
mod tissue;
mod uniforms;
mod upload;
mod wall;

pub use colour_map::colour_of;
pub use display::CREASE;
pub use error::RenderError;
pub use fields::{Fields, surfaces};
pub use image::Image;
pub use legend::{Legend, LegendWords};
pub use light::{KEY_LIGHT_AZIMUTH, KEY_LIGHT_ZENITH, SHADOW_LEVEL, key_light_direction};
pub use microsim_vocabulary::Finish;
pub use models::Models;
pub use picture::{DRAPE, Item, Pattern, Picture, View};
pub use proposal::Proposal;
pub use quality::Quality;
pub use renderer::Renderer;
pub use shape::{Model, Shape};
pub use stereo::{STEREO_BASE, Stereo, StereoLayout};
pub use tissue::Tissue;
