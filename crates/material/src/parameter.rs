//! Parameters become valid once, at the door; after that no code checks them again.

/// A material parameter outside its bounds.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{parameter} = {value:?} is not allowed: {bound}")]
pub struct ParameterError {
    /// The deck's name of the parameter.
    pub parameter: &'static str,
    /// The value that was given, in SI units.
    pub value: f64,
    /// What would be allowed.
    pub bound: &'static str,
}

/// `value` if it is finite and satisfies `allowed`.
pub(crate) fn checked(
    parameter: &'static str,
    value: f64,
    allowed: impl Fn(f64) -> bool,
    bound: &'static str,
) -> Result<f64, ParameterError> {
    if value.is_finite() && allowed(value) { Ok(value) } else { Err(ParameterError { parameter, value, bound }) }
}

/// `value` if it is finite and greater than zero.
pub(crate) fn positive(parameter: &'static str, value: f64) -> Result<f64, ParameterError> {
    checked(parameter, value, |v| v > 0.0, "it must be greater than 0")
}

/// `value` if it is finite and not negative.
pub(crate) fn not_negative(parameter: &'static str, value: f64) -> Result<f64, ParameterError> {
    checked(parameter, value, |v| v >= 0.0, "it must be 0 or greater")
}
