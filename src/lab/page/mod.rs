//! Self-contained HTML pages: one file with styles, tables, charts and pictures that needs no other file, no network
//! and, for reading, no JavaScript.

pub(crate) mod bars;
pub(crate) mod markup;
pub(crate) mod pictures;
pub(crate) mod views;

const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");

/// A whole page: `title` as text, `body` as HTML.
pub(crate) fn document(title: &str, body: &str) -> String {
    let title = markup::escaped(title);
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" \
         content=\"width=device-width\"><title>{title}</title>\n<style>\n{STYLE}</style></head><body>\n<h1>{title}</h1>\n\
         {body}<script>\n{SCRIPT}</script></body></html>\n"
    )
}
