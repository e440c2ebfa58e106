//! The prompt at a real pseudo-terminal.

use crate::support::Sandbox;
use crate::terminal::{COLUMNS, Terminal};

const CTRL_C: &str = "\x03";
const CTRL_D: &str = "\x04";
const CTRL_R: &str = "\x12";
const UP: &str = "\x1b[A";
const RIGHT: &str = "\x1b[C";
const TAB: &str = "\t";

#[test]
fn the_prompt_shows_what_is_selected_and_the_cursor() {
    let sandbox = Sandbox::new();
    let mut terminal = Terminal::modeller(&sandbox);
    terminal.line("prm ball", "ball> ");
    terminal.line("obj man", "man> ");
    terminal.line("ap ball head", "man[head]> ");
    terminal.line("ap ball body", "man[body]> ");
    terminal.line("cur head", "man[head]> ");
    terminal.line("undo", "man[body]> ");
    terminal.line("deselect", "superegg> ");
    terminal.line("prm a_name_that_is_too_long_for_any_prompt", "a_name_that_is_too_long_…> ");
    terminal.press(CTRL_D);
    assert_eq!(terminal.left(), 0);
}

#[test]
fn tab_completes_and_hints_show_what_is_to_come() {
    let sandbox = Sandbox::new();
    sandbox.write("robot arm.scn", "prm z\n").write("robe.png", "");
    std::fs::create_dir(sandbox.path("rooms")).unwrap();
    let mut terminal = Terminal::modeller(&sandbox);
    terminal.line("prm ball", "ball> ");
    terminal.press("setCol");
    terminal.wait_for("setColor r(0..1) g(0..1) b(0..1)");
    terminal.press(RIGHT);
    terminal.press(" 1 ");
    terminal.wait_for_last("a hint", |line| line == "ball> setColor 1 g(0..1) b(0..1)");
    terminal.press(CTRL_C);
    terminal.line("", "ball> ");

    terminal.press("setc");
    terminal.press(TAB);
    terminal.wait_for("setCoeff   setColor   setCursor");
    terminal.press(&format!("oe{TAB}"));
    terminal.wait_for_last("setCoeff", |line| line.starts_with("ball> setCoeff x(>0)"));
    terminal.press("2 2 2\r");

    terminal.line("obj man", "man> ");
    terminal.press(&format!("ap b{TAB}h"));
    terminal.wait_for_last("ap ball h", |line| line.starts_with("man> ap ball h"));
    terminal.press("\r");
    terminal.wait_for("man[h]> ");
    terminal.press(&format!("cur {TAB}\r"));
    terminal.wait_for("man[h]> cur h");

    terminal.press(&format!("load! ro{TAB}"));
    terminal.wait_for("robot arm.scn  rooms/");
    terminal.press(&format!("b{TAB}"));
    terminal.wait_for("load! \"robot arm.scn\"");
    terminal.press("\r");
    terminal.wait_for("robot arm.scn: 1 primitive, 0 objects");
}

#[test]
fn what_is_typed_is_painted_as_it_is_meant() {
    let sandbox = Sandbox::new();
    let mut terminal = Terminal::modeller(&sandbox);
    terminal.line("prm ball", "ball> ");
    terminal.press("setColor 1 7 ");
    terminal.wait_for("setColor 1 7 b(0..1)");
    let raw = &terminal.raw;
    for painted in
        ["\x1b[1;34msetColor\x1b[0m", "\x1b[36m1\x1b[0m", "\x1b[4;31m7\x1b[0m", "\x1b[2mb(0..1)\x1b[0m"]
    {
        assert!(raw.contains(painted), "{painted:?} in {raw:?}");
    }
}

#[test]
fn ctrl_c_clears_the_line_and_ctrl_d_leaves() {
    let sandbox = Sandbox::new();
    let mut terminal = Terminal::modeller(&sandbox);
    terminal.press_and_wait(&format!("prm wrong{CTRL_C}"), "ctrl-c", "superegg> ");
    terminal.line("info", "superegg> ");
    assert!(terminal.contents().contains("primitives (0)"), "{}", terminal.contents());
    terminal.press_and_wait(CTRL_C, "ctrl-c", "superegg> ");
    assert!(terminal.contents().contains("ctrl-d leaves, and so does 'stop'"));
    // Keys that come while a line is carried out wait for the next one.
    terminal.press(&format!("prm a\rsave a\r{CTRL_D}"));
    assert_eq!(terminal.left(), 0);
    assert_eq!(sandbox.files(), ["a.scn"]);
    let mut terminal = Terminal::modeller(&sandbox);
    terminal.press("quit\r");
    assert_eq!(terminal.left(), 0);
}

