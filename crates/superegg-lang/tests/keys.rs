//! Keys of commands, and the scene at a frame.

use superegg_geom::glam::DVec3;

use superegg_lang::{Effect, Session, load_text, scene_at, write_session};
use superegg_scene::Track;

const ARM: [&str; 7] =
    ["prm ball", "obj arm", "ap ball hand", "xs 1 0 0", "ap ball elbow", "cursor hand", "prm other"];

fn session(lines: &[&str]) -> Session {
    let mut session = Session::default();
    for line in ARM.iter().chain(lines) {
        session.run_line(line).unwrap_or_else(|fault| panic!("{line}: {fault:?}"));
    }
    session
}

fn hand_position(session: &Session, frame: f64) -> DVec3 {
    let scene = scene_at(session, frame).unwrap();
    let arm = scene.object("arm").unwrap();
    let hand = arm.parent_from_child(arm.child("hand").unwrap()).unwrap();
    hand.forward().transform_point3(DVec3::ZERO)
}

#[test]
fn a_hand_turns_while_something_else_is_selected() {
    let session =
        session(&["obj arm", "key 48 rotate 0 0 1 90", "key 0 rs 0 0 1 0", "cur elbow", "deselect"]);
    for (frame, angle_deg) in [(-7.0, 0.0f64), (0.0, 0.0), (24.0, 45.0), (48.0, 90.0), (1e9, 90.0)] {
        let (sin, cos) = angle_deg.to_radians().sin_cos();
        let position = hand_position(&session, frame);
        assert!((position - DVec3::new(cos, sin, 0.0)).length() < 1e-12, "{frame}: {position}");
    }
    let still = scene_at(&session, 24.0).unwrap();
    assert_eq!(still.object("arm").unwrap().cursor().unwrap().0, "elbow");
    let text = write_session(&session);
    assert!(text.contains("key 0 rotate 0 0 1 0\nkey 48 rotate 0 0 1 90\nsetCursor elbow\n"), "{text}");
    assert_eq!(load_text("saved", &text).0, session);
}

#[test]
fn tracks_are_text_apart_and_are_carried_out_in_the_order_they_began() {
    let session = session(&[
        "light lamp 0 0 5",
        "key 0 light lamp 0 0 5",
        "key 0 lightRadius lamp 1",
        "key 10 light lamp 10 0 5",
        "key 10 lightRadius lamp 3",
        "key 0 set exposure 0",
        "key 10 set EXPOSURE 2",
        "key 0 set samples 1",
        "key 10 set samples 4",
        "key 0 pattern checker 1 0 0 1",
    ]);
    assert_eq!(session.scene().tracks().len(), 5);
    let scene = scene_at(&session, 5.0).unwrap();
    let lamp = scene.light("lamp").unwrap();
    // In the other order the light would be a new one, with radius 0.
    assert_eq!((lamp.position(), lamp.radius), (Some(DVec3::new(5.0, 0.0, 5.0)), 2.0));
    // Samples are whole: 2.5 is rounded.
    assert_eq!((scene.picture.exposure, scene.picture.samples), (1.0, 3));
    let text = session.describe(&[]).unwrap();
    assert!(text.contains("keys (9)\n  light lamp: frames 0, 10\n"), "{text}");
    assert!(text.contains("\n  setPattern checker of other: frame 0"), "{text}");
    let text = session.describe(&["other".into()]).unwrap();
    assert!(text.ends_with("\n  key 0 setPattern checker 1 0 0 1"), "{text}");
}

#[test]
fn keys_follow_what_they_are_of() {
    let mut session = session(&[
        "floor 0 other",
        "key 0 floor 1 other",
        "key 0 floorUp 0 0 1",
        "key 0 color 1 0 0",
        "light lamp 0 0 5",
        "key 0 spot lamp 0 0 5 0 0 0 30",
        "key 0 sky 1 1 1",
        "obj arm",
        "key 0 rotate 0 0 1 0",
        "key 0 rotateAll 0 0 1 0",
    ]);
    let tracks = |session: &Session| session.scene().tracks().len();
    let mut after = |line: &str| {
        session.run_line(line).unwrap();
        let loaded = load_text("saved", &write_session(&session));
        assert_eq!((&loaded.0, loaded.1.len()), (&session, 0), "{line}");
        tracks(&session)
    };
    assert_eq!([after("rename arm limb"), after("rename other tile")], [7, 7]);
    assert_eq!([after("cursor elbow"), after("remove elbow"), after("remove hand")], [7, 7, 6]);
    assert_eq!([after("unlight lamp"), after("unsky")].len(), 2);
    // Its colour, and the floor that has its surface.
    assert_eq!([after("delete tile"), after("unfloor"), after("delete limb")], [2, 1, 0]);
}

#[test]
fn keys_are_taken_away_by_frame_and_by_command() {
    let mut session = session(&[
        "key 0 color 1 0 0",
        "key 5 color 0 1 0",
        "key 5 background 1 1 1",
        "obj arm",
        "key 5 rs 0 0 1 2",
    ]);
    let text = session.run_line("unkey 5 rotate").unwrap();
    assert_eq!(text, Effect::Changed(Some("1 key removed".into())));
    // The colour is that of another.
    assert_eq!(session.run_line("unkey 5 color").unwrap_err().code.as_str(), "no-key");
    session.run_line("unkey 5").unwrap();
    let frames = |session: &Session| {
        session.scene().tracks().flat_map(Track::keys).map(|key| key.frame).collect::<Vec<_>>()
    };
    assert_eq!(frames(&session), [0.0]);
    session.run_line("unkey ALL").unwrap();
    assert_eq!(session.scene().tracks().len(), 0);
}

