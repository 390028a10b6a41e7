//! Drawing: pipelines made once, textures retained while the size stays, one upload and three passes per picture.

use microsim_gpu::Gpu;
use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::error::RenderError;
use crate::image::Image;
use crate::light::{AMBIENT, COAXIAL, key_light_direction, key_strength, linear_from_srgb};
use crate::picture::{Picture, View};
use crate::pipelines::Pipelines;
use crate::surface::Surfaces;
use crate::targets::{DEPTH, Targets, texture};
use crate::upload::Upload;

/// Side of the shadow map \[texels\].
const SHADOW_SIDE: u32 = 1024;
/// Half the side of the square across the key light that the shadow map covers \[field radii\]: the field, seen at 35°, and what
/// stands up to one radius high in it.
const SHADOW_REACH: f64 = 1.5;
/// Depth range of the shadow map along the key light \[field radii\], with the focus point at zero: instruments reach up, nothing
/// below is seen for long.
const SHADOW_DEPTHS: [f64; 2] = [-3.0, 9.0];
/// Nearest plane that is drawn, in parts of the working distance. Shafts that reach higher have left the field.
const NEAR: f64 = 0.2;
/// Pictures that may be under way at once: one is drawn while the next is being encoded.
const UNDER_WAY: usize = 2;
/// What a buffer begins with \[bytes\].
const FIRST_BYTES: u64 = 1 << 16;

/// Draws pictures. Not shared between threads: each thread that draws has its own.
pub struct Renderer {
    gpu: Gpu,
    pipelines: Pipelines,
    scene: wgpu::Buffer,
    scene_group: wgpu::BindGroup,
    shadow_group: wgpu::BindGroup,
    shadow_view: wgpu::TextureView,
    vertices: Upload,
    indices: Upload,
    targets: Option<Targets>,
    /// Pictures that were submitted and are not known to be finished, the oldest first.
    under_way: VecDeque<(wgpu::SubmissionIndex, Arc<AtomicBool>)>,
}

/// The shader's `Scene`, same order.
#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Scene {
    lens: [f32; 4],
    light: [[f32; 4]; 3],
    lamps: [f32; 4],
    background: [f32; 4],
    field: [f32; 4],
}

impl Renderer {
    /// Compiles the shaders on `gpu`. Takes some hundred milliseconds with a software driver.
    ///
    /// # Errors
    /// [`RenderError::Device`] when the driver refuses.
    pub fn new(gpu: &Gpu) -> Result<Self, RenderError> {
        watched(gpu, || Ok(Self::build(gpu)))
    }

    /// Draws one picture and waits for it: [`render`](Self::render), then [`read_back`](Self::read_back).
    ///
    /// # Errors
    /// Those of both. The renderer can be used again after each of them, except after the loss of the device.
    pub fn draw(&mut self, picture: &Picture) -> Result<Image, RenderError> {
        self.render(picture)?;
        self.read_back()
    }

    /// Encodes and submits one picture and does not wait until it is drawn; returns the view that it is drawn into, in
    /// [`texture`](Self::texture). What is submitted to the same queue later sees the finished picture.
    ///
    /// Pictures do not queue up: the call waits for the picture before the previous one, so that one is drawn while the next is being encoded.
    ///
    /// # Errors
    /// A size that the adapter cannot draw, a view or an item with impossible numbers: found before anything is drawn. What the driver refuses (validation,
    /// memory) is found in this call, without waiting. What fails while the picture is being drawn is the loss of the device: the next call of
    /// this, [`read_back`](Self::read_back) or [`Gpu::lost`] reports it.
    pub fn render(&mut self, picture: &Picture) -> Result<&wgpu::TextureView, RenderError> {
        self.check(picture)?;
        self.is_busy()?;
        let gpu = self.gpu.clone();
        while self.under_way.len() >= UNDER_WAY {
            let oldest = self.under_way.pop_front().map(|(index, _)| index);
            self.wait(oldest)?;
        }
        watched(&gpu, || {
            self.submit(picture);
            Ok(())
        })?;
        match &self.targets {
            Some(targets) => Ok(&targets.view),
            None => unreachable!("submit makes the targets"),
        }
    }

    /// Waits for the last picture that was rendered and takes its pixels to memory.
    ///
    /// # Errors
    /// [`RenderError::Device`] when the driver fails, and when nothing was rendered yet.
    pub fn read_back(&mut self) -> Result<Image, RenderError> {
        let Some(targets) = &self.targets else {
            return Err(RenderError::Device {
                reason: "no picture was rendered that could be read back".to_owned(),
            });
        };
        let gpu = &self.gpu;
        let image = watched(gpu, || {
            let mut encoder = gpu.device().create_command_encoder(&Default::default());
            targets.copy_back(&mut encoder);
            gpu.queue().submit([encoder.finish()]);
            targets.read(gpu.device())
        });
        self.under_way.clear();
        image
    }

