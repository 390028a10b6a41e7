//! The dish of level 2 is what its example writes, closed towards the trainee and where the level has room for it.

#[allow(dead_code, reason = "its `main` writes the file")]
#[path = "../examples/write_touch_spheres_dish.rs"]
mod written;

use microsim_model::{Model, read};

fn model(bytes: &[u8]) -> Model {
    read("dish.glb", bytes, &|_| None).expect("a model")
}

/// As what it holds: another version of the encoder of pictures may write other bytes.
#[test]
fn the_dish_is_what_its_example_writes() {
    let shipped = include_bytes!("../assets/dish.glb");
    let written = written::dish().expect("a dish");
    assert!(
        model(shipped) == model(&written),
        "run the example write_touch_spheres_dish"
    );
}

/// Triangles are counterclockwise from where their normals point, and the normals have length one.
#[test]
fn its_faces_look_outwards() {
    let model = model(include_bytes!("../assets/dish.glb"));
    let part = &model.parts[0];
    assert_eq!(model.parts.len(), 1);
    assert!(part.texture.is_some() && part.mask.is_none());
    for triangle in &part.triangles {
        let [a, b, c] = triangle.map(|v| part.positions[v as usize].map(f64::from));
        let [u, v] = [b, c].map(|p| [p[0] - a[0], p[1] - a[1], p[2] - a[2]]);
        let face = [
            u[1] * v[2] - u[2] * v[1],
            u[2] * v[0] - u[0] * v[2],
            u[0] * v[1] - u[1] * v[0],
        ];
        for vertex in triangle {
            let normal = part.normals[*vertex as usize].map(f64::from);
            let length: f64 = normal.iter().map(|x| x * x).sum();
            assert!((length - 1.0).abs() < 1e-5, "{normal:?}");
            let along: f64 = (0..3).map(|k| face[k] * normal[k]).sum();
            assert!(along > 0.0, "{triangle:?} at {a:?}: {along}");
        }
    }
}
