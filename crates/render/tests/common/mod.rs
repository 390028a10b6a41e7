//! What tests of pictures have in common.

use microsim_gpu::Gpu;
use microsim_render::Renderer;

/// A renderer; without a graphics driver `None`, which is printed.
pub fn renderer() -> Option<Renderer> {
    match Gpu::off_screen() {
        Ok(gpu) => Some(Renderer::new(&gpu).expect("the driver opened, so it takes the shaders")),
        Err(error) => {
            println!("picture test skipped: {error}");
            None
        }
    }
}
