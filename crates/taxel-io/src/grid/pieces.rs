//! Pieces of a text of plain lines: read by one thread, turned into numbers by whichever has time, and put in order again.

use std::io::{self, Read};
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use taxel::Executor;

use crate::lines::read_some;
use crate::plain::{BEFORE, BEHIND, read_line};

/// Bytes that a thread reads in one go.
const PIECE: usize = if cfg!(test) { 1 << 7 } else { 1 << 17 };
/// For each so many bytes another thread: it takes as long to begin as some of them to read. And no more threads than these, where
/// nobody knows how many bytes there are.
const BYTES_OF_A_THREAD: u64 = if cfg!(test) { 1 << 9 } else { 1 << 21 };
const MOST_THREADS: u64 = 64;

/// What is read of a text.
pub(super) struct Wanted {
    /// Numbers of a line, and lines of a frame.
    pub(super) columns: usize,
    pub(super) frame_lines: usize,
    /// No number may be above it.
    pub(super) most: u16,
    /// Lines, and about how many bytes they take.
    pub(super) lines: usize,
    pub(super) bytes: u64,
}

/// What was read: numbers of whole lines, and what is left.
pub(super) struct Found {
    /// Lines whose numbers were taken, and the bytes of those whose text is not kept.
    pub(super) lines: usize,
    bytes: usize,
    /// Whether a comma closes the last of these.
    comma: bool,
    /// The last pieces, from the one on in which a frame without an end begins; behind them those that nobody wanted.
    kept: Vec<Piece>,
    /// Whether all lines that were wanted are plain.
    pub(super) is_plain: bool,
    /// Whether nothing more can be read.
    pub(super) has_ended: bool,
}

impl Found {
    /// Takes back all but so many lines; the bytes of those, and whether a comma closes the last of them.
    pub(super) fn keep(&mut self, lines: usize) -> (usize, bool) {
        let mut others = self.lines - lines;
        self.lines = lines;
        for piece in self.kept.iter_mut().rev() {
            let dropped = others.min(piece.lines);
            piece.drop_lines(dropped);
            others -= dropped;
        }
        let bytes = self.kept.iter().map(Piece::bytes_read).sum::<usize>();
        let last = self.kept.iter().rev().find(|piece| piece.lines > 0);
        let comma = last.map_or(self.comma, Piece::ends_with_comma);
        (self.bytes + bytes, comma)
    }

    /// The text of the lines that were not taken, as far as it was read in whole lines.
    pub(super) fn rest(&self) -> impl Iterator<Item = &[u8]> {
        self.kept
            .iter()
            .map(|piece| &piece.text[piece.read..piece.bytes.end])
    }
}

/// Room for pieces, kept from one text to the next.
#[derive(Default)]
pub(super) struct Pieces {
    /// Those that are done with.
    free: Vec<Piece>,
    /// What was read behind the last line feed.
    pub(super) tail: Vec<u8>,
}

impl Pieces {
    /// Reads plain lines, first those that are held, behind `out`.
    ///
    /// # Errors
    /// What cannot be read.
    pub(super) fn read<R: Read + Send>(
        &mut self,
        (held, reader): (&[u8], &mut R),
        wanted: &Wanted,
        out: &mut Vec<u16>,
        executor: &dyn Executor,
    ) -> io::Result<Found> {
        self.tail.clear();
        self.tail.extend_from_slice(held);
        let free = Mutex::new(&mut self.free);
        let feed = Mutex::new(Feed::new(reader, &mut self.tail));
        let taken = Mutex::new(Taken::new(out, wanted));
        let is_over = AtomicBool::new(false);
        let threads = (wanted.bytes / BYTES_OF_A_THREAD + 1).min(MOST_THREADS) as usize;
        executor.each(threads, &|_| {
            while !is_over.load(Ordering::Relaxed) {
                executor.step();
                let mut piece = lock(&free).pop().unwrap_or_default();
                let mut feed = lock(&feed);
                if feed.has_ended {
                    return lock(&free).push(piece);
                }
                let place = feed.fill(&mut piece);
                drop(feed);
                piece.read(wanted.columns, wanted.most);
                let mut taken = lock(&taken);
                taken.add(place, piece, &mut lock(&free));
                is_over.store(taken.is_over, Ordering::Relaxed);
            }
        });
        let (feed, taken) = (unlocked(feed), unlocked(taken));
        match feed.error {
            Some(error) => Err(error),
            None => Ok(taken.found(feed.has_ended)),
        }
    }

