//! `glsl/kernels.pack` holds what shaderc makes of the sources, and reads back word for word.

// A panic is a test's failure report, in its helpers too.
#![allow(clippy::unwrap_used)]

#[path = "../build/pack.rs"]
mod pack;

use pack::Compiled;
use whitted::kernel::spirv;
use whitted::kernel::table::KERNELS;

/// Where the build left its own pack; None where it had no shaderc and unpacked the kernels of the package.
const MADE: Option<&str> = option_env!("WHITTED_KERNELS");

#[test]
fn the_pack_is_what_the_sources_give() {
    let update = std::env::var_os("WHITTED_UPDATE_KERNELS").is_some();
    assert!(
        !update || MADE.is_some(),
        "built without shaderc: run `./whitted.sh setup`, and unset RUSTFLAGS"
    );
    let Some(made) = MADE else { return };
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(pack::FILE);
    let fresh = std::fs::read(made).unwrap();
    if update {
        let tools = pack::read(&fresh).unwrap().tools;
        assert!(!tools.contains("no spirv-opt"), "packed kernels are optimised: install spirv-tools");
        std::fs::write(&path, &fresh).unwrap();
        return;
    }
    let kept = std::fs::read(&path).unwrap();
    let (made, packed) = (pack::read(&fresh).unwrap(), pack::read(&kept).unwrap());
    assert_eq!(made.digest, packed.digest, "glsl/kernels.pack is out of date: run `./whitted.sh kernels`");
    // Other versions of the compilers may give other bytes.
    if made.tools == packed.tools {
        assert!(fresh == kept, "glsl/kernels.pack differs from its sources: run `./whitted.sh kernels`");
    }
}

fn compiled() -> Vec<Compiled> {
    let form =
        |k: &'static whitted::kernel::table::KernelCode, form: &str, code: whitted::kernel::table::Spirv| {
            let words = code.words();
            let module = spirv::Module { contractible: 0, arithmetic: 0, ..spirv::read(&words).unwrap() };
            Compiled { kernel: k.name.into(), form: form.into(), module, words }
        };
    KERNELS.iter().flat_map(|k| [form(k, "f64", k.double), form(k, "packet", k.packet)]).collect()
}

#[test]
fn a_pack_reads_back_as_it_was_written() {
    let mut kernels = compiled();
    kernels[0].module.structs.insert("Ray".into(), vec![("origin".into(), 0), ("slot".into(), 24)]);
    // An operand of each extreme, and instructions of an opcode in two lengths.
    kernels[0].words.extend([3 << 16 | 54, u32::MAX, 0, 3 << 16 | 54, 0, u32::MAX, 2 << 16 | 54, 1 << 31]);
    let bytes = pack::write("digest", "tool 1, tool 2", &kernels).unwrap();
    let back = pack::read(&bytes).unwrap();
    assert_eq!((back.digest.as_str(), back.tools.as_str()), ("digest", "tool 1, tool 2"));
    assert!(back.kernels == kernels);
    let raw: usize = kernels.iter().map(|k| 4 * k.words.len()).sum();
    assert!(bytes.len() * 8 < raw, "{} bytes of {raw}", bytes.len());
}

#[test]
fn damage_is_an_error() {
    let kernels = &compiled()[..1];
    let bytes = pack::write("digest", "tools", kernels).unwrap();
    for length in (0..bytes.len()).step_by(7) {
        assert!(pack::read(&bytes[..length]).is_err(), "cut to {length} bytes");
    }
    let stream = bytes.windows(2).position(|w| w == b"\n\n").unwrap() + 4;
    for at in stream..bytes.len() {
        let mut damaged = bytes.clone();
        damaged[at] ^= 0x10;
        // Some bits of a zlib stream mean nothing: the kernels are then what they were.
        assert!(!pack::read(&damaged).is_ok_and(|p| p.kernels != kernels), "byte {at}");
    }
}

#[test]
fn what_is_not_spirv_is_not_packed() {
    let mut kernel = compiled().swap_remove(0);
    // An instruction longer than the module.
    kernel.words.push(9 << 16 | 54);
    assert!(pack::write("digest", "tools", &[kernel]).is_err());
}
