//! Laws and their constants, as the command line gives them.

use microsim_settings::LawName;

/// A law by its name in files.
pub fn parse_law(text: &str) -> Result<LawName, String> {
    let expected = || format!("expected one of {}", LawName::NAMES.join(", "));
    LawName::from_name(text).ok_or_else(expected)
}

/// A constant that is given: its key and its value.
pub fn parse_constant(text: &str) -> Result<(String, String), String> {
    let (key, value) = text
        .split_once('=')
        .ok_or("expected KEY=VALUE, such as poisson_ratio=0.49")?;
    Ok((key.trim().to_owned(), value.trim().to_owned()))
}
