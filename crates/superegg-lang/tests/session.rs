//! Single commands: what they change, and what they refuse.

use superegg_geom::glam::DVec3;

use superegg_lang::{Effect, Session, load_text, write_session};
use superegg_scene::Lens;

fn session(lines: &[&str]) -> Session {
    let mut session = Session::default();
    for line in lines {
        session.run_line(line).unwrap_or_else(|fault| panic!("{line}: {fault:?}"));
    }
    session
}

#[test]
fn a_fault_changes_nothing() {
    let before = session(&["prm ball", "obj o", "ap ball", "ss 1e-300 1 1"]);
    for (line, code) in [
        ("coeff 1 1 1", "selection"),
        ("primitive a\0b", "not-text"),
        ("ap ball a\0", "not-text"),
        ("# a comment\0", "not-text"),
        ("prm o", "wrong-kind"),
        ("obj ball", "wrong-kind"),
        ("ap ball", "alias-taken"),
        ("ap bal second", "unknown-name"),
        ("ao ball second", "wrong-kind"),
        ("cursor bal", "unknown-name"),
        ("rs 0 0 0 10", "transform"),
        ("ss 1e-100 1 1", "transform"),
        ("unlight lamp", "unknown-name"),
        ("camera 0 0 1 0 0 1", "no-direction"),
        ("cameraUp 0 0 -0", "no-direction"),
        ("spot lamp 1 2 3 1 2 3 40", "no-direction"),
        ("spot lamp -1e308 0 0 1e308 0 0 40", "no-direction"),
        ("sun noon 0 -0 0", "no-direction"),
        ("lightRadius lamp 1", "unknown-name"),
        ("sky 1 1 1 0 0 1 0 0 0", "no-direction"),
        ("floor 0 bal", "unknown-name"),
        ("floor 0 o", "wrong-kind"),
        ("floor 0 ball 0 0 0", "no-direction"),
        ("floorUp 0 0 1", "no-floor"),
        ("unfloor", "no-floor"),
        ("absorb 1 1 1", "selection"),
        ("help nonsense", "unknown-command"),
        ("delete nobody", "unknown-name"),
        ("rename ball o", "name-taken"),
        ("rename o o", "name-taken"),
        ("copy nobody x", "unknown-name"),
        ("copy ball ball", "name-taken"),
        ("remove bal", "unknown-name"),
        ("set size 0x5", "out-of-range"),
        ("set sizes 5x5", "unknown-setting"),
        ("get nothing", "unknown-setting"),
        ("stop rendr", "unknown-word"),
        ("save --histry x", "unknown-option"),
        ("info nobody", "unknown-name"),
    ] {
        let mut after = before.clone();
        let fault = after.run_line(line).unwrap_err();
        assert_eq!(fault.code.as_str(), code, "{line}: {}", fault.message);
        assert!(fault.help.is_some() && fault.columns.is_some(), "{line}");
        assert_eq!(after, before, "{line}");
    }
}

#[test]
fn a_pattern_takes_the_numbers_of_its_word() {
    let before = session(&["prm ball", "pattern checker 1 0 0"]);
    for (line, code, columns) in [
        ("pattern none 1 0 0", "argument-count", 8..18),
        ("pattern checker", "argument-count", 8..15),
        ("pattern checker 1 0 0 1 1 1", "argument-count", 8..27),
        ("pattern checker 1 0 0 -1", "out-of-range", 22..24),
        ("pattern gradient 1 0 0 2", "argument-count", 8..24),
        ("pattern gradient 1 0 0 0 0 0", "no-direction", 8..28),
        ("pattern stripes", "unknown-word", 8..15),
    ] {
        let mut after = before.clone();
        let fault = after.run_line(line).unwrap_err();
        assert_eq!((fault.code.as_str(), fault.columns), (code, Some(columns)), "{line}");
        assert_eq!(after, before, "{line}");
    }
}

