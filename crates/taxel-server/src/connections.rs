//! Connections: how many there may be, and who has to go when there are too many.
//!
//! Strangers cannot keep viewers out: one who has shown no right to look gives way to who comes later. Viewers are not
//! counted here once they look: their seats are their own.

use std::collections::VecDeque;
use std::io;
use std::net::IpAddr;
use std::pin::Pin;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::task::{Context, Poll};
use std::time::Duration;

use axum::{Extension, Router};
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::net::TcpStream;
use tokio::task::AbortHandle;
use tokio::time::{Sleep, sleep};

/// The most connections at once, pages and their files included; and of one address.
const MAX_OPEN: usize = 96;
const MAX_OF_ONE: usize = 48;
/// A connection that asks for nothing in this time is closed.
const HEADERS_WITHIN: Duration = Duration::from_secs(10);
/// One that takes nothing for this long, too.
const TAKEN_WITHIN: Duration = Duration::from_secs(10);

/// Set once a request of a connection was allowed.
#[derive(Clone, Default)]
pub(crate) struct Known(Arc<AtomicBool>);

impl Known {
    pub fn set(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    fn is_set(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

struct One {
    from: IpAddr,
    known: Known,
    task: AbortHandle,
}

/// Those that are open, the oldest first.
#[derive(Default)]
pub(crate) struct Connections {
    open: Mutex<VecDeque<One>>,
}

impl Connections {
    /// Serves a connection, if there is room or somebody has to make some.
    pub fn take(&self, stream: TcpStream, from: IpAddr, router: &Router) {
        let mut open = self.open.lock().unwrap_or_else(PoisonError::into_inner);
        open.retain(|one| !one.task.is_finished());
        let of_one = open.iter().filter(|one| one.from == from).count();
        let crowded = of_one >= MAX_OF_ONE;
        if crowded || open.len() >= MAX_OPEN {
            let gives_way = |one: &One| !one.known.is_set() && (!crowded || one.from == from);
            let Some(at) = open.iter().position(gives_way) else {
                return;
            };
            if let Some(one) = open.remove(at) {
                one.task.abort();
            }
        }
        let known = Known::default();
        let service = TowerToHyperService::new(router.clone().layer(Extension(known.clone())));
        let task = tokio::spawn(async move {
            let connection = hyper::server::conn::http1::Builder::new()
                .timer(TokioTimer::new())
                .header_read_timeout(HEADERS_WITHIN)
                .serve_connection(TokioIo::new(Timed::new(stream)), service)
                .with_upgrades();
            // Whatever a client does wrong ends its own connection.
            let _ = connection.await;
        });
        open.push_back(One {
            from,
            known,
            task: task.abort_handle(),
        });
    }
}

/// A stream whose other end has to take what is written to it.
struct Timed {
    stream: TcpStream,
    due: Option<Pin<Box<Sleep>>>,
}

impl Timed {
    fn new(stream: TcpStream) -> Self {
        Self { stream, due: None }
    }

    /// An error where the other end has taken nothing for too long.
    fn in_time<T>(
        &mut self,
        context: &mut Context,
        written: Poll<io::Result<T>>,
    ) -> Poll<io::Result<T>> {
        if written.is_ready() {
            self.due = None;
            return written;
        }
        let due = self
            .due
            .get_or_insert_with(|| Box::pin(sleep(TAKEN_WITHIN)));
        match due.as_mut().poll(context) {
            Poll::Ready(()) => Poll::Ready(Err(io::ErrorKind::TimedOut.into())),
            Poll::Pending => Poll::Pending,
        }
    }
}

impl AsyncRead for Timed {
    fn poll_read(
        mut self: Pin<&mut Self>,
        context: &mut Context,
        into: &mut ReadBuf,
    ) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_read(context, into)
    }
}

impl AsyncWrite for Timed {
    fn poll_write(
        mut self: Pin<&mut Self>,
        context: &mut Context,
        bytes: &[u8],
    ) -> Poll<io::Result<usize>> {
        let written = Pin::new(&mut self.stream).poll_write(context, bytes);
        self.in_time(context, written)
    }

    fn poll_write_vectored(
        mut self: Pin<&mut Self>,
        context: &mut Context,
        bytes: &[io::IoSlice],
    ) -> Poll<io::Result<usize>> {
        let written = Pin::new(&mut self.stream).poll_write_vectored(context, bytes);
        self.in_time(context, written)
    }

    fn is_write_vectored(&self) -> bool {
        self.stream.is_write_vectored()
    }

    fn poll_flush(mut self: Pin<&mut Self>, context: &mut Context) -> Poll<io::Result<()>> {
        let flushed = Pin::new(&mut self.stream).poll_flush(context);
        self.in_time(context, flushed)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, context: &mut Context) -> Poll<io::Result<()>> {
        let shut = Pin::new(&mut self.stream).poll_shutdown(context);
        self.in_time(context, shut)
    }
}
