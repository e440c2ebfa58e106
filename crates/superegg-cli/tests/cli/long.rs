//! Long work: stopped, killed, gone on with, divided, damaged; the picture stays the same to the bit.

use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::time::Duration;

use crate::support::{Place, Random, project};

const SUPEREGG: &str = env!("CARGO_BIN_EXE_superegg");

/// Something of everything: mirrors, glass, a fractal, exponents that are not convex.
const SCENE: &str = "\
prm ball\nexp 1 1\nreflected .4\nprm star\nexp 2.5 2.5\nrefracted .5\nsetIndex 1.3\nprm box\nexp .1 .1\nsetColor .8 .3 .2\n\
obj twig\nap box\nss .3 1 .3\nao twig left\nss .6 .6 .6\nrs 0 0 1 40\nxs 0 1 0\nao twig right\nss .6 .6 .6\nrs 0 1 1 -50\nxs 0 1 0\n\
obj all\nao twig\nap ball\nxs 2 0 0\nap star\nxs -2 0 0\nss 1 1.5 1\nlight a 3 4 5\nlight b -3 4 5\nsetDepth 8\n\
camera 1 2 7 0 .5 0\nobj all\n";

fn command(place: &Place, words: &str) -> Command {
    let mut command = Command::new(SUPEREGG);
    command.args(words.split_whitespace()).current_dir(place.path("")).envs(place.user());
    for name in ["SLURM_ARRAY_TASK_ID", "JOB_COMPLETION_INDEX", "JOB_COMPLETIONS"] {
        command.env_remove(name);
    }
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

fn start(place: &Place, words: &str) -> Child {
    command(place, words).spawn().unwrap()
}

/// What was said on standard error by a command that ended with this code.
#[track_caller]
fn ended(output: &Output, code: i32) -> String {
    let err = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(code), "{err}");
    assert!(!err.contains("panicked"), "{err}");
    err
}

fn bytes(place: &Place, name: &str) -> Vec<u8> {
    std::fs::read(place.path(name)).unwrap()
}

