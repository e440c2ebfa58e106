//! Counts and times of frames.

/// Counts and time of a picture.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DrawStats {
    /// Instances in the view frustum.
    pub instances: usize,
    /// Triangles sent to the GPU, or edges in wireframe.
    pub triangles: usize,
    /// Draw calls.
    pub draws: usize,
    /// CPU time in seconds.
    pub seconds: f64,
    /// Instances drawn coarser than their size demands, because of the triangle budget.
    pub coarser: usize,
    /// Lights beyond the limit of the preview.
    pub lights_left_out: usize,
}

/// Times of a sequence of frames.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameTimes {
    /// Median time of a frame, in milliseconds.
    pub median_ms: f64,
    /// 95th percentile of the time of a frame, in milliseconds.
    pub slow_ms: f64,
    /// Number of frames.
    pub frames: usize,
}

/// Measurements of the preview.
#[derive(Clone, Debug, PartialEq)]
pub struct PreviewBench {
    /// Names of device and driver.
    pub device: String,
    /// Time to index and expand the scene, in milliseconds.
    pub open_ms: f64,
    /// Number of instances.
    pub instances: usize,
    /// Statistics of the last frame.
    pub stats: DrawStats,
    /// Times of the frames, each with reading the picture back, which a window does not do.
    pub times: FrameTimes,
}

/// Measurements of the live ray traced view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TraceBench {
    /// Number of threads.
    pub threads: usize,
    /// Time to compile the scene, in milliseconds.
    pub compile_ms: f64,
    /// Frames at full size with one sample per pixel.
    pub full: FrameTimes,
    /// Frames of a window during a drag: as coarse as 20 frames per second demand.
    pub live: FrameTimes,
    /// Side of the square of window pixels that one pixel of the last live frame covers.
    pub coarseness: u32,
}

/// Measurements of both views of the window.
#[derive(Clone, Debug, PartialEq)]
pub struct ViewerBench {
    /// The preview.
    pub preview: PreviewBench,
    /// The live ray traced view.
    pub traced: TraceBench,
}
