//! Before any work: whether what is to be written can be, and would destroy nothing that is read or written.

use std::fs;
use std::path::{Component, Path, PathBuf};

use crate::error::Error;
use crate::{out, patience};
use taxel_app::named_files;
use taxel_io::atomic::is_device;
use taxel_io::exports::file_of;

/// The files of a command, each with what the user calls it.
#[derive(Debug, Default)]
pub(crate) struct Files<'a> {
    inputs: Vec<Input<'a>>,
    outputs: Vec<(&'static str, &'a Path)>,
}

/// A file that is read.
#[derive(Debug)]
struct Input<'a> {
    name: &'static str,
    file: &'a Path,
    /// How to find the files that it names and that are read with it.
    names: Option<fn(&Path) -> Vec<PathBuf>>,
}

impl<'a> Files<'a> {
    /// A file that is read.
    pub(crate) fn input(self, name: &'static str, file: &'a Path) -> Self {
        self.with(name, file, None)
    }

    fn with(
        mut self,
        name: &'static str,
        file: &'a Path,
        names: Option<fn(&Path) -> Vec<PathBuf>>,
    ) -> Self {
        self.inputs.push(Input { name, file, names });
        self
    }

    /// A sensor file, or a preset; the files of per-taxel numbers that it names are read with it.
    pub(crate) fn sensor(self, file: &'a Path) -> Self {
        self.with("sensor", file, Some(named_files::of_sensor))
    }

    /// A sensor file that may be read.
    pub(crate) fn maybe_sensor(self, file: Option<&'a PathBuf>) -> Self {
        match file {
            Some(file) => self.sensor(file),
            None => self,
        }
    }

    /// A table that may be read, and the recordings that it names.
    pub(crate) fn maybe_table(self, name: &'static str, file: Option<&'a PathBuf>) -> Self {
        match file {
            Some(file) => self.with(name, file, Some(named_files::of_table)),
            None => self,
        }
    }

    /// The plan of an evaluation that may be read, and everything that it names.
    pub(crate) fn maybe_plan(self, file: Option<&'a PathBuf>) -> Self {
        match file {
            Some(file) => self.with("plan", file, Some(named_files::of_plan)),
            None => self,
        }
    }

    /// A file that may be read.
    pub(crate) fn maybe_input(self, name: &'static str, file: Option<&'a PathBuf>) -> Self {
        match file {
            Some(file) => self.input(name, file),
            None => self,
        }
    }

    /// A file that is written.
    pub(crate) fn output(mut self, name: &'static str, file: &'a Path) -> Self {
        self.outputs.push((name, file));
        self
    }

    /// A file that may be written.
    pub(crate) fn maybe_output(self, name: &'static str, file: Option<&'a PathBuf>) -> Self {
        match file {
            Some(file) => self.output(name, file),
            None => self,
        }
    }

    /// Refuses an output that is an input, a file that an input names, or another output, under whatever name.
    pub(crate) fn check(&self) -> Result<(), Error> {
        for (place, (option, file)) in self.outputs.iter().enumerate() {
            let Some(identity) = Identity::of(file) else {
                continue;
            };
            let replaced = |what: String| Error::Arguments {
                what: format!(
                    "{option} {} would replace what is read: it is {what}",
                    file.display()
                ),
                hint: "write to another name",
            };
            if let Some(input) = self
                .inputs
                .iter()
                .find(|input| identity.is(&file_of(input.file)))
            {
                return Err(replaced(format!("the {}", input.name)));
            }
            let before = self.outputs[..place].iter();
            if let Some((other, name)) = before.clone().find(|(_, output)| identity.is(output)) {
                return Err(Error::Arguments {
                    what: format!(
                        "{other} {} and {option} {} are one file, and the second would replace the first",
                        name.display(),
                        file.display()
                    ),
                    hint: "write to two names",
                });
            }
        }
        self.check_named()
    }

    /// Refuses an output that an input names; pipes among what inputs name are watched from here on.
    fn check_named(&self) -> Result<(), Error> {
        let outputs = self.outputs.iter().filter(|(_, file)| file.is_file());
        let there: Vec<_> = outputs
            .filter_map(|(option, file)| Some((option, file, Identity::of(file)?)))
            .collect();
        for input in &self.inputs {
            let Some(names) = input.names else { continue };
            let names = names(input.file);
            patience::watch_named(&names);
            for named in names {
                let found = there.iter().find(|(.., identity)| identity.is(&named));
                if let Some((option, file, _)) = found {
                    return Err(Error::Arguments {
                        what: format!(
                            "{option} {} would replace what is read: the {} {} names it ({})",
                            file.display(),
                            input.name,
                            input.file.display(),
                            named.display()
                        ),
                        hint: "write to another name",
                    });
                }
            }
        }
        Ok(())
    }
}

