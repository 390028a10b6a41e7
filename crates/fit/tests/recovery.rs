//! Constants come back from tables that another code made from them (`tests/data/fit/make_tables.py`).

use microsim_fit::{
    ANGLE, Constant, Determination, Fit, FitError, LawModel, Measurements, fit, material_toml,
};
use microsim_random::SplitMix64;
use microsim_settings::LawName;
use std::path::Path;

fn table(name: &str) -> Measurements {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/fit");
    let text = std::fs::read_to_string(folder.join(name)).expect("the table");
    Measurements::read(&text).expect("it is right")
}

fn fitted(law: LawName, set: &[(&str, &str)], data: &Measurements) -> Fit {
    let model = LawModel::new(law);
    let fixed = set.iter().map(|(key, text)| {
        Constant::parse(model.constants(), key, text).expect("a constant of the law")
    });
    fit(&model, &fixed.collect::<Vec<_>>(), data).expect("a fit")
}

/// Fitted constants with half of their intervals.
fn free(fit: &Fit) -> Vec<(&'static str, f64, f64)> {
    let within = |estimate: &microsim_fit::Estimate| match estimate.determination {
        Determination::Within(half) => Some((estimate.constant.key, estimate.value, half)),
        _ => None,
    };
    fit.estimates.iter().filter_map(within).collect()
}

/// To 1e-6, six digits: the stresses of the table have the rounding of 16 digits, states are solved to 1e-11, and derivatives to 1e-10.
#[track_caller]
fn assert_recovered(fit: &Fit, expected: &[(&str, f64)]) {
    let found = free(fit);
    assert_eq!(found.len(), expected.len(), "{fit:?}");
    for ((key, value, _), (name, expected)) in found.iter().zip(expected) {
        assert_eq!(key, name);
        assert!(
            (value - expected).abs() <= 1e-6 * expected,
            "{key}: {value} instead of {expected}"
        );
    }
    assert!(fit.goodness[0].r_squared.is_some_and(|r| r > 1.0 - 1e-12));
}

#[test]
fn mooney_rivlin_comes_back() {
    let data = table("mooney-rivlin.csv");
    let found = fitted(LawName::MooneyRivlin, &[("poisson_ratio", "0.45")], &data);
    assert_recovered(&found, &[("youngs_modulus", 60e3), ("c01_fraction", 0.3)]);
    let protocols: Vec<Option<&str>> = found
        .goodness
        .iter()
        .map(|goodness| goodness.protocol.as_deref())
        .collect();
    let expected = [
        None,
        Some("circumferential"),
        Some("axial"),
        Some("equibiaxial"),
    ];
    assert_eq!(protocols, expected);
    assert_eq!(found.goodness[0].count, 60);
    assert_eq!(found.warnings, [""; 0]);
}

#[test]
fn fibres_along_an_axis_come_back() {
    let data = table("transversely-isotropic.csv");
    let set = [("poisson_ratio", "0.49"), (ANGLE, "0 deg")];
    let found = fitted(LawName::TransverselyIsotropic, &set, &data);
    assert_recovered(&found, &[("youngs_modulus", 40e3), ("fibre_ratio", 6.0)]);
    // Without the angle it is found where it is, at the end of its range.
    let found = fitted(LawName::TransverselyIsotropic, &set[..1], &data);
    let angle = &found.estimates[3];
    assert_eq!(
        (angle.constant.key, angle.determination),
        (ANGLE, Determination::AtBound)
    );
    assert!(angle.value < 1e-3, "{angle:?}");
}

/// A wrong law shows in what is left: springs of rubber do not have the stress of fibres along one axis.
#[test]
fn a_law_without_fibres_does_not_fit_fibres() {
    let data = table("transversely-isotropic.csv");
    let found = fitted(LawName::MooneyRivlin, &[("poisson_ratio", "0.49")], &data);
    assert!(
        found.goodness[0].r_squared.is_some_and(|r| r < 0.9),
        "{found:?}"
    );
}

/// Errors of measurement that are independent and normal, of 2 kPa: of 100 tables the intervals of 95 % hold both constants in 95, each as
/// often as a binomial distribution allows: with a chance of 1 in 10⁴ they hold it in fewer than 85 or in all of them (1 − 0.95¹⁰⁰ = 0.994).
#[test]
fn intervals_hold_the_constant_in_95_of_100_tables() {
    const TABLES: u64 = 100;
    let exact = table("mooney-rivlin.csv");
    let mut hits = [0; 2];
    for seed in 0..TABLES {
        let mut random = SplitMix64(seed);
        // The sum of twelve numbers of variance 1/12 times 4 is normal but for its tails; the variance of one in [-1, 1) is 1/3.
        let mut normal = || (0..12).map(|_| random.number()).sum::<f64>() / 2.0;
        let mut data = exact.clone();
        for row in &mut data.rows {
            for stress in row.stress.iter_mut().flatten() {
                *stress += 2e3 * normal();
            }
        }
        let found = fitted(LawName::MooneyRivlin, &[("poisson_ratio", "0.45")], &data);
        for ((hits, (_, value, half)), expected) in
            hits.iter_mut().zip(free(&found)).zip([60e3, 0.3])
        {
            *hits += u32::from((value - expected).abs() <= half);
        }
    }
    for hits in hits {
        assert!((85..100).contains(&hits), "{hits}");
    }
}

