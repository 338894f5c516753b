//! Why a workbench does not start, or does not answer.

use std::net::SocketAddr;
use std::path::PathBuf;

use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use thiserror::Error;

/// Why a workbench does not start.
#[derive(Debug, Error)]
pub enum WorkbenchError {
    /// The folder is no folder.
    #[error("{}: no such folder; a folder with trials, studies, assets or data sets is accepted", folder.display())]
    NoFolder {
        /// As it was given.
        folder: PathBuf,
    },
    /// Another program listens at the address.
    #[error(
        "{address}: the port is taken, perhaps by another workbench; --port N takes another, --port 0 any free one"
    )]
    Taken {
        /// What was asked for.
        address: SocketAddr,
    },
    /// The address cannot be listened at.
    #[error("{address}: {error}; an address of this machine is accepted")]
    Address {
        /// What was asked for.
        address: SocketAddr,
        /// What the system says.
        error: std::io::Error,
    },
    /// The folder for results cannot be written.
    #[error(transparent)]
    Out(#[from] files::FileError),
    /// The system gives no threads or sockets.
    #[error("the server: {0}")]
    Server(#[from] std::io::Error),
}

/// Why a request has no answer; the page shows the words.
#[derive(Debug)]
pub(crate) struct Refusal(pub(crate) StatusCode, pub(crate) String);

impl Refusal {
    /// What was asked for is not there.
    pub(crate) fn missing(words: impl Into<String>) -> Self {
        Self(StatusCode::NOT_FOUND, words.into())
    }

    /// What was asked for makes no sense.
    pub(crate) fn wrong(words: impl Into<String>) -> Self {
        Self(StatusCode::UNPROCESSABLE_ENTITY, words.into())
    }

    /// It is not there yet.
    pub(crate) fn early(words: impl Into<String>) -> Self {
        Self(StatusCode::CONFLICT, words.into())
    }
}

impl IntoResponse for Refusal {
    fn into_response(self) -> Response {
        (self.0, self.1).into_response()
    }
}