/// A place with the scene, the words to render it with, and the picture that they give.
fn rendered(options: &str) -> (Place, String, Vec<u8>) {
    let place = Place::new();
    place.write("s.scn", SCENE);
    let words = format!("render s.scn {options}");
    place.run(&format!("{words} -o whole.png --threads 2")).fine();
    let whole = bytes(&place, "whole.png");
    (place, words, whole)
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
fn shares_come_to_the_whole_picture_to_the_bit() {
    // Twenty-one tiles, of which some are narrow.
    let (place, words, whole) = rendered("--size 200x40 --samples 3");
    place.run(&format!("{words} -o whole.exr")).fine();
    for count in [1, 2, 3, 7, 30] {
        let mut parts: Vec<String> = (1..=count).map(|number| format!("{number}.part")).collect();
        for (number, part) in (1..).zip(&parts) {
            let threads = 1 + number % 3;
            let said =
                place.run(&format!("{words} --tiles {number}/{count} -o {part} --threads {threads}")).fine();
            assert!(said.contains(&format!("{part}: 200x40, shard {number}/{count}")), "{said}");
        }
        // In any order.
        parts.rotate_left(count / 2);
        parts.reverse();
        for picture in ["merged.png", "merged.exr"] {
            place.run(&format!("merge {} -o {picture}", parts.join(" "))).fine();
            let whole = bytes(&place, &picture.replace("merged", "whole"));
            assert!(bytes(&place, picture) == whole, "{picture} of {count} shares");
        }
        assert!(bytes(&place, "merged.png") == whole);
    }
    let left: Vec<String> = place.files().into_iter().filter(|name| !name.ends_with(".part")).collect();
    assert_eq!(left, ["merged.exr", "merged.png", "s.scn", "whole.exr", "whole.png"]);
}

#[test]
fn shares_have_all_that_a_picture_takes() {
    let place = Place::new();
    place.write("s.scn", SCENE);
    let parts = "1.part 2.part 3.part";
    for options in [
        "--noise 0.02 --max-samples 40 --filter gaussian",
        "--transparent --bits 16 --filter mitchell --tone filmic --exposure 1.5",
        "--view depth",
        "--view steps",
        "--view id --depth 5",
    ] {
        let words = format!("render s.scn --size 50x40 --samples 4 {options}");
        place.run(&format!("{words} -o whole.png")).fine();
        for number in 1..=3 {
            place.run(&format!("{words} --tiles {number}/3 -o {number}.part")).fine();
        }
        place.run(&format!("merge {parts} -o merged.png")).fine();
        assert!(bytes(&place, "merged.png") == bytes(&place, "whole.png"), "{options}");
    }
    // Developed otherwise, as if rendered so.
    let words = "render s.scn --size 50x40 --samples 2";
    for number in 1..=3 {
        place.run(&format!("{words} --tiles {number}/3 -o {number}.part")).fine();
    }
    for options in ["--exposure -1", "--tone reinhard --bits 16", "--encoding linear"] {
        place.run(&format!("{words} {options} -o whole.png")).fine();
        place.run(&format!("merge {parts} {options} -o merged.png")).fine();
        assert!(bytes(&place, "merged.png") == bytes(&place, "whole.png"), "{options}");
    }
}

#[test]
fn a_share_says_what_it_is_by_default() {
    let (place, words, _) = rendered("--size 40x20 --samples 1");
    for (share, name) in [("2/3", "s-2-of-3.part"), ("7/100", "s-007-of-100.part")] {
        place.run(&format!("{words} --tiles {share}")).fine();
        assert!(place.path(name).exists());
    }
}

#[test]
fn merge_says_what_is_missing_and_what_does_not_belong() {
    let (place, words, whole) = rendered("--size 200x40 --samples 2");
    for number in 1..=4 {
        place.run(&format!("{words} --tiles {number}/4 -o {number}.part")).fine();
    }
    let said = place.run("merge 1.part 4.part -o m.png").failed(2);
    assert!(
        said.contains("11 of 21 tiles") && said.contains("of 4 shards") && said.contains("2-3"),
        "{said}"
    );
    assert!(said.contains("--partial") && !place.path("m.png").exists(), "{said}");
    let some = place.run("merge 1.part 4.part -o m.png --partial");
    assert!(
        some.code == Some(0) && some.err.contains("warning") && some.err.contains("11 of 21"),
        "{some:?}"
    );
    let (some, all) = [place.path("m.png"), place.path("whole.png")]
        .map(|path| image::open(path).unwrap().to_rgb8())
        .into();
    let is_there = |x: u32, y: u32| [0, 3].contains(&((y / 16 * 7 + x / 32) % 4));
    for (x, y, pixel) in some.enumerate_pixels() {
        assert_eq!(*pixel, if is_there(x, y) { *all.get_pixel(x, y) } else { image::Rgb([0; 3]) }, "{x} {y}");
    }

    // The same tiles twice, by themselves and as part of other shares.
    place.run(&format!("{words} --tiles 1/2 -o half.part")).fine();
    place.run("merge 1.part half.part 2.part 1.part 3.part 4.part -o m.png").fine();
    assert!(bytes(&place, "m.png") == whole);
    let said = place.run("merge half.part 2.part -o m.png").failed(2);
    assert!(said.contains("16 of 21 tiles") && !said.contains("shards"), "{said}");

    for (options, told) in [
        ("--size 200x40 --samples 3", "samples is 2 in '1.part', 3 in 'other.part'"),
        ("--size 200x41 --samples 2", "height is 40 in '1.part', 41 in"),
        ("--size 200x40 --samples 2 --depth 7", "depth is 8 in '1.part', 7 in"),
        ("--size 200x40 --samples 2 --object twig", "root is all in '1.part', twig in"),
        ("--size 200x40 --samples 2 --encoding linear", "encoding is Srgb in '1.part', Linear in"),
    ] {
        place.run(&format!("render s.scn {options} --tiles 2/4 -o other.part")).fine();
        let said = place.run("merge 1.part other.part 3.part 4.part -o m.png").failed(2);
        assert!(said.contains("different pictures") && said.contains(told), "{said}");
    }
    for (line, told) in [
        ("setColor 0 0 1", "the scene has changed"),
        ("light c 1 1 1", "the surroundings differ"),
        ("camera 1 2 8 0 .5 0", "the camera differ"),
    ] {
        place.write("other.scn", format!("{SCENE}prm box\n{line}\nobj all\n"));
        place.run("render other.scn --size 200x40 --samples 2 --tiles 2/4 -o other.part").fine();
        let said = place.run("merge 1.part other.part 3.part 4.part -o m.png").failed(2);
        assert!(said.contains(told), "{said}");
    }

    for words in [
        "merge s.scn -o m.png",
        "merge nothing.part -o m.png",
        "merge . -o m.png",
        "merge 1.part -o 1.part",
        "merge -o m.png",
        "merge 1.part",
    ] {
        place.run(words).failed(2);
    }
}

#[test]
fn wrong_shares_are_refused_before_the_work() {
    let (place, words, _) = rendered("--size 20x20 --samples 1");
    for (options, told) in [
        ("--tiles 0/3", "numbered from 1 to 3"),
        ("--tiles 4/3", "numbered from 1 to 3"),
        ("--tiles 3", "K/N"),
        ("--tiles auto", "SLURM_ARRAY_TASK_ID"),
        ("--tiles auto/3", "JOB_COMPLETION_INDEX"),
        ("--tiles 1/3 -o x.png", "NAME.part"),
        ("--tiles 1/3 -o -", "NAME.part"),
        ("-o x.part", "--shard K/N"),
        ("--resume -o -", "is none"),
    ] {
        let said = ended(&start(&place, &format!("{words} {options}")).wait_with_output().unwrap(), 2);
        assert!(said.contains(told), "{options}: {said}");
    }
    assert_eq!(place.files(), ["s.scn", "whole.png"]);
}

#[test]
fn a_killed_render_goes_on_to_the_same_picture() {
    let (place, words, whole) = rendered("--size 160x120 --samples 4");
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
            let mut child = start(&place, &words);
            // From the header's first bytes to well after the last tile.
            let more = length(&place.path(part)) + random.below(500_000);
            wait_for(&mut child, &place.path(part), more);
            child.kill().unwrap();
            let output = child.wait_with_output().unwrap();
            if output.status.code().is_some() {
                let said = ended(&output, 0);
                assert!(said.contains("going on from") || said.contains("begun anew"), "{said}");
                break;
            }
            kills += 1;
        }
        if is_share {
            place.run("merge x.part -o x.png").fine();
            std::fs::remove_file(place.path(part)).unwrap();
        }
        assert!(bytes(&place, "x.png") == whole, "round {round}");
        // A kill in the midst of writing the picture leaves a hidden file of the half that was written.
        let left: Vec<String> = place.files().into_iter().filter(|name| !name.starts_with('.')).collect();
        assert_eq!(left, ["s.scn", "whole.png", "x.png"]);
        std::fs::remove_file(place.path("x.png")).unwrap();
    }
    assert!(kills >= 6, "{kills}");
}

