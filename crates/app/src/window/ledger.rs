//! Trainees, courses and results for the window: the store as the commands see it.

use super::jobs::AtStore;
use super::{AtThisPlace, text};
use crate::date;
use crate::erasure::{belongings, remove, remove_name};
use crate::evaluation::{is_better, learning_curve, pairs, same_level, standings};
use crate::folders::{self, Folders};
use crate::names::{name_or_id, shown};
use crate::output::Problem;
use crate::records::{self, find, new_id};
use crate::result_table;
use microsim_message::LocalText;
use microsim_report::Verdict as Reported;
use microsim_settings::unwritable;
use microsim_store::{
    Course, Enrolled, Filter, Id, Measured, NamedSession, Role as Stored, StepProgress, Store,
    Trainee, Verdict,
};
use microsim_table::Format;
use microsim_training::{Category, CusumDecision, CusumPlan, MOTION_METRICS, Standing};
use microsim_window::{
    Attempt, Change, ComparedRow, Comparison, CourseEntry, CourseLevel, CourseProgress, CourseStep,
    Debrief, Job, Learning, Ledger, Participant, Percentile, Person, Role, Selection, StandingRow,
    StepState, Work,
};
use std::path::{Path, PathBuf};

/// Roles of the window and of the store.
const ROLES: [(Role, Stored); 3] = [
    (Role::Operator, Stored::Operator),
    (Role::Instructor, Stored::Instructor),
    (Role::Trainee, Stored::Trainee),
];

impl AtThisPlace {
    /// What is read of the store; nothing of one that is not there yet.
    fn of_store<T: Default>(
        &self,
        read: impl FnOnce(&Store) -> Result<T, Problem>,
    ) -> Result<T, String> {
        let store = records::open_to_read(&self.place).map_err(text)?;
        store.map_or_else(|| Ok(T::default()), |store| read(&store).map_err(text))
    }

    fn title_of(&self, module: &str) -> LocalText {
        let modules = self.installation.tree.modules.iter();
        let mut manifests = modules.map(|module| &module.manifest.settings);
        let found = manifests.find(|manifest| manifest.name == module);
        found.map_or_else(
            || LocalText::new(module.to_owned(), module.to_owned()),
            |manifest| manifest.title.clone(),
        )
    }

    /// In both languages where the installation knows the metric.
    fn title_of_metric(&self, module: &str, measured: &Measured) -> LocalText {
        let (id, title) = (&measured.metric.id, &measured.metric.title);
        let modules = self.installation.tree.modules.iter();
        let mut manifests = modules.map(|module| &module.manifest.settings);
        let manifest = manifests.find(|manifest| manifest.name == module);
        let mut own = manifest.iter().flat_map(|manifest| &manifest.metric);
        let own = own.find(|metric| metric.id == *id).map(|m| &m.title);
        let common = MOTION_METRICS.iter().find(|metric| metric.id == *id);
        let known = own.or_else(|| common.map(|metric| &metric.title));
        known.map_or_else(
            || LocalText::new(title.clone(), title.clone()),
            Clone::clone,
        )
    }

    fn attempt(&self, named: &NamedSession) -> Attempt {
        let session = &named.session;
        Attempt {
            id: session.id.to_string(),
            started: date::shown(session.started),
            module: session.module.clone(),
            title: self.title_of(&session.module),
            level: session.level,
            verdict: match session.verdict {
                Verdict::Passed => Reported::Passed,
                Verdict::Failed => Reported::Failed,
                Verdict::NotJudged => Reported::NotJudged,
                Verdict::Aborted => Reported::Aborted,
                Verdict::Incomplete => Reported::Incomplete,
            },
            score: session.score,
            duration: session.duration,
            who: name_or_id(named.name.as_deref(), session.trainee),
        }
    }

