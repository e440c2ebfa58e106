//! Instances as particles: what simulations, fits and tables of them hold.

use superegg_geom::Exponents;
use superegg_geom::glam::DVec3;

use super::flatten::{Instance, Instances, Part};
use super::rigid::Rigid;

/// An instance as a superquadric with semi-axes, rotation and position.
#[derive(Clone, Copy, Debug)]
pub(super) struct Particle<'a> {
    pub(super) instance: &'a Instance,
    pub(super) part: &'a Part,
    pub(super) rigid: Rigid,
    /// The row's id, or the particle's number from 1.
    pub(super) id: i64,
}

impl Particle<'_> {
    pub(super) fn exponents(&self) -> Exponents {
        self.part.shape.exponents()
    }

    /// LIGGGHTS's blockiness 1 and 2, of the profile and the section: 2/n and 2/e.
    pub(super) fn blockiness(&self) -> [f64; 2] {
        let exponents = self.exponents();
        [exponents.n(), exponents.e()].map(|exponent| (2.0 / exponent).min(MOST_BLOCKINESS))
    }

    /// The linear base colour.
    pub(super) fn color(&self) -> DVec3 {
        self.part.material.color
    }
}

/// A box to the last digit of what programs compute with it.
const MOST_BLOCKINESS: f64 = 1e4;
/// The paths that a message lists.
const MOST_LISTED: usize = 3;

/// The instances that are superquadrics, and the loss of the others.
pub(super) fn particles(instances: &Instances) -> (Vec<Particle<'_>>, Option<String>) {
    let mut sheared = Vec::new();
    let has_ids = unique_ids(instances);
    let mut particles = Vec::with_capacity(instances.list.len());
    for instance in &instances.list {
        let part = instances.part(instance);
        match Rigid::of(&part.shape, &instance.map) {
            Some(rigid) => {
                let number = particles.len() as i64 + 1;
                let id = instance.id.filter(|_| has_ids).unwrap_or(number);
                particles.push(Particle { instance, part, rigid, id });
            }
            None => sheared.push(instance.path.as_str()),
        }
    }
    (particles, listed(&sheared, "sheared instances are no superquadrics any more, and not in the file"))
}

/// Whether every instance has an id of its own.
fn unique_ids(instances: &Instances) -> bool {
    let mut ids: Vec<i64> = instances.list.iter().filter_map(|instance| instance.id).collect();
    ids.sort_unstable();
    ids.len() == instances.list.len() && ids.windows(2).all(|pair| pair[0] != pair[1])
}

/// A loss that concerns some instances.
pub(super) fn listed(paths: &[&str], what: &str) -> Option<String> {
    let first = paths.iter().take(MOST_LISTED).copied().collect::<Vec<_>>().join(", ");
    let more = if paths.len() > MOST_LISTED { ", ..." } else { "" };
    (!paths.is_empty()).then(|| format!("{what} ({}): {first}{more}", paths.len()))
}
