//! Text dumps: real ones against their truth, made ones against what was written, broken ones.

#![allow(clippy::print_stderr, reason = "a test that is skipped says so")]
#![expect(clippy::print_stderr, reason = "a skipped test says so")]

use std::io::Cursor;
use std::path::PathBuf;

use superegg_exchange::read::{Content, Format, Import, Particles, ReadError, ReadOptions, open, sniff};
use superegg_geom::glam::{DQuat, DVec3};

/// A file of the folder of other programs' files; `None`, with a message, if it is missing.
fn real(name: &str) -> Option<Vec<u8>> {
    let folder = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/exchange"));
    let read = std::fs::read(folder.join(name));
    if read.is_err() {
        eprintln!("skipped: there is no {name}");
    }
    read.ok()
}

fn read(bytes: &[u8], frame: usize, options: &ReadOptions) -> Result<(Format, Import), ReadError> {
    let mut source = open(Cursor::new(bytes), options)?;
    Ok((source.format(), source.read(frame, options)?))
}

fn particles(bytes: &[u8], frame: usize) -> (Format, Particles) {
    let (format, import) = read(bytes, frame, &ReadOptions::default()).unwrap();
    match import.content {
        Content::Particles(particles) => (format, particles),
        other => panic!("{other:?}"),
    }
}

/// The rows in the order of their ids.
fn sorted(particles: &Particles) -> Vec<(i64, DVec3, DVec3, [f64; 2], DQuat)> {
    let mut rows: Vec<_> = (0..particles.len())
        .map(|row| {
            let Particles { ids, positions, radii, exponents, rotations, .. } = particles;
            (ids[row], positions[row], radii[row], exponents[row], rotations[row])
        })
        .collect();
    rows.sort_by_key(|row| row.0);
    rows
}

#[test]
fn dumps_of_six_digits_have_the_numbers_of_one_of_sixteen() {
    let Some(truth) = real("liggghts/known_prec.dump") else { return };
    for (name, ids) in [
        ("liggghts/known.dump", vec![1, 2, 3, 4, 5, 6]),
        ("liggghts/known_roundness.dump", vec![1, 2, 3, 4, 5, 6]),
        ("liggghts/known_sub.dump", vec![3, 4, 6]),
    ] {
        let bytes = real(name).unwrap();
        let frames = open(Cursor::new(&bytes), &ReadOptions::default()).unwrap().frames().len();
        for frame in 0..frames {
            let (format, found) = particles(&bytes, frame);
            assert_eq!(format, Format::LiggghtsDump);
            let (_, exact) = particles(&truth, frame);
            assert_eq!(found.step, exact.step);
            let exact = sorted(&exact);
            let found = sorted(&found);
            assert_eq!(found.iter().map(|row| row.0).collect::<Vec<_>>(), ids);
            for (id, position, radii, exponents, rotation) in found {
                let truth = exact.iter().find(|row| row.0 == id).unwrap();
                assert!(position.abs_diff_eq(truth.1, 1e-7), "{name} {id}");
                assert!(radii.abs_diff_eq(truth.2, 1e-8) && exponents == truth.3);
                assert!(rotation.abs_diff_eq(truth.4, 2e-6), "{name} {id} {rotation} {}", truth.4);
            }
        }
    }
}

#[test]
fn the_truth_is_what_the_scripts_say() {
    let Some(bytes) = real("liggghts/known_prec.dump") else { return };
    let (_, found) = particles(&bytes, 0);
    let rows = sorted(&found);
    let turned = |axis: DVec3, degrees: f64| DQuat::from_axis_angle(axis, f64::to_radians(degrees));
    assert_eq!((rows[0].2, rows[0].3), (DVec3::new(0.01, 0.02, 0.03), [1.0, 0.25]));
    assert_eq!(rows[1].3, [0.25, 1.0]);
    assert_eq!(rows[4].3, [2.0 / 6.0, 0.5]);
    for (row, rotation) in [
        (0, DQuat::IDENTITY),
        (1, turned(DVec3::X, 90.0)),
        (3, turned(DVec3::Z, 30.0)),
        (4, turned(DVec3::Y, -70.0)),
    ] {
        assert!(rows[row].4.dot(rotation).abs() > 1.0 - 1e-12, "{row}");
    }
    let oblique = turned(DVec3::new(1.0, -1.0, 0.0).normalize(), 135.585);
    assert!(rows[5].4.dot(oblique).abs() > 1.0 - 1e-9);
}

