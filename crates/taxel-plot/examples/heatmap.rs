//! Draws a press on a 16 × 16 array: `cargo run -p taxel-plot --example heatmap -- press.png`

use taxel::Frame;
use taxel::frame::Newtons;
use taxel_plot::{Format, Panel};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args()
        .nth(1)
        .unwrap_or_else(|| "press.png".to_owned());
    let format = Format::from_extension(&path)?;
    let values = (0..256)
        .map(|i| {
            let (row, column) = (f64::from(i / 16), f64::from(i % 16));
            4.0 * (-((row - 6.0).powi(2) + (column - 9.0).powi(2)) / 9.0).exp()
        })
        .collect();
    let frame = Frame::<Newtons>::new(16, 16, values)?;
    let picture = Panel::of(&frame).title("one press").picture()?;
    std::fs::write(&path, picture.render(format)?)?;
    eprintln!(
        "wrote {path}, {} x {} points",
        picture.width(),
        picture.height()
    );
    Ok(())
}
