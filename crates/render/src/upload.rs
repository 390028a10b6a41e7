//! Buffers that persist from picture to picture and only grow.

/// A buffer on the device whose contents are replaced for each picture.
pub(crate) struct Upload {
    buffer: wgpu::Buffer,
    label: &'static str,
}

impl Upload {
    /// Space for `capacity` bytes at first.
    pub fn new(
        device: &wgpu::Device,
        label: &'static str,
        usage: wgpu::BufferUsages,
        capacity: u64,
    ) -> Self {
        let buffer = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size: capacity,
            usage: usage | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        Self { buffer, label }
    }

    /// Replaces the contents. Half as much again is reserved where the buffer is too small, so that a body that cuts open does not make one per picture.
    pub fn write<T: bytemuck::NoUninit>(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        contents: &[T],
    ) {
        let bytes: &[u8] = bytemuck::cast_slice(contents);
        let needed = bytes.len() as u64;
        if needed > self.buffer.size() {
            let capacity = (needed + needed / 2).next_multiple_of(wgpu::COPY_BUFFER_ALIGNMENT);
            *self = Self::new(device, self.label, self.buffer.usage(), capacity);
        }
        if needed > 0 {
            queue.write_buffer(&self.buffer, 0, bytes);
        }
    }

    /// The buffer, which another one replaces when it grows.
    pub fn buffer(&self) -> &wgpu::Buffer {
        &self.buffer
    }
}
