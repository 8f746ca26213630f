//! Why a device file cannot be opened, and what would help.

use std::io;
use std::path::Path;

/// What to do about a device that the system refuses to open; nothing where it says enough itself.
pub(crate) fn remedy(device: &Path, error: &io::Error) -> Option<String> {
    let name = device.to_string_lossy();
    match error.kind() {
        io::ErrorKind::PermissionDenied => Some(how_to_join(&name, group(device))),
        io::ErrorKind::NotFound if name.starts_with("/dev/spidev") => {
            Some("SPI is off: `sudo raspi-config nonint do_spi 0` turns it on".to_owned())
        }
        io::ErrorKind::NotFound if name.starts_with("/dev/gpiochip") => Some(
            "`ls /dev/gpiochip*` lists what there is; `gpio = …` in the board's file names another"
                .to_owned(),
        ),
        _ => None,
    }
}

/// The error with the remedy, in one line.
pub(crate) fn with_remedy(device: &Path, error: &io::Error) -> String {
    match remedy(device, error) {
        Some(remedy) => format!("{error}; {remedy}"),
        None => error.to_string(),
    }
}

/// What gives a user the right to a device of this group.
fn how_to_join(name: &str, group: Option<String>) -> String {
    match group {
        Some(group) if group != "root" => format!(
            "it is for members of the group {group}: `sudo usermod -aG {group} $USER`, then log in again"
        ),
        _ => format!(
            "it is for root alone; where it belongs to the group {group}, members of that may: `sudo chgrp {group} {name}`, `sudo chmod g+rw {name}`, and a rule of udev to keep it so",
            group = usual_group(name)
        ),
    }
}

/// The group whose members may open such devices on Debian and what stands on it.
fn usual_group(name: &str) -> &'static str {
    if name.starts_with("/dev/gpiochip") {
        "gpio"
    } else if name.starts_with("/dev/spidev") {
        "spi"
    } else {
        "dialout"
    }
}

/// The name of the group that a file belongs to.
#[cfg(unix)]
fn group(file: &Path) -> Option<String> {
    use std::os::unix::fs::MetadataExt;

    let gid = std::fs::metadata(file).ok()?.gid();
    let groups = std::fs::read_to_string("/etc/group").ok()?;
    // As `ls` writes a group that has no name.
    Some(name_of(gid, &groups).unwrap_or_else(|| gid.to_string()))
}

/// The name that lines of `name:x:gid:members` give a group.
#[cfg(unix)]
fn name_of(gid: u32, groups: &str) -> Option<String> {
    groups.lines().find_map(|line| {
        let mut fields = line.split(':');
        let name = fields.next()?;
        (fields.nth(1)?.parse() == Ok(gid)).then(|| name.to_owned())
    })
}

/// There are no such groups.
#[cfg(not(unix))]
fn group(_: &Path) -> Option<String> {
    None
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn the_group_to_join_is_named() {
        let groups = "root:x:0:\ndialout:x:20:pi\ngpio:x:997:pi,taxel\n";
        assert_eq!(name_of(7, groups), None);
        let words = how_to_join("/dev/gpiochip0", name_of(997, groups));
        assert!(words.contains("sudo usermod -aG gpio $USER"), "{words}");
        let words = how_to_join("/dev/ttyS0", name_of(0, groups));
        assert!(words.contains("sudo chgrp dialout /dev/ttyS0"), "{words}");
        let denied = io::Error::from(io::ErrorKind::PermissionDenied);
        let words = with_remedy(Path::new("/dev/null"), &denied);
        assert!(
            words.starts_with("permission denied; it is for "),
            "{words}"
        );
    }

    #[test]
    fn spi_that_is_off_is_named() {
        let absent = io::Error::from(io::ErrorKind::NotFound);
        let words = with_remedy(Path::new("/dev/spidev0.0"), &absent);
        assert!(words.contains("raspi-config nonint do_spi 0"), "{words}");
        assert_eq!(remedy(Path::new("/dev/ttyACM7"), &absent), None);
    }
}