    /// The texture of the last picture, sRGB; a view of it as `Rgba8Unorm` gives the encoded bytes, and it can be bound. It stays the same while the
    /// size of the pictures does. `None` before the first picture.
    pub fn texture(&self) -> Option<&wgpu::Texture> {
        self.targets.as_ref().map(|targets| &targets.resolved)
    }

    /// Whether the last picture is not finished yet. Asks the driver and does not wait.
    ///
    /// # Errors
    /// The loss of the device.
    pub fn is_busy(&mut self) -> Result<bool, RenderError> {
        let polled = self.gpu.device().poll(wgpu::PollType::Poll);
        self.alive()?;
        polled.map_err(|error| RenderError::Device {
            reason: error.to_string(),
        })?;
        let finished = |done: &Arc<AtomicBool>| done.load(Ordering::Acquire);
        self.under_way.retain(|(_, done)| !finished(done));
        Ok(!self.under_way.is_empty())
    }

    /// Waits for one submission.
    fn wait(&self, submission_index: Option<wgpu::SubmissionIndex>) -> Result<(), RenderError> {
        let polled = self.gpu.device().poll(wgpu::PollType::Wait {
            submission_index,
            timeout: None,
        });
        self.alive()?;
        polled.map(|_| ()).map_err(|error| RenderError::Device {
            reason: error.to_string(),
        })
    }

    fn alive(&self) -> Result<(), RenderError> {
        alive(&self.gpu)
    }

    fn check(&self, picture: &Picture) -> Result<(), RenderError> {
        let (width, height, max) = (picture.width, picture.height, self.gpu.max_picture_side());
        if !(1..=max).contains(&width) || !(1..=max).contains(&height) {
            return Err(RenderError::Size { width, height, max });
        }
        if let Some(reason) = picture.view.fault() {
            return Err(RenderError::View { reason });
        }
        for (index, item) in picture.items.iter().enumerate() {
            if let Some(reason) = item.fault() {
                return Err(RenderError::Item { index, reason });
            }
        }
        Ok(())
    }

    fn submit(&mut self, picture: &Picture) {
        let (device, queue) = (self.gpu.device(), self.gpu.queue());
        let field_pixels = 0.5 * f64::from(picture.width.min(picture.height));
        let surfaces = Surfaces::build(&picture.items, &picture.view, field_pixels);
        self.vertices.write(device, queue, &surfaces.vertices);
        self.indices.write(device, queue, &surfaces.indices);
        let (vertices, indices) = (self.vertices.buffer(), self.indices.buffer());
        queue.write_buffer(
            &self.scene,
            0,
            bytemuck::bytes_of(&scene_of(picture, field_pixels)),
        );
        let targets = match self.targets.take() {
            Some(targets) if (targets.width, targets.height) == (picture.width, picture.height) => {
                targets
            }
            _ => Targets::new(device, picture.width, picture.height),
        };

        let mut encoder = device.create_command_encoder(&Default::default());
        {
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("shadow"),
                depth_stencil_attachment: Some(depth_attachment(
                    &self.shadow_view,
                    wgpu::StoreOp::Store,
                )),
                ..Default::default()
            });
            pass.set_pipeline(&self.pipelines.shadow);
            pass.set_bind_group(0, &self.scene_group, &[]);
            pass.set_vertex_buffer(0, vertices.slice(..));
            pass.set_index_buffer(indices.slice(..), wgpu::IndexFormat::Uint32);
            for layer in surfaces.layers.iter().filter(|layer| layer.solid) {
                pass.draw_indexed(layer.indices.clone(), 0, 0..1);
            }
        }
        {
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("field"),
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: &targets.samples,
                    depth_slice: None,
                    resolve_target: Some(&targets.view),
                    ops: wgpu::Operations {
                        load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                        store: wgpu::StoreOp::Discard,
                    },
                })],
                depth_stencil_attachment: Some(depth_attachment(
                    &targets.depth,
                    wgpu::StoreOp::Discard,
                )),
                ..Default::default()
            });
            pass.set_bind_group(0, &self.scene_group, &[]);
            pass.set_pipeline(&self.pipelines.background);
            pass.draw(0..3, 0..1);
            pass.set_bind_group(1, &self.shadow_group, &[]);
            pass.set_vertex_buffer(0, vertices.slice(..));
            pass.set_index_buffer(indices.slice(..), wgpu::IndexFormat::Uint32);
            for layer in surfaces.layers {
                pass.set_pipeline(
                    &self.pipelines.surface[usize::from(layer.solid)][usize::from(layer.closed)],
                );
                pass.draw_indexed(layer.indices, 0, 0..1);
            }
        }
        let index = queue.submit([encoder.finish()]);
        let done = Arc::new(AtomicBool::new(false));
        let finished = done.clone();
        queue.on_submitted_work_done(move || finished.store(true, Ordering::Release));
        self.under_way.push_back((index, done));
        self.targets = Some(targets);
    }

    fn build(gpu: &Gpu) -> Self {
        let device = gpu.device();
        let pipelines = Pipelines::new(device);
        let scene = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("scene"),
            size: size_of::<Scene>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let scene_group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("scene"),
            layout: &pipelines.scene_layout,
            entries: &[wgpu::BindGroupEntry {
                binding: 0,
                resource: scene.as_entire_binding(),
            }],
        });
        let shadow_view = texture(
            device,
            (SHADOW_SIDE, SHADOW_SIDE),
            1,
            DEPTH,
            wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
        )
        .create_view(&Default::default());
        let shadow_sampler = device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("shadow"),
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            compare: Some(wgpu::CompareFunction::LessEqual),
            ..Default::default()
        });
        let shadow_group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("shadow"),
            layout: &pipelines.shadow_layout,
            entries: &[
                wgpu::BindGroupEntry {
                    binding: 0,
                    resource: wgpu::BindingResource::TextureView(&shadow_view),
                },
                wgpu::BindGroupEntry {
                    binding: 1,
                    resource: wgpu::BindingResource::Sampler(&shadow_sampler),
                },
            ],
        });
        Self {
            pipelines,
            gpu: gpu.clone(),
            scene,
            scene_group,
            shadow_group,
            shadow_view,
            vertices: Upload::new(device, "vertices", wgpu::BufferUsages::VERTEX, FIRST_BYTES),
            indices: Upload::new(device, "indices", wgpu::BufferUsages::INDEX, FIRST_BYTES),
            targets: None,
            under_way: VecDeque::new(),
        }
    }
}

