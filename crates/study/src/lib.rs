//! Many runs, one table: chart, tune, atlas.
