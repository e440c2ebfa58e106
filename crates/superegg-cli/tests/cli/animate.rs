//! Frames and films.

use std::process::Command;

use crate::support::Sandbox;

const SUPEREGG: &str = env!("CARGO_BIN_EXE_superegg");

/// A hand that turns by a right angle in four frames, before a sky.
const HAND: &str = "set size 16x12\nset samples 1\nsky 0 0 .5\ncamera 0 0 6 0 0 0\nprm ball\ncolor 1 0 0\nobj arm\nap ball hand\nxs 2 0 0\n";
const KEYS: &str = "key 0 rotate 0 0 1 0\nkey 4 rotate 0 0 1 90\n";

fn frame(sandbox: &Sandbox, name: &str) -> Vec<u8> {
    std::fs::read(sandbox.path(name)).unwrap()
}

#[test]
fn a_turntable_begins_where_the_scene_has_its_camera() {
    let sandbox = Sandbox::new();
    sandbox.write("hand.scn", HAND);
    let report = sandbox.run("animate hand.scn --turntable 4").fine();
    assert!(report.starts_with("hand_frames: 4 frames of 16x12, 4 rendered, "), "{report}");
    let names = ["frame_0000.png", "frame_0001.png", "frame_0002.png", "frame_0003.png"];
    sandbox.run("render hand.scn -o still.png --quiet").fine();
    assert_eq!(frame(&sandbox, "hand_frames/frame_0000.png"), frame(&sandbox, "still.png"));
    // A quarter round about y, right-handed: from +z to +x.
    sandbox.write("side.scn", HAND.replace("camera 0 0 6", "camera 6 0 0"));
    sandbox.run("render side.scn -o side.png --quiet").fine();
    let near = |a: &str, b: &str| {
        let open = |name: &str| image::open(sandbox.path(name)).unwrap().to_rgb8();
        let apart = open(a).pixels().zip(open(b).pixels()).filter(|(a, b)| a != b).count();
        assert!(apart <= 2, "{a} {b}: {apart} pixels differ");
    };
    near("hand_frames/frame_0001.png", "side.png");
    let mut files: Vec<String> = std::fs::read_dir(sandbox.path("hand_frames"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .filter(|name| name.ends_with(".png"))
        .collect();
    files.sort();
    assert_eq!(files, names);
}

#[test]
fn a_frame_is_the_scene_with_the_keyed_lines_carried_out() {
    let sandbox = Sandbox::new();
    sandbox.write("hand.scn", [HAND, KEYS, "prm other\nobj arm\n"].concat());
    let report = sandbox.run("animate hand.scn -o out/of/it").fine();
    assert!(report.starts_with("out/of/it: 5 frames of 16x12, 5 rendered, "), "{report}");
    for (number, angle) in [(0, "0"), (2, "45"), (4, "90")] {
        sandbox.write("still.scn", format!("{HAND}rotate 0 0 1 {angle}\n"));
        sandbox.run("render still.scn -o still.png --quiet").fine();
        let name = format!("out/of/it/frame_{number:04}.png");
        assert_eq!(frame(&sandbox, &name), frame(&sandbox, "still.png"), "{name}");
    }
}

#[test]
fn shards_of_the_frames_are_all_of_them_and_one_frame_is_a_picture() {
    let sandbox = Sandbox::new();
    sandbox.write("hand.scn", [HAND, KEYS].concat());
    sandbox.run("animate hand.scn -o whole --quiet").fine();
    for (share, count) in [("2/3", 2), ("1/3", 2), ("3/3", 1)] {
        let report = sandbox.run(&format!("animate hand.scn -o shared --tiles {share}")).fine();
        let expected = format!("shared: shard {share}, {count} frame");
        assert!(report.starts_with(&expected) && report.contains(&format!("{count} rendered, ")), "{report}");
    }
    let report = sandbox.run("animate hand.scn -o shared").fine();
    assert!(report.contains(" 0 rendered, 5 kept from before, "), "{report}");
    for number in 0..5 {
        let of = |folder: &str| frame(&sandbox, &format!("{folder}/frame_{number:04}.png"));
        assert_eq!(of("whole"), of("shared"), "{number}");
    }
    sandbox.run("render hand.scn --frame 3 -o three.png --quiet").fine();
    assert_eq!(frame(&sandbox, "three.png"), frame(&sandbox, "whole/frame_0003.png"));
    let report = sandbox.run("render hand.scn --frame soon");
    assert!(report.code == Some(2) && report.err.contains("--frame"), "{report:?}");
}

#[test]
fn work_that_was_broken_off_goes_on_and_changes_are_made_anew() {
    let sandbox = Sandbox::new();
    sandbox.write("hand.scn", [HAND, KEYS].concat());
    let run = |words: &str| sandbox.run(&format!("animate hand.scn --frames 0..4 {words}")).fine();
    let rendered = |report: String| {
        report.split(", ").nth(1).unwrap().to_owned() + " " + report.split(", ").nth(2).unwrap()
    };
    run("");
    let before = frame(&sandbox, "hand_frames/frame_0001.png");
    assert!(run("").contains(" 0 rendered, 5 kept from before, "));
    std::fs::remove_file(sandbox.path("hand_frames/frame_0001.png")).unwrap();
    std::fs::write(sandbox.path("hand_frames/frame_0002.png"), "of somebody else").unwrap();
    let refused = sandbox.run("animate hand.scn --frames 0..4").failed(2);
    assert!(refused.contains("frame_0002.png' is not a frame as superegg wrote it"), "{refused}");
    assert!(rendered(run("--force")).starts_with("2 rendered 3 kept"));
    assert_eq!(frame(&sandbox, "hand_frames/frame_0001.png"), before);
    // A comment changes no picture; where the hand is later does, in the frames that see it.
    sandbox.write(
        "hand.scn",
        ["# another day\n", HAND, "key 4 rotate 0 0 1 45\nkey 0 rotate 0 0 1 0\n"].concat(),
    );
    assert!(rendered(run("")).starts_with("4 rendered 1 kept"));
    assert!(run("--samples 2").contains(" 5 rendered, "));
    assert!(run("--samples 2 --size 8x6 --quiet").is_empty());
    let picture = image::open(sandbox.path("hand_frames/frame_0004.png")).unwrap();
    assert_eq!((picture.width(), picture.height()), (8, 6));
}

#[test]
fn frames_take_the_options_of_pictures() {
    let sandbox = Sandbox::new();
    sandbox.write("hand.scn", [HAND, KEYS].concat());
    let options = "--exposure 1 --tone filmic --encoding linear --bits 16 --dither --filter gaussian --light path --bounces 2 \
        --noise 0.1 --samples 2 --max-samples 8 --transparent --size 12x10";
    sandbox.run(&format!("animate hand.scn --frames 3..3 -o a --quiet {options}")).fine();
    sandbox.run(&format!("render hand.scn --frame 3 -o a.png --quiet {options}")).fine();
    assert_eq!(frame(&sandbox, "a/frame_0003.png"), frame(&sandbox, "a.png"));
    let warned = sandbox.run("animate hand.scn --frames 3..3 -o b --quiet --max-samples 8").failed(0);
    assert!(warned.contains("--max-samples has no effect without --noise"), "{warned}");
}

#[test]
fn what_cannot_be_made_is_an_error_before_any_frame() {
    let sandbox = Sandbox::new();
    sandbox.write("still.scn", HAND);
    sandbox.write("flat.scn", [HAND, "key 0 scale 1 1 -1\nkey 4 scale 1 1 1\n"].concat());
    sandbox.write("file", "");
    for (words, reported) in [
        ("animate still.scn", "--turntable N"),
        ("animate still.scn --turntable 2 -o a.avi", ".mp4, .webm or .gif"),
        ("animate still.scn --turntable 2 -o -", "standard output"),
        ("animate still.scn --turntable 2 -o file", "not a folder"),
        ("animate still.scn --turntable 2 -o nowhere/a.mp4", "no folder 'nowhere'"),
        ("animate still.scn --turntable 0", "1..="),
        ("animate still.scn --frames 5..2", "does not come before"),
        ("animate still.scn --frames 0..2 --fps 0", "above 0"),
        ("animate flat.scn", "at frame 2 'scale 1 1 0' cannot be"),
    ] {
        let report = sandbox.run(words).failed(2);
        assert!(report.contains(reported), "{words}: {report}");
    }
    assert_eq!(sandbox.files(), ["file", "flat.scn", "still.scn"]);
    // A frame that cannot be rendered leaves no folder that was not there before.
    image::RgbImage::new(2, 2).save(sandbox.path("t.png")).unwrap();
    sandbox.write("keyed.scn", [HAND, KEYS, "prm ball\nkey 0 texture color t.png 1\n"].concat());
    std::fs::create_dir(sandbox.path("old")).unwrap();
    let denoised = |words: &str| {
        let mut command = Command::new(SUPEREGG);
        command.args(words.split(' ')).current_dir(sandbox.path("")).env("SUPEREGG_OIDN", "/none/such.so");
        command.output().unwrap().status.code()
    };
    for folder in ["new", "new/within", "old", "old/new", "./new/"] {
        assert_eq!(denoised(&format!("animate keyed.scn --denoise -o {folder}")), Some(2), "{folder}");
    }
    assert_eq!(sandbox.files(), ["file", "flat.scn", "keyed.scn", "old", "still.scn", "t.png"]);
    assert_eq!(std::fs::read_dir(sandbox.path("old")).unwrap().count(), 0);
    let report = sandbox.run("animate still.scn --frames 0..1");
    assert!(report.err.contains("no keys") && report.code == Some(0), "{report:?}");
}

#[test]
fn without_ffmpeg_the_frames_stay_and_the_command_is_reported() {
    let sandbox = Sandbox::new();
    sandbox.write("hand.scn", [HAND, KEYS].concat());
    let empty = sandbox.path("no programs");
    std::fs::create_dir(&empty).unwrap();
    let output = Command::new(SUPEREGG)
        .args(["animate", "hand.scn", "-o", "a film.mp4"])
        .current_dir(sandbox.path(""))
        .env("PATH", empty)
        .output()
        .unwrap();
    let reported = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{reported}");
    assert!(
        reported.contains("ffmpeg") && reported.contains("/a film_frames/frame_%04d.png' -frames:v 5"),
        "{reported}"
    );
    assert!(sandbox.path("a film_frames/frame_0004.png").exists() && !sandbox.path("a film.mp4").exists());
}

#[test]
fn ffmpeg_makes_the_film() {
    let has_ffmpeg = Command::new("ffmpeg").arg("-version").output().is_ok();
    if !has_ffmpeg {
        eprintln!("ffmpeg is not on this machine; its films are not tested");
        return;
    }
    let sandbox = Sandbox::new();
    // Odd sides, which two of the formats do not have.
    sandbox.write("hand.scn", [&HAND.replace("16x12", "17x11"), KEYS].concat());
    for (ending, at, mark) in [("mp4", 4, b"ftyp"), ("webm", 0, b"\x1a\x45\xdf\xa3"), ("gif", 0, b"GIF8")] {
        let report = sandbox.run(&format!("animate hand.scn -o a.{ending} --fps 10")).fine();
        assert!(report.ends_with(&format!("a.{ending}: 0.5 s at 10 frames a second\n")), "{report}");
        assert_eq!(&frame(&sandbox, &format!("a.{ending}"))[at..at + 4], mark);
    }
    assert_eq!(sandbox.files(), ["a.gif", "a.mp4", "a.webm", "a_frames", "hand.scn"]);
}

/// Stopped in the middle there are whole frames only, and the next run goes on.
#[cfg(unix)]
#[test]
fn ctrl_c_leaves_whole_frames() {
    use nix::sys::signal::{Signal, kill};
    use nix::unistd::Pid;

    let sandbox = Sandbox::new();
    sandbox.write("hand.scn", [&HAND.replace("samples 1", "samples 64"), KEYS].concat());
    let words = "animate hand.scn --frames 0..400 --size 160x120 --threads 1";
    let mut child =
        Command::new(SUPEREGG).args(words.split(' ')).current_dir(sandbox.path("")).spawn().unwrap();
    let second = sandbox.path("hand_frames/frame_0001.png");
    while !second.exists() {
        assert!(child.try_wait().unwrap().is_none(), "it ended by itself");
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    kill(Pid::from_raw(child.id() as i32), Signal::SIGINT).unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(130));
    let count = std::fs::read_dir(sandbox.path("hand_frames"))
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|ending| ending == "png"))
        .inspect(|path| drop(image::open(path).unwrap()))
        .count();
    assert!((2..401).contains(&count), "{count}");
    let last = count - 1;
    let report = sandbox.run(&format!("animate hand.scn --frames 0..{last} --size 160x120")).fine();
    assert!(report.contains(&format!(" 0 rendered, {count} kept from before, ")), "{report}");
}

