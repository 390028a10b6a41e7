//! Instruction counts of kernels: read from callgrind, recorded in a table, compared with it.
//!
//! Times differ from run to run; the number of instructions of a build does not, so that a kernel that has become slower by a
//! few per cent shows. What instructions cost is not in it: a cache miss counts nothing.

use std::fmt::Write as _;

/// Largest relative difference of a count from the recorded one. The same build counts the same to the fourth digit but for
/// the copying and clearing of memory by the C library. [`PLAIN_COPIES`] keeps that from depending on the processor; what is
/// left is another version of the library. Between its plain and its wide copies the kernel that copies most differs by 3.4 %,
/// so half of that is more than two versions of the plain ones will.
pub const MARGIN: f64 = 0.017;

/// Setting of the GNU C library, variable and value, with which it copies memory by the same instructions on every processor.
pub const PLAIN_COPIES: (&str, &str) = (
    "GLIBC_TUNABLES",
    "glibc.cpu.hwcaps=-AVX2,-AVX512F,-AVX512VL,-AVX_Fast_Unaligned_Load,-ERMS,-FSRM",
);

/// Instructions of each kernel, per tetrahedron, and the build that has them.
#[derive(Clone, Debug, PartialEq)]
pub struct Counts {
    /// Compiler and instruction set.
    pub build: String,
    /// Kernels with their counts.
    pub kernels: Vec<(String, f64)>,
}

/// What comes out of a comparison.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// One line per kernel, as a Markdown table.
    pub table: String,
    /// Kernels beyond the margin, or in one of the tables alone.
    pub beyond: Vec<String>,
    /// Whether both tables are of the same build, so that the differences are those of the code.
    pub same_build: bool,
}

impl Counts {
    const HEAD: &'static str = "kernel,instructions_per_tetrahedron,build";

    /// As a file.
    pub fn to_csv(&self) -> String {
        let mut csv = format!("{}\n", Self::HEAD);
        for (kernel, count) in &self.kernels {
            let _ = writeln!(csv, "\"{kernel}\",{count:.1},\"{}\"", self.build);
        }
        csv
    }

    /// From a file.
    ///
    /// # Errors
    /// The number of the line that is none of this table, or 0 where no line is left.
    pub fn from_csv(csv: &str) -> Result<Self, usize> {
        let mut lines = csv.lines().enumerate();
        if lines.next().map(|(_, line)| line) != Some(Self::HEAD) {
            return Err(1);
        }
        let row = |line: &str| {
            let (kernel, rest) = line.strip_prefix('"')?.split_once("\",")?;
            let (count, build) = rest.split_once(",\"")?;
            let count = count.parse().ok().filter(|count| *count > 0.0)?;
            Some((
                kernel.to_owned(),
                count,
                build.strip_suffix('"')?.to_owned(),
            ))
        };
        let mut counts: Option<Self> = None;
        for (index, line) in lines {
            let (kernel, count, build) = row(line).ok_or(index + 1)?;
            let counts = counts.get_or_insert(Self {
                build: build.clone(),
                kernels: Vec::new(),
            });
            if counts.build != build {
                return Err(index + 1);
            }
            counts.kernels.push((kernel, count));
        }
        counts.ok_or(0)
    }

    /// Compares with what was recorded.
    pub fn compare(&self, recorded: &Self) -> Comparison {
        let mut table = String::from(
            "| kernel | instructions per tetrahedron | recorded | difference |\n|---|---|---|---|\n",
        );
        let mut beyond = Vec::new();
        let of = |counts: &Self, kernel: &str| {
            let found = counts.kernels.iter().find(|(name, _)| name == kernel);
            found.map(|(_, count)| *count)
        };
        for (kernel, count) in &self.kernels {
            let Some(before) = of(recorded, kernel) else {
                let _ = writeln!(table, "| {kernel} | {count:.1} | – | – |");
                beyond.push(format!("{kernel}: not recorded"));
                continue;
            };
            let change = count / before - 1.0;
            let _ = writeln!(
                table,
                "| {kernel} | {count:.1} | {before:.1} | {:+.2} % |",
                100.0 * change
            );
            // What is no number is beyond, too.
            if change.is_nan() || change.abs() > MARGIN {
                let percent = 100.0 * change;
                beyond.push(format!("{kernel}: {percent:+.2} % instructions"));
            }
        }
        for (kernel, _) in &recorded.kernels {
            if of(self, kernel).is_none() {
                beyond.push(format!("{kernel}: recorded and no more there"));
            }
        }
        Comparison {
            table,
            beyond,
            same_build: self.build == recorded.build,
        }
    }
}

