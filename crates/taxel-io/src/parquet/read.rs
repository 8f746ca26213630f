//! A table's frames, row by row.

use std::marker::PhantomData;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::time::{Duration, SystemTime};

use parquet::column::reader::get_column_reader;
use parquet::errors::{ParquetError as CrateError, Result as ParquetResult};
use taxel::{Counts, Frame};

use super::numbers::Numbers;
use super::pages::{Pages, Spent};
use super::table::{Leaves, Table};
use super::{COUNTS, MARKS, NEWTONS};
use crate::error::{BROKEN_READING, Error, ParquetError, other_shape};
use crate::integrity::{Gaps, Integrity, TimeGaps};
use crate::options::ReadOptions;
use crate::source::{FrameSource, MAX_TAXELS, SkipLog, Skipped, fill_marked, mark_of};

/// Reads frames from a table: its counts, or its loads (newtons, with their marks, as they stand in the file).
///
/// It holds one row, and the pages of a column that it stands in.
pub struct ParquetReader<Q = Counts> {
    path: PathBuf,
    table: Table,
    leaves: Leaves,
    options: ReadOptions,
    least: f64,
    most: f64,
    values: &'static str,
    /// The group that is being read, and rows of it that are left.
    group: Option<Group>,
    next_group: usize,
    numbers: Vec<f64>,
    marks: Vec<f64>,
    /// The one number of a column beside them.
    scalar: Vec<f64>,
    row: u64,
    skips: SkipLog,
    number: Option<u64>,
    host: Option<SystemTime>,
    gaps: Gaps,
    /// The time of the row before, seconds, and what such times tell.
    time_secs: Option<f64>,
    times: TimeGaps,
    spent: Spent,
    done: bool,
    quantity: PhantomData<Q>,
}

/// Readers of a group's columns.
struct Group {
    rows_left: u64,
    values: Numbers,
    marks: Option<Numbers>,
    sequence: Option<Numbers>,
    time_secs: Option<Numbers>,
    host_time: Option<Numbers>,
}

impl ParquetReader<Counts> {
    /// Opens the counts of a table: its column `counts`.
    ///
    /// # Errors
    /// [`Error::Open`], [`ParquetError::NotParquet`]; [`ParquetError::NoColumn`], [`ParquetError::ColumnType`]; [`Error::FrameShape`] for frames
    /// of another shape than `options` say.
    pub fn open_counts(path: impl AsRef<Path>, options: ReadOptions) -> Result<Self, Error> {
        let most = options.max_count.unwrap_or(f64::MAX);
        let mut reader = Self::open(path.as_ref(), options, COUNTS, 0.0, most)?;
        // The table's marks are those of its loads: of what a count is worth they say nothing.
        reader.leaves.marks = None;
        Ok(reader)
    }
}

impl<Q> ParquetReader<Q> {
    /// Opens the loads of a table: its column `newtons`.
    ///
    /// # Errors
    /// As [`ParquetReader::open_counts`].
    pub fn open_loads(path: impl AsRef<Path>, options: ReadOptions) -> Result<Self, Error> {
        Self::open(path.as_ref(), options, NEWTONS, -f64::MAX, f64::MAX)
    }

    fn open(
        path: &Path,
        options: ReadOptions,
        values: &'static str,
        least: f64,
        most: f64,
    ) -> Result<Self, Error> {
        let (rows, columns) = (options.rows, options.columns);
        let taxels = rows.checked_mul(columns);
        if taxels.is_none_or(|taxels| taxels == 0 || taxels > MAX_TAXELS) {
            return Err(Error::Size {
                file: path.to_owned(),
                rows,
                columns,
                limit: MAX_TAXELS,
            });
        }
        let table = Table::open(path)?;
        let leaves = table.leaves(path, values)?;
        let expected = if options.transpose {
            (columns, rows)
        } else {
            (rows, columns)
        };
        if let Some(found) = table.shape().filter(|found| *found != expected) {
            return Err(other_shape(path, found, expected));
        }
        Ok(Self {
            path: path.to_owned(),
            table,
            leaves,
            options,
            least,
            most,
            values,
            group: None,
            next_group: 0,
            numbers: Vec::new(),
            marks: Vec::new(),
            scalar: Vec::new(),
            row: 0,
            skips: SkipLog::default(),
            number: None,
            host: None,
            gaps: Gaps::default(),
            time_secs: None,
            times: TimeGaps::default(),
            spent: Spent::default(),
            done: false,
            quantity: PhantomData,
        })
    }

