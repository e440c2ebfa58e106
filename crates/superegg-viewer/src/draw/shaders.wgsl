// All positions are in eye space: x right, y up, the eye at the origin looking along -z, unit =
// distance from eye to target.

const MOST_LIGHTS: u32 = 32u;

struct Light {
    // Position, and k of the attenuation 1 / (1 + k d^2). For a directional light: the direction
    // towards it.
    position_falloff: vec4<f32>,
    // w: fraction of the cone's angle over which the light fades towards the rim; below 0 for a
    // directional light.
    color: vec4<f32>,
    // Unit axis, and half the opening angle. 0 is a point light.
    cone: vec4<f32>,
}

struct Frame {
    // Cotangents of half the angles of view in x and y, or for parallel rays reciprocals of half the
    // extents; near plane; 1 for the sRGB curve.
    projection: vec4<f32>,
    // x: number of lights. y: 1 for parallel rays. z: tone mapping, 1 Reinhard, 2 filmic, 3 ACES, 4 AgX. w: 1 if
    // there is a floor.
    counts: vec4<u32>,
    // x: factor of the exposure. y: size of a pixel at distance 1, or for parallel rays at any.
    // z, w: twice the reciprocals of width and height in pixels.
    develop: vec4<f32>,
    // The sky: colours at the horizon and the zenith, unit direction of the zenith.
    horizon: vec4<f32>,
    zenith: vec4<f32>,
    sky_up: vec4<f32>,
    // Unit normal n and distance d: the floor is dot(n, p) = d.
    floor_plane: vec4<f32>,
    // The coordinates of the floor's pattern are dot(xyz, p) + w.
    floor_x: vec4<f32>,
    floor_y: vec4<f32>,
    // The floor's surface: as of an instance.
    floor_color_ambient: vec4<f32>,
    floor_surface: vec4<f32>,
    floor_pattern: vec4<f32>,
    floor_lobes: vec4<f32>,
    lights: array<Light, MOST_LIGHTS>,
}

@group(0) @binding(0) var<uniform> frame: Frame;

// Reversed depth without a far plane: near / distance. Parallel rays have one, at distance 1000.
fn project(p: vec3<f32>) -> vec4<f32> {
    if frame.counts.y == 1u {
        return vec4(frame.projection.x * p.x, frame.projection.y * p.y, 1.0 + 1e-3 * p.z, 1.0);
    }
    return vec4(frame.projection.x * p.x, frame.projection.y * p.y, frame.projection.z, -p.z);
}

// Exposure and tone mapping.
fn developed(linear: vec3<f32>) -> vec3<f32> {
    let c = frame.develop.x * linear;
    if frame.counts.z == 1u {
        let luminance = dot(c, vec3(0.2126, 0.7152, 0.0722));
        return c * (1.0 + luminance / 16.0) / (1.0 + luminance);
    }
    if frame.counts.z == 2u {
        let x = clamp(c, vec3(0.0), vec3(1e6));
        return x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14);
    }
    if frame.counts.z == 3u {
        // Rows of the matrix are the columns of the transposed one.
        let m = clamp(c, vec3(0.0), vec3(1e6)) * mat3x3(0.59719, 0.35458, 0.04823, 0.076, 0.90834, 0.01566, 0.0284, 0.13383, 0.83777);
        let x = (m * (m + 0.0245786) - 0.000090537) / (m * (0.983729 * m + 0.432951) + 0.238081);
        return x * mat3x3(1.60475, -0.53108, -0.07367, -0.10208, 1.10813, -0.00605, -0.00327, -0.07276, 1.07602);
    }
    if frame.counts.z == 4u {
        let m = clamp(c, vec3(0.0), vec3(1e6)) * mat3x3(0.84247906, 0.0784336, 0.079223745, 0.042328242, 0.87846864, 0.07916613, 0.042375655, 0.0784336, 0.87914297);
        let x = clamp((log2(max(m, vec3(1e-10))) + 12.47393) / 16.5, vec3(0.0), vec3(1.0));
        let x2 = x * x;
        let x4 = x2 * x2;
        let bent = 15.5 * x4 * x2 - 40.14 * x4 * x + 31.96 * x4 - 6.868 * x2 * x + 0.4298 * x2 + 0.1191 * x - 0.00232;
        let apart = bent * mat3x3(1.196879, -0.09802088, -0.09902974, -0.05289685, 1.1519031, -0.09896118, -0.052971635, -0.09804345, 1.1510737);
        return pow(max(apart, vec3(0.0)), vec3(2.2));
    }
    return c;
}

