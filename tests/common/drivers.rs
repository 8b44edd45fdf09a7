//! Drivers beside the system's own, and the program run on a driver.

// Each test program uses its own part of this; a panic is a test's failure report.
#![allow(dead_code, clippy::unwrap_used)]

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// The manifest of the system's lavapipe.
pub fn lavapipe() -> PathBuf {
    let folders = ["/usr/share/vulkan/icd.d", "/usr/local/share/vulkan/icd.d", "/etc/vulkan/icd.d"];
    manifest_in(&folders, "lvp_icd").expect("these tests need lavapipe: ./whitted.sh setup brings it")
}

/// The manifest of SwiftShader, which comes with Chromium; `WHITTED_SWIFTSHADER` names another place.
pub fn swift_shader() -> PathBuf {
    if let Some(file) = std::env::var_os("WHITTED_SWIFTSHADER").filter(|file| !file.is_empty()) {
        return file.into();
    }
    let folders = ["/usr/lib/chromium", "/usr/lib/chromium-browser", "/opt/google/chrome"];
    manifest_in(&folders, "vk_swiftshader_icd")
        .expect("these tests need SwiftShader: ./whitted.sh setup brings it with the package chromium")
}

/// The first file of these folders that begins like this and ends in `.json`.
fn manifest_in(folders: &[&str], begin: &str) -> Option<PathBuf> {
    let files = folders.iter().flat_map(|folder| std::fs::read_dir(folder).into_iter().flatten().flatten());
    let mut found: Vec<PathBuf> = files
        .map(|entry| entry.path())
        .filter(|path| {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            name.starts_with(begin) && name.ends_with(".json")
        })
        .collect();
    found.sort();
    found.into_iter().next()
}

/// Driver files as `VK_DRIVER_FILES` lists them.
pub fn list(files: &[&Path]) -> String {
    std::env::join_paths(files).unwrap().into_string().unwrap()
}

/// The program, with these drivers alone, and caches under `cache`.
pub fn whitted(drivers: &[&Path], cache: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_whitted"));
    command
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .env("VK_DRIVER_FILES", list(drivers))
        .env("XDG_CACHE_HOME", cache);
    for variable in [
        "WHITTED_DEVICE",
        "VK_ICD_FILENAMES",
        "VK_ADD_DRIVER_FILES",
        "LP_NATIVE_VECTOR_WIDTH",
        "MESA_SHADER_CACHE_DIR",
        "MESA_SHADER_CACHE_DISABLE",
    ] {
        command.env_remove(variable);
    }
    command
}

/// What a command wrote to both streams.
pub fn both(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr)
}
