//! What `--view` asks for: views that can be laid over one picture.

use microsim_settings::DebugView;

/// Views of the pictures of a scene file: where it is touched, and lines of no return, are not among them.
const OF_SCENE: [DebugView; 5] = [
    DebugView::Wireframe,
    DebugView::Capsules,
    DebugView::Stress,
    DebugView::Quality,
    DebugView::Remedies,
];

/// Refuses several views that colour the same surfaces.
pub fn check(views: &[DebugView]) -> Result<(), String> {
    let colouring = views.iter().filter(|view| view.colours_surfaces());
    let mut names: Vec<&str> = colouring.map(|view| view.name()).collect();
    // The same one may be asked for again.
    names.dedup();
    match names.len() {
        0 | 1 => Ok(()),
        _ => Err(format!(
            "--view {}: surfaces have one colour; ask for one of them",
            names.join(", --view ")
        )),
    }
}

/// The same of a scene file, of which less is known.
pub fn check_of_scene(views: &[DebugView]) -> Result<(), String> {
    check(views)?;
    match views.iter().find(|view| !OF_SCENE.contains(view)) {
        None => Ok(()),
        Some(view) => Err(format!(
            "--view {}: pictures of a scene show {}",
            view.name(),
            OF_SCENE.map(DebugView::name).join(", ")
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn surfaces_have_one_colour() {
        use DebugView::{Contacts, Quality, Stress, Wireframe};
        assert_eq!(check(&[Wireframe, Stress, Contacts]), Ok(()));
        let why = check(&[Stress, Wireframe, Quality]).expect_err("two colours");
        assert!(why.contains("--view stress, --view quality"), "{why}");
        assert_eq!(check_of_scene(&[Wireframe, Stress]), Ok(()));
        let why = check_of_scene(&[Contacts]).expect_err("not known");
        assert!(
            why.contains("contacts") && why.contains("wireframe, capsules"),
            "{why}"
        );
    }
}
