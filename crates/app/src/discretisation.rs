//! How far the meshes of a file are off with their elements: what `check` warns of.

use microsim_scene::{Behaviour, Material, Scene, SceneSpec};
use microsim_settings::{Document, KeyPath};
use microsim_study::{DiscretisationError, MOST_ELEMENTS, discretisation_error};

/// Displacements that are further off than this are warned of.
const WARNED: f64 = 0.1;

/// What is done about the discretisation error of meshes.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Meshes {
    /// It is estimated: seconds for a mesh of 10,000 tetrahedra.
    Estimated,
    /// Nothing: what an installation holds states its error itself, where it is known.
    Stated,
}

/// A sentence for each body whose displacements are far off, or are not known to be not.
pub fn warnings(document: &Document, spec: &SceneSpec, scene: &Scene) -> Vec<String> {
    let bodies = spec.bodies.iter().zip(scene.bodies()).enumerate();
    let sentences = bodies.filter_map(|(index, (of, body))| {
        let held = body.held();
        let place = document.place(&KeyPath::root().key("body").at(index));
        let elastic = |(_, material): &(u32, Material)| {
            matches!(material.behaviour, Behaviour::Continuum(_))
        };
        let could_be = held.contains(&true) && of.materials.iter().all(elastic);
        if could_be && of.mesh.tets.len() > MOST_ELEMENTS {
            return Some(format!(
                "{place}: how far the mesh of body '{}' is off is not estimated: it has {} tetrahedra, more than {MOST_ELEMENTS}",
                of.name,
                of.mesh.tets.len()
            ));
        }
        let error = discretisation_error(&of.mesh, &of.materials, &held)?;
        sentence(&error).map(|sentence| format!("{place}: body '{}' {sentence}", of.name))
    });
    sentences.collect()
}

/// The sentence about an error that is large enough, with what helps.
fn sentence(error: &DiscretisationError) -> Option<String> {
    let off = |displacement: f64| (displacement - 1.0).abs();
    if off(error.displacement) <= WARNED {
        return None;
    }
    let percent = |displacement: f64| format!("{:.0} %", 100.0 * displacement);
    let helps = if off(error.selective) <= WARNED {
        format!(
            "discretisation = \"selective\" would have {}",
            percent(error.selective)
        )
    } else if off(error.selective) < off(error.displacement) - 0.01 {
        format!(
            "discretisation = \"selective\" would have {}, more needs a finer mesh",
            percent(error.selective)
        )
    } else {
        "it needs a finer mesh".into()
    };
    Some(format!(
        "moves {} as far under its own weight along {} as quadratic elements on its mesh have it: {helps}",
        percent(error.displacement),
        ["x", "y", "z"][error.axis],
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_near_is_not_warned_of_and_what_helps_is_named() {
        let said = |displacement, selective| {
            sentence(&DiscretisationError {
                displacement,
                selective,
                axis: 2,
            })
        };
        assert_eq!(said(0.92, 0.99), None);
        assert_eq!(said(1.09, 1.0), None);
        let has = |sentence: Option<String>, part: &str| {
            assert!(
                sentence.as_ref().is_some_and(|s| s.contains(part)),
                "{sentence:?}"
            );
        };
        has(
            said(0.34, 0.95),
            "moves 34 % as far under its own weight along z",
        );
        has(said(0.34, 0.95), "\"selective\" would have 95 %");
        has(said(0.34, 0.58), "58 %, more needs a finer mesh");
        has(said(0.58, 0.58), "it needs a finer mesh");
        has(said(1.8, 1.02), "moves 180 %");
    }
}
