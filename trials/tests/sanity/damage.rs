//! Damage to the files of a trial that makes them contradict each other, as careless handling or another program may
//! cause.

use std::fs;
use std::path::{Path, PathBuf};

/// A trial's folder with the names of its files.
pub(crate) struct Files {
    pub(crate) folder: PathBuf,
    pub(crate) before: String,
    pub(crate) repeat: String,
    pub(crate) material: Option<String>,
    pub(crate) logs: Vec<String>,
    pub(crate) scans: Vec<String>,
    pub(crate) is_sanding: bool,
}

impl Files {
    pub(crate) fn of(folder: &Path) -> Self {
        let text = fs::read_to_string(folder.join("trial.toml")).unwrap();
        let table: toml::Table = text.parse().unwrap();
        let name = |value: &toml::Value| value.as_str().unwrap().to_owned();
        let passes = table["pass"].as_array().unwrap();
        Self {
            folder: folder.to_owned(),
            before: name(&table["scan"]["before"]),
            repeat: name(&table["scan"]["repeat"][0]),
            material: table["scan"].get("material").map(name),
            logs: passes.iter().map(|pass| name(&pass["log"])).collect(),
            scans: passes.iter().map(|pass| name(&pass["scan"])).collect(),
            is_sanding: table["process"].as_str() == Some("sanding"),
        }
    }

    /// All height maps.
    pub(crate) fn maps(&self) -> Vec<String> {
        let after = if self.is_sanding { &[] } else { &self.scans[..] };
        [&self.before, &self.repeat].into_iter().chain(after).cloned().collect()
    }

    /// Changes the text of a file.
    pub(crate) fn edit(&self, name: &str, change: impl FnOnce(String) -> String) {
        let place = self.folder.join(name);
        let text = fs::read_to_string(&place).unwrap();
        fs::write(place, change(text)).unwrap();
    }

    /// The scan after the last pass.
    pub(crate) fn last(&self) -> &str {
        self.scans.last().unwrap()
    }

    /// Multiplies the numbers of a key in `trial.toml`.
    pub(crate) fn scale_key(&self, key: &str, factor: f64) {
        let line = |line: &str| match line.split_once('=') {
            Some((name, value)) if name.trim() == key => {
                let value = value.split('#').next().unwrap().trim();
                let scaled = |number: &str| format!("{:?}", number.trim().parse::<f64>().unwrap() * factor);
                match value.strip_prefix('[') {
                    Some(list) => {
                        let numbers: Vec<String> = list.trim_end_matches(']').split(',').map(scaled).collect();
                        format!("{key} = [{}]\n", numbers.join(", "))
                    }
                    None => format!("{key} = {}\n", scaled(value)),
                }
            }
            _ => format!("{line}\n"),
        };
        self.edit("trial.toml", |text| text.lines().map(line).collect());
    }

    /// Changes the numbers of a table by row, column and value; the header of a log stays.
    pub(crate) fn numbers(&self, name: &str, change: impl Fn(usize, usize, f64) -> f64) {
        let cell = |row: usize, column: usize, cell: &str| match cell.parse::<f64>() {
            Ok(value) => format!("{:.9}", change(row, column, value)),
            Err(_) => cell.to_owned(),
        };
        let line = |(row, line): (usize, &str)| {
            line.split(',').enumerate().map(|(column, text)| cell(row, column, text)).collect::<Vec<_>>().join(",")
                + "\n"
        };
        self.edit(name, |text| text.lines().enumerate().map(line).collect());
    }

    /// Changes one column of all logs.
    pub(crate) fn column(&self, column: usize, change: impl Fn(f64) -> f64) {
        for log in &self.logs {
            self.numbers(log, |_, at, value| if at == column { change(value) } else { value });
        }
    }

    /// Rearranges a table of cells.
    pub(crate) fn cells(&self, name: &str, change: impl FnOnce(Vec<Vec<String>>) -> Vec<Vec<String>>) {
        self.edit(name, |text| {
            let rows = text.lines().map(|line| line.split(',').map(str::to_owned).collect()).collect();
            change(rows).into_iter().map(|row| row.join(",") + "\n").collect()
        });
    }

    pub(crate) fn mirror_x(&self, name: &str) {
        self.cells(name, |mut rows| {
            rows.iter_mut().for_each(|row| row.reverse());
            rows
        });
    }

    pub(crate) fn mirror_y(&self, name: &str) {
        self.cells(name, |mut rows| {
            rows.reverse();
            rows
        });
    }

    /// Shifts a map's content by whole pixels; pixels without a source are empty.
    pub(crate) fn shift(&self, name: &str, dx: i64, dy: i64) {
        self.cells(name, |rows| {
            let (ny, nx) = (rows.len() as i64, rows[0].len() as i64);
            let from = |i: i64, j: i64| {
                let (i, j) = (i - dx, j - dy);
                if (0..nx).contains(&i) && (0..ny).contains(&j) {
                    rows[j as usize][i as usize].clone()
                } else {
                    String::new()
                }
            };
            (0..ny).map(|j| (0..nx).map(|i| from(i, j)).collect()).collect()
        });
    }

    pub(crate) fn copy(&self, from: &str, to: &str) {
        fs::copy(self.folder.join(from), self.folder.join(to)).unwrap();
    }

    pub(crate) fn swap(&self, a: &str, b: &str) {
        let kept = self.folder.join("kept");
        fs::rename(self.folder.join(a), &kept).unwrap();
        fs::rename(self.folder.join(b), self.folder.join(a)).unwrap();
        fs::rename(kept, self.folder.join(b)).unwrap();
    }

    /// Rewrites a scan as if taken again: new noise of this size [mm] on the heights of another file.
    pub(crate) fn scanned_again(&self, from: &str, to: &str, noise_mm: f64) {
        self.copy(from, to);
        let mixed = |row: usize, column: usize| {
            (row * 100_003 + column + 17)
                .wrapping_mul(0x9e37_79b9_7f4a_7c15)
                .rotate_left(31)
                .wrapping_mul(0xbf58_476d_1ce4_e5b9)
                >> 11
        };
        let uniform = |row, column| mixed(row, column) as f64 / (1u64 << 53) as f64 - 0.5;
        self.numbers(to, |row, column, height| height + noise_mm * 12f64.sqrt() * uniform(row, column));
    }
}