/// Runs `work` and turns what the driver complains about meanwhile into an error; wgpu would panic otherwise.
fn watched<T>(gpu: &Gpu, work: impl FnOnce() -> Result<T, RenderError>) -> Result<T, RenderError> {
    let memory = gpu
        .device()
        .push_error_scope(wgpu::ErrorFilter::OutOfMemory);
    let internal = gpu.device().push_error_scope(wgpu::ErrorFilter::Internal);
    let validation = gpu.device().push_error_scope(wgpu::ErrorFilter::Validation);
    let result = work();
    // Scopes are a stack; an error stands in the innermost scope of its kind.
    let complaints = [validation.pop(), internal.pop(), memory.pop()].map(pollster::block_on);
    alive(gpu)?;
    match complaints.into_iter().flatten().next() {
        Some(error) => Err(RenderError::Device {
            reason: error.to_string(),
        }),
        None => result,
    }
}

/// The loss of the device is no complaint of a scope.
fn alive(gpu: &Gpu) -> Result<(), RenderError> {
    match gpu.lost() {
        Some(reason) => Err(RenderError::Device {
            reason: reason.to_owned(),
        }),
        None => Ok(()),
    }
}

fn scene_of(picture: &Picture, field_pixels: f64) -> Scene {
    let View {
        field_diameter,
        working_distance,
        ..
    } = picture.view;
    let (width, height) = (f64::from(picture.width), f64::from(picture.height));
    let eye = 2.0 * working_distance / field_diameter;
    let towards = nalgebra::Vector3::from(key_light_direction());
    let across = nalgebra::Vector3::y().cross(&towards).normalize();
    let along = towards.cross(&across);
    let [far, near] = SHADOW_DEPTHS;
    let row = |axis: nalgebra::Vector3<f64>, scale: f64| {
        [axis.x, axis.y, axis.z, scale].map(|part| part as f32)
    };
    let texel = 2.0 * SHADOW_REACH / f64::from(SHADOW_SIDE);
    let background = picture
        .background
        .map(|part| linear_from_srgb(f64::from(part)));
    let single = |parts: [f64; 4]| parts.map(|part| part as f32);
    Scene {
        lens: single([
            2.0 * field_pixels / width,
            2.0 * field_pixels / height,
            eye,
            NEAR * eye,
        ]),
        light: [
            row(across, 1.0 / SHADOW_REACH),
            row(along, 1.0 / SHADOW_REACH),
            row(towards, 1.0 / (near - far)),
        ],
        lamps: single([AMBIENT, COAXIAL, key_strength(), far]),
        // The filter reaches two and a half texels; the lookup leaves the surface by as much.
        background: single([background[0], background[1], background[2], 2.5 * texel]),
        field: single([
            0.5 * width,
            0.5 * height,
            field_pixels,
            1.0 / f64::from(SHADOW_SIDE),
        ]),
    }
}

fn depth_attachment(
    view: &wgpu::TextureView,
    store: wgpu::StoreOp,
) -> wgpu::RenderPassDepthStencilAttachment<'_> {
    wgpu::RenderPassDepthStencilAttachment {
        view,
        depth_ops: Some(wgpu::Operations {
            load: wgpu::LoadOp::Clear(1.0),
            store,
        }),
        stencil_ops: None,
    }
}