fn curved(linear: vec3<f32>) -> vec3<f32> {
    let c = clamp(linear, vec3(0.0), vec3(1.0));
    if frame.projection.w == 0.0 {
        return c;
    }
    // The sRGB curve by square roots, correct to a third of an 8-bit step. pow is slow on a
    // software driver.
    let a = sqrt(c);
    let b = sqrt(a);
    let bent = 0.662002687 * a + 0.684122060 * b - 0.323583601 * sqrt(b) - 0.0225411470 * c;
    return select(bent, 12.92 * c, c <= vec3(0.0031308));
}

fn encode(linear: vec3<f32>) -> vec3<f32> {
    return curved(developed(linear));
}

struct Material {
    color: vec3<f32>,
    ambient: f32,
    diffuse: f32,
    specular: f32,
    exponent: f32,
    // Weights of mirrored and transmitted light; index of refraction, negative without Fresnel
    // reflection of the mirrored light, or 0 if nothing needs it.
    mirror: f32,
    transmitted: f32,
    index: f32,
}

// The unit direction from a point to the eye.
fn to_eye_from(p: vec3<f32>) -> vec3<f32> {
    return select(normalize(-p), vec3(0.0, 0.0, 1.0), frame.counts.y == 1u);
}

// The Fresnel reflectance for unpolarised light from air.
fn reflectance(cos_in: f32, index: f32) -> f32 {
    let c = clamp(cos_in, 0.0, 1.0);
    let cos_out = sqrt(max(1.0 - (1.0 - c * c) / (index * index), 0.0));
    let perpendicular = (c - index * cos_out) / max(c + index * cos_out, 1e-6);
    let parallel = (index * c - cos_out) / max(index * c + cos_out, 1e-6);
    return 0.5 * (perpendicular * perpendicular + parallel * parallel);
}

// The weights of local, mirrored and transmitted light.
fn lobes(m: Material, cos_in: f32) -> vec3<f32> {
    var mirror = m.mirror;
    if m.index > 0.0 && mirror > 0.0 {
        mirror *= reflectance(cos_in, m.index);
    }
    let total = max(mirror + m.transmitted, 1.0);
    let local = max(1.0 - mirror - m.transmitted, 0.0);
    // The interface mirrors what it does not transmit.
    let transmitted = m.transmitted / total;
    let turned_back = select(0.0, transmitted * reflectance(cos_in, max(abs(m.index), 1.0)), transmitted > 0.0);
    return vec3(local, mirror / total + turned_back, transmitted - turned_back);
}

// Blinn-Phong shading at a point as in the ray tracer, without shadows. `local` is the weight of
// local light.
fn local_light(m: Material, p: vec3<f32>, n: vec3<f32>, to_eye: vec3<f32>, local: f32) -> vec3<f32> {
    var sum = local * m.ambient * m.color;
    for (var i = 0u; i < frame.counts.x; i++) {
        let light = frame.lights[i];
        let is_sun = light.color.w < 0.0;
        let to = light.position_falloff.xyz - select(p, vec3(0.0), is_sun);
        let square = dot(to, to);
        if square == 0.0 {
            continue;
        }
        let l = to * inverseSqrt(square);
        let facing = dot(n, l);
        if facing <= 0.0 {
            continue;
        }
        var cone = 1.0;
        if light.cone.w > 0.0 {
            let angle = acos(clamp(-dot(l, light.cone.xyz), -1.0, 1.0));
            cone = smoothstep(0.0, max(light.color.w, 1e-4) * light.cone.w, light.cone.w - angle);
        }
        let h = normalize(l + to_eye);
        let highlight = m.specular * pow(max(dot(n, h), 1e-6), m.exponent);
        sum += cone * light.color.rgb / (1.0 + light.position_falloff.w * square) * (local * m.diffuse * facing * m.color + highlight);
    }
    return sum;
}

