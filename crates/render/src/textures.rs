//! Textures of models on the device: each once, with its pictures of half the size and so on, found again from picture to picture.

use microsim_model as model;
use std::collections::BTreeMap;
use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use crate::light::linear_from_srgb;

/// Textures that are not drawn are forgotten when there are more than this.
const MOST: usize = 64;
/// Linear light from 0 to 1 in whole steps, finer than those of sRGB in the darkest colours.
const STEPS: u32 = u16::MAX as u32;

/// A texture that is read once and drawn often. Two are the same if they are copies of one.
#[derive(Clone)]
pub(crate) struct Texture {
    id: u64,
    picture: Arc<model::Texture>,
}

impl Texture {
    /// Takes a picture; each call makes another texture.
    pub fn new(picture: model::Texture) -> Self {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        Self {
            id: NEXT.fetch_add(1, Ordering::Relaxed),
            picture: Arc::new(picture),
        }
    }

    /// What distinguishes it from others of the process.
    pub fn id(&self) -> u64 {
        self.id
    }
}

impl fmt::Debug for Texture {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?} {}", self.picture, self.id)
    }
}

struct Stored {
    group: wgpu::BindGroup,
    /// Number of the picture in which it was last drawn.
    used: u64,
}

/// All textures that are on the device.
pub(crate) struct Textures {
    /// By how coordinates leave 0 to 1, sideways and upwards; those that were asked for.
    samplers: BTreeMap<[model::Wrap; 2], wgpu::Sampler>,
    stored: BTreeMap<u64, Stored>,
    picture: u64,
}

/// How a texture is read: smoothed, and with one of the wrap modes beyond each pair of sides.
fn sampler_of(device: &wgpu::Device, wrap: [model::Wrap; 2]) -> wgpu::Sampler {
    let [u, v] = wrap.map(|wrap| match wrap {
        model::Wrap::Repeat => wgpu::AddressMode::Repeat,
        model::Wrap::Mirrored => wgpu::AddressMode::MirrorRepeat,
        model::Wrap::Clamp => wgpu::AddressMode::ClampToEdge,
    });
    device.create_sampler(&wgpu::SamplerDescriptor {
        label: Some("textures"),
        address_mode_u: u,
        address_mode_v: v,
        mag_filter: wgpu::FilterMode::Linear,
        min_filter: wgpu::FilterMode::Linear,
        mipmap_filter: wgpu::MipmapFilterMode::Linear,
        ..Default::default()
    })
}

impl Textures {
    pub fn new() -> Self {
        Self {
            samplers: BTreeMap::new(),
            stored: BTreeMap::new(),
            picture: 0,
        }
    }

    /// Begins a picture; textures that were not drawn of late make room.
    pub fn begin(&mut self) {
        self.picture += 1;
        if self.stored.len() > MOST {
            let picture = self.picture;
            self.stored.retain(|_, texture| texture.used + 1 >= picture);
        }
    }

    /// Brings a texture to the device if it is not there.
    pub fn place(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        layout: &wgpu::BindGroupLayout,
        texture: &Texture,
    ) {
        let wrap = texture.picture.wrap;
        let sampler = self.samplers.entry(wrap);
        let sampler = sampler.or_insert_with(|| sampler_of(device, wrap));
        let stored = self.stored.entry(texture.id).or_insert_with(|| Stored {
            group: upload(device, queue, layout, sampler, &texture.picture),
            used: 0,
        });
        stored.used = self.picture;
    }

    /// What the shader reads of a texture of this picture.
    pub fn group(&self, id: u64) -> Option<&wgpu::BindGroup> {
        self.stored.get(&id).map(|stored| &stored.group)
    }
}

fn upload(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    layout: &wgpu::BindGroupLayout,
    sampler: &wgpu::Sampler,
    picture: &model::Texture,
) -> wgpu::BindGroup {
    let most = device.limits().max_texture_dimension_2d;
    let levels: Vec<model::Texture> = levels(picture)
        .into_iter()
        .skip_while(|level| level.width > most || level.height > most)
        .collect();
    let size = |level: &model::Texture| wgpu::Extent3d {
        width: level.width,
        height: level.height,
        depth_or_array_layers: 1,
    };
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: Some("texture"),
        size: size(&levels[0]),
        mip_level_count: levels.len() as u32,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        // Read as linear light, before neighbours are averaged.
        format: wgpu::TextureFormat::Rgba8UnormSrgb,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    for (number, level) in levels.iter().enumerate() {
        queue.write_texture(
            wgpu::TexelCopyTextureInfo {
                texture: &texture,
                mip_level: number as u32,
                origin: wgpu::Origin3d::ZERO,
                aspect: wgpu::TextureAspect::All,
            },
            &level.pixels,
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(4 * level.width),
                rows_per_image: None,
            },
            size(level),
        );
    }
    device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("texture"),
        layout,
        entries: &[
            wgpu::BindGroupEntry {
                binding: 0,
                resource: wgpu::BindingResource::TextureView(
                    &texture.create_view(&Default::default()),
                ),
            },
            wgpu::BindGroupEntry {
                binding: 1,
                resource: wgpu::BindingResource::Sampler(sampler),
            },
        ],
    })
}

