//! Every screen in both languages and two sizes, laid out without a display: no text is cut off, none lies on another one.

use crate::debrief;
use crate::launcher::{Launcher, Offer, Wanted};
use crate::ledger::Debrief;
use crate::look;
use crate::pace::{Pace, Samples, Times};
use crate::panels::{self, Instrument, Pictures, Task};
use crate::shortcut::press;
use crate::station::{Catalogue, Choice, LevelEntry, ModuleEntry, ToolEntry, TraineeEntry};
use crate::steering;
use eframe::egui::epaint::ClippedShape;
use eframe::egui::{self, Event, Key, Pos2, RawInput, Rect, Shape, Ui, vec2};
use launcher::Album;
use microsim_controller::{Kind, Presence, Seen};
use microsim_message::{
    CategoryScore, LevelEvent, LevelPhase, LevelState, LimitRecord, LocalText, MetricRecord, Pose,
    ToolState, ToolStatus,
};
use microsim_render::Quality;
use microsim_report::{Moment, MomentKind, ReportBuilder, ReportInput, ToolSeries};
use microsim_settings::{DominantHand, RendererConfig, View};
use microsim_vocabulary::Language;
use std::path::PathBuf;

mod appearance;
mod contrast;
mod editor;
mod launcher;
pub(crate) mod player;
mod records;
mod replay;
mod upkeep;

const LANGUAGES: [Language; 2] = [Language::German, Language::English];
const SIZES: [[f32; 2]; 3] = [[1000.0, 640.0], [1280.0, 720.0], [1920.0, 1080.0]];
/// Texts of neighbours may overlap by what a glyph reaches beyond its line \[points\].
const TOUCH: f32 = 1.5;

fn words(n: usize) -> LocalText {
    let de = [
        "Übergangsgewebe",
        "wird",
        "vorsichtig",
        "zurückgeschoben",
        "und",
        "gehalten",
    ];
    let en = ["adventitia", "is", "pushed", "back", "with", "care"];
    let text = |words: &[&str]| {
        (0..n)
            .map(|k| words[k % words.len()])
            .collect::<Vec<_>>()
            .join(" ")
    };
    LocalText::new(text(&de), text(&en))
}

fn catalogue() -> Catalogue {
    let tool = |slot: &str, de: &'static str, en: &'static str| ToolEntry {
        slot: slot.into(),
        title: LocalText::new(de, en),
    };
    let level = |number| LevelEntry {
        number,
        variant: None,
        title: words(3),
        summary: words(22),
        tools: vec![
            tool("left", "Mikropinzette", "Micro-forceps"),
            tool("right", "Mikroschere", "Micro-scissors"),
        ],
    };
    let module = |index: usize| ModuleEntry {
        name: format!("module-{index}"),
        title: words(2),
        summary: words(14),
        levels: (1..=6).map(level).collect(),
    };
    Catalogue {
        modules: (0..8).map(module).collect(),
        complaints: vec!["modules/broken/module.toml:3: a key that nobody knows".into()],
    }
}

/// Lays a screen out and gives all of its texts: what, where, and what is visible of it.
fn texts(
    size: [f32; 2],
    events: Vec<Event>,
    show: impl FnMut(&mut Ui),
) -> Vec<(String, Rect, Rect)> {
    texts_of(&shapes(size, events, show))
}

fn texts_of(shapes: &[ClippedShape]) -> Vec<(String, Rect, Rect)> {
    let mut found = Vec::new();
    for clipped in shapes {
        collect(&clipped.shape, clipped.clip_rect, &mut found);
    }
    found
}

/// Lays a screen out and gives all that is drawn, in its order.
fn shapes(size: [f32; 2], events: Vec<Event>, mut show: impl FnMut(&mut Ui)) -> Vec<ClippedShape> {
    let context = egui::Context::default();
    look::apply(&context);
    let input = |events| RawInput {
        screen_rect: Some(Rect::from_min_size(Pos2::ZERO, vec2(size[0], size[1]))),
        events,
        ..RawInput::default()
    };
    // Sizes of panels and scroll areas are known from the second pass on.
    for _ in 0..2 {
        let mut output = context.run_ui(input(Vec::new()), &mut show);
        output.textures_delta.clear();
    }
    let mut output = context.run_ui(input(events), &mut show);
    output.textures_delta.clear();
    output.shapes
}

