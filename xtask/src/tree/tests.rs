//! The assembly on a small repository in a temporary folder.

use super::*;
use std::io::Read;

/// A repository with one plugin and one module, and what cargo would have built of it.
struct Repository {
    folder: tempfile::TempDir,
}

impl Repository {
    fn new() -> Self {
        let repository = Self {
            folder: tempfile::tempdir().unwrap(),
        };
        for (file, text) in [
            ("plugins/objects/Cargo.toml", ""),
            ("plugins/objects/src/lib.rs", ""),
            (
                "plugins/objects/plugin.toml",
                "name = \"objects\"\nlibrary = \"an_objects\"\n",
            ),
            ("plugins/objects/look/grid.csv", "1,2"),
            ("modules/hold/Cargo.toml", ""),
            ("modules/hold/examples/scripts.rs", ""),
            (
                "modules/hold/module.toml",
                "library = \"a_hold\"\n[title]\nlibrary = \"no\"\n",
            ),
            ("modules/hold/levels/level1.toml", "level"),
            ("modules/hold/scripts/level1-pass.toml", "script"),
            ("modules/hold/pictures/level1.png", "a picture"),
            ("modules/hold/README.md", "read me"),
            ("modules/no-package/module.toml", ""),
            ("config/host.toml", "host"),
            ("assets/recordings/a.csv", "t,x"),
            ("assets/docs/picture.png", "for readers"),
            ("assets/.hidden", ""),
            (&format!("release/microsim{EXE_SUFFIX}"), "program"),
            (
                &format!("release/{}", library_file("an_objects")),
                "objects",
            ),
            (&format!("release/{}", library_file("a_hold")), "hold"),
        ] {
            repository.write(file, text);
        }
        repository
    }

    fn path(&self, file: &str) -> PathBuf {
        self.folder.path().join(file)
    }

    fn write(&self, file: &str, text: &str) {
        let path = self.path(file);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    }

    fn tree(&self) -> PathBuf {
        self.path("tree")
    }

    fn assemble(&self) -> Result<(usize, usize), Failure> {
        apply(
            &plan(self.folder.path(), &self.path("release"))?,
            &self.tree(),
        )
    }

    fn in_tree(&self, file: &str) -> Option<String> {
        fs::read_to_string(self.path(&format!("tree/{file}"))).ok()
    }
}

fn library_file(base: &str) -> String {
    format!("{DLL_PREFIX}{base}{DLL_SUFFIX}")
}

fn files_below(folder: &Path) -> Vec<String> {
    let mut plan = Plan::new();
    add_files(&mut plan, folder, Path::new(""), &[]).unwrap();
    plan.keys()
        .map(|file| file.display().to_string().replace('\\', "/"))
        .collect()
}

#[test]
fn the_tree_holds_what_runs_and_nothing_else() {
    let repository = Repository::new();
    assert_eq!(repository.assemble(), Ok((12, 0)));
    let mut expected = vec![
        "assets/recordings/a.csv".to_owned(),
        "config/host.toml".into(),
        format!("microsim{EXE_SUFFIX}"),
        "modules/hold/README.md".into(),
        "modules/hold/levels/level1.toml".into(),
        format!("modules/hold/{}", library_file("a_hold")),
        "modules/hold/module.toml".into(),
        "modules/hold/pictures/level1.png".into(),
        "modules/hold/scripts/level1-pass.toml".into(),
        format!("plugins/objects/{}", library_file("an_objects")),
        "plugins/objects/look/grid.csv".into(),
        "plugins/objects/plugin.toml".into(),
    ];
    expected.sort();
    assert_eq!(files_below(&repository.tree()), expected);
}

#[test]
fn only_what_differs_is_written() {
    let repository = Repository::new();
    repository.assemble().unwrap();
    assert_eq!(repository.assemble(), Ok((0, 0)));
    repository.write("modules/hold/levels/level1.toml", "harder");
    assert_eq!(repository.assemble(), Ok((1, 0)));
    assert_eq!(
        repository
            .in_tree("modules/hold/levels/level1.toml")
            .unwrap(),
        "harder"
    );
}

