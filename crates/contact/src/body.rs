//! A body of a detector, with what is kept of it.

use crate::detector::Frame;
use crate::features::Features;
use crate::outward::Outward;
use crate::skin::Skin;
use crate::skin_change::SkinChange;
use crate::tool::Inside;
use crate::tree::Tree;

/// A body.
#[derive(Clone, Debug)]
pub(crate) struct Body {
    /// Its place in the group.
    pub index: u32,
    pub skin: Skin,
    pub tree: Tree,
    pub outward: Outward,
}

/// Lists that are used again and again.
#[derive(Clone, Debug, Default)]
pub(crate) struct Scratch {
    pub features: Features,
    pub inside: Vec<Inside>,
}

impl Body {
    pub fn new(index: u32, skin: Skin) -> Self {
        Self {
            index,
            tree: Tree::new(&skin),
            outward: Outward::default(),
            skin,
        }
    }

    /// Follows a cut.
    pub fn follow(&mut self, change: &SkinChange<'_>) {
        let to = self.skin.follow(change);
        self.tree.follow(&to);
        self.outward = Outward::default();
    }

    /// Positions are new.
    pub fn update(&mut self, frame: &Frame<'_>) {
        self.tree.update(&self.skin, frame);
        self.outward.clear(&self.skin);
    }

    /// How far a node goes in the step \[m\], at most.
    pub fn travel(&self, frame: &Frame<'_>) -> f64 {
        let nodes = self.skin.range();
        let moves = frame.start[nodes.clone()].iter().zip(&frame.now[nodes]);
        let squared = moves.map(|(start, now)| (now - start).norm_squared());
        squared.fold(0.0, f64::max).sqrt()
    }
}
