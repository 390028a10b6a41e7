//! The learning curve of somebody on a level, and where the values of the last attempt stand in populations.

use crate::debrief::decimals;
use crate::ledger::{Learning, Percentile, StandingRow};
use crate::look;
use crate::plot;
use crate::rows::cell;
use crate::text::{self, local, number};
use eframe::egui::{self, Align, RichText, ScrollArea, Ui};
use microsim_vocabulary::Language;

/// A module and one of its levels.
type Level = (String, u32);

/// The level that is shown, of those that were attempted.
#[derive(Debug, Default)]
pub struct Chosen {
    levels: Vec<Level>,
    level: Option<Level>,
    learning: Option<Learning>,
}

impl Chosen {
    /// The first of them, with its curve.
    pub fn new(levels: impl Iterator<Item = Level>, learning: Option<Learning>) -> Self {
        let levels: Vec<Level> = levels.collect();
        Self {
            level: levels.first().cloned(),
            levels,
            learning,
        }
    }

    /// Another one.
    pub fn take(&mut self, level: Level, learning: Option<Learning>) {
        (self.level, self.learning) = (Some(level), learning);
    }
}

/// Shows it; gives the level that was asked for instead.
pub fn show(ui: &mut Ui, chosen: &mut Chosen, language: Language) -> Option<Level> {
    let Some(shown) = chosen.level.clone() else {
        ui.label(text::NO_RESULTS.of(language));
        return None;
    };
    let mut level = shown.clone();
    let name = |(module, level): &Level| format!("{module}, {} {level}", text::LEVEL.of(language));
    egui::ComboBox::from_id_salt("level")
        .selected_text(name(&shown))
        .width(320.0)
        .show_ui(ui, |ui| {
            for known in &chosen.levels {
                ui.selectable_value(&mut level, known.clone(), name(known));
            }
        });
    if let Some(learning) = &chosen.learning {
        ScrollArea::vertical()
            .id_salt("learning")
            .auto_shrink(false)
            .show(ui, |ui| {
                show_curve(ui, learning, language);
                ui.add_space(8.0);
                show_standings(ui, &learning.standings, language);
            });
    }
    (level != shown).then_some(level)
}

fn show_curve(ui: &mut Ui, learning: &Learning, language: Language) {
    let percent = |rate: f64| format!("{} %", number(100.0 * rate, 0, language));
    let [acceptable, unacceptable] = learning.rates.map(percent);
    let title = format!(
        "CUSUM · {} {acceptable} · {} {unacceptable}",
        text::ACCEPTABLE.of(language),
        text::UNACCEPTABLE.of(language)
    );
    plot::attempts(ui, &title, &learning.values, learning.limits, language);
    let attempts = learning.values.len();
    let (sentence, colour) = match learning.decision {
        None if attempts == 0 => (text::NO_RESULTS.of(language).to_owned(), look::QUIET),
        None => (text::NOT_DECIDED.of(language).to_owned(), look::QUIET),
        Some((attempt, is_acceptable)) => {
            let (phrase, colour) = match is_acceptable {
                true => (text::IS_ACCEPTABLE, look::GOOD),
                false => (text::IS_UNACCEPTABLE, look::BAD),
            };
            (format!("{} {attempt}", phrase.of(language)), colour)
        }
    };
    ui.label(RichText::new(sentence).color(colour));
    ui.label(look::quiet(text::CUSUM_EXPLAINED.of(language)));
}

fn show_standings(ui: &mut Ui, standings: &[StandingRow], language: Language) {
    ui.label(look::heading(text::PERCENTILES.of(language)));
    if standings.is_empty() {
        ui.label(look::quiet(text::NO_POPULATION.of(language)));
    }
    for standing in standings {
        let value = number(standing.value, decimals(standing.value), language);
        let percent = |p: f64| number(p, 0, language);
        let percentile = match standing.percentile {
            Percentile::At(p) => percent(p),
            Percentile::Below(p) => format!("< {}", percent(p)),
            Percentile::Above(p) => format!("> {}", percent(p)),
        };
        ui.horizontal(|ui| {
            let title = (ui.available_width() - 330.0).max(120.0);
            cell(ui, title, Align::Min, local(&standing.title, language));
            cell(ui, 110.0, Align::Max, format!("{value} {}", standing.unit));
            let percentile = RichText::new(percentile).strong().color(look::ACCENT);
            cell(ui, 60.0, Align::Max, percentile);
            let of = format!("{} ({})", standing.source, standing.size);
            cell(ui, 120.0, Align::Min, look::quiet(of));
        });
    }
}