#[test]
fn tiles_made_for_a_png_have_their_light_alone() {
    let place = Place::new();
    place.write("s.scn", SCENE);
    let words = "render s.scn --size 2400x1800 --samples 16 --threads 1";
    for (options, part) in [("-o x.png --resume", "x.png.part"), ("--tiles 1/1 -o x.part", "x.part")] {
        let mut child = start(&place, &format!("{words} {options}"));
        // Some tiles of 512 pixels with 52 bytes each.
        wait_for(&mut child, &place.path(part), 200_000);
        child.kill().unwrap();
        assert_eq!(child.wait_with_output().unwrap().status.code(), None, "it was to be killed in its midst");
    }
    let merge = |parts: &str, name: &str| place.run(&format!("merge {parts} --partial -o {name}"));
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
    assert!(bytes(&place, "d.png") == bytes(&place, "e.png"));
    for parts in ["x.png.part", "x.part x.png.part", "x.png.part x.part"] {
        assert!(merge(parts, "f.exr").failed(2).contains("made for a .png"), "{parts}");
    }
    assert!(!place.path("f.exr").exists());
}

/// A partial file of some tiles, and where its header ends: no tile's pixels are shorter than that.
fn some_part(place: &Place, words: &str) -> (Vec<u8>, usize) {
    place.run(&format!("{words} --tiles 1/1 -o x.part")).fine();
    let part = bytes(place, "x.part");
    let start = part.windows(4).position(|four| four == b"TILE").unwrap();
    (part, start)
}

#[test]
fn a_part_cut_off_anywhere_goes_on_to_the_same_picture() {
    let (place, words, whole) = rendered("--size 120x30 --samples 2");
    let (part, start) = some_part(&place, &words);
    let mut random = Random(7);
    let mut cuts =
        vec![0, 1, 15, 16, 20, 35, 36, start - 1, start, start + 1, start + 16, part.len() - 1, part.len()];
    cuts.extend((0..20).map(|_| random.below(part.len() as u64) as usize));
    for cut in cuts {
        place.write("x.png.part", &part[..cut]);
        let answer = place.run(&format!("{words} -o x.png --resume"));
        assert_eq!(answer.code, Some(0), "{cut}: {}", answer.err);
        let told = if cut < start { "begun anew" } else { "going on from" };
        assert!(answer.err.contains(told), "{cut}: {}", answer.err);
        assert!(bytes(&place, "x.png") == whole, "{cut}");
        assert!(!place.path("x.png.part").exists());
    }
}