// The mean of a square wave, +1 on [0, 1) and -1 on [1, 2), over an interval of this width.
fn mean_sign(x: f32, width: f32) -> f32 {
    let w = max(width, 1e-3);
    let low = x - 0.5 * w;
    let high = x + 0.5 * w;
    let at_low = 1.0 - abs(low - 2.0 * floor(0.5 * low) - 1.0);
    let at_high = 1.0 - abs(high - 2.0 * floor(0.5 * high) - 1.0);
    return clamp((at_high - at_low) / w, -1.0, 1.0);
}

fn sky_light(direction: vec3<f32>) -> vec3<f32> {
    return mix(frame.horizon.rgb, frame.zenith.rgb, clamp(dot(direction, frame.sky_up.xyz), 0.0, 1.0));
}

// The t of the hit of a ray with the floor; 0 without one.
fn floor_hit(origin: vec3<f32>, direction: vec3<f32>) -> f32 {
    let n = frame.floor_plane.xyz;
    let t = (frame.floor_plane.w - dot(n, origin)) / dot(n, direction);
    return select(0.0, t, frame.counts.w == 1u && t > 0.0 && t < 1e20);
}

fn floor_material(p: vec3<f32>, to_eye: vec3<f32>) -> Material {
    let x = dot(frame.floor_x.xyz, p) + frame.floor_x.w;
    let y = dot(frame.floor_y.xyz, p) + frame.floor_y.w;
    let n = frame.floor_plane.xyz;
    let cos_in = max(abs(dot(n, to_eye)), 1e-3);
    let along = to_eye - dot(n, to_eye) * n;
    let lengthwise = along / max(length(along), 1e-6) * (1.0 / cos_in - 1.0);
    let pixel = frame.develop.y * select(length(p), 1.0, frame.counts.y == 1u);
    let width_x = pixel * (length(frame.floor_x.xyz) + abs(dot(frame.floor_x.xyz, lengthwise)));
    let width_y = pixel * (length(frame.floor_y.xyz) + abs(dot(frame.floor_y.xyz, lengthwise)));
    var weight = 0.0;
    if frame.floor_pattern.w == 1.0 {
        weight = 0.5 - 0.5 * mean_sign(x, width_x) * mean_sign(y, width_y);
    } else if frame.floor_pattern.w == 2.0 {
        weight = mix(1.0 - abs(x - 2.0 * floor(0.5 * x) - 1.0), 0.5, clamp(0.5 * width_x - 0.5, 0.0, 1.0));
    }
    return Material(
        mix(frame.floor_color_ambient.rgb, frame.floor_pattern.rgb, weight),
        frame.floor_color_ambient.w,
        frame.floor_surface.x,
        frame.floor_surface.y,
        frame.floor_surface.z,
        frame.floor_lobes.x,
        frame.floor_lobes.y,
        frame.floor_lobes.z,
    );
}

fn floor_normal(to_eye: vec3<f32>) -> vec3<f32> {
    return frame.floor_plane.xyz * select(-1.0, 1.0, dot(frame.floor_plane.xyz, to_eye) > 0.0);
}

// The light that a ray sees where there are no shapes: the floor or the sky.
fn environment_light(origin: vec3<f32>, direction: vec3<f32>) -> vec3<f32> {
    let t = floor_hit(origin, direction);
    if t == 0.0 {
        return sky_light(direction);
    }
    let p = origin + t * direction;
    let m = floor_material(p, -direction);
    let w = lobes(m, abs(dot(frame.floor_plane.xyz, direction)));
    return local_light(m, p, floor_normal(-direction), -direction, w.x);
}

