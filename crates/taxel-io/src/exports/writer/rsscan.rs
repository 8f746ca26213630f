//! RSscan text, as of an entire plate: newtons a taxel.

use taxel::frame::{Frame, Newtons};

use super::{Layout, push_decimal};

#[derive(Default)]
pub(super) struct RsScan {
    frames: u64,
    /// When the first frame was read: times are told from there.
    first_secs: Option<f64>,
}

impl Layout for RsScan {
    fn frame(&mut self, loads: &Frame<Newtons>, secs: f64, out: &mut Vec<u8>) {
        let ms = 1e3 * (secs - *self.first_secs.get_or_insert(secs));
        out.extend_from_slice(format!("Frame {} ({ms:.2} ms)\r\n", self.frames).as_bytes());
        self.frames += 1;
        for row in loads.values().chunks_exact(loads.columns()) {
            for (at, &load) in row.iter().enumerate() {
                if at > 0 {
                    out.push(b'\t');
                }
                push_decimal(out, load);
            }
            out.extend_from_slice(b"\r\n");
        }
        out.extend_from_slice(b"\r\n");
    }

    fn end(&mut self, _: &mut Vec<u8>) {}
}
