//! The prompt and the command line as someone meets them for the first time.

use crate::support::Sandbox;
#[cfg(unix)]
use crate::terminal::Terminal;

const CTRL_C: &str = "\x03";
const CTRL_D: &str = "\x04";

#[cfg(unix)]
#[test]
fn a_slip_in_a_name_is_seen_at_once() {
    let sandbox = Sandbox::new();
    let mut terminal = Terminal::modeller(&sandbox);
    terminal.line("object Foo", "Foo> ");
    terminal.line("object foo", "foo> ");
    terminal.line("object foo", "foo> ");
    let shown = terminal.contents();
    assert!(shown.contains("new object 'Foo'\n"), "{shown}");
    assert_eq!(shown.matches("new object 'foo'; did you mean 'Foo'?").count(), 1, "{shown}");
    // A pipe and a file say nothing of it.
    assert_eq!(sandbox.run_with("", "object Foo\nobject foo\n").fine(), "");
}

#[cfg(unix)]
#[test]
fn undo_stays_behind_the_file_that_the_session_began_with() {
    let sandbox = Sandbox::new();
    sandbox.write("start.scn", "prm ball\nobj man\nap ball\n");
    let mut terminal = Terminal::open(&sandbox, "start.scn");
    terminal.wait_for("man[ball]> ");
    terminal.line("undo", "man[ball]> ");
    assert!(terminal.contents().contains("there is nothing to undo"), "{}", terminal.contents());
    terminal.line("xs 1 0 0; xs 2 0 0", "man[ball]> ");
    terminal.line("undo 99", "man[ball]> ");
    let shown = terminal.contents();
    assert!(shown.contains("the scene is as it was when the session started"), "{shown}");
    terminal.line("save --history lines", "man[ball]> ");
    assert!(sandbox.read("lines.scn").contains("prm ball\nobj man\nap ball\n"));
    terminal.line("clear", "superegg> ");
    terminal.line("undo", "man[ball]> ");
}

#[cfg(unix)]
#[test]
fn lines_are_taken_as_people_write_them() {
    let sandbox = Sandbox::new();
    let mut terminal = Terminal::modeller(&sandbox);
    terminal.line("primitive ball; color orange; gloss 0.2;", "ball> ");
    terminal.line("object man; addPrimitive ball head; rotate x 90", "man[head]> ");
    terminal.line("samples 9; set exposure 1 # a comment; prm no", "man[head]> ");
    terminal.line("prm other; nonsense; prm never", "other> ");
    let shown = terminal.contents();
    assert!(shown.contains("    | prm other; nonsense; prm never\n    |            ^^^^^^^^"), "{shown}");
    terminal.line("color 255 128 0", "other> ");
    assert!(terminal.contents().contains("looks like 8-bit values"), "{}", terminal.contents());
    assert!(terminal.contents().contains("setColor #ff8000"), "{}", terminal.contents());
    terminal.line("save all", "other> ");
    let saved = sandbox.read("all.scn");
    for part in ["setColor 1 0.37626", "setGloss 0.2", "rotate 1 0 0 90", "set samples 9", "set exposure 1"] {
        assert!(saved.contains(part), "{part}: {saved}");
    }
    assert!(!saved.contains("never") && !saved.contains(" no\n"), "{saved}");
    // The hint and the colours are those of the command at the cursor.
    terminal.press("prm x; setCo");
    terminal.press("\t");
    terminal.wait_for("setCoeff  setColor");
    terminal.press_and_wait(CTRL_C, "ctrl-c", "other> ");
    // A question ends a line only if the answer is no.
    for (answer, prompt) in [("n", "other> "), ("y", "third> ")] {
        sandbox.write("second.scn", "prm second\n");
        terminal.press("prm other; index 1.1; load second; prm third\r");
        terminal.wait_for_last("a question", |line| line.ends_with("replace it even so? [y/N]"));
        terminal.line(answer, prompt);
    }
}

#[test]
fn a_scene_may_have_several_commands_in_a_line() {
    let sandbox = Sandbox::new();
    sandbox.write(
        "s.scn",
        "primitive ball; setColor red; gloss 2; never\nprm odd;\nobject a;b; exposure 1\nrotate x 5\n",
    );
    let answer = sandbox.run("info s.scn");
    assert!(answer.err.contains("s.scn:1:37: error[out-of-range]"), "{answer:?}");
    assert!(answer.err.contains("no child"), "{answer:?}");
    assert!(answer.out.contains("  odd;\n") && answer.out.contains("  a;b: 0 children"), "{answer:?}");
    // The same lines typed.
    let answer = sandbox.run_with("", "primitive ball; setColor red\ninfo ball; get samples\n").fine();
    assert!(answer.contains("color      1 0 0") && answer.contains("samples "), "{answer}");
}