    /// The readers of a group's columns.
    fn open_group(&self, at: usize) -> ParquetResult<Group> {
        let group = self.table.metadata.row_group(at);
        let rows = usize::try_from(group.num_rows())?;
        let schema = self.table.metadata.file_metadata().schema_descr();
        let open = |leaf: usize| {
            let spent = self.spent.clone();
            let pages = Pages::open(&self.table.file, group.column(leaf), rows, spent)?;
            let reader = get_column_reader(schema.column(leaf), Box::new(pages));
            // Looked at when the file was opened.
            Numbers::new(reader).ok_or_else(|| CrateError::General("no numbers".to_owned()))
        };
        let maybe = |leaf: Option<usize>| leaf.map(open).transpose();
        Ok(Group {
            rows_left: rows as u64,
            values: open(self.leaves.values)?,
            marks: maybe(self.leaves.marks)?,
            sequence: maybe(self.leaves.sequence)?,
            time_secs: maybe(self.leaves.time_secs)?,
            host_time: maybe(self.leaves.host_time.map(|(leaf, _)| leaf))?,
        })
    }

    /// Reads the next row of all columns; false behind the last.
    fn next_row(&mut self) -> ParquetResult<Option<Row>> {
        while self.group.as_ref().is_none_or(|group| group.rows_left == 0) {
            self.group = None;
            if self.next_group == self.table.metadata.num_row_groups() {
                return Ok(None);
            }
            self.group = Some(self.open_group(self.next_group)?);
            self.next_group += 1;
        }
        let Some(group) = &mut self.group else {
            return Ok(None);
        };
        group.rows_left -= 1;
        let mut scalar = |column: &mut Option<Numbers>| -> ParquetResult<Option<f64>> {
            let Some(column) = column else {
                return Ok(None);
            };
            self.spent.store(0, Ordering::Relaxed);
            let row = column.next(&mut self.scalar)?;
            check_there(row.is_there)?;
            Ok(self
                .scalar
                .first()
                .copied()
                .filter(|value| value.is_finite()))
        };
        let sequence = scalar(&mut group.sequence)?;
        let time_secs = scalar(&mut group.time_secs)?;
        let host = scalar(&mut group.host_time)?;
        self.spent.store(0, Ordering::Relaxed);
        let values = group.values.next(&mut self.numbers)?;
        check_there(values.is_there)?;
        let mut mark_places = None;
        if let Some(marks) = &mut group.marks {
            self.spent.store(0, Ordering::Relaxed);
            let marks = marks.next(&mut self.marks)?;
            check_there(marks.is_there)?;
            mark_places = Some(marks.places);
        }
        Ok(Some(Row {
            places: values.places,
            mark_places,
            sequence: sequence.map(|number| number as u64),
            time_secs,
            host,
        }))
    }

    /// What is wrong with the row that was read, if anything.
    fn check(&self, row: &Row) -> Result<(), Error> {
        self.check_length(self.values, self.numbers.len(), row.places)?;
        if let Some(places) = row.mark_places {
            self.check_length(MARKS, self.marks.len(), places)?;
        }
        let allowed = self.least..=self.most;
        if let Some(at) = self.numbers.iter().position(|v| !allowed.contains(v)) {
            let (row, column) = self.place(at);
            return Err(Error::Value {
                file: self.path.clone(),
                frame: self.row,
                row,
                column,
                found: self.numbers[at],
                minimum: self.least,
                maximum: self.most,
                hint: BROKEN_READING,
            });
        }
        let Some(at) = self.marks.iter().position(|code| mark_of(*code).is_none()) else {
            return Ok(());
        };
        let (row, column) = self.place(at);
        Err(Error::from(ParquetError::MarkCode {
            file: self.path.clone(),
            frame: self.row,
            row,
            column,
            found: self.marks[at],
        }))
    }

