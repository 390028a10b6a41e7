//! plugin-objects
