//! What is written and what is not: names that would destroy something, endings that say another format, temporaries.

use std::process::{Child, Command, Stdio};
use std::time::Duration;

use crate::run::Folder;

/// Frames and a table to work with.
fn prepared() -> Folder {
    let folder = Folder::new();
    folder.good(
        "simulate --sensor sensor.toml --pattern press --frames 30 --presses presses.csv -o run.txt --truth truth.csv",
    );
    folder
}

#[test]
fn nothing_that_is_read_or_written_is_replaced() {
    let folder = prepared();
    let before: Vec<String> = ["run.txt", "sensor.toml", "presses.csv", "truth.csv"]
        .map(|name| folder.read(name))
        .to_vec();
    let (names, sensor) = (folder.names(), "--sensor sensor.toml");
    for words in [
        format!("compensate run.txt {sensor} -o ./run.txt"),
        format!("compensate run.txt {sensor} -o q.csv --marks run.txt"),
        format!("compensate run.txt {sensor} -o q.csv --marks q.csv"),
        format!("compensate run.txt {sensor} -o q.csv --marks m.csv --standard-error m.csv"),
        // The marks' own name, beside the numbers.
        format!("compensate run.txt {sensor} -o q.csv --standard-error q.marks.csv"),
        format!("simulate {sensor} --pattern hand -o d.txt --truth d.txt"),
        format!("simulate {sensor} --pattern hand -o d.txt --truth-sensor sensor.toml"),
        format!("simulate {sensor} --conductance truth.csv -o truth.csv"),
        format!("convert run.txt {sensor} -o run.txt"),
        format!("calibrate {sensor} --presses presses.csv -o sensor.toml"),
        format!("calibrate {sensor} --presses presses.csv -o presses.csv"),
        format!("dataset {sensor} --presses presses.csv -o presses.csv"),
        format!("train row-set {sensor} --presses presses.csv -o presses.csv"),
        format!("compare run.txt --truth truth.csv {sensor} --presses presses.csv -o truth.csv"),
        format!("compare {sensor} --presses presses.csv -o a.csv --figure a.csv"),
        format!("netlist run.txt {sensor} -o run.txt"),
    ] {
        let run = folder.taxel(&words);
        assert_eq!(run.code, Some(2), "{words}: {run}");
        let told = ["would replace", "are one file"];
        assert!(told.iter().any(|told| run.err.contains(told)), "{run}");
    }
    folder.good("convert run.txt --sensor sensor.toml -o run.mcap");
    let recording = std::fs::read(folder.path("run.mcap")).unwrap();
    for words in [
        "convert run.mcap -o run.mcap",
        "recover run.mcap -o ./run.mcap",
    ] {
        assert_eq!(folder.taxel(words).code, Some(2), "{words}");
    }
    assert_eq!(std::fs::read(folder.path("run.mcap")).unwrap(), recording);
    std::fs::remove_file(folder.path("run.mcap")).unwrap();
    let after =
        ["run.txt", "sensor.toml", "presses.csv", "truth.csv"].map(|name| folder.read(name));
    assert_eq!(after.to_vec(), before);
    assert_eq!(folder.names(), names);
}

/// Another name of a file that is there.
fn link(folder: &Folder, from: &str, to: &str) {
    std::fs::hard_link(folder.path(from), folder.path(to)).unwrap();
}