#[test]
fn frames_may_be_empty_and_change_their_count() {
    let Some(bytes) = real("liggghts/ins.dump") else { return };
    let source = open(Cursor::new(&bytes), &ReadOptions::default()).unwrap();
    let counts: Vec<usize> =
        (0..source.frames().len()).map(|frame| particles(&bytes, frame).1.len()).collect();
    assert_eq!((counts[0], counts.last()), (0, Some(&24)));
}

#[test]
fn lammps_writes_diameters_and_ovito_semi_axes() {
    let half_turn = DQuat::from_axis_angle(DVec3::X, std::f64::consts::FRAC_PI_2);
    for name in ["lammps/columns_named_shapex.dump", "lammps/compute_named_shape.dump"] {
        let Some(bytes) = real(name) else { return };
        let (format, found) = particles(&bytes, 0);
        assert_eq!((format, found.radii[0]), (Format::LammpsDump, DVec3::new(0.5, 1.0, 1.5)));
        assert!(found.rotations[0].abs_diff_eq(half_turn, 1e-6) && found.exponents[0] == [1.0, 1.0]);
    }
    let Some(bytes) = real("ovito/exported.dump") else { return };
    let (format, found) = particles(&bytes, 0);
    assert_eq!((format, found.radii[0]), (Format::OvitoDump, DVec3::new(1.0, 2.0, 3.0)));
    assert_eq!(found.exponents, [[0.25, 1.0], [1.0, 0.5]]);
    assert!(
        found.rotations[0]
            .normalize()
            .abs_diff_eq(DQuat::from_xyzw(0.1, 0.2, 0.3, 0.927_361_843_2).normalize(), 1e-9)
    );
    assert_eq!(found.bounds.unwrap().edges[1], DVec3::new(0.0, 10.0, 0.0));
}

const HEADER: &str =
    "ITEM: TIMESTEP\n5\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS pp ff pp\n-1 1\n-2 2\n0 3\n";

#[test]
fn columns_may_come_in_any_order_with_others_between() {
    let columns = [
        "id",
        "type",
        "x",
        "y",
        "z",
        "shapex",
        "shapey",
        "shapez",
        "quat1",
        "quat2",
        "quat3",
        "quat4",
        "blockiness1",
        "blockiness2",
        "vx",
    ];
    let rows = [
        [7.0, 2.0, 0.1, -0.2, 0.3, 0.01, 0.02, 0.03, 0.6, 0.8, 0.0, 0.0, 8.0, 2.5, -4.5],
        [3.0, 1.0, 1.1, 1.2, 1.3, 0.04, 0.05, 0.06, 0.5, -0.5, 0.5, 0.5, 2.0, 20.0, 1e-3],
    ];
    let mut order: Vec<usize> = (0..columns.len()).collect();
    for turn in 0..40 {
        // A shuffle that visits other orders each time.
        for i in (1..order.len()).rev() {
            order.swap(i, (turn * 7 + i * i) % (i + 1));
        }
        let line = |of: &dyn Fn(usize) -> String| order.iter().map(|&i| of(i)).collect::<Vec<_>>().join(" ");
        let end = if turn % 2 == 0 { "\r\n" } else { " \n" };
        let mut text = HEADER.to_owned() + "ITEM: ATOMS " + &line(&|i| columns[i].to_owned()) + end;
        for row in rows {
            text += &(line(&|i| row[i].to_string()) + end);
        }
        let options =
            ReadOptions { extra: vec!["vx".to_owned(), "type".to_owned()], ..ReadOptions::default() };
        let (_, import) = read(text.as_bytes(), 0, &options).unwrap();
        let Content::Particles(found) = import.content else { panic!() };
        assert_eq!((found.step, &found.ids[..]), (Some(5.0), &[7, 3][..]));
        assert_eq!(found.positions[1], DVec3::new(1.1, 1.2, 1.3));
        assert_eq!(found.exponents, [[2.0 / 2.5, 0.25], [0.1, 1.0]]);
        assert_eq!(found.rotations[0], DQuat::from_xyzw(0.8, 0.0, 0.0, 0.6));
        assert_eq!(found.extra, [("vx".to_owned(), vec![-4.5, 1e-3]), ("type".to_owned(), vec![2.0, 1.0])]);
        let bounds = found.bounds.unwrap();
        assert_eq!((bounds.origin, bounds.periodic), (DVec3::new(-1.0, -2.0, 0.0), [true, false, true]));
    }
}

