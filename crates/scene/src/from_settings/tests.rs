use super::*;
use crate::spec::{BoxSpec, LoadKind};
use microsim_mesh::format::write_gmsh_2;
use microsim_mesh::{Block, CellSplit};
use microsim_tissue::law::{LawName, MaterialLaw};
use microsim_tissue::{Behaviour, Discretisation, Material};
use nalgebra::Vector3;

/// A scene with these lines of a body besides its name.
fn read(method: &str, body: &str) -> settings::Scene {
    // Statics needs something that holds.
    let clamp = if method == "quasi-static" && !body.contains("clamp") {
        "clamp = [{nodes = {min = ['-1.5 mm', '-1 m', '-1 m'], max = ['-1.5 mm', '1 m', '1 m']}}]\n"
    } else {
        ""
    };
    let text = format!(
        "title = {{de='a', en='b'}}\nsummary = {{de='a', en='b'}}\nrun = {{duration=1, step=0.01}}\n\
         method = {{name='{method}'}}\n[[body]]\nname = 'body'\n{clamp}{body}"
    );
    let scene = settings::read_scene(&text, "scene.toml", &[]);
    scene.unwrap_or_else(|errors| panic!("{errors}")).settings
}

const BLOCK: &str = "generator = 'block'\nsize = ['3 mm', '2 mm', '1 mm']\ncells = [3, 2, 1]\n";
const MATERIAL: &str = "material = [{density=1000, law='springs', stretch_modulus='10 kPa'}]\n";

fn no_file(_: &Path) -> io::Result<Vec<u8>> {
    Err(io::ErrorKind::NotFound.into())
}

fn describe(scene: &settings::Scene) -> SceneSpec {
    let described = scene_spec(scene, &mut no_file);
    described.unwrap_or_else(|error| panic!("{error}")).spec
}

fn material(lines: &str) -> Material {
    let scene = read(
        "quasi-static",
        &format!("{BLOCK}[[body.material]]\ndensity=1000\n{lines}"),
    );
    describe(&scene).bodies[0].materials[0].1
}

/// What files may write is what tissue can do, under the same names.
#[test]
fn every_name_of_the_settings_means_its_namesake() {
    for name in settings::MethodName::NAMES {
        let spec = describe(&read(name, &format!("{BLOCK}{MATERIAL}")));
        assert_eq!(spec.method.name(), name);
    }
    let constants = "youngs_modulus=1e5\npoisson_ratio=0.4\n";
    for law in LawName::ALL {
        let (name, mut own) = (law.name(), String::new());
        for (key, _) in law.parameters() {
            own += &format!("{key}=1\n");
        }
        own += match law.families() {
            0 => "",
            1 => "fibres={direction=[0, 0, 2]}\n",
            _ => "fibres={direction=[0, 0, 2], second_direction=[3, 0, 0]}\n",
        };
        // A dispersion of one there is not.
        own = own.replace("dispersion=1", "dispersion=0.25");
        match material(&format!("law='{name}'\n{constants}{own}")).behaviour {
            Behaviour::Continuum(continuum) => assert_eq!(
                Ok::<_, ()>(continuum.law),
                MaterialLaw::read(law, &|key| Ok(match key {
                    "fibre_dispersion" => 0.25,
                    _ => 1.0,
                }))
            ),
            other => panic!("{name} is {other:?}"),
        }
    }
    for name in Discretisation::NAMES {
        let lines = format!("law='corotational'\ndiscretisation='{name}'\n{constants}");
        match material(&lines).behaviour {
            Behaviour::Continuum(continuum) => assert_eq!(continuum.discretisation.name(), name),
            other => panic!("{name} is {other:?}"),
        }
    }
}

