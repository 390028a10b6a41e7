use super::*;
use crate::{Serial, scene_spec};

/// A beam of 30 × 10 × 10 mm in eighteen cells, clamped on the left, besides what `more` adds.
fn beam(method: &str, run: &str, more: &str) -> settings::Scene {
    let text = format!(
        "title = {{de='a', en='b'}}\nsummary = {{de='a', en='b'}}\n[run]\n{run}\n[method]\nname='{method}'\n
[[body]]
name = 'beam'
generator = 'block'
size = ['30 mm', '10 mm', '10 mm']
cells = [6, 2, 2]
material = [{{density=1000, law='stable-neo-hookean', youngs_modulus='100 kPa', poisson_ratio=0.3}}]
[[body.clamp]]
nodes = {{min=['-15 mm', -1, -1], max=['-15 mm', 1, 1]}}
{more}"
    );
    let scene = settings::read_scene(&text, "scene.toml", &[]);
    scene.unwrap_or_else(|errors| panic!("{errors}")).settings
}

fn runner(settings: &settings::Scene) -> Runner {
    let none = &mut |_: &std::path::Path| Err(std::io::ErrorKind::NotFound.into());
    let spec = scene_spec(settings, none).expect("a scene").spec;
    Runner::new(settings, Scene::new(&spec).expect("a scene")).expect("probes")
}

fn run(settings: &settings::Scene) -> Runner {
    let mut runner = runner(settings);
    runner.run(&Serial, &mut |_| true);
    runner
}

const RIGHT: &str = "{min=['15 mm', -1, -1], max=['15 mm', 1, 1]}";
const LEFT: &str = "{min=['-15 mm', -1, -1], max=['-15 mm', 1, 1]}";

/// Steps and samples are shortened so that whole numbers fit, and a long step makes the samples longer.
#[test]
fn times_are_divided_into_whole_numbers() {
    for (times, samples, steps) in [
        ("duration=1\nstep='1 ms'\nsample='10 ms'", 100, 10),
        ("duration=1\nstep='3 ms'\nsample='10 ms'", 100, 4),
        ("duration=1\nstep='3 ms'\nsample='30 ms'", 34, 10),
        ("duration=1\nstep='20 ms'\nsample='10 ms'", 50, 1),
        ("duration='0.3 s'\nstep='50 us'\nsample='0.5 ms'", 600, 10),
        ("duration='1 ms'\nstep='1 s'\nsample='1 s'", 1, 1),
    ] {
        let runner = runner(&beam("quasi-static", times, ""));
        assert_eq!((runner.samples, runner.steps), (samples, steps), "{times}");
        let duration = runner.samples as f64 * runner.sample;
        assert!((runner.step() * f64::from(steps) - runner.sample).abs() < 1e-15);
        assert!(
            (duration - 1.0).abs() < 1e-12 || duration < 0.31,
            "{duration}"
        );
    }
}

/// In equilibrium the clamp bears the weight, and its torque about the clamped end is weight times half the length: taken
/// about the clamp with the beam as it hangs, so from the centre of mass.
#[test]
fn probes_measure_what_statics_demands() {
    let probes = format!(
        "[[probe]]\nname='sag'\nbody='beam'\nnodes={RIGHT}\nquantity='displacement'\ndirection=[0, 0, -1]
[[probe]]\nname='weight'\nbody='beam'\nnodes={LEFT}\nquantity='force'\ndirection=[0, 0, 1]
[[probe]]\nname='torque'\nbody='beam'\nnodes={LEFT}\nquantity='torque'\naxis=[0, 1, 0]\npoint=['-15 mm', 0, 0]
[[probe]]\nname='centre-x'\nbody='beam'\nquantity='centre'\ndirection=[1, 0, 0]
[[probe]]\nname='everything'\nbody='beam'\nquantity='force'\ndirection=[0, 0, 1]
[[probe]]\nname='free'\nbody='beam'\nnodes={RIGHT}\nquantity='force'\ndirection=[0, 0, 1]
[[probe]]\nname='far'\nbody='beam'\nquantity='distance'
[[probe]]\nname='volume'\nbody='beam'\nquantity='volume'
[[probe]]\nname='energy'\nbody='beam'\nquantity='energy'
[[expect]]\nprobe='weight'\nwhat='at-end'\nvalue='29.43 mN'\ntolerance=1e-5\nsource='rho g V'
[[expect]]\nprobe='weight'\nwhat='at-end'\nvalue='29.44 mN'\ntolerance=1e-5\nsource='wrong on purpose'
[[expect]]\nprobe='sag'\nwhat='first-peak'\nvalue='1 mm'\ntolerance=1\nsource='it has none'
"
    );
    let times = "duration=1\nstep=0.1\nsample=0.1\nend='rest'\nrest_speed='1 um/s'";
    let settings = beam("quasi-static", times, &probes);
    let runner = run(&settings);
    assert_eq!(runner.end(), Some(&End::Rest));
    let value = |name: &str| {
        let index = settings
            .probe
            .iter()
            .position(|p| p.name == name)
            .expect(name);
        *runner.series().probes[index].last().expect("a sample")
    };
    let weight = 1000.0 * 9.81 * 0.03 * 0.01 * 0.01;
    // The solver stops at 1e-6 of the forces.
    assert!(
        (value("weight") / weight - 1.0).abs() < 1e-5,
        "{}",
        value("weight")
    );
    // The clamp must turn the beam upward: about −y, as z × x is y.
    let torque = -weight * (0.015 + value("centre-x"));
    assert!(
        (value("torque") / torque - 1.0).abs() < 1e-4,
        "{} {torque}",
        value("torque")
    );
    // Nothing holds the free end, whatever residual the solver leaves there; so all nodes are those of the clamp.
    assert_eq!(value("free"), 0.0);
    assert!((value("everything") / weight - 1.0).abs() < 1e-5);
    assert!(value("sag") > 0.0 && value("far") >= value("sag"));
    // What gravity gave is partly stored and, in statics, partly gone.
    assert!(value("energy") < 0.0);
    assert!(value("volume").abs() < 1e-2);

    let verdicts = runner.verdicts();
    assert_eq!(
        verdicts.iter().map(|v| v.met).collect::<Vec<_>>(),
        [true, false, false]
    );
    assert_eq!(verdicts[2].found, None);
    let error = verdicts[1].error.expect("a value");
    assert!((error + 0.01 / 29.44).abs() < 1e-5, "{error}");
}