#[test]
fn faults_of_a_key_are_those_of_its_line_in_their_place() {
    let before = session(&["obj arm", "key 0 light lamp 0 0 5", "key 9 light lamp 0 0 5"]);
    for (line, code, columns) in [
        ("key", "argument-count", 0..3),
        ("key 5", "argument-count", 0..5),
        ("key x rotate 0 0 1 0", "not-a-number", 4..5),
        ("key 5 rotat 0 0 1 0", "unknown-command", 6..11),
        ("key 5 rotate 0 0 1", "argument-count", 6..18),
        ("key 5 rotate 0 0 0 1", "transform", 13..20),
        ("key 5 scale 1 0 1", "out-of-range", 14..15),
        ("key 5 color 1 0 0", "selection", 6..11),
        ("key 5 lightRadius lmp 2", "unknown-name", 18..21),
        ("key 5 floorUp 0 0 1", "no-floor", 6..13),
        ("key 5 floor 0 bal", "unknown-name", 14..17),
        ("key 5 camera 0 0 0 0 0 0", "no-direction", 13..24),
        ("key 5 delete arm", "not-keyable", 6..12),
        ("key 5 key 6 rotate 0 0 1 0", "not-keyable", 6..9),
        ("key 5 ao arm again", "not-keyable", 6..8),
        ("key 5 set size 64x48", "not-keyable", 15..20),
        ("key 5 set threads 2", "not-keyable", 18..19),
        ("key 5 set exposure 99", "out-of-range", 19..21),
        ("key 5 set exposure", "not-keyable", 6..9),
        ("key 5 light lamp 0 0 5 1 1 1", "key-numbers", 12..28),
        ("unkey 7", "no-key", 6..7),
        ("unkey soon", "not-a-number", 6..10),
        ("unkey 0 rotat", "unknown-command", 8..13),
    ] {
        let mut after = before.clone();
        let fault = after.run_line(line).unwrap_err();
        assert_eq!(
            (fault.code.as_str(), fault.columns.clone()),
            (code, Some(columns)),
            "{line}: {}",
            fault.message
        );
        assert!(fault.help.is_some() && after == before, "{line}");
    }
}

#[test]
fn a_key_without_the_number_that_may_be_left_out_asks_for_it() {
    for (line, usage) in [
        ("key 3 setTexture color t.png", "setTexture color|roughness|bump"),
        ("key 3 environment f.hdr", "environment FILE"),
        ("key 3 set exposure", "set SETTING"),
    ] {
        let mut session = session(&["prm ball"]);
        let fault = session.run_line(line).unwrap_err();
        assert!(fault.message.contains("needs a number"), "{line}: {}", fault.message);
        assert!(fault.help.as_deref().is_some_and(|help| help.contains(usage)), "{line}: {:?}", fault.help);
    }
}

#[test]
fn a_frame_that_cannot_be_says_which_and_why() {
    let session = session(&["obj arm", "key 0 scale 1 1 -1", "key 10 scale 1 1 1"]);
    assert!(scene_at(&session, 4.0).is_ok());
    let fault = scene_at(&session, 5.0).unwrap_err();
    assert_eq!(fault.code.as_str(), "out-of-range");
    assert!(fault.message.starts_with("at frame 5 'scale 1 1 0' cannot be: "), "{}", fault.message);
}

#[test]
fn keys_follow_a_child_to_its_new_alias() {
    let (mut session, _) =
        load_text("s", "prm a\nobj o\nap a left\nap a right\nkey 0 translate 0 0 0\nkey 4 translate 4 0 0\n");
    for line in ["renameChild right east", "hide left", "hide"] {
        session.run_line(line).unwrap();
    }
    let text = write_session(&session);
    assert_eq!(load_text("s", &text).0, session, "{text}");
    let moved = |session: &Session| {
        let still = scene_at(session, 4.0).unwrap();
        let object = still.object("o").unwrap();
        (object.child("east").unwrap().steps().count(), object.hidden_count())
    };
    assert_eq!(moved(&session), (1, 2));
    assert_eq!(
        session.run_line("renameChild east left").unwrap_err().to_string(),
        "'o' has a child 'left' already"
    );
    for (line, command) in [("rename east west", "renameChild"), ("delete east", "remove")] {
        let fault = session.run_line(line).unwrap_err();
        assert!(fault.help.is_some_and(|help| help.contains(command)), "{line}");
    }
    session.run_line("unhide").unwrap();
    session.run_line("remove left").unwrap();
    assert_eq!(moved(&session), (1, 0));
}

#[test]
fn keys_of_files_with_blanks_are_saved_in_quotes() {
    let lines = [
        "primitive ball",
        "key 1 setTexture bump \"old walls/a b.png\" 1 around 0.1",
        "key 9 setTexture bump \"old walls/a b.png\" 1 around 0.9",
        "key 1 environment \"a #sky.hdr\" 0 1",
        "key 9 environment plain.hdr 90 1",
    ];
    let mut session = Session::default();
    for line in lines {
        assert!(session.run_line(line).is_ok(), "{line}");
    }
    let text = write_session(&session);
    assert!(text.contains("key 9 setTexture bump \"old walls/a b.png\" 1 around 0.9"), "{text}");
    let (read, diagnostics) = load_text("saved.scn", &text);
    assert!(diagnostics.is_empty(), "{diagnostics:?}");
    assert_eq!(write_session(&read), text);
}

#[test]
fn sky_sun_has_keys() {
    let (session, diagnostics) = load_text("day.scn", "key 0 sky sun 10 3 60\nkey 10 sky sun 30 3 80\n");
    assert!(diagnostics.is_empty(), "{diagnostics:?}");
    assert!(write_session(&session).contains("key 10 daylight 30 3 80"), "{}", write_session(&session));
}
