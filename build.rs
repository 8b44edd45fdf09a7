//! Compiles `glsl/*.comp` to SPIR-V, checks it against `src/kernel/abi.rs`, and writes the typed kernel
//! table `kernels.rs`. With the feature `defects`, the same once more in the folder `defects` from
//! sources with planted mistakes (`src/kernel/defects.rs`).

#[path = "src/kernel/abi.rs"]
#[allow(dead_code, unused_imports)]
mod abi;
#[path = "src/kernel/defects.rs"]
#[allow(dead_code)]
mod defects;
#[path = "src/kernel/spirv.rs"]
#[allow(dead_code)]
mod spirv;

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::{env, fs, process};

fn main() {
    println!("cargo:rerun-if-changed=src/kernel/abi.rs");
    println!("cargo:rerun-if-changed=src/kernel/defects.rs");
    println!("cargo:rerun-if-changed=src/kernel/spirv.rs");
    println!("cargo:rerun-if-changed=glsl");
    // The log of HEAD grows with every commit, HEAD itself only changes with the branch.
    if Path::new(".git/logs/HEAD").exists() {
        println!("cargo:rerun-if-changed=.git/logs/HEAD");
    }
    if let Ok(out) = process::Command::new("git").args(["rev-parse", "--short=12", "HEAD"]).output()
        && out.status.success()
    {
        println!("cargo:rustc-env=WHITTED_GIT={}", String::from_utf8_lossy(&out.stdout).trim());
    }
    if let Err(message) = compile_all() {
        eprintln!("{message}");
        process::exit(1);
    }
}

fn compile_all() -> Result<(), String> {
    let out = PathBuf::from(env::var("OUT_DIR").map_err(|e| e.to_string())?);
    compile_set(&out, false)?;
    if env::var_os("CARGO_FEATURE_DEFECTS").is_none() {
        return Ok(());
    }
    let out = out.join("defects");
    fs::create_dir_all(&out).map_err(|e| format!("{}: {e}", out.display()))?;
    compile_set(&out, true)
}

/// Kernels in which subgroups count together: in the form `packet` alone.
const JOINED: [&str; 2] = ["place", "trace"];

/// Compiles all kernels into `out`, as they are or with every planted mistake to choose from.
fn compile_set(out: &Path, planted: bool) -> Result<(), String> {
    let mut kernels: Vec<PathBuf> = fs::read_dir("glsl")
        .map_err(|e| format!("glsl: {e}"))?
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| path.extension().is_some_and(|e| e == "comp"))
        .collect();
    kernels.sort();
    let compiler = shaderc::Compiler::new().map_err(|e| format!("shaderc: {e}"))?;
    let precisions =
        [("f32", "float", "vec3", abi::single::STRUCTS), ("f64", "double", "dvec3", abi::double::STRUCTS)];

    let mut table = String::new();
    let mut variants = String::new();
    for path in &kernels {
        let name = path.file_stem().and_then(|s| s.to_str()).ok_or("kernel file name is not UTF-8")?;
        let mut accesses = Vec::new();
        let mut files = Vec::new();
        let mut texels = 0u64;
        // Kernels that test shapes have one form more, in which the lanes of a subgroup work together.
        let source = fs::read_to_string(path).map_err(|e| format!("{}: {e}", path.display()))?;
        let traces = source.contains("traverse/traverse.glsl");
        let packet = ("packet", "float", "vec3", abi::single::STRUCTS);
        let joined = JOINED.contains(&name);
        let forms =
            precisions.into_iter().filter(|_| !joined).chain(Some(packet).filter(|_| traces || joined));
        for (suffix, real, real3, structs) in forms {
            let words = compile(&compiler, path, &abi_glsl(real, real3, structs, suffix), planted)?;
            let module = spirv::read(&words).map_err(|e| format!("{}: {e}", path.display()))?;
            check(name, &module, structs)?;
            let file = out.join(format!("{name}.{suffix}.spv"));
            fs::write(&file, bytemuck::cast_slice(&words)).map_err(|e| e.to_string())?;
            optimise(&file)?;
            files.push(file);
            accesses.push(module.bindings);
            module.texels.iter().for_each(|b| texels |= 1 << (b - abi::TEXELS_AT));
        }
        let (mut reads, mut writes) = (0u64, 0u64);
        for b in accesses.iter().flatten() {
            reads |= u64::from(b.reads) << b.binding;
            writes |= u64::from(b.writes) << b.binding;
        }
        if texels & !reads != 0 {
            return Err(format!("{name}: a texel view of a buffer that it does not read"));
        }
        let [single, double, packet] = [0, 1, 2].map(|i| files.get(i).unwrap_or(&files[0]));
        let variant = camel(name);
        let _ = writeln!(variants, "    /// `glsl/{name}.comp`.\n    {variant},");
        let _ = writeln!(
            table,
            "    KernelCode {{ name: {name:?}, single: Spirv(include_bytes!({single:?})), double: Spirv(include_bytes!({double:?})), packet: Spirv(include_bytes!({packet:?})), reads: {reads:#x}, writes: {writes:#x}, texels: {texels:#x} }},"
        );
    }
    let mut source = format!(
        "/// What was compiled, in the order of [`Kernel`].\n\
         pub const KERNELS: [KernelCode; {}] = [\n{table}];\n",
        kernels.len()
    );
    if !planted {
        let _ = write!(
            source,
            "\n/// The kernels, one per file in `glsl`, in alphabetical order.\n\
             #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]\npub enum Kernel {{\n{variants}}}\n"
        );
    }
    fs::write(out.join("kernels.rs"), source).map_err(|e| e.to_string())
}

