//! Who may look: the token, and pages of this server alone.

use axum::http::{HeaderMap, Uri, header};
use rand::RngExt;

use crate::Shared;

/// Name of the cookie that carries the token from the page to its files: cookies know hosts, not ports.
fn cookie_name(shared: &Shared) -> String {
    format!("taxel_token_{}", shared.address.port())
}

const MIN_TOKEN_CHARS: usize = 8;
const MAX_TOKEN_CHARS: usize = 200;

/// What is wrong with a token that somebody chose; none where it will do.
pub fn token_problem(token: &str) -> Option<String> {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.' | '~');
    let length = token.chars().count();
    if let Some(other) = token.chars().find(|&c| !is_plain(c)) {
        return Some(format!(
            "the token has a '{}', which an address cannot carry",
            other.escape_default()
        ));
    }
    (!(MIN_TOKEN_CHARS..=MAX_TOKEN_CHARS).contains(&length)).then(|| {
        format!(
            "the token has {length} characters, expected {MIN_TOKEN_CHARS} to {MAX_TOKEN_CHARS}"
        )
    })
}

/// A token that nobody guesses: 128 bits.
pub fn random_token() -> String {
    let mut random = rand::rng();
    (0..32)
        .map(|_| char::from_digit(random.random_range(0..16), 16).expect("a digit"))
        .collect()
}

/// Why a request is refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Refusal {
    /// The address in the request is none of this server's: a page elsewhere has its own name lead here.
    Host,
    /// The page that asks is another server's.
    Origin,
    /// No token, or the wrong one.
    Token,
}

impl Refusal {
    pub fn words(self) -> &'static str {
        match self {
            Refusal::Host => "this server does not go by that name\n",
            Refusal::Origin => "pages of other servers may not look\n",
            Refusal::Token => {
                "a token is needed: open the address that the program printed, with its ?token=\n"
            }
        }
    }
}

/// Checks a request: the name it was sent to, the page it comes from, the token.
pub(crate) fn check(shared: &Shared, headers: &HeaderMap, uri: &Uri) -> Result<(), Refusal> {
    let text = |name| headers.get(name).and_then(|value| value.to_str().ok());
    let host = text(header::HOST).unwrap_or_default();
    if !is_own_name(shared, host) {
        return Err(Refusal::Host);
    }
    if let Some(origin) = headers.get(header::ORIGIN) {
        let origin = origin.to_str().unwrap_or_default();
        let own = ["http://", "https://"].iter().any(|scheme| {
            origin
                .strip_prefix(scheme)
                .is_some_and(|rest| rest.eq_ignore_ascii_case(host))
        });
        if !own {
            return Err(Refusal::Origin);
        }
    }
    check_token(shared, headers, uri)
}

/// Checks the token alone.
pub(crate) fn check_token(shared: &Shared, headers: &HeaderMap, uri: &Uri) -> Result<(), Refusal> {
    let Some(token) = &shared.token else {
        return Ok(());
    };
    let given = token_in_query(uri).or_else(|| token_in_cookie(&cookie_name(shared), headers));
    if given.is_some_and(|given| same(given, token)) {
        Ok(())
    } else {
        Err(Refusal::Token)
    }
}

/// The header that keeps the token for the page's files, if the query has it.
pub(crate) fn cookie(shared: &Shared, uri: &Uri) -> Option<String> {
    let token = shared.token.as_deref()?;
    token_in_query(uri)
        .filter(|given| same(given, token))
        .map(|token| {
            format!(
                "{}={token}; HttpOnly; SameSite=Strict; Path=/",
                cookie_name(shared)
            )
        })
}

fn token_in_query(uri: &Uri) -> Option<&str> {
    uri.query()?
        .split('&')
        .find_map(|part| part.strip_prefix("token="))
}

fn token_in_cookie<'a>(name: &str, headers: &'a HeaderMap) -> Option<&'a str> {
    headers
        .get_all(header::COOKIE)
        .iter()
        .filter_map(|value| value.to_str().ok())
        .flat_map(|line| line.split(';'))
        .find_map(|part| part.trim().strip_prefix(name)?.strip_prefix('='))
}

/// Whether two secrets are the same; how long it takes does not tell where they differ.
fn same(a: &str, b: &str) -> bool {
    let differs = a
        .bytes()
        .zip(b.bytes())
        .fold(0, |sum, (a, b)| sum | (a ^ b));
    a.len() == b.len() && differs == 0
}

/// On loopback its names and numbers, with the port. Beyond it any number, or a name without dots or in `.local`, as
/// laboratories have them; the token guards the rest.
fn is_own_name(shared: &Shared, host: &str) -> bool {
    let port = shared.address.port();
    let name = match host.strip_suffix(&format!(":{port}")) {
        Some(name) => name,
        None if port == 80 => host,
        None => return false,
    };
    let name = name.to_ascii_lowercase();
    if ["localhost", "127.0.0.1", "[::1]"].contains(&name.as_str()) {
        return true;
    }
    if shared.address.ip().is_loopback() {
        return false;
    }
    let number = name.trim_start_matches('[').trim_end_matches(']');
    number.parse::<std::net::IpAddr>().is_ok() || !name.contains('.') || name.ends_with(".local")
}
