//! Laws of colours, transforms by numbers, and included scenes.

use superegg_lang::{Session, load_text, parse_color, scene_at, write_session};

fn session(text: &str) -> Session {
    let (session, diagnostics) = load_text("t.scn", text);
    assert!(diagnostics.is_empty(), "{text}\n{diagnostics:?}");
    session
}

/// `text` with `added` included at its end.
fn included(text: &str, added: &str) -> Result<Session, String> {
    let mut own = session(text);
    let lines = own.lines_to_include(&session(added)).map_err(|fault| fault.message)?;
    for line in lines.lines() {
        own.run_line(line).unwrap_or_else(|fault| panic!("{line}: {fault}\n{lines}"));
    }
    Ok(own)
}

#[test]
fn an_included_scene_is_what_its_lines_would_make() {
    let own = "prm a\ncoeff 1 2 3\nobj o\nap a\nlight l 1 2 3\n";
    let added = "prm b\nexp 0 0\nobj p\nap b\norient 1 0.5 0 0\nobj q\nao p\nao q\nmatrix 1 0 0 2 0 1 0 0 0 .5 1 0\n\
        light m 3 2 1\nkey 3 light m 1 2 3\nobj p\nkey 4 rotate 0 0 1 30\n";
    let mut expected = session(&format!("{own}{added}"));
    expected.run_line("obj o").unwrap();
    assert_eq!(included(own, added).unwrap(), expected);
    // Twice is once.
    let twice = included(&write_session(&expected), added).unwrap();
    assert_eq!(twice, expected);
}

#[test]
fn settings_count_where_the_scene_has_none() {
    let added = "up z\ncamera 1 2 3 0 0 0\nbackground red\nsky white\nfloor -2\nset samples 9\nset exposure 1\nprm b\n";
    let scene = included("prm a\n", added).unwrap().scene().clone();
    let alone = session(added).scene().clone();
    assert_eq!((scene.camera, scene.up(), scene.sky), (alone.camera, alone.up(), alone.sky));
    assert_eq!((scene.floor.clone(), scene.picture), (alone.floor.clone(), alone.picture));
    let own = "camera 5 5 5 0 0 0\nfloor 7\nset samples 2\nbackground blue\nsky 1 2 3\n";
    let scene = included(own, added).unwrap().scene().clone();
    let before = session(own).scene().clone();
    assert_eq!((scene.camera, scene.up(), scene.sky), (before.camera, before.up(), before.sky));
    assert_eq!((scene.floor.clone(), scene.background), (before.floor.clone(), before.background));
    assert_eq!((scene.picture.samples, scene.picture.exposure), (2, 1.0));
}

#[test]
fn different_things_of_one_name_are_refused() {
    for (own, added, name) in [
        ("prm a\n", "prm a\ncoeff 2 2 2\n", "'a'"),
        ("prm a\n", "obj a\n", "'a'"),
        ("prm a\nobj o\nap a\n", "prm a\nobj o\n", "'o'"),
        ("light a 1 2 3\n", "light a 1 2 4\n", "'a'"),
        ("prm a\nkey 1 coeff 1 2 3\n", "prm a\n", "'a'"),
    ] {
        let error = included(own, added).unwrap_err();
        assert!(error.contains(name), "{error}");
    }
}

#[test]
fn colours_in_one_word_are_three_numbers_wherever_a_colour_is() {
    let numbers =
        |word: &str| parse_color(word).unwrap().to_array().map(superegg_lang::format_number).join(" ");
    for (line, plain) in [
        ("prm p\ncolor #ff8000 # a comment", "prm p\ncolor @"),
        ("background tomato", "background @"),
        ("light l 1 2 3 #f80 0.5", "light l 1 2 3 @ 0.5"),
        ("sun l 1 2 3 #ff8000# glued", "sun l 1 2 3 @"),
        ("spot s 0 6 0 0 0 0 40 #ff8000 0.01 0.3", "spot s 0 6 0 0 0 0 40 @ 0.01 0.3"),
        ("sky #f80 #ff8000 z", "sky @ @ 0 0 1"),
        ("prm p\npattern checker orange 0.25", "prm p\npattern checker @ 0.25"),
        ("prm p\npattern gradient #ff8000", "prm p\npattern gradient @"),
    ] {
        let words: Vec<&str> = line
            .split_whitespace()
            .filter_map(|word| {
                let word = word.strip_suffix('#').unwrap_or(word);
                parse_color(word).map(|_| word)
            })
            .collect();
        let mut expected = plain.to_owned();
        for word in words {
            expected = expected.replacen('@', &numbers(word), 1);
        }
        assert_eq!(session(line), session(&expected), "{line}");
    }
    let keyed = session("prm p\nkey 0 setColor #000\nkey 10 setColor white\n");
    let scene = scene_at(&keyed, 10.0).unwrap();
    assert_eq!(scene.primitive("p").unwrap().material.color.to_array(), [1.0; 3]);
}

#[test]
fn a_comment_stays_one_where_no_colour_is_needed() {
    for (line, plain) in [
        ("prm p\ncolor 1 0 0 #f80", "prm p\ncolor 1 0 0"),
        ("light l 1 2 3 #fading away", "light l 1 2 3"),
        ("light l 1 2 3 #add more", "light l 1 2 3"),
        ("prm p #f80", "prm p"),
        ("prm p\ncoeff 1 2 3 #fff", "prm p\ncoeff 1 2 3"),
    ] {
        assert_eq!(session(line), session(plain), "{line}");
    }
}

#[test]
fn up_is_the_direction_of_camera_sky_and_floor() {
    let once = session("sky white\nfloor 0\nup z\n");
    let first = session("up 0 0 1\nsky white\nfloor 0\n");
    let apart = session("sky white\nfloor 0\ncameraUp z\nfloorUp z\nsky white white z\n");
    assert_eq!(once, first);
    let (a, b) = (once.scene(), apart.scene());
    assert_eq!((a.camera, a.sky, a.floor.clone()), (b.camera, b.sky, b.floor.clone()));
    for text in ["up z\n", "up z\nfloor 0\nfloorUp y\ncameraUp x\n", "up -x\nsky red\ncamera 0 0 10 0 0 0\n"]
    {
        let scene = session(text);
        assert_eq!(session(&write_session(&scene)), scene, "{}", write_session(&scene));
    }
}
