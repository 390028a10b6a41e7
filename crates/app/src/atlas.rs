//! `microsim atlas`: where the methods fail, and what helps, as CSV, Markdown, SVG and one HTML page.

use crate::chart::{machine, thread_seconds};
use crate::cli::AtlasArgs;
use crate::output::{Exit, Problem, print, print_json};
use crate::progress::shown_while;
use crate::table_rows::table_rows;
use microsim_settings::unwritable;
use microsim_study::PageInfo;
use microsim_study::atlas::{Atlas, Extent};
use serde_json::{Map, json};
use std::time::Instant;

/// Makes the atlas.
pub fn atlas(args: &AtlasArgs) -> Result<Exit, Problem> {
    let start = Instant::now();
    std::fs::create_dir_all(&args.out).map_err(|e| unwritable(&args.out, e))?;
    let extent = if args.short {
        Extent::Short
    } else {
        Extent::Full
    };
    let atlas = shown_while(|progress| Atlas::make(extent, &thread_seconds, progress));
    let info = PageInfo {
        machine: machine(),
        command: format!("microsim atlas{}", if args.short { " --quick" } else { "" }),
        date: args.date.clone(),
        ..PageInfo::default()
    };
    let mut files = vec![
        ("atlas.html".to_owned(), atlas.to_html(&info)),
        ("atlas.md".to_owned(), atlas.to_markdown(&info)),
    ];
    files.extend(
        atlas
            .to_csv()
            .into_iter()
            .map(|(name, text)| (name.to_owned(), text)),
    );
    let figures = atlas.figures().into_iter();
    files.extend(figures.map(|figure| (format!("{}.svg", figure.name), figure.to_svg(true))));
    for (name, text) in files {
        let path = args.out.join(name);
        std::fs::write(&path, text).map_err(|e| unwritable(&path, e))?;
    }
    if args.json {
        let mut tables = Map::new();
        for (name, text) in atlas.to_csv() {
            let name = name.trim_end_matches(".csv");
            tables.insert(name.into(), table_rows(&text)?.into());
        }
        print_json(&json!({
            "command": info.command,
            "machine": info.machine,
            "seconds": start.elapsed().as_secs_f64(),
            "page": args.out.join("atlas.html"),
            "findings": atlas.findings(),
            "tables": tables,
        }))?;
        return Ok(Exit::Done);
    }
    for sentence in atlas.findings() {
        print(sentence)?;
    }
    let page = args.out.join("atlas.html");
    print(format!(
        "{} after {:.0} s",
        page.display(),
        start.elapsed().as_secs_f64()
    ))?;
    Ok(Exit::Done)
}