#[test]
fn only_bumps_have_a_height() {
    let mut session = session(&["prm ball", "setTexture color a.png 2 box", "texture bump b.png"]);
    for line in ["texture color a.png 1 box 0.1", "texture Roughness a.png 1 around 0"] {
        let before = session.clone();
        let fault = session.run_line(line).unwrap_err();
        assert_eq!((fault.code.as_str(), fault.columns.unwrap().start), ("argument-count", 8), "{line}");
        assert_eq!(session, before, "{line}");
    }
    let saved = |session: &Session| {
        let text = write_session(session);
        assert_eq!(load_text("saved", &text).0, *session);
        text
    };
    assert!(saved(&session).contains("setTexture color \"a.png\" 2 box\n"));
    assert!(saved(&session).contains("setTexture bump \"b.png\" 1 around\n"));
    session.run_line("texture bump \"b c.png\" 0.5 box -0.25").unwrap();
    assert!(saved(&session).contains("setTexture bump \"b c.png\" 0.5 box -0.25\n"));
    session.run_line("texture bump none").unwrap();
    assert!(!saved(&session).contains("bump"));
}

#[test]
fn a_light_is_replaced_whole_and_a_camera_keeps_its_lens() {
    let mut session = session(&["light lamp 0 0 5", "lightRadius lamp 2", "lens 0.5", "ortho 4"]);
    assert_eq!(session.scene().light("lamp").unwrap().radius, 2.0);
    session.run_line("spot lamp 0 0 5 0 0 0 30").unwrap();
    assert_eq!(session.scene().light("lamp").unwrap().radius, 0.0);
    session.run_line("camera 0 0 3 0 0 0").unwrap();
    let camera = session.scene().camera;
    assert_eq!((camera.lens, camera.ortho_height), (Some(Lens { radius: 0.5, focus: 10.0 }), Some(4.0)));
    session.run_line("lens 0").unwrap();
    session.run_line("ortho -0").unwrap();
    assert_eq!((session.scene().camera.lens, session.scene().camera.ortho_height), (None, None));
}

#[test]
fn a_floor_follows_the_primitive_it_names() {
    let mut session = session(&["prm tile", "floor -1 tile 0 0 1", "rename tile slab"]);
    assert_eq!(session.scene().floor.as_ref().unwrap().surface.as_deref(), Some("slab"));
    let loaded = load_text("saved", &write_session(&session)).0;
    assert_eq!(loaded, session);
    session.run_line("delete slab").unwrap();
    let text = write_session(&session);
    assert!(text.contains("floor -1\nfloorUp 0 0 1\n"), "{text}");
    assert_eq!(load_text("saved", &text).0, session);
}

#[test]
fn the_cursor_is_the_objects_own_and_follows_what_is_added() {
    let session = session(&[
        "prm a", "prm b", "obj o", "ap a", "ap b", "obj p", "obj o", "xs 1 0 0", "cur a", "xs 0 2 0",
    ]);
    let object = session.scene().object("o").unwrap();
    let moved = |alias: &str| {
        let child = object.child(alias).unwrap();
        object.parent_from_child(child).unwrap().forward().transform_point3(DVec3::ZERO)
    };
    assert_eq!((moved("a"), moved("b")), (DVec3::Y * 2.0, DVec3::X));
    assert_eq!(object.cursor().unwrap().0, "a");
}

#[test]
fn an_object_may_hold_itself() {
    let session =
        session(&["prm a", "obj o", "ap a", "ao o again", "ss .5 .5 .5", "obj p", "ao o", "obj o", "ao p"]);
    assert_eq!(session.scene().object("o").unwrap().children().len(), 3);
}

#[test]
fn deleting_takes_the_children_along_and_renaming_leads_them() {
    let mut session =
        session(&["prm a", "prm b", "obj o", "ap a", "ap b", "ap a again", "ao o self", "ss .5 .5 .5"]);
    session.run_line("copy o p").unwrap();
    session.run_line("rename o q").unwrap();
    assert_eq!(session.selected(), Some("q"));
    let target = |object: &str, alias: &str| {
        session.scene().object(object).unwrap().child(alias).map(|child| child.target().to_owned())
    };
    assert_eq!((target("q", "self").unwrap(), target("p", "self").unwrap()), ("q".into(), "p".into()));
    let effect = session.run_line("delete a").unwrap();
    let Effect::Changed(Some(message)) = effect else { panic!("{effect:?}") };
    assert!(message.contains("4 children: q/a, q/again, p/a, p/again"), "{message}");
    let object = session.scene().object("q").unwrap();
    assert_eq!(object.children().map(|(alias, _)| alias).collect::<Vec<_>>(), ["b", "self"]);
    assert_eq!(object.cursor().unwrap().0, "self");
    session.run_line("remove self").unwrap();
    assert_eq!(session.scene().object("q").unwrap().cursor().unwrap().0, "b");
    session.run_line("remove b").unwrap();
    assert_eq!(session.run_line("xs 1 0 0").unwrap_err().code.as_str(), "no-child");
    session.run_line("delete q").unwrap();
    assert_eq!((session.selected(), session.scene().entities().len()), (None, 2));
}

