//! `cargo xtask bench` and `cargo xtask soak`: measurements and long checks, by name. Each is an example; those of
//! `microsim-tests` work on the assembled tree.

use crate::child;
use crate::failure::Failure;
use crate::workspace::Workspace;
use std::ffi::OsString;
use std::process::Command;

/// A program with a name.
#[derive(Debug)]
pub struct Program {
    /// On the command line.
    pub name: &'static str,
    /// The example that it is; names of examples differ.
    pub example: &'static str,
    /// What it shows, for the help.
    pub shows: &'static str,
}

/// What `bench` runs.
pub const BENCHES: &[Program] = &[
    Program {
        name: "host",
        example: "bench_host",
        shows: "cost per step of host, bus and recording without physics, p50 and p99",
    },
    Program {
        name: "kernels",
        example: "bench_kernels",
        shows: "cost of forces and of an explicit step per tetrahedron, cache, memory",
    },
    Program {
        name: "solvers",
        example: "bench_solvers",
        shows: "cost of implicit methods: phases, first peak, rest, larger beams",
    },
    Program {
        name: "counts",
        example: "bench_counts",
        shows: "instructions of kernels under callgrind, compared with the recorded ones",
    },
    Program {
        name: "contact",
        example: "bench_contact",
        shows: "contact: two tubes that collide, a thin wall, a vessel with two tools, size",
    },
    Program {
        name: "cutting",
        example: "cut_tick",
        shows: "cutting: a tick that divides about 60 elements, over the size of the body",
    },
    Program {
        name: "coordination",
        example: "bench_coordination",
        shows: "CPU time per picture of 16 ms of each level, shares of the plugins",
    },
    Program {
        name: "levels",
        example: "bench_levels",
        shows: "levels with vessels: CPU time per picture, of the script and of trainees",
    },
    Program {
        name: "cut-error",
        example: "bench_cut_error",
        shows: "what the mesh adds to angle and place of a cut, on other meshes; their cost",
    },
    Program {
        name: "vessels",
        example: "bench_vessels",
        shows: "walls with fibres: cost per element beside rubber, a carotid that is gripped",
    },
    Program {
        name: "store",
        example: "bench_store",
        shows: "50,000 results: finding those of a trainee, export, import, size",
    },
    Program {
        name: "dissertation",
        example: "bench_dissertation",
        shows: "figures of the dissertation, with its methods and with ours",
    },
    Program {
        name: "filters",
        example: "bench_filters",
        shows: "one-euro filters: delay against the tremor that they leave",
    },
    Program {
        name: "pictures",
        example: "bench_pictures",
        shows: "the window: pictures in a second, delay of a motion by stage, by quality",
    },
    Program {
        name: "peers",
        example: "bench_peers",
        shows: "the reference beam in MuJoCo, Drake and pyPBD (from PyPI) and in ours",
    },
];

/// What `soak` runs.
pub const SOAKS: &[Program] = &[
    Program {
        name: "kills",
        example: "soak_kills",
        shows: "200 runs killed by `kill -9`: what of each session can be read",
    },
    Program {
        name: "guests",
        example: "soak_guests",
        shows: "guests that end their process, 20 times each; cost of a process of its own",
    },
    Program {
        name: "digests",
        example: "soak_digests",
        shows: "physics digest of every shipped script and scene, against the recorded ones",
    },
    Program {
        name: "convergence",
        example: "soak_convergence",
        shows: "how far the solver comes in every script, shipped and crippled",
    },
    Program {
        name: "sessions",
        example: "soak_sessions",
        shows: "sessions of up to two hours: CPU per second, memory of report and replay",
    },
    Program {
        name: "igtl",
        example: "soak_igtl",
        shows: "mutated frames of real trackers into the decoder (-- MINUTES SEED)",
    },
    Program {
        name: "trackers",
        example: "soak_trackers",
        shows: "pyigtl and the C++ library of OpenIGTLink as peers, both directions",
    },
    Program {
        name: "cuts",
        example: "soak_cuts",
        shows: "10,000 random cuts of blocks, tubes and filled meshes, checked step by step",
    },
    Program {
        name: "tremor",
        example: "soak_tremor",
        shows: "1,000 strokes of a trembling hand through a body: what still hangs together",
    },
    Program {
        name: "followers",
        example: "soak_followers",
        shows: "1,000 random cuts; model, solver and contact that follow against new ones",
    },
    Program {
        name: "stability",
        example: "cut_stability",
        shows: "500 cuts in a cube, then 10,000 steps with the mass floor and without",
    },
    Program {
        name: "scenes",
        example: "soak_scenes",
        shows: "every shipped scene to its end, and whether what it expects comes out",
    },
    Program {
        name: "trainees",
        example: "soak_trainees",
        shows: "synthetic experts and novices on a level (-- MODULE LEVEL N)",
    },
    Program {
        name: "effects",
        example: "soak_effects",
        shows: "experts against novices: effect sizes, verdicts that change (-- N SEED)",
    },
    Program {
        name: "matrix",
        example: "soak_matrix",
        shows: "every level without physics, friction, cutting, plasticity: none may pass",
    },
    Program {
        name: "training",
        example: "soak_training",
        shows: "60 minutes of all scripts in one process (-- --minutes N): faults, memory",
    },
    Program {
        name: "store",
        example: "soak_store",
        shows: "100 sessions of 10 trainees, half killed: none lost, all as rebuilt",
    },
    Program {
        name: "hands",
        example: "soak_hands",
        shows: "10 hours of random hands on every level (-- SECONDS SEED): held, too slow",
    },
    Program {
        name: "window",
        example: "soak_window",
        shows: "levels by mouse and keys (-- passes), 30 minutes (-- MINUTES SEED), -- memory",
    },
    Program {
        name: "screens",
        example: "soak_screens",
        shows: "every screen of the window, in both languages and two sizes",
    },
    Program {
        name: "levels",
        example: "soak_levels",
        shows: "a picture of each level for the window, as it is trained (-- MODULE...)",
    },
];

