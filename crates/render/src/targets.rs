//! The textures that are drawn into, and reading the pixels back to memory.

use crate::error::RenderError;
use crate::image::Image;
use crate::layouts::Layouts;
use crate::quality::Quality;
use crate::stereo::{Stereo, StereoLayout};

pub(crate) const COLOUR: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8UnormSrgb;
pub(crate) const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;
pub(crate) const OPENNESS: wgpu::TextureFormat = wgpu::TextureFormat::R8Unorm;

/// What textures depend on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Form {
    pub width: u32,
    pub height: u32,
    pub quality: Quality,
    /// Whether what is out of focus is blurred.
    pub has_focus: bool,
    pub layout: StereoLayout,
}

/// Where one eye's picture is drawn.
pub(crate) struct Eye {
    /// Where surfaces are drawn, and what it is resolved to.
    pub samples: wgpu::TextureView,
    pub resolved: Option<wgpu::TextureView>,
    pub depth: wgpu::TextureView,
    pub half_depth: wgpu::TextureView,
    pub raw: wgpu::TextureView,
    pub open: wgpu::TextureView,
    /// Where depth of field puts the picture.
    pub focused: Option<wgpu::TextureView>,
    /// The square around the round field: left, top, side \[pixels\].
    pub square: [u32; 3],
    pub light_group: wgpu::BindGroup,
    pub depth_group: wgpu::BindGroup,
    pub raw_group: wgpu::BindGroup,
    pub focus_group: wgpu::BindGroup,
}

/// Textures of one form of pictures, and the buffer through which the pixels come back.
pub(crate) struct Targets {
    pub form: Form,
    pub eyes: Vec<Eye>,
    pub compose_group: Option<wgpu::BindGroup>,
    pub picture: wgpu::Texture,
    pub view: wgpu::TextureView,
    readback: wgpu::Buffer,
    /// Bytes from one row to the next in `readback`.
    row_bytes: u32,
}

/// What the passes read besides.
pub(crate) struct Maps<'a> {
    pub layouts: &'a Layouts,
    pub shadow: &'a wgpu::TextureView,
    pub compare: &'a wgpu::Sampler,
    pub filter: &'a wgpu::Sampler,
}

impl Targets {
    pub fn new(device: &wgpu::Device, form: Form, maps: &Maps<'_>) -> Self {
        let Form { width, height, .. } = form;
        let align = wgpu::COPY_BYTES_PER_ROW_ALIGNMENT;
        let row_bytes = (4 * width).div_ceil(align) * align;
        let picture = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("picture"),
            view_formats: &[COLOUR.remove_srgb_suffix()],
            ..description(
                (width, height),
                1,
                COLOUR,
                wgpu::TextureUsages::RENDER_ATTACHMENT
                    | wgpu::TextureUsages::COPY_SRC
                    | wgpu::TextureUsages::TEXTURE_BINDING,
            )
        });
        let view = picture.create_view(&Default::default());
        let stereo = Stereo {
            layout: form.layout,
            ..Stereo::default()
        };
        let size = stereo.eye_size((width, height));
        let outputs: Vec<wgpu::TextureView> = match form.layout {
            StereoLayout::Mono => vec![view.clone()],
            _ => (0..2).map(|_| drawn(device, size, 1)).collect(),
        };
        let eyes: Vec<Eye> = outputs
            .iter()
            .map(|output| Eye::new(device, size, (form.quality, form.has_focus), output, maps))
            .collect();
        let compose_group = match (outputs.as_slice(), eyes.as_slice()) {
            ([left, right], [eye, _]) => {
                Some(post_group(device, [left, right], &eye.half_depth, maps))
            }
            _ => None,
        };
        Self {
            form,
            eyes,
            compose_group,
            picture,
            view,
            readback: device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("readback"),
                size: u64::from(row_bytes) * u64::from(height),
                usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
                mapped_at_creation: false,
            }),
            row_bytes,
        }
    }

    pub fn copy_back(&self, encoder: &mut wgpu::CommandEncoder) {
        encoder.copy_texture_to_buffer(
            self.picture.as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: &self.readback,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(self.row_bytes),
                    rows_per_image: None,
                },
            },
            self.picture.size(),
        );
    }

    /// Waits for the copy and takes the pixels without the padding of the rows.
    pub fn read(&self, device: &wgpu::Device) -> Result<Image, RenderError> {
        let failed = |reason: String| RenderError::Device { reason };
        let slice = self.readback.slice(..);
        slice.map_async(wgpu::MapMode::Read, |_| {});
        device
            .poll(wgpu::PollType::wait_indefinitely())
            .map_err(|error| failed(error.to_string()))?;
        let mapped = slice
            .get_mapped_range()
            .map_err(|error| failed(error.to_string()))?;
        let width = 4 * self.form.width as usize;
        let mut rgba8 = Vec::with_capacity(width * self.form.height as usize);
        for row in mapped.chunks_exact(self.row_bytes as usize) {
            rgba8.extend_from_slice(&row[..width]);
        }
        drop(mapped);
        self.readback.unmap();
        Ok(Image::new(self.form.width, self.form.height, rgba8))
    }
}

