//! All instances as one mesh in the world.

use superegg_geom::glam::DVec3;
use superegg_scene::Scene;

use super::baked::for_each;
use super::flatten::flatten;
use super::meshes::{Meshes, Tolerance};
use super::written::WriteError;

/// The triangles of all instances below a root, in world coordinates. Instances share no vertices.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct SceneMesh {
    /// The vertices.
    pub positions: Vec<DVec3>,
    /// The outward unit normal of the exact surface at each vertex.
    pub normals: Vec<DVec3>,
    /// The vertices of each triangle, counter-clockwise from outside.
    pub triangles: Vec<[u32; 3]>,
    /// The index of each triangle's instance.
    pub instance_of_triangle: Vec<u32>,
    /// The path of each instance.
    pub paths: Vec<String>,
    /// The base colour of each instance, in linear light.
    pub colors: Vec<DVec3>,
}

impl SceneMesh {
    /// The mesh of what is below `root`, opened `depth` levels deep.
    ///
    /// # Errors
    /// An unknown or empty root, too many instances or triangles, or a tolerance that is not possible.
    ///
    /// ```
    /// use superegg_exchange::write::meshes::Tolerance;
    /// use superegg_exchange::write::scene_mesh::SceneMesh;
    /// use superegg_lang::load_text;
    ///
    /// let (session, _) = load_text("ball.scn", "prm ball\nobj all\nap ball\nxs 2 0 0\nap ball b\nxs -2 0 0");
    /// let mesh = SceneMesh::of(session.scene(), "all", 25, Tolerance::Absolute(0.01))?;
    /// assert_eq!(mesh.paths, ["all/ball", "all/b"]);
    /// assert!(mesh.positions.iter().all(|p| p.x.abs() >= 1.0 - 1e-9));
    /// # Ok::<(), superegg_exchange::write::written::WriteError>(())
    /// ```
    pub fn of(scene: &Scene, root: &str, depth: u32, tolerance: Tolerance) -> Result<Self, WriteError> {
        let mut instances = flatten(scene, root, depth)?;
        let meshes = Meshes::of(&instances, tolerance)?;
        meshes.baked_triangles(tolerance)?;
        let mut whole = Self {
            colors: instances.list.iter().map(|instance| instances.part(instance).material.color).collect(),
            ..Self::default()
        };
        for_each(&meshes, |index, mesh, baked| {
            let first = whole.positions.len() as u32;
            whole.positions.extend(baked.positions);
            whole.normals.extend(baked.normals);
            whole
                .triangles
                .extend(mesh.triangles.iter().map(|triangle| triangle.map(|corner| first + corner)));
            whole.instance_of_triangle.resize(whole.triangles.len(), index as u32);
            Ok(())
        })?;
        whole.paths = instances.list.drain(..).map(|instance| instance.path).collect();
        Ok(whole)
    }
}
