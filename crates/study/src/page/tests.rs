use super::PageInfo;
use crate::page::panel_svg;
use crate::testing::results;

fn info() -> PageInfo {
    PageInfo {
        machine: "a machine with <2> cores".into(),
        command: "microsim chart --quick".into(),
        date: None,
        notes: vec!["two runs at a time".into()],
        left_out: vec!["Beam & more".into()],
    }
}

/// Checks that tags close in order and attributes are quoted: what a browser would have to guess otherwise. Elements of HTML
/// without an end are named here.
fn assert_well_formed(text: &str) {
    let mut open: Vec<&str> = Vec::new();
    let mut rest = text;
    while let Some(at) = rest.find('<') {
        let tag = &rest[at + 1..];
        let end = tag.find('>').expect("a tag ends");
        let (tag, after) = tag.split_at(end);
        rest = &after[1..];
        assert_eq!(tag.matches('"').count() % 2, 0, "<{tag}>");
        let name = tag
            .trim_start_matches('/')
            .split([' ', '/'])
            .next()
            .unwrap_or_default();
        if tag.starts_with('!') || tag.ends_with('/') || matches!(name, "meta" | "br") {
            continue;
        }
        if tag.starts_with('/') {
            assert_eq!(open.pop(), Some(name), "near {:.80}", rest);
        } else {
            open.push(name);
        }
        if name == "style" && !tag.starts_with('/') {
            rest = &rest[rest.find("</style>").expect("a style ends")..];
        }
    }
    assert_eq!(open, Vec::<&str>::new());
}

#[test]
fn the_page_is_well_formed_loads_nothing_and_holds_every_answer() {
    let results = results();
    let page = results.to_html(&info());
    assert_well_formed(&page);
    for forbidden in [
        "<script",
        "http://",
        "https://",
        "url(",
        "NaN",
        "inf ",
        "<patches>",
        "<2>",
    ] {
        assert!(!page.contains(forbidden), "{forbidden}");
    }
    assert!(
        page.contains("F-bar &lt;patches&gt;") && page.contains("a machine with &lt;2&gt; cores")
    );
    // Three panels: two ratios of the beam, the swing. The swing has no reference, so one drawing; the beams have two each.
    assert_eq!(
        page.matches("<section id=").count(),
        4,
        "with the one on locking"
    );
    assert_eq!(page.matches(">real time<").count(), 5);
    assert!(page.contains("two runs at a time") && page.contains("1 run of the plan left out"));
}

#[test]
fn the_page_depends_on_the_results_alone() {
    assert_eq!(results().to_html(&info()), results().to_html(&info()));
}

#[test]
fn each_drawing_stands_alone() {
    let results = results();
    for panel in results.panels() {
        let svg = panel_svg(&panel, true);
        assert_well_formed(&svg);
        assert!(svg.starts_with("<svg xmlns="));
        assert!(svg.contains("implicit Euler") || panel.id() == "swing");
    }
}

#[test]
fn the_sentences_give_the_answers_of_the_table() {
    let results = results();
    let panels = results.panels();
    // The third run of a group that ends errs by 2 % and costs 0.5: with patches that is the implicit one at 1 ms.
    let sentence = panels[0].sentence();
    assert!(
        sentence.starts_with("An error of 3 % costs least with implicit Euler, F-bar <patches>, mesh S, step 1 ms, 1 iteration: 0.50 CPU s per simulated s"),
        "{sentence}"
    );
    assert!(
        sentence.contains("Diverged: Störmer–Verlet (4 of 8 runs)."),
        "{sentence}"
    );
    assert!(
        sentence.contains("Over budget: implicit Euler (4 of 16 runs)"),
        "{sentence}"
    );
    let swing = panels[2].sentence();
    assert!(
        swing.starts_with("Nothing is known from outside"),
        "{swing}"
    );
    assert!(
        swing.contains("Nothing reaches 3 %. The smallest error is 8.0 %"),
        "{swing}"
    );
    let page = results.to_html(&info());
    assert!(
        page.contains("At the largest ratio, on the finest mesh of each scene, only F-bar &lt;patches&gt; stays within 5.0 %. The worst is linear tetrahedra, off by up to 60 %."),
        "{page}"
    );
}

/// In one drawing two methods of the plan that ships are never drawn alike.
#[test]
fn every_method_of_the_plan_has_a_marker_of_its_own() {
    let text = include_str!("../../../../config/chart.toml");
    let plan = microsim_settings::read_chart(text, "chart.toml").expect("the plan that ships");
    let drawn = |index: usize| {
        let mut out = String::new();
        crate::drawing::marker(&mut out, index, (0.0, 0.0), 5.0, "", "");
        out
    };
    let mut markers: Vec<String> = (0..plan.settings.method.len()).map(drawn).collect();
    markers.sort();
    markers.dedup();
    assert_eq!(markers.len(), plan.settings.method.len());
}