#[test]
fn what_is_gone_from_the_repository_goes_from_the_tree() {
    let repository = Repository::new();
    repository.assemble().unwrap();
    repository.write("tree/sessions/mine.session", "a session");
    // An entry that changes from file to folder, and one from folder to file.
    fs::remove_file(repository.path("config/host.toml")).unwrap();
    repository.write("config/host.toml/part.toml", "part");
    fs::remove_dir_all(repository.path("plugins/objects/look")).unwrap();
    repository.write("plugins/objects/look", "a file");
    fs::remove_dir_all(repository.path("modules/hold")).unwrap();
    let library = format!("modules/hold/{}", library_file("a_hold"));
    repository.write("tree/installed.b3", &format!("0123  {library}\n"));
    // Six files of the module, config/host.toml and look/grid.csv.
    assert_eq!(repository.assemble(), Ok((2, 8)));
    assert!(!repository.tree().join("modules/hold").exists());
    assert_eq!(
        repository.in_tree("config/host.toml/part.toml").unwrap(),
        "part"
    );
    assert_eq!(
        repository.in_tree("plugins/objects/look").unwrap(),
        "a file"
    );
    assert_eq!(
        repository.in_tree("sessions/mine.session").unwrap(),
        "a session"
    );
}

/// Building again deleted the modules of others.
#[test]
fn guests_in_the_tree_are_left_alone() {
    let repository = Repository::new();
    repository.assemble().unwrap();
    for file in ["modules/theirs/module.toml", "plugins/theirs/plugin.toml"] {
        repository.write(&format!("tree/{file}"), "a guest");
    }
    assert_eq!(repository.assemble(), Ok((0, 0)));
    assert!(repository.in_tree("modules/theirs/module.toml").is_some());
    assert!(repository.in_tree("plugins/theirs/plugin.toml").is_some());
}

#[cfg(unix)]
#[test]
fn an_open_library_stays_as_it_was() {
    let repository = Repository::new();
    repository.assemble().unwrap();
    let library = library_file("a_hold");
    let in_tree = format!("modules/hold/{library}");
    let mut open = fs::File::open(repository.tree().join(&in_tree)).unwrap();
    repository.write(&format!("release/{library}"), "a new one");
    assert_eq!(repository.assemble(), Ok((1, 0)));
    let mut old = String::new();
    open.read_to_string(&mut old).unwrap();
    assert_eq!(old, "hold");
    assert_eq!(repository.in_tree(&in_tree).unwrap(), "a new one");
}

#[cfg(unix)]
#[test]
fn the_program_stays_executable() {
    use std::os::unix::fs::PermissionsExt;
    let repository = Repository::new();
    let built = repository.path("release/microsim");
    fs::set_permissions(&built, fs::Permissions::from_mode(0o755)).unwrap();
    repository.assemble().unwrap();
    let mode = fs::metadata(repository.path("tree/microsim"))
        .unwrap()
        .permissions()
        .mode();
    assert_eq!(mode & 0o777, 0o755);
}

#[test]
fn a_library_that_is_not_there_is_named() {
    let repository = Repository::new();
    repository.write("modules/hold/module.toml", "library = \"another\"\n");
    let Err(Failure::Cannot(text)) = repository.assemble() else {
        panic!("assembled")
    };
    assert!(
        text.contains("module.toml: `library = \"another\"`"),
        "{text}"
    );
    assert!(text.contains(&library_file("another")), "{text}");
    // The key of the table [title] is not the manifest's.
    repository.write(
        "modules/hold/module.toml",
        "name = \"hold\"\n[title]\nlibrary = \"a_hold\"\n",
    );
    let Err(Failure::Cannot(text)) = repository.assemble() else {
        panic!("assembled")
    };
    assert!(text.contains("no key `library`"), "{text}");
}