    fn course_step(&self, step: &StepProgress, is_next: bool) -> CourseStep {
        CourseStep {
            module: step.step.module.clone(),
            title: self.title_of(&step.step.module),
            level: step.step.level,
            state: match (step.mastered_with, step.open) {
                (Some(attempt), _) => StepState::Mastered(attempt),
                (None, true) => StepState::Open,
                (None, false) => StepState::Locked,
            },
            is_next,
            row: [step.row, step.step.passes as usize],
            attempts: [step.passed, step.attempts],
        }
    }

    fn course_entry(&self, store: &Store, course: Course) -> Result<CourseEntry, Problem> {
        let (mut groups, mut trainees) = (Vec::new(), Vec::new());
        for who in store.enrolled(&course.name)? {
            match who {
                Enrolled::Group(name) => groups.push(name),
                Enrolled::Trainee(id) => trainees.push(id.to_string()),
            }
        }
        let levels = course.steps.iter().map(|step| CourseLevel {
            title: self.title_of(&step.module),
            level: step.level,
            passes: step.passes,
        });
        Ok(CourseEntry {
            levels: levels.collect(),
            title: LocalText::new(course.title_de, course.title_en),
            name: course.name,
            in_order: course.in_order,
            groups,
            trainees,
        })
    }

    fn changed(&self, change: &Change) -> Result<(), Problem> {
        let mut store = records::open(&self.place)?;
        match change {
            Change::Add { name, group } => {
                let trainee = Trainee {
                    id: new_id()?,
                    name: Some(name.clone()),
                    role: Stored::Trainee,
                    created: date::now(),
                };
                store.add_trainee(&trainee)?;
                if let Some(group) = group {
                    store.change_group(group, &[trainee.id], &[])?;
                }
            }
            Change::Rename { id, name } => store.rename(known(id)?, name)?,
            Change::Role { id, role } => {
                let mut roles = ROLES.iter();
                let stored = roles.find(|(shown, _)| shown == role);
                if let Some((_, stored)) = stored {
                    store.set_role(known(id)?, *stored)?;
                }
            }
            Change::Group { id, group, member } => {
                let id = [known(id)?];
                match member {
                    true => store.change_group(group, &id, &[])?,
                    false => store.change_group(group, &[], &id)?,
                }
            }
            Change::Enrol { who, course, takes } => {
                let who = match who {
                    Participant::Trainee(id) => Enrolled::Trainee(known(id)?),
                    Participant::Group(name) => Enrolled::Group(name.clone()),
                };
                match takes {
                    true => store.enrol(course, &who)?,
                    false => store.leave(course, &who)?,
                }
            }
            Change::RemoveCourse { course } => store.remove_course(course)?,
            Change::Unlock {
                id,
                course,
                module,
                level,
            } => store.unlock(course, known(id)?, module, *level)?,
            Change::Anonymise { id } => {
                let trainee = find(&store, id)?;
                remove_name(&mut store, &trainee)?;
            }
            Change::Erase { id } => {
                let trainee = find(&store, id)?;
                let found = belongings(&self.place, &store, &trainee)?;
                remove(&mut store, &trainee, &found)?;
            }
        }
        Ok(())
    }
}

/// An id that the window was given.
fn known(id: &str) -> Result<Id, Problem> {
    Id::parse(id).ok_or_else(|| format!("{id} is no id").into())
}

fn filter(of: &Selection) -> Result<Filter, Problem> {
    Ok(Filter {
        trainee: of.trainee.as_deref().map(known).transpose()?,
        group: of.group.clone(),
        ..Filter::default()
    })
}

/// As it is shown.
fn displayed(measured: &Measured) -> Option<f64> {
    measured.value.map(|v| v * measured.metric.display_factor)
}

/// The unit in which it is shown; empty for a number without one.
fn unit(measured: &Measured) -> String {
    match measured.metric.display_unit.as_str() {
        "1" => String::new(),
        unit => unit.to_owned(),
    }
}

