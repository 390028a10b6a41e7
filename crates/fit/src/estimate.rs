//! The fit of a law: its constants with how well the data determine them, and how well the law reproduces the data.

use crate::confidence::Confidence;
use crate::constant::{ASSUMED_POISSON, Constant, rounded};
use crate::measurements::Measurements;
use crate::model::LawModel;
use crate::search::{Minimum, Search, root_mean_square};
use microsim_settings::LawName;
use nalgebra::DMatrix;
use std::fmt;

/// Fewest stresses beyond the number of free constants: with fewer, intervals of confidence mean nothing.
const FREEDOM: usize = 3;
/// Difference of a constant, relative to it, for derivatives.
const DIFFERENCE: f64 = 1e-5;
/// Searches whose residuals differ by less than this, relative to the size of the data, ended at fits that are equally good.
const EQUAL: f64 = 1e-6;
/// Relative difference of a constant from which on two fits are different ones.
const DIFFERENT: f64 = 0.01;
/// Correlation from which on data determine a combination of two constants rather than each.
const CORRELATED: f64 = 0.98;

/// Where the value of a constant is from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Determination {
    /// It was given.
    Fixed,
    /// It was not given and is not fitted: Poisson's ratio.
    Assumed,
    /// Fitted: half of the interval of confidence of 95 % about it, in its unit. Of 100 tables of such data 95 have intervals that hold the
    /// constant.
    Within(f64),
    /// Fitted, and at a bound of its range.
    AtBound,
    /// The data do not determine it.
    Undetermined,
}

impl Determination {
    /// In a word or two.
    pub fn name(self) -> &'static str {
        match self {
            Self::Fixed => "given",
            Self::Assumed => "assumed",
            Self::Within(_) => "fitted",
            Self::AtBound => "at a bound",
            Self::Undetermined => "not determined",
        }
    }
}

/// A constant of a law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Which one.
    pub constant: Constant,
    /// In SI.
    pub value: f64,
    /// How well it is known.
    pub determination: Determination,
}

/// How well a law reproduces stresses.
#[derive(Clone, Debug, PartialEq)]
pub struct Goodness {
    /// Which test; none for all of them together.
    pub protocol: Option<String>,
    /// Number of stresses.
    pub count: usize,
    /// Root mean square of the residuals \[Pa\].
    pub rms: f64,
    /// R² = 1 − Σ residual²/Σ (stress − mean)²; `None` where the measured stresses are all equal.
    pub r_squared: Option<f64>,
}

/// The fit of a law.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// The law.
    pub law: LawName,
    /// Its constants.
    pub estimates: Vec<Estimate>,
    /// Coefficients of correlation of pairs of fitted constants, by their keys.
    pub correlations: Vec<(&'static str, &'static str, f64)>,
    /// Of all stresses, then of each protocol if there are several.
    pub goodness: Vec<Goodness>,
    /// Number of searches that ended at a fit as good as this one, and of all.
    pub agreeing: [usize; 2],
    /// What should be known before the constants are used: a sentence each.
    pub warnings: Vec<String>,
}

/// Why a law cannot be fitted.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FitError {
    /// Every constant is given.
    NothingFree,
    /// Fewer stresses than constants need.
    TooFew {
        /// Stresses.
        stresses: usize,
        /// Constants to be fitted.
        constants: usize,
    },
    /// All stresses are zero.
    NoStress,
    /// No search found constants with which the law has stresses for all rows.
    NoFit,
}

impl fmt::Display for FitError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NothingFree => write!(f, "every constant is given: there is nothing to fit"),
            Self::TooFew {
                stresses,
                constants,
            } => write!(
                f,
                "{stresses} stresses for {constants} constants: expected at least {}, or more constants given",
                constants + FREEDOM
            ),
            Self::NoStress => write!(f, "every stress is 0: there is nothing to fit"),
            Self::NoFit => write!(
                f,
                "no constants were found with which every specimen has a state: is the law, or a given constant, the right one?"
            ),
        }
    }
}

impl std::error::Error for FitError {}

