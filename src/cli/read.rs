//! Reads scenes for the commands, and says what was assumed.

use super::args::{ReadArgs, Size};
use super::console::Console;
use super::failure::Failure;
use crate::scene::{Notes, Scene, is_model, utf8};
use crate::units::plural;
use anyhow::Context;
use std::io::{self, Read};
use std::path::Path;
use std::sync::OnceLock;

/// Kinds of notes that are printed; the report has all.
const KINDS: usize = 12;

/// Reads the scene or model `path` and prints its notes, unless the console is quiet. `-` is a scene's text on standard
/// input. A model is framed for an image of `size`.
pub(crate) fn scene(
    path: &Path,
    args: &ReadArgs,
    size: Option<Size>,
    console: &mut Console,
) -> Result<Scene, Failure> {
    let scene = read(path, args, size)?;
    say(&scene.notes, console);
    Ok(scene)
}

/// Reads a scene or model without printing anything.
pub(crate) fn silently(path: &Path, args: &ReadArgs) -> Result<Scene, Failure> {
    read(path, args, None)
}

fn read(path: &Path, args: &ReadArgs, size: Option<Size>) -> Result<Scene, Failure> {
    if args.up.is_some() && !is_model(path) {
        return Err(Failure::Usage("--up is for models: the camera of a scene says `up`".into()));
    }
    let options = args.options(size);
    Ok(match path.as_os_str() == "-" {
        true => Scene::parse_with(utf8(input()?, path)?, path, &options),
        false => Scene::load_with(path, &options),
    }?)
}

/// Standard input to its end; read once, so that every frame of a batch finds it.
fn input() -> Result<&'static [u8], Failure> {
    static INPUT: OnceLock<Vec<u8>> = OnceLock::new();
    if INPUT.get().is_none() {
        let mut bytes = Vec::new();
        io::stdin().lock().read_to_end(&mut bytes).context("cannot read the scene from standard input")?;
        let _ = INPUT.set(bytes);
    }
    Ok(INPUT.get().map_or(&[], Vec::as_slice))
}

/// One line for each of the first kinds, and one for the others.
fn say(notes: &Notes, console: &mut Console) {
    notes.iter().take(KINDS).for_each(|note| console.say(&format!("assumed: {note}")));
    let more = notes.iter().count().saturating_sub(KINDS) as u64;
    if more > 0 {
        console.say(&format!("assumed: {} more; `--report` lists all", plural(more, "kind")));
    }
}