    /// Refuses a list that has not one number a taxel.
    fn check_length(&self, column: &'static str, found: usize, places: usize) -> Result<(), Error> {
        let taxels = self.options.rows * self.options.columns;
        if found == taxels && places == taxels {
            return Ok(());
        }
        Err(Error::from(ParquetError::RowLength {
            file: self.path.clone(),
            frame: self.row,
            column,
            found,
            rows: self.options.rows,
            columns: self.options.columns,
        }))
    }

    /// Row and column, as the file has them, of a number of its list.
    fn place(&self, at: usize) -> (usize, usize) {
        let columns = if self.options.transpose {
            self.options.rows
        } else {
            self.options.columns
        };
        (at / columns, at % columns)
    }

    fn fill(&mut self, row: &Row, frame: &mut Frame<Q>) {
        let shape = (self.options.rows, self.options.columns);
        let transpose = self.options.transpose;
        fill_marked(frame, shape, transpose, &self.numbers, &self.marks);
        frame.sequence = self.row;
        frame.time_secs = row.time_secs;
        self.host = row.host.and_then(|since| {
            let unit_nanos = self.leaves.host_time?.1;
            let nanos = (since.max(0.0) as u64).checked_mul(unit_nanos)?;
            SystemTime::UNIX_EPOCH.checked_add(Duration::from_nanos(nanos))
        });
    }

    fn take_number_and_time(&mut self, row: &Row) {
        let both = self.number.zip(row.sequence);
        // Their low 32 bits are what a recording holds.
        let goes_on = both.is_none_or(|(before, now)| self.gaps.add(before as u32, now as u32));
        // A device that began anew has a clock that did.
        if goes_on {
            self.times.add_times(self.time_secs, row.time_secs);
        }
        self.number = row.sequence;
        self.time_secs = row.time_secs;
    }
}

/// One row beside its numbers.
struct Row {
    /// Places of the list, empty ones too.
    places: usize,
    /// The same of its marks, where the table has them.
    mark_places: Option<usize>,
    sequence: Option<u64>,
    time_secs: Option<f64>,
    /// In the unit of its column.
    host: Option<f64>,
}

fn check_there(is_there: bool) -> ParquetResult<()> {
    if is_there {
        return Ok(());
    }
    let words = "a column has fewer rows than the file says";
    Err(CrateError::General(words.to_owned()))
}

impl<Q> FrameSource<Q> for ParquetReader<Q> {
    fn shape(&self) -> (usize, usize) {
        (self.options.rows, self.options.columns)
    }

    fn next_into(&mut self, frame: &mut Frame<Q>) -> Result<bool, Error> {
        while !self.done {
            // Nothing follows an error.
            self.done = true;
            let read = self.next_row().map_err(|error| {
                Error::from(ParquetError::Row {
                    file: self.path.clone(),
                    frame: self.row,
                    reason: error.to_string(),
                })
            })?;
            let Some(row) = read else {
                if self.row == 0 {
                    return Err(Error::Empty {
                        file: self.path.clone(),
                        what: "frame",
                        found: 0,
                    });
                }
                return Ok(false);
            };
            self.take_number_and_time(&row);
            let checked = self.check(&row);
            if checked.is_ok() {
                self.fill(&row, frame);
            }
            let position = self.row;
            self.row += 1;
            match checked {
                Ok(()) => {
                    self.done = false;
                    return Ok(true);
                }
                Err(error) if self.options.keep_going && error.is_one_frame() => {
                    self.done = false;
                    self.skips.add(Skipped {
                        frame: position,
                        first_line: None,
                        error,
                    });
                }
                Err(error) => return Err(error),
            }
        }
        Ok(false)
    }

    fn skipped(&self) -> usize {
        self.skips.count
    }
    fn skips(&self) -> &[Skipped] {
        &self.skips.first
    }
    fn bytes_read(&self) -> u64 {
        // Rows are of one length, about.
        let share = self.row as f64 / self.table.rows.max(1) as f64;
        (self.table.bytes as f64 * share) as u64
    }
    fn bytes_total(&self) -> Option<u64> {
        Some(self.table.bytes)
    }
    fn integrity(&self) -> Integrity {
        Integrity {
            gaps: self.gaps,
            times: self.times,
            ..Integrity::default()
        }
    }
    fn device_number(&self) -> Option<u64> {
        self.number
    }
    fn host_time(&self) -> Option<SystemTime> {
        self.host
    }
}