impl Ledger for AtThisPlace {
    fn people(&self) -> Result<Vec<Person>, String> {
        self.of_store(|store| {
            let person = |listed: microsim_store::ListedTrainee| {
                let trainee = listed.trainee;
                let role = ROLES.iter().find(|(_, stored)| *stored == trainee.role);
                Person {
                    id: trainee.id.to_string(),
                    name: name_or_id(trainee.name.as_deref(), Some(trainee.id)),
                    role: role.map_or(Role::Trainee, |(shown, _)| *shown),
                    groups: listed.groups,
                    sessions: listed.sessions.try_into().unwrap_or_default(),
                }
            };
            Ok(store.trainees(None)?.into_iter().map(person).collect())
        })
    }

    fn courses(&self) -> Result<Vec<CourseEntry>, String> {
        self.of_store(|store| {
            let courses = store.courses()?.into_iter();
            courses.map(|c| self.course_entry(store, c)).collect()
        })
    }

    fn groups(&self) -> Result<Vec<String>, String> {
        self.of_store(|store| Ok(store.groups()?))
    }

    fn attempts(&self, of: &Selection) -> Result<Vec<Attempt>, String> {
        self.of_store(|store| {
            let found = store.results(&filter(of)?, false)?;
            Ok(found
                .iter()
                .rev()
                .map(|named| self.attempt(named))
                .collect())
        })
    }

    fn compare(&self, ids: [&str; 2]) -> Result<Comparison, String> {
        let compared = || {
            let store = records::must_read(&self.place)?;
            let [a, b] = [store.find_session(ids[0])?, store.find_session(ids[1])?];
            let of_score = ComparedRow {
                title: LocalText::fixed("Punkte", "Score"),
                unit: String::new(),
                values: [a.session.score, b.session.score],
                outside: [false; 2],
                is_better: None,
            };
            let mut rows = vec![of_score];
            for (id, of_a) in &a.session.categories {
                let of_b = b.session.categories.iter().find(|(other, _)| other == id);
                let title = match Category::from_name(id) {
                    Some(category) => category.title(),
                    None => LocalText::new(id.clone(), id.clone()),
                };
                rows.push(ComparedRow {
                    title,
                    unit: String::new(),
                    values: [Some(*of_a), of_b.map(|(_, score)| *score)],
                    outside: [false; 2],
                    is_better: None,
                });
            }
            for row in &mut rows {
                let difference = row.values[0].zip(row.values[1]).map(|(a, b)| b - a);
                row.is_better = difference.and_then(|d| is_better("higher", d));
            }
            for (of_a, of_b) in pairs(&a.session, &b.session) {
                let difference = of_a.value.zip(of_b.value).map(|(a, b)| b - a);
                if of_a.value.is_some() || of_b.value.is_some() {
                    rows.push(ComparedRow {
                        title: self.title_of_metric(&a.session.module, of_a),
                        unit: unit(of_a),
                        values: [displayed(of_a), displayed(of_b)],
                        outside: [of_a, of_b].map(|measured| measured.within == Some(false)),
                        is_better: difference.and_then(|d| is_better(&of_a.metric.direction, d)),
                    });
                }
            }
            Ok::<_, Problem>(Comparison {
                same_level: same_level(&a.session, &b.session),
                attempts: [self.attempt(&a), self.attempt(&b)],
                rows,
            })
        };
        compared().map_err(text)
    }

