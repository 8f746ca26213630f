//! Pictures of any kind side by side and one below the other, as one.

use crate::heatmap::layout::{TITLE_LEADING, TITLE_SIZE};
use crate::picture::Picture;
use crate::svg::{Anchor, Canvas, Rect};
use crate::{Error, MARGIN, text};

/// Pictures on a grid, row by row, each at the top left of its cell.
#[derive(Debug, Clone)]
pub struct Board {
    pictures: Vec<Picture>,
    title: String,
    columns: usize,
}

impl Board {
    /// A board of `pictures`, two abreast.
    ///
    /// # Errors
    /// [`Error::Empty`] without pictures.
    pub fn new(pictures: Vec<Picture>) -> Result<Board, Error> {
        if pictures.is_empty() {
            return Err(Error::Empty {
                what: "board",
                of: "picture",
            });
        }
        Ok(Board {
            pictures,
            title: String::new(),
            columns: 2,
        })
    }

    /// The line above all of them.
    pub fn title(mut self, title: impl Into<String>) -> Self {
        self.title = title.into();
        self
    }

    /// The board as a picture.
    pub fn picture(&self) -> Picture {
        let rows: Vec<&[Picture]> = self.pictures.chunks(self.columns).collect();
        let width_of = |column: usize| {
            let each = rows.iter().filter_map(|row| row.get(column));
            each.map(|picture| f64::from(picture.width()))
                .fold(0.0, f64::max)
        };
        let widths: Vec<f64> = (0..self.columns).map(width_of).collect();
        let width: f64 = widths.iter().sum();
        let mut canvas = Canvas::default();
        let mut top = 0.0;
        for line in text::wrap(&self.title, TITLE_SIZE, width - 2.0 * MARGIN) {
            top += TITLE_LEADING;
            canvas.text(MARGIN, MARGIN + top - 3.0, TITLE_SIZE, Anchor::Start, &line);
        }
        if top > 0.0 {
            // Pictures have a white margin of their own.
            top += MARGIN;
        }
        for row in rows {
            let (mut left, mut height) = (0.0, 0f64);
            for (picture, width) in row.iter().zip(&widths) {
                let place = Rect {
                    x: left,
                    y: top,
                    width: picture.width().into(),
                    height: picture.height().into(),
                };
                canvas.nested(place, picture.svg());
                left += width;
                height = height.max(place.height);
            }
            top += height;
        }
        Picture::new(canvas, width, top)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Panel;

    #[test]
    fn pictures_stand_beside_and_below_each_other() {
        let one = Panel::new(1, 2, &[0.0, 1.0]).unwrap().picture().unwrap();
        let two = Panel::new(2, 1, &[0.0, 1.0]).unwrap().picture().unwrap();
        let board = Board::new(vec![one.clone(), two.clone(), one.clone()]).unwrap();
        let all = board.title("three").picture();
        assert_eq!(all.width(), one.width() + two.width());
        assert!(all.height() > one.height() + one.height().max(two.height()));
        assert!(all.svg().contains(">three</text>"));
        assert!(all.png().is_ok());
        assert!(Board::new(Vec::new()).is_err());
    }
}
