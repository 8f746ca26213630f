//! Pieces one below the other, over as many pages as they need.

use std::rc::Rc;

use crate::pdf::Heading;
use crate::svg::{Canvas, Rect};

/// Coordinates are rounded to hundredths; that much too high still fits.
const SLACK: f64 = 0.01;

/// What is never cut: a line of text, a picture, a row of a table.
#[derive(Debug, Clone, Default)]
pub(super) struct Piece {
    /// Space above it, in points; none at the top of a page.
    pub(super) before: f64,
    pub(super) height: f64,
    /// Drawn from its upper left corner.
    pub(super) content: Canvas,
    /// It stays on the page of the next piece.
    pub(super) keeps: bool,
    /// The section that begins with it.
    pub(super) heading: Option<String>,
    /// Drawn again above it where it is the first of a page.
    pub(super) head: Option<Rc<Piece>>,
}

/// The pages that `pieces` fill, at least one, and where sections begin. No piece may be higher than `area`.
pub(super) fn pages(pieces: &[Piece], area: Rect) -> (Vec<Canvas>, Vec<Heading>) {
    let mut flow = Flow {
        area,
        pages: vec![Canvas::default()],
        y: area.y,
        headings: Vec::new(),
    };
    let mut rest = pieces;
    while !rest.is_empty() {
        let kept = rest.iter().take_while(|piece| piece.keeps).count();
        let (chain, others) = rest.split_at((kept + 1).min(rest.len()));
        flow.place_chain(chain);
        rest = others;
    }
    (flow.pages, flow.headings)
}

struct Flow {
    area: Rect,
    pages: Vec<Canvas>,
    y: f64,
    headings: Vec<Heading>,
}

impl Flow {
    /// Pieces that belong on one page; where no page holds them all, from the top of one on.
    fn place_chain(&mut self, chain: &[Piece]) {
        let height: f64 = chain.iter().map(|piece| piece.before + piece.height).sum();
        if !self.fits(height) {
            self.turn();
        }
        for piece in chain {
            if !self.fits(piece.before + piece.height) {
                self.turn();
            }
            self.place(piece);
        }
    }

    fn fits(&self, height: f64) -> bool {
        self.y + height <= self.area.bottom() + SLACK
    }

    fn is_at_top(&self) -> bool {
        self.y <= self.area.y
    }

    /// Begins a page, unless this one is empty.
    fn turn(&mut self) {
        if !self.is_at_top() {
            self.pages.push(Canvas::default());
            self.y = self.area.y;
        }
    }

    fn place(&mut self, piece: &Piece) {
        match &piece.head {
            Some(head) if self.is_at_top() => self.draw(head),
            _ => {}
        }
        if !self.is_at_top() {
            self.y += piece.before;
        }
        if let Some(title) = &piece.heading {
            self.headings.push(Heading {
                title: title.clone(),
                page: self.pages.len() - 1,
                y: self.y,
            });
        }
        self.draw(piece);
    }

    fn draw(&mut self, piece: &Piece) {
        if let Some(page) = self.pages.last_mut() {
            page.group((self.area.x, self.y), 1.0, &piece.content);
        }
        self.y += piece.height;
    }
}
