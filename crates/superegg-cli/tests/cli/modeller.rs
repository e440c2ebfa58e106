//! Sessions through a pipe: the same as at the prompt, without a person.

use crate::support::{Answer, Sandbox};

impl Sandbox {
    fn session(&self, lines: &str) -> Answer {
        self.run_with("", lines)
    }
}

const MAN: &str = "prm ball\nobj man\nap ball body\nap ball head\nss .6 .6 .6\nxs 0 0 1.4\n";

#[test]
fn a_pipe_is_a_session_without_prompts_or_colours() {
    let sandbox = Sandbox::new();
    let out = sandbox.session("prm ball\ninfo\nget size\n").fine();
    assert!(
        out.starts_with("primitives (1)\n  ball\n") && !out.contains('\x1b') && !out.contains('>'),
        "{out}"
    );
    assert_eq!(sandbox.session("").fine(), "");
    sandbox.write("man.scn", MAN);
    let out = sandbox.run_with("man.scn", "show\nstop\nnonsense after the end\n").fine();
    assert!(
        out.contains("man: 2 instances, from -1 -1 -1 to 1 1 2\n├─ body = ball\n└─ head = ball  <- cursor"),
        "{out}"
    );
}

#[test]
fn a_course_session_typed_word_for_word() {
    let sandbox = Sandbox::new();
    let typed = "Primitive base\nsetCoeff 2 2 0.3\nsetExponent 0.1 1.\nsetPatch 20 20\nsetColor .8 .1 .1\nsetAmbient 0.2\n\
        setReflected 0.4\nsetRefracted 0.1\nsetGloss .2\nsetDiffuse .7\nsetSpecular .3\nPrimitive 2nd_part\ncoeff .3 .3 2\nexp 1 1\n\
        patch 10 10\nsurface 0 0 1\nambient .1\nreflected 0.3\nrefracted 0.5\ngloss 0.3\ndiffuse 0.8\nspecular 0.1\n\
        Object robot\naddPrimitive base\naddPrimitive 2nd_part arm\ntranslate 0 0 2\nrotate 0 1 0 30\nscale 1 1 .5\n\
        setCursor base\nxs 0 0 -.5\nrs 0 0 1 45\nss 2 2 2\ntranslateAll 1 0 0\nrotateAll 0 0 2 90\nscaleAll .5 .5 .5\n\
        Object scene\naddObject robot left\nao robot right\nxall 1 1 1\nrall 1 0 0 10\nsall 1 2 1\ndeselect\nobj scene\n\
        info\nls all\ninfo selected\nhelp setColor\nhelp\nsave session\nquit\n";
    let out = sandbox.session(typed).fine();
    for part in [
        "primitives (2)",
        "  scene: 2 children",
        "coeff      2 2 0.3",
        "exponent   0.1 1",
        "child arm (2nd_part)",
        "setColor r g b",
    ] {
        assert!(out.contains(part), "{part}: {out}");
    }
    let loaded = sandbox.session("load session\ninfo all\n").fine();
    assert_eq!(
        loaded,
        sandbox
            .session(
                &typed
                    .replace("info\nls all\ninfo selected\nhelp setColor\nhelp\n", "info all\n")
                    .replace("save session\n", "")
            )
            .fine()
    );
}

#[test]
fn a_file_with_errors_is_loaded_by_force_or_not_at_all() {
    let sandbox = Sandbox::new();
    sandbox.write("bad.scn", "prm good\ncoeff 1 1\nprm better\nbad line\n").write("man.scn", MAN);
    let answer = sandbox.session("load man\nload bad\ninfo\nload missing\nload! bad\ninfo\nundo\ninfo\n");
    let err = &answer.err;
    for part in [
        "bad.scn:2:1: error[argument-count]",
        "bad.scn:4:1: error[unknown-command]",
        "<stdin>:2:6: error[not-loaded]: 'bad.scn' has 2 errors; the scene is as it was",
        "'load! bad' loads the lines without errors",
        "<stdin>:4:6: error[unreadable]: cannot read 'missing'",
    ] {
        assert!(err.contains(part), "{part}: {err}");
    }
    let selected: Vec<&str> = answer.out.lines().filter(|line| line.starts_with("selected")).collect();
    assert_eq!(selected, ["selected: man", "selected: better", "selected: man"]);
    assert_eq!(answer.code, Some(1));
}

