//! Which nodes of a group are of which body.

/// A body of a group.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Member {
    /// Index of the body in the scene.
    pub body: usize,
    /// Number of its first node in the group.
    pub first_node: usize,
}
