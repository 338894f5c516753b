//! Report of a study: one HTML file with the data compared, the missing effects and the next steps.
//!
//! [`StudyReport`] holds the results of a study, in SI units (`data`, and `scan_data` for those of one scan). [`page`]
//! draws it; this module reads no file, simulates nothing and judges nothing.

pub(crate) mod colour_scale;
mod compared;
mod covariates;
mod exposure;
mod maps;
mod number;
mod outlook;
mod parameters;
mod proposal;
mod provenance;
mod sections;
mod statistics;
mod story;
mod suspects;
mod waterfall;
mod words;

pub use colour_scale::ColourScale;
pub use story::{Sealed, story};

use crate::Page;
use crate::page::STYLE as OF_PAGES;
use serde::{Deserialize, Serialize};
use study::{Conclusion, StudyReport};

/// Style sheets of a report: that of every page, then that of the report.
pub const STYLE: [&str; 2] = [OF_PAGES, include_str!("style.css")];
/// Script that shows the values of maps under the pointer; the document needs an element `tip`.
pub const HOVER: &str = include_str!("hover.js");

/// Sections of a report as HTML, for another document that includes [`STYLE`] and [`HOVER`].
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Sections {
    /// Error after each step of the study.
    pub waterfall: String,
    /// Misfits of the model: volumes, tests, maps, sections, covariates.
    pub failures: String,
    /// Fitted parameters.
    pub parameters: String,
    /// Notes of the reader and of the fit.
    pub method: String,
}

impl Sections {
    /// Draws the sections of a report.
    ///
    /// # Panics
    /// Those of [`page`].
    pub fn of(report: &StudyReport) -> Self {
        let drawn = |draw: &dyn Fn(&mut Page)| {
            let mut page = Page::bare();
            draw(&mut page);
            page.into_body()
        };
        Self {
            waterfall: drawn(&|page| waterfall::add(page, &report.waterfall)),
            failures: drawn(&|page| {
                compared::add_volumes(page, &report.volumes);
                add_residuals(page, report);
            }),
            parameters: drawn(&|page| parameters::add(page, &report.parameters, &report.correlations)),
            method: drawn(&|page| compared::add_method(page, &report.compared)),
        }
    }
}

/// Returns the report as an HTML document that loads nothing. The same study gives the same bytes.
///
/// # Panics
/// If the number of a map's values differs from its number of pixels, which is a bug of the caller.
pub fn page(report: &StudyReport) -> String {
    let campaign = &report.compared.campaign;
    let mut page = Page::new(&format!("{campaign}: measured against simulated"), "Report of a study, by RoboFin");
    page.style(include_str!("style.css"));
    compared::add_verdict(&mut page, report);
    page.contents();
    compared::add(&mut page, &report.compared);
    waterfall::add(&mut page, &report.waterfall);
    compared::add_volumes(&mut page, &report.volumes);
    add_residuals(&mut page, report);
    let is_diagnosed = matches!(report.conclusion, Conclusion::Searched(_));
    if is_diagnosed {
        suspects::add(&mut page, report);
    }
    parameters::add(&mut page, &report.parameters, &report.correlations);
    outlook::add_detectable(&mut page, &report.detectable);
    if let Some(proposal) = &report.proposal {
        proposal::add(&mut page, proposal);
    }
    if is_diagnosed {
        outlook::add_next(&mut page, report);
    }
    compared::add_method(&mut page, &report.compared);
    provenance::add(&mut page, &report.provenance);
    provenance::add_diagnosis(&mut page, &report.diagnosis);
    page.block(&format!("<div id=\"tip\" aria-hidden=\"true\"></div>\n<script>\n{}</script>\n", HOVER));
    page.finish()
}

/// Appends the differences between measurement and model: tests, maps, sections, covariates.
fn add_residuals(page: &mut Page, report: &StudyReport) {
    page.part("residuals", "Where the model fails");
    suspects::add_tests(page, &report.tests);
    if report.scans.is_empty() {
        page.paragraph("There are no maps: what was measured has no places.");
    }
    maps::add(page, &report.scans);
    exposure::add(page, &report.scans);
    sections::add(page, &report.sections, maps::page_noise(&report.scans));
    covariates::add(page, &report.covariates);
}
