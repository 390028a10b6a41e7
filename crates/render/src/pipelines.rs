//! The pipelines: which shader, which vertices, which tests make one kind of pass.

use crate::batch::Instance;
use crate::family::Family;
use crate::layouts::Layouts;
use crate::mesh::{Detail, Vertex};
use crate::quality::Quality;
use crate::targets::{COLOUR, DEPTH, OPENNESS};

/// Pipelines of surfaces that are not there where their texture is translucent.
struct Masked {
    depth: CutDepth,
    /// By family, by whether it is solid.
    surface: Vec<[wgpu::RenderPipeline; 2]>,
}

/// Depth of such surfaces.
pub(crate) struct CutDepth {
    pub shadow: wgpu::RenderPipeline,
    pub depth: wgpu::RenderPipeline,
}

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
    /// The same with a texture, of which both sides are seen; none before the first one is drawn.
    textured: Vec<[wgpu::RenderPipeline; 2]>,
    /// The same of surfaces that their texture cuts out; none before the first one is drawn.
    masked: Option<Masked>,
    /// By the layout's number less one.
    pub compose: Vec<wgpu::RenderPipeline>,
    /// Whether they are those of mirrored pictures, in which the corners of outer sides run clockwise.
    pub mirrored: bool,
}

impl Pipelines {
    pub fn new(device: &wgpu::Device, layouts: &Layouts, quality: Quality, mirrored: bool) -> Self {
        let module = |source, label| module(device, source, label);
        let surfaces = module(include_str!("surface.wgsl"), "surface");
        let openness = module(include_str!("openness.wgsl"), "openness");
        let post = module(include_str!("post.wgsl"), "post");
        let maker = Maker {
            device,
            layouts,
            quality,
            mirrored,
        };
        Self {
            shadow: maker.shadow(&surfaces, false),
            depth: maker.depth(&surfaces, false),
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
                        [false, true].map(|closed| {
                            maker.surface(&surfaces, family, solid, closed, "surface_fragment")
                        })
                    })
                })
                .into(),
            textured: Vec::new(),
            masked: None,
            compose: (1..=4)
                .map(|number| {
                    let constants = [("LAYOUT", f64::from(number))];
                    maker.whole(&post, "compose_fragment", &layouts.post, COLOUR, &constants)
                })
                .collect(),
            mirrored,
        }
    }

    /// That of a family; a solid one hides what is behind it, of a closed one no inner side is ever seen.
    pub fn surface(&self, family: Family, solid: bool, closed: bool) -> &wgpu::RenderPipeline {
        &self.surface[family as usize][usize::from(solid)][usize::from(closed)]
    }

    /// That of a family with a texture.
    pub fn textured(&self, family: Family, solid: bool) -> Option<&wgpu::RenderPipeline> {
        let of_family = self.textured.get(family as usize)?;
        Some(&of_family[usize::from(solid)])
    }

    /// Makes those with textures if there are none yet.
    pub fn prepare_textured(&mut self, device: &wgpu::Device, layouts: &Layouts, quality: Quality) {
        if !self.textured.is_empty() {
            return;
        }
        let surfaces = module(device, include_str!("surface.wgsl"), "textured surface");
        let maker = Maker {
            device,
            layouts,
            quality,
            mirrored: self.mirrored,
        };
        self.textured = maker.textured(&surfaces, "textured_fragment");
    }

    /// That of a family whose texture cuts it out.
    pub fn masked(&self, family: Family, solid: bool) -> Option<&wgpu::RenderPipeline> {
        let of_family = self.masked.as_ref()?.surface.get(family as usize)?;
        Some(&of_family[usize::from(solid)])
    }

    /// Those of the depth of surfaces that are cut out.
    pub fn cut_depth(&self) -> Option<&CutDepth> {
        self.masked.as_ref().map(|masked| &masked.depth)
    }

    /// Makes those of surfaces that are cut out if there are none yet.
    pub fn prepare_masked(&mut self, device: &wgpu::Device, layouts: &Layouts, quality: Quality) {
        if self.masked.is_some() {
            return;
        }
        let surfaces = module(
            device,
            include_str!("surface.wgsl"),
            "surface that is cut out",
        );
        let maker = Maker {
            device,
            layouts,
            quality,
            mirrored: self.mirrored,
        };
        self.masked = Some(Masked {
            depth: CutDepth {
                shadow: maker.shadow(&surfaces, true),
                depth: maker.depth(&surfaces, true),
            },
            surface: maker.textured(&surfaces, "masked_fragment"),
        });
    }
}

