//! Benchmarks, apart from the crates so that their tests build without criterion.