/// The picture and those of half the size each, rounded down, to one pixel.
fn levels(picture: &model::Texture) -> Vec<model::Texture> {
    let mean = Mean::new();
    let mut levels = vec![picture.clone()];
    while let Some(last) = levels.last().filter(|last| last.width * last.height > 1) {
        levels.push(mean.halved(last));
    }
    levels
}

/// Means of colours: the light that arrives from all of them together.
struct Mean {
    /// Of sRGB.
    linear: Vec<u32>,
    /// Of linear light.
    encoded: Vec<u8>,
}

impl Mean {
    fn new() -> Self {
        let linear = |byte: u32| linear_from_srgb(f64::from(byte) / 255.0) * f64::from(STEPS);
        let linear: Vec<u32> = (0..=255).map(|byte| linear(byte).round() as u32).collect();
        let mut encoded = Vec::with_capacity(STEPS as usize + 1);
        for byte in 0..=255_u32 {
            // Up to the middle between this value and the next one, which sRGB rounds to this one.
            let next = linear_from_srgb((f64::from(byte) + 0.5) / 255.0) * f64::from(STEPS);
            let end = match byte {
                255 => STEPS as usize + 1,
                _ => next.ceil() as usize,
            };
            encoded.resize(end.max(encoded.len()), byte as u8);
        }
        Self { linear, encoded }
    }

    /// Half the size: each pixel from four, or from two where a side is one pixel long.
    fn halved(&self, of: &model::Texture) -> model::Texture {
        let (width, height) = ((of.width / 2).max(1), (of.height / 2).max(1));
        let mut pixels = Vec::with_capacity(4 * width as usize * height as usize);
        for (row, column) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
            let four = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(right, down)| {
                let x = (2 * column + right).min(of.width - 1) as usize;
                let y = (2 * row + down).min(of.height - 1) as usize;
                let first = 4 * (y * of.width as usize + x);
                &of.pixels[first..first + 4]
            });
            for k in 0..3 {
                let light = four.iter().map(|pixel| self.linear[pixel[k] as usize]);
                let mean = (light.sum::<u32>() + 2) / 4;
                pixels.push(self.encoded[mean as usize]);
            }
            let opacity: u32 = four.iter().map(|pixel| u32::from(pixel[3])).sum();
            pixels.push(((opacity + 2) / 4) as u8);
        }
        model::Texture {
            width,
            height,
            pixels,
            wrap: of.wrap,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grey(width: u32, height: u32, value: impl Fn(u32, u32) -> u8) -> model::Texture {
        let pixel = |x, y| [value(x, y), value(x, y), value(x, y), 255];
        model::Texture {
            width,
            height,
            pixels: (0..height)
                .flat_map(|y| (0..width).map(move |x| (x, y)))
                .flat_map(|(x, y)| pixel(x, y))
                .collect(),
            wrap: [model::Wrap::Repeat; 2],
        }
    }

    /// Half black and half white is half the light, which sRGB has as 188 (IEC 61966-2-1: 255 (1.055 · 0.5^(1/2.4) − 0.055) = 187.5), on every level.
    #[test]
    fn smaller_pictures_have_the_mean_light() {
        let board = grey(8, 8, |x, y| if (x + y) % 2 == 0 { 0 } else { 255 });
        let levels = levels(&board);
        let sizes: Vec<(u32, u32)> = levels.iter().map(|l| (l.width, l.height)).collect();
        assert_eq!(sizes, [(8, 8), (4, 4), (2, 2), (1, 1)]);
        for level in &levels[1..] {
            let colours = level.pixels.chunks_exact(4);
            assert!(
                colours.clone().all(|p| p == [188, 188, 188, 255]),
                "{level:?}"
            );
        }
    }

    /// What is of one colour stays of it, whatever the colour, in pictures of any sides.
    #[test]
    fn one_colour_stays() {
        for value in 0..=255 {
            let levels = levels(&grey(5, 3, |_, _| value));
            let sizes: Vec<(u32, u32)> = levels.iter().map(|l| (l.width, l.height)).collect();
            assert_eq!(sizes, [(5, 3), (2, 1), (1, 1)]);
            let colours = levels.iter().flat_map(|level| level.pixels.chunks_exact(4));
            assert!(
                colours.clone().all(|p| p == [value, value, value, 255]),
                "{value}"
            );
        }
    }
}
