//! The textures that are drawn into, and reading the pixels back to memory.

use crate::error::RenderError;
use crate::image::Image;

/// Samples per pixel for smooth edges; 4 is what every driver offers.
pub(crate) const SAMPLES: u32 = 4;
pub(crate) const COLOUR: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8UnormSrgb;
pub(crate) const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// Textures of one picture size, and the buffer through which the pixels come back.
pub(crate) struct Targets {
    pub width: u32,
    pub height: u32,
    pub samples: wgpu::TextureView,
    pub depth: wgpu::TextureView,
    pub resolved: wgpu::Texture,
    pub view: wgpu::TextureView,
    readback: wgpu::Buffer,
    /// Bytes from one row to the next in `readback`.
    row_bytes: u32,
}

impl Targets {
    pub fn new(device: &wgpu::Device, width: u32, height: u32) -> Self {
        let attachment = wgpu::TextureUsages::RENDER_ATTACHMENT;
        let size = (width, height);
        let align = wgpu::COPY_BYTES_PER_ROW_ALIGNMENT;
        let row_bytes = (4 * width).div_ceil(align) * align;
        let resolved = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("picture"),
            view_formats: &[COLOUR.remove_srgb_suffix()],
            ..description(
                size,
                1,
                COLOUR,
                attachment | wgpu::TextureUsages::COPY_SRC | wgpu::TextureUsages::TEXTURE_BINDING,
            )
        });
        Self {
            width,
            height,
            samples: texture(device, size, SAMPLES, COLOUR, attachment)
                .create_view(&Default::default()),
            depth: texture(device, size, SAMPLES, DEPTH, attachment)
                .create_view(&Default::default()),
            view: resolved.create_view(&Default::default()),
            resolved,
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
            self.resolved.as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: &self.readback,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(self.row_bytes),
                    rows_per_image: None,
                },
            },
            self.resolved.size(),
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
        let mut rgba8 = Vec::with_capacity(4 * self.width as usize * self.height as usize);
        for row in mapped.chunks_exact(self.row_bytes as usize) {
            rgba8.extend_from_slice(&row[..4 * self.width as usize]);
        }
        drop(mapped);
        self.readback.unmap();
        Ok(Image::new(self.width, self.height, rgba8))
    }
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
