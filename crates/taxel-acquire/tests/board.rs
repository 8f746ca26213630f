//! The description of a board that the examples ship is read, and what cannot be is said.
#![cfg(feature = "std")]

use taxel_acquire::scan::Timing;
use taxel_acquire::scan::config::Board;

const BOARD: &str = include_str!("../../../examples/econe/board.toml");

#[test]
fn the_e_cone_s_board_is_read() {
    let board = Board::from_toml(BOARD).unwrap();
    assert_eq!((board.rows.count, board.columns.count), (64, 128));
    assert_eq!(Timing::from(board.timing).column_settling_ns, 20_000);
}

#[test]
fn what_cannot_be_is_said() {
    for (from, to, says) in [
        (
            "count = 64",
            "count = 65",
            "select 64 lines, but there are 65",
        ),
        ("count = 64", "count = 0", "expected at least 1"),
        ("bits = 16", "bits = 17", "expected 1 to 16"),
        ("bits = 16", "bots = 16", "unknown field"),
        (
            "[timing]",
            "[timing]\nrow_settling_us = -1.0 #",
            "settling times",
        ),
    ] {
        let changed = BOARD.replacen(from, to, 1);
        assert_ne!(changed, BOARD, "{from}");
        let error = Board::from_toml(&changed).unwrap_err().to_string();
        assert!(error.contains(says), "{to}: {error}");
    }
}
