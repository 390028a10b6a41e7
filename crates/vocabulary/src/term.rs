//! How a closed set of names is declared.

use std::fmt;

/// A closed set of names.
pub trait Term: Copy + Eq + 'static {
    /// All members, in the order of their declaration.
    const ALL: &'static [Self];

    /// The names of [`ALL`](Term::ALL), as files and messages write them.
    const NAMES: &'static [&'static str];

    /// What each of [`ALL`](Term::ALL) means, in a sentence.
    const DOCS: &'static [&'static str];

    /// Its name.
    fn name(self) -> &'static str;

    /// The member of this name.
    fn from_name(name: &str) -> Option<Self> {
        let index = Self::NAMES.iter().position(|known| *known == name)?;
        Some(Self::ALL[index])
    }
}

/// A name that no member of a set has.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnknownTerm {
    /// The name.
    pub name: String,
    /// The names that there are.
    pub known: &'static [&'static str],
}

impl fmt::Display for UnknownTerm {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "`{}` is none of {}", self.name, self.known.join(", "))
    }
}

impl std::error::Error for UnknownTerm {}

/// Declares a closed set of names: an enum that is read, written and listed by the names given here.
///
/// ```
/// use microsim_vocabulary::{Term, terms};
///
/// terms! {
///     /// Where a device stands.
///     pub enum Side {
///         /// To the left of the trainee.
///         Left = "left",
///         /// To the right of the trainee.
///         Right = "right",
///     }
/// }
///
/// assert_eq!(Side::NAMES, ["left", "right"]);
/// assert_eq!(Side::from_name("right"), Some(Side::Right));
/// assert_eq!(<Side as Term>::DOCS[0].trim(), "To the left of the trainee.");
/// ```
///
/// A member that is followed by `default` is the one of `#[derive(Default)]`. The crate that uses it depends on `serde`.
#[macro_export]
macro_rules! terms {
    ($(#[$attribute:meta])* $visibility:vis enum $name:ident {
        $($(#[doc = $doc:literal])+ $member:ident = $text:literal $($default:ident)?),+ $(,)?
    }) => {
        $(#[$attribute])*
        #[derive(
            Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash,
            ::serde::Serialize, ::serde::Deserialize,
        )]
        $visibility enum $name {
            $($(#[doc = $doc])+ $(#[$default])? #[serde(rename = $text)] $member),+
        }

        impl $name {
            /// All, in the order of their declaration.
            pub const ALL: [Self; [$($text),+].len()] = [$(Self::$member),+];

            /// The names of [`ALL`](Self::ALL), as files and messages write them.
            pub const NAMES: [&'static str; [$($text),+].len()] = [$($text),+];

            /// Its name in files, messages and reports.
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$member => $text),+
                }
            }

            /// The one of this name.
            pub fn from_name(name: &str) -> Option<Self> {
                <Self as $crate::Term>::from_name(name)
            }
        }

        impl $crate::Term for $name {
            const ALL: &'static [Self] = &Self::ALL;
            const NAMES: &'static [&'static str] = &Self::NAMES;
            const DOCS: &'static [&'static str] = &[$(concat!($($doc),+)),+];

            fn name(self) -> &'static str {
                self.name()
            }
        }

        impl ::std::str::FromStr for $name {
            type Err = $crate::UnknownTerm;

            fn from_str(name: &str) -> ::std::result::Result<Self, Self::Err> {
                Self::from_name(name).ok_or_else(|| $crate::UnknownTerm {
                    name: name.to_owned(),
                    known: &Self::NAMES,
                })
            }
        }
    };
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        Category, CellSplit, Direction, Discretisation, Filling, Finish, Interpolation, Language,
        LawName, MethodName, Overflow, PluginKind, ToolStatus,
    };
    use serde::Serialize;
    use serde::de::DeserializeOwned;
    use std::collections::BTreeSet;
    use std::fmt::Debug;

    /// Name, serialised form and reading agree, and no name or documentation occurs twice in a set.
    fn check<T: Term + Debug + Serialize + DeserializeOwned>() {
        assert_eq!(T::ALL.len(), T::NAMES.len());
        for (term, name) in T::ALL.iter().zip(T::NAMES) {
            assert_eq!(term.name(), *name);
            assert_eq!(T::from_name(name), Some(*term));
            let written = serde_json::to_string(term).expect("a name");
            assert_eq!(written, format!("\"{name}\""));
            assert_eq!(serde_json::from_str::<T>(&written).expect("a name"), *term);
        }
        for texts in [T::NAMES, T::DOCS] {
            assert_eq!(texts.iter().collect::<BTreeSet<_>>().len(), texts.len());
        }
        assert_eq!(T::from_name("zzz"), None);
    }

    #[test]
    fn names_are_read_as_they_are_written() {
        check::<Category>();
        check::<CellSplit>();
        check::<Direction>();
        check::<Discretisation>();
        check::<Filling>();
        check::<Finish>();
        check::<Interpolation>();
        check::<Language>();
        check::<LawName>();
        check::<MethodName>();
        check::<Overflow>();
        check::<PluginKind>();
        check::<ToolStatus>();
    }

    #[test]
    fn an_unknown_name_is_refused_with_the_names_that_there_are() {
        let refused = "matt".parse::<Finish>().expect_err("no finish");
        assert_eq!(refused.to_string(), "`matt` is none of matte, moist, metal");
    }
}
