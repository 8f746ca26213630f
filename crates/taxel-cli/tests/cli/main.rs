//! The real `taxel` binary, as users and scripts see it: exit code, standard output, standard error.

mod absent;
mod analyse;
mod bad_input;
mod bounds;
mod calibrate;
mod check;
mod compensate;
mod design;
mod evaluate;
mod files;
mod help;
mod identify;
mod intervals;
mod learn;
mod left_out;
mod line_ends;
mod live;
mod look;
mod record;
mod recordings;
mod rewritten;
mod run;
mod selftest;
mod simulate;
mod tables;
mod viewers;
