//! The remains of a session that is killed, or whose disk is full.

use std::io::{BufRead, BufReader, Read, Write};
use std::process::{Child, Command, Stdio};

use crate::support::{Random, Sandbox};

fn start(sandbox: &Sandbox, program: &[&str]) -> Child {
    Command::new(program[0])
        .args(&program[1..])
        .current_dir(sandbox.path(""))
        .envs(sandbox.user())
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

const SUPEREGG: &str = env!("CARGO_BIN_EXE_superegg");

/// Lines of all kinds that change a scene, undo and loads among them.
fn change(i: u64) -> String {
    match i % 9 {
        0 => format!("primitive p{i}"),
        1 => format!("setCoeff {} 1 2", i + 1),
        2 => format!("object o{i}"),
        3 => format!("addPrimitive p{}", i - 3),
        4 => format!("translate {i} 0 0"),
        5 => "undo 2".to_owned(),
        6 => "redo".to_owned(),
        7 if i.is_multiple_of(4) => "load part.scn".to_owned(),
        _ => format!("light l{i} 1 2 3"),
    }
}

/// The scene after so many of those lines.
fn scene_after(sandbox: &Sandbox, count: u64) -> String {
    let lines: String = (0..count).map(|i| change(i) + "\n").collect();
    saved_scene(&sandbox.run_with("", &(lines + "save -\n")).out)
}

/// The scene that `save -` wrote among other output.
fn saved_scene(out: &str) -> String {
    out.find("# superegg scene").map_or("", |at| &out[at..]).to_owned()
}

#[test]
fn a_kill_at_any_moment_loses_no_line_that_was_answered() {
    let sandbox = Sandbox::new();
    sandbox.write("part.scn", "prm part\nobj whole\nap part\n");
    let mut random = Random(2015);
    let mut found = 0;
    for round in 0..40 {
        let mut child = start(&sandbox, &[SUPEREGG]);
        let mut input = child.stdin.take().unwrap();
        let mut output = BufReader::new(child.stdout.take().unwrap());
        // It is killed as soon as so many lines are answered, with a few more on their way.
        let awaited = random.below(60);
        let count = awaited + 1 + random.below(5);
        // Each line is followed by one that is answered, so that it is known how many were taken.
        let writing = std::thread::spawn(move || {
            for i in 0..count {
                // The other end may be dead already.
                if input.write_all(format!("{}\nget samples\n", change(i)).as_bytes()).is_err() {
                    break;
                }
            }
            // Held open: at the end of its input a session ends well.
            input
        });
        let mut answered = 0;
        let mut line = String::new();
        while answered < awaited {
            line.clear();
            assert_ne!(output.read_line(&mut line).unwrap(), 0);
            answered += u64::from(line.starts_with("samples"));
        }
        child.kill().unwrap();
        child.wait().unwrap();
        drop(writing.join().unwrap());
        let mut rest = String::new();
        output.read_to_string(&mut rest).unwrap();
        answered += rest.lines().filter(|line| line.starts_with("samples")).count() as u64;

        let recovered = sandbox.run_with("", "recover\nsave -\n");
        // A session of a pipe keeps the journal that it recovers.
        let _ = std::fs::remove_dir_all(sandbox.own("state/superegg/journals"));
        let scene = saved_scene(&recovered.out);
        let after: Vec<u64> =
            (answered..=count).filter(|&taken| scene_after(&sandbox, taken) == scene).collect();
        // Just after a load all is on disk; before the first line there is nothing.
        let nothing_to_lose = |taken: u64| taken == 0 || change(taken - 1).starts_with("load");
        if recovered.err.contains("no session to recover") && (answered..=count).any(nothing_to_lose) {
            continue;
        }
        found += 1;
        assert!(
            !after.is_empty(),
            "round {round}: {answered} of {count} answered, recovered:\n{}\n{}",
            recovered.out,
            recovered.err
        );
    }
    assert!(found > 20, "{found}: most rounds should leave something to recover");
}

#[test]
fn a_session_that_ends_well_leaves_nothing_behind() {
    let sandbox = Sandbox::new();
    sandbox.run_with("", "prm ball\n").fine();
    assert!(sandbox.run_with("", "recover\n").err.contains("there is no session to recover"));
}

/// A shell line that runs the program with its folders on a file system of 64 KiB, if this machine
/// lets us make one.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_reported_and_loses_nothing() {
    let sandbox = Sandbox::new();
    std::fs::create_dir(sandbox.path("small")).unwrap();
    sandbox.write("small.sh", "mount -t tmpfs -o size=64k tmpfs small && export XDG_STATE_HOME=$PWD/small && cd small && exec \"$@\"");
    let in_own_space = |mount: &[&str]| {
        let words = [mount, &["sh", "small.sh", SUPEREGG]].concat();
        let mut child = start(&sandbox, &words);
        let mut input = child.stdin.take().unwrap();
        let big: String = (0..400).map(|i| format!("light l{i} 1 2 3 # {}\n", "x".repeat(200))).collect();
        let session = format!(
            "prm first\nsave first\n{big}save second\nprm last\nsave first\nrender big 600x600\ninfo\n"
        );
        let _ = input.write_all(session.as_bytes());
        // Room comes back, and what waited is written.
        let _ = input.write_all(b"save /dev/null\nget samples\n");
        drop(input);
        child.wait_with_output().unwrap()
    };
    let tries: [&[&str]; 2] = [&["unshare", "--mount"], &["unshare", "--user", "--map-root-user", "--mount"]];
    for mount in tries {
        if !Command::new(mount[0])
            .args(&mount[1..])
            .arg("true")
            .output()
            .is_ok_and(|out| out.status.success())
        {
            continue;
        }
        let ended = in_own_space(mount);
        let (out, err) = (String::from_utf8_lossy(&ended.stdout), String::from_utf8_lossy(&ended.stderr));
        if err.contains("mount:") {
            continue;
        }
        assert_eq!(err.matches("the autosave cannot be written").count(), 1, "{err}");
        assert!(err.contains("No space left on device"), "{err}");
        assert!(out.contains("  first\n  last\n") && out.contains("l399"), "{out}");
        assert!(!err.contains("panicked"), "{err}");
        return;
    }
    eprintln!("skipped: no small file system can be made here");
}

#[test]
fn a_save_that_fails_leaves_the_file_that_was_there() {
    let sandbox = Sandbox::new();
    sandbox.run_with("", "prm ball\nsave a\n").fine();
    let before = sandbox.read("a.scn");
    let mut permissions = std::fs::metadata(sandbox.path("")).unwrap().permissions();
    permissions.set_readonly(true);
    std::fs::set_permissions(sandbox.path(""), permissions.clone()).unwrap();
    let answer = sandbox.run_with("", "load a\nprm more\nsave a\n");
    // Whoever may write anywhere is not stopped by permissions.
    let is_stopped = answer.err.contains("error[unwritable]");
    #[allow(clippy::permissions_set_readonly_false)]
    permissions.set_readonly(false);
    std::fs::set_permissions(sandbox.path(""), permissions).unwrap();
    assert!(is_stopped == (sandbox.read("a.scn") == before), "{answer:?}");
    assert_eq!(sandbox.files(), ["a.scn"]);
}
