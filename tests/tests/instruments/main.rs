//! Instruments: peers that speak OpenIGTLink as others wrote it, calibration, markers, recordings of inputs, and what a run makes of them.

mod commands;
mod markers;
mod peers;
mod played;
