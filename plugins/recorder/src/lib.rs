//! plugin-recorder
