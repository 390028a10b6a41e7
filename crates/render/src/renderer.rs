//! Drawing: pipelines made once per quality, textures and buffers that stay from picture to picture, a few passes per picture.

use microsim_gpu::Gpu;
use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::batch::{Draw, Instance, Source, family_of, mask_of, sort};
use crate::bodies::Bodies;
use crate::colour_map;
use crate::error::RenderError;
use crate::family::Family;
use crate::frame::{Frame, encode};
use crate::image::Image;
use crate::layouts::Layouts;
use crate::mesh::Mesh;
use crate::picture::{Pattern, Picture};
use crate::pipelines::Pipelines;
use crate::quality::Quality;
use crate::shape::Shape;
use crate::store::{Store, Triangles, loose};
use crate::targets::{DEPTH, Form, Maps, Targets, texture};
use crate::textures::Textures;
use crate::uniforms::{SHADOW_SIDE, Scene};
use crate::upload::Upload;

/// Pictures that may be unfinished at once: one is drawn while the next is being encoded.
const UNDER_WAY: usize = 2;
/// What the buffer of instances begins with \[bytes\].
const FIRST_BYTES: u64 = 1 << 14;

/// Draws pictures. Not shared between threads: each thread that draws has its own.
pub struct Renderer {
    gpu: Gpu,
    quality: Quality,
    /// Whether pictures of a quality that has depth of field have it.
    depth_of_field: bool,
    layouts: Layouts,
    /// By quality; made when it is first drawn.
    pipelines: [Option<Pipelines>; 3],
    /// One per eye.
    scenes: [(wgpu::Buffer, wgpu::BindGroup); 2],
    shadow: wgpu::TextureView,
    compare: wgpu::Sampler,
    filter: wgpu::Sampler,
    instances: Upload,
    store: Store,
    textures: Textures,
    bodies: Bodies,
    /// Meshes that pictures bring themselves, by their number in the picture.
    loose: Vec<Triangles>,
    draws: Vec<Draw>,
    targets: Option<Targets>,
    /// Pictures that were submitted and are not known to be finished, the oldest first.
    under_way: VecDeque<(wgpu::SubmissionIndex, Arc<AtomicBool>)>,
}

impl Renderer {
    /// Compiles the shaders on `gpu`, of low quality for a software driver, else of medium. Takes some hundred milliseconds with a software driver.
    ///
    /// # Errors
    /// [`RenderError::Device`] when the driver refuses.
    pub fn new(gpu: &Gpu) -> Result<Self, RenderError> {
        let quality = match gpu.is_software() {
            true => Quality::Low,
            false => Quality::Medium,
        };
        Self::of_quality(gpu, quality)
    }

    /// The same for pictures of a quality.
    ///
    /// # Errors
    /// [`RenderError::Device`] when the driver refuses.
    pub fn of_quality(gpu: &Gpu, quality: Quality) -> Result<Self, RenderError> {
        watched(gpu, || Ok(Self::build(gpu, quality)))
    }

    /// How much is done for a picture.
    pub fn quality(&self) -> Quality {
        self.quality
    }

    /// Changes it from the next picture on. The shaders of a quality are compiled for its first picture.
    pub fn set_quality(&mut self, quality: Quality) {
        self.quality = quality;
    }

    /// Whether what is out of focus is blurred, from the next picture on, in qualities that do so: the highest.
    pub fn set_depth_of_field(&mut self, is_on: bool) {
        self.depth_of_field = is_on;
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
        self.targets.as_ref().map(|targets| &targets.picture)
    }

