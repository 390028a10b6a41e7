//! Ranges and values of axes, and buttons that are pressed, as the kernel has them at this moment.

use crate::capabilities::Capabilities;
use crate::range::Range;
use std::fs::File;
use std::io;

/// What holds before the first record, or after records were lost.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Probed {
    /// Absolute axes: number, range, value.
    pub axes: Vec<(u16, Range, i32)>,
    /// Buttons that are pressed.
    pub buttons: Vec<u16>,
}

/// Who asks a device for it.
pub trait Probe: Send + Sync + 'static {
    /// Asks an open device.
    ///
    /// # Errors
    /// If it is gone, or is none.
    fn probe(&self, device: &File, capabilities: &Capabilities) -> io::Result<Probed>;
}

/// The kernel.
#[derive(Clone, Copy, Debug)]
pub struct Kernel;

impl Probe for Kernel {
    fn probe(&self, device: &File, capabilities: &Capabilities) -> io::Result<Probed> {
        let axis = |&axis: &u16| {
            let [value, least, most, ..] = request::axis(device, axis)?;
            Ok::<_, io::Error>((axis, Range { least, most }, value))
        };
        let pressed = request::pressed(device)?;
        let is_pressed = |button: &u16| {
            let byte = pressed.get(usize::from(*button / 8));
            byte.is_some_and(|byte| byte >> (*button % 8) & 1 == 1)
        };
        Ok(Probed {
            axes: capabilities
                .absolute
                .iter()
                .map(axis)
                .collect::<Result<_, _>>()?,
            buttons: capabilities
                .buttons
                .iter()
                .copied()
                .filter(is_pressed)
                .collect(),
        })
    }
}

/// Two requests of `linux/input.h`.
mod request {
    use rustix::ioctl::{Ioctl, IoctlOutput, Opcode, ioctl, opcode};
    use std::ffi::c_void;
    use std::fs::File;
    use std::io;

    /// A request that fills plain numbers.
    struct Fill<T> {
        opcode: Opcode,
        numbers: T,
    }

    // SAFETY: `as_ptr` is the address of as many bytes as the opcode, made of the same type, has the kernel write; any bytes are numbers.
    unsafe impl<T: Copy> Ioctl for Fill<T> {
        type Output = T;
        const IS_MUTATING: bool = true;

        fn opcode(&self) -> Opcode {
            self.opcode
        }

        fn as_ptr(&mut self) -> *mut c_void {
            (&raw mut self.numbers).cast()
        }

        unsafe fn output_from_ptr(_: IoctlOutput, numbers: *mut c_void) -> rustix::io::Result<T> {
            // SAFETY: the address is that of `as_ptr`, and the request has succeeded.
            Ok(unsafe { numbers.cast::<T>().read() })
        }
    }

    /// EVIOCGABS: value, least and greatest value of an axis, then what is not used here.
    pub fn axis(device: &File, axis: u16) -> io::Result<[i32; 6]> {
        let request = Fill {
            // Axes are numbers up to 0x3f.
            opcode: opcode::read::<[i32; 6]>(b'E', 0x40 + (axis as u8 & 0x3f)),
            numbers: [0; 6],
        };
        // SAFETY: the request is one that fills six numbers of 32 bits; other devices refuse it.
        Ok(unsafe { ioctl(device, request) }?)
    }

    /// EVIOCGKEY: a bit for each button.
    pub fn pressed(device: &File) -> io::Result<[u8; 96]> {
        let request = Fill {
            opcode: opcode::read::<[u8; 96]>(b'E', 0x18),
            numbers: [0; 96],
        };
        // SAFETY: the request is one that fills as many bytes as its opcode has; other devices refuse it.
        Ok(unsafe { ioctl(device, request) }?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers of the requests by the macros of C: `EVIOCGABS(0)` is 0x80184540, `EVIOCGKEY(96)` 0x80604518. What is no device refuses them with ENOTTY.
    #[test]
    fn what_is_no_device_is_refused() {
        use rustix::ioctl::opcode::read;
        assert_eq!(read::<[i32; 6]>(b'E', 0x40), 0x8018_4540);
        assert_eq!(read::<[u8; 96]>(b'E', 0x18), 0x8060_4518);
        let file = tempfile::tempfile().expect("a file");
        let refused = Kernel.probe(&file, &Capabilities::default());
        let why = refused.expect_err("a file is no device").raw_os_error();
        assert_eq!(why, Some(rustix::io::Errno::NOTTY.raw_os_error()));
    }
}
