//! `microsim doctor`.

use crate::check::libraries;
use crate::cli::Place;
use crate::output::{Exit, Problem, print};
use crate::processor;
use crate::session_file::installation;
use crate::station;
use microsim_host::assemble::probe_renderer;
use microsim_settings::unwritable;

/// Prints what this machine has and lacks. Only what keeps runs from working makes the answer negative.
pub fn doctor(place: &Place) -> Result<Exit, Problem> {
    let mut healthy = true;
    print(format!("version        {}", env!("CARGO_PKG_VERSION")))?;
    let installation = installation(place)?;
    print(format!("installation   {}", installation.root.display()))?;
    let (plugins, modules) = (
        installation.tree.plugins.len(),
        installation.tree.modules.len(),
    );
    print(format!(
        "found          {modules} modules, {plugins} plugins"
    ))?;
    for complaint in &installation.complaints {
        healthy = false;
        print(format!("  problem      {complaint}"))?;
    }
    let problems: Vec<String> = libraries(&installation)
        .into_iter()
        .filter_map(|(_, checked)| checked.err())
        .collect();
    if problems.is_empty() {
        print("libraries      all can be opened")?;
    }
    for problem in problems {
        healthy = false;
        print(format!("  problem      {problem}"))?;
    }
    let cores = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    print(format!("processors     {cores}"))?;
    // Had it lacked one, the program would have ended before.
    match processor::used_names().as_str() {
        "" => print("instructions   those of every such processor; without FMA solvers are slow")?,
        names => print(format!("instructions   {names}: the processor has them"))?,
    }
    let folder = crate::run::session_folder(&installation);
    let writable = std::fs::create_dir_all(&folder).and_then(|()| {
        let probe = folder.join(format!(".doctor-{}", std::process::id()));
        std::fs::write(&probe, b"")?;
        std::fs::remove_file(&probe)
    });
    match writable {
        Ok(()) => print(format!("sessions       {} (writable)", folder.display()))?,
        Err(error) => {
            healthy = false;
            print(format!("sessions       {}", unwritable(&folder, error)))?;
        }
    }
    match station::path(place).and_then(|path| Ok((station::this(place)?, path))) {
        Ok((Some(this), path)) => print(format!("station        {this} ({})", path.display()))?,
        Ok((None, path)) => print(format!(
            "station        no key yet; the first run makes {}",
            path.display()
        ))?,
        Err(why) => {
            healthy = false;
            print(format!("station        sessions are not signed: {why}"))?;
        }
    }
    match probe_renderer(&installation) {
        Ok(()) => print("pictures       on")?,
        Err(reason) => print(format!("pictures       off: {reason}"))?,
    }
    Ok(if healthy { Exit::Done } else { Exit::Negative })
}
