//! Ranges of values: what a constant may be, and the error for what is outside.

/// A value outside its range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MaterialError {
    /// Which value.
    pub value_name: &'static str,
    /// What was given.
    pub value: f64,
    /// What is allowed, with the unit.
    pub allowed: &'static str,
}

impl std::fmt::Display for MaterialError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "{} is {}, allowed is {}",
            self.value_name, self.value, self.allowed
        )
    }
}

impl std::error::Error for MaterialError {}

/// Refuses what is not finite and above zero.
pub(crate) fn positive(
    value_name: &'static str,
    value: f64,
    allowed: &'static str,
) -> Result<(), MaterialError> {
    require(value.is_finite() && value > 0.0, value_name, value, allowed)
}

/// Refuses what is not finite or below zero.
pub(crate) fn not_negative(
    value_name: &'static str,
    value: f64,
    allowed: &'static str,
) -> Result<(), MaterialError> {
    require(
        value.is_finite() && value >= 0.0,
        value_name,
        value,
        allowed,
    )
}

/// Refuses a value of which a condition does not hold.
pub(crate) fn require(
    holds: bool,
    value_name: &'static str,
    value: f64,
    allowed: &'static str,
) -> Result<(), MaterialError> {
    match holds {
        true => Ok(()),
        false => Err(MaterialError {
            value_name,
            value,
            allowed,
        }),
    }
}
