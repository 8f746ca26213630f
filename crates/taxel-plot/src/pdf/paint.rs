//! Shapes and colours of a parsed document in the words of the PDF's writer.

use krilla::color::rgb;
use krilla::geom::{Path, PathBuilder, Transform};
use krilla::paint::{Fill, FillRule, LineCap, LineJoin, Paint, Stroke, StrokeDash};
use resvg::tiny_skia::{self, PathSegment};
use resvg::usvg::{self, ClipPath, Group, Node};

use super::writer::{normalised, refused};
use crate::Error;

pub(super) fn place(transform: tiny_skia::Transform) -> Transform {
    Transform::from_row(
        transform.sx,
        transform.ky,
        transform.kx,
        transform.sy,
        transform.tx,
        transform.ty,
    )
}

/// The path where `transform` brings it; none if nothing is left of it.
pub(super) fn path(path: &tiny_skia::Path, transform: Transform) -> Option<Path> {
    let mut out = PathBuilder::new();
    extend(&mut out, path);
    out.finish()?.transform(transform)
}

fn extend(out: &mut PathBuilder, path: &tiny_skia::Path) {
    for segment in path.segments() {
        match segment {
            PathSegment::MoveTo(p) => out.move_to(p.x, p.y),
            PathSegment::LineTo(p) => out.line_to(p.x, p.y),
            PathSegment::QuadTo(a, p) => out.quad_to(a.x, a.y, p.x, p.y),
            PathSegment::CubicTo(a, b, p) => out.cubic_to(a.x, a.y, b.x, b.y, p.x, p.y),
            PathSegment::Close => out.close(),
        }
    }
}

/// What a group is cut to, each within those before.
pub(super) fn clips(clip: Option<&ClipPath>) -> Vec<Path> {
    let Some(clip) = clip else {
        return Vec::new();
    };
    let mut found = clips(clip.clip_path());
    let mut shape = PathBuilder::new();
    add_shapes(&mut shape, clip.root(), clip.transform());
    found.extend(shape.finish());
    found
}

fn add_shapes(out: &mut PathBuilder, group: &Group, transform: tiny_skia::Transform) {
    for node in group.children() {
        match node {
            Node::Path(path) => {
                if let Some(path) = path.data().clone().transform(transform) {
                    extend(out, &path);
                }
            }
            Node::Group(group) => add_shapes(out, group, transform.pre_concat(group.transform())),
            _ => {}
        }
    }
}

fn paint(paint: &usvg::Paint) -> Result<Paint, Error> {
    match paint {
        usvg::Paint::Color(colour) => {
            Ok(rgb::Color::new(colour.red, colour.green, colour.blue).into())
        }
        _ => Err(refused("a gradient or pattern")),
    }
}

pub(super) fn fill(fill: &usvg::Fill) -> Result<Fill, Error> {
    Ok(Fill {
        paint: paint(fill.paint())?,
        opacity: normalised(fill.opacity().get())?,
        rule: match fill.rule() {
            usvg::FillRule::NonZero => FillRule::NonZero,
            usvg::FillRule::EvenOdd => FillRule::EvenOdd,
        },
    })
}

pub(super) fn stroke(stroke: &usvg::Stroke) -> Result<Stroke, Error> {
    Ok(Stroke {
        paint: paint(stroke.paint())?,
        width: stroke.width().get(),
        miter_limit: stroke.miterlimit().get(),
        line_cap: match stroke.linecap() {
            usvg::LineCap::Butt => LineCap::Butt,
            usvg::LineCap::Round => LineCap::Round,
            usvg::LineCap::Square => LineCap::Square,
        },
        line_join: match stroke.linejoin() {
            usvg::LineJoin::Miter | usvg::LineJoin::MiterClip => LineJoin::Miter,
            usvg::LineJoin::Round => LineJoin::Round,
            usvg::LineJoin::Bevel => LineJoin::Bevel,
        },
        opacity: normalised(stroke.opacity().get())?,
        dash: stroke.dasharray().map(|lengths| StrokeDash {
            array: lengths.to_vec(),
            offset: stroke.dashoffset(),
        }),
    })
}
