//! Lines of a header, as pairs of a key and a value.

/// The pairs of a header, keys in small letters.
#[derive(Debug, Clone, Default)]
pub(super) struct Pairs {
    pairs: Vec<(String, String, u64)>,
}

impl Pairs {
    /// Takes a line apart at the first of `separators`; one without is a key without a value.
    pub(super) fn add(&mut self, line: &str, separators: &[char], number: u64) {
        let (key, value) = line.split_once(separators).unwrap_or((line, ""));
        let key = key.trim().trim_matches('"').to_lowercase();
        // Two of the separators may stand together, as in `Key: = value`.
        let value = value.trim_start_matches(|c: char| matches!(c, ':' | '=') || c.is_whitespace());
        let value = value.trim_matches(|c: char| matches!(c, ',' | ';' | '"') || c.is_whitespace());
        self.pairs.push((key, value.to_owned(), number));
    }

    /// Takes a pair that is parted already, its key in small letters.
    pub(super) fn add_pair(&mut self, key: &str, value: &str, number: u64) {
        self.pairs.push((key.to_owned(), value.to_owned(), number));
    }

    /// Gives a key another name.
    pub(super) fn rename(&mut self, from: &str, to: &str) {
        let found = self.pairs.iter_mut().filter(|(key, ..)| key == from);
        found.for_each(|(key, ..)| to.clone_into(key));
    }

    /// Every pair, with the number of its line.
    pub(super) fn all(&self) -> impl Iterator<Item = (&str, &str, u64)> {
        let pairs = self.pairs.iter();
        pairs.map(|(key, value, line)| (key.as_str(), value.as_str(), *line))
    }

    /// The value of a key, where it has one.
    pub(super) fn get(&self, key: &str) -> Option<&str> {
        let mut values = self.pairs.iter().filter(|(own, ..)| own == key);
        let found = values.next().map(|(_, value, _)| value.as_str());
        found.filter(|value| !value.is_empty())
    }

    /// The last value of a key that `is_it` says so of: a comment may begin with the word of a key.
    pub(super) fn last_where(&self, key: &str, is_it: impl Fn(&str) -> bool) -> Option<&str> {
        let mut values = self.pairs.iter().rev().filter(|(own, ..)| own == key);
        let found = values.find(|(_, value, _)| is_it(value));
        found.map(|(_, value, _)| value.as_str())
    }

    /// The number of its line.
    pub(super) fn line_of(&self, key: &str) -> u64 {
        let found = self.pairs.iter().find(|(own, ..)| own == key);
        found.map_or(0, |(.., number)| *number)
    }

    /// A value that is a whole number above 0.
    pub(super) fn count(&self, key: &str) -> Option<usize> {
        self.get(key)?.parse().ok().filter(|count| *count > 0)
    }

    /// A value that begins with a number above 0.
    pub(super) fn positive(&self, key: &str) -> Option<f64> {
        let (value, _) = super::cells::number_and_rest(self.get(key)?)?;
        Some(value).filter(|value| *value > 0.0)
    }
}
