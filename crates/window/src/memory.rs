//! Memory that was freed goes back to the system.
//!
//! glibc keeps what is freed between blocks that are in use: levels with recordings and pictures of many sizes leave gaps of hundreds of
//! megabytes behind. Elsewhere nothing is done.

/// After so many pictures the driver has drawn, and freed, all that was let go with a level: it has three of them at most at the same time.
const PICTURES: u32 = 8;

/// Gives back what a level or a replay took, once all of it is freed.
#[derive(Debug, Default)]
pub struct GivingBack {
    pictures: Option<u32>,
}

impl GivingBack {
    /// Something was left.
    pub fn begin(&mut self) {
        self.pictures = Some(0);
    }

    /// Another picture is drawn; none counts while threads of what was left compute still. Whether more pictures are needed.
    pub fn count(&mut self, computes_still: bool) -> bool {
        let Some(pictures) = &mut self.pictures else {
            return false;
        };
        if computes_still {
            return true;
        }
        *pictures += 1;
        if *pictures < PICTURES {
            return true;
        }
        self.pictures = None;
        give_back();
        false
    }
}

/// Gives back what is freed, in all arenas.
pub fn give_back() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    // SAFETY: the function takes a size alone, may be called from any thread, and touches no block that is in use.
    unsafe {
        libc::malloc_trim(0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// It waits for the threads, then for the driver, and then no picture is drawn for it.
    #[test]
    fn it_is_given_back_some_pictures_after_the_last_thread() {
        let mut giving_back = GivingBack::default();
        assert!(!giving_back.count(false), "nothing was left");
        giving_back.begin();
        assert!((0..20).all(|_| giving_back.count(true)));
        assert!((1..PICTURES).all(|_| giving_back.count(false)));
        assert!(!giving_back.count(false));
        assert!(!giving_back.count(false));
    }
}

#[cfg(all(test, target_os = "linux", target_env = "gnu"))]
mod tests_with_glibc {
    use super::*;

    /// Resident memory \[bytes\].
    fn resident() -> usize {
        let text = std::fs::read_to_string("/proc/self/statm").expect("a process has its figures");
        let pages = text.split(' ').nth(1).expect("pages that are resident");
        pages.parse::<usize>().expect("a number") * rustix::param::page_size()
    }

    /// Of 256 MB in blocks of 16 kB every 64th stays in use, and with it the gaps between them, until they are given back: all but the pages at
    /// the ends of a gap of 1 MB. Half of it leaves room for what other tests take at the same time.
    #[test]
    fn gaps_between_blocks_go_back_to_the_system() {
        const BLOCK: usize = 16 << 10;
        const COUNT: usize = 16 << 10;
        let mut blocks: Vec<Option<Vec<u8>>> = (0..COUNT).map(|_| Some(vec![1; BLOCK])).collect();
        for (index, block) in blocks.iter_mut().enumerate() {
            if index % 64 != 0 {
                *block = None;
            }
        }
        let before = resident();
        give_back();
        let after = resident();
        assert!(
            before.saturating_sub(after) > COUNT * BLOCK / 2,
            "{before} bytes resident before, {after} after"
        );
        assert!(blocks.iter().flatten().all(|block| block[0] == 1));
    }
}