/// Each material gives its own elements their directions; others have none.
#[test]
fn fibres_of_a_layer_lie_around_the_axis_of_its_tube() {
    let tube = "generator='tube'\ninner_radius='2 mm'\nlength='4 mm'\naround=8\nalong=1\naxis=[0, 0, 3]\ncentre=['1 m', 0, 0]\n\
                layer=[{thickness='1 mm', cells=1, region=1}, {thickness='1 mm', cells=1, region=2}]\n\
                clamp=[{nodes={min=[-1, -1, -1], max=[1, 1, 1]}}]\n";
    let common = "density=1000\nyoungs_modulus=1e5\npoisson_ratio=0.3\n";
    let materials = format!(
        "[[body.material]]\nregion=2\nlaw='transversely-isotropic'\nfibre_ratio=4\nfibres={{angle='0 deg'}}\n{common}\
         [[body.material]]\nlaw='neo-hookean'\n{common}"
    );
    let spec = describe(&read("quasi-static", &format!("{tube}{materials}")));
    let mesh = &spec.bodies[0].mesh;
    let mut with = 0;
    for element in 0..mesh.tets.len() {
        let [direction, second] = mesh.fibres(element);
        assert_eq!(second, Vector3::zeros());
        assert_eq!(direction != second, mesh.regions[element] == 2);
        if direction != second {
            let centre = mesh.corners(element).iter().sum::<Vector3<f64>>() / 4.0;
            let out = centre - Vector3::new(1.0, 0.0, centre.z);
            assert!((direction.norm() - 1.0).abs() < 1e-15);
            assert!(direction.z == 0.0 && direction.dot(&out).abs() < 1e-17);
            // Right-handed about the axis.
            assert!(out.cross(&direction).z > 0.0);
            with += 1;
        }
    }
    assert_eq!(with, 48);
    assert!(
        spec.bodies[0]
            .materials
            .iter()
            .any(|(_, m)| m.directions() == 1)
    );
}

/// τ = η/E.
#[test]
fn a_viscosity_is_a_relaxation_time_of_the_modulus() {
    for lines in [
        "law='corotational'\nyoungs_modulus=1e5\npoisson_ratio=0.3\nviscosity='200 Pa s'",
        "law='springs'\nstretch_modulus=1e5\nviscosity='200 Pa s'",
        "law='springs'\nform='fitted'\nyoungs_modulus=1e5\npoisson_ratio=0.3\nviscosity='200 Pa s'",
        "law='springs'\nform='plain'\nlength_stiffness=1\nrelaxation_time='2 ms'",
    ] {
        assert_eq!(material(lines).relaxation_time, 0.002, "{lines}");
    }
}

#[test]
fn what_is_attached_to_a_body_keeps_its_values_and_order() {
    let attached = "
[[body.clamp]]
nodes = {min=['-1.5 mm', -1, -1], max=['-1.5 mm', 1, 1]}
[[body.clamp]]
nodes = {shell={axis=[0, 0, 3], radius=[0, '1 mm']}}
axis = [0, 2, 0]
motion = [{time=0.5, shift=[0, 0, '2 mm'], angle='180 deg'}]
release = 0.75
[[body.load]]
surface = {}
pressure = '2 kPa'
ramp = 0.25
[[body.start]]
nodes = {nearest=[0, 0, 0]}
velocity = [1, 0, 0]
";
    let body = describe(&read(
        "xpbd",
        &format!("{BLOCK}centre=[0, 0, '5 mm']\ndrag=7\n{MATERIAL}{attached}"),
    ));
    let body = &body.bodies[0];
    assert_eq!((body.origin, body.drag), ([0.0, 0.0, 0.005], 7.0));
    let held = BoxSpec {
        min: [-0.0015, -1.0, -1.0],
        max: [-0.0015, 1.0, 1.0],
    };
    assert_eq!(body.clamps[0].nodes, Selection::Box(held));
    assert_eq!(
        (&body.clamps[0].motion, body.clamps[0].release),
        (&None, None)
    );
    let shell = Selection::Shell {
        point: [0.0; 3],
        axis: [0.0, 0.0, 1.0],
        radius: [0.0, 0.001],
    };
    assert_eq!(
        (&body.clamps[1].nodes, body.clamps[1].release),
        (&shell, Some(0.75))
    );
    let motion = body.clamps[1].motion.as_ref().expect("a motion");
    assert_eq!(
        (motion.axis, motion.keys[0].angle),
        ([0.0, 1.0, 0.0], std::f64::consts::PI)
    );
    assert_eq!(body.loads[0].kind, LoadKind::Pressure(2000.0));
    assert_eq!(
        (&body.loads[0].surface, body.loads[0].ramp),
        (&Selection::All, 0.25)
    );
    assert_eq!(body.start[0].velocity, [1.0, 0.0, 0.0]);
    // The mesh stands around the centre.
    let lowest = body
        .mesh
        .positions
        .iter()
        .map(|p| p.z)
        .fold(f64::INFINITY, f64::min);
    assert!((lowest - 0.0045).abs() < 1e-15, "{lowest}");
}

