//! plugin-translator
