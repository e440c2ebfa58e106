//! Colour, roughness and bumps of surfaces, with patterns and textures.

use std::rc::Rc;

use superegg_geom::glam::{DAffine3, DVec3};
use superegg_scene::Material;
use superegg_trace::CompiledPrimitive;

use crate::shade::bump::bumped_normal;
use crate::shade::floor::FloorPlane;
use crate::shade::point::{MaterialRef, SurfaceView, albedo_of_floor, albedo_of_shape, extents};
use crate::texture::mapping::TexturePlace;
use crate::texture::set::PrimitiveTextures;

/// The colour and the material at a point.
pub(crate) struct Finish<'a> {
    /// The colour with pattern and texture.
    pub(crate) albedo: DVec3,
    pub(crate) material: MaterialRef<'a>,
    /// The unit normal that a texture of bumps has turned, on the side of the normal of the view.
    pub(crate) bumped: Option<DVec3>,
}

/// The finish at a point of a shape, given in the space of the unit shape. `primitive` has its textures; `None` for a proxy.
pub(crate) fn finish_of_shape<'a>(
    material: &MaterialRef<'a>,
    primitive: Option<(CompiledPrimitive, Option<&PrimitiveTextures>)>,
    unit_point: DVec3,
    world_from_unit: &DAffine3,
    view: &SurfaceView,
) -> Finish<'a> {
    let plain = Finish { albedo: material.color, material: material.clone(), bumped: None };
    let Some((primitive, textures)) = primitive else { return plain };
    let albedo = albedo_of_shape(material, &primitive, unit_point, world_from_unit, view);
    let finish = Finish { albedo, ..plain };
    let Some((textures, radii)) = textures.zip(primitive.radii) else { return finish };
    let linear = world_from_unit.matrix3;
    // The world vectors of unit steps along the axes of the primitive.
    let axes = [linear.x_axis / radii.x, linear.y_axis / radii.y, linear.z_axis / radii.z];
    let place = TexturePlace {
        local: unit_point * radii,
        unit: Some(unit_point),
        normal: DVec3::from_array(axes.map(|axis| axis.dot(view.normal))),
        extents: extents(axes, view),
        radii,
    };
    textured(finish, textures, &place, axes)
}

/// The finish at a point of the floor.
pub(crate) fn finish_of_floor<'a>(
    ground: &FloorPlane<'a>,
    textures: Option<&PrimitiveTextures>,
    position: DVec3,
    view: &SurfaceView,
) -> Finish<'a> {
    let albedo = albedo_of_floor(ground, position, view);
    let finish = Finish { albedo, material: MaterialRef::Scene(ground.material), bumped: None };
    let Some(textures) = textures else { return finish };
    let place = TexturePlace {
        local: ground.local(position),
        unit: None,
        normal: DVec3::Z,
        extents: extents(ground.axes(), view),
        radii: DVec3::ONE,
    };
    textured(finish, textures, &place, ground.axes())
}

/// A finish with textures. `axes` are the world vectors of unit steps along the axes of the primitive's own space.
fn textured<'a>(
    finish: Finish<'a>,
    textures: &PrimitiveTextures,
    place: &TexturePlace,
    axes: [DVec3; 3],
) -> Finish<'a> {
    let Finish { mut albedo, mut material, .. } = finish;
    if let Some(texture) = &textures.color {
        albedo *= texture.value(place);
    }
    if let Some(texture) = &textures.roughness {
        let roughness = Some(texture.value(place).x.clamp(0.0, 1.0));
        material = MaterialRef::Mean(Rc::new(Material { roughness, ..*material }));
    }
    let bumped = textures
        .bump
        .as_ref()
        .and_then(|(texture, height)| bumped_normal(place.normal, *height * texture.gradient(place), axes));
    Finish { albedo, material, bumped }
}
