//! Many runs, one table: speed against accuracy of methods, elements and meshes, and the choice among them.
//!
//! What is here: the plan of runs, the loop over them with budgets, exact solutions on the same mesh to compare with, the
//! Pareto front, the table as CSV, drawings as SVG, one page as HTML, the choice of the cheapest method for a scene, and how far a body's mesh and elements are off. What is
//! not: files (a function that the caller brings loads scenes) and clocks (another one gives CPU time). Nowhere else are
//! methods compared.

#![forbid(unsafe_code)]

pub mod atlas;
mod discretisation_error;
mod drawing;
mod eigen;
mod execute;
mod front;
mod page;
mod plan;
mod results;
mod row;
#[cfg(test)]
mod testing;
mod tune;

pub use discretisation_error::{DiscretisationError, MOST_ELEMENTS, discretisation_error};
pub use execute::{Context, LoadScene, LoadedScene, Step, run_group};
pub use front::{Point, cheapest, pareto_front};
pub use page::{PageInfo, panel_svg};
pub use plan::{Group, GroupKey, PlannedRun, PlannedStep, RunKey, groups};
pub use results::{ERRORS, Panel, Results};
pub use row::{Against, GroupResult, Measured, Row, Status};
pub use tune::{
    AsLevel, Candidates, Choices, Elements, Goal, Mesh, Trial, TuneStep, Tuning, candidates, doubt,
    error_of, locking, measure, tune,
};
