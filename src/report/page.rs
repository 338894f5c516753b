//! A self-contained HTML page: opens offline, prints on A4, loads nothing.

use std::fmt::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

/// A page under construction: blocks are appended in reading order.
pub struct Page {
    title: String,
    body: String,
}

const STYLE: &str = "
:root { color-scheme: light; }
body { font: 15px/1.5 system-ui, sans-serif; color: #1c2330; max-width: 62rem; margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.6rem; margin: 0 0 .3rem; } h2 { font-size: 1.15rem; margin: 2rem 0 .6rem; }
p.lead { font-size: 1.05rem; color: #3c4658; margin-top: 0; }
figure { margin: 1rem 0; } img, svg { max-width: 100%; height: auto; } figcaption { color: #5b6577; font-size: .9rem; }
table { border-collapse: collapse; margin: .5rem 0; } th, td { padding: .25rem .9rem .25rem 0; text-align: left;
border-bottom: 1px solid #dfe3ea; vertical-align: top; } td.n, th.n { text-align: right; font-variant-numeric: tabular-nums; }
code { font-size: .9em; background: #f2f4f8; padding: .05em .3em; border-radius: 3px; }
@media print { body { margin: 0; max-width: none; font-size: 10.5pt; } figure, table { break-inside: avoid; } @page { size: A4; margin: 15mm; } }
";

impl Page {
    /// A page with a heading and one sentence below it.
    pub fn new(title: &str, lead: &str) -> Self {
        let body = format!("<h1>{}</h1>\n<p class=\"lead\">{}</p>\n", escape(title), escape(lead));
        Self { title: title.to_owned(), body }
    }

    /// A section heading.
    pub fn section(&mut self, heading: &str) {
        self.append(&format!("<h2>{}</h2>\n", escape(heading)));
    }

    /// A paragraph of plain text.
    pub fn paragraph(&mut self, text: &str) {
        self.append(&format!("<p>{}</p>\n", escape(text)));
    }

    /// A PNG picture, embedded.
    pub fn picture(&mut self, png: &[u8], caption: &str) {
        let caption = escape(caption);
        let data = STANDARD.encode(png);
        self.append(&format!(
            "<figure><img alt=\"{caption}\" src=\"data:image/png;base64,{data}\"><figcaption>{caption}</figcaption></figure>\n"
        ));
    }

    /// An inline SVG drawing.
    pub fn drawing(&mut self, svg: &str, caption: &str) {
        self.append(&format!("<figure>{svg}<figcaption>{}</figcaption></figure>\n", escape(caption)));
    }

    /// A table of names and values.
    pub fn facts<N: AsRef<str>>(&mut self, rows: &[(N, String)]) {
        let rows: String = rows
            .iter()
            .map(|(name, value)| format!("<tr><th>{}</th><td>{}</td></tr>\n", escape(name.as_ref()), escape(value)))
            .collect();
        self.append(&format!("<table>\n{rows}</table>\n"));
    }

    /// A table of numbers under headings; the first column names the row.
    pub fn table(&mut self, headings: &[&str], rows: &[Vec<String>]) {
        let cells = |tag: &str, row: &mut dyn Iterator<Item = &str>| -> String {
            row.enumerate()
                .map(|(i, cell)| {
                    let class = if i == 0 { "" } else { " class=\"n\"" };
                    format!("<{tag}{class}>{}</{tag}>", escape(cell))
                })
                .collect()
        };
        let head = cells("th", &mut headings.iter().copied());
        let mut text = format!("<table>\n<tr>{head}</tr>\n");
        for row in rows {
            text += &format!("<tr>{}</tr>\n", cells("td", &mut row.iter().map(String::as_str)));
        }
        self.append(&(text + "</table>\n"));
    }

    /// The finished document.
    pub fn finish(self) -> String {
        format!(
            "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
             <title>{}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n{}</body>\n</html>\n",
            escape(&self.title),
            self.body
        )
    }

    fn append(&mut self, html: &str) {
        self.body.push_str(html);
    }
}

/// Text made safe for HTML and SVG.
pub(super) fn escape(text: &str) -> String {
    text.chars().fold(String::with_capacity(text.len()), |mut safe, c| {
        match c {
            '&' => safe.push_str("&amp;"),
            '<' => safe.push_str("&lt;"),
            '>' => safe.push_str("&gt;"),
            '"' => safe.push_str("&quot;"),
            _ if c.is_control() && c != '\n' => {
                let _ = write!(safe, "\\u{:04x}", c as u32);
            }
            _ => safe.push(c),
        }
        safe
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hostile_file_name_stays_text() {
        let mut page = Page::new("<script>alert(1)</script>", "a & b");
        page.facts(&[("part", "\"><img src=x>".to_owned())]);
        let html = page.finish();
        assert!(!html.contains("<script>") && !html.contains("<img src=x>"));
        assert!(html.contains("a &amp; b"));
    }
}