#[test]
#[expect(clippy::too_many_lines, reason = "a table of cases")]
fn nothing_that_an_input_names_is_replaced() {
    let folder = prepared();
    folder.write("gain.csv", &"1,1,1,1,1,1\n".repeat(4));
    let text = format!("{}gain = \"gain.csv\"\n", crate::run::SENSOR);
    folder.write("uneven.toml", &text);
    folder.write("even.csv", "recording,frame,load_g\nrun.txt,0,5\n");
    folder.write("trials.csv", "recording,row,column\nrun.txt,1,2\n");
    folder.write(
        "plan.toml",
        "format = 1\nsensor = \"uneven.toml\"\n[[experiment]]\nkind = \"repeatability\"\nname = \"a\"\ntrials = \"trials.csv\"\n",
    );
    for (from, to) in [
        ("run.txt", "run.csv"),
        ("run.txt", "run.toml"),
        ("run.txt", "run.html"),
        ("run.txt", "run.safetensors.checkpoint"),
        ("gain.csv", "gain.html"),
        ("trials.csv", "trials.html"),
        ("run.txt", "run.png"),
    ] {
        link(&folder, from, to);
    }
    let names = folder.names();
    let all = || {
        names
            .iter()
            .map(|name| folder.read(name))
            .collect::<Vec<_>>()
    };
    let before = all();
    let (uneven, presses) = ("--sensor uneven.toml", "--presses presses.csv");
    for (words, named) in [
        (
            format!("compensate run.txt {uneven} -o gain.csv"),
            "gain.csv",
        ),
        (
            format!("compensate run.txt {uneven} -o a.csv --standard-error gain.csv"),
            "gain.csv",
        ),
        (
            format!("calibrate {uneven} {presses} -o run.toml"),
            "run.txt",
        ),
        (
            format!("calibrate {uneven} {presses} --equilibration even.csv -o run.toml"),
            "run.txt",
        ),
        (format!("dataset {uneven} {presses} -o run.csv"), "run.txt"),
        (
            format!("train paper-mlp {uneven} {presses} -o run.safetensors"),
            "run.txt",
        ),
        (
            format!("compare {uneven} {presses} -o a.csv --figure run.png"),
            "run.txt",
        ),
        ("evaluate plan.toml -o run.html".to_owned(), "run.txt"),
        ("report plan.toml -o gain.html".to_owned(), "gain.csv"),
        ("report plan.toml -o trials.html".to_owned(), "trials.csv"),
    ] {
        let run = folder.taxel(&words);
        assert_eq!(run.code, Some(2), "{words}: {run}");
        let told = format!("names it ({named})");
        assert!(
            run.err.contains("would replace") && run.err.contains(&told),
            "{words}: {run}"
        );
    }
    assert_eq!(folder.names(), names);
    assert_eq!(all(), before);
    // A file that is there and that nothing names is replaced as ever.
    folder.write("old.csv", "x");
    folder.good(&format!("compensate run.txt {uneven} -o old.csv"));
}

#[test]
fn an_ending_that_cannot_be_written_is_refused_before_any_work() {
    let folder = prepared();
    let names = folder.names();
    for words in [
        "simulate --sensor sensor.toml --pattern hand -o a.parquet",
        "simulate --sensor sensor.toml --pattern hand -o a.xlsx",
        "simulate --sensor sensor.toml --pattern hand -o a",
        "simulate --sensor sensor.toml --pattern hand --unit volts -o a.mcap",
        "simulate --sensor sensor.toml --pattern hand -o a.csv --truth a.mcap",
        "compensate run.txt --sensor sensor.toml -o a.xlsx",
        "compensate run.txt --sensor sensor.toml -o a.csv --marks a.parquet",
        "compensate run.txt --sensor sensor.toml -o a.csv --marks a.toml",
        "convert run.txt --sensor sensor.toml -o a.xlsx",
        "record sim:sensor.toml?hand -o a.txt --frames 3",
        "analyse run.txt --sensor sensor.toml --taxel 0,0 --export a.json",
        "recover run.txt -o a.txt",
        "calibrate --sensor sensor.toml --presses presses.csv -o a.csv",
        "calibrate --sensor sensor.toml --series run.txt --loads truth.csv -o a.toml --static-output a.csv",
        "train row-set --sensor sensor.toml --presses presses.csv -o a.onnx",
        "model import no.onnx --sensor sensor.toml --presses presses.csv -o a.json",
        "model export no.safetensors -o a.json",
        "dataset --sensor sensor.toml --presses presses.csv -o a.parquet",
        "dataset --sensor sensor.toml --presses presses.csv -o a",
        "compare --sensor sensor.toml --presses presses.csv -o a.xlsx",
        "design -o a.txt",
        "live sim:sensor.toml --record a.txt",
        "simulate --sensor sensor.toml --pattern press -o b.txt --presses a.toml",
        "simulate --sensor sensor.toml --pattern hand -o b.txt --truth-sensor a.csv",
    ] {
        let run = folder.taxel(words);
        assert_eq!(run.code, Some(2), "{words}: {run}");
        assert!(run.err.contains("expected one of"), "{run}");
    }
    // Pictures have words of their own.
    for words in [
        "compare --sensor sensor.toml --presses presses.csv --figure a.gif",
        "plot run.txt --sensor sensor.toml -o a.jpg",
        "crosstalk -o a.txt",
    ] {
        let run = folder.taxel(words);
        assert_eq!(run.code, Some(2), "{words}: {run}");
        assert!(run.err.contains("png, svg"), "{run}");
    }
    assert_eq!(folder.names(), names);
}

