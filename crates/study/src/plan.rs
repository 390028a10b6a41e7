//! From the chart's file to runs: what is run, in which order, with which overrides.
//!
//! The order depends on the plan alone: groups of one mesh and one material in the order in which the sweeps name them first,
//! and in a group the runs in the order of the sweeps.

use microsim_settings::{Chart, ChartScene, ChartSweep};

/// A mesh with a material, as indices into the plan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GroupKey {
    /// Index of the scene.
    pub scene: usize,
    /// Index of the scene's variant.
    pub variant: usize,
    /// Index of the scene's resolution.
    pub resolution: usize,
    /// Index of the material.
    pub material: usize,
}

/// What is run, as indices into the plan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RunKey {
    /// Mesh and material.
    pub group: GroupKey,
    /// Index of the method.
    pub method: usize,
}

/// The step of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PlannedStep {
    /// \[s\]
    Seconds(f64),
    /// Fraction of the estimated stability limit.
    LimitFraction(f64),
    /// One step per sample.
    Sample,
}

impl PlannedStep {
    /// The same with a limit \[s\] that its fraction is of; without a limit as it is.
    pub fn of_limit(self, limit: f64) -> Self {
        match self {
            Self::LimitFraction(fraction) if limit.is_finite() => Self::Seconds(fraction * limit),
            Self::LimitFraction(_) | Self::Seconds(_) | Self::Sample => self,
        }
    }
}

/// A run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlannedRun {
    /// Method.
    pub method: usize,
    /// Step.
    pub step: PlannedStep,
    /// Largest number of iterations in a step; the method's own if `None`.
    pub iterations: Option<u32>,
}

/// Runs on one mesh with one material: one exact solution serves all of them.
#[derive(Clone, Debug, PartialEq)]
pub struct Group {
    /// Mesh and material.
    pub key: GroupKey,
    /// The runs.
    pub runs: Vec<PlannedRun>,
}

/// The groups of a plan: of all its scenes, or of those that are named; for the short chart only those of the sweeps marked for it.
pub fn groups(chart: &Chart, quick: bool, scenes: &[String]) -> Vec<Group> {
    let mut groups: Vec<Group> = Vec::new();
    for (scene, of) in chart.scene.iter().enumerate() {
        if !scenes.is_empty() && !scenes.contains(&of.name) {
            continue;
        }
        for sweep in of.sweep.iter().filter(|sweep| sweep.quick || !quick) {
            for key in keys(chart, scene, of, sweep) {
                let runs = sweep
                    .methods
                    .iter()
                    .flat_map(|name| runs_of(chart, sweep, name));
                match groups.iter_mut().find(|group| group.key == key) {
                    Some(group) => {
                        for run in runs {
                            if !group.runs.contains(&run) {
                                group.runs.push(run);
                            }
                        }
                    }
                    None => groups.push(Group {
                        key,
                        runs: runs.collect(),
                    }),
                }
            }
        }
    }
    groups
}

/// Meshes and materials of a sweep.
fn keys(chart: &Chart, scene: usize, of: &ChartScene, sweep: &ChartSweep) -> Vec<GroupKey> {
    let variants: Vec<usize> = match &sweep.variants[..] {
        [] => (0..of.variant.len()).collect(),
        names => places(names, of.variant.iter().map(|v| &v.name)),
    };
    let resolutions = places(&sweep.resolutions, of.resolution.iter().map(|r| &r.name));
    let materials = places(&sweep.materials, chart.material.iter().map(|m| &m.name));
    let mut keys = Vec::new();
    for &variant in &variants {
        for &resolution in &resolutions {
            for &material in &materials {
                keys.push(GroupKey {
                    scene,
                    variant,
                    resolution,
                    material,
                });
            }
        }
    }
    keys
}

/// Where names stand in a list; the settings see to it that they do.
fn places<'a>(names: &[String], list: impl Iterator<Item = &'a String> + Clone) -> Vec<usize> {
    let place = |name| list.clone().position(|other| other == name);
    names.iter().filter_map(place).collect()
}

