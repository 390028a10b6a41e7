//! How much is done for a picture.

/// How much is done for a picture. What is seen where is the same in each; [`Renderer::propose`](crate::Renderer::propose) finds the highest that a machine draws in time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Quality {
    /// One sample per pixel, shadows of one softness, little detail: for drivers without a graphics card.
    Low,
    /// Four samples per pixel, penumbrae that widen with distance, ambient occlusion, relief.
    #[default]
    Medium,
    /// The same with more samples of each, a finer surface and depth of field.
    High,
}

impl Quality {
    /// All, from the least.
    pub const ALL: [Self; 3] = [Self::Low, Self::Medium, Self::High];

    /// Its name in files and on screens.
    pub fn name(self) -> &'static str {
        match self {
            Self::Low => "low",
            Self::Medium => "medium",
            Self::High => "high",
        }
    }

    /// The level of a name.
    pub fn of_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|quality| quality.name() == name)
    }

    /// Samples per pixel for smooth edges.
    pub(crate) fn samples(self) -> u32 {
        match self {
            Self::Low => 1,
            _ => 4,
        }
    }

    /// Whether what is hidden from the surroundings is darker.
    pub(crate) fn has_openness(self) -> bool {
        self > Self::Low
    }

    /// Whether what is out of focus is blurred.
    pub(crate) fn has_focus(self) -> bool {
        self == Self::High
    }

    /// Steps of refinement of a body's surface, at most.
    pub(crate) fn steps(self) -> usize {
        match self {
            Self::Low => 1,
            _ => 2,
        }
    }

    /// Number in the shaders.
    pub(crate) fn number(self) -> f64 {
        self as u8 as f64
    }
}