#[test]
fn damage_is_told_and_made_good() {
    let (place, words, whole) = rendered("--size 120x30 --samples 2");
    let (part, start) = some_part(&place, &words);
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
        place.write("d.part", &damaged).write("x.png.part", &damaged);
        let said = place.run("merge d.part -o m.png").failed(2);
        assert!(said.contains("of 8 tiles"), "{said}");
        let answer = place.run(&format!("{words} -o x.png --resume"));
        assert_eq!(answer.code, Some(0), "{}", answer.err);
        assert!(answer.err.contains("going on from") && !answer.err.contains("with 8 of"), "{}", answer.err);
        assert!(bytes(&place, "x.png") == whole, "{round}");
    }
    // Damage in the middle is told; at the end it looks like a kill.
    let mut damaged = part.clone();
    damaged[start + 100] ^= 1;
    place.write("d.part", &damaged);
    assert!(place.run("merge d.part -o m.png").failed(2).contains("damaged"));
    // Of a header that was changed nothing can be believed.
    for at in [17, 25, 40, start - 2] {
        let mut damaged = part.clone();
        damaged[at] ^= 1;
        place.write("x.png.part", &damaged);
        let said = place.run(&format!("{words} -o x.png --resume")).failed(2);
        assert!(said.contains("header is damaged") && said.contains("without --resume"), "{said}");
    }
}

#[test]
fn resume_takes_only_what_it_would_have_made() {
    let (place, words, whole) = rendered("--size 120x30 --samples 2");
    let (part, _) = some_part(&place, &words);
    place.write("x.png.part", &part[..part.len() - 5]);
    let other = "render s.scn --size 120x30 --samples 3 -o x.png --resume";
    let said = place.run(other).failed(2);
    assert!(said.contains("samples is 2 there, 3 here") && said.contains("without --resume"), "{said}");
    place.write("changed.scn", format!("{SCENE}prm box\nsetColor 0 1 0\nobj all\n"));
    let said = place.run("render changed.scn --size 120x30 --samples 2 -o x.png --resume").failed(2);
    assert!(said.contains("the scene has changed"), "{said}");
    assert!(bytes(&place, "x.png.part") == part[..part.len() - 5], "what is refused stays as it was");
    // A scene that says the same in other words is the same.
    place.write("same.scn", format!("# the same\n\n{SCENE}"));
    place.run("render same.scn --size 120x30 --samples 2 -o x.png --resume --threads 1");
    assert!(bytes(&place, "x.png") == whole);

    place.write("s.part", &part);
    let said = place.run(&format!("{words} --tiles 1/2 -o s.part --resume")).failed(2);
    assert!(said.contains("shard 1/1, not 1/2"), "{said}");
    place.write("x.png.part", "my own notes\n");
    let said = place.run(&format!("{words} -o x.png --resume")).failed(2);
    assert!(said.contains("not a partial file"), "{said}");
    assert_eq!(place.read("x.png.part"), "my own notes\n");
    let said = place.run(&format!("{words} -o y.png --resume"));
    assert!(said.code == Some(0) && said.err.contains("there is no 'y.png.part'"), "{said:?}");
    assert_eq!(place.run(&format!("{words} -o y.png --resume --quiet")).fine(), "");
    assert!(!place.path("y.png.part").exists() && bytes(&place, "y.png") == whole);
}

#[test]
fn an_older_part_is_pointed_out_and_left() {
    let (place, words, _) = rendered("--size 20x20 --samples 1");
    let (part, _) = some_part(&place, &words);
    place.write("x.png.part", &part);
    let answer = place.run(&format!("{words} -o x.png"));
    assert!(answer.code == Some(0) && answer.err.contains("--resume would go on from it"), "{answer:?}");
    assert!(bytes(&place, "x.png.part") == part);
}

#[cfg(unix)]
mod signals {
    use nix::sys::signal::{Signal, kill};
    use nix::unistd::Pid;

    use super::*;

