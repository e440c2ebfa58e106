//! The drawing module without a window, on any Vulkan or OpenGL driver; software suffices. Without
//! a driver the tests print so and pass.

// A skipped test prints its reason.
#![allow(clippy::print_stderr, clippy::print_stdout)]

use image::{Rgba, RgbaImage};
use superegg_geom::glam::{DVec2, DVec3};
use superegg_lang::Session;
use superegg_render::View;
use superegg_scene::{Light, Scene, Shading};
use superegg_trace::CompiledScene;
use superegg_viewer::Eye;
use superegg_viewer::draw::{Drawing, Gpu, Line, Mark, Picture, SHADERS, Selected, Style};
use superegg_viewer::preview::{Preview, PreviewBudget, SceneIndex};

#[test]
fn shaders_are_valid() {
    let module = naga::front::wgsl::parse_str(SHADERS)
        .unwrap_or_else(|error| panic!("{}", error.emit_to_string(SHADERS)));
    let mut validator =
        naga::valid::Validator::new(naga::valid::ValidationFlags::all(), naga::valid::Capabilities::empty());
    validator.validate(&module).unwrap_or_else(|error| panic!("{}", error.emit_to_string(SHADERS)));
}

/// A drawing module. Without a driver it prints the reason and returns `None`.
fn drawing() -> Option<Drawing> {
    match Gpu::headless() {
        Ok(gpu) => Some(Drawing::for_images(&gpu)),
        Err(error) => {
            eprintln!("skipped: {error}");
            None
        }
    }
}

const SIZE: (u32, u32) = (240, 200);
const SOLID: Style = Style::Solid(Shading::Phong);

fn session(lines: &str) -> Session {
    let mut session = Session::default();
    for line in lines.split(';') {
        session.run_line(line.trim()).unwrap_or_else(|fault| panic!("{line}: {fault:?}"));
    }
    session
}

fn open(session: &Session) -> Preview {
    let budget = PreviewBudget { instances: 100_000, height_px: SIZE.1 };
    SceneIndex::new(session.scene()).open(session.selected(), &session.scene().camera, &budget)
}

fn picture<'a>(scene: &'a Scene, preview: &'a Preview, lights: &'a [Light], style: Style) -> Picture<'a> {
    Picture { style, ..Picture::of(scene, preview, lights) }
}

fn draw(drawing: &mut Drawing, lines: &str, style: Style) -> RgbaImage {
    draw_as(drawing, lines, style, false)
}

fn draw_as(drawing: &mut Drawing, lines: &str, style: Style, is_course: bool) -> RgbaImage {
    let session = session(lines);
    let (preview, lights) = (open(&session), session.scene().lights());
    let picture = Picture { is_course, ..picture(session.scene(), &preview, &lights, style) };
    drawing.draw_to_image(&picture, SIZE).unwrap().0
}

/// The fraction of pixels that differ by more than 8 in some channel.
fn difference(a: &RgbaImage, b: &RgbaImage) -> f64 {
    let far = |(a, b): (&Rgba<u8>, &Rgba<u8>)| a.0.iter().zip(b.0).any(|(x, y)| x.abs_diff(y) > 8);
    a.pixels().zip(b.pixels()).filter(|pair| far(*pair)).count() as f64 / f64::from(a.width() * a.height())
}

/// The silhouette by the preview: everything in ambient white before black.
fn silhouette(
    drawing: &mut Drawing,
    session: &Session,
    camera: superegg_scene::Camera,
    size: (u32, u32),
) -> Vec<bool> {
    let mut preview = open(session);
    for shape in &mut preview.shapes {
        shape.material.color = DVec3::ONE;
        shape.material.ambient = 1.0;
    }
    let picture =
        Picture { camera, background: DVec3::ZERO, ..picture(session.scene(), &preview, &[], SOLID) };
    let (image, stats) = drawing.draw_to_image(&picture, size).unwrap();
    assert_eq!(stats.coarser, 0);
    image.pixels().map(|pixel| pixel.0[0] > 127).collect()
}

