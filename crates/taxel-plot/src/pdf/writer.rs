//! Writing a PDF: lines stay lines, pixels pixels, and texts are set in the shipped font, so that they can
//! be searched and copied.

use krilla::geom::{Point, Size, Transform};
use krilla::image::Image;
use krilla::metadata::Metadata;
use krilla::num::NormalizedF32;
use krilla::outline::{Outline, OutlineNode};
use krilla::page::PageSettings;
use krilla::paint::FillRule;
use krilla::surface::Surface;
use krilla::text::{Font, GlyphId, KrillaGlyph};
use krilla::{Document, destination::XyzDestination};
use resvg::usvg::{self, BlendMode, Group, ImageKind, ImageRendering, Node};

use super::{Heading, Page, paint};
use crate::Error;
use crate::glyphs::{Line, advance_of, font_bytes, glyph_of, line_number, outlined, tree_of};

pub(super) fn document(
    pages: &[Page<'_>],
    title: &str,
    headings: &[Heading],
) -> Result<Vec<u8>, Error> {
    let font = Font::new(font_bytes().into(), 0).ok_or_else(|| refused("the font"))?;
    let mut document = Document::new();
    for page in pages {
        let (outlines, lines) = outlined(page.svg);
        // The parser reads this word in a style only.
        let outlines = outlines.replace(
            " image-rendering=\"pixelated\"",
            " style=\"image-rendering:pixelated\"",
        );
        let tree = tree_of(&outlines)?;
        let settings = PageSettings::from_wh(page.width as f32, page.height as f32)
            .ok_or_else(|| refused("the size of a page"))?;
        let mut page = document.start_page_with(settings);
        let mut pen = Pen {
            surface: page.surface(),
            font: &font,
            lines: &lines,
        };
        pen.group(tree.root())?;
    }
    let mut outline = Outline::new();
    for heading in headings {
        let place = XyzDestination::new(heading.page, Point::from_xy(0.0, heading.y as f32));
        outline.push_child(OutlineNode::new(heading.title.clone(), place));
    }
    if !headings.is_empty() {
        document.set_outline(outline);
    }
    let metadata = Metadata::new()
        .title(title.to_owned())
        .language("en".to_owned())
        .creator("Taxel".to_owned());
    document.set_metadata(metadata);
    document.finish().map_err(|error| Error::Pdf {
        message: error.to_string(),
    })
}

/// The error for a part that a PDF is not written with; [`crate::svg::Canvas`] draws none of them.
pub(super) fn refused(what: &str) -> Error {
    Error::Pdf {
        message: format!("{what} cannot be written"),
    }
}

/// What draws on a page.
struct Pen<'a> {
    surface: Surface<'a>,
    font: &'a Font,
    /// The texts of the document, by the number in the name of their path.
    lines: &'a [Line],
}

impl Pen<'_> {
    fn group(&mut self, group: &Group) -> Result<(), Error> {
        if !group.filters().is_empty()
            || group.mask().is_some()
            || group.blend_mode() != BlendMode::Normal
        {
            return Err(refused("a filter, mask or blending"));
        }
        let opacity = normalised(group.opacity().get())?;
        self.surface
            .push_transform(&paint::place(group.transform()));
        let mut pushed = 1;
        for clip in paint::clips(group.clip_path()) {
            self.surface.push_clip_path(&clip, &FillRule::NonZero);
            pushed += 1;
        }
        if opacity != NormalizedF32::ONE {
            self.surface.push_opacity(opacity);
            pushed += 1;
        }
        let drawn = group.children().iter().try_for_each(|node| self.node(node));
        // Also after an error: a surface that is left with something pushed panics.
        for _ in 0..pushed {
            self.surface.pop();
        }
        drawn
    }

    fn node(&mut self, node: &Node) -> Result<(), Error> {
        match node {
            Node::Group(group) => self.group(group),
            Node::Path(path) => self.path(path),
            Node::Image(image) => self.image(image),
            Node::Text(_) => Err(refused("a text without outlines")),
        }
    }

    /// A path, or the text that it is the outline of.
    fn path(&mut self, path: &usvg::Path) -> Result<(), Error> {
        let fill = path.fill().map(paint::fill).transpose()?;
        let stroke = path.stroke().map(paint::stroke).transpose()?;
        if !path.is_visible() || (fill.is_none() && stroke.is_none()) {
            return Ok(());
        }
        self.surface.set_fill(fill);
        self.surface.set_stroke(stroke);
        match line_number(path.id()).and_then(|number| self.lines.get(number)) {
            Some(line) => self.text(line),
            None => {
                if let Some(path) = paint::path(path.data(), Transform::identity()) {
                    self.surface.draw_path(&path);
                }
            }
        }
        Ok(())
    }

    fn text(&mut self, line: &Line) {
        let mut glyphs = Vec::new();
        for (start, character) in line.text.char_indices() {
            let mut push = |glyph: u16, advance: f64| {
                let range = start..start + character.len_utf8();
                let (id, advance) = (GlyphId::new(glyph.into()), advance as f32);
                glyphs.push(KrillaGlyph::new(id, advance, 0.0, 0.0, 0.0, range, None));
            };
            let glyph = glyph_of(character);
            push(glyph.0, advance_of(glyph));
            if glyph.0 == 0 {
                // The font's empty box stands for no character. What two glyphs draw is written out beside them, so that it
                // is found as well.
                push(glyph_of(' ').0, 0.0);
            }
        }
        let start = Point::from_xy(line.x as f32, line.y as f32);
        let (font, size) = (self.font.clone(), line.size as f32);
        self.surface
            .draw_glyphs(start, &glyphs, font, &line.text, size, false);
    }

    fn image(&mut self, image: &usvg::Image) -> Result<(), Error> {
        let ImageKind::PNG(png) = image.kind() else {
            return Err(refused("a picture that is no PNG"));
        };
        let is_smooth = !matches!(
            image.rendering_mode(),
            ImageRendering::OptimizeSpeed | ImageRendering::Pixelated | ImageRendering::CrispEdges
        );
        let pixels = Image::from_png(png.clone().into(), is_smooth)
            .map_err(|message| Error::Pdf { message })?;
        let size = Size::from_wh(image.size().width(), image.size().height())
            .ok_or_else(|| refused("the size of an image"))?;
        self.surface.draw_image(pixels, size);
        Ok(())
    }
}

pub(super) fn normalised(share: f32) -> Result<NormalizedF32, Error> {
    NormalizedF32::new(share).ok_or_else(|| refused("an opacity outside of 0 to 1"))
}
