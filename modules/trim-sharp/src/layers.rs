//! The layers of the vessel, by the regions of the level's body.

/// Of the media.
pub(crate) const MEDIA: u32 = 0;
/// Of the adventitia.
pub(crate) const ADVENTITIA: u32 = 1;