#[test]
fn undo_goes_over_loads_and_back() {
    let sandbox = Sandbox::new();
    sandbox.write("man.scn", MAN);
    let out = sandbox.session("prm mine\ncoeff 1 2 3\nload man\nprm ball\ncoeff 9 9 9\nundo 3\ninfo mine\nredo 2\ninfo ball\nundo 4\ninfo\n").fine();
    assert!(
        out.contains("primitive mine\n  coeff      1 2 3")
            && out.contains("primitive ball\n  coeff      1 1 1"),
        "{out}"
    );
    assert!(out.contains("undone: 4 changes, the last of them: prm mine"), "{out}");
}

#[test]
fn what_people_miss_is_there() {
    let sandbox = Sandbox::new();
    sandbox.write("man.scn", MAN);
    let lines = "load man\ncopy ball hat\nrename ball snow\nobj man\nap hat\nremove body\ninfo man\ndelete snow\nshow man\n\
        history 2\nget samples\nset samples 9\nget samples\nclear\ninfo\nundo\ninfo man\n";
    let out = sandbox.session(lines).fine();
    for part in [
        "object man\n  child head (snow)\n    scale 0.6 0.6 0.6\n    translate 0 0 1.4\n  child hat  <- cursor\n",
        "'snow' is deleted, and with it 1 child: man/head\n",
        "man: 1 instance, from -1 -1 -1 to 1 1 1\n└─ hat  <- cursor\n",
        "    9  show man\n   10  history 2\n",
        "samples        4  ",
        "samples        9  ",
        "primitives (0)\nobjects (0)\n",
        "undone: clear\nobject man\n  child hat  <- cursor\n",
    ] {
        assert!(out.contains(part), "{part}: {out}");
    }
}

#[test]
fn folders_are_printed_changed_and_listed() {
    let sandbox = Sandbox::new();
    std::fs::create_dir(sandbox.path("scenes and more")).unwrap();
    sandbox.write("scenes and more/man.scn", MAN).write("a.txt", "").write(".hidden", "");
    let out = sandbox.session("dir\ncd \"scenes and more\"\ndir\nload man\npwd\ncd ..\ndir \"scenes and more\"\nload \"scenes and more/man.scn\"\n").fine();
    let lines: Vec<&str> = out.lines().collect();
    assert_eq!(lines[..3], ["scenes and more/", "a.txt", "man.scn"]);
    assert!(lines[3].ends_with("/scenes and more") && lines[4] == "man.scn", "{out}");
    let wrong = sandbox.session("cd nowhere\ndir a.txt\npwd extra\ncd a b\n");
    assert_eq!((wrong.code, wrong.err.matches("error[").count()), (Some(1), 4), "{wrong:?}");
}

#[test]
fn the_two_tests_answer_at_the_prompt() {
    let sandbox = Sandbox::new();
    let lines = "prm ball\niotest 0 0 .5\niotest 1 0 0\niotest 2 2 2\niotest\nset ioStep 1\nset ioHalf 1\niotest\nintersect\n\
        intersect 0 5 0 0 -1 0\nintersect 5 5 5 1 0 0\n";
    let out = sandbox.session(lines).fine();
    assert_eq!(
        out,
        "inside: the function is -0.75 for ball\non the surface: the function is 0 for ball\n\
        outside: the function is 11 for ball, the nearest primitive\n9261 points from -5 to 5 in steps of 0.5: 27 inside, 9234 outside\n\
        27 points from -1 to 1 in steps of 1: 1 inside, 26 outside\n\
        the ray from the camera at 0 0 10 along 0 0 -1\nmeets ball\nat t = 9\nat the point 0 0 1\nwhere the normal is 0 0 1\n\
        the ray meets ball\nat t = 4\nat the point 0 1 0\nwhere the normal is 0 1 0\nthe ray meets nothing\n"
    );
}

#[test]
fn a_picture_is_of_the_scene_as_it_was_at_the_command() {
    let sandbox = Sandbox::new();
    sandbox.write("man.scn", MAN);
    let out = sandbox.session("load man\nset samples 1\nrender a 40x30\ndelete ball\nrender b 40x30\nundo\nrender 40x30 c.png\nset size 40x30\nrender\n").fine();
    for line in [
        "a.png: 40x30, 2 instances",
        "b.png: 40x30, 0 instances",
        "c.png: 40x30, 2 instances",
        "man.png: 40x30",
    ] {
        assert!(out.contains(line), "{line}: {out}");
    }
    let bytes = |name: &str| std::fs::read(sandbox.path(name)).unwrap();
    assert!(
        bytes("a.png") == bytes("c.png")
            && bytes("a.png") == bytes("man.png")
            && bytes("a.png") != bytes("b.png")
    );
    sandbox.run("render man.scn --size 40x30 --samples 1 -o d.png --quiet").fine();
    assert_eq!(bytes("a.png"), bytes("d.png"));
}