/// A beam that swings without damping is momentarily still at each turning point: that is no rest.
#[test]
fn what_swings_does_not_rest() {
    let probe = format!(
        "[[probe]]\nname='sag'\nbody='beam'\nnodes={RIGHT}\nquantity='displacement'\ndirection=[0, 0, -1]
[[expect]]\nprobe='sag'\nwhat='at-end'\nvalue='1 mm'\ntolerance=1e9\nsource='any value would do, but it does not rest'
[[expect]]\nprobe='sag'\nwhat='first-peak'\nvalue='1 mm'\ntolerance=1e9\nsource='any'
"
    );
    let probe = probe.replace("1e9", "10");
    let times = "duration=0.2\nstep='0.2 ms'\nend='rest'\nrest_speed='0.1 mm/s'";
    let runner = run(&beam("stoermer-verlet", times, &probe));
    assert_eq!(runner.end(), Some(&End::Duration));
    assert_eq!(
        runner.verdicts().iter().map(|v| v.met).collect::<Vec<_>>(),
        [false, true]
    );
    assert_eq!(runner.series().time.len(), 201);
    assert!((runner.progress(), runner.steps()) == (1.0, 1000));
}

/// A load that grows for half a second is no rest before, however slow it is.
#[test]
fn nothing_rests_before_the_last_event() {
    let load = "[[body.load]]\nsurface={}\npressure='1 Pa'\nramp=0.5\n";
    let times =
        "duration=1\nstep=0.1\nsample=0.1\nend='rest'\nrest_speed='1 mm/s'\ngravity=[0, 0, 0]";
    let runner = run(&beam("quasi-static", times, load));
    assert_eq!(runner.end(), Some(&End::Rest));
    assert!(runner.scene().time() > 0.49, "{}", runner.scene().time());
}

/// Far beyond the stability limit of an explicit method; the scene is at the last good sample, and no last value is taken
/// from it.
#[test]
fn a_divergence_ends_the_run_and_its_expectations() {
    let probe = "[[probe]]\nname='volume'\nbody='beam'\nquantity='volume'
[[expect]]\nprobe='volume'\nwhat='at-end'\nvalue=1\ntolerance=10\nsource='any value would do'
[[expect]]\nprobe='volume'\nwhat='largest'\nvalue=1\ntolerance=10\nsource='any value would do'\n";
    let settings = beam(
        "stoermer-verlet",
        "duration=1\nstep='5 ms'\nsample='10 ms'",
        probe,
    );
    let runner = run(&settings);
    let Some(End::Diverged(diverged)) = runner.end() else {
        panic!("{:?}", runner.end());
    };
    assert_eq!(diverged.body_name, "beam");
    assert!(
        runner
            .scene()
            .body(0)
            .positions()
            .iter()
            .all(|p| p.iter().all(|x| x.is_finite()))
    );
    for verdict in runner.verdicts() {
        assert!((verdict.found, verdict.met) == (None, false), "{verdict:?}");
    }
}

/// The same motion whether sampled often or seldom, on the same steps, but for the rounding of the step's length.
#[test]
fn samples_do_not_disturb() {
    let end = |sample: &str| {
        let times = format!("duration='20 ms'\nstep='0.2 ms'\nsample='{sample}'");
        run(&beam("stoermer-verlet", &times, ""))
            .scene()
            .body(0)
            .positions()
            .to_vec()
    };
    let (often, seldom) = (end("0.2 ms"), end("20 ms"));
    let rest = 0.03;
    for (a, b) in often.iter().zip(&seldom) {
        // The length of a step, sample over steps, is rounded differently: a few bits per step, 100 steps.
        assert!((a - b).norm() < 1e-12 * rest, "{a} {b}");
    }
}

#[test]
fn a_probe_without_nodes_is_refused() {
    let probe = "[[probe]]\nname='p'\nbody='beam'\nnodes={min=[0.5, 0, 0], max=[0.6, 0, 0]}\nquantity='distance'\n";
    let settings = beam("quasi-static", "duration=1\nstep=0.1", probe);
    let none = &mut |_: &std::path::Path| Err(std::io::ErrorKind::NotFound.into());
    let spec = scene_spec(&settings, none).expect("a scene").spec;
    let error = Runner::new(&settings, Scene::new(&spec).expect("a scene")).expect_err("no node");
    assert_eq!((error.probe, error.name.as_str()), (0, "p"));
}