/// One axis alone: along the fibres the stress of matrix and fibres adds up, and at small strain nothing distinguishes them.
#[test]
fn what_data_do_not_determine_is_named() {
    let mut data = table("transversely-isotropic.csv");
    data.rows.retain(|row| row.protocol == 0);
    for row in &mut data.rows {
        // Within 0.1 %: linear elasticity.
        row.stretch[0] = row.stretch[0].map(|stretch| 1.0 + 1e-3 * (stretch - 1.0));
        row.stress[0] = row.stretch[0].map(|stretch| 240e3 * (stretch - 1.0));
    }
    let set = [("poisson_ratio", "0.49"), (ANGLE, "0 deg")];
    let found = fitted(LawName::TransverselyIsotropic, &set, &data);
    // Young's modulus along the fibres, the product of both, is all that stresses along them determine.
    assert_eq!(
        found.warnings,
        [
            "youngs_modulus and fibre_ratio are correlated (-1.000): the data determine a combination of both better than each"
        ]
    );
}

const MEDIA: [(&str, f64); 5] = [
    ("youngs_modulus", 8940.0),
    ("fibre_stiffness", 2363.2),
    ("fibre_exponent", 0.8393),
    ("fibre_dispersion", 0.1),
    (ANGLE, 29.0 * std::f64::consts::PI / 180.0),
];

#[test]
fn the_media_of_an_artery_comes_back() {
    let data = table("holzapfel.csv");
    let set = [("poisson_ratio", "0.49")];
    let found = fitted(LawName::HolzapfelGasserOgden, &set, &data);
    assert_recovered(&found, &MEDIA);
}

/// With noise of 0.3 kPa each constant is within its interval, which is not wide: less than half of the value. What is left is the noise:
/// Σr²/σ² of 60 − 5 degrees of freedom has a mean of 55 and a standard deviation of √110, three of which are allowed.
#[test]
fn the_media_of_an_artery_comes_back_from_noise_within_its_intervals() {
    let data = table("holzapfel-noise.csv");
    let set = [("poisson_ratio", "0.49")];
    let found = fitted(LawName::HolzapfelGasserOgden, &set, &data);
    let constants = free(&found);
    assert_eq!(constants.len(), MEDIA.len(), "{found:?}");
    for ((key, value, half), (name, expected)) in constants.into_iter().zip(MEDIA) {
        assert_eq!(key, name);
        assert!((value - expected).abs() <= half, "{key}: {value} +- {half}");
        assert!(half < 0.5 * expected, "{key}: {value} +- {half}");
    }
    let squares = 60.0 * (found.goodness[0].rms / 300.0).powi(2);
    assert!((squares - 55.0).abs() < 3.0 * 110.0_f64.sqrt(), "{squares}");
}

/// One strip has one curve: it does not determine five constants, each of which bends it.
#[test]
fn one_strip_does_not_determine_an_artery() {
    let mut data = table("holzapfel-noise.csv");
    data.rows.retain(|row| row.protocol == 0);
    let found = fitted(
        LawName::HolzapfelGasserOgden,
        &[("poisson_ratio", "0.49")],
        &data,
    );
    let wide = |estimate: &microsim_fit::Estimate| match estimate.determination {
        Determination::Within(half) => half >= estimate.value,
        Determination::AtBound | Determination::Undetermined => true,
        Determination::Fixed | Determination::Assumed => false,
    };
    assert!(found.estimates.iter().any(wide), "{found:?}");
    assert!(found.warnings.len() >= 2, "{found:?}");
}

/// No material is pulled by pushing: the modulus ends at its smallest value, and that is stated.
#[test]
fn data_of_no_material_end_at_a_bound() {
    let table = "stretch_1,piola_1 [kPa]\n1.1,-1\n1.2,-2\n1.3,-3\n1.4,-4\n";
    let data = Measurements::read(table).expect("it is right");
    let found = fitted(LawName::NeoHookean, &[("poisson_ratio", "0.4")], &data);
    assert_eq!(found.estimates[0].determination, Determination::AtBound);
    assert_eq!(found.warnings.len(), 1, "{found:?}");
}

#[test]
fn what_cannot_be_fitted_is_refused() {
    let read = |rows: &str| Measurements::read(&format!("stretch_1,piola_1 [Pa]\n{rows}"));
    let refused = |law, rows| {
        let data = read(rows).expect("it is right");
        fit(&LawModel::new(law), &[], &data).map(drop)
    };
    let (stresses, constants) = (4, 2);
    assert_eq!(
        refused(LawName::MooneyRivlin, "1.1,1\n1.2,2\n1.3,3\n1.4,4\n"),
        Err(FitError::TooFew {
            stresses,
            constants
        })
    );
    assert_eq!(
        refused(LawName::NeoHookean, "1.1,0\n1.2,0\n1.3,0\n1.4,0\n"),
        Err(FitError::NoStress)
    );
}

/// Tetrahedra of one F each lock where the volume hardly changes: a material from 0.4 on states the discretisation that does not.
#[test]
fn a_material_that_would_lock_is_written_selective() {
    let data = Measurements::read("stretch_1,piola_1 [kPa]\n1.1,1\n1.2,2\n1.3,3\n1.4,4\n");
    let data = data.expect("it is right");
    for (poisson, selective) in [("0.39", false), ("0.4", true)] {
        let found = fitted(LawName::NeoHookean, &[("poisson_ratio", poisson)], &data);
        let toml = material_toml(&found);
        let states = toml.contains("\ndiscretisation = \"selective\" #");
        assert_eq!(states, selective, "{toml}");
    }
}
