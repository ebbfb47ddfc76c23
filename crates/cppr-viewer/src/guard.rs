//! Who may talk to the server: requests to the loopback address, under the secret path, from the server's own
//! page. Another site open in the same browser, or a name that was made to point to this computer, is turned away.

use axum::http::{HeaderMap, header};

/// A path that cannot be guessed: 128 random bits.
pub fn token() -> std::io::Result<String> {
    let mut bytes = [0_u8; 16];
    getrandom::fill(&mut bytes).map_err(std::io::Error::other)?;
    Ok(format!("{:032x}", u128::from_le_bytes(bytes)))
}

/// Is the request meant for this server by its own page? A page of another origin, or a name that
/// resolves to the loopback address, shows in these headers.
pub fn is_own(headers: &HeaderMap, port: u16) -> bool {
    let value = |name| headers.get(name).map(|v| v.to_str().unwrap_or_default());
    let own = |host: &str| host == format!("127.0.0.1:{port}") || host == format!("localhost:{port}");
    value(header::HOST).is_some_and(own)
        && value(header::ORIGIN).is_none_or(|origin| origin.strip_prefix("http://").is_some_and(own))
}

#[cfg(test)]
mod tests {
    use super::{is_own, token};
    use axum::http::{HeaderMap, HeaderValue, header};

    fn headers(host: &str, origin: Option<&str>) -> HeaderMap {
        let mut map = HeaderMap::new();
        map.insert(header::HOST, HeaderValue::from_str(host).unwrap());
        if let Some(origin) = origin {
            map.insert(header::ORIGIN, HeaderValue::from_str(origin).unwrap());
        }
        map
    }

    #[test]
    fn only_the_own_page_is_answered() {
        assert!(is_own(&headers("127.0.0.1:8000", None), 8000));
        assert!(is_own(&headers("localhost:8000", Some("http://localhost:8000")), 8000));
        for (host, origin) in [
            ("127.0.0.1:8001", None),
            ("127.0.0.1", None),
            ("evil.example:8000", None),
            ("127.0.0.1:8000", Some("http://evil.example")),
            ("127.0.0.1:8000", Some("http://127.0.0.1:8001")),
            ("127.0.0.1:8000", Some("https://127.0.0.1:8000")),
            ("127.0.0.1:8000", Some("null")),
        ] {
            assert!(!is_own(&headers(host, origin), 8000), "{host} {origin:?}");
        }
        assert!(!is_own(&HeaderMap::new(), 8000));
    }

    #[test]
    fn tokens_differ() {
        let (one, other) = (token().unwrap(), token().unwrap());
        assert_eq!(one.len(), 32);
        assert_ne!(one, other);
    }
}
