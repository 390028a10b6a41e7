//! Plugins that are wrong, lie or fail: each is named, with its path or its call and the reason, and nothing is lost.
//!
//! - `refused`: libraries and manifests that are refused before anything of them runs;
//! - `failing`: panics and faults in each call of the life cycle;
//! - `isolated`: guests that end their own process, and what is found before;
//! - `lies`: publications that a manifest does not declare, and queues that are flooded;
//! - `observers`: a renderer or recorder that fails does not change the run;
//! - `boundary`: the calls that a run never makes, in this process, and what the SDK's test host finds.

mod awkward;
mod boundary;
mod failing;
mod isolated;
mod lies;
mod observers;
mod refused;
mod tree;
