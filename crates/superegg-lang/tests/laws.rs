//! Laws of the language, on sessions generated from the command table.

use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use superegg_lang::{
    Arg, ArgKind, COMMANDS, CommandSpec, Effect, NameKind, Needs, Range, SETTINGS, Session, Settings,
    Timeline, complete, format_number, highlight, hint, load_text, parse_line, scene_at, write_session,
};

fn config(cases: u32) -> ProptestConfig {
    ProptestConfig {
        cases,
        rng_seed: RngSeed::Fixed(1971),
        failure_persistence: None,
        ..ProptestConfig::default()
    }
}

/// A number in a range, including its ends and extreme magnitudes.
fn number(range: Range) -> BoxedStrategy<f64> {
    let any =
        prop_oneof![-10.0..10.0f64, Just(0.0), Just(-0.0), (-30.0..30.0f64).prop_map(|log| 10f64.powf(log))];
    match range {
        Range::Any => any.boxed(),
        Range::Positive => any.prop_map(|x| if x == 0.0 { 1.0 } else { x.abs() }).boxed(),
        Range::NonNegative => any.prop_map(f64::abs).boxed(),
        Range::NonZero => any.prop_map(|x| if x == 0.0 { -1.0 } else { x }).boxed(),
        Range::Within(least, most) => prop_oneof![least..most, Just(least), Just(most)].boxed(),
        Range::Between(least, most) => (least + 1e-9..most).boxed(),
        Range::AboveTo(least, most) => prop_oneof![least + 1e-9..most, Just(most)].boxed(),
        Range::Whole(least, most) => (least..=most).prop_map(f64::from).boxed(),
    }
}

fn word(arg: &'static Arg) -> BoxedStrategy<String> {
    match arg.kind {
        ArgKind::Number(range) => number(range).prop_map(format_number).boxed(),
        ArgKind::Choice(choices) => prop::sample::select(choices.to_vec()).prop_map(str::to_owned).boxed(),
        ArgKind::Size => prop::sample::select(vec!["640x480", "1x1"]).prop_map(str::to_owned).boxed(),
        ArgKind::Value => prop::sample::select(vec![
            "on", "off", "2", "64x48", "linear", "kitty", "0.25", "16", "filmic", "tent",
        ])
        .prop_map(str::to_owned)
        .boxed(),
        ArgKind::Name(NameKind::Setting) | ArgKind::Words(NameKind::Setting) => {
            prop::sample::select(SETTINGS.iter().map(|spec| spec.name.to_owned()).collect::<Vec<_>>()).boxed()
        }
        ArgKind::Line => keyable_line().boxed(),
        ArgKind::Name(_) | ArgKind::File | ArgKind::Words(_) => {
            prop::sample::select(vec!["a", "b", "c", "2nd", "all", "größe", "a/b", "\"x\"", "prm"])
                .prop_map(str::to_owned)
                .boxed()
        }
    }
}

/// A line that the table allows, with any of its spellings and any number of its optional parts.
fn line() -> impl Strategy<Value = String> {
    line_of(COMMANDS.iter().collect())
}

/// The same of the commands that there can be keys of, but for those of no numbers: faults of a
/// line within a line are the line's.
fn keyable_line() -> impl Strategy<Value = String> {
    line_of(COMMANDS.iter().filter(|spec| spec.is_keyable()).collect())
}

fn line_of(specs: Vec<&'static CommandSpec>) -> impl Strategy<Value = String> {
    prop::sample::select(specs).prop_flat_map(|spec| {
        let spellings: Vec<_> = spec.all_spellings().collect();
        let words: Vec<_> = spec.all_args().map(word).collect();
        let mut counts: Vec<usize> = spec.counts().collect();
        if counts.is_empty() {
            counts.push(0);
        }
        (prop::sample::select(spellings), words, prop::sample::select(counts)).prop_map(
            |(spelling, words, count)| {
                std::iter::once(spelling.to_owned())
                    .chain(words.into_iter().take(count))
                    .collect::<Vec<_>>()
                    .join(" ")
            },
        )
    })
}

