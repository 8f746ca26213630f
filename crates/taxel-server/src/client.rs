//! One viewer.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;

use axum::extract::ws::{CloseFrame, Message, WebSocket, close_code};
use tokio::sync::broadcast::error::RecvError;
use tokio::time::{Instant, MissedTickBehavior, interval, sleep_until, timeout};

use crate::command::{self, Own, Watched};
use crate::messages::{Answer, Message as Text, Refused, Reply};
use crate::{Shared, ViewerBackend};

/// Frames that may be on the way to a viewer that has not said it got them.
const ON_THE_WAY: u32 = 3;
/// Frames a second for a viewer that has not said what it wants.
const USUAL_RATE: f64 = 60.0;
const RATES: std::ops::RangeInclusive<f64> = 0.1..=2000.0;
/// Messages a second that a viewer may send beside those for frames, and how many at once.
const REQUESTS_PER_SECOND: f64 = 100.0;
const REQUESTS_AT_ONCE: f64 = 200.0;
/// A viewer that takes nothing for this long is let go.
const PATIENCE: Duration = Duration::from_secs(10);
/// It is asked whether it is there this often, and let go after this much silence.
const PING_EVERY: Duration = Duration::from_secs(5);
const SILENCE: Duration = Duration::from_secs(20);
const DETAILS_EVERY: Duration = Duration::from_millis(500);

struct Viewer<'a> {
    shared: &'a Shared,
    socket: WebSocket,
    on_the_way: u32,
    rate: f64,
    due: Instant,
    heard: Instant,
    allowance: f64,
    allowed_at: Instant,
    watched: Watched,
    is_counted: bool,
}

/// Serves one viewer until it leaves.
pub(crate) async fn attend(socket: WebSocket, shared: &Shared) {
    let now = Instant::now();
    let mut viewer = Viewer {
        shared,
        socket,
        on_the_way: 0,
        rate: USUAL_RATE,
        due: now,
        heard: now,
        allowance: REQUESTS_AT_ONCE,
        allowed_at: now,
        watched: Watched::default(),
        is_counted: false,
    };
    // An ended connection needs no farewell.
    let _ = viewer.run().await;
    viewer.wait_for_frames(false);
}

/// Why it ended.
struct Gone;