/// The silhouette by a ray through the centre of each pixel.
fn traced_silhouette(session: &Session, camera: superegg_scene::Camera, size: (u32, u32)) -> Vec<bool> {
    let scene = session.scene();
    let compiled = CompiledScene::compile(scene, session.selected(), scene.depth);
    let view = View::new(&camera, size.0, size.1);
    let pixels = (0..size.1).flat_map(|y| (0..size.0).map(move |x| (x, y)));
    pixels
        .map(|(x, y)| {
            let ray = view.ray(DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5));
            compiled.intersect_ray(&ray).is_some()
        })
        .collect()
}

/// The number of pixels that differ, and of blocks of two by two pixels that differ as a whole:
/// there the difference is wider than a pixel.
fn disagreement(a: &[bool], b: &[bool], (width, height): (u32, u32)) -> (usize, usize) {
    let differs = |x: u32, y: u32| a[(y * width + x) as usize] != b[(y * width + x) as usize];
    let is_wide = |x, y| differs(x, y) && differs(x + 1, y) && differs(x, y + 1) && differs(x + 1, y + 1);
    let count = |width, height, holds: &dyn Fn(u32, u32) -> bool| {
        (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).filter(|(x, y)| holds(*x, *y)).count()
    };
    (count(width, height, &differs), count(width - 1, height - 1, &is_wide))
}

const SCENES: &[(&str, &str)] = &[
    ("ball", "prm a; coeff 3 2 1"),
    ("cube", "prm a; coeff 2 2 2; exp .0001 .0001; obj o; ap a; rs 1 2 3 50"),
    ("octahedron", "prm a; coeff 2 2 2; exp 2 2; obj o; ap a; rs 3 1 1 35"),
    (
        "pillow and cylinder",
        "prm a; exp .3 .6; prm b; exp 1 .0001; obj o; ap a; ss 2 2 1; xs -1 0 0; ap b; rs 1 0 0 70; xs 2 0 0",
    ),
    ("star", "prm a; coeff 3 3 3; exp 3 3; obj o; ap a; rs 1 1 0 40"),
    (
        "mirrored, sheared, nested",
        "prm a; exp .5 1.5; obj o; ap a; ss -1 2 1; rs 1 1 1 40; obj p; ao o; ss 2 1 .5; ao o two; ss 1 1 3; rs 0 1 0 80; xs 2 1 -3",
    ),
    (
        "self-reference",
        "depth 6; prm a; obj o; ap a; ao o up; ss .6 .6 .6; rs 0 0 1 40; xs 1 1.2 0; ao o right; ss .6 .6 .6; xs 1.4 -.6 0",
    ),
];

#[test]
fn silhouettes_equal_those_of_the_ray_tracer() {
    let Some(mut drawing) = drawing() else { return };
    let size = (300, 260);
    for (name, lines) in SCENES {
        let session = session(lines);
        let mut eye = Eye::new(&session.scene().camera);
        for point in [DVec2::ZERO, DVec2::new(0.3, 0.2), DVec2::new(-0.5, 0.1)] {
            eye.press(DVec2::ZERO);
            eye.drag(point);
            eye.release();
            let camera = eye.camera();
            let drawn = silhouette(&mut drawing, &session, camera, size);
            let traced = traced_silhouette(&session, camera, size);
            let covered = traced.iter().filter(|hit| **hit).count();
            assert!(covered > 500, "{name}: {covered} pixels");
            let (differing, wide) = disagreement(&drawn, &traced, size);
            let share = differing as f64 / drawn.len() as f64;
            println!(
                "{name}: {:.3} % of the pixels differ, wider than a pixel at {wide} positions",
                100.0 * share
            );
            assert!(
                wide == 0 && share < 0.004,
                "{name}: {share} differ, {wide} positions wider than a pixel"
            );
        }
    }
}

