//! The step of explicit methods on tissue at work: what it may be at rest, at the start, and when stretched.

use microsim_scene::{BodyView, Scene, SceneError, SceneSpec, TOO_LONG};

/// The longest steps of each body at rest, at the start if it is prestretched, and at the working stretch: a sentence each; none for a method
/// without a limit.
pub fn statements(spec: &SceneSpec, scene: &Scene) -> Result<Vec<String>, SceneError> {
    if !scene.method().is_explicit() {
        return Ok(Vec::new());
    }
    // The same bodies without prestretches: free of stress in the same shape.
    let mut natural = spec.clone();
    for body in &mut natural.bodies {
        body.mesh.prestretches.clear();
    }
    let natural = Scene::new(&natural)?;
    let sentences = scene.bodies().zip(natural.bodies()).map(|(body, natural)| {
        let (at_rest, at_work) = (natural.stable_step(), body.working_step());
        let at_start = match body.initial_equilibrium() {
            None => String::new(),
            Some(_) => format!(
                ", of {} at the start, stretched by {:.2}",
                microseconds(body.stable_step()),
                body.initial_stretch()
            ),
        };
        format!(
            "body '{}': {} is stable up to steps of {} at rest{at_start}, and of {} at a stretch of {} along any axis ({:.1} times shorter)",
            body.name(),
            scene.method().name(),
            microseconds(at_rest),
            microseconds(at_work),
            stretch(&body),
            at_rest / at_work
        )
    });
    Ok(sentences.collect())
}

/// The working stretch of a body, and where it is from if the scene prescribes it.
fn stretch(body: &BodyView<'_>) -> String {
    let (stretch, prescribed) = (body.working_stretch(), body.prescribed_stretch());
    match stretch == prescribed {
        true => format!("{stretch:.2}, the largest that the scene prescribes,"),
        false => format!("{stretch}"),
    }
}

/// That the step, which stands at `place` and is stable at rest, is not at the working stretch: a sentence for each body.
pub fn warnings(place: &str, step: f64, scene: &Scene) -> Vec<String> {
    let stiffens = |body: &BodyView<'_>| step > TOO_LONG * body.working_step();
    let bodies = scene.bodies().filter(stiffens);
    let sentences = bodies.map(|body| {
        let at_work = body.working_step();
        format!(
            "{place}: a step of {} is stable for body '{}' at the start, but at a stretch of {} it allows {}: where it is stretched so far the run makes {:.1} times as many steps, or use an implicit method",
            microseconds(step),
            body.name(),
            stretch(&body),
            microseconds(at_work),
            step / at_work
        )
    });
    sentences.collect()
}

/// A time \[s\] in microseconds.
pub fn microseconds(time: f64) -> String {
    format!("{:.3} us", time * 1e6)
}
