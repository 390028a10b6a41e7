//! What the page must and must not hold.

use super::{Page, Pictures};
use crate::testing::{contact, failed_result, input, log, metric, text};
use crate::{Report, ReportInput, Verdict};
use microsim_message::{
    ContactForces, InputSample, LevelEvent, LevelPhase, LevelState, Log, LogLevel, Pose,
    TissueRecovery, ToolSample,
};
use microsim_vocabulary::Language;

const ATTACK: &str = "<script src=\"https://evil.example/x.js\">'&</script>";

/// An English page with a picture of the first tick.
fn page() -> Page {
    Page {
        language: Language::English,
        pictures: Pictures::Drawn([(0, vec![1, 2, 3])].into()),
    }
}

fn tool_sample(tool: &str, time: f64) -> ToolSample {
    ToolSample {
        tool: tool.into(),
        time,
        tracked: true,
        pose: Pose {
            position: [1e-3 * time, 2e-3 * time * time, 0.0],
            ..Pose::default()
        },
        opening: 0.0,
    }
}

/// Every text of a session at once, each of them hostile.
fn hostile() -> Report {
    let mut result = failed_result(&[ATTACK]);
    result.reasons = vec![text(ATTACK)];
    result.categories[0].title = text(ATTACK);
    for metric in &mut result.metrics {
        metric.title = text(ATTACK);
        metric.advice = text(ATTACK);
        metric.display_unit = ATTACK.into();
        metric.formula = ATTACK.into();
        metric.source = ATTACK.into();
        metric.direction = ATTACK.into();
        metric.not_applicable = metric.not_applicable.as_ref().map(|_| text(ATTACK));
        if let Some(limit) = &mut metric.limit {
            limit.source = ATTACK.into();
        }
    }
    let hostile_input = ReportInput {
        tools: [(ATTACK.to_owned(), text(ATTACK))].into(),
        synthetic: Some(ATTACK.into()),
        version: ATTACK.into(),
        trainee: Some(ATTACK.into()),
        module: ATTACK.into(),
        module_title: text(ATTACK),
        level_title: text(ATTACK),
        level_summary: text(ATTACK),
        input: ATTACK.into(),
        without: vec![ATTACK.into()],
        state_hash: Some(ATTACK.into()),
        complaint: Some(ATTACK.into()),
        failures: vec![ATTACK.into()],
        session_file: ATTACK.into(),
        replay_command: ATTACK.into(),
        ..input()
    };
    let log = log(&[
        &InputSample {
            device: ATTACK.into(),
            device_time: 0.0,
            visible: true,
            pose: Pose::default(),
            opening: None,
        },
        &tool_sample(ATTACK, 0.0),
        &tool_sample(ATTACK, 1.0),
        &ContactForces {
            contacts: vec![contact(ATTACK, ATTACK, [1.0, 0.0, 0.0])],
            ..ContactForces::default()
        },
        &LevelEvent {
            id: ATTACK.into(),
            time: 1.0,
            text: text(ATTACK),
        },
        &TissueRecovery {
            body: ATTACK.into(),
            cause: ATTACK.into(),
            substeps: 2,
        },
        &Log {
            level: LogLevel::Warn,
            text: ATTACK.into(),
        },
        &result,
    ]);
    Report::build(&hostile_input, [(0, &log[..])])
}

#[test]
fn all_text_is_escaped() {
    let html = hostile().to_html(&page());
    assert!(!html.contains("<script"));
    assert!(!html.contains("evil.example/x.js\""));
    assert!(html.contains("&lt;script src=&quot;https://evil.example/x.js&quot;&gt;&#39;&amp;"));
}

