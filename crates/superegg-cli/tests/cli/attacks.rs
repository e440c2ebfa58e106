//! Files that are made to harm, and files that a command must not replace.

use std::path::Path;
use std::process::{Command, Output, Stdio};

use superegg_render::{Film, PartHeader, Pixel, RenderSettings, Shard};
use superegg_scene::{Picture, Scene};

use crate::support::Sandbox;

const SUPEREGG: &str = env!("CARGO_BIN_EXE_superegg");
const BALL: &str = "prm ball\n";

/// Runs a command in a process of at most so many KiB of address space.
#[cfg(target_os = "linux")]
fn limited(sandbox: &Sandbox, kib: u64, words: &str) -> Output {
    let script = format!("ulimit -v {kib}; exec '{SUPEREGG}' {words}");
    Command::new("sh").args(["-c", &script]).current_dir(sandbox.path("")).output().unwrap()
}

fn err(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// The header of a partial file that claims a picture of this size.
fn header(width: u32, height: u32) -> PartHeader {
    let picture = Picture { width, height, samples: 1, ..Picture::default() };
    let settings = RenderSettings::of(&Scene::default()).with_picture(picture);
    PartHeader::new("1", BALL, Some("ball"), 25, &settings, Shard::WHOLE)
}

/// A file of a few hundred bytes claims a picture of many gigabytes.
#[cfg(target_os = "linux")]
#[test]
fn a_partial_file_takes_memory_for_its_tiles_alone() {
    let sandbox = Sandbox::new();
    sandbox.write("claim.part", header(32_768, 4096).to_bytes());
    let output = limited(&sandbox, 1_000_000, "merge claim.part --partial -o a.png");
    assert!(output.status.code() == Some(2) && err(&output).contains("nothing to write"), "{output:?}");

    let header = header(32_768, 2048);
    let white = Pixel { color: [1.0; 3], alpha: 1.0, samples: 1, ..Pixel::EMPTY };
    let tile = Film::of_pixels(32, 16, [white; 32 * 16]);
    // The second tile of the second row of tiles.
    let part = [header.to_bytes(), header.record(1024 + 1, &tile)].concat();
    sandbox.write("one.part", &part);
    let output = limited(&sandbox, 700_000, "merge one.part --partial -o one.png");
    assert!(output.status.success() && err(&output).contains("1 of 131072 tiles"), "{output:?}");
    let mut decoder = image::ImageReader::open(sandbox.path("one.png")).unwrap();
    decoder.no_limits();
    let picture = decoder.decode().unwrap().into_rgb8();
    assert_eq!(picture.dimensions(), (32_768, 2048));
    let lit: Vec<(u32, u32)> = picture
        .enumerate_pixels()
        .filter(|(_, _, pixel)| pixel.0 == [255; 3])
        .map(|(x, y, _)| (x, y))
        .collect();
    assert_eq!((lit.len(), lit[0], lit[32 * 16 - 1]), (32 * 16, (32, 16), (63, 31)));

    // A hole in a file has a length and no bytes.
    let file = std::fs::File::create(sandbox.path("hole.part")).unwrap();
    std::io::Write::write_all(&mut &file, &part).unwrap();
    file.set_len(3_000_000_000).unwrap();
    let output = limited(&sandbox, 700_000, "merge hole.part --partial -o hole.png");
    assert!(output.status.success(), "{output:?}");
    assert!(
        std::fs::read(sandbox.path("hole.png")).unwrap() == std::fs::read(sandbox.path("one.png")).unwrap()
    );
}

/// Pictures that lack tiles are the whole pictures with gaps, in every layout.
#[test]
fn a_picture_that_lacks_tiles_is_the_whole_one_with_gaps() {
    let sandbox = Sandbox::new();
    sandbox.write("s.scn", "background .2 .3 .5\nprm ball\nexp .3 2\nset size 100x40\nset samples 1\n");
    for options in ["", "--bits 16 --transparent", "--aov depth", "--aov cost"] {
        sandbox.run(&format!("render s.scn -o whole.png --quiet {options}")).fine();
        sandbox.run(&format!("render s.scn --shard 1/2 -o 1.part --quiet {options}")).fine();
        let merged = sandbox.run("merge 1.part --partial -o some.png --quiet");
        assert_eq!(merged.code, Some(0), "{options}: {}", merged.err);
        let open = |name: &str| image::open(sandbox.path(name)).unwrap().into_rgba16();
        let (whole, some) = (open("whole.png"), open("some.png"));
        let is_there = |x: u32, y: u32| (y / 16 * 4 + x / 32).is_multiple_of(2);
        for (x, y, pixel) in some.enumerate_pixels() {
            let is_scaled = options.starts_with("--aov");
            if is_there(x, y) && !is_scaled {
                assert_eq!(pixel, whole.get_pixel(x, y), "{options} {x} {y}");
            }
            assert!(is_there(x, y) || pixel.0[..3] == [0; 3], "{options} {x} {y}");
        }
    }
    sandbox.run("render s.scn -o whole.exr --quiet").fine();
    sandbox.run("render s.scn --shard 1/2 -o 1.part --quiet").fine();
    assert_eq!(sandbox.run("merge 1.part --partial -o some.exr --quiet").code, Some(0));
    let open = |name: &str| {
        exr::prelude::read_first_rgba_layer_from_file(
            sandbox.path(name),
            |size, _| vec![[0f32; 4]; size.0 * size.1],
            |pixels, at, (r, g, b, a): (f32, f32, f32, f32)| pixels[at.1 * 100 + at.0] = [r, g, b, a],
        )
        .unwrap()
        .layer_data
        .channel_data
        .pixels
    };
    let (whole, some) = (open("whole.exr"), open("some.exr"));
    for (i, pixel) in some.iter().enumerate() {
        let is_there = (i / 100 / 16 * 4 + i % 100 / 32).is_multiple_of(2);
        assert_eq!(*pixel, if is_there { whole[i] } else { [0.0; 4] }, "{i}");
    }
}

#[cfg(unix)]
#[test]
fn only_files_on_a_disk_are_read() {
    let sandbox = Sandbox::new();
    let pipe = sandbox.path("pipe.scn");
    nix::unistd::mkfifo(&pipe, nix::sys::stat::Mode::S_IRWXU).unwrap();
    sandbox.write("real.scn", "load pipe.scn\ninclude pipe.scn\nprm ball\n").write("p.csv", "x,y,z\n0,0,0\n");
    std::os::unix::fs::symlink("real.scn", sandbox.path("link.scn")).unwrap();
    for file in [
        "pipe.scn",
        "/dev/zero",
        "/dev/null",
        "/proc/self/environ",
        "/proc/kmsg",
        "/sys/kernel/mm/transparent_hugepage/enabled",
    ] {
        if !Path::new(file).exists() && file.starts_with('/') {
            continue;
        }
        for words in [
            "info F",
            "check F",
            "render F -o a.png",
            "animate F --turntable 2",
            "view F --bench",
            "run F",
            "import F -o a.scn",
            "merge F -o a.png",
            "intersect link.scn F",
            "iotest link.scn F",
        ] {
            let answer = sandbox.run(&words.replace('F', file));
            let reason =
                answer.err.contains("a device or a pipe") || answer.err.contains("of the operating system");
            let is_refused = reason || answer.err.contains("no window");
            assert!(answer.code == Some(2) && is_refused, "{words} {file}: {answer:?}");
        }
    }
    let answer = sandbox.run("info link.scn");
    assert_eq!(answer.err.matches("a device or a pipe").count(), 2, "{answer:?}");
    assert!(answer.out.contains("primitives (1)"), "{answer:?}");
    // The name of a checkpoint may be taken, too.
    nix::unistd::mkfifo(&sandbox.path("b.png.part"), nix::sys::stat::Mode::S_IRWXU).unwrap();
    assert_eq!(sandbox.run("render link.scn --size 8x8 -o b.png").code, Some(1));
    assert!(sandbox.path("b.png").exists());
}

#[test]
fn a_scene_loads_no_large_file_again_and_again() {
    let sandbox = Sandbox::new();
    let big = format!("prm ball\n{}\n", "#".repeat(1 << 22));
    sandbox.write("big.scn", &big).write("a.scn", "load big.scn\n".repeat(900));
    let answer = sandbox.run("info a.scn");
    assert!(answer.err.contains("error[source-limit]"), "{:.500}", answer.err);
    assert!(answer.err.contains("more errors in this file"), "{:.500}", answer.err);
    assert_eq!(answer.code, Some(1));
}

/// Twice as many take about twice as long. A search through all for each would take minutes.
#[test]
fn many_faults_and_many_deletions_are_answered_at_once() {
    let sandbox = Sandbox::new();
    let count = 40_000;
    let lines = |line: &dyn Fn(usize) -> String| (0..count).map(line).collect::<String>();
    let primitives = lines(&|i| format!("prm p{i:05}\n"));
    let unknown = lines(&|i| format!("ap q{i:05}\n"));
    sandbox.write("unknown.scn", format!("{primitives}obj all\n{unknown}"));
    let answer = sandbox.run("info unknown.scn all");
    assert!(answer.err.contains("did you mean"), "{:.500}", answer.err);
    assert!(answer.err.contains("39900 more errors in this file"), "{}", answer.err.len());
    assert!(answer.err.len() < 100_000);

    let children = lines(&|i| format!("ap p{i:05}\nkey 0 translate {i} 0 0\n"));
    let deletions = lines(&|i| format!("delete p{:05}\n", count - 1 - i));
    sandbox.write("deleted.scn", format!("{primitives}obj all\n{children}{deletions}"));
    let out = sandbox.run("info deleted.scn").fine();
    assert!(
        out.contains("primitives (0)") && out.contains("all: 0 children") && !out.contains("keys"),
        "{out}"
    );
    let renamings = lines(&|i| format!("rename p{i:05} r{i:05}\n"));
    sandbox.write("renamed.scn", format!("{primitives}obj all\n{children}{renamings}obj all\n"));
    let out = sandbox.run("info renamed.scn").fine();
    assert!(
        out.contains("primitives (40000)") && out.contains("r39999") && out.contains("all: 40000"),
        "{out}"
    );
}

#[test]
fn messages_about_a_file_of_commands_are_counted_after_the_first() {
    let sandbox = Sandbox::new();
    sandbox.write("s.txt", format!("{}prm ball\ninfo\n", "nonsense\n".repeat(5000)));
    let answer = sandbox.run("run s.txt");
    assert!(answer.err.contains("4900 more"), "{:.300}", answer.err);
    assert!(answer.out.contains("primitives (1)") && answer.err.len() < 50_000 && answer.code == Some(1));
}

fn make_read_only(path: &Path, is_read_only: bool) {
    let mut permissions = path.metadata().unwrap().permissions();
    permissions.set_readonly(is_read_only);
    std::fs::set_permissions(path, permissions).unwrap();
}

#[test]
fn a_read_only_file_is_replaced_by_force_alone() {
    let sandbox = Sandbox::new();
    sandbox.write("s.scn", BALL);
    sandbox.run("render s.scn --size 8x8 --shard 1/1 -o s.part").fine();
    for (file, words) in [
        ("a.png", "render s.scn --size 8x8 -o a.png"),
        ("a.json", "render s.scn --size 8x8 -o b.png --stats a.json"),
        ("a.png", "merge s.part -o a.png"),
        ("a.stl", "export s.scn -o a.stl"),
        ("a.mtl", "export s.scn -o a.obj"),
        ("a.ply", "sample s.scn -n 10 -o a.ply"),
        ("a.csv", "iotest s.scn --step 5 -o a.csv"),
    ] {
        sandbox.write(file, "kept");
        make_read_only(&sandbox.path(file), true);
        let report = sandbox.run(words).failed(2);
        assert!(report.contains("read-only; --force") && sandbox.read(file) == "kept", "{words}: {report}");
        assert_eq!(sandbox.run(&format!("{words} --force")).code, Some(0), "{words}");
        assert_ne!(std::fs::read(sandbox.path(file)).unwrap(), b"kept", "{words}");
        let is_read_only = sandbox.path(file).metadata().unwrap().permissions().readonly();
        assert!(is_read_only, "{words}: the new file has the permissions of the old one");
        make_read_only(&sandbox.path(file), false);
        std::fs::remove_file(sandbox.path(file)).unwrap();
    }
    sandbox.run_with("", "prm a\nrender p.png 8x8\n").fine();
    make_read_only(&sandbox.path("p.png"), true);
    let answer = sandbox.run_with("", "prm a\nrender p.png 8x8\nrender! p.png 9x9\n");
    assert!(answer.err.matches("read-only").count() == 1 && answer.out.contains("9x9"), "{answer:?}");
}

#[test]
fn a_picture_of_another_maker_is_never_replaced_silently() {
    let sandbox = Sandbox::new();
    sandbox.write("s.scn", BALL);
    for part in ["", " --shard 1/2"] {
        let (words, file) = (
            format!("render s.scn --size 8x8{part}"),
            if part.is_empty() { "s.png" } else { "s-1-of-2.part" },
        );
        sandbox.run(&words).fine();
        // The same line again: its own picture is made anew.
        sandbox.run(&words).fine();
        sandbox.write(file, "of another program");
        let report = sandbox.run(&words).failed(2);
        assert!(
            report.contains("superegg did not make it; name another picture with -o, or --force"),
            "{report}"
        );
        assert_eq!(sandbox.read(file), "of another program");
        let answer = sandbox.run(&format!("{words} --force"));
        assert!(
            answer.code == Some(0) && answer.err.contains("is replaced; superegg did not make it"),
            "{answer:?}"
        );
    }
    // A name that the user has given is replaced, and said.
    for name in ["a.png", "a.exr"] {
        sandbox.write(name, "of another program");
        let answer = sandbox.run(&format!("render s.scn --size 8x8 -o {name}"));
        assert!(
            answer.code == Some(0) && answer.err.contains(&format!("'{name}' is replaced")),
            "{answer:?}"
        );
        let again = sandbox.run(&format!("render s.scn --size 8x8 -o {name}"));
        assert!(again.code == Some(0) && !again.err.contains("is replaced"), "{again:?}");
    }
    // At the prompt a picture of another program, without its name in it.
    let mut bytes = std::fs::read(sandbox.path("a.png")).unwrap();
    while let Some(at) = bytes.windows(8).position(|found| found == b"superegg") {
        bytes[at..at + 8].copy_from_slice(b"another!");
    }
    std::fs::write(sandbox.path("scene.png"), &bytes).unwrap();
    let answer = sandbox.run_with("", "prm a\nrender\n");
    assert!(
        answer.err.contains("superegg did not make it") && answer.err.contains("'render!' replaces"),
        "{answer:?}"
    );
    assert_eq!(std::fs::read(sandbox.path("scene.png")).unwrap(), bytes);
    let answer = sandbox.run_with("", "prm a\nset size 8x8\nrender!\n");
    assert!(answer.out.contains("scene.png: 8x8"), "{answer:?}");
}

#[test]
fn the_prompt_names_the_formats_of_exports() {
    let answer = Sandbox::new().run_with("", "primitive egg\nexport egg.xyz\nexport none/egg.stl\n");
    assert!(answer.err.contains("'egg.xyz' names no format that can be written\n"), "{}", answer.err);
    assert!(answer.err.contains("= help: end the name in .pov (POV-Ray), .stl (mesh)"), "{}", answer.err);
    assert!(answer.err.contains("= help: name a file in a folder that can be written to"), "{}", answer.err);
}

#[test]
fn the_prompt_exports_what_pictures_show() {
    let sandbox = Sandbox::new();
    let far = "primitive egg\nobject all\naddPrimitive egg\ntranslate 500 0 0\n";
    sandbox.write("far.scn", far);
    sandbox.run("export far.scn -o line.pov");
    let answer = sandbox.run_with("", &format!("{far}export prompt.pov\n"));
    assert!(answer.out.contains("so it is framed: camera"), "{answer:?}");
    assert_eq!(sandbox.read("prompt.pov"), sandbox.read("line.pov"));
}

#[test]
fn frames_of_another_maker_stay() {
    let sandbox = Sandbox::new();
    sandbox.write("s.scn", "set size 8x6\nset samples 1\nprm ball\n");
    std::fs::create_dir(sandbox.path("film")).unwrap();
    sandbox.write("film/frame_0001.png", "of another program");
    let report = sandbox.run("animate s.scn --turntable 3 -o film").failed(2);
    assert!(report.contains("film/frame_0001.png' is not a frame as superegg wrote it"), "{report}");
    assert!(!sandbox.path("film/frame_0000.png").exists(), "nothing is rendered in vain");
    assert_eq!(sandbox.read("film/frame_0001.png"), "of another program");
    sandbox.run("animate s.scn --turntable 3 -o film --force").fine();
    // Our own are made anew, also after a kill between the list and the file.
    sandbox.run("animate s.scn --turntable 3 -o film --samples 2").fine();
    let list = sandbox.read("film/superegg_frames.txt");
    sandbox.write(
        "film/superegg_frames.txt",
        format!("{list}frame_0002.png 0123456789abcdef 0123456789abcdef\n"),
    );
    let report = sandbox.run("animate s.scn --turntable 3 -o film --samples 2").fine();
    assert!(report.contains(" 1 rendered, 2 kept"), "{report}");
}

#[cfg(unix)]
#[test]
fn a_link_to_nothing_is_not_followed() {
    let sandbox = Sandbox::new();
    sandbox.write("s.scn", BALL);
    std::fs::create_dir(sandbox.path("film")).unwrap();
    for name in
        ["a.png", "a.scn", "a.csv", "a.part", "film/superegg_frames.txt", "film/frame_0000.png", "b.png.part"]
    {
        std::os::unix::fs::symlink(sandbox.path("elsewhere"), sandbox.path(name)).unwrap();
    }
    for words in [
        "render s.scn --size 8x8 -o a.png",
        "render s.scn --size 8x8 --shard 1/1 -o a.part",
        "iotest s.scn --step 5 -o a.csv",
        "import s.scn -o a.scn",
        "animate s.scn --turntable 2 --size 8x8 -o film",
        "animate s.scn --turntable 2 --size 8x8 -o film --force",
        "render s.scn --size 8x8 -o b.png --resume",
    ] {
        let answer = sandbox.run(words);
        assert!(!sandbox.path("elsewhere").exists(), "{words}");
        let report = answer.failed(2);
        assert!(report.contains("which does not exist"), "{words}: {report}");
    }
    let answer = sandbox.run_with("", "prm a\nsave! a.scn\nrender a.png 8x8\n");
    assert_eq!(answer.err.matches("which does not exist").count(), 2, "{answer:?}");
    assert!(!sandbox.path("elsewhere").exists());
}

/// The remains of a kill are gone after the next command that writes there.
#[cfg(unix)]
#[test]
fn temporary_files_of_a_killed_command_are_removed() {
    let sandbox = Sandbox::new();
    sandbox.write("s.scn", BALL);
    let leftovers = [".superegg-4711-1700000000000000000.png", ".superegg-1-2.scn"];
    let others = [".superegg-4711", ".superegg-notes-1.txt", ".hidden.png"];
    let write = || {
        for name in leftovers.iter().chain(&others) {
            sandbox.write(name, "half");
        }
    };
    let left =
        || -> Vec<String> { sandbox.files().into_iter().filter(|name| name.starts_with('.')).collect() };
    let mut kept: Vec<String> = others.map(str::to_owned).into();
    kept.sort();
    for (words, lines) in [
        ("render s.scn --size 8x8 -o a.png", ""),
        ("export s.scn -o a.stl", ""),
        ("", "prm a\nsave b.scn\n"),
        ("", "prm a\nrender c.png 8x8\n"),
    ] {
        write();
        assert_eq!(sandbox.run_with(words, lines).code, Some(0), "{words}");
        assert_eq!(left(), kept, "{words} {lines}");
    }
    // One that is being written stays.
    let busy = std::fs::File::create(sandbox.path(leftovers[0])).unwrap();
    busy.lock().unwrap();
    sandbox.run("render s.scn --size 8x8 -o a.png").fine();
    assert!(sandbox.path(leftovers[0]).exists());
}

/// A program that takes the place of ffmpeg gets addresses of files and nothing else.
#[cfg(unix)]
#[test]
fn ffmpeg_gets_absolute_paths_of_files() {
    use std::os::unix::fs::PermissionsExt;
    let sandbox = Sandbox::new();
    sandbox.write("s.scn", "set size 8x6\nset samples 1\nprm ball\n");
    std::fs::create_dir(sandbox.path("bin")).unwrap();
    sandbox.write("bin/ffmpeg", "#!/bin/sh\nfor word in \"$@\"; do echo \"$word\" >> words; last=$word; done\necho film > \"${last#file:}\"\n");
    std::fs::set_permissions(sandbox.path("bin/ffmpeg"), std::fs::Permissions::from_mode(0o755)).unwrap();
    let output = Command::new(SUPEREGG)
        .args(["animate", "s.scn", "--turntable", "2", "-o=-concat:a.mp4"])
        .current_dir(sandbox.path(""))
        .env("PATH", format!("{}:/usr/bin:/bin", sandbox.path("bin").display()))
        .output()
        .unwrap();
    assert!(output.status.success(), "{output:?}");
    let words = sandbox.read("words");
    let folder = std::fs::canonicalize(sandbox.path("")).unwrap();
    let input = words.lines().skip_while(|word| *word != "-i").nth(1).unwrap();
    assert_eq!(input, format!("file:{}/-concat:a_frames/frame_%04d.png", folder.display()));
    let last = words.lines().next_back().unwrap();
    assert!(
        last.starts_with(&format!("file:{}/.superegg-", folder.display())) && last.ends_with(".mp4"),
        "{last}"
    );
    assert_eq!(sandbox.read("-concat:a.mp4"), "film\n");
}

#[cfg(target_os = "linux")]
#[test]
fn output_that_cannot_be_written_is_a_failure() {
    let full = || Stdio::from(std::fs::File::options().write(true).open("/dev/full").unwrap());
    let sandbox = Sandbox::new();
    sandbox.write("s.scn", BALL).write("p.csv", "x,y,z\n0,0,0\n");
    sandbox.write("c.csv", "x,y,z,ax,ay,az\n0,0,0,1,1,1\n");
    for words in [
        "--help",
        "-h",
        "--version",
        "render --help",
        "help render",
        "info s.scn",
        "check s.scn",
        "measure s.scn",
        "render s.scn --size 8x8 -o -",
        "render s.scn --size 8x8 -o a.png",
        "iotest s.scn p.csv",
        "sample s.scn -n 3 -o -",
        "import c.csv -o -",
        "merge s.part -o -",
    ] {
        if words.contains("s.part") {
            sandbox.run("render s.scn --size 8x8 --shard 1/1 -o s.part").fine();
        }
        let output = Command::new(SUPEREGG)
            .args(words.split(' '))
            .current_dir(sandbox.path(""))
            .stdin(Stdio::null())
            .stdout(full())
            .output()
            .unwrap();
        assert!(
            output.status.code() == Some(2) && err(&output).contains("cannot write"),
            "{words}: {output:?}"
        );
    }
}

/// Lengths of gigabytes in files that have no such bytes, or only holes.
#[cfg(target_os = "linux")]
#[test]
fn claims_of_data_files_are_errors_and_not_aborts() {
    use base64::Engine;
    let sandbox = Sandbox::new();
    let rows = 100_000_000_u64;
    let payload = 4 + 1 + 8 + 3 * 4 + rows * (4 + 24 + 32);
    let mut bytes = b"sqb\x00v1\r\nTABL".to_vec();
    bytes.extend(payload.to_le_bytes());
    bytes.extend([1, 0, 0, 0, b'a']);
    bytes.extend(rows.to_le_bytes());
    bytes.extend([0; 12]);
    std::fs::write(sandbox.path("hole.sqb"), &bytes).unwrap();
    let file = std::fs::File::options().write(true).open(sandbox.path("hole.sqb")).unwrap();
    file.set_len(8 + 4 + 8 + payload + 16 + 28).unwrap();
    let output = limited(&sandbox, 1_000_000, "info hole.sqb");
    assert!(output.status.code() == Some(2) && err(&output).contains("larger than the memory"), "{output:?}");

    let points = 1_000_000_000_u64;
    let lengths: Vec<u8> = [1, 12 * points, 0, 8].into_iter().flat_map(u64::to_le_bytes).collect();
    let text = |bytes: &[u8]| base64::engine::general_purpose::STANDARD.encode(bytes);
    let data = format!("{}{}", text(&lengths), text(b"\x78\x9c\x03\0\0\0\0\x01"));
    sandbox.write(
        "claim.vtp",
        format!(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\" \
             compressor=\"vtkZLibDataCompressor\">\n<PolyData><Piece NumberOfPoints=\"{points}\"><Points>\
             <DataArray type=\"Float32\" NumberOfComponents=\"3\" format=\"binary\">{data}</DataArray></Points></Piece></PolyData></VTKFile>\n"
        ),
    );
    let output = limited(&sandbox, 1_000_000, "info claim.vtp");
    assert!(
        output.status.code() == Some(2) && err(&output).contains("the arrays would take more"),
        "{output:?}"
    );
}
