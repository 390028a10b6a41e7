//! The pipelines: which shader, which vertices, which tests make one kind of pass.

use crate::surface::Vertex;
use crate::targets::{COLOUR, DEPTH, SAMPLES};

/// All pipelines and the layouts of what the shader reads. Layouts: group 0 the scene, group 1 the shadow map.
pub(crate) struct Pipelines {
    pub scene_layout: wgpu::BindGroupLayout,
    pub shadow_layout: wgpu::BindGroupLayout,
    pub shadow: wgpu::RenderPipeline,
    pub background: wgpu::RenderPipeline,
    /// By `Layer::solid`, then by `Layer::closed`.
    pub surface: [[wgpu::RenderPipeline; 2]; 2],
}

impl Pipelines {
    pub fn new(device: &wgpu::Device) -> Self {
        let shader = device.create_shader_module(wgpu::include_wgsl!("shader.wgsl"));
        let scene_layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("scene"),
            entries: &[layout_entry(
                0,
                wgpu::ShaderStages::VERTEX_FRAGMENT,
                wgpu::BindingType::Buffer {
                    ty: wgpu::BufferBindingType::Uniform,
                    has_dynamic_offset: false,
                    min_binding_size: None,
                },
            )],
        });
        let shadow_layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("shadow"),
            entries: &[
                layout_entry(
                    0,
                    wgpu::ShaderStages::FRAGMENT,
                    wgpu::BindingType::Texture {
                        sample_type: wgpu::TextureSampleType::Depth,
                        view_dimension: wgpu::TextureViewDimension::D2,
                        multisampled: false,
                    },
                ),
                layout_entry(
                    1,
                    wgpu::ShaderStages::FRAGMENT,
                    wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Comparison),
                ),
            ],
        });
        let maker = Maker {
            device,
            shader: &shader,
            scene_layout: &scene_layout,
            shadow_layout: &shadow_layout,
        };
        Self {
            shadow: maker.shadow(),
            background: maker.background(),
            surface: [false, true]
                .map(|solid| [false, true].map(|closed| maker.surface(solid, closed))),
            scene_layout,
            shadow_layout,
        }
    }
}

/// What all pipelines are made from.
struct Maker<'a> {
    device: &'a wgpu::Device,
    shader: &'a wgpu::ShaderModule,
    scene_layout: &'a wgpu::BindGroupLayout,
    shadow_layout: &'a wgpu::BindGroupLayout,
}

impl Maker<'_> {
    /// Depth of the solid surfaces as the key light sees them.
    fn shadow(&self) -> wgpu::RenderPipeline {
        let attributes = wgpu::vertex_attr_array![0 => Float32x3];
        self.pipeline(&Stages {
            label: "shadow",
            groups: &[Some(self.scene_layout)],
            vertex: "shadow_vertex",
            buffers: &[Some(vertex_layout(&attributes))],
            cull: None,
            depth: wgpu::DepthStencilState {
                // Keeps a slope from shadowing itself: two texels' worth of its own depth.
                bias: wgpu::DepthBiasState {
                    constant: 0,
                    slope_scale: 2.0,
                    clamp: 0.0,
                },
                ..depth_state(true, wgpu::CompareFunction::Less)
            },
            samples: 1,
            fragment: None,
        })
    }

    fn background(&self) -> wgpu::RenderPipeline {
        self.pipeline(&Stages {
            label: "background",
            groups: &[Some(self.scene_layout)],
            vertex: "background_vertex",
            buffers: &[],
            cull: None,
            depth: depth_state(true, wgpu::CompareFunction::Always),
            samples: SAMPLES,
            fragment: Some(("background_fragment", None)),
        })
    }

    /// Lit surfaces. A closed one is spared its inner side, of an open one both sides are seen; a translucent one hides nothing.
    fn surface(&self, solid: bool, closed: bool) -> wgpu::RenderPipeline {
        let attributes =
            wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3, 2 => Float32x4, 3 => Float32];
        self.pipeline(&Stages {
            label: "surface",
            groups: &[Some(self.scene_layout), Some(self.shadow_layout)],
            vertex: "surface_vertex",
            buffers: &[Some(vertex_layout(&attributes))],
            cull: closed.then_some(wgpu::Face::Back),
            depth: depth_state(solid, wgpu::CompareFunction::Less),
            samples: SAMPLES,
            fragment: Some((
                "surface_fragment",
                (!solid).then_some(wgpu::BlendState::ALPHA_BLENDING),
            )),
        })
    }

    fn pipeline(&self, stages: &Stages<'_>) -> wgpu::RenderPipeline {
        let layout = self
            .device
            .create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some(stages.label),
                bind_group_layouts: stages.groups,
                ..Default::default()
            });
        let blend = stages.fragment.and_then(|(_, blend)| blend);
        let colour = [Some(wgpu::ColorTargetState {
            format: COLOUR,
            blend,
            write_mask: wgpu::ColorWrites::ALL,
        })];
        self.device
            .create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some(stages.label),
                layout: Some(&layout),
                vertex: wgpu::VertexState {
                    module: self.shader,
                    entry_point: Some(stages.vertex),
                    compilation_options: Default::default(),
                    buffers: stages.buffers,
                },
                primitive: wgpu::PrimitiveState {
                    cull_mode: stages.cull,
                    ..Default::default()
                },
                depth_stencil: Some(stages.depth.clone()),
                multisample: wgpu::MultisampleState {
                    count: stages.samples,
                    ..Default::default()
                },
                fragment: stages.fragment.map(|(entry, _)| wgpu::FragmentState {
                    module: self.shader,
                    entry_point: Some(entry),
                    compilation_options: Default::default(),
                    targets: &colour,
                }),
                multiview_mask: None,
                cache: None,
            })
    }
}

/// What distinguishes one pipeline from another.
struct Stages<'a> {
    label: &'a str,
    groups: &'a [Option<&'a wgpu::BindGroupLayout>],
    vertex: &'a str,
    buffers: &'a [Option<wgpu::VertexBufferLayout<'a>>],
    cull: Option<wgpu::Face>,
    depth: wgpu::DepthStencilState,
    samples: u32,
    /// Entry point and blending; none draws depth only.
    fragment: Option<(&'a str, Option<wgpu::BlendState>)>,
}

fn layout_entry(
    binding: u32,
    visibility: wgpu::ShaderStages,
    ty: wgpu::BindingType,
) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility,
        ty,
        count: None,
    }
}

fn vertex_layout(attributes: &[wgpu::VertexAttribute]) -> wgpu::VertexBufferLayout<'_> {
    wgpu::VertexBufferLayout {
        array_stride: size_of::<Vertex>() as u64,
        step_mode: wgpu::VertexStepMode::Vertex,
        attributes,
    }
}

fn depth_state(write: bool, compare: wgpu::CompareFunction) -> wgpu::DepthStencilState {
    wgpu::DepthStencilState {
        format: DEPTH,
        depth_write_enabled: Some(write),
        depth_compare: Some(compare),
        stencil: Default::default(),
        bias: Default::default(),
    }
}
