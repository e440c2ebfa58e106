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
    // Cotangents of half the angles of view in x and y; near plane; 1 for the sRGB curve.
    projection: vec4<f32>,
    // x: number of lights.
    counts: vec4<u32>,
    lights: array<Light, MOST_LIGHTS>,
}

@group(0) @binding(0) var<uniform> frame: Frame;

// Reversed depth without a far plane: near / distance.
fn project(p: vec3<f32>) -> vec4<f32> {
    return vec4(frame.projection.x * p.x, frame.projection.y * p.y, frame.projection.z, -p.z);
}

fn encode(linear: vec3<f32>) -> vec3<f32> {
    let c = clamp(linear, vec3(0.0), vec3(1.0));
    if frame.projection.w == 0.0 {
        return c;
    }
    // The sRGB curve by square roots, correct to a third of an 8-bit step. pow is slow on a
    // software driver.
    let a = sqrt(c);
    let b = sqrt(a);
    let curved = 0.662002687 * a + 0.684122060 * b - 0.323583601 * sqrt(b) - 0.0225411470 * c;
    return select(curved, 12.92 * c, c <= vec3(0.0031308));
}

struct Material {
    color: vec3<f32>,
    ambient: f32,
    diffuse: f32,
    specular: f32,
    exponent: f32,
}

// Blinn-Phong shading at a point as in the ray tracer, without shadows.
fn shade(m: Material, p: vec3<f32>, n: vec3<f32>) -> vec3<f32> {
    let to_eye = normalize(-p);
    var sum = m.ambient * m.color;
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
        sum += cone * light.color.rgb / (1.0 + light.position_falloff.w * square) * (m.diffuse * facing * m.color + highlight);
    }
    return sum;
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

fn material_of(i: Instance) -> Material {
    return Material(i.color_ambient.rgb, i.color_ambient.w, i.surface.x, i.surface.y, i.surface.z);
}

struct PerPixel {
    @builtin(position) clip: vec4<f32>,
    @location(0) position: vec3<f32>,
    @location(1) normal: vec3<f32>,
    @location(2) @interpolate(flat) color_ambient: vec4<f32>,
    @location(3) @interpolate(flat) surface: vec4<f32>,
}

@vertex
fn phong_vertex(v: Vertex, i: Instance) -> PerPixel {
    let p = to_eye_space(i, v.position);
    return PerPixel(project(p), p, map_normal(i, v.normal), i.color_ambient, i.surface);
}

@fragment
fn phong_fragment(in: PerPixel, @builtin(front_facing) is_front: bool) -> @location(0) vec4<f32> {
    // Inside a shape the back face is lit. A mirroring map reverses the winding of the triangles.
    let is_outside = is_front == (in.surface.w > 0.0);
    let n = normalize(in.normal) * select(-1.0, 1.0, is_outside);
    let m = Material(in.color_ambient.rgb, in.color_ambient.w, in.surface.x, in.surface.y, in.surface.z);
    return vec4(encode(shade(m, in.position, n)), 1.0);
}

struct PerVertex {
    @builtin(position) clip: vec4<f32>,
    @location(0) color: vec3<f32>,
}

@vertex
fn gouraud_vertex(v: Vertex, i: Instance) -> PerVertex {
    let p = to_eye_space(i, v.position);
    return PerVertex(project(p), shade(material_of(i), p, map_normal(i, v.normal)));
}

@fragment
fn gouraud_fragment(in: PerVertex) -> @location(0) vec4<f32> {
    return vec4(encode(in.color), 1.0);
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
    return encode(max(i.color_ambient.rgb, vec3(0.12)));
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
    return MarkOut(project(p), color, dot(normal, normalize(-p)));
}

@fragment
fn mark_fragment(in: MarkOut) -> @location(0) vec4<f32> {
    return vec4(in.color.rgb * (0.55 + 0.45 * max(in.facing, 0.0)), in.color.a);
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
