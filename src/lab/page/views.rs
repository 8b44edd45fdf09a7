//! Pictures on a page: side by side and enlarged by a click, or one at a time behind tabs.

use super::markup::{data_url, escaped};
use std::fmt::Write;

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

/// One at a time: names for tabs, and contents (HTML). The first is open; the arrow keys go from tab to tab. `group`
/// names the switch, different from every other on the page.
pub(crate) fn switch(group: &str, layers: &[(&str, String)]) -> String {
    let mut text = format!("<div class=\"switch\" style=\"--tabs:{}\">\n", layers.len());
    for (i, (name, content)) in layers.iter().enumerate() {
        let checked = if i == 0 { " checked" } else { "" };
        let _ = writeln!(
            text,
            "<label><input type=\"radio\" name=\"{group}\"{checked}><span>{}</span><div>{content}</div></label>",
            escaped(name)
        );
    }
    text + "</div>\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_tab_is_open_and_names_are_text() {
        let text = switch("layers", &[("a<b", "<p>1</p>".into()), ("c", "<p>2</p>".into())]);
        assert_eq!((text.matches(" checked").count(), text.matches("<label>").count()), (1, 2));
        assert!(text.contains("a&lt;b") && text.contains("--tabs:2") && text.contains("<p>2</p>"));
    }
}
