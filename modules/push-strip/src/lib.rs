//! module-push-strip
