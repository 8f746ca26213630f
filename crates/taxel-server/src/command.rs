//! What a viewer may ask for.

use serde::Deserialize;

/// One request, `do` in its JSON.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(tag = "do", rename_all = "kebab-case", deny_unknown_fields)]
#[non_exhaustive]
pub enum Command {
    /// Take the present loads for nothing.
    Tare {
        /// Though there is load on the sensor.
        #[serde(default)]
        force: bool,
    },
    /// Forget that.
    Untare,
    /// Begin a recording.
    Record {
        /// Its name, without a folder.
        #[serde(default)]
        name: Option<String>,
    },
    /// End the recording.
    Stop,
    /// Note something that happens now.
    Event {
        /// What.
        text: String,
    },
    /// Find loads another way.
    Method {
        /// Its name.
        name: String,
    },
    /// Turn a knob of the simulated source.
    Slider {
        /// Which.
        key: String,
        /// To where.
        value: f64,
    },
    /// Go on with the file.
    Play,
    /// Hold the file.
    Pause,
    /// Go to a place in the file.
    Seek {
        /// Seconds from its beginning.
        secs: f64,
    },
    /// Play the file faster or slower.
    Speed {
        /// 1: as recorded.
        factor: f64,
    },
    /// Go on with the grip session.
    Grip {
        /// How.
        step: GripStep,
    },
    /// Go on with the guided calibration.
    Calibrate {
        /// How.
        step: CalibrationStep,
    },
}

/// What the operator of a guided calibration does, `is` in its JSON.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(tag = "is", rename_all = "kebab-case", deny_unknown_fields)]
#[non_exhaustive]
pub enum CalibrationStep {
    /// What was to be done is done: all is taken off, or other things lie on the sensor.
    Ready,
    /// What presses now stands on the taxel where it is seen: take it there.
    Here,
    /// Take another taxel, load or kind of press instead of the one that is asked for.
    Skip,
    /// Press with another of the loads that there are.
    Load {
        /// Which, grams.
        load_g: f64,
    },
    /// The last press was none: forget it, and ask again.
    Undo,
    /// End with the presses that there are.
    Finish,
}

/// What the operator of a grip session does, `is` in its JSON.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(tag = "is", rename_all = "kebab-case", deny_unknown_fields)]
#[non_exhaustive]
pub enum GripStep {
    /// Begin the session of a person.
    Begin {
        /// A pseudonymous id.
        person: String,
        /// What is to be remembered of the session.
        #[serde(default)]
        note: String,
    },
    /// Nothing presses: take this for zero.
    Zero {
        /// Though there is load on the sensor.
        #[serde(default)]
        force: bool,
    },
    /// Start the trial.
    Start,
    /// End the countdown or the grip before its time; the trial is not kept as one.
    Cancel,
    /// The trial counts.
    Accept,
    /// The trial does not count.
    Repeat {
        /// Why.
        reason: String,
    },
    /// The person has rested enough.
    SkipRest,
    /// End the session with the trials that there are.
    Finish,
}

/// Everything that a viewer may send.
#[derive(Debug, Deserialize)]
pub(crate) struct Envelope {
    #[serde(default)]
    pub id: u64,
    #[serde(rename = "do")]
    pub verb: String,
}

/// What concerns the viewer's own connection.
#[derive(Debug, PartialEq, Deserialize)]
#[serde(tag = "do", rename_all = "kebab-case")]
pub(crate) enum Own {
    /// A frame has arrived.
    Got,
    /// The most frames a second it wants.
    Rate { frames_per_second: f64 },
    /// What it wants details of.
    Watch(Watched),
}

/// What a viewer wants to know more of than frames tell.
#[derive(Debug, Clone, PartialEq, Eq, Default, Deserialize)]
#[non_exhaustive]
pub struct Watched {
    /// Taxels: row, column.
    pub taxels: Vec<(usize, usize)>,
    /// What the frame's figures are uncertain by. A viewer that does not ask is told nothing that it may not know.
    #[serde(default)]
    pub figures: bool,
}

impl Watched {
    /// Whether there is anything to tell.
    pub(crate) fn is_any(&self) -> bool {
        self.figures || !self.taxels.is_empty()
    }
}

/// A message, taken apart.
#[derive(Debug, PartialEq)]
pub(crate) enum Message {
    Own(Own),
    Command(u64, Command),
}

/// The most taxels that a viewer watches.
const MAX_WATCHED: usize = 16;

/// Reads a viewer's message; on failure the id it had, and why.
pub(crate) fn parse(text: &str) -> Result<Message, (u64, String)> {
    let envelope: Envelope =
        serde_json::from_str(text).map_err(|error| (0, format!("no request: {error}")))?;
    let id = envelope.id;
    let failed = |error: serde_json::Error| (id, format!("{}: {error}", envelope.verb));
    if ["got", "rate", "watch"].contains(&envelope.verb.as_str()) {
        let own: Own = serde_json::from_str(text).map_err(failed)?;
        let too_many = matches!(&own, Own::Watch(watched) if watched.taxels.len() > MAX_WATCHED);
        if too_many {
            return Err((id, format!("at most {MAX_WATCHED} taxels can be watched")));
        }
        return Ok(Message::Own(own));
    }
    let mut value: serde_json::Value = serde_json::from_str(text).map_err(failed)?;
    if let Some(fields) = value.as_object_mut() {
        fields.remove("id");
    }
    let command = serde_json::from_value(value).map_err(failed)?;
    Ok(Message::Command(id, command))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn requests_are_read_and_what_is_wrong_is_said() {
        assert_eq!(
            parse(r#"{"id":3,"do":"tare"}"#),
            Ok(Message::Command(3, Command::Tare { force: false }))
        );
        assert_eq!(
            parse(r#"{"do":"got","sequence":9}"#),
            Ok(Message::Own(Own::Got))
        );
        let watch = |taxels, figures| Ok(Message::Own(Own::Watch(Watched { taxels, figures })));
        assert_eq!(
            parse(r#"{"do":"watch","taxels":[[1,2]]}"#),
            watch(vec![(1, 2)], false)
        );
        assert_eq!(
            parse(r#"{"do":"watch","taxels":[],"figures":true}"#),
            watch(Vec::new(), true)
        );
        let seek = parse(r#"{"id":1,"do":"seek","secs":2.5}"#);
        assert_eq!(seek, Ok(Message::Command(1, Command::Seek { secs: 2.5 })));
        for (text, id, says) in [
            ("tare", 0, "no request"),
            (r#"{"id":4,"do":"explode"}"#, 4, "unknown variant"),
            (r#"{"id":5,"do":"seek"}"#, 5, "missing field"),
            (r#"{"id":6,"do":"seek","secs":"x"}"#, 6, "invalid type"),
            (
                r#"{"id":7,"do":"seek","secs":1,"path":"/"}"#,
                7,
                "unknown field",
            ),
        ] {
            let (found, why) = parse(text).unwrap_err();
            assert_eq!(found, id);
            assert!(why.contains(says), "{text}: {why}");
        }
        let many = format!(r#"{{"id":8,"do":"watch","taxels":{:?}}}"#, vec![[1, 2]; 17]);
        assert!(parse(&many).is_err());
    }
}
