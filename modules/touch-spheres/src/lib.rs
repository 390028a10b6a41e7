//! module-touch-spheres
