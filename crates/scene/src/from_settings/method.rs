//! Methods.

use super::error::FromSettingsError;
use microsim_settings as settings;
use microsim_tissue::Method;

/// A method with its parameters; those that the file does not give are the method's own.
pub(super) fn method(method: &settings::Method) -> Result<Method, FromSettingsError> {
    Ok(match method.name {
        settings::MethodName::StoermerVerlet => Method::StoermerVerlet,
        settings::MethodName::ExplicitEuler => Method::ExplicitEuler,
        settings::MethodName::SymplecticEuler => Method::SymplecticEuler,
        settings::MethodName::VelocityVerlet => Method::VelocityVerlet,
        settings::MethodName::VelocityVerletLagged => Method::VelocityVerletLagged,
    })
}
