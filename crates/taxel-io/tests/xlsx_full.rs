//! A sheet goes through a temporary file: it lies beside the output, and when it cannot be written that is an error.
//! Each test runs its second half in a process of its own, whose folder for temporary files or largest file is another.
#![cfg(all(feature = "xlsx", target_os = "linux"))]

use std::path::{Path, PathBuf};
use std::process::Command;

use taxel_io::{Column, Error, write_columns};

/// Where the second half is to write.
const FOLDER: &str = "TAXEL_TEST_FOLDER";

/// Some megabytes of lines.
fn columns() -> Vec<Column> {
    let column = |name: &str| Column {
        name: name.to_owned(),
        values: (0..40_000).map(f64::from).collect(),
    };
    vec![column("frame"), column("newtons")]
}

/// None when every ignored test of the repository is run.
fn folder() -> Option<PathBuf> {
    std::env::var_os(FOLDER).map(PathBuf::from)
}

/// Runs the ignored test `name` of this program from a shell that has done `before`.
fn assert_passes(before: &str, name: &str, folder: &Path) {
    let script = format!("{before} exec \"$0\" --exact --ignored {name}");
    let output = Command::new("bash")
        .args(["-c", &script])
        .arg(std::env::current_exe().unwrap())
        .env(FOLDER, folder)
        .output()
        .unwrap();
    let told = String::from_utf8_lossy(&output.stdout);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{told}{errors}");
    assert!(told.contains("1 passed"), "{told}");
}

#[test]
fn a_sheet_needs_no_room_but_beside_it() {
    let folder = tempfile::tempdir().unwrap();
    let before = "export TMPDIR=/nowhere/at/all;";
    assert_passes(before, "writes_a_sheet", folder.path());
    let names: Vec<_> = std::fs::read_dir(folder.path()).unwrap().collect();
    assert_eq!(names.len(), 1);
}

#[test]
#[ignore = "the second half of another"]
fn writes_a_sheet() {
    let Some(folder) = folder() else {
        return;
    };
    write_columns(folder.join("a.xlsx"), &columns()).unwrap();
}

#[test]
fn a_temporary_file_that_cannot_be_written_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let before = "trap '' XFSZ; ulimit -f 256;";
    assert_passes(before, "is_told_of_the_temporary_file", folder.path());
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
#[ignore = "the second half of another"]
fn is_told_of_the_temporary_file() {
    let Some(folder) = folder() else {
        return;
    };
    let path = folder.join("a.xlsx");
    let error = write_columns(&path, &columns()).unwrap_err();
    assert!(matches!(error, Error::Write { .. }), "{error:?}");
    let words = format!(
        "the temporary file of its lines, in {}, could not be written",
        folder.display()
    );
    assert!(error.to_string().contains(&words), "{error}");
}
