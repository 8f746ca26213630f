//! Pictures one after the other, as a GIF.

use std::collections::HashMap;

use resvg::tiny_skia::Pixmap;

use crate::Error;
use crate::colour::{ColourMap, Rgb};
use crate::picture::Picture;

/// Most pixels of a picture of a movie: a GIF is slow to show, and large, long before it is forbidden.
const MOST_PIXELS: u64 = 4_000_000;
/// Greys of the palette, from ink to paper: text and axes.
const GREYS: usize = 16;
const INK: f64 = 34.0;
/// All other colours are the colour map's.
const COLOURS: usize = 256 - GREYS;

/// A GIF that grows by a picture at a time, and goes on for ever when it is shown.
///
/// One palette for all: 240 colours of the map, and 16 greys for text and axes. Of each picture what has changed is kept.
///
/// ```
/// use taxel_plot::{Movie, Panel};
/// let picture = |peak: f64| Panel::new(1, 2, &[0.0, peak])?.range(0.0, 9.0).picture();
/// let (mut movie, mut bytes) = Movie::new(&picture(1.0)?)?;
/// bytes.extend(movie.push(&picture(1.0)?, 4)?);
/// bytes.extend(movie.push(&picture(9.0)?, 4)?);
/// bytes.extend(movie.end()?);
/// assert!(bytes.starts_with(b"GIF89a"));
/// # Ok::<(), taxel_plot::Error>(())
/// ```
pub struct Movie {
    encoder: gif::Encoder<Vec<u8>>,
    palette: Palette,
    width: u16,
    height: u16,
    /// What is seen, an index per pixel; empty before the first picture.
    seen: Vec<u8>,
}

impl Movie {
    /// A movie of pictures as large as `first`, which is not yet in it, and the bytes it begins with.
    ///
    /// # Errors
    /// [`Error::TooLarge`] for more than 4 000 000 pixels.
    pub fn new(first: &Picture) -> Result<(Movie, Vec<u8>), Error> {
        let (width, height) = first.pixel_size();
        let side = |pixels: u64| u16::try_from(pixels).ok();
        let (Some(across), Some(down), true) =
            (side(width), side(height), width * height <= MOST_PIXELS)
        else {
            return Err(Error::TooLarge {
                width,
                height,
                limit: MOST_PIXELS,
            });
        };
        let palette = Palette::new(ColourMap::default());
        let table = palette.colours.concat();
        let mut encoder = gif::Encoder::new(Vec::new(), across, down, &table).map_err(refused)?;
        encoder.set_repeat(gif::Repeat::Infinite).map_err(refused)?;
        let mut movie = Movie {
            encoder,
            palette,
            width: across,
            height: down,
            seen: Vec::new(),
        };
        let bytes = movie.take();
        Ok((movie, bytes))
    }

    /// Goes on with a picture that is shown for so many hundredths of a second; gives back the bytes to be written next.
    ///
    /// # Errors
    /// [`Error::PictureSize`] for a picture that is not as large as the first.
    pub fn push(&mut self, picture: &Picture, hundredths: u16) -> Result<Vec<u8>, Error> {
        let (width, height) = picture.pixel_size();
        if (width, height) != (self.width.into(), self.height.into()) {
            return Err(Error::PictureSize {
                width,
                height,
                first_width: self.width.into(),
                first_height: self.height.into(),
            });
        }
        let drawn = self.palette.indices(&picture.pixels()?);
        let part = self.changed(&drawn);
        let buffer = part.of(&drawn, self.width.into());
        self.seen = drawn;
        let frame = gif::Frame {
            delay: hundredths,
            dispose: gif::DisposalMethod::Keep,
            left: part.left as u16,
            top: part.top as u16,
            width: part.width as u16,
            height: part.height as u16,
            buffer: buffer.into(),
            ..gif::Frame::default()
        };
        self.encoder.write_frame(&frame).map_err(refused)?;
        Ok(self.take())
    }

    /// The bytes it ends with.
    ///
    /// # Errors
    /// [`Error::Gif`] should the encoder refuse.
    pub fn end(self) -> Result<Vec<u8>, Error> {
        self.encoder.into_inner().map_err(|error| Error::Gif {
            message: error.to_string(),
        })
    }

    fn take(&mut self) -> Vec<u8> {
        std::mem::take(self.encoder.get_mut())
    }

    /// The smallest part that holds all pixels that are no longer what is seen; a pixel where there are none.
    fn changed(&self, drawn: &[u8]) -> Part {
        let (width, height) = (usize::from(self.width), usize::from(self.height));
        if self.seen.is_empty() {
            return Part {
                left: 0,
                top: 0,
                width,
                height,
            };
        }
        let (mut left, mut right) = (width, 0);
        let (mut top, mut bottom) = (height, 0);
        let rows = drawn.chunks(width).zip(self.seen.chunks(width));
        for (row, (new, old)) in rows.enumerate() {
            let differs = |&column: &usize| new[column] != old[column];
            let Some(first) = (0..width).find(differs) else {
                continue;
            };
            let last = (0..width).rfind(differs).unwrap_or(first);
            (left, right) = (left.min(first), right.max(last));
            (top, bottom) = (top.min(row), row);
        }
        if left > right {
            (left, right, top, bottom) = (0, 0, 0, 0);
        }
        Part {
            left,
            top,
            width: right - left + 1,
            height: bottom - top + 1,
        }
    }
}

