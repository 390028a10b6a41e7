//! The graphics device: instance, adapter, device, queue and limits, and the errors of getting them.
//!
//! Whoever draws (or computes) opens one [`Gpu`] and clones it. Not here: scenes, pictures, shaders, windows. The crate
//! sets no environment variable and reads none of its own; the Vulkan loader reads its usual ones.
//!
//! A machine without a graphics card draws with Mesa's software driver ("llvmpipe"); a machine without any driver gets
//! [`GpuError::NoAdapter`], whose text names what to install.
//!
//! Mesa's device-select layer, which the loader puts before every driver, prints "XDG_RUNTIME_DIR is invalid or not set" to
//! standard error where that variable is missing. It is harmless and only the environment can silence it: a valid
//! `XDG_RUNTIME_DIR`, or `NODEVICE_SELECT=1`, set before the process has a second thread.

#![forbid(unsafe_code)]

use std::fmt;
use std::sync::{Arc, OnceLock};

/// An open graphics device. Cloning shares the device.
#[derive(Clone, Debug)]
pub struct Gpu {
    device: wgpu::Device,
    queue: wgpu::Queue,
    adapter_name: String,
    lost: Arc<OnceLock<String>>,
}

impl Gpu {
    /// Opens the best adapter of this machine for drawing into memory, without a window.
    ///
    /// A hardware adapter is preferred to a software one. May take some hundred milliseconds (driver start-up).
    ///
    /// # Errors
    /// [`GpuError::NoAdapter`] without a usable driver, [`GpuError::Device`] when the driver refuses to open.
    pub fn off_screen() -> Result<Self, GpuError> {
        // Vulkan without a display handle: nothing here talks to a window system. Validation layers are for developers of
        // shaders, not for a training session.
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
            backends: wgpu::Backends::VULKAN,
            flags: wgpu::InstanceFlags::empty(),
            ..wgpu::InstanceDescriptor::new_without_display_handle()
        });
        let options = wgpu::RequestAdapterOptions {
            power_preference: wgpu::PowerPreference::HighPerformance,
            ..Default::default()
        };
        let adapter = pollster::block_on(instance.request_adapter(&options))
            .map_err(|_| GpuError::NoAdapter)?;
        let info = adapter.get_info();
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("microsim"),
            required_features: wgpu::Features::empty(),
            // What every WebGPU device guarantees; only the size of a picture follows the adapter.
            required_limits: wgpu::Limits::default().using_resolution(adapter.limits()),
            ..Default::default()
        };
        let (device, queue) =
            pollster::block_on(adapter.request_device(&descriptor)).map_err(|error| {
                GpuError::Device {
                    adapter: info.name.clone(),
                    reason: error.to_string(),
                }
            })?;
        Ok(Self::from_device(device, queue, info.name))
    }

    /// Takes a device that is open already, such as the one that draws to a window, with the name of its adapter. It needs the limits that every
    /// WebGPU device guarantees. The callback for the loss of the device is set here and belongs to the result.
    pub fn from_device(device: wgpu::Device, queue: wgpu::Queue, adapter_name: String) -> Self {
        let lost = Arc::new(OnceLock::new());
        let shared = lost.clone();
        device.set_device_lost_callback(move |reason, message| {
            // The first loss is the one that counts.
            let _ = shared.set(match message.is_empty() {
                true => format!("device lost ({reason:?})"),
                false => format!("device lost ({reason:?}): {message}"),
            });
        });
        Self {
            device,
            queue,
            adapter_name,
            lost,
        }
    }

    /// Why the device is lost, once it is: the driver was reset or removed, or the device destroyed. Nothing can be drawn with it any more; a new one
    /// has to be opened. Known from the next poll of the device on, which every submission and every wait does.
    pub fn lost(&self) -> Option<&str> {
        self.lost.get().map(String::as_str)
    }

    /// The adapter's name as its driver gives it, e.g. "llvmpipe (LLVM 19.1.7, 256 bits)".
    pub fn adapter_name(&self) -> &str {
        &self.adapter_name
    }

    /// Whether the processor draws, by the names of the software drivers that there are: Mesa's llvmpipe (lavapipe) and SwiftShader.
    pub fn is_software(&self) -> bool {
        let name = self.adapter_name.to_lowercase();
        ["llvmpipe", "lavapipe", "swiftshader"]
            .iter()
            .any(|driver| name.contains(driver))
    }

    /// The largest width and height of a picture \[pixels\].
    pub fn max_picture_side(&self) -> u32 {
        self.device.limits().max_texture_dimension_2d
    }

    /// The device: makes buffers, textures and pipelines. Callable from any thread.
    pub fn device(&self) -> &wgpu::Device {
        &self.device
    }

    /// The queue: uploads and runs commands. Callable from any thread.
    pub fn queue(&self) -> &wgpu::Queue {
        &self.queue
    }
}

/// Why there is no graphics device.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum GpuError {
    /// No Vulkan driver, or none that can draw.
    NoAdapter,
    /// A driver is there but would not open its device.
    Device {
        /// The adapter's name.
        adapter: String,
        /// Message of the driver.
        reason: String,
    },
}

impl fmt::Display for GpuError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoAdapter => f.write_str(
                "no graphics driver with Vulkan found, so pictures are off; install one \
                 (Debian, Ubuntu: apt-get install mesa-vulkan-drivers libvulkan1, which needs no graphics card)",
            ),
            Self::Device { adapter, reason } => write!(f, "the graphics driver of {adapter:?} did not open: {reason}"),
        }
    }
}

impl std::error::Error for GpuError {}

#[cfg(test)]
mod tests {
    use super::*;

    /// Opens where there is a driver and names it; where there is none the reason is the one an operator can act on.
    #[test]
    fn opens_or_says_what_to_install() {
        match Gpu::off_screen() {
            Ok(gpu) => {
                assert!(!gpu.adapter_name().is_empty());
                // 2048 is the least that WebGPU's downlevel limits allow; a picture of a training session is smaller.
                assert!(gpu.max_picture_side() >= 2048, "{}", gpu.max_picture_side());
            }
            Err(error) => {
                println!("skipped: {error}");
                assert_eq!(error, GpuError::NoAdapter);
            }
        }
    }

    /// The text names the two Debian packages and is one sentence (no line break, no full stop inside).
    #[test]
    fn missing_driver_is_one_clear_sentence() {
        let text = GpuError::NoAdapter.to_string();
        assert!(
            text.contains("mesa-vulkan-drivers") && text.contains("libvulkan1"),
            "{text}"
        );
        assert!(!text.contains('\n') && !text.contains(". "), "{text}");
    }
}
