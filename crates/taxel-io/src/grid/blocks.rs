//! Many frames of plain lines at once, by several threads. Where a line is of another kind, its frame and what follows are left
//! as they were, for the careful reader.

use std::io::{self, Read};
use std::ops::Range;

use taxel::Executor;

use super::pieces::{Pieces, Wanted};
use super::{Extra, Grid};
use crate::error::Error;
use crate::number::Rule;

/// Numbers of a frame of which several fit into what is read at once.
const MOST_NUMBERS: usize = 1 << 16;
/// After a frame that was not plain so many are read carefully before it is tried again, at most.
const MOST_CAREFUL: u32 = 64;

/// What is kept from one block to the next.
#[derive(Default)]
pub(super) struct Plain {
    pieces: Pieces,
    /// Frames to be read carefully from now on, and how many it will be after the next one that is not plain.
    careful: u32,
    next_careful: u32,
    /// Whether a block was begun and not ended: who wanted no more unwound out of it, and what was read of it is gone.
    is_stopped: bool,
}

impl<R: Read + Send> Grid<R> {
    /// Reads plain frames, at most so many, behind `out`: their positions. `left`: bytes of the text that are left, where that is
    /// known. Who unwinds out of the executor has lost the frames, and cannot read on.
    pub(crate) fn next_counts(
        &mut self,
        (most, left): (usize, Option<u64>),
        out: &mut Vec<u16>,
        executor: &dyn Executor,
    ) -> Result<Range<u64>, Error> {
        self.check_stopped()?;
        let first = self.frame;
        if self.plain.careful > 0 {
            self.plain.careful -= 1;
            return Ok(first..first);
        }
        // The first frame tells whether a line stands before each; where none does, all lines are alike.
        let is_bare = self.frame > 0 && matches!(self.extra, Extra::Bare | Extra::Never);
        let numbers = self.frame_lines * self.line_numbers;
        if !is_bare || self.done || self.options.transpose || numbers > MOST_NUMBERS {
            return Ok(first..first);
        }
        while let wanted = most - (self.frame - first) as usize
            && wanted > 0
            && self.block((wanted, left), out, executor)?
        {}
        Ok(first..self.frame)
    }

    /// Reads plain frames, at most so many; whether there may be more.
    fn block(
        &mut self,
        (wanted, left): (usize, Option<u64>),
        out: &mut Vec<u16>,
        executor: &dyn Executor,
    ) -> Result<bool, Error> {
        let Rule::Counts { maximum } = self.rule else {
            return Ok(false);
        };
        let bytes = self.lines.bytes();
        let text = Wanted {
            columns: self.line_numbers,
            frame_lines: self.frame_lines,
            most: maximum.min(f64::from(u16::MAX)) as u16,
            lines: wanted.saturating_mul(self.frame_lines),
            // By the frames so far.
            bytes: (wanted as u64)
                .saturating_mul(self.frame_bytes().unwrap_or(0))
                .min(left.unwrap_or(u64::MAX)),
        };
        let Some(from) = self.lines.held() else {
            return Ok(false);
        };
        let begun = out.len();
        self.plain.is_stopped = true;
        let found = self.plain.pieces.read(from, &text, out, executor);
        self.plain.is_stopped = false;
        let mut found = found.map_err(|source| self.unreadable(bytes, source))?;
        let frames = (found.lines / self.frame_lines).min(wanted);
        let lines = frames * self.frame_lines;
        out.truncate(begun + lines * self.line_numbers);
        let (bytes, comma) = found.keep(lines);
        if frames > 0 {
            self.extra = Extra::Never;
            self.commas = comma;
            self.frame += frames as u64;
        }
        let rest = found.rest().chain([&self.plain.pieces.tail[..]]);
        self.lines.put_back(bytes, lines, rest);
        let (is_plain, has_ended) = (found.is_plain && frames > 0, found.has_ended);
        self.plain.pieces.free(found);
        self.plain.was(is_plain);
        Ok(is_plain && !has_ended)
    }
}