/// Lines that set up something to work on, then any lines.
fn lines() -> impl Strategy<Value = Vec<String>> {
    let selecting = prop::sample::select(vec![
        "prm a",
        "prm b",
        "obj c",
        "obj 2nd",
        "ap a",
        "ap b x",
        "ao c",
        "ao 2nd y",
        "ap a z",
        "light a 1 2 3",
        "floor 1 a",
        "lightRadius a 2",
    ])
    .prop_map(str::to_owned);
    prop::collection::vec(prop_oneof![1 => selecting, 2 => line()], 0..60)
}

fn run(lines: &[String]) -> Timeline {
    let mut timeline = Timeline::default();
    for line in lines {
        // A line that does not fit the scene is refused, and that is right.
        let _ = timeline.run_line(line);
    }
    timeline
}

/// The part of a session that a load restores: scene and selection, not the settings.
fn loaded_part(session: &Session) -> Session {
    let mut loaded = session.clone();
    loaded.settings = Settings::default();
    loaded
}

proptest! {
    #![proptest_config(config(2000))]

    /// A written session, clean or as typed, loads to the same session without diagnostics. Saving
    /// and loading again gives the same text.
    #[test]
    fn loading_what_was_saved_gives_the_same(lines in lines()) {
        let timeline = run(&lines);
        let session = loaded_part(timeline.session());
        for text in [write_session(&session), timeline.typed_lines()] {
            let (loaded, diagnostics) = load_text("saved.scn", &text);
            prop_assert!(diagnostics.is_empty(), "{diagnostics:?}\n{text}");
            prop_assert_eq!(&loaded_part(&loaded), &session, "{}", text);
            let settled = write_session(&loaded);
            prop_assert_eq!(write_session(&load_text("again.scn", &settled).0), settled);
        }
    }

    /// With one key of a line the scene is, at any frame, what it is after that line.
    #[test]
    fn a_key_is_its_line_carried_out(
        lines in lines(), keyed in keyable_line(), frame in number(Range::Any), at in number(Range::Any)
    ) {
        let mut timeline = run(&lines);
        let _ = timeline.run_line("unkey all");
        let mut direct = timeline.session().clone();
        if timeline.run_line(&format!("key {} {keyed}", format_number(frame))).is_ok() {
            prop_assert_eq!(timeline.session().scene().tracks().len(), 1);
            let still = scene_at(timeline.session(), at);
            match direct.run_line(&keyed) {
                Ok(_) => prop_assert_eq!(still.as_ref(), Ok(direct.scene()), "{}", keyed),
                Err(_) => prop_assert!(still.is_err(), "{keyed}"),
            }
        }
    }

    /// At any frame there is a scene without keys, or a fault that says what to do; a scene that
    /// was saved and loaded has the same.
    #[test]
    fn stills_are_saved(lines in lines(), keys in prop::collection::vec((number(Range::Any), keyable_line()), 1..20), frame in number(Range::Any)) {
        let mut timeline = run(&lines);
        for (frame, line) in keys {
            let _ = timeline.run_line(&format!("key {} {line}", format_number(frame)));
        }
        let session = loaded_part(timeline.session());
        let still = scene_at(&session, frame);
        match &still {
            Ok(still) => prop_assert_eq!(still.tracks().len(), 0),
            Err(fault) => prop_assert!(fault.help.is_some() && fault.message.starts_with("at frame "), "{fault:?}"),
        }
        let (loaded, diagnostics) = load_text("saved.scn", &write_session(&session));
        prop_assert!(diagnostics.is_empty(), "{diagnostics:?}");
        prop_assert_eq!(&loaded_part(&loaded), &session);
        prop_assert_eq!(scene_at(&loaded, frame), still);
    }

    /// Every line of the table's making parses; a fault at carrying it out changes nothing and says
    /// where.
    #[test]
    fn lines_of_the_table_parse_and_faults_change_nothing(lines in lines(), last in line()) {
        let mut timeline = run(&lines);
        let before = timeline.session().clone();
        let parsed = parse_line(&last);
        prop_assert!(parsed.is_ok(), "{last}: {parsed:?}");
        match timeline.run_line(&last) {
            Ok(Effect::Changed(_)) => {}
            Ok(Effect::Done) => prop_assert_eq!(loaded_part(timeline.session()), loaded_part(&before)),
            Ok(_) => prop_assert_eq!(timeline.session(), &before),
            Err(fault) => {
                prop_assert!(fault.columns.is_some() && fault.help.is_some(), "{fault:?}");
                prop_assert_eq!(timeline.session(), &before);
            }
        }
    }

    /// Undo restores each earlier state, and redo each undone one.
    #[test]
    fn undo_and_redo_are_inverse(lines in lines(), steps in 1usize..20) {
        let mut timeline = run(&lines);
        let steps = steps.min(timeline.undo_count());
        let mut moments = vec![loaded_part(timeline.session())];
        for _ in 0..steps {
            timeline.run_line("undo").unwrap();
            moments.push(loaded_part(timeline.session()));
        }
        for moment in moments.iter().rev().skip(1) {
            timeline.run_line("redo").unwrap();
            prop_assert_eq!(&loaded_part(timeline.session()), moment);
        }
        if steps > 0 {
            timeline.run_line(&format!("undo {steps}")).unwrap();
            prop_assert_eq!(&loaded_part(timeline.session()), &moments[steps]);
        }
    }

    /// Typing any line letter by letter: no panic, and hints, paint and completion stay within it.
    #[test]
    fn any_line_can_be_typed(lines in lines(), typed in prop_oneof![line(), "\\PC{0,40}", "(load|save) \"[a-z \"#ü]{0,20}"]) {
        let timeline = run(&lines);
        let session = timeline.session();
        for at in (0..=typed.len()).filter(|&at| typed.is_char_boundary(at)) {
            let line = &typed[..at];
            let _ = hint(session, line);
            let mut last = 0;
            for (range, _) in highlight(session, line) {
                prop_assert!(range.start >= last && line.get(range.clone()).is_some(), "{line:?} {range:?}");
                last = range.end;
            }
            let completion = complete(session, &typed, at);
            prop_assert!(completion.start <= at && typed.is_char_boundary(completion.start), "{line:?}");
        }
    }

    /// Any text: no panic, and every fault has columns within the line.
    #[test]
    fn any_line_is_survived(lines in lines(), junk in "\\PC{0,60}|[ \\t#a-z0-9.eE+-]{0,60}") {
        let mut timeline = run(&lines);
        let before = timeline.session().clone();
        if let Err(fault) = timeline.run_line(&junk) {
            let columns = fault.columns.clone().expect("a place");
            prop_assert!(columns.start < columns.end && columns.end <= junk.chars().count(), "{fault:?}");
            prop_assert_eq!(timeline.session(), &before);
        }
    }
}

