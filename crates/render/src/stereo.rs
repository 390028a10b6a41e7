//! One picture, or one per eye, and how both lie in one image.

/// Distance between the two paths of light in the main lens of an operating microscope \[m\]: 22 to 25 mm are usual.
pub const STEREO_BASE: f64 = 0.024;

/// How both eyes' pictures lie in one image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum StereoLayout {
    /// One picture, from between the eyes.
    #[default]
    Mono,
    /// The left eye's in the left half.
    SideBySide,
    /// The left eye's in the upper half.
    TopBottom,
    /// The left eye's in the rows 0, 2, 4 … from the top: screens with polarised rows.
    RowInterleaved,
    /// The left eye's brightness in red, the right eye's in green and blue.
    RedCyan,
}

/// One picture or two, and the distance between the eyes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stereo {
    /// How they lie in the image.
    pub layout: StereoLayout,
    /// Between both eyes, in the plane of the main lens \[m\]; negative exchanges them. Their axes cross in the focus point, their planes of focus
    /// are one: what lies there has no parallax (off-axis frusta).
    pub base: f64,
}

impl Default for Stereo {
    fn default() -> Self {
        Self {
            layout: StereoLayout::Mono,
            base: STEREO_BASE,
        }
    }
}

impl Stereo {
    /// Places of the eyes across the view axis \[m\].
    pub(crate) fn eyes(&self) -> &'static [f64] {
        match self.layout {
            StereoLayout::Mono => &[0.0],
            _ => &[-0.5, 0.5],
        }
    }

    /// Size of one eye's picture in an image of this size \[pixels\].
    pub(crate) fn eye_size(&self, (width, height): (u32, u32)) -> (u32, u32) {
        match self.layout {
            StereoLayout::SideBySide => (width.div_ceil(2), height),
            StereoLayout::TopBottom => (width, height.div_ceil(2)),
            _ => (width, height),
        }
    }

    /// Number of the layout in the shader.
    pub(crate) fn number(&self) -> u32 {
        match self.layout {
            StereoLayout::Mono => 0,
            StereoLayout::SideBySide => 1,
            StereoLayout::TopBottom => 2,
            StereoLayout::RowInterleaved => 3,
            StereoLayout::RedCyan => 4,
        }
    }
}
