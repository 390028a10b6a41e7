//! plugin-source-script
