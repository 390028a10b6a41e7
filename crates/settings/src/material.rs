//! What bodies are made of: a law with its constants for each region.

use crate::kinds::{dependent, direction, point, quantity, ratio, time};
use crate::schema::Kind;
use crate::table::{Setting, Table, choices, table};
use microsim_vocabulary::{Discretisation, LawName, Unit, terms};
use serde::{Deserialize, Serialize};
use std::f64::consts::FRAC_PI_2;

table! {
    /// What a region is made of; the checks see to it that what each law needs is there, and nothing else.
    #[derive(Copy)]
    pub struct Material {
        /// Region of the mesh; all that no other material names if left out.
        region: Option<u32>,
        /// Mass per volume \[kg/m³\].
        density: f64 = quantity(Unit::Density, 1.0, 20_000.0),
        /// `springs` along edges with area and volume forces, or a law of a continuum.
        law: Law,
        /// Strain across a plane, of shreds of a cut their largest one, at which it tears by itself; without it never.
        tear_strain: Option<f64> = quantity(Unit::Ratio, 0.01, 100.0),
        /// Kelvin-Voigt damping \[s\]: a strain rate resists as that strain times this time.
        relaxation_time: Option<f64> = time(0.0, 600.0),
        /// Kelvin-Voigt damping in uniaxial stretch, instead of `relaxation_time` (their ratio is the modulus) \[Pa
        /// s\].
        viscosity: Option<f64> = quantity(Unit::Viscosity, 0.0, 1e9),
        /// Young's modulus of a continuum, or that springs are `fitted` to \[Pa\].
        youngs_modulus: Option<f64> = modulus(1.0),
        /// Poisson's ratio of a continuum, or that springs are `fitted` to; below 0.5, which is incompressible.
        poisson_ratio: Option<f64> = quantity(Unit::Ratio, -0.99, 0.4999),
        /// Of `mooney-rivlin`: c01/(c10 + c01), where E = 4 (1 + nu) (c10 + c01). Poisson's ratio is at least r/(1 + 2 r) with
        /// this r.
        c01_fraction: Option<f64> = ratio(1.0),
        /// Of `transversely-isotropic`: Young's modulus along the fibres over `youngs_modulus`, which is that of their matrix.
        fibre_ratio: Option<f64> = quantity(Unit::Ratio, 1.0, 1e4),
        /// Of `holzapfel-gasser-ogden`: k1 of each of its two families of fibres \[Pa\].
        fibre_stiffness: Option<f64> = modulus(0.0),
        /// Of `holzapfel-gasser-ogden`: k2, how fast fibres stiffen: the stress of a family grows with exp(k2 E^2), E the square of its
        /// stretch less one.
        fibre_exponent: Option<f64> = quantity(Unit::Ratio, 0.0, 1e4),
        /// Of `holzapfel-gasser-ogden`: dispersion kappa of each family, from 0, all along one direction, to 1/3, no direction.
        fibre_dispersion: Option<f64> = quantity(Unit::Ratio, 0.0, 1.0 / 3.0),
        /// Of laws with fibres: their directions in the natural state; those of the mesh file (cell data `fibre_direction` and, of a second family,
        /// `fibre_direction_2`) if left out.
        fibres: Option<Fibres>,
        /// How the mesh carries a continuum; `tetrahedra` if left out. From a Poisson's ratio of 0.4 on, `selective`,
        /// `patch-pressure` or `nodal-pressure` keep it from locking. What is not cut may have `quadratic` or `quadratic-pressure`
        /// tetrahedra on far fewer cells, which are then refined once.
        discretisation: Option<Discretisation>,
        /// What the constants of springs mean: `scaled` moduli (if left out), `plain` constants of equations 4.1 and
        /// 4.2, `normalised` ones of 3.5 to 3.8, or moduli `fitted` to Young's.
        form: Option<SpringForm>,
        /// Of `scaled` springs, against a change of length \[Pa\].
        stretch_modulus: Option<f64> = modulus(0.0),
        /// Of `scaled` springs, against a change of area \[Pa\].
        area_modulus: Option<f64> = modulus(0.0),
        /// Of `scaled` springs, against a change of volume \[Pa\].
        volume_modulus: Option<f64> = modulus(0.0),
        /// Of `plain` or `normalised` springs: stiffness of each edge.
        length_stiffness: Option<f64> = constant(Unit::LengthStiffness, Unit::Energy),
        /// Of `plain` or `normalised` springs: stiffness of each triangle.
        area_stiffness: Option<f64> = constant(Unit::AreaStiffness, Unit::Energy),
        /// Of `plain` or `normalised` springs: stiffness of each tetrahedron.
        volume_stiffness: Option<f64> = constant(Unit::VolumeStiffness, Unit::Energy),
        /// Of `plain` or `normalised` springs: damping of each edge.
        length_damping: Option<f64> = constant(Unit::LengthDamping, Unit::Action),
        /// Of `plain` or `normalised` springs: damping of each triangle.
        area_damping: Option<f64> = constant(Unit::AreaDamping, Unit::Action),
        /// Of `plain` or `normalised` springs: damping of each tetrahedron.
        volume_damping: Option<f64> = constant(Unit::VolumeDamping, Unit::Action),
        /// Plastic flow: of rest values of springs, or of the shape of a continuum, which has no volume.
        plasticity: Option<Plasticity>,
    }
}