#[test]
fn shading_is_per_pixel_or_per_vertex() {
    let Some(mut drawing) = drawing() else { return };
    let coarse = "prm a; coeff 4 4 4; patch 6 5; gloss .15; specular .9";
    let (phong, gouraud) = (
        draw_as(&mut drawing, coarse, SOLID, true),
        draw_as(&mut drawing, coarse, Style::Solid(Shading::Gouraud), true),
    );
    assert!(difference(&phong, &gouraud) > 0.1, "{}", difference(&phong, &gouraud));
    // Only shading per pixel shows a highlight between the vertices.
    let brightest = |image: &RgbaImage| image.pixels().map(|pixel| pixel.0[0]).max().unwrap();
    assert!(brightest(&phong) > brightest(&gouraud));
    // With patches of the size of pixels there is no difference.
    let fine = "prm a; coeff 4 4 4; patch 300 300; gloss .4; specular .5";
    let (phong, gouraud) = (
        draw_as(&mut drawing, fine, SOLID, true),
        draw_as(&mut drawing, fine, Style::Solid(Shading::Gouraud), true),
    );
    assert!(difference(&phong, &gouraud) < 0.01, "{}", difference(&phong, &gouraud));
}

#[test]
fn light_equals_that_of_the_ray_tracer_without_shadows() {
    let Some(mut drawing) = drawing() else { return };
    for light in [
        "set threads 0",
        "spot s 3 4 8 0 0 0 30 1 1 1 0.01 0.5",
        "spot s -1 0 8 0 1 0 40 1 1 1 0 0; light l 4 0 5 .2 .2 .4",
        "sun s 1 2 3 1 .9 .8",
    ] {
        let lines =
            format!("prm a; coeff 3 3 3; patch 200 200; color .9 .4 .2; specular .4; gloss .4; {light}");
        let drawn = draw(&mut drawing, &lines, SOLID);
        let apart = difference(&drawn, &traced(&session(&lines)));
        assert!(apart < 0.005, "{light}: {apart}");
    }
}

/// The picture of a scene by the ray tracer, one ray per pixel.
fn traced(session: &Session) -> RgbaImage {
    let compiled = CompiledScene::compile(session.scene(), session.selected(), session.scene().depth);
    let picture =
        superegg_scene::Picture { width: SIZE.0, height: SIZE.1, samples: 1, ..session.scene().picture };
    let settings = superegg_render::RenderSettings::of(session.scene()).with_picture(picture);
    let options = superegg_render::RenderOptions::default().with_threads(2);
    let film = superegg_render::render(&compiled, &settings, &options).unwrap().film;
    let bytes: Vec<u8> = superegg_render::Development::of(&settings.picture)
        .rgb8(&film)
        .chunks(3)
        .flat_map(|rgb| [rgb[0], rgb[1], rgb[2], 255])
        .collect();
    RgbaImage::from_raw(SIZE.0, SIZE.1, bytes).unwrap()
}

