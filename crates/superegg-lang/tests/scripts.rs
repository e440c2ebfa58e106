//! Whole files and their expected diagnostics.

use superegg_lang::{Diagnostic, Severity, lint, load_text};

/// Loads a text whose lines end in `#! code` where that fault is expected, and checks that exactly
/// these are reported.
fn check(text: &str) {
    let (_, diagnostics) = load_text("test.scn", text);
    let found: Vec<(usize, &str)> = diagnostics.iter().map(|d| (d.line.unwrap(), d.code.as_str())).collect();
    let expected: Vec<(usize, &str)> =
        text.lines().enumerate().filter_map(|(i, line)| Some((i + 1, line.split_once("#! ")?.1))).collect();
    assert_eq!(found, expected);
}

#[test]
fn every_error_is_told_and_the_good_lines_count() {
    let text = "\
prm ball
  coef 1 2        #! unknown-command
  coeff 1 2       #! argument-count
  coeff 1 2 3
  exp -1 1        #! out-of-range
  color rot 0 0   #! not-a-number
obj o
  ap bal          #! unknown-name
  ap ball
  ap ball         #! alias-taken
  ap ball second
  cursor third    #! unknown-name
  ao ball x       #! wrong-kind
  ss 0 1 1        #! out-of-range
  rs 0 0 0 90     #! transform
  coeff 1 1 1     #! selection
prm o             #! wrong-kind
  xs 1 2 3
";
    check(text);
    let (session, _) = load_text("test.scn", text);
    let object = session.scene().object("o").unwrap();
    assert_eq!(object.children().map(|(alias, _)| alias).collect::<Vec<_>>(), ["ball", "second"]);
    // The failed selection left everything as it was: the last line moved the child at the cursor
    // of o.
    assert_eq!(object.child("second").unwrap().steps().count(), 1);
}

#[test]
fn line_ends_and_marks_of_other_systems_are_nothing() {
    let (plain, _) = load_text("a", "prm a\ncoeff 1 2 3\nobj o\nap a");
    for text in [
        "\u{feff}prm a\r\ncoeff 1 2 3\r\nobj o\r\nap a\r\n",
        "PRM a   \n\t coeff\t1 2 3 # x\n\n\nOBJECT o\nap a #",
    ] {
        let (session, diagnostics) = load_text("b", text);
        assert!(diagnostics.is_empty(), "{diagnostics:?}");
        assert_eq!(session, plain);
    }
}

#[test]
fn stop_ends_the_file() {
    let (session, _) = load_text("a", "prm a\nquit\nprm b\n");
    assert_eq!(session.selected(), Some("a"));
}

#[test]
fn a_diagnostic_shows_the_place() {
    let (_, diagnostics) = load_text("my.scn", "prm a\n\tcolor 1 0 2");
    assert_eq!(
        diagnostics[0].to_string(),
        "my.scn:2:12: error[out-of-range]: b of setColor must be from 0 to 1, not 2\n    |  color 1 0 2\n    |            ^\n    = help: \
         setColor r g b, for example: setColor 0.8 0.2 0.1"
    );
}

#[test]
fn lint_tells_what_may_not_be_meant() {
    let text = "prm lost\nprm used\nreflected .6\nrefracted .6\nobj slip\nobj o\nap used\ndeselect\n";
    let (session, _) = load_text("test.scn", text);
    let warnings = lint(&session, "test.scn");
    let codes: Vec<&str> = warnings.iter().map(|w| w.code.as_str()).collect();
    assert_eq!(codes, ["unused", "empty-object", "unused", "shares", "nothing-selected"]);
    let (session, _) =
        load_text("test.scn", "prm a\nfloor 0 a\nobj o\nap a\nkey 0 scale 1 1 -1\nkey 8 scale 1 1 1\n");
    let of_keys = lint(&session, "test.scn");
    assert_eq!(of_keys.iter().map(|w| w.code.as_str()).collect::<Vec<_>>(), ["keys"]);
    assert!(of_keys[0].message.starts_with("at frame 4 "), "{}", of_keys[0].message);
    assert!(warnings.iter().all(|w: &Diagnostic| w.severity == Severity::Warning && w.help.is_some()));
}
