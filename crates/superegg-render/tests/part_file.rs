//! Kept partial files: the format does not change by accident, and files of older versions stay
//! readable.

use superegg_geom::glam::DVec3;
use superegg_render::{Film, Output, PartFile, PartHeader, Pixel, RenderSettings, Shard};
use superegg_scene::{Camera, Encoding, Filter, Light, LightKind, Picture, Scene, Sky, Tone};

/// Written by superegg 0.1.0 when the version was 2, of 16 x 12 pixels: one tile.
const VERSION_2: &[u8] = include_bytes!("data/version2.part");
/// The same pixels in version 3.
const VERSION_3: &[u8] = include_bytes!("data/version3.part");
/// The same pixels in version 4, with the header of [`header`].
const VERSION_4: &[u8] = include_bytes!("data/version4.part");

/// The text of the header of versions 3 and 4.
const TEXT: &str = "share 1/1
program 0.1.0
width 16
height 12
samples 3
noise 0x3f847ae147ae147b
most_samples 1024
filter Mitchell
encoding Srgb
exposure 0x3fb999999999999a
tone Filmic
bits 8
transparent true
bounces 16
least_weight 0x3f4999999999999a
light_rays 4
gloss_rays 0
view Light
layers true
root scene
depth 25
camera xxh3:3a905d8691f83804c05fab345076771f
surroundings xxh3:193ecf8288305918f0798b09a77b2a5c
scene xxh3:e07692221743aca0cdacae3501c0c275
";

fn settings() -> RenderSettings {
    let picture = Picture {
        width: 16,
        height: 12,
        samples: 3,
        noise: 0.01,
        filter: Filter::Mitchell,
        encoding: Encoding::Srgb,
        exposure: 0.1,
        tone: Tone::Filmic,
        transparent: true,
        ..Picture::default()
    };
    let camera = Camera { position: DVec3::new(3.0, 2.0, 6.0), fov_deg: 40.0, ..Camera::default() };
    let mut settings = RenderSettings::of(&Scene::default()).with_picture(picture).with_camera(camera);
    let kind = LightKind::Point { position: DVec3::new(4.0, 5.0, 6.0) };
    settings.environment.lights = vec![Light { kind, ..Light::DEFAULT }];
    settings.environment.sky = Some(Sky { horizon: DVec3::ZERO, zenith: DVec3::ONE, up: DVec3::Y });
    settings
}

fn header(settings: &RenderSettings) -> PartHeader {
    PartHeader::new("0.1.0", "prm egg\n", Some("scene"), 25, settings, Shard::WHOLE)
}

/// The only tile of a file.
fn only_tile(bytes: &[u8]) -> (PartHeader, Film) {
    let part = PartFile::read(bytes).unwrap();
    assert_eq!((part.end, part.damaged), (bytes.len() as u64, 0));
    let tiles: Vec<(usize, Film)> = part.tiles;
    assert_eq!((tiles.len(), tiles[0].0), (1, 0));
    (part.header, tiles[0].1.clone())
}

#[test]
fn a_file_of_version_2_is_read() {
    let (header, film) = only_tile(VERSION_2);
    let expected = Picture {
        width: 16,
        height: 12,
        samples: 3,
        filter: Filter::Mitchell,
        exposure: 0.1,
        ..Picture::default()
    };
    assert_eq!((header.picture(), header.output(), header.has_layers()), (&expected, Output::Light, true));
    assert!(film.pixels().all(|pixel| pixel.samples == 3 && pixel.alpha == 1.0));
    assert!(film.ids().any(|id| id != 0) && film.depths().all(|depth| depth > 0.0));
    // A header of version 2 stays one, so that its records stay valid.
    let again = [header.to_bytes(), header.record(0, &film)].concat();
    assert!(again == VERSION_2);
}

#[test]
fn files_of_two_versions_are_told_apart() {
    let (old, _) = only_tile(VERSION_2);
    let difference = old.difference(&header(&settings())).unwrap();
    assert_eq!(difference.name, "format_version");
    assert_eq!(difference.values, Some(("2".to_owned(), "4".to_owned())));
    assert_eq!(old.difference(&old.clone()), None);
}

#[test]
fn a_file_of_version_3_is_read() {
    let (header_2, film) = only_tile(VERSION_2);
    let (header, same) = only_tile(VERSION_3);
    assert_eq!(same, film);
    assert_eq!((header.has_layers(), header.has_numbers(), header_2.has_numbers()), (true, false, false));
    assert_eq!(header.to_bytes(), VERSION_3[..header.to_bytes().len()]);
    let again = [header.to_bytes(), header.record(0, &film)].concat();
    assert!(again == VERSION_3);
}

#[test]
fn the_bytes_of_version_4_are_pinned() {
    let (_, mut film) = only_tile(VERSION_2);
    for x in 0..16 {
        film.set(x, 3, Pixel { instance: 2 + x, object: x / 2, ..film.pixel(x, 3).unwrap() });
    }
    let header = header(&settings());
    let bytes = [header.to_bytes(), header.record(0, &film)].concat();
    assert_eq!(&header.to_bytes()[..16], b"superegg part 4\n");
    assert_eq!(std::str::from_utf8(&header.to_bytes()[36..]).unwrap(), TEXT);
    assert!(bytes == VERSION_4);
    let (read, same) = only_tile(VERSION_4);
    assert_eq!((read, same), (header, film));
}

#[test]
fn numbers_of_the_header_are_exact_and_readable_in_a_difference() {
    let ours = settings();
    for (exposure, text) in [(-0.0, "-0"), (0.1f64.next_up(), "0.10000000000000002"), (1e-300, "0.0")] {
        let other = ours.clone().with_picture(Picture { exposure, ..ours.picture });
        let other = header(&other);
        let difference = header(&ours).difference(&other).unwrap();
        let (one, two) = difference.values.unwrap();
        assert_eq!((difference.name.as_str(), one.as_str()), ("exposure", "0.1"));
        assert!(two.starts_with(text), "{two}");
        let read = PartHeader::read(&other.to_bytes()).unwrap().0;
        assert_eq!(read.picture().exposure.to_bits(), exposure.to_bits());
    }
}

#[test]
fn a_record_of_version_2_is_no_record_of_version_4() {
    let (old, film) = only_tile(VERSION_2);
    let mixed = [header(&settings()).to_bytes(), old.record(0, &film)].concat();
    assert_eq!(PartFile::read(&mixed[..]).unwrap().tiles.len(), 0);
    assert_eq!(film.pixel(16, 0), None);
    assert_ne!(film.pixel(0, 0), Some(Pixel::EMPTY));
}