#[cfg(unix)]
#[test]
fn help_is_read_page_by_page() {
    let sandbox = Sandbox::new();
    let mut terminal = Terminal::modeller(&sandbox);
    terminal.line("help", "superegg> ");
    assert!(terminal.contents().contains("First steps"), "{}", terminal.contents());
    terminal.line("? samples", "superegg> ");
    assert!(terminal.contents().contains("set samples VALUE"), "{}", terminal.contents());
    drop(terminal);
    let mut terminal = Terminal::open_with(&sandbox, "", &[("PAGER", "cat > paged.txt; echo was paged")]);
    terminal.wait_for("superegg> ");
    terminal.line("help rotate", "superegg> ");
    assert!(!sandbox.path("paged.txt").exists(), "it fits");
    terminal.line("help all", "superegg> ");
    assert!(terminal.contents().contains("was paged") && sandbox.read("paged.txt").contains("setFresnel"));
    terminal.line("help rotate", "superegg> ");
    // A pager that is not there.
    drop(terminal);
    let mut terminal = Terminal::open_with(&sandbox, "", &[("PAGER", "no-such-pager")]);
    terminal.wait_for("superegg> ");
    terminal.line("help all", "superegg> ");
    assert!(terminal.contents().contains("starts a comment"), "{}", terminal.contents());
}

#[cfg(unix)]
#[test]
fn questions_take_an_answer_and_nothing_else() {
    let sandbox = Sandbox::new();
    let journals = sandbox.own("state/superegg/journals");
    std::fs::create_dir_all(&journals).unwrap();
    std::fs::write(journals.join("1-1.journal"), "# superegg journal 1\n> prm lost\n").unwrap();
    // Without a person it stays.
    sandbox.run_with("", "recover\nsave got\n").fine();
    assert!(sandbox.read("got.scn").contains("primitive lost") && journals.join("1-1.journal").exists());
    sandbox.write("s.txt", "recover\nrecover discard\n");
    sandbox.run("run s.txt");
    assert!(journals.join("1-1.journal").exists());
    let mut terminal = Terminal::modeller(&sandbox);
    terminal.press("recover discard\r");
    terminal.wait_for_last("a question", |line| line.ends_with("forget them? [y/N]"));
    terminal.press("\t\t");
    terminal.line("n", "superegg> ");
    let shown = terminal.contents();
    assert!(shown.contains("nothing has changed") && !shown.contains("addObject"), "{shown}");
    assert!(journals.join("1-1.journal").exists());
    terminal.press("recover discard\r");
    terminal.wait_for_last("a question", |line| line.ends_with("forget them? [y/N]"));
    terminal.line("y", "superegg> ");
    assert!(!journals.join("1-1.journal").exists());
}

#[cfg(unix)]
#[test]
fn ctrl_c_leaves_no_hint() {
    let sandbox = Sandbox::new();
    let mut terminal = Terminal::modeller(&sandbox);
    terminal.press("setCol");
    terminal.wait_for("setColor r(0..1) g(0..1) b(0..1)");
    terminal.press_and_wait(CTRL_C, "ctrl-c", "superegg> ");
    let shown = terminal.contents();
    assert!(shown.contains("superegg> setCol\n") && !shown.contains("r(0..1)"), "{shown}");
}

#[cfg(unix)]
#[test]
fn a_terminal_without_means_gets_plain_lines() {
    for term in ["dumb", ""] {
        let sandbox = Sandbox::new();
        sandbox.write("other.scn", "prm other\n");
        let mut terminal = Terminal::open_with(&sandbox, "", &[("TERM", term)]);
        terminal.wait_for("superegg> ");
        terminal.press("prm ball\r");
        terminal.wait_for("ball> ");
        terminal.press("color 2 0 0\r");
        terminal.wait_for("= help:");
        terminal.press("load other\r");
        terminal.wait_for("[y/N]");
        terminal.press("y\r");
        terminal.wait_for("other> ");
        terminal.press("clear screen\rpreview\rhelp all\r");
        terminal.wait_for("starts a comment");
        terminal.press(CTRL_D);
        assert_eq!(terminal.left(), 0);
        assert!(!terminal.raw.contains('\x1b'), "{:?}", terminal.raw);
    }
}

