//! Tools that cut bodies, from their description.

use crate::error::SceneError;
use crate::jaws;
use crate::lonor::Ability;
use crate::pairs::{Pair, PairPartner};
use crate::spec::{BodySpec, SceneSpec};
use microsim_cutting::TopologyChange;
use microsim_tissue::Method;

/// A tool that cuts a body.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct CutPair {
    pub body: usize,
    pub tool: usize,
    pub ability: Ability,
    pub topology: TopologyChange,
}

/// Why a body cannot be cut with a method.
fn uncuttable(method: &Method, body: &BodySpec) -> Option<&'static str> {
    if body.materials.iter().any(|(_, m)| m.is_quadratic()) {
        return Some(
            "quadratic tetrahedra are not cut, as their eight parts belong together: take another discretisation",
        );
    }
    match method {
        Method::QuasiStatic(_) => Some(
            "quasi-static tissue has no inertia, so that a piece which comes off could not fall: use another method",
        ),
        Method::ExplicitEuler => Some(
            "explicit-euler is held by damping alone, which the stiffer elements that a cut leaves would need more of: use another method",
        ),
        _ => None,
    }
}

/// The cuts of a description.
pub(crate) fn find_cuts(spec: &SceneSpec, pairs: &[Pair]) -> Result<Vec<CutPair>, SceneError> {
    let torn = |body: &&BodySpec| !body.tear_strains.is_empty();
    let mut torn = spec.bodies.iter().filter(torn);
    let found = torn.find_map(|body| Some((body, uncuttable(&spec.method, body)?)));
    if let Some((body, reason)) = found {
        return Err(SceneError::Value {
            body: body.name.clone(),
            what: "cutting",
            index: 0,
            reason,
        });
    }
    let mut cuts: Vec<CutPair> = Vec::new();
    for (index, cut) in spec.cuts.iter().enumerate() {
        let wrong = |reason| SceneError::Cuts {
            index,
            body: cut.body.clone(),
            tool: cut.tool.clone(),
            reason,
        };
        let body = spec.bodies.iter().position(|body| body.name == cut.body);
        let body = body.ok_or_else(|| wrong("no such body"))?;
        let tool = spec.tools.iter().position(|tool| tool.name == cut.tool);
        let tool = tool.ok_or_else(|| wrong("no such tool"))?;
        if cuts.iter().any(|cut| (cut.body, cut.tool) == (body, tool)) {
            return Err(wrong("occurs twice"));
        }
        if !spec.tools[tool].capsules.iter().any(|part| part.lonor) {
            return Err(wrong("the tool has no line of no return"));
        }
        if !jaws::fit(&spec.tools[tool].capsules) {
            return Err(wrong(
                "lines of no return of both jaws must be as many, from the tips to the hinge, and b of one must meet a of the next",
            ));
        }
        if let Some(reason) = uncuttable(&spec.method, &spec.bodies[body]) {
            return Err(wrong(reason));
        }
        let touch = |pair: &Pair| pair.body == body && pair.with == PairPartner::Tool(tool);
        let (of_body, of_tool) = (&spec.bodies[body], &spec.tools[tool]);
        cuts.push(CutPair {
            body,
            tool,
            ability: Ability::new(
                of_tool.sharpness,
                of_body.toughness,
                of_body.brittleness,
                !pairs.iter().any(touch),
            )
            .by(cut.trigger),
            topology: cut.topology,
        });
    }
    Ok(cuts)
}
