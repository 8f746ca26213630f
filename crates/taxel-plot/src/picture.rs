//! A finished picture, as SVG text, or PNG or PDF bytes.

use std::path::Path;

use resvg::tiny_skia::{Color, Pixmap, Transform};
use resvg::usvg::Tree;

use crate::Error;
use crate::extent::{Extent, MAX_PIXELS, POINTS_PER_INCH};
use crate::glyphs::{outlined, tree_of};
use crate::pdf::{self, Page};
use crate::svg::Canvas;

/// Pixels per SVG point in a PNG.
pub const PNG_SCALE: u32 = 2;
const METRES_PER_INCH: f64 = 0.0254;
/// The extensions that pictures are written with.
const KNOWN: &str = if cfg!(feature = "pdf") {
    "png, svg, pdf"
} else {
    "png, svg"
};

/// What a picture is written as.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Format {
    /// Pixels, two per point.
    Png,
    /// Text and lines as vectors, heatmaps as embedded pixels.
    Svg,
    /// One page, a point of the picture a point of paper: text that can be searched, lines as vectors, heatmaps as embedded
    /// pixels. Written by builds with the feature `pdf`, which is on by default.
    Pdf,
}

impl Format {
    /// The format that the extension of `path` names, in capitals or not.
    ///
    /// # Errors
    /// [`Error::UnknownFormat`] with the extension, and those that would do; [`Error::NoPdf`] for `pdf` where this build
    /// writes none.
    pub fn from_extension(path: impl AsRef<Path>) -> Result<Format, Error> {
        let extension = path
            .as_ref()
            .extension()
            .unwrap_or_default()
            .to_string_lossy();
        match extension.to_ascii_lowercase().as_str() {
            "png" => Ok(Format::Png),
            "svg" => Ok(Format::Svg),
            "pdf" if cfg!(feature = "pdf") => Ok(Format::Pdf),
            "pdf" => Err(Error::NoPdf),
            _ => Err(Error::UnknownFormat {
                extension: extension.into_owned(),
                known: KNOWN,
            }),
        }
    }
}

/// A composed picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    svg: String,
    width: u32,
    height: u32,
    /// Pixels of its PNG, and how many of them make a point.
    raster: Raster,
    /// Pixels per inch that its PNG says, where that is asked for.
    dots_per_inch: Option<f64>,
}

/// What a PNG is rasterised to.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Raster {
    width: u64,
    height: u64,
    per_point: f64,
}

impl Raster {
    fn of(width: u32, height: u32, per_point: f64) -> Raster {
        let pixels = |points: u32| (f64::from(points) * per_point).round().max(1.0) as u64;
        Raster {
            width: pixels(width),
            height: pixels(height),
            per_point,
        }
    }
}

impl Picture {
    pub(crate) fn new(canvas: Canvas, width: f64, height: f64) -> Picture {
        let (width, height) = (width.ceil().max(1.0), height.ceil().max(1.0));
        Picture {
            svg: canvas.finish(width, height),
            width: width as u32,
            height: height as u32,
            raster: Raster::of(width as u32, height as u32, PNG_SCALE.into()),
            dots_per_inch: None,
        }
    }

    /// What is drawn over exactly so many pixels or points.
    pub(crate) fn exact(canvas: Canvas, extent: Extent) -> Picture {
        let (width, height) = extent.in_points();
        Picture {
            svg: canvas.finish(width, height),
            width: width.ceil() as u32,
            height: height.ceil() as u32,
            raster: Raster {
                width: extent.width.into(),
                height: extent.height.into(),
                per_point: extent.per_point,
            },
            dots_per_inch: None,
        }
    }

    /// So many pixels per inch in a PNG, which tells them to programs that print or place it: more pixels for the same
    /// picture, or for one of an [`Extent`] just those that it has.
    pub fn dots_per_inch(mut self, dots_per_inch: f64) -> Self {
        let per_point = dots_per_inch / POINTS_PER_INCH;
        if per_point != self.raster.per_point {
            self.raster = Raster::of(self.width, self.height, per_point);
        }
        self.dots_per_inch = Some(dots_per_inch);
        self
    }

    /// Width in points.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Height in points.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// The picture as an SVG document.
    pub fn svg(&self) -> &str {
        &self.svg
    }

    /// The picture as PNG bytes, [`PNG_SCALE`] pixels per point unless told.
    ///
    /// # Errors
    /// [`Error::TooLarge`] for more than 10⁸ pixels.
    pub fn png(&self) -> Result<Vec<u8>, Error> {
        let pixels = self.pixels()?;
        encode_rgb(&pixels, self.dots_per_inch)
    }

    /// The bytes of a file of that format.
    ///
    /// # Errors
    /// Those of [`Picture::png`] for a PNG; [`Error::Pdf`] and [`Error::NoPdf`] for a PDF.
    pub fn render(&self, format: Format) -> Result<Vec<u8>, Error> {
        match format {
            Format::Png => self.png(),
            Format::Svg => Ok(self.svg.clone().into_bytes()),
            Format::Pdf => pdf::document(&[self.page()], "", &[]),
        }
    }

