//! What frames cost: counts and times, as plain data.

/// What one drawn picture cost.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DrawStats {
    /// Instances within the picture.
    pub instances: usize,
    /// Triangles given to the GPU, or edges in wireframe.
    pub triangles: usize,
    /// Draw calls.
    pub draws: usize,
    /// Seconds on the processor to prepare it.
    pub seconds: f64,
    /// Instances drawn with fewer patches than their own, to keep to the drawing budget.
    pub coarser: usize,
    /// Lights that had no place.
    pub lights_left_out: usize,
}

/// Milliseconds of a row of frames.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameTimes {
    /// The frame in the middle.
    pub median_ms: f64,
    /// One of twenty frames takes longer.
    pub slow_ms: f64,
    /// How many frames there were.
    pub frames: usize,
}

/// The preview's frames.
#[derive(Clone, Debug, PartialEq)]
pub struct PreviewBench {
    /// Driver and device.
    pub device: String,
    /// To open the scene.
    pub open_ms: f64,
    /// Instances opened.
    pub instances: usize,
    /// The last frame.
    pub stats: DrawStats,
    /// Each frame with the picture read back, which a window does not do.
    pub times: FrameTimes,
}

/// The live ray traced view's frames.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TraceBench {
    /// Threads that traced.
    pub threads: usize,
    /// To compile the scene.
    pub compile_ms: f64,
    /// Frames at every pixel, one sample each.
    pub full: FrameTimes,
    /// Frames as a window shows them while it is turned: as coarse as 20 a second ask for.
    pub live: FrameTimes,
    /// One pixel of the last of these stands for so many of the window, along a side.
    pub coarseness: u32,
}

/// The frames of both views of the window.
#[derive(Clone, Debug, PartialEq)]
pub struct ViewerBench {
    /// The preview.
    pub preview: PreviewBench,
    /// The live ray traced view.
    pub traced: TraceBench,
}
