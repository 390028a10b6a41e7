//! Panics that are caught before they reach the boundary.

use std::any::Any;
use std::cell::{Cell, RefCell};
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::Once;

thread_local! {
    static CROSSING: Cell<bool> = const { Cell::new(false) };
    static PANIC: RefCell<String> = const { RefCell::new(String::new()) };
}

/// Keeps the place of a panic for the fault's text instead of printing it; panics elsewhere go on as before.
pub(crate) fn install_hook() {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let previous = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |info| {
            if CROSSING.get() {
                PANIC.with_borrow_mut(|text| *text = info.to_string());
            } else {
                previous(info);
            }
        }));
    });
}

/// A panic that was caught, with what the hook has recorded of it.
pub(crate) struct Caught {
    text: String,
    content: Box<dyn Any + Send>,
}

impl Caught {
    /// What the hook has recorded of it.
    pub fn into_text(self) -> String {
        // The destructor of the content is the plugin's own: it might panic again, where nothing catches it.
        std::mem::forget(self.content);
        self.text
    }

    /// Lets the panic go on, on this thread.
    pub fn resume(self) -> ! {
        PANIC.set(self.text);
        resume_unwind(self.content)
    }
}

/// Calls, and catches a panic.
pub(crate) fn caught<T>(call: impl FnOnce() -> T) -> Result<T, Caught> {
    let before = CROSSING.replace(true);
    let result = catch_unwind(AssertUnwindSafe(call));
    CROSSING.set(before);
    result.map_err(|content| Caught {
        text: PANIC.take(),
        content,
    })
}
