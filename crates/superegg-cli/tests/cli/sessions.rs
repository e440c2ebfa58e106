//! Whole sessions of the real binary.

use crate::support::Sandbox;

const BALLS: &str = "prm ball\nobj pair\nap ball left\nxs -2 0 0\nap ball right\nss 2 1 1\nxs 2 0 0\n";

fn rows(text: &str) -> Vec<Vec<&str>> {
    text.lines().map(|line| line.split(',').collect()).collect()
}

#[test]
fn render_writes_a_picture_beside_the_user_and_nothing_else() {
    let sandbox = Sandbox::new();
    std::fs::create_dir(sandbox.path("folder")).unwrap();
    sandbox.write("folder/pair.scn", BALLS);
    let report = sandbox.run("render folder/pair.scn --size 40x30").fine();
    assert!(report.starts_with("pair.png: 40x30, 2 instances"), "{report}");
    assert_eq!(sandbox.files(), ["folder", "pair.png"]);
    let picture = image::open(sandbox.path("pair.png")).unwrap();
    assert_eq!((picture.width(), picture.height()), (40, 30));
    assert!(
        picture.to_rgb8().pixels().any(|p| p.0[0] > 100) && picture.to_rgb8().get_pixel(0, 0).0 == [0; 3]
    );
    assert_eq!(sandbox.run("render folder/pair.scn --size 40x30 --quiet").fine(), "");
}

#[test]
fn the_same_command_gives_the_same_bytes_on_any_number_of_threads() {
    let sandbox = Sandbox::new();
    sandbox.write("pair.scn", BALLS);
    let pictures: Vec<Vec<u8>> = ["1", "2", "5"]
        .iter()
        .map(|threads| {
            sandbox
                .run(&format!(
                    "render pair.scn --size 50x40 --samples 3 --threads {threads} -o {threads}.png"
                ))
                .fine();
            std::fs::read(sandbox.path(&format!("{threads}.png"))).unwrap()
        })
        .collect();
    assert!(pictures.windows(2).all(|pair| pair[0] == pair[1]));
}

#[test]
fn stats_are_as_promised() {
    let sandbox = Sandbox::new();
    sandbox.write("tree.scn", "prm p\nprm unused\nobj o\nap p\nao o a\nss .5 .5 .5\nao o b\nss .5 .5 .5\n");
    sandbox.run("render tree.scn --size 8x6 --samples 2 --threads 3 --depth 40 --stats s.json").fine();
    let stats: serde_json::Value = serde_json::from_str(&sandbox.read("s.json")).unwrap();
    let keys =
        |value: &serde_json::Value| -> Vec<String> { value.as_object().unwrap().keys().cloned().collect() };
    let sorted = |words: &str| -> Vec<String> {
        let mut words: Vec<String> = words.split(' ').map(str::to_owned).collect();
        words.sort();
        words
    };
    assert_eq!(
        keys(&stats),
        sorted(
            "primitives objects groups instances compiled width height samples threads rays seconds peak_rss_bytes"
        )
    );
    assert_eq!(keys(&stats["rays"]), sorted("camera shadow reflection refraction"));
    assert_eq!(
        keys(&stats["compiled"]),
        sorted("bytes box_area_spared reaches_depth stand_in_rays coarsened_rays")
    );
    assert_eq!(stats["compiled"]["reaches_depth"], serde_json::json!(true));
    assert_eq!(keys(&stats["seconds"]), sorted("parse compile render write"));
    let instances = ((1u64 << 40) - 1).to_string();
    assert_eq!(stats["instances"], serde_json::json!(instances));
    assert_eq!(
        (&stats["primitives"], &stats["objects"], &stats["groups"]),
        (&2.into(), &1.into(), &40.into())
    );
    assert_eq!((&stats["rays"]["camera"], &stats["threads"]), (&96.into(), &3.into()));
    assert!(stats["peak_rss_bytes"].is_null() || stats["peak_rss_bytes"].as_u64().unwrap() > 1 << 20);
}