/// A picture by the preview and by the ray tracer agree but for shadows and small differences at
/// edges.
#[test]
fn floor_sky_patterns_exposure_and_tone_are_those_of_the_ray_tracer() {
    let Some(mut drawing) = drawing() else { return };
    let sun = "sun s 0.2 1 0.3; light l 300 400 500 .3 .3 .2";
    for (what, lines) in [
        ("sky", "camera 0 1 9 0 2 0; sky .8 .7 .6 .1 .2 .6; prm a"),
        ("sky of any direction", "camera 0 1 9 0 2 0; sky .8 .7 .6 .1 .2 .6 1 0 1; prm a"),
        (
            "floor",
            "camera 0 3 9 0 0 0; prm t; color .7 .4 .2; pattern checker .1 .1 .3 .7; prm a; coeff .1 .1 .1; floor -1 t",
        ),
        (
            "floor with a gradient",
            "camera 4 3 9 0 0 0; prm t; pattern gradient .1 .1 .3 1 .4 0; prm a; coeff .1 .1 .1; floor -1 t; floorUp .1 1 .2",
        ),
        ("checker", "prm a; coeff 3 2 3; exp .5 .7; color .9 .8 .3; pattern checker .1 .2 .6 .8"),
        ("gradient", "prm a; coeff 3 2 3; exp .5 1.4; pattern gradient .9 .1 0 1 2 0"),
        ("exposure", "set exposure -1.5; prm a; coeff 3 3 3; background .4 .4 .1"),
        ("reinhard", "set exposure 2; set tone reinhard; prm a; coeff 3 3 3; background .4 .4 .1"),
        ("filmic", "set exposure 1; set tone filmic; prm a; coeff 3 3 3; sky .4 .4 .1 1 2 3"),
        ("parallel rays", "orthographic 8; prm a; coeff 3 3 3; exp .3 .6"),
        (
            "parallel rays on a floor",
            "camera 0 4 9 0 0 0; ortho 8; sky .8 .7 .6; prm t; pattern checker .1 .1 .3 .7; prm a; coeff .1 .1 .1; floor -1 t",
        ),
        ("a mirror of the sky", "sky .8 .7 .6 .1 .2 .6; prm a; coeff 3 3 3; reflected .8; fresnel on"),
        (
            "a clear pane before the sky",
            "sky .8 .7 .6 .1 .2 .6; prm a; coeff 3 3 .01; exp .01 .01; refracted 1; index 1; specular 0",
        ),
    ] {
        let lines = format!("{lines}; {sun}");
        let drawn = draw(&mut drawing, &lines, SOLID);
        let expected = traced(&session(&lines));
        let apart = difference(&drawn, &expected);
        // Every scene of this list has more in it than one colour.
        let first = *expected.get_pixel(0, 0);
        assert!(expected.pixels().any(|pixel| *pixel != first), "{what}");
        // With one sample per pixel the ray tracer has moiré where the preview has the mean of a far pattern.
        let most = if what.starts_with("floor") { 0.2 } else { 0.01 };
        assert!(apart < most, "{what}: {apart}");
    }
}

#[test]
fn what_is_behind_glass_shows_through_in_any_order() {
    let Some(mut drawing) = drawing() else { return };
    let red = |image: &RgbaImage| {
        let middle = image.get_pixel(SIZE.0 / 2, SIZE.1 / 2).0;
        middle[0] > middle[2] + 40
    };
    for order in ["ap glass; ap ball; xs 0 0 -4", "ap ball; xs 0 0 -4; ap glass"] {
        let scene = |weight: f64| {
            format!(
                "prm glass; coeff 3 3 1; refracted {weight}; color 0 0 1; prm ball; color 1 0 0; coeff 2 2 2; obj o; {order}"
            )
        };
        assert!(red(&draw(&mut drawing, &scene(0.9), SOLID)), "{order}");
        assert!(!red(&draw(&mut drawing, &scene(0.0), SOLID)), "{order}");
        // The course program draws glass as any other surface.
        assert!(!red(&draw_as(&mut drawing, &scene(0.9), SOLID, true)), "{order}");
    }
}