    /// Takes back what is done with.
    pub(super) fn free(&mut self, found: Found) {
        self.free.extend(found.kept);
    }
}

/// Some of the lines that come next.
#[derive(Default)]
pub(super) struct Piece {
    text: Vec<u8>,
    /// Where in it they stand,
    bytes: Range<usize>,
    numbers: Vec<u16>,
    lines: usize,
    /// and how far they were read: all of them, or those before one that is not plain.
    read: usize,
}

/// What pieces are read from, one after the other.
struct Feed<'a, R> {
    reader: &'a mut R,
    /// Of the text behind the last piece, what is read already.
    tail: &'a mut Vec<u8>,
    /// Pieces so far.
    pieces: usize,
    has_ended: bool,
    error: Option<io::Error>,
}

impl<'a, R: Read> Feed<'a, R> {
    fn new(reader: &'a mut R, tail: &'a mut Vec<u8>) -> Self {
        Self {
            reader,
            tail,
            pieces: 0,
            has_ended: false,
            error: None,
        }
    }

    /// Fills the next piece with whole lines; its place among them.
    fn fill(&mut self, piece: &mut Piece) -> usize {
        let Piece { text, bytes, .. } = piece;
        let held = BEFORE + self.tail.len();
        // What is held first may be as much as is read in one go.
        let full = (BEFORE + PIECE).max(held);
        make_room(text, full + BEHIND);
        text[BEFORE..held].copy_from_slice(self.tail);
        let mut end = held;
        while !self.has_ended && end < full {
            match read_some(self.reader, &mut text[end..full]) {
                Ok(read) => {
                    self.has_ended = read == 0;
                    end += read;
                }
                Err(error) => {
                    self.error = Some(error);
                    self.has_ended = true;
                }
            }
        }
        let whole = memchr::memrchr(b'\n', &text[BEFORE..end]).map_or(0, |at| at + 1);
        *bytes = BEFORE..BEFORE + whole;
        self.tail.clear();
        self.tail.extend_from_slice(&text[BEFORE + whole..end]);
        // A line longer than a piece is for the careful reader.
        self.has_ended |= whole == 0;
        self.pieces += 1;
        self.pieces - 1
    }
}

impl Piece {
    fn read(&mut self, columns: usize, most: u16) {
        (self.lines, self.read) = (0, self.bytes.start);
        let text = &self.text[..];
        // A number and what ends it are two bytes at least. What is there is written over, not cleared first.
        make_room(&mut self.numbers, self.bytes.len() / 2 + columns);
        let mut used = 0;
        while self.read < self.bytes.end {
            let Some(length) = memchr::memchr(b'\n', &text[self.read..self.bytes.end]) else {
                break;
            };
            let returns = text[self.read..self.read + length].iter().rev();
            let returns = returns.take_while(|byte| **byte == b'\r').count();
            let Some(out) = self.numbers.get_mut(used..used + columns) else {
                break;
            };
            if !read_line(text, self.read..self.read + length - returns, out, most) {
                break;
            }
            used += columns;
            self.lines += 1;
            self.read += length + 1;
        }
    }

    fn is_plain(&self) -> bool {
        self.read == self.bytes.end
    }

    /// Bytes of the lines that were read.
    fn bytes_read(&self) -> usize {
        self.read - self.bytes.start
    }

    /// Whether a comma closes the last line that was read.
    fn ends_with_comma(&self) -> bool {
        let lines = &self.text[self.bytes.start..self.read];
        lines.trim_ascii_end().ends_with(b",")
    }

