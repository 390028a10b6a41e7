//! Connected components of a model, and what contact solvers know of it.

use crate::model::TissueModel;
use microsim_contact_solver::{
    Components, ContactOptions, Groups, Projection, RigidComponentOptions, RigidComponents,
};
use std::sync::Arc;

impl TissueModel {
    /// Its connected components.
    pub(crate) fn components(&self) -> &Arc<Components> {
        self.components.get_or_init(|| Arc::new(find(self)))
    }
}

fn find(model: &TissueModel) -> Components {
    let mut groups = Groups::new(model.node_count());
    // What is made of materials couples the nodes of each tetrahedron, and no others.
    let made = model.parts_made().len();
    if made > 0 {
        model.tets().iter().for_each(|tet| groups.join(tet));
    }
    for set in &model.sets()[made..] {
        (0..set.count()).for_each(|element| groups.join(set.nodes(element)));
    }
    Components::of_groups(&mut groups, model.node_count())
}

/// The components of a model as rigid ones.
pub(crate) fn rigid_components(
    model: &TissueModel,
    options: RigidComponentOptions,
) -> RigidComponents {
    RigidComponents::new(
        model.components().clone(),
        model.mean_edge_length(),
        |node| model.inertia(node),
        options,
    )
}

/// Contact of explicit and position-based methods for a model.
pub(crate) fn projection(model: &TissueModel) -> Projection {
    let options = ContactOptions::default();
    Projection::new(
        model.node_count(),
        model.mean_edge_length(),
        model.rate_bound().sqrt(),
        rigid_components(model, options.rigid_components),
        &options,
    )
}

/// Updates it after an edit of the model.
pub(crate) fn follow(projection: &mut Projection, model: &TissueModel) {
    let components = rigid_components(model, projection.options().rigid_components);
    projection.follow(model.node_count(), components);
}