/// A number just out of its range is refused, for every number of every command.
#[test]
fn every_range_of_the_table_is_checked() {
    for spec in COMMANDS {
        let good: Vec<String> = spec.example.split_whitespace().map(str::to_owned).collect();
        for (i, arg) in spec.all_args().enumerate() {
            let ArgKind::Number(range) = arg.kind else { continue };
            let bad = match range {
                Range::Any => "1e400".to_owned(),
                Range::Positive | Range::NonZero => "0".to_owned(),
                Range::NonNegative | Range::Whole(..) => "-1e-9".to_owned(),
                Range::Within(_, most) | Range::Between(_, most) | Range::AboveTo(_, most) => {
                    (most + 1e-6).to_string()
                }
            };
            let mut words = good.clone();
            if words.len() <= i + 1 {
                continue;
            }
            words[i + 1] = bad;
            let fault = parse_line(&words.join(" ")).expect_err(&words.join(" "));
            assert!(
                fault.message.contains(arg.name) || fault.code.as_str() == "not-a-number",
                "{}: {}",
                spec.name,
                fault.message
            );
        }
    }
}

/// A command that needs a selection reports it, whatever else is selected.
#[test]
fn every_need_of_the_table_is_checked() {
    for spec in COMMANDS.iter().filter(|spec| spec.needs() != Needs::Nothing) {
        let other = if spec.needs() == Needs::Primitive { "obj o" } else { "prm p" };
        for setup in ["deselect", other] {
            let mut session = Session::default();
            session.run_line(setup).unwrap();
            assert_eq!(
                session.run_line(spec.example).unwrap_err().code.as_str(),
                "selection",
                "{} after {setup}",
                spec.name
            );
        }
    }
}
