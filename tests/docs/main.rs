//! The pages say what the program does: tables and transcripts are the program's own, links resolve, options exist.
//!
//! `WHITTED_UPDATE_DOCS=1 cargo test --test docs` rewrites what is out of date. `WHITTED_UPDATE_DOCS=all` also
//! rewrites transcripts that differ only in times.

mod cli;
mod links;
mod names;
mod pages;
mod tables;
mod transcript;
mod transcripts;
