//! Laying a picture out to fit the size that it is asked to have.

use crate::Error;
use crate::extent::Extent;
use crate::heatmap::layout::Room;
use crate::picture::Picture;
use crate::svg::Canvas;

/// A layout is found in a few steps; this many say that there is none.
const MOST_TRIES: usize = 64;

/// What has been drawn, with what the next try must know of it.
#[derive(Debug)]
pub(crate) struct Drawn {
    pub(crate) canvas: Canvas,
    pub(crate) width: f64,
    pub(crate) height: f64,
    /// Of its largest plot, without axes.
    pub(crate) plot: (f64, f64),
    /// How many plots stand beside and below each other.
    pub(crate) grid: (usize, usize),
}

impl Drawn {
    /// As a picture just as large.
    pub(crate) fn whole(self) -> Picture {
        Picture::new(self.canvas, self.width, self.height)
    }

    /// In the middle of a picture of that size.
    fn amid(self, extent: Extent) -> Picture {
        let (width, height) = extent.in_points();
        let mut canvas = Canvas::default();
        let corner = ((width - self.width) / 2.0, (height - self.height) / 2.0);
        canvas.group(corner, 1.0, &self.canvas);
        Picture::exact(canvas, extent)
    }

    /// The room for each plot by which the next try comes nearer to this size.
    fn smaller(&self, room: Room, (width, height): (f64, f64), smallest: Room) -> Room {
        let less = |room: f64, plot: f64, over: f64, count: usize, smallest: f64| {
            if over > 0.0 {
                (room.min(plot) - over / count as f64).max(smallest)
            } else {
                room
            }
        };
        let over = (self.width - width, self.height - height);
        let (across, down) = self.grid;
        Room {
            width: less(room.width, self.plot.0, over.0, across, smallest.width),
            height: less(room.height, self.plot.1, over.1, down, smallest.height),
        }
    }
}

/// What `compose` draws with plots as large as fit in a picture of that size, and the area of a plot in it.
///
/// # Errors
/// [`Error::NoRoom`] where plots as small as `smallest` do not fit either.
pub(crate) fn fit(
    extent: Extent,
    smallest: Room,
    compose: impl Fn(Room) -> Result<Drawn, Error>,
) -> Result<(Picture, f64), Error> {
    let size = extent.in_points();
    let mut room = Room {
        width: size.0.max(smallest.width),
        height: size.1.max(smallest.height),
    };
    for _ in 0..MOST_TRIES {
        let drawn = compose(room)?;
        if drawn.width <= size.0 && drawn.height <= size.1 {
            let area = drawn.plot.0 * drawn.plot.1;
            return Ok((drawn.amid(extent), area));
        }
        let next = drawn.smaller(room, size, smallest);
        // What is over in one direction may be the other's doing, such as a bar that stands beside a high plot.
        room = if next != room {
            next
        } else if room != smallest {
            smallest
        } else {
            break;
        };
    }
    let least = compose(smallest)?;
    Err(extent.no_room(least.width, least.height))
}