// All light of a point, and the weight of transmitted light. A mirror shows the floor and the sky.
fn shade(m: Material, p: vec3<f32>, n: vec3<f32>) -> vec4<f32> {
    let to_eye = to_eye_from(p);
    let w = lobes(m, abs(dot(n, to_eye)));
    var sum = local_light(m, p, n, to_eye, w.x);
    if w.y > 0.0 {
        sum += w.y * environment_light(p + 1e-4 * n, reflect(-to_eye, n));
    }
    return vec4(sum, w.z);
}

// Solids: instances of meshes.

struct Vertex {
    @location(0) position: vec3<f32>,
    @location(1) normal: vec3<f32>,
}

struct Instance {
    // Rows of the map from the unit shape to eye space.
    @location(2) row_x: vec4<f32>,
    @location(3) row_y: vec4<f32>,
    @location(4) row_z: vec4<f32>,
    @location(5) color_ambient: vec4<f32>,
    // Diffuse, specular, highlight exponent; sign of the map's determinant.
    @location(6) surface: vec4<f32>,
    // Columns of the map of normals: a multiple of the inverse transpose.
    @location(7) normal_x: vec3<f32>,
    @location(8) normal_y: vec3<f32>,
    @location(9) normal_z: vec3<f32>,
    // The colour of the pattern; 1 for a checker, 2 for a gradient.
    @location(10) pattern: vec4<f32>,
    // Factors from the unit shape to the coordinates of the pattern; weight of mirrored light.
    @location(11) cells: vec4<f32>,
    // Weight of transmitted light; index of refraction as in a material.
    @location(12) lobes: vec2<f32>,
    // The colour that light through one side has after absorption.
    @location(13) tint: vec3<f32>,
}

fn to_eye_space(i: Instance, p: vec3<f32>) -> vec3<f32> {
    let q = vec4(p, 1.0);
    return vec3(dot(i.row_x, q), dot(i.row_y, q), dot(i.row_z, q));
}

fn map_normal(i: Instance, n: vec3<f32>) -> vec3<f32> {
    let mapped = i.normal_x * n.x + i.normal_y * n.y + i.normal_z * n.z;
    let size = dot(mapped, mapped);
    return select(vec3(0.0, 0.0, 1.0), mapped * inverseSqrt(size), size > 0.0);
}

// The coordinates of the pattern.
fn cells_of(i: Instance, p: vec3<f32>) -> vec3<f32> {
    return select(i.cells.xyz * p, vec3(dot(i.cells.xyz, p)), i.pattern.w == 2.0);
}

// The weight of the pattern's colour over intervals of this width.
fn pattern_weight(kind: f32, cells: vec3<f32>, width: vec3<f32>) -> f32 {
    if kind == 1.0 {
        let sign = mean_sign(cells.x, width.x) * mean_sign(cells.y, width.y) * mean_sign(cells.z, width.z);
        return 0.5 - 0.5 * sign;
    }
    return select(0.0, clamp(0.5 + 0.5 * cells.x, 0.0, 1.0), kind == 2.0);
}

struct PerPixel {
    @builtin(position) clip: vec4<f32>,
    @location(0) position: vec3<f32>,
    @location(1) normal: vec3<f32>,
    @location(2) @interpolate(flat) color_ambient: vec4<f32>,
    @location(3) @interpolate(flat) surface: vec4<f32>,
    @location(4) cells: vec3<f32>,
    @location(5) @interpolate(flat) pattern: vec4<f32>,
    @location(6) @interpolate(flat) lobes: vec3<f32>,
    @location(7) @interpolate(flat) tint: vec3<f32>,
}

@vertex
fn phong_vertex(v: Vertex, i: Instance) -> PerPixel {
    let p = to_eye_space(i, v.position);
    let n = map_normal(i, v.normal);
    let weights = vec3(i.cells.w, i.lobes);
    return PerPixel(project(p), p, n, i.color_ambient, i.surface, cells_of(i, v.position), i.pattern, weights, i.tint);
}