    /// Starts a render in a new place, and sends it a signal while it is in the midst of its tiles.
    fn stopped(options: &str, part: &str, signal: Signal) -> (Place, String, Output) {
        // The whole takes long enough on any machine; where it does not, more samples do.
        for samples in [16, 64, 256, 1024] {
            let place = Place::new();
            place.write("s.scn", SCENE);
            let words = format!("render s.scn --size 200x80 --samples {samples} {options}");
            let mut child = start(&place, &format!("{words} --resume --threads 1"));
            // It has a tile, so it listens.
            wait_for(&mut child, &place.path(part), 10_000);
            let id = Pid::from_raw(child.id() as i32);
            kill(id, Signal::SIGSTOP).unwrap();
            // Thirty-five tiles of some 26 kB.
            let is_midway = child.try_wait().unwrap().is_none() && length(&place.path(part)) < 700_000;
            kill(id, signal).unwrap();
            kill(id, Signal::SIGCONT).unwrap();
            let output = child.wait_with_output().unwrap();
            if is_midway {
                return (place, words, output);
            }
        }
        panic!("no render took long enough to be stopped");
    }

    #[test]
    fn ctrl_c_writes_what_there_is_and_keeps_it() {
        let (place, words, output) = stopped("-o x.png", "x.png.part", Signal::SIGINT);
        let said = ended(&output, 130);
        assert!(said.contains("of 35 tiles are done") && said.contains("black"), "{said}");
        assert!(said.contains("--resume goes on from 'x.png.part'"), "{said}");
        let some = image::open(place.path("x.png")).unwrap().to_rgb8();
        place.run(&format!("{words} --resume"));
        assert_eq!(place.files(), ["s.scn", "x.png"]);
        place.run(&words.replace("x.png", "whole.png")).fine();
        assert!(bytes(&place, "x.png") == bytes(&place, "whole.png"));
        let all = image::open(place.path("whole.png")).unwrap().to_rgb8();
        let black = image::Rgb([0; 3]);
        assert!(some.pixels().zip(all.pixels()).all(|(some, all)| *some == black || some == all));
        assert!(some != all);
    }

    #[test]
    fn a_scheduler_that_terminates_a_share_loses_nothing() {
        let (place, words, output) = stopped("--tiles 1/1 -o x.part", "x.part", Signal::SIGTERM);
        let said = ended(&output, 143);
        assert!(said.contains("of 35 tiles are in 'x.part'"), "{said}");
        assert_eq!(place.files(), ["s.scn", "x.part"]);
        place.run(&format!("{words} --resume"));
        place.run("merge x.part -o x.png").fine();
        place.run(&format!("{} -o whole.png", words.replace("--tiles 1/1 -o x.part", ""))).fine();
        assert!(bytes(&place, "x.png") == bytes(&place, "whole.png"));
    }

