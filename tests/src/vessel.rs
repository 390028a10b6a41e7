//! Vessels in one dimension: thick-walled tubes of several layers under pressure, axial force and residual stress, solved without elements.
//!
//! What elements compute in three dimensions is here an ordinary differential equation through the wall, so that these numbers are an
//! independent expectation. Nothing of the crate `tissue` is used for a law or a balance.
//!
//! - [`wall`]: the material of a layer, its energy and stresses in the directions r, θ, z;
//! - [`carotid`]: the rabbit's carotid artery of the literature;
//! - [`layers`]: the layers of a tube in their natural states;
//! - [`radial`]: the balance of forces along the radius, compressible;
//! - [`tube`]: a tube at given pressure with given axial stretch or force, or slit along its axis;
//! - [`incompressible`]: the closed tube of incompressible layers, by integrals alone;
//! - [`newton`]: roots of functions of one and of a few unknowns.

pub mod carotid;
pub mod flattened_ring;
pub mod incompressible;
pub mod layers;
pub mod newton;
pub mod radial;
pub mod tube;
pub mod wall;
