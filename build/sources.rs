//! The kernels' sources: the files under `glsl`, the shared declarations that each form sees, their digest.

use crate::{abi, text_of};
use sha2::{Digest as _, Sha256};
use std::fmt::Write as _;
use std::fs;
use std::path::PathBuf;

/// Kernels in which subgroups count together: in the form `packet` alone.
const JOINED: [&str; 2] = ["fused_depth", "place"];

/// Folders of `glsl/lib`.
pub const LIBRARY: [&str; 4] = ["base", "optics", "shape", "traverse"];

/// What `spirv-opt` is asked for. It leaves float operations alone that carry NoContraction, which all do.
pub const OPTIMISER: [&str; 4] = ["--target-env=vulkan1.2", "--scalar-block-layout", "--strip-debug", "-O"];

/// One way to compile a kernel.
pub struct Form {
    /// Suffix of the compiled file.
    pub name: &'static str,
    /// GLSL type of `real`.
    real: &'static str,
    /// GLSL type of `real3`.
    real3: &'static str,
    /// Shared structs with the host's offsets.
    pub structs: &'static [abi::GpuStruct],
}

/// All forms: two precisions, and the lanes of a subgroup traversing the scene together.
static FORMS: [Form; 3] = [
    Form { name: "f32", real: "float", real3: "vec3", structs: abi::single::STRUCTS },
    Form { name: "f64", real: "double", real3: "dvec3", structs: abi::double::STRUCTS },
    Form { name: "packet", real: "float", real3: "vec3", structs: abi::single::STRUCTS },
];

/// One `.comp` file.
pub struct Source {
    /// File name without extension.
    pub name: String,
    /// Path relative to the package.
    #[cfg_attr(not(whitted_shaderc), allow(dead_code))] // Only what compiles reads it.
    pub path: PathBuf,
    /// GLSL.
    pub text: String,
    /// Subgroups count together; see [`JOINED`].
    pub joined: bool,
}

impl Source {
    /// The forms in which this kernel is compiled. Kernels that test shapes have all three.
    pub fn forms(&self) -> impl Iterator<Item = &'static Form> {
        let traces = self.text.contains("traverse/traverse.glsl");
        let wanted = [!self.joined, !self.joined, traces || self.joined];
        FORMS.iter().zip(wanted).filter_map(|(form, wanted)| wanted.then_some(form))
    }
}

/// Files of one folder with one extension, sorted by path.
fn files(folder: &str, extension: &str) -> Result<Vec<PathBuf>, String> {
    let entries = fs::read_dir(folder).map_err(|e| format!("{folder}: {e}"))?;
    let mut paths: Vec<PathBuf> = entries
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| path.extension().is_some_and(|e| e == extension))
        .collect();
    paths.sort();
    Ok(paths)
}

/// The kernels in alphabetical order.
pub fn read() -> Result<Vec<Source>, String> {
    let source = |path: PathBuf| {
        let name = path.file_stem().and_then(|s| s.to_str()).ok_or("kernel file name is not UTF-8")?;
        let joined = JOINED.contains(&name);
        Ok(Source { name: name.to_owned(), text: text_of(&path)?, joined, path })
    };
    files("glsl", "comp")?.into_iter().map(source).collect()
}

/// SHA-256 of all that decides what the compiled kernels hold: every GLSL file, the shared declarations of every
/// form, the optimiser's options. Hexadecimal.
pub fn digest(kernels: &[Source]) -> Result<String, String> {
    let mut hash = Sha256::new();
    let mut add = |name: &str, text: &str| {
        hash.update(format!("{name} {}\n", text.len()));
        hash.update(text);
    };
    for kernel in kernels {
        add(&kernel.name, &kernel.text);
    }
    for folder in LIBRARY {
        for path in files(&format!("glsl/lib/{folder}"), "glsl")? {
            add(&path.file_name().unwrap_or_default().to_string_lossy(), &text_of(&path)?);
        }
    }
    for form in &FORMS {
        add(form.name, &abi_glsl(form));
    }
    add("spirv-opt", &OPTIMISER.join(" "));
    Ok(hash.finalize().iter().fold(String::new(), |mut hex, byte| {
        let _ = write!(hex, "{byte:02x}");
        hex
    }))
}

/// The shared declarations as GLSL, with macros READS(x), WRITES(x), UPDATES(x) that declare buffer x.
pub fn abi_glsl(form: &Form) -> String {
    let Form { name: form, real, real3, structs } = *form;
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