impl Eye {
    fn new(
        device: &wgpu::Device,
        size: (u32, u32),
        (quality, has_focus): (Quality, bool),
        output: &wgpu::TextureView,
        maps: &Maps<'_>,
    ) -> Self {
        let attachment = wgpu::TextureUsages::RENDER_ATTACHMENT;
        let bound = attachment | wgpu::TextureUsages::TEXTURE_BINDING;
        let made = |size, samples, format, usage| {
            texture(device, size, samples, format, usage).create_view(&Default::default())
        };
        // Where nothing at half size is drawn, there is one texel of it, which is bound.
        let half = match quality.has_openness() {
            true => (size.0.div_ceil(2), size.1.div_ceil(2)),
            false => (1, 1),
        };
        let half_depth = made(half, 1, DEPTH, bound);
        let (raw, open) = (
            made(half, 1, OPENNESS, bound),
            made(half, 1, OPENNESS, bound),
        );
        // Surfaces go to the samples, those to the sharp picture, that through depth of field to the output; what is not needed is left out.
        let sharp = match has_focus {
            true => drawn(device, size, 1),
            false => output.clone(),
        };
        let samples = quality.samples();
        let (samples, resolved) = match samples {
            1 => (sharp.clone(), None),
            _ => (made(size, samples, COLOUR, attachment), Some(sharp.clone())),
        };
        let layouts = maps.layouts;
        let group = |label, layout, entries: &[wgpu::BindGroupEntry<'_>]| {
            device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some(label),
                layout,
                entries,
            })
        };
        let entry = |binding, resource| wgpu::BindGroupEntry { binding, resource };
        let view = wgpu::BindingResource::TextureView;
        let focused = has_focus.then(|| output.clone());
        // A pass must not read what it writes: without depth of field its group is never used, and binds what is at hand.
        let picture = if focused.is_some() { &sharp } else { &open };
        let side = size.0.min(size.1);
        Self {
            square: [(size.0 - side) / 2, (size.1 - side) / 2, side],
            light_group: group(
                "light",
                &layouts.light,
                &[
                    entry(0, view(maps.shadow)),
                    entry(1, wgpu::BindingResource::Sampler(maps.compare)),
                    entry(2, view(&open)),
                    entry(3, wgpu::BindingResource::Sampler(maps.filter)),
                ],
            ),
            depth_group: group("depth", &layouts.depth, &[entry(0, view(&half_depth))]),
            raw_group: group(
                "raw",
                &layouts.raw,
                &[
                    entry(1, view(&raw)),
                    entry(2, wgpu::BindingResource::Sampler(maps.filter)),
                ],
            ),
            focus_group: post_group(device, [picture, picture], &half_depth, maps),
            depth: made(size, quality.samples(), DEPTH, attachment),
            samples,
            resolved,
            half_depth,
            raw,
            open,
            focused,
        }
    }
}

fn post_group(
    device: &wgpu::Device,
    [left, right]: [&wgpu::TextureView; 2],
    depth: &wgpu::TextureView,
    maps: &Maps<'_>,
) -> wgpu::BindGroup {
    let view = wgpu::BindingResource::TextureView;
    let resources = [
        view(left),
        view(right),
        view(depth),
        wgpu::BindingResource::Sampler(maps.filter),
    ];
    let entries: Vec<wgpu::BindGroupEntry<'_>> = resources
        .into_iter()
        .zip(0..)
        .map(|(resource, binding)| wgpu::BindGroupEntry { binding, resource })
        .collect();
    device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("post"),
        layout: &maps.layouts.post,
        entries: &entries,
    })
}

/// A picture that later passes read.
fn drawn(device: &wgpu::Device, size: (u32, u32), samples: u32) -> wgpu::TextureView {
    let usage = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING;
    texture(device, size, samples, COLOUR, usage).create_view(&Default::default())
}

/// A plain 2D texture.
pub(crate) fn texture(
    device: &wgpu::Device,
    size: (u32, u32),
    sample_count: u32,
    format: wgpu::TextureFormat,
    usage: wgpu::TextureUsages,
) -> wgpu::Texture {
    device.create_texture(&description(size, sample_count, format, usage))
}

fn description(
    (width, height): (u32, u32),
    sample_count: u32,
    format: wgpu::TextureFormat,
    usage: wgpu::TextureUsages,
) -> wgpu::TextureDescriptor<'static> {
    wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d {
            width,
            height,
            depth_or_array_layers: 1,
        },
        mip_level_count: 1,
        sample_count,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage,
        view_formats: &[],
    }
}
