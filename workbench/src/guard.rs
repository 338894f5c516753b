//! Access control: requests are answered only with the token, and only from the workbench's own page.
//!
//! The token is sent once in the printed address, and afterwards in a cookie that no other site's page can send. The
//! `Host` header must name this machine, so that a foreign name resolved to it is refused (DNS rebinding). A request
//! that changes something must have an `Origin` of the same host.

use std::net::IpAddr;
use std::sync::Arc;

use axum::extract::{Request, State};
use axum::http::header::{CONTENT_SECURITY_POLICY, COOKIE, HOST, LOCATION, ORIGIN, REFERRER_POLICY, SET_COOKIE};
use axum::http::{HeaderMap, HeaderName, HeaderValue, Method, StatusCode};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};

/// Content security policy of the pages: content from this server only.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; \
                      connect-src 'self'; form-action 'self'; frame-ancestors 'none'; base-uri 'none'";

/// Values that a request is checked against.
#[derive(Clone)]
pub(crate) struct Guard {
    token: Arc<str>,
    cookie: Arc<str>,
    address: IpAddr,
}

impl Guard {
    /// Makes the guard of a server at an address.
    ///
    /// - `port`: part of the cookie's name, because all ports of a host share their cookies
    pub(crate) fn new(token: &str, address: IpAddr, port: u16) -> Self {
        Self { token: token.into(), cookie: format!("robofin-{port}").into(), address }
    }

    /// Returns true if the `Host` header names this machine; the port is ignored, because a tunnel changes it.
    fn is_own_host(&self, headers: &HeaderMap) -> bool {
        let Some(host) = text(headers, &HOST) else { return false };
        let name = match host.rsplit_once(':') {
            Some((name, port)) if port.bytes().all(|b| b.is_ascii_digit()) => name,
            _ => host,
        };
        let name = name.trim_start_matches('[').trim_end_matches(']');
        let is_own = |ip: IpAddr| ip.is_loopback() || ip == self.address || self.address.is_unspecified();
        name == "localhost" || name.parse::<IpAddr>().is_ok_and(is_own)
    }

    /// Returns true if a request comes from a page of this server. A plain visit (GET, HEAD) has no `Origin` header.
    fn is_own_origin(method: &Method, headers: &HeaderMap) -> bool {
        let (origin, host) = (text(headers, &ORIGIN), text(headers, &HOST).unwrap_or_default());
        match origin {
            Some(origin) => origin == format!("http://{host}"),
            None => method == Method::GET || method == Method::HEAD,
        }
    }

    fn has_cookie(&self, headers: &HeaderMap) -> bool {
        let cookies = headers.get_all(COOKIE).iter().filter_map(|value| value.to_str().ok());
        let mut pairs = cookies.flat_map(|value| value.split(';')).filter_map(|pair| pair.trim().split_once('='));
        pairs.any(|(name, value)| name == &*self.cookie && self.is_token(value))
    }

    /// Compares with the token in constant time.
    fn is_token(&self, given: &str) -> bool {
        let (own, given) = (self.token.as_bytes(), given.as_bytes());
        own.len() == given.len() && own.iter().zip(given).fold(0, |differ, (a, b)| differ | (a ^ b)) == 0
    }

    /// Redirects to the page without the token, so that the token stays out of the browser's history.
    fn welcome(&self, path: &str) -> Response {
        let cookie = format!("{}={}; Path=/; HttpOnly; SameSite=Strict", self.cookie, self.token);
        (StatusCode::SEE_OTHER, [(SET_COOKIE, cookie), (LOCATION, path.to_owned())]).into_response()
    }
}

/// Refuses requests without the token or from another page.
pub(crate) async fn check(State(guard): State<Guard>, request: Request, next: Next) -> Response {
    let (method, headers) = (request.method(), request.headers());
    if !guard.is_own_host(headers) || !Guard::is_own_origin(method, headers) {
        return (StatusCode::FORBIDDEN, "this workbench answers only its own page").into_response();
    }
    let query = request.uri().query().unwrap_or_default();
    let given = query.split('&').find_map(|pair| pair.strip_prefix("token="));
    if given.is_some_and(|given| guard.is_token(given)) && method == Method::GET {
        return closed(guard.welcome(request.uri().path()));
    }
    if !guard.has_cookie(headers) {
        let words = "no token: open the address that `robofin workbench` has printed, with everything after the ?";
        return (StatusCode::FORBIDDEN, words).into_response();
    }
    closed(next.run(request).await)
}

/// Sets headers that forbid other pages to use an answer; an answer keeps a policy of its own.
fn closed(mut answer: Response) -> Response {
    let headers = answer.headers_mut();
    let mut set = |name: HeaderName, value: &'static str| {
        headers.entry(name).or_insert(HeaderValue::from_static(value));
    };
    set(CONTENT_SECURITY_POLICY, POLICY);
    set(REFERRER_POLICY, "no-referrer");
    set(HeaderName::from_static("x-content-type-options"), "nosniff");
    set(HeaderName::from_static("cross-origin-resource-policy"), "same-origin");
    set(axum::http::header::CACHE_CONTROL, "no-store");
    answer
}

fn text<'h>(headers: &'h HeaderMap, name: &HeaderName) -> Option<&'h str> {
    headers.get(name).and_then(|value| value.to_str().ok())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn headers(pairs: &[(HeaderName, &str)]) -> HeaderMap {
        pairs.iter().map(|(name, value)| (name.clone(), HeaderValue::from_str(value).unwrap())).collect()
    }

    #[test]
    fn only_names_of_this_machine_are_its_host() {
        let guard = Guard::new("abc", IpAddr::from([127, 0, 0, 1]), 80);
        for (host, is_own) in [
            ("localhost:9000", true),
            ("127.0.0.1:4747", true),
            ("[::1]:4747", true),
            ("127.0.0.1.evil.example:4747", false),
            ("evil.example", false),
            ("192.168.0.7:4747", false),
            ("", false),
        ] {
            assert_eq!(guard.is_own_host(&headers(&[(HOST, host)])), is_own, "{host}");
        }
    }

    #[test]
    fn what_changes_something_needs_the_origin_of_the_page() {
        let of = |origin: Option<&str>, method: Method| {
            let mut pairs = vec![(HOST, "localhost:4747")];
            pairs.extend(origin.map(|origin| (ORIGIN, origin)));
            Guard::is_own_origin(&method, &headers(&pairs))
        };
        assert!(of(None, Method::GET) && of(Some("http://localhost:4747"), Method::POST));
        assert!(!of(None, Method::POST) && !of(Some("http://evil.example"), Method::GET));
        assert!(!of(Some("null"), Method::POST) && !of(Some("http://localhost:4748"), Method::POST));
    }

    #[test]
    fn a_token_is_whole_or_none() {
        let guard = Guard::new("0123456789abcdef", IpAddr::from([127, 0, 0, 1]), 4747);
        let of = |cookie: &str| guard.has_cookie(&headers(&[(COOKIE, cookie)]));
        assert!(of("a=b; robofin-4747=0123456789abcdef"));
        for wrong in ["robofin-4747=", "robofin-4747=0123456789abcde", "robofin-80=0123456789abcdef", "x", ""] {
            assert!(!of(wrong), "{wrong}");
        }
    }
}
