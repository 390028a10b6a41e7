//! plugin-source-recording