#[test]
fn a_simulated_recording_is_one_and_the_same_for_a_seed() {
    let folder = Folder::new();
    for name in ["a.mcap", "b.mcap", "c.txt"] {
        folder.good(&format!(
            "simulate --sensor sensor.toml --pattern hand --frames 20 --seed 3 -o {name}"
        ));
    }
    let bytes = |name: &str| std::fs::read(folder.path(name)).unwrap();
    assert!(bytes("a.mcap") == bytes("b.mcap"));
    folder.good("convert a.mcap -o a.txt");
    assert_eq!(folder.numbers("a.txt"), folder.numbers("c.txt"));
    let info = folder.good("info a.mcap");
    assert!(
        info.out.contains("20 frames of 4 rows x 6 columns"),
        "{info}"
    );
    // A second one goes elsewhere.
    let again = folder.fails("simulate --sensor sensor.toml --pattern hand -o a.mcap");
    assert!(again.err.contains("a.mcap already exists"), "{again}");
}

/// Sends a signal to a command once what it is to have begun is there; its exit code.
#[cfg(unix)]
fn signalled(
    folder: &Folder,
    words: &str,
    signal: &str,
    is_there: impl Fn(&Child) -> bool,
) -> Option<i32> {
    let mut child = Command::new(env!("CARGO_BIN_EXE_taxel"))
        .args(words.split_whitespace())
        .current_dir(folder.path(""))
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    while !is_there(&child) {
        assert!(child.try_wait().unwrap().is_none(), "{words} has ended");
        std::thread::sleep(Duration::from_millis(5));
    }
    let sent = Command::new("kill")
        .args([signal, &child.id().to_string()])
        .status()
        .unwrap();
    assert!(sent.success());
    child.wait().unwrap().code()
}

#[cfg(unix)]
#[test]
fn a_signal_leaves_no_temporary_file_and_no_part() {
    let folder = Folder::new();
    let names = folder.names();
    for signal in ["-INT", "-TERM", "-HUP"] {
        let words = "simulate --sensor sensor.toml --pattern hand --frames 100000000 -o a.csv";
        let code = signalled(&folder, words, signal, |child| folder.is_written_by(child));
        assert_eq!(code, Some(130), "{signal}");
        assert_eq!(folder.names(), names, "{signal}");
    }
}

#[cfg(unix)]
#[test]
fn a_signal_ends_a_recording_as_ctrl_c_does() {
    let folder = Folder::new();
    for (turn, signal) in ["-TERM", "-HUP"].into_iter().enumerate() {
        let name = format!("{turn}.mcap");
        let words = format!("record sim:sensor.toml?hand -o {name}");
        let is_there =
            |_: &Child| std::fs::metadata(folder.path(&name)).is_ok_and(|about| about.len() > 4000);
        let code = signalled(&folder, &words, signal, is_there);
        // 3 where the machine was too busy to record every frame.
        assert!(matches!(code, Some(0 | 3)), "{signal}: {code:?}");
        // It has its end.
        let run = folder.taxel(&format!("convert {name} -o {turn}.txt"));
        assert!(matches!(run.code, Some(0 | 3)), "{run}");
    }
}

/// However a program ends: what it had begun is not there.
#[cfg(target_os = "linux")]
#[test]
fn a_killed_program_leaves_no_temporary_file_and_no_part() {
    let folder = Folder::new();
    let names = folder.names();
    for words in [
        "simulate --sensor sensor.toml --pattern hand --frames 100000000 -o a.csv",
        "simulate --sensor sensor.toml --pattern hand --frames 100000000 -o a.mcap",
        // No frame comes.
        "record tcp:127.0.0.1:1 --sensor sensor.toml -o a.mcap",
    ] {
        let code = signalled(&folder, words, "-KILL", |child| folder.is_written_by(child));
        assert_eq!(code, None, "{words}");
        assert_eq!(folder.names(), names, "{words}");
    }
    // Nothing stands in the way of the next.
    folder.good("record sim:sensor.toml?uniform -o a.mcap --frames 3");
    // Whose first frame is there as soon as its name is.
    let words = "record sim:sensor.toml?uniform&fps=20 -o b.mcap";
    let code = signalled(&folder, words, "-KILL", |_| folder.exists("b.mcap"));
    assert_eq!(code, None);
    let saved = folder.taxel("recover b.mcap -o c.mcap");
    assert_eq!(saved.code, Some(3), "{saved}");
    folder.good("info c.mcap");
}
