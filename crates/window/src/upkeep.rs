//! Courses, and the store as a whole: files that are read into it, exports, checks, rebuilding.

use crate::ledger::{Change, CourseEntry, Done, Ledger, Participant, Work};
use crate::look;
use crate::rows::{LINE, TWO_LINES, cell, row};
use crate::shortcut;
use crate::text::{self, Phrase, local};
use crate::work::{Running, left};
use eframe::egui::{
    self, Align, Button, Label, Layout, ProgressBar, RichText, ScrollArea, TextEdit, Ui,
};
use microsim_message::LocalText;
use microsim_vocabulary::Language;
use std::path::PathBuf;
use std::time::Duration;

/// Width of the buttons beside a line for a path \[points\].
const BUTTONS: f32 = 260.0;
/// Height of what is stated of work: four lines \[points\].
const SPOKEN: f32 = 84.0;

/// What the operator asked for.
#[derive(Debug, PartialEq, Eq)]
pub enum Wanted {
    /// Trainees and results.
    Back,
    /// The other language.
    Language,
}

/// A sentence that stays until something else is done.
#[derive(Clone, Debug)]
struct Spoken {
    is_complaint: bool,
    sentences: Vec<LocalText>,
}

/// What the screen shows, and what is entered on it.
#[derive(Debug, Default)]
pub struct Upkeep {
    courses: Vec<CourseEntry>,
    groups: Vec<String>,
    /// Name of the course that is shown.
    chosen: Option<String>,
    /// The group to be enrolled.
    group: Option<String>,
    /// Whether the course is about to be removed.
    is_removing: bool,
    /// Path of the file to be read.
    file: String,
    /// Path of one more folder with sessions.
    folder: String,
    /// Path of an export, once it was changed.
    export: Option<String>,
    running: Option<Running>,
    spoken: Option<Spoken>,
}

impl Upkeep {
    /// Reads again what is there.
    pub fn read(&mut self, ledger: &dyn Ledger) {
        let read = ledger
            .courses()
            .and_then(|courses| Ok((courses, ledger.groups()?)));
        match read {
            Ok((courses, groups)) => (self.courses, self.groups) = (courses, groups),
            Err(why) => {
                (self.courses, self.groups) = (Vec::new(), Vec::new());
                self.complain(why);
            }
        }
        let chosen = self.chosen.take();
        self.chosen = chosen.filter(|name| self.courses.iter().any(|c| c.name == *name));
        self.is_removing = false;
    }

    /// In both languages what commands state in one.
    fn complain(&mut self, why: String) {
        self.spoken = Some(Spoken {
            is_complaint: true,
            sentences: vec![text::NOT_DONE.both(), LocalText::new(why.clone(), why)],
        });
    }

    /// Takes what was dropped onto the window; whether there was anything. A path without extension is that of a folder.
    pub fn take_dropped(&mut self, context: &egui::Context) -> bool {
        let dropped = context.input(|input| input.raw.dropped_files.clone());
        let Some(first) = dropped.first() else {
            return false;
        };
        let place = match first.path().extension() {
            Some(_) => &mut self.file,
            None => &mut self.folder,
        };
        let complaint = match first.path().to_str() {
            Some(path) => {
                path.clone_into(place);
                (dropped.len() > 1).then_some(text::ONE_AT_A_TIME)
            }
            None => Some(text::NOT_UTF8),
        };
        // What came of earlier work is not about this file; what is wrong with the store still is.
        self.spoken = self.spoken.take().filter(|spoken| spoken.is_complaint);
        if let Some(phrase) = complaint {
            self.spoken = Some(Spoken {
                is_complaint: true,
                sentences: vec![phrase.both()],
            });
        }
        true
    }

    fn change(&mut self, ledger: &dyn Ledger, change: &Change) {
        self.spoken = None;
        match ledger.change(change) {
            Ok(()) => self.read(ledger),
            Err(why) => self.complain(why),
        }
    }