fn phong_light(in: PerPixel, is_front: bool, width: vec3<f32>) -> vec4<f32> {
    let weight = pattern_weight(in.pattern.w, in.cells, width);
    let color = mix(in.color_ambient.rgb, in.pattern.rgb, weight);
    // Inside a shape the back face is lit. A mirroring map reverses the winding of the triangles.
    let is_outside = is_front == (in.surface.w > 0.0);
    let n = normalize(in.normal) * select(-1.0, 1.0, is_outside);
    let m = Material(
        color, in.color_ambient.w, in.surface.x, in.surface.y, in.surface.z, in.lobes.x, in.lobes.y, in.lobes.z,
    );
    return shade(m, in.position, n);
}

@fragment
fn phong_fragment(in: PerPixel, @builtin(front_facing) is_front: bool) -> @location(0) vec4<f32> {
    return vec4(encode(phong_light(in, is_front, fwidth(in.cells)).rgb), 1.0);
}

// The encoded weight of what is behind a transparent surface.
@fragment
fn phong_behind_fragment(in: PerPixel, @builtin(front_facing) is_front: bool) -> @location(0) vec4<f32> {
    let cos_in = abs(dot(normalize(in.normal), to_eye_from(in.position)));
    let m = Material(vec3(0.0), 0.0, 0.0, 0.0, 1.0, in.lobes.x, in.lobes.y, in.lobes.z);
    return vec4(curved(lobes(m, cos_in).z * in.tint), 1.0);
}

struct PerVertex {
    @builtin(position) clip: vec4<f32>,
    @location(0) light: vec4<f32>,
    @location(1) @interpolate(flat) tint: vec3<f32>,
}

@vertex
fn gouraud_vertex(v: Vertex, i: Instance) -> PerVertex {
    let p = to_eye_space(i, v.position);
    let weight = pattern_weight(i.pattern.w, cells_of(i, v.position), vec3(0.0));
    let color = mix(i.color_ambient.rgb, i.pattern.rgb, weight);
    let m = Material(
        color, i.color_ambient.w, i.surface.x, i.surface.y, i.surface.z, i.cells.w, i.lobes.x, i.lobes.y,
    );
    return PerVertex(project(p), shade(m, p, map_normal(i, v.normal)), i.tint);
}

@fragment
fn gouraud_fragment(in: PerVertex) -> @location(0) vec4<f32> {
    return vec4(encode(in.light.rgb), 1.0);
}

@fragment
fn gouraud_behind_fragment(in: PerVertex) -> @location(0) vec4<f32> {
    return vec4(curved(in.light.w * in.tint), 1.0);
}

// Depth only.

@vertex
fn depth_vertex(v: Vertex, i: Instance) -> @builtin(position) vec4<f32> {
    return project(to_eye_space(i, v.position));
}

@fragment
fn depth_fragment() {
}

// Edges of patches and normals at vertices.

struct Colored {
    @builtin(position) clip: vec4<f32>,
    @location(0) color: vec4<f32>,
}

fn edge_color(i: Instance) -> vec3<f32> {
    return curved(max(i.color_ambient.rgb, vec3(0.12)));
}

@vertex
fn edge_vertex(v: Vertex, i: Instance) -> Colored {
    return Colored(project(to_eye_space(i, v.position)), vec4(edge_color(i), 1.0));
}

@vertex
fn dim_edge_vertex(v: Vertex, i: Instance) -> Colored {
    return Colored(project(to_eye_space(i, v.position)), vec4(edge_color(i), 0.22));
}

@vertex
fn selected_edge_vertex(v: Vertex, i: Instance) -> Colored {
    return Colored(project(to_eye_space(i, v.position)), vec4(1.0, 0.72, 0.2, 0.75));
}

// The far side of a shape that is two pixels larger: its rim shows around the shape.
@vertex
fn outline_vertex(v: Vertex, i: Instance) -> Colored {
    let p = to_eye_space(i, v.position);
    var clip = project(p);
    let n = map_normal(i, v.normal);
    // The normal on the screen. Towards the eye and away from it there is none.
    let across = n.xy + n.z * p.xy / select(max(-p.z, 1e-6), 1e30, frame.counts.y == 1u);
    let size = length(across);
    let direction = select(vec2(0.0), across / size, size > 1e-6);
    clip += vec4(2.0 * direction * frame.develop.zw * clip.w, 0.0, 0.0);
    return Colored(clip, vec4(1.0, 0.62, 0.12, 1.0));
}

