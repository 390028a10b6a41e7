//! The step of explicit methods on tissue at work: what it may be at rest, and what when stretched.

use crate::scene_file::microseconds;
use microsim_scene::{BodyView, Scene, TOO_LONG, WORKING_STRETCH};

/// The longest steps of each body at rest and at the working stretch: a sentence each; none for a method without a limit.
pub fn statements(scene: &Scene) -> Vec<String> {
    let bodies = scene.bodies().filter(|_| scene.method().is_explicit());
    let sentences = bodies.map(|body| {
        let (at_rest, stretched) = (body.stable_step(), body.stretched_step(WORKING_STRETCH));
        format!(
            "body '{}': {} is stable up to steps of {} at rest, and of {} at a stretch of {WORKING_STRETCH} along any axis ({:.2} times)",
            body.name(),
            scene.method().name(),
            microseconds(at_rest),
            microseconds(stretched),
            stretched / at_rest
        )
    });
    sentences.collect()
}

/// That the step, which stands at `place` and is stable at rest, is not at the working stretch: a sentence for each body.
pub fn warnings(place: &str, step: f64, scene: &Scene) -> Vec<String> {
    let stiffens = |body: &BodyView<'_>| step > TOO_LONG * body.stretched_step(WORKING_STRETCH);
    let bodies = scene.bodies().filter(stiffens);
    let sentences = bodies.map(|body| {
        let stretched = body.stretched_step(WORKING_STRETCH);
        format!(
            "{place}: a step of {} is stable for body '{}' at rest, but at a stretch of {WORKING_STRETCH} it allows {}: where it is stretched so far the run makes {:.1} times as many steps, or use an implicit method",
            microseconds(step),
            body.name(),
            microseconds(stretched),
            step / stretched
        )
    });
    sentences.collect()
}