#[test]
fn names_never_control_the_terminal() {
    let evil = "e\x1b[2Jv\u{202e}il\u{200b}";
    let sandbox = Sandbox::new();
    let scene = format!(
        "prm {evil}\nobj {evil}2\nap {evil} {evil}3\nap {evil}\nlight {evil} 1 2 3\nrefracted {evil}\nap {evil}4\nobj {evil}2\n"
    );
    sandbox
        .write("s.scn", &scene)
        .write("p.csv", "x,y,z\n0,0,0\n")
        .write("r.csv", "ox,oy,oz,dx,dy,dz\n0,0,9,0,0,-1\n");
    let is_clean = |answer: &crate::support::Answer, words: &str| {
        let text = format!("{}{}", answer.out, answer.err);
        let found = text.chars().find(|c| *c == '\x1b' || *c == '\u{202e}' || *c == '\u{200b}');
        assert!(found.is_none(), "{words}: {found:?} in {text:?}");
        text
    };
    let mut escaped = 0;
    for words in [
        "info s.scn",
        "info s.scn all",
        "check s.scn",
        "render s.scn --size 8x8 -o a.png",
        "iotest s.scn p.csv --all --distance",
        "intersect s.scn r.csv",
        "intersect s.scn",
        "measure s.scn",
        "measure s.scn --json",
        "sample s.scn -n 3 -o -",
        "export s.scn -o a.pov",
        "animate s.scn --turntable 2 --size 8x8 -o film",
    ] {
        escaped += usize::from(is_clean(&sandbox.run(words), words).contains("u{1b}"));
    }
    assert!(escaped >= 7, "{escaped}");
    let json: serde_json::Value = serde_json::from_str(&sandbox.run("measure s.scn --json").out).unwrap();
    assert!(
        json.to_string().contains(&serde_json::to_string(evil).unwrap().trim_matches('"').to_owned()),
        "{json}"
    );
    let lines = format!("{scene}info\nshow\nundo\nredo\nhistory\ndelete {evil}\nload {evil}\n");
    is_clean(&sandbox.run_with("", &lines), "a session");
    // A file name that a shell has put into the command line.
    for words in [
        format!("render s.scn {evil}"),
        format!("render --{evil}"),
        evil.to_owned(),
        format!("render {evil}.scn"),
    ] {
        let text = is_clean(&sandbox.run(&words), &words);
        assert!(text.contains("u{202e}"), "{words}: {text}");
    }
    // The root of a partial file.
    let one = sandbox.run(&format!("render s.scn --size 8x8 --shard 1/2 -o 1.part --object {evil}"));
    let two = sandbox.run("render s.scn --size 8x8 --shard 2/2 -o 2.part");
    assert_eq!((one.code, two.code), (Some(1), Some(1)), "{one:?} {two:?}");
    let text = is_clean(&sandbox.run("merge 1.part 2.part -o m.png"), "merge");
    assert!(text.contains("different pictures") && text.contains("u{1b}"), "{text}");
}

#[test]
fn colours_are_there_when_they_are_wanted() {
    let sandbox = Sandbox::new();
    sandbox.write("s.scn", "prm ball\ncolor 2 0 0\n");
    for (words, is_colored) in [
        ("check s.scn", false),
        ("check s.scn --color always", true),
        ("--color always check s.scn", true),
        ("--color=never check s.scn", false),
        ("render nowhere.scn --color always", true),
        ("rendr s.scn --color always", true),
        ("render --sice 3 --color=always", true),
        ("render --sice 3", false),
    ] {
        let answer = sandbox.run(words);
        assert_eq!(answer.err.contains('\x1b'), is_colored, "{words}: {answer:?}");
        assert!(!answer.out.contains('\x1b'), "{words}");
    }
    assert!(sandbox.run("--help --color always").fine().contains('\x1b'));
    assert!(!sandbox.run("--help").fine().contains('\x1b'));
    let report = sandbox.run("s.scn render s.scn").failed(2);
    assert!(report.contains("'s.scn' stands before a command"), "{report}");
    sandbox.run("check s.scn --color pink").failed(2);
}

