//! `microsim trainee`: the motion of a synthetic trainee along the plan of a script, as a script.

use crate::cli::{Place, TraineeArgs};
use crate::output::{Exit, Problem, print, print_json};
use crate::replace_file::write_new;
use crate::session_file::installation;
use microsim_settings::{self as settings, Sourced, TraineeProfile, load_script, load_trainees};
use microsim_tracking::{Profile, Script, Trainee};
use serde_json::json;
use std::fmt::Write;

/// Writes the script of one trainee.
pub fn trainee(place: &Place, args: &TraineeArgs) -> Result<Exit, Problem> {
    let installation = installation(place)?;
    let trainees = load_trainees(&installation.setting("trainees.toml"))?.settings;
    let found = trainees.profile.iter().find(|p| p.name == args.profile);
    let profile = found.ok_or_else(|| {
        let names: Vec<&str> = trainees.profile.iter().map(|p| p.name.as_str()).collect();
        format!(
            "{} has no profile \"{}\"; it has: {}",
            installation.setting("trainees.toml").display(),
            args.profile,
            names.join(", ")
        )
    })?;
    let path = installation.find(&args.script, &[]);
    let plan = load_script(&path)?.settings;
    if let Some(made) = &plan.synthetic {
        return Err(format!(
            "{}: it is a synthetic trainee already: {made}",
            path.display()
        )
        .into());
    }
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let made = format!("profile {}, seed {}, from {name}", profile.name, args.seed);
    let planned = plan.motion()?;
    let motion = Trainee::new(&numbers(profile), args.seed).follow(&planned, plan.rate)?;
    write_new(&args.out, text(&motion, &plan, &made).as_bytes())?;
    if args.json {
        print_json(&json!({
            "script": args.out, "plan": path, "profile": profile.name, "seed": args.seed, "synthetic": made,
            "duration_s": motion.duration(), "planned_s": planned.duration(),
        }))?;
        return Ok(Exit::Done);
    }
    print(format!(
        "{}: {made}; {:.1} s instead of {:.1} s",
        args.out.display(),
        motion.duration(),
        planned.duration()
    ))?;
    Ok(Exit::Done)
}

/// A profile without its sources.
fn numbers(profile: &TraineeProfile) -> Profile {
    let value = |sourced: &Sourced| sourced.value;
    Profile {
        tremor_still: value(&profile.tremor_still),
        tremor_actuating: value(&profile.tremor_actuating),
        pace: value(&profile.pace),
        hesitation_chance: value(&profile.hesitation_chance),
        hesitation: value(&profile.hesitation),
        aiming_error: value(&profile.aiming_error),
        angular_error: value(&profile.angular_error),
        lead: value(&profile.lead),
        detour: value(&profile.detour),
        grip_excess: value(&profile.grip_excess),
        spread: value(&profile.spread),
    }
}

/// A script as its file has it, for the level of its plan. Every number comes back to the last bit.
fn text(script: &Script, plan: &settings::Script, synthetic: &str) -> String {
    let mut out = "# The motion of a synthetic trainee: no person made it.\n".to_owned();
    if let Some(module) = &plan.module {
        let _ = writeln!(out, "module = \"{module}\"");
    }
    if let Some(level) = plan.level {
        let _ = writeln!(out, "level = {level}");
    }
    let _ = write!(
        out,
        "synthetic = {}\nrate = {:?}\ninterpolation = \"linear\"\n",
        toml_edit::Value::from(synthetic),
        plan.rate
    );
    for track in script.tracks() {
        let _ = write!(out, "\n[[tool]]\nname = \"{}\"\nkey = [\n", track.device);
        for key in &track.keyframes {
            let _ = writeln!(
                out,
                "    {{ t = {:?}, position = {:?}, orientation = {:?}, opening = {:?}, visible = {} }},",
                key.time_s, key.position, key.orientation, key.opening, key.visible
            );
        }
        out.push_str("]\n");
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use microsim_settings::read_script;

    /// What is written is read back as what was made, and labelled.
    #[test]
    fn a_script_comes_back() {
        let plan = "module = \"hold\"\nlevel = 2\nrate = 62.5\n[[tool]]\nname = \"right\"\nkey = [\n\
             { t = 0, position = [0, 0, 0.001], direction = [0.1, -0.7, 1], opening = 1 },\n\
             { t = 1, position = [0.01, 1e-7, 0], direction = [0, 0, 1] },\n]\n";
        let file = read_script(plan, "f.toml").expect("a plan").settings;
        let plan = file.motion().expect("a motion");
        let profile = Profile {
            tremor_still: 5e-5,
            tremor_actuating: 1e-4,
            pace: 1.3,
            hesitation_chance: 0.5,
            hesitation: 0.2,
            aiming_error: 1e-4,
            angular_error: 0.02,
            lead: 0.05,
            detour: 0.1,
            grip_excess: 0.1,
            spread: 0.1,
        };
        let motion = Trainee::new(&profile, 3)
            .follow(&plan, 62.5)
            .expect("a motion");
        let written = text(&motion, &file, "a \"label\"");
        let read = read_script(&written, "f.toml").expect("a script").settings;
        assert_eq!(read.synthetic.as_deref(), Some("a \"label\""));
        assert_eq!(
            (read.module.as_deref(), read.level),
            (Some("hold"), Some(2))
        );
        let back = read.motion().expect("a motion");
        for (made, read) in motion.tracks()[0]
            .keyframes
            .iter()
            .zip(&back.tracks()[0].keyframes)
        {
            assert_eq!(
                (made.time_s, made.position, made.opening),
                (read.time_s, read.position, read.opening)
            );
            // Both scale a quaternion to length 1: a rounding more.
            for (a, b) in made.orientation.iter().zip(read.orientation) {
                assert!((a - b).abs() <= 2.0 * f64::EPSILON, "{a} {b}");
            }
        }
        assert_eq!(
            motion.tracks()[0].keyframes.len(),
            back.tracks()[0].keyframes.len()
        );
    }
}