/// Looks for the constants of a law that reproduce measured stresses with the least sum of squares. `fixed` are those that are given, by
/// their index among the constants of the law; Poisson's ratio is [assumed](ASSUMED_POISSON) if it is not among them.
///
/// ```
/// use microsim_fit::{LawModel, Measurements, fit};
/// use microsim_settings::LawName;
///
/// // Uniaxial: P = 2 c (λ − 1/λ²) with c = 5 kPa, so that E = 6 c = 30 kPa.
/// let mut table = "stretch_1,piola_1 [Pa]\n".to_owned();
/// for stretch in [1.05_f64, 1.1, 1.2, 1.3, 1.4] {
///     table += &format!("{stretch},{}\n", 1e4 * (stretch - stretch.powi(-2)));
/// }
/// let law = LawModel::new(LawName::NeoHookean);
/// // Index 1 is Poisson's ratio: nearly incompressible.
/// let fitted = fit(&law, &[(1, 0.4999)], &Measurements::read(&table).expect("a table"))?;
/// assert!((fitted.estimates[0].value / 30e3 - 1.0).abs() < 1e-3);
/// # Ok::<(), microsim_fit::FitError>(())
/// ```
pub fn fit(model: &LawModel, fixed: &[(usize, f64)], data: &Measurements) -> Result<Fit, FitError> {
    let constants = model.constants();
    let mut determinations = vec![None; constants.len()];
    let mut values = vec![0.0; constants.len()];
    if let Some(index) = constants.iter().position(|c| c.key == "poisson_ratio") {
        values[index] = ASSUMED_POISSON;
        determinations[index] = Some(Determination::Assumed);
    }
    for (index, value) in fixed {
        values[*index] = *value;
        determinations[*index] = Some(Determination::Fixed);
    }
    let free: Vec<usize> = (0..constants.len())
        .filter(|index| determinations[*index].is_none())
        .collect();
    let measured: Vec<f64> = data.stresses().map(|(_, stress)| stress).collect();
    if free.is_empty() {
        return Err(FitError::NothingFree);
    }
    if measured.len() < free.len() + FREEDOM {
        return Err(FitError::TooFew {
            stresses: measured.len(),
            constants: free.len(),
        });
    }
    let scale = root_mean_square(measured.iter().copied());
    if scale == 0.0 {
        return Err(FitError::NoStress);
    }
    let search = Search {
        model,
        data,
        measured,
        scale,
        values,
        free,
    };
    let minima = search.minima();
    let best = minima.first().ok_or(FitError::NoFit)?;
    let equal = minima
        .iter()
        .take_while(|other| other.rms - best.rms <= EQUAL * scale);
    let agreeing = [equal.clone().count(), minima.len()];

    // What is at a bound is held there for the intervals of the others.
    let (bound, inner): (Vec<usize>, Vec<usize>) = search
        .free
        .iter()
        .partition(|index| constants[**index].is_at_bound(best.values[**index], scale));
    let derivatives = derivatives(&search, best, &inner).ok_or(FitError::NoFit)?;
    let confidence = Confidence::new(&derivatives, best.rms);
    for index in &bound {
        determinations[*index] = Some(Determination::AtBound);
    }
    for (index, half) in inner.iter().zip(&confidence.half_widths) {
        let known = half.map_or(Determination::Undetermined, Determination::Within);
        determinations[*index] = Some(known);
    }
    let estimates = constants.iter().zip(&best.values).zip(&determinations);
    let estimates: Vec<Estimate> = estimates
        .map(|((constant, value), determination)| Estimate {
            constant: *constant,
            value: *value,
            determination: determination.unwrap_or(Determination::Undetermined),
        })
        .collect();
    let correlations = confidence.correlations.iter();
    let key = |index: &usize| constants[inner[*index]].key;
    let correlations: Vec<_> = correlations
        .map(|(first, second, r)| (key(first), key(second), *r))
        .collect();
    let predicted = model.stresses(&best.values, data).ok_or(FitError::NoFit)?;
    let mut warnings = warnings(&estimates, &correlations);
    warnings.extend(other_fit(&search, best, equal));
    Ok(Fit {
        law: model.law(),
        estimates,
        correlations,
        goodness: goodness(data, &predicted),
        agreeing,
        warnings,
    })
}

