//! The stresses that a law predicts for measured stretches.

use crate::constant::{ANGLE, Constant, constants};
use crate::homogeneous::homogeneous_state;
use crate::measurements::{Measurements, StressMeasure};
use microsim_settings::LawName;
use microsim_tissue::law::{Lame, MaterialLaw};
use nalgebra::{Matrix3, Vector3};

/// A law whose constants are looked for.
#[derive(Clone, Debug, PartialEq)]
pub struct LawModel {
    law: LawName,
    constants: Vec<Constant>,
}

impl LawModel {
    /// A law by its name.
    pub fn new(law: LawName) -> Self {
        Self {
            law,
            constants: constants(law),
        }
    }

    /// Its name.
    pub fn law(&self) -> LawName {
        self.law
    }

    /// Its constants, in the order in which values of them stand.
    pub fn constants(&self) -> &[Constant] {
        &self.constants
    }

    /// The stresses \[Pa\] in the place of those of `data`, row by row. `None` if a value is out of range, or a specimen has no homogeneous
    /// state.
    pub fn stresses(&self, values: &[f64], data: &Measurements) -> Option<Vec<f64>> {
        let in_range =
            |(constant, value): (&Constant, &f64)| (constant.min..=constant.max).contains(value);
        if !self.constants.iter().zip(values).all(in_range) {
            return None;
        }
        let value = |key: &str| {
            let index = self
                .constants
                .iter()
                .position(|constant| constant.key == key);
            index.map(|index| values[index])
        };
        let (young, poisson) = (value("youngs_modulus")?, value("poisson_ratio")?);
        let law = MaterialLaw::read(self.law, &|key| value(key).ok_or(())).ok()?;
        law.check(poisson).ok()?;
        let lame = Lame::from_young_poisson(young, poisson);
        let (sine, cosine) = libm::sincos(value(ANGLE).unwrap_or(0.0));
        // A second family lies at the opposite angle; a law of one ignores it.
        let directions = [sine, -sine].map(|sine| Vector3::new(cosine, sine, 0.0));
        let stress = |f: &Matrix3<f64>| law.stress(f, &lame, directions);
        let mut stresses = Vec::new();
        for row in &data.rows {
            let state = homogeneous_state(&stress, row.stretch, young)?;
            let predicted = match data.measure {
                StressMeasure::Cauchy => state.cauchy(),
                StressMeasure::Piola => state.piola,
            };
            let measured = (0..2).filter(|axis| row.stress[*axis].is_some());
            stresses.extend(measured.map(|axis| predicted[axis]));
        }
        stresses.iter().all(|s| s.is_finite()).then_some(stresses)
    }
}
