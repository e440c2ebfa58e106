//! Long work: stopped, killed, gone on with, divided, damaged; the picture stays the same to the
//! bit.

use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::time::Duration;

use crate::support::{Random, Sandbox, project};

const SUPEREGG: &str = env!("CARGO_BIN_EXE_superegg");

/// Something of everything: mirrors, glass, a fractal, exponents that are not convex.
const SCENE: &str = "\
prm ball\nexp 1 1\nreflected .4\nprm star\nexp 2.5 2.5\nrefracted .5\nsetIndex 1.3\nprm box\nexp .1 .1\nsetColor .8 .3 .2\n\
obj twig\nap box\nss .3 1 .3\nao twig left\nss .6 .6 .6\nrs 0 0 1 40\nxs 0 1 0\nao twig right\nss .6 .6 .6\nrs 0 1 1 -50\nxs 0 1 0\n\
obj all\nao twig\nap ball\nxs 2 0 0\nap star\nxs -2 0 0\nss 1 1.5 1\nlight a 3 4 5\nlight b -3 4 5\nsetDepth 8\n\
camera 1 2 7 0 .5 0\nobj all\n";

fn command(sandbox: &Sandbox, words: &str) -> Command {
    let mut command = Command::new(SUPEREGG);
    command.args(words.split_whitespace()).current_dir(sandbox.path("")).envs(sandbox.user());
    for name in ["SLURM_ARRAY_TASK_ID", "JOB_COMPLETION_INDEX", "JOB_COMPLETIONS"] {
        command.env_remove(name);
    }
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

fn start(sandbox: &Sandbox, words: &str) -> Child {
    command(sandbox, words).spawn().unwrap()
}

/// The standard error of a command that ended with this code.
#[track_caller]
fn ended(output: &Output, code: i32) -> String {
    let err = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(code), "{err}");
    assert!(!err.contains("panicked"), "{err}");
    err
}

fn bytes(sandbox: &Sandbox, name: &str) -> Vec<u8> {
    std::fs::read(sandbox.path(name)).unwrap()
}

/// A sandbox with the scene, the words to render it with, and the picture that they give.
fn rendered(options: &str) -> (Sandbox, String, Vec<u8>) {
    let sandbox = Sandbox::new();
    sandbox.write("s.scn", SCENE);
    let words = format!("render s.scn {options}");
    sandbox.run(&format!("{words} -o whole.png --threads 2")).fine();
    let whole = bytes(&sandbox, "whole.png");
    (sandbox, words, whole)
}

/// How many bytes a file has; 0 where there is none.
fn length(path: &Path) -> u64 {
    path.metadata().map_or(0, |metadata| metadata.len())
}

/// Waits until a file has so many bytes, or the command has ended.
fn wait_for(child: &mut Child, path: &Path, bytes: u64) {
    while length(path) < bytes && child.try_wait().unwrap().is_none() {
        std::thread::sleep(Duration::from_millis(1));
    }
}

#[test]
fn shards_merge_to_the_whole_picture_to_the_bit() {
    // Twenty-one tiles, of which some are narrow.
    let (sandbox, words, whole) = rendered("--size 200x40 --samples 3");
    sandbox.run(&format!("{words} -o whole.exr")).fine();
    for count in [1, 2, 3, 7, 30] {
        let mut parts: Vec<String> = (1..=count).map(|number| format!("{number}.part")).collect();
        for (number, part) in (1..).zip(&parts) {
            let threads = 1 + number % 3;
            let report = sandbox
                .run(&format!("{words} --tiles {number}/{count} -o {part} --threads {threads}"))
                .fine();
            assert!(report.contains(&format!("{part}: 200x40, shard {number}/{count}")), "{report}");
        }
        // In any order.
        parts.rotate_left(count / 2);
        parts.reverse();
        for picture in ["merged.png", "merged.exr"] {
            sandbox.run(&format!("merge {} -o {picture}", parts.join(" "))).fine();
            let whole = bytes(&sandbox, &picture.replace("merged", "whole"));
            assert!(bytes(&sandbox, picture) == whole, "{picture} of {count} shares");
        }
        assert!(bytes(&sandbox, "merged.png") == whole);
    }
    let left: Vec<String> = sandbox.files().into_iter().filter(|name| !name.ends_with(".part")).collect();
    assert_eq!(left, ["merged.exr", "merged.png", "s.scn", "whole.exr", "whole.png"]);
}

