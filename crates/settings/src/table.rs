//! Tables of TOML files: each is declared once, as a struct whose fields carry all that their keys may hold.

use crate::colour::Colour;
use crate::schema::{Key, Kind, Presence};
use microsim_vocabulary::{
    Category, CellSplit, Direction, Discretisation, EyeLayout, Filling, Finish, Interpolation,
    Language, LocalText, MethodName, Overflow, PedalKey, PictureQuality, PluginKind, Unit,
};
use serde_json::Value;

/// What the value of a key may be, by the type that it is read into.
pub(crate) trait Setting {
    /// Whether the key may be left out, and has no value then.
    const OPTIONAL: bool = false;

    /// All that the type can hold; a table narrows it where not all of it is sensible.
    fn kind() -> Kind;
}

/// A struct that holds one table of a file.
pub(crate) trait Table {
    /// Its keys.
    fn keys() -> Vec<Key>;
}

/// Declares a table: a struct with one field for each key, from which the schema is derived.
///
/// ```text
/// table! {
///     /// A layer of the wall of a tube.
///     #[derive(Copy)]
///     pub struct Layer {
///         /// Of the layer \[m\].
///         thickness: f64 = size(),
///         /// Cells through the layer.
///         cells: u32 [1, 100],
///         /// Region of its elements.
///         region: u32 => 0,
///     }
/// }
/// ```
///
/// The documentation of a field is that of its key; the unit in brackets stays out of the schema, which states it by itself.
/// A key has the name of its field, or the one after `as`. Its kind is that of the type, bounded by `[smallest, largest]` or
/// replaced after `=`. The value after `=>`, in SI, holds if the key is left out. Without one the key is required, unless it
/// is an `Option`, or a list that may be empty.
macro_rules! table {
    (@name $field:ident) => { stringify!($field) };
    (@name $field:ident $key:literal) => { $key };
    (@kind $type:ty;) => { <$type as $crate::table::Setting>::kind() };
    (@kind $type:ty; [$min:expr, $max:expr]) => {
        $crate::table::bounded(<$type as $crate::table::Setting>::kind(), $min, $max)
    };
    (@kind $type:ty; = $kind:expr) => { $kind };
    (@default) => { None };
    (@default $default:expr) => { Some(::serde_json::json!($default)) };
    ($(#[$attribute:meta])* $visibility:vis struct $name:ident {
        $(
            $(#[doc = $doc:literal])+
            $(#[serde($($serde:tt)+)])?
            $field:ident $(as $key:literal)? : $type:ty
                $([$min:expr, $max:expr])? $(= $kind:expr)? $(=> $default:expr)?
        ),+ $(,)?
    }) => {
        $(#[$attribute])*
        #[derive(Clone, Debug, PartialEq, ::serde::Serialize, ::serde::Deserialize)]
        #[serde(deny_unknown_fields)]
        $visibility struct $name {
            $($(#[doc = $doc])+ $(#[serde($($serde)+)])? $(#[serde(rename = $key)])? pub $field: $type),+
        }

        impl $crate::table::Table for $name {
            fn keys() -> Vec<$crate::schema::Key> {
                use $crate::table::{key, table};
                vec![$(
                    key::<$type>(
                        table!(@name $field $($key)?),
                        table!(@kind $type; $([$min, $max])? $(= $kind)?),
                        concat!($($doc),+),
                        table!(@default $($default)?),
                    )
                ),+]
            }
        }

        impl $crate::table::Setting for $name {
            fn kind() -> $crate::schema::Kind {
                $crate::schema::Kind::Table(<Self as $crate::table::Table>::keys())
            }
        }
    };
}
pub(crate) use table;

/// A key as [`table!`] declares it.
pub(crate) fn key<T: Setting>(name: &str, kind: Kind, doc: &str, default: Option<Value>) -> Key {
    let presence = match (default, &kind) {
        (Some(default), _) => Presence::Default(default),
        (None, _) if T::OPTIONAL => Presence::Optional,
        (None, Kind::List { min: 0, .. }) => Presence::Default(Value::Array(Vec::new())),
        (None, _) => Presence::Required,
    };
    Key {
        name: name.to_owned(),
        kind,
        doc: without_units(doc),
        presence,
    }
}

/// The documentation of a field without the units in it, `\\[m\\]`.
fn without_units(doc: &str) -> String {
    let mut text = String::new();
    let mut rest = doc.trim();
    while let Some((before, after)) = rest.split_once("\\[") {
        text.push_str(before.trim_end());
        rest = after.split_once("\\]").map_or("", |(_, after)| after);
    }
    text + rest
}

/// A kind within narrower bounds: whole numbers, the length of a list, or the numbers in a list of fixed length.
pub(crate) fn bounded(kind: Kind, min: i64, max: i64) -> Kind {
    match kind {
        Kind::Integer { .. } => Kind::Integer { min, max },
        Kind::List { of, min: n, max: m } if n == m => Kind::List {
            of: Box::new(bounded(*of, min, max)),
            min: n,
            max: m,
        },
        Kind::List { of, .. } => Kind::List {
            of,
            min: usize::try_from(min).unwrap_or(0),
            max: usize::try_from(max).unwrap_or(usize::MAX),
        },
        other => unreachable!("{other:?} has no bounds that are whole numbers"),
    }
}

impl<T: Setting> Setting for Option<T> {
    const OPTIONAL: bool = true;

    fn kind() -> Kind {
        T::kind()
    }
}

impl<T: Setting> Setting for Vec<T> {
    fn kind() -> Kind {
        Kind::list(T::kind(), usize::MAX)
    }
}

impl<T: Setting, const N: usize> Setting for [T; N] {
    fn kind() -> Kind {
        Kind::List {
            of: Box::new(T::kind()),
            min: N,
            max: N,
        }
    }
}

/// Implements [`Setting`] for types of one kind each.
macro_rules! settings {
    ($($type:ty: $kind:expr),+ $(,)?) => {
        $(impl Setting for $type {
            fn kind() -> Kind {
                $kind
            }
        })+
    };
}

/// Implements [`Setting`] for closed sets of names.
macro_rules! choices {
    ($($type:ty),+ $(,)?) => {
        $(impl $crate::table::Setting for $type {
            fn kind() -> $crate::schema::Kind {
                $crate::schema::Kind::choice(&Self::NAMES)
            }
        })+
    };
}
pub(crate) use choices;

settings! {
    bool: Kind::Bool,
    String: Kind::Text,
    f64: Kind::quantity(Unit::Ratio, f64::NEG_INFINITY, f64::INFINITY),
    u32: Kind::Integer { min: 0, max: i64::from(u32::MAX) },
    usize: Kind::Integer { min: 0, max: i64::from(u32::MAX) },
    Value: Kind::Dependent("a value".to_owned()),
    LocalText: Kind::LocalText,
    Colour: Kind::Colour,
    Unit: Kind::Choice(Unit::ALL.map(|unit| unit.symbol().to_owned()).to_vec()),
}

choices! {
    Category, CellSplit, Direction, Discretisation, EyeLayout, Filling, Finish, Interpolation, Language, MethodName,
    Overflow, PedalKey, PictureQuality, PluginKind,
}
