//! Culling, level of detail and sorting of the instances of a picture.

use super::eye_space::{EyeSpace, NEAR};
use super::gpu_data::{InstanceData, instance_data};
use super::lod::{DetailRule, LevelOfDetail};
use super::meshes::{MeshKey, Meshes};
use super::picture::{Picture, Selected, Style};
use crate::frame_stats::DrawStats;
use crate::preview::PreviewInstance;

/// The triangles of an instance that may be visible.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Sides {
    /// Front faces.
    Front,
    /// Front faces of a mirrored instance, whose triangles are clockwise.
    MirroredFront,
    /// All faces: the eye may be inside.
    Both,
}

impl Sides {
    /// In the order of the pipelines.
    const ALL: [Self; 3] = [Self::Front, Self::MirroredFront, Self::Both];

    fn of(space: &EyeSpace, instance: &PreviewInstance, data: &InstanceData) -> Self {
        let center = space.eye_from_world.transform_point3(instance.world_from_unit.translation);
        if center.length() <= 1.001 * instance.radius / space.unit + NEAR {
            Self::Both
        } else if data.is_mirrored() {
            Self::MirroredFront
        } else {
            Self::Front
        }
    }
}

/// Instances of one mesh, consecutive in the buffer.
#[derive(Clone, Copy, Debug)]
pub(super) struct Batch {
    /// Number of the mesh.
    pub(super) mesh: usize,
    pub(super) sides: Sides,
    pub(super) first: u32,
    pub(super) count: u32,
}

/// The visible instances, sorted by mesh and sides.
#[derive(Debug, Default)]
pub(super) struct SortedInstances {
    pub(super) data: Vec<InstanceData>,
    /// The opaque ones.
    pub(super) batches: Vec<Batch>,
    /// The transparent ones, from far to near.
    pub(super) transparent: Vec<Batch>,
    /// The selected instances once more, after all others.
    pub(super) selected: Vec<Batch>,
}

/// An instance with its bucket in the sort order.
struct Sortable {
    /// `3 * mesh + sides`.
    bucket: usize,
    data: InstanceData,
    shape: u32,
    child: u32,
    /// Distance from the eye.
    distance: f64,
}

/// Most transparent instances that are drawn one by one from far to near.
const MOST_SORTED: usize = 4096;

impl SortedInstances {
    /// Culls the instances of a picture, chooses their level of detail within a budget of
    /// triangles, and sorts them.
    pub(super) fn new(
        picture: &Picture<'_>,
        space: &EyeSpace,
        triangle_budget: usize,
        meshes: &mut Meshes,
        stats: &mut DrawStats,
    ) -> Self {
        let preview = picture.preview;
        let is_wireframe = matches!(picture.style, Style::Wireframe { .. });
        let rule = match picture.style {
            Style::Wireframe { .. } => DetailRule::Wireframe,
            Style::Solid(_) if picture.is_course => DetailRule::Patches,
            Style::Solid(_) => DetailRule::Silhouette,
        };
        let visible: Vec<(&PreviewInstance, f64)> =
            preview.instances.iter().filter_map(|i| Some((i, space.size_px(i)?))).collect();
        let detail = LevelOfDetail::within(
            triangle_budget,
            rule,
            &meshes.segments,
            visible.iter().map(|(i, size_px)| (&preview.shapes[i.shape as usize], *size_px)),
        );
        let keys: Vec<MeshKey> = visible
            .iter()
            .map(|(i, size_px)| MeshKey::new(detail.mesh(&preview.shapes[i.shape as usize], *size_px)))
            .collect();
        stats.coarser = detail.coarser;
        stats.instances = visible.len();

        let mut counts: Vec<u32> = Vec::new();
        let sortable = |((instance, _), key): (&(&PreviewInstance, f64), &MeshKey)| {
            let shape = &preview.shapes[instance.shape as usize];
            let mesh = meshes.ensure(*key);
            let data = instance_data(space, instance, shape, picture.is_course);
            let bucket = 3 * mesh + Sides::of(space, instance, &data) as usize;
            let distance = space.distance(instance);
            Sortable { bucket, data, shape: instance.shape, child: instance.child, distance }
        };
        let all: Vec<Sortable> = visible.iter().zip(&keys).map(sortable).collect();
        let (unsorted, transparent) = partition(&all);
        for instance in &unsorted {
            if counts.len() <= instance.bucket {
                counts.resize(instance.bucket + 1, 0);
            }
            counts[instance.bucket] += 1;
        }

        let batches = batches(&counts);
        let mut sorted = Self { data: sorted_data(&unsorted, &counts), batches, ..Self::default() };
        sorted.append_transparent(transparent);
        for batch in sorted.batches.iter().chain(&sorted.transparent) {
            let size = meshes.get(batch.mesh);
            let cost = if is_wireframe { size.edge_count } else { size.triangle_count };
            stats.triangles += cost as usize * batch.count as usize;
        }
        if let Some(selected) = picture.selected {
            let is_selected = |instance: &&Sortable| match selected {
                Selected::Shape(shape) => instance.shape == shape,
                Selected::Child(child) => instance.child == child,
            };
            let has_edges = is_wireframe || picture.is_course;
            let mesh_of = |instance: &Sortable| {
                if has_edges {
                    meshes.ensure(MeshKey::of_patches(&preview.shapes[instance.shape as usize]))
                } else {
                    instance.bucket / 3
                }
            };
            sorted.append_selected(all.iter().filter(is_selected), mesh_of);
        }
        sorted
    }