fn collect(shape: &Shape, clip: Rect, found: &mut Vec<(String, Rect, Rect)>) {
    match shape {
        // Row by row, from its first glyph: what goes on in the line of another text begins behind it.
        Shape::Text(text) => found.extend(text.galley.rows.iter().map(|row| {
            let mut place = row.rect();
            if let Some(first) = row.glyphs.first() {
                place.min.x = row.pos.x + first.pos.x;
            }
            (row.text(), place.translate(text.pos.to_vec2()), clip)
        })),
        Shape::Vec(shapes) => shapes.iter().for_each(|shape| collect(shape, clip, found)),
        _ => {}
    }
}

/// What is scrolled out of sight, wholly or at an edge, can be scrolled to; sideways nothing scrolls.
fn check(what: &str, size: [f32; 2], texts: &[(String, Rect, Rect)]) {
    assert!(texts.len() > 5, "{what}: only {} texts", texts.len());
    for (text, place, clip) in texts {
        let beyond = place.left() < clip.left() - TOUCH || place.right() > clip.right() + TOUCH;
        assert!(
            !beyond,
            "{what}, {size:?}: {text:?} at {place:?} is cut off by {clip:?}"
        );
        assert!(
            place.right() <= size[0] + TOUCH,
            "{what}: {text:?} leaves the window"
        );
    }
    for (k, (text, place, clip)) in texts.iter().enumerate() {
        let seen = place.intersect(*clip);
        for (other, other_place, other_clip) in &texts[..k] {
            let both = seen.intersect(other_place.intersect(*other_clip));
            let overlaps = both.width() > TOUCH && both.height() > 2.0 * TOUCH;
            assert!(
                !overlaps,
                "{what}, {size:?}: {text:?} lies on {other:?} in {both:?}"
            );
        }
    }
}

fn everywhere(what: &str, mut show: impl FnMut(&mut Ui, Language)) {
    for language in LANGUAGES {
        for size in SIZES {
            let drawn = shapes(size, Vec::new(), |ui| show(ui, language));
            check(what, size, &texts_of(&drawn));
            contrast::check(what, &drawn);
        }
    }
}

fn trainees() -> Result<Vec<TraineeEntry>, String> {
    let names = [
        "A. Muster",
        "Ein sehr langer Name, der in keine Spalte passt, Freiherr von und zu",
    ];
    let entry = |name: &&str| TraineeEntry {
        id: (*name).into(),
        name: (*name).into(),
    };
    Ok(names.iter().map(entry).collect())
}

/// A microscope over nothing.
fn renderer() -> RendererConfig {
    RendererConfig {
        view: View {
            field: 0.025,
            centre: [0.0; 3],
            tilt: 0.0,
        },
        models: Default::default(),
        bodies: Vec::new(),
        width: 64,
        height: 64,
        caption: None,
        mirrored: false,
        views: Vec::new(),
    }
}

fn show_launcher(ui: &mut Ui, launcher: &mut Launcher, language: Language) -> Option<Wanted> {
    show_launcher_with(ui, launcher, language, &Album::default())
}

fn show_launcher_with(
    ui: &mut Ui,
    launcher: &mut Launcher,
    language: Language,
    album: &Album,
) -> Option<Wanted> {
    let (catalogue, trainees) = (catalogue(), trainees());
    let offer = Offer {
        catalogue: &catalogue,
        trainees: &trainees,
        locked: &|choice| (choice.level > 2).then(|| words(6)),
        pictures: album,
    };
    launcher.show(ui, &offer, language)
}

/// No text has a letter or sign for which a hollow box would stand.
#[test]
fn fonts_have_all_signs_of_all_texts() {
    let context = egui::Context::default();
    look::apply(&context);
    let mut output = context.run_ui(RawInput::default(), |_| ());
    output.textures_delta.clear();
    let font = egui::FontId::proportional(15.0);
    let speeds = crate::console::SPEED_NAMES.map(|name| ("a speed", format!("×{name}")));
    let phrases = crate::text::ALL.iter().flat_map(|(name, phrase)| {
        LANGUAGES.map(|language| (*name, phrase.of(language).to_owned()))
    });
    let missing: Vec<(&str, char)> = context.fonts_mut(|fonts| {
        let signs = phrases
            .chain(speeds)
            .flat_map(|(name, text)| text.chars().map(|sign| (name, sign)).collect::<Vec<_>>());
        signs
            .filter(|(_, sign)| !fonts.has_glyph(&font, *sign))
            .collect()
    });
    assert!(missing.is_empty(), "{missing:?}");
    assert!(!context.fonts_mut(|fonts| fonts.has_glyph(&font, '\u{e123}')));
}

