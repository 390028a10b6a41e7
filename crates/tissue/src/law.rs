//! Material laws of a continuum: energy density, stress, tangent as functions of the deformation gradient.
//!
//! A [`Law`] is a type without data; what it computes with are its [`Constants`]. All laws fulfil one contract, which is tested: at rest no
//! energy and no stress, stress = gradient of the energy, tangent = derivative of the stress, no change under rotation, small strains as
//! the constants' [`Elasticity`] states, and a [split](Constants::split) of the energy into two parts that can be integrated over
//! different domains. Every law is finite for every F, inverted or collapsed, so that a solver can recover from there.
//! [`MaterialLaw`] is a law as data, for models, files and comparisons.
//!
//! | law | parameters beside E and ν |
//! |---|---|
//! | [`StVenantKirchhoff`], [`NeoHookean`], [`Corotational`], [`StableNeoHookean`], [`NeoHookeanPolynomial`] | – |
//! | [`MooneyRivlin`] | [`MooneyRivlinParameters`] |
//! | [`TransverselyIsotropic`] | [`FibreParameters`], and a fibre direction in each element of the mesh |
//! | [`HolzapfelGasserOgden`], [`HolzapfelGasserOgdenIsochoric`] | [`HolzapfelParameters`], and two fibre directions |
//!
//! # E and ν
//! Every law has a Young's modulus E and a Poisson's ratio ν: those at small strain, for a law with fibres those of its matrix. All
//! stresses are in proportion to E, but those of fibres with moduli of their own. What goes by stiffness (bounds of the step, mass floors, damping) takes the whole small-strain
//! elasticity, fibres included; what goes by near-incompressibility (locking) takes ν.
//!
//! # A new law
//! A complete law with a parameter is the example of [`Law`](Law#a-law-of-ones-own). In the crate it takes:
//!
//! 1. `crates/tissue/src/law/NAME.rs`: a unit struct, documented with Ψ(F), source and limitations, that implements [`Law`], and
//!    [`IsotropicLaw`] unless it has a direction. A law of μ and λ alone has [`Lame`] for its constants and `()` for its parameters; any
//!    other has types of its own that implement [`Constants`] and [`Parameters`]. The derivatives of Ψ = a(tr FᵀF) + b(J) are in
//!    `law/invariants.rs`, a logarithm of J that stays finite in `law/volume.rs`, what is positive of a tangent in principal axes in
//!    `law/principal.rs`. Transcendental functions are those of the `libm` crate, so that
//!    every machine gives the same bits.
//! 2. In the same file tests: `contract::check_isotropic::<NAME>()` (`contract::check` with a direction), and closed forms.
//! 3. `law.rs`: the module and its `pub use`; `law/choice.rs`: a line in the list `laws!`.
//! 4. `crates/vocabulary/src/mechanics.rs`: a [`LawName`] with the name in files, and in [`LawName::parameters`] the key and unit of each
//!    parameter.
//! 5. For each parameter `crates/settings/src/material.rs`: its key with range and meaning, and a line in `Material::parameter`.
//! 6. `config/chart.toml`: a `[[material]]` with the law, in the sweeps that are to compare it.
//!
//! Files and functions without a path are in `crates/tissue/src/law/`. Every discretisation, integrator and scene can then use it. `cargo test -p microsim-vocabulary -p microsim-tissue -p microsim-settings`
//! checks it.

mod choice;
mod constants;
#[cfg(test)]
mod contract;
mod corotational;
pub mod decomposition;
mod definition;
mod elasticity;
mod exponential;
mod holzapfel;
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
pub(crate) use constants::FourFamilies;
pub use constants::{Constants, Parameters};
pub use corotational::Corotational;
pub use definition::Law;
pub(crate) use definition::positive_principal_tangents;
pub use elasticity::{Elasticity, Family, Lame, Matrix9};
pub use holzapfel::{
    HolzapfelConstants, HolzapfelGasserOgden, HolzapfelGasserOgdenIsochoric, HolzapfelParameters,
};
pub use isotropic::IsotropicLaw;
pub use microsim_vocabulary::LawName;
pub use mooney_rivlin::{MooneyRivlin, MooneyRivlinConstants, MooneyRivlinParameters};
pub use neo_hookean::NeoHookean;
pub use neo_hookean_polynomial::NeoHookeanPolynomial;
pub(crate) use principal::FourPrincipalTangents;
pub use principal::PrincipalTangent;
pub use st_venant_kirchhoff::StVenantKirchhoff;
pub use stable_neo_hookean::StableNeoHookean;
pub use transversely_isotropic::{FibreConstants, FibreParameters, TransverselyIsotropic};
