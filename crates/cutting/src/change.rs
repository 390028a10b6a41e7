//! How a mesh changes where a blade has gone: the methods that the dissertation compares (3.7, 4.2.1).

/// How a mesh changes where a blade has gone. A mesh is valid and conforming after every step with each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TopologyChange {
    /// Elements at crossed edges are taken away: their mass is lost, and the gap is as wide as they were.
    Remove,
    /// Nothing is divided: the mesh comes apart at the faces nearest to the path (Nienhuys and van der Stappen 2000).
    SplitAtFaces,
    /// Crossed edges wait until the blade has left all elements at them; those that it crosses back wait no more. What then is cut in part opens to the
    /// edge opposite (dissertation 4.2.1).
    SemiProgressive,
    /// Crossed edges are divided in the step in which they are crossed, and faces open as soon as the blade has passed them.
    #[default]
    Progressive,
}
