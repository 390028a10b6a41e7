//! The tissue against solutions by others: the cantilever of `data/reference`, static and released.
//!
//! Expected values stand in `data/reference/cantilever.json`, made with independent finite-element codes; here they are read,
//! never repeated.

mod beam;
mod foreign;
mod locking;
mod quadratic;
mod refinement;
mod released;
mod still;
mod threads;
