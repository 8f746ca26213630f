//! What a session that goes on has to say, said once.

use crate::out;

/// Warnings and troubles that were told already.
#[derive(Debug, Default)]
pub(crate) struct News {
    warnings: Vec<String>,
    trouble: String,
}

impl News {
    /// Tells what is new of both; a trouble that is over and comes again is new.
    pub(crate) fn tell(&mut self, warnings: &[String], trouble: &str) {
        for warning in warnings {
            if !self.warnings.contains(warning) {
                out::warn(warning);
            }
        }
        self.warnings = warnings.to_vec();
        if trouble != self.trouble {
            trouble.clone_into(&mut self.trouble);
            if !trouble.is_empty() {
                out::note(&format!("error: {trouble}"));
            }
        }
    }
}
