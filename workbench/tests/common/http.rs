//! Raw requests, so that a test can send bytes that no browser would.

use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};

/// Response: status, head and body.
pub struct Answer {
    pub status: u16,
    pub head: String,
    pub body: String,
}

/// Sends a request with headers, one a line, and a body.
pub fn send(address: SocketAddr, line: &str, headers: &str, body: &str) -> Answer {
    let mut stream = TcpStream::connect(address).expect("the server listens");
    let length = body.len();
    let text = format!("{line} HTTP/1.1\r\nConnection: close\r\nContent-Length: {length}\r\n{headers}\r\n{body}");
    stream.write_all(text.as_bytes()).expect("the server reads");
    let mut bytes = Vec::new();
    stream.read_to_end(&mut bytes).expect("the server answers");
    let text = String::from_utf8_lossy(&bytes).into_owned();
    let (head, body) = text.split_once("\r\n\r\n").expect("a head and a body");
    let status = head.split(' ').nth(1).and_then(|status| status.parse().ok()).expect("a status");
    Answer { status, head: head.to_owned(), body: body.to_owned() }
}

/// Sends a request as the page itself would.
pub fn own(address: SocketAddr, line: &str, body: &str) -> Answer {
    let port = address.port();
    let headers = format!(
        "Host: {address}\r\nOrigin: http://{address}\r\nCookie: robofin-{port}={}\r\nContent-Type: application/json\r\n",
        super::TOKEN
    );
    send(address, line, &headers, body)
}