/// Addresses may stand in plain text only: no attribute, no style sheet refers to anything outside.
#[test]
fn the_page_loads_nothing() {
    let html = hostile().to_html(&page());
    for (at, _) in html.match_indices("://") {
        let before = &html[..at];
        let in_tag = before.rfind('<') > before.rfind('>');
        assert!(!in_tag, "{}", &html[at.saturating_sub(80)..at + 20]);
    }
    for word in ["url(", "@import", "href=", "<link", "<iframe"] {
        assert!(!html.contains(word), "{word}");
    }
    // Pictures are in the page itself.
    assert_eq!(html.matches("<img").count(), 1);
    for (at, _) in html.match_indices("src=\"") {
        assert!(html[at..].starts_with("src=\"data:image/png;base64,"));
    }
}

/// Each element that is opened is closed, in order.
#[test]
fn elements_are_balanced() {
    let html = hostile().to_html(&page());
    let body = &html[html.find("<body").expect("a body")..];
    let mut open: Vec<&str> = Vec::new();
    for tag in body.split('<').skip(1).filter_map(|t| t.split('>').next()) {
        let name = tag.split([' ', '/']).next().unwrap_or_default();
        if let Some(closed) = tag.strip_prefix('/') {
            assert_eq!(
                open.pop(),
                Some(closed).filter(|c| *c != "html"),
                "</{closed}>"
            );
            if closed == "body" {
                return;
            }
        } else if !tag.ends_with('/') && !["input", "br", "img"].contains(&name) {
            open.push(name);
        }
    }
    panic!("no </body>; open: {open:?}");
}

#[test]
fn a_failed_session_says_why() {
    let log = log(&[&failed_result(&["depth", "too-slow"])]);
    let report = Report::build(&input(), [(0, &log[..])]);
    let html = report.to_html(&page());
    assert!(html.contains("class=\"verdict failed\"") && html.contains("Not passed"));
    assert!(html.contains("Reason depth.") && html.contains("Reason too-slow."));
    assert!(html.contains("provisional") && html.contains("no instrument was tracked"));
    // One metric met its limit of 500 mm, one did not, one could not be measured.
    assert_eq!(html.matches("mark good").count(), 1);
    assert_eq!(html.matches("mark bad").count(), 1);
    assert!(html.contains("≤ 500\u{a0}mm") && html.contains("750\u{a0}mm"));
    assert!(!html.contains("class=\"banner"));
}

#[test]
fn a_run_without_something_is_no_result() {
    let mut result = failed_result(&[]);
    result.passed = true;
    let log = log(&[&result]);
    let without = ReportInput {
        without: vec!["physics".into()],
        ..input()
    };
    let report = Report::build(&without, [(0, &log[..])]);
    assert_eq!((report.verdict, report.counts), (Verdict::Passed, false));
    let html = report.to_html(&page());
    assert!(html.contains("This run was computed without physics and does not count."));
    assert!(html.contains("(does not count)") && !html.contains("verdict passed"));
}

/// Killed in tick 8 (of 1/8 s each): what is known stands there, and that there is no result.
#[test]
fn an_incomplete_session_is_shown_as_such() {
    let state = LevelState {
        phase: LevelPhase::Running,
        running: 0.75,
        targets_done: 1,
        targets: 5,
    };
    let cut = ReportInput {
        complaint: Some("cut after 512 bytes".into()),
        state_hash: None,
        ..input()
    };
    let first = log(&[&state]);
    let report = Report::build(&cut, [(0, &first[..]), (7, &[][..])]);
    assert_eq!(
        (report.verdict, report.counts),
        (Verdict::Incomplete, false)
    );
    assert_eq!((report.duration, report.simulated), (0.75, 1.0));
    assert_eq!((report.targets_done, report.targets), (1, 5));
    assert_eq!((report.score, report.failed.len()), (None, 0));
    let html = report.to_html(&page());
    assert!(html.contains("The record ends after 1.0\u{a0}s (state: running)"));
    assert!(html.contains("cut after 512 bytes") && html.contains("none: no clean end"));
}

