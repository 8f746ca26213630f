//! Where a page listens, and who may look.

use std::path::PathBuf;

use taxel_io::bounded;
use taxel_server::{Options as ServerOptions, random_token, token_problem};

use crate::error::Error;

/// The longest file with a token, bytes.
const MAX_TOKEN_FILE: u64 = 64 << 10;

/// The options of a page.
#[derive(Debug, clap::Args)]
pub(super) struct Access {
    /// Address to listen on (a token protects it on other addresses)
    #[arg(long, value_name = "ADDRESS:PORT", default_value = "127.0.0.1:8432")]
    listen: String,
    /// Access token, at least 8 of A-Z, a-z, 0-9, - . _ ~; generated when --listen is not local
    #[arg(long, conflicts_with = "token_file")]
    token: Option<String>,
    /// File whose first line is the access token: unlike --token it does not show in the list of processes
    #[arg(long, value_name = "FILE")]
    token_file: Option<PathBuf>,
}

impl Access {
    /// Where and for whom.
    pub(super) fn server(&self) -> Result<ServerOptions, Error> {
        let mut server = ServerOptions::new(&self.listen);
        server.token = token_of(self)?.or_else(|| needs_token(&self.listen));
        Ok(server)
    }
}

/// The token that was chosen, if it will do.
fn token_of(shown: &Access) -> Result<Option<String>, Error> {
    let token = match (&shown.token, &shown.token_file) {
        (Some(token), _) => token.clone(),
        (None, Some(file)) => {
            let text = bounded::read_text(file, MAX_TOKEN_FILE);
            let text = text.map_err(|error| Error::Arguments {
                what: format!("cannot read the token in {}: {error}", file.display()),
                hint: "its first line is the token",
            })?;
            let text = text.ok_or_else(|| taxel_app::Error::TextLength {
                file: file.clone(),
                what: "a file with a token",
                limit: MAX_TOKEN_FILE,
            })?;
            text.lines().next().unwrap_or_default().trim().to_owned()
        }
        (None, None) => return Ok(None),
    };
    match token_problem(&token) {
        None => Ok(Some(token)),
        Some(what) => Err(Error::Arguments {
            what,
            hint: "letters, digits and - . _ ~; without --token one is made up where it is needed",
        }),
    }
}

/// A token, where the address is not this machine's own.
fn needs_token(listen: &str) -> Option<String> {
    let host = listen.rsplit_once(':').map_or(listen, |(host, _)| host);
    let own = ["127.0.0.1", "localhost", "[::1]"].contains(&host);
    (!own).then(random_token)
}