    /// Gives up what the last picture was drawn into and what its tissue took; the next picture makes both again. For a time in which nothing is drawn.
    /// The driver frees them once it has drawn what uses them.
    pub fn release(&mut self) {
        self.targets = None;
        self.bodies = Bodies::default();
        self.loose.clear();
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

    /// Waits until the last picture is drawn.
    ///
    /// # Errors
    /// The loss of the device.
    pub fn finish(&mut self) -> Result<(), RenderError> {
        let last = self.under_way.pop_back().map(|(index, _)| index);
        self.under_way.clear();
        match last {
            Some(index) => self.wait(Some(index)),
            None => Ok(()),
        }
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
        for (index, tissue) in picture.tissues.iter().enumerate() {
            if let Some(reason) = tissue.fault() {
                return Err(RenderError::Tissue { index, reason });
            }
        }
        Ok(())
    }

    fn submit(&mut self, picture: &Picture) {
        let size = picture.stereo.eye_size((picture.width, picture.height));
        self.list(picture, size);
        let (device, queue) = (self.gpu.device(), self.gpu.queue());
        let instances: Vec<Instance> = self.draws.iter().map(|draw| draw.instance).collect();
        self.instances.write(device, queue, &instances);
        for (beside, (buffer, _)) in picture.stereo.eyes().iter().zip(&self.scenes) {
            let scene = Scene::new(picture, size, beside * picture.stereo.base);
            queue.write_buffer(buffer, 0, bytemuck::bytes_of(&scene));
        }
        let form = Form {
            width: picture.width,
            height: picture.height,
            quality: self.quality,
            has_focus: self.quality.has_focus() && self.depth_of_field,
            layout: picture.stereo.layout,
        };
        // Those of another form go first, so that the driver can free them before new ones come.
        let targets = self.targets.take().filter(|targets| targets.form == form);
        let targets = targets.unwrap_or_else(|| Targets::new(device, form, &self.maps()));
        let mirrored = picture.mirrored;
        let pipelines = &mut self.pipelines[self.quality as usize];
        // A trainee's hand does not change from picture to picture.
        pipelines.take_if(|of| of.mirrored != mirrored);
        let pipelines = pipelines
            .get_or_insert_with(|| Pipelines::new(device, &self.layouts, self.quality, mirrored));
        if self.draws.iter().any(|draw| draw.texture.is_some()) {
            pipelines.prepare_textured(device, &self.layouts, self.quality);
        }
        if self.draws.iter().any(|draw| draw.is_masked) {
            pipelines.prepare_masked(device, &self.layouts, self.quality);
        }
        let frame = Frame {
            draws: &self.draws,
            instances: self.instances.buffer(),
            pipelines,
            targets: &targets,
            textures: &self.textures,
            shadow: &self.shadow,
            quality: self.quality,
            layout: picture.stereo,
        };
        let triangles = |source| match source {
            Source::Shape(place) => self.store.at(place),
            Source::Body(number) => self.bodies.of(picture.tissues[number].body),
            Source::Loose(number) => self.loose.get(number),
        };
        let groups: Vec<&wgpu::BindGroup> = self.scenes.iter().map(|(_, group)| group).collect();
        let mut encoder = device.create_command_encoder(&Default::default());
        encode(&mut encoder, &frame, &groups, &triangles);
        let index = queue.submit([encoder.finish()]);
        let done = Arc::new(AtomicBool::new(false));
        let finished = done.clone();
        queue.on_submitted_work_done(move || finished.store(true, Ordering::Release));
        self.under_way.push_back((index, done));
        self.targets = Some(targets);
    }

    /// Makes the list of what is drawn, and brings to the device what is not there.
    fn list(&mut self, picture: &Picture, (width, height): (u32, u32)) {
        let (device, queue) = (self.gpu.device(), self.gpu.queue());
        let view = &picture.view;
        let pixels = f64::from(width.min(height)) / view.field_diameter;
        self.store.begin();
        self.textures.begin();
        self.bodies
            .update(device, queue, &picture.tissues, self.quality.steps());
        self.draws.clear();
        let mut meshes = 0;
        let mut mesh = Mesh::default();
        for item in picture.items.iter().filter(|item| item.opacity > 0.0) {
            let (source, item) = match self.store.place(device, queue, item, pixels) {
                Some((place, item)) => (Source::Shape(place), item),
                None => {
                    if self.loose.len() == meshes {
                        self.loose.push(Triangles::new(device));
                    }
                    loose(&item.shape, &mut mesh);
                    self.loose[meshes].write(device, queue, &mesh);
                    meshes += 1;
                    (Source::Loose(meshes - 1), item.clone())
                }
            };
            let (closed, texture) = match &item.shape {
                Shape::Mesh { .. } => (false, None),
                Shape::Field { .. } => (false, Some(colour_map::texture())),
                Shape::Model(model) => (model.is_closed(), model.texture()),
                _ => (true, None),
            };
            if let Some(texture) = texture {
                let layout = &self.layouts.texture;
                self.textures.place(device, queue, layout, texture);
            }
            self.draws.push(Draw {
                source,
                family: family_of(item.finish),
                solid: item.opacity >= 1.0,
                casts: item.opacity >= 1.0 && item.pattern == Pattern::Plain,
                closed,
                texture: texture.map(|texture| texture.id()),
                is_masked: mask_of(&item).is_some(),
                instance: Instance::of_item(&item, view),
            });
        }
        let tissues = picture.tissues.iter().enumerate();
        self.draws.extend(tissues.map(|(number, tissue)| Draw {
            source: Source::Body(number),
            family: Family::Tissue,
            solid: true,
            casts: true,
            closed: true,
            texture: None,
            is_masked: false,
            instance: Instance::of_field(tissue.colour, view),
        }));
        sort(&mut self.draws);
    }

    fn maps(&self) -> Maps<'_> {
        Maps {
            layouts: &self.layouts,
            shadow: &self.shadow,
            compare: &self.compare,
            filter: &self.filter,
        }
    }

    fn build(gpu: &Gpu, quality: Quality) -> Self {
        let device = gpu.device();
        let layouts = Layouts::new(device);
        let scenes = [0, 1].map(|_| {
            let buffer = device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("scene"),
                size: size_of::<Scene>() as u64,
                usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            });
            let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("scene"),
                layout: &layouts.scene,
                entries: &[wgpu::BindGroupEntry {
                    binding: 0,
                    resource: buffer.as_entire_binding(),
                }],
            });
            (buffer, group)
        });
        let sampler = |compare| {
            device.create_sampler(&wgpu::SamplerDescriptor {
                mag_filter: wgpu::FilterMode::Linear,
                min_filter: wgpu::FilterMode::Linear,
                compare,
                ..Default::default()
            })
        };
        let usage = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING;
        let mut pipelines = [None, None, None];
        pipelines[quality as usize] = Some(Pipelines::new(device, &layouts, quality, false));
        Self {
            gpu: gpu.clone(),
            quality,
            depth_of_field: true,
            pipelines,
            layouts,
            scenes,
            shadow: texture(device, (SHADOW_SIDE, SHADOW_SIDE), 1, DEPTH, usage)
                .create_view(&Default::default()),
            compare: sampler(Some(wgpu::CompareFunction::LessEqual)),
            filter: sampler(None),
            instances: Upload::new(device, "instances", wgpu::BufferUsages::VERTEX, FIRST_BYTES),
            store: Store::default(),
            textures: Textures::new(),
            bodies: Bodies::default(),
            loose: Vec::new(),
            draws: Vec::new(),
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
