//! Kinds of values that several tables have in common.

use crate::schema::{Form, Kind};
use microsim_vocabulary::Unit;
use serde_json::{Map, Value};

/// Largest coordinate and size \[m\].
pub const LENGTH_MAX: f64 = 1.0;
/// Smallest size of anything: a micrometre \[m\].
const LENGTH_MIN: f64 = 1e-6;

/// A quantity of this unit from `min` to `max`, in SI.
pub(crate) fn quantity(unit: Unit, min: f64, max: f64) -> Kind {
    Kind::quantity(unit, min, max)
}

/// A pure number from 0 to `max`.
pub(crate) fn ratio(max: f64) -> Kind {
    quantity(Unit::Ratio, 0.0, max)
}

/// Any number, in the SI unit of what it is.
pub(crate) fn number() -> Kind {
    quantity(Unit::Ratio, f64::NEG_INFINITY, f64::INFINITY)
}

/// A time \[s\].
pub(crate) fn time(min: f64, max: f64) -> Kind {
    quantity(Unit::Time, min, max)
}

/// Length of a tube over that of its natural state.
pub(crate) fn axial_stretch() -> Kind {
    quantity(Unit::Ratio, 0.5, 3.0)
}

/// What is missing of a full circle in the natural state of a layer \[rad\]; negative where the layer is too wide.
pub(crate) fn opening_angle() -> Kind {
    quantity(Unit::Angle, -300_f64.to_radians(), 340_f64.to_radians())
}

/// A size \[m\].
pub(crate) fn size() -> Kind {
    quantity(Unit::Length, LENGTH_MIN, LENGTH_MAX)
}

/// Sizes along x, y and z \[m\].
pub(crate) fn size3() -> Kind {
    vector(Unit::Length, 3, LENGTH_MIN, LENGTH_MAX)
}

/// A point \[m\].
pub(crate) fn point() -> Kind {
    vector3(Unit::Length, LENGTH_MAX)
}

/// `len` quantities of this unit, each from `min` to `max`, in SI.
pub(crate) fn vector(unit: Unit, len: usize, min: f64, max: f64) -> Kind {
    Kind::Vector {
        unit,
        len,
        min,
        max,
    }
}

/// Three components of this unit, each from `-max` to `max`, in SI.
pub(crate) fn vector3(unit: Unit, max: f64) -> Kind {
    vector(unit, 3, -max, max)
}

/// A direction, read with length 1.
pub(crate) fn direction() -> Kind {
    Kind::Direction
}

/// A rotation, read with length 1.
pub(crate) fn rotation() -> Kind {
    Kind::Quaternion
}

/// Lower-case words joined by hyphens.
pub(crate) fn identifier() -> Kind {
    Kind::Name(Form::Identifier)
}

/// Lower-case words joined by underscores.
pub(crate) fn symbol() -> Kind {
    Kind::Name(Form::Symbol)
}

/// The name of a file, without a folder.
pub(crate) fn file_name() -> Kind {
    Kind::Name(Form::FileName)
}

/// The name of a message kind.
pub(crate) fn message_kind() -> Kind {
    Kind::Name(Form::Message)
}

/// Three numbers joined by dots.
pub(crate) fn version() -> Kind {
    Kind::Name(Form::Version)
}

/// A text that may be in English alone.
pub(crate) fn english_text() -> Kind {
    Kind::EnglishText
}

/// A path below the folder of the file.
pub(crate) fn relative_path() -> Kind {
    Kind::Name(Form::RelativePath)
}

/// A list of `min` to `max` elements.
pub(crate) fn list(of: Kind, min: usize, max: usize) -> Kind {
    Kind::List {
        of: Box::new(of),
        min,
        max,
    }
}

/// A value whose kind another part of the files decides; the text names it.
pub(crate) fn dependent(which: &str) -> Kind {
    Kind::Dependent(which.to_owned())
}

/// The default of a table: those of its own keys.
pub(crate) fn own_defaults() -> Value {
    Value::Object(Map::new())
}
