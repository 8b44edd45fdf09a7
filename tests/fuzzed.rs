//! Every reader survives its corpus: what libFuzzer kept of the inputs that took a reader to new places, and what once broke
//! it. `./whitted.sh fuzz` looks for more.

// A panic is a test's failure report, in its helpers too.
#![allow(clippy::unwrap_used)]

#[path = "../fuzz/src/lib.rs"]
#[allow(dead_code)]
mod readers;

use std::io::Read;

#[test]
fn every_reader_survives_its_corpus() {
    for (name, reader) in readers::READERS {
        let archive = format!("{}/fuzz/corpus/{name}.tar", env!("CARGO_MANIFEST_DIR"));
        let file = std::fs::File::open(&archive).unwrap_or_else(|error| panic!("{archive}: {error}"));
        let mut inputs = 0;
        for entry in tar::Archive::new(file).entries().unwrap() {
            let mut bytes = Vec::new();
            entry.unwrap().read_to_end(&mut bytes).unwrap();
            reader(&bytes);
            inputs += 1;
        }
        assert!(inputs >= 10, "{archive} has {inputs} inputs");
        eprintln!("{name}: {inputs} inputs");
    }
    readers::clean();
}
