//! Pieces of HTML.

/// Text that is no markup.
pub(super) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// A paragraph of HTML.
pub(super) fn paragraph(html: &str) -> String {
    format!("<p>{html}</p>\n")
}

/// A heading and a table whose first `words` columns are flush left; says so if there are no rows.
pub(super) fn table<const N: usize>(
    title: &str,
    words: usize,
    heads: &[&str; N],
    rows: &[[String; N]],
) -> String {
    let line = |tag: &str, cells: &[String; N]| {
        let cell = |(i, cell): (usize, &String)| {
            let class = if i < words { " class=\"l\"" } else { "" };
            format!("<{tag}{class}>{}</{tag}>", escaped(cell))
        };
        format!("<tr>{}</tr>\n", cells.iter().enumerate().map(cell).collect::<String>())
    };
    let heading = format!("<h2>{}</h2>\n", escaped(title));
    if rows.is_empty() {
        return heading + &paragraph("None.");
    }
    let head = line("th", &heads.map(String::from));
    let body: String = rows.iter().map(|row| line("td", row)).collect();
    format!(
        "{heading}<div class=\"scroll\"><table><thead>{head}</thead><tbody>\n{body}</tbody></table></div>\n"
    )
}
