//! Vessels: the one-dimensional solutions of `microsim_tests::vessel` against closed forms and each other.

mod radial;