#[test]
fn child_steps_come_before_overall_ones_in_the_order_written() {
    let session = session(&["prm a", "obj o", "sall 2 2 2", "ap a", "xs 1 0 0", "xall 0 0 5"]);
    let object = session.scene().object("o").unwrap();
    let transform = object.parent_from_child(object.child("a").unwrap()).unwrap();
    assert_eq!(transform.forward().transform_point3(DVec3::ZERO), DVec3::new(2.0, 0.0, 5.0));
}

#[test]
fn camera_keeps_its_up_direction() {
    let session = session(&["cameraUp 0 0 1", "camera 1 2 3 0 0 0 30", "camera 4 5 6 0 0 0"]);
    let camera = session.scene().camera;
    assert_eq!((camera.up, camera.fov_deg, camera.position.x), (DVec3::Z, 60.0, 4.0));
}

#[test]
fn the_name_of_a_setting_stands_for_set() {
    let mut session =
        session(&["prm a", "obj o", "ap a", "samples 9", "  exposure -1 # darker", "key 3 exposure 2"]);
    assert_eq!((session.scene().picture.samples, session.scene().picture.exposure), (9, -1.0));
    assert_eq!(session.scene().tracks().len(), 1);
    let Effect::Print(shown) = session.run_line("bounces").unwrap() else { panic!("it is shown") };
    assert!(shown.starts_with("bounces "), "{shown}");
    for (line, code, columns) in [
        ("samples 0", "out-of-range", 8..9),
        (" samples 1 2", "argument-count", 11..12),
        ("key 3 exposure x", "not-keyable", 15..16),
        ("sampels 3", "unknown-command", 0..7),
    ] {
        let fault = session.run_line(line).unwrap_err();
        assert_eq!(
            (fault.code.as_str(), fault.columns.clone()),
            (code, Some(columns)),
            "{line}: {}",
            fault.message
        );
    }
}

#[test]
fn an_axis_stands_for_three_numbers() {
    let by_word = session(&["prm a", "obj o", "ap a", "rotate x 90", "rotateAll -z 45", "key 2 rotate y 10"]);
    let by_numbers = session(&[
        "prm a",
        "obj o",
        "ap a",
        "rotate 1 0 0 90",
        "rotateAll 0 0 -1 45",
        "key 2 rotate 0 1 0 10",
    ]);
    assert_eq!(by_word, by_numbers);
    let mut session = by_word;
    let fault = session.run_line("rotate x").unwrap_err();
    assert_eq!(fault.help.as_deref(), Some("'x' alone stands for three numbers; missing: degrees"));
}

#[test]
fn light_of_bytes_is_taken_and_noted() {
    let mut session = session(&[]);
    for (line, word) in [
        ("background 255 128 0", Some("#ff8000")),
        ("light lamp 1 2 3 255 255 255", Some("#ffffff")),
        ("sky 0.1 0.2 0.3 16 0 0", Some("#100000")),
        ("sun noon 0 0 1 20 20.5 20", None),
        ("background 1 1 1", None),
        ("background #ff8000", None),
        ("background 300 0 0", None),
    ] {
        let Effect::Changed(note) = session.run_line(line).unwrap() else { panic!("{line}") };
        assert_eq!(note.is_some(), word.is_some(), "{line}: {note:?}");
        assert!(word.is_none_or(|word| note.unwrap().ends_with(word)), "{line}");
    }
}

#[test]
fn a_zero_byte_is_a_fault_at_its_column() {
    let fault = superegg_lang::parse_line("primitive \u{e4}\0b").unwrap_err();
    assert_eq!((fault.code.as_str(), fault.columns), ("not-text", Some(11..12)));
    let (session, diagnostics) = load_text("a.scn", "primitive ball\nprimitive a\0b\n");
    assert_eq!((diagnostics.len(), diagnostics[0].line), (1, Some(2)));
    // The written scene can be read again.
    let (_, diagnostics) = load_text("a.scn", &write_session(&session));
    assert!(diagnostics.is_empty(), "{diagnostics:?}");
}