/// The program of a name; all of them without one. The error of an unknown name lists the known ones.
pub fn select(
    programs: &'static [Program],
    name: Option<&str>,
) -> Result<Vec<&'static Program>, String> {
    let wanted = |program: &&Program| name.is_none_or(|name| program.name == name);
    let selected: Vec<_> = programs.iter().filter(wanted).collect();
    if selected.is_empty() {
        let names: Vec<_> = programs.iter().map(|program| program.name).collect();
        let name = name.unwrap_or_default();
        return Err(format!(
            "there is no \"{name}\"; there are: {}",
            names.join(", ")
        ));
    }
    Ok(selected)
}

impl Program {
    /// The command that runs it with these arguments, as one would type it.
    pub fn command(&self, arguments: &[OsString]) -> String {
        let is = |program: &Program| program.example == self.example;
        let list = if BENCHES.iter().any(is) {
            "bench"
        } else {
            "soak"
        };
        let mut words = vec![
            "cargo".into(),
            "xtask".into(),
            list.into(),
            self.name.into(),
        ];
        if !arguments.is_empty() {
            words.push("--".into());
        }
        let arguments = arguments.iter().map(|word| word.to_string_lossy());
        words.extend(arguments);
        words.join(" ")
    }
}

/// Runs a program to its end.
pub fn run(
    workspace: &Workspace,
    program: &Program,
    arguments: &[OsString],
) -> Result<(), Failure> {
    let mut cargo = workspace.cargo();
    // With the whole workspace selected, dependencies have the features that they have in tests: what tests have built is not built again.
    let build = ["build", "--release", "--workspace", "--example"];
    cargo.args(build).arg(program.example);
    child::must(&mut cargo)?;
    let file = format!("{}{}", program.example, std::env::consts::EXE_SUFFIX);
    let example = Command::new(workspace.release().join("examples").join(file));
    child::must(workspace.with_tree(example).args(arguments))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_program_has_the_command_that_heads_its_page() {
        let [host] = select(BENCHES, Some("host")).expect("it is there")[..] else {
            panic!("one of this name");
        };
        assert_eq!(host.command(&[]), "cargo xtask bench host");
        let [cuts] = select(SOAKS, Some("cuts")).expect("it is there")[..] else {
            panic!("one of this name");
        };
        let arguments = ["10000", "4242"].map(OsString::from);
        assert_eq!(
            cuts.command(&arguments),
            "cargo xtask soak cuts -- 10000 4242"
        );
    }

    #[test]
    fn a_program_is_found_by_its_name() {
        let names =
            |name| select(SOAKS, name).map(|s| s.iter().map(|p| p.example).collect::<Vec<_>>());
        assert_eq!(names(Some("kills")), Ok(vec!["soak_kills"]));
        assert_eq!(names(None).map(|all| all.len()), Ok(SOAKS.len()));
        let all: Vec<&str> = SOAKS.iter().map(|program| program.name).collect();
        let names_of_all = all.join(", ");
        assert_eq!(
            names(Some("kill")),
            Err(format!("there is no \"kill\"; there are: {names_of_all}"))
        );
    }
}