    fn begin(&mut self, ledger: &dyn Ledger, work: &Work, context: &egui::Context) {
        self.spoken = None;
        let context = context.clone();
        match Running::start(ledger.job(work), move || context.request_repaint()) {
            Ok(running) => self.running = Some(running),
            Err(why) => self.complain(why),
        }
    }

    /// Takes what came of work that has ended.
    fn take_end(&mut self, ledger: &dyn Ledger) {
        let Some(running) = self.running.take_if(|running| running.has_ended()) else {
            return;
        };
        self.read(ledger);
        match running.end() {
            Err(why) => self.complain(why),
            Ok(Done { is_good, sentences }) => {
                self.spoken = Some(Spoken {
                    is_complaint: !is_good,
                    sentences,
                });
            }
        }
    }

    /// Shows it.
    pub fn show(&mut self, ui: &mut Ui, ledger: &dyn Ledger, language: Language) -> Option<Wanted> {
        self.take_dropped(ui.ctx());
        self.take_end(ledger);
        let mut wanted = None;
        egui::Panel::top("upkeep")
            .show_separator_line(false)
            .show(ui, |ui| {
                ui.add_space(6.0);
                ui.horizontal(|ui| {
                    ui.heading(text::UPKEEP.of(language));
                    ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                        if shortcut::button(ui, text::BACK_TO_RECORDS.of(language), shortcut::BACK)
                        {
                            wanted = Some(Wanted::Back);
                        }
                        if shortcut::button(ui, text::LANGUAGE.of(language), shortcut::LANGUAGE) {
                            wanted = Some(Wanted::Language);
                        }
                    });
                });
                ui.add_space(4.0);
            });
        egui::Panel::bottom("work").show(ui, |ui| self.show_work(ui, ledger, language));
        egui::Panel::left("all courses")
            .exact_size(340.0)
            .resizable(false)
            .show(ui, |ui| self.show_courses(ui, language));
        let change = egui::CentralPanel::default()
            .show(ui, |ui| self.show_course(ui, language))
            .inner;
        if let Some(change) = change {
            self.change(ledger, &change);
        }
        wanted
    }

    fn show_courses(&mut self, ui: &mut Ui, language: Language) {
        if self.courses.is_empty() {
            ui.add(Label::new(look::quiet(text::NO_COURSES.of(language))).wrap());
        }
        let mut pressed = None;
        ScrollArea::vertical()
            .id_salt("all courses")
            .auto_shrink(false)
            .show_rows(ui, TWO_LINES, self.courses.len(), |ui, range| {
                for course in &self.courses[range] {
                    let is_chosen = self.chosen.as_ref() == Some(&course.name);
                    if row(ui, TWO_LINES, is_chosen, &course.name, |ui| {
                        show_entry(ui, course, language);
                    }) {
                        pressed = Some((!is_chosen).then(|| course.name.clone()));
                    }
                }
            });
        if let Some(chosen) = pressed {
            (self.chosen, self.is_removing) = (chosen, false);
        }
    }

    /// The course that is chosen; gives what is to be changed of it.
    fn show_course(&mut self, ui: &mut Ui, language: Language) -> Option<Change> {
        let chosen = self.chosen.as_ref();
        let course = self.courses.iter().find(|c| Some(&c.name) == chosen);
        let Some(course) = course else {
            if !self.courses.is_empty() {
                ui.label(look::quiet(text::CHOOSE_COURSE.of(language)));
            }
            return None;
        };
        let name = || course.name.clone();
        let mut change = None;
        let title = look::heading(local(&course.title, language));
        ui.add(Label::new(title).truncate());
        ScrollArea::vertical()
            .id_salt("course")
            .auto_shrink(false)
            .show(ui, |ui| {
                let enrol = |group: &str, takes| {
                    Some(Change::Enrol {
                        who: Participant::Group(group.to_owned()),
                        course: name(),
                        takes,
                    })
                };
                ui.label(text::TAKEN_BY.of(language));
                for group in &course.groups {
                    ui.horizontal(|ui| {
                        if ui.small_button(text::TAKE_OUT.of(language)).clicked() {
                            change = enrol(group, false);
                        }
                        ui.add(Label::new(group).truncate());
                    });
                }
                if course.groups.is_empty() {
                    ui.label(look::quiet(text::NO_GROUP_TAKES_IT.of(language)));
                }
                let others = self.groups.iter();
                let others = others.filter(|group| !course.groups.contains(group));
                let others: Vec<&String> = others.collect();
                let is_there = |group: &String| others.contains(&group);
                let group = self.group.take().filter(is_there);
                self.group = group.or_else(|| others.first().map(|group| (*group).clone()));
                if let Some(group) = &mut self.group {
                    ui.horizontal(|ui| {
                        if ui.button(text::ENROL_GROUP.of(language)).clicked() {
                            change = enrol(group, true);
                        }
                        egui::ComboBox::from_id_salt("group to enrol")
                            .selected_text(group.clone())
                            .width(ui.available_width())
                            .truncate()
                            .show_ui(ui, |ui| {
                                for other in others {
                                    ui.selectable_value(group, other.clone(), other);
                                }
                            });
                    });
                }
                if !course.trainees.is_empty() {
                    let by_themselves = text::BY_THEMSELVES.of(language);
                    let count = format!("{} {by_themselves}", course.trainees.len());
                    ui.label(look::quiet(count));
                }
                ui.add_space(8.0);
                show_levels(ui, course, language);
                ui.add_space(8.0);
                if ui.button(text::REMOVE_COURSE.of(language)).clicked() {
                    self.is_removing = true;
                }
                if self.is_removing {
                    let goes = RichText::new(text::COURSE_GOES.of(language)).color(look::BAD);
                    ui.add(Label::new(goes).wrap());
                    ui.horizontal(|ui| {
                        let remove = RichText::new(text::FOR_GOOD.of(language)).color(look::BAD);
                        if ui.button(remove).clicked() {
                            change = Some(Change::RemoveCourse { course: name() });
                        }
                        if ui.button(text::CANCEL.of(language)).clicked() {
                            self.is_removing = false;
                        }
                    });
                }
            });
        change
    }

    fn show_work(&mut self, ui: &mut Ui, ledger: &dyn Ledger, language: Language) {
        let is_free = self.running.is_none();
        let mut work = None;
        let button = |ui: &mut Ui, title: Phrase, is_ready: bool| {
            let button = Button::new(title.of(language));
            ui.add_enabled(is_ready && is_free, button).clicked()
        };
        let line = |ui: &mut Ui, path: &mut String, hint: &str| {
            let line = TextEdit::singleline(path).hint_text(hint);
            ui.add(line.desired_width(ui.available_width() - BUTTONS))
        };
        ui.add_space(4.0);
        ui.horizontal(|ui| {
            line(ui, &mut self.file, text::PATH_TO_READ.of(language));
            let path = self.file.trim();
            if button(ui, text::READ_FILE, !path.is_empty()) {
                work = Some(Work::Read(PathBuf::from(path)));
            }
        });
        let explained = look::quiet(text::READ_EXPLAINED.of(language));
        ui.add(Label::new(explained).wrap());
        ui.horizontal(|ui| {
            let mut path = match &self.export {
                Some(path) => path.clone(),
                None => ledger.export_file().display().to_string(),
            };
            if line(ui, &mut path, "").changed() {
                self.export = Some(path.clone());
            }
            let path = path.trim();
            if button(ui, text::EXPORT_ALL, !path.is_empty()) {
                work = Some(Work::Export(PathBuf::from(path)));
            }
        });
        ui.horizontal(|ui| {
            line(ui, &mut self.folder, text::PATH_OF_FOLDER.of(language));
            if button(ui, text::REBUILD, true) {
                let path = self.folder.trim();
                let more = (!path.is_empty()).then(|| PathBuf::from(path));
                work = Some(Work::Rebuild(more));
            }
            if button(ui, text::CHECK_STORE, true) {
                work = Some(Work::Check);
            }
        });
        let explained = look::quiet(text::REBUILD_EXPLAINED.of(language));
        ui.add(Label::new(explained).wrap());
        ui.allocate_ui(egui::vec2(ui.available_width(), SPOKEN), |ui| {
            ui.set_min_height(SPOKEN);
            self.show_spoken(ui, language);
        });
        ui.add_space(4.0);
        if let Some(work) = work {
            self.begin(ledger, &work, ui.ctx());
        }
    }

    fn show_spoken(&self, ui: &mut Ui, language: Language) {
        if let Some(running) = &self.running {
            let (part, passed) = running.part();
            let bar = ProgressBar::new(part.done.unwrap_or_default() as f32);
            ui.add(bar.fill(look::ACCENT).desired_height(10.0));
            let mut words = vec![
                part.done
                    .map_or_else(String::new, |done| format!("{:.0} %", 100.0 * done)),
                format!("{} {}", seconds(passed), text::PASSED_TIME.of(language)),
            ];
            if let Some(left) = part.done.and_then(|done| left(done, passed)) {
                let about = text::ABOUT_LEFT.of(language);
                words.push(format!("{about} {}", seconds(left)));
            }
            words.retain(|word| !word.is_empty());
            ui.label(words.join(" · "));
            ui.add(Label::new(look::quiet(part.what)).truncate());
            // The time goes on, also where nothing else is new.
            ui.ctx().request_repaint_after(Duration::from_millis(200));
        } else if let Some(spoken) = &self.spoken {
            let colour = match spoken.is_complaint {
                true => look::BAD,
                false => look::GOOD,
            };
            ScrollArea::vertical()
                .id_salt("spoken")
                .auto_shrink(false)
                .show(ui, |ui| {
                    for sentence in &spoken.sentences {
                        let sentence = RichText::new(local(sentence, language)).color(colour);
                        ui.add(Label::new(sentence).wrap());
                    }
                });
        }
    }
}

