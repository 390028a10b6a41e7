//! The scripts that pass levels, played without what makes tissue answer: a script that passes then as well shows that the level does not measure it.

use crate::changed_levels::{ChangedLevels, without_plasticity, without_shear_strength};
use crate::{microsim, run, tree};
use std::fs;
use std::path::Path;
use std::time::Instant;
use toml::{Table, Value};

/// What a level is computed without.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Lever {
    /// No tissue at all.
    Physics,
    /// Contacts without friction.
    Friction,
    /// Nothing is cut.
    Cutting,
    /// Tissue that does not flow.
    Plasticity,
    /// Layers that slide on each other without a strength of their own.
    ShearStrength,
    /// Neither of both: what was moved has nothing to stay by.
    Staying,
}

impl Lever {
    /// All, in the order of tables.
    pub const ALL: [Self; 6] = [
        Self::Physics,
        Self::Friction,
        Self::Cutting,
        Self::Plasticity,
        Self::ShearStrength,
        Self::Staying,
    ];

    /// Its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Physics => "physics",
            Self::Friction => "friction",
            Self::Cutting => "cutting",
            Self::Plasticity => "plasticity",
            Self::ShearStrength => "shear strength",
            Self::Staying => "plasticity and shear strength",
        }
    }

    /// How a level is played without it.
    fn means(self) -> Means {
        match self {
            Self::Physics => Means::Option("physics"),
            Self::Friction => Means::Option("friction"),
            Self::Cutting => Means::Option("lonor"),
            Self::Plasticity => Means::Level(without_plasticity),
            Self::ShearStrength => Means::Level(without_shear_strength),
            Self::Staying => {
                Means::Level(|level| without_shear_strength(&without_plasticity(level)))
            }
        }
    }

    /// Whether a level has it.
    fn is_in(self, level: &Table) -> bool {
        let list = |table: &Table, key: &str| {
            let list = table.get(key).and_then(Value::as_array).cloned();
            let tables = list.into_iter().flatten();
            tables
                .filter_map(|entry| entry.as_table().cloned())
                .collect::<Vec<Table>>()
        };
        let number = |value: &Value| {
            let whole = value.as_integer().map(|of| of as f64);
            value.as_float().or(whole)
        };
        match self {
            Self::Physics => level.contains_key("physics"),
            Self::Friction => {
                let contacts = list(level, "contact");
                let mut friction = contacts.iter().filter_map(|of| of.get("friction"));
                friction.any(|of| number(of) != Some(0.0))
            }
            Self::Cutting => !list(level, "cut").is_empty(),
            Self::Staying => Self::Plasticity.is_in(level) && Self::ShearStrength.is_in(level),
            Self::Plasticity | Self::ShearStrength => {
                let (of, key) = match self {
                    Self::Plasticity => ("material", "plasticity"),
                    _ => ("coupling", "shear_strength"),
                };
                let bodies = list(level, "body");
                let mut entries = bodies.iter().flat_map(|body| list(body, of));
                entries.any(|entry| entry.contains_key(key))
            }
        }
    }
}

/// How a level is played without something.
enum Means {
    /// An option `--without` of the program.
    Option(&'static str),
    /// Another text of the level's file.
    Level(fn(&str) -> String),
}

/// A level and what it is computed without.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Entry {
    /// The module.
    pub module: String,
    /// The level, from 1.
    pub level: u32,
    /// What it has, and is played without.
    pub without: Lever,
}

/// What came of an entry.
#[derive(Clone, Debug)]
pub struct Found {
    /// `passed`, `failed`, or `not-judged`: jaws that press where nothing answers may leave forces that mean nothing.
    pub verdict: String,
    /// Reasons against it.
    pub failed: Vec<String>,
    /// Targets reached, of all.
    pub targets: [u64; 2],
    /// How long it took \[s\].
    pub seconds: f64,
}