/// A shader after what all shaders have.
fn module(device: &wgpu::Device, source: &str, label: &str) -> wgpu::ShaderModule {
    let source = format!("{}\n{source}", include_str!("scene.wgsl"));
    device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some(label),
        source: wgpu::ShaderSource::Wgsl(source.into()),
    })
}

/// What all pipelines are made from.
struct Maker<'a> {
    device: &'a wgpu::Device,
    layouts: &'a Layouts,
    quality: Quality,
    mirrored: bool,
}

impl Maker<'_> {
    /// Surfaces with textures, by family and by whether they are solid.
    fn textured(
        &self,
        module: &wgpu::ShaderModule,
        fragment: &str,
    ) -> Vec<[wgpu::RenderPipeline; 2]> {
        let of = |family, solid| self.surface(module, family, solid, false, fragment);
        let families = Family::ALL.iter();
        families
            .map(|family| [false, true].map(|solid| of(*family, solid)))
            .collect()
    }

    /// What passes over depth alone read: the scene, and textures that cut surfaces out.
    fn of_depth(&self) -> [Option<&wgpu::BindGroupLayout>; 3] {
        [Some(&self.layouts.scene), None, Some(&self.layouts.texture)]
    }

    /// Depth of the solid surfaces as the key light sees them; `cut`: of those that their texture cuts out.
    fn shadow(&self, module: &wgpu::ShaderModule, cut: bool) -> wgpu::RenderPipeline {
        let groups = self.of_depth();
        let (groups, vertex) = match cut {
            true => (&groups[..], "cut_shadow_vertex"),
            false => (&groups[..1], "shadow_vertex"),
        };
        self.pipeline(&Stages {
            label: "shadow",
            discards: cut.then_some("cut_fragment"),
            depth: Some(wgpu::DepthStencilState {
                // Holds a slope from shadowing itself: two texels' worth of its own depth.
                bias: wgpu::DepthBiasState {
                    constant: 0,
                    slope_scale: 2.0,
                    clamp: 0.0,
                },
                ..depth_state(true, wgpu::CompareFunction::Less)
            }),
            ..Stages::new(module, groups, vertex)
        })
    }

    /// Depth of the solid surfaces as the eye sees them.
    fn depth(&self, module: &wgpu::ShaderModule, cut: bool) -> wgpu::RenderPipeline {
        let groups = self.of_depth();
        let (groups, vertex) = match cut {
            true => (&groups[..], "cut_depth_vertex"),
            false => (&groups[..1], "depth_vertex"),
        };
        self.pipeline(&Stages {
            label: "depth",
            discards: cut.then_some("cut_fragment"),
            depth: Some(depth_state(true, wgpu::CompareFunction::Less)),
            ..Stages::new(module, groups, vertex)
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
        fragment: &str,
    ) -> wgpu::RenderPipeline {
        let layouts = self.layouts;
        let groups = [
            Some(&layouts.scene),
            Some(&layouts.light),
            Some(&layouts.texture),
        ];
        let groups = match fragment {
            "surface_fragment" => &groups[..2],
            _ => &groups[..],
        };
        self.pipeline(&Stages {
            label: "surface",
            cull: closed.then_some(wgpu::Face::Back),
            depth: Some(depth_state(solid, wgpu::CompareFunction::Less)),
            samples: self.quality.samples(),
            fragment: Some((
                fragment,
                COLOUR,
                (!solid).then_some(wgpu::BlendState::ALPHA_BLENDING),
            )),
            constants: &[("FAMILY", f64::from(family as u8))],
            ..Stages::new(module, groups, "surface_vertex")
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
        let entry = stages.fragment.map(|(entry, ..)| entry).or(stages.discards);
        let vertex = wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3];
        let detail = wgpu::vertex_attr_array![2 => Float32x3, 3 => Float32, 9 => Float32x2];
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
                    front_face: match self.mirrored {
                        false => wgpu::FrontFace::Ccw,
                        true => wgpu::FrontFace::Cw,
                    },
                    cull_mode: stages.cull,
                    ..Default::default()
                },
                depth_stencil: stages.depth.clone(),
                multisample: wgpu::MultisampleState {
                    count: stages.samples,
                    ..Default::default()
                },
                fragment: entry.map(|entry| wgpu::FragmentState {
                    module: stages.module,
                    entry_point: Some(entry),
                    compilation_options: options(),
                    targets: target.as_ref().map_or(&[][..], |target| &target[..]),
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
    /// Entry point that discards what is not there, where depth only is drawn.
    discards: Option<&'a str>,
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
            discards: None,
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