#[test]
fn a_doubt_that_changes_the_picture_is_an_error_that_names_the_formats() {
    let text =
        HEADER.to_owned() + "ITEM: ATOMS id x y z shapex shapey shapez\n1 0 0 0 1 1 1\n2 0 0 0 1 1 1\n";
    let error = read(text.as_bytes(), 0, &ReadOptions::default()).unwrap_err().to_string();
    assert!(error.contains("--from: liggghts, lammps"), "{error}");
    assert!(sniff(text.as_bytes()).is_some());
    let from = |format| ReadOptions { from: Some(format), ..ReadOptions::default() };
    for (format, radius) in [(Format::LiggghtsDump, 1.0), (Format::LammpsDump, 0.5)] {
        let (_, import) = read(text.as_bytes(), 0, &from(format)).unwrap();
        let Content::Particles(found) = import.content else { panic!() };
        assert_eq!(found.radii[0], DVec3::splat(radius));
        assert!(import.warnings[0].contains("no quaternion"));
    }
}

#[test]
fn wrong_rows_are_errors_with_their_line() {
    let columns =
        "ITEM: ATOMS id x y z shapex shapey shapez quat1 quat2 quat3 quat4 blockiness1 blockiness2\n";
    let good = "1 0 0 0 1 1 1 1 0 0 0 2 2\n";
    for (bad, words) in [
        ("2 0 0 0 1 1 1 1 0 0 0 2\n", "line 11: the row has 12 columns instead of 13"),
        ("2 0 0 0 1 1 1 1 0 0 0 2 2 9\n", "more than 13"),
        ("2 0 0 x 1 1 1 1 0 0 0 2 2\n", "column 4 ('z'): 'x' is not a number"),
        ("2 0 0 nan 1 1 1 1 0 0 0 2 2\n", "not a finite number"),
        ("2 0 0 0 -1 1 1 1 0 0 0 2 2\n", "a semi-axis of -1"),
        ("2 0 0 0 1 1 1 0 0 0 0 2 2\n", "has no direction"),
        ("2 0 0 0 1 1 1 1 0 0 0 1.5 2\n", "a blockiness of 1.5"),
        ("", "ends after 1 of 2 rows"),
        ("2 0 0 0 1 1 1 1 0 0 0 2 2\n3 0 0 0 1 1 1 1 0 0 0 2 2\n", "more rows than the 2"),
    ] {
        let text = HEADER.to_owned() + columns + good + bad;
        let error = read(text.as_bytes(), 0, &ReadOptions::default()).unwrap_err().to_string();
        assert!(error.contains(words) && error.contains("line 1"), "{error}");
    }
    let huge = HEADER.replace("\n2\n", "\n18446744073709551615\n") + columns + good;
    assert!(
        read(huge.as_bytes(), 0, &ReadOptions::default()).unwrap_err().to_string().contains("ends after 1")
    );
}

#[test]
fn no_truncation_and_no_changed_byte_panics() {
    let columns =
        "ITEM: ATOMS id x y z shapex shapey shapez quat1 quat2 quat3 quat4 blockiness1 blockiness2\n";
    let one = HEADER.to_owned() + columns + &"1 0 0 0 1 1 1 1 0 0 0 2 2\n".repeat(2);
    let text = one.repeat(2);
    let bytes = text.as_bytes();
    let try_all = |bytes: &[u8]| {
        let Ok(mut source) = open(Cursor::new(bytes), &ReadOptions::default()) else { return };
        for frame in 0..source.frames().len() {
            let _ = source.read(frame, &ReadOptions::default());
        }
    };
    for cut in 0..bytes.len() {
        try_all(&bytes[..cut]);
        let mut changed = bytes.to_vec();
        changed[cut] = changed[cut].wrapping_mul(31).wrapping_add(cut as u8);
        try_all(&changed);
    }
    assert_eq!(open(Cursor::new(bytes), &ReadOptions::default()).unwrap().frames().len(), 2);
}

#[test]
fn scenes_of_the_language_are_no_data() {
    for text in
        ["primitive egg\nsetCoeff 1 1 1.3\n", "# ITEM: TIMESTEP\nobject a\n", "", "camera 0 0 10 0 0 0 60\n"]
    {
        assert_eq!(sniff(text.as_bytes()), None, "{text}");
    }
}