#[test]
fn limits_are_reported_once() {
    let sandbox = Sandbox::new();
    // A ball with four of half its size, and so on: dust that fills a square.
    let child = |name: &str, x: i32, y: i32| format!("ao o {name}\nss .5 .5 .5\nxs {x} {y} 0\n");
    let children = child("a", 1, 1) + &child("b", -1, 1) + &child("c", 1, -1) + &child("d", -1, -1);
    sandbox.write("dust.scn", format!("prm p\ncoeff .5 .5 .5\nobj o\nap p\n{children}"));
    let reported = sandbox.run("render dust.scn --size 64x48 --samples 1").fine();
    assert!(reported.contains("depth limit") && reported.contains("smaller than half a pixel"), "{reported}");
    assert_eq!(reported.lines().count(), 1);
    let reported = sandbox.run("render dust.scn --size 64x48 --samples 1 --object p").fine();
    assert!(!reported.contains("limit") && !reported.contains("proxy"), "{reported}");
}

#[test]
fn made_scenes_are_measured_and_saved() {
    let sandbox = Sandbox::new();
    let reported = sandbox.run("bench cloud:20 fractal:3,5 --size 16x12 --rounds 1 --json b.json").fine();
    assert!(reported.lines().any(|line| line.starts_with("| cloud:20 | 20 |")), "{reported}");
    let rows: serde_json::Value = serde_json::from_str(&sandbox.read("b.json")).unwrap();
    assert_eq!(rows[1]["instances"], serde_json::json!("121"));
    assert!(rows[0]["camera_mrays"].as_f64().unwrap() > 0.0);
    sandbox.run("bench cloud:20 --save .").fine();
    sandbox.run("check --strict cloud_20.scn").fine();
    // Textures are found beside the scene.
    std::fs::create_dir(sandbox.path("far")).unwrap();
    image::RgbImage::new(2, 2).save(sandbox.path("far/t.png")).unwrap();
    sandbox.write("far/t.scn", "prm ball\ntexture color t.png\n");
    let reported = sandbox.run("bench far/t.scn --size 16x12 --rounds 1").fine();
    assert!(reported.lines().any(|line| line.starts_with("| far/t.scn | 1 |")), "{reported}");
    for bad in ["bench cloud:0", "bench fractal:2", "bench nothing", "bench robot --save nowhere"] {
        assert!(!sandbox.run(bad).failed(2).is_empty());
    }
}

#[test]
fn a_scene_goes_to_povray() {
    let sandbox = Sandbox::new();
    sandbox.write("tree.scn", "prm p\nobj o\nap p\nao o a\nss .5 .5 .5\n");
    sandbox.run("export tree.scn -o tree.pov --depth 3").fine();
    let text = sandbox.read("tree.pov");
    assert!(text.contains("#version 3.7;") && text.matches("#declare").count() == 4, "{text}");
    assert!(!text.contains("scale 1000"), "{text}");
    sandbox.write(
        "grains.scn",
        "prm p\ncoeff 1e-4 1e-4 1e-4\ncamera 0 0 0.01 0 0 0 40\nlight lamp 0.02 0 0.01\nobj o\nap p\n",
    );
    let warnings = sandbox.run("export grains.scn -o grains.pov").failed(0);
    assert!(warnings.contains("1000 times those of the scene"), "{warnings}");
    let text = sandbox.read("grains.pov");
    for part in ["location <0, 0, 10>", "light_source { <20, 0, 10>", "\nobject { S_o_0 scale 1000 }"] {
        assert!(text.contains(part), "no {part} in {text}");
    }
    for bad in ["export tree.scn -o tree.xyzw", "export tree.scn -o no/tree.pov", "export gone.scn -o t.pov"]
    {
        assert!(!sandbox.run(bad).failed(2).is_empty());
    }
}

