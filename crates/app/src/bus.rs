//! `microsim bus`.

use crate::cli::{BusArgs, Place};
use crate::output::{Exit, Problem, complain, print, print_json};
use crate::session_file::{find, installation, read};
use microsim_bus::{Frames, HOST, Overflow, kind_id};
use microsim_host::record::Session;
use microsim_message::{core_kinds, to_json};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::Path;
use std::time::Duration;

/// Pause between two looks at a file that is being written.
const FOLLOW: Duration = Duration::from_millis(200);

/// A file that has not grown for so long is not being written any more.
const GIVE_UP: Duration = Duration::from_secs(10);

/// What flows on the bus.
pub fn bus(place: &Place, args: &BusArgs) -> Result<Exit, Problem> {
    match &args.session {
        None => kinds(place, args),
        Some(session) => messages(&find(place, session), args),
    }
}

/// The kinds, and who publishes and receives them.
fn kinds(place: &Place, args: &BusArgs) -> Result<Exit, Problem> {
    let installation = installation(place)?;
    let manifests: Vec<_> = installation
        .tree
        .plugins
        .iter()
        .chain(installation.tree.modules.iter().map(|m| &m.manifest))
        .map(|m| &m.settings)
        .collect();
    let mut kinds: BTreeMap<String, (u32, bool)> = core_kinds()
        .into_iter()
        .map(|k| {
            (
                k.name,
                (u32::from(k.version), k.overflow == Overflow::DropOldest),
            )
        })
        .collect();
    for own in manifests.iter().flat_map(|m| &m.message) {
        let drops = own.overflow == Overflow::DropOldest;
        kinds.insert(own.name.clone(), (own.version, drops));
    }
    kinds.retain(|name, _| args.kind.as_ref().is_none_or(|wanted| wanted == name));
    let mut table = Vec::new();
    for (kind, (version, drops)) in &kinds {
        let who = |list: fn(&microsim_settings::Manifest) -> &Vec<String>| -> Vec<&str> {
            manifests
                .iter()
                .filter(|m| list(m).contains(kind))
                .map(|m| m.name.as_str())
                .collect()
        };
        table.push(json!({
            "kind": kind,
            "version": version,
            "when_full": if *drops { "drop-oldest" } else { "refuse" },
            "published_by": who(|m| &m.publishes),
            "heard_by": who(|m| &m.subscribes),
        }));
    }
    if args.json {
        print_json(&Value::Array(table))?;
        return Ok(Exit::Done);
    }
    let names = |list: &Value| {
        let names: Vec<&str> = list
            .as_array()
            .into_iter()
            .flatten()
            .filter_map(Value::as_str)
            .collect();
        if names.is_empty() {
            "-".to_owned()
        } else {
            names.join(", ")
        }
    };
    print(format!(
        "{:<20} {:>3}  {:<12} {:<44} received by",
        "kind", "v", "when full", "published by"
    ))?;
    for row in &table {
        print(format!(
            "{:<20} {:>3}  {:<12} {:<44} {}",
            row["kind"].as_str().unwrap_or_default(),
            row["version"],
            row["when_full"].as_str().unwrap_or_default(),
            names(&row["published_by"]),
            names(&row["heard_by"])
        ))?;
    }
    Ok(Exit::Done)
}

/// All messages of a session.
fn messages(path: &Path, args: &BusArgs) -> Result<Exit, Problem> {
    let (mut shown, mut size, mut quiet) = (0, 0, Duration::ZERO);
    loop {
        let session = read(path)?;
        let rows = rows(&session, args, shown);
        if args.json {
            print_json(&Value::Array(rows))?;
            return Ok(Exit::Done);
        }
        for row in &rows {
            print(format!(
                "{:>6} {:>10.3} s  {:<16} {:<18} {}",
                row["tick"],
                row["time"].as_f64().unwrap_or_default(),
                row["from"].as_str().unwrap_or_default(),
                row["kind"].as_str().unwrap_or_default(),
                row["message"]
            ))?;
        }
        shown = session.ticks.len() + usize::from(session.failed_tick.is_some());
        let grown = std::fs::metadata(path).map(|m| m.len()).unwrap_or_default();
        quiet = if grown == size {
            quiet + FOLLOW
        } else {
            Duration::ZERO
        };
        size = grown;
        let over = session.end.is_some() || session.damaged || quiet >= GIVE_UP;
        if !args.follow || over {
            if let Some(complaint) = &session.complaint {
                complain(complaint);
            }
            return Ok(Exit::Done);
        }
        std::thread::sleep(FOLLOW);
    }
}

fn rows(session: &Session, args: &BusArgs, skip: usize) -> Vec<Value> {
    let plan = &session.header.plan;
    let own = plan
        .plugins
        .iter()
        .flat_map(|p| p.own_kinds.iter().map(|k| k.name.clone()));
    let names: BTreeMap<u64, String> = core_kinds()
        .into_iter()
        .map(|k| k.name)
        .chain(own)
        .map(|name| (kind_id(&name), name))
        .collect();
    let senders: Vec<&str> = plan
        .plugins
        .iter()
        .filter(|p| !p.kind.is_observer())
        .map(|p| p.name.as_str())
        .collect();
    let mut rows = Vec::new();
    let ticks = session.ticks.iter().chain(&session.failed_tick);
    for (tick, record) in ticks.skip(skip) {
        for frame in Frames::new(&record.log).filter_map(Result::ok) {
            let kind = names.get(&frame.header.kind).cloned();
            let kind = kind.unwrap_or_else(|| format!("{:#018x}", frame.header.kind));
            let from = match frame.header.sender {
                HOST => "host",
                sender => senders.get(sender as usize).copied().unwrap_or("?"),
            };
            if args.kind.as_ref().is_some_and(|k| *k != kind)
                || args.from.as_ref().is_some_and(|f| f != from)
            {
                continue;
            }
            let message = to_json(frame.payload)
                .unwrap_or_else(|_| json!(format!("{} bytes", frame.payload.len())));
            rows.push(json!({
                "tick": tick,
                "time": frame.header.time_ns as f64 * 1e-9,
                "from": from,
                "kind": kind,
                "message": message,
            }));
        }
    }
    rows
}
