//! Figures in READMEs are those of the levels and of the pages of results that they are taken from.

use super::{assert_none, text};
use microsim_tests::repository;

/// The text of a file of the repository, with single blanks.
fn words(file: &str) -> String {
    let text = text(&repository().join(file));
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// `[tuned]` of a level.
fn tuned(module: &str, level: u32) -> toml::Table {
    let file = repository().join(format!("modules/{module}/levels/level{level}.toml"));
    let level: toml::Table = text(&file).parse().expect("TOML");
    level["tuned"].as_table().expect("a table").clone()
}

/// A number of `[tuned]` of some levels.
fn numbers(module: &str, levels: &[u32], key: &str) -> Vec<f64> {
    let number = |level: &u32| tuned(module, *level)[key].as_float().expect("a number");
    levels.iter().map(number).collect()
}

/// In per cent, with two digits.
fn percent(fraction: f64) -> String {
    let percent = 100.0 * fraction;
    match percent < 9.95 {
        true => format!("{percent:.1}"),
        false => format!("{percent:.0}"),
    }
}

/// The smallest and the largest.
fn range(numbers: &[f64]) -> [f64; 2] {
    let [low, high] = [f64::min, f64::max].map(|of| numbers.iter().copied().reduce(of));
    [low.expect("a number"), high.expect("a number")]
}

/// Rows of tables of a page, the first table's first.
fn rows(page: &str) -> Vec<Vec<String>> {
    let page = text(&repository().join("tests/results").join(page));
    let lines = page.lines().filter(|line| line.starts_with("| "));
    let cells = |line: &str| {
        line.trim_matches('|')
            .split('|')
            .map(str::trim)
            .map(str::to_owned)
            .collect()
    };
    lines.map(cells).collect()
}

/// The first number of a cell.
fn number(cell: &str) -> f64 {
    let from = cell.find(|c: char| c.is_ascii_digit()).expect("a number");
    let digits = cell[from..]
        .chars()
        .take_while(|c| c.is_ascii_digit() || *c == '.');
    digits.collect::<String>().parse().expect("a number")
}

/// The sentences with the figures of today, and the file that must have them.
fn expected() -> Vec<(&'static str, String)> {
    let coordination =
        |levels: &[u32], key| range(&numbers("coordination", levels, key)).map(percent);
    let [least, most] = coordination(&[1, 3, 4, 5, 6], "error");
    let [stiff, _] = coordination(&[2], "error");
    let [locking_least, locking_most] = coordination(&[1, 2, 3, 4, 5, 6], "locking");
    let of_coordination = format!(
        "within {least} to {most} % of an exact solution on a very fine mesh, that of the stiff one of level 2 within {stiff} %; linear tetrahedra \
         would be off by {locking_least} to {locking_most} %."
    );
    let push_strip = |levels: &[u32], key| percent(range(&numbers("push-strip", levels, key))[1]);
    let of_push_strip = format!(
        "within {} % (levels 1 and 2, by a measure that is itself off by up to {} %), {} % (level 3) and {} % (level 4) of an exact solution on a very \
         fine mesh; linear tetrahedra would be off by {}, {} and {} %",
        push_strip(&[1, 2], "error"),
        push_strip(&[1, 2], "doubt"),
        push_strip(&[3], "error"),
        push_strip(&[4], "error"),
        push_strip(&[1, 2], "locking"),
        push_strip(&[3], "locking"),
        push_strip(&[4], "locking"),
    );

    let bench = rows("bench_coordination.md");
    let columns = bench.iter().find(|row| row[0] == "level").expect("a table");
    let column = |name: &str| {
        let at = columns.iter().position(|column| column == name);
        let at = at.unwrap_or_else(|| panic!("no column {name}"));
        let levels = bench.iter().filter(|row| row[0].parse::<u32>().is_ok());
        levels.map(|row| number(&row[at])).collect::<Vec<_>>()
    };
    let [slowest, _] = range(&column("real-time factor"));
    let [_, p99] = range(&column("CPU p99 [ms]"));
    let [_, longest] = range(&column("CPU most [ms]"));
    let beyond = column("CPU p99 [ms]");
    let beyond: Vec<String> = (1..=beyond.len())
        .filter(|level| beyond[level - 1] > 11.0)
        .map(|level| level.to_string())
        .collect();
    let cost = format!(
        "All levels run {} and more times faster than real time on one core. Of 16 ms in a picture the computation should take 11 ms at most; in 99 of 100 \
         pictures it takes {p99:.1} ms or less in every level ([bench_coordination.md](../../tests/results/bench_coordination.md)). Levels {} do not \
         hold the 11 ms on the machine that was measured; the longest single picture took {longest:.0} ms.",
        slowest.floor(),
        beyond.join(", ")
    );

    let solvers = rows("bench_solvers.md");
    let pulled = solvers
        .iter()
        .find(|row| row[..3] == ["patch-pressure", "quasi-static", "1"]);
    let vessel = format!(
        "takes {:.1} ms per picture of 16 ms while it is pulled",
        number(&pulled.expect("a row")[6])
    );

    let peers = rows("peers.md");
    let peer = |name: &str| {
        let row = peers.iter().find(|row| row[0] == name).expect("a row");
        row[1..4]
            .iter()
            .map(|cell| number(cell))
            .collect::<Vec<_>>()
    };
    let ours = peer("ours");
    let [less, more] = range(&peer("cheapest other engine / ours"));
    let beam = format!(
        "On one core a beam of 10,290 tetrahedra swings {:.1} times faster than real time",
        1.0 / ours[1]
    );
    let large = format!(
        "one of 51,840 takes {:.1} s per second; that is {less:.0} to {more:.0} times less",
        ours[2]
    );

    let cutting = rows("cutting.md");
    let floored = cutting.iter().filter(|row| row[1] == "floor");
    let inertia: Vec<f64> = floored.map(|row| number(&row[4])).collect();
    let [least, most] = range(&inertia);
    let inertia =
        format!("After 500 cuts in one cube that was {least:.0} to {most:.0} % of its inertia");
    vec![
        ("modules/coordination/README.md", of_coordination),
        ("modules/coordination/README.md", cost),
        ("modules/push-strip/README.md", of_push_strip),
        ("README.md", beam),
        ("README.md", large),
        ("README.md", vessel),
        ("README.md", inertia),
    ]
}

#[test]
fn readmes_have_the_figures_of_levels_and_pages() {
    let missing = expected()
        .into_iter()
        .filter(|(file, sentence)| !words(file).contains(sentence));
    let complaints: Vec<_> = missing
        .map(|(file, sentence)| format!("{file}: expected \"{sentence}\""))
        .collect();
    assert_none(&complaints);
}
