//! A recording cut into windows of time in which what presses lies still: the mean of one that moves is no map of anything.
//!
//! Frames are taken together in short blocks. A block belongs to the window before it where the window's map, each contact times a
//! number of its own, explains the block's: fingers that press harder by turns lie still, a hand that slides does not.

use super::watershed::{Contact, ContactOptions, Segmenter};
use crate::metric::is_usable;
use crate::{Frame, Mark, Newtons};

/// When a window ends.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct WindowOptions {
    /// Frames of a block.
    pub block_frames: u64,
    /// A block is of the window before it where this share of its squared loads is explained, 0 to 1.
    pub explained_share: f64,
    /// A window whose mean force is less than this share of the largest one's has no map of its own.
    pub loaded_share: f64,
    /// What counts as a contact, however small.
    pub contacts: ContactOptions,
}

impl Default for WindowOptions {
    /// Blocks of ten frames, explained by 97 %; windows of a tenth of the largest force.
    fn default() -> Self {
        Self {
            block_frames: 10,
            explained_share: 0.97,
            loaded_share: 0.1,
            contacts: ContactOptions {
                min_taxels: 1,
                ..ContactOptions::default()
            },
        }
    }
}

/// Frames in which what presses lies still.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Window {
    /// The first and the last of them, by their place in the recording.
    pub frames: [u64; 2],
    /// How many of them had an answer and a load, which its mean is of.
    pub loaded_frames: u64,
    /// Mean load of each taxel, newtons; marked absent where none was read.
    pub map: Frame<Newtons>,
}

/// More windows than this are thinned out on the way.
const MAX_WINDOWS: usize = 512;

/// Cuts a recording, frame by frame.
#[derive(Debug)]
pub struct Windows<'a> {
    segmenter: Segmenter<'a>,
    options: WindowOptions,
    block: Sum,
    done: Vec<Sum>,
    /// Contacts of the last window, and of how many frames it was when they were found.
    known: Option<(Vec<Contact>, u64)>,
}

impl<'a> Windows<'a> {
    /// For frames of the segmenter's sensor.
    pub fn new(segmenter: Segmenter<'a>, options: WindowOptions) -> Self {
        let sensor = segmenter.sensor();
        Self {
            block: Sum::new(sensor.rows() * sensor.columns()),
            segmenter,
            options,
            done: Vec::new(),
            known: None,
        }
    }

    /// The next frame of the recording, by its sequence number; `is_answer`: whether its loads are.
    ///
    /// # Panics
    /// When its shape is not the sensor's.
    pub fn add(&mut self, frame: u64, loads: &Frame<Newtons>, is_answer: bool) {
        self.block.add(frame, loads, is_answer);
        if self.block.seen >= self.options.block_frames {
            self.close_block();
        }
    }

    /// All windows in order; they follow one another without a gap. One at least, of a recording with any frame.
    pub fn finish(mut self) -> Vec<Window> {
        if self.block.seen > 0 {
            self.close_block();
        }
        self.join_unloaded();
        self.join_alike();
        let [rows, columns] = {
            let sensor = self.segmenter.sensor();
            [sensor.rows(), sensor.columns()]
        };
        let done = std::mem::take(&mut self.done);
        let windows = done.into_iter().map(|sum| Window {
            frames: sum.frames,
            loaded_frames: sum.loaded_frames,
            map: sum.mean(rows, columns),
        });
        windows.collect()
    }

    fn close_block(&mut self) {
        let taxels = self.block.sums.len();
        let block = std::mem::replace(&mut self.block, Sum::new(taxels));
        let is_new = match self.done.last() {
            None => true,
            Some(last) => {
                // What a window's map looks like changes little once it is long.
                let is_old = |at: &u64| last.loaded_frames >= 2 * at;
                if self.known.as_ref().is_none_or(|(_, at)| is_old(at)) {
                    let map = self.map(last);
                    let found = self.segmenter.contacts(&map, &self.options.contacts);
                    self.known = Some((found, last.loaded_frames));
                }
                let contacts = self.known.as_ref().map_or(&[][..], |(found, _)| found);
                self.explained(last, contacts, &block) < self.options.explained_share
            }
        };
        if is_new {
            self.done.push(block);
            self.known = None;
            if self.done.len() > MAX_WINDOWS {
                self.join_unloaded();
                self.join_alike();
                self.thin_out();
            }
        } else if let Some(last) = self.done.last_mut() {
            last.join(block);
        }
    }

    fn map(&self, sum: &Sum) -> Frame<Newtons> {
        let sensor = self.segmenter.sensor();
        sum.mean(sensor.rows(), sensor.columns())
    }

