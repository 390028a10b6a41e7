//! Trainees, courses and results in the built program: what is entered is found, what is asked to go is gone, and a store that fails costs no session.

mod commands;
mod courses;
mod erasure;
mod faults;
mod kills;
mod tables;