/// Two layers, of which one has a material of its own.
#[test]
fn a_material_without_a_region_is_for_the_rest() {
    let tube = "generator='tube'\ninner_radius='1 mm'\nlength='2 mm'\naround=8\nalong=2\n\
        layer=[{thickness='0.1 mm', cells=1, region=3}, {thickness='0.1 mm', cells=1, region=5}, {thickness='0.1 mm', cells=1, region=9}]\n";
    let soft = "{density=1000, law='springs', stretch_modulus=1}";
    let hard =
        |region| format!("{{region={region}, density=2000, law='springs', stretch_modulus=1}}");
    let scene = read("xpbd", &format!("{tube}material=[{soft}, {}]\n", hard(5)));
    let spec = describe(&scene);
    let densities = spec.bodies[0]
        .materials
        .iter()
        .map(|(region, m)| (*region, m.density));
    let mut densities: Vec<(u32, f64)> = densities.collect();
    densities.sort_by_key(|(region, _)| *region);
    assert_eq!(densities, [(3, 1000.0), (5, 2000.0), (9, 1000.0)]);

    let scene = read("xpbd", &format!("{tube}material=[{soft}, {}]\n", hard(4)));
    let error = scene_spec(&scene, &mut no_file).expect_err("no region 4");
    assert_eq!(error.key.to_string(), "body[0].material[1].region");
    let regions = vec![3, 5, 9];
    assert_eq!(
        *error.cause,
        FromSettingsCause::Region { region: 4, regions }
    );
}

/// A block written as a Gmsh file in millimetres comes back in metres, at its place.
#[test]
fn a_mesh_file_is_scaled_and_placed() {
    let block = Block {
        center: [0.0; 3],
        size: [3.0, 2.0, 1.0],
        cells: [3, 2, 1],
        split: CellSplit::Kuhn,
    };
    let mesh = block.mesh().expect("a block");
    let file = write_gmsh_2(&mesh);
    let scene = read(
        "xpbd",
        &format!(
            "generator='file'\nfile='meshes/block.msh'\nscale='1 mm'\ncentre=[0, 0, '5 mm']\n{MATERIAL}"
        ),
    );
    let mut asked = Vec::new();
    let described = scene_spec(&scene, &mut |path| {
        asked.push(path.to_path_buf());
        Ok(file.clone())
    });
    let read_back = &described.expect("a mesh").spec.bodies[0].mesh;
    assert_eq!(asked, [Path::new("meshes/block.msh")]);
    assert_eq!(read_back.tets, mesh.tets);
    for (found, unit) in read_back.positions.iter().zip(&mesh.positions) {
        let expected = unit * 1e-3 + Vector3::z() * 0.005;
        assert!((found - expected).norm() < 1e-17, "{found}");
    }
}

#[test]
fn a_file_that_is_no_mesh_is_named() {
    let body = |file: &str| format!("generator='file'\nfile='{file}'\n{MATERIAL}");
    let error = |file: &str, load: &mut Load<'_>| {
        let error = scene_spec(&read("xpbd", &body(file)), load).expect_err(file);
        assert_eq!(error.key.to_string(), "body[0].file");
        error.cause.to_string()
    };
    let missing = error("a.msh", &mut no_file);
    assert!(
        missing.starts_with("the mesh file `a.msh` cannot be read: "),
        "{missing}"
    );
    let unknown = error("a.txt", &mut |_| Ok(Vec::new()));
    assert!(unknown.starts_with("`a.txt` is no mesh file"), "{unknown}");
    let broken = error("a.msh", &mut |_| Ok(b"nothing".to_vec()));
    assert!(broken.starts_with("`a.msh`: "), "{broken}");
    // TetGen has two files; each is asked for by its name.
    let mut asked = Vec::new();
    let _ = error("a.node", &mut |path| {
        asked.push(path.display().to_string());
        Ok(Vec::new())
    });
    assert_eq!(asked, ["a.node", "a.ele"]);
}

/// A closed surface is filled; its volume is that of the box it bounds, whose sides are multiples of the cell.
#[test]
fn a_closed_surface_is_filled() {
    let surface = "\
v 0 0 0\nv 4 0 0\nv 4 2 0\nv 0 2 0\nv 0 0 2\nv 4 0 2\nv 4 2 2\nv 0 2 2\n\
f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
    let scene = read(
        "xpbd",
        &format!("generator='file'\nfile='box.obj'\nscale='1 mm'\nfill='0.5 mm'\n{MATERIAL}"),
    );
    let described = scene_spec(&scene, &mut |_| Ok(surface.as_bytes().to_vec()));
    let mesh = &described
        .unwrap_or_else(|error| panic!("{error}"))
        .spec
        .bodies[0]
        .mesh;
    let volume: f64 = mesh.volumes().iter().sum();
    assert!((volume / 16e-9 - 1.0).abs() < 0.05, "{volume}");
}

