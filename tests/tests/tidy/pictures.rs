//! Pictures of levels: as many as levels, as the window shows them, each with the moment at which it is drawn again.

use crate::{assert_none, files_below, folders, text};
use microsim_tests::{is_variant, scratch};
use std::collections::BTreeSet;
use std::fs;
use std::io::Cursor;
use std::path::Path;

/// Width and height of a picture \[pixels\].
const SIZE: (u32, u32) = (320, 240);
/// Most bytes of all pictures together: they come along with every copy of the repository and every installation.
const MOST: u64 = 3_000_000;

/// What is wrong with the pictures of a module; one without any is as it may be.
fn complaints(module: &Path) -> Vec<String> {
    let folder = module.join("pictures");
    if !folder.is_dir() {
        return Vec::new();
    }
    let stems = |folder: &Path, suffix: &str| -> BTreeSet<String> {
        let mut files = files_below(folder, suffix);
        files.retain(|file| !is_variant(file));
        let stem = |file: &std::path::PathBuf| file.file_stem()?.to_str().map(str::to_owned);
        files.iter().filter_map(stem).collect()
    };
    let levels = stems(&module.join("levels"), ".toml");
    let moments = text(&folder.join("moments.csv"));
    let numbers = moments
        .lines()
        .skip(1)
        .filter_map(|row| row.split(',').next());
    let moments: BTreeSet<String> = numbers.map(|number| format!("level{number}")).collect();
    let mut complaints = Vec::new();
    for (what, found) in [("pictures", stems(&folder, ".png")), ("moments", moments)] {
        if found != levels {
            let place = module.display();
            complaints.push(format!("{place}: {what} of {found:?}, levels {levels:?}"));
        }
    }
    for file in files_below(&folder, ".png") {
        let bytes = fs::read(&file).expect("a picture");
        let size = png::Decoder::new(Cursor::new(bytes))
            .read_info()
            .map(|reader| (reader.info().width, reader.info().height));
        if size.as_ref().ok() != Some(&SIZE) {
            complaints.push(format!("{}: {size:?}, not {SIZE:?}", file.display()));
        }
    }
    complaints
}

#[test]
fn every_level_has_its_picture_and_the_moment_of_it() {
    let modules = folders("modules");
    let found: Vec<String> = modules
        .iter()
        .flat_map(|module| complaints(module))
        .collect();
    assert_none(&found);
    let pictures = modules.iter().map(|module| module.join("pictures"));
    let files: Vec<_> = pictures
        .filter(|folder| folder.is_dir())
        .flat_map(|folder| files_below(&folder, ".png"))
        .collect();
    assert!(files.len() >= 37, "{} pictures", files.len());
    let bytes: u64 = files
        .iter()
        .map(|file| fs::metadata(file).expect("a picture").len())
        .sum();
    assert!(bytes <= MOST, "{bytes} bytes, at most {MOST}");
}

/// The check finds what it looks for.
#[test]
fn missing_and_broken_pictures_are_found() {
    let folder = scratch();
    let module = folder.path();
    assert_none(&complaints(module));
    for place in ["levels", "pictures"] {
        fs::create_dir(module.join(place)).expect("a folder");
    }
    for (file, text) in [
        ("levels/level1.toml", ""),
        ("levels/level2.toml", ""),
        ("levels/level2.soft.toml", ""),
        ("pictures/level1.png", "no picture"),
        ("pictures/moments.csv", "level,seconds\n1,2.5\n2,3\n3,1\n"),
    ] {
        fs::write(module.join(file), text).expect("a file");
    }
    let found = complaints(module).join("\n");
    for part in [
        "pictures of {\"level1\"}, levels {\"level1\", \"level2\"}",
        "moments of {\"level1\", \"level2\", \"level3\"}",
        "level1.png: Err",
    ] {
        assert!(found.contains(part), "no {part:?} in {found}");
    }
    assert_eq!(found.lines().count(), 3, "{found}");
}
