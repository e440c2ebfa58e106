//! Pictures made in parts.

use std::sync::Mutex;

use superegg_lang::load_text;
use superegg_render::{
    Film, RenderOptions, RenderResources, RenderSettings, Tile, TileWork, render, render_tiles,
    render_tiles_with, tiles,
};
use superegg_scene::Picture;
use superegg_trace::CompiledScene;

const SIZE: (u32, u32) = (50, 35);

/// The tiles that were handed out, and the film and rays of the whole call.
fn made(wanted: impl Fn(usize) -> bool + Sync, threads: usize) -> (Vec<(usize, Film)>, Film, u64) {
    let text = "prm egg\nexp .3 .4\nreflected .3\nobj o\nap egg\nap egg other\nxs 1 1 -1\n";
    let (session, _) = load_text("known.scn", text);
    let scene = session.scene();
    let compiled = CompiledScene::compile(scene, session.selected(), scene.depth);
    let picture = Picture { width: SIZE.0, height: SIZE.1, samples: 3, ..scene.picture };
    let settings = RenderSettings::of(scene).with_picture(picture);
    let options = RenderOptions::default().with_threads(threads);
    let handed = Mutex::new(Vec::new());
    let film = Mutex::new(Film::new(SIZE.0, SIZE.1));
    let work = TileWork {
        film: &film,
        wanted: &wanted,
        finished: &|index, tile| handed.lock().unwrap().push((index, tile.clone())),
    };
    let stats = render_tiles(&compiled, &settings, &options, &work).unwrap();
    let mut handed = handed.into_inner().unwrap();
    handed.sort_by_key(|(index, _)| *index);
    (handed, film.into_inner().unwrap(), stats.rays.camera)
}

#[test]
fn tiles_made_apart_come_to_the_whole_picture_to_the_bit() {
    let (all, whole, rays) = made(|_| true, 2);
    let places: Vec<Tile> = tiles(SIZE.0, SIZE.1);
    assert_eq!(all.len(), places.len());
    assert_eq!(rays, u64::from(SIZE.0 * SIZE.1 * 3));
    let mut put_together = Film::new(SIZE.0, SIZE.1);
    for part in 0..3 {
        let (tiles, film, _) = made(|index| index % 3 == part, 1 + part);
        for (index, pixels) in &tiles {
            assert_eq!(film.tile(&places[*index]), *pixels);
            put_together.set_tile(&places[*index], pixels);
        }
    }
    assert_eq!(put_together, whole);
    assert!(whole.pixels().all(|pixel| pixel.samples == 3));
}

#[test]
fn what_is_not_wanted_costs_no_ray() {
    let (none, film, rays) = made(|_| false, 2);
    assert!(none.is_empty() && rays == 0 && film == Film::new(SIZE.0, SIZE.1));
    let (one, film, rays) = made(|index| index == 3, 2);
    assert_eq!((one.len(), one[0].0, rays), (1, 3, 18 * 16 * 3));
    let made = film.pixels().filter(|pixel| pixel.samples > 0).count();
    assert_eq!(made, one[0].1.pixels().len());
}

#[test]
fn resources_that_are_kept_give_the_same_picture_in_slices() {
    let text = "set light path\nsky 1 1 1 1 1 1\nprm egg\nmetallic 1\nroughness .4\nprm lamp\nemission 2\n\
                obj o\nap egg\nap lamp\nxs 1 1 3\n";
    let (session, faults) = load_text("known.scn", text);
    assert!(faults.is_empty(), "{faults:?}");
    let scene = session.scene();
    let compiled = CompiledScene::compile(scene, session.selected(), scene.depth);
    let picture = Picture { width: SIZE.0, height: SIZE.1, samples: 2, ..scene.picture };
    let settings = RenderSettings::of(scene).with_picture(picture);
    let whole = render(&compiled, &settings, &RenderOptions::default()).unwrap().film;
    let resources = RenderResources::of(&compiled, &settings);
    let film = Mutex::new(settings.film());
    for tile in 0..tiles(SIZE.0, SIZE.1).len() {
        let work = TileWork { film: &film, wanted: &|index| index == tile, finished: &|_, _| () };
        render_tiles_with(&compiled, &resources, &settings, &RenderOptions::default(), &work).unwrap();
    }
    assert_eq!(film.into_inner().unwrap(), whole);
}
