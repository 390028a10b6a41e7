//! Plugins in a process of their own, without an installation: this program is host, and guest where it is called with `guest`.

use abi_stable::std_types::{ROption, RSlice};
use microsim_abi::Call;
use microsim_host::guest::{Guest, GuestRules, serve};
use microsim_message::{Setup, encode};
use std::path::PathBuf;
use std::process::Command;
use std::time::{Duration, Instant};

const MANIFEST: &str = "name = \"awkward\"\nkind = \"module\"\n";
/// Tick in which the plugin ends its process.
const TICK: u64 = 20;
/// What ends a process, and the sentence about it.
const ENDS: [(&str, &str); 5] = [
    ("segfault", "its process was ended by the signal SIGSEGV"),
    ("abort", "its process was ended by the signal SIGABRT"),
    ("exit", "its process ended by itself, with exit status 0"),
    (
        "loop",
        "its process gave no answer within 800 ms and was killed",
    ),
    (
        "allocate",
        "its process ran into its memory limit of 256 MiB",
    ),
];

fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    match words.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["guest"] => serve().expect("the host asks"),
        ["case", library] => case(library.into()),
        _ => {
            for (how, said) in ENDS {
                ends(how, said);
            }
            println!("{} ways to end are named", ENDS.len());
        }
    }
}

/// The library of the awkward plugin, which cargo has built for this test.
fn library() -> PathBuf {
    let own = std::env::current_exe().expect("a running test has a file");
    let name = format!(
        "{}microsim_fixture_awkward{}",
        std::env::consts::DLL_PREFIX,
        std::env::consts::DLL_SUFFIX
    );
    own.with_file_name(name)
}

/// In a process with the environment that steers the plugin: runs it until it ends, and prints when, why and after how long.
fn case(library: PathBuf) {
    let rules = GuestRules {
        program: std::env::current_exe().expect("a running test has a file"),
        deadline: Some(Duration::from_millis(800)),
        memory: Some(256 << 20),
        silent: false,
    };
    let guest = Guest::start("awkward", &library, MANIFEST, &rules).expect("it starts");
    let ended = guest.ended();
    let mut plugin = guest.into_plugin();
    let setup = encode(&Setup {
        name: "awkward".into(),
        seed: 1,
        tick_ns: 8_000_000,
        steps: 1,
        level: 1,
        config: serde_json::Value::Null,
        files: Vec::new(),
    });
    let started = plugin.initialise(RSlice::from_slice(&setup), ROption::RNone);
    started.into_result().expect("it starts");
    for tick in 0.. {
        let call = Call {
            tick,
            time_ns: (tick + 1) * 8_000_000,
            tick_ns: 8_000_000,
            steps: 1,
            messages: RSlice::from_slice(&[]),
            blocks: RSlice::from_slice(&[]),
        };
        let begun = Instant::now();
        if let Err(fault) = plugin.process(call).into_result() {
            let ended = ended.load(std::sync::atomic::Ordering::Relaxed);
            println!(
                "{tick} {ended} {} {}",
                begun.elapsed().as_millis(),
                fault.text
            );
            return;
        }
    }
}

/// A guest that ends like this is named within a second or two, and the host goes on.
fn ends(how: &str, said: &str) {
    let own = std::env::current_exe().expect("a running test has a file");
    let folder = std::env::temp_dir().join(format!("microsim-guest-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    let manifest = folder.join("module.toml");
    std::fs::write(&manifest, MANIFEST).expect("a manifest");
    let output = Command::new(own)
        .arg("case")
        .arg(library())
        .env("MICROSIM_AWKWARD", format!("{how} process {TICK}"))
        .env("MICROSIM_AWKWARD_MANIFEST", &manifest)
        .output()
        .expect("the case runs");
    std::fs::remove_dir_all(&folder).expect("removed");
    let printed = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{how}: {output:?}");
    let mut words = printed.splitn(4, ' ');
    let mut word = || words.next().unwrap_or_default();
    assert_eq!((word(), word()), ("20", "true"), "{how}: {printed}");
    let took: u64 = word().parse().expect("a time");
    // A second on a machine that does nothing else; tests share theirs.
    assert!(took < 3000, "{how}: {printed}");
    assert!(word().starts_with(said), "{how}: {printed}");
    println!("{how}: named after {took} ms");
}