#[test]
fn a_fault_is_reported_with_its_position_and_the_session_goes_on() {
    let sandbox = Sandbox::new();
    let mut terminal = Terminal::modeller(&sandbox);
    terminal.line("prm ball", "ball> ");
    terminal.line("setColor 1 2 0", "ball> ");
    let shown = terminal.contents();
    let lines: Vec<&str> = shown.lines().map(str::trim_end).collect();
    let at = lines.iter().position(|line| line.starts_with("error[out-of-range]")).unwrap();
    assert_eq!(lines[at], "error[out-of-range]: g of setColor must be from 0 to 1, not 2");
    assert_eq!(&lines[at + 1..at + 3], ["    | setColor 1 2 0", "    |            ^"]);
    assert!(lines[at + 3].starts_with("    = help: setColor r g b, for example"));
}

#[test]
fn history_lasts_over_sessions_and_can_be_searched() {
    let sandbox = Sandbox::new();
    let mut terminal = Terminal::modeller(&sandbox);
    terminal.line("prm unforgettable", "unforgettable> ");
    terminal.line("coeff 1 2 3", "unforgettable> ");
    terminal.line("nonsense", "unforgettable> ");
    terminal.press("stop\r");
    terminal.left();
    assert!(sandbox.own("state/superegg/history").is_file());
    let mut terminal = Terminal::modeller(&sandbox);
    terminal.press(&UP.repeat(3));
    terminal.wait_for_last("the third last line", |line| line.starts_with("superegg> coeff 1 2 3"));
    terminal.press_and_wait(CTRL_C, "ctrl-c", "superegg> ");
    terminal.press(CTRL_R);
    terminal.press("unforg");
    terminal.wait_for("prm unforgettable");
    terminal.press("\r");
    terminal.wait_for("unforgettable> ");
}

#[test]
fn pictures_are_rendered_behind_the_prompt_and_can_be_stopped() {
    let sandbox = Sandbox::new();
    let mut terminal = Terminal::modeller(&sandbox);
    terminal.line("prm ball", "ball> ");
    // Long enough to be met while it runs, on any machine.
    terminal.line("set samples 1000", "ball> ");
    terminal.line("set size 2000x1500", "ball> ");
    terminal.line("render big", "ball> ");
    terminal.press("coeff 2 2");
    terminal.wait_until("progress above the line that is typed", |terminal| {
        let screen = terminal.contents();
        let lines: Vec<&str> = screen.trim_end().lines().collect();
        let [.., above, last] = &lines[..] else { return false };
        above.contains("big.png:") && above.contains(" left") && last.starts_with("ball> coeff 2 2")
    });
    let progress = |screen: &str| screen.lines().filter(|line| line.contains(" left")).count();
    assert_eq!(progress(&terminal.contents()), 1);
    terminal.line(" 2", "ball> ");
    terminal.line("render second 4x3", "ball> ");
    assert!(terminal.contents().contains("queued behind 1 picture"));
    terminal.press(CTRL_C);
    terminal.wait_for("big.png: stopped at ");
    terminal.wait_for("second.png: stopped, nothing is written");
    terminal.line("set samples 1", "ball> ");
    terminal.line("render again 4x3", "ball> ");
    terminal.wait_for("again.png: 4x3, 1 instance");
    assert_eq!(sandbox.files(), ["again.png", "big.png"]);
    let stopped = image::open(sandbox.path("big.png")).unwrap().into_rgb8();
    assert!(stopped.dimensions() == (2000, 1500) && stopped.pixels().any(|pixel| pixel.0 == [0; 3]));
    terminal.line("stop render", "ball> ");
    assert!(terminal.contents().contains("nothing is being rendered"));
}

#[test]
fn a_long_paste_is_taken_whole() {
    let sandbox = Sandbox::new();
    let lines: String = (0..1000).map(|i| format!("xs 0 0 {i}\n")).collect();
    for (begin, end) in [("", ""), ("\x1b[200~", "\x1b[201~\r")] {
        let mut terminal = Terminal::modeller(&sandbox);
        terminal.line("prm ball", "ball> ");
        terminal.line("obj man", "man> ");
        terminal.line("ap ball", "man[ball]> ");
        let pasted = if begin.is_empty() { lines.replace('\n', "\r") } else { lines.clone() };
        terminal.press(&format!("{begin}{pasted}{end}prm done\r"));
        terminal.wait_for("done> ");
        terminal.press("save! out\r");
        terminal.wait_for("saved as out.scn");
        assert_eq!(sandbox.read("out.scn").matches("translate 0 0 ").count(), 1000);
        terminal.press(CTRL_D);
        terminal.left();
    }
}

