//! Tables, drawings and page of a small atlas.

use super::*;

/// A few rows of everything, for what is made of results.
fn small() -> Atlas {
    let variations = [Variation::Plain, Variation::Amplitude(0.1)];
    let scheme = Scheme {
        method: Method::QuasiStatic(newton(20)),
        substance: STABLE,
        step: StepLength::Seconds(0.6),
        drag: 20.0,
        relaxation_time: 0.0,
    };
    let body = subject(Substance::SpringsVolumes, Variation::Plain);
    Atlas {
        limits: limits(Substance::SpringsVolumes, &variations),
        large_steps: large_steps::large_steps(Substance::SpringsVolumes, &body, &[Start::Bent]),
        remedies: remedies::remedies(STABLE, Variation::Node(0.03)),
        recoveries: recover(&scheme, &[Damage::Tip, Damage::Jump], &|| 0.0),
    }
}

#[test]
fn tables_hold_every_run_and_the_page_every_figure() {
    let atlas = small();
    // Explicit Euler has no limit for a large motion.
    assert_eq!((atlas.limits.len(), atlas.agreement().0), (9, 5));
    let tables = atlas.to_csv();
    let rows = [
        atlas.limits.len(),
        atlas.large_steps.len(),
        atlas.remedies.len(),
        atlas.recoveries.len(),
    ];
    for ((name, text), rows) in tables.iter().zip(rows) {
        assert_eq!(text.lines().count(), rows + 1, "{name}");
        // No field here holds a comma but the names of methods and substances, which are quoted.
        let fields = |line: &str| {
            line.split('"')
                .step_by(2)
                .map(|part| part.matches(',').count())
                .sum::<usize>()
        };
        let head = fields(text.lines().next().unwrap());
        assert!(text.lines().all(|line| fields(line) == head), "{name}");
    }
    let info = crate::PageInfo {
        machine: "<a machine>".into(),
        command: "microsim atlas".into(),
        ..crate::PageInfo::default()
    };
    let page = atlas.to_html(&info);
    assert!(
        page.contains("&lt;a machine&gt;")
            && !page.contains("<a machine>")
            && !page.contains("<script")
    );
    let figures = atlas.figures();
    assert_eq!(page.matches("<figure").count(), figures.len());
    // One scheme is no overview.
    assert!(
        figures
            .iter()
            .all(|figure| figure.name != "recovery-overview")
    );
    for figure in &figures {
        assert!(page.contains(&figure.title), "{}", figure.title);
        let svg = figure.to_svg(true);
        let fields = figure.fields.iter().flatten().flatten().count();
        assert!(svg.starts_with("<svg xmlns") && svg.matches("class=\"field ").count() == fields);
        assert_eq!(figure.to_markdown().lines().count(), 2 + figure.rows.len());
    }
    assert_eq!(
        atlas.to_markdown(&info).matches("\n## ").count(),
        figures.len() + 1
    );
}

#[test]
fn materials_with_unexpected_limits_are_named() {
    let mut atlas = small();
    let named = |atlas: &Atlas| {
        let mut sentences = atlas.findings().into_iter();
        sentences.find(|sentence| sentence.contains("springs + volumes (1)"))
    };
    assert_eq!(named(&atlas), None);
    atlas.limits[0].exact *= 1.0 + 2.0 * TOLERANCE;
    assert!(named(&atlas).unwrap().starts_with("Those that differ"));
}