#[test]
fn shards_have_all_that_a_picture_takes() {
    let sandbox = Sandbox::new();
    sandbox.write("s.scn", SCENE);
    let parts = "1.part 2.part 3.part";
    for options in [
        "--noise 0.02 --max-samples 40 --filter gaussian",
        "--transparent --bits 16 --filter mitchell --tone filmic --exposure 1.5",
        "--view depth",
        "--view steps",
        "--view id --depth 5",
    ] {
        let words = format!("render s.scn --size 50x40 --samples 4 {options}");
        sandbox.run(&format!("{words} -o whole.png")).fine();
        for number in 1..=3 {
            sandbox.run(&format!("{words} --tiles {number}/3 -o {number}.part")).fine();
        }
        sandbox.run(&format!("merge {parts} -o merged.png")).fine();
        assert!(bytes(&sandbox, "merged.png") == bytes(&sandbox, "whole.png"), "{options}");
    }
    // Developed otherwise, as if rendered so.
    let words = "render s.scn --size 50x40 --samples 2";
    for number in 1..=3 {
        sandbox.run(&format!("{words} --tiles {number}/3 -o {number}.part")).fine();
    }
    for options in ["--exposure -1", "--tone reinhard --bits 16", "--encoding linear"] {
        sandbox.run(&format!("{words} {options} -o whole.png")).fine();
        sandbox.run(&format!("merge {parts} {options} -o merged.png")).fine();
        assert!(bytes(&sandbox, "merged.png") == bytes(&sandbox, "whole.png"), "{options}");
    }
}

#[test]
fn a_shard_has_a_default_name() {
    let (sandbox, words, _) = rendered("--size 40x20 --samples 1");
    for (share, name) in [("2/3", "s-2-of-3.part"), ("7/100", "s-007-of-100.part")] {
        sandbox.run(&format!("{words} --tiles {share}")).fine();
        assert!(sandbox.path(name).exists());
    }
}

#[test]
fn merge_reports_what_is_missing_and_what_does_not_belong() {
    let (sandbox, words, whole) = rendered("--size 200x40 --samples 2");
    for number in 1..=4 {
        sandbox.run(&format!("{words} --tiles {number}/4 -o {number}.part")).fine();
    }
    let report = sandbox.run("merge 1.part 4.part -o m.png").failed(2);
    assert!(
        report.contains("11 of 21 tiles") && report.contains("of 4 shards") && report.contains("2-3"),
        "{report}"
    );
    assert!(report.contains("--partial") && !sandbox.path("m.png").exists(), "{report}");
    let some = sandbox.run("merge 1.part 4.part -o m.png --partial");
    assert!(
        some.code == Some(0) && some.err.contains("warning") && some.err.contains("11 of 21"),
        "{some:?}"
    );
    let (some, all) = [sandbox.path("m.png"), sandbox.path("whole.png")]
        .map(|path| image::open(path).unwrap().to_rgb8())
        .into();
    let is_there = |x: u32, y: u32| [0, 3].contains(&((y / 16 * 7 + x / 32) % 4));
    for (x, y, pixel) in some.enumerate_pixels() {
        assert_eq!(*pixel, if is_there(x, y) { *all.get_pixel(x, y) } else { image::Rgb([0; 3]) }, "{x} {y}");
    }

    // The same tiles twice, by themselves and as part of other shares.
    sandbox.run(&format!("{words} --tiles 1/2 -o half.part")).fine();
    sandbox.run("merge 1.part half.part 2.part 1.part 3.part 4.part -o m.png").fine();
    assert!(bytes(&sandbox, "m.png") == whole);
    let report = sandbox.run("merge half.part 2.part -o m.png").failed(2);
    assert!(report.contains("16 of 21 tiles") && !report.contains("shards"), "{report}");

    for (options, reported) in [
        ("--size 200x40 --samples 3", "samples is 2 in '1.part', 3 in 'other.part'"),
        ("--size 200x41 --samples 2", "height is 40 in '1.part', 41 in"),
        ("--size 200x40 --samples 2 --depth 7", "depth is 8 in '1.part', 7 in"),
        ("--size 200x40 --samples 2 --object twig", "root is all in '1.part', twig in"),
        ("--size 200x40 --samples 2 --encoding linear", "encoding is Srgb in '1.part', Linear in"),
    ] {
        sandbox.run(&format!("render s.scn {options} --tiles 2/4 -o other.part")).fine();
        let report = sandbox.run("merge 1.part other.part 3.part 4.part -o m.png").failed(2);
        assert!(report.contains("different pictures") && report.contains(reported), "{report}");
    }
    for (line, reported) in [
        ("setColor 0 0 1", "the scene has changed"),
        ("light c 1 1 1", "the surroundings differ"),
        ("camera 1 2 8 0 .5 0", "the camera differ"),
    ] {
        sandbox.write("other.scn", format!("{SCENE}prm box\n{line}\nobj all\n"));
        sandbox.run("render other.scn --size 200x40 --samples 2 --tiles 2/4 -o other.part").fine();
        let report = sandbox.run("merge 1.part other.part 3.part 4.part -o m.png").failed(2);
        assert!(report.contains(reported), "{report}");
    }

    for words in [
        "merge s.scn -o m.png",
        "merge nothing.part -o m.png",
        "merge . -o m.png",
        "merge 1.part -o 1.part",
        "merge -o m.png",
        "merge 1.part",
    ] {
        sandbox.run(words).failed(2);
    }
}