// A line at each vertex: from the surface along the normal, a fifth of the shape's mean size long.
@vertex
fn normal_vertex(v: Vertex, i: Instance, @builtin(vertex_index) index: u32) -> Colored {
    let cx = vec3(i.row_x.x, i.row_y.x, i.row_z.x);
    let cy = vec3(i.row_x.y, i.row_y.y, i.row_z.y);
    let cz = vec3(i.row_x.z, i.row_y.z, i.row_z.z);
    let size = (length(cx) + length(cy) + length(cz)) / 3.0;
    let along = select(0.0, 0.2 * size, (index & 1u) == 1u);
    let p = to_eye_space(i, v.position) + along * map_normal(i, v.normal);
    return Colored(project(p), vec4(0.95, 0.95, 0.35, 1.0));
}

// Lines with given positions and colours.

@vertex
fn line_vertex(@location(0) position: vec3<f32>, @location(1) color: vec4<f32>) -> Colored {
    return Colored(project(position), color);
}

@fragment
fn colored_fragment(in: Colored) -> @location(0) vec4<f32> {
    return in.color;
}

// Marks: small emissive spheres, a little darker towards the rim.

struct MarkOut {
    @builtin(position) clip: vec4<f32>,
    @location(0) color: vec4<f32>,
    @location(1) facing: f32,
}

@vertex
fn mark_vertex(
    @location(0) position: vec3<f32>,
    @location(1) normal: vec3<f32>,
    @location(2) center_radius: vec4<f32>,
    @location(3) color: vec4<f32>,
) -> MarkOut {
    let p = center_radius.xyz + center_radius.w * position;
    return MarkOut(project(p), color, dot(normal, to_eye_from(p)));
}

@fragment
fn mark_fragment(in: MarkOut) -> @location(0) vec4<f32> {
    return vec4(in.color.rgb * (0.55 + 0.45 * max(in.facing, 0.0)), in.color.a);
}

// Floor and sky behind everything else.

struct EnvironmentOut {
    @location(0) color: vec4<f32>,
    @builtin(frag_depth) depth: f32,
}

@fragment
fn environment_fragment(in: FilmOut) -> EnvironmentOut {
    let across = vec2(2.0 * in.position.x - 1.0, 1.0 - 2.0 * in.position.y) / frame.projection.xy;
    let is_parallel = frame.counts.y == 1u;
    let origin = select(vec3(0.0), vec3(across, 0.0), is_parallel);
    let direction = select(normalize(vec3(across, -1.0)), vec3(0.0, 0.0, -1.0), is_parallel);
    let t = floor_hit(origin, direction);
    if t == 0.0 {
        return EnvironmentOut(vec4(encode(sky_light(direction)), 1.0), 0.0);
    }
    let p = origin + t * direction;
    let m = floor_material(p, -direction);
    let light = shade(m, p, floor_normal(-direction));
    // What the floor transmits is below it: the sky.
    let sum = light.rgb + light.w * sky_light(direction);
    let depth = select(frame.projection.z / max(-p.z, frame.projection.z), 1.0 + 1e-3 * p.z, is_parallel);
    return EnvironmentOut(vec4(encode(sum), 1.0), clamp(depth, 0.0, 1.0));
}

// A film over the whole viewport.

@group(1) @binding(0) var film: texture_2d<f32>;
@group(1) @binding(1) var film_sampler: sampler;

struct FilmOut {
    @builtin(position) clip: vec4<f32>,
    @location(0) position: vec2<f32>,
}

@vertex
fn film_vertex(@builtin(vertex_index) index: u32) -> FilmOut {
    let corner = vec2(f32((index << 1u) & 2u), f32(index & 2u));
    return FilmOut(vec4(2.0 * corner.x - 1.0, 1.0 - 2.0 * corner.y, 0.0, 1.0), corner);
}

@fragment
fn film_fragment(in: FilmOut) -> @location(0) vec4<f32> {
    return vec4(textureSample(film, film_sampler, in.position).rgb, 1.0);
}
