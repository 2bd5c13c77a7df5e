//! Where the ends of a scan are between the cells of a field, several at a time.

/// How many beams are looked up together.
pub(super) const TOGETHER: usize = 16;

/// Into how many parts the way from cell to cell is cut, and a step with it.
pub(super) const PARTS: u32 = 256;

/// Where a body stands, in cells.
pub(super) struct View {
    pub x: f32,
    pub y: f32,
    pub sin: f32,
    pub cos: f32,
    pub last_x: f32,
    pub last_y: f32,
    pub stride: u32,
}

impl View {
    /// The spots of these ends. Plain operations on several numbers at a time,
    /// and a border takes whatever lies beyond.
    #[inline(always)]
    pub fn spots(&self, x_m: &[f32; TOGETHER], y_m: &[f32; TOGETHER]) -> Spots {
        let mut spots = Spots::default();
        for k in 0..TOGETHER {
            let x = self.x + (self.cos * x_m[k] - self.sin * y_m[k]);
            let y = self.y + (self.sin * x_m[k] + self.cos * y_m[k]);
            let ((column, right), (row, up)) = (cut(x, self.last_x), cut(y, self.last_y));
            spots.place[k] = row.wrapping_mul(self.stride).wrapping_add(column);
            spots.right[k] = right;
            spots.up[k] = up;
        }
        spots
    }
}

/// Spots between cells: the cell to the lower left, and how far from its centre
/// to the next ones, in parts of 256.
#[derive(Default)]
pub(super) struct Spots {
    pub place: [u32; TOGETHER],
    pub right: [u32; TOGETHER],
    pub up: [u32; TOGETHER],
}

/// A number of cells: whole ones, and parts of the next.
#[inline(always)]
pub(super) fn cut(cells: f32, last: f32) -> (u32, u32) {
    /// Added to a number below 2²², it leaves the nearest whole number in the low
    /// bits.
    const WHOLE: f32 = 12_582_912.0;
    // Comparisons, so that what is no number becomes the border.
    let cells = if cells > 0.5 { cells } else { 0.5 };
    let cells = if cells < last { cells } else { last };
    let whole = (cells - 0.5) + WHOLE;
    // 0 to 256, both included: half-way the rounding may go either way.
    let parts = (cells - (whole - WHOLE)) * PARTS as f32 + WHOLE;
    (whole.to_bits() - WHOLE.to_bits(), parts.to_bits() - WHOLE.to_bits())
}