#[test]
fn wrong_shards_are_refused_before_the_work() {
    let (sandbox, words, _) = rendered("--size 20x20 --samples 1");
    for (options, reported) in [
        ("--tiles 0/3", "the shard must be from 1 to 3, not 0"),
        ("--tiles 4/3", "the shard must be from 1 to 3, not 4"),
        ("--tiles 3", "K/N"),
        ("--tiles auto", "SLURM_ARRAY_TASK_ID"),
        ("--tiles auto/3", "JOB_COMPLETION_INDEX"),
        ("--tiles 1/3 -o x.png", "NAME.part"),
        ("--tiles 1/3 -o -", "NAME.part"),
        ("-o x.part", "--shard K/N"),
        ("--resume -o -", "is none"),
    ] {
        let report = ended(&start(&sandbox, &format!("{words} {options}")).wait_with_output().unwrap(), 2);
        assert!(report.contains(reported), "{options}: {report}");
    }
    assert_eq!(sandbox.files(), ["s.scn", "whole.png"]);
}

#[test]
fn a_killed_render_goes_on_to_the_same_picture() {
    let (sandbox, words, whole) = rendered("--size 160x120 --samples 4");
    let mut random = Random(2015);
    let mut kills = 0;
    for round in 0..6 {
        // A share is killed like a picture.
        let is_share = round % 3 == 2;
        let (options, part) =
            if is_share { ("--tiles 1/1 -o x.part", "x.part") } else { ("-o x.png", "x.png.part") };
        let threads = 1 + random.below(3);
        let words = format!("{words} {options} --resume --threads {threads}");
        loop {
            let mut child = start(&sandbox, &words);
            // From the header's first bytes to well after the last tile.
            let more = length(&sandbox.path(part)) + random.below(500_000);
            wait_for(&mut child, &sandbox.path(part), more);
            child.kill().unwrap();
            let output = child.wait_with_output().unwrap();
            if output.status.code().is_some() {
                let report = ended(&output, 0);
                assert!(report.contains("going on from") || report.contains("begun anew"), "{report}");
                break;
            }
            kills += 1;
        }
        if is_share {
            sandbox.run("merge x.part -o x.png").fine();
            std::fs::remove_file(sandbox.path(part)).unwrap();
        }
        assert!(bytes(&sandbox, "x.png") == whole, "round {round}");
        // A kill in the midst of writing the picture leaves a hidden file of the half that was
        // written.
        let left: Vec<String> = sandbox.files().into_iter().filter(|name| !name.starts_with('.')).collect();
        assert_eq!(left, ["s.scn", "whole.png", "x.png"]);
        std::fs::remove_file(sandbox.path("x.png")).unwrap();
    }
    assert!(kills >= 6, "{kills}");
}

