//! What a level asks for, from its file: the vessel's axis, what counts as in the lumen, how wide the opening has to be, and which tool does what.

use microsim_sdk::tissue::{VesselAxis, tissue_of};
use microsim_sdk::{Fault, ModuleConfig};
use serde::Deserialize;

/// The region of the wall's elements that is media, and the one that is adventitia.
pub(crate) const MEDIA: u32 = 0;
/// See [`MEDIA`].
pub(crate) const ADVENTITIA: u32 = 1;

/// The model of the tool that is put into the lumen.
const DILATOR: &str = "dilator";

/// The object of the level that shows how wide the opening has to be.
pub(crate) const GAUGE: &str = "gauge";

/// The targets, in their order: the dilator is in the lumen; it is out again, and the opening is wide enough.
pub(crate) const ENTERED: &str = "entered";
/// See [`ENTERED`].
pub(crate) const DILATED: &str = "dilated";

/// The level's keys of this module.
#[derive(Clone, Debug, Deserialize)]
pub(crate) struct Keys {
    /// \[m\]
    pub held_end: [f64; 3],
    /// \[m\]
    pub open_end: [f64; 3],
    /// \[m\]
    pub insertion: f64,
    /// \[m\]
    pub diameter: f64,
    /// \[s\]
    pub dwell: f64,
    pub injury_stretch: f64,
}

/// A level.
#[derive(Clone, Debug)]
pub(crate) struct Site {
    pub keys: Keys,
    pub body: String,
    pub axis: VesselAxis,
    /// The tool that is put into the lumen.
    pub dilator: String,
    /// Tools that hold the vessel meanwhile; a level may have none.
    pub holders: Vec<String>,
    /// Whether the level has an object that shows how wide the opening has to be.
    pub gauge: bool,
}

impl Site {
    /// From the configuration of a level.
    pub fn new(config: &ModuleConfig) -> Result<Self, Fault> {
        let keys: Keys = serde_json::from_value(config.module.clone())?;
        let [from, to] = [keys.held_end, keys.open_end];
        let towards_end = [0, 1, 2].map(|k| to[k] - from[k]);
        let axis = VesselAxis::new(from, towards_end).ok_or_else(|| {
            Fault::new("[module] `open_end` has to lie elsewhere than `held_end`")
        })?;
        let dilators = config.tools.iter().filter(|tool| tool.model == DILATOR);
        let dilators: Vec<String> = dilators.map(|tool| tool.name.clone()).collect();
        let [dilator] = dilators.as_slice() else {
            return Err(Fault::new(format!(
                "the level needs one [[tool]] of the model \"{DILATOR}\"; it has {}",
                dilators.len()
            )));
        };
        let holders = config.holders().into_iter();
        Ok(Self {
            body: tissue_of(config)?,
            axis,
            dilator: dilator.clone(),
            holders: holders.filter(|tool| tool != dilator).collect(),
            gauge: config.objects.iter().any(|object| object.name == GAUGE),
            keys,
        })
    }
}
