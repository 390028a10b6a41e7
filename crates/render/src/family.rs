//! Families of surfaces: which shading a surface has.

/// Families of surfaces, the numbers of the shader.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Family {
    Matte = 0,
    Moist = 1,
    Metal = 2,
    Tissue = 3,
}

impl Family {
    pub const ALL: [Self; 4] = [Self::Matte, Self::Moist, Self::Metal, Self::Tissue];
}