#[test]
fn the_modeller_takes_keys_and_previews_a_frame() {
    let sandbox = Sandbox::new();
    let picture = |lines: &str| {
        let report = sandbox.run_with("", &format!("{HAND}{lines}set preview plain\n")).fine();
        let rows: Vec<&str> = report.lines().rev().take_while(|line| !line.contains('>')).collect();
        rows.join("\n")
    };
    let turned = picture(&format!("{KEYS}set preview plain\npreview 4\n"));
    assert_eq!(turned, picture("rotate 0 0 1 90\nset preview plain\npreview\n"));
    assert_ne!(turned, picture(&format!("{KEYS}set preview plain\npreview\n")));
    let report = sandbox.run_with("", &format!("{HAND}{KEYS}key 2 rotate 0 0 0 1\nunkey 3\nkey 9 scale -1 1 1\nkey 0 scale 1 1 1\npreview 4.5\nsave out.scn\n"));
    for reported in
        ["error[transform]", "error[no-key]", "error[out-of-range]: at frame 4.5 'scale 0 1 1' cannot be"]
    {
        assert!(report.err.contains(reported), "{reported}: {report:?}");
    }
    assert!(
        sandbox.read("out.scn").ends_with("key 0 scale 1 1 1\nkey 9 scale -1 1 1\n"),
        "{}",
        sandbox.read("out.scn")
    );
}