impl<R: Read> Grid<R> {
    pub(super) fn check_stopped(&mut self) -> Result<(), Error> {
        if !self.plain.is_stopped {
            return Ok(());
        }
        let bytes = self.lines.bytes();
        let source = io::Error::other("reading was stopped before, and what was read then is gone");
        Err(self.unreadable(bytes, source))
    }

    pub(super) fn unreadable(&mut self, bytes: u64, source: io::Error) -> Error {
        self.done = true;
        Error::Read {
            file: self.file.clone(),
            bytes,
            source,
        }
    }
}

impl Plain {
    /// Where frames of another kind come again and again, less and less is read twice.
    fn was(&mut self, plain: bool) {
        if plain {
            self.next_careful = 0;
        } else {
            self.careful = self.next_careful;
            self.next_careful = (2 * self.next_careful).clamp(1, MOST_CAREFUL);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
    use std::path::Path;
    use std::sync::atomic::{AtomicUsize, Ordering};

    use proptest::prelude::*;
    use taxel::parallel::Serial;
    use taxel::{Counts, Frame};

    use super::*;
    use crate::ReadOptions;

    /// A thread for each job.
    struct ThreadEach;

    impl Executor for ThreadEach {
        fn each(&self, jobs: usize, job: &(dyn Fn(usize) + Sync)) {
            std::thread::scope(|scope| {
                for i in 0..jobs {
                    scope.spawn(move || job(i));
                }
            });
        }
    }

    /// What is read of a text: values and positions, in the end what is wrong, and the bytes that were read.
    type Found = (Vec<(u64, Vec<f64>)>, Option<String>, u64, Vec<String>);

    fn read(text: &str, options: ReadOptions, most: Option<usize>) -> Found {
        let rule = Rule::Counts { maximum: 1023.0 };
        let mut grid = Grid::new(text.as_bytes(), Path::new("a"), options, rule).unwrap();
        let mut frame = Frame::<Counts>::zeros(options.rows, options.columns);
        let (mut frames, mut error) = (Vec::new(), None);
        loop {
            if let Some(most) = most {
                let mut out = vec![7];
                let read = grid
                    .next_counts((most, None), &mut out, &ThreadEach)
                    .unwrap();
                assert!(out[0] == 7 && read.end - read.start <= most as u64);
                let each = out[1..].chunks(options.rows * options.columns);
                assert_eq!(each.len() as u64, read.end - read.start);
                frames.extend(
                    read.zip(each.map(|each| each.iter().map(|&n| f64::from(n)).collect())),
                );
            }
            match grid.next_into(&mut frame) {
                Ok(true) => frames.push((frame.sequence, frame.values().to_vec())),
                Ok(false) => break,
                Err(found) => {
                    error = Some(found.to_string());
                    break;
                }
            }
        }
        let skips = grid.skips().first.iter();
        let skips = skips
            .map(|skip| format!("{:?} {}", skip.first_line, skip.error))
            .collect();
        (frames, error, grid.bytes(), skips)
    }

    fn check(text: &str, most: usize) -> Result<(), TestCaseError> {
        for (rows, columns) in [(2, 3), (1, 6), (3, 2)] {
            for keep_going in [false, true] {
                let mut options = ReadOptions::new(rows, columns);
                options.keep_going = keep_going;
                let careful = read(text, options, None);
                prop_assert_eq!(
                    &careful,
                    &read(text, options, Some(most)),
                    "{} x {}",
                    rows,
                    columns
                );
            }
        }
        Ok(())
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(300))]

        #[test]
        fn frames_and_errors_are_those_of_the_careful_reader(
            lines in prop::collection::vec("[0-9]{1,3},[0-9]{1,3},[0-9]{1,4}", 0..200),
            odd in prop::collection::vec((any::<prop::sample::Index>(), prop::sample::select(vec![
                "", "1,2", "1,2,3,4", "1,2.5,3", "x,2,3", "-1,2,3", "1,2,99999", "1,,2", " 1,2,3", "1,2,3,4,5,6",
            ])), 0..4),
            (end, most) in (prop::sample::select(vec!["\n", ",\n", "\r\n", ",\r\r\n"]), 1usize..40),
            is_closed in any::<bool>(),
        ) {
            let mut lines = lines;
            for (at, line) in odd {
                let at = at.index(lines.len() + 1);
                lines.insert(at, line.to_owned());
            }
            let text: String = lines.iter().map(|line| format!("{line}{end}")).collect();
            check(if is_closed { &text } else { text.trim_end() }, most)?;
        }
    }

