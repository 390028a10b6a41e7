//! `microsim fit`: the constants of a material law from measured stretches and stresses.

use crate::cli::FitArgs;
use crate::output::{Exit, Problem, print, print_json};
use crate::replace_file::write_new;
use microsim_fit::{
    Constant, Determination, Estimate, Fit, Goodness, LawModel, Measurements, fit as fit_law,
    material_toml, rounded,
};
use microsim_settings::{Unit, read_regular};
use serde_json::{Value, json};
use std::fmt::Write;

/// Fits a law to a table.
pub fn fit(args: &FitArgs) -> Result<Exit, Problem> {
    let name = args.data.display();
    let bytes = read_regular(&args.data).map_err(|error| format!("{name}: {error}"))?;
    let text = String::from_utf8(bytes).map_err(|error| format!("{name}: {error}"))?;
    let data = Measurements::read(&text).map_err(|error| format!("{name}:{error}"))?;
    let model = LawModel::new(args.law);
    let mut fixed: Vec<(usize, f64)> = Vec::new();
    for (key, text) in &args.set {
        let (index, value) = Constant::parse(model.constants(), key, text)
            .map_err(|error| format!("--set {key}={text}: {error}"))?;
        if fixed.iter().any(|(given, _)| *given == index) {
            return Err(format!(
                "--set {key}={text}: found {key} a second time, expected each constant once"
            )
            .into());
        }
        fixed.push((index, value));
    }
    let fitted = fit_law(&model, &fixed, &data).map_err(|error| format!("{name}: {error}"))?;
    let toml = material_toml(&fitted);
    if let Some(path) = &args.out {
        write_new(path, toml.as_bytes())?;
    }
    if args.json {
        print_json(&document(&fitted, &data, &toml))?;
    } else {
        print(page(&fitted, &data))?;
        print(toml.trim_end())?;
    }
    Ok(Exit::Done)
}

/// The fit for people.
fn page(fit: &Fit, data: &Measurements) -> String {
    let mut page = format!(
        "{}, {} {} stresses\n\n{:<18} {:>14}   95 %\n",
        fit.law.name(),
        fit.goodness[0].count,
        data.measure.name(),
        "constant",
        "value"
    );
    for estimate in &fit.estimates {
        let Estimate {
            constant, value, ..
        } = estimate;
        let known = match estimate.determination {
            Determination::Within(half) => format!("+- {}", rounded(constant.unit, half)),
            other => other.name().to_owned(),
        };
        // Writing to a text never fails.
        let _ = writeln!(
            page,
            "{:<18} {:>14}   {known}",
            constant.key,
            rounded(constant.unit, *value)
        );
    }
    let _ = writeln!(
        page,
        "\n{:<18} {:>8} {:>14} {:>10}",
        "test", "stresses", "rms residual", "R^2"
    );
    for goodness in &fit.goodness {
        let Goodness {
            protocol,
            count,
            rms,
            r_squared,
        } = goodness;
        let _ = writeln!(
            page,
            "{:<18} {count:>8} {:>14} {:>10}",
            protocol.as_deref().unwrap_or("all"),
            rounded(Unit::Pressure, *rms),
            r_squared.map_or("-".to_owned(), |r| format!("{r:.5}"))
        );
    }
    let [agreeing, searches] = fit.agreeing;
    let _ = writeln!(
        page,
        "\n{agreeing} of {searches} searches ended at an equally good fit"
    );
    for warning in &fit.warnings {
        let _ = writeln!(page, "warning: {warning}");
    }
    page
}

/// The fit as a document, in SI.
fn document(fit: &Fit, data: &Measurements, toml: &str) -> Value {
    let constants = fit.estimates.iter().map(|estimate| {
        let half = match estimate.determination {
            Determination::Within(half) => Some(half),
            _ => None,
        };
        json!({
            "key": estimate.constant.key,
            "unit": estimate.constant.unit.symbol(),
            "value": estimate.value,
            "determination": estimate.determination.name(),
            "interval_95": half.map(|half| [estimate.value - half, estimate.value + half]),
        })
    });
    let goodness = fit.goodness.iter().map(|goodness| {
        json!({
            "protocol": goodness.protocol,
            "stresses": goodness.count,
            "rms_pa": goodness.rms,
            "r_squared": goodness.r_squared,
        })
    });
    let correlations = fit
        .correlations
        .iter()
        .map(|(first, second, r)| json!({ "constants": [first, second], "coefficient": r }));
    json!({
        "law": fit.law.name(),
        "stress": data.measure.name(),
        "constants": constants.collect::<Vec<_>>(),
        "correlations": correlations.collect::<Vec<_>>(),
        "goodness": goodness.collect::<Vec<_>>(),
        "searches": { "agreeing": fit.agreeing[0], "all": fit.agreeing[1] },
        "warnings": fit.warnings,
        "toml": toml,
    })
}
