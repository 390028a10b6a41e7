//! A body of tissue to draw: its surface as a snapshot has it.

/// Surface of a body. The triangles of one body stay the same from picture to picture unless it is cut; what is prepared for them is found by `body`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tissue {
    /// Which body; any number that is its own.
    pub body: u64,
    /// Ids of the nodes, never used twice.
    pub node_ids: Vec<u32>,
    /// Of each node, field frame \[m\].
    pub positions: Vec<[f32; 3]>,
    /// Where each node lies at rest \[m\]; empty where it is not known.
    pub rest: Vec<[f32; 3]>,
    /// Ids of the nodes at rest that `original` has the places of; empty where they are not known.
    pub original_ids: Vec<u32>,
    /// Where the nodes before any cut lay at rest \[m\]; used where `rest` is empty.
    pub original: Vec<[f32; 3]>,
    /// Three places in `positions` each, anticlockwise from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Of each triangle: whether a cut or tear has opened it; those that are missing are not.
    pub inner: Vec<bool>,
    /// Of each triangle: the region of the mesh behind it; empty where it is not known.
    pub regions: Vec<u32>,
    /// Colour that the level gives, sRGB.
    pub colour: [f32; 3],
    /// Whether it is a vein, whose wall is thin and lets the blood be seen.
    pub vein: bool,
}

impl Tissue {
    /// What makes the tissue undrawable, if anything.
    pub(crate) fn fault(&self) -> Option<&'static str> {
        let nodes = self.positions.len();
        let places = self.positions.iter().chain(&self.rest);
        let of_nodes = |list: usize| list == 0 || list == nodes;
        if !places
            .chain(&self.original)
            .flatten()
            .all(|part| part.is_finite())
        {
            Some("tissue has a node that is not finite")
        } else if !self
            .triangles
            .iter()
            .flatten()
            .all(|&node| (node as usize) < nodes)
        {
            Some("tissue has a triangle with a node that does not exist")
        } else if !of_nodes(self.rest.len()) || !of_nodes(self.node_ids.len()) {
            Some("tissue has another number of nodes at rest, or of their ids, than of nodes")
        } else if self.original_ids.len() != self.original.len() {
            Some("tissue has another number of original nodes than of their ids")
        } else if !(self.regions.is_empty() || self.regions.len() == self.triangles.len()) {
            Some("tissue has another number of regions than of triangles")
        } else if !self.colour.iter().all(|part| (0.0..=1.0).contains(part)) {
            Some("colour must lie within 0..1")
        } else {
            None
        }
    }
}
