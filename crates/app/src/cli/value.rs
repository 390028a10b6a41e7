//! Values of options: text to what it names, or what was expected instead.

use clap::builder::{PossibleValuesParser, TypedValueParser};
use microsim_host::assemble::{Input, Isolate};
use microsim_settings::{DebugView, DominantHand, Override};
use microsim_store::Role;
use microsim_table::Format;
use std::path::PathBuf;

/// Where the motion of a run comes from.
pub fn parse_input(text: &str) -> Result<Input, String> {
    let known = "expected script:FILE, recording:FILE, openigtlink://HOST:PORT or plugin:NAME";
    match text.split_once(':') {
        Some((_, "")) => Err(format!("nothing behind the colon; {known}")),
        Some(("script", file)) => Ok(Input::Script(file.into())),
        Some(("recording", file)) => Ok(Input::Recording(file.into())),
        Some(("plugin", name)) => Ok(Input::Plugin(name.into())),
        Some(("openigtlink", rest)) => match rest.strip_prefix("//") {
            Some(address) if !address.is_empty() => Ok(Input::OpenIgtLink(address.into())),
            _ => Err(format!("no address behind openigtlink:; {known}")),
        },
        _ if text == "desktop" => Err(format!(
            "mouse and keyboard are those of a window (`microsim window`); {known}"
        )),
        _ => Err(format!("unknown source; {known}")),
    }
}

/// The dominant hand.
pub fn parse_hand(text: &str) -> Result<DominantHand, String> {
    DominantHand::from_name(text).ok_or_else(|| "expected left or right".into())
}

/// Which plugins run in a process of their own.
pub fn parse_isolate(text: &str) -> Result<Isolate, String> {
    match text {
        "guests" => Ok(Isolate::Guests),
        "all" => Ok(Isolate::All),
        "none" => Ok(Isolate::None),
        _ => Err("expected guests, all or none".into()),
    }
}

/// Paths go into sessions and reports as text.
pub fn utf8_path(text: &str) -> Result<PathBuf, String> {
    Ok(text.into())
}

/// What is laid over pictures.
pub fn views() -> impl TypedValueParser<Value = DebugView> {
    PossibleValuesParser::new(DebugView::NAMES).try_map(|name| name.parse::<DebugView>())
}

/// Another value for a key.
pub fn parse_override(text: &str) -> Result<Override, String> {
    Override::parse(text)
}

pub fn parse_positive(text: &str, what: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && value > 0.0 => Ok(value),
        _ => Err(format!("expected a positive number of {what}")),
    }
}

/// The number of a level.
pub fn parse_level(text: &str) -> Result<u32, String> {
    let level = text.parse();
    level.map_err(|_| "expected the number of a level, such as 1".into())
}

/// Pictures per simulated second.
pub fn parse_rate(text: &str) -> Result<f64, String> {
    parse_positive(text, "pictures per simulated second")
}

/// A time \[s\].
pub fn parse_seconds(text: &str) -> Result<f64, String> {
    parse_positive(text, "seconds")
}

/// A table whose name states its format.
pub fn table_path(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    match Format::of(&path) {
        Some(_) => Ok(path),
        None => Err("expected a file that ends in .csv or .parquet".into()),
    }
}

pub fn parse_role(text: &str) -> Result<Role, String> {
    Role::from_name(text).ok_or_else(|| format!("expected {}", Role::NAMES.join(", ")))
}

/// The beginning of a day in UTC, seconds since 1970.
pub fn parse_date(text: &str) -> Result<i64, String> {
    crate::date::parse(text).ok_or_else(|| "expected a day such as 2026-11-25".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_level_that_is_no_number_is_refused_with_what_is() {
        assert_eq!(parse_level("4"), Ok(4));
        for text in ["vier", "-1", "1.5", "4294967296"] {
            let error = parse_level(text).expect_err(text);
            assert!(error.contains("the number of a level"), "{error}");
        }
    }

    #[test]
    fn sources_are_parsed_or_refused_with_what_is_possible() {
        assert_eq!(
            parse_input("script:a:b.toml"),
            Ok(Input::Script("a:b.toml".into()))
        );
        assert_eq!(
            parse_input("recording:x.csv"),
            Ok(Input::Recording("x.csv".into()))
        );
        assert_eq!(
            parse_input("openigtlink://host:18944"),
            Ok(Input::OpenIgtLink("host:18944".into()))
        );
        for bad in [
            "",
            "x.csv",
            "script:",
            "desktop",
            "openigtlink://",
            "openigtlink:host:18944",
        ] {
            assert!(
                parse_input(bad).unwrap_err().contains("recording:FILE"),
                "{bad}"
            );
        }
    }
}