#[test]
fn settings_of_the_picture_are_saved_with_the_scene() {
    let sandbox = Sandbox::new();
    sandbox
        .session("prm ball\nset size 8x6\nset samples 2\nset encoding linear\nset wireframe on\nsave s\n")
        .fine();
    assert_eq!(
        sandbox.read("s.scn"),
        "# superegg scene\nset size 8x6\nset samples 2\nset encoding linear\n\nprimitive ball\n"
    );
    assert!(sandbox.run("render s.scn").fine().starts_with("s.png: 8x6,"));
    let flags = sandbox.run("render s.scn --size 4x4 --encoding srgb").fine();
    assert!(flags.starts_with("s.png: 4x4,"), "{flags}");
    let out = sandbox.session("set wireframe on\nload s\nget wireframe size\n").fine();
    assert!(out.contains("wireframe      on") && out.contains("size           8x6"), "{out}");
}

#[test]
fn saving_spares_what_is_not_ours() {
    let sandbox = Sandbox::new();
    sandbox
        .write("notes.txt", "precious")
        .write("old.scn", "prm old\n# by hand\n")
        .write("other.scn", "prm other\n");
    let answer = sandbox.session(
        "prm ball\nsave notes.txt\nsave old\nload! old\nprm more\nsave old\nsave other\nsave! other\n",
    );
    assert_eq!(answer.err.matches("error[not-ours]").count(), 3, "{}", answer.err);
    assert!(answer.err.contains(
        "<stdin>:2:6: error[not-ours]: 'notes.txt' was neither made by Superegg nor loaded in this session"
    ));
    assert!(answer.err.contains("'save! other.scn' overwrites it"));
    assert_eq!(sandbox.read("notes.txt"), "precious");
    assert!(
        sandbox.read("old.scn").contains("primitive more")
            && sandbox.read("other.scn").contains("primitive more")
    );
    // Files that we made, in any session, are ours.
    sandbox.session("prm again\nsave other\n").fine();
}

#[cfg(unix)]
#[test]
fn a_saved_file_keeps_its_permissions_and_its_link() {
    use std::os::unix::fs::{PermissionsExt, symlink};
    let sandbox = Sandbox::new();
    sandbox.session("prm ball\nsave a\n").fine();
    std::fs::set_permissions(sandbox.path("a.scn"), std::fs::Permissions::from_mode(0o640)).unwrap();
    symlink("a.scn", sandbox.path("link.scn")).unwrap();
    sandbox.session("prm other\nsave link\n").fine();
    assert!(sandbox.path("link.scn").is_symlink() && sandbox.read("a.scn").contains("other"));
    assert_eq!(std::fs::metadata(sandbox.path("a.scn")).unwrap().permissions().mode() & 0o777, 0o640);
    assert_eq!(sandbox.files(), ["a.scn", "link.scn"]);
}

#[test]
fn a_file_that_another_program_changed_is_not_overwritten() {
    let sandbox = Sandbox::new();
    sandbox.write("a.scn", "prm a\n");
    let lines = format!("load a\nprm b\nsave copy\n{}save a\n", "cd .\n");
    sandbox.session(&lines).fine();
    // Between the load and the save somebody else writes; the session waits for it at a pipe.
    let mut child = std::process::Command::new(env!("CARGO_BIN_EXE_superegg"))
        .current_dir(sandbox.path(""))
        .envs(sandbox.user())
        .stdin(std::process::Stdio::piped())
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    use std::io::{BufRead, Write};
    let mut input = child.stdin.take().unwrap();
    let mut out = std::io::BufReader::new(child.stdout.take().unwrap());
    input.write_all(b"load a\npwd\n").unwrap();
    out.read_line(&mut String::new()).unwrap();
    sandbox.write("a.scn", "prm somebody_else\n");
    input.write_all(b"save a\n").unwrap();
    drop(input);
    let ended = child.wait_with_output().unwrap();
    let err = String::from_utf8_lossy(&ended.stderr).into_owned();
    assert!(err.contains("has changed since this session read or wrote it"), "{err}");
    assert_eq!(sandbox.read("a.scn"), "prm somebody_else\n");
}

