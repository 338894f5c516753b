//! Errors of the workbench's start, and refusals of requests.

use std::net::SocketAddr;
use std::path::PathBuf;

use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use thiserror::Error;

/// Reason why a workbench does not start.
#[derive(Debug, Error)]
pub enum WorkbenchError {
    /// The path is not a folder.
    #[error("{}: no such folder; a folder with trials, studies, assets or data sets is accepted", folder.display())]
    NoFolder {
        /// Path as given.
        folder: PathBuf,
    },
    /// Another program listens at the address.
    #[error(
        "{address}: the port is taken, perhaps by another workbench; --port N takes another, --port 0 any free one"
    )]
    Taken {
        /// Requested address.
        address: SocketAddr,
    },
    /// The server cannot listen at the address.
    #[error("{address}: {error}; an address of this machine is accepted")]
    Address {
        /// Requested address.
        address: SocketAddr,
        /// Error of the operating system.
        error: std::io::Error,
    },
    /// The folder for results cannot be written.
    #[error(transparent)]
    OutputPath(#[from] files::FileError),
    /// The system cannot provide threads or sockets.
    #[error("the server: {0}")]
    Server(#[from] std::io::Error),
}

/// Refusal of a request: its status, and words for the page.
#[derive(Debug)]
pub(crate) struct Refusal(pub(crate) StatusCode, pub(crate) String);

impl Refusal {
    /// Refuses with 404: the requested item does not exist.
    pub(crate) fn missing(words: impl Into<String>) -> Self {
        Self(StatusCode::NOT_FOUND, words.into())
    }

    /// Refuses with 422: the request is invalid.
    pub(crate) fn wrong(words: impl Into<String>) -> Self {
        Self(StatusCode::UNPROCESSABLE_ENTITY, words.into())
    }

    /// Refuses with 409: the item does not exist yet.
    pub(crate) fn early(words: impl Into<String>) -> Self {
        Self(StatusCode::CONFLICT, words.into())
    }
}

impl IntoResponse for Refusal {
    fn into_response(self) -> Response {
        (self.0, self.1).into_response()
    }
}