/// A time in whole seconds.
fn seconds(time: Duration) -> String {
    format!("{:.0} s", time.as_secs_f64())
}

fn show_entry(ui: &mut Ui, course: &CourseEntry, language: Language) {
    ui.vertical(|ui| {
        ui.spacing_mut().item_spacing.y = 1.0;
        ui.add_space(3.0);
        let title = RichText::new(local(&course.title, language)).strong();
        ui.add(Label::new(title).truncate().selectable(false));
        let levels = course.levels.len();
        let noun = match levels {
            1 => text::LEVEL_OF_IT,
            _ => text::LEVELS_OF_IT,
        };
        let mut parts = vec![
            course.name.clone(),
            format!("{levels} {}", noun.of(language)),
        ];
        parts.extend(course.groups.iter().cloned());
        let parts = look::quiet(parts.join(" · "));
        ui.add(Label::new(parts).truncate().selectable(false));
    });
}

fn show_levels(ui: &mut Ui, course: &CourseEntry, language: Language) {
    let order = match course.in_order {
        true => text::IN_ORDER,
        false => text::ALL_OPEN,
    };
    ui.label(look::quiet(order.of(language)));
    for (at, level) in course.levels.iter().enumerate() {
        ui.allocate_ui(egui::vec2(ui.available_width(), LINE), |ui| {
            ui.horizontal(|ui| {
                let title = (ui.available_width() - 220.0).max(120.0);
                let of_level = format!(
                    "{}. {}, {} {}",
                    at + 1,
                    local(&level.title, language),
                    text::LEVEL.of(language),
                    level.level
                );
                cell(ui, title, Align::Min, of_level);
                let passes = match level.passes {
                    1 => text::ONE_PASS,
                    _ => text::PASSES_IN_A_ROW,
                };
                let passes = format!("{} {}", level.passes, passes.of(language));
                cell(ui, 200.0, Align::Min, look::quiet(passes));
            });
        });
    }
}
