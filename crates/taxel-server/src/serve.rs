//! Connections in, pages and WebSockets out.

use std::sync::Arc;
use std::time::Duration;

use axum::extract::ws::{CloseFrame, Message, WebSocketUpgrade};
use axum::extract::{Path, Request, State};
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::middleware::{self, Next};
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use axum::{Extension, Router};
use tokio::net::TcpListener;
use tokio::sync::oneshot;

use crate::connections::{Connections, Known};
use crate::guard::{self, Refusal};
use crate::{Shared, assets, client};

/// How often all viewers are told how things stand.
const STATE_EVERY: Duration = Duration::from_millis(500);
/// The longest message that a viewer may send.
const MAX_MESSAGE_BYTES: usize = 16 * 1024;
/// What a WebSocket without the token is closed with.
const NO_TOKEN: u16 = 4401;

/// Serves until it is told to stop.
pub(crate) async fn serve(
    listener: std::net::TcpListener,
    shared: Arc<Shared>,
    stopped: oneshot::Receiver<()>,
) {
    let Ok(listener) = TcpListener::from_std(listener) else {
        return;
    };
    let router = Router::new()
        .route("/", get(page))
        .route("/model", get(model_page))
        .route("/grip", get(grip_page))
        .route("/calibrate", get(calibrate_page))
        .route("/beside", get(beside_page))
        .route("/beside/live", get(live_beside))
        .route("/results/{name}", get(result_file))
        .route("/assets/{*path}", get(asset))
        .route("/live", get(live))
        .layer(middleware::from_fn_with_state(shared.clone(), check))
        .with_state(shared.clone());
    let connections = Connections::default();
    tokio::select! {
        _ = stopped => {}
        () = accept(&listener, &router, &connections) => {}
        () = tell_state(&shared) => {}
    }
}

async fn accept(listener: &TcpListener, router: &Router, connections: &Connections) {
    loop {
        let Ok((stream, from)) = listener.accept().await else {
            // Out of file descriptors, mostly: others will be closed.
            tokio::time::sleep(Duration::from_millis(50)).await;
            continue;
        };
        let _ = stream.set_nodelay(true);
        connections.take(stream, from.ip(), router);
    }
}

async fn tell_state(shared: &Shared) {
    let mut ticks = tokio::time::interval(STATE_EVERY);
    loop {
        ticks.tick().await;
        shared.tell_all();
    }
}

/// Refuses what comes from elsewhere, and lets go who asks for what is not there. A WebSocket without the token is
/// answered first, so that its page learns why.
async fn check(
    State(shared): State<Arc<Shared>>,
    Extension(known): Extension<Known>,
    request: Request,
    next: Next,
) -> Response {
    let mut response = match guard::check(&shared, request.headers(), request.uri()) {
        Err(Refusal::Token) if ["/live", "/beside/live"].contains(&request.uri().path()) => {
            next.run(request).await
        }
        Err(refusal) => {
            let status = match refusal {
                Refusal::Token => StatusCode::UNAUTHORIZED,
                _ => StatusCode::FORBIDDEN,
            };
            (status, refusal.words()).into_response()
        }
        Ok(()) => {
            known.set();
            next.run(request).await
        }
    };
    if response.status().is_client_error() {
        let close = HeaderValue::from_static("close");
        response.headers_mut().insert(header::CONNECTION, close);
    }
    assets::guarded(response)
}

async fn page(State(shared): State<Arc<Shared>>, request: Request) -> Response {
    page_of("index.html", &shared, &request)
}

async fn model_page(State(shared): State<Arc<Shared>>, request: Request) -> Response {
    page_of("model.html", &shared, &request)
}

async fn grip_page(State(shared): State<Arc<Shared>>, request: Request) -> Response {
    page_of("grip.html", &shared, &request)
}

async fn calibrate_page(State(shared): State<Arc<Shared>>, request: Request) -> Response {
    page_of("calibrate.html", &shared, &request)
}

async fn beside_page(State(shared): State<Arc<Shared>>, request: Request) -> Response {
    page_of("beside.html", &shared, &request)
}

/// A file of results, from a thread that may wait for the disk.
async fn result_file(State(shared): State<Arc<Shared>>, Path(name): Path<String>) -> Response {
    let backend = shared.backend.clone();
    let found = tokio::task::spawn_blocking(move || backend.result_file(&name)).await;
    match found.ok().flatten() {
        Some(file) => ([(header::CONTENT_TYPE, file.kind)], file.bytes).into_response(),
        None => (StatusCode::NOT_FOUND, "there is no such file\n").into_response(),
    }
}

/// A page, with the cookie that its files need.
fn page_of(file: &str, shared: &Shared, request: &Request) -> Response {
    let mut response = assets::file(file, request.headers());
    let cookie = guard::cookie(shared, request.uri());
    if let Some(cookie) = cookie.and_then(|cookie| HeaderValue::from_str(&cookie).ok()) {
        response.headers_mut().insert(header::SET_COOKIE, cookie);
    }
    response
}

async fn asset(Path(path): Path<String>, headers: HeaderMap) -> Response {
    assets::file(&path, &headers)
}

async fn live(
    State(shared): State<Arc<Shared>>,
    upgrade: WebSocketUpgrade,
    request: Request,
) -> Response {
    let may = guard::check_token(&shared, request.headers(), request.uri());
    attend(shared, may, upgrade)
}

/// What stands beside: looked at by whoever may look here.
async fn live_beside(
    State(shared): State<Arc<Shared>>,
    upgrade: WebSocketUpgrade,
    request: Request,
) -> Response {
    let may = guard::check_token(&shared, request.headers(), request.uri());
    match shared.beside.get() {
        Some(other) => attend(other.clone(), may, upgrade),
        None => (StatusCode::NOT_FOUND, "there is nothing beside\n").into_response(),
    }
}

/// Gives a viewer a seat, or says why there is none.
fn attend(shared: Arc<Shared>, may: Result<(), Refusal>, upgrade: WebSocketUpgrade) -> Response {
    let Ok(seat) = shared.viewers.clone().try_acquire_owned() else {
        let words = "too many viewers: close one\n";
        return (StatusCode::SERVICE_UNAVAILABLE, words).into_response();
    };
    upgrade
        .max_message_size(MAX_MESSAGE_BYTES)
        .max_frame_size(MAX_MESSAGE_BYTES)
        .on_upgrade(async move |mut socket| {
            if may.is_err() {
                let close = CloseFrame {
                    code: NO_TOKEN,
                    reason: "the token is missing or wrong".into(),
                };
                let _ = socket.send(Message::Close(Some(close))).await;
                return;
            }
            client::attend(socket, &shared).await;
            drop(seat);
        })
}
