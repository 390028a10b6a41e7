//! Material laws of a continuum: energy density, stress, tangent as functions of the deformation gradient.
//!
//! A law is a type of its own with constants of its own. All of them fulfil one contract, which is tested: at rest no energy and no
//! stress, stress = gradient of the energy, tangent = derivative of the stress, no change under rotation, small strains as the
//! constants' [`Elasticity`] states, and a split of the energy in two parts that can be integrated over different domains. Every law
//! is finite for every F, inverted or collapsed, so that a solver can come back from there.
//!
//! | law | constants beside E and ν |
//! |---|---|
//! | [`StVenantKirchhoff`], [`NeoHookean`], [`Corotational`], [`StableNeoHookean`], [`NeoHookeanPolynomial`] | – |
//! | [`MooneyRivlin`] | [`MooneyRivlinParameters`] |
//! | [`TransverselyIsotropic`] | [`FibreParameters`], and a fibre direction in each element of the mesh |
//!
//! # E and ν
//! Every law has a Young's modulus E and a Poisson's ratio ν: those at small strain, for a law with fibres those of its matrix. All
//! stresses are in proportion to E. What goes by stiffness (bounds of the step, mass floors, damping) takes the whole small-strain
//! elasticity, fibres included; what goes by near-incompressibility (locking) takes ν.
//!
//! # A new law
//! A file beside these with a type that implements [`Law`], its constants ([`Constants`]) and what it is given beside E and ν
//! ([`Parameters`]); a test that calls the contract; its module and its re-export in this file, and its line in `laws!` in `law/choice.rs`. What a file
//! calls it and its parameters stands in [`LawName`]; range and meaning of a parameter's key in `settings::Material`. From there on every
//! discretisation, integrator, file and comparison has it.

mod choice;
mod constants;
#[cfg(test)]
mod contract;
mod corotational;
pub mod decomposition;
mod definition;
mod elasticity;
mod invariants;
mod isotropic;
mod mooney_rivlin;
mod neo_hookean;
mod neo_hookean_polynomial;
mod principal;
mod st_venant_kirchhoff;
mod stable_neo_hookean;
mod transversely_isotropic;
pub mod viscosity;
mod volume;

pub use choice::MaterialLaw;
pub(crate) use choice::with_law;
pub use constants::{Constants, Parameters};
pub use corotational::Corotational;
pub use definition::Law;
pub use elasticity::{Elasticity, Lame, Matrix9};
pub use isotropic::IsotropicLaw;
pub use microsim_vocabulary::LawName;
pub use mooney_rivlin::{MooneyRivlin, MooneyRivlinConstants, MooneyRivlinParameters};
pub use neo_hookean::NeoHookean;
pub use neo_hookean_polynomial::NeoHookeanPolynomial;
pub use principal::PrincipalTangent;
pub use st_venant_kirchhoff::StVenantKirchhoff;
pub use stable_neo_hookean::StableNeoHookean;
pub use transversely_isotropic::{FibreConstants, FibreParameters, TransverselyIsotropic};
