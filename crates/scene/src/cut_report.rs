//! What a tick cut and tore, and what could not be cut.

use microsim_cutting::PathPoints;

/// What a tool cut in a tick, or what tore.
#[derive(Clone, Debug, PartialEq)]
pub struct CutReport {
    /// Index of the body.
    pub body: usize,
    /// Index of the tool; `None` of tissue that tore by itself.
    pub tool: Option<usize>,
    /// Elements that were divided in this tick. A tick that divides and lays nothing open is not reported: all that were divided are counted by
    /// [`BodyView::cut_tally`](crate::BodyView::cut_tally).
    pub divided: usize,
    /// Area that was opened, of one side, at rest \[m²\].
    pub area: f64,
    /// Its centroid at rest, in the world \[m\].
    pub rest_centroid: [f64; 3],
    /// Its mean normal at rest, of length 1.
    pub rest_normal: [f64; 3],
    /// Whether the tick is valid that it is of.
    pub valid: bool,
    /// Where the tool crossed edges of the mesh since it last opened something, at rest; none of a tear.
    pub points: PathPoints,
    /// Its centroid now \[m\].
    pub centroid: [f64; 3],
    /// Its mean normal now, of length 1.
    pub normal: [f64; 3],
    /// Size of the mean force of the tool on the body in the tick \[N\]; 0 where the two do not touch.
    pub force_n: f64,
    /// Numbers of the pieces that came off.
    pub pieces: Vec<u32>,
}

/// A cut that could not be made.
#[derive(Clone, Debug, PartialEq)]
pub struct RejectedCut {
    /// Index of the body.
    pub body: usize,
    /// Index of the tool.
    pub tool: usize,
    /// Why.
    pub why: String,
}