impl Material {
    /// What a law is given beside E and ν, by its key ([`LawName::parameters`]).
    pub fn parameter(&self, key: &str) -> Option<f64> {
        match key {
            "c01_fraction" => self.c01_fraction,
            "fibre_ratio" => self.fibre_ratio,
            "fibre_stiffness" => self.fibre_stiffness,
            "fibre_exponent" => self.fibre_exponent,
            "fibre_dispersion" => self.fibre_dispersion,
            _ => None,
        }
    }

    /// Unit of the number at a key, and its smallest and largest value in SI; `None` where there is no number.
    pub fn range(key: &str) -> Option<(Unit, f64, f64)> {
        let keys = <Self as Table>::keys();
        match keys.into_iter().find(|known| known.name == key)?.kind {
            Kind::Quantity { unit, min, max } => Some((unit, min, max)),
            _ => None,
        }
    }
}

table! {
    /// Fibre directions in the natural state, in the body's frame: the same for all elements, or at an angle to the circles around an axis.
    #[derive(Copy)]
    pub struct Fibres {
        /// The same direction everywhere.
        direction: Option<[f64; 3]> = direction(),
        /// Beside it: that of the second family, of laws that have two.
        second_direction: Option<[f64; 3]> = direction(),
        /// Instead: angle \[rad\] to the circles around an axis. 0 is around it, 90 deg along it; a helix turns right-handed
        /// about the outward normal. A second family lies at the opposite angle.
        angle: Option<f64> = quantity(Unit::Angle, -FRAC_PI_2, FRAC_PI_2),
        /// Direction of that axis; the tube's if left out.
        axis: Option<[f64; 3]> = direction(),
        /// A point of that axis in the body's frame \[m\]; its origin if left out.
        point: Option<[f64; 3]> = point(),
    }
}

/// The law of a material.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "&'static str")]
pub enum Law {
    /// Springs along the edges, and area and volume forces (4.1, 4.2).
    Springs,
    /// A continuum.
    Continuum(LawName),
}

impl Law {
    /// All, springs first.
    pub fn all() -> impl Iterator<Item = Self> {
        std::iter::once(Self::Springs).chain(LawName::ALL.map(Self::Continuum))
    }

    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Springs => "springs",
            Self::Continuum(law) => law.name(),
        }
    }
}

impl TryFrom<String> for Law {
    type Error = String;

    fn try_from(name: String) -> Result<Self, String> {
        let mut all = Self::all();
        all.find(|law| law.name() == name)
            .ok_or_else(|| format!("`{name}` is no law"))
    }
}

impl From<Law> for &'static str {
    fn from(law: Law) -> Self {
        law.name()
    }
}

terms! {
    /// What the constants of springs mean.
    pub enum SpringForm {
        /// Moduli, scaled with the elements: the same body on any mesh.
        Scaled = "scaled",
        /// Constants of each element, equations 4.1 and 4.2.
        Plain = "plain",
        /// Constants of each element for relative changes, equations 3.5 to 3.8.
        Normalised = "normalised",
        /// Moduli fitted to Young's modulus and Poisson's ratio.
        Fitted = "fitted",
    }
}

table! {
    /// Plastic flow (4.2, dilatation).
    #[derive(Copy)]
    pub struct Plasticity {
        /// Strain from which on the rest size flows; of a continuum the equivalent logarithmic elastic strain, that along a uniaxial stretch
        /// at constant volume, from the natural state: above that of a residual state.
        yield_strain: f64 = ratio(100.0),
        /// Of a continuum: growth of that strain per plastic strain.
        yield_growth: Option<f64> = ratio(1e6),
        /// Rate of the flow \[1/s\]; the flow of a continuum takes no time if it is left out.
        creep_rate: Option<f64> = quantity(Unit::Rate, 0.0, 1e6),
        /// Largest plastic strain, of a continuum summed up over its flow.
        max_strain: f64 = ratio(100.0),
        /// Growth of the stiffness per plastic strain, of a continuum that against a change of shape.
        hardening: f64 = ratio(1e6) => 0.0,
        /// Largest factor of the stiffness.
        max_stiffening: f64 = quantity(Unit::Ratio, 1.0, 1e6) => 1.0,
    }
}

choices!(SpringForm);

impl Setting for Law {
    fn kind() -> Kind {
        Kind::Choice(Law::all().map(|law| law.name().to_owned()).collect())
    }
}

/// A modulus \[Pa\].
fn modulus(min: f64) -> Kind {
    quantity(Unit::Pressure, min, 1e11)
}

/// A constant of springs, whose unit their form decides.
fn constant(plain: Unit, normalised: Unit) -> Kind {
    let (plain, normalised) = (plain.symbol(), normalised.symbol());
    dependent(&format!(
        "a constant in {plain} (`plain`) or {normalised} (`normalised`)"
    ))
}
