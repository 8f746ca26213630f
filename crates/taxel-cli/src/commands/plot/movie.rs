//! Frames as a movie: every frame a map over the same range, at the recording's own pace.

use taxel::{Frame, Mark};
use taxel_io::AtomicFile;
use taxel_plot::{Movie, Picture, Sheet};

use super::Job;
use super::collect::{Pass, Stages, each};
use super::draw::{COMPENSATED, RAW, caption, panel, present, with};
use super::look::{Beyond, ValueRange};
use crate::error::Error;
use crate::out;
use taxel_app::frames::DisplayUnit;

/// Time between pictures, hundredths of a second, no less on average: viewers slow down what has more than 25 a second.
const LEAST: u16 = 4;
/// Of a step between pictures that rounding of times may take.
const SLACK: f64 = 1e-6;
/// Most pictures of a movie: more than three minutes.
const MOST_PICTURES: u64 = 5000;

/// When each frame is shown.
#[derive(Debug, Clone)]
struct Pace {
    speed: f64,
    /// What the frame before told, seconds.
    before: Option<f64>,
    /// Of this frame in the movie, hundredths; none before the first.
    clock: Option<f64>,
    /// From when on the next picture may be shown, hundredths.
    next: f64,
    /// When the last picture was shown, whole hundredths.
    shown: f64,
    /// Whether a frame has told no time.
    timeless: bool,
}

impl Pace {
    fn new(speed: f64) -> Self {
        Self {
            speed,
            before: None,
            clock: None,
            next: f64::from(LEAST),
            shown: 0.0,
            timeless: false,
        }
    }

    /// For how many hundredths the picture before this frame is shown; none where this frame comes too soon to be shown
    /// itself. The first frame is shown, and gives the least time.
    fn take(&mut self, time: Option<f64>) -> Option<u16> {
        let least = f64::from(LEAST);
        self.timeless |= time.is_none();
        let before = self.before;
        self.before = time.or(before);
        let Some(clock) = self.clock else {
            self.clock = Some(0.0);
            return Some(LEAST);
        };
        let step = match (time, before) {
            (Some(time), Some(before)) if time >= before => (time - before) * 100.0,
            // Without a clock, or where it goes back, as if 25 frames were read a second.
            _ => least,
        };
        let clock = clock + step / self.speed;
        self.clock = Some(clock);
        if clock + SLACK < self.next {
            return None;
        }
        // After a pause it does not catch up.
        self.next = (self.next + least).max(clock + SLACK);
        let delay = clock.round() - self.shown;
        self.shown = clock.round();
        Some(delay.clamp(1.0, f64::from(u16::MAX)) as u16)
    }
}

/// What must be known of all pictures before the first is drawn.
struct Ahead {
    pictures: u64,
    range: ValueRange,
    beyond: Option<String>,
}

/// Writes the movie: once through the frames for their range, and once more to draw them, one at a time.
pub(super) fn write(job: &Job<'_>, file: &mut AtomicFile) -> Result<(), Error> {
    let ahead = look_ahead(job)?;
    if ahead.pictures > MOST_PICTURES {
        return Err(Error::Arguments {
            what: format!(
                "a movie of {} pictures is over the limit of {MOST_PICTURES}",
                ahead.pictures
            ),
            hint: "show fewer frames, with --frames, or show them faster, with --speed",
        });
    }
    let caption = with(caption(job), ahead.beyond);
    let mut pace = Pace::new(speed(job));
    let mut reel: Option<Movie> = None;
    // How long it is shown is known when the next one comes.
    let mut held: Option<Picture> = None;
    let mut last = LEAST;
    each(job, Pass::Again, |number, stages| {
        let Some(delay) = pace.take(time_of(&stages)) else {
            return Ok(());
        };
        let picture = job
            .args
            .look
            .moving(compose(job, number, &stages, ahead.range, &caption)?);
        if let (Some(movie), Some(held)) = (&mut reel, &held) {
            file.put(&movie.push(held, delay)?)?;
            last = delay;
        } else {
            let (movie, head) = Movie::new(&picture)?;
            file.put(&head)?;
            reel = Some(movie);
        }
        held = Some(picture);
        Ok(())
    })?;
    if let (Some(mut movie), Some(held)) = (reel, held) {
        file.put(&movie.push(&held, last)?)?;
        file.put(&movie.end()?)?;
    }
    Ok(())
}

fn speed(job: &Job<'_>) -> f64 {
    job.args.look.speed.unwrap_or(1.0)
}

fn time_of(stages: &Stages<'_>) -> Option<f64> {
    stages
        .compensated
        .or(stages.raw)
        .and_then(|frame| frame.time_secs)
}

