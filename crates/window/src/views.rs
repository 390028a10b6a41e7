//! What is laid over the picture to see what is computed: chosen by keys or in the panel, with what the colours mean.

use crate::look;
use crate::text::{self, Phrase};
use eframe::egui::{
    Align2, Button, CollapsingHeader, Color32, Event, FontId, Key, Modifiers, Painter, Pos2, Rect,
    Ui, vec2,
};
use microsim_render::{Legend, LegendWords, colour_of};
use microsim_vocabulary::{DebugView, Language};

/// The key of each of [`DebugView::ALL`], with Ctrl: digits alone are speeds of a replay.
const KEYS: [Key; DebugView::ALL.len()] = [
    Key::Num1,
    Key::Num2,
    Key::Num3,
    Key::Num4,
    Key::Num5,
    Key::Num6,
    Key::Num7,
];
/// Of the legend: length and height of the scale, height of a line, distance to what surrounds it \[points\].
const SCALE: [f32; 2] = [220.0, 12.0];
const LINE: f32 = 18.0;
const MARGIN: f32 = 8.0;
/// Steps of the scale.
const STEPS: u32 = 64;

fn name(view: DebugView) -> Phrase {
    match view {
        DebugView::Wireframe => text::WIREFRAME,
        DebugView::Capsules => text::CAPSULES,
        DebugView::NoReturn => text::NO_RETURN,
        DebugView::Contacts => text::CONTACTS,
        DebugView::Stress => text::STRESS,
        DebugView::Quality => text::ELEMENT_QUALITY,
        DebugView::Remedies => text::REMEDIES,
    }
}

/// Lays a view over the picture, or takes it away. Of those that colour surfaces one is there at a time.
fn toggle(views: &mut Vec<DebugView>, view: DebugView) {
    let was_there = views.contains(&view);
    views.retain(|other| {
        let is_replaced = view.colours_surfaces() && other.colours_surfaces();
        *other != view && !is_replaced
    });
    if !was_there {
        views.push(view);
    }
}

/// Does what keys ask for, and takes them from all others.
pub fn press(ui: &Ui, views: &mut Vec<DebugView>) {
    for (view, key) in DebugView::ALL.into_iter().zip(KEYS) {
        let is_pressed = ui.input_mut(|input| {
            let pressed = |event: &Event| {
                let Event::Key {
                    key: of,
                    pressed: true,
                    repeat: false,
                    modifiers,
                    ..
                } = event
                else {
                    return false;
                };
                *of == key && modifiers.matches_logically(Modifiers::CTRL)
            };
            let is_pressed = input.events.iter().any(pressed);
            // Repeats of a key that is held, too.
            input.consume_key(Modifiers::CTRL, key);
            is_pressed
        });
        if is_pressed {
            toggle(views, view);
        }
    }
}

/// Shows which there are, folded away at first, with their keys.
pub fn show(ui: &mut Ui, views: &mut Vec<DebugView>, language: Language) {
    let title = look::quiet(text::VIEWS.of(language));
    let shown = CollapsingHeader::new(title)
        .id_salt("views")
        .show(ui, |ui| {
            for (view, key) in DebugView::ALL.into_iter().zip(KEYS) {
                let (name, control) = (name(view).of(language), text::CONTROL.of(language));
                let text = format!("{name} ({control}+{})", key.symbol_or_name());
                let is_on = views.contains(&view);
                if ui
                    .add(Button::selectable(is_on, look::quiet(text)))
                    .clicked()
                {
                    toggle(views, view);
                }
            }
        });
    // What is unfolded below the edge of the panel is brought into it.
    if shown.header_response.clicked()
        && let Some(body) = shown.body_response
    {
        body.scroll_to_me(None);
    }
}

/// The words of a legend.
pub fn words(language: Language) -> LegendWords<'static> {
    LegendWords {
        stress: text::LEGEND_STRESS.of(language),
        no_stress: text::LEGEND_NO_STRESS.of(language),
        quality: text::LEGEND_QUALITY.of(language),
        remedies: text::LEGEND_REMEDIES.of(language),
        each: [
            text::REMEDY_INERTIA,
            text::REMEDY_INVERTED,
            text::REMEDY_OVERLAP,
            text::REMEDY_REPEATED,
            text::REMEDY_STIFFENED,
            text::REMEDY_HELD,
        ]
        .map(|phrase| phrase.of(language)),
        none: text::REMEDY_NONE.of(language),
        decimal: match language {
            Language::German => ',',
            Language::English => '.',
        },
    }
}

fn colour(colour: [f32; 3]) -> Color32 {
    let [red, green, blue] = colour.map(|part| (255.0 * part).round() as u8);
    Color32::from_rgb(red, green, blue)
}