/// A session of nothing at all, and one with a tool that never moved, are pages too.
#[test]
fn nothing_is_drawn_out_of_nothing() {
    let empty = Report::build(&input(), []).to_html(&page());
    assert!(empty.contains("No sample arrived.") && !empty.contains("<svg"));
    let log = log(&[&tool_sample("right", 0.0)]);
    let lone = Report::build(&input(), [(0, &log[..])]).to_html(&page());
    let drawings = &lone[lone.find("<svg").expect("a drawing")..];
    for nonsense in ["NaN", ">inf", "\"inf", "Minf", "Linf"] {
        assert!(!drawings.contains(nonsense), "{nonsense}");
    }
}

/// The language is the one that is asked for; both are there.
#[test]
fn the_page_opens_in_the_language_asked_for() {
    let log = log(&[&failed_result(&["depth"])]);
    let report = Report::build(&input(), [(0, &log[..])]);
    let german = report.to_html(&Page {
        language: Language::German,
        ..page()
    });
    assert!(german.contains("aria-label=\"Deutsch\" checked>"));
    assert_eq!(german.matches(" checked>").count(), 1);
    assert!(
        report
            .to_html(&page())
            .contains("aria-label=\"English\" checked>")
    );
}

/// A source that begins with the text of its badge is shown without it; one whose limit is not provisional as it is. Bodies have
/// names for people, distinct where there are several.
#[test]
fn names_and_sources_are_for_people() {
    let mut result = failed_result(&["depth"]);
    for (metric, provisional) in result.metrics.iter_mut().zip([true, false]) {
        let limit = metric.limit.as_mut().expect("a limit");
        limit.source = "provisional: by judgement".into();
        limit.provisional = provisional;
    }
    let forces = ContactForces {
        contacts: vec![contact("right", "strip-1", [1.0, 0.0, 0.0])],
        ..ContactForces::default()
    };
    let log = log(&[&forces, &result]);
    let page_of = |bodies: &[&str]| {
        let session = ReportInput {
            bodies: bodies.iter().map(|b| (*b).to_owned()).collect(),
            ..input()
        };
        Report::build(&session, [(0, &log[..])]).to_html(&page())
    };
    let html = page_of(&["strip-1"]);
    assert_eq!(html.matches("by judgement</td>").count(), 2);
    assert_eq!(html.matches("provisional: by judgement").count(), 1);
    assert!(html.contains("right → tissue") && !html.contains("strip-1"));
    assert!(page_of(&["strip-1", "strip-2"]).contains("right → tissue “strip-1”"));
}

/// Without pictures the page states why; a synthetic trainee is called one before anything else.
#[test]
fn what_is_missing_or_made_is_said() {
    let log = log(&[&failed_result(&["depth"])]);
    let made = ReportInput {
        synthetic: Some("novice, seed 3".into()),
        ..input()
    };
    let report = Report::build(&made, [(0, &log[..])]);
    let html = report.to_html(&Page {
        pictures: Pictures::Missing(text("There is no driver.")),
        ..page()
    });
    assert!(html.contains("This page has no pictures:") && html.contains("There is no driver."));
    assert!(!html.contains("<img"));
    let banner = html.find("Synthetic trainee.").expect("a banner");
    assert!(banner < html.find("class=\"verdict").expect("a verdict"));
    assert!(html.contains("novice, seed 3"));
    assert!(
        !Report::build(&input(), [(0, &log[..])])
            .to_html(&page())
            .contains("Synthetic trainee.")
    );
}

/// The error of the tissue is stated in both languages, rounded up; nothing stands there where a level states none.
#[test]
fn the_error_of_the_tissue_is_said() {
    let log = log(&[&failed_result(&["depth"])]);
    let page_of = |model_error| {
        let input = ReportInput {
            model_error,
            ..input()
        };
        Report::build(&input, [(0, &log[..])]).to_html(&page())
    };
    let html = page_of(Some(0.03456));
    assert!(html.contains("by 3.5\u{a0}% differently"));
    assert!(html.contains("um 3,5\u{a0}% anders"));
    assert!(!page_of(None).contains("Accuracy of the tissue"));
}

