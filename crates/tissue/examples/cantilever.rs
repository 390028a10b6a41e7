//! Cantilever probe (temporary).
use microsim_mesh::Block;
use microsim_tissue::law::LawName;
use microsim_tissue::*;
use nalgebra::Vector3;
use std::time::Instant;

fn main() {
    let args: Vec<String> = std::env::args().collect();
    let what = args[1].as_str();
    let cells = if args[2] == "S" { [15, 3, 3] } else { [35, 7, 7] };
    let law = LawName::from_name(args.get(3).map_or("stable-neo-hookean", |s| s)).unwrap();
    let block = Block { center: [0.05, 0.0, 0.01], size: [0.1, 0.02, 0.02], cells, split: Default::default() };
    let mesh = block.mesh().unwrap();
    let material = Material {
        density: 1000.0,
        relaxation_time: 0.0,
        behaviour: Behaviour::Continuum(ContinuumConstants { law, young: 1e5, poisson: 0.3, discretisation: Discretisation::Tetrahedra }),
    };
    let clamped: Vec<bool> = mesh.positions.iter().map(|p| p.x < 1e-9).collect();
    let model = build_model(&mesh, &[(0, material)], &clamped, 0.0, vec![]).unwrap();
    let end: Vec<usize> = (0..mesh.positions.len()).filter(|&i| mesh.positions[i].x > 0.1 - 1e-9).collect();
    let sag = |s: &State| -end.iter().map(|&i| s.positions[i].z - mesh.positions[i].z).sum::<f64>() / end.len() as f64 * 1e3;
    let control = Control { gravity: Vector3::new(0.0, 0.0, -9.81), ..Default::default() };
    let none = Contacts::default();
    match what {
        "static" => {
            let mut solver = SolverQuasiStatic::new(&model, Newton { iterations: 100, tolerance: 1e-10, must_converge: true });
            let mut state = State::at_rest(&model);
            let t = Instant::now();
            let r = solver.step(&model, &mut state, &control, &none, 1.0, &Serial);
            println!("{law:?} {r:?} sag {} mm, {:.3} s", sag(&state), t.elapsed().as_secs_f64());
        }
        "peak" => {
            for h in [1.0, 2.0, 5.0, 10.0, 20.0] {
                for (name, method) in [("one", 1u32), ("full", 20)].iter().flat_map(|&(n, it)| {
                    let newton = Newton { iterations: it, tolerance: 1e-6, must_converge: false };
                    [(format!("be {n}"), Method::ImplicitEuler(newton)), (format!("mid {n}"), Method::ImplicitMidpoint(newton)), (format!("sdirk2 {n}"), Method::Sdirk2(newton))]
                }).chain([("xpbd 10".to_string(), Method::Xpbd { substeps: 10, iterations: 1 })]) {
                    let Ok(mut solver) = method.solver(&model) else { continue };
                    let mut state = State::at_rest(&model);
                    let h = h * 1e-3;
                    let (mut best, mut at, mut its) = (0.0, 0.0, 0);
                    let t = Instant::now();
                    let steps = (0.2 / h) as usize;
                    let mut status = String::new();
                    for n in 1..=steps {
                        match solver.step(&model, &mut state, &control, &none, h, &Serial) {
                            Ok(r) => its += r.iterations,
                            Err(e) => { status = format!("{e} at {n}"); break; }
                        }
                        let s = sag(&state);
                        if s > best { best = s; at = n as f64 * h; }
                    }
                    let cpu = t.elapsed().as_secs_f64();
                    println!("h {:4.1} ms {name:12} peak {best:.3} mm at {at:.4} s, {its} its, {:.2} ms/it, {:.2} cpu s per s {status}", h * 1e3, cpu * 1e3 / its as f64, cpu / 0.2);
                }
            }
        }
        "recover" => {
            let h: f64 = args[4].parse().unwrap();
            let newton = Newton { iterations: args[5].parse().unwrap(), tolerance: 1e-6, must_converge: false };
            let rest = {
                let mut solver = SolverQuasiStatic::new(&model, Newton { iterations: 100, tolerance: 1e-8, must_converge: true });
                let mut state = State::at_rest(&model);
                solver.step(&model, &mut state, &control, &none, 1.0, &Serial).unwrap();
                state
            };
            for g in [0.0, -9.81] {
            let control = Control { gravity: Vector3::new(0.0, 0.0, g), ..Default::default() };
            let goal = if g == 0.0 { State::at_rest(&model) } else { rest.clone() };
            for case in ["yank", "flat", "mirror", "teleport"] {
                for (name, method) in [("be", Method::ImplicitEuler(newton)), ("mid", Method::ImplicitMidpoint(newton)), ("sdirk2", Method::Sdirk2(newton)), ("static", Method::QuasiStatic(Newton{iterations:200,..newton})), ("xpbd", Method::Xpbd { substeps: 20, iterations: 1 })] {
                    let Ok(mut solver) = method.solver(&model) else { continue };
                    let mut state = State::at_rest(&model);
                    let mut control = control.clone();
                    match case {
                        "yank" => state.positions[end[0]].z += 0.2,
                        "flat" => for i in 0..model.node_count() { if !clamped[i] { state.positions[i].z = 0.01; } },
                        "mirror" => for i in 0..model.node_count() { if !clamped[i] { state.positions[i].z = 0.02 - state.positions[i].z; } },
                        _ => {}
                    }
                    let shift = if case == "teleport" { Vector3::new(0.0, 0.05, 0.2) } else { Vector3::zeros() };
                    control.clamped_positions = model.clamped().iter().map(|&i| model.rest_positions()[i as usize] + shift).collect();
                    let t = Instant::now();
                    let steps = if name == "static" { 1 } else { (1.2 / h).round() as usize };
                    let mut its = 0;
                    let mut status = String::new();
                    let mut when = f64::NAN;
                    for n in 1..=steps {
                        match solver.step(&model, &mut state, &control, &none, h, &Serial) {
                            Ok(r) => its += r.iterations,
                            Err(e) => { status = format!("{e}"); break; }
                        }
                        let off = (0..model.node_count()).map(|i| (state.positions[i] - shift - goal.positions[i]).norm()).fold(0.0, f64::max);
                        if off < 0.003 { if when.is_nan() { when = n as f64 * h; } } else { when = f64::NAN; }
                    }
                    let off = (0..model.node_count()).map(|i| (state.positions[i] - shift - goal.positions[i]).norm()).fold(0.0, f64::max);
                    let inverted = model.tets().iter().filter(|t| { let [a, b, c, d] = t.map(|n| &state.positions[n as usize]); microsim_mesh::signed_volume(a, b, c, d) <= 0.0 }).count();
                    println!("g {g} {case:9}{name:7} off {:.2} % since {when:.3}, inverted {inverted}, {its} its, {:.3} s {status}", off * 1e3, t.elapsed().as_secs_f64());
                }
            }
            }
        }
        _ => {}
    }
}