/// Which file a name means, whether it is there or not.
struct Identity {
    path: PathBuf,
    #[cfg(unix)]
    inode: Option<(u64, u64)>,
}

impl Identity {
    /// `None` for what is no file: standard output, pipes, devices.
    fn of(file: &Path) -> Option<Self> {
        if out::is_stdout(file) || is_device(file) {
            return None;
        }
        let about = fs::metadata(file).ok();
        if about.as_ref().is_some_and(|about| !about.is_file()) {
            return None;
        }
        Some(Self {
            path: normal(file),
            #[cfg(unix)]
            inode: about.map(|about| {
                use std::os::unix::fs::MetadataExt;
                (about.dev(), about.ino())
            }),
        })
    }

    fn is(&self, other: &Path) -> bool {
        let Some(other) = Self::of(other) else {
            return false;
        };
        #[cfg(unix)]
        if self.inode.is_some() && self.inode == other.inode {
            return true;
        }
        self.path == other.path
    }
}

/// The name from the root on, links followed as far as there is something to follow.
fn normal(file: &Path) -> PathBuf {
    if let Ok(whole) = fs::canonicalize(file) {
        return whole;
    }
    let absolute = std::path::absolute(file).unwrap_or_else(|_| file.to_owned());
    let folder = absolute.parent().map(fs::canonicalize);
    if let (Some(Ok(folder)), Some(name)) = (folder, absolute.file_name()) {
        return folder.join(name);
    }
    let mut path = PathBuf::new();
    for part in absolute.components() {
        match part {
            Component::ParentDir => {
                path.pop();
            }
            Component::CurDir => {}
            part => path.push(part),
        }
    }
    path
}

/// Refuses a name whose ending says another format than those that can be written; devices and pipes have none.
pub(crate) fn check_ending(
    option: &str,
    file: &Path,
    endings: &[&str],
    hint: &'static str,
) -> Result<(), Error> {
    let is_file = match fs::metadata(file) {
        Ok(about) => about.is_file(),
        Err(_) => true,
    };
    if out::is_stdout(file) || is_device(file) || !is_file {
        return Ok(());
    }
    let ending = file.extension().unwrap_or_default().to_string_lossy();
    if endings.contains(&ending.to_ascii_lowercase().as_str()) {
        return Ok(());
    }
    let known: Vec<String> = endings.iter().map(|ending| format!(".{ending}")).collect();
    Err(Error::Arguments {
        what: format!(
            "{option} {} ends in `{}`, expected one of {}",
            file.display(),
            match ending.as_ref() {
                "" => String::new(),
                ending => format!(".{ending}"),
            },
            known.join(", ")
        ),
        hint,
    })
}

/// Refuses a name that is no sensor file's.
pub(crate) fn check_sensor_ending(option: &str, file: &Path) -> Result<(), Error> {
    check_ending(option, file, &["toml"], "a sensor file is TOML")
}

/// Refuses a name that is no model's.
pub(crate) fn check_model_ending(option: &str, file: &Path) -> Result<(), Error> {
    let hint = "a model is kept as safetensors; `taxel model export` writes ONNX";
    check_ending(option, file, &["safetensors"], hint)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_file_under_two_names_is_one_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        fs::write(path("a"), "1").unwrap();
        fs::hard_link(path("a"), path("b")).unwrap();
        fs::create_dir(path("c")).unwrap();
        let same = [
            ("a", "a"),
            ("a", "b"),
            ("a", "c/../a"),
            ("new", "c/../new"),
            ("new", "./new"),
            ("no/such", "no/x/../such"),
        ];
        for (one, two) in same {
            let (one, two) = (path(one), path(two));
            let files = Files::default().output("-o", &one);
            assert!(files.output("--marks", &two).check().is_err(), "{one:?}");
            let files = Files::default().input("recording", &one);
            assert!(files.output("-o", &two).check().is_err(), "{one:?}");
        }
        let (one, two) = (path("new"), path("c"));
        let files = Files::default().input("recording", &two);
        assert!(files.output("-o", &one).check().is_ok());
        let standard = Path::new("-");
        let files = Files::default().output("-o", standard);
        assert!(files.output("--marks", standard).check().is_ok());
    }

    #[test]
    fn endings_that_cannot_be_written_are_refused() {
        let check = |name: &str| check_ending("-o", Path::new(name), &["csv", "npy"], "x");
        for good in ["a.csv", "a.NPY", "-", "/dev/null"] {
            assert!(check(good).is_ok(), "{good}");
        }
        for bad in ["a.mcap", "a", "csv", "a.csv.gz"] {
            assert!(check(bad).is_err(), "{bad}");
        }
    }
}