fn camel(name: &str) -> String {
    name.split('_').map(|w| w[..1].to_uppercase() + &w[1..]).collect()
}

/// The shared declarations as GLSL, with macros READS(x), WRITES(x), UPDATES(x) that declare buffer x.
fn abi_glsl(real: &str, real3: &str, structs: &[abi::GpuStruct], form: &str) -> String {
    let mut text = String::new();
    if form == "packet" {
        for extension in ["basic", "shuffle"] {
            let _ = writeln!(text, "#extension GL_KHR_shader_subgroup_{extension} : require");
        }
        text.push_str("#define LANES\n");
    }
    let _ =
        writeln!(text, "#define real {real}\n#define real3 {real3}\n#define REAL_IS_{}", real.to_uppercase());
    for (name, value) in abi::CONSTANTS {
        let _ = writeln!(text, "#define {name} {value:#x}u");
    }
    for s in structs {
        text.push_str(s.glsl);
    }
    for (id, (name, default)) in abi::SPECIALISATION.iter().enumerate() {
        let _ = writeln!(text, "layout(constant_id = {id}) const uint {name} = {default}u;");
    }
    for (binding, (name, element, _)) in abi::BUFFERS.iter().enumerate() {
        let _ = writeln!(text, "#define BINDING_{name} {binding}\n#define ELEMENT_{name} {element}");
    }
    for (macro_name, access) in [("READS", "readonly "), ("WRITES", "writeonly "), ("UPDATES", "")] {
        let _ = writeln!(
            text,
            "#define {macro_name}(x) layout(scalar, set = 0, binding = BINDING_##x) {access}restrict buffer x##_block {{ ELEMENT_##x x[]; }};"
        );
    }
    // A view of the same buffer in texels of four words, for kernels in single precision.
    let _ = writeln!(
        text,
        "#define TEXELS(x) layout(set = 0, binding = TEXELS_AT + BINDING_##x) uniform usamplerBuffer x##_texels;"
    );
    text.push_str("layout(scalar, push_constant) uniform push_block { Push push; };\n");
    text
}

/// The text of a GLSL file.
fn read(path: &Path, planted: bool) -> Result<String, String> {
    let text = fs::read_to_string(path).map_err(|e| format!("{}: {e}", path.display()))?;
    match path.file_name().and_then(|name| name.to_str()) {
        Some(name) if planted => defects::plant(name, &text),
        _ => Ok(text),
    }
}

fn compile(
    compiler: &shaderc::Compiler,
    path: &Path,
    abi_glsl: &str,
    planted: bool,
) -> Result<Vec<u32>, String> {
    let source = read(path, planted)?;
    let mut abi_glsl = abi_glsl.to_owned();
    if planted {
        let _ = writeln!(abi_glsl, "layout(constant_id = {}) const uint defect = 0u;", defects::ID);
    }
    let mut options = shaderc::CompileOptions::new().map_err(|e| e.to_string())?;
    options.set_target_env(shaderc::TargetEnv::Vulkan, shaderc::EnvVersion::Vulkan1_2 as u32);
    options.set_warnings_as_errors();
    // Names of structs and members survive only with debug information; check_layout needs them.
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
        let content = read(&file, planted)?;
        Ok(shaderc::ResolvedInclude { resolved_name: file.display().to_string(), content })
    });
    let artifact = compiler
        .compile_into_spirv(
            &source,
            shaderc::ShaderKind::Compute,
            &path.display().to_string(),
            "main",
            Some(&options),
        )
        .map_err(|e| e.to_string())?;
    Ok(spirv::forbid_contraction(artifact.as_binary()))
}

/// Inlines and folds what can be folded before specialisation: drivers take a third of the time over such a
/// kernel. `spirv-opt` keeps its hands off float operations that carry NoContraction, which all do by now.
/// Where there is none the kernels stay as they are: slower to start, the same bits.
fn optimise(file: &Path) -> Result<(), String> {
    let run = process::Command::new("spirv-opt")
        .args(["--target-env=vulkan1.2", "--scalar-block-layout", "--strip-debug", "-O", "-o"])
        .args([file, file])
        .output();
    match run {
        Ok(out) if out.status.success() => Ok(()),
        Ok(out) => Err(format!("spirv-opt: {}: {}", file.display(), String::from_utf8_lossy(&out.stderr))),
        Err(_) => {
            println!("cargo:warning=no spirv-opt (package spirv-tools): programs will start slower");
            Ok(())
        }
    }
}

/// Every shared struct that the module stores in a buffer has the host's offsets; float arithmetic
/// cannot be contracted, and nothing with unstated rounding is used.
fn check(kernel: &str, module: &spirv::Module, structs: &[abi::GpuStruct]) -> Result<(), String> {
    for s in structs {
        let Some(found) = module.structs.get(s.name) else { continue };
        let wanted: Vec<(String, u32)> = s.fields.iter().map(|(n, o)| ((*n).to_owned(), *o as u32)).collect();
        if *found != wanted {
            return Err(format!("{kernel}: layout of {}: kernel has {found:?}, host has {wanted:?}", s.name));
        }
    }
    if module.contractible > 0 {
        return Err(format!("{kernel}: {} float operations lack NoContraction", module.contractible));
    }
    if !module.banned.is_empty() {
        return Err(format!("{kernel}: uses {}; write it out in scalars", module.banned.join(", ")));
    }
    Ok(())
}
