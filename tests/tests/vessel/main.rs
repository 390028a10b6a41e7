//! Vessels: the one-dimensional solutions of `microsim_tests::vessel`, checked against closed forms and each other, and elements and laws against them.

mod inflation;
mod law;
mod radial;
mod residual;
mod scenes;
mod slice;
mod slides;