#[test]
fn tiles_made_for_a_png_have_their_light_alone() {
    let sandbox = Sandbox::new();
    sandbox.write("s.scn", SCENE);
    let words = "render s.scn --size 2400x1800 --samples 16 --threads 1";
    for (options, part) in [("-o x.png --resume", "x.png.part"), ("--tiles 1/1 -o x.part", "x.part")] {
        let mut child = start(&sandbox, &format!("{words} {options}"));
        // Some tiles of 512 pixels with 52 bytes each.
        wait_for(&mut child, &sandbox.path(part), 200_000);
        child.kill().unwrap();
        assert_eq!(child.wait_with_output().unwrap().status.code(), None, "it was to be killed in its midst");
    }
    let merge = |parts: &str, name: &str| sandbox.run(&format!("merge {parts} --partial -o {name}"));
    // Tiles that both have are the same, as far as both know them.
    for (parts, name) in [
        ("x.png.part", "a.png"),
        ("x.part", "b.png"),
        ("x.part", "c.exr"),
        ("x.png.part x.part", "d.png"),
        ("x.part x.png.part", "e.png"),
    ] {
        let merged = merge(parts, name);
        assert_eq!(merged.code, Some(0), "{parts}: {}", merged.err);
    }
    assert!(bytes(&sandbox, "d.png") == bytes(&sandbox, "e.png"));
    for parts in ["x.png.part", "x.part x.png.part", "x.png.part x.part"] {
        assert!(merge(parts, "f.exr").failed(2).contains("made for a .png"), "{parts}");
    }
    assert!(!sandbox.path("f.exr").exists());
}

/// A partial file of some tiles, and where its header ends: no tile's pixels are shorter than that.
fn some_part(sandbox: &Sandbox, words: &str) -> (Vec<u8>, usize) {
    sandbox.run(&format!("{words} --tiles 1/1 -o x.part")).fine();
    let part = bytes(sandbox, "x.part");
    let start = part.windows(4).position(|four| four == b"TILE").unwrap();
    (part, start)
}

#[test]
fn a_part_cut_off_anywhere_goes_on_to_the_same_picture() {
    let (sandbox, words, whole) = rendered("--size 120x30 --samples 2");
    let (part, start) = some_part(&sandbox, &words);
    let mut random = Random(7);
    let mut cuts =
        vec![0, 1, 15, 16, 20, 35, 36, start - 1, start, start + 1, start + 16, part.len() - 1, part.len()];
    cuts.extend((0..20).map(|_| random.below(part.len() as u64) as usize));
    for cut in cuts {
        sandbox.write("x.png.part", &part[..cut]);
        let answer = sandbox.run(&format!("{words} -o x.png --resume"));
        assert_eq!(answer.code, Some(0), "{cut}: {}", answer.err);
        let reported = if cut < start { "begun anew" } else { "going on from" };
        assert!(answer.err.contains(reported), "{cut}: {}", answer.err);
        assert!(bytes(&sandbox, "x.png") == whole, "{cut}");
        assert!(!sandbox.path("x.png.part").exists());
    }
}

#[test]
fn damage_is_reported_and_made_good() {
    let (sandbox, words, whole) = rendered("--size 120x30 --samples 2");
    let (part, start) = some_part(&sandbox, &words);
    let mut random = Random(11);
    for round in 0..20 {
        let mut damaged = part.clone();
        for _ in 0..=round % 3 {
            let at = start + random.below((part.len() - start) as u64) as usize;
            damaged[at] ^= 1 + random.below(255) as u8;
        }
        if damaged == part {
            continue;
        }
        sandbox.write("d.part", &damaged).write("x.png.part", &damaged);
        let report = sandbox.run("merge d.part -o m.png").failed(2);
        assert!(report.contains("of 8 tiles"), "{report}");
        let answer = sandbox.run(&format!("{words} -o x.png --resume"));
        assert_eq!(answer.code, Some(0), "{}", answer.err);
        assert!(answer.err.contains("going on from") && !answer.err.contains("with 8 of"), "{}", answer.err);
        assert!(bytes(&sandbox, "x.png") == whole, "{round}");
    }
    // Damage in the middle is reported; at the end it looks like a kill.
    let mut damaged = part.clone();
    damaged[start + 100] ^= 1;
    sandbox.write("d.part", &damaged);
    assert!(sandbox.run("merge d.part -o m.png").failed(2).contains("damaged"));
    // Nothing of a changed header can be trusted.
    for at in [17, 25, 40, start - 2] {
        let mut damaged = part.clone();
        damaged[at] ^= 1;
        sandbox.write("x.png.part", &damaged);
        let report = sandbox.run(&format!("{words} -o x.png --resume")).failed(2);
        assert!(report.contains("header is damaged") && report.contains("without --resume"), "{report}");
    }
}