#[cfg(unix)]
#[test]
fn a_terminal_has_coloured_errors_unless_they_are_unwanted() {
    let sandbox = Sandbox::new();
    sandbox.write("s.scn", "prm ball\ncolor 2 0 0\n");
    for (words, environment, is_colored) in [
        ("check s.scn", ("A", "B"), true),
        ("check s.scn", ("NO_COLOR", "1"), false),
        ("check s.scn", ("CLICOLOR", "0"), false),
        ("check s.scn --color never", ("A", "B"), false),
        ("check s.scn", ("TERM", "dumb"), false),
    ] {
        // The library takes any value of CI for a terminal with colours.
        let mut terminal = Terminal::open_with(&sandbox, words, &[environment, ("CI", "true")]);
        terminal.wait_for("1 error");
        assert_eq!(
            terminal.raw.contains("\x1b[1;31merror[out-of-range]"),
            is_colored,
            "{words} {environment:?}"
        );
    }
    let mut terminal = Terminal::modeller(&sandbox);
    terminal.line("nonsense", "superegg> ");
    assert!(terminal.raw.contains("\x1b[1;31merror[unknown-command]\x1b[0m"), "{:?}", terminal.raw);
}

#[test]
fn short_options_completions_and_man_pages() {
    let sandbox = Sandbox::new();
    sandbox.write("s.scn", "prm ball\n");
    assert_eq!(sandbox.run("render s.scn -s 8x6 -q -o a.png").fine(), "");
    assert_eq!(image::image_dimensions(sandbox.path("a.png")).unwrap(), (8, 6));
    for shell in ["bash", "zsh", "fish", "powershell"] {
        let script = sandbox.run(&format!("completions {shell}")).fine();
        for word in ["render", "turntable", "force", "completions"] {
            assert!(script.contains(word), "{shell}: {word}");
        }
    }
    std::fs::create_dir(sandbox.path("man1")).unwrap();
    let pages = sandbox.run("man man1").fine();
    assert!(pages.contains("man1/superegg.1\n") && pages.contains("man1/superegg-render.1\n"), "{pages}");
    let page = sandbox.read("man1/superegg-render.1");
    assert!(page.contains(".TH SUPEREGG-RENDER 1") && page.contains("max\\-samples"), "{page}");
    sandbox.run("man nowhere").failed(2);
}

#[test]
fn every_example_of_the_help_runs() {
    let sandbox = Sandbox::new();
    for spec in superegg_lang::COMMANDS {
        // These read files, need a window or an unsaved session, or begin something else.
        if ["source", "include", "cd", "dir", "recover", "view", "interact"].contains(&spec.name) {
            continue;
        }
        let line = superegg_lang::example_line(spec);
        let answer = sandbox.run_with("", &format!("set size 16x12\n{line}\n"));
        assert_eq!((answer.code, answer.err.as_str()), (Some(0), ""), "{line}");
        let explained = sandbox.run_with("", &format!("help {}\n", spec.name)).fine();
        assert!(explained.contains(&format!("example: {line}")), "{explained}");
    }
}

#[cfg(unix)]
#[test]
fn all_that_belongs_to_the_program_is_installed() {
    let sandbox = Sandbox::new();
    let output = std::process::Command::new("sh")
        .arg(crate::support::project("packaging/install.sh"))
        .arg("/usr")
        .env("DESTDIR", sandbox.path("root"))
        .env("SUPEREGG", env!("CARGO_BIN_EXE_superegg"))
        .output()
        .unwrap();
    assert!(output.status.success(), "{output:?}");
    for file in [
        "man/man1/superegg.1",
        "man/man1/superegg-animate.1",
        "bash-completion/completions/superegg",
        "zsh/site-functions/_superegg",
        "fish/vendor_completions.d/superegg.fish",
        "powershell/superegg.ps1",
        "applications/superegg.desktop",
        "mime/packages/superegg.xml",
        "icons/hicolor/scalable/apps/superegg.svg",
    ] {
        let length =
            sandbox.path("root/usr/share").join(file).metadata().map_or(0, |metadata| metadata.len());
        assert!(length > 100, "{file}");
    }
    // A click opens the window, with a new scene where no file is given.
    let entry = sandbox.read("root/usr/share/applications/superegg.desktop");
    assert!(entry.contains("\nExec=superegg view %f\n") && entry.contains("\nTerminal=false\n"), "{entry}");
}
