//! A graphics driver that loses its device when it is asked to: a layer between the program and the driver of this machine, of which the program knows nothing.

use crate::peers::done;
use crate::repository;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

const LAYER: &str = "VK_LAYER_MICROSIM_lose_device";

/// The layer, and the folder that it obeys.
#[derive(Debug)]
pub struct Driver {
    folder: PathBuf,
}

impl Driver {
    /// Builds it in an empty folder, with a C compiler and Vulkan's headers, which are installed if they can be.
    ///
    /// # Errors
    /// What is missing.
    pub fn build(folder: &Path) -> Result<Self, String> {
        if !Path::new("/usr/include/vulkan/vk_layer.h").exists() {
            let mut install = Command::new("apt-get");
            install.args(["install", "-y", "-q", "libvulkan-dev"]);
            install.env("DEBIAN_FRONTEND", "noninteractive");
            done(&mut install)?;
        }
        fs::create_dir_all(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
        let library = folder.join("liblose_device.so");
        let mut compiler = Command::new("cc");
        compiler.args([
            "-shared",
            "-fPIC",
            "-fvisibility=hidden",
            "-O1",
            "-Wall",
            "-Werror",
        ]);
        compiler.arg(repository().join("tests/peers/lost_device/layer.c"));
        done(compiler.arg("-o").arg(&library))?;
        let manifest = serde_json::json!({
            "file_format_version": "1.1.2",
            "layer": {
                "name": LAYER,
                "type": "INSTANCE",
                "library_path": library,
                "api_version": "1.3.0",
                "implementation_version": "1",
                "description": "loses the device",
            },
        });
        let file = folder.join("lose_device.json");
        fs::write(&file, manifest.to_string()).map_err(|e| format!("{}: {e}", file.display()))?;
        Ok(Self {
            folder: folder.to_owned(),
        })
    }

    /// Has a program draw with it.
    pub fn put_below(&self, program: &mut Command) {
        program
            .env("VK_LAYER_PATH", &self.folder)
            .env("VK_INSTANCE_LAYERS", LAYER)
            .env("LOSE_DEVICE", &self.folder);
    }

    fn order(&self, name: &str) -> PathBuf {
        let file = self.folder.join(name);
        fs::write(&file, "").unwrap_or_else(|e| panic!("{}: {e}", file.display()));
        file
    }

    /// Loses the devices that are open, with the next that they are asked for; gives the file that is gone once that is done.
    pub fn lose(&self) -> PathBuf {
        self.order("lose")
    }

    /// Opens no device from now on.
    pub fn refuse(&self) {
        self.order("refuse");
    }
}