#[test]
fn the_launcher_has_room_for_its_texts() {
    everywhere("launcher", |ui, language| {
        show_launcher(ui, &mut Launcher::default(), language);
    });
}

/// Everything by keyboard: down, right, Enter begins level 2 of the second module.
#[test]
fn the_launcher_is_used_by_keyboard() {
    let mut launcher = Launcher::default();
    let mut wanted = None;
    // All of them between two pictures, as on a slow machine.
    let keys = [Key::ArrowDown, Key::ArrowRight, Key::Enter];
    texts(SIZES[0], keys.map(press).into(), |ui| {
        wanted = show_launcher(ui, &mut launcher, Language::English);
    });
    let choice = Choice {
        module: "module-1".into(),
        level: 2,
        variant: None,
        trainee: None,
        hand: DominantHand::Right,
    };
    assert_eq!(wanted, Some(Wanted::Begin(choice.clone())));
    texts(SIZES[0], vec![press(Key::E)], |ui| {
        wanted = show_launcher(ui, &mut launcher, Language::English);
    });
    assert_eq!(wanted, Some(Wanted::Edit(choice.clone())));

    texts(SIZES[0], [Key::H, Key::Enter].map(press).into(), |ui| {
        wanted = show_launcher(ui, &mut launcher, Language::English);
    });
    let hand = DominantHand::Left;
    assert_eq!(wanted, Some(Wanted::Begin(Choice { hand, ..choice })));
}

/// Behind a level stand its variants, and then the next level.
#[test]
fn the_launcher_goes_through_variants() {
    let mut catalogue = catalogue();
    let soft = LevelEntry {
        variant: Some("soft".into()),
        ..catalogue.modules[0].levels[0].clone()
    };
    catalogue.modules[0].levels.insert(1, soft);
    let trainees = trainees();
    let offer = Offer {
        catalogue: &catalogue,
        trainees: &trainees,
        locked: &|_| None,
        pictures: &Album::default(),
    };
    let mut launcher = Launcher::default();
    let mut seen = Vec::new();
    let keys = [
        Key::ArrowRight,
        Key::ArrowRight,
        Key::ArrowLeft,
        Key::ArrowDown,
    ];
    for key in keys {
        texts(SIZES[0], vec![press(key)], |ui| {
            launcher.show(ui, &offer, Language::English);
        });
        let choice = launcher.choice(&catalogue).expect("a choice");
        seen.push((choice.module, choice.level, choice.variant));
    }
    let at = |module: &str, level, variant: Option<&str>| {
        (module.to_owned(), level, variant.map(str::to_owned))
    };
    let expected = [
        at("module-0", 1, Some("soft")),
        at("module-0", 2, None),
        at("module-0", 1, Some("soft")),
        at("module-1", 1, None),
    ];
    assert_eq!(seen, expected);
}

/// What does not scroll, which is cut off by nothing above the lower edge, ends above it.
fn check_height(what: &str, size: [f32; 2], texts: &[(String, Rect, Rect)]) {
    for (text, place, clip) in texts {
        let scrolls = clip.bottom() < size[1] - TOUCH;
        assert!(
            scrolls || place.bottom() <= size[1],
            "{what}, {size:?}: {text:?} at {place:?}"
        );
    }
}

