//! Scene files, with the files and the names in them.

use std::fs;

use superegg::prelude::*;

/// A folder with a picture, a scene that has it on a sphere, and a scene in another folder that includes that one.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("parts")).unwrap();
    image::RgbImage::from_pixel(2, 2, image::Rgb([255, 0, 0]))
        .save(folder.path().join("parts/red.png"))
        .unwrap();
    fs::write(folder.path().join("parts/ball.scn"), "primitive ball\nsetTexture color red.png\n").unwrap();
    let scene = "include parts/ball.scn\nobject all\naddPrimitive ball\n";
    fs::write(folder.path().join("scene.scn"), scene).unwrap();
    folder
}

#[test]
fn included_files_and_textures_are_in_the_picture() {
    let folder = folder();
    let model = Model::load(folder.path().join("scene.scn")).unwrap();
    assert_eq!((model.root(), model.compile().instance_count().to_string().as_str()), (Some("all"), "1"));
    let png = model.render(9, 9).unwrap().to_png().unwrap();
    let [r, g, _] = image::load_from_memory(&png).unwrap().to_rgb8().get_pixel(4, 4).0;
    assert!(r > 100 && g < 60, "{r} {g}");
}

#[test]
fn files_that_cannot_be_read_are_errors_with_their_line() {
    let folder = folder();
    let scene = folder.path().join("scene.scn");
    for (text, expected) in [
        ("include none.scn\n", "scene.scn:1:1: error[unreadable]: cannot read 'none.scn'"),
        (
            "primitive a\ninclude scene.scn\n",
            "scene.scn:2:1: error[source-circle]: 'scene.scn' would be read within itself",
        ),
        (
            "include parts/wrong.scn\n",
            "wrong.scn:1:1: error[unknown-command]: there is no command 'primtive'",
        ),
    ] {
        fs::write(folder.path().join("parts/wrong.scn"), "primtive a\n").unwrap();
        fs::write(&scene, text).unwrap();
        let error = Model::load(&scene).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    }
    let error = Model::from_text("text", "include parts/ball.scn\n").unwrap_err().to_string();
    assert!(error.contains("text:1:1: error[not-here]: a text cannot read other files"), "{error}");

    fs::write(&scene, "primitive a\nsetTexture color scene.scn\n").unwrap();
    let error = Model::load(&scene).unwrap().render(4, 4).unwrap_err().to_string();
    assert!(error.contains("scene.scn' cannot be a texture: "), "{error}");
}

#[test]
fn names_that_a_scene_file_cannot_hold_are_errors() {
    let mut model = Model::new();
    let ball = || Part::new(Superquadric::unit_sphere());
    for name in ["a b", "", "#a", "a;b\nundo", "a\0"] {
        assert!(
            matches!(model.add(ball().named(name)), Err(Error::Name(wrong)) if wrong == name),
            "{name:?}"
        );
        assert!(matches!(model.add_to(name, ball()), Err(Error::Name(_))), "{name:?}");
    }
    assert_eq!(model, Model::new());
    model.add(ball().named("größe_1")).unwrap();
    assert_eq!(Model::from_text("scene.scn", &model.to_text()).unwrap(), model);
}