    /// Takes the last lines back.
    fn drop_lines(&mut self, lines: usize) {
        for _ in 0..lines {
            let before = &self.text[self.bytes.start..self.read - 1];
            self.read = self.bytes.start + memchr::memrchr(b'\n', before).map_or(0, |at| at + 1);
        }
        self.lines -= lines;
    }
}

/// What becomes of pieces: their numbers one behind the other, whoever was done with them first.
struct Taken<'a> {
    out: &'a mut Vec<u16>,
    wanted: &'a Wanted,
    /// Lines whose numbers were taken, and the bytes of those whose text is not kept.
    lines: usize,
    bytes: usize,
    /// Whether a comma closes the last of these.
    comma: bool,
    /// The piece that comes next, and those that are there before it.
    next: usize,
    waiting: Vec<(usize, Piece)>,
    /// The last pieces: a frame whose other lines are still to come begins in the first of them.
    kept: Vec<Piece>,
    /// Whether all was plain so far, and whether more is wanted.
    is_plain: bool,
    is_over: bool,
}

impl<'a> Taken<'a> {
    fn new(out: &'a mut Vec<u16>, wanted: &'a Wanted) -> Self {
        Self {
            out,
            wanted,
            lines: 0,
            bytes: 0,
            comma: false,
            next: 0,
            waiting: Vec::new(),
            kept: Vec::new(),
            is_plain: true,
            is_over: false,
        }
    }

    fn found(mut self, has_ended: bool) -> Found {
        // What came behind the end of what is wanted was read for nothing.
        self.waiting.sort_unstable_by_key(|(place, _)| *place);
        for (_, mut piece) in self.waiting {
            piece.drop_lines(piece.lines);
            self.kept.push(piece);
        }
        Found {
            lines: self.lines,
            bytes: self.bytes,
            comma: self.comma,
            kept: self.kept,
            is_plain: self.is_plain,
            has_ended,
        }
    }

    /// Takes a piece, and all that waited for it; those that are done with go to `free`.
    fn add(&mut self, place: usize, piece: Piece, free: &mut Vec<Piece>) {
        self.waiting.push((place, piece));
        let is_next = |this: &Self| this.waiting.iter().position(|(at, _)| *at == this.next);
        while let Some(at) = is_next(self).filter(|_| !self.is_over) {
            let (_, piece) = self.waiting.swap_remove(at);
            self.next += 1;
            let numbers = &piece.numbers[..piece.lines * self.wanted.columns];
            self.out.extend_from_slice(numbers);
            self.lines += piece.lines;
            self.is_plain &= piece.is_plain();
            self.is_over = !self.is_plain || self.lines >= self.wanted.lines;
            self.kept.push(piece);
            self.let_go(free);
        }
    }

    /// Lets go of the pieces before the one in which the frame that is still open begins.
    fn let_go(&mut self, free: &mut Vec<Piece>) {
        let mut open = self.lines % self.wanted.frame_lines;
        let mut first = self.kept.len() - 1;
        while first > 0 && open > self.kept[first].lines {
            open -= self.kept[first].lines;
            first -= 1;
        }
        for piece in self.kept.drain(..first) {
            self.bytes += piece.bytes_read();
            if piece.lines > 0 {
                self.comma = piece.ends_with_comma();
            }
            free.push(piece);
        }
    }
}

/// Grows a block of memory whose content is of no use. New memory is taken from the system as it is: zeros, of which a page that
/// nobody writes to costs nothing.
fn make_room<T: Copy + Default>(block: &mut Vec<T>, length: usize) {
    if block.len() < length {
        *block = Vec::new();
        *block = vec![T::default(); length];
    }
}

/// Whoever panicked is heard of elsewhere.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

fn unlocked<T>(mutex: Mutex<T>) -> T {
    mutex.into_inner().unwrap_or_else(PoisonError::into_inner)
}