#[test]
fn the_quicksave_is_the_users_and_the_old_one_is_found() {
    let sandbox = Sandbox::new();
    let missing = sandbox.session("load\n");
    assert!(missing.err.contains("there is no quicksave yet"), "{missing:?}");
    std::fs::create_dir(sandbox.path("data")).unwrap();
    sandbox.write("data/quicksave.scn", "prm old_one\n");
    assert!(sandbox.session("load\ninfo\n").fine().contains("old_one"));
    sandbox.session("prm new_one\nsave\n").fine();
    assert!(sandbox.own("data/superegg/quicksave.scn").is_file());
    assert_eq!(sandbox.read("data/quicksave.scn"), "prm old_one\n");
    assert!(sandbox.session("load\ninfo\n").fine().contains("new_one"));
}

#[test]
fn the_commands_as_typed_can_be_saved_and_loaded() {
    let sandbox = Sandbox::new();
    sandbox.write("man.scn", MAN);
    let out = sandbox.session("prm lost\nload man\nxs 1 0 0   # a step\nnonsense\nrs 0 0 1 9\nundo\ninfo\nsave --history h\ninfo all\nclear\nload h\ninfo all\n");
    assert_eq!(sandbox.read("h.scn"), format!("# superegg history\n{MAN}xs 1 0 0   # a step\n"));
    let all: Vec<&str> = out.out.split("primitive ball\n").skip(1).collect();
    assert_eq!(all.len(), 2);
    assert_eq!(all[0].trim(), all[1].trim());
}

#[test]
fn a_loaded_file_prints_what_it_asks_for_and_does_nothing_else() {
    let sandbox = Sandbox::new();
    sandbox.write("talk.scn", "prm a\ninfo a\nsave other\nrender x.png\nundo\n");
    let answer = sandbox.session("load talk\n");
    assert!(answer.out.starts_with("primitive a\n"), "{answer:?}");
    assert_eq!(answer.err.matches("warning[not-here]").count(), 3, "{answer:?}");
    assert_eq!((answer.code, sandbox.files()), (Some(0), vec!["talk.scn".to_owned()]));
}

/// Lines that cannot be carried out, each after `BEFORE`.
const WRONG: &[&str] = &[
    "colour 1 0 0",
    "prm",
    "prm a b",
    "prm man",
    "obj ball",
    "setCoeff 1 2",
    "setCoeff 0 1 1",
    "setCoeff 1 2 3",
    "exp 1 1",
    "setColor 1 1 2",
    "ap",
    "ap nobody",
    "ap man",
    "ap ball body",
    "ap ball x y",
    "ao ball",
    "ao nobody",
    "cur nobody",
    "cur",
    "xs 1 2",
    "xs 1 2 three",
    "xs 1 2 nan",
    "xs 1 2 inf",
    "xs 1 2 1e999",
    "rs 0 0 0 90",
    "rs 0 0 1",
    "ss 0 1 1",
    "ss 1 1",
    "rall 0 0 0 1",
    "sall 1 0 1",
    "remove nobody",
    "remove",
    "delete nobody",
    "delete",
    "rename ball",
    "rename nobody x",
    "rename ball man",
    "copy nobody x",
    "copy ball man",
    "unlight nobody",
    "light",
    "light l 1 2",
    "light l 1 2 3 -1 0 0",
    "camera 0 0 0 0 0 0",
    "camera 1 2 3",
    "cameraUp 0 0 0",
    "background -1 0 0",
    "setDepth 65",
    "setDepth 1.5",
    "load nowhere.scn",
    "load folder",
    "load /dev/null",
    "load \"\"",
    "load foreign.bin",
    "load bad.scn",
    "load a b",
    "save folder",
    "save nowhere/x",
    "save foreign.bin",
    "save --histroy x",
    "save a b",
    "undo 0",
    "undo x",
    "redo",
    "set",
    "set nothing 1",
    "set size 5",
    "set size 0x0",
    "set samples 0",
    "set wireframe maybe",
    "get nothing",
    "info nobody",
    "show nobody",
    "help gibberish",
    "render a.jpg",
    "render man.scn",
    "render folder",
    "render 0x5",
    "render a b",
    "iotest 1 2",
    "iotest x y z",
    "intersect 0 0 0 0 0 0",
    "intersect 1 2 3",
    "cd nowhere",
    "dir nowhere",
    "stop everything",
    "history 0",
    "history x",
    "clear all",
    "recover all",
    "\u{1b}[31m",
    "größer 1",
    "\"",
    "1 2 3",
    "source! nowhere",
];

