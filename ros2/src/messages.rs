//! The messages of ROS 2 that are sent: `sensor_msgs/Image` and `geometry_msgs/WrenchStamped`, field by field in the order of
//! their definitions, which is how CDR has them.

use ros2_client::Message;
use serde::{Deserialize, Serialize};

/// `builtin_interfaces/Time`: seconds and nanoseconds since 1970.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Time {
    pub sec: i32,
    pub nanosec: u32,
}

impl Time {
    /// Of seconds since 1970.
    pub fn from_secs(secs: f64) -> Self {
        let nanos = (secs * 1e9).round() as i64;
        Self {
            sec: nanos.div_euclid(1_000_000_000) as i32,
            nanosec: nanos.rem_euclid(1_000_000_000) as u32,
        }
    }
}

/// `std_msgs/Header`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Header {
    pub stamp: Time,
    pub frame_id: String,
}

/// `sensor_msgs/Image`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Image {
    pub header: Header,
    pub height: u32,
    pub width: u32,
    pub encoding: String,
    pub is_bigendian: u8,
    pub step: u32,
    pub data: Vec<u8>,
}

/// `geometry_msgs/Vector3`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Vector3 {
    pub x: f64,
    pub y: f64,
    pub z: f64,
}

/// `geometry_msgs/Wrench`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Wrench {
    pub force: Vector3,
    pub torque: Vector3,
}

/// `geometry_msgs/WrenchStamped`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct WrenchStamped {
    pub header: Header,
    pub wrench: Wrench,
}

impl Message for Image {}
impl Message for WrenchStamped {}

impl Image {
    /// Loads as 32FC1, newtons; NaN where nothing was measured.
    pub fn of_loads(header: Header, rows: &[Vec<Option<f64>>]) -> Self {
        let width = rows.first().map_or(0, Vec::len);
        let pixels = rows.iter().flatten();
        Self {
            header,
            height: rows.len() as u32,
            width: width as u32,
            encoding: "32FC1".to_owned(),
            is_bigendian: 0,
            step: 4 * width as u32,
            data: pixels
                .flat_map(|load| {
                    load.map_or(f32::NAN, |newtons| newtons as f32)
                        .to_le_bytes()
                })
                .collect(),
        }
    }

    /// Its pixels, as [`Self::of_loads`] has written them.
    pub fn pixels(&self) -> impl Iterator<Item = f32> {
        let words = self.data.chunks_exact(4);
        words.map(|word| f32::from_le_bytes([word[0], word[1], word[2], word[3]]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn loads_go_into_an_image_and_back() {
        let header = Header {
            stamp: Time::from_secs(1.25),
            frame_id: "taxel".to_owned(),
        };
        assert_eq!((header.stamp.sec, header.stamp.nanosec), (1, 250_000_000));
        let image = Image::of_loads(header, &[vec![Some(1.5), None], vec![Some(0.0), Some(2.0)]]);
        assert_eq!((image.height, image.width, image.step), (2, 2, 8));
        let pixels: Vec<f32> = image.pixels().collect();
        assert!(pixels[1].is_nan());
        assert_eq!([pixels[0], pixels[2], pixels[3]], [1.5, 0.0, 2.0]);
    }
}