impl Viewer<'_> {
    async fn run(&mut self) -> Result<(), Gone> {
        // The frame that is there already may be of a time long ago: it is none for this viewer.
        let mut frames = self.shared.frames.subscribe();
        frames.mark_unchanged();
        let mut is_new = true;
        let mut texts = self.shared.texts.subscribe();
        let mut pings = interval(PING_EVERY);
        let mut details = interval(DETAILS_EVERY);
        // Who has watched nothing for a while is not told the same over and over.
        details.set_missed_tick_behavior(MissedTickBehavior::Delay);
        let hello = Text::Hello(Box::new(self.shared.backend.hello()));
        self.say(hello.to_json()).await?;
        self.say(self.shared.state()).await?;
        if let Some(curve) = self.shared.backend.curve() {
            self.say(Text::Curve(curve).to_json()).await?;
        }
        loop {
            let has_room = self.on_the_way < ON_THE_WAY;
            // A little early is on time: sources and viewers have clocks of their own.
            let early = self.period().mul_f64(0.25);
            let is_due = self.due <= Instant::now() + early;
            self.wait_for_frames(has_room && is_due);
            if std::mem::take(&mut is_new) {
                self.shared.backend.joined();
            }
            tokio::select! {
                message = self.socket.recv() => {
                    let Some(Ok(message)) = message else { return Err(Gone) };
                    self.take(message).await?;
                }
                changed = frames.changed(), if has_room && is_due => {
                    changed.map_err(|_| Gone)?;
                    let frame = frames.borrow_and_update().clone();
                    if let Some(frame) = frame {
                        self.on_the_way += 1;
                        // On average the rate asked for, though frames come when they come.
                        let period = self.period();
                        self.due = (self.due + period).max(Instant::now() - period);
                        self.send(Message::Binary(frame.bytes())).await?;
                    }
                }
                () = sleep_until(self.due - early), if has_room && !is_due => {}
                text = texts.recv() => match text {
                    Ok(text) => self.say_shared(&text).await?,
                    // It was slow and has missed some; the next state says it all.
                    Err(RecvError::Lagged(_)) => {}
                    Err(RecvError::Closed) => return Err(Gone),
                },
                _ = details.tick(), if self.watched.is_any() => {
                    let details = self.shared.backend.details(&self.watched);
                    self.say(Text::Details(details).to_json()).await?;
                }
                _ = pings.tick() => {
                    if self.heard.elapsed() > SILENCE {
                        return Err(Gone);
                    }
                    self.send(Message::Ping(Vec::new().into())).await?;
                }
            }
        }
    }

    fn period(&self) -> Duration {
        Duration::from_secs_f64(1.0 / self.rate)
    }

    /// Counts it among those who are ready for a frame, or not.
    fn wait_for_frames(&mut self, waits: bool) {
        if waits != self.is_counted {
            self.is_counted = waits;
            if waits {
                self.shared.waiting.fetch_add(1, Ordering::Relaxed);
            } else {
                self.shared.waiting.fetch_sub(1, Ordering::Relaxed);
            }
        }
    }

    async fn take(&mut self, message: Message) -> Result<(), Gone> {
        self.heard = Instant::now();
        let text = match message {
            Message::Text(text) => text,
            Message::Close(_) => return Err(Gone),
            Message::Binary(_) => {
                return self
                    .close(close_code::UNSUPPORTED, "requests are text")
                    .await;
            }
            Message::Ping(_) | Message::Pong(_) => return Ok(()),
        };
        let (id, outcome) = match command::parse(&text) {
            Ok(command::Message::Own(Own::Got)) => {
                self.on_the_way = self.on_the_way.saturating_sub(1);
                return Ok(());
            }
            _ if !self.is_allowed() => {
                return self.close(close_code::POLICY, "too many requests").await;
            }
            Ok(command::Message::Own(own)) => {
                self.arrange(own);
                return Ok(());
            }
            Ok(command::Message::Command(id, command)) => {
                let backend = self.shared.backend.clone();
                (id, have_done(backend, command).await)
            }
            Err((id, why)) => (id, Err(Refused::because(why))),
        };
        let answer = Text::Answer(Answer::new(id, outcome));
        self.say(answer.to_json()).await?;
        self.shared.tell_all();
        Ok(())
    }

    fn arrange(&mut self, own: Own) {
        match own {
            Own::Got => {}
            Own::Rate { frames_per_second } => {
                self.rate = frames_per_second.clamp(*RATES.start(), *RATES.end());
                self.due = Instant::now();
            }
            Own::Watch(watched) => self.watched = watched,
        }
    }

    /// A bucket that fills with time: floods are cut off, a busy hand is not.
    fn is_allowed(&mut self) -> bool {
        let now = Instant::now();
        let gained = REQUESTS_PER_SECOND * (now - self.allowed_at).as_secs_f64();
        self.allowed_at = now;
        self.allowance = (self.allowance + gained).min(REQUESTS_AT_ONCE) - 1.0;
        self.allowance >= 0.0
    }

    async fn close(&mut self, code: u16, reason: &'static str) -> Result<(), Gone> {
        let frame = CloseFrame {
            code,
            reason: reason.into(),
        };
        let _ = self.send(Message::Close(Some(frame))).await;
        Err(Gone)
    }

    async fn say(&mut self, text: String) -> Result<(), Gone> {
        self.send(Message::Text(text.into())).await
    }

    async fn say_shared(&mut self, text: &Arc<str>) -> Result<(), Gone> {
        self.send(Message::Text((**text).into())).await
    }

    async fn send(&mut self, message: Message) -> Result<(), Gone> {
        match timeout(PATIENCE, self.socket.send(message)).await {
            Ok(Ok(())) => Ok(()),
            _ => Err(Gone),
        }
    }
}

/// Aside: a deed that waits for a disk holds up this viewer alone.
async fn have_done(
    backend: Arc<dyn ViewerBackend>,
    command: command::Command,
) -> Result<Reply, Refused> {
    let done = tokio::task::spawn_blocking(move || backend.command(command));
    let failed = |_| Err(Refused::because("the server failed at that"));
    done.await.unwrap_or_else(failed)
}
