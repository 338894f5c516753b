//! `robofin ledger`: shows the attempts on a campaign, and sets the current model.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use anyhow::Result;
use clap::Args;
use serde::Serialize;

use super::values::whole;
use crate::console::Console;
use crate::wrong_use;
use study::{Entry, LEDGER_FILE, Ledger, Standing};

/// Suffix of a ledger's default folder.
const SUFFIX: &str = "-ledger";

/// Where a ledger is.
#[derive(Clone, Debug, Args)]
pub(super) struct LedgerFlag {
    /// Folder of the ledger [default: the campaign's name with -ledger behind it, in the current folder].
    #[arg(long, value_name = "DIR")]
    ledger: Option<PathBuf>,
}

impl LedgerFlag {
    /// Returns the folder of a campaign's ledger.
    pub(super) fn of(&self, campaign: &Path) -> PathBuf {
        let usual = || {
            let whole = std::path::absolute(campaign).unwrap_or_else(|_| campaign.to_owned());
            let mut name = OsString::from(whole.file_name().unwrap_or_default());
            name.push(SUFFIX);
            PathBuf::from(name)
        };
        self.ledger.clone().unwrap_or_else(usual)
    }
}

#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  robofin ledger trials-ledger\n  robofin ledger trials-ledger --to 2")]
pub(super) struct LedgerArgs {
    /// Folder of the ledger, as `robofin try` names it.
    ledger: PathBuf,
    /// Make the model of this attempt the current one; 0 is the model with which the ledger began.
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = whole::<usize>([0, 1_000_000]))]
    to: Option<usize>,
}

/// The answer of `ledger --json`.
#[derive(Serialize)]
struct LedgerAnswer<'a> {
    current: Option<Standing>,
    attempts: Vec<&'a Entry>,
}

/// Runs the verb.
pub(super) fn run(args: &LedgerArgs, console: &Console) -> Result<()> {
    if !args.ledger.join(LEDGER_FILE).is_file() {
        return Err(wrong_use(format!("{}: no ledger; `robofin try` begins one", args.ledger.display())));
    }
    let mut ledger = Ledger::open(&args.ledger)?;
    if let Some(number) = args.to {
        ledger.return_to(number)?;
    }
    for entry in ledger.entries() {
        console.result(&entry.number.to_string(), entry.line())?;
    }
    let current = ledger.current();
    if let Some(standing) = &current {
        console.result("current", format!("{}: {}", standing.number, standing.model.display()))?;
    }
    console.answer(&LedgerAnswer { current, attempts: ledger.entries().collect() })
}