    /// Appends transparent instances. More than [`MOST_SORTED`] are drawn by mesh and not by
    /// distance.
    fn append_transparent(&mut self, mut transparent: Vec<&Sortable>) {
        let is_by_distance = transparent.len() <= MOST_SORTED;
        if is_by_distance {
            transparent.sort_by(|a, b| b.distance.total_cmp(&a.distance));
        } else {
            transparent.sort_by_key(|instance| instance.bucket);
        }
        for instance in transparent {
            let (mesh, sides) = (instance.bucket / 3, Sides::ALL[instance.bucket % 3]);
            let sides = if instance.data.is_mirrored() { Sides::MirroredFront } else { sides };
            let first = self.data.len() as u32;
            self.data.push(instance.data);
            match self.transparent.last_mut() {
                Some(last) if !is_by_distance && last.mesh == mesh && last.sides == sides => last.count += 1,
                _ => self.transparent.push(Batch { mesh, sides, first, count: 1 }),
            }
        }
    }

    fn append_selected<'a>(
        &mut self,
        selected: impl Iterator<Item = &'a Sortable>,
        mut mesh_of: impl FnMut(&Sortable) -> usize,
    ) {
        for instance in selected {
            let mesh = mesh_of(instance);
            let sides = if instance.data.is_mirrored() { Sides::MirroredFront } else { Sides::Front };
            let first = self.data.len() as u32;
            self.data.push(instance.data);
            match self.selected.last_mut() {
                Some(last) if last.mesh == mesh && last.sides == sides => last.count += 1,
                _ => self.selected.push(Batch { mesh, sides, first, count: 1 }),
            }
        }
    }
}

/// The opaque instances and the transparent ones.
fn partition(all: &[Sortable]) -> (Vec<&Sortable>, Vec<&Sortable>) {
    all.iter().partition(|instance| !instance.data.is_transparent())
}

fn batches(counts: &[u32]) -> Vec<Batch> {
    let mut batches = Vec::new();
    let mut first = 0;
    for (bucket, &count) in counts.iter().enumerate() {
        if count > 0 {
            batches.push(Batch { mesh: bucket / 3, sides: Sides::ALL[bucket % 3], first, count });
        }
        first += count;
    }
    batches
}

/// A counting sort by bucket.
fn sorted_data(unsorted: &[&Sortable], counts: &[u32]) -> Vec<InstanceData> {
    let mut next: Vec<u32> = Vec::with_capacity(counts.len());
    let mut first = 0;
    for count in counts {
        next.push(first);
        first += count;
    }
    let mut sorted = vec![InstanceData::default(); unsorted.len()];
    for Sortable { bucket, data, .. } in unsorted {
        sorted[next[*bucket] as usize] = *data;
        next[*bucket] += 1;
    }
    sorted
}