/// Shows what the colours of surfaces mean, in the lower left corner of the picture: above, a run that pauses has its card.
pub fn legend(painter: &Painter, picture: Rect, legend: &Legend, language: Language) {
    let words = words(language);
    let (classes, numbers) = (legend.classes(&words), legend.numbers(&words));
    let rows = LINE * (1 + classes.len()) as f32;
    let scale = numbers.as_ref().map_or(0.0, |_| SCALE[1] + LINE);
    let size = vec2(SCALE[0] + 2.0 * MARGIN, rows + scale + 2.0 * MARGIN);
    let corner = picture.left_bottom() + vec2(MARGIN, -MARGIN - size.y);
    let inner = corner + vec2(MARGIN, MARGIN);
    painter.rect_filled(Rect::from_min_size(corner, size), 4.0, look::SURFACE);
    let write = |place: Pos2, align, text: &str| {
        let font = FontId::proportional(13.0);
        painter.text(place, align, text, font, look::TEXT);
    };
    write(inner, Align2::LEFT_TOP, legend.title(&words));
    if let Some(numbers) = numbers {
        let top = inner + vec2(0.0, LINE);
        for step in 0..STEPS {
            let [from, to] = [step, step + 1].map(|k| SCALE[0] * k as f32 / STEPS as f32);
            let of = colour_of((f64::from(step) + 0.5) / f64::from(STEPS));
            let part = Rect::from_min_size(top + vec2(from, 0.0), vec2(to - from, SCALE[1]));
            painter.rect_filled(part, 0.0, colour(of));
        }
        let below = top + vec2(0.0, SCALE[1] + 2.0);
        let aligned = [Align2::LEFT_TOP, Align2::CENTER_TOP, Align2::RIGHT_TOP];
        for (part, (number, align)) in numbers.iter().zip(aligned).enumerate() {
            write(
                below + vec2(0.5 * SCALE[0] * part as f32, 0.0),
                align,
                number,
            );
        }
    }
    for (number, (of, name)) in classes.iter().enumerate() {
        let place = inner + vec2(0.0, LINE * (1 + number) as f32);
        let square = Rect::from_min_size(place + vec2(0.0, 3.0), vec2(SCALE[1], SCALE[1]));
        painter.rect_filled(square, 2.0, colour(*of));
        write(place + vec2(LINE + 2.0, 0.0), Align2::LEFT_TOP, name);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eframe::egui::{Context, Event, RawInput};

    /// The views after keys were pressed, and what is left of the keys.
    fn pressed(views: &mut Vec<DebugView>, keys: &[(Key, Modifiers)]) -> usize {
        let event = |&(key, modifiers): &(Key, Modifiers)| Event::Key {
            key,
            physical_key: None,
            pressed: true,
            repeat: false,
            modifiers,
        };
        let input = RawInput {
            events: keys.iter().map(event).collect(),
            ..RawInput::default()
        };
        let mut left = 0;
        let mut output = Context::default().run_ui(input, |ui| {
            press(ui, views);
            left = ui.input(|input| input.events.len());
        });
        output.textures_delta.clear();
        left
    }

    /// Ctrl and a digit lay a view over the picture or take it away; one colour of surfaces takes the place of another, digits alone belong to the speeds.
    #[test]
    fn keys_choose_views() {
        use DebugView::{Quality, Stress, Wireframe};
        let mut views = Vec::new();
        let with_control = |key| (key, Modifiers::CTRL);
        let keys = [Key::Num1, Key::Num5].map(with_control);
        assert_eq!(pressed(&mut views, &keys), 0, "nobody else sees them");
        assert_eq!(views, [Wireframe, Stress]);
        pressed(&mut views, &[with_control(Key::Num6)]);
        assert_eq!(views, [Wireframe, Quality]);
        pressed(&mut views, &[with_control(Key::Num1)]);
        assert_eq!(views, [Quality]);
        assert_eq!(pressed(&mut views, &[(Key::Num6, Modifiers::NONE)]), 1);
        assert_eq!(views, [Quality]);
    }

    /// The order of names is that of the vocabulary; German numbers have a comma.
    #[test]
    fn a_legend_is_in_the_language_of_the_window() {
        let [german, english] = [Language::German, Language::English].map(words);
        assert_eq!(english, LegendWords::ENGLISH);
        let numbers = Legend::Quality.numbers(&german).expect("a scale");
        assert_eq!(numbers, ["0", "0,5", "1"]);
        assert_eq!(Legend::Remedies.classes(&german)[0].1, "Trägheit zugefügt");
    }
}