#[test]
fn wireframe_shows_edges_and_normals_are_extra() {
    let Some(mut drawing) = drawing() else { return };
    let lines = "prm a; coeff 3 3 3; patch 8 6; color 1 1 1";
    let lit = |image: &RgbaImage| image.pixels().filter(|pixel| pixel.0[0] > 200).count();
    let solid = draw(&mut drawing, lines, SOLID);
    let wires = draw(&mut drawing, lines, Style::Wireframe { has_normals: false });
    let normals = draw(&mut drawing, lines, Style::Wireframe { has_normals: true });
    let covered = solid.pixels().filter(|pixel| pixel.0[0] > 8).count();
    let dim = |image: &RgbaImage| image.pixels().filter(|pixel| (30..200).contains(&pixel.0[0])).count();
    assert!(lit(&wires) > 500 && lit(&wires) < covered / 4, "{} of {covered}", lit(&wires));
    // Hidden edges are drawn dim.
    assert!(dim(&wires) > 300, "{}", dim(&wires));
    let yellow = |image: &RgbaImage| image.pixels().filter(|p| p.0[0] > 200 && p.0[2] < 150).count();
    assert!(yellow(&normals) > 100 && yellow(&wires) == 0);
    // Twice as many patches have more edges.
    let finer = draw(
        &mut drawing,
        "prm a; coeff 3 3 3; patch 16 12; color 1 1 1",
        Style::Wireframe { has_normals: false },
    );
    assert!(lit(&finer) > lit(&wires) * 3 / 2);
}

#[test]
fn edges_on_a_surface_are_complete() {
    let Some(mut drawing) = drawing() else { return };
    let session = session("prm a; coeff 3 3 3; patch 8 6");
    let (preview, lights) = (open(&session), session.scene().lights());
    let plain = picture(session.scene(), &preview, &lights, SOLID);
    let wires = picture(session.scene(), &preview, &lights, Style::Wireframe { has_normals: false });
    let orange = |image: &RgbaImage| image.pixels().filter(|p| p.0[0] > 150 && p.0[2] < p.0[0] / 2).count();
    let selected = drawing
        .draw_to_image(
            &Picture { selected: Some(Selected::Shape(0)), is_course: true, ..plain.clone() },
            SIZE,
        )
        .unwrap()
        .0;
    let wires = drawing.draw_to_image(&wires, SIZE).unwrap().0;
    let front = wires.pixels().filter(|pixel| pixel.0[0] > 200).count();
    assert!(orange(&selected) > front * 7 / 10, "{} of {front}", orange(&selected));
    assert_eq!(orange(&drawing.draw_to_image(&plain, SIZE).unwrap().0), 0);
}

#[test]
fn the_selected_child_has_an_outline_of_two_pixels() {
    let Some(mut drawing) = drawing() else { return };
    let session = session(
        "prm a; coeff 2 2 2; exp .2 .3; prm b; color 0 0 1; obj o; ap a; xs -3 0 0; ap b; ss 2 2 2; xs 3 0 0",
    );
    let (preview, lights) = (open(&session), session.scene().lights());
    let plain = picture(session.scene(), &preview, &lights, SOLID);
    let without = drawing.draw_to_image(&plain, SIZE).unwrap().0;
    for (child, is_there) in [(0, 0..SIZE.0 / 2), (1, SIZE.0 / 2..SIZE.0)] {
        let picture = Picture { selected: Some(Selected::Child(child)), ..plain.clone() };
        let with = drawing.draw_to_image(&picture, SIZE).unwrap().0;
        let changed: Vec<(u32, u32)> = (0..SIZE.1)
            .flat_map(|y| (0..SIZE.0).map(move |x| (x, y)))
            .filter(|(x, y)| with.get_pixel(*x, *y) != without.get_pixel(*x, *y))
            .collect();
        // About two pixels around a shape of some forty pixels.
        assert!((200..900).contains(&changed.len()), "{child}: {}", changed.len());
        assert!(changed.iter().all(|(x, _)| is_there.contains(x)), "{child}");
    }
}