/// The runs of a method in a sweep.
fn runs_of(chart: &Chart, sweep: &ChartSweep, name: &str) -> Vec<PlannedRun> {
    let Some(method) = chart.method.iter().position(|m| m.name == *name) else {
        return Vec::new();
    };
    let own = &chart.method[method];
    // A list of the sweep takes the place of a list that the method has.
    fn chosen<'a, T>(own: &'a [T], of_sweep: &'a [T]) -> &'a [T] {
        if own.is_empty() || of_sweep.is_empty() {
            own
        } else {
            of_sweep
        }
    }
    let steps = chosen(&own.steps, &sweep.steps).iter();
    let fractions = chosen(&own.fractions, &sweep.fractions).iter();
    let steps = steps.map(|step| PlannedStep::Seconds(*step));
    let steps = steps.chain(fractions.map(|fraction| PlannedStep::LimitFraction(*fraction)));
    let iterations: Vec<Option<u32>> = match chosen(&own.iterations, &sweep.iterations) {
        [] => vec![None],
        list => list.iter().copied().map(Some).collect(),
    };
    let run = |step| {
        iterations.iter().map(move |&iterations| PlannedRun {
            method,
            step,
            iterations,
        })
    };
    steps.flat_map(run).collect()
}

/// The overrides of a mesh with a material.
pub fn group_overrides(chart: &Chart, key: &GroupKey) -> Vec<String> {
    let scene = &chart.scene[key.scene];
    let mut set = scene.resolution[key.resolution].set.clone();
    set.extend_from_slice(&chart.material[key.material].set);
    // Last, as a variant changes single values of what a material may set as a whole.
    set.extend_from_slice(&scene.variant[key.variant].set);
    set
}

/// The overrides of a run, without those of its step.
pub fn run_overrides(chart: &Chart, key: &GroupKey, run: &PlannedRun) -> Vec<String> {
    let mut set = group_overrides(chart, key);
    set.extend_from_slice(&chart.method[run.method].set);
    if let Some(iterations) = run.iterations {
        set.push(format!("method.iterations={iterations}"));
    }
    set
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::chart;

    #[test]
    fn the_order_is_that_of_the_plan_and_nothing_is_run_twice() {
        let chart = chart();
        let all = groups(&chart, false, &[]);
        let key = |g: &Group| (g.key.scene, g.key.variant, g.key.resolution, g.key.material);
        let keys: Vec<_> = all.iter().map(key).collect();
        // By hand: the quick sweep first, then what the second sweep adds; then the other scene.
        let expected = [
            (0, 0, 0, 0),
            (0, 1, 0, 0),
            (0, 0, 0, 1),
            (0, 0, 1, 0),
            (0, 0, 1, 1),
            (0, 1, 0, 1),
            (0, 1, 1, 0),
            (0, 1, 1, 1),
            (1, 0, 0, 0),
        ];
        assert_eq!(keys, expected);
        let run = |method, step, iterations| PlannedRun {
            method,
            step,
            iterations,
        };
        let (seconds, fraction) = (PlannedStep::Seconds, PlannedStep::LimitFraction);
        // The run of the quick sweep stays in front and is not made again.
        let expected = [
            run(1, seconds(0.01), Some(1)),
            run(0, fraction(0.5), None),
            run(0, fraction(1.5), None),
            run(1, seconds(0.001), Some(1)),
            run(1, seconds(0.001), Some(4)),
            run(1, seconds(0.01), Some(4)),
        ];
        assert_eq!(all[0].runs, expected);
    }

    #[test]
    fn the_quick_chart_and_named_scenes_are_parts_of_it() {
        let chart = chart();
        let quick = groups(&chart, true, &[]);
        let count: Vec<_> = quick.iter().map(|g| (g.key.scene, g.runs.len())).collect();
        assert_eq!(count, [(0, 1), (0, 1), (1, 2)]);
        let named = groups(&chart, false, &["swing".into()]);
        assert!(named.iter().all(|g| g.key.scene == 1) && !named.is_empty());
    }

    #[test]
    fn a_variant_changes_what_a_material_sets() {
        let chart = chart();
        let key = GroupKey {
            scene: 0,
            variant: 1,
            resolution: 1,
            material: 1,
        };
        let run = groups(&chart, false, &[])[0].runs[0];
        assert_eq!(
            run_overrides(&chart, &key, &run),
            [
                "body.0.cells=[8,2,2]",
                "body.0.material.0.discretisation=patches",
                "body.0.material.0.poisson_ratio=0.49",
                "method.name=implicit-euler",
                "method.iterations=1",
            ]
        );
    }
}
