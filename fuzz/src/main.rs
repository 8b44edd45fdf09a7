//! libFuzzer over one reader: `READER=obj reader CORPUS`, with libFuzzer's own options. `./whitted.sh fuzz` calls it.
#![no_main]

use libfuzzer_sys::fuzz_target;
use std::sync::LazyLock;
use whitted_fuzz::READERS;

static READER: LazyLock<fn(&[u8])> = LazyLock::new(|| {
    let name = std::env::var("READER").unwrap_or_default();
    let found = READERS.iter().find(|(known, _)| *known == name);
    let Some((_, reader)) = found else {
        let known: Vec<_> = READERS.iter().map(|(name, _)| *name).collect();
        eprintln!("READER must be one of {}", known.join(" "));
        std::process::exit(2);
    };
    *reader
});

fuzz_target!(|bytes: &[u8]| READER(bytes));