/// The number of instructions that callgrind prints on standard error.
pub fn collected(callgrind: &str) -> Option<u64> {
    let line = callgrind.lines().find_map(|line| {
        let (_, after) = line.split_once("Collected :")?;
        Some(after)
    })?;
    line.trim().parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn counts(kernels: &[(&str, f64)]) -> Counts {
        let named = kernels.iter().map(|(name, count)| ((*name).into(), *count));
        Counts {
            build: "rustc 1.95.0 (5980 2026-04-14), AVX2".into(),
            kernels: named.collect(),
        }
    }

    /// A check that nothing fails would be none.
    #[test]
    fn a_count_beyond_the_margin_is_named() {
        let recorded = counts(&[("forces, springs", 100.0), ("factor", 2000.0)]);
        let within = counts(&[("forces, springs", 101.6), ("factor", 1967.0)]);
        assert_eq!(within.compare(&recorded).beyond, Vec::<String>::new());
        for (changed, printed) in [
            ([101.8, 2000.0], "forces, springs: +1.80 %"),
            ([98.2, 2000.0], "forces, springs: -1.80 %"),
            ([100.0, 2035.0], "factor: +1.75 %"),
            ([100.0, f64::NAN], "factor: "),
        ] {
            let now = counts(&[("forces, springs", changed[0]), ("factor", changed[1])]);
            let beyond = now.compare(&recorded).beyond;
            assert!(
                beyond.len() == 1 && beyond[0].starts_with(printed),
                "{beyond:?}"
            );
        }
        let others = counts(&[("factor", 2000.0), ("solve", 50.0)]);
        assert_eq!(
            others.compare(&recorded).beyond,
            [
                "solve: not recorded",
                "forces, springs: recorded and no more there"
            ]
        );
    }

    #[test]
    fn another_build_is_told_apart() {
        let recorded = counts(&[("factor", 2000.0)]);
        assert!(recorded.compare(&recorded).same_build);
        let other = Counts {
            build: "rustc 1.96.0".into(),
            ..recorded.clone()
        };
        assert!(!other.compare(&recorded).same_build);
    }

    #[test]
    fn a_table_comes_back_and_a_damaged_one_does_not() {
        let table = counts(&[("forces, springs", 100.5), ("factor", 2000.0)]);
        let csv = table.to_csv();
        assert_eq!(Counts::from_csv(&csv), Ok(table));
        assert_eq!(Counts::from_csv(""), Err(1));
        assert_eq!(Counts::from_csv(Counts::HEAD), Err(0));
        for (from, to, line) in [
            ("100.5", "many", 2),
            ("100.5", "0", 2),
            ("\"factor", "factor", 3),
            ("kernel,", "core,", 1),
        ] {
            assert_eq!(Counts::from_csv(&csv.replace(from, to)), Err(line), "{to}");
        }
        let builds = csv.replacen("rustc 1.95.0", "rustc 1.94.0", 1);
        assert_eq!(Counts::from_csv(&builds), Err(3));
    }

    /// As valgrind 3.19 prints it.
    #[test]
    fn callgrind_is_understood() {
        let printed = "==7== Events    : Ir\n==7== Collected : 35791894\n==7== \n==7== I   refs:      35,791,894\n";
        assert_eq!(collected(printed), Some(35_791_894));
        assert_eq!(collected("valgrind: no such program"), None);
    }
}