#[test]
fn resume_takes_only_what_it_would_have_made() {
    let (sandbox, words, whole) = rendered("--size 120x30 --samples 2");
    let (part, _) = some_part(&sandbox, &words);
    sandbox.write("x.png.part", &part[..part.len() - 5]);
    let other = "render s.scn --size 120x30 --samples 3 -o x.png --resume";
    let report = sandbox.run(other).failed(2);
    assert!(report.contains("samples is 2 there, 3 here") && report.contains("without --resume"), "{report}");
    sandbox.write("changed.scn", format!("{SCENE}prm box\nsetColor 0 1 0\nobj all\n"));
    let report = sandbox.run("render changed.scn --size 120x30 --samples 2 -o x.png --resume").failed(2);
    assert!(report.contains("the scene has changed"), "{report}");
    assert!(bytes(&sandbox, "x.png.part") == part[..part.len() - 5], "what is refused stays as it was");
    // A scene that says the same in other words is the same.
    sandbox.write("same.scn", format!("# the same\n\n{SCENE}"));
    sandbox.run("render same.scn --size 120x30 --samples 2 -o x.png --resume --threads 1");
    assert!(bytes(&sandbox, "x.png") == whole);

    sandbox.write("s.part", &part);
    let report = sandbox.run(&format!("{words} --tiles 1/2 -o s.part --resume")).failed(2);
    assert!(report.contains("shard 1/1, not 1/2"), "{report}");
    sandbox.write("x.png.part", "my own notes\n");
    let report = sandbox.run(&format!("{words} -o x.png --resume")).failed(2);
    assert!(report.contains("not a partial file"), "{report}");
    assert_eq!(sandbox.read("x.png.part"), "my own notes\n");
    let report = sandbox.run(&format!("{words} -o y.png --resume"));
    assert!(report.code == Some(0) && report.err.contains("there is no 'y.png.part'"), "{report:?}");
    assert_eq!(sandbox.run(&format!("{words} -o y.png --resume --quiet")).fine(), "");
    assert!(!sandbox.path("y.png.part").exists() && bytes(&sandbox, "y.png") == whole);
}

#[test]
fn an_older_part_is_pointed_out_and_left() {
    let (sandbox, words, _) = rendered("--size 20x20 --samples 1");
    let (part, _) = some_part(&sandbox, &words);
    sandbox.write("x.png.part", &part);
    let answer = sandbox.run(&format!("{words} -o x.png"));
    assert!(answer.code == Some(0) && answer.err.contains("--resume would go on from it"), "{answer:?}");
    assert!(bytes(&sandbox, "x.png.part") == part);
}

#[cfg(unix)]
mod signals {
    use nix::sys::signal::{Signal, kill};
    use nix::unistd::Pid;

    use super::*;