#[test]
fn wrong_lines_say_where_what_and_what_to_do_and_change_nothing() {
    let sandbox = Sandbox::new();
    std::fs::create_dir(sandbox.path("folder")).unwrap();
    sandbox.write("man.scn", MAN).write("foreign.bin", b"\x00\x01\x02").write("bad.scn", "prm x\noops\n");
    let before = "prm ball\nobj man\nap ball body\n";
    let files = sandbox.files();
    let expected = sandbox.session(&format!("{before}info all\ninfo\n")).fine();
    for (number, wrong) in WRONG.iter().enumerate() {
        let answer = sandbox.session(&format!("{before}{wrong}\ninfo all\ninfo\n"));
        assert_eq!(answer.out, expected, "{wrong}");
        assert_eq!(answer.code, Some(1), "{number} {wrong}: {}", answer.err);
        let reported = answer
            .err
            .lines()
            .find(|line| line.starts_with("<stdin>:4:"))
            .unwrap_or_else(|| panic!("{wrong}: {}", answer.err));
        let column: usize = reported.split(':').nth(2).unwrap().parse().unwrap();
        assert!(column >= 1 && column <= wrong.chars().count().max(1), "{wrong}: {reported}");
        assert!(reported.contains(" error[") && answer.err.contains("= help: "), "{wrong}: {}", answer.err);
        assert!(!answer.err.contains('\u{1b}'), "{wrong}: {:?}", answer.err);
    }
    assert_eq!(sandbox.files(), files);
}

#[test]
fn odd_bytes_and_long_lines_are_survived() {
    let sandbox = Sandbox::new();
    let long = "x".repeat(3 << 20);
    let lines =
        format!("prm ball\n{long}\nprm {}\nprm \u{7f}\u{1b}[2J\ninfo\nprm last\n", "n".repeat(100_000));
    let answer = sandbox.session(&lines);
    assert!(answer.err.contains("<stdin>:2:1: error[too-long]"), "{:.300}", answer.err);
    assert!(answer.out.contains("\\u{7f}\\u{1b}[2J") && !answer.out.contains('\u{1b}'));
    let mut bytes = b"\xef\xbb\xbfprm ok\n\xff\xfe\nprm a\xc3\n".to_vec();
    bytes.extend((0..200_000u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as u8));
    bytes.extend(b"\ninfo ok\n");
    let answer = sandbox.run_bytes("", &bytes);
    assert!(
        answer.err.contains("<stdin>:2:1: error[not-text]")
            && answer.err.contains("<stdin>:3:6: error[not-text]")
    );
    assert!(answer.out.starts_with("primitive ok\n"), "{:.300}", answer.out);
}

#[cfg(unix)]
#[test]
fn devices_pipes_and_circles_are_refused() {
    let sandbox = Sandbox::new();
    std::os::unix::fs::symlink("b.scn", sandbox.path("a.scn")).unwrap();
    std::os::unix::fs::symlink("a.scn", sandbox.path("b.scn")).unwrap();
    nix::unistd::mkfifo(&sandbox.path("pipe.scn"), nix::sys::stat::Mode::S_IRWXU).unwrap();
    let answer = sandbox.session("load a.scn\nload pipe.scn\nsave pipe.scn\nload /dev/zero\nprm ball\nsave /dev/full\nsave a.scn\nrender pipe.png\n");
    let err = &answer.err;
    for part in [
        "<stdin>:1:6: error[unreadable]: cannot read 'a.scn'",
        "<stdin>:2:6: error[unreadable]: cannot read 'pipe.scn': it is a device or a pipe",
        "<stdin>:3:6: error[unwritable]: cannot write 'pipe.scn': it is a pipe",
        "<stdin>:4:6: error[unreadable]",
        "<stdin>:6:6: error[unwritable]: cannot write '/dev/full': No space left",
        "<stdin>:7:6: error[unwritable]: cannot write 'a.scn'",
    ] {
        assert!(err.contains(part), "{part}: {err}");
    }
}

