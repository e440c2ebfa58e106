#![expect(clippy::print_stderr, reason = "a skipped test says so")]
//! Data files, tables, SudoDEM's text and points: real files against their truth, made ones against
//! what was written, broken ones.

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

fn read_with(text: &str, options: &ReadOptions) -> Result<(Format, Import), ReadError> {
    let mut source = open(Cursor::new(text.as_bytes()), options)?;
    Ok((source.format(), source.read(0, options)?))
}

fn with_columns(map: &str) -> ReadOptions {
    ReadOptions { columns: Some(map.parse().unwrap()), ..ReadOptions::default() }
}

fn particles(text: &str, options: &ReadOptions) -> (Format, Particles) {
    let (format, import) = read_with(text, options).unwrap();
    let Content::Particles(particles) = import.content else { panic!("{text}") };
    (format, particles)
}

fn error_of(text: &str, options: &ReadOptions) -> String {
    read_with(text, options).unwrap_err().to_string()
}

#[test]
fn data_files_of_both_programs_have_the_numbers_of_their_scripts() {
    let default = ReadOptions::default();
    let Some(bytes) = real("liggghts/mine.data") else { return };
    let (format, found) = particles(std::str::from_utf8(&bytes).unwrap(), &default);
    assert_eq!((format, &found.ids[..]), (Format::LiggghtsData, &[1, 2][..]));
    assert_eq!(found.radii, [DVec3::new(0.01, 0.02, 0.03); 2]);
    assert_eq!(found.exponents, [[1.0, 0.25], [0.25, 1.0]]);
    assert_eq!(found.positions, [DVec3::new(-0.05, 0.0, 0.0), DVec3::new(0.05, 0.0, 0.0)]);
    assert_eq!(found.bounds.unwrap().origin, DVec3::splat(-0.1));
    let Some(bytes) = real("lammps/ellipsoid.data") else { return };
    let (format, found) = particles(std::str::from_utf8(&bytes).unwrap(), &default);
    assert_eq!((format, found.radii[0]), (Format::LammpsData, DVec3::new(0.5, 1.0, 1.5)));
    let half_turn = DQuat::from_axis_angle(DVec3::X, std::f64::consts::FRAC_PI_2);
    assert!(found.rotations[0].abs_diff_eq(half_turn, 1e-15));
}

#[test]
fn data_files_that_lost_the_shape_are_refused_with_the_reason() {
    let head = "made\n\n1 atoms\n1 atom types\n\n-1 1 xlo xhi\n-1 1 ylo yhi\n-1 1 zlo zhi\n\nAtoms\n\n";
    let default = ReadOptions::default();
    let error = error_of(&format!("{head}1 1 1000 .1 0 0 0 0 0 0\n"), &default);
    assert!(error.contains("line 12: the row has 10 columns: write_data of LIGGGHTS leaves out"), "{error}");
    let error = error_of(&format!("{head}1 1 1000 .1 .2 .3 8 2 0 0 nan\n"), &default);
    assert!(error.contains("line 12") && error.contains("'z'"), "{error}");
    let error = error_of(&head.replace("\n1 atoms", "\n18446744073709551615 atoms"), &default);
    assert!(error.contains("'Atoms': the section has 0 rows"), "{error}");
    let (_, found) = particles(&format!("{head}1 1 1000 .1 .2 .3 8 2 0 0 0 0 1 0 # a comment\n"), &default);
    assert_eq!(found.radii, [DVec3::new(0.1, 0.2, 0.3)]);
}

const LAMMPS: &str = "LAMMPS data file\n\n3 atoms\n1 atom types\n2 ellipsoids\n\n0 4 xlo xhi\n0 5 ylo yhi\n\
                      0 6 zlo zhi\n1 0 0 xy xz yz\n\nMasses\n\n1 1\n\nAtoms # ellipsoid\n\n7 1 1 1 1 2 3 0 0 0\n\
                      5 1 0 1 0 0 0 0 0 0\n2 1 1 1 4 5 6 0 0 0\n\nVelocities\n\n7 0 0 0 0 0 0\n\nEllipsoids\n\n";