    /// Starts a render in a new sandbox, and sends it a signal while it is in the midst of its tiles.
    fn stopped(options: &str, part: &str, signal: Signal) -> (Sandbox, String, Output) {
        // The whole takes long enough on any machine; where it does not, more samples do.
        for samples in [16, 64, 256, 1024] {
            let sandbox = Sandbox::new();
            sandbox.write("s.scn", SCENE);
            let words = format!("render s.scn --size 200x80 --samples {samples} {options}");
            let mut child = start(&sandbox, &format!("{words} --resume --threads 1"));
            // It has a tile, so it listens.
            wait_for(&mut child, &sandbox.path(part), 10_000);
            let id = Pid::from_raw(child.id() as i32);
            kill(id, Signal::SIGSTOP).unwrap();
            // Thirty-five tiles of some 26 kB.
            let is_midway = child.try_wait().unwrap().is_none() && length(&sandbox.path(part)) < 700_000;
            kill(id, signal).unwrap();
            kill(id, Signal::SIGCONT).unwrap();
            let output = child.wait_with_output().unwrap();
            if is_midway {
                return (sandbox, words, output);
            }
        }
        panic!("no render took long enough to be stopped");
    }

    #[test]
    fn ctrl_c_writes_what_there_is_and_keeps_it() {
        let (sandbox, words, output) = stopped("-o x.png", "x.png.part", Signal::SIGINT);
        let report = ended(&output, 130);
        assert!(report.contains("of 35 tiles are done") && report.contains("black"), "{report}");
        assert!(report.contains("--resume goes on from 'x.png.part'"), "{report}");
        let some = image::open(sandbox.path("x.png")).unwrap().to_rgb8();
        sandbox.run(&format!("{words} --resume"));
        assert_eq!(sandbox.files(), ["s.scn", "x.png"]);
        sandbox.run(&words.replace("x.png", "whole.png")).fine();
        assert!(bytes(&sandbox, "x.png") == bytes(&sandbox, "whole.png"));
        let all = image::open(sandbox.path("whole.png")).unwrap().to_rgb8();
        let black = image::Rgb([0; 3]);
        assert!(some.pixels().zip(all.pixels()).all(|(some, all)| *some == black || some == all));
        assert!(some != all);
    }

    #[test]
    fn a_scheduler_that_terminates_a_share_loses_nothing() {
        let (sandbox, words, output) = stopped("--tiles 1/1 -o x.part", "x.part", Signal::SIGTERM);
        let report = ended(&output, 143);
        assert!(report.contains("of 35 tiles are in 'x.part'"), "{report}");
        assert_eq!(sandbox.files(), ["s.scn", "x.part"]);
        sandbox.run(&format!("{words} --resume"));
        sandbox.run("merge x.part -o x.png").fine();
        sandbox.run(&format!("{} -o whole.png", words.replace("--tiles 1/1 -o x.part", ""))).fine();
        assert!(bytes(&sandbox, "x.png") == bytes(&sandbox, "whole.png"));
    }

