//! A self-contained HTML page: opens offline, prints on A4, loads nothing.

use std::fmt::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use super::table::{Cell, Table};

/// A page under construction; blocks are appended in reading order.
pub struct Page {
    title: String,
    style: String,
    body: String,
    parts: Vec<(&'static str, &'static str)>,
    contents_at: Option<usize>,
}

/// Style sheet of every page.
pub(crate) const STYLE: &str = "
:root { color-scheme: light; }
body { font: 15px/1.5 system-ui, sans-serif; color: #1c2330; max-width: 62rem; margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.6rem; margin: 0 0 .3rem; } h2 { font-size: 1.15rem; margin: 2rem 0 .6rem; }
p.lead { font-size: 1.05rem; color: #3c4658; margin-top: 0; }
figure { margin: 1rem 0; } img, svg { max-width: 100%; height: auto; } figcaption { color: #5b6577; font-size: .9rem; }
table { border-collapse: collapse; margin: .5rem 0; } th, td { padding: .25rem .9rem .25rem 0; text-align: left;
border-bottom: 1px solid #dfe3ea; vertical-align: top; } .scroll { overflow-x: auto; } td.n, th.n { text-align: right; font-variant-numeric: tabular-nums; }
rect.strip { fill: transparent; } rect.strip:hover { fill: rgb(28 35 48 / .12); }
.facts th { font-weight: 600; } .facts td { overflow-wrap: anywhere; } a { color: #1f5f99; }
@media (max-width: 40rem) { .drawing { overflow-x: auto; } .drawing svg { width: 40rem; max-width: none; } .facts th { width: 42%; overflow-wrap: anywhere; } }
code { font-size: .9em; background: #f2f4f8; padding: .05em .3em; border-radius: 3px; }
@media print { body { margin: 0; max-width: none; font-size: 10.5pt; } figure, table { break-inside: avoid; } @page { size: A4; margin: 15mm; } }
";

impl Page {
    /// Starts a page with a heading and one sentence below it.
    pub fn new(title: &str, lead: &str) -> Self {
        let body = format!("<header><h1>{}</h1>\n<p class=\"lead\">{}</p></header>\n", escape(title), escape(lead));
        Self { title: title.to_owned(), style: STYLE.to_owned(), body, parts: Vec::new(), contents_at: None }
    }

    /// Starts a page without a heading, for sections that go into another document.
    pub(crate) fn bare() -> Self {
        Self { title: String::new(), style: String::new(), body: String::new(), parts: Vec::new(), contents_at: None }
    }

    /// Returns the appended HTML without a document around it.
    pub(crate) fn into_body(self) -> String {
        self.body
    }

    /// Appends a section heading.
    pub fn section(&mut self, heading: &str) {
        self.append(&format!("<h2>{}</h2>\n", escape(heading)));
    }

    /// Appends a section heading with an entry in the list of contents.
    pub(crate) fn part(&mut self, id: &'static str, heading: &'static str) {
        self.parts.push((id, heading));
        self.append(&format!("<h2 id=\"{id}\">{}</h2>\n", escape(heading)));
    }

    /// Appends a heading within a section.
    pub(crate) fn subsection(&mut self, heading: &str) {
        self.append(&format!("<h3>{}</h3>\n", escape(heading)));
    }

    /// Marks the position of the list of contents.
    pub(crate) fn contents(&mut self) {
        self.contents_at = Some(self.body.len());
    }

    /// Appends a paragraph of plain text.
    pub fn paragraph(&mut self, text: &str) {
        self.append(&format!("<p>{}</p>\n", escape(text)));
    }

    /// Appends an embedded PNG picture.
    pub fn picture(&mut self, png: &[u8], caption: &str) {
        let caption = escape(caption);
        let data = STANDARD.encode(png);
        self.append(&format!(
            "<figure><img alt=\"{caption}\" src=\"data:image/png;base64,{data}\"><figcaption>{caption}</figcaption></figure>\n"
        ));
    }

    /// Appends an inline SVG drawing; on a narrow screen it scrolls sideways, so that its text can be read.
    pub fn drawing(&mut self, svg: &str, caption: &str) {
        let caption = escape(caption);
        self.append(&format!(
            "<figure><div class=\"drawing\" tabindex=\"0\" role=\"group\" aria-label=\"{caption}\">{svg}</div>\
             <figcaption>{caption}</figcaption></figure>\n"
        ));
    }

    /// Appends a list of links to files beside the page, each with its address and words.
    pub fn links(&mut self, links: &[(String, String)]) {
        let item = |(address, words): &(String, String)| {
            format!("<li><a href=\"{}\">{}</a></li>\n", escape(address), escape(words))
        };
        self.append(&format!("<ul>\n{}</ul>\n", links.iter().map(item).collect::<String>()));
    }

    /// Appends a table of names and values.
    pub fn facts<N: AsRef<str>>(&mut self, rows: &[(N, String)]) {
        let rows: String = rows
            .iter()
            .map(|(name, value)| {
                format!("<tr><th scope=\"row\">{}</th><td>{}</td></tr>\n", escape(name.as_ref()), escape(value))
            })
            .collect();
        self.append(&format!("<table class=\"facts\">\n{rows}</table>\n"));
    }

    /// Appends a table of numbers under headings; the first column names the row.
    pub fn table(&mut self, headings: &[&str], rows: &[Vec<String>]) {
        let cell = |(i, text): (usize, &String)| match i {
            0 => Cell::text(text),
            _ => Cell::number(text.clone(), f64::NAN),
        };
        let rows = rows.iter().map(|row| row.iter().enumerate().map(cell).collect()).collect();
        self.append(&Table { rows, ..Table::new("", headings) }.to_html());
    }

    /// Appends a table of words under headings.
    pub fn words(&mut self, headings: &[&str], rows: &[Vec<String>]) {
        let rows = rows.iter().map(|row| row.iter().map(Cell::text).collect()).collect();
        self.append(&Table { rows, ..Table::new("", headings) }.to_html());
    }

    /// Appends HTML made by this crate; `html` is not escaped.
    pub(crate) fn block(&mut self, html: &str) {
        self.append(html);
    }

    /// Adds rules to the page's style sheet.
    pub(crate) fn style(&mut self, css: &str) {
        self.style.push_str(css);
    }

    /// Returns the finished document.
    pub fn finish(mut self) -> String {
        if let Some(at) = self.contents_at {
            let links = self.parts.iter().map(|(id, heading)| format!("<a href=\"#{id}\">{}</a>\n", escape(heading)));
            self.body.insert_str(at, &format!("<nav aria-label=\"Contents\">\n{}</nav>\n", links.collect::<String>()));
        }
        format!(
            "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
             <title>{}</title>\n<style>{}</style>\n</head>\n<body>\n<main>\n{}</main>\n</body>\n</html>\n",
            escape(&self.title),
            self.style,
            self.body
        )
    }

    fn append(&mut self, html: &str) {
        self.body.push_str(html);
    }
}

/// Escapes text for HTML and SVG.
pub(crate) fn escape(text: &str) -> String {
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
