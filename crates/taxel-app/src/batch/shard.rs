//! One part of an archive among several, for jobs that know nothing of each other.

use std::fmt;
use std::str::FromStr;

/// Every `of`-th recording, from the `number`-th on, counted from 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shard {
    number: usize,
    of: usize,
}

impl Shard {
    /// Those of a list that are its.
    pub fn part<T: Clone>(self, all: &[T]) -> Vec<T> {
        let every = all.iter().skip(self.number - 1).step_by(self.of);
        every.cloned().collect()
    }

    /// As it stands in names of files: `3-of-8`.
    pub fn word(self) -> String {
        format!("{}-of-{}", self.number, self.of)
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parts = text.split_once('/');
        let numbers = parts.and_then(|(i, n)| Some((i.parse().ok()?, n.parse().ok()?)));
        match numbers {
            Some((number, of)) if (1..=of).contains(&number) => Ok(Self { number, of }),
            _ => Err(format!(
                "`{text}` is no part of a whole; `3/8` is the third of eight, `1/8` the first"
            )),
        }
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.number, self.of)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_parts_are_the_whole() {
        let all: Vec<usize> = (0..23).collect();
        for of in [1, 2, 5, 23, 40] {
            let shards = (1..=of).map(|i| format!("{i}/{of}").parse::<Shard>().unwrap());
            let mut found: Vec<usize> = shards.flat_map(|shard| shard.part(&all)).collect();
            found.sort_unstable();
            assert_eq!(found, all);
        }
    }

    #[test]
    fn what_is_no_part_is_refused() {
        for text in ["0/3", "4/3", "1", "a/b", "1/0", "-1/3", "1/3/5", ""] {
            assert!(text.parse::<Shard>().is_err(), "{text}");
        }
    }
}
