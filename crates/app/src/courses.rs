//! `microsim courses`.

use crate::cli::{
    CourseAddArgs, CourseEnrolArgs, CourseProgressArgs, CourseUnlockArgs, CoursesCommand, NameArgs,
    Place,
};
use crate::names::{name_or_id, shown};
use crate::output::{Exit, Problem, complain, print, print_json};
use crate::records::{find, must_read, open};
use crate::upkeep::take_course;
use microsim_store::{Enrolled, Progress, StepProgress, Store, Trainee};
use serde_json::{Value, json};

/// Does what was asked of courses.
pub fn courses(place: &Place, command: &CoursesCommand) -> Result<Exit, Problem> {
    match command {
        CoursesCommand::List(args) => {
            let courses = must_read(place)?.courses()?;
            if args.json {
                print_json(&json!({ "courses": courses }))?;
                return Ok(Exit::Done);
            }
            for course in &courses {
                let levels = course.steps.len();
                print(format!(
                    "{:<24} {levels:>3} levels  {}",
                    course.name, course.title_en
                ))?;
            }
            Ok(Exit::Done)
        }
        CoursesCommand::Show(args) => show(&must_read(place)?, args),
        CoursesCommand::Add(args) => add(place, args),
        CoursesCommand::Remove(args) => {
            let mut store = open(place)?;
            store.remove_course(&args.course)?;
            done(
                args.json,
                json!({ "removed": args.course }),
                &format!("{} is removed; results stay", args.course),
            )
        }
        CoursesCommand::Enrol(args) => enrol(place, args),
        CoursesCommand::Unlock(args) => unlock(place, args),
        CoursesCommand::Progress(args) => progress(place, args),
    }
}

fn done(as_json: bool, document: Value, sentence: &str) -> Result<Exit, Problem> {
    match as_json {
        true => print_json(&document)?,
        false => print(sentence)?,
    }
    Ok(Exit::Done)
}

fn add(place: &Place, args: &CourseAddArgs) -> Result<Exit, Problem> {
    let (course, missing) = take_course(place, &args.file)?;
    missing.iter().for_each(complain);
    done(
        args.json,
        json!(course),
        &format!(
            "{} is in the store, with {} levels",
            course.name,
            course.steps.len()
        ),
    )
}

fn who(store: &Store, args: &CourseEnrolArgs) -> Result<(Enrolled, String), Problem> {
    Ok(match (&args.trainee, &args.group) {
        (Some(asked), _) => {
            let trainee = find(store, asked)?;
            let name = name_or_id(trainee.name.as_deref(), Some(trainee.id));
            (Enrolled::Trainee(trainee.id), name)
        }
        (None, group) => {
            let group = group.clone().unwrap_or_default();
            store.must_be_group(&group)?;
            let name = format!("group {}", shown(&group));
            (Enrolled::Group(group), name)
        }
    })
}

fn enrol(place: &Place, args: &CourseEnrolArgs) -> Result<Exit, Problem> {
    let mut store = open(place)?;
    let (who, name) = who(&store, args)?;
    match args.remove {
        true => store.leave(&args.course, &who)?,
        false => store.enrol(&args.course, &who)?,
    }
    let does = if args.remove {
        "does not take"
    } else {
        "takes"
    };
    done(
        args.json,
        json!({ "course": args.course, "who": name, "enrolled": !args.remove }),
        &format!("{name} {does} {}", args.course),
    )
}

fn unlock(place: &Place, args: &CourseUnlockArgs) -> Result<Exit, Problem> {
    let mut store = open(place)?;
    let trainee = find(&store, &args.trainee)?;
    store.unlock(&args.course, trainee.id, &args.module, args.level)?;
    let name = name_or_id(trainee.name.as_deref(), Some(trainee.id));
    done(
        args.json,
        json!({ "course": args.course, "trainee": trainee.id, "module": args.module, "level": args.level }),
        &format!("{}, level {}, is open for {name}", args.module, args.level),
    )
}

