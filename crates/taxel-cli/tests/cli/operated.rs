//! The binary with somebody at its terminal.

use std::io::{BufRead, BufReader, Read, Write};
use std::process::{Child, ChildStderr};

use crate::run::Folder;

/// The program, and an operator who reads what it says.
pub struct Operated {
    pub child: Child,
    said: BufReader<ChildStderr>,
    text: String,
}

impl Operated {
    pub fn begin(folder: &Folder, words: &str) -> Self {
        let mut child = folder.spawn(words);
        let said = BufReader::new(child.stderr.take().unwrap());
        Self {
            child,
            said,
            text: String::new(),
        }
    }

    /// Waits until it says `words`.
    pub fn hear(&mut self, words: &str) {
        let mut line = String::new();
        while !line.contains(words) {
            line.clear();
            let read = self.said.read_line(&mut line).unwrap();
            assert!(read > 0, "it never says {words:?}:\n{}", self.text);
            self.text += &line;
        }
    }

    /// Waits until it says `words`, and answers.
    pub fn answer(&mut self, words: &str, answer: &str) {
        self.hear(words);
        writeln!(self.child.stdin.as_mut().unwrap(), "{answer}").unwrap();
    }

    /// Its exit code, and what it printed.
    pub fn end(mut self) -> (Option<i32>, String, String) {
        drop(self.child.stdin.take());
        self.said.read_to_string(&mut self.text).unwrap();
        let mut printed = String::new();
        let out = self.child.stdout.as_mut().unwrap();
        out.read_to_string(&mut printed).unwrap();
        (self.child.wait().unwrap().code(), printed, self.text)
    }
}