    #[test]
    fn two_renders_do_not_write_into_one_part() {
        let sandbox = Sandbox::new();
        sandbox.write("s.scn", SCENE);
        let words = "render s.scn --size 200x80 --samples 65536 --threads 1 -o x.png --resume";
        let mut first = start(&sandbox, words);
        wait_for(&mut first, &sandbox.path("x.png.part"), 100);
        let report = ended(&start(&sandbox, words).wait_with_output().unwrap(), 2);
        assert!(report.contains("another superegg is writing it"), "{report}");
        first.kill().unwrap();
        first.wait().unwrap();
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_costs_the_part_and_not_the_picture() {
    let (sandbox, words, whole) = rendered("--size 200x80 --samples 2");
    std::fs::create_dir(sandbox.path("small")).unwrap();
    let session = format!(
        "mount -t tmpfs -o size=200k tmpfs small || exit 77\n\
         \"$1\" {words} -o small/x.png --resume; echo \"picture $?\"; ls small; cmp small/x.png whole.png && echo same\n\
         \"$1\" {words} --tiles 1/1 -o small/x.part; echo \"share $?\"; cp small/x.part . && \"$1\" {words} --tiles 1/1 -o x.part --resume; echo \"resumed $?\"; true\n"
    );
    sandbox.write("session.sh", session);
    for own in [&["unshare", "--mount"][..], &["unshare", "--user", "--map-root-user", "--mount"]] {
        let mut command = Command::new(own[0]);
        command.args(&own[1..]).args(["sh", "session.sh", SUPEREGG]);
        let output = command.current_dir(sandbox.path("")).envs(sandbox.user()).output();
        // Not every machine lets us mount.
        let Ok(output) = output else { continue };
        if output.status.code() != Some(0) {
            continue;
        }
        let reported =
            format!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
        assert!(reported.contains("picture 0\nx.png\nsame"), "{reported}");
        assert!(
            reported.contains("finished tiles are not kept") && reported.contains("No space left"),
            "{reported}"
        );
        assert!(reported.contains("share 2") && reported.contains("resumed 0"), "{reported}");
        sandbox.run("merge x.part -o m.png").fine();
        assert!(bytes(&sandbox, "m.png") == whole);
        return;
    }
    eprintln!("skipped: no small file system can be made here");
}

#[test]
fn hostile_parts_are_refused_and_never_panic() {
    let (sandbox, words, _) = rendered("--size 120x30 --samples 1");
    let (part, start) = some_part(&sandbox, &words);
    let mut random = Random(5);
    // Little memory, so that a length that is believed ends the program.
    let limited = cfg!(target_os = "linux")
        && Command::new("sh").args(["-c", "ulimit -v 1000000"]).status().is_ok_and(|status| status.success());
    let run = |words: &str| {
        let limit = if limited { "ulimit -v 1000000; " } else { "" };
        let mut command = Command::new("sh");
        command.args(["-c", &format!("{limit}exec \"$0\" {words}"), SUPEREGG]).current_dir(sandbox.path(""));
        let output = command.envs(sandbox.user()).output().unwrap();
        let err = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(
            [Some(0), Some(2)].contains(&output.status.code()) && !err.contains("panicked"),
            "{words}: {output:?}"
        );
        err
    };
    for round in 0..120 {
        let mut hostile = part.clone();
        match round % 6 {
            0 => hostile = (0..random.below(3000)).map(|_| random.below(256) as u8).collect(),
            1 => hostile[16..20].copy_from_slice(&(random.below(1 << 32) as u32).to_le_bytes()),
            2 => {
                hostile.truncate(start);
                hostile.extend(b"TILE\xff\xff\xff\x7f".repeat(random.below(1000) as usize));
            }
            3 => {
                for _ in 0..100 {
                    let at = random.below(part.len() as u64) as usize;
                    hostile[at] = random.below(256) as u8;
                }
            }
            4 => drop(hostile.drain(..random.below(start as u64) as usize)),
            _ => hostile.extend_from_slice(&part),
        }
        sandbox.write("h.part", &hostile).write("x.png.part", &hostile);
        run("merge h.part -o m.png");
        run("merge h.part h.part -o m.png --partial");
        if round % 4 == 0 {
            run("render s.scn --size 120x30 --samples 1 -o x.png --resume --threads 1");
        }
    }
    // A header that is right, of the largest picture there is, and no tile.
    sandbox.run("render s.scn --size 1x1 --samples 1 --tiles 2/2 -o h.part").fine();
    assert!(run("merge h.part -o m.png").contains("0 of 1 tile"));
    #[cfg(unix)]
    assert!(run("merge /dev/zero -o m.png").contains("a device"));
}

#[test]
fn a_shard_is_found_in_the_environment() {
    let (sandbox, words, whole) = rendered("--size 200x40 --samples 1");
    let with = |options: &str, environment: &[(&str, &str)]| {
        let output =
            command(&sandbox, &format!("{words} {options}")).envs(environment.to_vec()).output().unwrap();
        ended(&output, 0)
    };
    for id in ["4", "6", "8"] {
        let array = [
            ("SLURM_ARRAY_TASK_ID", id),
            ("SLURM_ARRAY_TASK_MIN", "4"),
            ("SLURM_ARRAY_TASK_MAX", "8"),
            ("SLURM_ARRAY_TASK_STEP", "2"),
            ("SLURM_ARRAY_TASK_COUNT", "3"),
        ];
        with("--tiles auto", &array);
    }
    sandbox.run("merge s-1-of-3.part s-2-of-3.part s-3-of-3.part -o m.png").fine();
    assert!(bytes(&sandbox, "m.png") == whole);
}

/// The words of the `args` of a manifest.
fn manifest_args(name: &str) -> Vec<String> {
    let text = std::fs::read_to_string(project("examples/kubernetes").join(name)).unwrap();
    let args = text.lines().find_map(|line| line.trim().strip_prefix("args: ")).unwrap();
    serde_json::from_str(args).unwrap()
}

#[test]
fn the_kubernetes_manifests_make_a_picture() {
    let sandbox = Sandbox::new();
    sandbox.write("scene.scn", SCENE);
    // Smaller, so that it is made soon.
    let small = |word: &String| match word.as_str() {
        "3840x2160" => "200x40".to_owned(),
        "256" => "2".to_owned(),
        _ => word.clone(),
    };
    let words: Vec<String> = manifest_args("render.yaml").iter().map(small).collect();
    for index in 0..8 {
        let mut pod = command(&sandbox, "");
        pod.args(&words).env("JOB_COMPLETION_INDEX", index.to_string());
        ended(&pod.output().unwrap(), 0);
    }
    let merge = manifest_args("merge.yaml").join(" ");
    let output =
        with_path(Command::new("sh").args(["-c", &merge]).current_dir(sandbox.path(""))).output().unwrap();
    ended(&output, 0);
    sandbox.run("render scene.scn --size 200x40 --samples 2 -o whole.png").fine();
    assert!(bytes(&sandbox, "scene.png") == bytes(&sandbox, "whole.png"));
}

/// The same with this `superegg` on its path.
fn with_path(command: &mut Command) -> &mut Command {
    let own = Path::new(SUPEREGG).parent().unwrap().to_owned();
    let others = std::env::var_os("PATH").unwrap_or_default();
    let path = std::env::join_paths(std::iter::once(own).chain(std::env::split_paths(&others))).unwrap();
    command.env("PATH", path)
}

/// A port that is free just now.
#[cfg(target_os = "linux")]
fn free_port() -> u16 {
    std::net::TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port()
}

#[cfg(target_os = "linux")]
#[test]
fn a_slurm_cluster_makes_a_picture() {
    let has = |program: &str| {
        Command::new("sh")
            .args(["-c", &format!("command -v {program}")])
            .output()
            .is_ok_and(|out| out.status.success())
    };
    if !["munged", "slurmctld", "slurmd", "sbatch", "sinfo", "squeue"].iter().all(|program| has(program)) {
        eprintln!("skipped: there is no Slurm here (slurmctld slurmd slurm-client munge)");
        return;
    }
    if !nix::unistd::geteuid().is_root() {
        eprintln!("skipped: a Slurm cluster is started by root");
        return;
    }
    let (sandbox, words, whole) = rendered("--size 200x40 --samples 2");
    sandbox.write(
        "session.sh",
        format!(
            "set -e\nsubmit={}/submit.sh\nwait() {{ while [ -n \"$(squeue --noheader)\" ]; do sleep 0.2; done; }}\n\
             $submit s.scn 3 {options}; wait; mv s.png first.png\n\
             rm s.parts/2.part; truncate --size -100 s.parts/3.part; $submit s.scn 3 {options}; wait; mv s.png second.png\n\
             $submit s.scn 3 --size 200x40 --samples 1; wait; test ! -e s.png; grep 'samples is 2 there, 1 here' s.parts/1.log\n",
            project("examples/slurm").canonicalize().unwrap().display(),
            options = words.trim_start_matches("render s.scn"),
        ),
    );
    let cluster = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/slurm/one_node.sh");
    let mut command = Command::new("bash");
    command
        .arg(cluster)
        .arg(sandbox.own("cluster"))
        .args([free_port(), free_port()].map(|port| port.to_string()));
    let output =
        with_path(command.args(["sh", "session.sh"]).current_dir(sandbox.path(""))).output().unwrap();
    if output.status.code() == Some(125) {
        eprintln!(
            "skipped: no Slurm cluster can be started here: {}",
            String::from_utf8_lossy(&output.stderr)
        );
        return;
    }
    let reported =
        format!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success(), "{reported}");
    assert!(reported.contains("(shards 1-3)"), "{reported}");
    for picture in ["first.png", "second.png"] {
        assert!(bytes(&sandbox, picture) == whole, "{picture}: {reported}");
    }
    let log = sandbox.read("s.parts/3.log");
    assert!(log.contains("going on from 's.parts/3.part' with 6 of"), "{log}");
}