/// Derivatives of the stresses by some constants \[Pa per unit\], one column each.
fn derivatives(search: &Search<'_>, at: &Minimum, constants: &[usize]) -> Option<DMatrix<f64>> {
    let mut derivatives = DMatrix::zeros(search.measured.len(), constants.len());
    for (mut column, index) in derivatives.column_iter_mut().zip(constants) {
        let constant = &search.model.constants()[*index];
        let value = at.values[*index];
        let change = DIFFERENCE * value.abs().max(DIFFERENCE);
        // One-sided where a bound is near.
        let ends = [value - change, value + change];
        let ends = ends.map(|end| end.clamp(constant.min, constant.max));
        let beside = |end: f64| {
            let mut values = at.values.clone();
            values[*index] = end;
            search.model.stresses(&values, search.data)
        };
        let (before, behind) = (beside(ends[0])?, beside(ends[1])?);
        for (entry, (before, behind)) in column.iter_mut().zip(before.iter().zip(&behind)) {
            *entry = (behind - before) / (ends[1] - ends[0]);
        }
    }
    Some(derivatives)
}

/// What the data do not determine.
fn warnings(
    estimates: &[Estimate],
    correlations: &[(&'static str, &'static str, f64)],
) -> Vec<String> {
    let mut warnings = Vec::new();
    for estimate in estimates {
        let Constant { key, unit, .. } = estimate.constant;
        let value = rounded(unit, estimate.value);
        match estimate.determination {
            Determination::Assumed => warnings.push(format!(
                "{key} is not fitted: {value} is assumed; give the measured one"
            )),
            Determination::AtBound => warnings.push(format!(
                "{key} is at a bound of its range, {value}: the data ask for more or less than the law can have, or for a law without it"
            )),
            Determination::Undetermined => warnings.push(format!(
                "the data do not determine {key}: give it, or measure along the other axis too"
            )),
            Determination::Within(half) if half >= estimate.value.abs() => warnings.push(format!(
                "{key} may as well be 0: its interval is wider than its value"
            )),
            Determination::Within(_) | Determination::Fixed => {}
        }
    }
    let close = correlations.iter().filter(|(.., r)| r.abs() > CORRELATED);
    warnings.extend(close.map(|(first, second, r)| {
        format!("{first} and {second} are correlated ({r:.3}): the data determine a combination of both better than each")
    }));
    warnings
}

/// That other constants reproduce the data as well.
fn other_fit<'a>(
    search: &Search<'_>,
    best: &Minimum,
    mut equal: impl Iterator<Item = &'a Minimum>,
) -> Option<String> {
    let constants = search.model.constants();
    let differs = |other: &Minimum, index: usize| {
        let (a, b) = (best.values[index], other.values[index]);
        let bound = |value| constants[index].is_at_bound(value, search.scale);
        (a - b).abs() > DIFFERENT * a.abs().max(b.abs()) && !(bound(a) && bound(b))
    };
    let other = equal.find(|other| search.free.iter().any(|index| differs(other, *index)))?;
    let values = search.free.iter().map(|index| {
        let Constant { key, unit, .. } = constants[*index];
        format!("{key} = {}", rounded(unit, other.values[*index]))
    });
    let values: Vec<String> = values.collect();
    Some(format!(
        "other constants reproduce the data as well: {}",
        values.join(", ")
    ))
}

/// How well the stresses are reproduced: of all, and of each protocol where there are several.
fn goodness(data: &Measurements, predicted: &[f64]) -> Vec<Goodness> {
    let of = |protocol: Option<usize>| {
        let pairs = data.stresses().zip(predicted);
        let pairs: Vec<(f64, f64)> = pairs
            .filter(|((of, _), _)| protocol.is_none_or(|protocol| protocol == *of))
            .map(|((_, measured), predicted)| (measured, *predicted))
            .collect();
        let mean = pairs.iter().map(|(m, _)| m).sum::<f64>() / pairs.len() as f64;
        let rms = root_mean_square(pairs.iter().map(|(m, p)| p - m));
        let spread = root_mean_square(pairs.iter().map(|(m, _)| m - mean));
        Goodness {
            protocol: protocol.map(|protocol| data.protocols[protocol].clone()),
            count: pairs.len(),
            rms,
            r_squared: (spread > 0.0).then(|| 1.0 - (rms / spread) * (rms / spread)),
        }
    };
    let several = data.protocols.len() > 1;
    let each = (0..data.protocols.len()).filter(|_| several).map(Some);
    std::iter::once(None).chain(each).map(of).collect()
}
