//! The courses that somebody takes: what is mastered, open and next.

use crate::ledger::{Change, CourseEntry, CourseProgress, CourseStep, Participant, StepState};
use crate::look;
use crate::rows::cell;
use crate::text::{self, local};
use eframe::egui::{self, Align, Label, RichText, ScrollArea, Ui};
use microsim_vocabulary::Language;

/// Courses of somebody, and those that they could take.
#[derive(Debug, Default)]
pub struct Courses {
    taken: Vec<CourseProgress>,
    others: Vec<CourseEntry>,
    /// Whoever it is takes these courses by themselves, not as a member of a group alone.
    own: Vec<String>,
    /// The one to be taken.
    other: Option<String>,
}

impl Courses {
    /// Of all courses, with those that are taken.
    pub fn new(taken: Vec<CourseProgress>, mut all: Vec<CourseEntry>, id: &str) -> Self {
        let own = all.iter().filter(|c| c.trainees.iter().any(|t| t == id));
        let own = own.map(|course| course.name.clone()).collect();
        all.retain(|other| taken.iter().all(|course| course.name != other.name));
        Self {
            taken,
            other: all.first().map(|course| course.name.clone()),
            others: all,
            own,
        }
    }
}

/// Shows them.
pub fn show(ui: &mut Ui, courses: &mut Courses, id: &str, language: Language) -> Option<Change> {
    let mut change = None;
    if let Some(other) = &mut courses.other {
        ui.horizontal(|ui| {
            let title = |name: &str| {
                let found = courses.others.iter().find(|other| other.name == name);
                found.map_or_else(String::new, |c| local(&c.title, language).to_owned())
            };
            if ui.button(text::ENROL.of(language)).clicked() {
                change = Some(Change::Enrol {
                    who: Participant::Trainee(id.to_owned()),
                    course: other.clone(),
                    takes: true,
                });
            }
            egui::ComboBox::from_id_salt("course")
                .selected_text(title(other))
                .width(ui.available_width())
                .truncate()
                .show_ui(ui, |ui| {
                    for course in &courses.others {
                        let title = title(&course.name);
                        ui.selectable_value(other, course.name.clone(), title);
                    }
                });
        });
    }
    if courses.taken.is_empty() {
        ui.label(look::quiet(text::NO_COURSE.of(language)));
    }
    ScrollArea::vertical()
        .id_salt("courses")
        .auto_shrink(false)
        .show(ui, |ui| {
            for course in &courses.taken {
                ui.horizontal(|ui| {
                    if courses.own.contains(&course.name)
                        && ui.small_button(text::TAKE_OUT.of(language)).clicked()
                    {
                        change = Some(Change::Enrol {
                            who: Participant::Trainee(id.to_owned()),
                            course: course.name.clone(),
                            takes: false,
                        });
                    }
                    let title = look::heading(local(&course.title, language));
                    ui.add(Label::new(title).truncate());
                });
                for step in &course.steps {
                    if show_step(ui, step, language) {
                        change = Some(Change::Unlock {
                            id: id.to_owned(),
                            course: course.name.clone(),
                            module: step.module.clone(),
                            level: step.level,
                        });
                    }
                }
                ui.add_space(8.0);
            }
        });
    change
}

/// Whether it is to be opened.
fn show_step(ui: &mut Ui, step: &CourseStep, language: Language) -> bool {
    let (state, colour) = match step.state {
        StepState::Mastered(attempt) => {
            let mastered = text::MASTERED_WITH.of(language);
            (format!("{mastered} {attempt}"), look::GOOD)
        }
        StepState::Open if step.is_next => {
            let next = text::IS_NEXT.of(language);
            (next.to_owned(), look::ACCENT)
        }
        StepState::Open => (text::IS_OPEN.of(language).to_owned(), look::TEXT),
        StepState::Locked => (text::LOCKED.of(language).to_owned(), look::QUIET),
    };
    let mut opened = false;
    ui.horizontal(|ui| {
        let title = (ui.available_width() - 480.0).max(120.0);
        let of_level = format!(
            "{}, {} {}",
            local(&step.title, language),
            text::LEVEL.of(language),
            step.level
        );
        let of_level = match step.is_next {
            true => RichText::new(of_level).strong(),
            false => RichText::new(of_level),
        };
        cell(ui, title, Align::Min, of_level);
        cell(ui, 170.0, Align::Min, RichText::new(state).color(colour));
        let [row, needed] = step.row;
        let [passed, all] = step.attempts;
        let row = format!(
            "{row} / {needed} {} · {passed} / {all}",
            text::IN_A_ROW.of(language)
        );
        cell(ui, 190.0, Align::Min, look::quiet(row));
        if step.state == StepState::Locked {
            opened = ui.small_button(text::UNLOCK.of(language)).clicked();
        }
    });
    opened
}
