//! The results of shading, and the memory that it reuses.

use superegg_geom::glam::DVec3;

use crate::shade::surfaces::Surfaces;
use crate::stats::TraceStats;

/// The results of shading, and the memory that it reuses.
pub(crate) struct ShadingState<'t, 'a> {
    /// The colours of the samples.
    pub(crate) colors: &'t mut [DVec3],
    pub(crate) stats: &'t mut TraceStats,
    pub(crate) surfaces: &'t mut Surfaces<'a>,
}
