//! A texture copied into a place of the window, pixel by pixel.
//!
//! egui's own shader filters each texel of an image four times, which on a software driver takes longer than the picture of the field itself.

use eframe::egui::{PaintCallbackInfo, Rect, Shape};
use eframe::egui_wgpu::{Callback, CallbackResources, CallbackTrait};
use eframe::wgpu;

/// A triangle over all of the place; each pixel gets the texel at its place.
const SHADER: &str = "
@group(0) @binding(0) var picture: texture_2d<f32>;

struct Corner {
    @builtin(position) position: vec4f,
    @location(0) place: vec2f,
}

@vertex
fn corner(@builtin(vertex_index) index: u32) -> Corner {
    let place = vec2f(f32((index << 1u) & 2u), f32(index & 2u));
    return Corner(vec4f(2.0 * place.x - 1.0, 1.0 - 2.0 * place.y, 0.0, 1.0), place);
}

@fragment
fn texel(corner: Corner) -> @location(0) vec4f {
    let size = vec2f(textureDimensions(picture));
    return textureLoad(picture, vec2i(min(corner.place * size, size - 1.0)), 0);
}
";

/// Copies textures into windows of one format.
pub struct Blitter {
    pipeline: wgpu::RenderPipeline,
    target: wgpu::TextureFormat,
}

impl Blitter {
    /// For the format of a window.
    pub fn new(device: &wgpu::Device, target: wgpu::TextureFormat) -> Self {
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("blit"),
            source: wgpu::ShaderSource::Wgsl(SHADER.into()),
        });
        let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("blit"),
            layout: None,
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("corner"),
                compilation_options: Default::default(),
                buffers: &[],
            },
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some("texel"),
                compilation_options: Default::default(),
                targets: &[Some(target.into())],
            }),
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: None,
            multisample: wgpu::MultisampleState::default(),
            multiview_mask: None,
            cache: None,
        });
        Self { pipeline, target }
    }

    /// A texture of encoded colours that can be shown.
    pub fn shown(&self, device: &wgpu::Device, texture: &wgpu::Texture) -> Shown {
        // What the window encodes has to be decoded before; otherwise colours stay as they are.
        let format = match self.target.is_srgb() {
            true => texture.format().add_srgb_suffix(),
            false => texture.format().remove_srgb_suffix(),
        };
        let view = texture.create_view(&wgpu::TextureViewDescriptor {
            format: Some(format),
            ..Default::default()
        });
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("blit"),
            layout: &self.pipeline.get_bind_group_layout(0),
            entries: &[wgpu::BindGroupEntry {
                binding: 0,
                resource: wgpu::BindingResource::TextureView(&view),
            }],
        });
        Shown {
            pipeline: self.pipeline.clone(),
            group,
        }
    }
}

/// A texture that can be shown.
#[derive(Clone, Debug)]
pub struct Shown {
    pipeline: wgpu::RenderPipeline,
    group: wgpu::BindGroup,
}

impl Shown {
    /// All of it, in a place of the window.
    pub fn at(&self, place: Rect) -> Shape {
        Callback::new_paint_callback(place, self.clone()).into()
    }
}

impl CallbackTrait for Shown {
    fn paint(
        &self,
        _: PaintCallbackInfo,
        pass: &mut wgpu::RenderPass<'static>,
        _: &CallbackResources,
    ) {
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.group, &[]);
        pass.draw(0..3, 0..1);
    }
}