    /// A converter of 16 bits has them, and a frame with one is no slower to read.
    #[test]
    fn counts_of_five_digits_are_plain() {
        let options = ReadOptions::new(2, 3);
        let rule = Rule::Counts { maximum: 65535.0 };
        let frames = |count: u32| format!("1,{count},10000\n65535,9999,0\n").repeat(80);
        for (count, plain) in [(12345, 1..80), (65535, 1..80), (65536, 1..1)] {
            let text = "0,1,2\n3,4,5\n".to_owned() + &frames(count)[..];
            let mut grid = Grid::new(text.as_bytes(), Path::new("a"), options, rule).unwrap();
            let mut frame = Frame::<Counts>::zeros(2, 3);
            assert!(grid.next_into(&mut frame).unwrap());
            let mut out = Vec::new();
            assert_eq!(
                grid.next_counts((79, None), &mut out, &Serial).unwrap(),
                plain
            );
            let row = [1, count as u16, 10000, 65535, 9999, 0];
            assert_eq!(out, row.repeat((plain.end - 1) as usize));
        }
    }

    #[test]
    fn most_of_a_long_text_is_read_plainly() {
        let line = "1,22,333,\n".repeat(64);
        let text = line.repeat(50);
        let options = ReadOptions::new(64, 3);
        let rule = Rule::Counts { maximum: 1023.0 };
        let mut grid = Grid::new(text.as_bytes(), Path::new("a"), options, rule).unwrap();
        let mut frame = Frame::<Counts>::zeros(64, 3);
        let mut out = Vec::new();
        assert_eq!(
            grid.next_counts((100, None), &mut out, &Serial).unwrap(),
            0..0
        );
        assert!(grid.next_into(&mut frame).unwrap());
        assert_eq!(
            grid.next_counts((9, None), &mut out, &Serial).unwrap(),
            1..10
        );
        assert_eq!(
            grid.next_counts((100, None), &mut out, &Serial).unwrap(),
            10..50
        );
        assert_eq!(out, [1, 22, 333].repeat(64 * 49));
        assert_eq!(grid.bytes(), text.len() as u64);
        assert!(!grid.next_into(&mut frame).unwrap());
    }

    /// Wants no more after some steps.
    struct Stopping(AtomicUsize);

    impl Executor for Stopping {
        fn each(&self, jobs: usize, job: &(dyn Fn(usize) + Sync)) {
            (0..jobs).for_each(job);
        }

        fn step(&self) {
            if self.0.fetch_add(1, Ordering::Relaxed) == 5 {
                resume_unwind(Box::new("stopped"));
            }
        }
    }

    #[test]
    fn who_stopped_cannot_read_on() {
        let text = "1,2,3\n".repeat(600);
        let options = ReadOptions::new(2, 3);
        let rule = Rule::Counts { maximum: 1023.0 };
        let mut grid = Grid::new(text.as_bytes(), Path::new("a"), options, rule).unwrap();
        let mut frame = Frame::<Counts>::zeros(2, 3);
        assert!(grid.next_into(&mut frame).unwrap());
        let mut out = Vec::new();
        let stopped = catch_unwind(AssertUnwindSafe(|| {
            grid.next_counts((300, None), &mut out, &Stopping(AtomicUsize::new(0)))
        }));
        assert!(stopped.is_err());
        let error = grid.next_into(&mut frame).unwrap_err().to_string();
        assert!(error.contains("stopped before"), "{error}");
    }
}
