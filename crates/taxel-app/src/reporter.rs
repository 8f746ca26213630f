//! Who hears how long work goes on and what was left out: a terminal, a window, a notebook, nobody.

/// Hears of work in progress.
pub trait Reporter {
    /// Something worth a line.
    fn note(&self, _text: &str) {}

    /// Something is missing, or not as it should be; the work goes on.
    fn warn(&self, _text: &str) {}

    /// A stage of the work begins. It ends when what is given is dropped.
    fn stage(&self, _name: &str) -> Box<dyn Stage + '_> {
        Box::new(Silent)
    }
}

/// A stage of the work, while it goes on.
pub trait Stage {
    /// The share that is done, 0 to 1.
    fn set(&self, _share: f64) {}

    /// A step is done, whatever the share: who wants no more of the work unwinds here.
    fn step(&self) {}

    /// Whether nobody wants the work any more: asked between steps where it can end with an error.
    fn is_stopped(&self) -> bool {
        false
    }
}

impl dyn Stage + '_ {
    /// A step is done, and the share by bytes read where the whole is known.
    pub fn set_bytes(&self, read: u64, total: Option<u64>) {
        self.step();
        if let Some(total) = total.filter(|&total| total > 0) {
            self.set(read as f64 / total as f64);
        }
    }
}

/// Nobody hears anything.
#[derive(Debug, Clone, Copy, Default)]
pub struct Silent;

impl Reporter for Silent {}

impl Stage for Silent {}

/// Nobody hears anything; the work ends once it is no longer wanted.
#[derive(Clone, Copy)]
pub struct Until<'a>(
    /// Whether nobody wants it any more.
    pub &'a (dyn Fn() -> bool + Sync),
);

impl Reporter for Until<'_> {
    fn stage(&self, _name: &str) -> Box<dyn Stage + '_> {
        Box::new(*self)
    }
}

impl Stage for Until<'_> {
    fn is_stopped(&self) -> bool {
        (self.0)()
    }
}