#[test]
fn a_scene_goes_to_mesh_files() {
    let sandbox = Sandbox::new();
    sandbox.write("tree.scn", "prm p\nobj o\nap p\nao o a\nss .5 .5 .5\n");
    for name in ["tree.stl", "tree.ply", "tree.obj", "tree.glb"] {
        let output = sandbox.run(&format!("export tree.scn -o {name} --depth 3 --tolerance 0.01"));
        let warnings = output.failed(0);
        assert!(warnings.contains(&format!("{name}: ")) && warnings.contains("camera"), "{warnings}");
    }
    assert!(sandbox.read("tree.obj").starts_with("# superegg\nmtllib tree.mtl\n"));
    assert!(sandbox.read("tree.mtl").contains("newmtl p_0"));
    for bad in [
        "export tree.scn -o tree.stl --tolerance 0",
        "export tree.scn -o tree.stl --tolerance nan",
        "export tree.scn -o tree.stl --tolerance 1e-12",
    ] {
        assert!(!sandbox.run(bad).failed(2).is_empty());
    }
}

#[test]
fn errors_in_a_scene_are_reported_and_the_rest_is_rendered() {
    let sandbox = Sandbox::new();
    sandbox.write("bad.scn", format!("{BALLS}colour 1 0 0\nxs 1 2\n"));
    let err = sandbox.run("render bad.scn --size 8x8").failed(1);
    assert!(
        err.contains("bad.scn:8:1: error[unknown-command]") && err.contains("did you mean 'color'?"),
        "{err}"
    );
    assert!(err.contains("bad.scn:9:1: error[argument-count]: translate takes 3 arguments, not 2"), "{err}");
    assert!(sandbox.path("bad.png").exists());
}

#[test]
fn wrong_usage_and_unreadable_files_end_with_two_and_write_nothing() {
    let sandbox = Sandbox::new();
    sandbox.write("pair.scn", BALLS).write("rays.csv", "ox,oy,oz,dx,dy,dz\n");
    std::fs::create_dir(sandbox.path("folder")).unwrap();
    for (words, report) in [
        ("draw pair.scn", "there is no command and no scene 'draw'; 'superegg --help' lists"),
        ("rendr pair.scn", "did you mean 'superegg render'?"),
        ("pairs.scn", "there is no command and no scene 'pairs.scn'"),
        ("render missing.scn", "cannot read 'missing.scn'"),
        ("render folder", "it is a folder"),
        ("render pair.scn --object par", "did you mean 'pair'?"),
        ("render pair.scn --size 0x10", "width and height"),
        ("render pair.scn --samples 0", "0 is not in 1..=65536"),
        ("render pair.scn --depth 65", "from 0 to 64"),
        ("render pair.scn --threads 0", "0 is not in"),
        ("render pair.scn --encoding gamma", "possible values: srgb, linear"),
        ("render pair.scn -o nowhere/x.png", "there is no folder 'nowhere'"),
        ("render pair.scn -o folder", "it is a folder"),
        ("render pair.scn --stats nowhere/x.json", "there is no folder"),
        ("intersect pair.scn --rays missing.csv", "cannot read 'missing.csv'"),
        ("intersect pair.scn --rays rays.csv -o nowhere/x.csv", "nowhere"),
        ("iotest pair.scn --step 0", "above 0"),
        ("iotest pair.scn --step nan", "is not a number"),
        ("iotest pair.scn --step 1e-9", "take a larger step"),
        ("iotest pair.scn --half -1", "0 or above"),
        ("intersect pair.scn --rays rays.csv -o pair.scn", "is the scene itself"),
        ("info pair.scn nobody", "nothing is named 'nobody'"),
    ] {
        let err = sandbox.run(words).failed(2);
        assert!(err.contains(report), "{words}: {err}");
    }
    assert_eq!(sandbox.files(), ["folder", "pair.scn", "rays.csv"]);
}

#[test]
fn an_output_that_fails_leaves_what_was_there() {
    let sandbox = Sandbox::new();
    sandbox.write("pair.scn", BALLS).write("bad.csv", "ox,oy,oz,dx,dy\n1,2,3\n").write("out.csv", "precious");
    sandbox.run("intersect pair.scn --rays bad.csv -o out.csv").failed(1);
    assert_eq!(sandbox.read("out.csv"), "precious");
}

