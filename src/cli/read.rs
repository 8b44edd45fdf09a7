//! Reads scenes for the commands, and says what was assumed.

use super::args::ReadArgs;
use super::console::Console;
use super::failure::Failure;
use crate::scene::Scene;
use std::path::Path;

/// Reads the scene `path` and prints its notes, unless the console is quiet.
pub(crate) fn scene(path: &Path, args: &ReadArgs, console: &mut Console) -> Result<Scene, Failure> {
    let scene = Scene::load_with(path, &args.options())?;
    for note in scene.notes.iter() {
        console.say(&format!("note: {note}"));
    }
    Ok(scene)
}
