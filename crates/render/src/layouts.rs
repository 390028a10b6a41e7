//! Layouts of what shaders read: textures, samplers and numbers by group and place.

/// Layouts of what shaders read. Group 0 is the scene in all of them.
pub(crate) struct Layouts {
    pub scene: wgpu::BindGroupLayout,
    /// Shadow map, openness, samplers.
    pub light: wgpu::BindGroupLayout,
    /// Depth of the half size.
    pub depth: wgpu::BindGroupLayout,
    /// Openness before it is smoothed.
    pub raw: wgpu::BindGroupLayout,
    /// Base colour of a model.
    pub texture: wgpu::BindGroupLayout,
    /// Pictures of the eyes, and depth.
    pub post: wgpu::BindGroupLayout,
}

impl Layouts {
    pub fn new(device: &wgpu::Device) -> Self {
        let fragment = wgpu::ShaderStages::FRAGMENT;
        let layout = |label, entries: &[(u32, wgpu::ShaderStages, wgpu::BindingType)]| {
            let entries: Vec<wgpu::BindGroupLayoutEntry> = entries
                .iter()
                .map(|&(binding, visibility, ty)| wgpu::BindGroupLayoutEntry {
                    binding,
                    visibility,
                    ty,
                    count: None,
                })
                .collect();
            device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: Some(label),
                entries: &entries,
            })
        };
        let texture = |sample_type| wgpu::BindingType::Texture {
            sample_type,
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        };
        let depth = texture(wgpu::TextureSampleType::Depth);
        let colour = texture(wgpu::TextureSampleType::Float { filterable: true });
        let sampler = wgpu::BindingType::Sampler;
        let compare = sampler(wgpu::SamplerBindingType::Comparison);
        let filter = sampler(wgpu::SamplerBindingType::Filtering);
        let uniform = wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Uniform,
            has_dynamic_offset: false,
            min_binding_size: None,
        };
        Self {
            scene: layout(
                "scene",
                &[(0, wgpu::ShaderStages::VERTEX_FRAGMENT, uniform)],
            ),
            light: layout(
                "light",
                &[
                    (0, fragment, depth),
                    (1, fragment, compare),
                    (2, fragment, colour),
                    (3, fragment, filter),
                ],
            ),
            depth: layout("depth", &[(0, fragment, depth)]),
            raw: layout("raw", &[(1, fragment, colour), (2, fragment, filter)]),
            texture: layout("texture", &[(0, fragment, colour), (1, fragment, filter)]),
            post: layout(
                "post",
                &[
                    (0, fragment, colour),
                    (1, fragment, colour),
                    (2, fragment, depth),
                    (3, fragment, filter),
                ],
            ),
        }
    }
}
