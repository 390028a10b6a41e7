//! plugin-renderer