#[test]
fn intersect_answers_each_ray_in_order() {
    let sandbox = Sandbox::new();
    sandbox.write("pair.scn", BALLS);
    let rays = "ox,oy,oz,dx,dy,dz\n-2,0,10,0,0,-2\n9,9,9,1,0,0\n2,0,0,1,0,0\n-9,0,0,.5,0,0\n";
    let out = sandbox.run_with("intersect pair.scn --rays -", rays).fine();
    let rows = rows(&out);
    assert_eq!(rows[0], ["hit", "t", "px", "py", "pz", "nx", "ny", "nz", "leaving", "path"]);
    assert_eq!(rows[1], ["1", "4.5", "-2", "0", "1", "0", "0", "1", "0", "pair/left"]);
    assert_eq!(rows[2], ["0", "", "", "", "", "", "", "", "", ""]);
    assert_eq!(rows[3], ["1", "2", "4", "0", "0", "1", "0", "0", "1", "pair/right"]);
    assert_eq!(rows[4], ["1", "12", "-3", "0", "0", "-1", "0", "0", "0", "pair/left"]);
    assert_eq!(rows.len(), 5);
    sandbox.run_with("intersect pair.scn --rays - -o out.csv", rays).fine();
    assert_eq!(sandbox.read("out.csv"), out);
}

#[test]
fn intersect_tells_the_camera_ray_in_words() {
    let sandbox = Sandbox::new();
    sandbox.write("ball.scn", "prm ball\n");
    let reported = sandbox.run("intersect ball.scn").fine();
    assert!(
        reported.contains("camera at 0 0 10 along 0 0 -1\nmeets ball\nat t = 9\nat the point 0 0 1\n"),
        "{reported}"
    );
    sandbox.write("none.scn", "prm ball\ncamera 0 0 10 0 0 20\n");
    assert!(sandbox.run("intersect none.scn").fine().contains("meets nothing"));
}

#[test]
fn every_bad_row_of_rays_and_points_is_reported_with_its_position() {
    let sandbox = Sandbox::new();
    sandbox.write("pair.scn", BALLS);
    let rays = "ox,oy,oz,dx,dy,dz\n1,2,3,4,5,6\n1,2,3,4,5\n1,2,3,0,0,-0\n1,2,3,4,x,6\n1,2,inf,1,1,1\n";
    let err = sandbox.run_with("intersect pair.scn --rays -", rays).failed(1);
    for sandbox in ["-:3:10: error", "-:4:7: error", "-:5:9: error", "-:6:5: error"] {
        assert!(err.contains(sandbox), "{sandbox}: {err}");
    }
    assert!(
        sandbox
            .run_with("iotest pair.scn --points -", "1,2,3\n")
            .failed(1)
            .contains("the first line must be the header x,y,z")
    );
}

#[test]
fn a_bad_row_has_an_empty_answer_and_the_others_are_answered() {
    let sandbox = Sandbox::new();
    sandbox.write("pair.scn", BALLS);
    let points = "id, Z ,X,y,note\n7,0,-2,0,\"a,b\"\n8,0,x,0,c\n9,0,.5,0,d\n10,1\n";
    let answer = sandbox.run_with("iotest pair.scn -", points);
    let expected = "x,y,z,inside,value,path,id,note\n-2,0,0,1,-1,pair/left,7,\"a,b\"\n,,,,,,8,c\n\
        0.5,0,0,1,-0.4375,pair/right,9,d\n,,,,,,10,\n";
    assert_eq!((answer.code, answer.out.as_str()), (Some(1), expected));
    assert_eq!(answer.err.lines().count(), 2, "{}", answer.err);
    assert!(answer.err.contains("-:3:5: error: x 'x' is not a number"), "{}", answer.err);
    assert!(answer.err.contains("-:5:5: error: a row has 5 fields (id,Z,X,y,note), not 2"), "{}", answer.err);

    let rays = "name,dx,dy,dz,OX,OY,OZ\na,0,0,-1,-2,0,10\nb,0,0,0,-2,0,10\nc,1,0,0,9,9,9\n";
    let answer = sandbox.run_with("intersect pair.scn --rays -", rays);
    assert_eq!(answer.code, Some(1));
    let rows = rows(&answer.out);
    assert_eq!(rows[0][9..], ["path", "name"]);
    assert_eq!((rows[1][1], rows[1][10]), ("9", "a"));
    assert_eq!(rows[2], ["", "", "", "", "", "", "", "", "", "", "b"]);
    assert_eq!((rows[3][0], rows[3][10]), ("0", "c"));
    assert!(answer.err.contains("-:3:3: error: the direction"), "{}", answer.err);
}

