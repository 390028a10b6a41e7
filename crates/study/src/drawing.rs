//! Drawings: SVG by hand, without scripts, fonts or references. Colours stand in [`STYLE`], which knows light and dark.

mod locking;
mod marker;
mod scatter;

pub use locking::{LockingCurve, SIZE as LOCKING_SIZE, locking_plot};
pub use marker::marker;
pub use scatter::{SIZE as SCATTER_SIZE, ScatterPoint, Zone, scatter};

use microsim_drawing::escape;

/// Style of the drawings, for a page or a drawing of its own.
pub const STYLE: &str = include_str!("drawing/style.css");

/// Number of colours of series in the style, and of forms of markers.
pub const SERIES: usize = 12;

/// A complete drawing: `body` on an area of this size, with its own style when it stands alone.
pub fn document(width: f64, height: f64, title: &str, body: &str, alone: bool) -> String {
    let style = if alone {
        format!(
            "<style>{STYLE}</style><rect class=\"ground\" width=\"{width:.0}\" height=\"{height:.0}\"/>"
        )
    } else {
        String::new()
    };
    let space = if alone {
        " xmlns=\"http://www.w3.org/2000/svg\""
    } else {
        ""
    };
    format!(
        "<svg{space} class=\"drawing\" viewBox=\"0 0 {width:.0} {height:.0}\" role=\"img\"><title>{}</title>{style}{body}</svg>",
        escape(title)
    )
}
