//! The pipelines: which shader, which vertices, which tests make one kind of pass.

use crate::batch::Instance;
use crate::family::Family;
use crate::layouts::Layouts;
use crate::mesh::{Detail, Vertex};
use crate::quality::Quality;
use crate::targets::{COLOUR, DEPTH, OPENNESS};

/// All pipelines of one quality.
pub(crate) struct Pipelines {
    pub shadow: wgpu::RenderPipeline,
    pub depth: wgpu::RenderPipeline,
    pub openness: wgpu::RenderPipeline,
    pub smooth: wgpu::RenderPipeline,
    pub background: wgpu::RenderPipeline,
    pub focus: wgpu::RenderPipeline,
    /// By family, by whether it is solid, by whether it is closed.
    surface: Vec<[[wgpu::RenderPipeline; 2]; 2]>,
    /// By the layout's number less one.
    pub compose: Vec<wgpu::RenderPipeline>,
}

impl Pipelines {
    pub fn new(device: &wgpu::Device, layouts: &Layouts, quality: Quality) -> Self {
        let module = |source: &'static str, label| {
            let source = format!("{}\n{source}", include_str!("scene.wgsl"));
            device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some(label),
                source: wgpu::ShaderSource::Wgsl(source.into()),
            })
        };
        let surfaces = module(include_str!("surface.wgsl"), "surface");
        let openness = module(include_str!("openness.wgsl"), "openness");
        let post = module(include_str!("post.wgsl"), "post");
        let maker = Maker {
            device,
            layouts,
            quality,
        };
        Self {
            shadow: maker.shadow(&surfaces),
            depth: maker.depth(&surfaces),
            openness: maker.whole(
                &openness,
                "openness_fragment",
                &layouts.depth,
                OPENNESS,
                &[],
            ),
            smooth: maker.whole(&openness, "smooth_fragment", &layouts.raw, OPENNESS, &[]),
            background: maker.background(&surfaces),
            focus: maker.whole(&post, "focus_fragment", &layouts.post, COLOUR, &[]),
            surface: Family::ALL
                .map(|family| {
                    [false, true].map(|solid| {
                        [false, true].map(|closed| maker.surface(&surfaces, family, solid, closed))
                    })
                })
                .into(),
            compose: (1..=4)
                .map(|number| {
                    let constants = [("LAYOUT", f64::from(number))];
                    maker.whole(&post, "compose_fragment", &layouts.post, COLOUR, &constants)
                })
                .collect(),
        }
    }

    /// That of a family; a solid one hides what is behind it, of a closed one no inner side is ever seen.
    pub fn surface(&self, family: Family, solid: bool, closed: bool) -> &wgpu::RenderPipeline {
        &self.surface[family as usize][usize::from(solid)][usize::from(closed)]
    }
}

/// What all pipelines are made from.
struct Maker<'a> {
    device: &'a wgpu::Device,
    layouts: &'a Layouts,
    quality: Quality,
}

