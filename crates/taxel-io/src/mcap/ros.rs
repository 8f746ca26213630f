//! What ROS 2 and programs that know its messages read of a recording: loads and marks as images, the total as a wrench. Serialized
//! as CDR (OMG DDSI-RTPS 10.2.1.2, little-endian): each number begins at a multiple of its size.

use taxel::metric::is_usable;
use taxel::{Frame, Newtons};

/// The schema of images.
pub(super) const IMAGE: (&str, &str) = (
    "sensor_msgs/msg/Image",
    "std_msgs/Header header\nuint32 height\nuint32 width\nstring encoding\nuint8 is_bigendian\nuint32 step\nuint8[] data\n================================================================================\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n================================================================================\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n",
);
/// The schema of a force and a torque.
pub(super) const WRENCH: (&str, &str) = (
    "geometry_msgs/msg/WrenchStamped",
    "std_msgs/Header header\ngeometry_msgs/Wrench wrench\n================================================================================\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n================================================================================\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n================================================================================\nMSG: geometry_msgs/Wrench\ngeometry_msgs/Vector3 force\ngeometry_msgs/Vector3 torque\n================================================================================\nMSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n",
);

/// Bytes before the first field: which encoding it is.
const ENCAPSULATION: [u8; 4] = [0, 1, 0, 0];

/// A message being written.
struct Cdr<'a>(&'a mut Vec<u8>);

impl<'a> Cdr<'a> {
    /// Begins it with its header: when, and in whose frame of reference.
    fn begin(out: &'a mut Vec<u8>, nanos: u64, frame_id: &str) -> Self {
        out.clear();
        out.extend_from_slice(&ENCAPSULATION);
        let mut cdr = Self(out);
        cdr.u32((nanos / 1_000_000_000) as u32);
        cdr.u32((nanos % 1_000_000_000) as u32);
        cdr.text(frame_id);
        cdr
    }

    fn align(&mut self, size: usize) {
        let length = (self.0.len() - ENCAPSULATION.len()).next_multiple_of(size);
        self.0.resize(length + ENCAPSULATION.len(), 0);
    }

    fn u32(&mut self, value: u32) {
        self.align(4);
        self.0.extend_from_slice(&value.to_le_bytes());
    }

    fn f64(&mut self, value: f64) {
        self.align(8);
        self.0.extend_from_slice(&value.to_le_bytes());
    }

    /// A text, and the zero that closes it.
    fn text(&mut self, text: &str) {
        self.u32(text.len() as u32 + 1);
        self.0.extend_from_slice(text.as_bytes());
        self.0.push(0);
    }

    /// What stands in an image before its pixels; so many bytes each.
    fn image(&mut self, (rows, columns): (usize, usize), encoding: &str, pixel: usize) {
        self.u32(rows as u32);
        self.u32(columns as u32);
        self.text(encoding);
        // Little-endian.
        self.0.push(0);
        self.u32((pixel * columns) as u32);
        self.u32((pixel * rows * columns) as u32);
    }
}

/// Loads as an image of newtons; NaN where nothing was measured, or there is no taxel.
pub(super) fn loads_image(out: &mut Vec<u8>, loads: &Frame<Newtons>, nanos: u64, frame_id: &str) {
    let mut cdr = Cdr::begin(out, nanos, frame_id);
    cdr.image((loads.rows(), loads.columns()), "32FC1", 4);
    for (&load, mark) in loads.values().iter().zip(loads.marks()) {
        let pixel = if is_usable(*mark) {
            load as f32
        } else {
            f32::NAN
        };
        out.extend_from_slice(&pixel.to_le_bytes());
    }
}

/// Marks as an image of their codes.
pub(super) fn marks_image(out: &mut Vec<u8>, loads: &Frame<Newtons>, nanos: u64, frame_id: &str) {
    let mut cdr = Cdr::begin(out, nanos, frame_id);
    cdr.image((loads.rows(), loads.columns()), "mono8", 1);
    out.extend(loads.marks().iter().map(|mark| mark.code()));
}

/// The sum of all loads, into the surface: along z.
pub(super) fn total_wrench(out: &mut Vec<u8>, loads: &Frame<Newtons>, nanos: u64, frame_id: &str) {
    let total: f64 = loads.values().iter().sum();
    let mut cdr = Cdr::begin(out, nanos, frame_id);
    for number in [0.0, 0.0, total, 0.0, 0.0, 0.0] {
        cdr.f64(number);
    }
}