/// Range and number of the pictures, by all frames that are shown.
fn look_ahead(job: &Job<'_>) -> Result<Ahead, Error> {
    let mut pace = Pace::new(speed(job));
    let asked = job.args.look.range;
    let mut beyond = asked.map(Beyond::new);
    let mut pictures = 0;
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    each(job, Pass::First, |_, stages| {
        if pace.take(time_of(&stages)).is_none() {
            return Ok(());
        }
        pictures += 1;
        for frame in [stages.raw, stages.compensated].into_iter().flatten() {
            if let Some(beyond) = &mut beyond {
                beyond.count(present(frame));
            }
            for value in present(frame).filter(|value| value.is_finite()) {
                (low, high) = (low.min(value), high.max(value));
            }
        }
        Ok(())
    })?;
    if pace.timeless {
        let file = job.args.file.display();
        out::note(&format!(
            "{file} does not tell when frames were read: shown as if 25 a second"
        ));
    }
    let range = match asked {
        Some(range) => range,
        None if low > high => ValueRange {
            low: 0.0,
            high: 1.0,
        },
        // As pictures do: from 0 where the lowest is next to it.
        None if low > 0.0 && low <= 0.05 * high => ValueRange { low: 0.0, high },
        None => ValueRange { low, high },
    };
    Ok(Ahead {
        pictures,
        range,
        beyond: beyond.and_then(|beyond| beyond.told(job.symbol())),
    })
}

/// One picture, laid out as every other: what changes from frame to frame changes no size.
fn compose(
    job: &Job<'_>,
    number: u64,
    stages: &Stages<'_>,
    range: ValueRange,
    caption: &str,
) -> Result<Picture, Error> {
    let both = stages.raw.is_some() && stages.compensated.is_some();
    let given = [(RAW, stages.raw), (COMPENSATED, stages.compensated)];
    let plain: Vec<(&str, Frame<DisplayUnit>)> = given
        .into_iter()
        .filter_map(|(word, frame)| Some((if both { word } else { "" }, unmarked(frame?))))
        .collect();
    let panels = plain
        .iter()
        .map(|(word, frame)| Ok(panel(job, word, frame)?.range(range.low, range.high)))
        .collect::<Result<Vec<_>, Error>>()?;
    let own = job.args.look.title.as_deref().unwrap_or_default();
    let when = match time_of(stages) {
        Some(time) => format!("{time:.2} s, frame {number}"),
        None => format!("frame {number}"),
    };
    let mut sheet = Sheet::new(panels)?
        .shared_range(true)
        .title(format!("{own}\n{when}"))
        .caption(caption);
    if let Some(extent) = job.extent {
        sheet = sheet.fit(extent);
    }
    Ok(sheet.picture()?)
}

/// Without outlines, which are counted below a map: maps would jump as their number changes.
fn unmarked(frame: &Frame<DisplayUnit>) -> Frame<DisplayUnit> {
    let mut plain = frame.clone();
    for mark in plain.marks_mut() {
        if *mark != Mark::Absent {
            *mark = Mark::Good;
        }
    }
    plain
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The delays of the pictures that are shown of frames at these times.
    fn delays(speed: f64, times: impl IntoIterator<Item = Option<f64>>) -> Vec<u16> {
        let mut pace = Pace::new(speed);
        let shown = times.into_iter().filter_map(|time| pace.take(time));
        shown.skip(1).collect()
    }

    fn at(per_second: f64, count: u32) -> impl Iterator<Item = Option<f64>> {
        (0..count).map(move |i| Some(3.0 + f64::from(i) / per_second))
    }

    #[test]
    fn a_slow_recording_keeps_its_pace_and_a_fast_one_has_25_pictures_a_second() {
        assert_eq!(delays(1.0, at(10.0, 5)), [10; 4]);
        assert_eq!(delays(1.0, at(25.0, 5)), [4; 4]);
        assert_eq!(delays(1.0, at(1000.0, 201)), [4; 5]);
        for per_second in [30.0, 60.0, 77.0, 240.0] {
            let delays = delays(1.0, at(per_second, 10 * per_second as u32 + 1));
            let total: u32 = delays.iter().map(|&delay| u32::from(delay)).sum();
            assert!((995..=1000).contains(&total), "{per_second}: {total}");
            assert!((230..=250).contains(&delays.len()), "{}", delays.len());
        }
    }

    #[test]
    fn speed_shortens_time_and_lets_frames_out() {
        assert_eq!(delays(2.0, at(10.0, 5)), [5; 4]);
        assert_eq!(delays(10.0, at(10.0, 9)), [4, 4]);
        assert_eq!(delays(0.5, at(10.0, 3)), [20, 20]);
    }

    #[test]
    fn without_times_or_where_they_go_back_25_frames_are_a_second() {
        assert_eq!(delays(1.0, [None; 4]), [4; 3]);
        assert_eq!(delays(0.5, [None; 3]), [8; 2]);
        let back = [0.0, 0.1, 0.2, 0.0, 0.1].map(Some);
        assert_eq!(delays(1.0, back), [10, 10, 4, 10]);
        let pause = [0.0, 1e6, 1e6 + 0.1].map(Some);
        assert_eq!(delays(1.0, pause), [u16::MAX, 10]);
    }
}
