//! `taxel completions`: a shell that has read the script completes what is typed.

use std::process::Command;

use crate::run::Folder;

/// What bash offers for the last of these words, the script read before.
fn offered(folder: &Folder, words: &[&str]) -> Option<Vec<String>> {
    let typed = words.join(" ");
    let last = words.len() - 1;
    let before = &words[last - 1];
    let current = words[last];
    let line = format!(
        "source taxel.bash; COMP_WORDS=({typed} {}); COMP_CWORD={last}; \
         _taxel taxel '{current}' '{before}'; printf '%s\\n' \"${{COMPREPLY[@]}}\"",
        if current.is_empty() { "''" } else { "" },
    );
    let run = Command::new("bash")
        .args(["--norc", "-c", &line])
        .current_dir(folder.path(""))
        .output();
    // A machine without bash has nothing to complete.
    let output = run.ok()?;
    assert!(output.status.success(), "{output:?}");
    assert!(output.stderr.is_empty(), "{output:?}");
    let text = String::from_utf8(output.stdout).unwrap();
    Some(text.lines().map(str::to_owned).collect())
}

#[test]
fn bash_completes_verbs_options_and_the_words_of_an_option() {
    let folder = Folder::new();
    folder.write("taxel.bash", &folder.good("completions bash").out);
    let Some(verbs) = offered(&folder, &["taxel", "cal"]) else {
        return;
    };
    assert_eq!(verbs, ["calibrate"]);
    let options = offered(&folder, &["taxel", "plot", "--before"]).unwrap();
    assert_eq!(options, ["--before-after"]);
    let words = offered(&folder, &["taxel", "plot", "--interpolation", ""]).unwrap();
    assert_eq!(words, ["bilinear", "nearest"]);
    let nothing = offered(&folder, &["taxel", "calx"]).unwrap();
    assert_eq!(nothing.concat(), "");
}

#[test]
fn every_shell_has_a_script_of_its_own_with_every_verb() {
    let folder = Folder::new();
    for (shell, own) in [
        ("bash", "complete -F _taxel"),
        ("zsh", "#compdef taxel"),
        ("fish", "complete -c taxel"),
    ] {
        let script = folder.good(&format!("completions {shell}"));
        assert!(script.out.contains(own), "{shell}: {script}");
        assert!(script.err.is_empty(), "{script}");
        for verb in ["calibrate", "compensate", "plot", "completions"] {
            assert!(script.out.contains(verb), "{shell} has no {verb}");
        }
    }
}

#[test]
fn a_shell_that_is_not_known_is_a_bad_argument() {
    let run = Folder::new().taxel("completions csh");
    assert_eq!(run.code, Some(2), "{run}");
    assert!(run.err.contains("bash, zsh, fish"), "{run}");
}
