//! Tables of an HTML page: headings, a caption, and cells that hold the full value of the rounded number.

use super::page::escape;

/// Text of an absent number.
const ABSENT: &str = "–";

/// A cell of a table.
#[derive(Clone, Debug, Default)]
pub struct Cell {
    text: String,
    value: Option<f64>,
    is_number: bool,
}

impl Cell {
    /// Makes a cell of text, left-aligned.
    pub fn text(text: impl Into<String>) -> Self {
        Self { text: text.into(), ..Self::default() }
    }

    /// Makes a cell of a number: shown as text, right-aligned, with the full value in `data-value`.
    pub fn number(shown: String, value: f64) -> Self {
        Self { text: shown, value: value.is_finite().then_some(value), is_number: true }
    }

    /// Makes a cell with a dash for an absent number.
    pub fn absent() -> Self {
        Self { text: ABSENT.to_owned(), is_number: true, ..Self::default() }
    }

    fn is_absent(&self) -> bool {
        self.is_number && self.value.is_none() && self.text == ABSENT
    }

    fn to_html(&self, tag: &str) -> String {
        let class = if self.is_number { " class=\"n\"" } else { "" };
        let value = self.value.map_or(String::new(), |value| format!(" data-value=\"{}\"", exact(value)));
        let end = tag.split(' ').next().unwrap_or(tag);
        format!("<{tag}{class}{value}>{}</{end}>", escape(&self.text))
    }
}

/// Formats a number as in JSON: parsing it gives the same value.
pub(crate) fn exact(value: f64) -> String {
    serde_json::Number::from_f64(value).map_or("null".to_owned(), |number| number.to_string())
}

/// A table; the first column names the row.
#[derive(Clone, Debug, Default)]
pub struct Table {
    /// Caption; empty for none.
    pub caption: String,
    /// Headings with their units.
    pub headings: Vec<String>,
    /// Rows, with one cell for each heading.
    pub rows: Vec<Vec<Cell>>,
}

impl Table {
    /// Makes a table without rows.
    pub fn new(caption: &str, headings: &[&str]) -> Self {
        let headings = headings.iter().map(|&heading| heading.to_owned()).collect();
        Self { caption: caption.to_owned(), headings, rows: Vec::new() }
    }

    /// Removes the columns in which no row has a number.
    pub fn without_empty_columns(mut self) -> Self {
        let is_empty = |column: usize| {
            !self.rows.is_empty() && self.rows.iter().all(|row| row.get(column).is_some_and(Cell::is_absent))
        };
        let kept: Vec<bool> = (0..self.headings.len()).map(|column| !is_empty(column)).collect();
        let mut keep = kept.iter().copied();
        self.headings.retain(|_| keep.next().unwrap_or(true));
        for row in &mut self.rows {
            let mut keep = kept.iter().copied();
            row.retain(|_| keep.next().unwrap_or(true));
        }
        self
    }

    /// Returns the table as HTML; it scrolls horizontally if it is wider than the page.
    pub fn to_html(&self) -> String {
        let caption = match self.caption.as_str() {
            "" => String::new(),
            caption => format!("<caption>{}</caption>\n", escape(caption)),
        };
        let head: String = self.headings.iter().enumerate().map(|(i, heading)| self.heading(i, heading)).collect();
        let rows: String = self.rows.iter().map(|row| row_html(row)).collect();
        format!(
            "<div class=\"scroll\"><table>\n{caption}<thead><tr>{head}</tr></thead>\n<tbody>\n{rows}</tbody></table></div>\n"
        )
    }

    fn heading(&self, column: usize, heading: &str) -> String {
        let numbers = self.rows.first().and_then(|row| row.get(column)).is_some_and(|cell| cell.is_number);
        let class = if numbers { " class=\"n\"" } else { "" };
        format!("<th scope=\"col\"{class}>{}</th>", escape(heading))
    }
}

fn row_html(row: &[Cell]) -> String {
    let cells: String = row
        .iter()
        .enumerate()
        .map(|(i, cell)| cell.to_html(if i == 0 && !cell.is_number { "th scope=\"row\"" } else { "td" }))
        .collect();
    format!("<tr>{cells}</tr>\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_column_without_a_number_is_left_out() {
        let mut table = Table::new("", &["pass", "typical", "size"]);
        table.rows.push(vec![Cell::text("1"), Cell::absent(), Cell::number("none shows".to_owned(), f64::NAN)]);
        table.rows.push(vec![Cell::text("2"), Cell::absent(), Cell::absent()]);
        let kept = table.without_empty_columns();
        assert_eq!(kept.headings, ["pass", "size"]);
        assert!(kept.rows.iter().all(|row| row.len() == 2));
        assert_eq!(Table::new("", &["pass"]).without_empty_columns().headings, ["pass"]);
    }

    #[test]
    fn a_cell_keeps_the_full_value() {
        let mut table = Table::new("Volumes", &["pass", "removed [mm³]"]);
        table.rows.push(vec![Cell::text("<1>"), Cell::number("1.23".to_owned(), 1.25e-9)]);
        let html = table.to_html();
        assert!(html.contains("data-value=\"1.25e-9\">1.23<"), "{html}");
        assert!(html.contains("<th scope=\"row\">&lt;1&gt;</th>") && html.contains("<caption>Volumes</caption>"));
        assert!(!Cell::number("–".to_owned(), f64::NAN).to_html("td").contains("data-value"));
    }
}
