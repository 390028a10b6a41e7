//! What the tests of several modules use.

use crate::picture::View;

/// From above, with a field of radius 1.
pub(crate) const VIEW: View = View {
    centre: [0.0; 3],
    field_diameter: 2.0,
    working_distance: 16.0,
    tilt: 0.0,
};
