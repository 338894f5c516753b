//! The server: an address, a folder, a token.

use std::ffi::OsString;
use std::io::ErrorKind;
use std::net::{SocketAddr, TcpListener};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Arc;

use axum::middleware;
use tokio::runtime;

use crate::error::WorkbenchError;
use crate::guard::{self, Guard};
use crate::home::Home;
use crate::routes;

/// What the usual name of the folder for results ends with.
const SUFFIX: &str = "-workbench";

/// What a workbench is of.
pub struct Options {
    /// Folder whose trials, studies, assets and data sets it shows.
    pub folder: PathBuf,
    /// Folder that keeps what is tried; it need not exist.
    pub out: PathBuf,
    /// Where it listens; port 0 is any free one.
    pub address: SocketAddr,
    /// What a browser must know to be answered: letters and digits that nobody guesses.
    pub token: String,
}

impl Options {
    /// The folder that keeps what is tried on another unless it is named: its name with a suffix, in the current folder.
    pub fn usual_out(folder: &Path) -> PathBuf {
        let mut name = OsString::from(folder.file_name().unwrap_or_default());
        name.push(SUFFIX);
        PathBuf::from(name)
    }
}

/// Asks the system to open a page. Where it has no browser nothing happens, and the address can be opened by hand.
pub fn open_in_browser(url: &str) {
    let program = match std::env::consts::OS {
        "macos" => "open",
        "windows" => "explorer",
        _ => "xdg-open",
    };
    let mut command = Command::new(program);
    let begun = command.arg(url).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).spawn();
    if let Ok(mut child) = begun {
        // It ends once the browser has the address; nobody waits for that.
        std::thread::spawn(move || child.wait());
    }
}

/// A server that listens, and answers once it runs.
pub struct Workbench {
    listener: TcpListener,
    address: SocketAddr,
    token: String,
    home: Arc<Home>,
}

impl Workbench {
    /// Listens at an address.
    ///
    /// # Errors
    /// [`WorkbenchError`] where the folder is none or the address cannot be had.
    pub fn bind(options: Options) -> Result<Self, WorkbenchError> {
        let Options { folder, out, address, token } = options;
        if !folder.is_dir() {
            return Err(WorkbenchError::NoFolder { folder });
        }
        let listener = TcpListener::bind(address).map_err(|error| match error.kind() {
            ErrorKind::AddrInUse => WorkbenchError::Taken { address },
            _ => WorkbenchError::Address { address, error },
        })?;
        listener.set_nonblocking(true)?;
        let address = listener.local_addr()?;
        let home = Arc::new(Home::new(folder, out));
        Ok(Self { listener, address, token, home })
    }

    /// Where it listens.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// The address to open, with the token.
    pub fn url(&self) -> String {
        format!("http://{}/?token={}", self.address, self.token)
    }

    /// Answers until the process ends.
    ///
    /// # Errors
    /// When the system gives no threads.
    pub fn run(self) -> Result<(), WorkbenchError> {
        let guard = Guard::new(&self.token, self.address.ip(), self.address.port());
        let routes = routes::all(self.home).layer(middleware::from_fn_with_state(guard, guard::check));
        let runtime = runtime::Builder::new_multi_thread().worker_threads(2).enable_all().build()?;
        runtime.block_on(async {
            let listener = tokio::net::TcpListener::from_std(self.listener)?;
            axum::serve(listener, routes).await
        })?;
        Ok(())
    }
}