#[test]
fn errors_of_rows_are_capped() {
    let sandbox = Sandbox::new();
    sandbox.write("pair.scn", BALLS);
    let points = format!("x,y,z\n{}", "1,2\n".repeat(1000));
    let err = sandbox.run_with("iotest pair.scn --points -", &points).failed(1);
    assert_eq!(err.lines().count(), 21, "{err}");
    assert!(err.contains("superegg: 980 more errors of this kind"), "{err}");
}

#[test]
fn iotest_lists_all_holders_and_the_signed_distance() {
    let sandbox = Sandbox::new();
    sandbox.write("pair.scn", BALLS);
    let points = "x,y,z\n50,0,0\n0,3,4\n2.5,0,0\n";
    let out = sandbox.run_with("iotest pair.scn --all --distance --points -", points).fine();
    let found = rows(&out);
    assert_eq!(found[0][6..], ["holders", "holder_paths", "distance", "distance_error", "distance_path"]);
    assert_eq!(found[1][5..8], ["pair/right", "0", ""]);
    assert_eq!((found[1][8], found[1][10]), ("46", "pair/right"));
    assert_eq!((found[3][6], found[3][7]), ("1", "pair/right"));
    // The ellipse x^2/4 + y^2 = 1 is nearest to (0.5, 0) at x = 2/3.
    let inside: f64 = found[3][8].parse().unwrap();
    assert!((inside + (1.0 / 36.0 + 8.0_f64 / 9.0).sqrt()).abs() < 1e-9, "{inside}");
    let distance: f64 = found[2][8].parse().unwrap();
    assert!((distance - (29f64.sqrt() - 2.0)).abs() < 1e-9 || distance > 0.0, "{distance}");
    // Two shapes around one point.
    sandbox.write("nested.scn", "prm a\nprm b\ncoeff 2 2 2\nobj o\nap a\nap b\n");
    let out = sandbox.run_with("iotest nested.scn --all --distance --points -", "x,y,z\n0,0,.5\n").fine();
    let found = rows(&out);
    assert_eq!(found[1][5..9], ["o/b", "2", "o/a o/b", "-1.5"]);
    assert_eq!(found[1][10], "o/b");
}

#[test]
fn a_point_that_too_many_parts_surround_is_an_error_in_bounded_time() {
    let sandbox = Sandbox::new();
    let children: String = (0..20).map(|i| format!("ao o c{i}\nss .9 .9 .9\nxs .{i:02} 0 0\n")).collect();
    sandbox.write("deep.scn", format!("prm p\nobj o\nap p\n{children}setDepth 64\n"));
    let answer =
        sandbox.run_with("iotest deep.scn --all --points -", "x,y,z\n0.9,.9,.9\n.1,.2,.3\n900,0,0\n");
    assert_eq!(answer.code, Some(1));
    assert!(answer.err.contains(":3:1: error: more primitives surround the point"), "{}", answer.err);
    assert!(answer.err.contains("--limit"), "{}", answer.err);
    let found = rows(&answer.out);
    assert_eq!((found.len(), found[2][3], found[2][5]), (4, "", ""));
}

#[test]
fn iotest_tells_inside_from_outside() {
    let sandbox = Sandbox::new();
    sandbox.write("pair.scn", BALLS);
    let points = "x,y,z\n-2,0,0\n0.5,0,0\n0,0,0\n-1.2,0.9,0\n50,0,0\n";
    let out = sandbox.run_with("iotest pair.scn --points -", points).fine();
    let rows = rows(&out);
    assert_eq!(rows[0], ["x", "y", "z", "inside", "value", "path"]);
    assert_eq!(rows[1], ["-2", "0", "0", "1", "-1", "pair/left"]);
    assert_eq!(rows[2], ["0.5", "0", "0", "1", "-0.4375", "pair/right"]);
    assert_eq!(rows[3], ["0", "0", "0", "0", "0", "pair/right"]);
    assert_eq!((rows[4][3], rows[4][5]), ("0", "pair/left"));
    assert!((rows[4][4].parse::<f64>().unwrap() - 0.45).abs() < 1e-12);
    assert_eq!((rows[5][3], rows[5][5]), ("0", "pair/right"));
}

