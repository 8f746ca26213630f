//! Documents as the pages of a PDF, in builds with the feature `pdf`.

#[cfg(feature = "pdf")]
mod paint;
#[cfg(feature = "pdf")]
mod writer;

use crate::Error;

/// What a page shows.
#[cfg_attr(not(feature = "pdf"), allow(dead_code))]
pub(crate) struct Page<'a> {
    /// As [`crate::svg::Canvas`] writes it.
    pub(crate) svg: &'a str,
    /// Its size in points.
    pub(crate) width: u32,
    pub(crate) height: u32,
}

/// Where a section begins.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(not(feature = "pdf"), allow(dead_code))]
pub(crate) struct Heading {
    pub(crate) title: String,
    /// Its page, from 0.
    pub(crate) page: usize,
    /// Its upper edge, in points from the top.
    pub(crate) y: f64,
}

/// One PDF of these pages, its title and its headings where a viewer lists them. It has no date: the same pages give the same
/// bytes.
#[cfg(feature = "pdf")]
pub(crate) fn document(
    pages: &[Page<'_>],
    title: &str,
    headings: &[Heading],
) -> Result<Vec<u8>, Error> {
    writer::document(pages, title, headings)
}

/// [`Error::NoPdf`].
#[cfg(not(feature = "pdf"))]
pub(crate) fn document(
    _pages: &[Page<'_>],
    _title: &str,
    _headings: &[Heading],
) -> Result<Vec<u8>, Error> {
    Err(Error::NoPdf)
}
