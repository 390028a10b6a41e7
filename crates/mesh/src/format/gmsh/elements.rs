//! Gmsh's element types.

/// Number of the linear tetrahedron.
pub(super) const TETRAHEDRON: i64 = 4;

/// Number of nodes and name of each element type (Gmsh reference manual, "MSH file format").
const ELEMENT_TYPES: [(i64, usize, &str); 33] = [
    (1, 2, "lines"),
    (2, 3, "triangles"),
    (3, 4, "quadrilaterals"),
    (4, 4, "tetrahedra"),
    (5, 8, "hexahedra"),
    (6, 6, "prisms"),
    (7, 5, "pyramids"),
    (8, 3, "lines"),
    (9, 6, "triangles"),
    (10, 9, "quadrilaterals"),
    (11, 10, CURVED),
    (12, 27, "hexahedra"),
    (13, 18, "prisms"),
    (14, 14, "pyramids"),
    (15, 1, "points"),
    (16, 8, "quadrilaterals"),
    (17, 20, "hexahedra"),
    (18, 15, "prisms"),
    (19, 13, "pyramids"),
    (20, 9, "triangles"),
    (21, 10, "triangles"),
    (22, 12, "triangles"),
    (23, 15, "triangles"),
    (24, 15, "triangles"),
    (25, 21, "triangles"),
    (26, 4, "lines"),
    (27, 5, "lines"),
    (28, 6, "lines"),
    (29, 20, CURVED),
    (30, 35, CURVED),
    (31, 56, CURVED),
    (92, 64, "hexahedra"),
    (93, 125, "hexahedra"),
];

/// Name of the tetrahedra that are not linear.
pub(super) const CURVED: &str = "curved tetrahedra";

/// Number of nodes and name of an element type.
pub(super) fn element_type(number: i64) -> Option<(usize, &'static str)> {
    ELEMENT_TYPES
        .iter()
        .find(|entry| entry.0 == number)
        .map(|&(_, nodes, name)| (nodes, name))
}
