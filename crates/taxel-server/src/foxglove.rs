//! Frames for Foxglove, live: its own server and its own messages, over WebSocket.
//!
//! | topic | message | what |
//! |---|---|---|
//! | `/taxel/loads` | `foxglove.Grid` | `newtons` (float32) and `mark` (uint8) a cell, with the array's pitch |
//! | `/taxel/loads/image` | `foxglove.RawImage`, 32FC1 | newtons, NaN where nothing was measured |
//! | `/taxel/figures` | `taxel.FrameFigures` (JSON) | total force, peak, contact area, centre of pressure |

use std::io;
use std::sync::Arc;
use std::time::{SystemTime, UNIX_EPOCH};

use foxglove::messages::packed_element_field::NumericType;
use foxglove::messages::{
    Grid, PackedElementField, Pose, Quaternion, RawImage, Timestamp, Vector2, Vector3,
};
use foxglove::{
    Channel, ChannelBuilder, Context, FoxgloveError, PartialMetadata, RawChannel, Schema,
    WebSocketServer, WebSocketServerHandle,
};
use serde::Serialize;
use taxel::metric::{FrameFigures, is_usable};
use taxel::{Frame, Newtons, Sensor};

/// Frames of reference need a name; there is one.
const FRAME_ID: &str = "taxel";
const FIGURES_SCHEMA: &str = r#"{"title":"taxel.FrameFigures","type":"object","properties":{"total_force_newtons":{"type":["number","null"]},"peak_kilopascals":{"type":["number","null"]},"contact_area_mm2":{"type":["number","null"]},"centre_row_mm":{"type":["number","null"]},"centre_column_mm":{"type":["number","null"]},"measured_share":{"type":"number"}}}"#;

/// The server. Dropped, it ends.
pub struct FoxgloveServer {
    server: Option<WebSocketServerHandle>,
    /// Without it the channels close.
    _context: Arc<Context>,
    grid: Channel<Grid>,
    image: Channel<RawImage>,
    figures: Arc<RawChannel>,
    pitch_mm: [f64; 2],
    message: Vec<u8>,
}

/// Figures as they stand in a message: null where there are no loads.
#[derive(Serialize)]
struct FiguresJson {
    total_force_newtons: Option<f64>,
    peak_kilopascals: Option<f64>,
    contact_area_mm2: Option<f64>,
    centre_row_mm: Option<f64>,
    centre_column_mm: Option<f64>,
    measured_share: f64,
}

impl FoxgloveServer {
    /// Begins to listen; port 0 takes a free one.
    ///
    /// # Errors
    /// An address that cannot be listened on.
    pub fn start(host: &str, port: u16, sensor: &Sensor) -> io::Result<Self> {
        let context = Context::new();
        let channel = |topic: &str| ChannelBuilder::new(topic).context(&context);
        let figures = channel("/taxel/figures")
            .message_encoding("json")
            .schema(Schema::new(
                "taxel.FrameFigures",
                "jsonschema",
                FIGURES_SCHEMA.as_bytes().to_vec(),
            ))
            .build_raw()
            .map_err(failed)?;
        let grid = channel("/taxel/loads").build();
        let image = channel("/taxel/loads/image").build();
        let server = WebSocketServer::new()
            .name(sensor.name())
            .bind(host, port)
            .context(&context)
            .start_blocking()
            .map_err(failed)?;
        Ok(Self {
            server: Some(server),
            _context: context,
            grid,
            image,
            figures,
            pitch_mm: sensor.array().pitch_mm,
            message: Vec::new(),
        })
    }

    /// The port that it listens on.
    pub fn port(&self) -> u16 {
        self.server.as_ref().map_or(0, WebSocketServerHandle::port)
    }

    /// Sends a frame to whoever watches, if anybody does; without loads its figures are null.
    pub fn send(&mut self, loads: Option<&Frame<Newtons>>, figures: &FrameFigures, at: SystemTime) {
        let since = at.duration_since(UNIX_EPOCH).unwrap_or_default();
        let nanos = since.as_nanos() as u64;
        let time = Timestamp::new(since.as_secs() as u32, since.subsec_nanos());
        let meta = PartialMetadata {
            log_time: Some(nanos),
        };
        if let Some(loads) = loads {
            if self.grid.has_sinks() {
                self.grid.log_with_meta(&self.grid_of(loads, time), meta);
            }
            if self.image.has_sinks() {
                self.image.log_with_meta(&image_of(loads, time), meta);
            }
        }
        if self.figures.has_sinks() {
            let centre = figures.centre_mm.filter(|_| loads.is_some());
            let json = FiguresJson {
                total_force_newtons: loads.map(|_| figures.total_force_newtons),
                peak_kilopascals: loads.map(|_| figures.peak_kilopascals),
                contact_area_mm2: loads.map(|_| figures.contact_area_mm2),
                centre_row_mm: centre.map(|centre| centre[0]),
                centre_column_mm: centre.map(|centre| centre[1]),
                measured_share: figures.measured_share,
            };
            self.message.clear();
            // Numbers become numbers, and what is none becomes null; there is nothing that could fail.
            let _ = serde_json::to_writer(&mut self.message, &json);
            self.figures.log_with_meta(&self.message, meta);
        }
    }

    fn grid_of(&self, loads: &Frame<Newtons>, time: Timestamp) -> Grid {
        let mut data = Vec::with_capacity(5 * loads.taxels());
        for (&load, mark) in loads.values().iter().zip(loads.marks()) {
            data.extend((load as f32).to_le_bytes());
            data.push(mark.code());
        }
        let field = |name: &str, offset, numeric: NumericType| PackedElementField {
            name: name.to_owned(),
            offset,
            r#type: numeric.into(),
        };
        Grid {
            timestamp: Some(time),
            frame_id: FRAME_ID.to_owned(),
            pose: Some(Pose {
                position: Some(Vector3::default()),
                orientation: Some(Quaternion {
                    w: 1.0,
                    ..Quaternion::default()
                }),
            }),
            column_count: loads.columns() as u32,
            cell_size: Some(Vector2 {
                x: self.pitch_mm[1] / 1000.0,
                y: self.pitch_mm[0] / 1000.0,
            }),
            row_stride: 5 * loads.columns() as u32,
            cell_stride: 5,
            fields: vec![
                field("newtons", 0, NumericType::Float32),
                field("mark", 4, NumericType::Uint8),
            ],
            data: data.into(),
        }
    }
}

fn image_of(loads: &Frame<Newtons>, time: Timestamp) -> RawImage {
    let mut data = Vec::with_capacity(4 * loads.taxels());
    for (&load, mark) in loads.values().iter().zip(loads.marks()) {
        let pixel = if is_usable(*mark) {
            load as f32
        } else {
            f32::NAN
        };
        data.extend(pixel.to_le_bytes());
    }
    RawImage {
        timestamp: Some(time),
        frame_id: FRAME_ID.to_owned(),
        width: loads.columns() as u32,
        height: loads.rows() as u32,
        encoding: "32FC1".to_owned(),
        step: 4 * loads.columns() as u32,
        data: data.into(),
    }
}

fn failed(error: FoxgloveError) -> io::Error {
    match error {
        FoxgloveError::Bind(source) => source,
        other => io::Error::other(other),
    }
}

impl Drop for FoxgloveServer {
    fn drop(&mut self) {
        if let Some(server) = self.server.take() {
            server.stop().wait_blocking();
        }
    }
}
