//! plugin-physics