/// A strip is fine across its middle, a region of a tube is fine, and the faces at its ends are still its ends; in the body's frame: the block lies 1 mm beside
/// the origin of the field.
#[test]
fn meshes_are_refined_where_bodies_ask_for_it() {
    let block = format!("{BLOCK}centre = ['1 mm', 0, 0]\n{MATERIAL}");
    let plain = describe(&read("quasi-static", &block))
        .bodies
        .remove(0)
        .mesh;
    let refine =
        "refine = [{point=[0, '-1 mm', 0], to=[0, '1 mm', 0], radius='0.1 mm', size='0.4 mm'}]\n";
    let fine = describe(&read("quasi-static", &format!("{block}{refine}")))
        .bodies
        .remove(0)
        .mesh;
    let longest = |mesh: &microsim_mesh::TetMesh, element: usize| {
        let edges = mesh
            .element_edges(element)
            .map(|[a, b]| (mesh.positions[a as usize] - mesh.positions[b as usize]).norm());
        edges.into_iter().fold(0.0, f64::max)
    };
    let mut small = 0;
    for element in 0..fine.tets.len() {
        let middle: Vector3<f64> = fine.corners(element).iter().sum::<Vector3<f64>>() / 4.0;
        let near = Vector3::new(middle.x - 1e-3, 0.0, middle.z).norm() < 0.1e-3;
        assert!(!near || longest(&fine, element) <= 0.4e-3);
        small += usize::from(near);
    }
    assert!(small > 0 && fine.tets.len() > 4 * plain.tets.len());
    let volume = |mesh: &microsim_mesh::TetMesh| mesh.volumes().iter().sum::<f64>();
    assert!((volume(&fine) / volume(&plain) - 1.0).abs() < 1e-12);

    let tube = "generator='tube'\ninner_radius='0.5 mm'\nlength='2 mm'\naround=12\nalong=4\n\
                layer=[{thickness='0.1 mm', cells=1}, {thickness='0.1 mm', cells=1, region=1}]\n";
    for discretisation in ["selective", "quadratic-pressure"] {
        let material = format!(
            "material=[{{density=1000, law='stable-neo-hookean', youngs_modulus='1 MPa', poisson_ratio=0.45, discretisation='{discretisation}'}}]\n"
        );
        let area = |refine: &str| {
            let read = read("implicit-euler", &format!("{tube}{material}{refine}"));
            let body = describe(&read).bodies.remove(0);
            assert!(body.mesh.volumes().iter().all(|v| *v > 0.0));
            let areas = body.ends.iter().map(|faces| -> f64 {
                let of_face = |face: &[u32; 3]| {
                    let [a, b, c] = face.map(|n| body.mesh.positions[n as usize]);
                    (b - a).cross(&(c - a)).norm() / 2.0
                };
                faces.iter().map(of_face).sum()
            });
            (body.ends[0].len(), areas.collect::<Vec<f64>>())
        };
        let (coarse, fine) = (area(""), area("refine = [{region=1, size='0.25 mm'}]\n"));
        assert!(fine.0 > coarse.0);
        for (before, after) in coarse.1.iter().zip(&fine.1) {
            // Straight edges are divided. Curved ones have 24 sides before, of 0.98862 of each circle; the outer comes closer to its circle, (0.7² − 0.98862 · 0.5²) /
            // (0.98862 (0.7² − 0.5²)) = 1.0235 at most.
            match discretisation {
                "selective" => assert!((after / before - 1.0).abs() < 1e-12, "{before} {after}"),
                _ => assert!(
                    (1.001..1.0235).contains(&(after / before)),
                    "{before} {after}"
                ),
            }
        }
    }
}

/// A region that is not there is known when the mesh is, and so is how many tetrahedra there would be.
#[test]
fn refinement_that_cannot_be_made_names_its_key() {
    let refused = |refine: &str| {
        let scene = read("quasi-static", &format!("{BLOCK}{MATERIAL}{refine}"));
        scene_spec(&scene, &mut no_file)
            .expect_err("refused")
            .to_string()
    };
    let place = "{point=[0, 0, 0], radius='0.1 mm', size='0.3 mm'}";
    let said = refused(&format!("refine = [{place}, {{region=4, size='1 mm'}}]\n"));
    assert!(
        said.contains("`body[0].refine[1]`") && said.contains("region 4"),
        "{said}"
    );
    let said = refused("refine = [{region=0, size='2 um'}]\n");
    assert!(
        said.contains("`body[0].refine[0]`") && said.contains("expected 5000000 at most"),
        "{said}"
    );
}
