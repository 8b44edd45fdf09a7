//! Checks the compiled kernels against the host's declarations and writes the typed table `kernels.rs`.

use crate::pack::Compiled;
use crate::sources::{Form, Source};
use crate::{abi, spirv};
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

/// Every shared struct that the module stores in a buffer has the host's offsets; float arithmetic
/// cannot be contracted, and nothing with unstated rounding is used, neither before nor after optimisation.
fn check(kernel: &Compiled, form: &Form) -> Result<(), String> {
    let name = format!("{}.{}", kernel.kernel, kernel.form);
    for s in form.structs {
        let Some(found) = kernel.module.structs.get(s.name) else { continue };
        let wanted: Vec<(String, u32)> = s.fields.iter().map(|(n, o)| ((*n).to_owned(), *o as u32)).collect();
        if *found != wanted {
            return Err(format!("{name}: layout of {}: kernel has {found:?}, host has {wanted:?}", s.name));
        }
    }
    let optimised = spirv::read(&kernel.words).map_err(|e| format!("{name}: {e}"))?;
    for module in [&kernel.module, &optimised] {
        if module.contractible > 0 {
            return Err(format!("{name}: {} float operations lack NoContraction", module.contractible));
        }
        if !module.banned.is_empty() {
            return Err(format!("{name}: uses {}; write it out in scalars", module.banned.join(", ")));
        }
    }
    Ok(())
}

/// Which kernels a table is of.
#[derive(Clone, Copy, PartialEq)]
pub enum Kernels {
    /// Those that render; their table declares the `Kernel` enumeration.
    Shipped,
    /// Those with planted mistakes.
    Planted,
}

/// Writes `NAME.FORM.spv` of every kernel and `kernels.rs` into `out`.
pub fn write(out: &Path, sources: &[Source], compiled: &[Compiled], which: Kernels) -> Result<(), String> {
    let mut table = String::new();
    let (mut variants, mut all) = (String::new(), String::new());
    let mut rest = compiled.iter();
    for source in sources {
        let name = &source.name;
        let (mut reads, mut writes, mut texels) = (0u64, 0u64, 0u64);
        let mut files = Vec::new();
        for form in source.forms() {
            let kernel = rest
                .next()
                .filter(|k| k.kernel == *name && k.form == form.name)
                .ok_or_else(|| format!("{name}.{}: not compiled", form.name))?;
            check(kernel, form)?;
            let file = out.join(format!("{name}.{}.spv", form.name));
            fs::write(&file, bytemuck::cast_slice(&kernel.words)).map_err(|e| e.to_string())?;
            files.push(file);
            for b in &kernel.module.bindings {
                reads |= u64::from(b.reads) << b.binding;
                writes |= u64::from(b.writes) << b.binding;
            }
            kernel.module.texels.iter().for_each(|b| texels |= 1 << (b - abi::TEXELS_AT));
        }
        if texels & !reads != 0 {
            return Err(format!("{name}: a texel view of a buffer that it does not read"));
        }
        let [single, double, packet] = [0, 1, 2].map(|i| files.get(i).unwrap_or(&files[0]));
        let variant = camel(name);
        let _ = writeln!(variants, "    /// `glsl/{name}.comp`.\n    {variant},");
        let _ = write!(all, "Kernel::{variant}, ");
        let _ = writeln!(
            table,
            "    KernelCode {{ name: {name:?}, single: Spirv(include_bytes!({single:?})), double: Spirv(include_bytes!({double:?})), packet: Spirv(include_bytes!({packet:?})), reads: {reads:#x}, writes: {writes:#x}, texels: {texels:#x} }},"
        );
    }
    let mut text = format!(
        "/// What was compiled, in the order of [`Kernel`].\n\
         pub const KERNELS: [KernelCode; {}] = [\n{table}];\n",
        sources.len()
    );
    if which == Kernels::Shipped {
        let _ = write!(
            text,
            "\n/// The kernels, one per file in `glsl`, in alphabetical order.\n\
             #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]\npub enum Kernel {{\n{variants}}}\n\n\
             impl Kernel {{\n    /// All kernels, in the order of [`KERNELS`].\n    \
             pub const ALL: [Kernel; {}] = [{all}];\n}}\n",
            sources.len()
        );
    }
    fs::write(out.join("kernels.rs"), text).map_err(|e| e.to_string())
}

fn camel(name: &str) -> String {
    name.split('_').map(|w| w[..1].to_uppercase() + &w[1..]).collect()
}