/// What failed is advised on at the top; in a run that met every limit, what cost most points.
#[test]
fn advice_is_about_what_cost_most() {
    let advice = |result: &microsim_message::TrainingResult| {
        let log = log(&[result]);
        let html = Report::build(&input(), [(0, &log[..])]).to_html(&page());
        let from = html.find("class=\"better\"").expect("advice");
        html[from..][..html[from..].find("</ul>").expect("its end")].to_owned()
    };
    let failed = failed_result(&["depth"]);
    let shown = advice(&failed);
    assert!(
        shown.contains("depth:") && !shown.contains("path-length:"),
        "{shown}"
    );
    let mut passed = failed;
    passed.passed = true;
    (passed.failed, passed.reasons) = (vec![], vec![]);
    for (metric, score) in passed.metrics.iter_mut().zip([80.0, 30.0, 100.0]) {
        metric.within = metric.value.map(|_| true);
        metric.score = Some(score);
    }
    let shown = advice(&passed);
    assert!(
        shown.contains("depth:") && !shown.contains("path-length:"),
        "{shown}"
    );
}

/// A target that was missed is what to do better: the advice spoke of whatever else had cost points. Mistakes are named without a limit, too.
#[test]
fn advice_on_missed_targets_is_about_them() {
    let mut result = failed_result(&["targets-missed"]);
    for metric in &mut result.metrics {
        metric.within = metric.value.map(|_| true);
        metric.score = Some(40.0);
    }
    let mut drops = metric("drops", Some(1.0), None);
    drops.unit = "count".into();
    result.metrics.push(drops);
    let page_of = |result: &microsim_message::TrainingResult| {
        let log = log(&[result]);
        Report::build(&input(), [(0, &log[..])]).to_html(&page())
    };
    let html = page_of(&result);
    let from = html.find("class=\"better\"").expect("advice");
    let shown = &html[from..][..html[from..].find("</ul>").expect("its end")];
    assert!(shown.contains("Reason targets-missed."), "{shown}");
    assert!(shown.contains("drops:"), "{shown}");
    assert!(
        !shown.contains("path-length:") && !shown.contains("depth:"),
        "{shown}"
    );
    // No mistake, no advice on it.
    result.metrics[3].value = Some(0.0);
    assert!(!page_of(&result).contains("drops:"));
}

/// A level that wants a still hand sets no limit to how much it moves, and gives no advice on it either.
#[test]
fn what_has_no_limit_gets_no_advice() {
    let mut result = failed_result(&["depth"]);
    let mut still = metric("bimanual-fraction", Some(0.0), None);
    still.advice = text("Let the other hand take part.");
    result.metrics.push(still);
    let log = log(&[&result]);
    let html = Report::build(&input(), [(0, &log[..])]).to_html(&page());
    assert!(html.contains("Fraction of the time in which both tools move."));
    assert!(!html.contains("Let the other hand take part."));
    assert!(html.contains("Take the direct path."));
}

/// 92.5 stood above, and 92 below for the same score.
#[test]
fn a_score_has_the_same_digits_everywhere() {
    let mut result = failed_result(&["depth"]);
    (result.score, result.categories[0].score) = (92.5, 92.5);
    result.metrics[0].score = Some(92.5);
    let log = log(&[&result]);
    let html = Report::build(&input(), [(0, &log[..])]).to_html(&page());
    // Score, category and metric, in English each.
    assert_eq!(html.matches(">92.5<").count(), 3, "{html}");
    assert!(!html.contains(">92<") && !html.contains(">93<"));
}