#[test]
fn run_is_the_same_session_from_a_file() {
    let sandbox = Sandbox::new();
    sandbox.write("s.txt", "prm ball\nnonsense\nundo\nredo\nrender a.png 8x6\nsave s\ninfo\nrecover\n");
    let answer = sandbox.run("run s.txt");
    assert!(answer.err.contains("s.txt:2:1: error[unknown-command]") && answer.code == Some(1), "{answer:?}");
    assert!(answer.err.contains("s.txt:8:1: warning[nothing-left]"), "{answer:?}");
    assert_eq!(sandbox.files(), ["a.png", "s.scn", "s.txt"]);
    assert!(!sandbox.own("state").exists(), "a file that is run leaves no journal");
}

#[test]
fn a_clean_scene_has_one_block_for_each_thing() {
    let sandbox = Sandbox::new();
    let typed = "obj man\nprm ball\nobj man\nap ball\nprm nose\nobj man\nap nose\nobj fractal\nap ball\nao fractal again\nss .5 .5 .5\n\
        obj a\nobj b\nao a\nobj a\nao b\nprm ball\ncolor 1 0 0\ncameraUp -0 1 0\nbackground -0 0 0\n";
    let before = sandbox.session(&format!("{typed}save s\ninfo all\ninfo\n")).fine();
    let text = sandbox.read("s.scn");
    for line in [
        "primitive ball",
        "primitive nose",
        "object man",
        "object fractal",
        "object b",
        "background -0 0 0",
        "cameraUp -0 1 0",
    ] {
        let expected = if line == "primitive ball" { 2 } else { 1 };
        assert_eq!(text.lines().filter(|l| *l == line).count(), expected, "{line}: {text}");
    }
    assert_eq!(sandbox.session("load s\ninfo all\ninfo\n").fine(), before);
}

#[test]
fn unsaved_sessions_are_numbered() {
    let sandbox = Sandbox::new();
    std::fs::create_dir_all(sandbox.own("state/superegg/journals")).unwrap();
    for (name, line) in [("1-1", "prm older"), ("2-2", "prm newer")] {
        let path = sandbox.own(&format!("state/superegg/journals/{name}.journal"));
        std::fs::write(&path, format!("# superegg journal 1\n> {line}\n")).unwrap();
        let age = std::time::Duration::from_secs(if name == "1-1" { 7200 } else { 60 });
        let file = std::fs::File::options().append(true).open(path).unwrap();
        file.set_modified(std::time::SystemTime::now() - age).unwrap();
    }
    let answer = sandbox.session("recover list\nrecover restore 3\nrecover restore 2\ninfo\nrecover list\nrecover discard 1\nrecover\n");
    assert!(
        answer.out.contains(
            "  1  1 change, 1 min ago, the last: prm newer\n  2  1 change, 2 h ago, the last: prm older\n"
        ),
        "{answer:?}"
    );
    assert!(
        answer.out.contains("recovered: 1 change, 2 h ago") && answer.out.contains("  older\n"),
        "{answer:?}"
    );
    // Without a person nothing is forgotten.
    assert!(
        answer.err.contains("only discarded at the prompt")
            && answer.err.contains("there are 2 sessions to recover"),
        "{answer:?}"
    );
    assert_eq!(std::fs::read_dir(sandbox.own("state/superegg/journals")).unwrap().count(), 2);
}

#[test]
fn a_recovered_session_finds_its_files() {
    let sandbox = Sandbox::new();
    let journals = sandbox.own("state/superegg/journals");
    std::fs::create_dir_all(&journals).unwrap();
    std::fs::create_dir(sandbox.path("far")).unwrap();
    image::RgbImage::new(2, 2).save(sandbox.path("far/t.png")).unwrap();
    let far = sandbox.path("far").display().to_string();
    let text = format!("# superegg journal 2 {far}\n> prm lost\n> texture color t.png\n");
    std::fs::write(journals.join("1-1.journal"), text).unwrap();
    for before in ["", "prm other\n"] {
        let lines = format!(
            "{before}recover\nrender a.png 8x6\ntexture bump far/t.png\nsave got\nsave --history typed\n"
        );
        let answer = sandbox.session(&lines);
        assert!(answer.err.is_empty() && sandbox.path("a.png").exists(), "{answer:?}");
        let text = sandbox.read("got.scn");
        assert!(text.contains("color \"far/t.png\"") && text.contains("bump \"far/t.png\""), "{text}");
        assert!(
            sandbox.read("typed.scn").contains("texture color \"far/t.png\"\n"),
            "{}",
            sandbox.read("typed.scn")
        );
        std::fs::remove_file(sandbox.path("a.png")).unwrap();
    }
}
