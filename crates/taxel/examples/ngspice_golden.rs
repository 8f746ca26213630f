//! Writes the netlist of every case of `testdata/ngspice` into a folder, as `NAME.cir`:
//! `cargo run -p taxel --example ngspice_golden -- FOLDER`. `testdata/ngspice/reproduce.sh` runs them.

#[path = "../tests/golden/mod.rs"]
mod golden;

use std::path::PathBuf;

use taxel::circuit::netlist::{Selection, netlist};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = std::env::args()
        .nth(1)
        .ok_or("usage: ngspice_golden FOLDER")?;
    let folder = PathBuf::from(folder);
    std::fs::create_dir_all(&folder)?;
    for case in golden::cases() {
        let selection = if case.v_out.is_empty() {
            Selection::Scan
        } else {
            let taxels = case.v_out.iter().map(|&(row, column, _)| (row, column));
            Selection::Taxels(taxels.collect())
        };
        let text = netlist(&case.sensor, &case.conductance, selection)?;
        std::fs::write(folder.join(format!("{}.cir", case.name)), text)?;
    }
    Ok(())
}
