//! Contact against closed forms and against solutions that this test computes by other means.

mod hertz;
mod quasi_static;
mod steady_state;
