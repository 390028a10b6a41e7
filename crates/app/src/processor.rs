//! What the build takes of a processor, asked before anything is computed: a missing instruction would end the program without
//! a word.
//!
//! The processor itself is asked (`cpuid`). `is_x86_feature_detected!` would not ask: it is true at compile time for all that
//! the build may use. A processor without AVX at all is refused before `main`, whose first instructions may be of that kind.

/// Instructions that the build may use (`.cargo/config.toml`), and whether this one does.
const USED: [(Instructions, bool); 7] = [
    (Instructions::Avx2, cfg!(target_feature = "avx2")),
    (Instructions::Fma, cfg!(target_feature = "fma")),
    (Instructions::Bmi1, cfg!(target_feature = "bmi1")),
    (Instructions::Bmi2, cfg!(target_feature = "bmi2")),
    (Instructions::F16c, cfg!(target_feature = "f16c")),
    (Instructions::Lzcnt, cfg!(target_feature = "lzcnt")),
    (Instructions::Movbe, cfg!(target_feature = "movbe")),
];

/// A set of instructions that not every x86-64 processor has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Instructions {
    Avx2,
    Fma,
    Bmi1,
    Bmi2,
    F16c,
    Lzcnt,
    Movbe,
}

impl Instructions {
    /// As processors' descriptions write it.
    fn name(self) -> &'static str {
        match self {
            Self::Avx2 => "AVX2",
            Self::Fma => "FMA",
            Self::Bmi1 => "BMI1",
            Self::Bmi2 => "BMI2",
            Self::F16c => "F16C",
            Self::Lzcnt => "LZCNT",
            Self::Movbe => "MOVBE",
        }
    }
}

/// One sentence about what the build uses and this processor lacks; `None` where it lacks nothing.
pub fn complaint() -> Option<String> {
    lacking(&used(), &found())
}

/// Names of the instructions that the build uses besides those of every x86-64 processor.
pub fn used_names() -> String {
    names(&used())
}

fn used() -> Vec<Instructions> {
    let used = USED.into_iter().filter(|(_, used)| *used);
    used.map(|(instructions, _)| instructions).collect()
}

fn names(instructions: &[Instructions]) -> String {
    let names: Vec<_> = instructions.iter().map(|one| one.name()).collect();
    names.join(", ")
}

fn lacking(used: &[Instructions], found: &[Instructions]) -> Option<String> {
    let missing: Vec<_> = used
        .iter()
        .copied()
        .filter(|one| !found.contains(one))
        .collect();
    (!missing.is_empty()).then(|| {
        format!(
            "this processor lacks {}: MicroSim needs an x86-64 processor with AVX2 and FMA (Intel since 2013, AMD since 2015), or a build for another one",
            names(&missing)
        )
    })
}

/// What the processor has and the system lets programs use.
#[cfg(target_arch = "x86_64")]
#[allow(unused_unsafe, reason = "newer compilers know that `cpuid` is safe")]
fn found() -> Vec<Instructions> {
    use std::arch::x86_64::{__cpuid, __cpuid_count};
    // SAFETY: every x86-64 processor has `cpuid`; leaves above the largest one, in which Intel's processors would answer
    // something else, are not read.
    let (basic, extended, more) = unsafe {
        let leaf =
            |number: u32, of: u32| (__cpuid(of).eax >= number).then(|| __cpuid_count(number, 0));
        (leaf(1, 0), leaf(7, 0), leaf(0x8000_0001, 0x8000_0000))
    };
    let bit = |register: u32, at: u32| register >> at & 1 == 1;
    let (basic, extended, more) = (
        basic.map_or(0, |leaf| leaf.ecx),
        extended.map_or(0, |leaf| leaf.ebx),
        more.map_or(0, |leaf| leaf.ecx),
    );
    let wide = bit(basic, 27) && saves_wide_registers();
    [
        (Instructions::Avx2, wide && bit(extended, 5)),
        (Instructions::Fma, wide && bit(basic, 12)),
        (Instructions::Bmi1, bit(extended, 3)),
        (Instructions::Bmi2, bit(extended, 8)),
        (Instructions::F16c, wide && bit(basic, 29)),
        (Instructions::Lzcnt, bit(more, 5)),
        (Instructions::Movbe, bit(basic, 22)),
    ]
    .into_iter()
    .filter(|(_, has)| *has)
    .map(|(instructions, _)| instructions)
    .collect()
}