#[test]
fn iotest_has_the_grid_of_the_course_text() {
    let sandbox = Sandbox::new();
    sandbox.write("ball.scn", "prm ball\n");
    let out = sandbox.run("iotest ball.scn").fine();
    assert_eq!(out.lines().count(), 21 * 21 * 21 + 1);
    let first = rows(&out)[1].clone();
    assert_eq!((&first[..4], first[5]), (&["-5", "-5", "-5", "0"][..], "ball"));
    assert!((first[4].parse::<f64>().unwrap() - 74.0).abs() < 1e-12);
    let inside = |out: &str| rows(out).iter().filter(|row| row[3] == "1").count();
    assert_eq!(inside(&out), 27);
    let small = sandbox.run("iotest ball.scn --step 0.25 --half 0.5").fine();
    assert_eq!((small.lines().count(), inside(&small)), (126, 125));
}

#[test]
fn info_and_check_say_what_there_is() {
    let sandbox = Sandbox::new();
    sandbox.write("pair.scn", BALLS);
    let list = sandbox.run("info pair.scn").fine();
    assert!(
        list.contains("primitives (1)\n  ball\nobjects (1)\n  pair: 2 children")
            && list.contains("selected: pair"),
        "{list}"
    );
    let details = sandbox.run("info pair.scn ball selected").fine();
    assert!(
        details.contains("coeff      1 1 1") && details.contains("child right (ball)  <- cursor"),
        "{details}"
    );
    assert_eq!(
        sandbox.run("check pair.scn --strict").fine(),
        "pair.scn: 0 errors, 0 warnings; 1 primitive, 1 object, 2 instances in the picture\n"
    );
    sandbox.write("slip.scn", format!("{BALLS}obj pairs\nobj pair\n"));
    assert_eq!(sandbox.run("check slip.scn").code, Some(0));
    assert!(
        sandbox
            .run("check slip.scn --strict")
            .failed(1)
            .contains("warning[empty-object]: the object 'pairs'")
    );
}

#[test]
fn files_source_files_but_not_themselves() {
    let sandbox = Sandbox::new();
    std::fs::create_dir(sandbox.path("sub")).unwrap();
    sandbox
        .write("sub/part.scn", BALLS)
        .write("a.scn", "prm lost\nsource sub/part.scn\nload sub/beside.scn\n")
        .write("sub/beside.scn", "source part.scn\nprm added\n")
        .write("circle.scn", "prm a\nsource other.scn\n")
        .write("other.scn", "prm b\nsource circle.scn\n")
        .write("missing.scn", "prm kept\nsource nothing.scn\n");
    let list = sandbox.run("info a.scn").fine();
    assert!(list.contains("primitives (2)\n  added\n  ball"), "{list}");
    assert!(sandbox.run("info circle.scn").failed(1).contains("other.scn:2:1: error[source-circle]"));
    let missing = sandbox.run("info missing.scn");
    assert!(
        missing.out.contains("kept") && missing.err.contains("missing.scn:2:1: error[unreadable]"),
        "{missing:?}"
    );
}

