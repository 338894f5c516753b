//! `robofin workbench`: a page on which users see where a model fails, try a cause, and watch the error fall.

use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use clap::Args;
use rand::TryRng;
use rand::rngs::SysRng;
use serde::Serialize;
use workbench::{Options, Workbench, WorkbenchError, open_in_browser};

use super::backend_flags::BackendFlags;
use crate::console::Console;
use crate::wrong_use;

#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  robofin workbench trials\n  robofin workbench out --port 0 --no-open\n  \
                        ssh -L 4747:localhost:4747 lab robofin workbench trials --no-open   (then open the address it prints)")]
pub(super) struct WorkbenchArgs {
    /// Folder whose trials, tables, studies, assets and data sets are shown.
    #[arg(default_value = ".")]
    folder: PathBuf,
    /// Port; 0 takes any that is free.
    #[arg(long, value_name = "N", default_value_t = 4747)]
    port: u16,
    /// Address of this machine to listen at; other machines reach only another one than the loopback address.
    #[arg(long, value_name = "ADDRESS", default_value_t = IpAddr::V4(Ipv4Addr::LOCALHOST))]
    listen: IpAddr,
    /// Folder that keeps what is tried [default: the folder's name with -workbench behind it, in the current folder].
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    #[command(flatten)]
    backend: BackendFlags,
    /// Open no browser.
    #[arg(long)]
    no_open: bool,
}

/// The answer of `workbench --json`, before it serves.
#[derive(Serialize)]
struct WorkbenchAnswer<'a> {
    url: &'a str,
    out: &'a Path,
}

/// Runs the verb.
pub(super) fn run(args: &WorkbenchArgs, console: &Console) -> Result<()> {
    let folder = std::path::absolute(&args.folder)?;
    let out = std::path::absolute(args.out.clone().unwrap_or_else(|| Options::usual_out(&folder)))?;
    let address = SocketAddr::new(args.listen, args.port);
    let device = args.backend.device(None, console)?;
    let options = Options { folder, out: out.clone(), address, token: token()?, device };
    let bench = Workbench::bind(options).map_err(|error| match error {
        WorkbenchError::NoFolder { .. } => wrong_use(error.to_string()),
        error => error.into(),
    })?;
    let url = bench.url();
    if !args.listen.is_loopback() {
        console.step("note", "other machines can reach this page: who has its address can use this program");
    }
    console.step("kept in", out.display().to_string());
    console.result("open", &url)?;
    console.answer(&WorkbenchAnswer { url: &url, out: &out })?;
    if !args.no_open {
        open_in_browser(&url);
    }
    Ok(bench.run()?)
}

/// Draws a random token of 128 bits, in hexadecimal digits.
fn token() -> Result<String> {
    let mut bits = [0; 16];
    SysRng.try_fill_bytes(&mut bits).context("the system gives no random numbers for a token")?;
    Ok(bits.iter().map(|byte| format!("{byte:02x}")).collect())
}
