//! The page's files, in the program itself.
//!
//! Each has a tag, a hash of its content: a browser that has it already asks with the tag and gets 304 instead of the
//! file. It asks each time, since a newer program brings newer files under the same names.

use std::hash::{DefaultHasher, Hasher};

use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use include_dir::{Dir, include_dir};

static FILES: Dir = include_dir!("$CARGO_MANIFEST_DIR/web");

/// Nothing from elsewhere is loaded, nothing inline is run, and no other page may frame this one.
const POLICY: &str = "default-src 'self'; connect-src 'self'; img-src 'self' blob: data:; \
                      style-src 'self' 'unsafe-inline'; frame-ancestors 'none'; base-uri 'none'; form-action 'none'";

/// A file below `web/`, or 304 where the asker's own has the same content.
pub(crate) fn file(path: &str, asked: &HeaderMap) -> Response {
    let Some(file) = FILES.get_file(path) else {
        return (StatusCode::NOT_FOUND, "there is no such file\n").into_response();
    };
    let tag = tag_of(file.contents());
    let mut headers = HeaderMap::new();
    headers.insert(header::CACHE_CONTROL, HeaderValue::from_static("no-cache"));
    let known = asked.get_all(header::IF_NONE_MATCH);
    let is_known = known.iter().any(|tags| names(tags, &tag));
    headers.insert(
        header::ETAG,
        tag.try_into().expect("hexadecimal digits in quotes"),
    );
    if is_known {
        return (StatusCode::NOT_MODIFIED, headers).into_response();
    }
    let kind = match path.rsplit_once('.').map(|(_, kind)| kind) {
        Some("html") => "text/html; charset=utf-8",
        Some("css") => "text/css; charset=utf-8",
        Some("js") => "text/javascript; charset=utf-8",
        Some("svg") => "image/svg+xml",
        Some("png") => "image/png",
        _ => "text/plain; charset=utf-8",
    };
    headers.insert(header::CONTENT_TYPE, HeaderValue::from_static(kind));
    (headers, file.contents()).into_response()
}

/// The entity tag of a content. It needs to differ from that of other versions of the file, no more: 64 bits will do.
fn tag_of(content: &[u8]) -> String {
    let mut hasher = DefaultHasher::new();
    hasher.write(content);
    format!("\"{:016x}\"", hasher.finish())
}

/// Whether a list of tags in a request has this one (RFC 9110, 13.1.2; the comparison is the weak one).
fn names(list: &HeaderValue, tag: &str) -> bool {
    let tags = list.to_str().unwrap_or_default().split(',');
    tags.map(|one| one.trim().trim_start_matches("W/"))
        .any(|one| one == tag || one == "*")
}

/// What every answer says, good or bad.
pub(crate) fn guarded(mut response: Response) -> Response {
    for (name, value) in [
        (header::CONTENT_SECURITY_POLICY, POLICY),
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (header::REFERRER_POLICY, "no-referrer"),
    ] {
        let value = HeaderValue::from_static(value);
        response.headers_mut().insert(name, value);
    }
    response
}
