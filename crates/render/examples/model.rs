//! Draws a model from a file as the microscope shows it, with its own texture or another one: `cargo run --release --example model -p microsim-render --
//! MODEL PICTURE.png [SCALE [TEXTURE.png]]`. `SCALE`: metres in a unit of the file, 0.001 if left out. The field is as wide as the model and half of it, tilted by 40°.

use microsim_gpu::Gpu;
use microsim_message::{ObjectScene, ObjectState, Pose, Shape};
use microsim_render::{Finish, Models, Picture, Renderer, View};
use std::error::Error;
use std::path::Path;

/// Width and height \[pixels\].
const SIZE: u32 = 720;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let (Some(file), Some(target)) = (arguments.first(), arguments.get(1)) else {
        return Err("MODEL PICTURE.png [SCALE [TEXTURE.png]]".into());
    };
    let scale = arguments.get(2).map_or(Ok(1e-3), |scale| scale.parse())?;
    let name = |path: &Path| {
        path.file_name()
            .map(|name| name.to_string_lossy().into_owned())
    };
    let path = Path::new(file);
    let model = name(path).ok_or("a model without a name")?;
    let bytes = std::fs::read(path)?;
    let mut files = vec![(model.clone(), bytes.clone())];
    for reference in microsim_model::references(&model, &bytes)? {
        let bytes = std::fs::read(path.with_file_name(&reference))?;
        files.push((format!("{model}/{reference}"), bytes));
    }
    let texture = arguments.get(3).map(Path::new);
    if let Some(texture) = texture {
        let name = name(texture).ok_or("a texture without a name")?;
        files.push((name, std::fs::read(texture)?));
    }
    let of_file = |wanted: &str| {
        let file = files.iter().find(|(name, _)| name == wanted);
        file.map(|(_, bytes)| &bytes[..])
    };
    let beside = |reference: &str| of_file(&format!("{model}/{reference}"));
    let parts = microsim_model::read(&model, &bytes, &beside)?.placed();
    let corners = parts.iter().flat_map(|part| &part.positions);
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for corner in corners {
        for k in 0..3 {
            low[k] = low[k].min(scale * f64::from(corner[k]));
            high[k] = high[k].max(scale * f64::from(corner[k]));
        }
    }
    let centre = std::array::from_fn(|k| 0.5 * (low[k] + high[k]));
    let width = (0..3).map(|k| high[k] - low[k]).fold(0.0, f64::max);
    let scene = ObjectScene {
        objects: vec![ObjectState {
            name: "model".into(),
            shape: Shape::Model {
                model: model.clone(),
                scale,
                texture: texture.and_then(name),
            },
            pose: Pose::default(),
            colour: [1.0; 3],
            finish: Finish::Matte,
        }],
    };
    let borrowed: Vec<(&str, &[u8])> = files
        .iter()
        .map(|(n, bytes)| (&n[..], &bytes[..]))
        .collect();
    let items = Models::new(&borrowed)?.items(&scene);
    let view = View::of_microscope(centre, 1.5 * width, 40_f64.to_radians());
    let mut renderer = Renderer::new(&Gpu::off_screen()?)?;
    let image = renderer.draw(&Picture::new((SIZE, SIZE), view, items))?;
    image.write_png(Path::new(target))?;
    Ok(())
}