fn refused(error: gif::EncodingError) -> Error {
    Error::Gif {
        message: error.to_string(),
    }
}

/// A rectangle of pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Part {
    left: usize,
    top: usize,
    width: usize,
    height: usize,
}

impl Part {
    /// Its pixels of a picture so many pixels wide.
    fn of(self, pixels: &[u8], across: usize) -> Vec<u8> {
        let rows = pixels.chunks(across).skip(self.top).take(self.height);
        rows.flat_map(|row| &row[self.left..self.left + self.width])
            .copied()
            .collect()
    }
}

/// 256 colours, and which of them is nearest to one.
#[derive(Debug)]
struct Palette {
    colours: Vec<Rgb>,
    known: HashMap<Rgb, u8>,
}

impl Palette {
    fn new(map: ColourMap) -> Palette {
        let share = |i: usize, count: usize| i as f64 / (count - 1) as f64;
        let of_map = (0..COLOURS).map(|i| map.entry((share(i, COLOURS) * 255.0).round() as u8));
        let grey = |i: usize| [(INK + share(i, GREYS) * (255.0 - INK)).round() as u8; 3];
        Palette {
            colours: of_map.chain((0..GREYS).map(grey)).collect(),
            known: HashMap::new(),
        }
    }

    fn indices(&mut self, pixels: &Pixmap) -> Vec<u8> {
        // The background is opaque, so premultiplied colours are the colours.
        let colours = pixels.data().chunks_exact(4).map(|p| [p[0], p[1], p[2]]);
        let mut last = None;
        colours
            .map(|colour| match last {
                Some((same, index)) if same == colour => index,
                _ => {
                    let index = self.nearest(colour);
                    last = Some((colour, index));
                    index
                }
            })
            .collect()
    }

    fn nearest(&mut self, colour: Rgb) -> u8 {
        if let Some(index) = self.known.get(&colour) {
            return *index;
        }
        let apart = |other: &Rgb| -> i32 {
            let both = colour.iter().zip(other);
            both.map(|(&a, &b)| (i32::from(a) - i32::from(b)).pow(2))
                .sum()
        };
        let best = (0..=u8::MAX).min_by_key(|&i| apart(&self.colours[usize::from(i)]));
        let index = best.unwrap_or(0);
        self.known.insert(colour, index);
        index
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Panel;

    fn picture(peak: f64, width: f64) -> Picture {
        let values = [0.0, peak];
        let panel = Panel::new(1, 2, &values).unwrap().within(width, 60.0);
        panel.range(0.0, 9.0).picture().unwrap()
    }

    #[test]
    fn every_colour_of_the_map_is_near_to_one_of_the_palette() {
        let mut palette = Palette::new(ColourMap::Inferno);
        for index in 0..=255 {
            let colour = ColourMap::Inferno.entry(index);
            let near = palette.nearest(colour);
            let near = palette.colours[usize::from(near)];
            let apart = colour.iter().zip(near).map(|(a, b)| a.abs_diff(b));
            assert!(apart.max().unwrap() <= 5, "{colour:?} {near:?}");
        }
        for exact in [[255; 3], [34; 3], ColourMap::Inferno.entry(0)] {
            let index = palette.nearest(exact);
            assert_eq!(palette.colours[usize::from(index)], exact);
        }
        assert_eq!(palette.colours.len(), 256);
    }

    #[test]
    fn of_a_picture_that_is_the_same_one_pixel_is_kept() {
        let (mut movie, _) = Movie::new(&picture(3.0, 100.0)).unwrap();
        let whole = movie.push(&picture(3.0, 100.0), 4).unwrap();
        let same = movie.push(&picture(3.0, 100.0), 4).unwrap();
        let other = movie.push(&picture(8.0, 100.0), 4).unwrap();
        assert!(same.len() < 40, "{}", same.len());
        assert!(same.len() < other.len() && other.len() < whole.len());
    }

    #[test]
    fn a_picture_of_another_size_is_refused_with_both_sizes() {
        let (first, second) = (picture(3.0, 100.0), picture(3.0, 200.0));
        let (mut movie, _) = Movie::new(&first).unwrap();
        let refused = movie.push(&second, 4).unwrap_err();
        let expected = Error::PictureSize {
            width: second.pixel_size().0,
            height: second.pixel_size().1,
            first_width: first.pixel_size().0,
            first_height: first.pixel_size().1,
        };
        assert_eq!(refused, expected);
    }
}