#[test]
fn lines_and_marks_are_hidden_by_surfaces_before_them() {
    let Some(mut drawing) = drawing() else { return };
    let session = session("prm a; coeff 2 2 2; color 0 0 1");
    let (preview, lights) = (open(&session), session.scene().lights());
    let red = |image: &RgbaImage| image.pixels().filter(|p| p.0[0] > 100 && p.0[2] < 50).count();
    let plain = picture(session.scene(), &preview, &lights, SOLID);
    let mut red_at = |z: f64, is_on_top: bool| {
        let lines =
            [Line { ends: [DVec3::new(-1.0, 0.0, z), DVec3::new(1.0, 0.0, z)], color: [1.0, 0.0, 0.0, 1.0] }];
        let marks =
            [Mark { center: DVec3::new(0.0, 1.0, z), radius: 0.2, color: [1.0, 0.0, 0.0, 1.0], is_on_top }];
        let with = |lines, marks| Picture { lines, marks, ..plain.clone() };
        let by_line = red(&drawing.draw_to_image(&with(&lines, &[]), SIZE).unwrap().0);
        (by_line, red(&drawing.draw_to_image(&with(&[], &marks), SIZE).unwrap().0))
    };
    let (line, mark) = red_at(3.0, false);
    assert!(line > 30 && mark > 30, "{line} {mark}");
    assert_eq!(red_at(-3.0, false), (0, 0));
    // The same marks, but for those that show through.
    let (line, mark) = red_at(-3.0, true);
    assert!(line == 0 && mark > 10, "{line} {mark}");
}

#[test]
fn a_mesh_is_stored_once_however_often_it_is_used() {
    let Some(mut drawing) = drawing() else { return };
    let mut lines = "prm a; obj o".to_owned();
    for i in 0..100 {
        lines += &format!("; ap a a{i}; xs {} {} 0", i % 10 - 5, i / 10 - 5);
    }
    draw_as(&mut drawing, &lines, SOLID, true);
    assert_eq!(drawing.mesh_count(), 1);
    draw_as(&mut drawing, &lines.replace("prm a;", "prm a; coeff 2 1 1; color 1 0 0;"), SOLID, true);
    assert_eq!(drawing.mesh_count(), 1);
    // Within a tolerance near instances have a finer one than far ones.
    draw(&mut drawing, &lines, SOLID);
    assert!((2..=4).contains(&drawing.mesh_count()), "{}", drawing.mesh_count());
    // Small instances with any exponents share a few meshes.
    let mut lines = String::new();
    for i in 0..300 {
        lines += &format!("prm a{i}; exp {} 1; ", 0.5 + 0.0001 * f64::from(i));
    }
    lines += "obj o";
    for i in 0..300 {
        lines += &format!(
            "; ap a{i}; ss .05 .05 .05; xs {} {} 0",
            0.3 * f64::from(i % 20 - 10),
            0.3 * f64::from(i / 20 - 7)
        );
    }
    draw(&mut drawing, &lines, SOLID);
    assert!(drawing.mesh_count() < 10, "{}", drawing.mesh_count());
}

#[test]
fn any_scale_and_an_empty_scene_can_be_drawn() {
    let Some(mut drawing) = drawing() else { return };
    let unit = draw(&mut drawing, "camera 0 0 10 0 0 0; light l 3 4 5; prm a; coeff 2 2 2", SOLID);
    for exponent in [-60, -20, 20, 60] {
        let k = 2f64.powi(exponent);
        let lines = format!(
            "camera 0 0 {} 0 0 0; light l {} {} {}; prm a; coeff {r} {r} {r}",
            10.0 * k,
            3.0 * k,
            4.0 * k,
            5.0 * k,
            r = 2.0 * k
        );
        let scaled = draw(&mut drawing, &lines, SOLID);
        assert!(difference(&unit, &scaled) < 0.001, "{exponent}: {}", difference(&unit, &scaled));
    }
    for lines in ["deselect", "obj o", "prm a; obj o; ap a; ss 1e-200 1 1e200", "camera 0 0 0.5 0 0 0; prm a"]
    {
        for style in [SOLID, Style::Wireframe { has_normals: true }] {
            draw(&mut drawing, lines, style);
        }
    }
    let background = draw(&mut drawing, "background .5 0 1; obj o", SOLID);
    assert!(background.pixels().all(|pixel| pixel.0 == [188, 0, 255, 255]));
}
