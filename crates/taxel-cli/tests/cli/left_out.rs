//! Formats that a build was made without.
#![cfg(not(any(feature = "parquet", feature = "xlsx")))]

use crate::run::Folder;

#[test]
fn a_format_that_is_left_out_is_told_with_what_to_do() {
    let folder = Folder::new();
    folder.good("simulate --sensor sensor.toml --pattern hand --frames 3 -o run.txt");
    for (words, file, format, feature) in [
        (
            "convert run.txt --sensor sensor.toml -o a.parquet",
            "a.parquet",
            "Parquet",
            "parquet",
        ),
        ("info b.parquet", "b.parquet", "Parquet", "parquet"),
        (
            "compensate run.txt --sensor sensor.toml -o c.parquet",
            "c.parquet",
            "Parquet",
            "parquet",
        ),
        (
            "analyse run.txt --sensor sensor.toml --row 1 --export d.xlsx",
            "d.xlsx",
            "XLSX",
            "xlsx",
        ),
        (
            "analyse run.txt --sensor sensor.toml --row 1 --export e.parquet",
            "e.parquet",
            "Parquet",
            "parquet",
        ),
    ] {
        let run = folder.fails(words);
        assert_eq!(run.code, Some(1), "{run}");
        let expected = format!(
            "error: {file}: this build has no {format}\nhint: `cargo install --path crates/taxel-cli --features {feature}`\n"
        );
        assert!(run.err.ends_with(&expected), "{run}");
        assert!(!folder.exists(file));
    }
}

#[cfg(not(feature = "foxglove"))]
#[test]
fn a_server_that_is_left_out_is_told_with_what_to_do() {
    let folder = Folder::new();
    let run =
        folder.fails("live sim:sensor.toml?uniform --listen=127.0.0.1:0 --foxglove=127.0.0.1:0");
    assert!(
        run.err.ends_with(
            "error: --foxglove=127.0.0.1:0: this build has no Foxglove\nhint: `cargo install --path crates/taxel-cli --features foxglove`\n"
        ),
        "{run}"
    );
}