    /// The picture as a page of a PDF.
    pub(crate) fn page(&self) -> Page<'_> {
        Page {
            svg: &self.svg,
            width: self.width,
            height: self.height,
        }
    }

    /// Width and height of its PNG.
    pub(crate) fn pixel_size(&self) -> (u64, u64) {
        (self.raster.width, self.raster.height)
    }

    pub(crate) fn pixels(&self) -> Result<Pixmap, Error> {
        let Raster {
            width,
            height,
            per_point,
        } = self.raster;
        let too_large = Error::TooLarge {
            width,
            height,
            limit: MAX_PIXELS,
        };
        if width.saturating_mul(height) > MAX_PIXELS {
            return Err(too_large);
        }
        let tree = parse(&self.svg)?;
        let mut pixmap = Pixmap::new(width as u32, height as u32).ok_or(too_large)?;
        // Where the last pixel is not wholly the picture's it would else be grey.
        pixmap.fill(Color::WHITE);
        let scale = per_point as f32;
        resvg::render(
            &tree,
            Transform::from_scale(scale, scale),
            &mut pixmap.as_mut(),
        );
        Ok(pixmap)
    }
}

/// The document as the rasteriser understands it.
pub(crate) fn parse(svg: &str) -> Result<Tree, Error> {
    tree_of(&outlined(svg).0)
}

fn encode_rgb(pixels: &Pixmap, dots_per_inch: Option<f64>) -> Result<Vec<u8>, Error> {
    // The background is opaque, so premultiplied colours are the colours.
    let rgb: Vec<u8> = pixels
        .data()
        .chunks_exact(4)
        .flat_map(|p| [p[0], p[1], p[2]])
        .collect();
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, pixels.width(), pixels.height());
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_compression(png::Compression::Fast);
    let density = dots_per_inch.map(|dots| (dots / METRES_PER_INCH).round() as u32);
    encoder.set_pixel_dims(density.map(|per_metre| png::PixelDimensions {
        xppu: per_metre,
        yppu: per_metre,
        unit: png::Unit::Meter,
    }));
    write_image(encoder, &rgb)?;
    Ok(bytes)
}

/// Writes all of `data` and ends the file.
pub(crate) fn write_image(
    encoder: png::Encoder<'_, &mut Vec<u8>>,
    data: &[u8],
) -> Result<(), Error> {
    let write = || -> Result<(), png::EncodingError> {
        let mut writer = encoder.write_header()?;
        writer.write_image_data(data)?;
        writer.finish()
    };
    write().map_err(|error| Error::Png {
        message: error.to_string(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::svg::Anchor;

    #[test]
    fn formats_are_known_by_their_extension() {
        assert_eq!(Format::from_extension("a/b.PNG"), Ok(Format::Png));
        assert_eq!(Format::from_extension("a.b.svg"), Ok(Format::Svg));
        let error = Format::from_extension("frame.jpg").unwrap_err().to_string();
        assert!(error.contains("`jpg`") && error.contains(KNOWN));
        assert!(Format::from_extension("frame").is_err());
        let pdf = Format::from_extension("frame.pdf");
        if cfg!(feature = "pdf") {
            assert_eq!(pdf, Ok(Format::Pdf));
        } else {
            assert_eq!(pdf, Err(Error::NoPdf));
            let picture = Picture::new(Canvas::default(), 9.0, 9.0);
            assert_eq!(picture.render(Format::Pdf), Err(Error::NoPdf));
        }
    }

    #[test]
    fn every_sign_of_physics_is_in_the_font() {
        for sign in "AZaz09 µΩ²³×−±°⁻⁰¹⁴⁹…–≤≥".chars() {
            let mut canvas = Canvas::default();
            canvas.text(10.0, 30.0, 20.0, Anchor::Start, &sign.to_string());
            let picture = Picture::new(canvas, 40.0, 40.0);
            let drawn = picture
                .pixels()
                .unwrap()
                .data()
                .iter()
                .any(|&byte| byte < 128);
            assert!(drawn || sign == ' ', "{sign}");
        }
    }

    #[test]
    fn the_table_of_widths_is_that_of_the_font() {
        for text in [
            "0123456789",
            "conductance",
            "Frame 12, row 5: (N) + 4.5 %",
            "{before} ~ [after] | W@M",
        ] {
            let mut canvas = Canvas::default();
            canvas.text(0.0, 300.0, 100.0, Anchor::Start, text);
            let tree = parse(&canvas.finish(5000.0, 400.0)).unwrap();
            let drawn = tree
                .root()
                .children()
                .last()
                .unwrap()
                .abs_bounding_box()
                .width();
            let expected = crate::text::width(text, 100.0);
            // The box is that of the ink: less the white at both sides, and what kerning takes.
            let missing = expected - f64::from(drawn);
            assert!(
                (-1.0..0.05 * expected).contains(&missing),
                "{text}: {expected}, {drawn}"
            );
        }
    }

    #[test]
    fn a_picture_too_large_is_refused_with_its_size() {
        let error = Picture::new(Canvas::default(), 20_000.0, 20_000.0)
            .png()
            .unwrap_err();
        assert_eq!(
            error,
            Error::TooLarge {
                width: 40_000,
                height: 40_000,
                limit: MAX_PIXELS
            }
        );
    }
}
