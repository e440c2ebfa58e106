//! Denoising, where Open Image Denoise is installed; without it those tests say that they are skipped.

use std::process::Command;

use crate::support::Sandbox;

const SCENE: &str = "up z\ncamera 0 -6 2 0 0 0 40\nset size 144x96\nset samples 4\nset light path\nset bits 16\nset encoding linear\n\
    sky .8 .8 .9 .3 .4 .6\nprm ground\ncolor .7 .6 .5\nfloor -1 ground\nprm lamp\nemission 20\ncoeff .3 .3 .3\n\
    prm ball\ncolor .8 .3 .2\nobj all\nap ball\nap lamp\ntranslate 2 -1 2\n";

/// Whether the library is there.
fn is_installed(sandbox: &Sandbox) -> bool {
    sandbox.write("probe.scn", "set size 8x8\nprm a\n");
    let probe = sandbox.run("render probe.scn --denoise -o probe.png --quiet");
    let is_installed = probe.code == Some(0);
    if !is_installed {
        assert!(probe.err.contains("denoising needs the library Open Image Denoise 2"), "{}", probe.err);
        assert!(probe.err.contains("SUPEREGG_OIDN"), "{}", probe.err);
        eprintln!("skipped: {}", probe.err.trim());
    }
    is_installed
}

/// The linear values of a picture.
fn values(sandbox: &Sandbox, name: &str) -> Vec<f64> {
    let picture = image::open(sandbox.path(name)).unwrap().to_rgb16();
    picture.as_raw().iter().map(|value| f64::from(*value) / 65535.0).collect()
}

fn error(found: &[f64], expected: &[f64]) -> f64 {
    let squares: f64 = found.iter().zip(expected).map(|(a, b)| (a - b).powi(2)).sum();
    (squares / found.len() as f64).sqrt()
}

#[test]
fn a_missing_library_is_an_error_before_the_render() {
    let sandbox = Sandbox::new();
    sandbox.write("s.scn", SCENE);
    let program = |words: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_superegg"));
        command.args(words.split(' ')).current_dir(sandbox.path(".")).env("SUPEREGG_OIDN", "/none/such.so");
        command.output().unwrap()
    };
    let said = program("render s.scn --denoise --samples 60000 -o a.png");
    let text = String::from_utf8_lossy(&said.stderr).into_owned();
    assert!(
        !said.status.success() && text.contains("Open Image Denoise 2") && text.contains("pip install"),
        "{text}"
    );
    assert!(!sandbox.path("a.png").exists());
    // A shard needs no library, because it keeps the samples, and neither does what is no light.
    assert!(program("render s.scn --denoise --shard 1/2 --quiet -o a.part").status.success());
    assert!(program("render s.scn --denoise --aov normal --quiet -o n.png").status.success());
    assert!(sandbox.run("info n.png").fine().contains("\nset denoise off\n"));
    assert!(!program("merge a.part --partial --denoise -o m.png").status.success());
}

#[test]
fn a_denoised_picture_is_nearer_to_the_light_and_always_the_same() {
    let sandbox = Sandbox::new();
    if !is_installed(&sandbox) {
        return;
    }
    sandbox.write("s.scn", SCENE);
    sandbox.write("d.scn", SCENE.to_owned() + "set denoise on\n");
    sandbox.run("render s.scn --samples 256 -o reference.png --quiet").fine();
    sandbox.run("render s.scn -o noisy.png --quiet").fine();
    sandbox.run("render d.scn -o clean.png --quiet").fine();
    let reference = values(&sandbox, "reference.png");
    let [noisy, clean] = ["noisy.png", "clean.png"].map(|name| error(&values(&sandbox, name), &reference));
    eprintln!("root mean square error at 4 samples: {noisy:.4}, denoised {clean:.4}");
    assert!(clean < 0.6 * noisy, "{noisy} {clean}");
    let same = |name: &str| assert_eq!(values(&sandbox, name), values(&sandbox, "clean.png"), "{name}");
    sandbox.run("render s.scn --denoise --threads 1 -o one.png --quiet").fine();
    same("one.png");
    // Shards have the samples, and their merged picture is the whole one's.
    for shard in 1..=3 {
        sandbox.run(&format!("render d.scn --shard {shard}/3 -o {shard}.part --quiet")).fine();
        sandbox.run(&format!("render s.scn --shard {shard}/3 -o {shard}s.part --quiet")).fine();
    }
    sandbox.run("merge 1.part 2.part 3.part -o merged.png --quiet").fine();
    same("merged.png");
    sandbox.run("merge 1s.part 2s.part 3s.part --denoise -o merged.png --quiet").fine();
    same("merged.png");
    sandbox.run("merge 1s.part 2s.part 3s.part -o merged.png --quiet").fine();
    assert_eq!(values(&sandbox, "merged.png"), values(&sandbox, "noisy.png"));
    // Both kinds of files.
    sandbox.run("render d.scn -o whole.exr --quiet").fine();
    sandbox.run("merge 1.part 2.part 3.part -o merged.exr --quiet").fine();
    let bytes = |name: &str| std::fs::read(sandbox.path(name)).unwrap();
    assert_eq!(bytes("whole.exr"), bytes("merged.exr"));
    assert!(sandbox.run("info clean.png").out.contains("set denoise on"));
    // An incomplete picture is not denoised, and neither are other passes.
    for name in ["part.png", "part.exr"] {
        sandbox.run(&format!("merge 1.part --partial --denoise -o {name} --quiet")).failed(0);
        assert!(sandbox.run(&format!("info {name}")).fine().contains("set denoise off"), "{name}");
    }
    sandbox.run("render s.scn --aov normal -o a.png --quiet").fine();
    sandbox.run("render d.scn --aov normal -o b.png --quiet").fine();
    assert_eq!(values(&sandbox, "a.png"), values(&sandbox, "b.png"));
}