#[test]
fn ellipsoids_of_lammps_are_joined_with_their_atoms() {
    let text = format!("{LAMMPS}2 2 4 6 0 1 0 0 4 8\n7 1 1 1 1 0 0 0\n");
    let (format, import) = read_with(&text, &ReadOptions::default()).unwrap();
    let Content::Particles(found) = import.content else { panic!() };
    assert_eq!((format, &found.ids[..]), (Format::LammpsData, &[7, 2][..]));
    assert_eq!(found.positions[1], DVec3::new(4.0, 5.0, 6.0));
    assert_eq!(found.radii, [DVec3::splat(0.5), DVec3::new(1.0, 2.0, 3.0)]);
    assert_eq!(found.exponents, [[1.0, 1.0], [0.25, 0.5]]);
    assert_eq!(found.bounds.unwrap().edges[1], DVec3::new(1.0, 5.0, 0.0));
    assert!(import.warnings[0].contains("1 atoms have no ellipsoid"));
    for (rows, words) in [
        ("2 2 4 6 0 1 0 0\n", "'Ellipsoids': the section has 1 rows"),
        ("2 2 4 6 0 1 0 0\n2 2 4 6 0 1 0 0\n", "line 29: the ellipsoid of atom 2 stands twice"),
        ("2 2 4 6 0 1 0 0\n9 2 4 6 0 1 0 0\n", "line 29: there is no atom"),
        ("2 2 4 6 0 1 0\n9 2 4 6 0 1 0 0\n", "line 28: the row has 7 columns"),
        ("2 2 -4 6 0 1 0 0\n7 2 4 6 0 1 0 0\n", "'shapey'"),
    ] {
        let error = error_of(&format!("{LAMMPS}{rows}"), &ReadOptions::default());
        assert!(error.contains(words), "{error}");
    }
}

#[test]
fn tables_have_usual_names_or_named_columns() {
    let default = ReadOptions::default();
    let csv = "id, X ,\"y\",z,a,b,c,e,n,qw,qx,qy,qz,r,g,b,speed\n4,1,2,3,.1,.2,.3,.5,.25,0,0,0,2,1,.5,0,7\n";
    // The column b stands twice: the first one counts.
    let (format, import) =
        read_with(csv, &ReadOptions { extra: vec!["speed".to_owned()], ..default.clone() }).unwrap();
    let Content::Particles(found) = import.content else { panic!() };
    assert_eq!(
        (format, &found.ids[..], found.positions[0]),
        (Format::Table, &[4][..], DVec3::new(1.0, 2.0, 3.0))
    );
    assert_eq!((found.radii[0], found.exponents[0]), (DVec3::new(0.1, 0.2, 0.3), [0.5, 0.25]));
    assert_eq!(found.rotations[0], DQuat::from_xyzw(0.0, 0.0, 1.0, 0.0));
    assert_eq!(found.extra, [("speed".to_owned(), vec![7.0])]);
    assert!(import.warnings[0].contains("not of unit length"));
    let odd = "# u v w sx sy sz p1 p2 al be ga\n1 2 3 2 4 6 4 8 90 0 0\n";
    assert_eq!(sniff(odd.as_bytes()), None);
    let map = "position=u,v,w;diameters=sx,sy,sz;blockiness=p1,p2;euler-zyx-deg=al,be,ga";
    let (_, found) = particles(odd, &with_columns(map));
    assert_eq!((found.radii[0], found.exponents[0]), (DVec3::new(1.0, 2.0, 3.0), [0.25, 0.5]));
    assert!((found.rotations[0] * DVec3::X).abs_diff_eq(DVec3::Y, 1e-15));
    let (_, found) = particles("1;2;3;.5\n4;5;6;.25\n", &with_columns("position=1,2,3;radius=4"));
    assert_eq!(found.radii, [DVec3::splat(0.5), DVec3::splat(0.25)]);
    let error = error_of(odd, &with_columns("position=u,v,missing"));
    assert!(error.contains("no column 'missing'; the file has: u, v, w"), "{error}");
}

#[test]
fn doubtful_names_of_tables_are_errors_that_say_what_to_write() {
    let default = ReadOptions::default();
    for (text, words) in [
        ("x y z a b c e1 e2\n0 0 0 1 1 1 1 1\n", "--columns exponents=E,N"),
        ("x y z shapex shapey shapez\n0 0 0 1 1 1\n", "--columns semi-axes="),
        ("x,y,z,radius\n0,0,0,1\n0,0,,1\n", "line 3: column 3 ('z'): '' is not a number"),
        ("x,y,z,radius\n0,0,0,1\n0,0,0\n", "line 3: the row has 3 columns instead of 4"),
        ("x,y,z,radius\n0,0,0,1\n0,0,0,-1\n", "line 3: a semi-axis of -1"),
    ] {
        let error = error_of(text, &default);
        assert!(error.contains(words), "{error}");
    }
}

#[test]
fn colours_of_bytes_are_decoded_and_fractions_kept() {
    let (_, found) = particles("x y z r g b\n0 0 0 255 0 128\n1 0 0 0 0 0\n", &ReadOptions::default());
    assert_eq!(found.colors[0][0], 1.0);
    assert!((found.colors[0][2] - 0.215_86).abs() < 1e-4);
    let (format, found) = particles("0 0 0 0.5 0 1\n1 0 0 1 1 1\n", &ReadOptions::default());
    assert_eq!((format, found.colors[0]), (Format::Xyz, [0.5, 0.0, 1.0]));
    // Normals are no colours.
    let (_, found) = particles("0 0 0 0 -1 0\n1 0 0 1 0 0\n", &ReadOptions::default());
    assert!(found.colors.is_empty());
}

