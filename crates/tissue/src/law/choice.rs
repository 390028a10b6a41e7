//! The laws as data: by name, and with what they are given beside E and ν. A new law has its line in `laws!`.

use super::constants::{Constants, Parameters};
use super::definition::Law;
use crate::range::MaterialError;
use microsim_vocabulary::LawName;

/// Makes the enum of all laws, and `with_law!`, from one list.
macro_rules! laws {
    ($dollar:tt $($law:ident),+ $(,)?) => {
        /// A law with what it is given beside E and ν.
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub enum MaterialLaw {
            $(
                #[doc = concat!("[`", stringify!($law), "`](super::", stringify!($law), ").")]
                $law(<$crate::law::$law as Law>::Parameters),
            )+
        }

        impl MaterialLaw {
            /// Its name.
            pub fn name(&self) -> LawName {
                match self {
                    $(Self::$law(_) => LawName::$law,)+
                }
            }

            /// The law of a name, with its parameters from values by their keys in files ([`LawName::parameters`]), or the error of
            /// the first that is not there.
            pub fn read<E>(
                name: LawName,
                value: &dyn Fn(&'static str) -> Result<f64, E>,
            ) -> Result<Self, E> {
                Ok(match name {
                    $(LawName::$law => Self::$law(Parameters::read(value)?),)+
                })
            }
        }

        impl From<LawName> for MaterialLaw {
            /// With the parameters that comparisons take.
            fn from(name: LawName) -> Self {
                match name {
                    $(LawName::$law => Self::$law(Default::default()),)+
                }
            }
        }

        /// Evaluates an expression with the type of a law and its parameters:
        /// `with_law!(law, L, parameters => L::constants(&lame, &parameters))`.
        macro_rules! with_law {
            ($dollar value:expr, $dollar of:ident, $dollar parameters:pat => $dollar body:expr) => {
                match $dollar value {
                    $(
                        $crate::law::MaterialLaw::$law($dollar parameters) => {
                            type $dollar of = $crate::law::$law;
                            $dollar body
                        }
                    )+
                }
            };
        }
        pub(crate) use with_law;
    };
}

laws! {
    $
    StVenantKirchhoff,
    NeoHookean,
    Corotational,
    StableNeoHookean,
    NeoHookeanPolynomial,
    MooneyRivlin,
    TransverselyIsotropic,
}

impl MaterialLaw {
    /// Whether its parameters are in range, together with Poisson's ratio.
    pub fn check(&self, poisson: f64) -> Result<(), MaterialError> {
        with_law!(self, L, parameters => <L as Law>::Parameters::check(parameters, poisson))
    }

    /// Whether it needs a fibre direction in each element.
    pub fn has_direction(&self) -> bool {
        with_law!(self, L, _ => <L as Law>::Constants::HAS_DIRECTION)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_selects_the_law_that_has_it() {
        for name in LawName::ALL {
            let law = MaterialLaw::from(name);
            assert_eq!((law.name(), law.check(0.45)), (name, Ok(())));
            assert_eq!(with_law!(law, L, _ => L::NAME), name);
            // It reads the keys that its name states, each of them.
            let read = std::cell::RefCell::new(Vec::new());
            let one = |key| {
                read.borrow_mut().push(key);
                Ok::<f64, ()>(1.0)
            };
            assert_eq!(
                MaterialLaw::read(name, &one).map(|law| law.name()),
                Ok(name)
            );
            let stated = name.parameters().iter().map(|(key, _)| *key);
            assert_eq!(read.into_inner(), stated.collect::<Vec<_>>());
        }
    }

    #[test]
    fn one_law_needs_directions() {
        let with: Vec<LawName> = LawName::ALL
            .into_iter()
            .filter(|law| MaterialLaw::from(*law).has_direction())
            .collect();
        assert_eq!(with, [LawName::TransverselyIsotropic]);
    }
}
