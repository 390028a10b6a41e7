//! The model error that levels state: measured again it is what the files state, and a level whose tissue or mesh was changed without
//! a new figure is found out. `microsim tune --verify` compares with the exact solution on a mesh of three times the cells along each
//! edge, whose values are in the file, and these with a mesh of twice the cells, which it computes.

use microsim_tests::{command, finish, microsim, scratch, tree};
use std::fs;
use std::path::{Path, PathBuf};

const MODULE: &str = "coordination";

/// What has to be installed for a level to be measured: the module, the settings, and no plugin.
fn installation(folder: &Path) -> PathBuf {
    let module = folder.join("modules").join(MODULE);
    for (from, to) in [
        (tree().join("modules").join(MODULE), module.clone()),
        (
            tree().join("modules").join(MODULE).join("levels"),
            module.join("levels"),
        ),
        (tree().join("config"), folder.join("config")),
        (
            tree().join("config").join("tools"),
            folder.join("config").join("tools"),
        ),
    ] {
        fs::create_dir_all(&to).expect("a folder");
        for entry in fs::read_dir(&from).expect("a folder of the tree") {
            let path = entry.expect("an entry").path();
            if path.is_file() {
                fs::copy(&path, to.join(path.file_name().expect("a name"))).expect("a copy");
            }
        }
    }
    fs::create_dir_all(folder.join("plugins")).expect("a folder");
    module.join("levels").join("level1.toml")
}

#[test]
fn the_model_error_of_every_level_is_what_its_file_states() {
    for (module, levels) in [(MODULE, 6), ("push-strip", 4)] {
        for level in 1..=levels {
            let level = level.to_string();
            let printed = microsim(["tune", module, "--level", &level, "--verify"]).expect(0);
            assert!(
                printed.out.contains("confirmed"),
                "{module}, level {level}: {}",
                printed.out
            );
        }
    }
}

/// Each change moves a figure by more than the hundredth of it that is left to rounding.
#[test]
fn a_level_that_was_changed_without_a_new_figure_is_found_out() {
    let folder = scratch();
    let file = installation(folder.path());
    let original = fs::read_to_string(&file).expect("a level");
    let verify = || {
        let mut command = command(["tune", MODULE, "--level", "1", "--verify"]);
        finish(command.arg("--root").arg(folder.path()))
    };
    verify().expect(0);
    for (from, to) in [
        ("cells = [20, 2, 1]", "cells = [20, 3, 1]"),
        ("youngs_modulus = \"60 kPa\"", "youngs_modulus = \"63 kPa\""),
        ("poisson_ratio = 0.45", "poisson_ratio = 0.48"),
        (
            "discretisation = \"selective\"",
            "discretisation = \"patch-pressure\"",
        ),
        ("shift = [\"0.2 mm\", 0, 0]", "shift = [\"0.22 mm\", 0, 0]"),
    ] {
        let changed = original.replacen(from, to, 1);
        assert_ne!(changed, original, "the level has no `{from}`");
        fs::write(&file, changed).expect("a changed level");
        let printed = verify().expect(1);
        assert!(
            printed.out.contains("NOT CONFIRMED"),
            "{to}: {}",
            printed.out
        );
    }
}
