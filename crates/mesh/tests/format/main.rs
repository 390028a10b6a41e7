//! Mesh files: round trips, files of other programs, damaged files.

mod damage;
mod encode;
mod foreign;
mod refusals;
mod round_trip;
mod samples;
mod write;