    #[test]
    fn two_renders_do_not_write_into_one_part() {
        let place = Place::new();
        place.write("s.scn", SCENE);
        let words = "render s.scn --size 200x80 --samples 65536 --threads 1 -o x.png --resume";
        let mut first = start(&place, words);
        wait_for(&mut first, &place.path("x.png.part"), 100);
        let said = ended(&start(&place, words).wait_with_output().unwrap(), 2);
        assert!(said.contains("another superegg is writing it"), "{said}");
        first.kill().unwrap();
        first.wait().unwrap();
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_costs_the_part_and_not_the_picture() {
    let (place, words, whole) = rendered("--size 200x80 --samples 2");
    std::fs::create_dir(place.path("small")).unwrap();
    let session = format!(
        "mount -t tmpfs -o size=200k tmpfs small || exit 77\n\
         \"$1\" {words} -o small/x.png --resume; echo \"picture $?\"; ls small; cmp small/x.png whole.png && echo same\n\
         \"$1\" {words} --tiles 1/1 -o small/x.part; echo \"share $?\"; cp small/x.part . && \"$1\" {words} --tiles 1/1 -o x.part --resume; echo \"resumed $?\"; true\n"
    );
    place.write("session.sh", session);
    for own in [&["unshare", "--mount"][..], &["unshare", "--user", "--map-root-user", "--mount"]] {
        let mut command = Command::new(own[0]);
        command.args(&own[1..]).args(["sh", "session.sh", SUPEREGG]);
        let output = command.current_dir(place.path("")).envs(place.user()).output();
        // Not every machine lets us mount.
        let Ok(output) = output else { continue };
        if output.status.code() != Some(0) {
            continue;
        }
        let told =
            format!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
        assert!(told.contains("picture 0\nx.png\nsame"), "{told}");
        assert!(told.contains("finished tiles are not kept") && told.contains("No space left"), "{told}");
        assert!(told.contains("share 2") && told.contains("resumed 0"), "{told}");
        place.run("merge x.part -o m.png").fine();
        assert!(bytes(&place, "m.png") == whole);
        return;
    }
    eprintln!("skipped: no small file system can be made here");
}

#[test]
fn hostile_parts_are_refused_and_never_panic() {
    let (place, words, _) = rendered("--size 120x30 --samples 1");
    let (part, start) = some_part(&place, &words);
    let mut random = Random(5);
    // Little memory, so that a length that is believed ends the program.
    let limited = cfg!(target_os = "linux")
        && Command::new("sh").args(["-c", "ulimit -v 1000000"]).status().is_ok_and(|status| status.success());
    let run = |words: &str| {
        let limit = if limited { "ulimit -v 1000000; " } else { "" };
        let mut command = Command::new("sh");
        command.args(["-c", &format!("{limit}exec \"$0\" {words}"), SUPEREGG]).current_dir(place.path(""));
        let output = command.envs(place.user()).output().unwrap();
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
        place.write("h.part", &hostile).write("x.png.part", &hostile);
        run("merge h.part -o m.png");
        run("merge h.part h.part -o m.png --partial");
        if round % 4 == 0 {
            run("render s.scn --size 120x30 --samples 1 -o x.png --resume --threads 1");
        }
    }
    // A header that is right, of the largest picture there is, and no tile.
    place.run("render s.scn --size 1x1 --samples 1 --tiles 2/2 -o h.part").fine();
    assert!(run("merge h.part -o m.png").contains("0 of 1 tile"));
    #[cfg(unix)]
    assert!(run("merge /dev/zero -o m.png").contains("a device"));
}

#[test]
fn a_share_is_found_in_the_environment() {
    let (place, words, whole) = rendered("--size 200x40 --samples 1");
    let with = |options: &str, environment: &[(&str, &str)]| {
        let output =
            command(&place, &format!("{words} {options}")).envs(environment.to_vec()).output().unwrap();
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
    place.run("merge s-1-of-3.part s-2-of-3.part s-3-of-3.part -o m.png").fine();
    assert!(bytes(&place, "m.png") == whole);
}

/// The words of the `args` of a manifest.
fn manifest_args(name: &str) -> Vec<String> {
    let text = std::fs::read_to_string(project("examples/kubernetes").join(name)).unwrap();
    let args = text.lines().find_map(|line| line.trim().strip_prefix("args: ")).unwrap();
    serde_json::from_str(args).unwrap()
}

#[test]
fn the_kubernetes_manifests_make_a_picture() {
    let place = Place::new();
    place.write("scene.scn", SCENE);
    // Smaller, so that it is made soon.
    let small = |word: &String| match word.as_str() {
        "3840x2160" => "200x40".to_owned(),
        "256" => "2".to_owned(),
        _ => word.clone(),
    };
    let words: Vec<String> = manifest_args("render.yaml").iter().map(small).collect();
    for index in 0..8 {
        let mut pod = command(&place, "");
        pod.args(&words).env("JOB_COMPLETION_INDEX", index.to_string());
        ended(&pod.output().unwrap(), 0);
    }
    let merge = manifest_args("merge.yaml").join(" ");
    let output =
        with_path(Command::new("sh").args(["-c", &merge]).current_dir(place.path(""))).output().unwrap();
    ended(&output, 0);
    place.run("render scene.scn --size 200x40 --samples 2 -o whole.png").fine();
    assert!(bytes(&place, "scene.png") == bytes(&place, "whole.png"));
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
    let (place, words, whole) = rendered("--size 200x40 --samples 2");
    place.write(
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
        .arg(place.own("cluster"))
        .args([free_port(), free_port()].map(|port| port.to_string()));
    let output = with_path(command.args(["sh", "session.sh"]).current_dir(place.path(""))).output().unwrap();
    if output.status.code() == Some(125) {
        eprintln!(
            "skipped: no Slurm cluster can be started here: {}",
            String::from_utf8_lossy(&output.stderr)
        );
        return;
    }
    let told =
        format!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success(), "{told}");
    assert!(told.contains("(shards 1-3)"), "{told}");
    for picture in ["first.png", "second.png"] {
        assert!(bytes(&place, picture) == whole, "{picture}: {told}");
    }
    let log = place.read("s.parts/3.log");
    assert!(log.contains("going on from 's.parts/3.part' with 6 of"), "{log}");
}
