//! Compiles the kernels with shaderc, marks their arithmetic, and optimises them with `spirv-opt`.

use crate::pack::Compiled;
use crate::sources::{LIBRARY, OPTIMISER, Source, abi_glsl};
use crate::{defects, spirv, text_of};
use std::path::Path;
use std::{env, fs, process};

/// Compiles every form of every kernel; `planted`: with all planted mistakes, each behind its value of one more
/// specialisation constant. Modules are read before the optimiser takes their names away.
pub fn all(kernels: &[Source], planted: bool) -> Result<Vec<Compiled>, String> {
    if planted && let Some(edit) = defects::EDITS.iter().find(|e| !is_source(e.file)) {
        return Err(format!("src/kernel/defects.rs, {:?}: there is no file {}", edit.defect, edit.file));
    }
    let compiler = shaderc::Compiler::new().map_err(|e| format!("shaderc: {e}"))?;
    let mut compiled = Vec::new();
    for kernel in kernels {
        for form in kernel.forms() {
            let plain = compile(&compiler, kernel, &abi_glsl(form), planted)?;
            let module = spirv::read(&plain).map_err(|e| format!("{}: {e}", kernel.path.display()))?;
            let words = optimise(&plain)?;
            compiled.push(Compiled {
                kernel: kernel.name.clone(),
                form: form.name.to_owned(),
                module,
                words,
            });
        }
    }
    Ok(compiled)
}

/// Versions of what makes the bytes: equal tools and equal sources give equal kernels.
pub fn tools() -> String {
    let spirv = shaderc::get_spirv_version();
    let optimiser = process::Command::new("spirv-opt").arg("--version").output();
    // Version 2023.1 writes it to standard error.
    let text = optimiser.map(|out| String::from_utf8_lossy(&[out.stdout, out.stderr].concat()).into_owned());
    let version = text.as_deref().ok().and_then(|text| text.lines().next()).unwrap_or("no spirv-opt");
    format!("SPIR-V {:#x} revision {}, {}", spirv.0, spirv.1, version.trim())
}

/// Whether a kernel or a library file has this name.
fn is_source(name: &str) -> bool {
    let folders = LIBRARY.iter().map(|folder| format!("glsl/lib/{folder}"));
    folders.chain(["glsl".to_owned()]).any(|folder| Path::new(&folder).join(name).exists())
}

/// The text of a GLSL file.
fn text(path: &Path, planted: bool) -> Result<String, String> {
    let text = text_of(path)?;
    match path.file_name().and_then(|name| name.to_str()) {
        Some(name) if planted => defects::plant(name, &text),
        _ => Ok(text),
    }
}

fn compile(
    compiler: &shaderc::Compiler,
    kernel: &Source,
    abi_glsl: &str,
    planted: bool,
) -> Result<Vec<u32>, String> {
    let source = text(&kernel.path, planted)?;
    let choice = format!("layout(constant_id = {}) const uint defect = 0u;\n", defects::ID);
    let abi_glsl = if planted { abi_glsl.to_owned() + &choice } else { abi_glsl.to_owned() };
    let mut options = shaderc::CompileOptions::new().map_err(|e| e.to_string())?;
    options.set_target_env(shaderc::TargetEnv::Vulkan, shaderc::EnvVersion::Vulkan1_2 as u32);
    options.set_warnings_as_errors();
    // Names of structs and members survive only with debug information; the layout check needs them.
    options.set_generate_debug_info();
    options.set_optimization_level(shaderc::OptimizationLevel::Zero);
    options.set_include_callback(|requested, _, _, _| {
        if requested == "abi.glsl" {
            return Ok(shaderc::ResolvedInclude {
                resolved_name: requested.into(),
                content: abi_glsl.clone(),
            });
        }
        let file = Path::new("glsl/lib").join(requested);
        Ok(shaderc::ResolvedInclude {
            resolved_name: file.display().to_string(),
            content: text(&file, planted)?,
        })
    });
    let path = kernel.path.display().to_string();
    let artifact = compiler
        .compile_into_spirv(&source, shaderc::ShaderKind::Compute, &path, "main", Some(&options))
        .map_err(|e| e.to_string())?;
    Ok(spirv::forbid_contraction(artifact.as_binary()))
}

/// Inlines and folds what can be folded before specialisation: drivers take a third of the time over such a
/// kernel. Without `spirv-opt` the kernels stay as they are: slower to start, the same bits.
fn optimise(words: &[u32]) -> Result<Vec<u32>, String> {
    let file = Path::new(&env::var("OUT_DIR").map_err(|e| e.to_string())?).join("optimised.spv");
    fs::write(&file, bytemuck::cast_slice(words)).map_err(|e| format!("{}: {e}", file.display()))?;
    let run = process::Command::new("spirv-opt").args(OPTIMISER).arg("-o").args([&file, &file]).output();
    match run {
        Ok(out) if out.status.success() => {
            let bytes = fs::read(&file).map_err(|e| format!("{}: {e}", file.display()))?;
            let _ = fs::remove_file(&file);
            Ok(bytes.as_chunks::<4>().0.iter().map(|word| u32::from_le_bytes(*word)).collect())
        }
        Ok(out) => Err(format!("spirv-opt: {}", String::from_utf8_lossy(&out.stderr))),
        Err(_) => {
            println!("cargo:warning=no spirv-opt (package spirv-tools): programs will start slower");
            Ok(words.to_vec())
        }
    }
}
