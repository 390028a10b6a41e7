//! The passes of one picture.

use crate::batch::{Draw, Source};
use crate::pipelines::{CutDepth, Pipelines};
use crate::quality::Quality;
use crate::stereo::{Stereo, StereoLayout};
use crate::store::Triangles;
use crate::targets::{Eye, Targets};
use crate::textures::Textures;

/// What a picture is drawn with.
pub(crate) struct Frame<'a> {
    pub draws: &'a [Draw],
    pub instances: &'a wgpu::Buffer,
    pub pipelines: &'a Pipelines,
    pub targets: &'a Targets,
    pub textures: &'a Textures,
    pub shadow: &'a wgpu::TextureView,
    pub quality: Quality,
    pub layout: Stereo,
}

/// Looks up the triangles of a drawing.
type Find<'a> = dyn Fn(Source) -> Option<&'a Triangles> + 'a;

/// Encodes all passes; `scenes` has the group of each eye.
pub(crate) fn encode<'a>(
    encoder: &mut wgpu::CommandEncoder,
    frame: &Frame<'a>,
    scenes: &[&wgpu::BindGroup],
    find: &Find<'a>,
) {
    let solid = || {
        frame
            .draws
            .iter()
            .enumerate()
            .filter(|(_, draw)| draw.solid)
    };
    {
        let mut pass = depth_pass(encoder, "shadow", frame.shadow);
        pass.set_bind_group(0, scenes[0], &[]);
        for (index, draw) in solid().filter(|(_, draw)| draw.casts) {
            let pipelines = frame.pipelines;
            match frame.cut(draw) {
                Some((texture, cut)) => {
                    pass.set_pipeline(&cut.shadow);
                    pass.set_bind_group(2, texture, &[]);
                }
                None => pass.set_pipeline(&pipelines.shadow),
            }
            frame.draw(&mut pass, index, draw, find);
        }
    }
    for (eye, scene) in frame.targets.eyes.iter().zip(scenes) {
        if frame.quality.has_openness() {
            {
                let mut pass = depth_pass(encoder, "depth", &eye.half_depth);
                pass.set_bind_group(0, *scene, &[]);
                for (index, draw) in solid() {
                    match frame.cut(draw) {
                        Some((texture, cut)) => {
                            pass.set_pipeline(&cut.depth);
                            pass.set_bind_group(2, texture, &[]);
                        }
                        None => pass.set_pipeline(&frame.pipelines.depth),
                    }
                    frame.draw(&mut pass, index, draw, find);
                }
            }
            let pipelines = frame.pipelines;
            whole(
                encoder,
                &eye.raw,
                &pipelines.openness,
                [scene, &eye.depth_group],
            );
            whole(
                encoder,
                &eye.open,
                &pipelines.smooth,
                [scene, &eye.raw_group],
            );
        }
        field(encoder, frame, eye, scene, find);
        if let Some(focused) = &eye.focused {
            let groups = [*scene, &eye.focus_group];
            whole(encoder, focused, &frame.pipelines.focus, groups);
        }
    }
    if let (Some(group), false) = (
        &frame.targets.compose_group,
        frame.layout.layout == StereoLayout::Mono,
    ) {
        let pipeline = &frame.pipelines.compose[frame.layout.number() as usize - 1];
        whole(encoder, &frame.targets.view, pipeline, [scenes[0], group]);
    }
}

/// Background and surfaces.
fn field<'a>(
    encoder: &mut wgpu::CommandEncoder,
    frame: &Frame<'a>,
    eye: &Eye,
    scene: &wgpu::BindGroup,
    find: &Find<'a>,
) {
    let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("field"),
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view: &eye.samples,
            depth_slice: None,
            resolve_target: eye.resolved.as_ref(),
            ops: wgpu::Operations {
                load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                store: match eye.resolved {
                    Some(_) => wgpu::StoreOp::Discard,
                    None => wgpu::StoreOp::Store,
                },
            },
        })],
        depth_stencil_attachment: Some(depth_attachment(&eye.depth, wgpu::StoreOp::Discard)),
        ..Default::default()
    });
    // An odd rest leaves the field half a pixel to the right and below.
    let [left, top, side] = eye.square;
    pass.set_scissor_rect(left, top, side, side);
    pass.set_bind_group(0, scene, &[]);
    pass.set_pipeline(&frame.pipelines.background);
    pass.draw(0..3, 0..1);
    pass.set_bind_group(1, &eye.light_group, &[]);
    for (index, draw) in frame.draws.iter().enumerate() {
        let pipelines = frame.pipelines;
        let texture = draw.texture.and_then(|id| frame.textures.group(id));
        let surface = match draw.is_masked {
            true => pipelines.masked(draw.family, draw.solid),
            false => pipelines.textured(draw.family, draw.solid),
        };
        match texture.zip(surface) {
            Some((texture, pipeline)) => {
                pass.set_pipeline(pipeline);
                pass.set_bind_group(2, texture, &[]);
            }
            None => pass.set_pipeline(pipelines.surface(draw.family, draw.solid, draw.closed)),
        }
        frame.draw(&mut pass, index, draw, find);
    }
}

impl<'a> Frame<'a> {
    /// What draws the depth of a surface that is cut out by its texture, and this texture.
    fn cut(&self, draw: &Draw) -> Option<(&'a wgpu::BindGroup, &'a CutDepth)> {
        let id = draw.texture.filter(|_| draw.is_masked)?;
        self.textures.group(id).zip(self.pipelines.cut_depth())
    }

    fn draw(&self, pass: &mut wgpu::RenderPass<'_>, index: usize, draw: &Draw, find: &Find<'a>) {
        let Some(triangles) = find(draw.source).filter(|triangles| triangles.count > 0) else {
            return;
        };
        pass.set_vertex_buffer(0, triangles.vertices.buffer().slice(..));
        pass.set_vertex_buffer(1, triangles.details.buffer().slice(..));
        pass.set_vertex_buffer(2, self.instances.slice(..));
        let indices = triangles.indices.buffer().slice(..);
        pass.set_index_buffer(indices, wgpu::IndexFormat::Uint32);
        let instance = index as u32;
        pass.draw_indexed(0..triangles.count, 0, instance..instance + 1);
    }
}

/// A pass over all pixels of `target`.
fn whole(
    encoder: &mut wgpu::CommandEncoder,
    target: &wgpu::TextureView,
    pipeline: &wgpu::RenderPipeline,
    [scene, group]: [&wgpu::BindGroup; 2],
) {
    let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view: target,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations {
                load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                store: wgpu::StoreOp::Store,
            },
        })],
        ..Default::default()
    });
    pass.set_pipeline(pipeline);
    pass.set_bind_group(0, scene, &[]);
    pass.set_bind_group(1, group, &[]);
    pass.draw(0..3, 0..1);
}

fn depth_pass<'e>(
    encoder: &'e mut wgpu::CommandEncoder,
    label: &str,
    view: &wgpu::TextureView,
) -> wgpu::RenderPass<'e> {
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some(label),
        depth_stencil_attachment: Some(depth_attachment(view, wgpu::StoreOp::Store)),
        ..Default::default()
    })
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