    /// How much of what one sum holds another's map explains, each contact of it times a number of its own; a pure number of squares.
    fn explained(&self, window: &Sum, contacts: &[Contact], block: &Sum) -> f64 {
        let window = self.segmenter.smoothed(&self.map(window));
        let block = self.segmenter.smoothed(&self.map(block));
        let all: f64 = block.iter().map(|load| load * load).sum();
        if all <= 0.0 {
            return 1.0;
        }
        let explained = contacts.iter().map(|contact| {
            let over =
                |of: &dyn Fn(usize) -> f64| -> f64 { contact.taxels.iter().map(|&t| of(t)).sum() };
            let both = over(&|t| block[t] * window[t]);
            let own = over(&|t| window[t] * window[t]);
            if own > 0.0 { both * both / own } else { 0.0 }
        });
        explained.sum::<f64>() / all
    }

    /// Windows in which next to nothing pressed go to the one before or after that is more like them.
    fn join_unloaded(&mut self) {
        let most = self.done.iter().map(Sum::mean_newtons).fold(0.0, f64::max);
        let least = self.options.loaded_share * most;
        let mut joined: Vec<Sum> = Vec::new();
        let mut waiting: Option<Sum> = None;
        for mut sum in std::mem::take(&mut self.done) {
            if sum.mean_newtons() < least {
                sum.unload();
                match joined.last_mut() {
                    Some(last) => last.join(sum),
                    None => match &mut waiting {
                        Some(first) => first.join(sum),
                        None => waiting = Some(sum),
                    },
                }
            } else {
                if let Some(first) = waiting.take() {
                    sum.frames[0] = first.frames[0];
                }
                joined.push(sum);
            }
        }
        joined.extend(waiting);
        self.done = joined;
        self.known = None;
    }

    /// Windows that follow one another and explain each other are one.
    fn join_alike(&mut self) {
        let mut joined: Vec<Sum> = Vec::new();
        for sum in std::mem::take(&mut self.done) {
            let is_alike = joined.last().is_some_and(|last| {
                let contacts = self
                    .segmenter
                    .contacts(&self.map(last), &self.options.contacts);
                self.explained(last, &contacts, &sum) >= self.options.explained_share
            });
            match joined.last_mut() {
                Some(last) if is_alike => last.join(sum),
                _ => joined.push(sum),
            }
        }
        self.done = joined;
        self.known = None;
    }

    /// Half as many, two and two together: of what never lies still.
    fn thin_out(&mut self) {
        if self.done.len() <= MAX_WINDOWS / 2 {
            return;
        }
        let mut joined: Vec<Sum> = Vec::new();
        for (at, sum) in std::mem::take(&mut self.done).into_iter().enumerate() {
            match joined.last_mut() {
                Some(last) if at % 2 == 1 => last.join(sum),
                _ => joined.push(sum),
            }
        }
        self.done = joined;
    }
}

/// Loads of some frames, added up.
#[derive(Debug)]
struct Sum {
    frames: [u64; 2],
    seen: u64,
    loaded_frames: u64,
    sums: Vec<f64>,
    counts: Vec<u32>,
}

impl Sum {
    fn new(taxels: usize) -> Self {
        Self {
            frames: [0; 2],
            seen: 0,
            loaded_frames: 0,
            sums: vec![0.0; taxels],
            counts: vec![0; taxels],
        }
    }

    fn add(&mut self, frame: u64, loads: &Frame<Newtons>, is_answer: bool) {
        if self.seen == 0 {
            self.frames[0] = frame;
        }
        self.frames[1] = frame;
        self.seen += 1;
        if !is_answer {
            return;
        }
        self.loaded_frames += 1;
        let each = loads.values().iter().zip(loads.marks()).enumerate();
        for (taxel, (load, mark)) in each {
            if is_usable(*mark) {
                self.sums[taxel] += load;
                self.counts[taxel] += 1;
            }
        }
    }

    /// Its frames stay, what they hold counts no more.
    fn unload(&mut self) {
        self.loaded_frames = 0;
        self.sums.fill(0.0);
        self.counts.fill(0);
    }

    fn join(&mut self, later: Self) {
        self.frames[1] = later.frames[1];
        self.seen += later.seen;
        self.loaded_frames += later.loaded_frames;
        let each = self.sums.iter_mut().zip(&later.sums);
        each.for_each(|(sum, later)| *sum += later);
        let each = self.counts.iter_mut().zip(&later.counts);
        each.for_each(|(count, later)| *count += later);
    }

    fn mean_newtons(&self) -> f64 {
        self.sums.iter().sum::<f64>() / (self.loaded_frames as f64).max(1.0)
    }

    fn mean(&self, rows: usize, columns: usize) -> Frame<Newtons> {
        let mut map = Frame::zeros(rows, columns);
        for (taxel, (sum, count)) in self.sums.iter().zip(&self.counts).enumerate() {
            if *count > 0 {
                map.values_mut()[taxel] = sum / f64::from(*count);
            } else {
                map.marks_mut()[taxel] = Mark::Absent;
            }
        }
        map
    }
}
