//! What is chosen.

use microsim_settings::DominantHand;

/// What is to be trained, and by whom.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Choice {
    /// Module.
    pub module: String,
    /// Level, from 1.
    pub level: u32,
    /// A variant of it, instead of the level itself.
    pub variant: Option<String>,
    /// Id of the trainee.
    pub trainee: Option<String>,
    /// The trainee's dominant hand: for the left one the level is mirrored.
    pub hand: DominantHand,
}