#[test]
fn a_scene_that_is_only_read_writes_nothing_and_a_session_does() {
    let sandbox = Sandbox::new();
    sandbox.write("s.scn", format!("{BALLS}save copy.scn\nsave\nhelp xs\ninfo\ninteract\n"));
    assert!(sandbox.run("check s.scn").err.contains("warning[not-here]: save is not carried out"));
    assert_eq!(sandbox.files(), ["s.scn"]);
    let session = sandbox.run("run s.scn");
    assert!(session.out.contains("translate x y z") && session.out.contains("selected: pair"), "{session:?}");
    assert_eq!(sandbox.files(), ["copy.scn", "s.scn"]);
    let quicksave = std::fs::read_to_string(sandbox.own("data/superegg/quicksave.scn")).unwrap();
    assert_eq!(sandbox.read("copy.scn"), quicksave);
    let same = |name: &str| sandbox.run(&format!("render {name} --size 20x20 -o - --quiet")).out;
    assert_eq!(same("copy.scn"), same("s.scn"));
}

#[test]
fn nothing_selected_is_an_empty_picture_with_a_warning() {
    let sandbox = Sandbox::new();
    sandbox.write("none.scn", "prm ball\ndeselect\nbackground 0 0 1\n").write("empty.scn", "");
    for scene in ["none.scn", "empty.scn"] {
        let answer = sandbox.run(&format!("render {scene} --size 4x4 -o x.png"));
        assert_eq!(answer.code, Some(0));
        assert!(answer.err.contains("nothing is selected"), "{answer:?}");
    }
    assert!(sandbox.run("render none.scn --object ball --size 4x4").fine().contains("1 instance,"));
}

#[test]
fn a_fractal_that_grows_out_of_all_numbers_is_still_tested() {
    let sandbox = Sandbox::new();
    sandbox.write("grow.scn", "prm p\nobj o\nap p\nao o\nss 1e20 1e20 1e20\nsetDepth 64\n");
    let out = sandbox.run_with("iotest grow.scn --points -", "x,y,z\n0,0,0\n").fine();
    assert_eq!(out.lines().nth(1).unwrap(), "0,0,0,1,-1,o/p");
}

#[test]
fn children_at_the_same_position_do_not_multiply_the_work() {
    let sandbox = Sandbox::new();
    sandbox.write("twice.scn", "prm p\nobj o\nap p\nao o a\nao o b\n");
    let report = sandbox.run("render twice.scn --size 32x24").fine();
    assert!(report.contains(&format!("{} instances", (1u32 << 25) - 1)), "{report}");
}

#[test]
fn a_closed_pipe_is_no_error_and_a_full_disk_is() {
    let sandbox = Sandbox::new();
    sandbox.write("ball.scn", "prm ball\n");
    let full = std::path::Path::new("/dev/full");
    if !full.exists() {
        eprintln!("skipped: there is no /dev/full");
        return;
    }
    let ended = |words: &[&str], out: std::process::Stdio| {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_superegg"));
        command.args(words).current_dir(sandbox.path("")).stdout(out).stderr(std::process::Stdio::null());
        command.status().unwrap().code()
    };
    for words in
        [["info", "ball.scn"], ["check", "ball.scn"], ["iotest", "ball.scn"], ["intersect", "ball.scn"]]
    {
        let to_full = std::fs::File::options().write(true).open(full).unwrap();
        assert_eq!(ended(&words, to_full.into()), Some(2), "{words:?}");
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        assert_eq!(ended(&words, writer.into()), Some(0), "{words:?}");
    }
}

#[test]
fn fast_answers_are_those_of_the_exact_path_to_a_millionth() {
    let sandbox = Sandbox::new();
    sandbox.write("pair.scn", BALLS);
    let rays = "ox,oy,oz,dx,dy,dz\n-2.3,0.1,10,0,0,-2\n9,9,9,1,0,0\n2.2,.1,0,1,.3,0\n-900,0.2,0,5,0,0\n";
    let exact = sandbox.run_with("intersect pair.scn --rays -", rays).fine();
    let fast = sandbox.run_with("intersect pair.scn --rays - --fast", rays).fine();
    for (exact, fast) in rows(&exact).into_iter().zip(rows(&fast)).skip(1) {
        assert_eq!((exact[0], exact[8], exact[9]), (fast[0], fast[8], fast[9]));
        let t = |row: &[&str]| row[1].parse::<f64>().unwrap_or(0.0);
        assert!((t(&exact) - t(&fast)).abs() < 1e-6 * (1.0 + t(&exact)), "{exact:?} {fast:?}");
    }
}