    fn learning(&self, trainee: &str, module: &str, level: u32) -> Result<Learning, String> {
        let learned = || {
            let store = records::must_read(&self.place)?;
            let filter = Filter {
                trainee: Some(known(trainee)?),
                module: Some(module.to_owned()),
                level: Some(level),
                ..Filter::default()
            };
            let found = store.results(&filter, true)?;
            let populations = store.populations(Some((module, level)))?;
            let (curve, plan) = (learning_curve(&found), CusumPlan::published());
            let mut rows = Vec::new();
            let last = found.iter().rfind(|named| named.session.counts);
            for measured in last.iter().flat_map(|last| &last.session.metrics) {
                let session = last.map(|last| &last.session);
                let places = session.map(|s| standings(s, measured, &populations));
                for (record, standing) in places.into_iter().flatten() {
                    rows.push(StandingRow {
                        title: self.title_of_metric(module, measured),
                        unit: unit(measured),
                        value: displayed(measured).unwrap_or_default(),
                        source: shown(&record.source),
                        size: record.n,
                        percentile: match standing {
                            Standing::At(percent) => Percentile::At(percent),
                            Standing::Below(percent) => Percentile::Below(percent),
                            Standing::Above(percent) => Percentile::Above(percent),
                        },
                    });
                }
            }
            Ok::<_, Problem>(Learning {
                values: curve.values,
                limits: [plan.lower(), plan.upper()],
                rates: plan.rates(),
                decision: curve.decision.map(|(attempt, decision)| {
                    (attempt + 1, decision == CusumDecision::Acceptable)
                }),
                standings: rows,
            })
        };
        learned().map_err(text)
    }

    fn progress(&self, trainee: &str) -> Result<Vec<CourseProgress>, String> {
        self.of_store(|store| {
            let id = known(trainee)?;
            let mut taken = Vec::new();
            for name in store.courses_of(id)? {
                let progress = store.progress(&name, id)?;
                let next = progress.next().map(|next| &next.step);
                let steps = progress.steps.iter();
                let steps = steps.map(|step| self.course_step(step, next == Some(&step.step)));
                let course = &progress.course;
                taken.push(CourseProgress {
                    title: LocalText::new(course.title_de.clone(), course.title_en.clone()),
                    steps: steps.collect(),
                    name,
                });
            }
            Ok(taken)
        })
    }

    fn debrief(&self, id: &str) -> Result<Debrief, String> {
        let read = || {
            let store = records::must_read(&self.place)?;
            let session = PathBuf::from(store.find_session(id)?.session.path);
            super::recorded::debrief(session)
        };
        read().map_err(text)
    }

    fn table(&self) -> PathBuf {
        let today = date::shown(date::now());
        let day = today.split(' ').next().unwrap_or_default();
        let file = format!("results-{day}.csv");
        // Without folders of the user there is no store either; each reading of it states why.
        Folders::of(&self.place).map_or_else(
            |_| PathBuf::from(&file),
            |folders| folders.tables().join(&file),
        )
    }

    fn export(&self, of: &Selection, file: &Path, names: bool) -> Result<usize, String> {
        let written = || {
            let format = Format::of(file)
                .ok_or_else(|| unwritable(file, std::io::ErrorKind::InvalidInput.into()))?;
            let tables = Folders::of(&self.place)?.tables();
            if file.parent() == Some(&tables) {
                folders::make(&tables)?;
            }
            let store = records::must_read(&self.place)?;
            result_table::write(&store, &filter(of)?, names, format, file)
        };
        written().map_err(text)
    }

    fn belongings(&self, trainee: &str) -> Result<[usize; 2], String> {
        let found = || {
            let store = records::must_read(&self.place)?;
            let found = belongings(&self.place, &store, &find(&store, trainee)?)?;
            Ok::<_, Problem>([found.sessions, found.files.len()])
        };
        found().map_err(text)
    }

    fn change(&self, change: &Change) -> Result<(), String> {
        self.changed(change).map_err(text)
    }

    fn export_file(&self) -> PathBuf {
        let now = date::shown(date::now()).replace([' ', ':'], "-");
        let mut file = self.table();
        file.set_file_name(format!("store-{now}.json"));
        file
    }

    fn job(&self, work: &Work) -> Box<dyn Job> {
        Box::new(AtStore {
            place: self.place.clone(),
            work: work.clone(),
        })
    }
}
