//! Numbers from files.

use crate::error::{Flaw, ModelError, flawed};

/// Largest coordinate, in the unit of the file: beyond it single precision has less than a twentieth of a unit.
const LARGEST: f32 = 1e6;

/// A coordinate that can be worked with.
pub(crate) fn coordinate(value: f32) -> Result<f32, ModelError> {
    match value.abs() <= LARGEST {
        // Also turns -0 into 0, so that equal points have equal bits.
        true => Ok(value + 0.0),
        false => flawed(Flaw::NotANumber, format!("the coordinate {value}")),
    }
}

/// A point of three coordinates.
pub(crate) fn point(values: [f32; 3]) -> Result<[f32; 3], ModelError> {
    let [x, y, z] = values;
    Ok([coordinate(x)?, coordinate(y)?, coordinate(z)?])
}

/// A text as a number; words such as `nan` are none.
pub(crate) fn number(word: &str) -> Option<f32> {
    let of_digits = word
        .bytes()
        .all(|b| b.is_ascii_digit() || b"+-.eE".contains(&b));
    word.parse().ok().filter(|_| of_digits)
}

/// Four bytes at a place, the lowest first.
pub(crate) fn four(bytes: &[u8], at: usize) -> Option<[u8; 4]> {
    bytes.get(at..at.checked_add(4)?)?.try_into().ok()
}