#[test]
fn the_panels_beside_the_picture_have_room_for_their_texts() {
    let catalogue = catalogue();
    let (module, level) = (&catalogue.modules[0], &catalogue.modules[0].levels[0]);
    let event = |k: usize| LevelEvent {
        id: "target-done".into(),
        time: 3.0 * k as f64,
        text: words(8),
    };
    let events: Vec<LevelEvent> = (0..9).map(event).collect();
    let state = ToolState {
        tool: "right".into(),
        model: "micro-scissors".into(),
        status: ToolStatus::Tracked,
        pose: Pose::default(),
        opening: 0.8,
    };
    let presence = |kind, seen| Presence {
        name: "Microsoft X-Box One S pad".into(),
        kind,
        seen,
    };
    let why = "/dev/input/event7 may not be read: add the user to the group `input` (usermod -aG input NAME) and log in again";
    let presences = [
        presence(Kind::Gamepad, Seen::Here),
        presence(Kind::SpaceMouse, Seen::Here),
        presence(Kind::SpaceMouse, Seen::Gone),
        presence(Kind::Gamepad, Seen::Refused(why.into())),
    ];
    let show = |ui: &mut Ui, language: Language| {
        let task = Task {
            module,
            level,
            mirrored: language == Language::German,
            state: LevelState {
                phase: LevelPhase::Running,
                running: 12.0,
                targets_done: 1,
                targets: 3,
            },
            time: 12.0,
            events: &events,
        };
        let instrument = |index: usize| Instrument {
            tool: &level.tools[index],
            state: Some(&state),
            is_active: index == 1,
            keeps_closed: true,
        };
        egui::Panel::left("task")
            .exact_size(270.0)
            .show(ui, |ui| task.show(ui, language));
        egui::Panel::right("tools")
            .exact_size(270.0)
            .show(ui, |ui| {
                panels::scrolled(ui, |ui| {
                    panels::instruments(ui, &[instrument(0), instrument(1)], language);
                    steering::presences(ui, &presences, language);
                    panels::scope(ui, 8.0, language);
                    let helps = steering::help(&presences);
                    assert_eq!(helps.len(), 2);
                    panels::help(ui, &helps, language);
                    let pictures = Pictures {
                        rate: Some(24.0),
                        delays: &Times::default(),
                        quality: Quality::Low,
                    };
                    let mut pace = Pace::default();
                    pace.samples = Some(Samples::default());
                    panels::pace(ui, &pace, &pictures, language);
                })
            });
    };
    everywhere("panels", show);
    for language in LANGUAGES {
        for size in SIZES {
            check_height(
                "panels",
                size,
                &texts(size, Vec::new(), |ui| show(ui, language)),
            );
        }
    }
}

/// A debrief with as much as a long level leaves behind.
fn long_debrief() -> Debrief {
    let input = ReportInput {
        module_title: words(2),
        level: 2,
        level_title: words(3),
        tick_s: 0.008,
        ..ReportInput::default()
    };
    let mut report = ReportBuilder::new(&input).finish();
    let metric = |within: bool| MetricRecord {
        id: "peak-force".into(),
        title: words(5),
        unit: "N".into(),
        display_unit: "mN".into(),
        display_factor: 1e3,
        direction: "lower-is-better".into(),
        category: "tissue".into(),
        formula: "peak-force/1".into(),
        source: String::new(),
        advice: words(18),
        value: Some(0.0712),
        not_applicable: None,
        limit: Some(LimitRecord {
            min: None,
            max: Some(0.06),
            source: String::new(),
            provisional: true,
            decides: true,
        }),
        within: Some(within),
        score: Some(12.0),
    };
    report.metrics = (0..12).map(|k| metric(k % 3 > 0).into()).collect();
    let category = |n| CategoryScore {
        id: format!("category-{n}"),
        title: words(n),
        score: 33.0 * n as f64,
    };
    report.categories = (1..=3).map(category).collect();
    report.score = Some(66.0);
    report.reasons = vec![words(9), words(14)];
    report.simulated = 200.0;
    let kinds = [
        MomentKind::Begin,
        MomentKind::Grip,
        MomentKind::Cut,
        MomentKind::Tear,
        MomentKind::Event,
    ];
    let moment = |tick: u64| Moment {
        kind: kinds[tick as usize % kinds.len()],
        session_time: 10.0 * tick as f64,
        tick: 1250 * tick,
        text: words(4 + tick as usize),
        event: None,
    };
    report.moments = (0..20).map(moment).collect();
    report.series = vec![ToolSeries {
        tool: "right".into(),
        time: (0..200).map(f64::from).collect(),
        speed: (0..200).map(|k| Some(1e-4 * f64::from(k))).collect(),
        ..ToolSeries::default()
    }];
    Debrief {
        variant: None,
        report,
        session: PathBuf::from("/home/somebody/microsim/sessions/a-long-name-of-a-session.session"),
        page: PathBuf::from("page.html"),
        complaints: vec!["the result is not in the store".into()],
    }
}

#[test]
fn the_debrief_has_room_for_its_texts() {
    let debrief = long_debrief();
    everywhere("debrief", |ui, language| {
        debrief::show(ui, &debrief, true, language);
    });
}
