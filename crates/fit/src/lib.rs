//! Constants of a material law from measured stretches and stresses, with intervals of confidence.
//!
//! [`Measurements`] are read from a table, [`fit()`] looks for the constants of a law of [`microsim_tissue::law`] that reproduce them best,
//! and gives with each its interval of confidence, or that the data do not determine it. Every law that the crate `tissue` has can be fitted:
//! its constants come from [`LawName::parameters`](microsim_settings::LawName::parameters), their ranges from the keys of materials.
//!
//! Each specimen is in a homogeneous state ([`homogeneous_state`]): stretched along axes 1 and 2, free of stress along 3 and along the axis
//! whose stretch is not given. Fibres lie in the plane of 1 and 2. What is not here: files, and the printing of results.

#![forbid(unsafe_code)]

mod confidence;
mod constant;
mod estimate;
mod homogeneous;
mod measurements;
mod model;
mod search;
mod snippet;

pub use constant::{ANGLE, ASSUMED_POISSON, Constant, ConstantError, constants, rounded};
pub use estimate::{Determination, Estimate, Fit, FitError, Goodness, fit};
pub use homogeneous::{HomogeneousState, homogeneous_state};
pub use measurements::{Measurement, Measurements, StressMeasure, TableError};
pub use model::LawModel;
pub use snippet::material_toml;