/// Whether the system keeps registers of 128 and 256 bits when it switches programs.
#[cfg(target_arch = "x86_64")]
fn saves_wide_registers() -> bool {
    let low: u32;
    // SAFETY: asked only where `cpuid` shows that the system lets programs use `xgetbv`, which reads and nothing else.
    unsafe {
        std::arch::asm!("xgetbv", in("ecx") 0, out("eax") low, out("edx") _, options(nomem, nostack, preserves_flags));
    }
    low & 0b110 == 0b110
}

/// Elsewhere the compiler's default stands, which every processor of the kind has.
#[cfg(not(target_arch = "x86_64"))]
fn found() -> Vec<Instructions> {
    used()
}

/// Before `main`, on the system that the project is for: whole numbers alone, and no library.
#[cfg(all(target_arch = "x86_64", target_os = "linux", target_feature = "avx"))]
mod before_main {
    const SENTENCE: &str = "microsim: this processor lacks AVX: MicroSim needs an x86-64 processor with AVX2 and FMA (Intel since 2013, AMD since 2015)\n";

    #[used]
    // SAFETY: the loader calls what stands in this section, a function without results, once and before `main`.
    #[unsafe(link_section = ".init_array")]
    static CHECK: extern "C" fn() = check;

    extern "C" fn check() {
        // SAFETY: the first leaf is there on every x86-64 processor; `write` reads the bytes of a constant, `exit_group` does
        // not return.
        #[allow(unused_unsafe, reason = "newer compilers know that `cpuid` is safe")]
        unsafe {
            const AVX_AND_SAVED: u32 = 1 << 28 | 1 << 27;
            if std::arch::x86_64::__cpuid(1).ecx & AVX_AND_SAVED == AVX_AND_SAVED {
                return;
            }
            std::arch::asm!(
                "syscall", "mov eax, 231", "mov edi, 2", "syscall",
                inout("eax") 1 => _, in("edi") 2, in("rsi") SENTENCE.as_ptr(), in("rdx") SENTENCE.len(),
                out("rcx") _, out("r11") _,
            );
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Instructions::*;
    use super::*;

    #[test]
    fn what_is_missing_is_named_and_nothing_else() {
        let used = [Avx2, Fma, Bmi1, Lzcnt];
        assert_eq!(lacking(&used, &used), None);
        assert_eq!(lacking(&[], &[]), None);
        let sentence = lacking(&used, &[Bmi1, Avx2, F16c]).expect("two are missing");
        assert!(
            sentence.starts_with("this processor lacks FMA, LZCNT: "),
            "{sentence}"
        );
    }

    /// The tests are built like the program: they run, so the processor has what the build uses.
    #[test]
    fn the_processor_that_runs_this_has_what_it_runs() {
        assert_eq!(complaint(), None);
    }

    /// As the system itself lists them; `lzcnt` is part of what it calls `abm`.
    #[test]
    #[cfg(all(target_arch = "x86_64", target_os = "linux"))]
    fn the_processor_is_read_as_the_system_reads_it() {
        let text = std::fs::read_to_string("/proc/cpuinfo").expect("a file of every Linux");
        let flags = text
            .lines()
            .find(|line| line.starts_with("flags"))
            .expect("flags");
        for (instructions, _) in USED {
            let name = match instructions {
                Lzcnt => "abm".to_owned(),
                other => other.name().to_lowercase(),
            };
            let listed = flags.split_whitespace().any(|flag| flag == name);
            assert_eq!(found().contains(&instructions), listed, "{name}");
        }
    }

    /// `.cargo/config.toml` and this list name the same level, unless a builder chose another one.
    #[test]
    fn a_build_with_fused_products_uses_all_of_its_level() {
        let fused = cfg!(target_feature = "fma") && cfg!(target_feature = "movbe");
        assert!(!fused || used().len() == USED.len(), "{}", used_names());
    }
}
