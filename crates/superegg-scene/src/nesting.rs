//! Nesting of objects.

use crate::scene::MAX_DEPTH;

/// The number of levels of each object, at most [`MAX_DEPTH`].
///
/// `child_objects[i]` lists the objects among the children of object `i`. An object without child
/// objects has 1 level. An object on or above a cycle has [`MAX_DEPTH`] levels. More recursion
/// depth than its levels adds nothing to an object.
///
/// ```
/// use superegg_scene::{MAX_DEPTH, object_heights};
/// assert_eq!(object_heights(&[vec![1, 2], vec![2], vec![]]), [3, 2, 1]);
/// assert_eq!(object_heights(&[vec![0], vec![0], vec![]]), [MAX_DEPTH, MAX_DEPTH, 1]);
/// ```
pub fn object_heights(child_objects: &[Vec<u32>]) -> Vec<u32> {
    let mut heights = vec![1; child_objects.len()];
    // Each round corrects one more level. Objects on or above a cycle rise to the limit.
    for _ in 1..MAX_DEPTH {
        let mut has_changed = false;
        for (object, children) in child_objects.iter().enumerate() {
            let below = children.iter().map(|&child| heights[child as usize]).max().unwrap_or(0);
            let height = (below + 1).min(MAX_DEPTH);
            has_changed |= height != heights[object];
            heights[object] = height;
        }
        if !has_changed {
            break;
        }
    }
    heights
}