#[test]
fn a_load_asks_only_where_something_would_be_lost() {
    let sandbox = Sandbox::new();
    sandbox
        .write("a.scn", "prm a\n")
        .write("other.scn", "prm other\n")
        .write("bad.scn", "prm b\nnonsense\nprm c\n");
    let mut terminal = Terminal::modeller(&sandbox);
    terminal.line("load a", "a> ");
    terminal.line("load a.scn", "a> ");
    terminal.line("coeff 2 2 2", "a> ");
    for (answer, prompt) in [("n", "a> "), (CTRL_C, "a> "), ("", "a> ")] {
        terminal.press("load other\r");
        terminal.wait_for_last("a question", |line| line.ends_with("replace it even so? [y/N]"));
        terminal.line(answer, prompt);
        assert!(terminal.contents().trim_end().contains("nothing has changed"));
    }
    // A file that cannot be loaded is reported without a question.
    terminal.line("load nowhere", "a> ");
    terminal.line("load bad", "a> ");
    terminal.press("load other\r");
    terminal.wait_for_last("a question", |line| line.ends_with("[y/N]"));
    terminal.press("perhaps\r");
    terminal.wait_for_last("the question again", |line| line == "y or n?");
    terminal.line("y", "other> ");
    terminal.line("undo", "a> ");
    let shown = terminal.contents();
    assert!(shown.contains("bad.scn:2:1: error[unknown-command]"), "{shown}");
    assert!(
        shown.contains("'bad.scn' has 1 error; the scene is as it was") && shown.contains("'load! bad'"),
        "{shown}"
    );
    terminal.line("load! bad", "c> ");
    terminal.line("undo", "a> ");
    terminal.line("redo", "c> ");
}

#[test]
fn what_was_not_saved_is_offered_at_the_next_start() {
    let sandbox = Sandbox::new();
    let mut terminal = Terminal::modeller(&sandbox);
    terminal.line("prm kept", "kept> ");
    terminal.line("coeff 1 2 3", "kept> ");
    terminal.press("this is lost");
    terminal.kill();
    // A session that runs at the same time is nobody's to recover.
    let mut other = Terminal::modeller(&sandbox);
    assert!(
        other.contents().contains("A session was not saved: 2 changes, just now, the last: coeff 1 2 3."),
        "{}",
        other.contents()
    );
    let mut another = Terminal::modeller(&sandbox);
    other.line("recover", "kept> ");
    other.line("undo", "kept> ");
    another.line("recover", "superegg> ");
    assert!(another.contents().contains("there is no session to recover"));
    other.press(CTRL_D);
    other.wait_for("The scene was not saved; the next start offers it again.");
    other.left();
    another.line("recover list", "superegg> ");
    assert!(another.contents().contains("3 changes, just now"), "{}", another.contents());
    another.line("recover", "kept> ");
    another.line("redo", "kept> ");
    another.line("info kept", "kept> ");
    assert!(another.contents().contains("coeff      1 2 3"));
    another.line("save done", "kept> ");
    another.press(CTRL_D);
    another.left();
    let quiet = Terminal::modeller(&sandbox);
    assert!(!quiet.contents().contains("not saved"), "{}", quiet.contents());
}

#[test]
fn a_preview_fills_the_terminal_and_no_more() {
    let sandbox = Sandbox::new();
    sandbox.write("ball.scn", "prm ball\ncamera 0 0 3 0 0 0\n");
    let mut terminal = Terminal::open(&sandbox, "ball.scn");
    terminal.wait_for("ball> ");
    terminal.line("preview", "ball> ");
    let shown = terminal.contents();
    let drawn: Vec<&str> = shown.lines().filter(|line| line.contains('▀')).collect();
    assert_eq!(drawn.len(), 38);
    assert!(drawn.iter().all(|line| line.chars().count() <= usize::from(COLUMNS)));
    assert!(terminal.raw.contains("\x1b[38;2;"), "in true colour");
    terminal.line("set preview kitty", "ball> ");
    terminal.press("preview\r");
    terminal.wait_for_last("a prompt", |line| line == "ball>");
    terminal.line("set preview sixel", "ball> ");
    terminal.line("preview", "ball> ");
    terminal.line("get preview", "ball> ");
    assert!(terminal.raw.contains("\x1b_Gf=100,a=T") && terminal.raw.contains("\x1bP"), "both protocols");
}

#[test]
fn a_signal_that_ends_it_leaves_the_terminal_as_it_was() {
    let sandbox = Sandbox::new();
    let mut terminal = Terminal::modeller(&sandbox);
    terminal.line("prm kept", "kept> ");
    terminal.end_by_signal();
    assert_eq!(terminal.left(), 128 + 15);
    assert!(terminal.echoes(), "what is typed next is seen");
    let next = Terminal::modeller(&sandbox);
    assert!(next.contents().contains("A session was not saved: 1 change"));
}
