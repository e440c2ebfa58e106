//! Culling, level of detail and sorting of the instances of a picture.

use std::collections::HashMap;

use super::eye_space::{EyeSpace, NEAR};
use super::gpu_data::{InstanceData, instance_data};
use super::lod::LevelOfDetail;
use super::meshes::{MeshKey, Meshes};
use super::picture::{Picture, Style};
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
    pub(super) batches: Vec<Batch>,
    /// The instances of the selected shape once more, after all others.
    pub(super) selected: Option<Batch>,
}

/// An instance with its bucket in the sort order.
struct Sortable {
    /// `3 * mesh + sides`.
    bucket: usize,
    data: InstanceData,
    shape: u32,
}

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
        let visible: Vec<(&PreviewInstance, f64)> =
            preview.instances.iter().filter_map(|i| Some((i, space.size_px(i)?))).collect();
        let detail = LevelOfDetail::within(
            triangle_budget,
            is_wireframe,
            visible.iter().map(|(i, size_px)| (preview.shapes[i.shape as usize].patches, *size_px)),
        );
        stats.coarser = detail.coarser;
        stats.instances = visible.len();

        let mut mesh_of: HashMap<(u32, u8), usize> = HashMap::new();
        let mut counts: Vec<u32> = Vec::new();
        let sortable = |(instance, size_px): &(&PreviewInstance, f64)| {
            let shape = &preview.shapes[instance.shape as usize];
            let level = detail.level(shape.patches, *size_px);
            let mesh = *mesh_of
                .entry((instance.shape, level))
                .or_insert_with(|| meshes.ensure(MeshKey::new(shape, level)));
            let data = instance_data(space, instance, &shape.material);
            let bucket = 3 * mesh + Sides::of(space, instance, &data) as usize;
            if counts.len() <= bucket {
                counts.resize(bucket + 1, 0);
            }
            counts[bucket] += 1;
            Sortable { bucket, data, shape: instance.shape }
        };
        let unsorted: Vec<Sortable> = visible.iter().map(sortable).collect();

        let batches = batches(&counts);
        for batch in &batches {
            let size = meshes.get(batch.mesh);
            let cost = if is_wireframe { size.edge_count } else { size.triangle_count };
            stats.triangles += cost as usize * batch.count as usize;
        }
        let mut sorted = Self { data: sorted_data(&unsorted, &counts), batches, selected: None };
        if let Some(shape) = picture.selected {
            // One mesh for all of them: the finest.
            let mesh = || meshes.ensure(MeshKey::new(&preview.shapes[shape as usize], 0));
            sorted.append_selected(unsorted.iter().filter(|instance| instance.shape == shape), mesh);
        }
        sorted
    }

    fn append_selected<'a>(
        &mut self,
        selected: impl Iterator<Item = &'a Sortable>,
        mesh: impl FnOnce() -> usize,
    ) {
        let first = self.data.len();
        self.data.extend(selected.map(|instance| instance.data));
        let count = self.data.len() - first;
        self.selected = (count > 0).then(|| Batch {
            mesh: mesh(),
            sides: Sides::Both,
            first: first as u32,
            count: count as u32,
        });
    }
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
fn sorted_data(unsorted: &[Sortable], counts: &[u32]) -> Vec<InstanceData> {
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