/// What lies side by side with different meanings stays apart for eyes without red or green receptors (Machado, Oliveira & Fernandes 2009,
/// severity 1), by a CIE 1976 difference of more than 20; 2.3 is just noticeable.
#[test]
fn colours_that_mean_different_things_differ_to_the_colour_blind() {
    const PROTANOPIA: [[f64; 3]; 3] = [
        [0.152286, 1.052583, -0.204868],
        [0.114503, 0.786281, 0.099216],
        [-0.003882, -0.048116, 1.051998],
    ];
    const DEUTERANOPIA: [[f64; 3]; 3] = [
        [0.367322, 0.860646, -0.227968],
        [0.280085, 0.672501, 0.047413],
        [-0.011820, 0.042940, 0.968881],
    ];
    let style = include_str!("style.css");
    let colour = |selector: &str| -> [f64; 3] {
        let from = style
            .find(selector)
            .unwrap_or_else(|| panic!("no {selector}"));
        let from = from + style[from..].find('#').expect("a colour") + 1;
        [0, 2, 4].map(|k| {
            let byte = u8::from_str_radix(&style[from + k..from + k + 2], 16);
            let value = f64::from(byte.expect("a colour")) / 255.0;
            match value <= 0.04045 {
                true => value / 12.92,
                false => ((value + 0.055) / 1.055).powf(2.4),
            }
        })
    };
    let product = |m: &[[f64; 3]; 3], v: [f64; 3]| {
        m.map(|row| {
            row.iter()
                .zip(v)
                .map(|(a, b)| a * b)
                .sum::<f64>()
                .clamp(0.0, 1.0)
        })
    };
    let lab = |rgb: [f64; 3]| {
        let to_xyz = [
            [0.4124 / 0.95047, 0.3576 / 0.95047, 0.1805 / 0.95047],
            [0.2126, 0.7152, 0.0722],
            [0.0193 / 1.08883, 0.1192 / 1.08883, 0.9505 / 1.08883],
        ];
        let [x, y, z] = product(&to_xyz, rgb).map(|t| match t > 0.008856 {
            true => t.cbrt(),
            false => 7.787 * t + 16.0 / 116.0,
        });
        [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
    };
    let states = [
        ".rail .tracked",
        ".rail .occluded",
        ".rail .stale",
        ".rail .unseen",
    ];
    let gauge = [".gauge .track", ".gauge .allowed"];
    for group in [&states[..], &gauge] {
        for (k, one) in group.iter().enumerate() {
            for other in &group[k + 1..] {
                for eye in [PROTANOPIA, DEUTERANOPIA] {
                    let [a, b] = [one, other].map(|c| lab(product(&eye, colour(c))));
                    let difference = a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>();
                    assert!(
                        difference.sqrt() > 20.0,
                        "{one}, {other}: {}",
                        difference.sqrt()
                    );
                }
            }
        }
    }
}

/// Whoever made a recording elsewhere did not fail this task; the recorded session of a trainee is another matter.
#[test]
fn a_failed_run_of_a_recorded_hand_says_so() {
    let log = log(&[&failed_result(&["depth"])]);
    let page_of = |input_text: &str| {
        let session = crate::ReportInput {
            input: input_text.into(),
            ..input()
        };
        Report::build(&session, [(0, &log[..])]).to_html(&page())
    };
    let said = "whoever made it did not know this task";
    assert!(page_of("recording:hand.csv").contains(said));
    assert!(!page_of("recording:sessions/a.session").contains(said));
    assert!(!page_of("script:level1-fail.toml").contains(said));
}

/// Limits that were loosened, or tissue that is stiffer, are seen on the page; a file's name is text, whatever it is.
#[test]
fn a_level_that_is_not_the_installed_one_says_so() {
    let log = log(&[]);
    let page_of = |files: &[&str]| {
        let session = crate::ReportInput {
            changed_files: files.iter().map(|file| (*file).to_owned()).collect(),
            ..input()
        };
        Report::build(&session, [(0, &log[..])]).to_html(&page())
    };
    let said = "Not the level that was installed.";
    assert!(!page_of(&[]).contains(said));
    let page = page_of(&["modules/a/levels/<b>.toml"]);
    assert!(page.contains(said) && page.contains("levels/&lt;b&gt;.toml"));
}
