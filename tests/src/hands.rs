//! Random players of levels: hands that keep to no script.
//!
//! A player is a function of profile, module, level, seed and length ([`Player`]). It writes a script that is aimed at where the tissue or
//! the targets of the level are, which the built program plays in a process of its own ([`played::play`]).
//!
//! - here: the profiles, the players, and which of them a level permits;
//! - [`stage`]: what of a level a player has to know;
//! - [`hand`]: one tool from place to place, and the script of all tools;
//! - [`motions`]: how each profile moves a hand;
//! - [`played`]: a run of a player, and what came of it;
//! - [`cost`]: CPU time of pictures, as a histogram that can be stored and added up.

pub mod cost;
pub mod hand;
pub mod motions;
pub mod played;
pub mod stage;

use crate::tree;
use microsim_random::SplitMix64;
use stage::{LevelName, Stage};

/// How a player moves.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize, serde::Deserialize,
)]
#[serde(rename_all = "lowercase")]
pub enum Profile {
    /// Reaches, grips or cuts, lets go; half of them follow the script that passes the level, with small errors of aim.
    Calm,
    /// Misses, turns the tool, closes it anyhow, changes its mind; a third of them follow the script that passes.
    Clumsy,
    /// Thrusts through the tissue, closes, pulls and swipes faster than anybody should.
    Violent,
    /// As a calm one, with ten times the tremor of hands and noise in every sample.
    Jittery,
    /// Closes the jaws completely on tissue and moves on with them closed.
    Closing,
    /// Stabs with the tip, one to three times a second.
    Stabbing,
    /// Grips or presses, and drags.
    Dragging,
    /// Opens and closes one to eight times a second and wanders along the tissue.
    Snipping,
    /// The tools cross in the middle of the tissue and exchange their sides.
    Swapping,
    /// As a calm one whose tracker gives single bad samples, jumps and gaps.
    Outliers,
}

impl Profile {
    /// All, in the order of tables.
    pub const ALL: [Self; 10] = [
        Self::Calm,
        Self::Clumsy,
        Self::Violent,
        Self::Jittery,
        Self::Closing,
        Self::Stabbing,
        Self::Dragging,
        Self::Snipping,
        Self::Swapping,
        Self::Outliers,
    ];

    /// Its name on the command line and in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Calm => "calm",
            Self::Clumsy => "clumsy",
            Self::Violent => "violent",
            Self::Jittery => "jittery",
            Self::Closing => "closing",
            Self::Stabbing => "stabbing",
            Self::Dragging => "dragging",
            Self::Snipping => "snipping",
            Self::Swapping => "swapping",
            Self::Outliers => "outliers",
        }
    }

    /// The profile of a name.
    pub fn of(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|profile| profile.name() == name)
    }

    /// What its acts are, of which tables give the number.
    pub fn act(self) -> &'static str {
        match self {
            Self::Calm | Self::Clumsy | Self::Jittery => "touches",
            Self::Violent => "thrusts",
            Self::Closing => "full closures",
            Self::Stabbing => "stabs",
            Self::Dragging => "drags",
            Self::Snipping => "snips",
            Self::Swapping => "crossings",
            Self::Outliers => "bad samples",
        }
    }

    /// Whether a level has what it takes: jaws to close them, two tools to cross them.
    pub fn is_permitted(self, stage: &Stage) -> bool {
        match self {
            Self::Closing | Self::Snipping => stage.tools.iter().any(|tool| tool.jaws),
            Self::Swapping => stage.tools.len() > 1,
            _ => true,
        }
    }
}

/// A random player of a level.
#[derive(Clone, Debug, PartialEq, PartialOrd, serde::Serialize, serde::Deserialize)]
pub struct Player {
    /// The module.
    pub module: String,
    /// The level.
    pub level: LevelName,
    /// How it moves.
    pub profile: Profile,
    /// Of all that is random.
    pub seed: u64,
    /// Length of its script \[s\].
    pub seconds: f64,
}

impl Player {
    /// Its name in messages and of files.
    pub fn name(&self) -> String {
        let (profile, seed) = (self.profile.name(), self.seed);
        format!("{}-{}-{profile}-{seed}", self.module, self.level)
    }

    /// Random numbers of its own; each tool has another `stream`.
    fn random(&self, stream: u64) -> SplitMix64 {
        // FNV-1a over the names, so that players of one seed differ from level to level. On a variant of a level they move as on the level.
        let words = [self.module.as_str(), self.profile.name()];
        let bytes = words.iter().flat_map(|word| word.bytes());
        let hash = bytes.fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
        });
        let mixed = [u64::from(self.level.number), self.seed, stream];
        let state = mixed.iter().fold(hash, |state, number| {
            SplitMix64(state ^ number.wrapping_mul(0x9E37_79B9_7F4A_7C15)).bits()
        });
        SplitMix64(state)
    }
}

/// Every level with tools and a script that passes it, with the profiles that it permits, in the order of their names.
///
/// # Errors
/// The file that cannot be read.
pub fn stages() -> Result<Vec<(Stage, Vec<Profile>)>, String> {
    let folder = tree().join("modules");
    let entries = std::fs::read_dir(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let mut modules: Vec<String> = entries
        .flatten()
        .filter_map(|entry| entry.file_name().into_string().ok())
        .collect();
    modules.sort();
    let mut stages = Vec::new();
    for module in modules {
        for level in levels(&module)? {
            if !stage::passing_script(&module, &level).is_file() {
                continue;
            }
            let stage = Stage::read(&module, &level)?;
            let permitted = Profile::ALL.into_iter().filter(|p| p.is_permitted(&stage));
            let permitted: Vec<Profile> = permitted.collect();
            if !stage.tools.is_empty() {
                stages.push((stage, permitted));
            }
        }
    }
    Ok(stages)
}

/// The levels of a module and their variants, in order.
fn levels(module: &str) -> Result<Vec<LevelName>, String> {
    let folder = tree().join("modules").join(module).join("levels");
    let entries = std::fs::read_dir(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let level = |name: String| {
        let name = name.strip_prefix("level")?.strip_suffix(".toml")?;
        name.parse::<LevelName>().ok()
    };
    let names = entries
        .flatten()
        .map(|entry| entry.file_name().into_string());
    let mut levels: Vec<LevelName> = names.flatten().filter_map(level).collect();
    levels.sort();
    Ok(levels)
}
