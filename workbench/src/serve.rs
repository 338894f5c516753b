//! The server: an address, a folder, a token.

use std::ffi::OsString;
use std::io::ErrorKind;
use std::net::{SocketAddr, TcpListener};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Arc;

use axum::middleware;
use shaders::Device;
use tokio::runtime;

use crate::error::WorkbenchError;
use crate::guard::{self, Guard};
use crate::home::Home;
use crate::part::Studio;
use crate::routes;

/// Suffix of the default name of the folder for results.
const SUFFIX: &str = "-workbench";

/// Options of a workbench.
pub struct Options {
    /// Folder whose trials, studies, assets and data sets it shows.
    pub folder: PathBuf,
    /// Folder for results; it need not exist.
    pub out: PathBuf,
    /// Address to listen at; port 0 is any free one.
    pub address: SocketAddr,
    /// Token that a browser must present: random letters and digits.
    pub token: String,
    /// Device that takes photographs; `None` for the CPU.
    pub device: Option<Device>,
}

impl Options {
    /// Returns the default folder for results: the name of the served folder with a suffix, in the current folder.
    pub fn usual_out(folder: &Path) -> PathBuf {
        let mut name = OsString::from(folder.file_name().unwrap_or_default());
        name.push(SUFFIX);
        PathBuf::from(name)
    }
}

/// Asks the system to open a page. Without a browser nothing happens; the address can be opened by hand.
pub fn open_in_browser(url: &str) {
    let program = match std::env::consts::OS {
        "macos" => "open",
        "windows" => "explorer",
        _ => "xdg-open",
    };
    let mut command = Command::new(program);
    let begun = command.arg(url).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).spawn();
    if let Ok(mut child) = begun {
        // The child ends once the browser has the address; a thread reaps it.
        std::thread::spawn(move || child.wait());
    }
}

/// A server that is bound to its address; it answers once it runs.
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
    /// [`WorkbenchError`] if the path is not a folder or the address cannot be bound.
    pub fn bind(options: Options) -> Result<Self, WorkbenchError> {
        let Options { folder, out, address, token, device } = options;
        if !folder.is_dir() {
            return Err(WorkbenchError::NoFolder { folder });
        }
        let listener = TcpListener::bind(address).map_err(|error| match error.kind() {
            ErrorKind::AddrInUse => WorkbenchError::Taken { address },
            _ => WorkbenchError::Address { address, error },
        })?;
        listener.set_nonblocking(true)?;
        let address = listener.local_addr()?;
        let home = Arc::new(Home::new(folder, out, device.map(Studio::on).transpose()?));
        Ok(Self { listener, address, token, home })
    }

    /// Returns the address that the server is bound to.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// Returns the URL to open, with the token.
    pub fn url(&self) -> String {
        format!("http://{}/?token={}", self.address, self.token)
    }

    /// Answers until the process ends.
    ///
    /// # Errors
    /// If the system cannot provide threads.
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
