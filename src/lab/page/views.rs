//! Pictures on a page: side by side and enlarged by a click.

use super::markup::{data_url, escaped};

/// A PNG of `size` pixels; `what` is its name.
pub(crate) fn image(png: &[u8], [width, height]: [u32; 2], what: &str) -> String {
    let what = escaped(what);
    format!("<img width=\"{width}\" height=\"{height}\" alt=\"{what}\" src=\"{}\">", data_url(png))
}

/// Side by side: names and pictures (HTML). A click shows one at full size; the arrow keys then show its neighbours.
pub(crate) fn views(pictures: &[(&str, String)]) -> String {
    let view = |(what, image): &(&str, String)| {
        let what = escaped(what);
        format!("<label class=\"view\"><input type=\"checkbox\">{image}<span>{what}</span></label>\n")
    };
    format!("<div class=\"views\">\n{}</div>", pictures.iter().map(view).collect::<String>())
}