fn show(store: &Store, args: &NameArgs) -> Result<Exit, Problem> {
    let course = store.course(&args.course)?;
    let enrolled = store.enrolled(&args.course)?;
    let mut groups = Vec::new();
    let mut trainees = Vec::new();
    for who in enrolled {
        match who {
            Enrolled::Group(name) => groups.push(name),
            Enrolled::Trainee(id) => trainees.extend(store.trainee(id)?),
        }
    }
    if args.json {
        let mut document = json!(course);
        document["groups"] = json!(groups);
        let ids: Vec<_> = trainees.iter().map(|trainee| trainee.id).collect();
        document["trainees"] = json!(ids);
        print_json(&document)?;
        return Ok(Exit::Done);
    }
    let order = match course.in_order {
        true => "a level opens when the one before it is mastered",
        false => "all levels are open",
    };
    print(format!("{} ({}): {order}", course.title_en, course.name))?;
    for (at, step) in course.steps.iter().enumerate() {
        print(format!(
            "  {:>2}  {:<20} mastered with {} passes in a row",
            at + 1,
            format!("{} {}", step.module, step.level),
            step.passes
        ))?;
    }
    for group in &groups {
        print(format!("  group {}", shown(group)))?;
    }
    for trainee in &trainees {
        print(format!(
            "  {}",
            name_or_id(trainee.name.as_deref(), Some(trainee.id))
        ))?;
    }
    Ok(Exit::Done)
}

fn progress(place: &Place, args: &CourseProgressArgs) -> Result<Exit, Problem> {
    let store = must_read(place)?;
    let ids = match &args.trainee {
        Some(asked) => vec![find(&store, asked)?.id],
        None => store.participants(&args.course)?,
    };
    let mut documents = Vec::new();
    for id in ids {
        let progress = store.progress(&args.course, id)?;
        let Some(trainee) = store.trainee(id)? else {
            continue;
        };
        if args.json {
            documents.push(document(&trainee, &progress));
        } else {
            write_progress(&trainee, &progress)?;
        }
    }
    if args.json {
        print_json(&json!({ "course": args.course, "trainees": documents }))?;
    }
    Ok(Exit::Done)
}

/// The state of a level in a word.
fn state(step: &StepProgress) -> &'static str {
    match (step.mastered_with, step.open) {
        (Some(_), _) => "mastered",
        (None, true) => "open",
        (None, false) => "locked",
    }
}

fn document(trainee: &Trainee, progress: &Progress) -> Value {
    let steps = progress.steps.iter().map(|step| {
        json!({
            "module": step.step.module,
            "level": step.step.level,
            "state": state(step),
            "unlocked_by_hand": step.unlocked,
            "attempts": step.attempts,
            "passed": step.passed,
            "passes_in_a_row": step.row,
            "passes_needed": step.step.passes,
            "mastered_with_attempt": step.mastered_with,
        })
    });
    let next = progress.next();
    json!({
        "trainee": trainee.id,
        "name": trainee.name,
        "levels": steps.collect::<Vec<_>>(),
        "next": next.map(|next| json!({ "module": next.step.module, "level": next.step.level })),
        "completed": progress.steps.iter().all(|step| step.mastered_with.is_some()),
    })
}

fn write_progress(trainee: &Trainee, progress: &Progress) -> Result<(), Problem> {
    print(name_or_id(trainee.name.as_deref(), Some(trainee.id)))?;
    let next = progress.next().map(|next| &next.step);
    for (at, step) in progress.steps.iter().enumerate() {
        let detail = match step.mastered_with {
            Some(attempt) => format!("with attempt {attempt}"),
            None => format!("{} of {} passes in a row", step.row, step.step.passes),
        };
        let mark = match (next == Some(&step.step), step.unlocked) {
            (true, _) => "  <- next",
            (false, true) => "  opened by hand",
            (false, false) => "",
        };
        print(format!(
            "  {:>2}  {:<20} {:<9} {detail}, {} of {} attempts passed{mark}",
            at + 1,
            format!("{} {}", step.step.module, step.step.level),
            state(step),
            step.passed,
            step.attempts,
        ))?;
    }
    Ok(())
}
