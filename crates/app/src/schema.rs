//! `microsim schema`.

use crate::cli::{Place, SchemaArgs};
use crate::output::{Exit, Problem, print, print_json};
use crate::session_file::installation;
use microsim_settings as settings;

/// The JSON Schema of a kind of file, or the list of kinds.
pub fn schema(place: &Place, args: &SchemaArgs) -> Result<Exit, Problem> {
    let Some(kind) = &args.kind else {
        for (kind, doc) in settings::KINDS {
            print(format!("{kind:<12} {doc}"))?;
        }
        print("level:MODULE as level, with the keys of that module")?;
        return Ok(Exit::Done);
    };
    let schema = match kind.split_once(':') {
        Some(("level", module)) => {
            let installation = installation(place)?;
            Some(settings::level_schema(Some(
                &installation.module(module)?.manifest.settings,
            )))
        }
        _ => settings::schema_for(kind),
    };
    let Some(schema) = schema else {
        let kinds: Vec<&str> = settings::KINDS.iter().map(|(name, _)| *name).collect();
        return Err(format!(
            "no kind of file \"{kind}\"; there are: {}, level:MODULE",
            kinds.join(", ")
        )
        .into());
    };
    if args.markdown {
        print(settings::reference(&schema))?;
    } else {
        print_json(&settings::json_schema(&schema))?;
    }
    Ok(Exit::Done)
}