/// Why a level is passed without something that it has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Passes {
    /// What passes it does not use it.
    Unused(&'static str),
    /// It should not be: what its tissue is described by does not decide.
    Finding(&'static str),
}

/// What is passed all the same; whatever is not here is not.
pub const PASSED: &[(&str, &[u32], Lever, Passes)] = &[
    (
        "coordination",
        &[2],
        Lever::Friction,
        Passes::Unused("one cut in stiff tissue: nothing has to be held"),
    ),
    (
        "diagonal-cut",
        &[3],
        Lever::Friction,
        Passes::Unused("nothing is held: the end is spread from inside"),
    ),
    (
        "diagonal-cut",
        &[3],
        Lever::Cutting,
        Passes::Unused("the scissors lie there to be left alone"),
    ),
    (
        "dilatation",
        &[1],
        Lever::Friction,
        Passes::Unused("nothing is held: the level has the dilator alone"),
    ),
    (
        "trim-blunt",
        &[1],
        Lever::Plasticity,
        Passes::Finding(
            "the shear strength between the layers alone holds the adventitia where it was pushed",
        ),
    ),
    (
        "trim-blunt",
        &[1, 2, 3, 4],
        Lever::ShearStrength,
        Passes::Finding("what the adventitia flowed by alone holds it where it was pushed"),
    ),
];

/// Whether and why a level is known to be passed without something that it has.
pub fn passes(entry: &Entry) -> Option<Passes> {
    let of_it = PASSED.iter().find(|(module, levels, without, _)| {
        *module == entry.module && levels.contains(&entry.level) && *without == entry.without
    });
    of_it.map(|(.., passes)| *passes)
}

/// Every level of the tree with everything that it has.
///
/// # Panics
/// If the tree cannot be read.
pub fn entries() -> Vec<Entry> {
    let listed = microsim(["list", "--json"]).expect(0).json();
    let mut entries = Vec::new();
    for module in listed["modules"].as_array().expect("modules") {
        let name = module["name"].as_str().expect("a name");
        for level in module["levels"].as_array().expect("levels") {
            let number = level["level"].as_u64().expect("a number") as u32;
            let file = tree().join(format!("modules/{name}/levels/level{number}.toml"));
            let text = fs::read_to_string(&file).expect("a level");
            let table: Table = text.parse().expect("TOML");
            let used = Lever::ALL.into_iter().filter(|lever| lever.is_in(&table));
            entries.extend(used.map(|without| Entry {
                module: name.to_owned(),
                level: number,
                without,
            }));
        }
    }
    entries
}

impl Entry {
    /// Its name in messages and of files.
    pub fn name(&self) -> String {
        let without = self.without.name().replace(' ', "-");
        format!("{}-{}-without-{without}", self.module, self.level)
    }

    /// Plays the script that passes the level, its session in `folder`.
    ///
    /// # Panics
    /// If the program cannot run it, or counts it as a result.
    pub fn play(&self, folder: &Path) -> Found {
        let began = Instant::now();
        let Self { module, level, .. } = self;
        let script = tree().join(format!("modules/{module}/scripts/level{level}-pass.toml"));
        let input = format!("script:{}", script.display());
        let level = level.to_string();
        let args = ["--no-pictures", "--level", &level, "--input", &input];
        let session = folder.join(format!("{}.session", self.name()));
        let printed = match self.without.means() {
            Means::Option(what) => {
                let printed = run(
                    module,
                    &session,
                    &[&args[..], &["--without", what]].concat(),
                );
                assert_eq!(printed["counts"], false, "{}: {printed}", self.name());
                printed
            }
            Means::Level(change) => ChangedLevels::new(module, change).run(&session, &args),
        };
        // Sessions are large, and there are many.
        fs::remove_file(&session).expect("the session that was written");
        let failed = printed["failed"].as_array().into_iter().flatten();
        let number = |key: &str| printed[key].as_u64().expect("a number");
        Found {
            verdict: printed["verdict"].as_str().expect("a verdict").to_owned(),
            failed: failed
                .filter_map(|of| of.as_str().map(str::to_owned))
                .collect(),
            targets: [number("targets_done"), number("targets")],
            seconds: began.elapsed().as_secs_f64(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Levels by hand.
    #[test]
    fn what_a_level_has_is_read_from_its_file() {
        let has = |text: &str| {
            let table: Table = text.parse().expect("TOML");
            let used = Lever::ALL.into_iter().filter(|lever| lever.is_in(&table));
            used.map(Lever::name).collect::<Vec<_>>()
        };
        assert!(has("[clock]\ntick = \"8 ms\"\n").is_empty());
        let smooth = "[physics]\n[[contact]]\nfriction = 0\n[[contact]]\nfriction = 0.0\n";
        assert_eq!(has(smooth), ["physics"]);
        let all = "[physics]\n[[contact]]\nfriction = 0\n[[contact]]\nfriction = 0.3\n[[cut]]\ntool = \"right\"\n\
            [[body]]\n[[body.material]]\nregion = 0\n[[body.material]]\nplasticity = { yield_strain = \"5 %\" }\n[[body.coupling]]\nshear_strength = 100\n";
        assert_eq!(has(all), Lever::ALL.map(Lever::name));
    }
}