#[test]
fn text_of_sudodem_has_e_first() {
    let head = "#For poly-superellipsoids(15 columns:rx\try\trz\teps1\teps2\tx\ty\tz\tq0\tq1\tq2\tq3)\n";
    let text = format!(
        "{head}1e-2\t2e-2\t3e-2\t.5\t.25\t1\t2\t3\t0\t1\t0\t0\n.5\t4\t5\t6\n{}\n",
        ["1"; 15].join("\t")
    );
    let (format, import) = read_with(&text, &ReadOptions::default()).unwrap();
    let Content::Particles(found) = import.content else { panic!() };
    assert_eq!(format, Format::Sudodem);
    assert_eq!(found.exponents, [[0.5, 0.25], [1.0, 1.0]]);
    assert_eq!(found.radii, [DVec3::new(0.01, 0.02, 0.03), DVec3::splat(0.5)]);
    assert_eq!(found.positions[1], DVec3::new(4.0, 5.0, 6.0));
    assert_eq!(found.rotations[0], DQuat::from_xyzw(1.0, 0.0, 0.0, 0.0));
    assert!(import.warnings[0].contains("1 poly-superellipsoids"));
    let by_ids = "#x y z qw qx qy qz rx ry rz eps1 eps2\n1 2 3 1 0 0 0 .1 .2 .3 .5 .25\n";
    let (_, found) = particles(by_ids, &ReadOptions::default());
    assert_eq!((found.positions[0], found.exponents[0]), (DVec3::new(1.0, 2.0, 3.0), [0.5, 0.25]));
}

#[test]
fn points_become_spheres_of_half_their_spacing() {
    let rows: String = (0..50).map(|i| format!("{} 0 0\n", f64::from(i) * 0.5)).collect();
    let chemistry: String = (0..50).map(|i| format!("C {} 0 0\n", f64::from(i) * 0.5)).collect();
    for text in [rows.clone(), format!("50\na comment 1 2 3\n{chemistry}"), format!("// X Y Z\n{rows}")] {
        let (format, found) = particles(&text, &ReadOptions::default());
        assert_eq!((format, found.len(), found.radii[7]), (Format::Xyz, 50, DVec3::splat(0.25)));
    }
    let options = ReadOptions { point_radius: Some(2.0), ..ReadOptions::default() };
    assert_eq!(particles(&rows, &options).1.radii[0], DVec3::splat(2.0));
    let short = format!("51\n\n{chemistry}");
    assert!(error_of(&short, &ReadOptions::default()).contains("ends after 50 of 51 points"));
}

#[test]
fn no_truncation_and_no_changed_byte_panics() {
    let texts = [
        format!("{LAMMPS}2 2 4 6 0 1 0 0 4 8\n7 1 1 1 1 0 0 0\n"),
        "made\n\n1 atoms\n\n-1 1 xlo xhi\n\nAtoms\n\n1 1 1000 .1 .2 .3 8 2 0 0 0\n".to_owned(),
        "id,x,y,z,a,b,c,e,n\n4,1,2,3,.1,.2,.3,.5,.25\n".to_owned(),
        "#rx ry rz eps1 eps2 x y z q0 q1 q2 q3\n1 1 1 1 1 1 1 1 1 1 1 1\n".to_owned(),
        "2\n\nC 0 0 0\nC 1 1 1\n".to_owned(),
        "0 0 0 255 0 0\n1 1 1 0 0 0\n".to_owned(),
    ];
    for text in &texts {
        for from in
            [None, Some(Format::Table), Some(Format::Xyz), Some(Format::Sudodem), Some(Format::LammpsData)]
        {
            let options = ReadOptions { from, all_extra: true, ..ReadOptions::default() };
            for cut in 0..text.len() {
                let mut changed = text.clone().into_bytes();
                changed[cut] = changed[cut].wrapping_mul(31).wrapping_add(cut as u8);
                for bytes in [&text.as_bytes()[..cut], &changed] {
                    let Ok(mut source) = open(Cursor::new(bytes), &options) else { continue };
                    let _ = source.read(0, &options);
                }
            }
        }
    }
}

#[test]
fn wrong_rows_below_names_are_named() {
    let options = ReadOptions::default();
    for (text, expected) in [
        ("x,y,z,a,b,c\n1,2,3,1,1\n", "line 2: the row has 5 columns"),
        ("x;y;z\n1;2;three\n", "line 2: column 3 ('z'): 'three' is not a number"),
        ("x,y,z\n", "the format is not recognized"),
    ] {
        let error = error_of(text, &options);
        assert!(error.starts_with(expected), "{text:?}: {error}");
    }
}