impl Maker<'_> {
    /// Depth of the solid surfaces as the key light sees them.
    fn shadow(&self, module: &wgpu::ShaderModule) -> wgpu::RenderPipeline {
        self.pipeline(&Stages {
            label: "shadow",
            depth: Some(wgpu::DepthStencilState {
                // Holds a slope from shadowing itself: two texels' worth of its own depth.
                bias: wgpu::DepthBiasState {
                    constant: 0,
                    slope_scale: 2.0,
                    clamp: 0.0,
                },
                ..depth_state(true, wgpu::CompareFunction::Less)
            }),
            ..Stages::new(module, &[Some(&self.layouts.scene)], "shadow_vertex")
        })
    }

    /// Depth of the solid surfaces as the eye sees them.
    fn depth(&self, module: &wgpu::ShaderModule) -> wgpu::RenderPipeline {
        self.pipeline(&Stages {
            label: "depth",
            depth: Some(depth_state(true, wgpu::CompareFunction::Less)),
            ..Stages::new(module, &[Some(&self.layouts.scene)], "depth_vertex")
        })
    }

    fn background(&self, module: &wgpu::ShaderModule) -> wgpu::RenderPipeline {
        self.pipeline(&Stages {
            label: "background",
            has_vertices: false,
            depth: Some(depth_state(true, wgpu::CompareFunction::Always)),
            samples: self.quality.samples(),
            fragment: Some(("background_fragment", COLOUR, None)),
            ..Stages::new(module, &[Some(&self.layouts.scene)], "background_vertex")
        })
    }

    /// A pass over all pixels.
    fn whole(
        &self,
        module: &wgpu::ShaderModule,
        fragment: &str,
        group: &wgpu::BindGroupLayout,
        format: wgpu::TextureFormat,
        constants: &[(&str, f64)],
    ) -> wgpu::RenderPipeline {
        self.pipeline(&Stages {
            label: fragment,
            has_vertices: false,
            fragment: Some((fragment, format, None)),
            constants,
            ..Stages::new(
                module,
                &[Some(&self.layouts.scene), Some(group)],
                "whole_vertex",
            )
        })
    }

    /// Lit surfaces. A closed one is spared its inner side, of an open one both sides are seen; a translucent one hides nothing.
    fn surface(
        &self,
        module: &wgpu::ShaderModule,
        family: Family,
        solid: bool,
        closed: bool,
    ) -> wgpu::RenderPipeline {
        self.pipeline(&Stages {
            label: "surface",
            cull: closed.then_some(wgpu::Face::Back),
            depth: Some(depth_state(solid, wgpu::CompareFunction::Less)),
            samples: self.quality.samples(),
            fragment: Some((
                "surface_fragment",
                COLOUR,
                (!solid).then_some(wgpu::BlendState::ALPHA_BLENDING),
            )),
            constants: &[("FAMILY", f64::from(family as u8))],
            ..Stages::new(
                module,
                &[Some(&self.layouts.scene), Some(&self.layouts.light)],
                "surface_vertex",
            )
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
        let mut constants = vec![("QUALITY", self.quality.number())];
        constants.extend_from_slice(stages.constants);
        let options = || wgpu::PipelineCompilationOptions {
            constants: &constants,
            ..Default::default()
        };
        let target = stages.fragment.map(|(_, format, blend)| {
            [Some(wgpu::ColorTargetState {
                format,
                blend,
                write_mask: wgpu::ColorWrites::ALL,
            })]
        });
        let vertex = wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3];
        let detail = wgpu::vertex_attr_array![2 => Float32x3, 3 => Float32];
        let instance = wgpu::vertex_attr_array![
            4 => Float32x4, 5 => Float32x4, 6 => Float32x4, 7 => Float32x4, 8 => Float32x4
        ];
        let buffer = |stride: usize, step_mode, attributes| {
            Some(wgpu::VertexBufferLayout {
                array_stride: stride as u64,
                step_mode,
                attributes,
            })
        };
        let buffers = [
            buffer(
                size_of::<Vertex>(),
                wgpu::VertexStepMode::Vertex,
                vertex.as_slice(),
            ),
            buffer(
                size_of::<Detail>(),
                wgpu::VertexStepMode::Vertex,
                detail.as_slice(),
            ),
            buffer(
                size_of::<Instance>(),
                wgpu::VertexStepMode::Instance,
                instance.as_slice(),
            ),
        ];
        self.device
            .create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some(stages.label),
                layout: Some(&layout),
                vertex: wgpu::VertexState {
                    module: stages.module,
                    entry_point: Some(stages.vertex),
                    compilation_options: options(),
                    buffers: if stages.has_vertices { &buffers } else { &[] },
                },
                primitive: wgpu::PrimitiveState {
                    cull_mode: stages.cull,
                    ..Default::default()
                },
                depth_stencil: stages.depth.clone(),
                multisample: wgpu::MultisampleState {
                    count: stages.samples,
                    ..Default::default()
                },
                fragment: stages
                    .fragment
                    .zip(target.as_ref())
                    .map(|((entry, _, _), targets)| wgpu::FragmentState {
                        module: stages.module,
                        entry_point: Some(entry),
                        compilation_options: options(),
                        targets,
                    }),
                multiview_mask: None,
                cache: None,
            })
    }
}

/// What distinguishes one pipeline from another.
struct Stages<'a> {
    label: &'a str,
    module: &'a wgpu::ShaderModule,
    groups: &'a [Option<&'a wgpu::BindGroupLayout>],
    vertex: &'a str,
    has_vertices: bool,
    cull: Option<wgpu::Face>,
    depth: Option<wgpu::DepthStencilState>,
    samples: u32,
    /// Entry point, format and blending; none draws depth only.
    fragment: Option<(&'a str, wgpu::TextureFormat, Option<wgpu::BlendState>)>,
    /// Of the shader, besides the quality.
    constants: &'a [(&'a str, f64)],
}

impl<'a> Stages<'a> {
    fn new(
        module: &'a wgpu::ShaderModule,
        groups: &'a [Option<&'a wgpu::BindGroupLayout>],
        vertex: &'a str,
    ) -> Self {
        Self {
            label: vertex,
            module,
            groups,
            vertex,
            has_vertices: true,
            cull: None,
            depth: None,
            samples: 1,
            fragment: None,
            constants: &[],
        }
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
